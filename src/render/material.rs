//! Materials as rendering reads them: in `f32` and prepared units, with grey for what the settings switch off.

use super::phong::Phong;
use super::specular::Specular;
use crate::math::Vec3;
use crate::scene::{Material, RenderSettings};

/// A material as rendering reads it. What the settings switch off has already been replaced.
#[derive(Clone, Copy, Debug)]
pub enum PreparedMaterial {
    Phong(Phong),
    Specular(Specular),
    Emitter { radiance: Vec3 },
}

impl PreparedMaterial {
    /// `scale`: prepared units per scene unit.
    pub fn new(material: &Material, settings: &RenderSettings, scale: f64) -> Self {
        match *material {
            Material::Mirror { .. } if !settings.mirror => Self::Phong(Phong::grey()),
            Material::Glass { .. } if !settings.glass => Self::Phong(Phong::grey()),
            Material::Phong {
                diffuse,
                specular,
                shininess,
                ..
            } => Self::Phong(Phong::new(diffuse, specular, shininess)),
            Material::Mirror { reflectance } => Self::Specular(Specular::Mirror {
                reflectance: reflectance.as_vec3(),
            }),
            #[expect(clippy::cast_possible_truncation, reason = "rendering is f32")]
            Material::Glass { ior, attenuation } => Self::Specular(Specular::Glass {
                ior: ior as f32,
                attenuation: (attenuation / scale).as_vec3(),
            }),
            Material::Emitter { radiance } => Self::Emitter {
                radiance: radiance.as_vec3(),
            },
        }
    }

    /// Whether its numbers fit the precision of rendering.
    pub fn is_finite(&self) -> bool {
        match self {
            Self::Phong(phong) => phong.diffuse.is_finite() && phong.specular.is_finite(),
            Self::Specular(Specular::Mirror { reflectance }) => reflectance.is_finite(),
            Self::Specular(Specular::Glass { ior, attenuation }) => {
                ior.is_finite() && attenuation.is_finite()
            }
            Self::Emitter { radiance } => radiance.is_finite(),
        }
    }

    /// What it emits; `None` where it is no emitter.
    pub fn emission(&self) -> Option<Vec3> {
        match self {
            Self::Emitter { radiance } => Some(*radiance),
            _ => None,
        }
    }

    /// Whether light gets less inside.
    pub fn absorbs(&self) -> bool {
        matches!(self, Self::Specular(Specular::Glass { attenuation, .. }) if *attenuation != Vec3::ZERO)
    }

    /// Diffuse plus specular reflectance; what a mirror reflects; white for glass; black for emitters.
    pub fn albedo(&self) -> Vec3 {
        match self {
            Self::Phong(phong) => phong.albedo(),
            Self::Specular(Specular::Mirror { reflectance }) => *reflectance,
            Self::Specular(Specular::Glass { .. }) => Vec3::ONE,
            Self::Emitter { .. } => Vec3::ZERO,
        }
    }
}
