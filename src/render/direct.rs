//! The `direct` mode: at the first surface that is neither mirror nor glass, the light that arrives straight from lights and
//! background. Mirrors and glass are followed along one path, never a tree.

use std::f32::consts::PI;

use super::camera::CameraRay;
use super::disks::DiskHit;
use super::fresnel::{fresnel, reflect, refract};
use super::light::{LightSample, PreparedDisk, PreparedLight};
use super::material::{PreparedMaterial, transmittance};
use super::phong::Phong;
use super::prepare::{PreparedScene, Seen};
use super::run::RayCounts;
use super::sampler::{Decision, Dimension, Sampler};
use super::surface::SurfacePoint;
use crate::math::{Ray, Vec2, Vec3, warp};
use crate::scene::Shadows;

/// The most lights that are summed. Of more, some are chosen: what a sample costs then does not depend on their number.
pub const MOST_SUMMED: usize = 32;
/// Lights chosen for each of the scene's shadow samples: a quarter of what the largest sum costs, as the noise of a choice among
/// many calls for more than one.
const CHOSEN_PER_SHADOW_SAMPLE: u32 = 8;

/// Radiance that arrives against `ray`, a camera ray.
pub fn radiance(
    scene: &PreparedScene,
    CameraRay { mut ray, mut start }: CameraRay,
    sampler: Sampler,
    rays: &mut RayCounts,
) -> Vec3 {
    let mut throughput = Vec3::ONE;
    for bounce in 0.. {
        let point = match scene.nearest(&ray) {
            Seen::Background => {
                return throughput * scene.background().radiance(ray.direction.normalize());
            }
            Seen::Disk(DiskHit { disk, .. }) => return throughput * disk.emitted(ray.direction),
            Seen::Surface(point) => point,
        };
        let material = scene.material(point.object);
        if let PreparedMaterial::Emitter { radiance } = material {
            return throughput * radiance;
        }
        if bounce == scene.settings().max_bounces {
            break;
        }
        ray = match *material {
            PreparedMaterial::Phong(ref phong) => {
                return throughput
                    * Shading {
                        scene,
                        phong,
                        point: &point,
                        sampler,
                        bounce,
                    }
                    .reflected(rays);
            }
            PreparedMaterial::Mirror { reflectance } => {
                throughput *= reflectance;
                point.ray_along(reflect(point.wo, point.specular_normal()))
            }
            PreparedMaterial::Glass { ior, attenuation } => {
                if !point.front {
                    throughput *= transmittance(attenuation, point.distance + narrowed(start));
                }
                let dimension = Dimension::at(Decision::Boundary, bounce);
                point.ray_along(through_boundary(&point, ior, sampler.next_2d(dimension).x))
            }
            PreparedMaterial::Emitter { .. } => unreachable!("emitters end the path above"),
        };
        rays.bounce += 1;
        start = 0.0;
    }
    Vec3::ZERO
}

/// A distance in the precision of rendering.
#[expect(clippy::cast_possible_truncation, reason = "rendering is f32")]
pub fn narrowed(distance: f64) -> f32 {
    distance as f32
}

/// The direction in which light goes on from a boundary of glass: reflected with the probability that Fresnel's equations give,
/// else refracted. `u`: uniform in `[0, 1)`. The throughput stays: the share chosen cancels its probability.
pub fn through_boundary(point: &SurfacePoint, ior: f32, u: f32) -> Vec3 {
    let normal = point.specular_normal();
    let eta = if point.front { ior } else { 1.0 / ior };
    let boundary = fresnel(normal.dot(point.wo), eta);
    if u < boundary.reflectance {
        reflect(point.wo, normal)
    } else {
        refract(point.wo, normal, eta, boundary.cos_transmitted)
    }
}

/// Share of the hemisphere over `point` in which nothing is near, weighted by the cosine; each channel counts a free direction
/// by what `weight` gives it.
pub fn ambient_occlusion(
    scene: &PreparedScene,
    point: &SurfacePoint,
    (sampler, dimension): (Sampler, Dimension),
    rays: &mut RayCounts,
    weight: impl Fn(Vec3) -> Vec3,
) -> Vec3 {
    let samples = scene.settings().ambient_occlusion.samples;
    let mut sum = Vec3::ZERO;
    for turn in 0..samples {
        let local = warp::cosine_hemisphere(sampler.next_2d_of(dimension, turn, samples));
        let wi = warp::around(point.shading_normal, local);
        // Below the surface itself, where an interpolated normal leans over.
        if !point.is_above(wi) {
            continue;
        }
        rays.ambient_occlusion += 1;
        let ray = point.ray_along(wi * scene.occlusion_radius());
        if !scene.occluded(&ray, 1.0, None) {
            sum += weight(wi);
        }
    }
    sum / samples as f32
}

/// A surface point to be shaded.
struct Shading<'a> {
    scene: &'a PreparedScene,
    phong: &'a Phong,
    point: &'a SurfacePoint,
    sampler: Sampler,
    /// Scattering events before this one.
    bounce: u32,
}

impl Shading<'_> {
    /// All light that the point reflects towards `wo`.
    fn reflected(&self, rays: &mut RayCounts) -> Vec3 {
        if self.phong.is_black() {
            return Vec3::ZERO;
        }
        let mut radiance = self.phong.diffuse * self.ambient(rays);
        if !self.scene.emitters().holds_lights() {
            for (index, light) in (0..).zip(self.scene.lights()) {
                radiance += self.light_from(index, light, rays);
            }
        }
        radiance + self.chosen_light(rays)
    }

    /// Reflected light of what one is chosen from: emitting objects, with as many rays as to a light with area, and lights too
    /// many to sum.
    fn chosen_light(&self, rays: &mut RayCounts) -> Vec3 {
        let emitters = self.scene.emitters();
        if emitters.is_empty() {
            return Vec3::ZERO;
        }
        let mut turns = self.scene.settings().shadow_samples;
        if emitters.holds_lights() {
            turns *= CHOSEN_PER_SHADOW_SAMPLE;
        }
        let at = self.point.receiver();
        let mut sum = Vec3::ZERO;
        for turn in 0..turns {
            let pair = |decision| {
                let dimension = Dimension::at(decision, self.bounce);
                self.sampler.next_2d_of(dimension, turn, turns)
            };
            let Some(chosen) = emitters.choose(&at, pair(Decision::LightChoice)) else {
                continue;
            };
            let lights = self.scene.lights();
            sum += if let Some(index) = chosen.light() {
                let light = &lights[index as usize];
                self.light_from_once(index, light, pair, rays) / chosen.probability
            } else {
                let aim = chosen.aim(lights, at.position, pair(Decision::EmitterPoint));
                self.light_from_sample(None, &aim.sample, rays, |_| 1.0)
            };
        }
        sum / turns as f32
    }

    /// The mean of the background's radiance over the hemisphere, weighted by the cosine and by what is not occluded.
    fn ambient(&self, rays: &mut RayCounts) -> Vec3 {
        let background = self.scene.background();
        if background.is_black() {
            return Vec3::ZERO;
        }
        if !self.scene.settings().ambient_occlusion.enabled {
            return background.mean_over_hemisphere(self.point.shading_normal);
        }
        let dimension = Dimension::at(Decision::AmbientOcclusion, self.bounce);
        ambient_occlusion(
            self.scene,
            self.point,
            (self.sampler, dimension),
            rays,
            |wi| background.radiance(wi),
        )
    }

    fn light_from(&self, index: u32, light: &PreparedLight, rays: &mut RayCounts) -> Vec3 {
        let turns = if self.is_point(light) {
            1
        } else {
            self.scene.settings().shadow_samples
        };
        let mut sum = Vec3::ZERO;
        for turn in 0..turns {
            let pair = |decision| {
                let dimension = Dimension::at(decision, self.bounce).about(index);
                self.sampler.next_2d_of(dimension, turn, turns)
            };
            sum += self.light_from_once(index, light, pair, rays);
        }
        sum / turns as f32
    }

    /// Whether the light shines from one point alone.
    fn is_point(&self, light: &PreparedLight) -> bool {
        !light.has_area() || self.scene.settings().shadows == Shadows::Hard
    }

    /// [`Self::light_from`] by one point of the light, and one direction in which it is looked for where it is near; `pair` gives
    /// the numbers for both.
    fn light_from_once(
        &self,
        index: u32,
        light: &PreparedLight,
        pair: impl Fn(Decision) -> Vec2,
        rays: &mut RayCounts,
    ) -> Vec3 {
        let from = self.point.position;
        if self.is_point(light) {
            return self.light_from_sample(Some(index), &light.center(from), rays, |_| 1.0);
        }
        let sample = light.sample(from, pair(Decision::Light));
        match light {
            PreparedLight::Disk(disk) if disk.is_near(from) => {
                let weight = |wi: Vec3| {
                    let towards = Ray::new(from, sample.position - from);
                    power_heuristic(disk.pdf_solid_angle(&towards, 1.0), self.cosine_pdf(wi))
                };
                self.light_from_sample(Some(index), &sample, rays, weight)
                    + self.looking_for_disk(index, disk, pair(Decision::NearLight), rays)
            }
            _ => self.light_from_sample(Some(index), &sample, rays, |_| 1.0),
        }
    }

    /// Reflected light of one point of a light, times what `weight` says of its direction.
    fn light_from_sample(
        &self,
        light: Option<u32>,
        sample: &LightSample,
        rays: &mut RayCounts,
        weight: impl Fn(Vec3) -> f32,
    ) -> Vec3 {
        // No ray where nothing would be reflected anyway.
        let Some(wi) = (sample.position - self.point.position).try_normalize() else {
            return Vec3::ZERO;
        };
        if sample.irradiance == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let reflected = self.reflected_share(wi);
        if reflected == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let ray = self.point.ray_to(sample.position);
        reflected * sample.irradiance * weight(wi) * self.visible(&ray, light, rays)
    }

    /// Reflected light of a near disk, looked for in a direction of the hemisphere: the other half of
    /// [`Self::light_from_sample`], which is noisy where the light is near.
    fn looking_for_disk(
        &self,
        index: u32,
        disk: &PreparedDisk,
        u: Vec2,
        rays: &mut RayCounts,
    ) -> Vec3 {
        let wi = warp::around(self.point.shading_normal, warp::cosine_hemisphere(u));
        let reflected = self.reflected_share(wi);
        let mut ray = self.point.ray_along(wi);
        let emitted = disk.emitted(wi);
        let Some(t) = disk.intersect(&ray, f32::INFINITY) else {
            return Vec3::ZERO;
        };
        if reflected == Vec3::ZERO || emitted == Vec3::ZERO {
            return Vec3::ZERO;
        }
        let pdf = self.cosine_pdf(wi);
        let weight = power_heuristic(pdf, disk.pdf_solid_angle(&ray, t));
        ray.direction *= t;
        reflected * emitted * (weight / pdf) * self.visible(&ray, Some(index), rays)
    }

    /// What leaves towards `wo` of light from `wi`, per irradiance on a surface that faces it.
    fn reflected_share(&self, wi: Vec3) -> Vec3 {
        let cosine = self.point.cosine(wi);
        if cosine <= 0.0 {
            return Vec3::ZERO;
        }
        let model = self.scene.settings().phong;
        self.phong
            .reflected(model, self.point.shading_normal, self.point.wo, wi, cosine)
    }

    /// Density of cosine-distributed directions about the shading normal.
    fn cosine_pdf(&self, wi: Vec3) -> f32 {
        self.point.shading_normal.dot(wi).max(0.0) / PI
    }

    /// Share of the light that comes through along `ray`, from here to the light where its parameter is 1.
    fn visible(&self, ray: &Ray, light: Option<u32>, rays: &mut RayCounts) -> Vec3 {
        if self.scene.settings().shadows == Shadows::Off {
            return Vec3::ONE;
        }
        rays.shadow += 1;
        if self.scene.has_glass() {
            return self.through_glass(*ray, light);
        }
        if self.scene.occluded(ray, 1.0, light) {
            Vec3::ZERO
        } else {
            Vec3::ONE
        }
    }

    /// [`Self::visible`] where glass may stand in between: it is passed straight, losing what each face reflects and what
    /// the inside absorbs.
    fn through_glass(&self, mut ray: Ray, light: Option<u32>) -> Vec3 {
        let target = ray.at(1.0);
        let mut passed = Vec3::ONE;
        loop {
            if self.scene.disk_occludes(&ray, 1.0, light) {
                return Vec3::ZERO;
            }
            let Some(point) = self.scene.surface_along(&ray, 1.0) else {
                return passed;
            };
            let PreparedMaterial::Glass { ior, attenuation } = *self.scene.material(point.object)
            else {
                return Vec3::ZERO;
            };
            // The ray stays straight, so both faces are met at the angle outside; Fresnel's equations give the way out the
            // same loss as the way in.
            passed *= 1.0 - fresnel(point.shading_normal.dot(point.wo), ior).reflectance;
            if !point.front {
                passed *= transmittance(attenuation, point.distance);
            }
            if passed == Vec3::ZERO {
                return passed;
            }
            ray = point.ray_to(target);
        }
    }
}

/// Weight of a sample taken with density `pdf` where another strategy would have taken it with density `other`.
///
/// Source: Veach, Robust Monte Carlo Methods for Light Transport Simulation, 1997: the power heuristic of exponent 2.
pub fn power_heuristic(pdf: f32, other: f32) -> f32 {
    // As a ratio, so that large densities do not overflow.
    let ratio = other / pdf;
    1.0 / (1.0 + ratio * ratio)
}
