//! The parts of a picture: where its light comes from, and by how much shadow and occlusion darken it. [`gathered`] sorts the light of
//! a sample into them.

mod gathered;

use serde::{Deserialize, Serialize};

use crate::scene::{Material, Mode, Rgb, Scene, Shadows};
pub use gathered::{AllParts, Beginning, ByLobe, Gathered, NoParts, Parts};

/// A part of the picture, or a factor beside the parts.
///
/// Parts add up to the picture. Which of them light belongs to is decided by what the camera ray met first: an emitter, the background or a
/// light, a surface that scatters, or a mirror or glass, which take everything that is seen in them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Layer {
    /// Lights, emitters and background seen directly.
    Emission,
    /// Light straight from lights and emitters, reflected diffusely.
    DirectDiffuse,
    /// Light straight from lights and emitters, reflected in the lobe.
    DirectSpecular,
    /// The background's light on surfaces.
    Ambient,
    /// Everything seen in mirrors and on the outside of glass.
    Reflection,
    /// Everything seen through glass.
    Refraction,
    /// Light that met several surfaces, the first of them neither mirror nor glass.
    Indirect,
    /// Factor: share of the shadow rays from the first scattering surface that come through, white where there are none.
    Shadow,
    /// Factor: share of its hemisphere that is not occluded, white where occlusion is not looked for, as on what reflects nothing
    /// diffusely.
    Occlusion,
    /// How far the picture is from the truth, as far as can be told: no sum of samples, unlike the others.
    Error,
}

impl Layer {
    /// All layers, the parts first.
    pub const ALL: [Self; 10] = [
        Self::Emission,
        Self::DirectDiffuse,
        Self::DirectSpecular,
        Self::Ambient,
        Self::Reflection,
        Self::Refraction,
        Self::Indirect,
        Self::Shadow,
        Self::Occlusion,
        Self::Error,
    ];

    /// The name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Emission => "emission",
            Self::DirectDiffuse => "direct_diffuse",
            Self::DirectSpecular => "direct_specular",
            Self::Ambient => "ambient",
            Self::Reflection => "reflection",
            Self::Refraction => "refraction",
            Self::Indirect => "indirect",
            Self::Shadow => "shadow",
            Self::Occlusion => "occlusion",
            Self::Error => "error",
        }
    }

    /// The layers that the picture of `scene` can have; none for false colours.
    #[must_use]
    pub fn all_of(scene: &Scene) -> Vec<Self> {
        let settings = &scene.render;
        let is_path = settings.mode == Mode::Path;
        if !is_path && settings.mode != Mode::Direct {
            return Vec::new();
        }
        let materials = scene.objects.iter().map(|object| scene.material_of(object));
        let materials: Vec<Material> = materials.filter_map(Result::ok).collect();
        let has = |holds: &dyn Fn(&Material) -> bool| materials.iter().any(holds);

        let mirror = settings.mirror && has(&|m| matches!(m, Material::Mirror { .. }));
        let glass = settings.glass && has(&|m| matches!(m, Material::Glass { .. }));
        let scatters = has(&|m| match m {
            Material::Phong { .. } => true,
            Material::Mirror { .. } => !settings.mirror,
            Material::Glass { .. } => !settings.glass,
            Material::Emitter { .. } => false,
        });
        let has_lobe =
            has(&|m| matches!(m, Material::Phong { specular, .. } if *specular != Rgb::ZERO));
        let emits = has(&|m| matches!(m, Material::Emitter { .. }));
        let is_lit = scatters && (emits || !scene.lights.is_empty());
        let has_ambient = scatters && !scene.background.is_black();
        let has_diffuse = has(&|m| match m {
            Material::Phong { diffuse, .. } => *diffuse != Rgb::ZERO,
            Material::Mirror { .. } => !settings.mirror,
            Material::Glass { .. } => !settings.glass,
            Material::Emitter { .. } => false,
        });
        let is_there = |layer: &Self| match layer {
            Self::Emission => true,
            Self::DirectDiffuse => is_lit,
            Self::DirectSpecular => is_lit && has_lobe,
            Self::Ambient => has_ambient,
            Self::Reflection => mirror || glass,
            Self::Refraction => glass,
            Self::Indirect => is_path && scatters && settings.max_bounces > 1,
            Self::Shadow => is_lit && (is_path || settings.shadows != Shadows::Off),
            Self::Occlusion => {
                has_ambient && has_diffuse && !is_path && settings.ambient_occlusion.enabled
            }
            Self::Error => false,
        };
        Self::ALL.into_iter().filter(is_there).collect()
    }

    /// Whether it is a part of the sum and not a factor.
    #[must_use]
    pub fn is_part(self) -> bool {
        !matches!(self, Self::Shadow | Self::Occlusion | Self::Error)
    }
}
