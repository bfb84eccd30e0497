//! Checkpoints of renders as files: a line that names the format, what the render is of, what it has reached, and the SHA-256 of
//! all that, without which nothing is believed.

use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::atomic::write_atomically;
use super::render_description::difference;
use super::unless::Unless;
use super::whole_file::{open_file, read_bounded_file};
use crate::control::{CancelToken, Progress};
use crate::render::Checkpoint;

/// What the first line of every version begins with.
const NAME: &str = "RayMini checkpoint ";
/// The version of what follows, and the end of the line.
const VERSION: &str = "3";
const DIGEST_BYTES: usize = 32;
/// What is hashed and written at once.
const BUFFER_BYTES: usize = 1 << 16;
/// What is hashed between two looks at the cancel token.
const PIECE_BYTES: usize = 1 << 20;

/// Why a checkpoint cannot be gone on from.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {reason}", path.display())]
pub struct CheckpointError {
    /// The file.
    pub path: PathBuf,
    /// A plain sentence.
    pub reason: String,
}

/// Writes `checkpoint` of a render of that [description](super::describe_render) to `path`. The file appears whole or not at all. `None`
/// when cancelled: what was there is as it was.
///
/// # Errors
/// What the system says.
pub fn save_checkpoint(
    path: &Path,
    description: &str,
    checkpoint: &Checkpoint,
    cancel: &CancelToken,
) -> io::Result<Option<()>> {
    let written = write_atomically(path, |inner| {
        write(description, checkpoint, &mut Unless { cancel, inner })
    });
    match written {
        // Failing is how the writing ends then.
        Err(_) if cancel.is_cancelled() => Ok(None),
        written => written.map(Some),
    }
}

/// Reads the checkpoint at `path`, of a render of that [description](super::describe_render). A file of more than `most_bytes` is
/// not one. `None` when cancelled. `progress` advances by the bytes of the file, each once when it is read and once when it is found to be
/// what was written; setting its total is the caller's.
///
/// # Errors
/// When the file cannot be read, is damaged or something else, or is of another render: then with the first thing that differs.
pub fn load_checkpoint(
    path: &Path,
    description: &str,
    most_bytes: u64,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<Checkpoint>, CheckpointError> {
    let read = read(path, description, most_bytes, cancel, progress);
    read.map_err(|reason| CheckpointError {
        path: path.to_owned(),
        reason,
    })
}

fn read(
    path: &Path,
    description: &str,
    most_bytes: u64,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<Checkpoint>, String> {
    const EXPECTED: &str = "a checkpoint of this render";
    // However large the file is, its first line tells whether it is one.
    let mut start = Vec::new();
    let first_line = (NAME.len() + VERSION.len() + 1) as u64;
    let file = open_file(path, EXPECTED)?;
    let read = file.take(first_line).read_to_end(&mut start);
    read.map_err(|error| format!("the file cannot be read: {error}"))?;
    check_first_line(&start)?;
    match read_bounded_file(path, EXPECTED, most_bytes, cancel, progress)? {
        Some(bytes) => parse(&bytes, description, cancel, progress),
        None => Ok(None),
    }
}

/// The checkpoint in the bytes of a file, if it is one of a render of that description.
fn parse(
    bytes: &[u8],
    description: &str,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<Checkpoint>, String> {
    let rest = check_first_line(bytes)?;
    let damaged = || "the checkpoint is damaged: what it holds is not what was written".to_owned();
    let (body, digest) = rest
        .len()
        .checked_sub(DIGEST_BYTES)
        .map(|end| rest.split_at(end))
        .ok_or_else(damaged)?;
    let mut hasher = Sha256::new();
    for piece in bytes[..bytes.len() - DIGEST_BYTES].chunks(PIECE_BYTES) {
        if cancel.is_cancelled() {
            return Ok(None);
        }
        hasher.update(piece);
        progress.advance(piece.len() as u64);
    }
    progress.advance(DIGEST_BYTES as u64);
    if hasher.finalize().as_slice() != digest {
        return Err(damaged());
    }
    let (saved, body) = postcard::take_from_bytes::<&str>(body).map_err(|_| damaged())?;
    if let Some(difference) = difference(saved, description) {
        return Err(format!(
            "it is a checkpoint of another render: {difference}"
        ));
    }
    match postcard::take_from_bytes(body) {
        Ok((checkpoint, [])) => Ok(Some(checkpoint)),
        _ => Err(damaged()),
    }
}

/// What follows the line that every file begins with.
fn check_first_line(bytes: &[u8]) -> Result<&[u8], String> {
    let Some(rest) = bytes.strip_prefix(NAME.as_bytes()) else {
        return Err("this is not a checkpoint of a render".to_owned());
    };
    let version = format!("{VERSION}\n");
    rest.strip_prefix(version.as_bytes()).ok_or_else(|| {
        format!("it is a checkpoint of another version of RayMini; this one reads format {VERSION}")
    })
}

fn write(description: &str, checkpoint: &Checkpoint, file: &mut dyn Write) -> io::Result<()> {
    let mut hashed = Hashed {
        file,
        digest: Sha256::new(),
        failure: None,
    };
    let mut buffer = BufWriter::with_capacity(BUFFER_BYTES, &mut hashed);
    writeln!(buffer, "{NAME}{VERSION}")?;
    let encoded = postcard::to_io(&(description, checkpoint), &mut buffer).map(drop);
    let flushed = buffer.flush();
    // Else what could not be written would be tried again.
    drop(buffer.into_parts());
    if let Some(failure) = hashed.failure {
        return Err(failure);
    }
    encoded.map_err(io::Error::other)?;
    flushed?;
    let Hashed { file, digest, .. } = hashed;
    file.write_all(digest.finalize().as_slice())
}

/// Hashes what it passes on. It keeps the reason of a failure, which serialising does not hand on.
struct Hashed<'a> {
    file: &'a mut dyn Write,
    digest: Sha256,
    failure: Option<io::Error>,
}

impl Write for Hashed<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if let Err(failure) = self.file.write_all(bytes) {
            let kind = failure.kind();
            self.failure = Some(failure);
            return Err(kind.into());
        }
        self.digest.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::*;
    use crate::geometry::shapes::{self, Random};
    use crate::render::{
        CheckpointKeeper, PreparedScene, Region, RenderProgress, RunConfig, Watch, render_watched,
    };
    use crate::scene::{Object, RenderSettings, Scene};

    const DESCRIPTION: &str = "region = 0,0,3,2\n";

    fn parse(bytes: &[u8], description: &str) -> Result<Checkpoint, String> {
        let parsed = super::parse(bytes, description, &CancelToken::new(), &Progress::new());
        parsed.map(|checkpoint| checkpoint.expect("nobody cancels"))
    }

    fn prepared() -> PreparedScene {
        let mut scene = Scene::default();
        let ball = shapes::icosphere(0);
        scene.meshes.insert("ball".into(), Arc::new(ball));
        scene.objects.push(Object {
            mesh: "ball".into(),
            ..Object::default()
        });
        scene.render = RenderSettings {
            width: 3,
            height: 2,
            ..RenderSettings::default()
        };
        scene.render.stop.noise = Some(1e-3);
        let prepared = PreparedScene::prepare(&scene, None, &CancelToken::new());
        prepared.expect("can be rendered").expect("nobody cancels")
    }

    /// The last checkpoint of a render of `scene`, as a file.
    fn file(scene: &PreparedScene) -> Vec<u8> {
        let bytes = Mutex::new(Vec::new());
        let keep = |checkpoint: Checkpoint| {
            let mut bytes = bytes.lock().expect("one thread");
            bytes.clear();
            write(DESCRIPTION, &checkpoint, &mut *bytes).expect("memory takes all");
        };
        let watch = Watch {
            checkpoints: Some(CheckpointKeeper {
                every: std::time::Duration::ZERO,
                most_share: f64::INFINITY,
                keep: &keep,
                in_background: None,
            }),
            ..Watch::default()
        };
        let (run, progress) = (RunConfig::default(), RenderProgress::default());
        render_watched(scene, None, &run, &progress, watch).expect("nobody cancels");
        bytes.into_inner().expect("one thread")
    }

    /// Puts the right digest at the end of `bytes`.
    fn signed(mut bytes: Vec<u8>) -> Vec<u8> {
        let digest = Sha256::digest(&bytes);
        bytes.extend_from_slice(digest.as_slice());
        bytes
    }

    fn parsed(bytes: &[u8]) -> Result<Checkpoint, String> {
        parse(bytes, DESCRIPTION)
    }

    #[test]
    fn what_is_cancelled_is_neither_written_nor_read() {
        let checkpoint = parsed(&file(&prepared())).expect("is right");
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("checkpoint");
        let (never, cancelled) = (CancelToken::new(), CancelToken::new());
        cancelled.cancel();
        let save = |description, cancel| {
            save_checkpoint(&path, description, &checkpoint, cancel).expect("can be written")
        };
        let load = |cancel| load_checkpoint(&path, DESCRIPTION, u64::MAX, cancel, &Progress::new());
        assert_eq!(save(DESCRIPTION, &cancelled), None);
        assert!(!path.exists());
        assert_eq!(save(DESCRIPTION, &never), Some(()));
        assert_eq!(save("another", &cancelled), None);
        assert!(load(&never).expect("is as it was").is_some());
        assert!(load(&cancelled).expect("is right").is_none());
        assert_eq!(
            std::fs::read_dir(folder.path()).expect("a folder").count(),
            1
        );
    }

    #[test]
    fn what_is_read_is_what_was_written() {
        let file = file(&prepared());
        let checkpoint = parsed(&file).expect("is right");
        let mut again = Vec::new();
        write(DESCRIPTION, &checkpoint, &mut again).expect("memory takes all");
        assert!(again == file);
        assert_eq!(checkpoint.region(), Region::full(3, 2));
        assert_eq!(checkpoint.samples_per_pixel(), 16.0);
    }

    #[test]
    fn reading_tells_how_far_it_is_and_can_be_cancelled() {
        let bytes = file(&prepared());
        let file = tempfile::NamedTempFile::new().expect("a file");
        std::fs::write(file.path(), &bytes).expect("is written");
        let (cancel, progress) = (CancelToken::new(), Progress::new());
        let read = || load_checkpoint(file.path(), DESCRIPTION, u64::MAX, &cancel, &progress);
        assert!(read().expect("is right").is_some());
        assert_eq!(progress.done(), 2 * bytes.len() as u64);
        cancel.cancel();
        assert!(read().expect("is right").is_none());
    }

    /// Even with the right digest nothing panics, and no length is believed.
    #[test]
    fn nonsense_with_the_right_digest_is_refused() {
        let scene = prepared();
        let file = file(&scene);
        let body = &file[..file.len() - DIGEST_BYTES];
        for end in 0..body.len() {
            assert!(parsed(&signed(body[..end].to_vec())).is_err());
        }
        let head = NAME.len() + VERSION.len() + 2 + DESCRIPTION.len();
        let mut random = Random::new(3);
        for place in 0..body.len() {
            let mut changed = body.to_vec();
            changed[place] ^= 1 << (random.bits() % 8);
            // Other numbers may be fine.
            if let Ok(other) = parsed(&signed(changed)) {
                assert!(place >= head);
                let _ = other.fits(&scene, Region::full(3, 2), &[]);
            }
            let mut endless = body[..place.max(head)].to_vec();
            endless.extend([0xff; 9]);
            endless.push(1);
            // The last number of all may be any.
            drop(parsed(&signed(endless)));
        }
    }

    #[test]
    fn a_failure_keeps_its_reason() {
        struct Full;
        impl Write for Full {
            fn write(&mut self, _: &[u8]) -> io::Result<usize> {
                Err(io::Error::new(io::ErrorKind::StorageFull, "no room"))
            }

            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let checkpoint = parsed(&file(&prepared())).expect("is right");
        let error = write(DESCRIPTION, &checkpoint, &mut Full).expect_err("is full");
        assert_eq!(error.to_string(), "no room");
    }
}
