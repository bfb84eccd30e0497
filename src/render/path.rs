//! The `path` mode: all light, by paths from the eye that aim at a light at every surface and also see the lights they meet;
//! both ways of finding a light are weighted by how likely each was.
//!
//! Source: Veach, Robust Monte Carlo Methods for Light Transport Simulation, 1997; the loop follows the shape that Pharr et al.,
//! Physically Based Rendering (4th ed.), teach.

use super::aim::{self, Aimed};
use super::camera::CameraRay;
use super::eye_path::EyePath;
use super::kernel::Kernel;
use super::layers::{Beginning, ByLobe, Gathered, Parts};
use super::light_tree::Receiver;
use super::material::PreparedMaterial;
use super::media::Media;
use super::mis::power_heuristic;
use super::phong::Phong;
use super::plan::Feature;
use super::prepare::{PreparedScene, Seen};
use super::sampler::{Decision, Dimension, Sampler};
use super::shadow_ray;
use super::stops::Stops;
use super::surface::SurfacePoint;
use super::tally::Tally;
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

/// The light that arrives against `camera_ray`, which makes that `hit`; not all of it when stopped.
pub fn gather<K: Kernel>(
    scene: &PreparedScene,
    camera_ray: CameraRay,
    hit: Option<Hit>,
    sampler: Sampler,
    stops: &Stops<'_>,
    tally: &mut K::Tally,
) -> Gathered<K::Parts> {
    let settings = scene.settings();
    let mut path = EyePath::<K>::new(scene, camera_ray, hit, stops);
    // How much denser radiance is where the path is than at the eye.
    let mut concentration = 1.0;
    // Density of the last scattered direction, and where light was aimed at instead; `None` where none could be: from the eye, a
    // mirror, glass.
    let mut scattered: Option<(f32, Receiver)> = None;

    loop {
        // Emission met along the way.
        let mut point = match path.seen() {
            Seen::Background => {
                let direction = path.ray.direction.normalize();
                let (radiance, pdf) = aim::background_along(scene, direction);
                let weight =
                    pdf.map_or(1.0, |pdf| met_weight(settings, scattered.as_ref(), |_| pdf));
                path.meet_background(radiance, weight);
                break;
            }
            Seen::Disk(met) => {
                let aimed = |from: &Receiver| aim::pdf_of_disk(scene, from, &path.ray, &met);
                let weight = met_weight(settings, scattered.as_ref(), aimed);
                path.meet_disk(&met, weight);
                break;
            }
            Seen::Surface(point) => point,
        };
        path.absorb(&point);
        let material = scene.material(point.object);
        if let PreparedMaterial::Emitter { radiance } = *material {
            let aimed = |from: &Receiver| aim::pdf_of_object(scene, from, &path.ray, &point);
            let weight = met_weight(settings, scattered.as_ref(), aimed);
            path.meet_emitter(radiance, weight);
            break;
        }
        if path.end_if_spent(material) {
            break;
        }

        // The next direction, after aiming at a light where that is possible.
        match material {
            PreparedMaterial::Phong(phong) => {
                let hit = path.hit.as_ref();
                let phong = path.texturing.at(scene, phong, &mut point, hit);
                let phong: &Phong = phong.borrow();
                if phong.is_black() && !scene.does(Feature::DarkRays) {
                    break;
                }
                let mirror = point.mirror_direction();
                let aiming = Aiming {
                    scene,
                    phong,
                    point: &point,
                    media: &path.media,
                    mirror,
                };
                if scene.does(Feature::Aiming)
                    && let Some(lit) = aiming.reflected((sampler, path.bounce), tally)
                {
                    lit.add_to(&mut path.gathered, path.beginning, path.throughput);
                }
                // A ray that scatters no more is there for the light it meets alone.
                if path.bounce + 1 == settings.max_bounces && !scene.does(Feature::LastRays) {
                    path.gathered.is_depth_limited = path.throughput * phong.albedo() != Vec3::ZERO;
                    break;
                }
                let dimension = Dimension::at(Decision::Direction, path.bounce);
                let direction = tally.draw_2d(&sampler, dimension);
                let Some(sample) = phong.sample(point.shading_normal, mirror, direction) else {
                    break;
                };
                path.throughput *= sample.weight.sum();
                scattered = Some((sample.pdf_solid_angle, point.receiver()));
                path.beginning = path.beginning.then_scattered(sample.weight);
                path.ray = point.ray_above(sample.wi);
                path.texturing.scatter();
            }
            PreparedMaterial::Specular(specular) => {
                let onward = path.deflect(specular, &point, &sampler, tally);
                concentration *= onward.concentration;
                scattered = None;
            }
            PreparedMaterial::Emitter { .. } => unreachable!("emitters end the path above"),
        }

        if path.bounce + 1 >= ROULETTE_FROM && scene.does(Feature::Roulette) {
            let u = || tally.draw_1d(&sampler, Dimension::at(Decision::Roulette, path.bounce));
            let carried = path.throughput.max_element() * concentration;
            let Some(divisor) = after_roulette(scene, carried, u) else {
                break;
            };
            path.throughput /= divisor;
        }
        if path.throughput == Vec3::ZERO {
            break;
        }
        if !path.go_on(tally) {
            break;
        }
    }
    path.gathered
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
        let passed = shadow_ray::passed(scene, aimed.ray, aimed.reach, aimed.light, tally);
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
            let &Aimed { ray, reach, .. } = aimed;
            black_box(shadow_ray::passed(
                self.scene,
                ray,
                reach,
                aimed.light,
                tally,
            ));
        }
        None
    }
}
