//! Trees with only some of their triangles left, made by leaving lanes of leaves empty: far quicker than building. The boxes stay as they
//! were, so rays take longer than in a tree that was built for what is left.

use std::ops::Range;

use super::{TriangleBlock, WideTree};
use crate::accel::simd::{LANES, Lanes};
use crate::math::Bounds;
use rayon::prelude::*;

impl WideTree {
    /// The same tree, in which no ray meets the triangles `ids`. They are still counted, so the others keep their ids.
    #[must_use]
    pub fn without(&self, ids: &Range<u32>) -> Self {
        let mut tree = self.clone();
        tree.blocks
            .par_iter_mut()
            .for_each(|block| block.keep(|id| (!ids.contains(&id)).then_some(id)));
        tree
    }

    /// The triangles `ids` alone, numbered from 0.
    ///
    /// # Panics
    /// When there are not so many triangles.
    #[must_use]
    pub fn only(&self, ids: &Range<u32>) -> Self {
        let mut blocks = self.blocks.clone();
        blocks.par_iter_mut().for_each(|block| {
            block.keep(|id| ids.contains(&id).then(|| id - ids.start));
        });
        let mut tree = Self {
            places: self.places[ids.start as usize..ids.end as usize].to_vec(),
            bounds: Bounds::EMPTY,
            reach: self.reach,
            root: self.root,
            nodes: self.nodes.clone(),
            blocks,
        };
        let corners = (0..ids.len()).flat_map(|id| tree.triangle(id).corners);
        tree.bounds = Bounds::of_points(corners);
        tree
    }
}

impl TriangleBlock {
    /// Keeps the triangles to which `number` gives an id, under that id.
    fn keep(&mut self, number: impl Fn(u32) -> Option<u32>) {
        for lane in 0..LANES {
            let id = self.ids[lane];
            if id == Self::NO_TRIANGLE {
                continue;
            }
            let kept = number(id);
            self.ids[lane] = kept.unwrap_or(Self::NO_TRIANGLE);
            if kept.is_none() {
                let axes = self.corners.as_flattened_mut();
                for Lanes(values) in axes {
                    values[lane] = f32::NAN;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::accel::BruteForce;
    use crate::accel::tests::{bits, rays, scenes, wide_tree};
    use crate::geometry::Triangle;
    use crate::math::Vec3;

    #[test]
    fn what_is_left_out_is_met_by_no_ray_and_the_rest_as_by_brute_force() {
        let nothing = Triangle {
            corners: [Vec3::splat(f32::NAN); 3],
        };
        for (name, triangles) in scenes() {
            let tree = wide_tree(&triangles);
            let count = u32::try_from(triangles.len()).unwrap();
            for ids in [0..0, 0..count, count / 3..count / 2, count / 2..count] {
                let range = ids.start as usize..ids.end as usize;
                let mut others = triangles.clone();
                others[range.clone()].fill(nothing);
                let others = BruteForce::new(others);
                let (without, only) = (tree.without(&ids), tree.only(&ids));
                assert_eq!(without.triangle_count(), triangles.len());
                assert_eq!(only.triangle_count(), range.len());
                let alone = BruteForce::new(triangles[range].to_vec());
                assert_eq!(only.bounds(), alone.bounds(), "{name}");
                for ray in rays(&triangles, 7).iter().step_by(61) {
                    let end = f32::INFINITY;
                    assert_eq!(
                        bits(without.intersect(ray, end)),
                        bits(others.intersect(ray, end)),
                        "{name}, without {ids:?}"
                    );
                    assert_eq!(
                        bits(only.intersect(ray, end)),
                        bits(alone.intersect(ray, end)),
                        "{name}, only {ids:?}"
                    );
                }
            }
        }
    }
}
