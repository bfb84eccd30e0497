//! A ray that asks whether anything is in the way of light, in both modes that have light.

use super::prepare::PreparedScene;
use super::tally::{NotedRay, RayPurpose, Tally};
use crate::math::{Ray, Vec3};

/// Share of the light that passes along `ray` up to its parameter `reach`: all of it, or nothing where anything but the light number
/// `except` is in the way.
#[inline]
pub fn passed(
    scene: &PreparedScene,
    ray: Ray,
    reach: f32,
    except: Option<u32>,
    tally: &mut impl Tally,
) -> Vec3 {
    let is_occluded = scene.occluded(&ray, reach, except);
    let passed = if is_occluded { Vec3::ZERO } else { Vec3::ONE };
    tally.note(RayPurpose::Shadow, || NotedRay::passing(ray, reach, passed));
    passed
}
