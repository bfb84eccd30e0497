//! Which ears of a polygon cannot be cut off, because a corner lies in them: a search in a kd-tree over the corners that are left.

use super::orientation::orientation;
use super::spokes::Spokes;
use crate::math::DVec2;
use std::ops::Range;

/// The corners that may lie inside somebody's ear, found by place.
///
/// A balanced kd-tree without pointers: the node of a range of `places` is its middle, its children the halves. Corners are
/// only ever removed; `occupied` lets a search pass by what is gone. Corners that share a point share a place, so that
/// a search looks at them once however many they are.
pub(super) struct Blockers {
    places: Vec<Place>,
    /// Where in `places` each corner is; [`GONE`] for those that block nothing, or no more.
    place_of: Vec<u32>,
    bounds: Area,
}

/// A point at which corners blocked when the polygon was whole.
struct Place {
    point: DVec2,
    /// How many corners here still block.
    corners: u32,
    /// How many places in the range of this node have corners that still block.
    occupied: u32,
    /// The edges of the corners that still block, where there are other corners here whose ears they may lead into.
    spokes: Option<Spokes>,
}

const GONE: u32 = u32::MAX;

#[cfg(test)]
thread_local! {
    /// How many nodes searches have come to.
    pub(super) static VISITS: std::cell::Cell<usize> = const { std::cell::Cell::new(0) };
}

/// An axis-aligned rectangle.
#[derive(Clone, Copy)]
struct Area {
    min: DVec2,
    max: DVec2,
}

impl Blockers {
    /// The corners of a whole polygon that `blocks` picks, without their edges: those are to be [connected](Self::connect).
    pub(super) fn new(points: &[DVec2], blocks: impl Fn(u32) -> bool) -> Self {
        let count = u32::try_from(points.len()).expect("corners have u32 numbers");
        let point = |corner: u32| points[corner as usize];
        let mut by_point: Vec<u32> = (0..count).collect();
        by_point.sort_unstable_by(|&a, &b| {
            let order = point(a).to_array().partial_cmp(&point(b).to_array());
            order.expect("points are finite").then(a.cmp(&b))
        });
        let mut groups: Vec<&[u32]> = by_point
            .chunk_by(|&a, &b| point(a) == point(b))
            .filter(|corners| corners.iter().any(|&corner| blocks(corner)))
            .collect();
        let mut occupied = vec![0; groups.len()];
        arrange(&mut groups, &mut occupied, 0, &|corners| point(corners[0]));

        let mut place_of = vec![GONE; points.len()];
        let mut places = Vec::with_capacity(groups.len());
        for (place, (group, occupied)) in (0..).zip(groups.into_iter().zip(occupied)) {
            let mut corners = 0;
            for &corner in group.iter().filter(|&&corner| blocks(corner)) {
                place_of[corner as usize] = place;
                corners += 1;
            }
            places.push(Place {
                point: point(group[0]),
                corners,
                occupied,
                spokes: (group.len() > 1).then(Spokes::default),
            });
        }
        Self {
            places,
            place_of,
            bounds: Area {
                min: points.iter().copied().fold(DVec2::INFINITY, DVec2::min),
                max: points.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max),
            },
        }
    }

    /// Says where the edges of a corner lead; nothing happens if it does not block.
    pub(super) fn connect(&mut self, corner: u32, ends: [DVec2; 2]) {
        if let Some((hub, spokes)) = self.spokes(corner) {
            spokes.insert(corner, hub, ends);
        }
    }

    /// Takes edges out that [`connect`](Self::connect) put in.
    pub(super) fn disconnect(&mut self, corner: u32, ends: [DVec2; 2]) {
        if let Some((hub, spokes)) = self.spokes(corner) {
            spokes.remove(corner, hub, ends);
        }
    }

    fn spokes(&mut self, corner: u32) -> Option<(DVec2, &mut Spokes)> {
        let place = self
            .places
            .get_mut(self.place_of[corner as usize] as usize)?;
        Some((place.point, place.spokes.as_mut()?))
    }

    /// Takes a corner out, which must not be connected; nothing happens if it is not in.
    pub(super) fn remove(&mut self, corner: u32) {
        let place = std::mem::replace(&mut self.place_of[corner as usize], GONE) as usize;
        let Some(here) = self.places.get_mut(place) else {
            return;
        };
        here.corners -= 1;
        if here.corners > 0 {
            return;
        }
        let (mut start, mut end) = (0, self.places.len());
        loop {
            let middle = usize::midpoint(start, end);
            self.places[middle].occupied -= 1;
            match place.cmp(&middle) {
                std::cmp::Ordering::Less => end = middle,
                std::cmp::Ordering::Equal => return,
                std::cmp::Ordering::Greater => start = middle + 1,
            }
        }
    }

    /// Whether a corner that is still in blocks the ear with these points, counter-clockwise, its tip in the middle.
    ///
    /// It does if it lies inside or on the border. One that coincides with the tip blocks if one of its edges leads
    /// between those of the tip; one that coincides with another point does not: if it led into the ear, so would the
    /// next corner that turns right.
    pub(super) fn any_in(&self, ear: [DVec2; 3]) -> bool {
        self.any_in_range(ear, 0..self.places.len(), self.bounds, 0)
    }

    fn any_in_range(&self, ear: [DVec2; 3], range: Range<usize>, area: Area, axis: usize) -> bool {
        #[cfg(test)]
        VISITS.set(VISITS.get() + 1);
        if range.is_empty() {
            return false;
        }
        let middle = usize::midpoint(range.start, range.end);
        let place = &self.places[middle];
        if place.occupied == 0 || area.misses(ear) {
            return false;
        }
        if place.blocks(ear) {
            return true;
        }
        let (mut below, mut above) = (area, area);
        below.max[axis] = place.point[axis];
        above.min[axis] = place.point[axis];
        self.any_in_range(ear, range.start..middle, below, 1 - axis)
            || self.any_in_range(ear, middle + 1..range.end, above, 1 - axis)
    }
}

impl Place {
    fn blocks(&self, ear: [DVec2; 3]) -> bool {
        let [before, tip, after] = ear;
        if self.corners == 0 || self.point == before || self.point == after {
            false
        } else if self.point == tip {
            let spokes = self.spokes.as_ref();
            spokes.is_some_and(|spokes| spokes.any_between(ear))
        } else {
            is_inside(ear, self.point)
        }
    }
}

/// Sorts corners, grouped by their point, into a kd-tree and counts what is below each node.
fn arrange<'a>(
    groups: &mut [&'a [u32]],
    counts: &mut [u32],
    axis: usize,
    point: &impl Fn(&'a [u32]) -> DVec2,
) {
    if groups.is_empty() {
        return;
    }
    let middle = groups.len() / 2;
    groups.select_nth_unstable_by(middle, |&a, &b| {
        let order = point(a)[axis].total_cmp(&point(b)[axis]);
        order.then(a[0].cmp(&b[0]))
    });
    counts[middle] = u32::try_from(groups.len()).expect("corners have u32 numbers");
    let (below, above) = groups.split_at_mut(middle);
    let (counts_below, counts_above) = counts.split_at_mut(middle);
    arrange(below, counts_below, 1 - axis, point);
    arrange(&mut above[1..], &mut counts_above[1..], 1 - axis, point);
}

fn is_inside([a, b, c]: [DVec2; 3], point: DVec2) -> bool {
    orientation(a, b, point) >= 0.0
        && orientation(b, c, point) >= 0.0
        && orientation(c, a, point) >= 0.0
}

impl Area {
    /// Whether it lies beyond one side of the triangle, or of the triangle's box. Exact, as a corner on the border counts.
    fn misses(self, [a, b, c]: [DVec2; 3]) -> bool {
        let (min, max) = (a.min(b).min(c), a.max(b).max(c));
        self.max.cmplt(min).any()
            || self.min.cmpgt(max).any()
            || [(a, b), (b, c), (c, a)].iter().any(|&(from, to)| {
                // The corner furthest to the left of the side.
                let x = if to.y < from.y {
                    self.max.x
                } else {
                    self.min.x
                };
                let y = if to.x > from.x {
                    self.max.y
                } else {
                    self.min.y
                };
                orientation(from, to, DVec2::new(x, y)) < 0.0
            })
    }
}
