//! What samples take, counted in full: rays by purpose and random numbers by decision.

use super::camera_samples::SampleId;
use super::kernel::Watched;
use super::plan::Feature;
use super::prepare::PreparedScene;
use super::run::RayCounts;
use super::sampler::Decision;
use super::stops::Stops;
use super::tally::WorkTally;
use crate::control::{CancelToken, Throttle};

/// What some samples took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Pixels they are of.
    pub pixels: u64,
    /// How many they are.
    pub samples: u64,
    /// Their rays.
    pub rays: RayCounts,
    /// Those to lights that asked for the nearest hit, as it may be of glass.
    pub shadow_rays_for_glass: u64,
    draws: [u64; Decision::ALL.len()],
}

impl Work {
    /// That of the first `samples` samples of each pixel, at column `x` and row `y`.
    ///
    /// # Panics
    /// Where a sample makes a render panic.
    #[must_use]
    pub fn of(
        scene: &PreparedScene,
        pixels: impl IntoIterator<Item = (u32, u32)>,
        samples: u32,
    ) -> Self {
        let mut work = Self::default();
        let (never, throttle) = (CancelToken::new(), Throttle::default());
        let stops = Stops {
            cancel: &never,
            halt: &never,
            throttle: &throttle,
        };
        for pixel in pixels {
            let mut line = None;
            work.pixels += 1;
            for index in 0..samples {
                let mut tally = WorkTally::default();
                let id = SampleId { pixel, index };
                let begun = match &line {
                    Some(known) if !scene.does(Feature::EyeRays) => scene.along(known, id),
                    _ => scene.begin(id, &mut tally),
                };
                let _ = scene.gathered::<Watched>(&begun, &stops, &mut tally);
                work.samples += 1;
                line = Some(begun);
                work.rays.add(&tally.counts);
                work.shadow_rays_for_glass += tally.for_glass;
                for (sum, draws) in work.draws.iter_mut().zip(tally.draws) {
                    *sum += draws;
                }
            }
        }
        work
    }

    /// How often random numbers were drawn for a decision: one, or a pair.
    #[must_use]
    pub fn draws(&self, decision: Decision) -> u64 {
        self.draws[decision as usize]
    }

    /// How often random numbers were drawn in all.
    #[must_use]
    pub fn all_draws(&self) -> u64 {
        self.draws.iter().sum()
    }
}
