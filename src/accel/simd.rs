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

/// Instructions on eight numbers at once.
pub(super) trait Simd: Copy {
    /// Eight numbers in registers.
    type F32x8: Copy;

    fn load(self, lanes: &Lanes) -> Self::F32x8;
    fn store(self, x: Self::F32x8) -> Lanes;
    fn splat(self, x: f32) -> Self::F32x8;
    fn add(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    fn sub(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    fn mul(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    /// `a · b + c`, the product rounded or not.
    fn mul_add(self, a: Self::F32x8, b: Self::F32x8, c: Self::F32x8) -> Self::F32x8;
    /// `a · b − c`, the product rounded or not.
    fn mul_sub(self, a: Self::F32x8, b: Self::F32x8, c: Self::F32x8) -> Self::F32x8;
    fn abs(self, x: Self::F32x8) -> Self::F32x8;
    /// The smaller number; `old` if either is NaN.
    fn smaller(self, new: Self::F32x8, old: Self::F32x8) -> Self::F32x8;
    /// The larger number; `old` if either is NaN.
    fn larger(self, new: Self::F32x8, old: Self::F32x8) -> Self::F32x8;
    /// Where `a < b`; nowhere NaN.
    fn less(self, a: Self::F32x8, b: Self::F32x8) -> LaneSet;
    /// Where `a ≤ b`; nowhere NaN.
    fn less_or_equal(self, a: Self::F32x8, b: Self::F32x8) -> LaneSet;
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

/// Some of eight lanes, in ascending order: a bit each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct LaneSet(u32);

impl LaneSet {
    pub const NONE: Self = Self(0);

    #[inline(always)]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    #[inline(always)]
    pub fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    #[inline(always)]
    pub fn and_not(self, other: Self) -> Self {
        Self(self.0 & !other.0)
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

/// The instructions that every machine has: loops over lanes, which compilers turn into what vectors there are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Portable;

impl Portable {
    #[inline(always)]
    fn each(a: Lanes, b: Lanes, f: impl Fn(f32, f32) -> f32) -> Lanes {
        let mut result = Lanes([0.0; LANES]);
        for (result, (&a, &b)) in result.0.iter_mut().zip(a.0.iter().zip(&b.0)) {
            *result = f(a, b);
        }
        result
    }

    #[inline(always)]
    fn each_bit(a: Lanes, b: Lanes, f: impl Fn(f32, f32) -> bool) -> LaneSet {
        let mut bits = 0;
        for i in 0..LANES {
            bits |= u32::from(f(a.0[i], b.0[i])) << i;
        }
        LaneSet(bits)
    }
}

impl Simd for Portable {
    type F32x8 = Lanes;

    #[inline(always)]
    fn load(self, lanes: &Lanes) -> Lanes {
        *lanes
    }

    #[inline(always)]
    fn store(self, x: Lanes) -> Lanes {
        x
    }

    #[inline(always)]
    fn splat(self, x: f32) -> Lanes {
        Lanes([x; LANES])
    }

    #[inline(always)]
    fn add(self, a: Lanes, b: Lanes) -> Lanes {
        Self::each(a, b, |a, b| a + b)
    }

    #[inline(always)]
    fn sub(self, a: Lanes, b: Lanes) -> Lanes {
        Self::each(a, b, |a, b| a - b)
    }

    #[inline(always)]
    fn mul(self, a: Lanes, b: Lanes) -> Lanes {
        Self::each(a, b, |a, b| a * b)
    }

    #[inline(always)]
    fn mul_add(self, a: Lanes, b: Lanes, c: Lanes) -> Lanes {
        self.add(self.mul(a, b), c)
    }

    #[inline(always)]
    fn mul_sub(self, a: Lanes, b: Lanes, c: Lanes) -> Lanes {
        self.sub(self.mul(a, b), c)
    }

    #[inline(always)]
    fn abs(self, x: Lanes) -> Lanes {
        Self::each(x, x, |x, _| x.abs())
    }

    #[inline(always)]
    fn smaller(self, new: Lanes, old: Lanes) -> Lanes {
        Self::each(new, old, |new, old| if new < old { new } else { old })
    }

    #[inline(always)]
    fn larger(self, new: Lanes, old: Lanes) -> Lanes {
        Self::each(new, old, |new, old| if new > old { new } else { old })
    }

    #[inline(always)]
    fn less(self, a: Lanes, b: Lanes) -> LaneSet {
        Self::each_bit(a, b, |a, b| a < b)
    }

    #[inline(always)]
    fn less_or_equal(self, a: Lanes, b: Lanes) -> LaneSet {
        Self::each_bit(a, b, |a, b| a <= b)
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
    use super::{LaneSet, Lanes, Query, Simd};
    use std::arch::x86_64::{
        __m256, _CMP_LE_OQ, _CMP_LT_OQ, _mm256_add_ps, _mm256_andnot_ps, _mm256_cmp_ps,
        _mm256_fmadd_ps, _mm256_fmsub_ps, _mm256_load_ps, _mm256_max_ps, _mm256_min_ps,
        _mm256_movemask_ps, _mm256_mul_ps, _mm256_set1_ps, _mm256_store_ps, _mm256_sub_ps,
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
                && is_x86_feature_detected!("bmi2");
            has_all.then_some(Self(()))
        }

        /// The query's answer, compiled with the instructions.
        #[inline]
        pub fn answer<Q: Query>(self, query: &Q) -> Q::Answer {
            // SAFETY: the only condition is that the machine has the features, which `self` proves.
            unsafe { with_avx2(self, query) }
        }
    }

    #[target_feature(enable = "avx2,fma,bmi1,bmi2")]
    fn with_avx2<Q: Query>(proof: Avx2, query: &Q) -> Q::Answer {
        query.answer(proof)
    }

    /// Calls an instruction.
    macro_rules! instruction {
        ($call:expr) => {{
            // SAFETY: the only condition is that the machine has the instruction, which the `Avx2` at hand proves; pointers
            // come from references to eight aligned numbers.
            unsafe { $call }
        }};
    }

    impl Simd for Avx2 {
        type F32x8 = __m256;

        #[inline(always)]
        fn load(self, lanes: &Lanes) -> __m256 {
            instruction!(_mm256_load_ps(lanes.0.as_ptr()))
        }

        #[inline(always)]
        fn store(self, x: __m256) -> Lanes {
            let mut lanes = Lanes([0.0; super::LANES]);
            instruction!(_mm256_store_ps(lanes.0.as_mut_ptr(), x));
            lanes
        }

        #[inline(always)]
        fn splat(self, x: f32) -> __m256 {
            instruction!(_mm256_set1_ps(x))
        }

        #[inline(always)]
        fn add(self, a: __m256, b: __m256) -> __m256 {
            instruction!(_mm256_add_ps(a, b))
        }

        #[inline(always)]
        fn sub(self, a: __m256, b: __m256) -> __m256 {
            instruction!(_mm256_sub_ps(a, b))
        }

        #[inline(always)]
        fn mul(self, a: __m256, b: __m256) -> __m256 {
            instruction!(_mm256_mul_ps(a, b))
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
        fn abs(self, x: __m256) -> __m256 {
            instruction!(_mm256_andnot_ps(_mm256_set1_ps(-0.0), x))
        }

        #[inline(always)]
        fn smaller(self, new: __m256, old: __m256) -> __m256 {
            // The second operand is the result where either is NaN.
            instruction!(_mm256_min_ps(new, old))
        }

        #[inline(always)]
        fn larger(self, new: __m256, old: __m256) -> __m256 {
            instruction!(_mm256_max_ps(new, old))
        }

        #[inline(always)]
        fn less(self, a: __m256, b: __m256) -> LaneSet {
            let bits = instruction!(_mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(a, b)));
            LaneSet(bits.cast_unsigned())
        }

        #[inline(always)]
        fn less_or_equal(self, a: __m256, b: __m256) -> LaneSet {
            let bits = instruction!(_mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b)));
            LaneSet(bits.cast_unsigned())
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

    impl Query for Everything {
        /// Results that must agree in every bit, sets, and products that may be rounded once or twice.
        type Answer = (Vec<[f32; LANES]>, Vec<LaneSet>, Vec<[f32; LANES]>);

        fn answer<S: Simd>(&self, simd: S) -> Self::Answer {
            let [a, b, c] = [&self.a, &self.b, &self.c].map(|lanes| simd.load(lanes));
            let exact = [
                simd.add(a, b),
                simd.sub(a, b),
                simd.mul(a, b),
                simd.abs(a),
                simd.smaller(a, b),
                simd.larger(a, b),
                simd.splat(self.a.0[0]),
            ];
            let fused = [simd.mul_add(a, b, c), simd.mul_sub(a, b, c)];
            (
                exact.map(|x| simd.store(x).0).to_vec(),
                vec![simd.less(a, b), simd.less_or_equal(a, b)],
                fused.map(|x| simd.store(x).0).to_vec(),
            )
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
            let bits = |rows: &[[f32; LANES]]| -> Vec<_> {
                // Which NaN it is does not matter.
                let bits = |x: f32| if x.is_nan() { None } else { Some(x.to_bits()) };
                rows.iter().map(|row| row.map(bits)).collect()
            };
            assert_eq!(bits(&wide.0), bits(&portable.0));
            assert_eq!(wide.1, portable.1);
            // The product is rounded, or not, and the sum is rounded.
            let product = Portable.mul(query.a, query.b).0;
            for (wide, portable) in wide.2.iter().zip(&portable.2) {
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
        let one = LaneSet(2);
        assert_eq!((set.and(one), set.and_not(one)), (one, LaneSet(64)));
        assert!(set.and_not(set).into_iter().is_empty());
    }
}
