//! The lengths of passes over all pixels, and when some pixels may get more samples than others: by rules and numbers of samples alone.

use crate::render::film::block_after;
use crate::render::rules::StopRules;
use crate::scene::RenderSettings;

/// Most samples of a pixel that are summed before they meet the film. Passes grow to this size, so that a whole picture is soon
/// there. Their sizes are part of the picture's definition: they fix the order of additions.
pub(super) const MOST_SAMPLES_PER_PASS: u32 = 16;

/// What every pixel gets before a render stops for its noise, or gives some pixels more than others: from fewer, what is rare
/// would be taken for absent.
pub(super) const LEAST_SAMPLES: u32 = 16;

/// The numbers of samples of every pixel at which passes end, from none on, where each is as long as it may be.
fn ends_of_passes() -> impl Iterator<Item = u32> {
    let next = |&taken: &u32| Some(taken + block_after(taken).min(MOST_SAMPLES_PER_PASS));
    std::iter::successors(Some(0), next)
}

/// How many passes give every pixel that many samples, where nothing ends the render before.
#[must_use]
pub fn even_passes(samples: u32) -> u32 {
    let earlier = |&end: &u32| end < samples;
    ends_of_passes()
        .take_while(earlier)
        .fold(0, |passes, _| passes + 1)
}

/// The first number of samples, from `samples` on, at which a pass over all pixels ends, where none may get more than `most`.
pub(super) fn end_of_even_pass(samples: f64, most: u32) -> u32 {
    ends_of_passes()
        .find(|&end| f64::from(end) >= samples || end >= most)
        .map_or(most, |end| end.min(most))
}

/// Whether a pass that is as long as it may be ends with so many samples of every pixel.
pub(super) fn is_end_of_a_pass(samples: u32) -> bool {
    ends_of_passes().find(|&end| end >= samples) == Some(samples)
}

/// Whether a render that may end by these rules gives some pixels more samples than others.
pub(super) fn chooses_pixels(settings: &RenderSettings, rules: &StopRules) -> bool {
    let stop = &rules.stop;
    settings.adaptive
        && settings.measures_error()
        && (stop.noise.is_some() || stop.seconds.is_some())
}

/// Whether rules that are changed from `before` to `after` lead to another picture than the new ones would have from the start, where they end
/// up with as many samples. `even_samples`: those that every pixel has; `has_chosen`: whether some have more.
pub fn leads_elsewhere(
    settings: &RenderSettings,
    [before, after]: [&StopRules; 2],
    even_samples: u32,
    has_chosen: bool,
) -> bool {
    let choice = |rules: &StopRules| (rules.samples_per_pixel, rules.stop.noise);
    let chooses = chooses_pixels(settings, after);
    // Whether pixels are chosen, and when from, depends on what is asked for.
    let would_choose_alike = chooses_pixels(settings, before) && choice(before) == choice(after);
    if has_chosen {
        !chooses || !would_choose_alike
    } else {
        chooses && !would_choose_alike && even_samples > LEAST_SAMPLES
    }
}
