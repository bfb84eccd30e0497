//! Sets of lanes, as comparisons of registers return them: bit `i` stands for lane `i`.

use super::{DOUBLES, LANES};

/// Some of up to sixteen lanes, in ascending order, a bit each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LaneSet(pub(super) u32);

impl LaneSet {
    pub const NONE: Self = Self(0);

    /// The first so many lanes.
    #[inline(always)]
    pub fn first(count: usize) -> Self {
        Self((1 << count) - 1)
    }

    #[inline(always)]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// A bit per lane.
    #[inline(always)]
    pub fn bits(self) -> u64 {
        self.0.into()
    }

    #[inline(always)]
    pub fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    #[inline(always)]
    pub fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    #[inline(always)]
    pub fn and_not(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// These of eight lanes, and those of the eight after them.
    #[inline(always)]
    pub fn followed_by(self, others: Self) -> Self {
        Self(self.0 | others.0 << LANES)
    }

    /// How many lanes it holds.
    #[inline(always)]
    pub fn count(self) -> usize {
        self.0.count_ones() as usize
    }

    /// Takes the first of the lanes out of the set.
    #[inline(always)]
    pub fn take_first(&mut self) -> Option<usize> {
        let Self(bits) = *self;
        (bits != 0).then(|| {
            self.0 = bits & (bits - 1);
            bits.trailing_zeros() as usize
        })
    }

    #[cfg(test)]
    pub fn contains(self, lane: usize) -> bool {
        self.0 >> lane & 1 != 0
    }

    #[inline(always)]
    pub fn insert(&mut self, lane: usize) {
        self.0 |= 1 << lane;
    }

    /// The lanes four by four, as many as `f64` stand side by side: the fours that hold any of these, by their index.
    #[inline(always)]
    pub fn fours(self) -> Fours {
        Fours(self)
    }
}

impl IntoIterator for LaneSet {
    type Item = usize;
    type IntoIter = LaneIndices;

    #[inline(always)]
    fn into_iter(self) -> LaneIndices {
        LaneIndices(self)
    }
}

/// The lanes of a set that are left to visit.
#[derive(Debug)]
pub struct LaneIndices(LaneSet);

impl LaneIndices {
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl Iterator for LaneIndices {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        self.0.take_first()
    }
}

/// The lanes of a set that are in one four of lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Four {
    /// How many fours come before.
    pub index: usize,
    /// Counted from the first of the four.
    pub lanes: LaneSet,
}

impl Four {
    /// The first lane of the four.
    #[inline(always)]
    pub fn first(self) -> usize {
        self.index * DOUBLES
    }
}

/// The fours of a set that are left to visit.
#[derive(Debug)]
pub struct Fours(LaneSet);

impl Iterator for Fours {
    type Item = Four;

    #[inline(always)]
    fn next(&mut self) -> Option<Four> {
        const FOUR: u32 = (1 << DOUBLES) - 1;
        let LaneSet(bits) = self.0;
        (bits != 0).then(|| {
            let index = bits.trailing_zeros() as usize / DOUBLES;
            let first = index * DOUBLES;
            self.0 = LaneSet(bits & !(FOUR << first));
            let lanes = LaneSet(bits >> first & FOUR);
            Four { index, lanes }
        })
    }
}
