//! What the window looks like, from the last window and for the next.

use std::time::{Duration, Instant};

use super::App;
use crate::gui::jobs::Lane;
use crate::gui::keeping::{self, Layout, Theme};

/// Time between two writes of a layout that goes on changing.
const INTERVAL: Duration = Duration::from_secs(1);

/// The layout, and what of it is on disk.
#[derive(Debug, Default)]
pub struct Looks {
    /// As it is.
    pub layout: Layout,
    kept: Layout,
    written: Option<Instant>,
}

impl Looks {
    /// The looks of a window that begins with `layout`.
    pub fn new(layout: Layout) -> Self {
        Self {
            layout,
            kept: layout,
            written: None,
        }
    }
}

impl App {
    /// Takes the looks of the last window.
    pub(super) fn take_looks(&mut self, ctx: &egui::Context) {
        let layout = &self.looks.layout;
        if layout.theme != Theme::Desktop {
            ctx.set_theme(egui::ThemePreference::from(layout.theme));
        }
        self.panel_open = layout.panel.is_open;
        self.error_plot.open = layout.error_plot.is_open;
        self.renders.open = layout.renders.is_open;
        self.tile_outlines.are_shown = layout.tiles_outlined;
    }

    /// Has the looks of the window written where they have changed, but not while they do.
    pub(super) fn keep_looks(&mut self, ctx: &egui::Context) {
        let Some(data) = self.keeping_folder() else {
            return;
        };
        let layout = &mut self.looks.layout;
        layout.theme = ctx.options(|options| options.theme_preference).into();
        layout.tiles_outlined = self.tile_outlines.are_shown;
        ctx.input(|input| {
            let viewport = input.viewport();
            layout.is_maximized = viewport.maximized.unwrap_or(false);
            let size = viewport.inner_rect.map(|rect| rect.size().round());
            if let Some(size) = size.filter(|_| !layout.is_maximized) {
                layout.window = size.into();
            }
        });
        let layout = *layout;
        let is_changing = ctx.input(|input| input.pointer.any_down());
        if layout == self.looks.kept || is_changing || self.jobs.is_busy(Lane::Layout) {
            return;
        }
        let since = self.looks.written.map(|written| written.elapsed());
        if let Some(rest) = since.and_then(|since| INTERVAL.checked_sub(since)) {
            ctx.request_repaint_after(rest);
            return;
        }
        self.looks.kept = layout;
        self.looks.written = Some(Instant::now());
        self.jobs.start(Lane::Layout, move |_| {
            // Looks that cannot be written are no loss to stop anybody for.
            let _ = keeping::save_layout(&data, &layout);
        });
    }

    /// Writes what has changed since, as the window closes.
    pub(super) fn end_looks(&mut self) {
        if let Some(data) = self.keeping_folder()
            && self.looks.layout != self.looks.kept
        {
            self.jobs.wait_for(Lane::Layout, INTERVAL);
            let _ = keeping::save_layout(&data, &self.looks.layout);
        }
    }
}
