//! What rays in a prepared scene meet: surfaces, visible lights or the background, and whether anything is in their way.

use super::PreparedScene;
use crate::accel::{Fan, Hit};
use crate::math::{Ray, Vec3};
use crate::render::disks::DiskHit;
use crate::render::surface::SurfacePoint;

/// What a ray meets first.
pub(in crate::render) enum Seen<'a> {
    Surface(SurfacePoint),
    Disk(DiskHit<'a>),
    Background,
}

impl PreparedScene {
    /// What `ray` hits first, lights aside.
    #[inline]
    pub(in crate::render) fn hit(&self, ray: &Ray) -> Option<Hit> {
        self.accelerator().intersect(ray, f32::INFINITY)
    }

    /// What `ray` meets first, lights included. `hit`: what [`Self::hit`] says of it.
    #[inline]
    pub(in crate::render) fn seen(&self, ray: &Ray, hit: Option<Hit>) -> Seen<'_> {
        let disk = self
            .disks
            .nearest(ray, hit.map_or(f32::INFINITY, |hit| hit.t));
        match (disk, hit) {
            (Some(disk), _) => Seen::Disk(disk),
            (None, Some(hit)) => Seen::Surface(self.surface(ray, &hit)),
            (None, None) => Seen::Background,
        }
    }

    /// The point where `ray` makes `hit`.
    #[inline]
    pub(in crate::render) fn surface(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        SurfacePoint::new(&self.geometry, ray, hit)
    }

    /// Whether `ray` may end at something that shines, told without looking for surfaces: `false` is certain.
    pub(in crate::render) fn may_meet_light(&self, ray: &Ray) -> bool {
        self.has_shining_surroundings || self.disks.nearest(ray, f32::INFINITY).is_some()
    }

    /// The surface that `ray` meets first in `0 < t < t_max`, lights aside.
    #[must_use]
    pub fn surface_along(&self, ray: &Ray, t_max: f32) -> Option<SurfacePoint> {
        let hit = self.accelerator().intersect(ray, t_max)?;
        Some(self.surface(ray, &hit))
    }

    /// Whether anything but the light number `except` is in the way in `0 < t < t_max`.
    pub(in crate::render) fn occluded(&self, ray: &Ray, t_max: f32, except: Option<u32>) -> bool {
        self.disk_occludes(ray, t_max, except) || self.accelerator().occluded(ray, t_max)
    }

    /// Along which rays of `fan` anything but the light number `except` is in the way, as bits.
    pub(in crate::render) fn occluded_fan(&self, fan: &Fan<'_>, except: Option<u32>) -> u64 {
        self.disks.occlude_fan(fan, except) | self.accelerator().occluded_fan(fan)
    }

    /// Along which of the directions from `point` (unit, at most [`Fan::MOST_RAYS`]) anything is within the radius of ambient
    /// occlusion, as bits.
    pub(in crate::render) fn near_things(&self, point: &SurfacePoint, directions: &[Vec3]) -> u64 {
        let mut scaled = [Vec3::ZERO; Fan::MOST_RAYS];
        for (scaled, &direction) in scaled.iter_mut().zip(directions) {
            *scaled = direction * self.occlusion_radius;
        }
        self.occluded_fan(&point.fan(&scaled[..directions.len()]), None)
    }

    /// Whether a visible disk other than the light number `except` is in the way in `0 < t < t_max`.
    pub(in crate::render) fn disk_occludes(
        &self,
        ray: &Ray,
        t_max: f32,
        except: Option<u32>,
    ) -> bool {
        self.disks.occlude(ray, t_max, except)
    }
}
