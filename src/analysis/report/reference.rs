//! What is taken for the truth, and how wrong that is itself.

use crate::render::{
    ErrorEstimate, Image, Interval, PreparedScene, RenderProgress, RunConfig, render,
};
use crate::scene::{Choice, LightSampling, Mode, SamplerChoice, Scene, SceneError, Stop};

use crate::io::WrittenError;
use crate::math::{counted, percent, three_digits};

/// What renders are measured against.
#[derive(Clone, Debug)]
pub struct Reference {
    /// The picture that is taken for the truth.
    pub image: Image,
    /// Where it is from.
    pub origin: Origin,
}

/// What is wrong with a reference that is a PNG.
const ROUNDED: &str =
    "it holds what a screen shows: exposure, tone curve, the end at 1 and rounding are in it";

/// Where a reference is from.
#[derive(Clone, Debug)]
pub enum Origin {
    /// Every pixel's exact answer is this radiance.
    Exact {
        /// Red, green, blue.
        radiance: [f32; 3],
    },
    /// A picture made before. Whether it shares random numbers with what is measured against it is not known.
    File {
        /// As it was named.
        name: String,
        /// How wrong it is, where the file tells.
        error: Option<WrittenError>,
        /// Whether it holds what a screen shows, rounded, as a PNG does.
        is_rounded: bool,
        /// The seed it shares with a render that is measured against it, where it is known to.
        shared_seed: Option<u64>,
    },
    /// Made by this program, independently of what is measured against it.
    Rendered {
        /// Its random numbers.
        seed: u64,
        /// Of every pixel.
        samples_per_pixel: u32,
        /// How it found light; `None` where the mode has no choice.
        light_sampling: Option<LightSampling>,
        /// What it took.
        render_seconds: f64,
        /// How wrong it is, estimated.
        error: Option<ErrorEstimate>,
        /// Samples that were infinite or not a number.
        non_finite_samples: u64,
    },
}

/// What is measured against a reference at a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// The mean square relative error.
    pub relmse: f64,
    /// What that of the renders may be at most, where they can tell.
    pub most: Option<f64>,
    /// Of the renders.
    pub samples_per_pixel: f64,
    /// Whether it falls with samples, as noise does.
    pub falls: bool,
}

impl Reference {
    /// An even picture of this size.
    #[must_use]
    pub fn exact(radiance: [f32; 3], width: u32, height: u32) -> Self {
        let mut image = Image::black(width, height);
        image.pixels.fill(radiance);
        Self {
            image,
            origin: Origin::Exact { radiance },
        }
    }

    /// Renders one for `scene` with `seed`, `samples_per_pixel` for every pixel, by the sampler of least noise, and without the bias of
    /// `render.clamp`.
    ///
    /// `by` is how it finds light in mode `path`; other modes have no choice. `None` when cancelled.
    ///
    /// # Errors
    /// What about the scene cannot be rendered.
    pub fn render(
        scene: &Scene,
        seed: u64,
        samples_per_pixel: u32,
        by: LightSampling,
        run: &RunConfig,
        progress: &RenderProgress,
    ) -> Result<Option<Self>, SceneError> {
        let mut scene = scene.clone();
        let settings = &mut scene.render;
        settings.seed = seed;
        settings.samples_per_pixel = samples_per_pixel;
        settings.stop = Stop::default();
        settings.error_estimate = true;
        settings.clamp = None;
        settings.light_sampling = by;
        settings.sampler = SamplerChoice::Sobol;
        let light_sampling = (settings.mode == Mode::Path).then_some(by);

        let Some(prepared) = PreparedScene::prepare(&scene, None, &run.cancel)? else {
            return Ok(None);
        };
        Ok(
            render(&prepared, None, run, progress, None).map(|outcome| Self {
                image: outcome.image,
                origin: Origin::Rendered {
                    seed,
                    samples_per_pixel,
                    light_sampling,
                    render_seconds: outcome.stats.render_seconds,
                    error: outcome.stats.error,
                    non_finite_samples: outcome.stats.non_finite_samples,
                },
            }),
        )
    }

    /// Whether its own mean square error is more than a quarter of that of `measured`, or is not known where that is.
    ///
    /// With sixteen times the samples it is expected to be a sixteenth.
    pub(super) fn is_too_wrong_for(&self, measured: &Self) -> bool {
        match (self.relmse(), measured.relmse()) {
            (Some(own), Some(measured)) => own.value > measured.value / 4.0,
            (own, measured) => own.is_none() && measured.is_some(),
        }
    }

    /// Root mean square of its own error; `None` where it is not known, or may not be independent of what is measured.
    #[must_use]
    pub fn rmse(&self) -> Option<Interval> {
        self.own(|error| error.rmse)
    }

    /// Mean of its own squared relative error; `None` as above.
    #[must_use]
    pub fn relmse(&self) -> Option<Interval> {
        self.own(|error| error.relmse)
    }

    fn own(&self, part: impl Fn(&ErrorEstimate) -> Interval) -> Option<Interval> {
        match &self.origin {
            Origin::Exact { .. } => Some(Interval {
                value: 0.0,
                low: 0.0,
                high: 0.0,
            }),
            Origin::File { .. } => None,
            Origin::Rendered { error, .. } => error.as_ref().map(part),
        }
    }

    /// Its own [`Self::rmse`] and [`Self::relmse`], independent of what is measured or not; `None` where they are not known.
    pub(super) fn known_errors(&self) -> Option<[f64; 2]> {
        match &self.origin {
            Origin::File { error, .. } => error.map(|error| [error.rmse, error.relmse]),
            _ => Some([self.rmse()?.value, self.relmse()?.value]),
        }
    }

    /// Whether it holds what a screen shows, not the radiance.
    pub(super) fn is_rounded(&self) -> bool {
        matches!(&self.origin, Origin::File { is_rounded, .. } if *is_rounded)
    }

    /// What makes the errors measured against it wrong, in sentences.
    pub(super) fn cautions(&self) -> Vec<String> {
        let Origin::File {
            is_rounded,
            shared_seed,
            ..
        } = &self.origin
        else {
            return Vec::new();
        };
        let rounded = is_rounded.then(|| format!("the reference is a PNG: {ROUNDED}"));
        let shared = shared_seed.map(|seed| {
            format!(
                "the reference was rendered with seed {seed}, as one of the renders that are measured against it, whose error may come \
                out too small: choose another with --set render.seed=N"
            )
        });
        rounded.into_iter().chain(shared).collect()
    }

    /// Whether more than half of the mean square relative error that is measured against it is not that of the renders.
    ///
    /// What a file does not tell of its own error shows in what is measured: mean squares add, and that of the renders is known. Of a
    /// reference that is known renders may say too little of theirs, which falls; what does not fall is another picture's.
    pub(super) fn outweighs(&self, seen: &Seen) -> bool {
        let renders_know_less = seen.most.is_some_and(|most| most < seen.relmse / 2.0);
        let is_known = self
            .known_errors()
            .is_some_and(|[_, own]| own > seen.relmse / 2.0);
        is_known
            || match self.origin {
                Origin::Exact { .. } => renders_know_less && !seen.falls,
                Origin::File { .. } => renders_know_less,
                // From few samples its estimate says too little.
                Origin::Rendered {
                    samples_per_pixel, ..
                } => seen.samples_per_pixel > f64::from(samples_per_pixel),
            }
    }

    /// What it is, in a line.
    #[must_use]
    pub fn describe(&self) -> String {
        match &self.origin {
            Origin::Exact { radiance } => {
                let [r, g, b] = radiance;
                format!("the exact answer, radiance {r}, {g}, {b} in every pixel")
            }
            Origin::File { name, .. } => format!("{name}; {}", self.describe_error()),
            Origin::Rendered {
                seed,
                samples_per_pixel,
                light_sampling,
                ..
            } => {
                let way = light_sampling.map_or_else(String::new, |way| {
                    format!(", light_sampling {}", way.name())
                });
                let samples = counted(u64::from(*samples_per_pixel), "sample", "samples");
                format!(
                    "a render of {samples} per pixel, seed {seed}{way}; {}",
                    self.describe_error()
                )
            }
        }
    }

    fn describe_error(&self) -> String {
        match self.known_errors() {
            Some([rmse, relmse]) => {
                let when = if self.is_rounded() {
                    " before it was written as a PNG"
                } else {
                    ""
                };
                format!(
                    "its own error{when}, estimated: {} noise, RMSE {}",
                    percent(relmse.sqrt()),
                    three_digits(rmse)
                )
            }
            None => "its own error is not known".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::report::test_data;

    #[test]
    fn a_reference_is_as_even_as_can_be_whatever_the_scene_says() {
        let mut scene = crate::io::demo_scene();
        [scene.render.width, scene.render.height] = [8, 6];
        let mut picture_by = |sampler| {
            scene.render.sampler = sampler;
            let (run, progress) = (RunConfig::default(), RenderProgress::default());
            let way = scene.render.light_sampling;
            let reference = Reference::render(&scene, 3, 4, way, &run, &progress);
            reference
                .expect("can be rendered")
                .expect("nobody cancels")
                .image
        };
        let [spread, independent] =
            [SamplerChoice::Sobol, SamplerChoice::Independent].map(&mut picture_by);
        assert_eq!(spread, independent);
    }

    /// More than half of the mean square must be known to be the reference's.
    #[test]
    fn a_reference_outweighs_renders_that_are_better() {
        let silent = test_data::file_reference(None);
        let telling = test_data::file_reference(Some(0.03));
        let rendered = test_data::rendered_reference(0.1, 0.03);
        let exact = Reference::exact([1.0; 3], 2, 1);
        let seen = |relmse, most| Seen {
            relmse,
            most,
            samples_per_pixel: 128.0,
            falls: true,
        };
        let even = |seen| Seen {
            falls: false,
            ..seen
        };
        let later = |seen| Seen {
            samples_per_pixel: 129.0,
            ..seen
        };
        for (reference, seen, expected) in [
            (&silent, seen(0.04, None), false),
            (&silent, seen(0.04, Some(0.03)), false),
            (&silent, seen(0.04, Some(0.01)), true),
            (&silent, seen(f64::NAN, Some(0.01)), false),
            (&telling, seen(0.05, None), true),
            (&telling, seen(0.07, None), false),
            (&telling, seen(0.07, Some(0.01)), true),
            (&rendered, seen(0.05, None), true),
            // What renders say too little of is no reason to doubt a reference that is known.
            (&rendered, seen(0.07, Some(0.01)), false),
            (&exact, seen(0.04, Some(0.01)), false),
            // One of 128 samples has more noise than renders of more.
            (&rendered, later(seen(0.07, None)), true),
            (&exact, even(seen(0.04, Some(0.03))), false),
            (&exact, even(seen(0.04, Some(0.01))), true),
        ] {
            let found = reference.outweighs(&seen);
            assert_eq!(found, expected, "{} {seen:?}", reference.describe());
        }
        assert_eq!(telling.relmse(), None, "it may not be independent");
        assert!(!telling.describe().contains("PNG"));
        let mut png = telling.clone();
        if let Origin::File { is_rounded, .. } = &mut png.origin {
            *is_rounded = true;
        }
        let said = png.describe();
        assert!(said.contains("before it was written as a PNG"), "{said}");
    }
}
