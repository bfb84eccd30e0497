use super::{Half, LANES};

/// Some of up to sixteen lanes, in ascending order, a bit each: those of one register, or of the two that hold a packet.
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

    /// The same lanes after so many others.
    #[inline(always)]
    pub fn beyond(self, others: usize) -> Self {
        Self(self.0 << others)
    }

    /// How many lanes it holds.
    #[inline(always)]
    pub fn count(self) -> usize {
        self.0.count_ones() as usize
    }

    /// The lanes of the register with that number, counted from its first.
    #[inline(always)]
    pub fn of_register(self, index: usize) -> Self {
        Self(self.0 >> (index * LANES) & ((1 << LANES) - 1))
    }

    #[inline(always)]
    pub fn insert(&mut self, lane: usize) {
        self.0 |= 1 << lane;
    }

    /// The halves that hold any of these lanes, with them, counted from the half's first.
    #[inline(always)]
    pub fn halves(self) -> Halves {
        Halves(self)
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
        let LaneSet(bits) = self.0;
        (bits != 0).then(|| {
            self.0 = LaneSet(bits & (bits - 1));
            bits.trailing_zeros() as usize
        })
    }
}

/// The halves of a set that are left to visit.
#[derive(Debug)]
pub struct Halves(LaneSet);

impl Iterator for Halves {
    type Item = (Half, LaneSet);

    #[inline(always)]
    fn next(&mut self) -> Option<(Half, LaneSet)> {
        const LOWER: u32 = (1 << (LANES / 2)) - 1;
        let LaneSet(bits) = self.0;
        if bits & LOWER != 0 {
            self.0 = LaneSet(bits & !LOWER);
            Some((Half::Lower, LaneSet(bits & LOWER)))
        } else if bits != 0 {
            self.0 = LaneSet::NONE;
            Some((Half::Upper, LaneSet(bits >> (LANES / 2))))
        } else {
            None
        }
    }
}
