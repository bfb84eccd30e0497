//! Lanes without instructions of a particular machine: the fallback, and the reference that the others are tested against.

use super::{
    Arithmetic, DOUBLES, Doubles, Floats, LANES, LaneSet, Lanes, Places, Simd, WIDE_LANES,
    WideLanes,
};

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
    ($number:ty) => {
        impl<const N: usize> Arithmetic<[$number; N]> for Portable {
            #[inline(always)]
            fn add(self, a: [$number; N], b: [$number; N]) -> [$number; N] {
                Self::each(a, b, |a, b| a + b)
            }

            #[inline(always)]
            fn sub(self, a: [$number; N], b: [$number; N]) -> [$number; N] {
                Self::each(a, b, |a, b| a - b)
            }

            #[inline(always)]
            fn mul(self, a: [$number; N], b: [$number; N]) -> [$number; N] {
                Self::each(a, b, |a, b| a * b)
            }

            #[inline(always)]
            fn div(self, a: [$number; N], b: [$number; N]) -> [$number; N] {
                Self::each(a, b, |a, b| a / b)
            }

            #[inline(always)]
            fn abs(self, x: [$number; N]) -> [$number; N] {
                Self::each(x, x, |x, _| x.abs())
            }

            #[inline(always)]
            fn smaller(self, new: [$number; N], old: [$number; N]) -> [$number; N] {
                Self::each(new, old, |new, old| if new < old { new } else { old })
            }

            #[inline(always)]
            fn larger(self, new: [$number; N], old: [$number; N]) -> [$number; N] {
                Self::each(new, old, |new, old| if new > old { new } else { old })
            }

            #[inline(always)]
            fn less(self, a: [$number; N], b: [$number; N]) -> LaneSet {
                Self::each_bit(a, b, |a, b| a < b)
            }

            #[inline(always)]
            fn less_or_equal(self, a: [$number; N], b: [$number; N]) -> LaneSet {
                Self::each_bit(a, b, |a, b| a <= b)
            }
        }
    };
}

portable_arithmetic!(f32);
portable_arithmetic!(f64);

impl<const N: usize> Floats<[f32; N]> for Portable {
    #[inline(always)]
    fn splat(self, x: f32) -> [f32; N] {
        [x; N]
    }

    #[inline(always)]
    fn mul_add(self, a: [f32; N], b: [f32; N], c: [f32; N]) -> [f32; N] {
        self.add(self.mul(a, b), c)
    }

    #[inline(always)]
    fn mul_sub(self, a: [f32; N], b: [f32; N], c: [f32; N]) -> [f32; N] {
        self.sub(self.mul(a, b), c)
    }

    #[inline(always)]
    fn least(self, x: [f32; N]) -> f32 {
        x.into_iter().fold(f32::INFINITY, f32::min)
    }

    #[inline(always)]
    fn greatest(self, x: [f32; N]) -> f32 {
        x.into_iter().fold(f32::NEG_INFINITY, f32::max)
    }
}

impl Doubles<[f64; DOUBLES]> for Portable {
    #[inline(always)]
    fn splat_double(self, x: f64) -> [f64; DOUBLES] {
        [x; DOUBLES]
    }

    #[inline(always)]
    fn store_rounded(self, x: [f64; DOUBLES]) -> Lanes {
        let mut lanes = Lanes([0.0; _]);
        for (number, x) in lanes.0.iter_mut().zip(x) {
            #[expect(
                clippy::cast_possible_truncation,
                reason = "the rounding is the purpose"
            )]
            let rounded = x as f32;
            *number = rounded;
        }
        lanes
    }

    #[cfg(test)]
    fn store_doubles(self, x: [f64; DOUBLES]) -> Vec<f64> {
        x.to_vec()
    }
}

impl Simd for Portable {
    // As many as the four lanes of the compiler's vectors make it.
    const REGISTERS_PER_PACKET: usize = 4;

    type F32x8 = [f32; LANES];
    type F32x16 = [f32; WIDE_LANES];
    type F64x4 = [f64; DOUBLES];
    type F64s = [f64; DOUBLES];
    const DOUBLES_PER_REGISTER: usize = DOUBLES;

    #[inline(always)]
    fn load(self, lanes: &Lanes) -> [f32; LANES] {
        lanes.0
    }

    #[inline(always)]
    fn store(self, x: [f32; LANES]) -> Lanes {
        Lanes(x)
    }

    #[inline(always)]
    fn load_wide(self, lanes: &WideLanes) -> [f32; WIDE_LANES] {
        lanes.0
    }

    #[inline(always)]
    fn store_wide(self, x: [f32; WIDE_LANES]) -> WideLanes {
        WideLanes(x)
    }

    #[inline(always)]
    fn prefetch<T>(self, _what: &T) {}

    #[inline(always)]
    fn load_doubles(self, numbers: &[f32; DOUBLES]) -> [f64; DOUBLES] {
        let mut result = [0.0; _];
        for (result, &number) in result.iter_mut().zip(numbers) {
            *result = f64::from(number);
        }
        result
    }

    #[inline(always)]
    fn pick(self, lanes: &Lanes, places: Places) -> [f64; DOUBLES] {
        let mut result = [0.0; _];
        for (index, result) in result.iter_mut().enumerate() {
            *result = f64::from(lanes.0[places.get(index) % LANES]);
        }
        result
    }

    #[inline(always)]
    fn pick_wide(self, lanes: &WideLanes, places: Places) -> [f64; DOUBLES] {
        let mut result = [0.0; _];
        for (index, result) in result.iter_mut().enumerate() {
            *result = f64::from(lanes.0[places.get(index)]);
        }
        result
    }
}
