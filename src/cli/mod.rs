//! The command line: what it takes, and one file per command.
//!
//! Errors carry exit code 1; wrong usage 2, by clap; signals 128 and their number.

mod bench;
mod check;
mod checkpoint;
mod checkpoint_lock;
mod compare;
mod contributions;
mod convert;
mod costs;
mod info;
mod inputs;
mod outcome;
mod plan;
mod progress_bar;
mod proofs;
mod render;
mod report;
mod scene_arguments;
mod signals;
mod stats;
mod time_left;
mod trace;
mod values;

use std::borrow::Cow;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result, anyhow};
use clap::{Parser, Subcommand};
use serde::Serialize;

use crate::analysis::hazards::why_black;
use crate::control::{CancelToken, Progress};
use crate::io::{self, LoadError, LoadedScene};
use crate::scene::SceneError;

pub use bench::WindowBench;
pub use inputs::new_picture;
pub use render::{RenderArguments, render_to_file};
pub use signals::Signals;

/// RayMini: an interactive ray tracer.
#[derive(Debug, Parser)]
#[command(version, about, args_conflicts_with_subcommands = true)]
pub struct Arguments {
    /// What to do instead of opening the window.
    #[command(subcommand)]
    pub command: Option<Command>,

    /// A scene file, or meshes to show together; the built-in demo when left out
    #[arg(value_name = "SCENE or MESH")]
    pub files: Vec<PathBuf>,
}

/// What the program does without a window.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene or mesh to a PNG or EXR file
    Render(RenderArguments),
    /// Measure how the error of a scene's picture falls with run time
    Report(report::ReportArguments),
    /// Say what the render of a scene does, what it leaves out and why, and what each costs
    Plan(plan::PlanArguments),
    /// Say what a mesh, scene or rendered picture holds
    Info(info::InfoArguments),
    /// Write a mesh in another format
    Convert(convert::ConvertArguments),
    /// Measure how far a picture is from a reference, and draw the difference
    Compare(compare::CompareArguments),
    /// Look for what may spoil the picture of a scene, or try the extreme cases that break renderers
    Check(check::CheckArguments),
    /// Measure how fast the structures over a scene are built and traversed
    Bench(bench::BenchArguments),
}

/// The scene of a file; the demo where none is named. `None` when cancelled.
fn load_unless(cancel: &CancelToken, path: Option<&Path>) -> Result<Option<LoadedScene>> {
    match path {
        None => Ok(Some(LoadedScene {
            scene: io::demo_scene(),
            warnings: Vec::new(),
        })),
        Some(path) => Ok(io::load_scene(path, cancel, &Progress::new())?),
    }
}

/// The scene of a file; the demo where none is named.
fn load(path: Option<&Path>) -> Result<LoadedScene> {
    load_unless(&CancelToken::new(), path)?.ok_or_else(|| anyhow!("loading was cancelled"))
}

/// `text` as a terminal may show it: what files hold could else move its cursor, or worse. Line breaks stay.
#[must_use]
pub fn printable(text: &str) -> Cow<'_, str> {
    let is_harmless = |c: char| !c.is_control() || c == '\n';
    if text.chars().all(is_harmless) {
        return Cow::Borrowed(text);
    }
    let shown = |c: char| {
        let escaped = (!is_harmless(c)).then(|| c.escape_default());
        let plain = is_harmless(c).then_some(c);
        escaped.into_iter().flatten().chain(plain)
    };
    Cow::Owned(text.chars().flat_map(shown).collect())
}

/// Prints a line to the standard error. That nobody can read it is no reason to stop.
pub fn tell(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{}", printable(text));
}

/// Prints a warning.
fn warn(text: &str) {
    tell(&format!("warning: {text}"));
}

/// Warns of what is odd about a scene that was read with `warnings`, before it is rendered.
fn warn_of_scene(loaded: &LoadedScene) -> Result<()> {
    for warning in loaded.warnings.iter().chain(&loaded.scene.warnings()) {
        warn(warning);
    }
    if let Some(reason) = why_black(&loaded.scene)? {
        warn(&format!("the picture is black: {reason}"));
    }
    Ok(())
}

/// Prints a line to the standard output. A reader that has gone away is no error.
///
/// # Errors
/// When it cannot be written.
pub fn say(text: &str) -> Result<()> {
    match writeln!(std::io::stdout().lock(), "{}", printable(text)) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(error).context("cannot write to the standard output")
        }
        _ => Ok(()),
    }
}

/// Prints what a program may read to the standard output.
///
/// # Errors
/// When it cannot be written.
pub fn say_json(facts: &impl Serialize) -> Result<()> {
    let json = serde_json::to_string_pretty(facts);
    say(&json.context("the facts cannot be written as JSON")?)
}

impl Command {
    /// What is to be measured of the window, where that is the command: no other needs one.
    #[must_use]
    pub fn window_bench(&self) -> Option<WindowBench> {
        match self {
            Self::Bench(arguments) => arguments.of_window(),
            _ => None,
        }
    }

    /// Carries the command out; the exit code tells whether it was interrupted.
    ///
    /// # Errors
    /// What kept it from being done, in words for the user.
    pub fn run(self, signals: &Signals) -> Result<ExitCode> {
        let scene = self.scene().map(Path::to_owned);
        let done = self.carry_out(signals);
        done.map_err(|error| in_file(error, scene.as_deref()))
    }

    /// The file of the scene that the command is about, if it is about one.
    fn scene(&self) -> Option<&Path> {
        match self {
            Self::Render(arguments) => arguments.scene.path(),
            Self::Check(arguments) => arguments.scene.as_deref(),
            Self::Report(arguments) => arguments.scene.path(),
            Self::Plan(arguments) => arguments.scene.path(),
            Self::Bench(arguments) => arguments.scene.path(),
            Self::Info(_) | Self::Convert(_) | Self::Compare(_) => None,
        }
    }

    fn carry_out(self, signals: &Signals) -> Result<ExitCode> {
        match self {
            Self::Render(arguments) => return render::run(&arguments, signals),
            Self::Check(arguments) => return check::run(&arguments),
            Self::Report(arguments) => return report::run(&arguments, signals),
            Self::Plan(arguments) => plan::run(&arguments)?,
            Self::Info(arguments) => info::run(&arguments)?,
            Self::Convert(arguments) => convert::run(&arguments)?,
            Self::Compare(arguments) => compare::run(&arguments)?,
            Self::Bench(arguments) => bench::run(&arguments)?,
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// The error, with the file of the scene in front where it is about what that describes and does not say so itself.
fn in_file(error: anyhow::Error, scene: Option<&Path>) -> anyhow::Error {
    let is_of_scene =
        error.is::<SceneError>() || matches!(error.downcast_ref(), Some(LoadError::Description(_)));
    match scene.filter(|_| is_of_scene) {
        Some(path) => error.context(path.display().to_string()),
        None => error,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_shown_and_not_sent() {
        assert_eq!(printable("über\ntwo lines"), "über\ntwo lines");
        assert_eq!(
            printable("a\u{1b}[31mb\u{7}\u{9b}\r\t"),
            "a\\u{1b}[31mb\\u{7}\\u{9b}\\r\\t"
        );
    }
}
