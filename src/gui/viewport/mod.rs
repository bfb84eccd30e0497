//! The central area: the picture's frame, the mouse that moves camera, lights and handles in it, and the markers of lights.
//!
//! The frame has the ratio of the picture and lies on whole pixels of the screen. Positions in it are given in points from
//! its top left corner.
//!
//! - `markers`: those of lights

mod markers;

use egui::{CornerRadius, PointerButton, Pos2, Rect, Response, Sense, Stroke, Ui, Vec2};

use super::gizmo::motion::Placed;
use super::gizmo::shape::{Shape, Viewed, handle_at};
use super::gizmo::{Axes, Axis, Handle, HandleDrag, Orientation, Part};
use super::orbit::{self, DistanceLimits, PictureSize};
use super::pick::{self, Picked};
use super::selection::Selection;
use super::theme;
use super::tool::{self, Tool};
use super::zoom::Zoom;
use crate::math::{DBounds, DVec2, DVec3};
use crate::render::PreparedGeometry;
use crate::scene::{Camera, Light, RenderSettings, Scene};
use markers::{Mark, marker_at, move_light};
pub use markers::{box_ui, markers_ui};

/// Room around the frame, in points.
const MARGIN: f32 = 14.0;
/// Half turns for dragging over the full height of the frame.
const HALF_TURNS_PER_HEIGHT: f64 = 1.0;
/// How much nearer one point of scrolling comes.
const ZOOM_PER_POINT: f64 = 0.0025;
/// What a drag does, decided when it starts.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
enum Drag {
    #[default]
    None,
    Orbit,
    /// The depth of the point that follows the mouse.
    Pan {
        depth: f64,
    },
    /// A light, or what it is turned towards, kept at its depth; the light as it was.
    Light {
        mark: Mark,
        depth: f64,
        before: Light,
    },
    /// The handle in [`Viewport::held`].
    Handle,
    /// The picture that is looked at, where it is enlarged. Else nothing moves: a slip is no edit of the scene.
    Picture,
}

/// What the central area remembers from frame to frame.
#[derive(Clone, Debug, Default)]
pub struct Viewport {
    /// What the mouse does beside looking around.
    pub tool: Tool,
    /// Which axes its handles go along.
    pub orientation: Orientation,
    drag: Drag,
    /// The handle that is held.
    held: Option<HandleDrag>,
    /// The light whose target was pointed at last.
    aimed: Option<usize>,
    /// How far along the view axis what is under the mouse is, for the focus.
    depth: Option<f64>,
    /// Where a ray was asked for, as shares of the frame's width and height.
    asked_ray: Option<DVec2>,
}

/// What the central area works on.
#[derive(Debug)]
pub struct ViewportScene<'a> {
    /// The scene being edited.
    pub scene: &'a mut Scene,
    /// The selected part.
    pub selection: &'a mut Selection,
    /// For picking; `None` until the scene is prepared.
    pub geometry: Option<&'a PreparedGeometry>,
    /// Whether `geometry` has its tree. Before, picking looks at every triangle, which is too slow for every frame.
    pub is_quick: bool,
    /// The world box of the objects.
    pub bounds: DBounds,
    /// What the selected object turns about, in its own coordinates.
    pub center: DVec3,
    /// The camera of the picture that is looked at in place of the preview, and its size in pixels.
    pub picture: Option<(Camera, [u32; 2])>,
}

/// The largest rectangle with the picture's ratio inside `area` and beside the bar of tools, on whole pixels of the screen.
#[must_use]
pub fn frame_in(area: Rect, settings: &RenderSettings, pixels_per_point: f32) -> Rect {
    let inside = area.shrink(MARGIN);
    let inside = inside.with_min_x(area.left() + tool::BAR_WIDTH);
    let ratio = settings.width.max(1) as f32 / settings.height.max(1) as f32;
    let available = inside.size().max(Vec2::splat(1.0));
    let width = available.x.min(available.y * ratio);
    let size = Vec2::new(width, width / ratio);
    let snap = |points: f32| (points * pixels_per_point).round() / pixels_per_point;
    let min = area.center() - size / 2.0;
    Rect::from_min_size(
        Pos2::new(snap(min.x.max(inside.left())), snap(min.y)),
        Vec2::new(snap(size.x), snap(size.y)).max(Vec2::splat(1.0 / pixels_per_point)),
    )
}

/// Draws the ground around the frame and an edge; below the frame too, unless something `covers` all of that.
pub fn backdrop_ui(ui: &Ui, area: Rect, frame: Rect, covers: bool) {
    let visuals = ui.visuals();
    let painter = ui.painter().with_clip_rect(area);
    let ground = theme::backdrop(visuals);
    let hidden = frame.intersect(area);
    if covers && hidden.is_positive() {
        // Where the processor draws, a pixel that is drawn over costs as much as one that is seen.
        let Rect { min, max } = hidden;
        for visible in [
            Rect::from_min_max(area.min, Pos2::new(area.max.x, min.y)),
            Rect::from_min_max(Pos2::new(area.min.x, max.y), area.max),
            Rect::from_min_max(Pos2::new(area.min.x, min.y), Pos2::new(min.x, max.y)),
            Rect::from_min_max(Pos2::new(max.x, min.y), Pos2::new(area.max.x, max.y)),
        ] {
            painter.rect_filled(visible, CornerRadius::ZERO, ground);
        }
    } else {
        painter.rect_filled(area, CornerRadius::ZERO, ground);
    }
    painter.rect_stroke(
        frame,
        CornerRadius::ZERO,
        Stroke::new(1.0, visuals.widgets.noninteractive.bg_stroke.color),
        egui::StrokeKind::Outside,
    );
}

impl Viewport {
    /// Lets the mouse move camera and lights and select things. Returns whether the camera moved. `visible`: what of the frame is
    /// seen; `zoom`: that of the picture, where one is looked at in place of the preview: the wheel and every drag are for it.
    pub fn interact_ui(
        &mut self,
        ui: &Ui,
        frame: Rect,
        visible: Rect,
        mut zoom: Option<&mut Zoom>,
        view: &mut ViewportScene<'_>,
    ) -> bool {
        let response = ui
            .interact(
                frame.intersect(visible),
                ui.scope_id().with("viewport"),
                Sense::click_and_drag(),
            )
            .accessible_name("Viewport");
        let before = view.scene.camera;
        self.drag_ui(ui, &response, frame, zoom.as_deref_mut(), view);
        self.depth = None;
        match self.tool {
            Tool::Focus => self.focus_ui(&response, frame, view),
            Tool::Rays if response.clicked() => {
                let place = response.interact_pointer_pos();
                let size = picture_size(frame);
                let size = DVec2::new(size.width, size.height);
                self.asked_ray = place.map(|place| in_frame(frame, place) / size);
            }
            Tool::Rays => {}
            _ => self.click(&response, frame, view),
        }
        match zoom {
            Some(zoom) => zoom.scroll_ui(ui, &response),
            // What is in the hand is seen from where it was taken.
            None if self.is_handle_held() => {}
            None => scroll(ui, &response, frame, view),
        }
        orbit::is_moved(&before, &view.scene.camera)
    }

    /// Takes note of how far what is under the mouse is; a click makes that sharp.
    fn focus_ui(&mut self, response: &Response, frame: Rect, view: &mut ViewportScene<'_>) {
        let place = response.hover_pos().or(response.interact_pointer_pos());
        let size = picture_size(frame);
        let place = place.filter(|_| view.is_quick || response.clicked());
        let seen = place.and_then(|place| seen_at(view, size, in_frame(frame, place)));
        self.depth = seen.and_then(|seen| orbit::depth_of(&view.scene.camera, seen.point));
        if response.clicked()
            && let Some(depth) = self.depth
        {
            view.scene.camera.focus_distance = Some(depth);
        }
    }

    /// How far along the view axis what is under the mouse is, while the focus is chosen.
    #[must_use]
    pub fn depth_under_mouse(&self) -> Option<f64> {
        self.depth
    }

    /// Where the rays of a pixel were asked for since the last call, as shares of the frame's width and height.
    pub fn take_asked_ray(&mut self) -> Option<DVec2> {
        self.asked_ray.take()
    }

    /// Whether somebody drags over a picture that is looked at.
    #[must_use]
    pub fn drags_picture(&self) -> bool {
        self.drag == Drag::Picture
    }

    /// Whether a handle is held.
    #[must_use]
    pub fn is_handle_held(&self) -> bool {
        self.held.is_some()
    }

    /// What the handle that is held has done so far.
    #[must_use]
    pub fn handle_in_words(&self) -> Option<String> {
        self.held.as_ref().map(HandleDrag::in_words)
    }

    /// Lets go of the handle or the marker that is held, and puts what it moved back.
    pub fn put_back(&mut self, scene: &mut Scene) {
        if let Some(held) = self.held.take() {
            held.cancel(scene);
        }
        if let Drag::Light { mark, before, .. } = self.drag
            && let Some(light) = scene.lights.get_mut(mark.light)
        {
            *light = before;
        }
        self.drag = Drag::None;
    }

    /// Forgets what was pointed at last.
    pub fn look_away(&mut self) {
        self.aimed = None;
    }

    /// Whether an object or a light, or what that is turned towards, is held. It is known by its place in the scene, so nothing else may
    /// change what is there.
    #[must_use]
    pub fn is_part_held(&self) -> bool {
        self.is_handle_held() || matches!(self.drag, Drag::Light { .. })
    }

    /// Lets go of whatever is held and leaves it where it is; the mouse moves nothing until it is pressed again.
    pub fn release(&mut self) {
        self.held = None;
        self.drag = Drag::None;
    }

    /// Lets the handle that is held go on along or about `axis` alone.
    pub fn constrain_handle(&mut self, axis: Axis) {
        if let Some(held) = &mut self.held {
            held.constrain(axis);
        }
    }

    /// What handles work on, where the tool has some for it.
    #[must_use]
    pub fn handled_part(&self, scene: &Scene, selection: &Selection) -> Option<Part> {
        let part = Part::of(selection, self.aimed)?;
        part.allows(self.tool, scene).then_some(part)
    }

    /// The handles on the screen, and the part that they work on.
    fn handles(
        &self,
        scene: &Scene,
        selection: &Selection,
        center: DVec3,
        size: PictureSize,
    ) -> Option<(Placed, Vec<Shape>)> {
        let part = self.handled_part(scene, selection)?;
        let placed = Placed::of(scene, part, center)?;
        let camera = &scene.camera;
        let pivot = placed.pivot;
        let viewed = Viewed {
            camera,
            size,
            pivot,
            axes: self.axes_of(&placed),
        };
        Some((placed, viewed.shapes(self.tool)))
    }

    /// Takes hold of the handle at `start`, where there is one.
    fn hold_handle(
        &self,
        frame: Rect,
        start: Pos2,
        view: &ViewportScene<'_>,
    ) -> Option<HandleDrag> {
        let size = picture_size(frame);
        let start = in_frame(frame, start);
        let (placed, shapes) = self.handles(view.scene, view.selection, view.center, size)?;
        let handle = handle_at(&shapes, start)?;
        let handle = (handle, self.axes_of(&placed));
        HandleDrag::new(placed, self.tool, handle, (&view.scene.camera, size), start)
    }

    /// The axes that handles of `placed` go along; those of a drag stay as they were when it began.
    fn axes_of(&self, placed: &Placed) -> Axes {
        let held = self.held.as_ref().map(HandleDrag::axes);
        held.unwrap_or_else(|| Axes::of(placed, self.orientation))
    }

    /// Draws the handles of the tool at the selected part. `pointer`: the mouse, where it is over the preview.
    pub fn handles_ui(
        &self,
        ui: &Ui,
        frame: Rect,
        scene: &Scene,
        (selection, center): (&Selection, DVec3),
        pointer: Option<Pos2>,
    ) {
        let size = picture_size(frame);
        let Some((_, shapes)) = self.handles(scene, selection, center, size) else {
            return;
        };
        let painter = ui.painter().with_clip_rect(frame);
        let held = self.held.as_ref().map(HandleDrag::handle);
        let pointed = pointer.and_then(|place| handle_at(&shapes, in_frame(frame, place)));
        let bright = held.or(pointed);
        let is_shown = |shape: &&Shape| held.is_none_or(|held| held == shape.handle);
        for shape in shapes.iter().filter(is_shown) {
            shape.paint(&painter, frame, bright == Some(shape.handle));
        }
        // While an arrow is held that is not drawn, as it was chosen by a key, its line says where it goes.
        if let Some(Handle::Along(axis)) = held
            && self.tool == Tool::Move
        {
            self.axis_ui(&painter, frame, scene, center, (selection, axis));
        }
    }

    /// Draws the line that a held part moves along.
    fn axis_ui(
        &self,
        painter: &egui::Painter,
        frame: Rect,
        scene: &Scene,
        center: DVec3,
        (selection, axis): (&Selection, Axis),
    ) {
        const LENGTHS: f64 = 3.0;
        let part = self.handled_part(scene, selection);
        let Some(placed) = part.and_then(|part| Placed::of(scene, part, center)) else {
            return;
        };
        let viewed = Viewed {
            camera: &scene.camera,
            size: picture_size(frame),
            pivot: placed.pivot,
            axes: self.axes_of(&placed),
        };
        let Some(length) = viewed.length() else {
            return;
        };
        let reach = viewed.axes.direction(axis) * (length * LENGTHS);
        let ends = [placed.pivot - reach, placed.pivot + reach];
        if let [Some(a), Some(b)] = ends.map(|end| on_screen(scene, frame, end)) {
            let color = axis.color().gamma_multiply(0.6);
            painter.line_segment([a, b], Stroke::new(1.0, color));
        }
    }

    fn drag_ui(
        &mut self,
        ui: &Ui,
        response: &Response,
        frame: Rect,
        zoom: Option<&mut Zoom>,
        view: &mut ViewportScene<'_>,
    ) {
        let size = picture_size(frame);
        if response.drag_started()
            && let Some(start) = ui.input(|input| input.pointer.press_origin())
        {
            let shift = ui.input(|input| input.modifiers.shift);
            let primary = response.drag_started_by(PointerButton::Primary);
            let can_hold = primary && !shift && zoom.is_none();
            self.held = can_hold
                .then(|| self.hold_handle(frame, start, view))
                .flatten();
            let marker = marker_at(view.scene, view.selection, frame, start);
            let marker = marker.filter(|_| can_hold);
            self.drag = match marker {
                _ if zoom.is_some() => Drag::Picture,
                _ if self.held.is_some() => Drag::Handle,
                Some((mark, depth)) => {
                    self.point_at(mark, view.selection);
                    let before = view.scene.lights[mark.light];
                    Drag::Light {
                        mark,
                        depth,
                        before,
                    }
                }
                None if primary && !shift => Drag::Orbit,
                None => Drag::Pan {
                    depth: depth_under(view, size, in_frame(frame, start)),
                },
            };
        }
        if !response.dragged() {
            self.release();
            return;
        }
        let Some(position) = response.interact_pointer_pos() else {
            return;
        };
        let delta = response.drag_delta();
        let to = in_frame(frame, position);
        let from = in_frame(frame, position - delta);
        match self.drag {
            Drag::None => {}
            Drag::Picture => {
                if let Some(zoom) = zoom {
                    zoom.pan(delta);
                }
            }
            Drag::Orbit => {
                let radians =
                    HALF_TURNS_PER_HEIGHT * std::f64::consts::PI / f64::from(frame.height());
                let turn = DVec2::new(-f64::from(delta.x), f64::from(delta.y)) * radians;
                view.scene.camera = orbit::orbit(&view.scene.camera, turn);
            }
            Drag::Pan { depth } => {
                view.scene.camera = orbit::pan(&view.scene.camera, size, from, to, depth);
            }
            Drag::Light { mark, depth, .. } => move_light(view.scene, size, mark, depth, to),
            Drag::Handle => {
                let snap = ui.input(|input| input.modifiers.command);
                if let Some(held) = &mut self.held {
                    held.drag_to(view.scene, size, to, snap);
                }
            }
        }
    }

    /// Selects the light of a marker, and has handles work on what it stands for.
    fn point_at(&mut self, mark: Mark, selection: &mut Selection) {
        *selection = Selection::Light(mark.light);
        self.aimed = mark.is_target.then_some(mark.light);
    }

    /// A click selects what is under it; a double click makes it the point to orbit about, in the preview.
    fn click(&mut self, response: &Response, frame: Rect, view: &mut ViewportScene<'_>) {
        if !response.clicked() && !response.double_clicked() {
            return;
        }
        let Some(position) = response.interact_pointer_pos() else {
            return;
        };
        // A picture has no markers, and its camera is not that of the scene.
        let is_preview = view.picture.is_none();
        let marker = marker_at(view.scene, view.selection, frame, position);
        if let Some((mark, _)) = marker.filter(|_| is_preview) {
            self.point_at(mark, view.selection);
            return;
        }
        let Some(picked) = seen_at(view, picture_size(frame), in_frame(frame, position)) else {
            return;
        };
        self.aimed = None;
        if response.double_clicked() && is_preview {
            view.scene.camera = orbit::look_at(&view.scene.camera, picked.point);
        } else {
            *view.selection = Selection::Object(picked.object).within(view.scene);
        }
    }
}

/// Scrolling and pinching come nearer to the point under the mouse.
fn scroll(ui: &Ui, response: &Response, frame: Rect, view: &mut ViewportScene<'_>) {
    let Some(position) = response.hover_pos() else {
        return;
    };
    let (scrolled, pinched) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
    let factor = (-f64::from(scrolled) * ZOOM_PER_POINT).exp() / f64::from(pinched.max(0.01));
    if (factor - 1.0).abs() < 1e-9 {
        return;
    }
    let size = picture_size(frame);
    let position = in_frame(frame, position);
    let depth = depth_under(view, size, position);
    let Some(direction) = orbit::view_direction(&view.scene.camera, size, position) else {
        return;
    };
    let fixed = view.scene.camera.eye + direction * depth;
    let limits = DistanceLimits::of_scene(&view.bounds);
    view.scene.camera = orbit::zoom(&view.scene.camera, factor, fixed, limits);
}

/// The frame as the picture that camera moves refer to.
#[must_use]
pub fn picture_size(frame: Rect) -> PictureSize {
    PictureSize {
        width: f64::from(frame.width()),
        height: f64::from(frame.height()),
    }
}

/// A position on the screen, from the frame's top left corner.
fn in_frame(frame: Rect, position: Pos2) -> DVec2 {
    let offset = position - frame.min;
    DVec2::new(f64::from(offset.x), f64::from(offset.y))
}

fn picked_at(view: &ViewportScene<'_>, size: PictureSize, position: DVec2) -> Option<Picked> {
    let scene = &view.scene;
    pick::pick(view.geometry?, &scene.camera, &scene.render, size, position)
}

/// What is under `position` on the screen: of the picture, where one is looked at, else of the preview.
fn seen_at(view: &ViewportScene<'_>, size: PictureSize, position: DVec2) -> Option<Picked> {
    let Some((camera, [width, height])) = view.picture else {
        return picked_at(view, size, position);
    };
    let settings = RenderSettings {
        width,
        height,
        ..view.scene.render.clone()
    };
    pick::pick(view.geometry?, &camera, &settings, size, position)
}

/// Depth of what is under `position`: the surface there, where that is found quickly, else the plane through the camera's target.
fn depth_under(view: &ViewportScene<'_>, size: PictureSize, position: DVec2) -> f64 {
    let camera = &view.scene.camera;
    let picked = view.is_quick.then(|| picked_at(view, size, position));
    picked
        .flatten()
        .and_then(|picked| orbit::depth_of(camera, picked.point))
        .unwrap_or_else(|| camera.eye.distance(camera.target))
}

/// Where a world point is on the screen; `None` behind the eye.
fn on_screen(scene: &Scene, frame: Rect, point: DVec3) -> Option<Pos2> {
    let (position, _) = orbit::project(&scene.camera, picture_size(frame), point)?;
    #[expect(clippy::cast_possible_truncation, reason = "screen positions are f32")]
    Some(frame.min + Vec2::new(position.x as f32, position.y as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_frame_has_the_pictures_ratio_and_lies_on_pixels() {
        let area = Rect::from_min_size(Pos2::new(3.3, 40.7), Vec2::new(931.0, 640.0));
        for (width, height) in [(640, 480), (333, 217), (100, 900), (65_536, 1)] {
            let settings = RenderSettings {
                width,
                height,
                ..RenderSettings::default()
            };
            for scale in [1.0, 1.5, 2.0] {
                let frame = frame_in(area, &settings, scale);
                assert!(area.contains_rect(frame));
                for edge in [frame.min.x, frame.min.y, frame.width(), frame.height()] {
                    let pixels = edge * scale;
                    assert!((pixels - pixels.round()).abs() < 1e-3);
                }
                let wanted = width as f32 / height as f32;
                let slack = 1.0 / (frame.height() * scale);
                let ratio = frame.width() / frame.height();
                assert!(wanted > 1000.0 || (ratio / wanted - 1.0).abs() < 2.0 * slack + 0.01);
            }
        }
    }
}
