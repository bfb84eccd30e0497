//! The program: reads the command line and hands over to a command or to the window.
//!
//! It is a console program on Windows too: as one without a console (`windows_subsystem`) it could print nothing to the terminal that a
//! command is given in, which would not wait for it either. Started from the desktop it has a console beside its window.

use std::ffi::OsStr;
use std::panic::{catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result, bail};
use clap::Parser;
use raymini::cli::{Arguments, Signals, WindowBench, new_picture, render_to_file, tell};
use raymini::control::{CancelToken, Progress};
use raymini::io;
use raymini::render::{RenderFault, keep_panics_quiet};

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    // Who gives a command reads what it says.
    let may_come_from_an_icon = arguments.command.is_none();
    keep_panics_quiet();
    let result = catch_unwind(|| run(arguments)).unwrap_or_else(|payload| {
        // Any other panic has been printed, and ends the program as panics do.
        match payload.downcast::<RenderFault>() {
            Ok(fault) => Err((*fault).into()),
            Err(payload) => resume_unwind(payload),
        }
    });
    result.unwrap_or_else(|error| {
        tell(&format!("error: {error:#}"));
        if may_come_from_an_icon {
            show_on_desktop(&format!("{error:#}"));
        }
        ExitCode::FAILURE
    })
}

fn run(arguments: Arguments) -> Result<ExitCode> {
    let signals = Signals::watch().context("signals cannot be watched")?;
    match arguments.command {
        Some(command) => match command.window_bench() {
            Some(bench) => bench_window(&bench),
            None => command.run(&signals),
        },
        None => open_window(&arguments.files, &signals),
    }
}

/// Measures the window and prints what comes out; exit code 1 where a bar is missed.
fn bench_window(bench: &WindowBench) -> Result<ExitCode> {
    if let Some(missing) = bench.scene.as_ref().filter(|path| !path.exists()) {
        bail!("{}: there is no such file", missing.display());
    }
    measure_window(bench)
}

#[cfg(feature = "gui")]
fn measure_window(bench: &WindowBench) -> Result<ExitCode> {
    use raymini::gui::bench::{BenchRequest, measure};

    let figures = measure(&BenchRequest {
        scene: bench.scene.clone(),
        repeats: bench.repeats,
    })?;
    if bench.json {
        raymini::cli::say_json(&figures.for_programs())?;
    } else {
        raymini::cli::say(figures.describe().trim_end())?;
    }
    Ok(if figures.keeps_all_bars() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// There is no window to measure.
#[cfg(not(feature = "gui"))]
fn measure_window(_: &WindowBench) -> Result<ExitCode> {
    bail!("this program was built without its window, so there is none to measure")
}

/// Opens the window on `files`; where there is no screen, or no graphics driver, renders them to a file instead and says so.
fn open_window(files: &[PathBuf], signals: &Signals) -> Result<ExitCode> {
    if let Some(missing) = files.iter().find(|path| !path.exists()) {
        bail!(
            "{}: there is no such file or command; `raymini --help` lists the commands",
            missing.display()
        );
    }
    #[cfg(feature = "gui")]
    let reason = match raymini::gui::run(raymini::gui::OpenRequest {
        paths: files.to_vec(),
    }) {
        Ok(()) => return Ok(ExitCode::SUCCESS),
        // Who has worked in it wants no picture instead.
        Err(error) if error.was_open() => bail!(error),
        Err(error) => error.to_string(),
    };
    #[cfg(not(feature = "gui"))]
    let reason = "this program was built without its window";

    let no_window = format!("No window can be opened: {reason}");
    tell(&no_window);
    let (scene, stem) = if files.is_empty() {
        (io::demo_scene(), OsStr::new("raymini-demo"))
    } else {
        let loaded = io::load_scenes(files, &CancelToken::new(), &Progress::new())?;
        let stem = files[0].file_stem().unwrap_or_default();
        (loaded.context("loading was cancelled")?.scene, stem)
    };
    // Nobody has asked for a picture, so none takes the place of a file.
    let output = new_picture(Path::new(""), stem);
    let instead = |output: &Path| {
        format!(
            "Rendering to {} instead. `raymini render --help` says what else can be done.",
            output.display()
        )
    };
    tell(&instead(&output));
    // On the desktop there is no folder that names are from.
    let place = std::path::absolute(&output).unwrap_or_else(|_| output.clone());
    let words = format!("{no_window}\n\n{}", instead(&place));
    // It may be long until somebody has read them.
    std::thread::scope(|scope| {
        scope.spawn(|| show_on_desktop(&words));
        let path = files.first().map(PathBuf::as_path);
        render_to_file(&scene, path, &output, signals)
    })
}

/// Shows `text` on the desktop where no terminal does.
fn show_on_desktop(text: &str) {
    #[cfg(feature = "gui")]
    raymini::gui::show_on_desktop(&raymini::cli::printable(text));
    #[cfg(not(feature = "gui"))]
    let _ = text;
}
