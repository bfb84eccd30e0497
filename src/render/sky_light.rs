//! The light of an image background at a point, for mode `direct`.

use super::ambient_occlusion::Occlusion;
use super::background::ImageBackground;
use super::mis::power_heuristic;
use super::prepare::PreparedScene;
use super::sampler::{Decision, Dimension, Sampler};
use super::stops::Stops;
use super::surface::SurfacePoint;
use super::tally::{NotedRay, RayPurpose, Tally};
use crate::math::{Vec3, warp};

/// The mean of `image`'s radiance over the hemisphere at `point`, weighted by the cosine and by what is not occluded; without occlusion
/// nothing is in the way, and no ray is traced. Not over all of it when stopped.
///
/// Half of the occlusion samples go where the image is bright, half are spread by the cosine, and each is weighted by how
/// likely either half was to take it: the first half finds the sun, the second all that is wide and dim. An odd sample is the
/// image's.
pub fn mean_over_hemisphere(
    scene: &PreparedScene,
    image: &ImageBackground,
    point: &SurfacePoint,
    (sampler, bounce): (Sampler, u32),
    stops: &Stops<'_>,
    tally: &mut impl Tally,
) -> Occlusion {
    let occlusion = scene.settings().ambient_occlusion;
    let by_cosine = occlusion.samples / 2;
    let by_image = occlusion.samples - by_cosine;
    let (cosine_count, image_count) = (by_cosine as f32, by_image as f32);
    tally.note_draws(Decision::AmbientOcclusion, by_cosine);
    tally.note_draws(Decision::Background, by_image);
    let mut is_free = |wi: Vec3| {
        if !occlusion.enabled {
            return true;
        }
        let ray = point.ray_above(wi * scene.occlusion_radius());
        let is_occluded = scene.occluded(&ray, 1.0, None);
        let passed = if is_occluded { Vec3::ZERO } else { Vec3::ONE };
        let noted = || NotedRay::passing(ray, 1.0, passed);
        tally.note(RayPurpose::AmbientOcclusion, noted);
        !is_occluded
    };
    let cosine_pdf = |wi: Vec3| warp::cosine_hemisphere_pdf(Vec3::Z * point.shading_normal.dot(wi));

    let mut sum = Vec3::ZERO;
    let mut free = 0;
    let around_normal = warp::Frame::around(point.shading_normal);
    let numbers = sampler.turns(Dimension::at(Decision::AmbientOcclusion, bounce), by_cosine);
    for turns in stops.parts(by_cosine) {
        for turn in turns {
            let local = warp::cosine_hemisphere(numbers.next_2d(turn));
            let wi = around_normal.world_from_local(local);
            if !is_free(wi) {
                continue;
            }
            free += 1;
            let (radiance, pdf) = image.radiance_and_pdf(wi);
            if radiance == Vec3::ZERO {
                continue;
            }
            let weight = power_heuristic(cosine_count * cosine_pdf(wi), image_count * pdf);
            sum += radiance * (weight / cosine_count);
        }
    }
    let numbers = sampler.turns(Dimension::at(Decision::Background, bounce), by_image);
    for turns in stops.parts(by_image) {
        for turn in turns {
            let Some(sample) = image.sample(numbers.next_2d(turn)) else {
                continue;
            };
            let (wi, pdf) = (sample.direction, sample.pdf_solid_angle);
            let cosine_pdf = cosine_pdf(wi);
            if cosine_pdf <= 0.0 || !is_free(wi) {
                continue;
            }
            let weight = power_heuristic(image_count * pdf, cosine_count * cosine_pdf);
            sum += sample.radiance * (cosine_pdf / pdf * weight / image_count);
        }
    }
    Occlusion {
        free: if by_cosine > 0 {
            free as f32 / cosine_count
        } else {
            1.0
        },
        radiance: sum,
    }
}
