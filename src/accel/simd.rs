//! Several numbers side by side, in the widest instructions of the machine the program runs on.
//!
//! A [`Query`] is written once over [`Simd`] and compiled three times: with [`Portable`] for the instructions every machine has,
//! with [`Avx2`], where one instruction works on eight numbers, and with [`Avx512`], where one works on sixteen. What it finds may
//! not depend on which: only [`Floats::mul_add`] and [`Floats::mul_sub`] may round differently, and they serve filters with an
//! error bound, never an answer.
//!
//! All functions of lanes are always inlined, as is everything in a query, so that they are compiled with the instructions of the
//! query's caller. Closures cannot ask for that, so there are none around lanes.

mod lane_set;
mod portable;
#[cfg(test)]
mod tests;
#[cfg(target_arch = "x86_64")]
#[expect(
    unsafe_code,
    reason = "instructions that not every machine has; `Portable` is the twin that tests compare with"
)]
mod x86;

pub(super) use lane_set::{Four, LaneSet};
pub(super) use portable::Portable;
#[cfg(target_arch = "x86_64")]
use x86::Widest;
#[cfg(all(test, target_arch = "x86_64"))]
use x86::{Avx2, Avx512};

/// How many boxes of a node, or triangles of a block, stand side by side.
pub(super) const LANES: usize = 8;

/// How many rays of a packet stand side by side.
pub(super) const WIDE_LANES: usize = 16;

/// How many `f64` stand side by side.
pub(super) const DOUBLES: usize = 4;

/// One number per lane, as it lies in memory.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub(super) struct Lanes(pub [f32; LANES]);

impl Lanes {
    /// The lanes of one of the fours of [`LaneSet::fours`].
    #[inline(always)]
    pub fn four(&self, index: usize) -> &[f32; DOUBLES] {
        let (fours, _) = self.0.as_chunks();
        &fours[index % (LANES / DOUBLES)]
    }
}

/// One number per ray of a packet, as it lies in memory.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct WideLanes(pub [f32; WIDE_LANES]);

/// From which lane each of up to eight numbers is taken, a byte each. The first lane, where nothing else is said.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Places(u64);

impl Places {
    /// Takes the number `index`, of which nothing was said, from a lane.
    #[inline(always)]
    pub fn put(&mut self, index: usize, lane: usize) {
        self.0 |= (lane as u64) << (8 * index);
    }

    #[inline(always)]
    pub fn get(self, index: usize) -> usize {
        #[expect(clippy::cast_possible_truncation, reason = "a byte")]
        let lane = (self.0 >> (8 * index)) as u8;
        usize::from(lane) % WIDE_LANES
    }
}

/// Arithmetic on registers of several numbers.
pub(super) trait Arithmetic<Register>: Copy {
    fn add(self, a: Register, b: Register) -> Register;
    fn sub(self, a: Register, b: Register) -> Register;
    fn mul(self, a: Register, b: Register) -> Register;
    fn div(self, a: Register, b: Register) -> Register;
    fn abs(self, x: Register) -> Register;
    /// The smaller number; `old` if either is NaN.
    fn smaller(self, new: Register, old: Register) -> Register;
    /// The larger number; `old` if either is NaN.
    fn larger(self, new: Register, old: Register) -> Register;
    /// Where `a < b`; nowhere NaN.
    fn less(self, a: Register, b: Register) -> LaneSet;
    /// Where `a ≤ b`; nowhere NaN.
    fn less_or_equal(self, a: Register, b: Register) -> LaneSet;
}

/// What only registers of `f32` are asked for.
pub(super) trait Floats<Register>: Arithmetic<Register> {
    fn splat(self, x: f32) -> Register;
    /// `a · b + c`, the product rounded or not.
    fn mul_add(self, a: Register, b: Register, c: Register) -> Register;
    /// `a · b − c`, the product rounded or not.
    fn mul_sub(self, a: Register, b: Register, c: Register) -> Register;
    /// The least of the numbers, any of them if one is NaN; of zeros, either.
    fn least(self, x: Register) -> f32;
    /// The greatest of the numbers, any of them if one is NaN; of zeros, either.
    fn greatest(self, x: Register) -> f32;
}

/// What only registers of `f64` are asked for.
pub(super) trait Doubles<Register>: Arithmetic<Register> {
    fn splat_double(self, x: f64) -> Register;
    /// Rounded to nearest; 0 in lanes beyond those of the register.
    fn store_rounded(self, x: Register) -> Lanes;
    #[cfg(test)]
    fn store_doubles(self, x: Register) -> Vec<f64>;
}

/// Instructions on eight or sixteen numbers at once, or on fewer of twice the length.
pub(super) trait Simd:
    Floats<Self::F32x8> + Floats<Self::F32x16> + Doubles<Self::F64x4> + Doubles<Self::F64s>
{
    /// How many registers hold a number of each ray of a packet.
    const REGISTERS_PER_PACKET: usize;

    /// Eight numbers in registers.
    type F32x8: Copy;
    /// Sixteen numbers in registers.
    type F32x16: Copy;
    /// Four numbers of twice the length in registers.
    type F64x4: Copy;
    /// As many numbers of twice the length as one register holds: [`Self::DOUBLES_PER_REGISTER`].
    type F64s: Copy;
    /// At most [`LANES`].
    const DOUBLES_PER_REGISTER: usize;

    fn load(self, lanes: &Lanes) -> Self::F32x8;
    fn store(self, x: Self::F32x8) -> Lanes;
    fn load_wide(self, lanes: &WideLanes) -> Self::F32x16;
    fn store_wide(self, x: Self::F32x16) -> WideLanes;

    /// Asks memory for what is going to be needed soon.
    fn prefetch<T>(self, what: &T);

    fn load_doubles(self, numbers: &[f32; DOUBLES]) -> Self::F64x4;
    /// The numbers in these places of `lanes`.
    fn pick(self, lanes: &Lanes, places: Places) -> Self::F64s;
    /// The numbers in these places of `lanes`.
    fn pick_wide(self, lanes: &WideLanes, places: Places) -> Self::F64s;
}

/// Three numbers, each in all lanes.
#[inline(always)]
pub(super) fn splat_all<R, S: Floats<R>>(simd: S, [x, y, z]: [f32; 3]) -> [R; 3] {
    [simd.splat(x), simd.splat(y), simd.splat(z)]
}

/// Code that gains from wide instructions.
pub(super) trait Query {
    type Answer;

    /// Always inlined, as the module's documentation says.
    fn answer<S: Simd>(&self, simd: S) -> Self::Answer;
}

/// The answer, by the widest instructions there are.
#[inline]
pub(super) fn answer<Q: Query>(query: &Q) -> Q::Answer {
    #[cfg(target_arch = "x86_64")]
    match *x86::WIDEST {
        Widest::Avx512(avx512) => return avx512.answer(query),
        Widest::Avx2(avx2) => return avx2.answer(query),
        Widest::Neither => {}
    }
    query.answer(Portable)
}

/// The answer by each kind of instructions that the machine has, those of [`Portable`] first.
#[cfg(test)]
pub(super) fn answers<Q: Query>(query: &Q) -> Vec<Q::Answer> {
    let mut answers = vec![query.answer(Portable)];
    #[cfg(target_arch = "x86_64")]
    {
        answers.extend(Avx2::detect().map(|avx2| avx2.answer(query)));
        answers.extend(Avx512::detect().map(|avx512| avx512.answer(query)));
    }
    answers
}
