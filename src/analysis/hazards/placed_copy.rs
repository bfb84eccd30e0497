//! Copies of objects where the prepared scene has them, so that their faces are looked for at a few places in it.

use super::mesh_use::{bounds_of_first_copy, narrowed};
use super::stops;
use crate::accel::BoxTree;
use crate::control::CancelToken;
use crate::geometry::TriangleMesh;
use crate::math::{Bounds, DBounds, DVec3, SceneFrame};
use crate::scene::{Object, Placement};

/// One copy of an object; all lengths are prepared units.
pub struct PlacedCopy<'a> {
    mesh: &'a TriangleMesh,
    frame: &'a SceneFrame,
    /// Of the first copy.
    placement: Placement,
    /// From the first copy to this one, in the world.
    offset: DVec3,
    bounds: Bounds,
}

impl<'a> PlacedCopy<'a> {
    /// All copies of `object`, which shows `mesh`; none where that has no vertices.
    pub fn all_of(
        object: &Object,
        mesh: &'a TriangleMesh,
        frame: &'a SceneFrame,
    ) -> impl Iterator<Item = Self> {
        let placement = object.placement();
        let around = bounds_of_first_copy(object, mesh);
        let offsets = object.copies.offsets();
        let offsets = offsets.take_while(move |_| !around.is_empty());
        offsets.map(move |offset| Self {
            mesh,
            frame,
            placement,
            offset,
            bounds: narrowed(&DBounds {
                min: frame.prepared_from_world(around.min + offset),
                max: frame.prepared_from_world(around.max + offset),
            }),
        })
    }

    /// How many faces it has.
    pub fn faces(&self) -> usize {
        self.mesh.triangles.len()
    }

    /// Whether the box around it overlaps one of `places` that `counts`.
    pub fn is_near(&self, places: &BoxTree, counts: impl Fn(u32) -> bool) -> bool {
        let mut is_near = false;
        places.overlapping(&self.bounds, |place| is_near |= counts(place));
        is_near
    }

    /// Calls `visit` with every one of `places` that the box around a face overlaps, and the face's number and corners. `None` when
    /// cancelled.
    pub fn for_each_face_near(
        &self,
        places: &BoxTree,
        cancel: &CancelToken,
        mut visit: impl FnMut(u32, usize, [DVec3; 3]),
    ) -> Option<()> {
        for face in 0..self.faces() {
            if stops(cancel, face) {
                return None;
            }
            let corners = self.mesh.corners(face).map(|corner| {
                let in_world = self.placement.world_from_object(corner) + self.offset;
                self.frame.prepared_from_world(in_world)
            });
            let bounds = narrowed(&DBounds::of_points(corners));
            places.overlapping(&bounds, |place| visit(place, face, corners));
        }
        Some(())
    }
}
