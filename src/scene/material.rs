use super::Rgb;

/// How a surface scatters light. Surfaces are two-sided, except glass, where the side decides inside and outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Material {
    /// `f = diffuse/π + specular · (shininess + 2)/(2π) · cosᵅ`, the modified Phong model (Lafortune & Willems 1994), or
    /// the classic one where [`super::PhongModel`] says so.
    Phong {
        /// Diffuse reflectance, `0..=1` per channel.
        diffuse: Rgb,
        /// Specular reflectance, `0..=1` per channel.
        specular: Rgb,
        /// Exponent of the lobe, 0 or more.
        shininess: f64,
    },
    /// Reflects like a perfect mirror.
    Mirror {
        /// Share of the light that is reflected, `0..=1` per channel.
        reflectance: Rgb,
    },
    /// A clear solid that reflects and refracts by Fresnel's equations.
    Glass {
        /// Index of refraction relative to the outside, more than 0. With 1 and no attenuation, nothing is there.
        ior: f64,
        /// Absorption inside, per scene unit (Beer-Lambert): light fades by `exp(−attenuation · distance)`.
        attenuation: Rgb,
    },
    /// Shines on both sides and reflects nothing.
    Emitter {
        /// Emitted radiance in W/m²/sr.
        radiance: Rgb,
    },
}

impl Material {
    /// One colour to know it by: what it reflects or lets through in all, or what it emits.
    #[must_use]
    pub fn color(&self) -> Rgb {
        match *self {
            Self::Phong {
                diffuse, specular, ..
            } => diffuse + specular,
            Self::Mirror { reflectance } => reflectance,
            Self::Glass { .. } => Rgb::ONE,
            Self::Emitter { radiance } => radiance,
        }
    }

    /// A bright mirror, for files that say no more.
    #[must_use]
    pub fn mirror() -> Self {
        Self::Mirror {
            reflectance: Rgb::splat(0.95),
        }
    }

    /// Clear window glass, for files that say no more.
    #[must_use]
    pub fn glass() -> Self {
        Self::Glass {
            ior: 1.5,
            attenuation: Rgb::ZERO,
        }
    }

    /// An emitter of radiance 1, for files that say no more.
    #[must_use]
    pub fn emitter() -> Self {
        Self::Emitter { radiance: Rgb::ONE }
    }
}

impl Default for Material {
    fn default() -> Self {
        Self::Phong {
            diffuse: Rgb::splat(0.8),
            specular: Rgb::ZERO,
            shininess: 40.0,
        }
    }
}
