//! Eight numbers side by side, in the widest instructions of the machine the program runs on.
//!
//! A [`Query`] is written once over [`Simd`] and compiled twice: with [`Portable`] for the instructions every machine has, and
//! with [`Avx2`], where one instruction works on eight numbers. What it finds may not depend on which: only [`Simd::mul_add`]
//! and [`Simd::mul_sub`] may round differently, and they serve filters with an error bound, never an answer.
//!
//! All functions of lanes are always inlined, as is everything in a query, so that they are compiled with the instructions of the
//! query's caller. Closures cannot ask for that, so there are none around lanes.

#[cfg(target_arch = "x86_64")]
#[expect(
    unsafe_code,
    reason = "instructions that not every machine has; `Portable` is the twin that tests compare with"
)]
mod avx2;
mod lane_set;
mod portable;
#[cfg(test)]
mod tests;

#[cfg(target_arch = "x86_64")]
pub(super) use avx2::Avx2;
pub(super) use lane_set::LaneSet;
pub(super) use portable::Portable;

/// How many numbers stand side by side.
pub(super) const LANES: usize = 8;

/// One number per lane, as it lies in memory.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub(super) struct Lanes(pub [f32; LANES]);

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

/// Instructions on eight numbers at once, or on four of twice the length.
pub(super) trait Simd: Arithmetic<Self::F32x8> + Arithmetic<Self::F64x4> {
    /// Eight numbers in registers.
    type F32x8: Copy;
    /// Four numbers in registers.
    type F64x4: Copy;

    fn load(self, lanes: &Lanes) -> Self::F32x8;
    fn store(self, x: Self::F32x8) -> Lanes;
    fn splat(self, x: f32) -> Self::F32x8;
    /// `a · b + c`, the product rounded or not.
    fn mul_add(self, a: Self::F32x8, b: Self::F32x8, c: Self::F32x8) -> Self::F32x8;
    /// `a · b − c`, the product rounded or not.
    fn mul_sub(self, a: Self::F32x8, b: Self::F32x8, c: Self::F32x8) -> Self::F32x8;
    /// The least of the numbers, any of them if one is NaN; of zeros, either.
    fn least(self, x: Self::F32x8) -> f32;
    /// The greatest of the numbers, any of them if one is NaN; of zeros, either.
    fn greatest(self, x: Self::F32x8) -> f32;

    /// Asks memory for what is going to be needed soon.
    fn prefetch<T>(self, what: &T);
    /// The lanes of one half.
    fn load_half(self, lanes: &Lanes, half: Half) -> Self::F64x4;
    #[cfg(test)]
    fn store_double(self, x: Self::F64x4) -> [f64; LANES / 2];
    /// Rounded to nearest.
    fn store_rounded(self, x: Self::F64x4) -> [f32; LANES / 2];
    fn splat_double(self, x: f64) -> Self::F64x4;
}

/// One half of eight lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    Lower,
    Upper,
}

impl Half {
    /// Its first lane.
    #[inline(always)]
    pub fn first(self) -> usize {
        match self {
            Self::Lower => 0,
            Self::Upper => LANES / 2,
        }
    }
}

/// Three numbers, each in all lanes.
#[inline(always)]
pub(super) fn splat_all<S: Simd>(simd: S, [x, y, z]: [f32; 3]) -> [S::F32x8; 3] {
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
    if let Some(avx2) = Avx2::detect() {
        return avx2.answer(query);
    }
    query.answer(Portable)
}
