//! What depends on light: what ends of paths take away, bright specks, numbers that are none.

use super::dark::why_black;
use super::overlaps::Look;
use super::pilot::{self, Pilot};
use super::{Hazard, HazardKind, Severity, Subject, depth, fireflies, view};
use crate::control::CancelToken;
use crate::render::PreparedScene;
use crate::scene::{Mode, Scene, SceneError};

/// Renders pilots of `scene`, whose `pilot_scene` is prepared, and examines them; `looks` are at what its rays from the eye meet. `None` when
/// cancelled.
///
/// # Errors
/// What about the scene cannot be rendered.
pub fn examine(
    scene: &Scene,
    (pilot_scene, looks): (&Scene, &[Look]),
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
    // Where it is certain, it has been told.
    if why_black(scene)?.is_none() {
        hazards.extend(view::darkness(scene, looks, &short));
    }
    hazards.extend(fireflies::examine(scene, &short));
    // Where the scene's own paths are longer than the pilot's, what is missing in the pilot is not missing in the picture.
    if short.depth_limited > 0 && bounces == scene.render.max_bounces {
        let Some(found) = depth::examine(pilot_scene, prepared, &short, cancel)? else {
            return Ok(None);
        };
        hazards.extend(found);
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
