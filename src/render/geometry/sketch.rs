//! Geometry for a first look, while objects move.
//!
//! Triangles are rounded where they are, in a frame around the whole scene, so an object that moves changes the last digits of
//! all of them, and with those the picture's: everything is placed anew and gets a new tree. That takes its time. A first look
//! needs no last digits. Here an object that moved leaves the tree it is in, which keeps its boxes, and becomes a copy of itself that
//! is somewhere else: next to nothing is done for each move, and little when an object moves for the first time.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use super::origin::GeometryOrigin;
use super::{PreparedGeometry, id};
use crate::accel::{Accelerator, Assembly, Copies, Part};
use crate::math::{DMat3, DVec3, ScaledRotation};
use crate::scene::{Move, Scene, SceneError};

/// Keeps objects that have left the tree of some geometry, from one sketch to the next. Clones are one and the same.
#[derive(Clone, Debug, Default)]
pub struct SketchStore(Arc<Mutex<Option<Arc<Loose>>>>);

/// A tree that objects have left.
#[derive(Debug)]
struct Loose {
    /// Whose tree it was: not kept alive.
    of: Weak<PreparedGeometry>,
    flat: Arc<Accelerator>,
    /// The structure of each object that left, by its index in the description.
    objects: BTreeMap<usize, Arc<Accelerator>>,
}

impl SketchStore {
    /// The tree of `geometry` without the objects `moved`, and perhaps without others; `None` where it cannot be had quickly.
    fn loosened(&self, geometry: &Arc<PreparedGeometry>, moved: &[usize]) -> Option<Arc<Loose>> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = kept.as_ref().filter(|loose| {
            loose.of.as_ptr() == Arc::as_ptr(geometry)
                && moved.iter().all(|index| loose.objects.contains_key(index))
        });
        if let Some(known) = known {
            return Some(Arc::clone(known));
        }
        // The memory of those that other objects have left is given back first.
        *kept = None;
        let mut flat = Arc::clone(geometry.accelerator.flat());
        let mut objects = BTreeMap::new();
        for &index in moved {
            let [without, only] = flat.parted(&geometry.accelerator.flat_range(index)?)?;
            flat = Arc::new(without);
            objects.insert(index, Arc::new(only));
        }
        let of = Arc::downgrade(geometry);
        Some(Arc::clone(kept.insert(Arc::new(Loose {
            of,
            flat,
            objects,
        }))))
    }
}

impl PreparedGeometry {
    /// Approximately what `scene` would be prepared to, where it differs from the scene of `self` only by places of objects; `None` where
    /// it differs by more, or a sketch would take as long. The frame is that of `self`.
    ///
    /// # Errors
    /// A mesh that is not loaded.
    pub(in crate::render) fn sketch(
        self: &Arc<Self>,
        scene: &Scene,
        store: &SketchStore,
    ) -> Result<Option<Arc<Self>>, SceneError> {
        let origin = GeometryOrigin::of(scene)?;
        Ok(self.sketch_of(origin, store).map(Arc::new))
    }

    fn sketch_of(self: &Arc<Self>, origin: GeometryOrigin, store: &SketchStore) -> Option<Self> {
        let is_like = self.origin.structure == origin.structure
            && self.origin.objects.len() == origin.objects.len();
        if !is_like {
            return None;
        }
        let mut moved = Vec::new();
        let pairs = self.origin.objects.iter().zip(&origin.objects);
        for (index, ((mesh, before), (mesh_now, now))) in pairs.enumerate() {
            let is_one = now.copies.total() == 1;
            let is_like = mesh == mesh_now
                && before.smooth == now.smooth
                && (is_one || before.copies == now.copies)
                && before.copies.total() == now.copies.total();
            if !is_like {
                return None;
            }
            let is_flat = self.accelerator.flat_range(index).is_some();
            if is_flat && before.placement != now.placement {
                let way = Move::between_places(&before.placement, &now.placement)?;
                // Copies would each turn about a point of its own, and what is mirrored has its corners in another order.
                if way.turn().is_mirrored() || !is_one && !way.only_shifts() {
                    return None;
                }
                moved.push(index);
            }
        }
        let loose = store.loosened(self, &moved)?;
        let mut shared = self.shared.structures();
        let mut parts = Vec::with_capacity(origin.objects.len());
        for (index, (mesh, shape)) in origin.objects.iter().enumerate() {
            let count = id(self.objects[index].triangles.len());
            parts.push(
                if let Some((copies, _)) = self.shared.place(mesh, shape, &self.frame) {
                    Part::Copies(copies)
                } else if let Some(alone) = loose.objects.get(&index) {
                    shared.push(Arc::clone(alone));
                    let before = &self.origin.objects[index].1.placement;
                    let way = Move::between_places(before, &shape.placement);
                    let place = way.map(|way| (*way.turn(), way.shift_in(&self.frame)));
                    // One that has come back is where it was.
                    let nowhere = || (ScaledRotation::new(DMat3::IDENTITY), DVec3::ZERO);
                    let (turn, translation) = place.unwrap_or_else(nowhere);
                    let copies = Copies {
                        structure: shared.len() - 1,
                        turn,
                        translations: vec![translation],
                    };
                    Part::Moved(copies, count)
                } else {
                    Part::Flat(count)
                },
            );
        }
        Some(Self {
            frame: self.frame,
            accelerator: Assembly::new(Arc::clone(&loose.flat), shared, parts),
            objects: self.objects.clone(),
            shared: self.shared.clone(),
            // No structure is what it would be built to be.
            origin: GeometryOrigin {
                structure: None,
                ..origin
            },
        })
    }
}
