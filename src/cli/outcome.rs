//! What a render took and how wrong it is, in words.

use std::path::Path;

use anyhow::Result;

use crate::math::percent;
use crate::render::{Ending, ErrorEstimate, Image, RenderStats};
use crate::scene::RenderSettings;

/// Prints what a render took and how wrong it is, and warns of what went wrong. The picture comes with its place and its hash;
/// `samples_key` is what the user has said the most samples of a pixel by.
pub(super) fn say(
    (output, image, hash): (&Path, &Image, &str),
    stats: &RenderStats,
    settings: &RenderSettings,
    samples_key: &str,
) -> Result<()> {
    let rate = stats.rays.total() as f64 / stats.render_seconds.max(1e-9) / 1e6;
    super::say(&format!(
        "{}: {}×{} pixels, {}, {:.2} s, {rate:.2} Mrays/s, hash {}",
        output.display(),
        image.width,
        image.height,
        describe_samples(stats),
        stats.render_seconds,
        &hash[..16]
    ))?;
    if let Some(error) = &stats.error {
        super::say(&describe_error(error))?;
    }
    if stats.ending == Ending::Interrupted {
        let gaps = if stats.sample_range[0] == 0 {
            ", and is black where there are none"
        } else {
            ""
        };
        super::warn(&format!(
            "interrupted: the picture has the samples taken so far{gaps}"
        ));
    }
    if stats.ending == Ending::Time && stats.sample_range[0] == 0 {
        super::warn(
            "the time was up before every pixel had a sample: the picture is black where there is none",
        );
    }
    if stats.ending != Ending::Noise
        && let Some(noise) = settings.stop.noise
    {
        let reason = match stats.ending {
            Ending::Time => "the time was up".to_owned(),
            Ending::Interrupted => "the render was interrupted".to_owned(),
            _ => format!("pixels have all the samples that {samples_key} allows"),
        };
        super::warn(&format!(
            "noise is not down to {}: {reason}",
            percent(noise)
        ));
    }
    if stats.non_finite_samples > 0 {
        super::warn(&format!(
            "{} samples were infinite or not a number",
            stats.non_finite_samples
        ));
    }
    if stats.negative_samples > 0 {
        super::warn(&format!(
            "{} samples had less than no light",
            stats.negative_samples
        ));
    }
    if let Some(share) = stats.notable_depth_limited_share() {
        super::warn(&format!(
            "{:.0} % of the samples may lack light: render.max_bounces = {} ended their paths",
            share * 100.0,
            settings.max_bounces
        ));
    }
    if settings.clamp.is_some() {
        super::tell(&format!(
            "render.clamp limited {} samples and took {:.3} % of the picture's light away",
            stats.clamped.samples,
            stats.clamped.energy_share * 100.0
        ));
    }
    Ok(())
}

/// Samples per pixel in words.
fn describe_samples(stats: &RenderStats) -> String {
    match stats.sample_range {
        [1, 1] => "1 sample".to_owned(),
        [least, most] if least == most => format!("{most} samples"),
        [least, most] => format!(
            "{:.1} samples on average ({least} to {most})",
            stats.samples_per_pixel
        ),
    }
}

/// The error in one line.
fn describe_error(error: &ErrorEstimate) -> String {
    let noise = error.noise();
    format!(
        "estimated noise {} ({} to {}), rmse {:.3e}, 99.9 % of pixels within {:.3e} ({:.3e} to {:.3e})",
        percent(noise.value),
        percent(noise.low),
        percent(noise.high),
        error.rmse.value,
        error.percentile_999.value,
        error.percentile_999.low,
        error.percentile_999.high
    )
}
