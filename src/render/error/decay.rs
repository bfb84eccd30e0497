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
//! Drops are looked at in pairs, the *fall* from `n/4` to `n`: in two dimensions a sequence is better at powers of four than
//! between them, so drops go up and down while falls do not. From falls one factor of four apart comes their ratio, and from it
//! all that are to come. Two laws are taken for likely: a single power of `n`, and a part that falls as for independent samples,
//! `n⁻¹`, beside one that falls as for smooth integrands, `n⁻²`. The truth was between the two in every scene measured: their
//! geometric mean is taken, and their distance tells how much it may be off.

/// Highest level: twice the most samples a pixel can get.
const MOST_LEVEL: u32 = 25;

/// By what variance falls with four times as many independent samples.
const INDEPENDENT: f64 = 0.25;
/// The same where it falls as n⁻².
const SMOOTH: f64 = 1.0 / 16.0;

/// The largest ratio that is believed. More than for independent samples is chance; cut off at once, chance would always make
/// estimates smaller.
const LARGEST: f64 = 0.3;
/// The smallest: the error of rounding ends every fall.
const SMALLEST: f64 = 1e-6;

/// How much the last but one ratio of falls counts beside the last, whose levels are the others.
const OLDER_SHARE: f64 = 0.4;

/// The fall of variance, up to a factor: what matters is the variance at one number of samples over that at another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decay {
    /// By what it falls with four times as many samples.
    ratio: f64,
    /// The level at which the two laws agree by definition: variances are multiples of that there.
    level: u32,
}

impl Decay {
    /// That of independent samples: what is assumed before anything is seen.
    pub const INDEPENDENT: Self = Self {
        ratio: INDEPENDENT,
        level: 0,
    };

    /// As it is at `level`, from `links`: number `i` is the drop at level `i + 2` over the drop at level `i + 1`.
    pub fn at(level: u32, links: &[f64]) -> Self {
        let level = level.min(MOST_LEVEL);
        let link = |level: u32| {
            let link = links.get(level.checked_sub(2)? as usize)?;
            (link.is_finite() && *link > 0.0).then_some(*link)
        };
        // The fall to a level over the fall to two levels below: (d₀ + d₁) / (d₂ + d₃), by links d₀/d₁, d₁/d₂, d₂/d₃.
        let falls = |level: u32| {
            let (newest, middle, oldest) = (link(level)?, link(level - 1)?, link(level - 2)?);
            Some((newest + 1.0) * middle * oldest / (oldest + 1.0))
        };
        // The drop at a level over that two levels below.
        let drops = |level: u32| Some(link(level)? * link(level - 1)?);
        let mean = |last: Option<f64>, older: Option<f64>| {
            Some(libm::pow(last?, 1.0 - OLDER_SHARE) * libm::pow(older?, OLDER_SHARE))
        };
        let ratio = match level {
            0 | 1 => None,
            2 => link(level).map(|link| link * link),
            3 => drops(level),
            4 => mean(falls(level), drops(level)),
            _ => mean(falls(level), falls(level - 1)),
        };
        Self {
            ratio: ratio.unwrap_or(INDEPENDENT).clamp(SMALLEST, LARGEST),
            level,
        }
    }

    /// By what a drop is smaller than the one before it.
    pub fn link(&self) -> f64 {
        self.ratio.sqrt()
    }

    /// The variance left over the fall to this level: what turns an observed fall into an error.
    pub fn variance_over_fall(&self) -> f64 {
        let [power, mixture] = self.laws();
        (power * mixture).sqrt()
    }

    /// By what factor the two laws disagree about it, as a logarithm.
    pub fn disagreement(&self) -> f64 {
        let [power, mixture] = self.laws();
        libm::log(mixture / power)
    }

    /// What is left over the fall, by a power law and by the mixture.
    fn laws(&self) -> [f64; 2] {
        let left = |ratio: f64| ratio / (1.0 - ratio);
        let [independent, smooth] = self.parts();
        let mixture = if self.ratio < SMOOTH {
            left(self.ratio)
        } else {
            independent * left(INDEPENDENT) + smooth * left(SMOOTH)
        };
        [left(self.ratio), mixture]
    }

    /// The parts of the fall in the mixture.
    fn parts(&self) -> [f64; 2] {
        let smooth = (1.0 / self.ratio - 1.0 / INDEPENDENT) / (1.0 / SMOOTH - 1.0 / INDEPENDENT);
        [1.0 - smooth, smooth]
    }

    /// The variance of the mean of the first `samples`.
    pub fn variance(&self, samples: u32) -> f64 {
        let samples = samples.max(1);
        let level = samples.next_power_of_two().trailing_zeros();
        self.at_power(level) + self.within(samples, level)
    }

    /// The variance of the mean of 2ᵏ samples; 1 at [`Self::level`].
    fn at_power(&self, level: u32) -> f64 {
        let quarterings = (f64::from(level) - f64::from(self.level)) / 2.0;
        let power = libm::pow(self.ratio.min(INDEPENDENT), quarterings);
        if self.ratio < SMOOTH || self.ratio >= INDEPENDENT {
            return power;
        }
        let [independent, smooth] = self.parts();
        // What is left of each part at the level, which is one and a fifteenth over three and fifteen.
        let (independent, smooth) = (independent / 3.0, smooth / 15.0);
        let mixture = (independent * libm::pow(INDEPENDENT, quarterings)
            + smooth * libm::pow(SMOOTH, quarterings))
            / (independent + smooth);
        (power * mixture).sqrt()
    }

    /// Expected square of the difference between the mean of the first `samples` and that of all 2ᵏ.
    ///
    /// The two halves of a block lie at equal distances on both sides of its mean; so do the halves of the halves.
    fn within(&self, samples: u32, level: u32) -> f64 {
        if samples == 1 << level {
            return 0.0;
        }
        let half = 1 << (level - 1);
        let drop = self.at_power(level - 1) - self.at_power(level);
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

    /// A power law is found again as far as the mixture lets it: exactly where both are the same, and between the two else.
    #[test]
    fn power_laws_are_found_again() {
        for (link, doubt) in [(0.5, 1e-12), (0.25, 1e-12), (0.125, 1e-12), (0.354, 0.31)] {
            for level in 2..12 {
                let decay = Decay::at(level, &[link; 12]);
                let fall = 1.0 + 1.0 / link;
                let expected = link / (1.0 - link);
                let found = decay.variance_over_fall() * fall;
                assert!(
                    found >= expected * (1.0 - 1e-12) && found <= expected * (1.0 + doubt),
                    "{link}, {level}: {found}, {expected}"
                );
                let four_times = decay.variance(1 << (level + 2)) / decay.variance(1 << level);
                assert!(four_times >= link * link * (1.0 - 1e-12) && four_times < 0.251);
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
            let ratio = found / variance(k);
            assert!((0.8..1.25).contains(&ratio), "{level}: {ratio}");
        }
    }

    #[test]
    fn without_usable_drops_samples_count_as_independent() {
        for links in [&[][..], &[f64::NAN, 0.5, 0.5], &[0.0, 0.5, 0.5]] {
            for level in [0, 1, 2, 4] {
                assert_eq!(Decay::at(level, links).ratio, INDEPENDENT, "{links:?}");
            }
        }
    }

    /// The variance of the mean of any number of independent samples is 1/n of one's.
    #[test]
    fn independent_samples_are_exact_at_every_count() {
        let one = Decay::INDEPENDENT.variance(1);
        for samples in 1..200 {
            let share = Decay::INDEPENDENT.variance(samples) * f64::from(samples) / one;
            assert!((share - 1.0).abs() < 1e-12, "{samples}: {share}");
        }
    }

    /// Scrambled nets between two powers of two, against the sequence itself: the integral of a quarter disk (a jump along a
    /// curve), whose variance over 4,000 pixels is known to 1 / √2000 = 2.3 %. 5 standard deviations, and that its fall is no
    /// pure power of n, leave 25 % from the last power of two back to the one before.
    #[test]
    fn counts_between_powers_of_two_follow_the_sequence() {
        use crate::render::sampler::{Decision, Dimension, Sampler};
        let pixels = 4000;
        let mut squares = vec![0.0; 97];
        for pixel in 0..pixels {
            let mut sum = 0.0;
            for index in 0..96 {
                let u = Sampler::new(5, pixel, 0, index).next_2d(Dimension::once(Decision::Pixel));
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
