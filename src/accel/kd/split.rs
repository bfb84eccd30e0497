//! Which plane to split a cell with, by the surface area heuristic.

use super::KdParameters;
use super::build::{CHUNK, Reference};
use crate::control::CancelToken;
use crate::math::Bounds;
use rayon::prelude::*;

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

/// Finds planes; holds the buffers it sorts in.
pub(super) struct Splitter<'a> {
    parameters: &'a KdParameters,
    cancel: &'a CancelToken,
    starts: Vec<f32>,
    ends: Vec<f32>,
    planars: Vec<f32>,
}

impl<'a> Splitter<'a> {
    pub fn new(parameters: &'a KdParameters, cancel: &'a CancelToken) -> Self {
        Self {
            parameters,
            cancel,
            starts: Vec::new(),
            ends: Vec::new(),
            planars: Vec::new(),
        }
    }

    /// The cheapest plane through the inside of `cell`; `None` when it has none or no area.
    pub fn best_plane(&mut self, references: &[Reference], cell: &Bounds) -> Option<Plane> {
        let mut best: Option<Plane> = None;
        for axis in 0..3 {
            let Some(candidates) = Candidates::new(self.parameters, cell, axis) else {
                continue;
            };
            let found = if references.len() <= self.parameters.exact_limit {
                self.sweep(references, &candidates)
            } else {
                bins(references, &candidates, self.cancel)
            };
            if let Some(found) = found
                && best.is_none_or(|best| found.cost < best.cost)
            {
                best = Some(found);
            }
        }
        best
    }

    /// The exact search: every plane at which some reference starts or ends.
    fn sweep(&mut self, references: &[Reference], candidates: &Candidates) -> Option<Plane> {
        self.starts.clear();
        self.ends.clear();
        self.planars.clear();
        for reference in references {
            let start = reference.bounds.min[candidates.axis];
            let end = reference.bounds.max[candidates.axis];
            if start < end {
                self.starts.push(start);
                self.ends.push(end);
            } else {
                self.planars.push(start);
            }
        }
        for list in [&mut self.starts, &mut self.ends, &mut self.planars] {
            list.sort_unstable_by(f32::total_cmp);
        }

        let mut starts = Cursor(&self.starts);
        let mut ends = Cursor(&self.ends);
        let mut planars = Cursor(&self.planars);
        let (mut left, mut right) = (0, references.len());
        let mut best = None;
        loop {
            let position = starts.next().min(ends.next()).min(planars.next());
            if position >= candidates.end {
                return best;
            }
            let planar = planars.pass(position);
            right -= ends.pass(position) + planar;
            candidates.offer(&mut best, position, [left, planar, right]);
            left += starts.pass(position) + planar;
        }
    }
}

/// What is left of a sorted list.
struct Cursor<'a>(&'a [f32]);

impl Cursor<'_> {
    /// The next value; infinity at the end.
    fn next(&self) -> f32 {
        self.0.first().copied().unwrap_or(f32::INFINITY)
    }

    /// Moves past all values equal to `position`, which are the next ones, and counts them.
    fn pass(&mut self, position: f32) -> usize {
        let count = self
            .0
            .iter()
            .take_while(|&&value| value <= position)
            .count();
        self.0 = &self.0[count..];
        count
    }
}

/// The approximate search for many references: equally spaced planes.
///
/// Counts of starts and ends per bin say how many references lie on each side, up to those that touch a plane. Once
/// cancelled, any plane will do.
fn bins(references: &[Reference], candidates: &Candidates, cancel: &CancelToken) -> Option<Plane> {
    #[expect(clippy::cast_possible_truncation, reason = "a position among 64 bins")]
    let bins_per_length = (BINS as f64 / candidates.length) as f32;
    let bin = |x: f32| {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "saturates, then is clamped"
        )]
        let index = ((x - candidates.start) * bins_per_length) as usize;
        index.min(BINS - 1)
    };
    let count = |chunk: &[Reference]| {
        let mut counts = Counts::default();
        if cancel.is_cancelled() {
            return counts;
        }
        for reference in chunk {
            counts.starts[bin(reference.bounds.min[candidates.axis])] += 1;
            counts.ends[bin(reference.bounds.max[candidates.axis])] += 1;
        }
        counts
    };
    let counts = references
        .par_chunks(CHUNK)
        .map(count)
        .reduce(Counts::default, Counts::add);
    let (mut left, mut right) = (0, references.len());
    let mut best = None;
    for k in 1..BINS {
        left += counts.starts[k - 1];
        right -= counts.ends[k - 1];
        #[expect(
            clippy::cast_possible_truncation,
            reason = "any position inside will do"
        )]
        let position =
            (f64::from(candidates.start) + candidates.length * (k as f64 / BINS as f64)) as f32;
        candidates.offer(&mut best, position, [left, 0, right]);
    }
    best
}

const BINS: usize = 64;

#[derive(Clone, Copy)]
struct Counts {
    starts: [usize; BINS],
    ends: [usize; BINS],
}

impl Default for Counts {
    fn default() -> Self {
        Self {
            starts: [0; BINS],
            ends: [0; BINS],
        }
    }
}

impl Counts {
    fn add(mut self, other: Self) -> Self {
        for i in 0..BINS {
            self.starts[i] += other.starts[i];
            self.ends[i] += other.ends[i];
        }
        self
    }
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
        let (if_left, if_right) = (cost(left + planar, right), cost(left, right + planar));
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
    use crate::geometry::shapes::Random;
    use crate::math::{DVec3, Vec3};

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
        let (parameters, cancel) = (KdParameters::default(), CancelToken::new());
        let mut splitter = Splitter::new(&parameters, &cancel);
        let mut random = Random::new(1);
        for _ in 0..200 {
            let references = lattice_boxes(60, &mut random);
            let found = splitter.best_plane(&references, &CELL).unwrap();
            let expected = least_cost(&references, &parameters);
            assert!(
                (found.cost - expected).abs() < 1e-12,
                "{found:?}, {expected}"
            );
        }
    }

    #[test]
    fn bins_come_close_to_the_cheapest_plane() {
        let exact = KdParameters::default();
        let binned = KdParameters {
            exact_limit: 0,
            ..exact
        };
        let cancel = CancelToken::new();
        let mut random = Random::new(2);
        let references: Vec<_> = (0..900)
            .map(|triangle| {
                let middle = random.in_cube() * 0.95;
                let half = random.in_cube() * 0.05;
                Reference {
                    bounds: Bounds::of_points([middle + half, middle - half].map(DVec3::as_vec3)),
                    triangle,
                }
            })
            .collect();
        let cost = |parameters| {
            let plane = Splitter::new(parameters, &cancel).best_plane(&references, &CELL);
            plane.unwrap().cost
        };
        assert!(cost(&binned) >= cost(&exact));
        assert!(cost(&binned) < 1.05 * cost(&exact));
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
