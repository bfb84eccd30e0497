//! How much is near over a point: what darkens the background's light in corners and folds.

use super::prepare::PreparedScene;
use super::sampler::{Decision, Turns};
use super::stops::Stops;
use super::surface::SurfacePoint;
use super::tally::{NotedRay, RayPurpose, Tally};
use crate::accel::Fan;
use crate::math::{Vec3, warp};

const _: () = assert!(Stops::TURNS as usize == Fan::MOST_RAYS, "full fans");

/// What [`ambient_occlusion`] finds.
#[derive(Clone, Copy, Debug)]
pub struct Occlusion {
    /// Share of the hemisphere in which nothing is near, weighted by the cosine.
    pub free: f32,
    /// The cosine-weighted mean of a radiance over the hemisphere, 0 where something is near.
    pub radiance: Vec3,
}

/// Looks for what is near over `point`, not everywhere when stopped; `radiance` is what a free direction gives.
pub fn ambient_occlusion(
    scene: &PreparedScene,
    point: &SurfacePoint,
    turns: &Turns,
    stops: &Stops<'_>,
    tally: &mut impl Tally,
    radiance: impl Fn(Vec3) -> Vec3,
) -> Occlusion {
    let samples = scene.settings().ambient_occlusion.samples;
    let around_normal = warp::Frame::around(point.shading_normal);
    let mut sum = Vec3::ZERO;
    let mut free = 0_u32;
    let mut unit = [Vec3::ZERO; Fan::MOST_RAYS];
    for turns_of_fan in stops.parts(samples) {
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
