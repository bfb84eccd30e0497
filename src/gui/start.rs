//! Opening the window, and words for when it does not open.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;

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
    open(|creation| Box::new(App::new(creation, options)))
}

/// Opens a window with what `create` makes in it.
pub(super) fn open(
    create: impl FnOnce(&eframe::CreationContext<'_>) -> Box<dyn eframe::App>,
) -> Result<(), GuiError> {
    let native = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("RayMini")
            .with_app_id("raymini")
            .with_inner_size([1280.0, 800.0])
            .with_min_inner_size([800.0, 520.0]),
        // Pictures are shown as they are saved, without noise on top.
        dithering: false,
        ..eframe::NativeOptions::default()
    };
    let opened = catch_unwind(AssertUnwindSafe(|| {
        eframe::run_native("RayMini", native, Box::new(|creation| Ok(create(creation))))
    }));
    match opened {
        Ok(result) => result.map_err(|error| in_words(&error)),
        Err(payload) => Err(GuiError::Panicked {
            reason: crate::render::panic_message(payload.as_ref()),
        }),
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
