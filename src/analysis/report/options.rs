//! What somebody wants a report of.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use crate::scene::RenderSettings;

/// How many times the samples of what is measured the reference gets: 1/16 of its mean square error, or less.
const REFERENCE_FACTOR: u32 = 16;

/// What is measured, and against what.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportOptions {
    /// Width and height of the picture in pixels; `None` for the scene's.
    pub size: Option<(u32, u32)>,
    /// Samples of a pixel at the last point, in [`Self::SAMPLES`]; `None` for [`Self::default_samples`].
    pub samples: Option<u32>,
    /// Renders of each variant, in [`Self::SEEDS`].
    pub seeds: u32,
    /// Changes of the scene, each `KEY=VALUE`.
    pub assignments: Vec<String>,
    /// Variants of the changed scene, each `KEY=VALUE[;KEY=VALUE...]`.
    pub comparisons: Vec<String>,
    /// What is taken for the truth.
    pub reference: ReferenceOptions,
}

/// What is taken for the truth.
#[derive(Clone, Debug, PartialEq)]
pub enum ReferenceOptions {
    /// A render of its own, with so many samples of a pixel; `None` for [`ReportOptions::default_reference_samples`].
    Rendered {
        /// From 1 to [`RenderSettings::MAX_SAMPLES`].
        samples: Option<u32>,
    },
    /// A picture made before.
    File(PathBuf),
    /// This radiance in every pixel.
    Exact([f32; 3]),
}

impl Default for ReportOptions {
    fn default() -> Self {
        Self {
            size: None,
            samples: None,
            seeds: Self::DEFAULT_SEEDS,
            assignments: Vec::new(),
            comparisons: Vec::new(),
            reference: ReferenceOptions::Rendered { samples: None },
        }
    }
}

impl ReportOptions {
    /// Renders of each variant that are usual: enough to see how much they differ.
    pub const DEFAULT_SEEDS: u32 = 5;
    /// Renders of each variant there can be.
    pub const SEEDS: RangeInclusive<u32> = 1..=1000;
    /// Samples of a pixel there can be at the last point. With 16 there are 3 points that a slope is fitted to.
    pub const SAMPLES: RangeInclusive<u32> = 16..=RenderSettings::MAX_SAMPLES;

    /// Samples of a pixel at the last point where nothing else is asked for: those of the scene, where they are enough.
    #[must_use]
    pub fn default_samples(render: &RenderSettings) -> u32 {
        render.samples_per_pixel.max(*Self::SAMPLES.start())
    }

    /// Samples of a pixel of the reference where nothing else is asked for. `most`: those of what is measured against it.
    #[must_use]
    pub fn default_reference_samples(most: u32) -> u32 {
        let samples = most.saturating_mul(REFERENCE_FACTOR);
        samples.min(RenderSettings::MAX_SAMPLES)
    }
}

/// Reads red, green, blue, such as `1,1,1`.
///
/// # Errors
/// What was expected, where it is anything but three finite numbers of at least 0.
pub fn parse_radiance(text: &str) -> Result<[f32; 3], String> {
    let values: Option<Vec<f32>> = text
        .split(',')
        .map(|value| {
            value
                .trim()
                .parse()
                .ok()
                .filter(|value: &f32| value.is_finite() && *value >= 0.0)
        })
        .collect();
    let values = values.and_then(|values| values.try_into().ok());
    values.ok_or_else(|| "expected red, green, blue, each at least 0, such as 1,1,1".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_radiance_is_three_numbers() {
        assert_eq!(parse_radiance("1, 0.5,2"), Ok([1.0, 0.5, 2.0]));
        for wrong in ["1", "1,2", "1,2,3,4", "a,1,1", "1,1,inf", "-1,0,0", ""] {
            assert!(parse_radiance(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn samples_left_out_are_enough_and_not_too_many() {
        let with = |samples_per_pixel| RenderSettings {
            samples_per_pixel,
            ..RenderSettings::default()
        };
        assert_eq!(ReportOptions::default_samples(&with(4)), 16);
        assert_eq!(ReportOptions::default_samples(&with(100)), 100);
        assert_eq!(ReportOptions::default_reference_samples(16), 256);
        let most = RenderSettings::MAX_SAMPLES;
        assert_eq!(ReportOptions::default_reference_samples(most), most);
    }
}
