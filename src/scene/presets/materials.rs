//! Materials to begin with.
//!
//! Reflectances of metals are those at normal incidence, linear RGB, as tabulated in Akenine-Möller et al., Real-Time Rendering (4th
//! ed.), table 9.2; indices of refraction are the usual ones for yellow light.

use crate::scene::{Material, Rgb, Textures};

/// A material to begin with.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialPreset {
    /// What people call it.
    pub name: &'static str,
    /// What it is good for.
    pub description: &'static str,
    /// The material.
    pub material: Material,
}

/// All of them, matt ones first.
#[must_use]
pub fn all() -> Vec<MaterialPreset> {
    let preset = |name, description, material| MaterialPreset {
        name,
        description,
        material,
    };
    let aluminium = Rgb::new(0.913, 0.922, 0.924);
    let gold = Rgb::new(1.0, 0.782, 0.344);
    let copper = Rgb::new(0.955, 0.638, 0.538);
    let chromium = Rgb::new(0.549, 0.556, 0.554);
    let silver = Rgb::new(0.972, 0.960, 0.915);
    vec![
        preset(
            "Plaster",
            "White and matt",
            phong([0.85, 0.85, 0.83], Rgb::ZERO, 1.0),
        ),
        preset(
            "Clay",
            "Fired, with a faint shine",
            phong([0.72, 0.42, 0.28], Rgb::splat(0.04), 12.0),
        ),
        preset(
            "Red plastic",
            "Coloured, with a white highlight",
            phong([0.62, 0.03, 0.025], Rgb::splat(0.05), 220.0),
        ),
        preset(
            "Porcelain",
            "White, with a sharp highlight",
            phong([0.82, 0.83, 0.84], Rgb::splat(0.06), 2000.0),
        ),
        preset(
            "Rubber",
            "Nearly black, with a wide and faint shine",
            phong([0.025; 3], Rgb::splat(0.04), 14.0),
        ),
        preset(
            "Brushed aluminium",
            "A metal that mirrors its surroundings blurred, in mode path",
            phong([0.0; 3], aluminium, 60.0),
        ),
        preset(
            "Brushed gold",
            "A metal that mirrors its surroundings blurred, in mode path",
            phong([0.0; 3], gold, 60.0),
        ),
        preset(
            "Chrome",
            "A polished metal, dark for a mirror",
            mirror(chromium),
        ),
        preset("Silver", "The brightest mirror", mirror(silver)),
        preset("Gold", "A yellow mirror", mirror(gold)),
        preset("Copper", "A red mirror", mirror(copper)),
        preset(
            "Glass",
            "Clear window glass, index 1.52",
            glass(1.52, [0.0; 3]),
        ),
        preset(
            "Bottle glass",
            "Green where it is thick: set its absorption to fit the object's size",
            glass(1.52, [0.9, 0.22, 0.6]),
        ),
        preset("Water", "Clear, index 1.333", glass(1.333, [0.0; 3])),
        preset("Diamond", "Clear, index 2.418", glass(2.418, [0.0; 3])),
        preset(
            "Warm lamp",
            "Shines by itself; in mode path it lights what is around it",
            Material::Emitter {
                radiance: Rgb::new(8.0, 5.6, 3.1),
            },
        ),
    ]
}

fn phong(diffuse: [f64; 3], specular: Rgb, shininess: f64) -> Material {
    Material::Phong {
        diffuse: Rgb::from_array(diffuse),
        specular,
        shininess,
        textures: Textures::default(),
    }
}

fn mirror(reflectance: Rgb) -> Material {
    Material::Mirror { reflectance }
}

fn glass(ior: f64, attenuation: [f64; 3]) -> Material {
    Material::Glass {
        ior,
        attenuation: Rgb::from_array(attenuation),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    /// None makes light, and all are as scene files may have them.
    #[test]
    fn presets_are_sound_and_told_apart() {
        let presets = all();
        for (index, preset) in presets.iter().enumerate() {
            let mut reflected = Rgb::ZERO;
            match preset.material {
                Material::Phong {
                    diffuse, specular, ..
                } => reflected = diffuse + specular,
                Material::Mirror { reflectance } => reflected = reflectance,
                Material::Glass { .. } | Material::Emitter { .. } => {}
            }
            assert!(reflected.max_element() <= 1.0, "{}", preset.name);
            let mut scene = Scene::default();
            let name = preset.name.to_owned();
            scene
                .materials
                .insert(name, Material::clone(&preset.material));
            assert_eq!(scene.validate(), Ok(()));
            for other in &presets[..index] {
                assert_ne!(preset.name, other.name);
                assert_ne!(preset.material, other.material);
            }
        }
    }
}
