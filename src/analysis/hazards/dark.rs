//! Light that cannot arrive: pictures that are black, and lights that no path through glass or by mirrors meets.

use super::{Hazard, HazardKind, Severity, Subject};
use crate::math::DVec3;
use crate::render::{Feature, is_nothing, reasons};
use crate::scene::{Light, Material, Mode, Scene, SceneError};

/// Why every pixel of `scene` is black, in a clause; `None` where light may arrive.
///
/// # Errors
/// When an object has a material that there is not, or the background an image that was not loaded.
pub fn why_black(scene: &Scene) -> Result<Option<String>, SceneError> {
    if !scene.render.mode.shows_light() {
        return Ok(None);
    }
    let reasons = reasons(scene)?;
    let against = |wanted| {
        let of_it = reasons.iter().find(|(feature, _)| *feature == wanted);
        of_it.and_then(|(_, reason)| *reason)
    };
    if against(Feature::Light).is_some() {
        let nothing = "no light and no object shines, and the background is black";
        return Ok(Some(nothing.to_owned()));
    }
    // What is not aimed at brings light only where rays meet it.
    Ok(match against(Feature::Aiming) {
        Some(reason) if !shows_a_source(scene)? => {
            Some(format!("{reason}, and rays meet nothing that shines"))
        }
        _ => None,
    })
}

/// Whether there is anything that shines and that rays may meet.
fn shows_a_source(scene: &Scene) -> Result<bool, SceneError> {
    let image = scene.background_image()?;
    let is_background_black =
        scene.background.is_black() || image.is_some_and(|image| image.is_black());
    let mut lights = scene.lights.iter();
    let shines = |material: &Material| matches!(material, Material::Emitter { radiance } if *radiance != DVec3::ZERO);
    Ok(!is_background_black
        || lights.any(|light| light.shines() && light.is_visible())
        || materials(scene)?.iter().any(shines))
}

/// The materials of what is there.
fn materials(scene: &Scene) -> Result<Vec<Material>, SceneError> {
    let objects = scene.objects.iter();
    let solid = objects.filter(|object| scene.has_triangles(object));
    let materials = solid.map(|object| scene.material_of(object));
    let mut materials: Vec<_> = materials.collect::<Result<_, _>>()?;
    materials.retain(|material| !is_nothing(material, &scene.render));
    Ok(materials)
}

/// Examines where light may come from.
///
/// # Errors
/// Those of [`why_black`].
pub fn examine(scene: &Scene) -> Result<Vec<Hazard>, SceneError> {
    let black = why_black(scene)?.map(|reason| Hazard {
        kind: HazardKind::BlackPicture,
        severity: Severity::Warning,
        subject: Subject::Picture {},
        count: 1,
        places: Vec::new(),
        figure: None,
        message: format!("the picture is black: {reason}"),
        advice: "Add a light, an object of kind emitter, or a background.".to_owned(),
    });
    let unmet = unmet_lights(scene)?;
    Ok(black.into_iter().chain(unmet).collect())
}

/// Lights that paths through glass and by mirrors would have to meet, and cannot.
fn unmet_lights(scene: &Scene) -> Result<Option<Hazard>, SceneError> {
    let settings = &scene.render;
    if settings.mode != Mode::Path {
        return Ok(None);
    }
    let materials = materials(scene)?;
    let is_glass = |material: &Material| matches!(material, Material::Glass { .. });
    let is_mirror = |material: &Material| matches!(material, Material::Mirror { .. });
    let has_glass = settings.glass && materials.iter().any(is_glass);
    let has_mirror = settings.mirror && materials.iter().any(is_mirror);
    let lights = scene.lights.iter().enumerate();
    let unmet = lights.filter(|(_, light)| light.shines() && !light.is_visible());
    let unmet: Vec<(usize, &Light)> = unmet.collect();
    if unmet.is_empty() || !(has_glass || has_mirror) {
        return Ok(None);
    }
    let numbers: Vec<_> = unmet
        .iter()
        .take(MOST_NUMBERS)
        .map(|(number, _)| number.to_string())
        .collect();
    let more = match unmet.len() - numbers.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let (lights, are, them) = match unmet.len() {
        1 => ("light", "is a point or invisible", "it"),
        _ => ("lights", "are points or invisible", "them"),
    };
    let way = match (has_glass, has_mirror) {
        (true, true) => "through glass or by mirrors",
        (true, false) => "through glass",
        _ => "by mirrors",
    };
    let numbers = numbers.join(", ");
    Ok(Some(Hazard {
        kind: HazardKind::UnmetLights,
        // Behind glass it is dark then; light by mirrors is often not missed.
        severity: if has_glass { Severity::Warning } else { Severity::Note },
        subject: Subject::Picture {},
        count: unmet.len() as u64,
        places: Vec::new(),
        figure: None,
        message: format!(
            "{lights} {numbers}{more} {are}: in mode path no path meets {them}, so that nothing is lit by {them} {way}"
        ),
        advice: if has_glass {
            "Use disks with visible = true or emitters, or mode direct, where light goes straight through glass."
        } else {
            "Use disks with visible = true or emitters where mirrors are to light something."
        }
        .to_owned(),
    }))
}

/// The most lights that are named.
const MOST_NUMBERS: usize = 3;
