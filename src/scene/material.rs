//! How surfaces scatter and emit light. Reflectances are linear RGB in `0..=1`, emission is radiance in W/m²/sr.

use super::Rgb;
use crate::geometry::TriangleMesh;

/// How a surface scatters light. Surfaces are two-sided, except glass, where the side decides inside and outside.
#[derive(Clone, Debug, PartialEq)]
pub enum Material {
    /// `f = diffuse/π + specular · (shininess + 2)/(2π) · cosᵅ`, the modified Phong model (Lafortune & Willems 1994), or
    /// the classic one where [`super::PhongModel`] says so.
    Phong {
        /// Diffuse reflectance, `0..=1` per channel.
        diffuse: Rgb,
        /// Specular reflectance, `0..=1` per channel.
        specular: Rgb,
        /// Exponent of the lobe, `0..=`[`Material::MAX_SHININESS`].
        shininess: f64,
        /// What varies over the surface.
        textures: Textures,
    },
    /// Reflects like a perfect mirror.
    Mirror {
        /// Share of the light that is reflected, `0..=1` per channel.
        reflectance: Rgb,
    },
    /// A clear solid that reflects and refracts by Fresnel's equations.
    Glass {
        /// Index of refraction relative to the outside, [`Material::MIN_IOR`]`..=`[`Material::MAX_IOR`]. With 1 and no attenuation,
        /// nothing is there.
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

/// What of a [`Material::Phong`] varies over a surface, where its mesh says how: images by texture coordinates, and the colours of
/// vertices. What a mesh does not have changes nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Textures {
    /// The file of an image whose colours multiply `diffuse`; its texels are in [`Scene::textures`](super::Scene::textures).
    pub diffuse_image: Option<String>,
    /// The file of an image of normals, relative to the surface: red goes along the first texture coordinate, green along the
    /// second, blue off the surface, each from −1 to 1.
    pub normal_image: Option<String>,
    /// Whether the colours of vertices multiply `diffuse`.
    pub vertex_colors: bool,
}

impl Textures {
    /// The names of its images.
    pub fn images(&self) -> impl Iterator<Item = &str> {
        let images = [&self.diffuse_image, &self.normal_image].into_iter();
        images.flatten().map(String::as_str)
    }

    /// The names of its images, to be changed.
    pub fn images_mut(&mut self) -> impl Iterator<Item = &mut String> {
        let images = [&mut self.diffuse_image, &mut self.normal_image].into_iter();
        images.flatten()
    }

    /// Calls the image called `from` by another name.
    pub fn rename(&mut self, from: &str, to: &str) {
        for image in self.images_mut().filter(|image| *image == from) {
            to.clone_into(image);
        }
    }

    /// Takes the image called `name` away.
    pub fn leave_out(&mut self, name: &str) {
        for image in [&mut self.diffuse_image, &mut self.normal_image] {
            image.take_if(|image| image == name);
        }
    }

    /// Takes the image called `name` away as one of normals; whether it was one.
    pub fn leave_out_normals(&mut self, name: &str) -> bool {
        self.normal_image.take_if(|image| image == name).is_some()
    }

    /// Whether anything varies over `mesh`, which may have neither texture coordinates nor colours.
    #[must_use]
    pub fn vary_over(&self, mesh: &TriangleMesh) -> bool {
        let has_image = self.images().next().is_some();
        has_image && mesh.texture_coordinates.is_some()
            || self.vertex_colors && mesh.colors.is_some()
    }
}

impl Material {
    /// What a channel may reflect in all without reflecting more light than arrives: 1, and what colours are off by that were picked as
    /// `f32`.
    pub const MAX_REFLECTANCE: f64 = 1.0 + 1e-6;
    /// Largest exponent of a lobe.
    pub const MAX_SHININESS: f64 = 1e12;
    /// Least index of refraction.
    pub const MIN_IOR: f64 = 1e-6;
    /// Largest index of refraction.
    pub const MAX_IOR: f64 = 1e6;
    /// The index of refraction of window glass, where none is stated.
    pub const USUAL_IOR: f64 = 1.5;

    /// What varies over a surface of it; `None` where nothing can.
    #[must_use]
    pub fn textures(&self) -> Option<&Textures> {
        match self {
            Self::Phong { textures, .. } => Some(textures),
            _ => None,
        }
    }

    /// [`Material::textures`], to be changed.
    pub fn textures_mut(&mut self) -> Option<&mut Textures> {
        match self {
            Self::Phong { textures, .. } => Some(textures),
            _ => None,
        }
    }

    /// One colour to know it by: what it reflects or lets through in all, or what it emits.
    #[must_use]
    pub fn color(&self) -> Rgb {
        match self {
            Self::Phong {
                diffuse, specular, ..
            } => diffuse + specular,
            Self::Mirror { reflectance } => *reflectance,
            Self::Glass { .. } => Rgb::ONE,
            Self::Emitter { radiance } => *radiance,
        }
    }

    /// The name of its kind, as scene files have it.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Phong { .. } => "phong",
            Self::Mirror { .. } => "mirror",
            Self::Glass { .. } => "glass",
            Self::Emitter { .. } => "emitter",
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
            ior: Self::USUAL_IOR,
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
            textures: Textures::default(),
        }
    }
}
