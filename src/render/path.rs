//! The `path` mode: all light, by paths from the eye that aim at a light at every surface and also see the lights they meet;
//! both ways of finding a light are weighted by how likely each was.
//!
//! Source: Veach, Robust Monte Carlo Methods for Light Transport Simulation, 1997; the loop follows the shape that Pharr et al.,
//! Physically Based Rendering (4th ed.), teach.

use super::aim::{self, Aimed};
use super::camera::CameraRay;
use super::kernel::Kernel;
use super::layers::{Beginning, ByLobe, Gathered, Layer, Parts};
use super::light_tree::Receiver;
use super::material::PreparedMaterial;
use super::media::Media;
use super::mis::power_heuristic;
use super::phong::Phong;
use super::plan::Feature;
use super::prepare::{PreparedScene, Seen};
use super::sampler::{Decision, Dimension, Sampler};
use super::surface::SurfacePoint;
use super::tally::{NotedRay, RayPurpose, Tally};
use super::texturing::Texturing;
use crate::accel::Hit;
use crate::math::{Vec2, Vec3};
use crate::scene::{LightSampling, RenderSettings};
use std::borrow::Borrow;
use std::hint::black_box;

/// Scattering events before roulette may end a path.
pub(super) const ROULETTE_FROM: u32 = 4;
/// What a path must carry to be left alone; one that carries less goes on as often as its share of this, and then carries this. So
/// rays are saved where they bring little, no path that brings much is lost early, and no path ever carries more than its surfaces
/// reflect: ending some that carry much would make the rest of them carry more at every bounce, without bound where an albedo is
/// near 1. Where nothing is absorbed, paths end by `max_bounces`.
const ENOUGH: f32 = 0.5;

/// The light that arrives against `ray`, a camera ray that makes that `hit`.
#[expect(
    clippy::too_many_lines,
    reason = "one loop, to be read from top to bottom"
)]
pub fn gather<K: Kernel>(
    scene: &PreparedScene,
    camera_ray: CameraRay,
    mut hit: Option<Hit>,
    sampler: Sampler,
    tally: &mut K::Tally,
) -> Gathered<K::Parts> {
    let mut texturing = K::Texturing::from_eye(scene, &camera_ray);
    let CameraRay { mut ray, mut start } = camera_ray;
    let settings = scene.settings();
    let mut gathered = Gathered::<K::Parts>::nothing();
    let mut beginning = Beginning::Eye;
    let mut throughput = Vec3::ONE;
    let mut media = scene.media_at_eye();
    // How much denser radiance is where the path is than at the eye.
    let mut concentration = 1.0;
    // Density of the last scattered direction, and where light was aimed at instead; `None` where none could be: from the eye, a
    // mirror, glass.
    let mut scattered: Option<(f32, Receiver)> = None;

    for bounce in 0.. {
        // Emission met along the way.
        let mut point = match scene.seen(&ray, hit) {
            Seen::Background => {
                let (radiance, pdf) = aim::background_along(scene, ray.direction.normalize());
                let weight =
                    pdf.map_or(1.0, |pdf| met_weight(settings, scattered.as_ref(), |_| pdf));
                gathered.add_background(beginning, throughput * radiance * weight);
                break;
            }
            Seen::Disk(met) => {
                let aimed = |from: &Receiver| aim::pdf_of_disk(scene, from, &ray, &met);
                let weight = met_weight(settings, scattered.as_ref(), aimed);
                let radiance = met.disk.emitted(ray.direction)
                    * media.transmittance_along(scene, &ray, met.t, start);
                gathered.add_light(beginning, throughput * radiance * weight);
                break;
            }
            Seen::Surface(point) => point,
        };
        if scene.absorbs() {
            throughput *= media.transmittance_from(scene, &point, start);
        }
        let material = scene.material(point.object);
        if let PreparedMaterial::Emitter { radiance } = *material {
            let aimed = |from: &Receiver| aim::pdf_of_object(scene, from, &ray, &point);
            let weight = met_weight(settings, scattered.as_ref(), aimed);
            gathered.add_light(beginning, throughput * radiance * weight);
            break;
        }
        if bounce == settings.max_bounces {
            gathered.is_depth_limited = throughput != Vec3::ZERO && material.albedo() != Vec3::ZERO;
            break;
        }

        // The next direction, after aiming at a light where that is possible.
        match material {
            PreparedMaterial::Phong(phong) => {
                let phong = texturing.at(scene, phong, &mut point, hit.as_ref());
                let phong: &Phong = phong.borrow();
                if phong.is_black() && !scene.does(Feature::DarkRays) {
                    break;
                }
                let mirror = point.mirror_direction();
                let aiming = Aiming {
                    scene,
                    phong,
                    point: &point,
                    media: &media,
                    mirror,
                };
                if scene.does(Feature::Aiming)
                    && let Some(lit) = aiming.reflected((sampler, bounce), tally)
                {
                    lit.add_to(&mut gathered, beginning, throughput);
                }
                // A ray that scatters no more is there for the light it meets alone.
                if bounce + 1 == settings.max_bounces && !scene.does(Feature::LastRays) {
                    gathered.is_depth_limited = throughput * phong.albedo() != Vec3::ZERO;
                    break;
                }
                let direction = tally.draw_2d(&sampler, Dimension::at(Decision::Direction, bounce));
                let Some(sample) = phong.sample(point.shading_normal, mirror, direction) else {
                    break;
                };
                throughput *= sample.weight.sum();
                scattered = Some((sample.pdf_solid_angle, point.receiver()));
                beginning = beginning.then_scattered(sample.weight);
                ray = point.ray_above(sample.wi);
                texturing.scatter();
            }
            PreparedMaterial::Specular(specular) => {
                let u = || tally.draw_1d(&sampler, Dimension::at(Decision::Boundary, bounce));
                let onward = specular.onward(&point, u);
                texturing.deflect(&point);
                throughput *= onward.throughput;
                concentration *= onward.concentration;
                scattered = None;
                if onward.layer == Layer::Refraction {
                    media.cross(&point);
                }
                beginning = beginning.then_specular(onward.layer);
                ray = onward.ray;
            }
            PreparedMaterial::Emitter { .. } => unreachable!("emitters end the path above"),
        }

        if bounce + 1 >= ROULETTE_FROM && scene.does(Feature::Roulette) {
            let u = || tally.draw_1d(&sampler, Dimension::at(Decision::Roulette, bounce));
            let carried = throughput.max_element() * concentration;
            let Some(divisor) = after_roulette(scene, carried, u) else {
                break;
            };
            throughput /= divisor;
        }
        if throughput == Vec3::ZERO {
            break;
        }
        if bounce + 1 == settings.max_bounces
            && !scene.may_meet_light(&ray)
            && !scene.does(Feature::DarkRays)
        {
            gathered.is_depth_limited = true;
            break;
        }
        start = 0.0;
        hit = scene.hit(&ray);
        tally.note(RayPurpose::Bounce, || NotedRay::nearest(ray, hit));
    }
    gathered
}

/// What to divide the throughput by where a path goes on that `carried` this much; `None` where it ends. Paths that carry little end at
/// random, and the rest carry more for them. `carried` is counted as at the eye: inside glass, radiance is concentrated. `u`: uniform in
/// `[0, 1)`.
fn after_roulette(scene: &PreparedScene, carried: f32, u: impl FnOnce() -> f32) -> Option<f32> {
    let survival = carried / ENOUGH;
    if survival >= 1.0 {
        return Some(1.0);
    }
    let u = u();
    if !scene.needs(Feature::Roulette) {
        black_box(u);
        return Some(1.0);
    }
    (u < survival).then_some(survival)
}

/// Weight of light that a path meets. `scattered`: the density of its last direction and the point it left; `aimed_pdf`: how likely that
/// point was to aim at the same light instead.
fn met_weight(
    settings: &RenderSettings,
    scattered: Option<&(f32, Receiver)>,
    aimed_pdf: impl FnOnce(&Receiver) -> f32,
) -> f32 {
    match (scattered, settings.light_sampling) {
        (None, _) | (_, LightSampling::Bsdf) => 1.0,
        (_, LightSampling::Nee) => 0.0,
        (Some((pdf, from)), LightSampling::Mis) => power_heuristic(*pdf, aimed_pdf(from)),
    }
}

/// A surface point that aims at lights.
struct Aiming<'a> {
    scene: &'a PreparedScene,
    phong: &'a Phong,
    point: &'a SurfacePoint,
    /// What it is in.
    media: &'a Media,
    /// The mirror direction of `wo`.
    mirror: Vec3,
}

/// What came of aiming at a light.
struct Lit {
    /// Reflected towards `wo`, divided by the probability of the choice.
    lobes: ByLobe,
    /// Share of the light that came through.
    passed: Vec3,
    /// Whether the light is the background.
    is_background: bool,
}

impl Lit {
    /// Adds it to what a path with this `beginning` and `throughput` has gathered.
    fn add_to<P: Parts>(&self, gathered: &mut Gathered<P>, beginning: Beginning, throughput: Vec3) {
        let lobes = self.lobes * throughput;
        if self.is_background {
            gathered.add_ambient(beginning, lobes.sum());
        } else {
            gathered.add_reflected(beginning, lobes);
        }
        if beginning.has_not_scattered() {
            gathered.parts.count_shadow_ray(self.passed);
        }
    }
}

impl Aiming<'_> {
    /// Aims at one light; `None` where no ray was needed to know that it adds nothing.
    #[expect(clippy::inline_always, reason = "each form of the code calls it once")]
    #[inline(always)]
    fn reflected(&self, (sampler, bounce): (Sampler, u32), tally: &mut impl Tally) -> Option<Lit> {
        let Self {
            scene,
            phong,
            point,
            media,
            mirror,
        } = *self;
        let u = if scene.does(Feature::LightPoints) {
            tally.draw_2d(&sampler, Dimension::at(Decision::Light, bounce))
        } else {
            // It decides nothing.
            Vec2::splat(0.5)
        };
        let choice = || tally.draw_2d(&sampler, Dimension::at(Decision::LightChoice, bounce));
        let aimed = Aimed::choose(scene, point, choice, u)?;
        if aimed.irradiance == Vec3::ZERO {
            return self.nothing(&aimed, tally);
        }
        let cosine = point.cosine(aimed.wi);
        if cosine <= 0.0 {
            return self.nothing(&aimed, tally);
        }
        let response = phong.response(mirror, aimed.wi, cosine);
        let weight = match (aimed.pdf_solid_angle, scene.settings().light_sampling) {
            (None, _) | (_, LightSampling::Nee) => 1.0,
            (_, LightSampling::Bsdf) => return self.nothing(&aimed, tally),
            (Some(pdf), LightSampling::Mis) => power_heuristic(pdf, response.pdf_solid_angle),
        };
        let reflected = response.brdf * Vec3::splat(cosine);
        if reflected.sum() == Vec3::ZERO {
            return self.nothing(&aimed, tally);
        }
        let is_occluded = scene.occluded(&aimed.ray, aimed.reach, aimed.light);
        let passed = if is_occluded { Vec3::ZERO } else { Vec3::ONE };
        let noted = || NotedRay::passing(aimed.ray, aimed.reach, passed);
        tally.note(RayPurpose::Shadow, noted);
        let mut irradiance = aimed.irradiance * weight * passed;
        if scene.absorbs() {
            // What is behind glass is not aimed at: all of the way is in what the point is in.
            irradiance *= media.transmittance_along(scene, &aimed.ray, aimed.reach, 0.0);
        }
        Some(Lit {
            lobes: reflected * irradiance,
            passed,
            is_background: aimed.is_background,
        })
    }

    /// The result of aiming where nothing can come of it: no ray is needed.
    #[inline]
    fn nothing(&self, aimed: &Aimed, tally: &mut impl Tally) -> Option<Lit> {
        if self.scene.does(Feature::DarkRays) {
            let (scene, ray, reach) = (self.scene, aimed.ray, aimed.reach);
            let is_occluded = black_box(scene.occluded(&ray, reach, aimed.light));
            let passed = if is_occluded { Vec3::ZERO } else { Vec3::ONE };
            tally.note(RayPurpose::Shadow, || NotedRay::passing(ray, reach, passed));
        }
        None
    }
}
