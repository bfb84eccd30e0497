//! How the variance of a pixel's mean falls as its samples grow.
//!
//! A pixel's samples are one scrambled low-discrepancy sequence, so the error falls faster than that of independent samples,
//! and nothing about one sequence alone tells how fast. What tells is how much the mean moved whenever the samples doubled.
//!
//! Let `V(n)` be the variance of the mean of the first `n` samples and `n = 2ᵏ`. Scrambling makes the two halves of the
//! sequence exchangeable, so the mean of all is uncorrelated with the difference of the halves, and
//! `V(n/2) − V(n) = E[(mean of n − mean of n/2)²]` exactly: the *drop* of level `k`, which is observed. Summed over all levels
//! still to come, drops give back `V(n)`.
//!
//! From the drops of the past follow those to come, if the variance falls by a law. Which one, nobody knows: many are tried,
//! each a power of `n` that may go up and down from one level to the next, as sequences in two dimensions are better at powers
//! of four, and that may have beside it a part that falls as slowly as for independent samples ([`Law`]). What counts is the
//! mean over all laws, each weighted by how well it explains the drops that were seen (Bayesian model averaging; Hoeting et
//! al. 1999), and by how much they differ is how far it may be off. A drop that fits no law, as where a sequence happens to suit
//! the edge of a shadow, makes all of them equally likely again, and not one of them wrong with certainty: deviations are taken
//! for Student's.

use std::ops::RangeInclusive;
use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use crate::scene::RenderSettings;

/// Highest level: twice the most samples a pixel can get.
const MOST_LEVEL: u32 = RenderSettings::MAX_SAMPLES.ilog2() + 1;
const LEVELS: usize = MOST_LEVEL as usize + 1;
/// Levels in a law's tables before and after the one at which it is asked.
const OFFSET: i32 = MOST_LEVEL.cast_signed();

/// The factor by which the variance falls when independent samples double. Nothing falls more slowly.
const INDEPENDENT: f64 = 0.5;
/// The same for the fastest law: about n⁻⁴·⁵.
const FASTEST: f64 = 0.045;
/// Number of powers between them.
const POWERS: u32 = 14;

/// By which part the variance is larger at odd levels and smaller at even ones, and how likely that is before anything is seen.
const SWINGS: [(f64, f64); 4] = [(0.0, 0.4), (0.1, 0.2), (0.2, 0.2), (0.3, 0.2)];
/// The level from which on swings are believed in: of the one link that is seen before, a slow fall without any is as good an explanation as
/// a fast one that swings, and the slow fall is what pictures have.
const SWINGS_FROM: u32 = 3;

/// Which part of the variance falls as for independent samples, at the level where the law is asked, and how likely that is.
const SLOW_PARTS: [(f64, f64); 7] = [
    (0.0, 0.73),
    (0.03, 0.05),
    (0.1, 0.05),
    (0.3, 0.05),
    (0.6, 0.04),
    (0.8, 0.04),
    (0.9, 0.04),
];

/// Typical deviation of the logarithm of the newest link from the law.
const DEVIATION: f64 = 0.1;
/// What each level of age adds to it.
const DEVIATION_OF_AGE: f64 = 0.1;
/// What is added to it at level 2, where no law holds yet; half as much at each level that follows.
const EARLY_DEVIATION: f64 = 0.2;
/// Degrees of freedom of the deviations.
const FREEDOM: f64 = 4.0;

/// Scenes differ less than laws do: with this share of the laws' spread as doubt, intervals over eighteen scenes and pictures of
/// 24 × 18 to 96 × 72 pixels hold the truth 95 times of 100.
const SCENES_OVER_LAWS: f64 = 0.8;

/// The doubt before anything is seen: a factor of two.
const IGNORANCE: f64 = std::f64::consts::LN_2;

/// A way for the variance to fall: `V(2ᵏ) = (1 − m) rᵏ (1 ± a) + m 2⁻ᵏ`, up to a factor, where `k` counts from the level at which
/// the law is asked.
#[derive(Clone, Debug)]
struct Law {
    /// Logarithm of how likely it is before anything is seen.
    prior: f64,
    swings: bool,
    /// For even and odd levels at which it is asked: the variance, over that at this level, at each level from [`MOST_LEVEL`]
    /// below to as many above.
    variances: [Vec<f64>; 2],
    /// The logarithms of the drops there.
    drops: [Vec<f64>; 2],
}

static LAWS: LazyLock<Vec<Law>> = LazyLock::new(|| {
    let mut laws = Vec::new();
    let independent = powers(INDEPENDENT);
    for power in 0..POWERS {
        let way = f64::from(power) / f64::from(POWERS - 1);
        let ratio = FASTEST * libm::pow(INDEPENDENT / FASTEST, way);
        let fast = powers(ratio);
        for (swing, swing_prior) in SWINGS {
            for (slow_part, slow_prior) in SLOW_PARTS {
                let always_falls = ratio * (1.0 + swing) < 1.0 - swing;
                let is_new = power + 1 < POWERS || slow_part == 0.0;
                if always_falls && is_new {
                    let prior = swing_prior * slow_prior;
                    laws.push(Law::new([&fast, &independent], swing, slow_part, prior));
                }
            }
        }
    }
    laws
});

/// The steps from the level at which a law is asked to those of its tables and the one before.
const STEPS: RangeInclusive<i32> = -OFFSET - 1..=OFFSET;

/// What the variance is after each of the [`STEPS`] that multiplies it by `ratio`.
fn powers(ratio: f64) -> Vec<f64> {
    let power = |step| libm::pow(ratio, f64::from(step));
    STEPS.map(power).collect()
}

impl Law {
    /// Of the [`powers`] of its ratio and of [`INDEPENDENT`].
    fn new([fast, slow]: [&[f64]; 2], swing: f64, slow_part: f64, prior: f64) -> Self {
        let variances = [1.0, -1.0].map(|sign| {
            let powers = STEPS.zip(fast.iter().zip(slow));
            let raw = powers.map(|(step, (fast, slow))| {
                let swing = if step % 2 == 0 { -swing } else { swing } * sign;
                (1.0 - slow_part) * fast * (1.0 + swing) + slow_part * slow
            });
            raw.collect::<Vec<f64>>()
        });
        let present = OFFSET as usize + 1;
        Self {
            prior: libm::log(prior),
            swings: swing > 0.0,
            variances: variances.each_ref().map(|variances| {
                let relative = |variance: &f64| variance / variances[present];
                variances[1..].iter().map(relative).collect()
            }),
            drops: variances.each_ref().map(|variances| {
                let drop = |pair: &[f64]| libm::log((pair[0] - pair[1]) / variances[present]);
                variances.windows(2).map(drop).collect()
            }),
        }
    }

    /// The variance at level `at` over that at `level`, where it is asked.
    fn variance(&self, level: u32, at: u32) -> f64 {
        self.variances[(level % 2) as usize][place(level, at)]
    }

    /// Logarithm of the drop at level `at` over the variance at `level`, where it is asked.
    fn drop(&self, level: u32, at: u32) -> f64 {
        self.drops[(level % 2) as usize][place(level, at)]
    }

    /// Logarithm of what is left at `level` over the fall to it.
    fn variance_over_fall(&self, level: u32) -> f64 {
        -libm::log(self.variance(level, level - 2) - 1.0)
    }

    /// Logarithm of how likely the law is once these links are `seen`, each with its level.
    fn likelihood(&self, level: u32, seen: &[(u32, f64)]) -> f64 {
        if self.swings && level < SWINGS_FROM {
            return f64::NEG_INFINITY;
        }
        let of_link = |&(at, link): &(u32, f64)| {
            let early = EARLY_DEVIATION * libm::exp2(2.0 - f64::from(at));
            let age = DEVIATION_OF_AGE * f64::from(level - at);
            let scale = DEVIATION * DEVIATION + age * age + early * early;
            let deviation = link - (self.drop(level, at) - self.drop(level, at - 1));
            libm::log1p(deviation * deviation / (scale * FREEDOM)) * (FREEDOM + 1.0) / -2.0
        };
        self.prior + seen.iter().map(of_link).sum::<f64>()
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a level"
)]
fn whole_part(level: f64) -> usize {
    level as usize
}

/// Index of level `at` in the tables of a law that is asked at `level`.
fn place(level: u32, at: u32) -> usize {
    (MOST_LEVEL + at - level) as usize
}

/// The fall of variance, up to a factor: what matters is the variance at one number of samples over that at another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Decay {
    /// The variance of the mean of 2ᵏ samples over that at the level where the decay was asked.
    at_powers: [f64; LEVELS],
    /// By how much laws differ on it: the standard deviation of its logarithm.
    doubts: [f64; LEVELS],
    link: f64,
    variance_over_fall: f64,
    doubt: f64,
}

impl Decay {
    /// The decay of independent samples, at `level`: what is assumed before anything is seen.
    pub fn independent(level: u32) -> Self {
        let power = |k: usize| libm::exp2(f64::from(level) - k as f64);
        Self {
            at_powers: std::array::from_fn(power),
            // A factor of two in the power of n, or nearly: nothing is known.
            doubts: std::array::from_fn(|k| IGNORANCE / 2.0 * (k as f64 - f64::from(level)).abs()),
            link: INDEPENDENT,
            // The drops left sum to the last one, and the one before was twice that.
            variance_over_fall: 1.0 / 3.0,
            doubt: IGNORANCE,
        }
    }

    /// The decay at `level`, from `links`: number `i` is the drop at level `i + 2` over the drop at level `i + 1`.
    pub fn at(level: u32, links: &[f64]) -> Self {
        let level = level.min(MOST_LEVEL);
        let seen: Vec<(u32, f64)> = (2..=level)
            .zip(links)
            .filter(|(_, link)| link.is_finite() && **link > 0.0)
            .map(|(at, link)| (at, libm::log(*link)))
            .collect();
        if seen.is_empty() {
            return Self::independent(level);
        }
        let mut weights: Vec<f64> = LAWS.iter().map(|l| l.likelihood(level, &seen)).collect();
        let most = weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        for weight in &mut weights {
            *weight = libm::exp(*weight - most);
        }
        let total: f64 = weights.iter().sum();
        let mean_of = |values: &mut dyn Iterator<Item = f64>| {
            let weighted = values.zip(&weights).map(|(value, weight)| weight * value);
            weighted.sum::<f64>() / total
        };
        let mean = |value: &dyn Fn(&Law) -> f64| mean_of(&mut LAWS.iter().map(value));
        let mean_and_spread = |value: &dyn Fn(&Law) -> f64| {
            let values: Vec<f64> = LAWS.iter().map(value).collect();
            let mean = mean_of(&mut values.iter().copied());
            let mut squares = values.iter().map(|value| (value - mean).powi(2));
            (mean, mean_of(&mut squares).sqrt())
        };
        let (over_fall, spread) = mean_and_spread(&|law| law.variance_over_fall(level));
        // Always the mean of the variance of more samples over that of fewer: no power of a large ratio outweighs all others.
        let at_power = |at: u32| {
            if at < level {
                mean(&|law| law.variance(level, at).recip()).recip()
            } else {
                mean(&|law| law.variance(level, at))
            }
        };
        let doubt_at = |at: u32| mean_and_spread(&|law| libm::log(law.variance(level, at))).1;
        let mut at_powers = [0.0; LEVELS];
        let mut doubts = [0.0; LEVELS];
        for (at, (variance, doubt)) in (0..).zip(at_powers.iter_mut().zip(&mut doubts)) {
            *variance = at_power(at);
            *doubt = doubt_at(at);
        }
        Self {
            at_powers,
            doubts,
            link: libm::exp(mean(&|law| {
                law.drop(level, level) - law.drop(level, level - 1)
            })),
            variance_over_fall: libm::exp(over_fall),
            doubt: SCENES_OVER_LAWS * spread,
        }
    }

    /// A drop over the one before it.
    pub fn link(&self) -> f64 {
        self.link
    }

    /// The variance left over the fall to this level, from a quarter of the samples on: what turns an observed fall into an error.
    pub fn variance_over_fall(&self) -> f64 {
        self.variance_over_fall
    }

    /// By how much that may be off: the standard deviation of its logarithm.
    pub fn doubt(&self) -> f64 {
        self.doubt
    }

    /// By how much the variance of the mean of so many samples, over that at the level where the decay was asked, may be off: the
    /// standard deviation of its logarithm.
    pub fn doubt_at(&self, samples: f64) -> f64 {
        let level = libm::log2(samples.max(1.0)).min(f64::from(MOST_LEVEL));
        let below = whole_part(level);
        let [from, to] = [below, (below + 1).min(LEVELS - 1)].map(|at| self.doubts[at]);
        from + (to - from) * level.fract()
    }

    /// The variance of the mean of the first `samples`.
    pub fn variance(&self, samples: u32) -> f64 {
        let samples = samples.max(1);
        let level = samples.next_power_of_two().ilog2().min(MOST_LEVEL);
        self.at_powers[level as usize] + self.within(samples, level)
    }

    /// Expected square of the difference between the mean of the first `samples` and that of all 2ᵏ.
    ///
    /// The two halves of a block lie at equal distances on both sides of its mean; so do the halves of the halves.
    fn within(&self, samples: u32, level: u32) -> f64 {
        if samples == 1 << level {
            return 0.0;
        }
        let half = 1 << (level - 1);
        let drop = self.at_powers[level as usize - 1] - self.at_powers[level as usize];
        if samples <= half {
            return drop + self.within(samples, level - 1);
        }
        let first = f64::from(half) / f64::from(samples);
        let rest = 1.0 - first;
        (first - rest).powi(2) * drop + rest.powi(2) * self.within(samples - half, level - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Power laws: what is left is known to be link / (1 − link) last drops. The mean over all laws never believes one alone: within
    /// a quarter of the root mean square for what real pictures show, and wider the faster the fall.
    #[test]
    fn power_laws_are_found_again() {
        for (link, allowed) in [
            (0.5, 1.25),
            (0.42, 1.25),
            (0.354, 1.25),
            (0.25, 1.25),
            (0.125, 1.5),
        ] {
            for level in 4..16 {
                let decay = Decay::at(level, &[link; 16]);
                let fall = 1.0 + 1.0 / link;
                let found = (decay.variance_over_fall() * fall / (link / (1.0 - link))).sqrt();
                assert!(
                    found > 1.0 / allowed && found < allowed,
                    "{link}, {level}: {found}"
                );
                let twice = decay.variance(1 << (level + 1)) / decay.variance(1 << level);
                assert!(twice > link / 1.5 && twice < link * 1.5, "{twice}, {link}");
            }
        }
    }

    /// The first link of all, at four samples: what is left is known within the same quarter for what real pictures show.
    #[test]
    fn one_link_tells_how_much_is_left() {
        for link in [0.5, 0.42, 0.354, 0.25] {
            let decay = Decay::at(2, &[link]);
            let fall = 1.0 + 1.0 / link;
            let found = (decay.variance_over_fall() * fall / (link / (1.0 - link))).sqrt();
            assert!((0.8..1.25).contains(&found), "{link}: {found}");
        }
    }

    /// One step that no law explains, as where an edge suits the sequence, is doubted, and two steps later forgotten: what is left
    /// is a third of the fall again.
    #[test]
    fn one_lucky_level_does_not_decide() {
        let lucky = [0.5, 0.5, 0.5, 0.05, 0.5, 0.5];
        for level in [5, 7] {
            let [without, with] = [&[0.5; 6], &lucky].map(|links| Decay::at(level, links));
            let ratio = (with.variance_over_fall() / without.variance_over_fall()).sqrt();
            match level {
                5 => assert!(with.doubt() > 2.0 * without.doubt(), "{with:?}"),
                _ => assert!(ratio > 0.8 && ratio < 1.25, "{ratio}"),
            }
        }
    }

    /// Drops that go up and down as those of nets do: V = 4⁻ᵏ, three quarters of it at even k, five at odd.
    #[test]
    fn going_up_and_down_does_not_mislead() {
        let variance = |k: i32| 0.25_f64.powi(k) * if k % 2 == 0 { 0.75 } else { 1.25 };
        let drop = |k: i32| variance(k - 1) - variance(k);
        let links: Vec<f64> = (2..=10).map(|k| drop(k) / drop(k - 1)).collect();
        for level in 4..=10_u32 {
            let k = level.cast_signed();
            let fall = drop(k) + drop(k - 1);
            let found = Decay::at(level, &links).variance_over_fall() * fall;
            let ratio = (found / variance(k)).sqrt();
            assert!((0.8..1.25).contains(&ratio), "{level}: {ratio}");
        }
    }

    #[test]
    fn without_usable_drops_samples_count_as_independent() {
        for links in [&[][..], &[f64::NAN; 3], &[0.0, f64::INFINITY, -1.0]] {
            for level in [0, 1, 2, 4] {
                assert_eq!(
                    Decay::at(level, links),
                    Decay::independent(level),
                    "{links:?}"
                );
            }
        }
    }

    /// The variance of the mean of any number of independent samples is 1/n of one's.
    #[test]
    fn independent_samples_are_exact_at_every_count() {
        let decay = Decay::independent(4);
        let one = decay.variance(1);
        for samples in 1..200 {
            let share = decay.variance(samples) * f64::from(samples) / one;
            assert!((share - 1.0).abs() < 1e-12, "{samples}: {share}");
        }
    }

    /// Scrambled nets between two powers of two, against the sequence itself: the integral of a quarter disk (a jump along a
    /// curve), whose variance over 4,000 pixels is known to 1 / √2000 = 2.3 %. 5 standard deviations, and that its fall is no
    /// pure power of n, leave 25 % from the last power of two back to the one before.
    #[test]
    fn counts_between_powers_of_two_follow_the_sequence() {
        use crate::render::sampler::{Decision, Dimension, Sampler};
        use crate::scene::SamplerChoice;
        let pixels = 4000;
        let mut squares = vec![0.0; 97];
        for pixel in 0..pixels {
            let mut sum = 0.0;
            for index in 0..96 {
                let sampler = Sampler::new(SamplerChoice::Sobol, 5, (pixel, 0), index);
                let u = sampler.next_2d(Dimension::once(Decision::Pixel));
                sum += f64::from(u8::from(u.length_squared() < 1.0));
                let error: f64 = sum / f64::from(index + 1) - std::f64::consts::FRAC_PI_4;
                squares[index as usize + 1] += error * error / f64::from(pixels);
            }
        }
        let drop = |level: u32| squares[1 << (level - 1)] - squares[1 << level];
        let links: Vec<f64> = (2..=6).map(|level| drop(level) / drop(level - 1)).collect();
        let decay = Decay::at(6, &links);
        for samples in [40, 48, 56, 80, 96] {
            let predicted = decay.variance(samples) / decay.variance(64) * squares[64];
            let ratio = predicted / squares[samples as usize];
            assert!((0.75..1.33).contains(&ratio), "{samples}: {ratio}");
        }
    }
}
