//! What it took renders to the noise at which they stop.

use serde::Serialize;

use super::study::Variant;
use super::summary::spread;
use crate::render::{Ending, RenderStats};

/// What it took renders to the noise at which they were to stop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Target {
    /// What was asked for, as √relmse.
    pub noise: f64,
    /// How many renders say that they are there.
    pub reached: usize,
    /// How many had all their samples before.
    pub out_of_samples: usize,
    /// How many the clock ended before.
    pub out_of_time: usize,
    /// Of how many.
    pub renders: usize,
    /// What those took that are; `None` where none is.
    pub took: Option<Took>,
}

/// Medians over renders; what is called a range holds the least and the largest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Took {
    /// Mean over the pixels.
    pub samples_per_pixel: f64,
    /// Wall time of rendering.
    pub seconds: f64,
    /// Its range.
    pub seconds_range: [f64; 2],
    /// Processor time of the threads that render.
    pub cpu_seconds: f64,
    /// Its range.
    pub cpu_seconds_range: [f64; 2],
}

impl Target {
    /// That of the trials of `variant`; `None` where they stop at no noise.
    pub(super) fn of(variant: &Variant) -> Option<Self> {
        let trials = &variant.trials;
        let ended = |ending| trials.iter().filter(move |t| t.stats.ending == ending);
        let reached = || ended(Ending::Noise);
        let of = |value: fn(&RenderStats) -> f64| spread(reached().map(|t| value(&t.stats)));
        let took = || {
            let (seconds, cpu_seconds) = (of(|s| s.render_seconds)?, of(|s| s.cpu_seconds)?);
            Some(Took {
                samples_per_pixel: of(|s| s.samples_per_pixel)?.median,
                seconds: seconds.median,
                seconds_range: [seconds.min, seconds.max],
                cpu_seconds: cpu_seconds.median,
                cpu_seconds_range: [cpu_seconds.min, cpu_seconds.max],
            })
        };
        Some(Self {
            noise: variant.scene.render.stop.noise?,
            reached: reached().count(),
            out_of_samples: ended(Ending::Samples).count(),
            out_of_time: ended(Ending::Time).count(),
            renders: trials.len(),
            took: took(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::report::test_data;

    #[test]
    fn the_time_to_the_noise_that_was_asked_for_is_that_of_the_renders_that_reached_it() {
        let mut study = test_data::study();
        let variant = &mut study.variants[0];
        assert_eq!(Target::of(variant), None);
        variant.scene.render.stop.noise = Some(0.05);
        let nobody = Target::of(variant).expect("is asked for");
        assert_eq!((nobody.reached, nobody.took), (0, None));
        assert_eq!((nobody.out_of_samples, nobody.out_of_time), (3, 0));
        for (trial, seconds) in variant.trials.iter_mut().zip([8.0, 6.0]) {
            trial.stats.ending = Ending::Noise;
            trial.stats.render_seconds = seconds;
            trial.stats.cpu_seconds = 2.0 * seconds;
        }
        let target = Target::of(variant).expect("is asked for");
        assert_eq!((target.noise, target.reached, target.renders), (0.05, 2, 3));
        let took = target.took.expect("two are there");
        assert_eq!((took.seconds, took.seconds_range), (7.0, [6.0, 8.0]));
        assert_eq!(took.cpu_seconds_range, [12.0, 16.0]);
    }
}
