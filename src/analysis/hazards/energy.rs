//! What depends on light: what ends of paths take away, bright specks, numbers that are none.

use super::pilot::{self, Pilot};
use super::{Figure, Hazard, HazardKind, Severity, Subject, fireflies};
use crate::analysis::report::percent;
use crate::control::CancelToken;
use crate::render::PreparedScene;
use crate::scene::{Mode, RenderSettings, Scene, SceneError};

/// The missing share of the light that is told.
const LEAST_LOSS: f64 = 1e-3;
/// The missing share that is warned of.
const NOTABLE_LOSS: f64 = 1e-2;

/// How many times as many bounces paths may have where it is looked for what is missing.
const MORE_BOUNCES: u32 = 4;
/// How many bounces they may have then at least.
const LEAST_BOUNCES: u32 = 64;

/// 97.5 % of the t distribution with 15 degrees of freedom: what an estimate from 16 seeds is off by in 1 of 20 cases, in standard
/// errors.
const T_QUANTILE: f64 = 2.131;
const _: () = assert!(pilot::FEW_SEEDS == 16, "15 degrees of freedom");

/// How many standard errors a loss must have to be told: by chance, 1 in 200 has.
const SIGNIFICANT: f64 = 3.0;

/// Renders pilots of `scene`, whose `pilot_scene` is prepared, and examines them. `None` when cancelled.
///
/// # Errors
/// What about the scene cannot be rendered.
pub fn examine(
    scene: &Scene,
    pilot_scene: &Scene,
    prepared: &PreparedScene,
    cancel: &CancelToken,
) -> Result<Option<Vec<Hazard>>, SceneError> {
    if !scene.render.mode.shows_light() {
        return Ok(Some(Vec::new()));
    }
    let bounces = pilot_scene.render.max_bounces;
    // Specks are rare, and in mode direct hardly any.
    let seeds = match scene.render.mode {
        Mode::Path => pilot::SEEDS,
        _ => pilot::FEW_SEEDS,
    };
    let Some(short) = pilot::take(pilot_scene, prepared, (bounces, seeds), cancel)? else {
        return Ok(None);
    };
    let mut hazards = Vec::new();
    hazards.extend(non_finite(&short));
    hazards.extend(fireflies::examine(scene, &short));
    // Where the scene's own paths are longer than the pilot's, what is missing in the pilot is not missing in the picture.
    if short.depth_limited > 0 && bounces == scene.render.max_bounces {
        let more = bounces
            .saturating_mul(MORE_BOUNCES)
            .clamp(LEAST_BOUNCES, RenderSettings::MAX_BOUNCES);
        let Some(long) = pilot::take(pilot_scene, prepared, (more, pilot::FEW_SEEDS), cancel)?
        else {
            return Ok(None);
        };
        hazards.extend(depth_loss(&short, bounces, &long, more));
    }
    Ok(Some(hazards))
}

fn non_finite(pilot: &Pilot) -> Option<Hazard> {
    (pilot.non_finite > 0).then(|| Hazard {
        kind: HazardKind::NonFinite,
        severity: Severity::Warning,
        subject: Subject::Picture {},
        count: pilot.non_finite,
        places: Vec::new(),
        figure: None,
        message: format!(
            "{} of {} samples of a pilot picture are infinite or not a number",
            pilot.non_finite,
            pilot.samples()
        ),
        advice: "Look for a light or material whose values are near the largest numbers there are, and make them smaller.".to_owned(),
    })
}

/// A share of the light, and its standard error.
struct Loss {
    share: f64,
    error: f64,
}

impl Loss {
    /// What the means `short` lack of `long`, those of pictures with the same seeds, as a share of the latter. `None` where these are
    /// black.
    fn of(short: &[f64], long: &[f64]) -> Option<Self> {
        let count = short.len() as f64;
        let total = long.iter().sum::<f64>();
        if total <= 0.0 {
            return None;
        }
        let share = 1.0 - short.iter().sum::<f64>() / total;
        // The error of a ratio, from how far each seed is off it.
        let off = |(short, long): (&f64, &f64)| (long - short - share * long).powi(2);
        let squares = short.iter().zip(long).map(off).sum::<f64>();
        let error = (squares / (count * (count - 1.0))).sqrt() / (total / count);
        Some(Self { share, error })
    }
}

fn depth_loss(short: &Pilot, bounces: u32, long: &Pilot, more: u32) -> Option<Hazard> {
    let Loss { share, error } = Loss::of(&short.means(), &long.means())?;
    if share < LEAST_LOSS || share < SIGNIFICANT * error {
        return None;
    }
    let ended = short.depth_limited as f64 / short.samples() as f64;
    let severity = if share < NOTABLE_LOSS {
        Severity::Note
    } else {
        Severity::Warning
    };
    Some(Hazard {
        kind: HazardKind::DepthLoss,
        severity,
        subject: Subject::Picture {},
        count: short.depth_limited,
        places: Vec::new(),
        figure: Some(Figure {
            value: share,
            of: "missing share of the mean luminance",
        }),
        message: format!(
            "render.max_bounces = {bounces} ends {} of the paths and takes away {} of the light ({} to {}) that there is with {more}",
            percent(ended),
            percent(share),
            percent((share - T_QUANTILE * error).max(0.0)),
            percent((share + T_QUANTILE * error).min(1.0))
        ),
        advice: format!(
            "Raise render.max_bounces, to {more} at most, if the picture is to have this light."
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::Random;

    /// Pairs that share most of their noise: the error is that of what they do not share, and covers the truth.
    #[test]
    fn losses_of_pairs_are_right_within_their_error() {
        let mut random = Random::new(3);
        let mut covered = 0;
        for _ in 0..1000 {
            let pairs: Vec<(f64, f64)> = (0..16)
                .map(|_| {
                    let long = 1.0 + random.unit();
                    (long * (0.9 + 0.02 * (random.unit() - 0.5)), long)
                })
                .collect();
            let (short, long): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
            let loss = Loss::of(&short, &long).expect("is not black");
            assert!(loss.error < 0.004);
            covered += usize::from((loss.share - 0.1).abs() <= T_QUANTILE * loss.error);
        }
        // 950 ± 4 σ.
        assert!((922..=978).contains(&covered), "{covered}");
        assert!(Loss::of(&[0.0; 16], &[0.0; 16]).is_none());
    }
}
