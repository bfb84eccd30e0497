//! How the variance of a pixel's mean falls as its samples grow.
//!
//! A pixel's samples are one scrambled low-discrepancy sequence, so the error falls faster than that of independent samples
//! and nothing about one sequence alone tells how fast. What tells is how much the mean moved whenever the samples doubled.
//!
//! Let `V(n)` be the variance of the mean of the first `n` samples and `n = 2ᵏ`. Scrambling makes the two halves of the
//! sequence exchangeable, so the mean of all is uncorrelated with the difference of the halves, and
//! `V(n/2) − V(n) = E[(mean of n − mean of n/2)²]` exactly: the *drop* of level `k`, which is observed. Summed over all levels
//! still to come, drops give back `V(n)`. Those are extrapolated by a sum of power laws, fitted to the drops seen so far:
//! `n⁻¹` as for independent samples, `n^−1.5` as at edges in two dimensions, `n⁻²` between, and `n⁻³` of smooth integrands.
//! Sources: Owen, Scrambled net variance for integrals of smooth functions, 1997, for the last; He & Wang, On the convergence
//! rate of randomized quasi-Monte Carlo for discontinuous functions, 2015, for the second.

/// By how much each power law falls when the samples double.
const RATIOS: [f64; 4] = [0.5, 0.353_553_390_593_273_8, 0.25, 0.125];

/// How much less a drop counts than the one after it: old ones are steadier, new ones say more about what comes.
const MEMORY: f64 = 0.6;

/// The first level whose drops are fitted where there are two later ones: before it, most pixels have not settled.
const FIRST_LEVEL: u32 = 2;

/// Highest level: twice the most samples a pixel can get.
const MOST_LEVEL: u32 = 25;

/// The fall of variance, up to a factor: what matters is the variance at one number of samples over that at another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decay {
    /// Of the drop at level [`Self::level`], the part of each power law.
    parts: [f64; RATIOS.len()],
    level: u32,
}

impl Decay {
    /// That of independent samples: what is assumed before anything is seen.
    pub const HALVING: Self = Self {
        parts: [1.0, 0.0, 0.0, 0.0],
        level: 0,
    };

    /// Fits `links`: number `i` is the drop at level `i + 2` over the drop at level `i + 1`.
    pub fn fit(links: &[f64]) -> Self {
        let usable = |link: &&f64| link.is_finite() && **link > 0.0;
        let count = links.iter().take_while(usable).count();
        let Some(level) = u32::try_from(count).ok().filter(|&count| count > 0) else {
            return Self::HALVING;
        };
        // Levels 1 to `top`; the drop at `top` is 1.
        let top = level + 1;
        let mut drops = vec![1.0];
        for link in links[..count].iter().rev() {
            drops.push(drops.last().expect("is not empty") / link);
        }
        let first = FIRST_LEVEL.min(top - 1);
        let mut rows = Vec::new();
        for (age, drop) in (0..=top - first).zip(&drops) {
            // All but the newest were seen twice.
            let weight = MEMORY.powi(age.cast_signed()) * if age == 0 { 1.0 } else { 2_f64.sqrt() };
            rows.push(Row {
                values: RATIOS.map(|ratio| weight * ratio.powi(-age.cast_signed()) / drop),
                target: weight,
            });
        }
        Self {
            parts: non_negative_least_squares(&rows),
            level: top,
        }
    }

    /// The drop at level `k`.
    fn drop(&self, level: u32) -> f64 {
        self.sum(level, |_| 1.0)
    }

    /// The drop at `level` over that at the level before.
    pub fn ratio(&self, level: u32) -> f64 {
        let before = self.sum(level, |ratio| 1.0 / ratio);
        if before > 0.0 {
            self.drop(level) / before
        } else {
            0.5
        }
    }

    /// The variance left over the drop at `level`: what turns an observed drop into an error.
    pub fn variance_over_drop(&self, level: u32) -> f64 {
        let drop = self.drop(level);
        if drop > 0.0 {
            self.sum(level, remainder) / drop
        } else {
            1.0
        }
    }

    /// The variance of the mean of the first `samples`, in the unit of [`Self::drop`].
    pub fn variance(&self, samples: u32) -> f64 {
        let samples = samples.max(1);
        let level = samples.next_power_of_two().trailing_zeros();
        self.sum(level, remainder) + self.within(samples, level)
    }

    /// Expected square of the difference between the mean of the first `samples` and that of all 2ᵏ.
    ///
    /// The two halves of a block lie at equal distances on both sides of its mean; so do the halves of the halves.
    fn within(&self, samples: u32, level: u32) -> f64 {
        if samples == 1 << level {
            return 0.0;
        }
        let half = 1 << (level - 1);
        let drop = self.drop(level);
        if samples <= half {
            return drop + self.within(samples, level - 1);
        }
        let first = f64::from(half) / f64::from(samples);
        let rest = 1.0 - first;
        (first - rest).powi(2) * drop + rest.powi(2) * self.within(samples - half, level - 1)
    }

    fn sum(&self, level: u32, factor: impl Fn(f64) -> f64) -> f64 {
        let age = level.min(MOST_LEVEL).cast_signed() - self.level.cast_signed();
        let terms = self.parts.iter().zip(RATIOS);
        terms
            .map(|(part, ratio)| part * ratio.powi(age) * factor(ratio))
            .sum()
    }
}

/// All drops to come over the present one, where each is `ratio` of the one before.
fn remainder(ratio: f64) -> f64 {
    ratio / (1.0 - ratio)
}

/// One equation of a least squares problem: the values' weighted sum should be the target.
#[derive(Debug)]
struct Row {
    values: [f64; RATIOS.len()],
    target: f64,
}

/// The weights of at least 0 that bring the rows nearest to their targets. There are so few unknowns that every set of those
/// above 0 is tried.
fn non_negative_least_squares(rows: &[Row]) -> [f64; RATIOS.len()] {
    let mut best = (f64::INFINITY, Decay::HALVING.parts);
    for set in 1_usize..1 << RATIOS.len() {
        let chosen: Vec<usize> = (0..RATIOS.len()).filter(|i| set >> i & 1 == 1).collect();
        if chosen.len() > rows.len() {
            continue;
        }
        let Some(weights) = least_squares(rows, &chosen) else {
            continue;
        };
        let residual: f64 = rows
            .iter()
            .map(|row| {
                let sum: f64 = row.values.iter().zip(weights).map(|(v, w)| v * w).sum();
                (sum - row.target).powi(2)
            })
            .sum();
        if weights.iter().all(|&weight| weight >= 0.0) && residual < best.0 {
            best = (residual, weights);
        }
    }
    best.1
}

/// Least squares in the `chosen` unknowns, the others 0, by the normal equations; `None` where they hardly differ.
fn least_squares(rows: &[Row], chosen: &[usize]) -> Option<[f64; RATIOS.len()]> {
    let size = chosen.len();
    let mut matrix = [[0.0; RATIOS.len() + 1]; RATIOS.len()];
    for row in rows {
        for (line, &i) in matrix.iter_mut().zip(chosen) {
            for (cell, &j) in line.iter_mut().zip(chosen) {
                *cell += row.values[i] * row.values[j];
            }
            line[size] += row.values[i] * row.target;
        }
    }
    // The matrix is symmetric and positive, so elimination needs no change of rows.
    for pivot in 0..size {
        let largest = matrix[pivot][pivot];
        if largest.is_nan() || largest <= 1e-12 {
            return None;
        }
        let line = matrix[pivot];
        for other in (0..size).filter(|&other| other != pivot) {
            let factor = matrix[other][pivot] / largest;
            for column in pivot..=size {
                matrix[other][column] -= factor * line[column];
            }
        }
    }
    let mut weights = [0.0; RATIOS.len()];
    for (line, (row, &i)) in matrix.iter().zip(chosen).enumerate() {
        weights[i] = row[size] / row[line];
    }
    Some(weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Links of drops that fall by `ratio` at every level.
    fn steady(ratio: f64, levels: usize) -> Vec<f64> {
        vec![ratio; levels]
    }

    #[test]
    fn power_laws_are_found_again() {
        for ratio in RATIOS {
            for levels in 2..9_u32 {
                let decay = Decay::fit(&steady(ratio, levels as usize));
                let left = decay.variance_over_drop(levels);
                let expected = ratio / (1.0 - ratio);
                assert!(
                    (left / expected - 1.0).abs() < 1e-3,
                    "{ratio}, {levels}: {left}"
                );
                let fall = decay.variance(1 << (levels + 1)) / decay.variance(1 << levels);
                assert!((fall / ratio - 1.0).abs() < 1e-3, "{ratio}, {levels}");
            }
        }
    }

    #[test]
    fn a_mixture_is_extrapolated_by_its_slowest_part() {
        // Drops of 1 · 2⁻ᵏ + 40 · 8⁻ᵏ: at first the smooth part falls, later the rough one is left.
        let drop = |level: i32| 0.5_f64.powi(level) + 40.0 * 0.125_f64.powi(level);
        let links: Vec<f64> = (2..=8).map(|level| drop(level) / drop(level - 1)).collect();
        let decay = Decay::fit(&links);
        let expected = (0.5_f64.powi(8) + 40.0 * 0.125_f64.powi(8) / 7.0) / drop(8);
        assert!((decay.variance_over_drop(8) / expected - 1.0).abs() < 0.01);
    }

    #[test]
    fn without_usable_drops_samples_count_as_independent() {
        for links in [&[][..], &[f64::NAN], &[0.0, 0.5], &[-1.0, 0.5]] {
            assert_eq!(Decay::fit(links), Decay::HALVING, "{links:?}");
        }
        assert_eq!(Decay::HALVING.variance_over_drop(7), 1.0);
    }

    /// The variance of the mean of any number of independent samples is 1/n of one's.
    #[test]
    fn independent_samples_are_exact_at_every_count() {
        let one = Decay::HALVING.variance(1);
        for samples in 1..200 {
            let share = Decay::HALVING.variance(samples) * f64::from(samples) / one;
            assert!((share - 1.0).abs() < 1e-12, "{samples}: {share}");
        }
    }

    /// Scrambled nets between two powers of two, against the sequence itself: the integral of a quarter disk (a jump along a
    /// curve), whose variance over 4,000 pixels is known to 1 / √2000 = 2.3 %. 5 standard deviations and the extrapolation's own
    /// error leave 20 %; below 8 samples nets are so much better at powers of four that no smooth law holds.
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
        let decay = Decay::fit(&links);
        for samples in [12, 20, 24, 40, 48, 56, 80, 96] {
            let predicted = decay.variance(samples) / decay.variance(64) * squares[64];
            let ratio = predicted / squares[samples as usize];
            assert!((0.8..1.25).contains(&ratio), "{samples}: {ratio}");
        }
    }
}
