//! Lanes by AVX2 and FMA: a register holds eight `f32` or four `f64`.

use super::super::{
    Arithmetic, DOUBLES, Doubles, Floats, LaneSet, Lanes, Places, Query, Simd, WideLanes,
};
use super::{arithmetic, instruction};
use std::arch::x86_64::{
    __m256, __m256d, __m256i, _CMP_LE_OQ, _CMP_LT_OQ, _MM_HINT_T0, _mm_cvtsi64_si128,
    _mm_cvtss_f32, _mm_loadu_ps, _mm_max_ps, _mm_max_ss, _mm_min_ps, _mm_min_ss, _mm_movehdup_ps,
    _mm_movehl_ps, _mm_prefetch, _mm256_add_pd, _mm256_add_ps, _mm256_andnot_pd, _mm256_andnot_ps,
    _mm256_blendv_ps, _mm256_castps256_ps128, _mm256_castsi256_ps, _mm256_cmp_pd, _mm256_cmp_ps,
    _mm256_cvtepu8_epi32, _mm256_cvtpd_ps, _mm256_cvtps_pd, _mm256_div_pd, _mm256_div_ps,
    _mm256_extractf128_ps, _mm256_fmadd_ps, _mm256_fmsub_ps, _mm256_load_ps, _mm256_max_pd,
    _mm256_max_ps, _mm256_min_pd, _mm256_min_ps, _mm256_movemask_pd, _mm256_movemask_ps,
    _mm256_mul_pd, _mm256_mul_ps, _mm256_permutevar8x32_ps, _mm256_set1_pd, _mm256_set1_ps,
    _mm256_slli_epi32, _mm256_store_ps, _mm256_sub_pd, _mm256_sub_ps, _mm256_zextps128_ps256,
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

macro_rules! compare_ps {
    ($predicate:ident, $a:expr, $b:expr) => {
        LaneSet(_mm256_movemask_ps(_mm256_cmp_ps::<$predicate>($a, $b)).cast_unsigned())
    };
}

macro_rules! compare_pd {
    ($predicate:ident, $a:expr, $b:expr) => {
        LaneSet(_mm256_movemask_pd(_mm256_cmp_pd::<$predicate>($a, $b)).cast_unsigned())
    };
}

arithmetic!(
    Avx2,
    __m256,
    _mm256_add_ps,
    _mm256_sub_ps,
    _mm256_mul_ps,
    _mm256_div_ps,
    _mm256_andnot_ps,
    _mm256_set1_ps,
    _mm256_min_ps,
    _mm256_max_ps,
    compare_ps
);
arithmetic!(
    Avx2,
    __m256d,
    _mm256_add_pd,
    _mm256_sub_pd,
    _mm256_mul_pd,
    _mm256_div_pd,
    _mm256_andnot_pd,
    _mm256_set1_pd,
    _mm256_min_pd,
    _mm256_max_pd,
    compare_pd
);

impl Floats<__m256> for Avx2 {
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
}

impl Doubles<__m256d> for Avx2 {
    #[inline(always)]
    fn splat_double(self, x: f64) -> __m256d {
        instruction!(_mm256_set1_pd(x))
    }

    #[inline(always)]
    fn store_rounded(self, x: __m256d) -> Lanes {
        self.store(instruction!(_mm256_zextps128_ps256(_mm256_cvtpd_ps(x))))
    }

    #[cfg(test)]
    fn store_doubles(self, x: __m256d) -> Vec<f64> {
        let mut numbers = vec![0.0; DOUBLES];
        instruction!(std::arch::x86_64::_mm256_storeu_pd(numbers.as_mut_ptr(), x));
        numbers
    }
}

/// Places as the instructions want them.
#[inline(always)]
pub fn indices(Places(bytes): Places) -> __m256i {
    instruction!(_mm256_cvtepu8_epi32(_mm_cvtsi64_si128(bytes.cast_signed())))
}

/// Sixteen numbers are two registers.
type Pair = [__m256; 2];

impl Arithmetic<Pair> for Avx2 {
    #[inline(always)]
    fn add(self, a: Pair, b: Pair) -> Pair {
        [self.add(a[0], b[0]), self.add(a[1], b[1])]
    }

    #[inline(always)]
    fn sub(self, a: Pair, b: Pair) -> Pair {
        [self.sub(a[0], b[0]), self.sub(a[1], b[1])]
    }

    #[inline(always)]
    fn mul(self, a: Pair, b: Pair) -> Pair {
        [self.mul(a[0], b[0]), self.mul(a[1], b[1])]
    }

    #[inline(always)]
    fn div(self, a: Pair, b: Pair) -> Pair {
        [self.div(a[0], b[0]), self.div(a[1], b[1])]
    }

    #[inline(always)]
    fn abs(self, x: Pair) -> Pair {
        [self.abs(x[0]), self.abs(x[1])]
    }

    #[inline(always)]
    fn smaller(self, new: Pair, old: Pair) -> Pair {
        [self.smaller(new[0], old[0]), self.smaller(new[1], old[1])]
    }

    #[inline(always)]
    fn larger(self, new: Pair, old: Pair) -> Pair {
        [self.larger(new[0], old[0]), self.larger(new[1], old[1])]
    }

    #[inline(always)]
    fn less(self, a: Pair, b: Pair) -> LaneSet {
        self.less(a[0], b[0]).followed_by(self.less(a[1], b[1]))
    }

    #[inline(always)]
    fn less_or_equal(self, a: Pair, b: Pair) -> LaneSet {
        let lower = self.less_or_equal(a[0], b[0]);
        lower.followed_by(self.less_or_equal(a[1], b[1]))
    }
}

impl Floats<Pair> for Avx2 {
    #[inline(always)]
    fn splat(self, x: f32) -> Pair {
        [self.splat(x); 2]
    }

    #[inline(always)]
    fn mul_add(self, a: Pair, b: Pair, c: Pair) -> Pair {
        [
            self.mul_add(a[0], b[0], c[0]),
            self.mul_add(a[1], b[1], c[1]),
        ]
    }

    #[inline(always)]
    fn mul_sub(self, a: Pair, b: Pair, c: Pair) -> Pair {
        [
            self.mul_sub(a[0], b[0], c[0]),
            self.mul_sub(a[1], b[1], c[1]),
        ]
    }

    #[inline(always)]
    fn least(self, [lower, upper]: Pair) -> f32 {
        self.least(self.smaller(lower, upper))
    }

    #[inline(always)]
    fn greatest(self, [lower, upper]: Pair) -> f32 {
        self.greatest(self.larger(lower, upper))
    }
}

impl Simd for Avx2 {
    const REGISTERS_PER_PACKET: usize = 2;

    type F32x8 = __m256;
    type F32x16 = Pair;
    type F64x4 = __m256d;
    type F64s = __m256d;
    const DOUBLES_PER_REGISTER: usize = 4;

    #[inline(always)]
    fn load(self, lanes: &Lanes) -> __m256 {
        instruction!(_mm256_load_ps(lanes.0.as_ptr()))
    }

    #[inline(always)]
    fn store(self, x: __m256) -> Lanes {
        let mut lanes = Lanes([0.0; _]);
        instruction!(_mm256_store_ps(lanes.0.as_mut_ptr(), x));
        lanes
    }

    #[inline(always)]
    fn load_wide(self, lanes: &WideLanes) -> Pair {
        let first = lanes.0.as_ptr();
        instruction!([_mm256_load_ps(first), _mm256_load_ps(first.add(8))])
    }

    #[inline(always)]
    fn store_wide(self, [lower, upper]: Pair) -> WideLanes {
        let mut lanes = WideLanes([0.0; _]);
        let first = lanes.0.as_mut_ptr();
        instruction!({
            _mm256_store_ps(first, lower);
            _mm256_store_ps(first.add(8), upper);
        });
        lanes
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
    fn load_doubles(self, numbers: &[f32; DOUBLES]) -> __m256d {
        instruction!(_mm256_cvtps_pd(_mm_loadu_ps(numbers.as_ptr())))
    }

    #[inline(always)]
    fn pick(self, lanes: &Lanes, places: Places) -> __m256d {
        instruction!({
            let picked = _mm256_permutevar8x32_ps(self.load(lanes), indices(places));
            _mm256_cvtps_pd(_mm256_castps256_ps128(picked))
        })
    }

    #[inline(always)]
    fn pick_wide(self, lanes: &WideLanes, places: Places) -> __m256d {
        let [lower, upper] = self.load_wide(lanes);
        instruction!({
            // A permutation heeds the last three bits of an index, a choice the sign: the fourth bit, moved there.
            let indices = indices(places);
            let lower = _mm256_permutevar8x32_ps(lower, indices);
            let upper = _mm256_permutevar8x32_ps(upper, indices);
            let is_upper = _mm256_castsi256_ps(_mm256_slli_epi32::<28>(indices));
            let picked = _mm256_blendv_ps(lower, upper, is_upper);
            _mm256_cvtps_pd(_mm256_castps256_ps128(picked))
        })
    }
}
