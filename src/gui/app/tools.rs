//! What the mouse does in the preview beside looking around: handles, and choosing the focus.

use egui::{Key, Modifiers, Rect, Ui};

use super::{App, PreparedState};
use crate::gui::commands::Command;
use crate::gui::focus::{self, FocusAid};
use crate::gui::gizmo::Axis;
use crate::gui::gizmo::motion::Placed;
use crate::gui::orbit;
use crate::gui::selection::Selection;
use crate::gui::tool::{self, Tool};
use crate::gui::viewport;
use crate::math::{DBounds, DVec3};
use crate::scene::{Move, Scene};

/// What can be done while a handle that moves, turns or scales is held.
const MOVE_KEYS: &str =
    "X, Y, Z along one axis, a second time across it  ·  Ctrl snaps  ·  Esc cancels";
const TURN_KEYS: &str = "X, Y, Z about one axis  ·  Ctrl snaps  ·  Esc cancels";
const SCALE_KEYS: &str = "Ctrl snaps  ·  Esc cancels";

impl App {
    /// Chooses what the mouse does; the tool in use gives way to selecting.
    pub(super) fn choose_tool(&mut self, tool: Tool) {
        self.viewport.tool = if self.viewport.tool == tool {
            Tool::Select
        } else {
            tool
        };
        if self.viewport.tool.has_handles() {
            self.show_camera_view();
        }
    }

    /// Keys that mean something while a handle is held or the focus is chosen, before they mean anything else.
    pub(super) fn take_tool_keys(&mut self, ctx: &egui::Context) {
        let pressed = |key: Key| ctx.input_mut(|input| input.consume_key(Modifiers::NONE, key));
        if self.viewport.is_handle_held() {
            let keys = [Key::X, Key::Y, Key::Z].into_iter().zip(Axis::ALL);
            // With Ctrl too, which snaps.
            let with_command =
                |key: Key| ctx.input_mut(|input| input.consume_key(Modifiers::COMMAND, key));
            for (_, axis) in keys.filter(|(key, _)| pressed(*key) || with_command(*key)) {
                self.viewport.constrain_handle(axis);
            }
            if take_cut(ctx) {
                self.viewport.constrain_handle(Axis::X);
            }
        }
        if self.viewport.is_part_held() && pressed(Key::Escape) {
            self.viewport.put_back(&mut self.document.scene);
        }
        let is_free = !egui::Popup::is_any_open(ctx) && !ctx.egui_wants_keyboard_input();
        if !is_free {
            return;
        }
        // First the window in front goes, then what goes on is stopped, then the tool goes, then what is selected.
        if self.has_window_in_front() && pressed(Key::Escape) {
            self.close_window_in_front(ctx);
        }
        let is_asking = matches!(self.viewport.tool, Tool::Focus | Tool::Rays);
        let is_working = self.viewport.tool.has_handles() && self.what_to_stop().is_none();
        let is_told = !self.messages.banners().is_empty() && self.what_to_stop().is_none();
        if (is_asking || is_working) && pressed(Key::Escape) {
            self.viewport.tool = Tool::Select;
        } else if is_told && pressed(Key::Escape) {
            self.messages.dismiss_newest();
        }
        if self.viewport.tool == Tool::Rays {
            for (key, step) in [(Key::Comma, -1), (Key::Period, 1)] {
                if pressed(key) {
                    self.trace_other_sample(step);
                }
            }
        }
    }

    /// Draws handles, the bar of tools, and what the tool in use has to say.
    pub(super) fn tools_ui(&mut self, ui: &mut Ui, frame: Rect, area: Rect) {
        let scene = &self.document.scene;
        let visible = frame.intersect(area);
        if self.is_camera_view() {
            let pointer = ui.input(|input| input.pointer.hover_pos());
            let pointer = pointer.filter(|&place| visible.contains(place));
            let part = (&self.selection, self.selected_center());
            self.viewport.handles_ui(ui, frame, scene, part, pointer);
            if let Some(rays) = self.rays.as_ref().filter(|_| self.shows_rays()) {
                rays.rays_ui(ui, frame, &scene.camera);
            }
            self.boxes.boxes_ui(ui, frame, &scene.camera);
        }
        let lines = match self.viewport.tool {
            Tool::Select => Vec::new(),
            Tool::Rays => self.ray_words(),
            Tool::Focus => focus::in_words(scene, self.viewport.depth_under_mouse()),
            tool => self.handle_words(tool, frame, visible),
        };
        if !lines.is_empty() {
            let note = tool::note_ui(ui, visible, &lines);
            if self.viewport.tool == Tool::Focus {
                self.open_lens_ui(ui, note);
            }
        }
        if self.is_camera_view()
            && let Some(tool) = tool::tools_ui(ui, area, self.viewport.tool)
        {
            self.choose_tool(tool);
        }
        let orientation = self.viewport.orientation;
        if self.picture_on_screen().is_none()
            && self.viewport.tool.has_handles()
            && tool::axes_ui(ui, area, orientation)
        {
            self.viewport.orientation = orientation.other();
        }
    }

    /// Where nothing is blurred, offers above the note of the focus at `note` what blurs.
    fn open_lens_ui(&mut self, ui: &mut Ui, note: Rect) {
        let scene = &mut self.document.scene;
        let has_lens = scene.camera.aperture_radius > 0.0;
        let text = match (has_lens, scene.render.depth_of_field) {
            (true, true) => return,
            (false, _) => "Open the lens",
            (true, false) => "Switch Depth of field on",
        };
        let size = egui::vec2(170.0, ui.spacing().interact_size.y);
        let place = Rect::from_min_size(note.right_top() - size - egui::vec2(0.0, 6.0), size);
        let response = ui.put(place, egui::Button::new(text));
        let tooltip = "Blur what is not sharp: gives the lens a radius of a hundredth of the focus distance where it has none";
        if response.on_hover_text(tooltip).clicked() {
            if !has_lens {
                scene.camera.aperture_radius = focus::wide_radius(&scene.camera);
            }
            scene.render.depth_of_field = true;
        }
    }

    /// Whether the middle of the handles is in `visible`, a part of `frame`.
    fn are_handles_seen(&self, frame: Rect, visible: Rect) -> bool {
        let scene = &self.document.scene;
        let part = self.viewport.handled_part(scene, &self.selection);
        let placed = part.and_then(|part| Placed::of(scene, part, self.selected_center()));
        let size = viewport::picture_size(frame);
        let place = placed.and_then(|placed| orbit::project(&scene.camera, size, placed.pivot));
        place.is_some_and(|(place, _)| {
            let seen = visible.translate(-frame.min.to_vec2());
            let (min, max) = (seen.min, seen.max);
            let x = f64::from(min.x)..=f64::from(max.x);
            let y = f64::from(min.y)..=f64::from(max.y);
            x.contains(&place.x) && y.contains(&place.y)
        })
    }

    /// What to say beside the handles of `tool`, in `visible` of `frame`.
    fn handle_words(&self, tool: Tool, frame: Rect, visible: Rect) -> Vec<String> {
        if !self.is_camera_view() {
            return Vec::new();
        }
        let part = self
            .viewport
            .handled_part(&self.document.scene, &self.selection);
        match (self.viewport.handle_in_words(), part, &self.selection) {
            (Some(words), ..) => {
                let keys = match tool {
                    Tool::Rotate => TURN_KEYS,
                    Tool::Scale => SCALE_KEYS,
                    _ => MOVE_KEYS,
                };
                vec![words, keys.to_owned()]
            }
            (None, Some(_), _) if self.are_handles_seen(frame, visible) => Vec::new(),
            (None, Some(_), Selection::Object(_)) => vec![format!(
                "The handles are out of sight: {} looks at the object",
                Command::FrameSelected.label()
            )],
            (None, Some(_), _) => {
                vec!["The handles are out of sight: look at the light to use them".to_owned()]
            }
            (None, None, Selection::Light(_)) => {
                let verb = if tool == Tool::Rotate {
                    "turned"
                } else {
                    "scaled"
                };
                vec![format!("Only objects and disk lights can be {verb}")]
            }
            (None, None, _) => vec!["Select an object or a light".to_owned()],
        }
    }

    /// Whether preparing the scene may wait: the preview shows the object in the hand where it is, and it moves on.
    pub(super) fn is_in_hand(&self) -> bool {
        let Selection::Object(index) = self.selection else {
            return false;
        };
        let object = self.document.scene.objects.get(index);
        let is_one = object.is_some_and(|object| object.copies.total() == 1);
        is_one && self.viewport.is_handle_held()
    }

    /// What the selected object turns about, in its own coordinates.
    pub(super) fn selected_center(&self) -> DVec3 {
        let selected = self.placed_selection();
        let own = selected.and_then(|(index, state)| state.placed.object_boxes.get(index));
        let own = own.filter(|own| !own.is_empty());
        own.map_or(DVec3::ZERO, DBounds::center)
    }

    /// The corners of the box around the selected object, in the order of [`corners_of`]: along its own axes, or around all copies along
    /// those of the world.
    pub(super) fn selected_corners(&self) -> Option<[DVec3; 8]> {
        let (index, state) = self.placed_selection()?;
        let object = self.document.scene.objects.get(index)?;
        if object.copies.total() == 1 {
            let own = state.placed.object_boxes.get(index)?;
            let placement = object.placement();
            let place = |corner| placement.world_from_object(corner);
            return (!own.is_empty()).then(|| corners_of(own).map(place));
        }
        let bounds = self.selected_bounds();
        let moved = self.selected_move();
        let place = |corner| moved.map_or(corner, |moved| moved.apply(corner));
        (!bounds.is_empty()).then(|| corners_of(&bounds).map(place))
    }

    /// The world box of the selected object.
    pub(super) fn selected_bounds(&self) -> DBounds {
        let selected = self.placed_selection();
        let bounds = selected.and_then(|(index, state)| state.placed.object_bounds.get(index));
        bounds.copied().unwrap_or(DBounds::EMPTY)
    }

    /// The number of the selected object, and what was placed of the scene, where the number means the same object in it.
    fn placed_selection(&self) -> Option<(usize, &PreparedState)> {
        let (Selection::Object(index), Some(state)) = (&self.selection, &self.prepared) else {
            return None;
        };
        // While an edit that adds or removes objects is prepared, places in the list mean others.
        let is_same = state.scene.objects.len() == self.document.scene.objects.len();
        is_same.then_some((*index, state))
    }

    /// What happened to the selected object since its triangles were prepared.
    fn selected_move(&self) -> Option<Move> {
        let (Selection::Object(index), Some(state)) = (&self.selection, &self.prepared) else {
            return None;
        };
        let moves = moves_since(&state.scene, &self.document.scene);
        moves.get(*index).copied().flatten()
    }
}

/// The corners of a box; bit `n` of a corner's number says which end of axis `n` it is at.
fn corners_of(bounds: &DBounds) -> [DVec3; 8] {
    std::array::from_fn(|bits| {
        let at = |axis: usize| {
            let end = if bits >> axis & 1 == 1 {
                bounds.max
            } else {
                bounds.min
            };
            end[axis]
        };
        DVec3::new(at(0), at(1), at(2))
    })
}

/// Whether Ctrl+X was pressed, which desktops tell of in place of the keys. It means nothing else then.
fn take_cut(ctx: &egui::Context) -> bool {
    ctx.input_mut(|input| {
        let before = input.events.len();
        input.events.retain(|event| *event != egui::Event::Cut);
        input.events.len() < before
    })
}

/// What happened to each object of `prepared` until it is as in `now`; empty where they are not the same objects.
pub(super) fn moves_since(prepared: &Scene, now: &Scene) -> Vec<Option<Move>> {
    if prepared.objects.len() != now.objects.len() {
        return Vec::new();
    }
    let pairs = prepared.objects.iter().zip(&now.objects);
    pairs
        .map(|(before, after)| Move::between(before, after))
        .collect()
}

/// What the preview shows of the focus.
pub(super) fn focus_aid(tool: Tool, selection: &Selection, scene: &Scene) -> FocusAid {
    if tool == Tool::Focus {
        return FocusAid::Blur;
    }
    let has_lens = scene.camera.aperture_radius > 0.0 && scene.render.depth_of_field;
    if *selection == Selection::Camera && has_lens {
        FocusAid::Plane
    } else {
        FocusAid::Off
    }
}
