//! What a surface point reflects of light that arrives straight from the background, from lights and from emitters.

use super::aiming::LightNumbers;
use super::shadow_rays::ShadowRays;
use crate::math::Vec3;
use crate::render::ambient_occlusion::{Occlusion, ambient_occlusion};
use crate::render::kernel::Kernel;
use crate::render::layers::{ByLobe, Parts};
use crate::render::light::PreparedLight;
use crate::render::media::Media;
use crate::render::phong::Phong;
use crate::render::plan::Feature;
use crate::render::prepare::PreparedScene;
use crate::render::sampler::{Decision, Dimension, Sampler, Turns};
use crate::render::sky_light;
use crate::render::stops::Stops;
use crate::render::surface::SurfacePoint;
use crate::render::tally::Tally;
use std::hint::black_box;

/// The most lights that are summed. Of more, some are chosen: what a sample costs then does not depend on their number.
pub const MOST_SUMMED: usize = 32;
/// Lights chosen for each of the scene's shadow samples: a quarter of what the largest sum costs, as the noise of a choice among
/// many calls for more than one.
const CHOSEN_PER_SHADOW_SAMPLE: u32 = 8;

/// Fewer shadow rays to a light than this are traced one by one.
const FEWEST_TOGETHER: u32 = 3;

/// A surface point to be shaded. What it reflects is not all there when stopped.
pub struct Shading<'a, K: Kernel> {
    pub scene: &'a PreparedScene,
    pub phong: &'a Phong,
    pub point: &'a SurfacePoint,
    /// What it is in.
    pub media: &'a Media,
    /// The mirror direction of `wo`.
    pub mirror: Vec3,
    pub sampler: Sampler,
    /// Scattering events before this one.
    pub bounce: u32,
    pub stops: &'a Stops<'a>,
    /// Takes note of shadow and occlusion.
    pub parts: &'a mut K::Parts,
    pub tally: &'a mut K::Tally,
}

impl<K: Kernel> Shading<'_, K> {
    /// What is reflected of the background's light.
    #[inline]
    pub fn reflected_background(&mut self) -> Vec3 {
        let (scene, diffuse) = (self.scene, self.phong.diffuse);
        if scene.needs(Feature::Occlusion) && !scene.background().is_black() {
            if diffuse != Vec3::ZERO {
                let found = self.over_hemisphere();
                self.parts.set_occlusion(found.free);
                return diffuse * found.radiance;
            }
            if scene.does(Feature::DarkRays) {
                black_box(self.over_hemisphere());
            }
            return Vec3::ZERO;
        }
        if scene.forces(Feature::Occlusion) {
            black_box(self.over_hemisphere());
        }
        let mean = scene
            .background()
            .mean_over_hemisphere(self.point.shading_normal);
        mean.map_or(Vec3::ZERO, |mean| diffuse * mean)
    }

    /// Looks for what is near, and for the background where nothing is.
    fn over_hemisphere(&mut self) -> Occlusion {
        let (scene, background) = (self.scene, self.scene.background());
        if let Some(image) = background.image() {
            let numbers = (self.sampler, self.bounce);
            let (point, stops) = (self.point, self.stops);
            return sky_light::mean_over_hemisphere(
                scene, image, point, numbers, stops, self.tally,
            );
        }
        let samples = scene.settings().ambient_occlusion.samples;
        let turns = self.turns(Decision::AmbientOcclusion, 0, samples);
        let radiance = |wi| background.radiance(wi);
        ambient_occlusion(scene, self.point, &turns, self.stops, self.tally, radiance)
    }

    /// Reflected light of all lights and emitting objects.
    #[inline]
    pub fn light_from_all(&mut self) -> ByLobe {
        let mut sum = ByLobe::default();
        let scene = self.scene;
        if !scene.does(Feature::Aiming) {
            return sum;
        }
        if !scene.emitters().holds_lights() {
            let mut turns = 0;
            for (index, light) in (0..).zip(scene.lights()) {
                sum += self.light_from(index, light);
                turns += scene.settings().shadow_samples;
                if turns >= Stops::TURNS {
                    if self.stops.is_asked() {
                        return sum;
                    }
                    turns = 0;
                }
            }
        }
        sum += self.chosen_light();
        sum
    }

    /// Reflected light of sources of which some are chosen, in place of a sum over all: emitting objects, with as many rays as to a light
    /// with area, and lights where they are too many to sum.
    fn chosen_light(&mut self) -> ByLobe {
        let mut sum = ByLobe::default();
        let scene = self.scene;
        let (emitters, lights) = (scene.emitters(), scene.lights());
        if emitters.is_empty() {
            return sum;
        }
        let mut count = scene.settings().shadow_samples;
        if emitters.holds_lights() {
            count *= CHOSEN_PER_SHADOW_SAMPLE;
        }
        let at = self.point.receiver();
        let choices = self.turns(Decision::LightChoice, 0, count);
        let emitter_points = self.turns(Decision::EmitterPoint, 0, count);
        let numbers = scene
            .does(Feature::LightPoints)
            .then(|| LightNumbers::new(self, 0, count));
        let number = |turn| choices.next_2d(turn);
        self.tally.note_draws(Decision::LightChoice, count);
        let stops = self.stops;
        let turns = (0..count).take_while(|&turn| turn == 0 || stops.lets_go_on(turn));
        emitters.choose_each(&at, turns.map(number), |turn, chosen| {
            if let Some(index) = chosen.light() {
                let light = &lights[index as usize];
                for ray in self
                    .aim(light, numbers.as_ref(), turn)
                    .into_iter()
                    .flatten()
                {
                    let brought = self.light_along(&ray, Some(index));
                    sum += brought * Vec3::splat(1.0 / chosen.probability);
                }
            } else {
                self.tally.note_draws(Decision::EmitterPoint, 1);
                let aim = chosen.aim(lights, &at, emitter_points.next_2d(turn));
                if let Some(ray) = self.aim_at_sample(&aim.sample, |_| 1.0) {
                    sum += self.light_along(&ray, None);
                }
            }
        });
        sum * Vec3::splat(1.0 / count as f32)
    }

    fn light_from(&mut self, index: u32, light: &PreparedLight) -> ByLobe {
        let scene = self.scene;
        let mut sum = ByLobe::default();
        if light.is_black() && !scene.does(Feature::DarkRays) {
            return sum;
        }
        let is_point = self.is_point(light);
        let count = if is_point {
            1
        } else {
            scene.settings().shadow_samples
        };
        let numbers = (!is_point || scene.forces(Feature::LightPoints))
            .then(|| LightNumbers::new(self, index, count));
        let light_number = Some(index);
        if count < FEWEST_TOGETHER {
            for turn in 0..count {
                for ray in self
                    .aim(light, numbers.as_ref(), turn)
                    .into_iter()
                    .flatten()
                {
                    sum += self.light_along(&ray, light_number);
                }
            }
        } else {
            let mut shadow_rays = ShadowRays::new();
            for turns in self.stops.parts(count) {
                for turn in turns {
                    if shadow_rays.is_full() {
                        sum += self.light_along_all(&mut shadow_rays, light_number);
                    }
                    shadow_rays.extend(self.aim(light, numbers.as_ref(), turn));
                }
            }
            sum += self.light_along_all(&mut shadow_rays, light_number);
        }
        sum * Vec3::splat(1.0 / count as f32)
    }

    /// The random numbers of a decision about `item` that is taken `count` times here.
    pub fn turns(&self, decision: Decision, item: u32, count: u32) -> Turns {
        let dimension = Dimension::at(decision, self.bounce).about(item);
        self.sampler.turns(dimension, count)
    }
}
