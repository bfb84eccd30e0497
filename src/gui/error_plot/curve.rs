//! What the plot shows of one render, and what can be read from its points.

use crate::gui::document::{same_geometry, same_image};
use crate::gui::picture::{Outcome, Picture};
use crate::gui::status_bar::duration;
use crate::gui::widgets::{chosen_percent, counted, percent};
use crate::render::{ErrorPoint, Interval, NOISE_TARGETS};
use crate::scene::{Choice, RenderSettings, Scene};

/// The slope is that of the last part of a curve: from its end back to the time that is this part of it.
const SLOPE_FROM: f64 = 1.0 / 8.0;
/// Least factor of time between the first and the last point of a slope; less says more about chance than about the slope.
const SLOPE_LEAST_SPAN: f64 = 2.0;
/// Most changes that a name tells.
const MOST_CHANGES: usize = 3;

/// The error of a render over time.
#[derive(Clone, Debug)]
pub struct Curve {
    /// What the render is called.
    pub name: String,
    /// What became of it, in a few words.
    pub result: String,
    /// What is known of its error, oldest first; all of it can be drawn.
    pub points: Vec<ErrorPoint>,
}

impl Curve {
    /// The curve of a render as far as it is.
    #[must_use]
    pub fn of(picture: &Picture) -> Self {
        let points = drawable(picture.errors());
        let result = points.last().map_or_else(
            || "no error known".to_owned(),
            |last| {
                let noise = percent(last.error.noise().value);
                let cancelled = match picture.outcome {
                    Outcome::Cancelled => ", cancelled",
                    _ => "",
                };
                // Not the time since it was asked for, which its place in the strip tells.
                let time = seconds_in_words(last.seconds);
                format!("{noise} after {time} of rendering{cancelled}")
            },
        );
        Self {
            name: picture.name.clone(),
            result,
            points,
        }
    }
}

/// The points that a logarithmic axis has a place for. A picture without noise has none.
fn drawable(points: &[ErrorPoint]) -> Vec<ErrorPoint> {
    let has_place = |number: f64| number > 0.0 && number.is_finite();
    points
        .iter()
        .filter(|point| has_place(point.seconds) && has_place(point.error.relmse.low))
        .filter(|point| has_place(point.error.relmse.high))
        .copied()
        .collect()
}

/// Slope of the logarithm of noise over that of time in the last part of a curve: -0.5 where samples are independent. `None` where
/// there is too little of it.
#[must_use]
pub fn slope(points: &[ErrorPoint]) -> Option<f64> {
    let last = points.last()?;
    let start = points.partition_point(|point| point.seconds < last.seconds * SLOPE_FROM);
    let points = &points[start..];
    if points.len() < 3 || last.seconds < points[0].seconds * SLOPE_LEAST_SPAN {
        return None;
    }
    let logarithms = || {
        points
            .iter()
            .map(|point| (point.seconds.ln(), point.error.noise().value.ln()))
    };
    let count = points.len() as f64;
    let (x_sum, y_sum) = logarithms().fold((0.0, 0.0), |(a, b), (x, y)| (a + x, b + y));
    let (x_mean, y_mean) = (x_sum / count, y_sum / count);
    let (products, squares) = logarithms().fold((0.0, 0.0), |(a, b), (x, y)| {
        (a + (x - x_mean) * (y - y_mean), b + (x - x_mean).powi(2))
    });
    Some(products / squares)
}

/// A level of noise that is still to be reached, and when it will be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The level.
    pub noise: f64,
    /// Seconds from the render's start.
    pub seconds: Interval,
}

/// The level that comes next: `target` where the render is to stop at one, else the next of [`NOISE_TARGETS`].
#[must_use]
pub fn next_crossing(points: &[ErrorPoint], target: Option<f64>) -> Option<Crossing> {
    let last = points.last()?;
    let (noise, seconds) = match target {
        Some(noise) => (noise, last.time_to_stop?),
        None => NOISE_TARGETS
            .into_iter()
            .zip(last.time_to)
            .find_map(|(noise, seconds)| Some((noise, seconds?)))?,
    };
    Some(Crossing { noise, seconds })
}

/// A time in seconds as people read it.
#[must_use]
pub fn seconds_in_words(seconds: f64) -> String {
    std::time::Duration::try_from_secs_f64(seconds).map_or_else(|_| "ages".to_owned(), duration)
}

/// What sets a render apart from the one before it, `before`, in a few words: what was changed, or the scene's name where that is
/// another scene.
#[must_use]
pub fn name_of_render(name: &str, scene: &Scene, before: Option<(&str, &Scene)>) -> String {
    let Some((_, before)) = before.filter(|(before, _)| *before == name) else {
        return format!("{name}, {}", scene.render.mode.name());
    };
    let mut changes = settings_changes(&before.render, &scene.render);
    let parts = [
        (before.camera == scene.camera, "camera"),
        (
            before.background == scene.background && same_image(before, scene),
            "background",
        ),
        (before.lights == scene.lights, "lights"),
        (before.materials == scene.materials, "materials"),
        (
            same_geometry(before, scene) && before.objects == scene.objects,
            "objects",
        ),
    ];
    let changed = parts.iter().filter(|(same, _)| !same);
    changes.extend(changed.map(|(_, part)| format!("other {part}")));
    if changes.is_empty() && before.render != scene.render {
        changes.push("other settings".to_owned());
    }
    match changes.len() {
        0 => "the same again".to_owned(),
        1..=MOST_CHANGES => changes.join(", "),
        _ => format!("{}, …", changes[..MOST_CHANGES].join(", ")),
    }
}

/// What differs between the settings that matter most for noise and time.
fn settings_changes(before: &RenderSettings, after: &RenderSettings) -> Vec<String> {
    let mut changes = Vec::new();
    let mut note = |differs: bool, words: String| {
        if differs {
            changes.push(words);
        }
    };
    let switch = |on: bool| if on { "on" } else { "off" };
    note(
        before.mode != after.mode,
        format!("mode {}", after.mode.name()),
    );
    note(
        (before.width, before.height) != (after.width, after.height),
        format!("{} × {}", after.width, after.height),
    );
    note(
        before.samples_per_pixel != after.samples_per_pixel,
        counted(after.samples_per_pixel as usize, "sample", "samples"),
    );
    note(
        before.stop.noise != after.stop.noise,
        after.stop.noise.map_or_else(
            || "no noise stop".to_owned(),
            |noise| format!("stop at {}", chosen_percent(noise)),
        ),
    );
    note(
        before.stop.seconds != after.stop.seconds,
        after.stop.seconds.map_or_else(
            || "no time stop".to_owned(),
            |seconds| format!("stop after {}", seconds_in_words(seconds)),
        ),
    );
    note(
        before.adaptive != after.adaptive,
        format!("adaptive {}", switch(after.adaptive)),
    );
    note(
        before.light_sampling != after.light_sampling,
        format!("light search {}", after.light_sampling.name()),
    );
    note(
        before.roulette != after.roulette,
        format!("roulette {}", switch(after.roulette)),
    );
    note(
        before.max_bounces != after.max_bounces,
        counted(after.max_bounces as usize, "bounce", "bounces"),
    );
    note(
        before.shadows != after.shadows,
        format!("shadows {}", after.shadows.name()),
    );
    note(
        before.shadow_samples != after.shadow_samples,
        counted(after.shadow_samples as usize, "shadow ray", "shadow rays"),
    );
    note(
        before.ambient_occlusion != after.ambient_occlusion,
        if after.ambient_occlusion.enabled {
            counted(
                after.ambient_occlusion.samples as usize,
                "occlusion ray",
                "occlusion rays",
            )
        } else {
            "no occlusion".to_owned()
        },
    );
    note(
        before.filter != after.filter,
        format!("filter {}", after.filter.name()),
    );
    note(before.seed != after.seed, format!("seed {}", after.seed));
    note(
        before.sampler != after.sampler,
        format!("sampler {}", after.sampler.name()),
    );
    note(
        before.accelerator != after.accelerator,
        format!("structure {}", after.accelerator.name()),
    );
    changes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::ErrorEstimate;

    fn point(seconds: f64, noise: f64) -> ErrorPoint {
        let exactly = |value: f64| Interval {
            value,
            low: value,
            high: value,
        };
        ErrorPoint {
            seconds,
            cpu_seconds: seconds,
            error: ErrorEstimate {
                samples_per_pixel: 4.0,
                rmse: exactly(noise),
                relmse: exactly(noise * noise),
                percentile_999: exactly(noise),
                unmeasured_pixels: 0,
            },
            time_to: [None, Some(exactly(7.0)), Some(exactly(70.0))],
            time_to_stop: Some(exactly(3.0)),
        }
    }

    #[test]
    fn the_slope_is_that_of_the_power_law_at_the_end() {
        let mut points = vec![point(0.001, 50.0), point(0.002, 0.1)];
        points.extend((1..=16_u8).map(|i| point(f64::from(i), 0.2 * f64::from(i).powf(-0.7))));
        assert!((slope(&points).unwrap() + 0.7).abs() < 1e-9);
        assert_eq!(slope(&points[..2]), None);
        assert_eq!(slope(&points[15..]), None, "too short a part");
    }

    #[test]
    fn pictures_without_noise_have_no_points() {
        let points = [point(1.0, 0.0), point(0.0, 0.1), point(1.0, 0.1)];
        assert_eq!(drawable(&points).len(), 1);
    }

    #[test]
    fn the_next_level_is_the_target_or_what_is_foreseen_first() {
        let points = [point(1.0, 0.05)];
        let next = next_crossing(&points, None).unwrap();
        assert_eq!((next.noise, next.seconds.value), (0.03, 7.0));
        let next = next_crossing(&points, Some(0.04)).unwrap();
        assert_eq!((next.noise, next.seconds.value), (0.04, 3.0));
        assert_eq!(next_crossing(&[], None), None);
    }

    #[test]
    fn renders_are_named_by_what_changed() {
        let first = Scene::default();
        assert_eq!(name_of_render("Room", &first, None), "Room, direct");
        let mut second = first.clone();
        let name = |scene: &Scene| name_of_render("Room", scene, Some(("Room", &first)));
        assert_eq!(name(&second), "the same again");
        second.render.stop.noise = Some(0.03);
        second.camera.eye.x += 1.0;
        assert_eq!(name(&second), "stop at 3 %, other camera");
        second.render.sampler = crate::scene::SamplerChoice::Independent;
        assert_eq!(
            name(&second),
            "stop at 3 %, sampler independent, other camera"
        );
        let other = name_of_render("Hall", &second, Some(("Room", &first)));
        assert_eq!(other, "Hall, direct");
    }
}
