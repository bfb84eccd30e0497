//! The difference between two placements of an object: the preview and first looks show an edited object by it, before its
//! triangles are prepared anew.

use super::{Object, Placement};
use crate::math::{DMat3, DVec3, ScaledRotation, SceneFrame};

/// What happened to an object that went elsewhere: `after = turn · before + shift`, in the world.
///
/// It lets an object be shown where it is now by triangles that were prepared where it was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    turn: ScaledRotation,
    shift: DVec3,
}

impl Move {
    /// What brings `before` to where `after` is; `None` where that is nothing, where they are not the same triangles, or where copies
    /// would each go elsewhere.
    #[must_use]
    pub fn between(before: &Object, after: &Object) -> Option<Self> {
        let is_same = before.mesh == after.mesh && before.copies == after.copies;
        let is_one = before.copies.total() == 1;
        let (from, to) = (before.placement(), after.placement());
        Self::between_places(&from, &to).filter(|moved| is_same && (is_one || moved.only_shifts()))
    }

    /// What brings the place `from` to the place `to`; `None` where that is nothing, or nothing that numbers can say.
    #[must_use]
    pub fn between_places(from: &Placement, to: &Placement) -> Option<Self> {
        if from == to {
            return None;
        }
        let turn = if from.linear == to.linear {
            DMat3::IDENTITY
        } else {
            to.linear * from.linear.inverse()
        };
        let shift = to.translate - turn * from.translate;
        let is_finite = turn.is_finite() && shift.is_finite();
        is_finite.then(|| Self {
            turn: ScaledRotation::new(turn),
            shift,
        })
    }

    /// Where a point of the object is now.
    #[must_use]
    pub fn apply(&self, point: DVec3) -> DVec3 {
        self.turn.apply(point) + self.shift
    }

    /// Whether it neither turns nor scales.
    #[must_use]
    pub fn only_shifts(&self) -> bool {
        *self.turn.matrix() == DMat3::IDENTITY
    }

    /// What it does to directions.
    #[must_use]
    pub fn turn(&self) -> &ScaledRotation {
        &self.turn
    }

    /// Where the origin of the prepared scene goes, in the scene prepared with `frame`.
    #[must_use]
    pub fn shift_in(&self, frame: &SceneFrame) -> DVec3 {
        frame.prepared_from_world(self.apply(frame.world_from_prepared(DVec3::ZERO)))
    }

    /// The turn, and what is added after it to places that are seen from `eye` (world), in units of the scene prepared with `frame`.
    #[must_use]
    pub fn seen_from(&self, eye: DVec3, frame: &SceneFrame) -> (ScaledRotation, DVec3) {
        (self.turn, (self.apply(eye) - eye) * frame.scale())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::DBounds;
    use crate::scene::Copies;

    #[test]
    fn a_move_takes_points_from_before_to_after() {
        let before = Object {
            scale: 2.0,
            rotate: DVec3::new(10.0, 20.0, 30.0),
            translate: DVec3::new(1.0, -2.0, 3.0),
            ..Object::default()
        };
        let after = Object {
            scale: -0.5,
            rotate: DVec3::new(-70.0, 5.0, 90.0),
            translate: DVec3::new(0.0, 4.0, 1.0),
            ..Object::default()
        };
        assert_eq!(Move::between(&before, &before), None);
        let moved = Move::between(&before, &after).unwrap();
        let frame = SceneFrame::around(&DBounds {
            min: DVec3::new(-3.0, 1.0, 2.0),
            max: DVec3::new(5.0, 2.0, 7.0),
        });
        for point in [DVec3::ZERO, DVec3::X, DVec3::new(0.2, -3.0, 7.0)] {
            let from = before.placement().world_from_object(point);
            let to = after.placement().world_from_object(point);
            assert!(moved.apply(from).distance(to) < 1e-12);
            let [from, to] = [from, to].map(|point| frame.prepared_from_world(point));
            let prepared = moved.turn().apply(from) + moved.shift_in(&frame);
            assert!(prepared.distance(to) < 1e-12);
        }
    }

    #[test]
    fn copies_move_together_or_wait() {
        let copies = Copies {
            count: [2, 1, 1],
            step: DVec3::X,
        };
        let before = Object {
            copies,
            ..Object::default()
        };
        let mut after = before.clone();
        after.translate.z = 2.0;
        assert!(Move::between(&before, &after).is_some());
        after.rotate.z = 1.0;
        assert_eq!(Move::between(&before, &after), None);
    }
}
