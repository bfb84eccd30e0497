//! What a drag does to a part of the scene: moving, turning and scaling about a point, in the terms of the scene file.

use super::Part;
use crate::math::{DMat3, DVec3};
use crate::scene::{Facing, Light, Object, Scene};

/// Turns snap to multiples of this, in degrees.
pub const TURN_STEP: f64 = 15.0;
/// Factors of scaling snap to multiples of this.
pub const SCALE_STEP: f64 = 0.1;
/// Smallest factor of scaling.
const LEAST_FACTOR: f64 = 1e-3;
/// Angles are kept to this part of a degree, so that a quarter turn is one in every digit.
const PER_DEGREE: f64 = 1e9;

/// A change of place, direction or size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// By this vector; the places it leads to are multiples of `step` where that is given.
    Move {
        /// In scene units.
        by: DVec3,
        /// In scene units.
        step: Option<f64>,
    },
    /// By this many degrees about this unit vector.
    Turn {
        /// Along which the turn is seen to go clockwise.
        axis: DVec3,
        /// The angle.
        degrees: f64,
    },
    /// To this many times the size.
    Scale(f64),
}

/// A part of the scene as it is, with the point that it turns and scales about.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed {
    /// Which part.
    pub part: Part,
    /// In the world.
    pub pivot: DVec3,
    state: State,
}

#[derive(Clone, Debug, PartialEq)]
enum State {
    Object(Box<Object>),
    Light(Light),
}

impl Placed {
    /// The part as it is in `scene`; `center`: what objects turn about, in their own coordinates. `None` where there is no such part.
    #[must_use]
    pub fn of(scene: &Scene, part: Part, center: DVec3) -> Option<Self> {
        let (pivot, state) = match part {
            Part::Object(index) => {
                let object = scene.objects.get(index)?;
                let pivot = object.placement().world_from_object(center);
                (pivot, State::Object(Box::new(object.clone())))
            }
            Part::Light(index) => {
                let light = scene.lights.get(index)?;
                (light.position(), State::Light(*light))
            }
            Part::LightTarget(index) => {
                let light = scene.lights.get(index)?;
                (light.target()?, State::Light(*light))
            }
        };
        pivot.is_finite().then_some(Self { part, pivot, state })
    }

    /// Its own axes: unit vectors at right angles, right-handed.
    #[must_use]
    pub fn own_axes(&self) -> [DVec3; 3] {
        match (&self.state, self.part) {
            (State::Object(object), _) => {
                let turned = Object {
                    rotate: object.rotate,
                    ..Object::default()
                };
                let DMat3 {
                    x_axis,
                    y_axis,
                    z_axis,
                } = turned.placement().linear;
                [x_axis, y_axis, z_axis]
            }
            (State::Light(Light::Disk { center, facing, .. }), Part::Light(_)) => {
                facing.normal(*center).map_or(DVec3::AXES, |normal| {
                    let (x, y) = normal.any_orthonormal_pair();
                    [x, y, normal]
                })
            }
            _ => DVec3::AXES,
        }
    }

    /// Puts the part into `scene` as it is here.
    pub fn restore(&self, scene: &mut Scene) {
        match &self.state {
            State::Object(object) => put_object(scene, self.part, object.as_ref().clone()),
            State::Light(light) => put_light(scene, self.part, *light),
        }
    }

    /// Puts the part into `scene` as it is here, moved. What would not be a scene any more is left as it was.
    pub fn apply(&self, scene: &mut Scene, motion: Motion) {
        match &self.state {
            State::Object(object) => {
                let moved = moved_object(object, self.pivot, motion);
                let is_sound = moved.translate.is_finite()
                    && moved.rotate.is_finite()
                    && moved.scale.is_finite()
                    && moved.scale != 0.0;
                if is_sound {
                    put_object(scene, self.part, moved);
                }
            }
            State::Light(light) => {
                let moved = match self.part {
                    Part::LightTarget(_) => with_moved_target(light, motion),
                    _ => moved_light(light, motion),
                };
                if is_sound_light(&moved) {
                    put_light(scene, self.part, moved);
                }
            }
        }
    }

    /// Where its pivot comes to lie.
    #[must_use]
    pub fn moved_pivot(&self, motion: Motion) -> DVec3 {
        match (motion, &self.state, self.part) {
            (Motion::Move { by, step }, State::Object(object), _) => {
                self.pivot + (moved_place(object.translate, by, step) - object.translate)
            }
            (Motion::Move { by, step }, ..) => moved_place(self.pivot, by, step),
            _ => self.pivot,
        }
    }
}

fn put_object(scene: &mut Scene, part: Part, object: Object) {
    if let Part::Object(index) = part
        && let Some(place) = scene.objects.get_mut(index)
    {
        *place = object;
    }
}

fn put_light(scene: &mut Scene, part: Part, light: Light) {
    if let Part::Light(index) | Part::LightTarget(index) = part
        && let Some(place) = scene.lights.get_mut(index)
    {
        *place = light;
    }
}

fn moved_object(object: &Object, pivot: DVec3, motion: Motion) -> Object {
    let mut moved = object.clone();
    let offset = object.translate - pivot;
    match motion {
        Motion::Move { by, step } => moved.translate = moved_place(object.translate, by, step),
        Motion::Turn { axis, degrees } => {
            let turn = DMat3::from_axis_angle(axis, degrees.to_radians());
            moved.translate = pivot + turn * offset;
            moved.rotate = turned(object.rotate, axis, degrees);
        }
        Motion::Scale(factor) => {
            let factor = factor.max(LEAST_FACTOR);
            moved.translate = pivot + offset * factor;
            moved.scale = object.scale * factor;
        }
    }
    moved
}

fn moved_light(light: &Light, motion: Motion) -> Light {
    let mut moved = *light;
    match motion {
        Motion::Move { by, step } => moved.move_to(moved_place(light.position(), by, step)),
        Motion::Turn { axis, degrees } => {
            let turn = DMat3::from_axis_angle(axis, degrees.to_radians());
            if let Light::Disk { center, facing, .. } = &mut moved {
                *facing = match *facing {
                    Facing::Target(target) => Facing::Target(*center + turn * (target - *center)),
                    Facing::Normal(normal) => Facing::Normal(turn * normal),
                };
            }
        }
        Motion::Scale(factor) => {
            if let Light::Disk { radius, .. } = &mut moved {
                *radius *= factor.max(LEAST_FACTOR);
            }
        }
    }
    moved
}

fn with_moved_target(light: &Light, motion: Motion) -> Light {
    let mut moved = *light;
    if let (Motion::Move { by, step }, Light::Disk { facing, .. }) = (motion, &mut moved)
        && let Facing::Target(target) = facing
    {
        *target = moved_place(*target, by, step);
    }
    moved
}

fn is_sound_light(light: &Light) -> bool {
    let is_sound = match light {
        Light::Point { .. } => true,
        Light::Disk {
            center,
            facing,
            radius,
            ..
        } => facing.normal(*center).is_some() && *radius > 0.0 && radius.is_finite(),
    };
    is_sound && light.position().is_finite()
}

/// `place` moved by `by`; with `step`, the coordinates that change become multiples of it.
fn moved_place(place: DVec3, by: DVec3, step: Option<f64>) -> DVec3 {
    let moved = place + by;
    let Some(step) = step else { return moved };
    let snapped = DVec3::from_array(moved.to_array().map(|x| snapped(x, step)));
    DVec3::select(by.cmpeq(DVec3::ZERO), place, snapped)
}

/// The multiple of `step` nearest to `value`.
#[must_use]
pub fn snapped(value: f64, step: f64) -> f64 {
    let count = (value / step).round();
    // The reciprocals of decimal steps below 1 are whole: three tenths are 0.3 in every digit.
    if step < 1.0 {
        count / step.recip().round()
    } else {
        count * step
    }
}

/// The largest of 1, 2 and 5 times a power of ten that is at most `length`.
#[must_use]
pub fn round_step(length: f64) -> f64 {
    if !(length > 0.0 && length.is_finite()) {
        return 1.0;
    }
    let power = 10_f64.powf(length.log10().floor());
    let times = [5.0, 2.0].into_iter().find(|times| times * power <= length);
    times.unwrap_or(1.0) * power
}

/// The rotation of an object (degrees about X, then Y, then Z) after another turn about the unit vector `axis`. Of the many triples
/// that mean the same, the one nearest to `rotate`.
#[must_use]
pub fn turned(rotate: DVec3, axis: DVec3, degrees: f64) -> DVec3 {
    // The turn about Z is the last one anyway.
    if axis == DVec3::Z || axis == DVec3::NEG_Z {
        return rounded(rotate + DVec3::Z * (degrees * axis.z));
    }
    let before = Object {
        rotate,
        ..Object::default()
    };
    let turn = DMat3::from_axis_angle(axis, degrees.to_radians());
    let matrix = turn * before.placement().linear;
    let candidates = angles_of(&matrix, rotate).map(|angles| nearest_turns(angles, rotate));
    let [a, b] = candidates.map(rounded);
    let distance = |angles: DVec3| (angles - rotate).abs().element_sum();
    if distance(b) < distance(a) { b } else { a }
}

/// The two triples of degrees about X, then Y, then Z whose rotation is `matrix`. Where Y is turned by a quarter, X and Z do the same,
/// and Z stays that of `before`.
fn angles_of(matrix: &DMat3, before: DVec3) -> [DVec3; 2] {
    /// Below this cosine of the turn about Y, the other two are not told apart.
    const LEAST_COSINE: f64 = 1e-7;
    let x_axis = matrix.x_axis;
    let cosine = x_axis.x.hypot(x_axis.y);
    let y = (-x_axis.z).atan2(cosine);
    if cosine > LEAST_COSINE {
        let x = matrix.y_axis.z.atan2(matrix.z_axis.z);
        let z = x_axis.y.atan2(x_axis.x);
        let angles = DVec3::new(x, y, z).map(f64::to_degrees);
        let other = DVec3::new(angles.x + 180.0, 180.0 - angles.y, angles.z + 180.0);
        return [angles, other];
    }
    let z = before.z.to_radians();
    let about_x = (DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y)).transpose() * *matrix;
    let x = about_x.y_axis.z.atan2(about_x.y_axis.y);
    [DVec3::new(x.to_degrees(), y.to_degrees(), before.z); 2]
}

/// The same angles, each within half a turn of that of `before`.
fn nearest_turns(angles: DVec3, before: DVec3) -> DVec3 {
    angles + ((before - angles) / 360.0).round() * 360.0
}

fn rounded(degrees: DVec3) -> DVec3 {
    (degrees * PER_DEGREE).round() / PER_DEGREE
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene() -> Scene {
        Scene {
            objects: vec![Object {
                scale: 2.0,
                rotate: DVec3::new(20.0, -35.0, 50.0),
                translate: DVec3::new(1.0, 2.0, 3.0),
                ..Object::default()
            }],
            lights: vec![Light::Disk {
                center: DVec3::new(0.0, 0.0, 4.0),
                facing: Facing::Target(DVec3::ZERO),
                radius: 0.5,
                radiance: DVec3::ONE,
                visible: true,
            }],
            ..Scene::default()
        }
    }

    /// Where a motion takes a point.
    type Expected<'a> = &'a dyn Fn(DVec3) -> DVec3;

    /// What a motion does to points is what it says: the corners of an object are turned and scaled about the pivot.
    #[test]
    fn corners_go_where_the_motion_takes_them() {
        let center = DVec3::new(0.5, -1.0, 0.25);
        let corners = [DVec3::ZERO, DVec3::X, DVec3::new(0.3, 2.0, -1.0)];
        let axis = DVec3::new(1.0, -2.0, 0.5).normalize();
        let by = DVec3::new(0.1, 0.0, -4.0);
        let turn = DMat3::from_axis_angle(axis, 71_f64.to_radians());
        let mut after = scene();
        let placed = Placed::of(&after, Part::Object(0), center).unwrap();
        let before = after.objects[0].placement();
        let pivot = placed.pivot;
        let cases: [(Motion, Expected<'_>); 4] = [
            (Motion::Move { by, step: None }, &|p| p + by),
            (
                Motion::Turn {
                    axis,
                    degrees: 71.0,
                },
                &|p| pivot + turn * (p - pivot),
            ),
            (Motion::Scale(0.4), &|p| pivot + (p - pivot) * 0.4),
            (Motion::Turn { axis, degrees: 0.0 }, &|p| p),
        ];
        for (motion, expected) in cases {
            placed.apply(&mut after, motion);
            let placement = after.objects[0].placement();
            for corner in corners {
                let found = placement.world_from_object(corner);
                let expected = expected(before.world_from_object(corner));
                assert!(found.distance(expected) < 1e-8, "{motion:?}");
            }
            let center_now = placement.world_from_object(center);
            assert!(center_now.distance(placed.moved_pivot(motion)) < 1e-8);
        }
        placed.restore(&mut after);
        assert_eq!(after, scene());
    }

    /// Every rotation of a grid, also those where Y is turned by a quarter, turned about axes of all kinds.
    #[test]
    fn angles_are_found_for_every_rotation() {
        let angles = [-180.0, -90.0, -30.0, 0.0, 45.0, 90.0, 123.0];
        let axes = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(0.6, 0.0, -0.8)];
        let linear = |rotate: DVec3| {
            let object = Object {
                rotate,
                ..Object::default()
            };
            object.placement().linear
        };
        for x in angles {
            for y in angles {
                for z in angles {
                    let rotate = DVec3::new(x, y, z);
                    for axis in axes {
                        for degrees in [0.0, 1.0, 90.0, -170.0] {
                            let found = linear(turned(rotate, axis, degrees));
                            let turn = DMat3::from_axis_angle(axis, f64::to_radians(degrees));
                            let wanted = turn * linear(rotate);
                            assert!(found.abs_diff_eq(wanted, 1e-6), "{rotate} {axis} {degrees}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn angles_follow_a_turn_without_leaps() {
        // Past a quarter turn and round again: X and Z stay.
        let mut rotate = DVec3::new(0.0, 0.0, 720.0);
        for step in 1..=400 {
            rotate = turned(rotate, DVec3::Y, 1.0);
            let expected = DVec3::new(0.0, f64::from(step), 720.0);
            assert!(rotate.distance(expected) < 1e-6, "{step}: {rotate}");
        }
        assert_eq!(turned(DVec3::ZERO, DVec3::Z, 370.0).z, 370.0);
        assert_eq!(turned(DVec3::ZERO, DVec3::X, 90.0), DVec3::X * 90.0);
    }

    #[test]
    fn snapped_places_are_round() {
        assert_eq!(snapped(0.31, 0.1), 0.3);
        assert_eq!(snapped(-7.0, 5.0), -5.0);
        let steps = [0.4, 0.99, 1.0, 7.3, 20.0, 0.0, f64::NAN].map(round_step);
        assert_eq!(steps, [0.2, 0.5, 1.0, 5.0, 20.0, 1.0, 1.0]);
        let place = DVec3::new(0.123, 4.56, -1.0);
        let moved = moved_place(place, DVec3::X * 0.1, Some(0.1));
        assert_eq!(moved, DVec3::new(0.2, 4.56, -1.0), "Y and Z are not moved");
    }

    #[test]
    fn lights_move_turn_and_grow() {
        let mut after = scene();
        let center = DVec3::ZERO;
        let light = Placed::of(&after, Part::Light(0), center).unwrap();
        let axis = DVec3::Y;
        light.apply(
            &mut after,
            Motion::Turn {
                axis,
                degrees: 90.0,
            },
        );
        // It shone down; the right hand's turn about Y takes that to −X.
        let target = after.lights[0].target().unwrap();
        assert!(target.distance(DVec3::new(-4.0, 0.0, 4.0)) < 1e-12);
        light.apply(&mut after, Motion::Scale(3.0));
        assert!(matches!(after.lights[0], Light::Disk { radius, .. } if radius == 1.5));
        assert_eq!(
            after.lights[0].target(),
            Some(DVec3::ZERO),
            "from the start"
        );

        let target = Placed::of(&after, Part::LightTarget(0), center).unwrap();
        let by = DVec3::Z * 4.0;
        let before = after.clone();
        target.apply(&mut after, Motion::Move { by, step: None });
        assert_eq!(after, before, "a target in the light is none");
        let by = DVec3::X;
        target.apply(&mut after, Motion::Move { by, step: None });
        assert_eq!(after.lights[0].target(), Some(DVec3::X));
        light.restore(&mut after);
        assert_eq!(after, scene());
    }
}
