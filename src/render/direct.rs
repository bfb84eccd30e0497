//! The `direct` mode: at the first surface that is neither mirror nor glass, the light that arrives straight from lights and
//! background. Mirrors and glass are followed along one path, never a tree.

use super::camera::CameraRay;
use super::eye_path::EyePath;
use super::fresnel::fresnel;
use super::kernel::Kernel;
use super::layers::{ByLobe, Gathered, Parts};
use super::light::{LightSample, PreparedDisk, PreparedLight};
use super::material::PreparedMaterial;
use super::media::Media;
use super::mis::power_heuristic;
use super::phong::Phong;
use super::plan::Feature;
use super::prepare::{PreparedScene, Seen};
use super::sampler::{Decision, Dimension, Sampler, Turns};
use super::shadow_ray;
use super::sky_light;
use super::specular::Specular;
use super::surface::SurfacePoint;
use super::tally::{NotedRay, RayPurpose, Tally};
use super::texturing::Texturing;
use crate::accel::{Fan, Hit};
use crate::math::{Ray, Vec2, Vec3, warp};
use crate::scene::Shadows;
use std::borrow::Borrow;
use std::hint::black_box;

/// The most lights that are summed. Of more, some are chosen: what a sample costs then does not depend on their number.
pub const MOST_SUMMED: usize = 32;
/// Lights chosen for each of the scene's shadow samples: a quarter of what the largest sum costs, as the noise of a choice among
/// many calls for more than one.
const CHOSEN_PER_SHADOW_SAMPLE: u32 = 8;

/// The light that arrives against `camera_ray`, which makes that `hit`.
pub fn gather<K: Kernel>(
    scene: &PreparedScene,
    camera_ray: CameraRay,
    hit: Option<Hit>,
    sampler: Sampler,
    tally: &mut K::Tally,
) -> Gathered<K::Parts> {
    let mut path = EyePath::<K>::new(scene, camera_ray, hit);
    loop {
        let mut point = match path.seen() {
            Seen::Background => {
                let direction = path.ray.direction.normalize();
                path.meet_background(scene.background().radiance(direction), 1.0);
                break;
            }
            Seen::Disk(met) => {
                path.meet_disk(&met, 1.0);
                break;
            }
            Seen::Surface(point) => point,
        };
        path.absorb(&point);
        let material = scene.material(point.object);
        if let PreparedMaterial::Emitter { radiance } = *material {
            path.meet_emitter(radiance, 1.0);
            break;
        }
        if path.end_if_spent(material) {
            break;
        }
        match material {
            PreparedMaterial::Phong(phong) => {
                let hit = path.hit.as_ref();
                let phong = path.texturing.at(scene, phong, &mut point, hit);
                let phong: &Phong = phong.borrow();
                if !phong.is_black() || scene.does(Feature::DarkRays) {
                    let mut shading = Shading::<K> {
                        scene,
                        phong,
                        point: &point,
                        media: path.media,
                        mirror: point.mirror_direction(),
                        sampler,
                        bounce: path.bounce,
                        parts: &mut path.gathered.parts,
                        tally,
                    };
                    let ambient = shading.reflected_background();
                    let lobes = shading.light_from_all();
                    let (beginning, throughput) = (path.beginning, path.throughput);
                    path.gathered.add_ambient(beginning, throughput * ambient);
                    path.gathered.add_reflected(beginning, lobes * throughput);
                }
                break;
            }
            PreparedMaterial::Specular(specular) => {
                path.deflect(specular, &point, &sampler, tally);
            }
            PreparedMaterial::Emitter { .. } => unreachable!("emitters end the path above"),
        }
        if path.throughput == Vec3::ZERO && !scene.does(Feature::DarkRays) {
            break;
        }
        if !path.go_on(tally) {
            break;
        }
    }
    path.gathered
}

/// Fewer shadow rays to a light than this are traced one by one.
const FEWEST_TOGETHER: u32 = 3;
/// The most rays of ambient occlusion that are traced together.
const FAN_SIZE: u32 = 64;
const _: () = assert!(FAN_SIZE as usize == Fan::MOST_RAYS, "full fans");

/// What [`ambient_occlusion`] finds.
#[derive(Clone, Copy, Debug)]
pub struct Occlusion {
    /// Share of the hemisphere in which nothing is near, weighted by the cosine.
    pub free: f32,
    /// The cosine-weighted mean of a radiance over the hemisphere, 0 where something is near.
    pub radiance: Vec3,
}

/// Looks for what is near over `point`; `radiance` is what a free direction gives.
pub fn ambient_occlusion(
    scene: &PreparedScene,
    point: &SurfacePoint,
    turns: &Turns,
    tally: &mut impl Tally,
    radiance: impl Fn(Vec3) -> Vec3,
) -> Occlusion {
    let samples = scene.settings().ambient_occlusion.samples;
    let around_normal = warp::Frame::around(point.shading_normal);
    let mut sum = Vec3::ZERO;
    let mut free = 0_u32;
    let mut unit = [Vec3::ZERO; Fan::MOST_RAYS];
    for first in (0..samples).step_by(Fan::MOST_RAYS) {
        let turns_of_fan = first..samples.min(first + FAN_SIZE);
        let unit = &mut unit[..turns_of_fan.len()];
        for (wi, turn) in unit.iter_mut().zip(turns_of_fan) {
            let local = warp::cosine_hemisphere(turns.next_2d(turn));
            *wi = around_normal.world_from_local(local);
        }
        #[expect(clippy::cast_possible_truncation, reason = "a fan has few rays")]
        tally.note_draws(Decision::AmbientOcclusion, unit.len() as u32);
        let occluded = scene.near_things(point, unit);
        tally.note_all(RayPurpose::AmbientOcclusion, unit.len(), |number| {
            let ray = point.ray_above(unit[number] * scene.occlusion_radius());
            NotedRay::of_fan(ray, number, occluded)
        });
        for (index, &wi) in unit.iter().enumerate() {
            if occluded >> index & 1 == 0 {
                free += 1;
                sum += radiance(wi);
            }
        }
    }
    let samples = samples as f32;
    Occlusion {
        free: free as f32 / samples,
        radiance: sum / samples,
    }
}

/// A ray from a surface point to a light, and what it brings where nothing is in the way.
#[derive(Clone, Copy)]
struct ShadowRay {
    /// As far as the light.
    direction: Vec3,
    light: ByLobe,
}

/// Rays from one point to one light that wait to be traced together.
struct ShadowRays {
    directions: [Vec3; Self::MOST],
    lights: [ByLobe; Self::MOST],
    count: usize,
}

impl ShadowRays {
    /// Few, as room for so many is cleared for every light.
    const MOST: usize = 18;

    fn new() -> Self {
        Self {
            directions: [Vec3::ZERO; Self::MOST],
            lights: [ByLobe::default(); Self::MOST],
            count: 0,
        }
    }

    /// Whether there may be no room for what aiming once adds.
    fn is_full(&self) -> bool {
        self.count + 2 > Self::MOST
    }

    fn extend(&mut self, rays: [Option<ShadowRay>; 2]) {
        for ShadowRay { direction, light } in rays.into_iter().flatten() {
            self.directions[self.count] = direction;
            self.lights[self.count] = light;
            self.count += 1;
        }
    }

    /// All of them, directions and lights; leaves none.
    fn take(&mut self) -> (&[Vec3], &[ByLobe]) {
        let count = std::mem::take(&mut self.count);
        (&self.directions[..count], &self.lights[..count])
    }
}

/// A surface point to be shaded.
struct Shading<'a, K: Kernel> {
    scene: &'a PreparedScene,
    phong: &'a Phong,
    point: &'a SurfacePoint,
    /// What it is in.
    media: Media,
    /// The mirror direction of `wo`.
    mirror: Vec3,
    sampler: Sampler,
    /// Scattering events before this one.
    bounce: u32,
    /// Takes note of shadow and occlusion.
    parts: &'a mut K::Parts,
    tally: &'a mut K::Tally,
}

impl<K: Kernel> Shading<'_, K> {
    /// What is reflected of the background's light.
    fn reflected_background(&mut self) -> Vec3 {
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
            return sky_light::mean_over_hemisphere(scene, image, self.point, numbers, self.tally);
        }
        let samples = scene.settings().ambient_occlusion.samples;
        let turns = self.turns(Decision::AmbientOcclusion, 0, samples);
        let radiance = |wi| background.radiance(wi);
        ambient_occlusion(scene, self.point, &turns, self.tally, radiance)
    }

    /// Reflected light of all lights and emitting objects.
    fn light_from_all(&mut self) -> ByLobe {
        let mut sum = ByLobe::default();
        let scene = self.scene;
        if !scene.does(Feature::Aiming) {
            return sum;
        }
        if !scene.emitters().holds_lights() {
            for (index, light) in (0..).zip(scene.lights()) {
                sum += self.light_from(index, light);
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
        emitters.choose_each(&at, (0..count).map(number), |turn, chosen| {
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
            for turn in 0..count {
                if shadow_rays.is_full() {
                    sum += self.light_along_all(&mut shadow_rays, light_number);
                }
                shadow_rays.extend(self.aim(light, numbers.as_ref(), turn));
            }
            sum += self.light_along_all(&mut shadow_rays, light_number);
        }
        sum * Vec3::splat(1.0 / count as f32)
    }

    /// Whether the light shines from one point alone.
    fn is_point(&self, light: &PreparedLight) -> bool {
        !light.has_area() || self.scene.settings().shadows == Shadows::Hard
    }

    /// Aims at one point of the light and, where the light is near, also looks for it in one direction of the hemisphere.
    fn aim(
        &mut self,
        light: &PreparedLight,
        numbers: Option<&LightNumbers>,
        turn: u32,
    ) -> [Option<ShadowRay>; 2] {
        let from = self.point.shading_position;
        let point = numbers.map(|numbers| numbers.points.next_2d(turn));
        self.tally
            .note_draws(Decision::Light, u32::from(point.is_some()));
        let (Some(numbers), Some(point), false) = (numbers, point, self.is_point(light)) else {
            black_box(point);
            return [self.aim_at_sample(&light.center(from), |_| 1.0), None];
        };
        let sample = light.sample(from, point);
        if self.scene.settings().shadows == Shadows::Fraction {
            let ray = self.center_by_place(&light.center(from), sample.position);
            return [ray, None];
        }
        match light {
            PreparedLight::Disk(disk) if disk.is_near(from) => {
                let normal = self.point.shading_normal;
                let weight = |wi: Vec3| {
                    let towards = Ray::new(from, sample.position - from);
                    power_heuristic(
                        disk.pdf_solid_angle(&towards, 1.0),
                        warp::cosine_pdf_around(normal, wi),
                    )
                };
                self.tally.note_draws(Decision::NearLight, 1);
                let looked_for = self.look_for_disk(disk, numbers.directions.next_2d(turn));
                [self.aim_at_sample(&sample, weight), looked_for]
            }
            _ => [self.aim_at_sample(&sample, |_| 1.0), None],
        }
    }

    /// The rule of 2011: what the light's `center` would give, where `place` on the light is seen. Its mean is the light of the
    /// centre times the share of the light that is seen.
    fn center_by_place(&mut self, center: &LightSample, place: Vec3) -> Option<ShadowRay> {
        let wi = (center.position - self.point.shading_position).try_normalize()?;
        let reflected = self.reflected_share(wi);
        if reflected.sum() == Vec3::ZERO || center.irradiance == Vec3::ZERO {
            return self.nothing(place);
        }
        Some(ShadowRay {
            direction: self.point.ray_to(place).direction,
            light: reflected * center.irradiance,
        })
    }

    /// Reflected light of one point of a light, times what `weight` says of its direction.
    fn aim_at_sample(
        &mut self,
        sample: &LightSample,
        weight: impl Fn(Vec3) -> f32,
    ) -> Option<ShadowRay> {
        // No ray where nothing would be reflected anyway.
        let wi = (sample.position - self.point.shading_position).try_normalize()?;
        if sample.irradiance == Vec3::ZERO {
            return self.nothing(sample.position);
        }
        let reflected = self.reflected_share(wi);
        if reflected.sum() == Vec3::ZERO {
            return self.nothing(sample.position);
        }
        Some(ShadowRay {
            direction: self.point.ray_to(sample.position).direction,
            light: reflected * (sample.irradiance * weight(wi)),
        })
    }

    /// The result of aiming at a `place` that can bring nothing: no ray is needed.
    fn nothing(&mut self, place: Vec3) -> Option<ShadowRay> {
        if self.scene.does(Feature::DarkRays) {
            let ray = self.point.ray_to(place);
            black_box(shadow_ray::passed(self.scene, ray, 1.0, None, self.tally));
        }
        None
    }

    /// Reflected light of a near disk, looked for in a direction of the hemisphere: the other half of
    /// [`Self::aim_at_sample`], which is noisy where the light is near.
    fn look_for_disk(&self, disk: &PreparedDisk, u: Vec2) -> Option<ShadowRay> {
        let normal = self.point.shading_normal;
        let wi = warp::around(normal, warp::cosine_hemisphere(u));
        let reflected = self.reflected_share(wi);
        let ray = self.point.ray_above(wi);
        let emitted = disk.emitted(wi);
        let t = disk.intersect(&ray, f32::INFINITY)?;
        if reflected.sum() == Vec3::ZERO || emitted == Vec3::ZERO {
            return None;
        }
        let pdf = warp::cosine_pdf_around(normal, wi);
        let weight = power_heuristic(pdf, disk.pdf_solid_angle(&ray, t));
        let ray = self.point.ray_to(disk.in_front(ray.at(t)));
        Some(ShadowRay {
            direction: ray.direction,
            light: reflected * (emitted * (weight / pdf)),
        })
    }

    /// What leaves towards `wo` of light from `wi`, per irradiance on a surface that faces it.
    fn reflected_share(&self, wi: Vec3) -> ByLobe {
        let cosine = self.point.cosine(wi);
        if cosine <= 0.0 {
            return ByLobe::default();
        }
        let model = self.scene.settings().phong;
        self.phong.reflected(model, self.mirror, wi, cosine)
    }

    /// What `ray` brings, where nothing is in the way but the light number `light`.
    fn light_along(&mut self, ray: &ShadowRay, light: Option<u32>) -> ByLobe {
        ray.light * self.visible(&self.point.ray_above(ray.direction), light)
    }

    /// [`Self::light_along`] for all of `shadow_rays`, which are taken out.
    fn light_along_all(&mut self, shadow_rays: &mut ShadowRays, light: Option<u32>) -> ByLobe {
        let mut sum = ByLobe::default();
        let (directions, lights) = shadow_rays.take();
        let fan = self.point.fan(directions);
        let scene = self.scene;
        if !scene.does(Feature::ShadowRays) || scene.does(Feature::GlassShadows) {
            for (ray, &brought) in fan.rays().zip(lights) {
                sum += brought * self.visible(&ray, light);
            }
            return sum;
        }
        let occluded = scene.occluded_fan(&fan, light);
        let origin = self.point;
        let noted = |number| {
            let ray = origin.ray_above(directions[number]);
            NotedRay::of_fan(ray, number, occluded)
        };
        self.tally
            .note_all(RayPurpose::Shadow, directions.len(), noted);
        for (index, &brought) in lights.iter().enumerate() {
            let is_free = occluded >> index & 1 == 0;
            let passed = if is_free { Vec3::ONE } else { Vec3::ZERO };
            sum += brought * self.through(passed);
        }
        sum
    }

    /// Share of the light that comes through along `ray`, from here to the light where its parameter is 1.
    fn visible(&mut self, ray: &Ray, light: Option<u32>) -> Vec3 {
        let scene = self.scene;
        if !scene.does(Feature::ShadowRays) {
            return Vec3::ONE;
        }
        let passed = if scene.does(Feature::GlassShadows) {
            self.tally.note_looking_for_glass();
            let passed = self.through_glass(*ray, light);
            let noted = || NotedRay::passing(*ray, 1.0, passed);
            self.tally.note(RayPurpose::Shadow, noted);
            passed
        } else {
            shadow_ray::passed(scene, *ray, 1.0, light, self.tally)
        };
        self.through(passed)
    }

    /// What counts of a shadow ray along which `passed` came through: all of it, or everything where there are no shadows.
    fn through(&mut self, passed: Vec3) -> Vec3 {
        if self.scene.needs(Feature::ShadowRays) {
            self.parts.count_shadow_ray(passed);
            passed
        } else {
            black_box(passed);
            Vec3::ONE
        }
    }

    /// [`Self::visible`] where glass may stand in between: it is passed straight, losing what each face reflects and what
    /// the inside absorbs.
    fn through_glass(&self, mut ray: Ray, light: Option<u32>) -> Vec3 {
        let target = ray.at(1.0);
        let mut passed = Vec3::ONE;
        let mut media = self.media;
        loop {
            if self.scene.disk_occludes(&ray, 1.0, light) {
                return Vec3::ZERO;
            }
            let Some(point) = self.scene.surface_along(&ray, 1.0) else {
                return passed * media.transmittance_along(self.scene, &ray, 1.0, 0.0);
            };
            let PreparedMaterial::Specular(Specular::Glass { ior, .. }) =
                *self.scene.material(point.object)
            else {
                return Vec3::ZERO;
            };
            // The ray stays straight, so both faces are met at the angle outside; Fresnel's equations give the way out the
            // same loss as the way in.
            passed *= 1.0 - fresnel(point.shading_normal.dot(point.wo), ior).reflectance;
            passed *= media.transmittance_from(self.scene, &point, 0.0);
            media.cross(&point);
            if passed == Vec3::ZERO {
                return passed;
            }
            ray = point.ray_through_to(target);
        }
    }

    /// The random numbers of a decision about `item` that is taken `count` times here.
    fn turns(&self, decision: Decision, item: u32, count: u32) -> Turns {
        let dimension = Dimension::at(decision, self.bounce).about(item);
        self.sampler.turns(dimension, count)
    }
}

/// The random numbers for lights with area.
struct LightNumbers {
    /// For points on them.
    points: Turns,
    /// For directions in which near ones are looked for.
    directions: Turns,
}

impl LightNumbers {
    fn new<K: Kernel>(shading: &Shading<'_, K>, item: u32, count: u32) -> Self {
        Self {
            points: shading.turns(Decision::Light, item, count),
            directions: shading.turns(Decision::NearLight, item, count),
        }
    }
}
