//! `raymini bench --window`: how quick the window is while all cores render, measured in a real one.
//!
//! The program opens its own window and works in it as a user does, by keys and the mouse, while a render runs that would take hours:
//! it watches, points at the picture, drags the camera, cancels, and edits with Live on. What is measured of a frame is the processor
//! time of the thread that draws the window, from the start of one frame to that of the next. The window keeps work and renders on disk as
//! any other does, in a folder of its own that goes when it closes.
//!
//! - `script`: what is done in the window
//! - `figures`: what came out
//! - `bars`: what is to come out, and all of it as a table

mod bars;
mod figures;
mod script;

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use super::app::{App, AppOptions, FileDialogs};
use super::keeping::Layout;
use super::start::{self, GuiError, Survivor};
use crate::analysis::report::Machine;
pub use bars::Kept;
pub use figures::{FrameFigures, RestartFigures, Spread, WindowFigures};
use script::{Ending, Script};

/// What is measured.
#[derive(Clone, Debug)]
pub struct BenchRequest {
    /// A scene or a mesh; the demo when left out.
    pub scene: Option<PathBuf>,
    /// How often everything is measured.
    pub repeats: u16,
}

/// Opens a window, measures in it and closes it.
///
/// # Errors
/// When no window can be opened, when it is closed before the end, or when something in it does not come about; when nothing can be kept
/// in the system's folder for temporary files.
pub fn measure(request: &BenchRequest) -> Result<WindowFigures, GuiError> {
    let data = data_folder()?;
    let options = AppOptions {
        paths: request.scene.iter().cloned().collect(),
        file_dialogs: FileDialogs::PathField,
        data_folder: Some(data.path().to_owned()),
        ..AppOptions::default()
    };
    let ending: Arc<Mutex<Option<Ending>>> = Arc::default();
    let place = Arc::clone(&ending);
    let repeats = usize::from(request.repeats);
    start::open(&Layout::default(), move |creation| {
        let render_state = creation.wgpu_render_state.as_ref();
        let adapter = render_state.map(|state| state.adapter.get_info().name);
        Bench {
            app: App::new(creation, options),
            script: Script::new(repeats),
            adapter: adapter.unwrap_or_else(|| "none".to_owned()),
            ending: place,
        }
    })?;
    remove(&data);
    let ending = ending.lock().unwrap_or_else(PoisonError::into_inner).take();
    let reason = match ending {
        Some(Ending::Measured(figures)) => {
            return Ok(WindowFigures {
                scene: request
                    .scene
                    .as_ref()
                    .map_or_else(|| "demo".to_owned(), |path| path.display().to_string()),
                ..*figures
            });
        }
        Some(Ending::Stuck(reason)) => reason,
        None => "the window was closed before the end".to_owned(),
    };
    Err(GuiError::NotMeasured { reason })
}

/// Where the window keeps its work: never where the user's is.
fn data_folder() -> Result<TempDir, GuiError> {
    let folder = tempfile::Builder::new().prefix("raymini-bench-").tempdir();
    folder.map_err(|error| GuiError::NotMeasured {
        reason: format!("nothing can be kept on disk: {error}"),
    })
}

/// Removes the folder, in which other threads may still be removing what they kept.
fn remove(data: &TempDir) {
    const MOST: Duration = Duration::from_secs(5);
    let started = Instant::now();
    while data.path().exists()
        && std::fs::remove_dir_all(data.path()).is_err()
        && started.elapsed() < MOST
    {
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// The window, and who works in it.
struct Bench {
    app: App,
    script: Script,
    adapter: String,
    ending: Arc<Mutex<Option<Ending>>>,
}

impl Bench {
    /// Whether all is done. The window is closing then.
    fn take_ending(&mut self, ctx: &egui::Context) -> bool {
        let Some(ending) = self.script.take_ending() else {
            return self.script.is_over();
        };
        let pixels = ctx.content_rect().size() * ctx.pixels_per_point();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "sides of a window"
        )]
        let size = [pixels.x, pixels.y].map(|side| side.round() as u32);
        let ending = match ending {
            Ending::Measured(figures) => Ending::Measured(Box::new(WindowFigures {
                adapter: self.adapter.clone(),
                machine: Machine::this(super::threads::cores()).describe(),
                triangles: self.app.document().scene.triangle_count(),
                window: size,
                ..*figures
            })),
            stuck @ Ending::Stuck(_) => stuck,
        };
        *self.ending.lock().unwrap_or_else(PoisonError::into_inner) = Some(ending);
        ctx.send_viewport_cmd(egui::ViewportCommand::Close);
        true
    }
}

impl eframe::App for Bench {
    fn raw_input_hook(&mut self, ctx: &egui::Context, raw_input: &mut egui::RawInput) {
        self.script
            .begin_frame(&mut self.app, ctx, &mut raw_input.events);
    }

    fn logic(&mut self, ctx: &egui::Context, frame: &mut eframe::Frame) {
        self.app.logic(ctx, frame);
    }

    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        let ctx = ui.ctx().clone();
        // What was edited is nobody's work, so the window may close without a question.
        if !self.take_ending(&ctx) {
            self.app.ui(ui, frame);
            self.script.end_frame(&self.app, &ctx);
        }
    }

    fn on_exit(&mut self) {
        self.app.on_exit();
    }
}

impl Survivor for Bench {
    fn ask_driver(&self) {
        self.app.ask_driver();
    }

    fn loss(&self) -> Option<String> {
        self.app.loss()
    }

    fn move_to(&mut self, creation: &eframe::CreationContext<'_>, loss: &str) {
        self.app.move_to(creation, loss);
        self.script.window_moved(&mut self.app);
    }

    fn give_up(&mut self) {
        self.app.give_up();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_kept_goes_with_all_that_is_in_it() {
        let data = data_folder().unwrap();
        let folder = data.path().to_owned();
        std::fs::create_dir_all(folder.join("sessions/a")).unwrap();
        std::fs::write(folder.join("sessions/a/scene.toml"), "").unwrap();
        remove(&data);
        assert!(!folder.exists());
        // Twice is no error.
        remove(&data);
    }
}
