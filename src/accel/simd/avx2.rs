//! The one module with `unsafe` code: instructions that not every machine has, behind a value that only machines with them make.
//! Left to itself, the compiler turned the loops of [`super::Portable`] into a mixture of two and four lanes.

use super::{Arithmetic, Half, LANES, LaneSet, Lanes, Query, Simd};
use std::arch::x86_64::{
    __m256, __m256d, _CMP_LE_OQ, _CMP_LT_OQ, _MM_HINT_T0, _mm_cvtss_f32, _mm_load_ps, _mm_max_ps,
    _mm_max_ss, _mm_min_ps, _mm_min_ss, _mm_movehdup_ps, _mm_movehl_ps, _mm_prefetch,
    _mm_storeu_ps, _mm256_add_pd, _mm256_add_ps, _mm256_andnot_pd, _mm256_andnot_ps,
    _mm256_castps256_ps128, _mm256_cmp_pd, _mm256_cmp_ps, _mm256_cvtpd_ps, _mm256_cvtps_pd,
    _mm256_div_pd, _mm256_div_ps, _mm256_extractf128_ps, _mm256_fmadd_ps, _mm256_fmsub_ps,
    _mm256_load_ps, _mm256_max_pd, _mm256_max_ps, _mm256_min_pd, _mm256_min_ps, _mm256_movemask_pd,
    _mm256_movemask_ps, _mm256_mul_pd, _mm256_mul_ps, _mm256_set1_pd, _mm256_set1_ps,
    _mm256_store_ps, _mm256_sub_pd, _mm256_sub_ps,
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
