use super::phong::Phong;
use crate::math::Vec3;
use crate::scene::{Material, RenderSettings};

/// A material as rendering reads it. What the settings switch off has already been replaced.
#[derive(Clone, Copy, Debug)]
pub enum PreparedMaterial {
    Phong(Phong),
    Mirror {
        reflectance: Vec3,
    },
    Glass {
        ior: f32,
        /// Per prepared unit.
        attenuation: Vec3,
    },
    Emitter {
        radiance: Vec3,
    },
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
            } => Self::Phong(Phong::new(diffuse, specular, shininess)),
            Material::Mirror { reflectance } => Self::Mirror {
                reflectance: reflectance.as_vec3(),
            },
            #[expect(clippy::cast_possible_truncation, reason = "rendering is f32")]
            Material::Glass { ior, attenuation } => Self::Glass {
                ior: ior as f32,
                attenuation: (attenuation / scale).as_vec3(),
            },
            Material::Emitter { radiance } => Self::Emitter {
                radiance: radiance.as_vec3(),
            },
        }
    }

    /// Whether its numbers fit the precision of rendering.
    pub fn is_finite(&self) -> bool {
        match self {
            Self::Phong(phong) => phong.diffuse.is_finite() && phong.specular.is_finite(),
            Self::Mirror { reflectance } => reflectance.is_finite(),
            Self::Glass { ior, attenuation } => ior.is_finite() && attenuation.is_finite(),
            Self::Emitter { radiance } => radiance.is_finite(),
        }
    }

    /// Diffuse plus specular reflectance; what a mirror reflects; white for glass; black for emitters.
    pub fn albedo(&self) -> Vec3 {
        match self {
            Self::Phong(phong) => phong.diffuse + phong.specular,
            Self::Mirror { reflectance } => *reflectance,
            Self::Glass { .. } => Vec3::ONE,
            Self::Emitter { .. } => Vec3::ZERO,
        }
    }
}

/// Share of the light that is left after `distance` through a medium.
pub fn transmittance(attenuation: Vec3, distance: f32) -> Vec3 {
    if attenuation == Vec3::ZERO {
        Vec3::ONE
    } else {
        (-attenuation * distance).map(libm::expf)
    }
}
