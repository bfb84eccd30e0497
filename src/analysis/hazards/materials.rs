//! Materials that reflect more light than arrives.

use super::{Figure, Hazard, HazardKind, Severity, Subject};
use crate::math::percent;
use crate::scene::Scene;

/// Examines all materials.
pub fn examine(scene: &Scene) -> Vec<Hazard> {
    let hazard = |(name, reflected): (&str, f64)| {
        let has_it = |object: &&crate::scene::Object| object.material.as_deref() == Some(name);
        let objects = scene.objects.iter().filter(has_it);
        Hazard {
            kind: HazardKind::EnergyCreating,
            severity: Severity::Warning,
            subject: Subject::Material {
                material: name.to_owned(),
                objects: objects.map(|object| object.name.clone()).collect(),
            },
            count: 1,
            places: Vec::new(),
            figure: Some(Figure {
                value: reflected,
                of: "largest share of the light that is reflected",
            }),
            message: format!(
                "reflects up to {} of the light that arrives, so that light grows from bounce to bounce",
                percent(reflected)
            ),
            advice: "Keep diffuse + specular, or reflectance, at 1 or less in every channel."
                .to_owned(),
        }
    };
    scene.energy_creators().map(hazard).collect()
}
