use super::Rgb;

/// How a surface scatters light. Surfaces are two-sided.
#[derive(Clone, Debug, PartialEq)]
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
