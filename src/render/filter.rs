//! Where around the centre of a pixel its samples fall.

use crate::math::Vec2;
use crate::scene::Filter;

/// A sample's place relative to the centre of its pixel, in pixels, distributed as `filter` weighs; `u` is uniform over the unit
/// square.
pub fn offset(filter: Filter, u: Vec2) -> Vec2 {
    match filter {
        Filter::Box => u - 0.5,
        Filter::Tent => u.map(tent),
        Filter::Gaussian => u.map(gaussian),
    }
}

/// The inverse of the cumulative distribution of `1 − |x|` on `−1..=1`.
fn tent(u: f32) -> f32 {
    if u < 0.5 {
        (2.0 * u).sqrt() - 1.0
    } else {
        1.0 - (2.0 - 2.0 * u).sqrt()
    }
}

/// The inverse of the cumulative normal distribution of standard deviation ½, cut at ±2 (four standard deviations).
///
/// Source: Giles, Approximating the erfinv function, GPU Computing Gems 2, 2011 (single precision coefficients).
fn gaussian(u: f32) -> f32 {
    const DEVIATION: f32 = 0.5;
    /// erf(4/√2): the part of the distribution within the cut.
    const KEPT: f32 = 0.999_936_66;
    let x = (2.0 * u - 1.0) * KEPT;
    let w = -libm::log1pf(-x * x);
    let polynomial = if w < 5.0 {
        let w = w - 2.5;
        [
            2.810_226_4e-8,
            3.432_739_4e-7,
            -3.523_387_7e-6,
            -4.391_506_5e-6,
            2.185_808_7e-4,
            -1.253_725e-3,
            -4.177_681_6e-3,
            0.246_640_73,
            1.501_409_4,
        ]
        .into_iter()
        .fold(0.0, |sum, coefficient| sum * w + coefficient)
    } else {
        let w = w.sqrt() - 3.0;
        [
            -2.002_142_6e-4,
            1.009_505_6e-4,
            1.349_343_2e-3,
            -3.673_428_4e-3,
            5.739_507_7e-3,
            -7.622_461_3e-3,
            9.438_870_5e-3,
            1.001_674,
            2.832_976_8,
        ]
        .into_iter()
        .fold(0.0, |sum, coefficient| sum * w + coefficient)
    };
    DEVIATION * std::f32::consts::SQRT_2 * polynomial * x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean of `x²` over a fine grid of `u`: 1/6 for the tent, ¼ for the Gaussian.
    #[test]
    fn filters_have_their_width() {
        let second_moment = |warp: fn(f32) -> f32| {
            let steps = 100_000;
            let sum: f64 = (0..steps)
                .map(|i| f64::from(warp((i as f32 + 0.5) / steps as f32)).powi(2))
                .sum();
            sum / f64::from(steps)
        };
        assert!((second_moment(tent) - 1.0 / 6.0).abs() < 1e-5);
        assert!(
            (second_moment(gaussian) - 0.25).abs() < 1e-3,
            "{}",
            second_moment(gaussian)
        );
        for (warp, reach) in [(tent as fn(f32) -> f32, 1.0), (gaussian, 2.0)] {
            assert!(warp(0.5).abs() < 1e-6);
            assert!(
                (warp(0.0) + reach).abs() < 1e-2 && (warp(0.999_999_9) - reach).abs() < 2e-2,
                "{} {}",
                warp(0.0),
                warp(0.999_999_9)
            );
        }
        // The cumulative normal distribution at one deviation.
        assert!((gaussian(0.841_344_7) - 0.5).abs() < 1e-3);
    }
}
