//! The one module with `unsafe` code: instructions that not every machine has, behind values that only machines with them make.
//! Left to itself, the compiler turned the loops of [`super::Portable`] into a mixture of two and four lanes.

mod avx2;
mod avx512;

use std::sync::LazyLock;

pub use avx2::Avx2;
pub use avx512::Avx512;

/// The widest instructions that the machine has, looked for once: asking about every one of them took some fifty instructions a ray.
pub static WIDEST: LazyLock<Widest> = LazyLock::new(|| {
    let avx512 = Avx512::detect().map(Widest::Avx512);
    let avx2 = || Avx2::detect().map(Widest::Avx2);
    avx512.or_else(avx2).unwrap_or(Widest::Neither)
});

/// See [`WIDEST`].
#[derive(Clone, Copy, Debug)]
pub enum Widest {
    Avx512(Avx512),
    Avx2(Avx2),
    Neither,
}

/// Calls an instruction.
macro_rules! instruction {
    ($call:expr) => {{
        // SAFETY: the only condition is that the machine has the instruction, which the proof at hand proves; pointers come from
        // references to as many numbers as are moved, aligned where the instruction asks for it.
        unsafe { $call }
    }};
}

/// [`Arithmetic`](super::Arithmetic) by the instructions of these names; `$compare` is a macro that makes a
/// [`LaneSet`](super::LaneSet) of a predicate and two registers.
macro_rules! arithmetic {
    ($proof:ty, $register:ty, $add:ident, $sub:ident, $mul:ident, $div:ident, $and_not:ident, $splat:ident, $min:ident, $max:ident,
     $compare:ident) => {
        impl Arithmetic<$register> for $proof {
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
                instruction!($compare!(_CMP_LT_OQ, a, b))
            }

            #[inline(always)]
            fn less_or_equal(self, a: $register, b: $register) -> LaneSet {
                instruction!($compare!(_CMP_LE_OQ, a, b))
            }
        }
    };
}

use {arithmetic, instruction};
