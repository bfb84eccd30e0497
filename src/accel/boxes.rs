//! The boxes of a structure, one level at a time: to look at.

use super::{Accelerator, Assembly};
use crate::math::{Bounds, DBounds};

/// The boxes of one level.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LevelBoxes {
    /// In the prepared scene.
    pub boxes: Vec<Bounds>,
    /// Whether there are more than were asked for.
    pub is_cut: bool,
}

/// A part of a tree on the way down.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell<N> {
    /// The node.
    pub node: N,
    /// Its box.
    pub bounds: Bounds,
}

/// Goes down `depth` levels from `root`, and gathers the boxes of that level, and those above it that hold triangles and are not
/// divided further; at most `most` of them. `divide` gives the parts of a node, or `None` and whether it holds triangles.
pub(super) fn gather<N: Copy>(
    root: Cell<N>,
    (depth, most): (u32, usize),
    mut divide: impl FnMut(&Cell<N>, &mut Vec<Cell<N>>) -> Division,
) -> LevelBoxes {
    let mut found = LevelBoxes::default();
    let mut open = vec![(root, 0)];
    let mut parts = Vec::new();
    while let Some((cell, level)) = open.pop() {
        parts.clear();
        let division = divide(&cell, &mut parts);
        if division == Division::Empty || cell.bounds.is_empty() {
            continue;
        }
        if level < depth && division == Division::Divided {
            open.extend(parts.iter().map(|&part| (part, level + 1)));
        } else if found.boxes.len() == most {
            found.is_cut = true;
            break;
        } else {
            found.boxes.push(cell.bounds);
        }
    }
    found
}

/// What a node turns out to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Division {
    /// It has parts.
    Divided,
    /// It holds triangles.
    Whole,
    /// It holds nothing.
    Empty,
}

impl Accelerator {
    /// The boxes `depth` levels below the box around everything, and those above that are not divided so often; at most `most`.
    #[must_use]
    pub fn boxes_at(&self, depth: u32, most: usize) -> LevelBoxes {
        match self {
            Self::Wide(tree) => tree.boxes_at(depth, most),
            Self::KdTree(tree) => tree.boxes_at(depth, most),
            Self::BruteForce(all) => {
                let bounds = all.bounds();
                let boxes = (!bounds.is_empty()).then_some(bounds);
                LevelBoxes {
                    boxes: boxes.into_iter().take(most).collect(),
                    is_cut: false,
                }
            }
        }
    }
}

impl Assembly {
    /// [`Accelerator::boxes_at`] of what occurs once, and the boxes of placed copies, which are not divided here.
    #[must_use]
    pub fn boxes_at(&self, depth: u32, most: usize) -> LevelBoxes {
        let mut found = self.flat().boxes_at(depth, most);
        for bounds in self.copy_boxes() {
            if found.boxes.len() == most {
                found.is_cut = true;
                break;
            }
            found.boxes.push(bounds);
        }
        found
    }
}

/// The smallest box around both corners, rounded to nearest.
pub(super) fn narrowed(bounds: &DBounds) -> Bounds {
    Bounds {
        min: bounds.min.as_vec3(),
        max: bounds.max.as_vec3(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::{BruteForce, BuildQuality, KdParameters, KdTree, WideTree};
    use crate::control::{CancelToken, Progress};
    use crate::geometry::{Triangle, shapes};
    use crate::math::{DVec3, Vec3};

    fn triangles() -> Vec<Triangle> {
        let mesh = shapes::soup(3000, 0.1, 7);
        let corners = (0..mesh.triangles.len()).map(|index| mesh.corners(index));
        let narrowed = corners.map(|corners| Triangle {
            corners: corners.map(DVec3::as_vec3),
        });
        narrowed.collect()
    }

    fn structures(triangles: &[Triangle]) -> [Accelerator; 3] {
        let cancel = CancelToken::new();
        let wide =
            WideTree::build(triangles, BuildQuality::Best, &cancel, &Progress::new()).unwrap();
        let kd = KdTree::build(triangles, &KdParameters::default(), &cancel).unwrap();
        let all = BruteForce::new(triangles.to_vec());
        [
            Accelerator::Wide(wide),
            Accelerator::KdTree(kd),
            Accelerator::BruteForce(all),
        ]
    }

    fn volume(bounds: &Bounds) -> f64 {
        bounds.size().as_dvec3().element_product()
    }

    /// On every level the boxes hold all triangles, lie in the whole box, and those of the kd-tree share no space.
    #[test]
    fn the_boxes_of_every_level_hold_all_triangles() {
        let triangles = triangles();
        for structure in structures(&triangles) {
            let whole = structure.bounds();
            let mut before = 0;
            for depth in [0, 1, 2, 5, 60] {
                let found = structure.boxes_at(depth, usize::MAX);
                assert!(!found.is_cut);
                assert!(found.boxes.len() >= before);
                before = found.boxes.len();
                if depth == 0 {
                    assert_eq!(found.boxes, [whole]);
                }
                for triangle in &triangles {
                    let middle = triangle.corners.iter().sum::<Vec3>() / 3.0;
                    let mut boxes = found.boxes.iter();
                    assert!(boxes.any(|bounds| bounds.contains(middle)), "{depth}");
                }
                let volumes: f64 = found.boxes.iter().map(volume).sum();
                if matches!(structure, Accelerator::KdTree(_)) {
                    // Planes lie on `f32`, so that the sizes of two cells may add up to more than their box by a rounding each.
                    assert!(volumes <= volume(&whole) * (1.0 + 1e-6));
                }
            }
            let is_divided = !matches!(structure, Accelerator::BruteForce(_));
            assert_eq!(before > 1, is_divided);
        }
    }

    #[test]
    fn no_more_boxes_come_than_were_asked_for() {
        let triangles = triangles();
        let [wide, kd, all] = structures(&triangles);
        for structure in [wide, kd] {
            let found = structure.boxes_at(20, 10);
            assert_eq!((found.boxes.len(), found.is_cut), (10, true));
        }
        assert!(!all.boxes_at(20, 10).is_cut);
        for empty in structures(&[]) {
            assert!(empty.boxes_at(3, 10).boxes.is_empty());
        }
    }
}
