//! Opening the window, opening it anew when its graphics device is lost, and words for when it does not open.

use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::rc::Rc;
use std::time::{Duration, Instant};

use eframe::egui_wgpu;

use super::app::{App, AppOptions, FileDialogs};

/// What the window opens.
#[derive(Clone, Debug, Default)]
pub struct OpenRequest {
    /// Scene or mesh files; the demo when there are none.
    pub paths: Vec<PathBuf>,
}

/// Why there is no window, what is missing, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum GuiError {
    /// No display server, or a library to talk to it is missing.
    #[error(
        "no display answers ({reason}).\n\
         On a machine with a desktop, start RayMini inside it: DISPLAY or WAYLAND_DISPLAY must name it, and a stale \
         WAYLAND_DISPLAY must be unset.\n\
         On a fresh Debian the libraries are: apt install libx11-xcb1 libxcursor1 libxi6 libxkbcommon-x11-0\n\
         Without a display, `raymini render SCENE -o picture.png` makes the same picture."
    )]
    NoDisplay {
        /// What the window library says.
        reason: String,
    },
    /// No graphics driver.
    #[error(
        "no graphics driver can draw the window ({reason}).\n\
         On Debian: apt install mesa-vulkan-drivers (works without a graphics card, too).\n\
         Without it, `raymini render SCENE -o picture.png` makes the same picture."
    )]
    NoGpu {
        /// What the graphics library says.
        reason: String,
    },
    /// A library of the display server is missing in a way that only shows by a panic.
    #[error(
        "the window system gave up ({reason}).\n\
         On Debian: apt install libxkbcommon-x11-0 libx11-xcb1 libxcursor1 libxi6\n\
         Without a window, `raymini render SCENE -o picture.png` makes the same picture."
    )]
    Panicked {
        /// The message of the panic.
        reason: String,
    },
    /// The graphics device was lost, and there is no other.
    #[error(
        "the graphics device was lost, and no other draws the window ({reason}).\n\
         Nothing of your work is lost: the next start offers what was not saved.\n\
         Without a window, `raymini render SCENE -o picture.png` makes the same picture."
    )]
    DeviceLost {
        /// What the driver says.
        reason: String,
    },
    /// The window opened, and what was to be measured in it did not come about.
    #[error("the window cannot be measured: {reason}")]
    NotMeasured {
        /// What happened.
        reason: String,
    },
    /// Something else.
    #[error("the window cannot be opened: {reason}")]
    Other {
        /// What the window library says.
        reason: String,
    },
}

/// Opens the window and returns when it is closed.
///
/// # Errors
/// When there is no display, no graphics driver, or a library is missing: in words, with what to install.
pub fn run(request: OpenRequest) -> Result<(), GuiError> {
    let options = AppOptions {
        paths: request.paths,
        file_dialogs: FileDialogs::Desktop,
        data_folder: super::keeping::data_folder(),
    };
    open(|creation| App::new(creation, options))
}

/// What is in a window, and goes on in another one when the graphics device of the first is lost.
pub(super) trait Survivor: eframe::App {
    /// Has the driver say whether the graphics device is still there.
    fn ask_driver(&self);

    /// Why the graphics device is of no use any more, as far as the driver has said; `None` as long as it is there.
    fn loss(&self) -> Option<String>;

    /// Goes on in a new window, after the device of the one before was lost for the reason `loss`.
    fn move_to(&mut self, creation: &eframe::CreationContext<'_>, loss: &str);

    /// There will be no other window: puts work in safety.
    fn give_up(&mut self);
}

/// A device that is lost sooner after the last loss was never of any use.
const USEFUL: Duration = Duration::from_secs(5);
/// So many such devices in a row are enough.
const MOST_USELESS: usize = 3;

/// Opens a window with what `create` makes in it, and opens it anew whenever its graphics device is lost.
pub(super) fn open<A: Survivor + 'static>(
    create: impl FnOnce(&eframe::CreationContext<'_>) -> A,
) -> Result<(), GuiError> {
    let mut create = Some(create);
    let saved: Rc<RefCell<Option<Saved<A>>>> = Rc::default();
    let mut useless = 0;
    loop {
        let before = saved.take();
        let mut native = native_options();
        if let Some(Saved { window, .. }) = &before {
            native.viewport = placed_as(native.viewport, window);
        }
        let opened_at = Instant::now();
        // Where no window opens, what was saved is still here.
        let waiting = Rc::new(RefCell::new(before));
        let (place, inside) = (Rc::clone(&saved), Rc::clone(&waiting));
        let create = create.take();
        let fill = move |creation: &eframe::CreationContext<'_>| {
            let app = match (inside.take(), create) {
                (Some(mut before), _) => {
                    let memory = before.window.memory(Clone::clone);
                    creation.egui_ctx.memory_mut(|new| *new = memory);
                    before.app.move_to(creation, &before.loss);
                    before.app
                }
                (None, Some(create)) => create(creation),
                (None, None) => return Err("there is nothing to show".into()),
            };
            let hosted = Hosted {
                app: Some(app),
                window: creation.egui_ctx.clone(),
                saved: place,
            };
            Ok(Box::new(hosted) as Box<dyn eframe::App>)
        };
        let run = AssertUnwindSafe(|| eframe::run_native("RayMini", native, Box::new(fill)));
        let result = match catch_unwind(run) {
            Ok(result) => result.map_err(|error| in_words(&error)),
            Err(payload) => {
                // Drawing had begun when the device was lost. The library that opens windows opens no other after that.
                if let Some(Saved { mut app, loss, .. }) = saved.take() {
                    app.give_up();
                    return Err(GuiError::DeviceLost { reason: loss });
                }
                let reason = crate::render::panic_message(payload.as_ref());
                return Err(GuiError::Panicked { reason });
            }
        };
        if let (Some(mut before), Err(error)) = (waiting.take(), &result) {
            before.app.give_up();
            let reason = error.to_string();
            let first = reason.lines().next().unwrap_or_default().to_owned();
            return Err(GuiError::DeviceLost { reason: first });
        }
        let Some(mut lost) = saved.take() else {
            return result;
        };
        useless = if opened_at.elapsed() < USEFUL {
            useless + 1
        } else {
            0
        };
        if useless >= MOST_USELESS {
            lost.app.give_up();
            return Err(GuiError::DeviceLost { reason: lost.loss });
        }
        saved.replace(Some(lost));
    }
}

fn native_options() -> eframe::NativeOptions {
    eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("RayMini")
            .with_app_id("raymini")
            .with_inner_size([1280.0, 800.0])
            .with_min_inner_size([800.0, 520.0]),
        // Pictures are shown as they are saved, without noise on top.
        dithering: false,
        ..eframe::NativeOptions::default()
    }
}

/// A window where the lost one was, as large as that.
fn placed_as(builder: egui::ViewportBuilder, lost: &egui::Context) -> egui::ViewportBuilder {
    let (inner, outer, is_maximized) = lost.input(|input| {
        let viewport = input.viewport();
        (viewport.inner_rect, viewport.outer_rect, viewport.maximized)
    });
    let mut builder = builder.with_maximized(is_maximized.unwrap_or(false));
    if let Some(inner) = inner {
        builder = builder.with_inner_size(inner.size());
    }
    if let Some(outer) = outer {
        builder = builder.with_position(outer.min);
    }
    builder
}

/// What outlives its window.
struct Saved<A> {
    app: A,
    /// The window that was.
    window: egui::Context,
    /// Why its device was lost.
    loss: String,
}

/// What is in a window, which closes when its device is lost.
struct Hosted<A: Survivor> {
    /// `None` once it is saved.
    app: Option<A>,
    window: egui::Context,
    saved: Rc<RefCell<Option<Saved<A>>>>,
}

impl<A: Survivor> Hosted<A> {
    fn app(&mut self) -> &mut A {
        self.app.as_mut().expect("it is saved last")
    }

    fn loss(&self) -> Option<String> {
        self.app.as_ref().and_then(Survivor::loss)
    }
}

impl<A: Survivor> eframe::App for Hosted<A> {
    fn raw_input_hook(&mut self, ctx: &egui::Context, raw_input: &mut egui::RawInput) {
        if self.loss().is_none() {
            self.app().raw_input_hook(ctx, raw_input);
        }
    }

    fn logic(&mut self, ctx: &egui::Context, frame: &mut eframe::Frame) {
        self.app().ask_driver();
        if self.loss().is_none() {
            self.app().logic(ctx, frame);
        }
    }

    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        // Nothing is drawn with a device that is not there: to the library that draws, it would be a fault to give up at.
        if self.loss().is_some() {
            ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close);
        } else {
            self.app().ui(ui, frame);
        }
    }

    fn on_exit(&mut self) {
        if self.loss().is_none() {
            self.app().on_exit();
        }
    }
}

impl<A: Survivor> Drop for Hosted<A> {
    fn drop(&mut self) {
        // Where the library that draws has given up, the loss may not be told of yet.
        if let Some(app) = self.app.as_ref().filter(|_| std::thread::panicking()) {
            app.ask_driver();
        }
        if let (Some(loss), Some(app)) = (self.loss(), self.app.take()) {
            let window = self.window.clone();
            self.saved.replace(Some(Saved { app, window, loss }));
        }
    }
}

fn in_words(error: &eframe::Error) -> GuiError {
    let text = error.to_string();
    // Some libraries name the line of their source that failed, which helps nobody here.
    let reason = match text.rsplit_once(".rs:") {
        Some((_, after)) => after.trim_start_matches(|c: char| c.is_ascii_digit() || c == ':'),
        None => &text,
    };
    let reason = reason.trim().trim_end_matches('.').to_owned();
    match error {
        eframe::Error::Winit(_) | eframe::Error::WinitEventLoop(_) => {
            GuiError::NoDisplay { reason }
        }
        eframe::Error::Wgpu(
            egui_wgpu::WgpuError::CreateSurfaceError(_)
            | egui_wgpu::WgpuError::RequestAdapterError(_)
            | egui_wgpu::WgpuError::RequestDeviceError(_),
        ) => GuiError::NoGpu { reason },
        _ => GuiError::Other { reason },
    }
}
