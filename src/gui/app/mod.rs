//! The window's state and the order of one frame.
//!
//! A frame takes in what background jobs have to say (`App::take_news`), draws bars, panels and the central area, which
//! edit the scene in place or name a [`Command`], carries the commands out, and last looks at what changed: new geometry
//! is handed to a job to prepare, a new display setting to a job that encodes the picture anew. What came of a picture goes to its
//! textures when the central area is drawn (`App::show_tiles`). Everything slow is a job; see [`super::jobs`] for how jobs and window talk.
//!
//! - `bookmarks`: cameras to come back to
//! - `comparing`: the shown picture against another
//! - `contributing`: what effects and lights bring
//! - `editing`: undoing, copying, removing
//! - `importing`: what becomes of meshes that were read
//! - `keeping`: unsaved work and recent files on disk
//! - `locating`: files that scenes name and that are elsewhere
//! - `opening`: scenes and meshes from files
//! - `reloading`: files that change while they are open
//! - `saving`: scenes and pictures to files, and questions about unsaved work
//! - `seeing`: pixels and brightness of the picture on the screen
//! - `rendering`: preparing, rendering, showing the picture
//! - `looks`: what the window looks like, for the next one
//! - `stopping`: by which rules renders end, and going on by other ones
//! - `naming`: what renders are called
//! - `live`: the picture that follows every change
//! - `renders`: which of the session's pictures is looked at
//! - `reporting`: error against run time
//! - `measuring`: what effects cost
//! - `surviving`: going on in another window when the graphics device is lost
//! - `timing`: how long a render will take
//! - `waiting`: the render that was asked for, until its geometry is there
//! - `news`: what jobs have to say
//! - `obeying`: what the user asks for by name
//! - `tracing`: the rays of a pixel, and the structure they pass
//! - `tools`: what the mouse does in the preview
//! - `layout`: where everything is drawn

mod asking;
mod bookmarks;
mod comparing;
mod contributing;
mod editing;
mod importing;
mod keeping;
mod layout;
mod live;
mod locating;
mod looks;
mod measuring;
mod naming;
mod news;
mod obeying;
mod opening;
mod reloading;
mod rendering;
mod renders;
mod reporting;
mod saving;
mod seeing;
mod stopping;
mod surviving;
#[cfg(test)]
mod testing;
mod timing;
mod tools;
mod tracing;
mod waiting;

use std::collections::VecDeque;
use std::path::PathBuf;

use super::balls::Balls;
use super::box_view::BoxView;
use super::commands::Command;
use super::compare::Comparison;
use super::contributions::Contributions;
use super::costs::CostState;
use super::dialogs::{Dialog, Intent};
use super::document::Document;
use super::edit::Part;
use super::error_plot::ErrorPlot;
use super::event::Event;
use super::gizmo::Orientation;
use super::inspector::{Inspected, Surface};
use super::jobs::{Jobs, Lane};
use super::keeping::Layout;
use super::look::Channels;
use super::messages::Messages;
use super::picture::Picture;
use super::preview_image::PreviewImage;
use super::ray_view::RayView;
use super::region::RegionTool;
use super::renders::{Freed, Renders};
use super::report::ReportWindow;
use super::selection::Selection;
use super::theme;
use super::threads::{Attention, Threads};
use super::tile_outlines::TileOutlines;
use super::time_estimate::TimeState;
use super::top_bar::{Phase, Recent, TopBarState, View};
use super::undo::Gesture;
use super::viewport::Viewport;
use super::worker::{Placed, ReportRequest};
use super::zoom::Zoom;
use crate::control::Progress;
use crate::io::{self, MissingFile, Moves};
use crate::math::DBounds;
use crate::render::{Layer, PreparedScene, PrimaryHitStore, SketchStore, StopRules};
use crate::scene::{Object, Scene, SceneError};

pub use reloading::Stale;
use waiting::WaitingRender;

/// How the window starts.
#[derive(Clone, Debug, Default)]
pub struct AppOptions {
    /// Files to open; the demo when there are none.
    pub paths: Vec<PathBuf>,
    /// Where file paths come from.
    pub file_dialogs: FileDialogs,
    /// Where unsaved work and the list of recent files are kept; `None` keeps neither.
    pub data_folder: Option<PathBuf>,
    /// What the window looks like at first.
    pub layout: Layout,
}

/// Where file paths come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum FileDialogs {
    /// The desktop's dialog; the path field where there is none.
    #[default]
    Desktop,
    /// Always the path field.
    PathField,
}

/// The window.
#[derive(Debug)]
pub struct App {
    document: Document,
    selection: Selection,
    /// What was copied last.
    clipboard: Option<Part>,
    gesture: Gesture,
    view: View,
    viewport: Viewport,
    preview: Option<PreviewImage>,
    prepared: Option<PreparedState>,
    /// What the rays from the eye hit in the last render.
    primary_hits: PrimaryHitStore,
    /// What is kept from one sketch of moving objects to the next.
    sketches: SketchStore,
    /// The scene that was last handed over to prepare.
    preparing: Option<Scene>,
    /// How far its acceleration structure is.
    build_progress: Progress,
    /// A scene that is not prepared until it is to be rendered, or edited: that was cancelled.
    unwanted_preparation: Option<Scene>,
    /// Rules to end a render by that were set in the panel, as long as the running one may not go by them yet.
    asked_rules: Option<StopRules>,
    /// The first value of the scene as it is that cannot be rendered.
    invalid: Option<String>,
    /// The objects that were looked through for it last, and what was found: they may be very many, and seldom change.
    checked_objects: (Vec<Object>, Result<(), SceneError>),
    /// Why the scene that was prepared last cannot be rendered.
    problem: Option<String>,
    picture: Option<Picture>,
    renders: Renders,
    /// The number of the render before the present one that is looked at; `None` for the present one.
    shown_render: Option<usize>,
    /// The number of the last render that was remembered.
    render_count: usize,
    /// Memory that the next render gives back before it begins.
    freed: Vec<Freed>,
    comparison: Option<Comparison>,
    zoom: Zoom,
    /// What the mouse points at in the picture.
    inspected: Option<Inspected>,
    /// What it points at in the preview.
    seen: Option<Surface>,
    brightness: seeing::Brightness,
    error_plot: ErrorPlot,
    /// The layer of the picture to show, where it is kept; `None` shows all of it.
    shown_layer: Option<Layer>,
    /// The channels that show.
    channels: Channels,
    /// Whether a render follows every change of what it shows.
    is_live: bool,
    /// A render that waits for its geometry.
    waiting_render: Option<WaitingRender>,
    costs: CostState,
    time: TimeState,
    balls: Balls,
    contributions: Contributions,
    /// The rays of the pixel that was clicked last.
    rays: Option<RayView>,
    boxes: BoxView,
    report: ReportWindow,
    /// A report was asked for and waits until nothing else works.
    waiting_report: Option<ReportRequest>,
    loading: Option<Loading>,
    reloading: reloading::Reloading,
    keeping: keeping::Keeping,
    jobs: Jobs<Event>,
    messages: Messages,
    dialog: Option<Dialog>,
    file_dialogs: FileDialogs,
    after_saving: Option<Intent>,
    /// The scenes that are being written, in that order.
    scene_saves: VecDeque<Scene>,
    /// The pictures that are being written, in that order.
    picture_saves: VecDeque<saving::PictureSave>,
    /// Where files were found that scenes named elsewhere.
    found_places: Moves,
    /// A missing file of the open scene of which the user is to say where it is.
    sought: Option<MissingFile>,
    /// Questions that wait for the one that shows.
    asked_later: VecDeque<Dialog>,
    may_close: bool,
    panel_open: bool,
    tile_outlines: TileOutlines,
    looks: looks::Looks,
    threads: Threads,
    attention: Attention,
    /// The part of the picture that is rendered.
    region: RegionTool,
    title: String,
}

/// What was prepared, and from what.
#[derive(Debug)]
struct PreparedState {
    placed: Placed,
    /// For rendering; that of a scene before where this one is placed only, `None` for the first.
    prepared: Option<PreparedScene>,
    scene: Scene,
    bounds: DBounds,
}

/// Files being read.
#[derive(Debug)]
struct Loading {
    what: String,
    progress: Progress,
}

impl App {
    /// The window on what `options` names. Without `wgpu_render_state` there is no preview, and everything else works.
    #[must_use]
    pub fn new(creation: &eframe::CreationContext<'_>, options: AppOptions) -> Self {
        theme::install(&creation.egui_ctx);
        let mut app = Self {
            document: Document::new(Scene::default(), "RayMini".to_owned(), None),
            selection: Selection::Camera,
            clipboard: None,
            gesture: Gesture::default(),
            view: View::Preview,
            viewport: Viewport::default(),
            preview: creation
                .wgpu_render_state
                .as_ref()
                .map(|state| PreviewImage::new(state, &creation.egui_ctx)),
            prepared: None,
            primary_hits: PrimaryHitStore::default(),
            sketches: SketchStore::default(),
            preparing: None,
            build_progress: Progress::new(),
            unwanted_preparation: None,
            asked_rules: None,
            invalid: None,
            checked_objects: (Vec::new(), Ok(())),
            problem: None,
            picture: None,
            renders: Renders::default(),
            shown_render: None,
            render_count: 0,
            freed: Vec::new(),
            comparison: None,
            zoom: Zoom::default(),
            inspected: None,
            seen: None,
            brightness: seeing::Brightness::default(),
            error_plot: ErrorPlot::default(),
            shown_layer: None,
            channels: Channels::default(),
            is_live: false,
            waiting_render: None,
            costs: CostState::default(),
            time: TimeState::default(),
            balls: Balls::default(),
            contributions: Contributions::default(),
            rays: None,
            boxes: BoxView::default(),
            report: ReportWindow::default(),
            waiting_report: None,
            loading: None,
            reloading: reloading::Reloading::default(),
            keeping: keeping::Keeping::default(),
            jobs: Jobs::new(creation.egui_ctx.clone()),
            messages: Messages::default(),
            dialog: None,
            file_dialogs: options.file_dialogs,
            after_saving: None,
            scene_saves: VecDeque::new(),
            picture_saves: VecDeque::new(),
            found_places: Moves::new(),
            sought: None,
            asked_later: VecDeque::new(),
            may_close: false,
            panel_open: true,
            tile_outlines: TileOutlines::default(),
            looks: looks::Looks::new(options.layout),
            threads: Threads::default(),
            attention: Attention::default(),
            region: RegionTool::default(),
            title: String::new(),
        };
        app.take_looks(&creation.egui_ctx);
        app.load(options.paths);
        app.begin_keeping(options.data_folder);
        app
    }

    /// The scene being edited.
    #[must_use]
    pub fn document(&self) -> &Document {
        &self.document
    }

    /// The scene being edited, for whoever edits it from outside.
    pub fn document_mut(&mut self) -> &mut Document {
        &mut self.document
    }

    /// What is known of what effects cost.
    #[must_use]
    pub fn costs(&self) -> &CostState {
        &self.costs
    }

    /// What is known of what materials look like.
    #[must_use]
    pub fn balls(&self) -> &Balls {
        &self.balls
    }

    /// What is known of what effects and lights bring.
    #[must_use]
    pub fn contributions(&self) -> &Contributions {
        &self.contributions
    }

    /// The last render, running or ended.
    #[must_use]
    pub fn picture(&self) -> Option<&Picture> {
        self.picture.as_ref()
    }

    /// The renders before the present one.
    #[must_use]
    pub fn renders(&self) -> &Renders {
        &self.renders
    }

    /// The picture that is looked at: of the present render, or of one before it.
    #[must_use]
    pub fn picture_on_screen(&self) -> Option<&Picture> {
        let is_shown = self.view == View::Picture;
        self.shown_picture().filter(|_| is_shown)
    }

    /// What the shown picture is compared with.
    #[must_use]
    pub fn comparison(&self) -> Option<&Comparison> {
        self.comparison.as_ref()
    }

    /// The part of the picture that is rendered.
    #[must_use]
    pub fn region(&self) -> &RegionTool {
        &self.region
    }

    /// How the picture is looked at.
    #[must_use]
    pub fn zoom(&self) -> &Zoom {
        &self.zoom
    }

    /// What the mouse points at in the picture.
    #[must_use]
    pub fn inspected(&self) -> Option<&Inspected> {
        self.inspected.as_ref()
    }

    /// What the mouse points at in the preview.
    #[must_use]
    pub fn seen(&self) -> Option<&Surface> {
        self.seen.as_ref()
    }

    /// The renders of this session and their errors.
    #[must_use]
    pub fn error_plot(&self) -> &ErrorPlot {
        &self.error_plot
    }

    /// The report that is described, made or looked at.
    #[must_use]
    pub fn report(&self) -> &ReportWindow {
        &self.report
    }

    /// The banners and the last news.
    #[must_use]
    pub fn messages(&self) -> &Messages {
        &self.messages
    }

    /// Takes all banners away, as if somebody had read them.
    pub fn dismiss_messages(&mut self) {
        self.messages.clear();
    }

    /// What shows over the window.
    #[must_use]
    pub fn dialog(&self) -> Option<&Dialog> {
        self.dialog.as_ref()
    }

    /// What the central area shows.
    #[must_use]
    pub fn view(&self) -> View {
        self.view
    }

    /// Whether files are read, or the scene as it is has not been prepared yet but will be.
    #[must_use]
    pub fn is_settling(&self) -> bool {
        let is_unwanted = self.is_preparation_unwanted();
        let lacks_preparation = !self.is_prepared() && !is_unwanted;
        self.loading.is_some() || self.jobs.is_busy(Lane::Prepare) || lacks_preparation
    }

    /// How many jobs of that kind were started so far.
    #[must_use]
    pub fn jobs_started(&self, lane: Lane) -> u64 {
        self.jobs.started(lane)
    }

    /// Whether a render follows every change.
    #[must_use]
    pub fn is_live(&self) -> bool {
        self.is_live
    }

    /// Whether the processor itself draws the window.
    #[must_use]
    pub fn is_drawn_by_processor(&self) -> bool {
        self.preview.as_ref().is_some_and(PreviewImage::is_software)
    }

    /// Whether background work of this kind goes on.
    #[must_use]
    pub fn works_in(&self, lane: Lane) -> bool {
        self.jobs.is_busy(lane)
    }

    /// Threads that still work on renders and reports, cancelled ones included.
    #[must_use]
    pub fn render_threads(&self) -> usize {
        self.jobs.running_threads(Lane::Render) + self.jobs.running_threads(Lane::Report)
    }

    /// What the top bar shows, which is also what commands may be given.
    fn top_bar_state(&self) -> TopBarState<'_> {
        TopBarState {
            view: self.view,
            phase: if self.is_rendering() {
                Phase::Rendering
            } else if self.report.is_running() {
                Phase::Reporting
            } else if self.document.scene.objects.is_empty() {
                Phase::Empty
            } else {
                Phase::Ready
            },
            tool: self.viewport.tool,
            has_own_axes: self.viewport.orientation == Orientation::Own,
            has_bookmarks: !self.document.scene.bookmarks.is_empty(),
            is_live: self.is_live,
            can_cancel: self.what_to_stop().is_some(),
            can_pause: self.picture.as_ref().is_some_and(Picture::is_running),
            is_paused: self.is_paused(),
            can_continue: self.can_continue(),
            time: self.estimated_time(),
            is_estimating_time: self.is_estimating_time(),
            can_estimate_time: self.can_estimate_time(),
            is_valid: self.invalid.is_none(),
            is_drawing_region: self.region.is_drawing,
            has_region: self.region.is_chosen(),
            is_measuring: self.is_measuring_costs(),
            has_picture: self.shown_picture().is_some_and(Picture::is_shown),
            panel_open: self.panel_open,
            error_plot_open: self.error_plot.open,
            renders_open: self.renders.open,
            are_tiles_outlined: self.tile_outlines.are_shown,
            can_compare: self.can_compare(),
            is_picture_shown: self.picture_on_screen().is_some(),
            is_comparing: self.comparison.is_some(),
            has_renders: self.picture.is_some() || !self.renders.entries().is_empty(),
            modified: self.document.is_modified(),
            edit: self.edit_state(),
            recent: &self.keeping.recent,
        }
    }

    /// The world box of the objects, as last prepared.
    fn bounds(&self) -> DBounds {
        self.prepared
            .as_ref()
            .map_or(DBounds::EMPTY, |state| state.bounds)
    }

    /// Keeps the window's title what it should be; while rendering or making a report it says how far, for the task bar.
    fn update_title(&mut self, ctx: &egui::Context) {
        let dot = if self.document.is_modified() {
            " •"
        } else {
            ""
        };
        let running = self.picture.as_ref().filter(|picture| picture.is_running());
        let rendered = running.map(|picture| picture.progress.share());
        let run = self.report.run().filter(|_| self.report.is_running());
        let share = rendered.or_else(|| Some(run?.progress.how_far().0));
        let paused = if self.is_paused() { ", paused" } else { "" };
        let progress = share.map_or_else(String::new, |share| {
            format!("{} %{paused} – ", (share * 100.0).floor())
        });
        let title = format!("{progress}{}{dot} – RayMini", self.document.name());
        if title != self.title {
            ctx.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    /// Files dropped on the window are opened; an image becomes the background, unless it tells what was rendered.
    fn take_dropped_files(&mut self, ctx: &egui::Context) {
        let dropped = ctx.input(|input| input.raw.dropped_files.clone());
        let paths: Vec<PathBuf> = dropped.iter().map(|f| f.path().to_owned()).collect();
        match paths.as_slice() {
            [] => {}
            [image] if io::is_image_file(image) => self.take_dropped_image(image.clone()),
            _ => self.open(paths),
        }
    }

    /// Closing the window waits for unsaved work, what runs and unsaved pictures to be decided about.
    fn take_close_request(&mut self, ctx: &egui::Context) {
        let asked = ctx.input(|input| input.viewport().close_requested());
        if asked && !self.may_close && self.holds_up_closing() {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.ask_to_close();
        }
    }

    /// What the graphics driver complains about becomes a banner; the window goes on.
    fn take_gpu_faults(&mut self) {
        // Of a device that is lost nothing else is of interest.
        let preview = self.preview.iter();
        let preview = preview.filter(|preview| preview.loss().is_none());
        for fault in preview.flat_map(PreviewImage::take_faults) {
            self.messages
                .error("The graphics driver reports a fault", fault);
        }
    }
}

impl eframe::App for App {
    fn logic(&mut self, ctx: &egui::Context, _frame: &mut eframe::Frame) {
        if let Some(picture) = self.picture.as_ref().filter(|p| p.first_tile.is_some()) {
            picture.first_look.set_drawn();
        }
        self.take_news(ctx);
        self.take_gpu_faults();
        if let Some(picture) = self.picture.as_mut().filter(|p| p.is_running()) {
            picture.take_errors();
        }
        self.update_background_work();
        self.start_waiting_report();
    }

    fn on_exit(&mut self) {
        self.end_looks();
        self.end_keeping();
    }

    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        let ctx = ui.ctx().clone();
        self.take_dropped_files(&ctx);
        self.take_close_request(&ctx);

        let mut commands = if self.dialog.is_none() {
            self.take_tool_keys(&ctx);
            Command::pressed(&ctx)
        } else {
            Vec::new()
        };
        if ctx.input(|input| input.pointer.any_pressed()) {
            // What was typed before is a step of its own.
            self.document.record_edit(&self.selection);
        }
        let before = (self.shown_layer, self.channels);
        let selected = self.selection.clone();
        let rules = StopRules::of(&self.document.scene.render);
        let asked = self.window_ui(ui);
        self.note_asked_rules(rules);
        if self.selection != selected {
            self.messages.note_edit();
        }
        commands.extend(asked.commands);
        match asked.recent {
            Some(Recent::Open(path)) => self.open(vec![path]),
            Some(Recent::Forget) => self.forget_recent(),
            None => {}
        }
        if let Some(asked) = asked.render {
            self.carry_out_asked(&ctx, asked);
        }
        if let Some(what) = asked.stop {
            self.stop(what);
        }
        self.report_ui(&ctx);
        let display = self.document.scene.display;
        self.contributions.window_ui(&ctx, &display);
        self.dialogs_ui(&ctx);
        for command in commands {
            self.carry_out(&ctx, command);
        }

        self.selection = std::mem::take(&mut self.selection).within(&self.document.scene);
        let is_editing = self.gesture.goes_on(&ctx);
        if !is_editing && self.document.record_edit(&self.selection) {
            self.messages.note_edit();
        }
        // Half of a number that is typed may be less than what is there.
        if !is_editing {
            self.take_over_rules();
        }
        let display = self.document.scene.display;
        if self
            .shown_picture()
            .is_some_and(|picture| picture.scene.display != display)
        {
            self.show_picture_with(display);
        }
        if (self.shown_layer, self.channels) != before {
            self.show_picture_as_asked();
        }
        self.restart_edited_render();
        self.share_processor(&ctx);
        self.update_background_work();
        self.start_waiting_report();
        self.update_thumbnails();
        self.update_balls();
        self.update_contributions(&ctx);
        self.update_comparison();
        self.update_histogram();
        self.watch_files();
        self.reload_next();
        self.keep_work(&ctx);
        self.keep_looks(&ctx);
        self.ask_about_lost_work();
        self.update_title(&ctx);
    }
}
