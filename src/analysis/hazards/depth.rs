//! Light that is missing because paths end at `render.max_bounces`: how much it is, and how many bounces bring it.
//!
//! A pilot with more bounces tells. Where its paths end there as well, one with more again is taken, smaller as its paths are longer, until
//! what is still missing does not matter.

use super::dark::why_black;
use super::pilot::{self, Pilot};
use super::{Figure, Hazard, HazardKind, Severity, Subject};
use crate::control::CancelToken;
use crate::math::percent;
use crate::render::PreparedScene;
use crate::scene::{RenderSettings, Scene, SceneError};

/// The missing share of the light that is told: less is a fraction of the steps of a picture of 8 bits.
const LEAST_LOSS: f64 = 1e-3;
/// The missing share that is warned of, and that matters where it is missing still: it is some two steps of 8 bits, which who compares two
/// pictures sees.
const NOTABLE_LOSS: f64 = 1e-2;

/// How many times as many bounces paths may have where it is looked for what is missing.
const MORE_BOUNCES: u32 = 4;
/// How many bounces they may have then at least.
const LEAST_BOUNCES: u32 = 64;

/// The share of paths that still end which does not matter: did they bring as much light as the others, it would be a tenth of what does.
const FEW_ENDED: f64 = 1e-3;

/// So many samples must meet light for their mean to tell how much there is.
const LEAST_LIT: u64 = 100;

/// 97.5 % of the t distribution with 15 degrees of freedom: what an estimate from 16 seeds is off by in 1 of 20 cases, in standard
/// errors.
const T_QUANTILE: f64 = 2.131;
const _: () = assert!(pilot::FEW_SEEDS == 16, "15 degrees of freedom");

/// How many standard errors a loss must have to be told: by chance, 1 in 200 has.
const SIGNIFICANT: f64 = 3.0;

/// Looks for what `short`, the pilot of `pilot_scene`, lacks; `prepared` is that scene. `None` when cancelled.
///
/// # Errors
/// What about the scene cannot be rendered.
pub fn examine(
    pilot_scene: &Scene,
    prepared: &PreparedScene,
    short: &Pilot,
    cancel: &CancelToken,
) -> Result<Option<Vec<Hazard>>, SceneError> {
    let bounces = pilot_scene.render.max_bounces;
    let first = more_than(bounces);
    let take = |scene: &Scene, bounces: u32| {
        pilot::take(scene, prepared, (bounces, pilot::FEW_SEEDS), cancel)
    };
    let Some(long) = take(pilot_scene, first)? else {
        return Ok(None);
    };
    let Some(loss) = Loss::between(short, &long) else {
        let is_black = why_black(pilot_scene)?.is_some();
        let matters = !is_black && short.ended() >= NOTABLE_LOSS;
        let hazard = matters.then(|| unknown_loss(short, bounces, &long, first));
        return Ok(Some(hazard.into_iter().collect()));
    };
    if loss.share < LEAST_LOSS || !loss.is_significant() {
        return Ok(Some(Vec::new()));
    }
    let mut missing = Missing {
        loss,
        with: first,
        ended: long.ended(),
        is_all: true,
    };
    while missing.ended > FEW_ENDED {
        let more = more_than(missing.with);
        missing.is_all = false;
        if more > pilot::MOST_BOUNCES {
            break;
        }
        // Half as wide as the first ones would do: these only say where to stop.
        let factor = 0.5 * (f64::from(first) / f64::from(more)).sqrt();
        let scene = pilot::resized(pilot_scene.clone(), factor);
        let (Some(fewer), Some(longer)) = (take(&scene, missing.with)?, take(&scene, more)?) else {
            return Ok(None);
        };
        let Some(loss) = Loss::between(&fewer, &longer) else {
            break;
        };
        if loss.share + T_QUANTILE * loss.error < NOTABLE_LOSS {
            missing.is_all = true;
            break;
        }
        if !loss.is_significant() {
            break;
        }
        missing = Missing {
            loss: missing.loss.and(&loss),
            with: more,
            ended: longer.ended(),
            is_all: true,
        };
    }
    Ok(Some(vec![missing.hazard(short, bounces)]))
}

/// How many bounces are tried after so many.
fn more_than(bounces: u32) -> u32 {
    bounces
        .saturating_mul(MORE_BOUNCES)
        .clamp(LEAST_BOUNCES, RenderSettings::MAX_BOUNCES)
}

/// A share of the light, and its standard error.
struct Loss {
    share: f64,
    error: f64,
}

impl Loss {
    /// What `short` lacks of `long`, pictures of one size with the same seeds. `None` where too few samples meet light to tell.
    fn between(short: &Pilot, long: &Pilot) -> Option<Self> {
        let (few, many) = (short.lit(), long.lit());
        if many < LEAST_LIT {
            return None;
        }
        let loss = Self::of(&short.means(), &long.means())?;
        // Seeds that meet no light are all alike, which says nothing of how rare it is; what is counted is off by its root.
        let of_count = if few < LEAST_LIT {
            (few as f64 + 1.0).sqrt() / many as f64
        } else {
            0.0
        };
        Some(Self {
            error: loss.error.max(of_count),
            ..loss
        })
    }

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

    fn is_significant(&self) -> bool {
        self.share >= SIGNIFICANT * self.error
    }

    /// The loss of what is left after this one and then the `next`.
    fn and(&self, next: &Self) -> Self {
        let (kept, kept_next) = (1.0 - self.share, 1.0 - next.share);
        Self {
            share: 1.0 - kept * kept_next,
            error: (kept_next * self.error).hypot(kept * next.error),
        }
    }
}

/// The light that paths lose at `render.max_bounces`.
struct Missing {
    loss: Loss,
    /// The bounces that bring it.
    with: u32,
    /// The share of paths that end at these.
    ended: f64,
    /// Whether more than these would bring nothing that matters.
    is_all: bool,
}

impl Missing {
    /// The hazard to a scene whose paths have `bounces`.
    fn hazard(&self, short: &Pilot, bounces: u32) -> Hazard {
        let Loss { share, error } = self.loss;
        let (lowest, highest) = (share - T_QUANTILE * error, share + T_QUANTILE * error);
        let lowest = lowest.max(0.0);
        let ended = percent(short.ended());
        let with = self.with;
        let (message, advice) = if self.is_all {
            (
                format!(
                    "render.max_bounces = {bounces} ends {ended} of the paths and takes away {} of the light ({} to {}) that there is with \
                     {with}",
                    percent(share),
                    percent(lowest),
                    percent(highest.min(1.0))
                ),
                format!(
                    "Raise render.max_bounces, to {with} at most, if the picture is to have this light."
                ),
            )
        } else {
            (
                format!(
                    "render.max_bounces = {bounces} ends {ended} of the paths and takes away at least {} of the light: with {with}, {} of \
                     the paths end still, which may take away more",
                    percent(lowest),
                    percent(self.ended)
                ),
                format!(
                    "Raise render.max_bounces, to {with} or more, if the picture is to have this light; surfaces that reflect less need \
                     fewer."
                ),
            )
        };
        Hazard {
            figure: Some(Figure {
                value: if self.is_all { share } else { lowest },
                of: "missing share of the mean luminance",
            }),
            severity: if share < NOTABLE_LOSS {
                Severity::Note
            } else {
                Severity::Warning
            },
            message,
            advice,
            ..hazard(short)
        }
    }
}

/// That it cannot be told how much is missing.
fn unknown_loss(short: &Pilot, bounces: u32, long: &Pilot, more: u32) -> Hazard {
    Hazard {
        message: format!(
            "render.max_bounces = {bounces} ends {} of the paths; how much light that takes away cannot be told, as with {more} only {} of \
             {} paths of a pilot picture meet any",
            percent(short.ended()),
            long.lit(),
            long.samples()
        ),
        advice: "Compare pictures with more bounces. Make small lights larger, or let them be aimed at by render.light_sampling = \
                 \"mis\", so that more paths meet light."
            .to_owned(),
        ..hazard(short)
    }
}

fn hazard(short: &Pilot) -> Hazard {
    Hazard {
        kind: HazardKind::DepthLoss,
        severity: Severity::Warning,
        subject: Subject::Picture {},
        count: short.depth_limited,
        places: Vec::new(),
        figure: None,
        message: String::new(),
        advice: String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::Random;

    /// A picture in which so many samples of each seed have a luminance of 1.
    fn pilot(lit: usize) -> Pilot {
        let row: Vec<f64> = (0..100)
            .map(|pixel| if pixel < lit { 1.0 } else { 0.0 })
            .collect();
        Pilot {
            width: 100,
            height: 1,
            luminances: vec![row; pilot::FEW_SEEDS as usize],
            non_finite: 0,
            depth_limited: 0,
        }
    }

    #[test]
    fn what_too_few_samples_tell_is_not_certain() {
        // 16 seeds of 6 samples are too few.
        assert!(Loss::between(&pilot(0), &pilot(6)).is_none());
        let loss = Loss::between(&pilot(0), &pilot(10)).expect("is lit");
        assert!(loss.share == 1.0 && (loss.error - 1.0 / 160.0).abs() < 1e-12);
        let loss = Loss::between(&pilot(50), &pilot(100)).expect("is lit");
        assert!((loss.share - 0.5).abs() < 1e-12 && loss.error < 1e-12);
    }

    #[test]
    fn losses_in_a_row_multiply_what_is_left() {
        let [a, b] = [(0.5, 0.02), (0.8, 0.01)].map(|(share, error)| Loss { share, error });
        let both = a.and(&b);
        assert!((both.share - 0.9).abs() < 1e-12);
        assert!((both.error - 0.004_f64.hypot(0.005)).abs() < 1e-12);
    }

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
