//! What one camera sample brings: the sum and, where the picture has layers, each of its parts. How its path began decides to which of
//! them light belongs.

use super::Layer;
use crate::math::Vec3;

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
