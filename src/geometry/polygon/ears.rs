//! Ear clipping: while more than three corners are left, one whose triangle lies inside the polygon is cut off.
//!
//! Only corners that do not turn left can lie in an ear, and an ear only comes or goes when a neighbour is cut; so each
//! cut asks twice, and each question costs a search in a tree. Source of the method: Meisters, Polygons Have Ears,
//! American Mathematical Monthly 82, 1975; Everett et al., Slicing an Ear Using Prune-and-Search, 1993.

use super::blockers::Blockers;
use super::orientation::orientation;
use super::{Triangulation, corners_of, goes_up};
use crate::math::DVec2;
use std::collections::VecDeque;

/// Cuts a polygon of at least three corners, counter-clockwise as a whole.
pub(super) fn cut(points: &[DVec2]) -> Triangulation {
    let mut clipper = Clipper::new(points);
    clipper.look_at_spikes_first();
    clipper.crosses_itself = turns(points).is_some_and(|turns| turns != 1);
    for _ in 3..points.len() {
        let tip = clipper.choose();
        clipper.clip(tip);
    }
    clipper.last_triangle()
}

/// How often the polygon turns around, counter-clockwise; `None` where it turns back on itself or stands still.
fn turns(points: &[DVec2]) -> Option<i32> {
    // The direction passes that of +X where it leaves the lower half plane to the left or the upper one to the right.
    let mut turns = 0;
    for [a, b, c] in corners_of(points) {
        let turn = orientation(a, b, c);
        match (goes_up(a, b), goes_up(b, c)) {
            _ if turn == 0.0 && is_spike(a, b, c) => return None,
            (false, true) if turn > 0.0 => turns += 1,
            (true, false) if turn < 0.0 => turns -= 1,
            _ => {}
        }
    }
    Some(turns)
}

/// Whether the way over `b`, which lies on the line of `a` and `c`, does not lead on: it turns back or stands still.
fn is_spike(a: DVec2, b: DVec2, c: DVec2) -> bool {
    a == b || b == c || goes_up(a, b) != goes_up(b, c)
}

/// What a corner is at the moment.
enum Kind {
    /// Its triangle can be cut off; or it has none, as the corner is the tip of a spike.
    Ear,
    /// It turns left, but another corner is in the way.
    Blocked,
    /// It lies on a straight edge.
    Flat,
    /// It turns right.
    Reflex,
}

/// A corner to look at, unless its neighbours have changed since.
#[derive(Clone, Copy)]
struct Candidate {
    corner: u32,
    changes: u32,
}

/// The part of the polygon that is left, as a ring, and the corners sorted by what they were last seen to be.
struct Clipper<'a> {
    points: &'a [DVec2],
    previous: Vec<u32>,
    next: Vec<u32>,
    /// How often the neighbours of a corner, or whether it is there at all, have changed.
    changes: Vec<u32>,
    blockers: Blockers,
    unseen: VecDeque<Candidate>,
    blocked: VecDeque<Candidate>,
    flat: VecDeque<Candidate>,
    reflex: VecDeque<Candidate>,
    /// The number of triangles when the blocked corners were last seen.
    triangles_at_review: usize,
    triangles: Vec<[u32; 3]>,
    crosses_itself: bool,
}

impl<'a> Clipper<'a> {
    fn new(points: &'a [DVec2]) -> Self {
        let count = u32::try_from(points.len()).expect("corners have u32 numbers");
        let turns_left: Vec<bool> = corners_of(points)
            .map(|[a, b, c]| orientation(a, b, c) > 0.0)
            .collect();
        let mut blockers = Blockers::new(points, |corner| !turns_left[corner as usize]);
        for (corner, [before, _, after]) in (0..).zip(corners_of(points)) {
            blockers.connect(corner, [before, after]);
        }
        Self {
            points,
            previous: (0..count).map(|i| (i + count - 1) % count).collect(),
            next: (0..count).map(|i| (i + 1) % count).collect(),
            changes: vec![0; points.len()],
            blockers,
            unseen: (0..count)
                .map(|corner| Candidate { corner, changes: 0 })
                .collect(),
            blocked: VecDeque::new(),
            flat: VecDeque::new(),
            reflex: VecDeque::new(),
            triangles_at_review: 0,
            triangles: Vec::with_capacity(points.len() - 2),
            crosses_itself: false,
        }
    }

    /// The corner to cut off next: an ear; without one, a corner that takes no area with it; without one, any.
    fn choose(&mut self) -> u32 {
        if let Some(ear) = self.find_ear() {
            return ear;
        }
        // Where the polygon touches itself, the corner in the way may be gone by now. Looking again only after enough
        // cuts keeps all looks together proportional to the number of corners.
        if 4 * (self.triangles.len() - self.triangles_at_review) >= self.blocked.len() {
            self.triangles_at_review = self.triangles.len();
            self.unseen.append(&mut self.blocked);
            if let Some(ear) = self.find_ear() {
                return ear;
            }
        }
        if let Some(tip) = take(&mut self.flat, &self.changes) {
            return tip;
        }
        // A simple polygon always has an ear.
        self.crosses_itself = true;
        take(&mut self.blocked, &self.changes)
            .or_else(|| take(&mut self.reflex, &self.changes))
            .expect("every corner left waits in one of the queues")
    }

    /// Sorts corners whose neighbours have changed until one is an ear.
    fn find_ear(&mut self) -> Option<u32> {
        while let Some(candidate) = self.unseen.pop_front() {
            let corner = candidate.corner;
            if candidate.changes != self.changes[corner as usize] {
                continue;
            }
            match self.kind(corner) {
                Kind::Ear => return Some(corner),
                Kind::Blocked => self.blocked.push_back(candidate),
                Kind::Flat => self.flat.push_back(candidate),
                Kind::Reflex => self.reflex.push_back(candidate),
            }
        }
        None
    }

    fn kind(&self, corner: u32) -> Kind {
        let triangle = self.triangle_points(corner);
        let [a, b, c] = triangle;
        let turn = orientation(a, b, c);
        if turn < 0.0 {
            return Kind::Reflex;
        }
        if turn == 0.0 {
            return if is_spike(a, b, c) {
                Kind::Ear
            } else {
                Kind::Flat
            };
        }
        if self.blockers.any_in(triangle) {
            Kind::Blocked
        } else {
            Kind::Ear
        }
    }

    fn is_spike(&self, corner: u32) -> bool {
        let [a, b, c] = self.triangle_points(corner);
        orientation(a, b, c) == 0.0 && is_spike(a, b, c)
    }

    /// Spikes hold no area, but make what is next to them look like ears.
    fn look_at_spikes_first(&mut self) {
        let mut unseen = std::mem::take(&mut self.unseen);
        unseen
            .make_contiguous()
            .sort_by_key(|candidate| !self.is_spike(candidate.corner));
        self.unseen = unseen;
    }

    fn triangle_points(&self, corner: u32) -> [DVec2; 3] {
        self.triangle(corner)
            .map(|corner| self.points[corner as usize])
    }

    /// A corner between its neighbours.
    fn triangle(&self, corner: u32) -> [u32; 3] {
        let place = corner as usize;
        [self.previous[place], corner, self.next[place]]
    }

    /// Cuts off a corner; its neighbours go to the end of the queue, which keeps triangles fat, unless they are spikes.
    fn clip(&mut self, tip: u32) {
        let [before, _, after] = self.triangle(tip);
        self.triangles.push([before, tip, after]);
        for corner in [before, tip, after] {
            let [a, _, c] = self.triangle_points(corner);
            self.blockers.disconnect(corner, [a, c]);
        }
        self.next[before as usize] = after;
        self.previous[after as usize] = before;
        self.changes[tip as usize] += 1;
        self.blockers.remove(tip);
        for corner in [before, after] {
            let [a, b, c] = self.triangle_points(corner);
            if orientation(a, b, c) > 0.0 {
                self.blockers.remove(corner);
            } else {
                self.blockers.connect(corner, [a, c]);
            }
            self.changes[corner as usize] += 1;
            let changes = self.changes[corner as usize];
            let candidate = Candidate { corner, changes };
            if self.is_spike(corner) {
                self.unseen.push_front(candidate);
            } else {
                self.unseen.push_back(candidate);
            }
        }
    }

    /// Ends with the three corners that are left.
    fn last_triangle(mut self) -> Triangulation {
        let corner = take(&mut self.unseen, &self.changes)
            .or_else(|| take(&mut self.blocked, &self.changes))
            .or_else(|| take(&mut self.flat, &self.changes))
            .or_else(|| take(&mut self.reflex, &self.changes))
            .expect("three corners are left");
        self.crosses_itself |= matches!(self.kind(corner), Kind::Reflex);
        self.triangles.push(self.triangle(corner));
        Triangulation {
            triangles: self.triangles,
            crosses_itself: self.crosses_itself,
        }
    }
}

/// The first corner of a queue that is still as it was when it came in.
fn take(queue: &mut VecDeque<Candidate>, changes: &[u32]) -> Option<u32> {
    while let Some(candidate) = queue.pop_front() {
        if candidate.changes == changes[candidate.corner as usize] {
            return Some(candidate.corner);
        }
    }
    None
}
