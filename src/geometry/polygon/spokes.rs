//! Where a polygon touches itself, several corners share a point, and only the directions of their edges tell which ears they block.

use super::goes_up;
use super::orientation::orientation;
use crate::math::DVec2;
use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::ops::Bound;

/// The edges that leave one point, sorted by where they lead, for points that several corners share.
#[derive(Clone, Default)]
pub(super) struct Spokes {
    spokes: BTreeSet<Spoke>,
}

/// An edge of positive length, as seen from one of its ends.
///
/// Those of one point are ordered counter-clockwise from the direction of +X, exactly unless a product underflows: then an edge may
/// stay that should go, and a polygon be cut as if it touched itself.
#[derive(Clone, Copy)]
struct Spoke {
    hub: DVec2,
    end: DVec2,
    /// Whose edge it is, which tells edges of one direction apart.
    corner: u32,
}

impl Spokes {
    /// Adds the edges of a corner at `hub` that lead to `ends`.
    pub(super) fn insert(&mut self, corner: u32, hub: DVec2, ends: [DVec2; 2]) {
        self.spokes.extend(spokes_of(corner, hub, ends));
    }

    pub(super) fn remove(&mut self, corner: u32, hub: DVec2, ends: [DVec2; 2]) {
        for spoke in spokes_of(corner, hub, ends) {
            self.spokes.remove(&spoke);
        }
    }

    /// Whether an edge leads between those of a corner that turns left, `a` to `hub` to `c`; along one of them does not count.
    pub(super) fn any_between(&self, [a, hub, c]: [DVec2; 3]) -> bool {
        let spoke = |end, corner| Spoke { hub, end, corner };
        // Corners have smaller numbers than the first bound and none smaller than the second.
        let (from, to) = (spoke(c, u32::MAX), spoke(a, 0));
        let any = |from, to| self.spokes.range((from, to)).next().is_some();
        if self.spokes.is_empty() {
            false
        } else if goes_up(hub, c) || !goes_up(hub, a) {
            // Where a product underflows, the order may be a little off.
            from < to && any(Bound::Excluded(from), Bound::Excluded(to))
        } else {
            any(Bound::Excluded(from), Bound::Unbounded)
                || any(Bound::Unbounded, Bound::Excluded(to))
        }
    }
}

fn spokes_of(corner: u32, hub: DVec2, ends: [DVec2; 2]) -> impl Iterator<Item = Spoke> {
    let leaves = move |end: &DVec2| *end != hub;
    let spoke = move |end| Spoke { hub, end, corner };
    ends.into_iter().filter(leaves).map(spoke)
}

impl Ord for Spoke {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_half = || goes_up(other.hub, other.end).cmp(&goes_up(self.hub, self.end));
        let by_turn = || {
            let turn = orientation(self.hub, self.end, other.end);
            0.0_f64.partial_cmp(&turn).unwrap_or(Ordering::Equal)
        };
        by_half()
            .then_with(by_turn)
            .then(self.corner.cmp(&other.corner))
    }
}

impl PartialOrd for Spoke {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Spoke {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Spoke {}
