//! Samples so rare and so bright that each of them will show as a speck.

use super::pilot::Pilot;
use super::tally::Tally;
use super::{Figure, Hazard, HazardKind, Place, Severity, Subject};
use crate::math::{percent, three_digits};
use crate::scene::Scene;

/// What a sample must add to its pixel to show, of the picture's mean luminance; it must also double it.
const LEAST_ADDED: f64 = 0.1;

/// So many samples must be specks: a rate from fewer is known to no better than a factor.
const FEWEST: u64 = 3;

/// Looks for specks among the samples of `pilot`, as they would be in the picture of `scene`.
///
/// A sample counts as one if its share of a pixel with all the scene's samples is more than the mean of the other samples of
/// its pilot pixel, more than that of these and the samples of the eight pixels around, and more than a tenth of the picture's
/// mean. With N samples of which a part r are specks, a pixel has one with the probability 1 − (1 − r)ᴺ.
pub fn examine(scene: &Scene, pilot: &Pilot) -> Option<Hazard> {
    let specks = Specks::among(pilot, scene.render.samples_per_pixel);
    let tally = specks.tally(scene, pilot);
    if tally.count < FEWEST {
        return None;
    }
    let rate = tally.count as f64 / pilot.samples() as f64;
    let samples = scene.render.samples_per_pixel;
    let share = -f64::exp_m1(f64::from(samples) * f64::ln_1p(-rate));
    let pixels = scene.render.pixel_count() as f64;
    Some(Hazard {
        kind: HazardKind::Fireflies,
        severity: Severity::Warning,
        subject: Subject::Picture {},
        count: tally.count,
        places: tally.places,
        figure: Some(Figure {
            value: share,
            of: "share of the pixels that are expected to have one",
        }),
        message: format!(
            "about {} of {pixels} pixels ({}) will be specks more than twice as bright as what is around them: of {} samples of a \
             pilot picture, {} are bright enough for that with {samples} per pixel, and carry {} of the variance",
            three_digits(share * pixels),
            percent(share),
            pilot.samples(),
            tally.count,
            percent(specks.share_of_variance)
        ),
        advice: advice(scene).to_owned(),
    })
}

fn advice(scene: &Scene) -> &'static str {
    use crate::scene::{LightSampling, Mode};
    match (scene.render.mode, scene.render.light_sampling) {
        (Mode::Path, LightSampling::Bsdf) => {
            "Set render.light_sampling to mis, which aims at lights; or make the lights larger; or limit samples by render.clamp, \
             which takes their light away and says how much."
        }
        (Mode::Path, LightSampling::Nee) => {
            "Set render.light_sampling to mis; or make small lights that mirrors and glass show larger; or limit samples by \
             render.clamp, which takes their light away and says how much."
        }
        _ => {
            "Make small, bright lights larger, above all those that mirrors and glass throw on surfaces, and lights near surfaces \
             fainter; take more samples; or limit them by render.clamp, which takes their light away and says how much."
        }
    }
}

struct Specks {
    /// Pixel of each.
    pixels: Vec<usize>,
    /// What they carry of the variance within pixels.
    share_of_variance: f64,
}

impl Specks {
    /// The specks among the samples, where a pixel has `samples` of them in the end.
    fn among(pilot: &Pilot, samples: u32) -> Self {
        let (width, height) = (pilot.width, pilot.height);
        let seeds = pilot.luminances.len() as f64;
        let sum_of = |pixel: usize| {
            pilot
                .luminances
                .iter()
                .map(|picture| picture[pixel])
                .sum::<f64>()
        };
        let sums: Vec<f64> = (0..width * height).map(sum_of).collect();
        let mean = sums.iter().sum::<f64>() / (sums.len() as f64 * seeds);
        let (mut all, mut of_specks) = (0.0, 0.0);
        let mut pixels = Vec::new();
        for pixel in 0..sums.len() {
            let (x, y) = (pixel % width, pixel / width);
            let columns = x.saturating_sub(1)..(x + 2).min(width);
            let rows = y.saturating_sub(1)..(y + 2).min(height);
            let around =
                rows.flat_map(|row| columns.clone().map(move |column| row * width + column));
            let (sum, count) = around.fold((0.0, 0.0), |(sum, count), pixel| {
                (sum + sums[pixel], count + seeds)
            });
            for picture in &pilot.luminances {
                let value = picture[pixel];
                let square = (value - sums[pixel] / seeds).powi(2);
                all += square;
                let others = (sum - value) / (count - 1.0);
                let others_here = (sums[pixel] - value) / (seeds - 1.0);
                let least = others.max(others_here).max(LEAST_ADDED * mean);
                if value / f64::from(samples) > least {
                    of_specks += square;
                    pixels.push(pixel);
                }
            }
        }
        Self {
            pixels,
            share_of_variance: if all > 0.0 { of_specks / all } else { 0.0 },
        }
    }

    /// Where they are in the picture of `scene`.
    fn tally(&self, scene: &Scene, pilot: &Pilot) -> Tally {
        let mut tally = Tally::default();
        for &pixel in &self.pixels {
            tally.add(|| Place {
                pixel: Some([
                    scaled(pixel % pilot.width, pilot.width, scene.render.width),
                    scaled(pixel / pilot.width, pilot.height, scene.render.height),
                ]),
                ..Place::default()
            });
        }
        tally
    }
}

/// The pixel of a row of `large` that lies at the middle of pixel number `at` of a row of `small`.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a place in the row"
)]
fn scaled(at: usize, small: usize, large: u32) -> u32 {
    ((at as f64 + 0.5) / small as f64 * f64::from(large)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::RenderSettings;

    /// A grey picture of 6×4 pixels and 16 samples, with some values changed: seed, pixel, value.
    fn pilot(changes: &[(usize, usize, f64)]) -> Pilot {
        let mut luminances = vec![vec![0.5; 24]; 16];
        for &(seed, pixel, value) in changes {
            luminances[seed][pixel] = value;
        }
        Pilot {
            width: 6,
            height: 4,
            luminances,
            non_finite: 0,
            depth_limited: 0,
        }
    }

    fn scene(samples_per_pixel: u32) -> Scene {
        Scene {
            render: RenderSettings {
                width: 60,
                height: 40,
                samples_per_pixel,
                ..RenderSettings::default()
            },
            ..Scene::default()
        }
    }

    #[test]
    fn samples_that_double_a_pixel_by_themselves_are_specks() {
        // At 64 samples, 40 adds 0.625 to 0.5, and 30 less than that.
        let bright = [(0, 0, 40.0), (3, 10, 40.0), (9, 21, 40.0), (2, 2, 30.0)];
        let found = examine(&scene(64), &pilot(&bright)).expect("is there");
        assert_eq!(found.count, 3);
        let figure = found.figure.expect("is one").value;
        let expected = 1.0 - (1.0 - 3.0 / 384.0_f64).powi(64);
        assert!((figure - expected).abs() < 1e-12);
        let pixels: Vec<_> = found.places.iter().map(|place| place.pixel).collect();
        assert_eq!(pixels, [[5, 5], [45, 15], [35, 35]].map(Some));
        assert!(examine(&scene(128), &pilot(&bright)).is_none());
    }

    /// A lamp that is seen is as bright in every sample.
    #[test]
    fn bright_pixels_are_no_specks() {
        let lamp: Vec<_> = (0..16).map(|seed| (seed, 8, 1000.0)).collect();
        assert!(examine(&scene(4), &pilot(&lamp)).is_none());
    }
}
