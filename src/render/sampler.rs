//! Random numbers, well spread within a pixel or independent: a function of seed, pixel, sample and dimension alone, so that a picture
//! does not depend on threads or on the order of work.

use crate::math::Vec2;
use crate::scene::SamplerChoice;

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

/// The step from turn to turn in their sequence where they are independent: the golden ratio of 2³², to the nearest odd number, which keeps
/// all turns far from each other. Only what is near stays together when the sequence is shuffled.
const FAR: u32 = 0x9e37_79b9;

/// The random numbers of one sample of one pixel: an Owen-scrambled Sobol sequence per pixel and decision.
///
/// Each decision takes the first two Sobol dimensions with its own shuffle and scrambles, which keeps every pair well spread
/// and different pairs independent. Source: Burley, Practical Hash-based Owen Scrambling, JCGT 9(4), 2020, with the hash
/// constants of Vegdahl, Building a Better LK Hash, 2021.
///
/// Independent numbers are those of the same sequences at random places among all 2³²: what makes a sequence even is that its places
/// are taken in turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampler {
    /// Of the seed and the pixel.
    key: u64,
    /// The bits of the sample's place in the sequences, in reverse order.
    reversed: u32,
    choice: SamplerChoice,
}

impl Sampler {
    /// The numbers of sample `index` of pixel `(x, y)` of the full picture.
    #[must_use]
    pub fn new(choice: SamplerChoice, seed: u64, (x, y): (u32, u32), index: u32) -> Self {
        let key = mix(mix(seed) ^ (u64::from(y) << 32 | u64::from(x)));
        let reversed = match choice {
            SamplerChoice::Sobol => index.reverse_bits(),
            // Mixed twice, as the bits of dimensions come of the key mixed once.
            SamplerChoice::Independent => upper_half(mix(mix(key) ^ u64::from(index))),
        };
        Self {
            key,
            reversed,
            choice,
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

    /// The numbers of a decision taken `count` times per sample. All turns of all samples are one well-spread sequence, or all
    /// independent.
    #[must_use]
    pub fn turns(&self, dimension: Dimension, count: u32) -> Turns {
        let place = self.reversed.reverse_bits();
        let (first, step) = match self.choice {
            SamplerChoice::Sobol => (place.wrapping_mul(count), 1),
            SamplerChoice::Independent => (place, FAR),
        };
        Turns {
            first,
            step,
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
    step: u32,
    scrambles: Scrambles,
}

impl Turns {
    /// Two numbers in `[0, 1)` for number `turn`, from 0.
    #[must_use]
    #[inline]
    pub fn next_2d(&self, turn: u32) -> Vec2 {
        let index = self.first.wrapping_add(turn.wrapping_mul(self.step));
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
    #[expect(clippy::cast_possible_truncation, reason = "a part of the bits")]
    fn from_bits(bits: u64) -> Self {
        Self {
            order: upper_half(bits),
            x: bits as u32,
            // Another product of all bits, of which the upper half is the good one.
            y: upper_half(bits.wrapping_mul(0xd6e8_feb8_6659_fd93)),
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

fn upper_half(bits: u64) -> u32 {
    (bits >> 32) as u32
}

/// The upper 24 bits as a number in `[0, 1)`, each exactly representable.
fn unit_from_bits(bits: u32) -> f32 {
    (bits >> 8) as f32 / 16_777_216.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Choice;

    fn sampler(choice: SamplerChoice, pixel: (u32, u32), index: u32) -> Sampler {
        Sampler::new(choice, 7, pixel, index)
    }

    fn points(seed: u64, pixel: (u32, u32), count: u32) -> Vec<Vec2> {
        (0..count)
            .map(|index| Sampler::new(SamplerChoice::Sobol, seed, pixel, index))
            .map(|sampler| sampler.next_2d(Dimension::once(Decision::Pixel)))
            .collect()
    }

    /// In which of `side`² equal squares the point lies.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "cell indices"
    )]
    fn cell(point: Vec2, side: usize) -> usize {
        let place = |u: f32| (u * side as f32) as usize;
        place(point.y) * side + place(point.x)
    }

    /// χ² of what was counted against what is `expected`.
    fn chi_squared(counts: &[u32], expected: impl Fn(usize) -> f64) -> f64 {
        let terms = counts.iter().enumerate().map(|(cell, &count)| {
            let expected = expected(cell);
            (f64::from(count) - expected).powi(2) / expected
        });
        terms.sum()
    }

    /// χ² over 256 equally likely cells, of which `cell_of` says the one for each of 2¹⁶ trials.
    fn chi_squared_256(cell_of: impl Fn(u32) -> usize) -> f64 {
        let mut counts = vec![0_u32; 256];
        for trial in 0..65_536 {
            counts[cell_of(trial)] += 1;
        }
        chi_squared(&counts, |_| 256.0)
    }

    /// A scrambled (0, m, 2)-net: each elementary interval of area 2⁻ᵐ holds exactly one of 2ᵐ points.
    #[test]
    fn every_power_of_two_prefix_is_a_net() {
        for pixel in 0..8 {
            for m in [1_u32, 4, 8] {
                for split in 0..=m {
                    let (columns, rows) = (1_u32 << split, 1_u32 << (m - split));
                    let mut counts = vec![0; 1 << m];
                    for point in points(pixel.into(), (pixel, 3), 1 << m) {
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

    /// As they were before there was a choice: pictures of old scenes keep their bits.
    #[test]
    fn the_sequences_stay_what_they_are() {
        let numbers = |point: Vec2| point.to_array().map(|u| f64::from(u) * f64::from(1 << 24));
        let at = |index| sampler(SamplerChoice::Sobol, (3, 5), index);
        let first = at(9).next_2d(Dimension::once(Decision::Pixel));
        assert_eq!(numbers(first), [0x00fd_c0d6, 0x0032_ada4].map(f64::from));
        let later = at(1000).next_2d(Dimension::at(Decision::Direction, 2).about(1));
        assert_eq!(numbers(later), [0x0003_7c6d, 0x0058_881c].map(f64::from));
        let turns = at(9).turns(Dimension::once(Decision::AmbientOcclusion), 5);
        let third = numbers(turns.next_2d(3));
        assert_eq!(third, [0x00ed_b0f6, 0x006e_591a].map(f64::from));
    }

    /// χ² over 16×16 cells of the first samples of 2¹⁶ pixels, which no net property helps: α = 0.001 each (χ² of 255 degrees of
    /// freedom below 330.5), seed fixed.
    #[test]
    fn different_pixels_are_independent() {
        for &(choice, name) in SamplerChoice::ALL {
            let found = chi_squared_256(|pixel| {
                let sampler = sampler(choice, (pixel % 256, pixel / 256), 0);
                cell(sampler.next_2d(Dimension::once(Decision::Pixel)), 16)
            });
            assert!(found < 330.5, "{name}: {found}");
        }
    }

    /// χ² of 255 degrees of freedom is within these in all but one of 5,000 cases.
    const LIKELY_256: std::ops::Range<f64> = 179.4..347.7;

    /// Over 16×16 cells of single points and 4⁴ of pairs, in each of eight pixels: 48 comparisons, α = 0.01 over all, seed fixed.
    /// A well-spread sequence shows in points that are near each other in it.
    #[test]
    fn independent_points_are_so_within_a_pixel() {
        let once = Dimension::once(Decision::Pixel);
        let [first, second] = [1, 2].map(|bounce| Dimension::at(Decision::Direction, bounce));
        let two = |a, b| 16 * cell(a, 4) + cell(b, 4);
        let turned = |sampler: Sampler, count, [a, b]: [u32; 2]| {
            let turns = sampler.turns(first.about(3), count);
            two(turns.next_2d(a), turns.next_2d(b))
        };
        for (x, &(choice, _)) in (0..8).flat_map(|x| SamplerChoice::ALL.iter().map(move |c| (x, c)))
        {
            let at = |index| sampler(choice, (x, 2), index);
            let point = |index| at(index).next_2d(once);
            let near = [
                chi_squared_256(|i| cell(point(i), 16)),
                chi_squared_256(|i| two(point(2 * i), point(2 * i + 1))),
                chi_squared_256(|i| turned(at(i), 16, [0, 1])),
            ];
            let far = [
                chi_squared_256(|i| turned(at(i), 1024, [5, 1000])),
                chi_squared_256(|i| two(point(i), at(i).next_2d(first))),
                chi_squared_256(|i| two(at(i).next_2d(first), at(i).next_2d(second))),
            ];
            let is_likely = |found: &f64| LIKELY_256.contains(found);
            let what = format!("{choice:?}, {x}: {near:?}, {far:?}");
            match choice {
                SamplerChoice::Sobol => assert!(!near.iter().any(is_likely), "{what}"),
                SamplerChoice::Independent => {
                    assert!(near.iter().chain(&far).all(is_likely), "{what}");
                }
            }
        }
    }

    /// How many of 16 turns lie in one half, left or upper, over 2¹⁴ samples in each of four pixels, against the binomial distribution with
    /// its ends taken together: χ² of 10 degrees of freedom, 8 comparisons, α = 0.001 over all, seed fixed. Spread turns share
    /// the halves evenly.
    #[test]
    fn independent_turns_fall_as_coins_do() {
        const SAMPLES: u32 = 1 << 14;
        let ways = [
            697, 1820, 4368, 8008, 11_440, 12_870, 11_440, 8008, 4368, 1820, 697,
        ];
        let expected = |cell: usize| f64::from(SAMPLES) * f64::from(ways[cell]) / 65_536.0;
        for x in 0..4 {
            for is_left in [true, false] {
                let found = SamplerChoice::ALL.iter().map(|&(choice, _)| {
                    let mut counts = vec![0_u32; ways.len()];
                    for index in 0..SAMPLES {
                        let turns = sampler(choice, (x, 1), index)
                            .turns(Dimension::once(Decision::Light), 16);
                        let lies_there = |&turn: &u32| {
                            let u = turns.next_2d(turn);
                            (if is_left { u.x } else { u.y }) < 0.5
                        };
                        let there = (0..16).filter(lies_there).count();
                        counts[there.clamp(3, 13) - 3] += 1;
                    }
                    chi_squared(&counts, expected)
                });
                let [spread, independent] =
                    <[f64; 2]>::try_from(found.collect::<Vec<_>>()).expect("two choices");
                assert!(
                    independent < 35.6 && spread > 1000.0,
                    "{x}, {is_left}: {independent}, {spread}"
                );
            }
        }
    }

    #[test]
    fn numbers_depend_on_seed_pixel_and_sample() {
        for &(choice, _) in SamplerChoice::ALL {
            let points = |seed, pixel| {
                let numbers = |index| {
                    let sampler = Sampler::new(choice, seed, pixel, index);
                    sampler.next_2d(Dimension::once(Decision::Pixel))
                };
                [0, 1, 2, 3].map(numbers)
            };
            let base = points(0, (0, 0));
            assert_eq!(base, points(0, (0, 0)));
            assert_ne!(base[0], base[1]);
            for other in [
                points(1, (0, 0)),
                points(1 << 32, (0, 0)),
                points(0, (1, 0)),
                points(0, (0, 1)),
            ] {
                assert_ne!(base, other);
            }
        }
    }
}
