//! Opening the window, and words for when it does not open.
//!
//! - `guard`: faults while a window draws, which end that window and not the program
//! - `reopening`: a new window when the graphics device of one is lost
//! - `message_box`: the words, where no terminal shows them

mod guard;
mod message_box;
mod reopening;

use std::path::PathBuf;

use eframe::wgpu;

use super::app::{App, AppOptions, FileDialogs};
use super::keeping::{LEAST_WINDOW, Layout};
pub use message_box::show_on_desktop;
pub(super) use reopening::{Survivor, open};

/// What the window opens.
#[derive(Clone, Debug, Default)]
pub struct OpenRequest {
    /// Scene or mesh files; the demo when there are none.
    pub paths: Vec<PathBuf>,
}

/// Whether it is known what is to be installed.
const IS_LINUX: bool = cfg!(target_os = "linux");
/// What to do where no display answers.
const DISPLAY_ADVICE: &str = if IS_LINUX {
    "On a machine with a desktop, start RayMini inside it: DISPLAY or WAYLAND_DISPLAY must name it, and a stale \
     WAYLAND_DISPLAY must be unset.\n\
     On a fresh Debian the libraries are: apt install libx11-xcb1 libxcursor1 libxi6 libxkbcommon-x11-0"
} else {
    DESKTOP_ADVICE
};
/// What to do where no graphics driver draws.
const DRIVER_ADVICE: &str = if IS_LINUX {
    "On Debian: apt install mesa-vulkan-drivers (works without a graphics card, too)."
} else {
    "Install the newest graphics driver that there is for this machine."
};
/// What to do where the window system fails.
const LIBRARY_ADVICE: &str = if IS_LINUX {
    "On Debian: apt install libxkbcommon-x11-0 libx11-xcb1 libxcursor1 libxi6"
} else {
    DESKTOP_ADVICE
};
/// What to do where nothing is to be installed.
const DESKTOP_ADVICE: &str = "Start RayMini on a desktop that somebody is logged in to.";

/// Why there is no window, what is missing, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum GuiError {
    /// Nothing to show a window on, or a library to talk to it is missing.
    #[error(
        "no display answers ({reason}).\n\
         {}\n\
         Without a display, `raymini render SCENE -o picture.png` makes the same picture.",
        DISPLAY_ADVICE
    )]
    NoDisplay {
        /// What the window library says.
        reason: String,
    },
    /// No graphics driver.
    #[error(
        "no graphics driver can draw the window ({reason}).\n\
         {}\n\
         Without it, `raymini render SCENE -o picture.png` makes the same picture.",
        DRIVER_ADVICE
    )]
    NoGpu {
        /// What the graphics library says.
        reason: String,
    },
    /// The window system, or a library to talk to it, failed in a way that only shows by a panic.
    #[error(
        "the window system gave up ({reason}).\n\
         {}\n\
         Without a window, `raymini render SCENE -o picture.png` makes the same picture.",
        LIBRARY_ADVICE
    )]
    Panicked {
        /// The message of the panic.
        reason: String,
    },
    /// The graphics device was lost, and there is no other.
    #[error(
        "the graphics device was lost, and no other draws the window ({reason}).\n\
         What you have not saved is kept: the next start offers it.\n\
         Without a window, `raymini render SCENE -o picture.png` makes the same picture."
    )]
    DeviceLost {
        /// What the driver says.
        reason: String,
    },
    /// A fault of the program while it was in use.
    #[error(
        "the program has a fault and cannot go on: {reason}.\n\
         What you have not saved is kept: the next start offers it."
    )]
    Fault {
        /// The message of the panic.
        reason: String,
    },
    /// The window opened, and what was to be measured in it did not come about.
    #[error("the window cannot be measured: {reason}")]
    NotMeasured {
        /// What happened.
        reason: String,
    },
}

impl GuiError {
    /// Whether there was a window, which somebody worked in.
    #[must_use]
    pub fn was_open(&self) -> bool {
        matches!(
            self,
            Self::DeviceLost { .. } | Self::Fault { .. } | Self::NotMeasured { .. }
        )
    }
}

/// Opens the window and returns when it is closed.
///
/// # Errors
/// When there is no display, no graphics driver, or a library is missing: in words, with what to install. When the graphics device is
/// lost for good, or the program has a fault: what is not saved is kept then.
pub fn run(request: OpenRequest) -> Result<(), GuiError> {
    let data_folder = super::keeping::data_folder();
    let layout = data_folder.as_deref().map(super::keeping::load_layout);
    let layout = layout.unwrap_or_default();
    let options = AppOptions {
        paths: request.paths,
        file_dialogs: FileDialogs::Desktop,
        data_folder,
        layout,
    };
    open(&layout, |creation| App::new(creation, options))
}

fn native_options(layout: &Layout) -> eframe::NativeOptions {
    eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("RayMini")
            .with_app_id("raymini")
            .with_inner_size(layout.window_size())
            .with_maximized(layout.is_maximized)
            .with_min_inner_size(LEAST_WINDOW),
        // Pictures are shown as they are saved, without noise on top.
        dithering: false,
        ..eframe::NativeOptions::default()
    }
}

/// Why the library that opens windows, which does not tell, has opened none: what the graphics drivers say.
fn why_no_window() -> GuiError {
    let setup = eframe::egui_wgpu::WgpuSetup::without_display_handle();
    let instance = pollster::block_on(setup.new_instance());
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    let names: Vec<String> = adapters.iter().map(|a| a.get_info().name).collect();
    let reason = if names.is_empty() {
        "none is installed".to_owned()
    } else {
        format!("not even {}", names.join(", "))
    };
    GuiError::NoGpu { reason }
}

/// What went wrong with the window system, for a sentence.
fn no_display(error: &winit::error::EventLoopError) -> GuiError {
    let text = error.to_string();
    // Some libraries name the line of their source that failed, which helps nobody here.
    let reason = match text.rsplit_once(".rs:") {
        Some((_, after)) => after.trim_start_matches(|c: char| c.is_ascii_digit() || c == ':'),
        None => &text,
    };
    let reason = reason.trim().trim_end_matches('.').to_owned();
    GuiError::NoDisplay { reason }
}
