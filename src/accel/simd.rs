//! Eight numbers side by side, in the widest instructions of the machine the program runs on.
//!
//! A [`Query`] is written once over [`Simd`] and compiled twice: with [`Portable`] for the instructions every machine has, and
//! with [`Avx2`], where one instruction works on eight numbers. What it finds may not depend on which: only [`Simd::mul_add`]
//! and [`Simd::mul_sub`] may round differently, and they serve filters with an error bound, never an answer.
//!
//! All functions of lanes are always inlined, as is everything in a query, so that they are compiled with the instructions of the
//! query's caller. Closures cannot ask for that, so there are none around lanes.

#[cfg(target_arch = "x86_64")]
pub(super) use avx2::Avx2;

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
pub(super) enum Half {
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

/// Some of up to sixteen lanes, in ascending order, a bit each: those of one register, or of the two that hold a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct LaneSet(u32);

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
pub(super) struct LaneIndices(LaneSet);

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
pub(super) struct Halves(LaneSet);

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

/// The instructions that every machine has: loops over lanes, which compilers turn into what vectors there are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Portable;

impl Portable {
    #[inline(always)]
    fn each<T: Copy, const N: usize>(a: [T; N], b: [T; N], f: impl Fn(T, T) -> T) -> [T; N] {
        let mut result = a;
        for (result, b) in result.iter_mut().zip(b) {
            *result = f(*result, b);
        }
        result
    }

    #[inline(always)]
    fn each_bit<T: Copy, const N: usize>(
        a: [T; N],
        b: [T; N],
        f: impl Fn(T, T) -> bool,
    ) -> LaneSet {
        let mut bits = 0;
        for i in 0..N {
            bits |= u32::from(f(a[i], b[i])) << i;
        }
        LaneSet(bits)
    }
}

macro_rules! portable_arithmetic {
    ($number:ty, $count:expr) => {
        impl Arithmetic<[$number; $count]> for Portable {
            #[inline(always)]
            fn add(self, a: [$number; $count], b: [$number; $count]) -> [$number; $count] {
                Self::each(a, b, |a, b| a + b)
            }

            #[inline(always)]
            fn sub(self, a: [$number; $count], b: [$number; $count]) -> [$number; $count] {
                Self::each(a, b, |a, b| a - b)
            }

            #[inline(always)]
            fn mul(self, a: [$number; $count], b: [$number; $count]) -> [$number; $count] {
                Self::each(a, b, |a, b| a * b)
            }

            #[inline(always)]
            fn div(self, a: [$number; $count], b: [$number; $count]) -> [$number; $count] {
                Self::each(a, b, |a, b| a / b)
            }

            #[inline(always)]
            fn abs(self, x: [$number; $count]) -> [$number; $count] {
                Self::each(x, x, |x, _| x.abs())
            }

            #[inline(always)]
            fn smaller(self, new: [$number; $count], old: [$number; $count]) -> [$number; $count] {
                Self::each(new, old, |new, old| if new < old { new } else { old })
            }

            #[inline(always)]
            fn larger(self, new: [$number; $count], old: [$number; $count]) -> [$number; $count] {
                Self::each(new, old, |new, old| if new > old { new } else { old })
            }

            #[inline(always)]
            fn less(self, a: [$number; $count], b: [$number; $count]) -> LaneSet {
                Self::each_bit(a, b, |a, b| a < b)
            }

            #[inline(always)]
            fn less_or_equal(self, a: [$number; $count], b: [$number; $count]) -> LaneSet {
                Self::each_bit(a, b, |a, b| a <= b)
            }
        }
    };
}

portable_arithmetic!(f32, LANES);
portable_arithmetic!(f64, LANES / 2);

impl Simd for Portable {
    type F32x8 = [f32; LANES];
    type F64x4 = [f64; LANES / 2];

    #[inline(always)]
    fn load(self, lanes: &Lanes) -> [f32; LANES] {
        lanes.0
    }

    #[inline(always)]
    fn store(self, x: [f32; LANES]) -> Lanes {
        Lanes(x)
    }

    #[inline(always)]
    fn splat(self, x: f32) -> [f32; LANES] {
        [x; LANES]
    }

    #[inline(always)]
    fn mul_add(self, a: [f32; LANES], b: [f32; LANES], c: [f32; LANES]) -> [f32; LANES] {
        self.add(self.mul(a, b), c)
    }

    #[inline(always)]
    fn mul_sub(self, a: [f32; LANES], b: [f32; LANES], c: [f32; LANES]) -> [f32; LANES] {
        self.sub(self.mul(a, b), c)
    }

    #[inline(always)]
    fn prefetch<T>(self, _what: &T) {}

    #[inline(always)]
    fn least(self, x: [f32; LANES]) -> f32 {
        x.into_iter().fold(f32::INFINITY, f32::min)
    }

    #[inline(always)]
    fn greatest(self, x: [f32; LANES]) -> f32 {
        x.into_iter().fold(f32::NEG_INFINITY, f32::max)
    }

    #[inline(always)]
    fn load_half(self, lanes: &Lanes, half: Half) -> [f64; LANES / 2] {
        let mut result = [0.0; LANES / 2];
        for (result, &lane) in result.iter_mut().zip(&lanes.0[half.first()..]) {
            *result = f64::from(lane);
        }
        result
    }

    #[cfg(test)]
    fn store_double(self, x: [f64; LANES / 2]) -> [f64; LANES / 2] {
        x
    }

    #[inline(always)]
    fn store_rounded(self, x: [f64; LANES / 2]) -> [f32; LANES / 2] {
        let mut numbers = [0.0; LANES / 2];
        for (number, x) in numbers.iter_mut().zip(x) {
            #[expect(
                clippy::cast_possible_truncation,
                reason = "the rounding is the purpose"
            )]
            let rounded = x as f32;
            *number = rounded;
        }
        numbers
    }

    #[inline(always)]
    fn splat_double(self, x: f64) -> [f64; LANES / 2] {
        [x; LANES / 2]
    }
}

/// The one module with `unsafe` code: instructions that not every machine has, behind a value that only machines with them make.
/// Left to itself, the compiler turned the loops of [`Portable`] into a mixture of two and four lanes.
#[cfg(target_arch = "x86_64")]
#[expect(
    unsafe_code,
    reason = "instructions that not every machine has; `Portable` is the twin that tests compare with"
)]
mod avx2 {
    use super::{Arithmetic, Half, LANES, LaneSet, Lanes, Query, Simd};
    use std::arch::x86_64::{
        __m256, __m256d, _CMP_LE_OQ, _CMP_LT_OQ, _MM_HINT_T0, _mm_cvtss_f32, _mm_load_ps,
        _mm_max_ps, _mm_max_ss, _mm_min_ps, _mm_min_ss, _mm_movehdup_ps, _mm_movehl_ps,
        _mm_prefetch, _mm_storeu_ps, _mm256_add_pd, _mm256_add_ps, _mm256_andnot_pd,
        _mm256_andnot_ps, _mm256_castps256_ps128, _mm256_cmp_pd, _mm256_cmp_ps, _mm256_cvtpd_ps,
        _mm256_cvtps_pd, _mm256_div_pd, _mm256_div_ps, _mm256_extractf128_ps, _mm256_fmadd_ps,
        _mm256_fmsub_ps, _mm256_load_ps, _mm256_max_pd, _mm256_max_ps, _mm256_min_pd,
        _mm256_min_ps, _mm256_movemask_pd, _mm256_movemask_ps, _mm256_mul_pd, _mm256_mul_ps,
        _mm256_set1_pd, _mm256_set1_ps, _mm256_store_ps, _mm256_sub_pd, _mm256_sub_ps,
    };

    /// Proof that the machine has the instructions: [`Avx2::detect`] alone makes one.
    #[derive(Clone, Copy, Debug)]
    pub struct Avx2(());

    impl Avx2 {
        /// `None` where the machine lacks any of the instructions.
        #[inline]
        pub fn detect() -> Option<Self> {
            let has_all = is_x86_feature_detected!("avx2")
                && is_x86_feature_detected!("fma")
                && is_x86_feature_detected!("bmi1")
                && is_x86_feature_detected!("bmi2")
                && is_x86_feature_detected!("popcnt");
            has_all.then_some(Self(()))
        }

        /// The query's answer, compiled with the instructions.
        #[inline]
        pub fn answer<Q: Query>(self, query: &Q) -> Q::Answer {
            // SAFETY: the only condition is that the machine has the features, which `self` proves.
            unsafe { with_avx2(self, query) }
        }
    }

    #[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt")]
    fn with_avx2<Q: Query>(proof: Avx2, query: &Q) -> Q::Answer {
        query.answer(proof)
    }

    /// Calls an instruction.
    macro_rules! instruction {
        ($call:expr) => {{
            // SAFETY: the only condition is that the machine has the instruction, which the `Avx2` at hand proves; pointers
            // come from references to as many numbers as are moved, aligned where the instruction asks for it.
            unsafe { $call }
        }};
    }

    /// [`Arithmetic`] by the instructions of these names.
    macro_rules! arithmetic {
        ($register:ty, $add:ident, $sub:ident, $mul:ident, $div:ident, $and_not:ident, $splat:ident, $min:ident, $max:ident,
         $compare:ident, $mask:ident) => {
            impl Arithmetic<$register> for Avx2 {
                #[inline(always)]
                fn add(self, a: $register, b: $register) -> $register {
                    instruction!($add(a, b))
                }

                #[inline(always)]
                fn sub(self, a: $register, b: $register) -> $register {
                    instruction!($sub(a, b))
                }

                #[inline(always)]
                fn mul(self, a: $register, b: $register) -> $register {
                    instruction!($mul(a, b))
                }

                #[inline(always)]
                fn div(self, a: $register, b: $register) -> $register {
                    instruction!($div(a, b))
                }

                #[inline(always)]
                fn abs(self, x: $register) -> $register {
                    instruction!($and_not($splat(-0.0), x))
                }

                #[inline(always)]
                fn smaller(self, new: $register, old: $register) -> $register {
                    // The second operand is the result where either is NaN.
                    instruction!($min(new, old))
                }

                #[inline(always)]
                fn larger(self, new: $register, old: $register) -> $register {
                    instruction!($max(new, old))
                }

                #[inline(always)]
                fn less(self, a: $register, b: $register) -> LaneSet {
                    LaneSet(instruction!($mask($compare::<_CMP_LT_OQ>(a, b))).cast_unsigned())
                }

                #[inline(always)]
                fn less_or_equal(self, a: $register, b: $register) -> LaneSet {
                    LaneSet(instruction!($mask($compare::<_CMP_LE_OQ>(a, b))).cast_unsigned())
                }
            }
        };
    }

    arithmetic!(
        __m256,
        _mm256_add_ps,
        _mm256_sub_ps,
        _mm256_mul_ps,
        _mm256_div_ps,
        _mm256_andnot_ps,
        _mm256_set1_ps,
        _mm256_min_ps,
        _mm256_max_ps,
        _mm256_cmp_ps,
        _mm256_movemask_ps
    );
    arithmetic!(
        __m256d,
        _mm256_add_pd,
        _mm256_sub_pd,
        _mm256_mul_pd,
        _mm256_div_pd,
        _mm256_andnot_pd,
        _mm256_set1_pd,
        _mm256_min_pd,
        _mm256_max_pd,
        _mm256_cmp_pd,
        _mm256_movemask_pd
    );

    impl Simd for Avx2 {
        type F32x8 = __m256;
        type F64x4 = __m256d;

        #[inline(always)]
        fn load(self, lanes: &Lanes) -> __m256 {
            instruction!(_mm256_load_ps(lanes.0.as_ptr()))
        }

        #[inline(always)]
        fn store(self, x: __m256) -> Lanes {
            let mut lanes = Lanes([0.0; LANES]);
            instruction!(_mm256_store_ps(lanes.0.as_mut_ptr(), x));
            lanes
        }

        #[inline(always)]
        fn splat(self, x: f32) -> __m256 {
            instruction!(_mm256_set1_ps(x))
        }

        #[inline(always)]
        fn mul_add(self, a: __m256, b: __m256, c: __m256) -> __m256 {
            instruction!(_mm256_fmadd_ps(a, b, c))
        }

        #[inline(always)]
        fn mul_sub(self, a: __m256, b: __m256, c: __m256) -> __m256 {
            instruction!(_mm256_fmsub_ps(a, b, c))
        }

        #[inline(always)]
        fn prefetch<T>(self, what: &T) {
            const LINE_BYTES: usize = 64;
            let first = std::ptr::from_ref(what).cast::<i8>();
            for line in 0..size_of::<T>().div_ceil(LINE_BYTES) {
                instruction!(_mm_prefetch::<_MM_HINT_T0>(first.add(line * LINE_BYTES)));
            }
        }

        #[inline(always)]
        fn least(self, x: __m256) -> f32 {
            instruction!({
                let four = _mm_min_ps(_mm256_castps256_ps128(x), _mm256_extractf128_ps::<1>(x));
                let two = _mm_min_ps(four, _mm_movehl_ps(four, four));
                _mm_cvtss_f32(_mm_min_ss(two, _mm_movehdup_ps(two)))
            })
        }

        #[inline(always)]
        fn greatest(self, x: __m256) -> f32 {
            instruction!({
                let four = _mm_max_ps(_mm256_castps256_ps128(x), _mm256_extractf128_ps::<1>(x));
                let two = _mm_max_ps(four, _mm_movehl_ps(four, four));
                _mm_cvtss_f32(_mm_max_ss(two, _mm_movehdup_ps(two)))
            })
        }

        #[inline(always)]
        fn load_half(self, lanes: &Lanes, half: Half) -> __m256d {
            let lanes = &lanes.0[half.first()..][..LANES / 2];
            instruction!(_mm256_cvtps_pd(_mm_load_ps(lanes.as_ptr())))
        }

        #[cfg(test)]
        fn store_double(self, x: __m256d) -> [f64; LANES / 2] {
            let mut numbers = [0.0; LANES / 2];
            instruction!(std::arch::x86_64::_mm256_storeu_pd(numbers.as_mut_ptr(), x));
            numbers
        }

        #[inline(always)]
        fn store_rounded(self, x: __m256d) -> [f32; LANES / 2] {
            let mut numbers = [0.0; LANES / 2];
            instruction!(_mm_storeu_ps(numbers.as_mut_ptr(), _mm256_cvtpd_ps(x)));
            numbers
        }

        #[inline(always)]
        fn splat_double(self, x: f64) -> __m256d {
            instruction!(_mm256_set1_pd(x))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug)]
    struct Everything {
        a: Lanes,
        b: Lanes,
        c: Lanes,
    }

    /// What [`Everything`] gives.
    #[derive(Default)]
    struct Results {
        /// Numbers that must agree in every bit, `f32` as the `f64` that they are.
        exact: Vec<f64>,
        sets: Vec<LaneSet>,
        /// The least and the greatest of numbers without NaN, where of two zeros either will do.
        extremes: Vec<f32>,
        /// Products with sums that may be rounded once or twice.
        fused: Vec<[f32; LANES]>,
    }

    impl Query for Everything {
        type Answer = Results;

        fn answer<S: Simd>(&self, simd: S) -> Results {
            let mut results = Results::default();
            let [a, b, c] = [&self.a, &self.b, &self.c].map(|lanes| simd.load(lanes));
            let exact = [
                simd.add(a, b),
                simd.sub(a, b),
                simd.mul(a, b),
                simd.div(a, b),
                simd.abs(a),
                simd.smaller(a, b),
                simd.larger(a, b),
                simd.splat(self.a.0[0]),
            ];
            for register in exact {
                results.exact.extend(simd.store(register).0.map(f64::from));
            }
            results.sets = vec![simd.less(a, b), simd.less_or_equal(a, b)];
            if !self.a.0.iter().any(|x| x.is_nan()) {
                results.extremes = vec![simd.least(a), simd.greatest(a)];
            }
            let fused = [simd.mul_add(a, b, c), simd.mul_sub(a, b, c)];
            results.fused = fused.map(|x| simd.store(x).0).to_vec();
            for half in [Half::Lower, Half::Upper] {
                let [a, b] = [&self.a, &self.b].map(|lanes| simd.load_half(lanes, half));
                let exact = [
                    simd.add(a, b),
                    simd.sub(a, b),
                    simd.mul(a, b),
                    simd.div(a, b),
                    simd.abs(a),
                    simd.smaller(a, b),
                    simd.larger(a, b),
                    simd.splat_double(f64::from(self.a.0[0]) * 1e100),
                ];
                for register in exact {
                    results.exact.extend(simd.store_double(register));
                    let rounded = simd.store_rounded(register);
                    results.exact.extend(rounded.map(f64::from));
                }
                results
                    .sets
                    .extend([simd.less(a, b), simd.less_or_equal(a, b)]);
            }
            results
        }
    }

    /// On machines without wide instructions, the same code twice.
    #[test]
    fn wide_instructions_work_as_the_portable_ones() {
        let special = [
            0.0,
            -0.0,
            1.0,
            -2.5,
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::MIN_POSITIVE / 4.0,
            f32::MAX,
            1.0 + f32::EPSILON,
        ];
        let lanes = |first: usize, step: usize| {
            let at = |i: usize| special[(first + i * step) % special.len()];
            Lanes(std::array::from_fn(at))
        };
        for turn in 0..1000 {
            let query = Everything {
                a: lanes(turn, 1),
                b: lanes(turn / 10, 3),
                c: lanes(turn / 100, 7),
            };
            let (wide, portable) = (answer(&query), query.answer(Portable));
            let bits = |numbers: &[f64]| -> Vec<_> {
                // Which NaN it is does not matter.
                let bits = |x: &f64| if x.is_nan() { None } else { Some(x.to_bits()) };
                numbers.iter().map(bits).collect()
            };
            assert_eq!(bits(&wide.exact), bits(&portable.exact));
            assert_eq!(wide.sets, portable.sets);
            assert_eq!(wide.extremes, portable.extremes);
            // The product is rounded, or not, and the sum is rounded.
            let product = Portable.mul(query.a.0, query.b.0);
            for (wide, portable) in wide.fused.iter().zip(&portable.fused) {
                for (lane, product) in product.iter().enumerate() {
                    let (wide, portable) = (wide[lane], portable[lane]);
                    let most = (product.abs() + portable.abs()) * f32::EPSILON;
                    let overflown = !wide.is_finite() || !portable.is_finite();
                    assert!((wide - portable).abs() <= most || overflown, "{query:?}");
                }
            }
        }
    }

    #[test]
    fn sets_of_lanes_count_up() {
        let set = LaneSet(0b100_0010);
        let lanes: Vec<_> = set.into_iter().collect();
        assert_eq!(lanes, [1, 6]);
        let halves: Vec<_> = set.halves().collect();
        assert_eq!(
            halves,
            [(Half::Lower, LaneSet(2)), (Half::Upper, LaneSet(4))]
        );
        let upper: Vec<_> = LaneSet(0b1000_0000).halves().collect();
        assert_eq!(upper, [(Half::Upper, LaneSet(8))]);
        let one = LaneSet(2);
        assert_eq!((set.and(one), set.and_not(one)), (one, LaneSet(64)));
        assert!(set.and_not(set).into_iter().is_empty());
    }
}
