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
    /// Which lobe of a material scatters.
    Lobe,
    /// Where it scatters to.
    Direction,
    /// Whether a path ends.
    Roulette,
    /// In which direction the background's image is looked at.
    Background,
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

    fn hash(self) -> u32 {
        [self.decision as u32, self.bounce, self.item]
            .into_iter()
            .fold(0, |state, word| mix(state ^ mix(word)))
    }
}

/// The random numbers of one sample of one pixel: an Owen-scrambled Sobol sequence per pixel and decision.
///
/// Each decision takes the first two Sobol dimensions with its own shuffle and scrambles, which keeps every pair well spread
/// and different pairs independent. Source: Burley, Practical Hash-based Owen Scrambling, JCGT 9(4), 2020, with the hash
/// constants of Vegdahl, Building a Better LK Hash, 2021.
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    pixel_seed: u32,
    index: u32,
}

impl Sampler {
    /// The numbers of sample `index` of pixel `(x, y)` of the full picture.
    #[must_use]
    pub fn new(seed: u64, x: u32, y: u32, index: u32) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "the two halves of the seed"
        )]
        let (low, high) = (seed as u32, (seed >> 32) as u32);
        let pixel_seed = [low, high, x, y]
            .into_iter()
            .fold(0, |state, word| mix(state ^ mix(word)));
        Self { pixel_seed, index }
    }

    /// Two numbers in `[0, 1)`, uniform over the square as `index` runs.
    #[must_use]
    pub fn next_2d(&self, dimension: Dimension) -> Vec2 {
        self.next_2d_of(dimension, 0, 1)
    }

    /// [`Sampler::next_2d`] for a decision taken `count` times per sample: number `turn` of them. All turns of all samples are one
    /// well-spread sequence.
    #[must_use]
    pub fn next_2d_of(&self, dimension: Dimension, turn: u32, count: u32) -> Vec2 {
        let seed = mix(self.pixel_seed ^ dimension.hash());
        // Aligned blocks of 2ᵐ indices stay blocks, in another order and place: prefixes stay nets.
        let index = owen_scramble(self.index.wrapping_mul(count).wrapping_add(turn), seed);
        let [x, y] = sobol_2d(index);
        Vec2::new(
            unit_from_bits(owen_scramble(x, mix(seed ^ 1))),
            unit_from_bits(owen_scramble(y, mix(seed ^ 2))),
        )
    }
}

/// The first two dimensions of the Sobol sequence as 32-bit fractions.
fn sobol_2d(index: u32) -> [u32; 2] {
    let mut y = 0;
    let mut direction = 1_u32 << 31;
    let mut rest = index;
    while rest != 0 {
        if rest & 1 == 1 {
            y ^= direction;
        }
        direction ^= direction >> 1;
        rest >>= 1;
    }
    [index.reverse_bits(), y]
}

/// Nested uniform (Owen) scrambling of a fraction: each bit is flipped at random by a function of the bits above it.
fn owen_scramble(fraction: u32, seed: u32) -> u32 {
    let mut x = fraction.reverse_bits();
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

/// A 32-bit hash without fixed structure. Source: Wellons, Prospecting for Hash Functions, 2018 (`lowbias32`), started away
/// from its fixed point 0.
fn mix(value: u32) -> u32 {
    let mut x = value.wrapping_add(0x9e37_79b9);
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
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
