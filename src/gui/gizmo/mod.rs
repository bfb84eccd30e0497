//! Handles in the preview that move, turn and scale the selected object or light.
//!
//! A drag remembers the part as it was when it began ([`Placed`]) and puts it anew on every frame, so that it never drifts, can be
//! cancelled, and may be constrained to an axis half-way.
//!
//! - [`sight`]: where the mouse points in the world
//! - [`motion`]: what a drag does to the scene
//! - [`shape`]: what handles look like, and which is under the mouse

pub mod motion;
pub mod shape;
pub mod sight;

use egui::Color32;

use super::orbit::PictureSize;
use super::selection::Selection;
use super::tool::Tool;
use super::widgets::format_number;
use crate::math::{DVec2, DVec3};
use crate::scene::{Camera, Light, Scene};
use motion::{Motion, Placed, SCALE_STEP, TURN_STEP, round_step, snapped};
use shape::Viewed;
use sight::{Sight, angle_about};

/// Below this cosine between its axis and the line of sight, a ring is dragged along rather than around.
const EDGE_ON: f64 = 0.2;
/// Moves snap to a round part of this share of an arrow's length.
const STEP_SHARE: f64 = 0.25;

/// A part of the scene that handles work on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The object at this place.
    Object(usize),
    /// The light at this place.
    Light(usize),
    /// What the light at this place is turned towards.
    LightTarget(usize),
}

impl Part {
    /// What handles work on where `selection` is selected; `aimed`: the light whose target was pointed at last.
    #[must_use]
    pub fn of(selection: &Selection, aimed: Option<usize>) -> Option<Self> {
        match *selection {
            Selection::Object(index) => Some(Self::Object(index)),
            Selection::Light(index) if aimed == Some(index) => Some(Self::LightTarget(index)),
            Selection::Light(index) => Some(Self::Light(index)),
            _ => None,
        }
    }

    /// Whether `tool` has handles for it.
    #[must_use]
    pub fn allows(self, tool: Tool, scene: &Scene) -> bool {
        let is_disk = |index: usize| matches!(scene.lights.get(index), Some(Light::Disk { .. }));
        match self {
            Self::Object(index) => tool.has_handles() && index < scene.objects.len(),
            Self::Light(index) if tool == Tool::Move => index < scene.lights.len(),
            Self::Light(index) => tool.has_handles() && is_disk(index),
            Self::LightTarget(index) => {
                let target = scene.lights.get(index).and_then(Light::target);
                tool == Tool::Move && target.is_some()
            }
        }
    }
}

/// An axis, of the world or of a part of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// The first.
    X,
    /// The second.
    Y,
    /// The third.
    Z,
}

impl Axis {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// Its unit vector, where it is one of the world.
    #[must_use]
    pub fn direction(self) -> DVec3 {
        DVec3::AXES[self as usize]
    }

    /// The other two, so that all three are right-handed.
    #[must_use]
    pub fn others(self) -> [Self; 2] {
        match self {
            Self::X => [Self::Y, Self::Z],
            Self::Y => [Self::Z, Self::X],
            Self::Z => [Self::X, Self::Y],
        }
    }

    fn name(self) -> &'static str {
        ["X", "Y", "Z"][self as usize]
    }

    /// The colour it is drawn in.
    #[must_use]
    pub fn color(self) -> Color32 {
        match self {
            Self::X => Color32::from_rgb(0xf0, 0x60, 0x5c),
            Self::Y => Color32::from_rgb(0x70, 0xcc, 0x58),
            Self::Z => Color32::from_rgb(0x5c, 0x9c, 0xff),
        }
    }
}

/// Which axes handles go along.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Orientation {
    /// Those of the world.
    #[default]
    World,
    /// Those of the part itself: of an object as it is turned, of a disk with Z where it shines.
    Own,
}

impl Orientation {
    /// The one that it is not.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::World => Self::Own,
            Self::Own => Self::World,
        }
    }
}

/// The directions of the three axes: unit vectors at right angles, right-handed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes([DVec3; 3]);

impl Axes {
    /// Those of the world.
    pub const WORLD: Self = Self(DVec3::AXES);

    /// The axes of `placed`, or of the world, as `orientation` says.
    #[must_use]
    pub fn of(placed: &Placed, orientation: Orientation) -> Self {
        match orientation {
            Orientation::World => Self::WORLD,
            Orientation::Own => Self(placed.own_axes()),
        }
    }

    /// The direction of one of them.
    #[must_use]
    pub fn direction(&self, axis: Axis) -> DVec3 {
        self.0[axis as usize]
    }
}

/// What of a gizmo is taken hold of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handle {
    /// Moves along an axis, or turns about it.
    Along(Axis),
    /// Moves in the plane across an axis.
    Across(Axis),
    /// Moves in the plane across the view, turns about the line of sight, or scales.
    Free,
}

impl Handle {
    fn color(self) -> Color32 {
        match self {
            Self::Along(axis) | Self::Across(axis) => axis.color(),
            Self::Free => Color32::from_gray(0xe4),
        }
    }
}

/// A handle that is held.
#[derive(Clone, Debug)]
pub struct HandleDrag {
    placed: Placed,
    tool: Tool,
    /// What was taken hold of, and what it goes on as.
    taken: Handle,
    handle: Handle,
    /// As they were when it was taken hold of.
    axes: Axes,
    /// Where it was taken hold of.
    from: DVec2,
    /// Length of an arrow in the world.
    length: f64,
    turn: Turn,
    motion: Motion,
}

/// How far a ring has been turned: over more than a whole turn, too.
#[derive(Clone, Copy, Debug, Default)]
struct Turn {
    /// The angle at the last place of the mouse, within ±π.
    last: f64,
    /// All of it, in radians.
    total: f64,
}

impl HandleDrag {
    /// Takes hold of `handle` at `from`, a place of the frame. `None` where the part is not seen.
    #[must_use]
    pub fn new(
        placed: Placed,
        tool: Tool,
        (handle, axes): (Handle, Axes),
        (camera, size): (&Camera, PictureSize),
        from: DVec2,
    ) -> Option<Self> {
        let pivot = placed.pivot;
        let length = Viewed {
            camera,
            size,
            pivot,
            axes,
        }
        .length()?;
        Some(Self {
            placed,
            tool,
            taken: handle,
            handle,
            axes,
            from,
            length,
            turn: Turn::default(),
            motion: Motion::Scale(1.0),
        })
    }

    /// The part that is moved.
    #[must_use]
    pub fn part(&self) -> Part {
        self.placed.part
    }

    /// The axes that it goes along.
    #[must_use]
    pub fn axes(&self) -> Axes {
        self.axes
    }

    /// The handle that is held.
    #[must_use]
    pub fn handle(&self) -> Handle {
        self.handle
    }

    /// Goes on along or about `axis` alone, from where the drag began. A second time, a move goes on across it; but an arrow keeps to the
    /// axis that it was taken hold of for.
    pub fn constrain(&mut self, axis: Axis) {
        let along = Handle::Along(axis);
        let is_again = self.handle == along && self.taken != along;
        self.handle = match self.tool {
            Tool::Move if is_again => Handle::Across(axis),
            Tool::Move | Tool::Rotate => along,
            _ => self.handle,
        };
        self.turn = Turn::default();
    }

    /// Puts the part as it was when the drag began.
    pub fn cancel(&self, scene: &mut Scene) {
        self.placed.restore(scene);
    }

    /// Moves the part to where the mouse is now, `to`. `snap`: to round places, angles and sizes.
    pub fn drag_to(&mut self, scene: &mut Scene, size: PictureSize, to: DVec2, snap: bool) {
        let camera = scene.camera;
        let motion = match self.tool {
            Tool::Move => self.moved(&camera, size, to, snap),
            Tool::Rotate => self.rotated(&camera, size, to, snap),
            Tool::Scale => self.scaled(&camera, size, to, snap),
            Tool::Select | Tool::Focus | Tool::Rays => None,
        };
        // Where the mouse points at nothing that can be said, the part stays where it is.
        if let Some(motion) = motion {
            self.motion = motion;
            self.placed.apply(scene, motion);
        }
    }

    fn moved(&self, camera: &Camera, size: PictureSize, to: DVec2, snap: bool) -> Option<Motion> {
        let pivot = self.placed.pivot;
        let [from, to] = [self.from, to].map(|place| Sight::through(camera, size, place));
        let (from, to) = (from?, to?);
        let step = snap.then(|| round_step(self.length * STEP_SHARE));
        let by = match self.handle {
            Handle::Along(axis) => {
                let axis = self.axes.direction(axis);
                axis * (to.along(pivot, axis)? - from.along(pivot, axis)?)
            }
            Handle::Across(axis) => {
                let normal = self.axes.direction(axis);
                let by = to.in_plane(pivot, normal)? - from.in_plane(pivot, normal)?;
                if self.axes == Axes::WORLD {
                    // Exactly, so that what does not move is not rounded either.
                    by * (DVec3::ONE - normal)
                } else {
                    by - normal * by.dot(normal)
                }
            }
            Handle::Free => {
                let normal = camera.axes()?.forward;
                to.in_plane(pivot, normal)? - from.in_plane(pivot, normal)?
            }
        };
        // Along axes of its own, what is round is the way, not the place.
        Some(match step {
            Some(step) if self.axes != Axes::WORLD => Motion::Move {
                by: self
                    .axes
                    .0
                    .map(|axis| axis * snapped(by.dot(axis), step))
                    .into_iter()
                    .sum(),
                step: None,
            },
            step => Motion::Move { by, step },
        })
    }

    fn rotated(
        &mut self,
        camera: &Camera,
        size: PictureSize,
        to: DVec2,
        snap: bool,
    ) -> Option<Motion> {
        let pivot = self.placed.pivot;
        let [from, to] = [self.from, to].map(|place| Sight::through(camera, size, place));
        let (from, to) = (from?, to?);
        let forward = camera.axes()?.forward;
        let axis = match self.handle {
            Handle::Along(axis) | Handle::Across(axis) => self.axes.direction(axis),
            Handle::Free => -forward,
        };
        let to_eye = (camera.eye - pivot).try_normalize()?;
        if axis.dot(to_eye).abs() < EDGE_ON {
            // The near side of the ring follows the mouse.
            let along = axis.cross(to_eye).try_normalize()?;
            let by = to.in_plane(pivot, forward)? - from.in_plane(pivot, forward)?;
            self.turn.total = by.dot(along) / (self.length * shape::RING);
        } else {
            let [from, to] = [from, to].map(|sight| sight.in_plane(pivot, axis));
            let angle = angle_about(axis, from? - pivot, to? - pivot);
            let half = std::f64::consts::PI;
            let step = (angle - self.turn.last + half).rem_euclid(2.0 * half) - half;
            self.turn.last = angle;
            self.turn.total += step;
        }
        let degrees = self.turn.total.to_degrees();
        let degrees = if snap {
            snapped(degrees, TURN_STEP)
        } else {
            degrees
        };
        Some(Motion::Turn { axis, degrees })
    }

    fn scaled(&self, camera: &Camera, size: PictureSize, to: DVec2, snap: bool) -> Option<Motion> {
        let pivot = self.placed.pivot;
        let normal = camera.axes()?.forward;
        let distance = |place: DVec2| {
            let sight = Sight::through(camera, size, place)?;
            Some(sight.in_plane(pivot, normal)?.distance(pivot))
        };
        let factor = distance(to)? / distance(self.from)?;
        let factor = if snap {
            snapped(factor, SCALE_STEP).max(SCALE_STEP)
        } else {
            factor
        };
        factor.is_finite().then_some(Motion::Scale(factor))
    }

    /// Whose axes those are that are named.
    fn whose(&self) -> &'static str {
        if self.axes == Axes::WORLD {
            ""
        } else {
            ", own axes,"
        }
    }

    /// What the drag has done so far.
    #[must_use]
    pub fn in_words(&self) -> String {
        match self.motion {
            Motion::Move { .. } => {
                let by = self.placed.moved_pivot(self.motion) - self.placed.pivot;
                let size = by.length();
                let parts = Axis::ALL.iter().filter_map(|&axis| {
                    let by = by.dot(self.axes.direction(axis));
                    let sign = if by > 0.0 { "+" } else { "" };
                    // Less is rounding.
                    let is_moved = by.abs() > 1e-9 * size;
                    is_moved.then(|| format!("{} {sign}{}", axis.name(), format_number(by, 3)))
                });
                let parts: Vec<String> = parts.collect();
                format!("Move{}  {}", self.whose(), parts.join("  "))
            }
            Motion::Turn { degrees, .. } => {
                let about = match self.handle {
                    Handle::Along(axis) | Handle::Across(axis) => axis.name(),
                    Handle::Free => "the line of sight",
                };
                let whose = if self.handle == Handle::Free {
                    ""
                } else {
                    self.whose()
                };
                format!("Turn{whose} about {about}  {}°", format_number(degrees, 1))
            }
            Motion::Scale(factor) => format!("Scale  × {}", format_number(factor, 3)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gui::orbit;
    use crate::scene::{Facing, Object};

    const SIZE: PictureSize = PictureSize {
        width: 900.0,
        height: 600.0,
    };

    fn scene() -> Scene {
        Scene {
            camera: Camera {
                eye: DVec3::new(3.0, -6.0, 2.5),
                target: DVec3::ZERO,
                ..Camera::default()
            },
            objects: vec![Object {
                translate: DVec3::new(0.25, 0.5, 0.0),
                ..Object::default()
            }],
            ..Scene::default()
        }
    }

    fn on_screen(scene: &Scene, point: DVec3) -> DVec2 {
        orbit::project(&scene.camera, SIZE, point).unwrap().0
    }

    fn hold(scene: &Scene, tool: Tool, handle: Handle, from: DVec3) -> HandleDrag {
        let placed = Placed::of(scene, Part::Object(0), DVec3::ZERO).unwrap();
        let from = on_screen(scene, from);
        let handle = (handle, Axes::WORLD);
        HandleDrag::new(placed, tool, handle, (&scene.camera, SIZE), from).unwrap()
    }

    /// Along and about the axes of a turned object, which its corners tell.
    #[test]
    fn a_turned_object_moves_and_turns_along_axes_of_its_own() {
        let mut before = scene();
        before.objects[0].rotate = DVec3::new(25.0, -40.0, 65.0);
        let object = &before.objects[0];
        let start = object.translate;
        let own = |point: DVec3| object.placement().world_from_object(point) - start;
        for axis in Axis::ALL {
            let placed = Placed::of(&before, Part::Object(0), DVec3::ZERO).unwrap();
            let axes = Axes::of(&placed, Orientation::Own);
            let along = own(axis.direction());
            assert!(axes.direction(axis).distance(along) < 1e-12);
            let [u, v] = axis.others().map(|other| own(other.direction()));
            let hold = |tool, handle, place| {
                let from = on_screen(&before, place);
                let view = (&before.camera, SIZE);
                HandleDrag::new(placed.clone(), tool, (handle, axes), view, from).unwrap()
            };
            let mut after = before.clone();
            let mut drag = hold(Tool::Move, Handle::Along(axis), start + along * 0.7);
            let to = on_screen(&after, start - along * 1.2);
            drag.drag_to(&mut after, SIZE, to, false);
            let expected = start - along * 1.9;
            assert!(after.objects[0].translate.distance(expected) < 1e-9);
            drag.drag_to(&mut after, SIZE, to, true);
            let way = after.objects[0].translate - start;
            let step = round_step(drag.length * STEP_SHARE);
            let steps = way.length() / step;
            assert!((steps - steps.round()).abs() < 1e-9, "{steps}");
            assert!(way.cross(along).length() < 1e-9);

            let mut after = before.clone();
            let mut drag = hold(Tool::Move, Handle::Across(axis), start + u * 0.4);
            let to = on_screen(&after, start + u * 0.9 - v * 0.3);
            drag.drag_to(&mut after, SIZE, to, false);
            let expected = start + u * 0.5 - v * 0.3;
            assert!(after.objects[0].translate.distance(expected) < 1e-9);

            // A quarter turn takes one of the other two axes to the other, and leaves this one.
            let mut after = before.clone();
            let mut drag = hold(Tool::Rotate, Handle::Along(axis), start + u);
            for step in 1..=9 {
                let angle = f64::to_radians(f64::from(step) * 10.0);
                let to = on_screen(&after, start + u * angle.cos() + v * angle.sin());
                drag.drag_to(&mut after, SIZE, to, false);
            }
            let turned = after.objects[0].placement();
            let [first, _] = axis.others();
            let moved = |axis: Axis| turned.world_from_object(axis.direction()) - start;
            assert!(moved(first).distance(v) < 1e-6, "{axis:?}");
            assert!(moved(axis).distance(along) < 1e-6, "{axis:?}");
        }
    }

    /// The point that is held follows the mouse along every handle.
    #[test]
    fn what_is_held_follows_the_mouse() {
        let start = DVec3::new(0.25, 0.5, 0.0);
        for axis in Axis::ALL {
            let mut after = scene();
            let held = start + axis.direction() * 0.7;
            let mut drag = hold(&after, Tool::Move, Handle::Along(axis), held);
            let to = on_screen(&after, held - axis.direction() * 1.9);
            drag.drag_to(&mut after, SIZE, to, false);
            let expected = start - axis.direction() * 1.9;
            assert!(after.objects[0].translate.distance(expected) < 1e-9);

            let [u, v] = axis.others().map(Axis::direction);
            let mut after = scene();
            let mut drag = hold(&after, Tool::Move, Handle::Across(axis), start + u * 0.4);
            let to = on_screen(&after, start + u * 0.9 - v * 0.3);
            drag.drag_to(&mut after, SIZE, to, false);
            let moved = after.objects[0].translate;
            assert!(moved.distance(start + u * 0.5 - v * 0.3) < 1e-9);
            assert_eq!(moved[axis as usize], start[axis as usize], "exactly");

            let mut after = scene();
            let mut drag = hold(&after, Tool::Rotate, Handle::Along(axis), start + u);
            // In steps, as the mouse moves: all but a whole turn.
            for step in 1..=35 {
                let angle = f64::to_radians(f64::from(step) * 10.0);
                let to = on_screen(&after, start + u * angle.cos() + v * angle.sin());
                drag.drag_to(&mut after, SIZE, to, false);
            }
            let Motion::Turn { degrees, .. } = drag.motion else {
                panic!("it turns");
            };
            assert!((degrees - 350.0).abs() < 1e-6, "{axis:?} {degrees}");
            assert!(after.objects[0].translate.distance(start) < 1e-9);
        }
    }

    #[test]
    fn a_ring_seen_from_its_side_turns_with_the_mouse_along_it() {
        let mut after = scene();
        after.camera.eye = DVec3::new(0.25, -6.0, 0.0);
        after.camera.target = DVec3::new(0.25, 0.5, 0.0);
        let start = after.objects[0].translate;
        let mut drag = hold(&after, Tool::Rotate, Handle::Along(Axis::Z), start);
        let radius = drag.length * shape::RING;
        let to = on_screen(&after, start + DVec3::X * radius);
        drag.drag_to(&mut after, SIZE, to, false);
        // The near side goes to the right by the radius: a turn of one radian.
        assert!((after.objects[0].rotate.z - 1_f64.to_degrees()).abs() < 1e-6);
    }

    #[test]
    fn scaling_goes_by_the_distance_and_snaps() {
        let mut after = scene();
        let start = after.objects[0].translate;
        let right = after.camera.axes().unwrap().right;
        let mut drag = hold(&after, Tool::Scale, Handle::Free, start + right * 0.5);
        let to = on_screen(&after, start - right * 1.24);
        drag.drag_to(&mut after, SIZE, to, false);
        assert!((after.objects[0].scale - 2.48).abs() < 1e-9);
        drag.drag_to(&mut after, SIZE, to, true);
        assert_eq!(after.objects[0].scale, 2.5);
        assert_eq!(drag.in_words(), "Scale  × 2.5");
        let to = on_screen(&after, start);
        drag.drag_to(&mut after, SIZE, to, true);
        assert_eq!(after.objects[0].scale, 0.1, "never nothing");
    }

    #[test]
    fn a_drag_is_constrained_half_way_and_cancelled() {
        let mut after = scene();
        let start = after.objects[0].translate;
        let mut drag = hold(&after, Tool::Move, Handle::Free, start);
        let to = on_screen(&after, start + DVec3::X * 0.8);
        drag.drag_to(&mut after, SIZE, to, false);
        drag.constrain(Axis::X);
        drag.drag_to(&mut after, SIZE, to, false);
        assert!(after.objects[0].translate.distance(start + DVec3::X * 0.8) < 1e-9);
        drag.drag_to(&mut after, SIZE, to, true);
        let x = after.objects[0].translate.x;
        let step = round_step(drag.length * STEP_SHARE);
        assert!((x / step - (x / step).round()).abs() < 1e-9, "{x} {step}");
        drag.constrain(Axis::X);
        assert_eq!(drag.handle(), Handle::Across(Axis::X));
        drag.cancel(&mut after);
        assert_eq!(after, scene());
    }

    #[test]
    fn an_arrow_keeps_to_its_axis_when_its_own_letter_is_pressed() {
        let mut after = scene();
        let start = after.objects[0].translate;
        let held = start + DVec3::X * 0.7;
        for tool in [Tool::Move, Tool::Rotate] {
            let mut drag = hold(&after, tool, Handle::Along(Axis::X), held);
            for _ in 0..3 {
                drag.constrain(Axis::X);
                assert_eq!(drag.handle(), Handle::Along(Axis::X));
            }
            drag.constrain(Axis::Y);
            assert_eq!(drag.handle(), Handle::Along(Axis::Y));
            drag.constrain(Axis::X);
            assert_eq!(drag.handle(), Handle::Along(Axis::X));
        }
        let mut drag = hold(&after, Tool::Move, Handle::Along(Axis::X), held);
        drag.constrain(Axis::X);
        let to = on_screen(&after, held + DVec3::new(0.5, 0.0, 0.6));
        drag.drag_to(&mut after, SIZE, to, false);
        let way = after.objects[0].translate - start;
        assert!(way.x != 0.0 && way.y == 0.0 && way.z == 0.0, "{way}");
    }

    #[test]
    fn tools_know_what_they_can_do() {
        let mut scene = scene();
        scene.lights.push(Light::default());
        scene.lights.push(Light::disk());
        let tools = |part: Part, scene: &Scene| {
            let tools = Tool::ALL.into_iter();
            tools.filter(|&t| part.allows(t, scene)).collect::<Vec<_>>()
        };
        let all = [Tool::Move, Tool::Rotate, Tool::Scale];
        assert_eq!(tools(Part::Object(0), &scene), all);
        assert_eq!(tools(Part::Object(1), &scene), []);
        assert_eq!(tools(Part::Light(0), &scene), [Tool::Move]);
        assert_eq!(tools(Part::Light(1), &scene), all);
        assert_eq!(
            tools(Part::LightTarget(1), &scene),
            [],
            "it has a direction"
        );
        if let Light::Disk { facing, .. } = &mut scene.lights[1] {
            *facing = Facing::Target(DVec3::NEG_Z);
        }
        assert_eq!(tools(Part::LightTarget(1), &scene), [Tool::Move]);
        let part = Part::of(&Selection::Light(1), Some(1));
        assert_eq!(part, Some(Part::LightTarget(1)));
        assert_eq!(Part::of(&Selection::Camera, None), None);
    }
}
