//! The window: an egui application around the renderer.
//!
//! It edits a plain [`crate::scene::Scene`], shows it by the GPU while one looks around, and watches renders that run on
//! worker threads. It knows nothing of the command line, and nothing outside this module knows egui, eframe or wgpu.
//!
//! - [`app`]: state, the order of a frame, opening, saving, rendering
//! - [`jobs`], [`worker`], [`event`]: background work and what it says
//! - [`orbit`], [`pick`]: the camera under the mouse, as plain maths
//! - [`tool`], [`gizmo`], [`focus`]: what else the mouse does: moving things by handles, choosing what is sharp
//! - [`ray_view`], [`box_view`]: the rays of a pixel, and the boxes of the structure that they pass
//! - [`preview`], [`preview_image`]: the scene drawn by the GPU
//! - [`picture`], [`picture_buffer`], [`canvas`], [`tile_outlines`], [`first_look`]: the render as it fills in
//! - [`part`], [`region`], [`threads`]: which of its pixels, and who renders them
//! - [`renders`], [`compare`]: the renders of this session, one against another
//! - [`zoom`], [`look`], [`false_colors`], [`inspector`], [`histogram`], [`steps_legend`], [`legend`]: a picture looked at closely
//! - [`error_plot`], [`error_colors`]: how wrong it still is
//! - [`report`]: error against run time, measured over several renders
//! - [`costs`], [`contributions`], [`time_estimate`]: what effects cost, what they bring, and how long all takes
//! - [`balls`]: what materials look like
//! - [`document`], [`undo`], [`edit`], [`selection`], [`commands`], [`messages`]: what is edited, shown, asked for and told
//! - [`keeping`], `recovering`, `render_keeper`: what outlives the window
//! - [`watching`]: files that change while they are open
//! - [`top_bar`], [`status_bar`], [`viewport`], [`panels`], [`dialogs`], [`widgets`], [`number_field`], [`sum`], [`log_plot`],
//!   [`icons`], [`theme`]: what is drawn
//! - [`mod@bench`]: how quick the window is, measured in a real one
//! - `start`: opening the window, and words for when it does not open

pub mod app;
pub mod balls;
pub mod bench;
pub mod box_view;
pub mod canvas;
pub mod commands;
pub mod compare;
pub mod contributions;
pub mod costs;
pub mod dialogs;
pub mod document;
pub mod edit;
pub mod error_colors;
pub mod error_plot;
pub mod event;
pub mod false_colors;
pub mod first_look;
pub mod focus;
pub mod gizmo;
pub mod histogram;
pub mod icons;
pub mod inspector;
pub mod jobs;
pub mod keeping;
pub mod legend;
pub mod log_plot;
pub mod look;
pub mod messages;
pub mod number_field;
pub mod opened_picture;
pub mod orbit;
pub mod panels;
pub mod part;
pub mod pick;
pub mod picture;
pub mod picture_buffer;
pub mod preview;
pub mod preview_image;
pub mod ray_view;
mod recovering;
pub mod region;
mod render_keeper;
pub mod renders;
pub mod report;
pub mod selection;
mod start;
pub mod status_bar;
pub mod steps_legend;
pub mod sum;
pub mod theme;
pub mod threads;
pub mod tile_outlines;
pub mod time_estimate;
pub mod tool;
pub mod top_bar;
pub mod undo;
pub mod viewport;
pub mod watching;
pub mod widgets;
pub mod worker;
pub mod zoom;

pub use app::{App, AppOptions, FileDialogs};
pub use start::{GuiError, OpenRequest, run, show_on_desktop};
