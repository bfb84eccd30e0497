//! Where everything is drawn.

use std::ops::RangeInclusive;
use std::time::Duration;

use egui::{
    CentralPanel, Color32, CornerRadius, FontId, Frame, Margin, Panel, Rect, RichText, Ui,
    UiBuilder, Vec2,
};

use super::App;
use super::tools::{focus_aid, moves_since};
use crate::gui::commands::{Command, Stoppable};
use crate::gui::focus::FocusAid;
use crate::gui::keeping::Fold;
use crate::gui::look::Channels;
use crate::gui::panels::{self, PanelState, StructureInUse};
use crate::gui::picture::Picture;
use crate::gui::preview::choice::Omission;
use crate::gui::renders::{self, StripState};
use crate::gui::status_bar::{self, Activity, Status};
use crate::gui::theme;
use crate::gui::tool;
use crate::gui::top_bar::{self, Recent};
use crate::gui::viewport::{self, ViewportScene};
use crate::gui::zoom::Place;
use crate::gui::{compare, error_colors, error_plot, false_colors, inspector, steps_legend};
use crate::io;
use crate::render::Layer;
use crate::scene::Mode;

/// Time between two frames while a report is made and the user does nothing: rarely, as each frame takes time from what is measured.
const REPORT_REFRESH: Duration = Duration::from_millis(500);
/// The same while costs are measured: drawing counts among the processor time of what is measured.
const MEASURING_REFRESH: Duration = Duration::from_secs(1);

/// How wide the side panel may be, in points.
const PANEL_WIDTHS: RangeInclusive<f32> = theme::PANEL_WIDTH - 40.0..=560.0;

/// What was asked for in the window.
#[derive(Clone, Debug)]
pub(super) struct WindowAsked {
    /// By name.
    pub commands: Vec<Command>,
    /// About the files opened last.
    pub recent: Option<Recent>,
    /// About the renders of this session.
    pub render: Option<renders::Asked>,
    /// What is to be stopped.
    pub stop: Option<Stoppable>,
}

impl App {
    /// Draws the window; returns what was asked for.
    pub(super) fn window_ui(&mut self, ui: &mut Ui) -> WindowAsked {
        let fill = ui.visuals().panel_fill;
        let bar = |x, y| {
            Frame::new()
                .fill(fill)
                .inner_margin(Margin::symmetric(x, y))
        };
        let state = self.top_bar_state();
        let name = self.document.name();
        let mut bar_asked = Panel::top("top bar")
            .frame(bar(10, 6))
            .show(ui, |ui| top_bar::top_bar_ui(ui, state, name))
            .inner;
        let status_asked = Panel::bottom("status bar")
            .frame(bar(12, 1))
            .show(ui, |ui| self.status_ui(ui))
            .inner;
        bar_asked.commands.extend(status_asked.command);
        let mut open = self.panel_open;
        let panel = Panel::right("side panel")
            .frame(bar(0, 0))
            .default_size(panel_width(&self.looks.layout.panel))
            .size_range(PANEL_WIDTHS)
            .show_collapsible(ui, &mut open, |ui| {
                self.panels_ui(ui, &mut bar_asked.commands);
            });
        self.panel_open = open;
        let width = panel.map(|panel| panel.response.rect.width());
        let width = width.filter(|width| PANEL_WIDTHS.contains(width));
        self.looks.layout.panel.note(open, width);
        let mut open = self.error_plot.open;
        let plot = Panel::bottom("error plot")
            .frame(bar(12, 8))
            .default_size(self.looks.layout.error_plot.size_or(error_plot::HEIGHT))
            .size_range(error_plot::LEAST_HEIGHT..=480.0)
            .show_collapsible(ui, &mut open, |ui| {
                self.error_plot.plot_ui(ui, self.picture.as_ref());
            });
        self.error_plot.open = open;
        let height = plot.map(|plot| plot.response.rect.height());
        self.looks.layout.error_plot.note(open, height);
        let render = self.renders_ui(ui, bar(12, 8));
        if !self.document.scene.objects.is_empty() {
            Panel::bottom("pixel")
                .frame(bar(12, 1))
                .show(ui, |ui| self.inspector_ui(ui));
        }
        CentralPanel::default()
            .frame(Frame::new())
            .show(ui, |ui| self.central_ui(ui));
        WindowAsked {
            commands: bar_asked.commands,
            recent: bar_asked.recent,
            render,
            stop: status_asked.stop,
        }
    }

    /// Draws the strip of renders; returns what was asked for there.
    fn renders_ui(&mut self, ui: &mut Ui, frame: Frame) -> Option<renders::Asked> {
        let mut open = self.renders.open;
        let shown = self.shown_picture();
        let state = StripState {
            present: self.picture.as_ref(),
            shown: self.shown_number(),
            can_save: shown.is_some_and(Picture::is_shown),
        };
        let response = Panel::bottom("renders")
            .frame(frame)
            .default_size(self.looks.layout.renders.size_or(renders::HEIGHT))
            .size_range(renders::LEAST_HEIGHT..=320.0)
            .show_collapsible(ui, &mut open, |ui| self.renders.strip_ui(ui, &state));
        self.renders.open = open;
        let height = response.as_ref();
        let height = height.map(|strip| strip.response.rect.height());
        self.looks.layout.renders.note(open, height);
        response.and_then(|response| response.inner)
    }

    /// Draws what is known of what the mouse points at.
    fn inspector_ui(&self, ui: &mut Ui) {
        if self.picture_on_screen().is_some() {
            let scale = self.zoom.scale();
            let is_live = self.is_live_view();
            inspector::inspector_ui(ui, self.inspected.as_ref(), scale, is_live);
        } else {
            inspector::preview_inspector_ui(ui, self.seen.as_ref());
        }
    }

    /// Draws the status bar; returns what was asked for there.
    fn status_ui(&self, ui: &mut Ui) -> status_bar::Asked {
        let activity = if let Some(loading) = &self.loading {
            Activity::Loading {
                what: &loading.what,
                share: loading.progress.fraction(),
            }
        } else if let Some(run) = self.report.run().filter(|_| self.report.is_running()) {
            Activity::Reporting(run)
        } else if self.awaits_preparation() {
            Activity::Preparing {
                share: self.build_progress.fraction(),
            }
        } else if let Some(picture) = self.picture_on_screen().or(self.picture.as_ref()) {
            Activity::Picture {
                picture,
                is_of_other: picture.file != self.document.file_number(),
                outdated: self.is_outdated(picture),
            }
        } else {
            Activity::Idle
        };
        let is_preparing = matches!(activity, Activity::Preparing { .. });
        let is_rendering = self.is_rendering() && !self.is_paused();
        if self.loading.is_some() || is_preparing || is_rendering {
            // Times and shares move also while nothing else happens.
            ui.ctx().request_repaint_after(self.refresh_interval());
        }
        if self.is_measuring_costs() {
            ui.ctx().request_repaint_after(MEASURING_REFRESH);
        }
        if self.report.is_running() {
            ui.ctx().request_repaint_after(REPORT_REFRESH);
        }
        let scene = &self.document.scene;
        let (news, left) = self.messages.fresh_news();
        if let Some(left) = left {
            ui.ctx().request_repaint_after(left);
        }
        let told = match &activity {
            Activity::Picture { picture, .. } => Some(picture.number),
            _ => None,
        };
        let present = self.picture.as_ref();
        let is_present_told = present.is_some_and(|picture| Some(picture.number) == told);
        let running = present.filter(|picture| picture.is_running() && !is_present_told);
        let status = Status {
            activity,
            measuring: self.costs.share_measured(),
            running,
            can_continue: is_present_told && self.can_continue(),
            saving: self.pictures_being_saved(),
            esc_stops: self.what_to_stop().filter(|_| !self.has_window_in_front()),
            news,
            scene: (!scene.objects.is_empty()).then_some(scene),
        };
        status_bar::status_bar_ui(ui, &status)
    }

    fn panels_ui(&mut self, ui: &mut Ui, commands: &mut Vec<Command>) {
        // Nothing in the panel makes it wider: what has no room is cut off.
        let place = ui.available_rect_before_wrap();
        ui.advance_cursor_after_rect(place);
        let mut ui = ui.new_child(UiBuilder::new().max_rect(place));
        egui::ScrollArea::vertical()
            .auto_shrink(false)
            .show(&mut ui, |ui| {
                Frame::new()
                    .inner_margin(Margin {
                        left: 12,
                        right: 14,
                        top: 6,
                        bottom: 12,
                    })
                    .show(ui, |ui| {
                        let prepared = self.prepared.as_ref().and_then(|s| s.prepared.as_ref());
                        let structure = prepared.map(|prepared| {
                            let accelerator = prepared.geometry().accelerator();
                            StructureInUse {
                                name: accelerator.name(),
                                bytes: accelerator.bytes(),
                            }
                        });
                        let can_measure_costs = self.top_bar_state().allows(Command::MeasureCosts);
                        let shown = match self.shown_render {
                            Some(number) => self.renders.picture(number),
                            None => self.picture.as_ref(),
                        };
                        let layers = shown.map_or(&[][..], |p| p.buffer.layers());
                        let (mut asked_pixel, mut sought) = (None, None);
                        let mut state = PanelState {
                            scene: &mut self.document.scene,
                            selection: &mut self.selection,
                            threads: &mut self.threads,
                            region: &mut self.region,
                            shown_layer: &mut self.shown_layer,
                            channels: &mut self.channels,
                            layers,
                            histogram: self.brightness.histogram.as_ref(),
                            asked_pixel: &mut asked_pixel,
                            structure,
                            costs: &self.costs,
                            balls: &mut self.balls,
                            contributions: &mut self.contributions,
                            boxes: &mut self.boxes,
                            can_measure_costs,
                            sought: &mut sought,
                            commands,
                        };
                        panels::panels_ui(ui, &mut state);
                        if let Some(pixel) = asked_pixel {
                            self.zoom.show_pixel(pixel);
                        }
                        if let Some(path) = sought {
                            self.seek(&path);
                        }
                    });
            });
    }

    fn central_ui(&mut self, ui: &mut Ui) {
        let ground = ui.painter().add(egui::Shape::Noop);
        self.messages.banners_ui(ui);
        if let Some(problem) = self.problem() {
            problem_ui(ui, problem);
        }
        self.reload_question_ui(ui);
        self.comparison_bar_ui(ui);
        // Between the bars, and between them and the rest, there would be lines of nothing.
        let mut area = ui.available_rect_before_wrap();
        if area.top() > ui.max_rect().top() {
            area.min.y -= ui.spacing().item_spacing.y;
        }
        let bars = area.with_min_y(ui.max_rect().top()).with_max_y(area.min.y);
        let fill = ui.visuals().panel_fill;
        ui.painter().set(
            ground,
            egui::Shape::rect_filled(bars, CornerRadius::ZERO, fill),
        );
        self.follow_edits(ui.ctx());
        let showing_picture = self.picture_on_screen().is_some();
        let scene = self.picture_on_screen().map(|picture| &picture.scene);
        let settings = &scene.unwrap_or(&self.document.scene).render;
        let size = [settings.width, settings.height];
        let pixels_per_point = ui.ctx().pixels_per_point();
        let mut frame = viewport::frame_in(area, settings, pixels_per_point);
        if showing_picture {
            frame = self.zoom.frame_in(Place {
                area,
                fit: frame,
                size,
                pixels_per_point,
            });
        }
        if self.document.scene.objects.is_empty() {
            self.show_tiles(ui.ctx());
            self.viewport.release();
            viewport::backdrop_ui(ui, area, frame, false);
            self.empty_ui(ui, area);
            hovered_files_ui(ui, area);
            return;
        }
        // The camera moves before what it sees is drawn.
        if self.region.is_drawing {
            self.viewport.release();
        } else {
            self.interact_ui(ui, frame, area);
            self.follow_edits(ui.ctx());
        }
        self.show_tiles(ui.ctx());
        let showing_picture = self.picture_on_screen().is_some();
        viewport::backdrop_ui(ui, area, frame, self.is_preview_hidden());
        // Behind an enlarged picture it would be larger than a texture may be, and behind a whole one nobody sees it.
        if !showing_picture || !self.zoom.is_enlarged() && !self.is_preview_hidden() {
            self.preview_ui(ui, frame, showing_picture);
        }
        if showing_picture {
            self.picture_ui(ui, frame, area);
        }
        if self.region.is_drawing {
            self.region.draw_ui(ui, frame, area, size);
        }
        self.overlays_ui(ui, frame, area);
        self.region.outline_ui(ui, frame, area, size);
        hovered_files_ui(ui, area);
    }

    /// Says where the camera is moved, while somebody drags over a whole picture, where nothing moves.
    fn drag_hint_ui(&self, ui: &Ui, visible: Rect) {
        if self.viewport.drags_picture() && !self.zoom.is_enlarged() {
            let keys = [Command::ShowPreview, Command::ToggleLive];
            let [preview, live] = keys.map(|command| command.shortcut_text(ui.ctx()));
            tool::hint_ui(
                ui,
                visible,
                &format!(
                    "The camera moves in the preview ({preview}), or here with Live on ({live})"
                ),
            );
        }
    }

    /// Draws what lies over preview and picture, and says what is in them.
    fn overlays_ui(&mut self, ui: &mut Ui, frame: Rect, area: Rect) {
        self.trace_asked_ray();
        self.update_boxes();
        if self.is_camera_view() {
            let scene = &self.document.scene;
            viewport::markers_ui(ui, frame, scene, &self.selection);
            if let Some(corners) = self.selected_corners() {
                viewport::box_ui(ui, frame, scene, &corners);
            }
        }
        self.tools_ui(ui, frame, area);
        self.drag_hint_ui(ui, frame.intersect(area));
        if self.picture_on_screen().is_some() {
            let name = self.shown_name();
            if let Some(comparison) = &mut self.comparison {
                comparison.show_ui(ui, frame, frame.intersect(area), &name);
            }
        }
        let picture = self.picture_on_screen();
        let Some(picture) = picture else { return };
        let (seen, display) = (frame.intersect(area), &picture.scene.display);
        if let Some(scale) = picture.buffer.shown_error_scale() {
            error_colors::legend_ui(ui, seen, scale);
        } else if self.channels == Channels::FalseColors {
            let is_radiance = picture.scene.render.mode.shows_light()
                && picture.buffer.shown_layer().is_none_or(Layer::is_part);
            false_colors::legend_ui(ui, seen, display, is_radiance);
        } else if picture.scene.render.mode == Mode::Steps {
            steps_legend::legend_ui(ui, seen, display);
        }
    }

    /// Draws the bar over two compared pictures, where they are looked at.
    fn comparison_bar_ui(&mut self, ui: &mut Ui) {
        let name = self.shown_name();
        let is_shown = self.picture_on_screen().is_some();
        let comparison = self.comparison.as_mut().filter(|_| is_shown);
        match comparison.and_then(|comparison| comparison.bar_ui(ui, &name)) {
            Some(compare::Asked::Close) => self.stop_comparing(),
            None => {}
        }
    }

    /// Whether the picture on the screen leaves nothing of the preview to be seen.
    fn is_preview_hidden(&self) -> bool {
        let picture = self.picture_on_screen();
        picture.is_some_and(|picture| picture.is_covered() && picture.buffer.part().is_whole())
    }

    /// Draws the preview; under a picture that is not whole, that picture's own view, dimmed.
    fn preview_ui(&mut self, ui: &mut Ui, frame: Rect, under_picture: bool) {
        let Some(preview) = &mut self.preview else {
            no_gpu_ui(ui, frame);
            return;
        };
        let Some(state) = &self.prepared else { return };
        let Some(triangles) = &state.placed.triangles else {
            return;
        };
        let sky = state.placed.sky.as_ref();
        let shown = match self.shown_render {
            Some(number) => self.renders.picture(number),
            None => self.picture.as_ref(),
        };
        let picture = shown.filter(|_| under_picture);
        let mut scene = picture.map_or(&self.document.scene, |picture| &picture.scene);
        // While an edit that adds or removes objects is prepared, the triangles are still those of the scene before.
        let stale;
        if scene.objects.len() != state.scene.objects.len() {
            stale = crate::scene::Scene {
                objects: state.scene.objects.clone(),
                ..scene.clone()
            };
            scene = &stale;
        }
        if under_picture {
            preview.set_aids(Vec::new(), FocusAid::Off);
        } else {
            let focus = focus_aid(self.viewport.tool, &self.selection, scene);
            preview.set_aids(moves_since(&state.scene, scene), focus);
        }
        let scale = ui.ctx().pixels_per_point();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "sides of a rectangle on the screen"
        )]
        let size = [frame.width(), frame.height()].map(|side| (side * scale).round() as u32);
        let tint = if under_picture {
            Color32::from_gray(70)
        } else {
            Color32::WHITE
        };
        if let Some(texture) = preview.show(scene, triangles, sky, size) {
            image_ui(ui.painter(), texture, frame, tint);
        }
        if let Some(rest) = preview.rests_in() {
            ui.ctx().request_repaint_after(rest);
        }
        let omission = preview.omission();
        if omission.is_any() && !under_picture {
            omission_ui(ui, frame, omission);
        }
    }

    /// Draws what of the picture lies in `area`.
    fn picture_ui(&self, ui: &Ui, frame: Rect, area: Rect) {
        if let Some(picture) = self.shown_picture() {
            let painter = ui.painter().with_clip_rect(area);
            let place = picture.buffer.part().rect_in(frame);
            picture.paint(&painter, place);
            self.tile_outlines.outlines_ui(ui, frame, area, picture);
        }
    }

    /// Lets the mouse work on the scene. Moving the camera brings the preview back, or the picture that follows it.
    fn interact_ui(&mut self, ui: &Ui, frame: Rect, area: Rect) {
        let is_picture = self.picture_on_screen().is_some();
        let is_camera_view = self.is_camera_view();
        let picture = self.picture_on_screen().filter(|_| !is_camera_view);
        let picture = picture.map(|picture| {
            let settings = &picture.scene.render;
            let size = [settings.width, settings.height];
            (picture.scene.camera, size)
        });
        let bounds = self.bounds();
        let center = self.selected_center();
        let is_quick = self.is_prepared();
        let geometry = self
            .prepared
            .as_ref()
            .map(|state| state.placed.geometry.as_ref());
        let mut view = ViewportScene {
            scene: &mut self.document.scene,
            selection: &mut self.selection,
            geometry,
            is_quick,
            bounds,
            center,
            picture,
        };
        let zoom = (!is_camera_view).then_some(&mut self.zoom);
        let viewport = &mut self.viewport;
        if viewport.interact_ui(ui, frame, area, zoom, &mut view) {
            self.show_camera_view();
        }
        if is_picture {
            self.inspect_ui(ui, frame.intersect(area));
        } else {
            self.look_ui(ui, frame.intersect(area), frame);
        }
    }

    /// What to do where there is nothing to see.
    fn empty_ui(&mut self, ui: &mut Ui, area: Rect) {
        let text = if let Some(loading) = &self.loading {
            format!("Loading {}…", loading.what)
        } else {
            let keys = Command::Open.shortcut_text(ui.ctx());
            format!("Drop a mesh or a scene here, or press {keys}")
        };
        ui.put(
            area,
            egui::Label::new(RichText::new(text).size(16.0).weak()),
        );
    }
}

/// The width of the side panel that was remembered, where it can be right.
fn panel_width(panel: &Fold) -> f32 {
    let width = panel.size_or(theme::PANEL_WIDTH);
    if PANEL_WIDTHS.contains(&width) {
        width
    } else {
        theme::PANEL_WIDTH
    }
}

fn image_ui(painter: &egui::Painter, texture: egui::TextureId, frame: Rect, tint: Color32) {
    let whole = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
    painter.image(texture, frame, whole, tint);
}

/// Says what the preview leaves out, in the lower left corner of `frame`.
fn omission_ui(ui: &mut Ui, frame: Rect, omission: Omission) {
    let details = (omission.pixels > 0.0)
        .then(|| format!(": details under {:.1} px left out", omission.pixels));
    let copies = (omission.copies > 1).then(|| format!(", 1 of {} copies drawn", omission.copies));
    let [details, copies] = [details, copies].map(Option::unwrap_or_default);
    let text = format!("Preview simplified{details}{copies}");
    let corner = frame.left_bottom() + Vec2::new(10.0, -32.0);
    let galley = ui.painter().layout_no_wrap(
        text.clone(),
        FontId::proportional(12.0),
        Color32::from_gray(0xe8),
    );
    let area = Rect::from_min_size(corner, galley.size() + Vec2::new(16.0, 8.0));
    ui.painter()
        .rect_filled(area, 6.0, Color32::from_black_alpha(170));
    let place = area.min + Vec2::new(8.0, 4.0);
    ui.painter().galley(place, galley, Color32::WHITE);
    let response = ui.interact(area, ui.scope_id().with("simplified"), egui::Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, &text));
    response.on_hover_text(
        "There are more triangles in sight than this graphics adapter draws fluently, so the preview shows fewer: fewest while the view moves, \
         more at rest. The picture is always rendered from all of them",
    );
}

/// Says what happens to files that hang over the window.
fn hovered_files_ui(ui: &Ui, area: Rect) {
    let hovered = ui.input(|input| input.raw.hovered_files.clone());
    let text = match hovered.as_slice() {
        [] => return,
        [one] if one.path.as_deref().is_some_and(io::is_image_file) => {
            // Whether a file tells a scene is known when it is read.
            if one.path.as_deref().is_some_and(io::is_render_file) {
                "Drop to make it the background, or to open it if RayMini saved it"
            } else {
                "Drop to make it the background"
            }
        }
        [_] => "Drop to open",
        _ => "Drop to open together",
    };
    let painter = ui.painter();
    painter.rect_filled(area, 0.0, Color32::from_black_alpha(150));
    let inside = area.shrink(16.0);
    let stroke = egui::Stroke::new(2.0, theme::ACCENT);
    painter.rect_stroke(inside, 10.0, stroke, egui::StrokeKind::Inside);
    painter.text(
        area.center(),
        egui::Align2::CENTER_CENTER,
        text,
        FontId::proportional(20.0),
        Color32::WHITE,
    );
}

/// Why the scene as it is cannot be rendered; it goes when the reason does.
fn problem_ui(ui: &mut Ui, problem: &str) {
    let color = ui.visuals().warn_fg_color;
    Frame::new()
        .fill(ui.visuals().panel_fill.lerp_to_gamma(color, 0.16))
        .inner_margin(Margin::symmetric(12, 8))
        .show(ui, |ui| {
            ui.set_width(ui.available_width());
            ui.label(
                RichText::new("This scene cannot be rendered as it is")
                    .strong()
                    .color(color),
            );
            ui.label(problem);
        });
}

/// Where the preview would be.
fn no_gpu_ui(ui: &Ui, frame: Rect) {
    let advice = if cfg!(target_os = "linux") {
        "On Debian the package mesa-vulkan-drivers brings one that works in software.\n"
    } else {
        ""
    };
    let text = format!(
        "No preview: there is no GPU adapter.\n{advice}Rendering works without: press Render."
    );
    ui.painter().text(
        frame.center(),
        egui::Align2::CENTER_CENTER,
        text,
        FontId::proportional(15.0),
        ui.visuals().weak_text_color(),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_width_that_the_panel_cannot_have_is_not_remembered() {
        let width = |size| {
            let is_open = true;
            panel_width(&Fold { is_open, size })
        };
        assert_eq!(width(Some(400.0)), 400.0);
        for wrong in [None, Some(1250.0), Some(3.0), Some(-1.0), Some(f32::NAN)] {
            assert_eq!(width(wrong), theme::PANEL_WIDTH, "{wrong:?}");
        }
    }
}
