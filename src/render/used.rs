//! What of a description its render uses.

use std::collections::BTreeSet;

use serde::Serialize;

use super::geometry::is_nothing;
use crate::math::counted;
use crate::scene::{AcceleratorChoice, Choice, Material, RenderSettings, Rgb, Scene};

/// What of a scene its render uses; the rest costs nothing.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Used {
    /// Lights that shine, of how many.
    pub lights: [usize; 2],
    /// Materials of objects with triangles, of how many there are; objects that name none have one of their own, which is not counted.
    pub materials: [usize; 2],
    /// The ways in which those send light on, as far as the settings let them.
    pub lobes: BTreeSet<&'static str>,
    /// What rays look for triangles in.
    pub structure: &'static str,
    /// How many there are, copies counted.
    pub triangles: u64,
}

impl Used {
    /// What a render of `scene` uses. Materials that are not defined count as none.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let settings = &scene.render;
        let shining = scene.lights.iter().filter(|light| light.shines());
        let solid = scene
            .objects
            .iter()
            .filter(|object| scene.has_triangles(object));
        let solid = solid.filter_map(|object| Some((object, scene.material_of(object).ok()?)));
        let solid: Vec<_> = solid
            .filter(|(_, material)| !is_nothing(material, settings))
            .collect();
        let worn: BTreeSet<_> = solid
            .iter()
            .filter_map(|(object, _)| object.material.as_ref())
            .collect();
        let triangles = solid.iter().map(|(object, _)| scene.triangles_of(object));
        Self {
            lights: [shining.count(), scene.lights.len()],
            materials: [worn.len(), scene.materials.len()],
            lobes: solid
                .iter()
                .flat_map(|(_, material)| lobes_of(material, settings))
                .collect(),
            structure: match settings.accelerator {
                AcceleratorChoice::Auto => AcceleratorChoice::Wide.name(),
                named => named.name(),
            },
            triangles: triangles.fold(0, u64::saturating_add),
        }
    }

    /// In words: of lights, of materials, of the structure.
    #[must_use]
    pub fn facts(&self) -> [String; 3] {
        let [shining, lights] = self.lights;
        let [worn, materials] = self.materials;
        let lobes: Vec<_> = self.lobes.iter().copied().collect();
        let lobes = match lobes.join(", ") {
            none if none.is_empty() => "none".to_owned(),
            lobes => lobes,
        };
        let (structure, triangles) = (self.structure, self.triangles);
        [
            format!("lights: {shining} of {lights} shine"),
            format!("materials: {worn} of {materials} are worn, lobes: {lobes}"),
            format!(
                "structure: {structure}, over {}",
                counted(triangles, "triangle", "triangles")
            ),
        ]
    }
}

/// How a material sends light on, or makes it.
fn lobes_of(material: &Material, settings: &RenderSettings) -> Vec<&'static str> {
    match material {
        Material::Phong {
            diffuse, specular, ..
        } => {
            let lobes = [(diffuse, "diffuse"), (specular, "specular")];
            let used = lobes.into_iter().filter(|(share, _)| **share != Rgb::ZERO);
            used.map(|(_, name)| name).collect()
        }
        // What stands in where they are switched off is matt.
        Material::Mirror { .. } if !settings.mirror => vec!["diffuse"],
        Material::Glass { .. } if !settings.glass => vec!["diffuse"],
        Material::Mirror { .. } => vec!["mirror"],
        Material::Glass { .. } => vec!["glass"],
        Material::Emitter { .. } => vec!["emission"],
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::control::CancelToken;
    use crate::geometry::shapes::icosphere;
    use crate::render::PreparedScene;
    use crate::scene::{Copies, Light, Object, Textures};

    fn used(scene: &Scene) -> (Vec<&'static str>, [usize; 2]) {
        let used = Used::of(scene);
        (used.lobes.into_iter().collect(), used.materials)
    }

    #[test]
    fn what_is_there_but_not_used_does_not_count() {
        let mut scene = Scene::default();
        scene.meshes.insert("ball".into(), Arc::new(icosphere(1)));
        let glossy = Material::Phong {
            diffuse: Rgb::ZERO,
            specular: Rgb::splat(0.5),
            shininess: 9.0,
            textures: Textures::default(),
        };
        let nothing = Material::Glass {
            ior: 1.0,
            attenuation: Rgb::ZERO,
        };
        scene.materials = [
            ("glossy", glossy),
            ("chrome", Material::mirror()),
            ("nothing", nothing),
            ("unworn", Material::emitter()),
        ]
        .map(|(name, material)| (name.to_owned(), material))
        .into();
        let ball = |material: &str| Object {
            mesh: "ball".into(),
            material: Some(material.into()),
            ..Object::default()
        };
        scene.objects = vec![ball("glossy"), ball("chrome"), ball("nothing")];
        scene.objects[0].copies = Copies {
            count: [3, 1, 1],
            ..Copies::default()
        };
        scene.lights = vec![
            Light::Point {
                position: Rgb::ONE,
                intensity: Rgb::ZERO,
            },
            Light::Point {
                position: Rgb::ONE,
                intensity: Rgb::ONE,
            },
        ];
        assert_eq!(used(&scene), (vec!["mirror", "specular"], [2, 4]));
        assert_eq!(Used::of(&scene).lights, [1, 2]);
        scene.render.mirror = false;
        assert_eq!(used(&scene).0, ["diffuse", "specular"]);
        scene.objects.clear();
        assert_eq!(used(&scene), (vec![], [0, 4]));
    }

    #[test]
    fn the_structure_is_the_one_that_is_prepared() {
        let mut scene = Scene::default();
        scene.meshes.insert("ball".into(), Arc::new(icosphere(1)));
        scene.objects = vec![Object {
            mesh: "ball".into(),
            copies: Copies {
                count: [2, 3, 1],
                step: Rgb::splat(3.0),
            },
            ..Object::default()
        }];
        for (choice, _) in AcceleratorChoice::ALL {
            scene.render.accelerator = *choice;
            let prepared = PreparedScene::prepare(&scene, None, &CancelToken::new());
            let prepared = prepared.expect("a scene").expect("nobody cancels");
            let accelerator = prepared.geometry().accelerator();
            let used = Used::of(&scene);
            assert_eq!(used.structure, accelerator.name());
            assert_eq!(used.triangles, u64::from(accelerator.triangle_count()));
        }
    }
}
