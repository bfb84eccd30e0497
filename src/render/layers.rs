//! The parts of a picture: where its light comes from, and by how much shadow and occlusion darken it.

use serde::{Deserialize, Serialize};

use crate::math::Vec3;
use crate::scene::{Material, Mode, Rgb, Scene, Shadows};

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

/// Light that a surface reflects, by lobe.
#[derive(Clone, Copy, Debug, Default)]
pub struct ByLobe {
    pub diffuse: Vec3,
    pub specular: Vec3,
}

impl ByLobe {
    pub fn sum(self) -> Vec3 {
        self.diffuse + self.specular
    }
}

impl std::ops::AddAssign for ByLobe {
    fn add_assign(&mut self, other: Self) {
        self.diffuse += other.diffuse;
        self.specular += other.specular;
    }
}

impl std::ops::Mul<Vec3> for ByLobe {
    type Output = Self;

    fn mul(self, factor: Vec3) -> Self {
        Self {
            diffuse: self.diffuse * factor,
            specular: self.specular * factor,
        }
    }
}

/// How a path from the eye began, which decides the layer of what it finds.
#[derive(Clone, Copy, Debug)]
pub enum Beginning {
    /// It has met nothing yet.
    Eye,
    /// With a mirror or glass, whose layer takes all.
    Specular(Layer),
    /// With one scattering event, in which the diffuse lobe had this share.
    Scattered { diffuse_share: Vec3 },
    /// With a scattering event and at least another event.
    Indirect,
}

impl Beginning {
    /// Whether it has met nothing but mirrors and glass.
    pub fn has_not_scattered(self) -> bool {
        matches!(self, Self::Eye | Self::Specular(_))
    }

    /// After an event at a mirror or glass, of this layer.
    pub fn then_specular(self, layer: Layer) -> Self {
        match self {
            Self::Eye => Self::Specular(layer),
            Self::Specular(first) => Self::Specular(first),
            Self::Scattered { .. } | Self::Indirect => Self::Indirect,
        }
    }

    /// After scattering at a surface that reflects `lobes` of the light from the new direction.
    pub fn then_scattered(self, lobes: ByLobe) -> Self {
        match self {
            Self::Eye => {
                let share = lobes.diffuse / lobes.sum();
                // 0 / 0 in a channel that reflects nothing: either share will do.
                let diffuse_share = Vec3::select(share.is_nan_mask(), Vec3::ONE, share);
                Self::Scattered { diffuse_share }
            }
            Self::Specular(first) => Self::Specular(first),
            Self::Scattered { .. } | Self::Indirect => Self::Indirect,
        }
    }
}

/// What is kept of a sample beside its radiance.
pub trait Parts: Copy {
    /// Those of a sample that has met nothing yet.
    fn nothing() -> Self;

    /// Adds to a layer that is part of the sum.
    fn add(&mut self, layer: Layer, radiance: Vec3);

    /// Takes note of what came through along a shadow ray from the first scattering surface.
    fn count_shadow_ray(&mut self, passed: Vec3);

    /// Takes note of the share of the hemisphere that is free.
    fn set_occlusion(&mut self, free: f32);

    /// What the sample adds to `layer`.
    fn of(&self, layer: Layer) -> Vec3;

    /// Scales the layers that are parts of the sum.
    fn scale(&mut self, factor: f32);
}

/// Nothing is kept: for pictures without layers.
#[derive(Clone, Copy, Debug)]
pub struct NoParts;

impl Parts for NoParts {
    fn nothing() -> Self {
        Self
    }

    fn add(&mut self, _: Layer, _: Vec3) {}

    fn count_shadow_ray(&mut self, _: Vec3) {}

    fn set_occlusion(&mut self, _: f32) {}

    fn of(&self, layer: Layer) -> Vec3 {
        unreachable!("{layer:?} is asked for and was not kept")
    }

    fn scale(&mut self, _: f32) {}
}

/// All layers are kept.
#[derive(Clone, Copy, Debug)]
pub struct AllParts {
    layers: [Vec3; Layer::ALL.len()],
    shadow_rays: u32,
}

impl Parts for AllParts {
    fn nothing() -> Self {
        let mut layers = [Vec3::ZERO; Layer::ALL.len()];
        layers[Layer::Occlusion as usize] = Vec3::ONE;
        Self {
            layers,
            shadow_rays: 0,
        }
    }

    fn add(&mut self, layer: Layer, radiance: Vec3) {
        self.layers[layer as usize] += radiance;
    }

    fn count_shadow_ray(&mut self, passed: Vec3) {
        self.layers[Layer::Shadow as usize] += passed;
        self.shadow_rays += 1;
    }

    fn set_occlusion(&mut self, free: f32) {
        self.layers[Layer::Occlusion as usize] = Vec3::splat(free);
    }

    fn of(&self, layer: Layer) -> Vec3 {
        let value = self.layers[layer as usize];
        match layer {
            Layer::Shadow if self.shadow_rays == 0 => Vec3::ONE,
            Layer::Shadow => value / self.shadow_rays as f32,
            _ => value,
        }
    }

    fn scale(&mut self, factor: f32) {
        for layer in Layer::ALL.into_iter().filter(|layer| layer.is_part()) {
            self.layers[layer as usize] *= factor;
        }
    }
}

/// What one camera sample brings.
#[derive(Clone, Copy, Debug)]
pub struct Gathered<P> {
    /// The sum of all parts.
    pub radiance: Vec3,
    /// Whether `max_bounces` ended the path where it might have brought more.
    pub is_depth_limited: bool,
    pub parts: P,
}

impl<P: Parts> Gathered<P> {
    pub fn nothing() -> Self {
        Self {
            radiance: Vec3::ZERO,
            is_depth_limited: false,
            parts: P::nothing(),
        }
    }

    /// Light seen directly, or a false colour.
    pub fn seen(radiance: Vec3) -> Self {
        let mut gathered = Self::nothing();
        gathered.add(Layer::Emission, radiance);
        gathered
    }

    fn add(&mut self, layer: Layer, radiance: Vec3) {
        self.radiance += radiance;
        self.parts.add(layer, radiance);
    }

    /// Adds light of a light or emitter that a path met.
    pub fn add_light(&mut self, beginning: Beginning, radiance: Vec3) {
        match beginning {
            Beginning::Eye => self.add(Layer::Emission, radiance),
            Beginning::Specular(layer) => self.add(layer, radiance),
            Beginning::Scattered { diffuse_share } => {
                self.radiance += radiance;
                let diffuse = radiance * diffuse_share;
                self.parts.add(Layer::DirectDiffuse, diffuse);
                self.parts.add(Layer::DirectSpecular, radiance - diffuse);
            }
            Beginning::Indirect => self.add(Layer::Indirect, radiance),
        }
    }

    /// Adds light of the background that a path met.
    pub fn add_background(&mut self, beginning: Beginning, radiance: Vec3) {
        match beginning {
            Beginning::Scattered { .. } => self.add(Layer::Ambient, radiance),
            _ => self.add_light(beginning, radiance),
        }
    }

    /// Adds light that a surface reflects straight from lights, met by a path that had this `beginning` before.
    pub fn add_reflected(&mut self, beginning: Beginning, lobes: ByLobe) {
        match beginning {
            Beginning::Eye => {
                self.radiance += lobes.sum();
                self.parts.add(Layer::DirectDiffuse, lobes.diffuse);
                self.parts.add(Layer::DirectSpecular, lobes.specular);
            }
            Beginning::Specular(layer) => self.add(layer, lobes.sum()),
            _ => self.add(Layer::Indirect, lobes.sum()),
        }
    }

    /// Adds light of the background that a surface reflects, as [`Self::add_reflected`].
    pub fn add_ambient(&mut self, beginning: Beginning, radiance: Vec3) {
        match beginning {
            Beginning::Eye => self.add(Layer::Ambient, radiance),
            Beginning::Specular(layer) => self.add(layer, radiance),
            _ => self.add(Layer::Indirect, radiance),
        }
    }

    /// Scales it down to `most` in its brightest channel; returns whether it was brighter.
    pub fn limit(&mut self, most: f32) -> bool {
        let brightest = self.radiance.max_element();
        let is_brighter = brightest > most;
        if is_brighter {
            self.scale(most / brightest);
        }
        is_brighter
    }

    /// Scales the parts and their sum.
    fn scale(&mut self, factor: f32) {
        self.radiance *= factor;
        self.parts.scale(factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_way_of_adding_keeps_the_sum() {
        let lobes = ByLobe {
            diffuse: Vec3::new(0.3, 0.0, 0.1),
            specular: Vec3::new(0.1, 0.0, 0.5),
        };
        let beginnings = [
            Beginning::Eye,
            Beginning::Eye.then_specular(Layer::Refraction),
            Beginning::Eye.then_scattered(lobes),
            Beginning::Eye
                .then_scattered(lobes)
                .then_specular(Layer::Reflection),
            Beginning::Eye
                .then_specular(Layer::Reflection)
                .then_scattered(lobes),
        ];
        for beginning in beginnings {
            let mut gathered = Gathered::<AllParts>::nothing();
            gathered.add_light(beginning, Vec3::new(1.0, 2.0, 3.0));
            gathered.add_background(beginning, Vec3::new(0.5, 0.25, 0.125));
            gathered.add_reflected(beginning, lobes);
            gathered.add_ambient(beginning, Vec3::splat(0.7));
            gathered.parts.count_shadow_ray(Vec3::ZERO);
            gathered.scale(0.5);
            let parts = Layer::ALL.into_iter().filter(|layer| layer.is_part());
            let sum: Vec3 = parts.map(|layer| gathered.parts.of(layer)).sum();
            assert!(
                sum.abs_diff_eq(gathered.radiance, 1e-6),
                "{beginning:?}: {sum} {}",
                gathered.radiance
            );
        }
    }

    #[test]
    fn the_first_event_decides_the_layer() {
        let lobes = ByLobe {
            diffuse: Vec3::splat(0.75),
            specular: Vec3::splat(0.25),
        };
        let light = |beginning| {
            let mut gathered = Gathered::<AllParts>::nothing();
            gathered.add_light(beginning, Vec3::ONE);
            gathered.parts
        };
        let scattered = Beginning::Eye.then_scattered(lobes);
        assert_eq!(light(Beginning::Eye).of(Layer::Emission), Vec3::ONE);
        assert_eq!(
            light(scattered).of(Layer::DirectDiffuse).x.to_bits(),
            0.75_f32.to_bits()
        );
        assert_eq!(
            light(scattered).of(Layer::DirectSpecular).x.to_bits(),
            0.25_f32.to_bits()
        );
        let caustic = scattered.then_specular(Layer::Refraction);
        assert_eq!(light(caustic).of(Layer::Indirect), Vec3::ONE);
        let seen_in_glass = Beginning::Eye
            .then_specular(Layer::Refraction)
            .then_scattered(lobes)
            .then_specular(Layer::Reflection);
        assert_eq!(light(seen_in_glass).of(Layer::Refraction), Vec3::ONE);
        assert_eq!(light(scattered).of(Layer::Shadow), Vec3::ONE);
    }
}
