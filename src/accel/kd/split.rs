//! Which plane to split a cell with, by the surface area heuristic.

use super::KdParameters;
use super::build::CHUNK;
use super::events::{Event, EventKind, Events};
use crate::math::Bounds;

/// A plane that splits a cell, and what the heuristic expects of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    pub axis: usize,
    pub position: f32,
    /// Which side the references lying in the plane go to.
    pub planar_goes_left: bool,
    /// Expected cost of a ray through the cell if it is split here, in the unit of [`KdParameters`].
    pub cost: f64,
}

impl Plane {
    /// The plane through the middle of the longest side of `cell`; `None` when the cell is a point.
    pub fn halving(cell: &Bounds) -> Option<Self> {
        let axis = cell.size().max_position();
        let position = cell.center()[axis];
        (cell.min[axis] < position && position < cell.max[axis]).then_some(Self {
            axis,
            position,
            planar_goes_left: true,
            cost: f64::INFINITY,
        })
    }
}

/// Expected cost of a ray through a leaf with this many references.
pub(super) fn leaf_cost(parameters: &KdParameters, references: usize) -> f64 {
    parameters.intersection_cost * references.div_ceil(super::LANES) as f64
}

/// The cheapest of all planes through the inside of `cell` at which one of its `count` references starts or ends; `None` when
/// there is none or the cell has no area. `events` are those of its references.
pub(super) fn best_plane(
    parameters: &KdParameters,
    events: &Events,
    count: usize,
    cell: &Bounds,
) -> Option<Plane> {
    let best_across = |axis: usize| {
        let candidates = Candidates::new(parameters, cell, axis)?;
        sweep(&events[axis], count, &candidates)
    };
    let planes: [Option<Plane>; 3] = if count > CHUNK {
        let (x, (y, z)) = rayon::join(
            || best_across(0),
            || rayon::join(|| best_across(1), || best_across(2)),
        );
        [x, y, z]
    } else {
        [0, 1, 2].map(best_across)
    };
    let cheaper = |a: Plane, b: Plane| if b.cost < a.cost { b } else { a };
    planes.into_iter().flatten().reduce(cheaper)
}

/// Counts along an axis how many references lie on each side of every plane.
fn sweep(events: &[Event], count: usize, candidates: &Candidates) -> Option<Plane> {
    let (mut left, mut right) = (0, count);
    let mut best = None;
    let mut rest = events.iter().copied().peekable();
    while let Some(&first) = rest.peek() {
        let position = first.position();
        if position >= candidates.end {
            break;
        }
        let [mut ends, mut planar, mut starts] = [0; 3];
        while let Some(event) = rest.next_if(|event| event.is_at_position_of(first)) {
            ends += usize::from(event.kind() == EventKind::End);
            planar += usize::from(event.kind() == EventKind::Planar);
            starts += usize::from(event.kind() == EventKind::Start);
        }
        right -= ends + planar;
        candidates.offer(&mut best, position, [left, planar, right]);
        left += starts + planar;
    }
    best
}

/// The planes across one axis of a cell, and their cost.
struct Candidates<'a> {
    parameters: &'a KdParameters,
    axis: usize,
    start: f32,
    end: f32,
    length: f64,
    /// The cell's half area is `cross_section + length · rim`.
    cross_section: f64,
    rim: f64,
    half_area: f64,
}

impl<'a> Candidates<'a> {
    /// `None` when the cell is flat across this axis or so small or thin that no ray has a chance to meet it.
    fn new(parameters: &'a KdParameters, cell: &Bounds, axis: usize) -> Option<Self> {
        let size = cell.max.as_dvec3() - cell.min.as_dvec3();
        let (length, a, b) = (size[axis], size[(axis + 1) % 3], size[(axis + 2) % 3]);
        let (cross_section, rim) = (a * b, a + b);
        let half_area = cross_section + length * rim;
        (length > 0.0 && half_area > 0.0).then_some(Self {
            parameters,
            axis,
            start: cell.min[axis],
            end: cell.max[axis],
            length,
            cross_section,
            rim,
            half_area,
        })
    }

    /// Replaces `best` by the plane at `position` if that lies inside and costs less. `counts`: references to the left
    /// of it or across, in it, to the right or across.
    fn offer(&self, best: &mut Option<Plane>, position: f32, [left, planar, right]: [usize; 3]) {
        if !(self.start < position && position < self.end) {
            return;
        }
        let before = f64::from(position) - f64::from(self.start);
        let p_left = (self.cross_section + before * self.rim) / self.half_area;
        let p_right = (self.cross_section + (self.length - before) * self.rim) / self.half_area;
        let cost = |left: usize, right: usize| {
            let children = p_left * leaf_cost(self.parameters, left)
                + p_right * leaf_cost(self.parameters, right);
            let bonus = if left == 0 || right == 0 {
                1.0 - self.parameters.empty_bonus
            } else {
                1.0
            };
            self.parameters.traversal_cost + bonus * children
        };
        let if_left = cost(left + planar, right);
        let if_right = if planar == 0 {
            if_left
        } else {
            cost(left, right + planar)
        };
        let planar_goes_left = if_left <= if_right;
        let cost = if_left.min(if_right);
        if best.is_none_or(|best| cost < best.cost) {
            *best = Some(Plane {
                axis: self.axis,
                position,
                planar_goes_left,
                cost,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::kd::build::Reference;
    use crate::accel::kd::events::sorted;
    use crate::control::CancelToken;
    use crate::geometry::shapes::Random;
    use crate::math::Vec3;

    const CELL: Bounds = Bounds {
        min: Vec3::NEG_ONE,
        max: Vec3::ONE,
    };

    /// Boxes on a lattice, so that starts, ends and flat boxes coincide.
    fn lattice_boxes(count: u32, random: &mut Random) -> Vec<Reference> {
        let mut corner = || (random.in_cube() * 4.0).round().as_vec3() / 4.0;
        let boxes = (0..count).map(|triangle| Reference {
            bounds: Bounds::of_points([corner(), corner()]),
            triangle,
        });
        boxes.collect()
    }

    /// Counts by looking at every box, and looks at every plane.
    fn least_cost(references: &[Reference], parameters: &KdParameters) -> f64 {
        let mut best = None;
        for axis in 0..3 {
            let candidates = Candidates::new(parameters, &CELL, axis).unwrap();
            for plane in references.iter().flat_map(|r| [r.bounds.min, r.bounds.max]) {
                let position = plane[axis];
                let mut counts = [0; 3];
                for Reference { bounds, .. } in references {
                    counts[0] += usize::from(bounds.min[axis] < position);
                    counts[1] +=
                        usize::from(bounds.min[axis] >= position && bounds.max[axis] <= position);
                    counts[2] += usize::from(bounds.max[axis] > position);
                }
                candidates.offer(&mut best, position, counts);
            }
        }
        best.expect("there is a plane inside").cost
    }

    #[test]
    fn the_sweep_finds_the_cheapest_plane() {
        let parameters = KdParameters::default();
        let mut random = Random::new(1);
        for _ in 0..200 {
            let references = lattice_boxes(60, &mut random);
            let events = sorted(&references, &CancelToken::new());
            let found = best_plane(&parameters, &events, references.len(), &CELL).unwrap();
            let expected = least_cost(&references, &parameters);
            assert!(
                (found.cost - expected).abs() < 1e-12,
                "{found:?}, {expected}"
            );
        }
    }

    #[test]
    fn flat_cells_are_not_split_across() {
        let flat = Bounds {
            max: CELL.max.with_z(-1.0),
            ..CELL
        };
        let parameters = KdParameters::default();
        assert!(Candidates::new(&parameters, &flat, 2).is_none());
        assert!(Candidates::new(&parameters, &flat, 0).is_some());
        assert!(Plane::halving(&Bounds::of_points([Vec3::ONE])).is_none());
    }
}
