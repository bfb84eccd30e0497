//! One render, measured whenever its samples have doubled.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use super::reference::Reference;
use crate::analysis::{SquaredErrors, percentile_999_between};
use crate::render::{
    ErrorEstimate, Image, PreparedScene, RenderProgress, RenderStats, Round, RunConfig, Watch,
    render_watched,
};
use crate::scene::{Scene, SceneError};

/// A render that was measured on its way.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Its random numbers.
    pub seed: u64,
    /// What it took to prepare the scene.
    pub build_seconds: f64,
    /// At every power of two of samples, and at the end.
    pub measurements: Vec<Measurement>,
    /// What it took in all.
    pub stats: RenderStats,
}

/// The errors of a picture at a moment of its render.
#[derive(Clone, Copy, Debug)]
pub struct Measurement {
    /// Mean over the pixels.
    pub samples_per_pixel: f64,
    /// Wall time of rendering.
    pub seconds: f64,
    /// Processor time of the threads that render.
    pub cpu_seconds: f64,
    /// What the render knows by itself; `None` before it can, and where it is not to.
    pub estimated: Option<ErrorEstimate>,
    /// How far it is from the reference.
    pub measured: SquaredErrors,
    /// What the worst channel's distance from the reference exceeds in one pixel of a thousand.
    pub measured_percentile_999: f64,
}

/// Errors without that of the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueErrors {
    /// Mean squared error.
    pub mse: f64,
    /// Mean squared relative error.
    pub relmse: f64,
    /// What the worst channel's error exceeds in one pixel of a thousand.
    pub percentile_999: f64,
}

impl Measurement {
    /// The errors against the truth that `reference` stands for. Its errors are independent of those measured against it, so
    /// that mean squares add: the mean of what is measured is `σ²/N + σ²/N_ref`. Where the reference's own error is not known,
    /// nothing is taken away. Never below 0. Percentiles do not add: of that the same part is left as of the RMSE.
    #[must_use]
    pub fn true_errors(&self, reference: &Reference) -> TrueErrors {
        let square = |value: f64| value * value;
        let own_mse = reference.rmse().map(|rmse| square(rmse.value));
        let own_relmse = reference.relmse().map(|relmse| relmse.value);
        let mse = without(self.measured.mse, own_mse);
        let left = if self.measured.mse > 0.0 {
            (mse / self.measured.mse).sqrt()
        } else {
            1.0
        };
        TrueErrors {
            mse,
            relmse: without(self.measured.relmse, own_relmse),
            percentile_999: self.measured_percentile_999 * left,
        }
    }
}

/// The part of a mean square that is not the reference's own. What is not a number stays so.
fn without(measured: f64, own: Option<f64>) -> f64 {
    let left = measured - own.unwrap_or(0.0);
    if left < 0.0 { 0.0 } else { left }
}

impl Trial {
    /// Prepares and renders `scene` with this seed, and measures it against `reference`. Returns the picture too; `None` when cancelled.
    ///
    /// # Errors
    /// What about the scene cannot be rendered.
    ///
    /// # Panics
    /// When the reference is of another size than the scene's picture.
    pub fn render(
        scene: &Scene,
        seed: u64,
        reference: &Reference,
        run: &RunConfig,
        progress: &RenderProgress,
    ) -> Result<Option<(Self, Image)>, SceneError> {
        let mut scene = scene.clone();
        scene.render.seed = seed;
        let started = Instant::now();
        let Some(prepared) = PreparedScene::prepare(&scene, None, &run.cancel)? else {
            return Ok(None);
        };
        let build_seconds = started.elapsed().as_secs_f64();

        let measurements = Mutex::new(Vec::new());
        let on_round = |round: &Round<'_>| {
            let image = round.image();
            let same_size = "the reference is of the picture's size";
            let measured = SquaredErrors::measure(&image, &reference.image).expect(same_size);
            let percentile = percentile_999_between(&image, &reference.image);
            let measurement = Measurement {
                samples_per_pixel: round.samples_per_pixel,
                seconds: round.seconds,
                cpu_seconds: round.cpu_seconds,
                estimated: round.error,
                measured,
                measured_percentile_999: percentile.expect(same_size),
            };
            let mut known = measurements.lock().unwrap_or_else(PoisonError::into_inner);
            known.push(measurement);
        };
        let watch = Watch {
            on_round: Some(&on_round),
            ..Watch::default()
        };
        let outcome = render_watched(&prepared, None, run, progress, watch);
        Ok(outcome.map(|outcome| {
            let measurements = measurements.into_inner();
            let trial = Self {
                seed,
                build_seconds,
                measurements: measurements.unwrap_or_else(PoisonError::into_inner),
                stats: outcome.stats,
            };
            (trial, outcome.image)
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::report::test_data;

    /// By hand: the reference's rmse of 0.1 is a mean square of 0.01.
    #[test]
    fn the_error_of_the_reference_is_taken_away() {
        let mut measurement = test_data::measurement(4.0, 1.0, 0.05, 0.09);
        let reference = test_data::rendered_reference(0.1, 0.04);
        let errors = measurement.true_errors(&reference);
        assert!((errors.mse - 0.04).abs() < 1e-15 && (errors.relmse - 0.05).abs() < 1e-15);
        // Of an rmse of √0.05 there is √0.04 left.
        let left = 0.625 * (0.04_f64 / 0.05).sqrt();
        assert!((errors.percentile_999 - left).abs() < 1e-12);
        measurement.measured.relmse = 0.03;
        assert_eq!(measurement.true_errors(&reference).relmse, 0.0);
        measurement.measured.relmse = f64::NAN;
        assert!(measurement.true_errors(&reference).relmse.is_nan());

        let exact = Reference::exact([1.0; 3], 1, 1);
        assert_eq!(measurement.true_errors(&exact).mse, 0.05);
    }
}
