use super::{Arithmetic, Half, LANES, LaneSet, Lanes, Simd};

/// The instructions that every machine has: loops over lanes, which compilers turn into what vectors there are.
#[derive(Clone, Copy, Debug)]
pub struct Portable;

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
