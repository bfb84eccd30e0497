//! Random numbers, well spread within a pixel: a function of seed, pixel, sample and dimension alone, so that a picture does not
//! depend on threads or on the order of work.

use crate::math::Vec2;

/// What a pair of random numbers decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// Where in the pixel a camera ray passes.
    Pixel,
    /// Where it passes the lens.
    Lens,
    /// Which point of a light shines.
    Light,
    /// In which direction a near light is looked for instead.
    NearLight,
    /// In which direction occlusion is looked for.
    AmbientOcclusion,
    /// Whether a boundary of glass reflects or refracts.
    Boundary,
    /// Which light is aimed at.
    LightChoice,
    /// Which point of an emitting object shines.
    EmitterPoint,
    /// Which lobe of a material scatters, and where to.
    Direction,
    /// Whether a path ends.
    Roulette,
    /// In which direction the background's image is looked at.
    Background,
}

impl Decision {
    /// All of them.
    pub const ALL: [Self; 11] = [
        Self::Pixel,
        Self::Lens,
        Self::Light,
        Self::NearLight,
        Self::AmbientOcclusion,
        Self::Boundary,
        Self::LightChoice,
        Self::EmitterPoint,
        Self::Direction,
        Self::Roulette,
        Self::Background,
    ];

    /// In words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Pixel => "point in the pixel",
            Self::Lens => "point on the lens",
            Self::Light => "point on a light",
            Self::NearLight => "direction to a near light",
            Self::AmbientOcclusion => "direction of occlusion",
            Self::Boundary => "reflection or refraction",
            Self::LightChoice => "light",
            Self::EmitterPoint => "point on an emitter",
            Self::Direction => "direction of a path",
            Self::Roulette => "end of a path",
            Self::Background => "direction to the sky",
        }
    }
}

/// A pair of dimensions of its own for every decision at every bounce. Because dimensions are named and not counted, a
/// decision a scene does not need can be left out without changing any other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dimension {
    decision: Decision,
    bounce: u32,
    item: u32,
}

impl Dimension {
    /// A decision that is taken once per camera sample.
    #[must_use]
    pub const fn once(decision: Decision) -> Self {
        Self {
            decision,
            bounce: 0,
            item: 0,
        }
    }

    /// A decision after `bounce` scattering events.
    #[must_use]
    pub const fn at(decision: Decision, bounce: u32) -> Self {
        Self {
            decision,
            bounce,
            item: 0,
        }
    }

    /// The same decision about one of several things, such as lights.
    #[must_use]
    pub const fn about(self, item: u32) -> Self {
        Self { item, ..self }
    }

    /// What it decides.
    #[must_use]
    pub const fn decision(self) -> Decision {
        self.decision
    }

    /// A number that no other dimension has, as long as paths have less than 2²⁸ bounces.
    const fn word(self) -> u64 {
        ((self.bounce << 4 | self.decision as u32) as u64) << 32 | self.item as u64
    }
}

/// The random numbers of one sample of one pixel: an Owen-scrambled Sobol sequence per pixel and decision.
///
/// Each decision takes the first two Sobol dimensions with its own shuffle and scrambles, which keeps every pair well spread
/// and different pairs independent. Source: Burley, Practical Hash-based Owen Scrambling, JCGT 9(4), 2020, with the hash
/// constants of Vegdahl, Building a Better LK Hash, 2021.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampler {
    /// Of the seed and the pixel.
    key: u64,
    index: u32,
    /// The bits of `index` in reverse order.
    reversed: u32,
}

impl Sampler {
    /// The numbers of sample `index` of pixel `(x, y)` of the full picture.
    #[must_use]
    pub fn new(seed: u64, x: u32, y: u32, index: u32) -> Self {
        Self {
            key: mix(mix(seed) ^ (u64::from(y) << 32 | u64::from(x))),
            index,
            reversed: index.reverse_bits(),
        }
    }

    /// One number in `[0, 1)`, uniform as `index` runs.
    #[must_use]
    #[inline]
    pub fn next_1d(&self, dimension: Dimension) -> f32 {
        self.scrambles(dimension).single(self.reversed)
    }

    /// Two numbers in `[0, 1)`, uniform over the square as `index` runs.
    #[must_use]
    #[inline]
    pub fn next_2d(&self, dimension: Dimension) -> Vec2 {
        self.scrambles(dimension).pair(self.reversed)
    }

    /// The numbers of a decision taken `count` times per sample. All turns of all samples are one well-spread sequence.
    #[must_use]
    pub fn turns(&self, dimension: Dimension, count: u32) -> Turns {
        Turns {
            first: self.index.wrapping_mul(count),
            scrambles: self.scrambles(dimension),
        }
    }

    fn scrambles(&self, dimension: Dimension) -> Scrambles {
        Scrambles::from_bits(mix(self.key ^ dimension.word()))
    }
}

/// The random numbers of a decision that one camera sample takes several times, see [`Sampler::turns`].
#[derive(Clone, Copy, Debug)]
pub struct Turns {
    first: u32,
    scrambles: Scrambles,
}

impl Turns {
    /// Two numbers in `[0, 1)` for number `turn`, from 0.
    #[must_use]
    #[inline]
    pub fn next_2d(&self, turn: u32) -> Vec2 {
        let index = self.first.wrapping_add(turn);
        self.scrambles.pair(index.reverse_bits())
    }
}

/// The seeds that tell one decision's numbers from another's: of their order and of each number.
#[derive(Clone, Copy, Debug)]
struct Scrambles {
    order: u32,
    x: u32,
    y: u32,
}

impl Scrambles {
    #[expect(clippy::cast_possible_truncation, reason = "parts of the bits")]
    fn from_bits(bits: u64) -> Self {
        Self {
            order: (bits >> 32) as u32,
            x: bits as u32,
            // Another product of all bits, of which the upper half is the good one.
            y: (bits.wrapping_mul(0xd6e8_feb8_6659_fd93) >> 32) as u32,
        }
    }

    /// The number of the sequence at an index whose bits, in reverse order, are `reversed`.
    #[inline]
    fn single(&self, reversed: u32) -> f32 {
        let index = self.shuffled(reversed);
        unit_from_bits(owen_scramble(index, self.x).reverse_bits())
    }

    /// The pair of the sequence at an index whose bits, in reverse order, are `reversed`.
    #[inline]
    fn pair(&self, reversed: u32) -> Vec2 {
        let index = self.shuffled(reversed);
        // The first Sobol dimension is the index read backwards, the second its Taylor shift.
        let x = owen_scramble(index, self.x);
        let y = owen_scramble(taylor_shift(index), self.y);
        // Both are turned round at once, which makes them change places.
        let both = (u64::from(x) << 32 | u64::from(y)).reverse_bits();
        #[expect(clippy::cast_possible_truncation, reason = "the two halves")]
        let (x, y) = (both as u32, (both >> 32) as u32);
        Vec2::new(unit_from_bits(x), unit_from_bits(y))
    }

    /// Aligned blocks of 2ᵐ indices stay blocks, in another order and place: prefixes stay nets.
    fn shuffled(&self, reversed: u32) -> u32 {
        owen_scramble(reversed, self.order).reverse_bits()
    }
}

/// The second dimension of the Sobol sequence at `index`, its bits in reverse order.
///
/// Its direction numbers are the powers of `1 + x` over GF(2), so this is the polynomial with the bits of `index` as
/// coefficients, taken at `1 + x`. As `(1 + x)^s = 1 + x^s` for powers of two, halves of every block add up.
/// Source: Joe & Kuo, Constructing Sobol Sequences with Better Two-Dimensional Projections, 2008, for the numbers.
fn taylor_shift(index: u32) -> u32 {
    let mut bits = index;
    for (shift, lower_halves) in [
        (16, 0x0000_ffff),
        (8, 0x00ff_00ff),
        (4, 0x0f0f_0f0f),
        (2, 0x3333_3333),
        (1, 0x5555_5555),
    ] {
        bits ^= (bits >> shift) & lower_halves;
    }
    bits
}

/// Nested uniform (Owen) scrambling of a fraction given with its bits in reverse order: each bit is flipped at random by a
/// function of the bits above it, here below it.
fn owen_scramble(reversed: u32, seed: u32) -> u32 {
    let mut x = reversed;
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// A 64-bit hash without fixed structure. Source: Steele, Lea, Flood, Fast Splittable Pseudorandom Number Generators, 2014: a
/// step of their generator (Stafford's variant 13).
fn mix(value: u64) -> u64 {
    let mut x = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// The upper 24 bits as a number in `[0, 1)`, each exactly representable.
fn unit_from_bits(bits: u32) -> f32 {
    (bits >> 8) as f32 / 16_777_216.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(seed: u64, x: u32, y: u32, count: u32) -> Vec<Vec2> {
        (0..count)
            .map(|index| Sampler::new(seed, x, y, index).next_2d(Dimension::once(Decision::Pixel)))
            .collect()
    }

    /// A scrambled (0, m, 2)-net: each elementary interval of area 2⁻ᵐ holds exactly one of 2ᵐ points.
    #[test]
    fn every_power_of_two_prefix_is_a_net() {
        for pixel in 0..8 {
            for m in [1_u32, 4, 8] {
                for split in 0..=m {
                    let (columns, rows) = (1_u32 << split, 1_u32 << (m - split));
                    let mut counts = vec![0; 1 << m];
                    for point in points(pixel.into(), pixel, 3, 1 << m) {
                        #[expect(
                            clippy::cast_possible_truncation,
                            clippy::cast_sign_loss,
                            reason = "cell indices"
                        )]
                        let (column, row) = (
                            (point.x * columns as f32) as usize,
                            (point.y * rows as f32) as usize,
                        );
                        counts[row * columns as usize + column] += 1;
                    }
                    assert!(
                        counts.iter().all(|&count| count == 1),
                        "m {m}, {columns}×{rows}: {counts:?}"
                    );
                }
            }
        }
    }

    /// χ² over 16×16 cells of the first samples of 2¹⁶ pixels, which no net property helps: α = 0.001 (χ² of 255 degrees
    /// of freedom below 330.5), seed fixed.
    #[test]
    fn different_pixels_are_independent() {
        let mut counts = vec![0_u32; 256];
        for pixel in 0..65_536_u32 {
            let point = Sampler::new(7, pixel % 256, pixel / 256, 0)
                .next_2d(Dimension::once(Decision::Pixel));
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "cell indices"
            )]
            let cell = (point.y * 16.0) as usize * 16 + (point.x * 16.0) as usize;
            counts[cell] += 1;
        }
        let chi_squared: f64 = counts
            .iter()
            .map(|&n| (f64::from(n) - 256.0).powi(2) / 256.0)
            .sum();
        assert!(chi_squared < 330.5, "{chi_squared}");
    }

    #[test]
    fn numbers_depend_on_seed_pixel_and_sample() {
        let base = points(0, 0, 0, 4);
        assert_eq!(base, points(0, 0, 0, 4));
        for other in [
            points(1, 0, 0, 4),
            points(1 << 32, 0, 0, 4),
            points(0, 1, 0, 4),
            points(0, 0, 1, 4),
        ] {
            assert_ne!(base, other);
        }
    }
}
