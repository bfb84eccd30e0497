//! The `path` mode: all light, by paths from the eye that aim at a light at every surface and also see the lights they meet;
//! both ways of finding a light are weighted by how likely each was.
//!
//! Source: Veach, Robust Monte Carlo Methods for Light Transport Simulation, 1997; the loop follows the shape that Pharr et al.,
//! Physically Based Rendering (4th ed.), teach.

use super::camera::CameraRay;
use super::direct::{narrowed, power_heuristic, through_boundary};
use super::disks::DiskHit;
use super::fresnel::reflect;
use super::light_tree::Receiver;
use super::material::{PreparedMaterial, transmittance};
use super::phong::Phong;
use super::prepare::{PreparedScene, Seen};
use super::run::RayCounts;
use super::sampler::{Decision, Dimension, Sampler};
use super::surface::SurfacePoint;
use crate::math::Vec3;
use crate::scene::LightSampling;

/// Scattering events before roulette may end a path.
const ROULETTE_FROM: u32 = 4;
/// The most likely a path goes on under roulette, so that it ends even where nothing is absorbed.
const MOST_SURVIVAL: f32 = 0.95;

/// Radiance that arrives against `ray`, a camera ray.
pub fn radiance(
    scene: &PreparedScene,
    CameraRay { mut ray, mut start }: CameraRay,
    sampler: Sampler,
    rays: &mut RayCounts,
) -> Vec3 {
    let settings = scene.settings();
    let mut radiance = Vec3::ZERO;
    let mut throughput = Vec3::ONE;
    // Density of the last scattered direction, and where light was aimed at instead; `None` where none could be: from the eye, a
    // mirror, glass.
    let mut scattered: Option<(f32, Receiver)> = None;

    for bounce in 0.. {
        // Emission met along the way.
        let weight =
            |aimed_pdf: &dyn Fn(&Receiver) -> f32| match (&scattered, settings.light_sampling) {
                (None, _) | (_, LightSampling::Bsdf) => 1.0,
                (_, LightSampling::Nee) => 0.0,
                (Some((pdf, from)), LightSampling::Mis) => power_heuristic(*pdf, aimed_pdf(from)),
            };
        let point = match scene.nearest(&ray) {
            Seen::Background => {
                return radiance
                    + throughput * scene.background().radiance(ray.direction.normalize());
            }
            Seen::Disk(DiskHit { disk, light, t }) => {
                let pdf = |from: &Receiver| {
                    let emitters = scene.emitters();
                    emitters.pdf_of_disk(scene.lights(), from, light, (&ray, t))
                };
                return radiance + throughput * disk.emitted(ray.direction) * weight(&pdf);
            }
            Seen::Surface(point) => point,
        };
        let material = scene.material(point.object);
        if let PreparedMaterial::Emitter { radiance: emitted } = *material {
            let pdf = |from: &Receiver| {
                scene.emitters().pdf_of_object(
                    from,
                    (point.object, point.triangle),
                    point.geometric_normal(),
                    point.position - ray.origin,
                )
            };
            return radiance + throughput * emitted * weight(&pdf);
        }
        if bounce == settings.max_bounces {
            break;
        }

        // The next direction, after aiming at a light where that is possible.
        ray = match *material {
            PreparedMaterial::Phong(ref phong) => {
                radiance += throughput * aimed_light(scene, phong, &point, (sampler, bounce), rays);
                let direction = sampler.next_2d(Dimension::at(Decision::Direction, bounce));
                let lobe = sampler.next_2d(Dimension::at(Decision::Lobe, bounce)).x;
                let Some(sample) = phong.sample(point.shading_normal, point.wo, lobe, direction)
                else {
                    break;
                };
                if !point.is_above(sample.wi) {
                    break;
                }
                throughput *= sample.weight;
                scattered = Some((sample.pdf_solid_angle, point.receiver()));
                point.ray_along(sample.wi)
            }
            PreparedMaterial::Mirror { reflectance } => {
                throughput *= reflectance;
                scattered = None;
                point.ray_along(reflect(point.wo, point.specular_normal()))
            }
            PreparedMaterial::Glass { ior, attenuation } => {
                if !point.front {
                    throughput *= transmittance(attenuation, point.distance + narrowed(start));
                }
                scattered = None;
                let u = sampler.next_2d(Dimension::at(Decision::Boundary, bounce)).x;
                point.ray_along(through_boundary(&point, ior, u))
            }
            PreparedMaterial::Emitter { .. } => unreachable!("emitters end the path above"),
        };

        // Paths that carry little end at random; the rest carry more for them.
        if settings.roulette && bounce + 1 >= ROULETTE_FROM {
            let survival = throughput.max_element().min(MOST_SURVIVAL);
            if sampler.next_2d(Dimension::at(Decision::Roulette, bounce)).x >= survival {
                break;
            }
            throughput /= survival;
        } else if throughput == Vec3::ZERO {
            break;
        }
        rays.bounce += 1;
        start = 0.0;
    }
    radiance
}

/// What `point` reflects towards `wo` of one chosen light, divided by the probability of the choice.
fn aimed_light(
    scene: &PreparedScene,
    phong: &Phong,
    point: &SurfacePoint,
    (sampler, bounce): (Sampler, u32),
    rays: &mut RayCounts,
) -> Vec3 {
    let choice = sampler.next_2d(Dimension::at(Decision::LightChoice, bounce));
    let u = sampler.next_2d(Dimension::at(Decision::Light, bounce));
    let Some(aim) = scene
        .emitters()
        .aim(scene.lights(), &point.receiver(), choice, u)
    else {
        return Vec3::ZERO;
    };
    let Some(wi) = (aim.sample.position - point.position).try_normalize() else {
        return Vec3::ZERO;
    };
    let weight = match (aim.pdf_solid_angle, scene.settings().light_sampling) {
        (None, _) | (_, LightSampling::Nee) => 1.0,
        (_, LightSampling::Bsdf) => return Vec3::ZERO,
        (Some(pdf), LightSampling::Mis) => power_heuristic(
            pdf,
            phong.pdf_solid_angle(point.shading_normal, point.wo, wi),
        ),
    };
    let cosine = point.cosine(wi);
    if cosine <= 0.0 || aim.sample.irradiance == Vec3::ZERO {
        return Vec3::ZERO;
    }
    let reflected = phong.brdf(point.shading_normal, point.wo, wi) * cosine;
    if reflected == Vec3::ZERO {
        return Vec3::ZERO;
    }
    rays.shadow += 1;
    let ray = point.ray_to(aim.sample.position);
    if scene.occluded(&ray, 1.0, aim.light) {
        Vec3::ZERO
    } else {
        reflected * aim.sample.irradiance * weight
    }
}
