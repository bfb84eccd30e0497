//! Objects that were moved since their triangles were prepared: the preview draws them where they are now, so that an object in the
//! hand follows it however large its mesh is.

use crate::math::{DMat3, DVec3, ScaledRotation, SceneFrame};
use crate::scene::Object;

/// What happened to an object: `after = turn · before + shift`, in the world.
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
        let (from, to) = (before.placement(), after.placement());
        let is_same = before.mesh == after.mesh && before.copies == after.copies;
        let only_shifted = from.linear == to.linear;
        if from == to || !is_same || (before.copies.total() > 1 && !only_shifted) {
            return None;
        }
        let turn = if only_shifted {
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

    /// The turn, and what is added after it to places that are seen from `eye` (world), in units of the prepared scene.
    pub(super) fn seen_from(&self, eye: DVec3, frame: &SceneFrame) -> (ScaledRotation, DVec3) {
        (self.turn, (self.apply(eye) - eye) * frame.scale())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
        for point in [DVec3::ZERO, DVec3::X, DVec3::new(0.2, -3.0, 7.0)] {
            let from = before.placement().world_from_object(point);
            let to = after.placement().world_from_object(point);
            assert!(moved.apply(from).distance(to) < 1e-12);
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
