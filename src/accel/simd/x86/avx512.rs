//! Lanes by AVX-512 (F, DQ and VL): a register holds sixteen `f32` or eight `f64`. Eight `f32` and four `f64` stay in registers of
//! 256 bits.

#[cfg(test)]
use super::super::LANES;
use super::super::{
    Arithmetic, DOUBLES, Doubles, Floats, LaneSet, Lanes, Places, Query, Simd, WideLanes,
};
use super::avx2::indices;
use super::{Avx2, arithmetic, instruction};
use std::arch::x86_64::{
    __m256, __m256d, __m512, __m512d, _CMP_LE_OQ, _CMP_LT_OQ, _mm256_add_pd, _mm256_add_ps,
    _mm256_andnot_pd, _mm256_andnot_ps, _mm256_cmp_pd_mask, _mm256_cmp_ps_mask, _mm256_div_pd,
    _mm256_div_ps, _mm256_max_pd, _mm256_max_ps, _mm256_min_pd, _mm256_min_ps, _mm256_mul_pd,
    _mm256_mul_ps, _mm256_permutexvar_ps, _mm256_set1_pd, _mm256_set1_ps, _mm256_sub_pd,
    _mm256_sub_ps, _mm512_add_pd, _mm512_add_ps, _mm512_andnot_pd, _mm512_andnot_ps,
    _mm512_castps512_ps256, _mm512_castsi256_si512, _mm512_cmp_pd_mask, _mm512_cmp_ps_mask,
    _mm512_cvtpd_ps, _mm512_cvtps_pd, _mm512_div_pd, _mm512_div_ps, _mm512_fmadd_ps,
    _mm512_fmsub_ps, _mm512_load_ps, _mm512_max_pd, _mm512_max_ps, _mm512_min_pd, _mm512_min_ps,
    _mm512_mul_pd, _mm512_mul_ps, _mm512_permutexvar_ps, _mm512_reduce_max_ps,
    _mm512_reduce_min_ps, _mm512_set1_pd, _mm512_set1_ps, _mm512_store_ps, _mm512_sub_pd,
    _mm512_sub_ps,
};

/// Proof that the machine has the instructions: [`Avx512::detect`] alone makes one.
///
/// What works on sixteen numbers is one instruction, and comparisons make sets of lanes without a detour. Eight numbers are
/// added and multiplied as by [`Avx2`].
#[derive(Clone, Copy, Debug)]
pub struct Avx512(Avx2);

impl Avx512 {
    /// `None` where the machine lacks any of the instructions.
    #[inline]
    pub fn detect() -> Option<Self> {
        let has_all = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512vl");
        Avx2::detect().filter(|_| has_all).map(Self)
    }

    /// The query's answer, compiled with the instructions.
    #[inline]
    pub fn answer<Q: Query>(self, query: &Q) -> Q::Answer {
        // SAFETY: the only condition is that the machine has the features, which `self` proves.
        unsafe { with_avx512(self, query) }
    }
}

#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,popcnt")]
fn with_avx512<Q: Query>(proof: Avx512, query: &Q) -> Q::Answer {
    query.answer(proof)
}

macro_rules! compare_ps {
    ($predicate:ident, $a:expr, $b:expr) => {
        LaneSet(_mm256_cmp_ps_mask::<$predicate>($a, $b).into())
    };
}

macro_rules! compare_pd {
    ($predicate:ident, $a:expr, $b:expr) => {
        LaneSet(_mm256_cmp_pd_mask::<$predicate>($a, $b).into())
    };
}

macro_rules! compare_wide_pd {
    ($predicate:ident, $a:expr, $b:expr) => {
        LaneSet(_mm512_cmp_pd_mask::<$predicate>($a, $b).into())
    };
}

macro_rules! compare_wide_ps {
    ($predicate:ident, $a:expr, $b:expr) => {
        LaneSet(_mm512_cmp_ps_mask::<$predicate>($a, $b).into())
    };
}

arithmetic!(
    Avx512,
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
    Avx512,
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
arithmetic!(
    Avx512,
    __m512,
    _mm512_add_ps,
    _mm512_sub_ps,
    _mm512_mul_ps,
    _mm512_div_ps,
    _mm512_andnot_ps,
    _mm512_set1_ps,
    _mm512_min_ps,
    _mm512_max_ps,
    compare_wide_ps
);

arithmetic!(
    Avx512,
    __m512d,
    _mm512_add_pd,
    _mm512_sub_pd,
    _mm512_mul_pd,
    _mm512_div_pd,
    _mm512_andnot_pd,
    _mm512_set1_pd,
    _mm512_min_pd,
    _mm512_max_pd,
    compare_wide_pd
);

impl Floats<__m256> for Avx512 {
    #[inline(always)]
    fn splat(self, x: f32) -> __m256 {
        self.0.splat(x)
    }

    #[inline(always)]
    fn mul_add(self, a: __m256, b: __m256, c: __m256) -> __m256 {
        self.0.mul_add(a, b, c)
    }

    #[inline(always)]
    fn mul_sub(self, a: __m256, b: __m256, c: __m256) -> __m256 {
        self.0.mul_sub(a, b, c)
    }

    #[inline(always)]
    fn least(self, x: __m256) -> f32 {
        self.0.least(x)
    }

    #[inline(always)]
    fn greatest(self, x: __m256) -> f32 {
        self.0.greatest(x)
    }
}

impl Floats<__m512> for Avx512 {
    #[inline(always)]
    fn splat(self, x: f32) -> __m512 {
        instruction!(_mm512_set1_ps(x))
    }

    #[inline(always)]
    fn mul_add(self, a: __m512, b: __m512, c: __m512) -> __m512 {
        instruction!(_mm512_fmadd_ps(a, b, c))
    }

    #[inline(always)]
    fn mul_sub(self, a: __m512, b: __m512, c: __m512) -> __m512 {
        instruction!(_mm512_fmsub_ps(a, b, c))
    }

    #[inline(always)]
    fn least(self, x: __m512) -> f32 {
        instruction!(_mm512_reduce_min_ps(x))
    }

    #[inline(always)]
    fn greatest(self, x: __m512) -> f32 {
        instruction!(_mm512_reduce_max_ps(x))
    }
}

impl Doubles<__m256d> for Avx512 {
    #[inline(always)]
    fn splat_double(self, x: f64) -> __m256d {
        self.0.splat_double(x)
    }

    #[inline(always)]
    fn store_rounded(self, x: __m256d) -> Lanes {
        self.0.store_rounded(x)
    }

    #[cfg(test)]
    fn store_doubles(self, x: __m256d) -> Vec<f64> {
        self.0.store_doubles(x)
    }
}

impl Doubles<__m512d> for Avx512 {
    #[inline(always)]
    fn splat_double(self, x: f64) -> __m512d {
        instruction!(_mm512_set1_pd(x))
    }

    #[inline(always)]
    fn store_rounded(self, x: __m512d) -> Lanes {
        self.store(instruction!(_mm512_cvtpd_ps(x)))
    }

    #[cfg(test)]
    fn store_doubles(self, x: __m512d) -> Vec<f64> {
        let mut numbers = vec![0.0; LANES];
        instruction!(std::arch::x86_64::_mm512_storeu_pd(numbers.as_mut_ptr(), x));
        numbers
    }
}

impl Simd for Avx512 {
    const REGISTERS_PER_PACKET: usize = 1;

    type F32x8 = __m256;
    type F32x16 = __m512;
    type F64x4 = __m256d;
    type F64s = __m512d;
    const DOUBLES_PER_REGISTER: usize = 8;

    #[inline(always)]
    fn load(self, lanes: &Lanes) -> __m256 {
        self.0.load(lanes)
    }

    #[inline(always)]
    fn store(self, x: __m256) -> Lanes {
        self.0.store(x)
    }

    #[inline(always)]
    fn load_wide(self, lanes: &WideLanes) -> __m512 {
        instruction!(_mm512_load_ps(lanes.0.as_ptr()))
    }

    #[inline(always)]
    fn store_wide(self, x: __m512) -> WideLanes {
        let mut lanes = WideLanes([0.0; _]);
        instruction!(_mm512_store_ps(lanes.0.as_mut_ptr(), x));
        lanes
    }

    #[inline(always)]
    fn prefetch<T>(self, what: &T) {
        self.0.prefetch(what);
    }

    #[inline(always)]
    fn load_doubles(self, numbers: &[f32; DOUBLES]) -> __m256d {
        self.0.load_doubles(numbers)
    }

    #[inline(always)]
    fn pick(self, lanes: &Lanes, places: Places) -> __m512d {
        let lanes = self.load(lanes);
        instruction!(_mm512_cvtps_pd(_mm256_permutexvar_ps(
            indices(places),
            lanes
        )))
    }

    #[inline(always)]
    fn pick_wide(self, lanes: &WideLanes, places: Places) -> __m512d {
        let lanes = self.load_wide(lanes);
        instruction!({
            let indices = _mm512_castsi256_si512(indices(places));
            let picked = _mm512_permutexvar_ps(indices, lanes);
            _mm512_cvtps_pd(_mm512_castps512_ps256(picked))
        })
    }
}
