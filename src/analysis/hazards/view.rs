//! What the eye sees at all: a camera that looks past everything, and one in the dark inside of a body.

use super::overlaps::Look;
use super::pilot::Pilot;
use super::{Hazard, HazardKind, Severity, Subject};
use crate::scene::{Scene, SceneError};

/// Looks for a camera that sees no object of `scene`, of which there is something: `looks` are at what so many `rays` from the eye met.
///
/// # Errors
/// Objects that cannot be measured.
pub fn past_everything(
    scene: &Scene,
    looks: &[Look],
    rays: u64,
) -> Result<Option<Hazard>, SceneError> {
    let bounds = scene.measured_bounds()?;
    if !looks.is_empty() || bounds.is_empty() {
        return Ok(None);
    }
    let middle = bounds
        .center()
        .to_array()
        .map(|place| format!("{place:.3}"));
    Ok(Some(Hazard {
        kind: HazardKind::NothingSeen,
        severity: Severity::Warning,
        subject: Subject::Picture {},
        count: rays,
        places: Vec::new(),
        figure: None,
        message: format!("no object is in the picture: none of {rays} rays from the eye meets one"),
        advice: format!(
            "Aim the camera at the objects, whose middle is at ({}), or bring them before it.",
            middle.join(", ")
        ),
    }))
}

/// Tells that no sample of `pilot`, in which light may arrive, meets any; and why, where `looks`, at what its rays from the eye met, say so.
pub fn darkness(scene: &Scene, looks: &[Look], pilot: &Pilot) -> Option<Hazard> {
    // What nobody sees, or paths that are too short, are told of by themselves.
    if looks.is_empty() || pilot.lit() > 0 || pilot.non_finite > 0 || pilot.depth_limited > 0 {
        return None;
    }
    let (why, advice) = match body_around(looks) {
        Some(object) => (
            format!(
                ": the camera is inside of the object {:?}",
                scene.objects[object].name
            ),
            "Move the camera out of it.",
        ),
        None => (
            String::new(),
            "Look whether the lights, or the camera, are shut in by objects.",
        ),
    };
    Some(Hazard {
        kind: HazardKind::BlackPicture,
        severity: Severity::Warning,
        subject: Subject::Picture {},
        count: pilot.samples(),
        places: Vec::new(),
        figure: None,
        message: format!(
            "the picture is black, as far as {} samples of a pilot picture tell{why}",
            pilot.samples()
        ),
        advice: advice.to_owned(),
    })
}

/// The object whose backs alone are seen.
fn body_around(looks: &[Look]) -> Option<usize> {
    let object = looks.first()?.object;
    let is_back = |look: &Look| look.object == object && look.normal.dot(look.direction) > 0.0;
    looks.iter().all(is_back).then_some(object)
}
