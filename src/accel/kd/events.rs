//! Where the references of a cell start and end, in order along each axis.
//!
//! The order is made once, for the whole scene. When a cell is split, each side takes over its part of the lists as it
//! stands; only references that the plane cuts get new events, which are sorted and merged in. So a level of the tree
//! takes time in proportion to its references, and the whole tree `n log n`.
//!
//! Source: Wald, Havran, On building fast kd-trees for ray tracing, and on doing that in O(N log N), IEEE Symposium on
//! Interactive Ray Tracing, 2006.

use super::build::{CHUNK, Reference};
use crate::control::CancelToken;
use crate::math::Bounds;
use rayon::prelude::*;

/// What happens at a position, in the order in which a sweep counts it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum EventKind {
    End,
    /// Start and end of a reference that is flat across the axis.
    Planar,
    Start,
}

/// The start or end of a reference, in eight bytes whose order as a number is that of a sweep: by position, then kind, then
/// reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Event(u64);

impl Event {
    const KIND_SHIFT: u32 = 30;
    const REFERENCE: u64 = (1 << Self::KIND_SHIFT) - 1;
    const SIGN: u32 = 1 << 31;

    /// The event of the reference with that index in its cell, below 2³⁰.
    pub fn new(position: f32, kind: EventKind, reference: u32) -> Self {
        // Both zeros are one position. The bits of positive numbers are in order, those of negative ones in reverse.
        let bits = (position + 0.0).to_bits();
        let ordered = if bits & Self::SIGN == 0 {
            bits | Self::SIGN
        } else {
            !bits
        };
        let kind = (kind as u64) << Self::KIND_SHIFT;
        Self(u64::from(ordered) << 32 | kind | u64::from(reference))
    }

    #[inline]
    pub fn position(self) -> f32 {
        let ordered = (self.0 >> 32) as u32;
        f32::from_bits(if ordered & Self::SIGN == 0 {
            !ordered
        } else {
            ordered & !Self::SIGN
        })
    }

    #[inline]
    pub fn kind(self) -> EventKind {
        match self.0 >> Self::KIND_SHIFT & 3 {
            0 => EventKind::End,
            1 => EventKind::Planar,
            _ => EventKind::Start,
        }
    }

    #[inline]
    pub fn is_at_position_of(self, other: Self) -> bool {
        (self.0 ^ other.0) >> 32 == 0
    }

    #[inline]
    fn reference(self) -> usize {
        (self.0 & Self::REFERENCE) as usize
    }

    #[inline]
    fn of_reference(self, reference: u32) -> Self {
        Self(self.0 & !Self::REFERENCE | u64::from(reference))
    }
}

/// The events of a cell, in order, by axis.
pub(super) type Events = [Vec<Event>; 3];

/// The events of these references. Not meaningful when cancelled.
pub(super) fn sorted(references: &[Reference], cancel: &CancelToken) -> Events {
    [0, 1, 2].map(|axis| {
        if cancel.is_cancelled() {
            return Vec::new();
        }
        let mut events = Vec::with_capacity(2 * references.len());
        for (index, reference) in (0..).zip(references) {
            add(&mut events, &reference.bounds, axis, index);
        }
        events.par_sort_unstable();
        events
    })
}

/// Adds the events along `axis` of the reference with this index.
fn add(events: &mut Vec<Event>, bounds: &Bounds, axis: usize, index: u32) {
    let (start, end) = (bounds.min[axis], bounds.max[axis]);
    if start < end {
        events.push(Event::new(start, EventKind::Start, index));
        events.push(Event::new(end, EventKind::End, index));
    } else {
        events.push(Event::new(start, EventKind::Planar, index));
    }
}

/// What becomes of a reference when its cell is split.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fate(u32);

impl Fate {
    /// Its events are of no more use.
    pub const CUT: Self = Self(2);

    /// It goes to the left or to the right as it is, with a new index there.
    pub fn whole(is_right: bool, index: u32) -> Self {
        Self(index << 2 | u32::from(is_right))
    }

    /// The same with other references put before those of each side.
    pub fn behind(self, [left, right]: [u32; 2]) -> Self {
        match self.0 & 3 {
            0 => Self(self.0 + (left << 2)),
            1 => Self(self.0 + (right << 2)),
            _ => self,
        }
    }
}

/// What lies on one side of a plane.
#[derive(Debug, Default)]
pub(super) struct Side {
    /// By ascending triangle.
    pub references: Vec<Reference>,
    /// Indices of the references that were cut.
    pub cut: Vec<u32>,
}

/// Divides events among the sides of planes; holds a buffer for each axis.
#[derive(Default)]
pub(super) struct Distributor([Vec<Event>; 3]);

impl Distributor {
    /// The events on both sides of a plane, of those sides that need any. `fates` are those of the cell's references.
    pub fn distribute(
        &mut self,
        events: &Events,
        fates: &[Fate],
        sides: [Option<&Side>; 2],
    ) -> [Events; 2] {
        let mut distributed = [Events::default(), Events::default()];
        if sides.iter().all(Option::is_none) {
            return distributed;
        }
        let divide = |(axis, buffer): (usize, &mut Vec<Event>)| {
            let kept = divide_whole(&events[axis], fates, buffer);
            let merge = |i: usize| sides[i].map(|side| merged(kept[i], side, axis));
            [merge(0), merge(1)].map(Option::unwrap_or_default)
        };
        let by_axis: Vec<[Vec<Event>; 2]> = if fates.len() > CHUNK {
            self.0.par_iter_mut().enumerate().map(divide).collect()
        } else {
            self.0.iter_mut().enumerate().map(divide).collect()
        };
        for (axis, sides) in by_axis.into_iter().enumerate() {
            for (distributed, events) in distributed.iter_mut().zip(sides) {
                distributed[axis] = events;
            }
        }
        distributed
    }
}

/// The events of references that stay whole, for either side, in order.
fn divide_whole<'a>(
    events: &[Event],
    fates: &[Fate],
    buffer: &'a mut Vec<Event>,
) -> [&'a [Event]; 2] {
    buffer.resize(events.len(), Event(0));
    let buffer = &mut buffer[..events.len()];
    // The left fills the buffer from the front, the right from the back. Each event is written to the next place of both,
    // of which at most one is then taken, as which side is next cannot be predicted.
    let (mut left, mut right) = (0, buffer.len());
    for &event in events {
        let Fate(fate) = fates[event.reference()];
        let (index, side) = (fate >> 2, fate & 3);
        let event = event.of_reference(index);
        buffer[left] = event;
        buffer[right - 1] = event;
        left += usize::from(side == 0);
        right -= usize::from(side == 1);
    }
    let (front, back) = buffer.split_at_mut(right);
    back.reverse();
    [&front[..left], back]
}

/// The events of a side: those it took over and new ones of references that were cut.
fn merged(kept: &[Event], side: &Side, axis: usize) -> Vec<Event> {
    let mut fresh = Vec::with_capacity(2 * side.cut.len());
    for &index in &side.cut {
        add(
            &mut fresh,
            &side.references[index as usize].bounds,
            axis,
            index,
        );
    }
    fresh.sort_unstable();
    let mut all = Vec::with_capacity(kept.len() + fresh.len());
    let mut rest = kept;
    for event in fresh {
        let (before, after) = rest.split_at(rest.partition_point(|&other| other < event));
        all.extend_from_slice(before);
        all.push(event);
        rest = after;
    }
    all.extend_from_slice(rest);
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::Random;

    #[test]
    fn events_are_ordered_by_position_then_kind() {
        use EventKind::{End, Planar, Start};
        let positions = [
            f32::NEG_INFINITY,
            -2.0,
            -1.0,
            -f32::MIN_POSITIVE / 4.0,
            0.0,
            f32::MIN_POSITIVE,
            3.0,
            f32::INFINITY,
        ];
        let kinds = [End, Planar, Start];
        let mut events = Vec::new();
        for position in positions {
            for kind in kinds {
                for reference in [0, 7, (1 << 30) - 1] {
                    let event = Event::new(position, kind, reference);
                    assert_eq!((event.position(), event.kind()), (position, kind));
                    assert_eq!(event.reference(), reference as usize);
                    events.push(event);
                }
            }
        }
        assert!(events.is_sorted_by(|a, b| a < b));
        assert_eq!(Event::new(-0.0, Start, 5), Event::new(0.0, Start, 5));
    }

    /// Boxes on a lattice, so that starts, ends and flat boxes coincide.
    #[test]
    fn lists_divided_are_those_sorted_anew() {
        let mut random = Random::new(1);
        let mut distributor = Distributor::default();
        let cancel = CancelToken::new();
        for count in [0, 1, 5, 300] {
            let mut corner = || (random.in_cube() * 4.0).round().as_vec3();
            let boxes = (0..count).map(|triangle| Reference {
                bounds: Bounds::of_points([corner(), corner()]),
                triangle,
            });
            let references: Vec<_> = boxes.collect();
            let events = sorted(&references, &cancel);
            let mut sides = [Side::default(), Side::default()];
            let mut fates = Vec::new();
            for reference in &references {
                let (Bounds { min, max }, mut fate) = (reference.bounds, Fate::CUT);
                for (is_right, side) in sides.iter_mut().enumerate() {
                    let index = u32::try_from(side.references.len()).unwrap();
                    let mut part = *reference;
                    if is_right == 0 && min.x <= 0.0 {
                        part.bounds.max.x = max.x.min(0.0);
                    } else if is_right == 1 && max.x > 0.0 {
                        part.bounds.min.x = min.x.max(0.0);
                    } else {
                        continue;
                    }
                    if part.bounds == reference.bounds {
                        fate = Fate::whole(is_right == 1, index);
                    } else {
                        side.cut.push(index);
                    }
                    side.references.push(part);
                }
                fates.push(fate);
            }
            let wanted = [Some(&sides[0]), Some(&sides[1])];
            let both = distributor.distribute(&events, &fates, wanted);
            assert_eq!(both[0], sorted(&sides[0].references, &cancel));
            assert_eq!(both[1], sorted(&sides[1].references, &cancel));
            let one = distributor.distribute(&events, &fates, [None, wanted[1]]);
            assert_eq!(one, [Events::default(), both[1].clone()]);
        }
    }
}
