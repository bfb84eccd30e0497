use super::orientation::orientation;
use crate::math::DVec2;
use std::ops::Range;

/// The corners that may lie inside somebody's ear, found by place.
///
/// A balanced kd-tree without pointers: the node of a range of `order` is its middle, its children the halves. Corners are
/// only ever removed; `live` lets a search pass by what is gone.
pub(super) struct Blockers<'a> {
    points: &'a [DVec2],
    order: Vec<u32>,
    /// Corners left in the range of each node.
    live: Vec<u32>,
    /// Where each corner stands in `order`; [`GONE`] for those that block nothing, or no more.
    places: Vec<u32>,
    bounds: Area,
}

const GONE: u32 = u32::MAX;

/// An axis-aligned rectangle.
#[derive(Clone, Copy)]
struct Area {
    min: DVec2,
    max: DVec2,
}

impl<'a> Blockers<'a> {
    pub(super) fn new(points: &'a [DVec2], mut order: Vec<u32>) -> Self {
        let mut live = vec![0; order.len()];
        arrange(points, &mut order, &mut live, 0);
        let mut places = vec![GONE; points.len()];
        for (place, &corner) in (0..).zip(&order) {
            places[corner as usize] = place;
        }
        let bounds = Area {
            min: points.iter().copied().fold(DVec2::INFINITY, DVec2::min),
            max: points.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max),
        };
        Self {
            points,
            order,
            live,
            places,
            bounds,
        }
    }

    /// Takes a corner out; nothing happens if it is not in.
    pub(super) fn remove(&mut self, corner: u32) {
        let place = std::mem::replace(&mut self.places[corner as usize], GONE) as usize;
        if place == GONE as usize {
            return;
        }
        let (mut start, mut end) = (0, self.order.len());
        loop {
            let middle = usize::midpoint(start, end);
            self.live[middle] -= 1;
            match place.cmp(&middle) {
                std::cmp::Ordering::Less => end = middle,
                std::cmp::Ordering::Equal => return,
                std::cmp::Ordering::Greater => start = middle + 1,
            }
        }
    }

    /// Whether a corner that is still in blocks the ear with these points, counter-clockwise, its tip in the middle.
    ///
    /// It does if it lies inside or on the border. One that coincides with the tip blocks if `reaches_in` says so; one
    /// that coincides with another point does not: if it led into the ear, so would the next corner that turns right.
    pub(super) fn any_in(&self, ear: [DVec2; 3], reaches_in: impl Fn(u32) -> bool) -> bool {
        let blocks = |corner: u32| {
            let point = self.points[corner as usize];
            if point == ear[1] {
                reaches_in(corner)
            } else {
                point != ear[0] && point != ear[2] && is_inside(ear, point)
            }
        };
        self.any_in_range(ear, 0..self.order.len(), self.bounds, 0, &blocks)
    }

    fn any_in_range(
        &self,
        ear: [DVec2; 3],
        range: Range<usize>,
        area: Area,
        axis: usize,
        blocks: &impl Fn(u32) -> bool,
    ) -> bool {
        if range.is_empty() {
            return false;
        }
        let middle = usize::midpoint(range.start, range.end);
        if self.live[middle] == 0 || area.misses(ear) {
            return false;
        }
        let corner = self.order[middle];
        if self.places[corner as usize] != GONE && blocks(corner) {
            return true;
        }
        let split = self.points[corner as usize][axis];
        let (mut below, mut above) = (area, area);
        below.max[axis] = split;
        above.min[axis] = split;
        self.any_in_range(ear, range.start..middle, below, 1 - axis, blocks)
            || self.any_in_range(ear, middle + 1..range.end, above, 1 - axis, blocks)
    }
}

/// Sorts `order` into a kd-tree and counts what is below each node.
fn arrange(points: &[DVec2], order: &mut [u32], live: &mut [u32], axis: usize) {
    if order.is_empty() {
        return;
    }
    let middle = order.len() / 2;
    order.select_nth_unstable_by(middle, |&a, &b| {
        let [p, q] = [a, b].map(|corner| points[corner as usize][axis]);
        p.total_cmp(&q).then(a.cmp(&b))
    });
    live[middle] = u32::try_from(order.len()).expect("corners have u32 numbers");
    let (below, above) = order.split_at_mut(middle);
    let (live_below, live_above) = live.split_at_mut(middle);
    arrange(points, below, live_below, 1 - axis);
    arrange(points, &mut above[1..], &mut live_above[1..], 1 - axis);
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
