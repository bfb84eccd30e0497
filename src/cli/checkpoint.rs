//! `raymini render --checkpoint`: a file that keeps a long render from being lost.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use anyhow::{Context, Result, bail};
use clap::Args;

use super::checkpoint_lock::Lock;
use super::inputs::is_same_file;
use super::values;
use crate::control::{CancelToken, Progress};
use crate::io::{
    check_writable, describe_render, is_render_file, load_checkpoint, save_checkpoint,
};
use crate::render::{Checkpoint, PictureMemory, PreparedScene, Region, RunConfig};
use crate::scene::{RenderSettings, Scene};

/// What a checkpoint file may hold beside the picture's sums: what the pixels' number does not tell, such as how the error fell.
const MOST_OTHER_BYTES: u64 = 1 << 24;

/// What `raymini render` takes to be gone on with.
#[derive(Debug, Default, Args)]
pub struct CheckpointArguments {
    /// Keep what the render has reached in this file, now and then and when interrupted; the file goes when the picture is written
    #[arg(long, value_name = "FILE", allow_hyphen_values = true, value_parser = values::output())]
    checkpoint: Option<PathBuf>,

    /// Go on from the checkpoint: the picture has the same bits as if it had never been interrupted. With other --spp, --seconds or --noise it
    /// goes on by these
    #[arg(long, requires = "checkpoint")]
    resume: bool,

    /// How long to wait from one checkpoint to the next; 0 keeps one after every tile
    #[arg(
        long,
        value_name = "SECONDS",
        default_value = "60",
        requires = "checkpoint",
        allow_hyphen_values = true,
        value_parser = parse_seconds
    )]
    checkpoint_every: Duration,
}

/// Writes the checkpoints of one render.
#[derive(Debug)]
pub struct CheckpointFile<'a> {
    path: &'a Path,
    /// Of the render.
    description: String,
    /// How long to wait from one to the next.
    pub every: Duration,
    resumes: bool,
    /// Why the last one could not be written.
    failure: Mutex<Option<io::Error>>,
}

impl CheckpointArguments {
    /// Finds out what would keep the file from being read or written, before work is spent on the render, and keeps other renders
    /// from it for as long as what is returned lives. `others` are the files that the render writes too.
    pub fn take(&self, others: &[&Path]) -> Result<Option<Lock>> {
        let Some(path) = &self.checkpoint else {
            return Ok(None);
        };
        let name = path.display();
        if others.iter().any(|other| is_same_file(path, other)) {
            bail!("{name}: the checkpoint needs a file of its own");
        }
        if is_render_file(path) {
            bail!("{name}: a checkpoint is no picture: expected another extension, or none");
        }
        if self.resume && !path.exists() {
            bail!("{name}: there is no checkpoint to go on from; leave --resume out to begin anew");
        }
        let lock = match Lock::of(path) {
            Ok(Some(lock)) => lock,
            Ok(None) => bail!("{name}: the checkpoint is in use by another render"),
            Err(error) => {
                check_writable(path).with_context(|| cannot_write(path))?;
                return Err(error).with_context(|| {
                    format!("{name}: other renders cannot be kept from the checkpoint")
                });
            }
        };
        if !self.resume && path.exists() {
            bail!(
                "{name}: there is a file already, maybe of a render to go on with: add --resume, or remove the file"
            );
        }
        check_writable(path).with_context(|| cannot_write(path))?;
        Ok(Some(lock))
    }

    /// What keeps checkpoints of a render of `region` of `scene`; `None` where that is not asked for.
    pub fn of_render(
        &self,
        scene: &Scene,
        prepared: &PreparedScene,
        region: Region,
        run: &RunConfig,
    ) -> Option<CheckpointFile<'_>> {
        let path = self.checkpoint.as_ref()?;
        let layers = run.layers_of(prepared);
        let scene = without_rules(scene);
        let description = describe_render(&scene, region, layers, &CancelToken::new());
        Some(CheckpointFile {
            path,
            description: description.expect("nobody cancels"),
            every: self.checkpoint_every,
            resumes: self.resume,
            failure: Mutex::new(None),
        })
    }
}

impl CheckpointFile<'_> {
    /// What the render is to go on from; `None` where it begins anew. `memory` is what the render takes.
    pub fn load(
        &self,
        prepared: &PreparedScene,
        region: Region,
        run: &RunConfig,
        memory: PictureMemory,
    ) -> Result<Option<Checkpoint>> {
        if !self.resumes {
            return Ok(None);
        }
        // Small numbers take up to a quarter more in the file than in memory.
        let most_bytes = 2 * memory.bytes() + self.description.len() as u64 + MOST_OTHER_BYTES;
        let never = CancelToken::new();
        let checkpoint = load_checkpoint(
            self.path,
            &self.description,
            most_bytes,
            &never,
            &Progress::new(),
        )?;
        let checkpoint = checkpoint.expect("nobody cancels");
        let name = self.path.display();
        if !checkpoint.fits(prepared, region, run.layers_of(prepared)) {
            bail!("{name}: the checkpoint is damaged: its parts do not fit the render");
        }
        super::tell(&format!(
            "{name}: going on from {:.1} samples per pixel after {:.2} s",
            checkpoint.samples_per_pixel(),
            checkpoint.seconds()
        ));
        Ok(Some(checkpoint.with_rules_of(prepared.settings())))
    }

    /// Replaces the file by `checkpoint`. Where that fails, warns once, and the old one stays.
    pub fn keep(&self, checkpoint: &Checkpoint) {
        let never = CancelToken::new();
        let saved = save_checkpoint(self.path, &self.description, checkpoint, &never);
        let mut failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        if let (Err(error), None) = (&saved, &*failure) {
            super::warn(&format!(
                "{}: {error}; the render goes on",
                cannot_write(self.path)
            ));
        }
        *failure = saved.err();
    }

    /// Tells how to go on with a render that was interrupted.
    pub fn say_how_to_go_on(&self) {
        let failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        match &*failure {
            None => super::tell(&format!(
                "{}: --resume goes on from here",
                self.path.display()
            )),
            Some(error) => super::warn(&format!("{}: {error}", cannot_write(self.path))),
        }
    }

    /// Removes the file, which nobody needs once the picture is there.
    pub fn remove(&self) {
        if let Err(error) = std::fs::remove_file(self.path)
            && error.kind() != io::ErrorKind::NotFound
        {
            let name = self.path.display();
            super::warn(&format!("{name}: cannot remove the checkpoint: {error}"));
        }
    }
}

/// `scene` without what only says when its render ends, which may be another time when it goes on.
fn without_rules(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    let usual = RenderSettings::default();
    scene.render = RenderSettings {
        samples_per_pixel: usual.samples_per_pixel,
        stop: usual.stop,
        // A single sample has no error to go on with.
        error_estimate: scene.render.measures_error(),
        ..scene.render
    };
    scene
}

fn cannot_write(path: &Path) -> String {
    format!("{}: cannot write the checkpoint", path.display())
}

fn parse_seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.trim().parse().ok();
    seconds
        .and_then(|seconds| Duration::try_from_secs_f64(seconds).ok())
        .ok_or_else(|| "expected a number of seconds, such as 60 or 0.5".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_are_understood_or_refused() {
        assert_eq!(parse_seconds("0"), Ok(Duration::ZERO));
        assert_eq!(parse_seconds(" 1.5"), Ok(Duration::from_millis(1500)));
        for wrong in ["", "x", "-1", "nan", "inf", "1e300"] {
            assert!(parse_seconds(wrong).is_err(), "{wrong}");
        }
    }
}
