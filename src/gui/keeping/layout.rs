//! What the window looks like, as JSON: a new one looks like the last that was closed.

use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::lock_shared;
use crate::io::write_atomically;

const FILE: &str = "layout.json";
/// Width and height of the window where nothing else is known, in points.
const WINDOW: [f32; 2] = [1280.0, 800.0];
/// The least width and height of the window, in points.
pub const LEAST_WINDOW: [f32; 2] = [800.0, 520.0];
/// Larger than any screen: a file that says so is wrong.
const MOST: f32 = 32_768.0;

/// Colours of the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Theme {
    /// Those of the desktop.
    #[default]
    Desktop,
    /// Dark ones.
    Dark,
    /// Light ones.
    Light,
}

impl From<egui::ThemePreference> for Theme {
    fn from(preference: egui::ThemePreference) -> Self {
        match preference {
            egui::ThemePreference::System => Self::Desktop,
            egui::ThemePreference::Dark => Self::Dark,
            egui::ThemePreference::Light => Self::Light,
        }
    }
}

impl From<Theme> for egui::ThemePreference {
    fn from(theme: Theme) -> Self {
        match theme {
            Theme::Desktop => Self::System,
            Theme::Dark => Self::Dark,
            Theme::Light => Self::Light,
        }
    }
}

/// A part of the window that may be folded away.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Fold {
    /// Whether it is seen.
    pub is_open: bool,
    /// Its width or height while it is, in points; `None` for the usual.
    pub size: Option<f32>,
}

impl Fold {
    /// Takes note of how it is drawn now; `size`: where it is.
    pub fn note(&mut self, is_open: bool, size: Option<f32>) {
        self.is_open = is_open;
        // Fractions come of the way there, and are nobody's wish.
        self.size = size.filter(|_| is_open).map(f32::round).or(self.size);
    }

    /// [`Self::size`] where it can be right, else `usual`.
    #[must_use]
    pub fn size_or(&self, usual: f32) -> f32 {
        self.size.filter(|&size| is_size(size)).unwrap_or(usual)
    }
}

/// What the window looks like.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Layout {
    /// Width and height of the window, in points; as it was before, where it is maximized.
    pub window: [f32; 2],
    /// Whether it fills the screen.
    pub is_maximized: bool,
    /// Its colours.
    pub theme: Theme,
    /// The side panel.
    pub panel: Fold,
    /// The error plot.
    pub error_plot: Fold,
    /// The renders of the session.
    pub renders: Fold,
    /// Whether tiles at work are outlined.
    pub tiles_outlined: bool,
}

impl Default for Layout {
    fn default() -> Self {
        Self {
            window: WINDOW,
            is_maximized: false,
            theme: Theme::default(),
            panel: Fold {
                is_open: true,
                size: None,
            },
            error_plot: Fold::default(),
            renders: Fold::default(),
            tiles_outlined: true,
        }
    }
}

impl Layout {
    /// Width and height of the window where they can be right, else the usual ones.
    #[must_use]
    pub fn window_size(&self) -> [f32; 2] {
        let is_right = |(size, least): (&f32, f32)| is_size(*size) && *size >= least;
        if self.window.iter().zip(LEAST_WINDOW).all(is_right) {
            self.window
        } else {
            WINDOW
        }
    }
}

fn is_size(size: f32) -> bool {
    (1.0..=MOST).contains(&size)
}

/// What the last window looked like that kept its layout in `data`; the usual where none did, or where that cannot be read.
#[must_use]
pub fn load_layout(data: &Path) -> Layout {
    let text = std::fs::read_to_string(data.join(FILE)).unwrap_or_default();
    serde_json::from_str(&text).unwrap_or_default()
}

/// Keeps `layout` in `data` for the next window.
///
/// # Errors
/// What the system says.
pub fn save_layout(data: &Path, layout: &Layout) -> io::Result<()> {
    let lock = lock_shared(data)?;
    let text = serde_json::to_string_pretty(layout)?;
    write_atomically(&data.join(FILE), |file| file.write_all(text.as_bytes()))?;
    drop(lock);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layout_is_what_it_was_and_a_wrong_file_does_no_harm() {
        let folder = tempfile::tempdir().unwrap();
        let data = folder.path();
        assert_eq!(load_layout(data), Layout::default());
        let mut layout = Layout {
            window: [1600.0, 900.0],
            theme: Theme::Light,
            ..Layout::default()
        };
        layout.renders.note(true, Some(180.4));
        layout.renders.note(false, Some(3.0));
        assert_eq!(
            layout.renders.size_or(1.0),
            180.0,
            "as it was when it was open"
        );
        save_layout(data, &layout).unwrap();
        assert_eq!(load_layout(data), layout);

        let file = data.join(FILE);
        for (text, window) in [
            ("no layout", WINDOW),
            ("{\"window\": [1e30, 900]}", WINDOW),
            (
                "{\"window\": [3, 900], \"panel\": {\"size\": -1e9}}",
                WINDOW,
            ),
            ("{\"window\": [900, 800], \"unknown\": 1}", [900.0, 800.0]),
        ] {
            std::fs::write(&file, text).unwrap();
            let layout = load_layout(data);
            assert_eq!(layout.window_size(), window, "{text}");
            assert_eq!(layout.panel.size_or(332.0), 332.0);
        }
    }
}
