//! A path from the eye, followed from surface to surface: what the modes `direct` and `path` share. Which light falls on a surface that
//! scatters, and where the path goes on from there, each mode says itself.

use super::camera::CameraRay;
use super::disks::DiskHit;
use super::kernel::Kernel;
use super::layers::{Beginning, Gathered, Layer};
use super::material::PreparedMaterial;
use super::media::Media;
use super::plan::Feature;
use super::prepare::{PreparedScene, Seen};
use super::sampler::{Decision, Dimension, Sampler};
use super::specular::{Onward, Specular};
use super::stops::Stops;
use super::surface::SurfacePoint;
use super::tally::{NotedRay, RayPurpose, Tally};
use super::texturing::Texturing;
use crate::accel::Hit;
use crate::math::{Ray, Vec3};

/// A path from the eye, and what it has gathered so far.
pub struct EyePath<'a, K: Kernel> {
    scene: &'a PreparedScene,
    stops: &'a Stops<'a>,
    /// Its last part, from the eye or the last surface.
    pub ray: Ray,
    /// What [`Self::ray`] hits, lights aside.
    pub hit: Option<Hit>,
    /// How far from the eye [`Self::ray`] begins; 0 for all but camera rays.
    start: f64,
    /// Scattering events so far.
    pub bounce: u32,
    /// Share of the radiance against [`Self::ray`] that arrives at the eye, divided by the probability of the path.
    pub throughput: Vec3,
    pub beginning: Beginning,
    /// The glass that [`Self::ray`] is in.
    pub media: Media,
    pub texturing: K::Texturing,
    pub gathered: Gathered<K::Parts>,
}

#[expect(
    clippy::inline_always,
    reason = "a single call that takes the path would keep all of it in memory, where it is followed in registers: 1 % of the time"
)]
impl<'a, K: Kernel> EyePath<'a, K> {
    /// The path that begins with `camera_ray`, which makes that `hit`.
    #[inline(always)]
    pub fn new(
        scene: &'a PreparedScene,
        camera_ray: CameraRay,
        hit: Option<Hit>,
        stops: &'a Stops<'a>,
    ) -> Self {
        let texturing = K::Texturing::from_eye(scene, &camera_ray);
        let CameraRay { ray, start } = camera_ray;
        Self {
            scene,
            stops,
            ray,
            hit,
            start,
            bounce: 0,
            throughput: Vec3::ONE,
            beginning: Beginning::Eye,
            media: scene.media_at_eye(),
            texturing,
            gathered: Gathered::nothing(),
        }
    }

    /// What it meets, lights included.
    #[inline(always)]
    pub fn seen(&self) -> Seen<'a> {
        self.scene.seen(&self.ray, self.hit)
    }

    /// Adds the background's `radiance`, which it meets. `weight`: that of MIS for light met by chance, 1 where no surface could have
    /// aimed at it instead.
    #[inline(always)]
    pub fn meet_background(&mut self, radiance: Vec3, weight: f32) {
        let radiance = self.throughput * radiance * weight;
        self.gathered.add_background(self.beginning, radiance);
    }

    /// Adds the light of a disk that it meets; `weight` as for [`Self::meet_background`].
    #[inline(always)]
    pub fn meet_disk(&mut self, met: &DiskHit<'_>, weight: f32) {
        let ray = &self.ray;
        let passed = self
            .media
            .transmittance_along(self.scene, ray, met.t, self.start);
        let radiance = met.disk.emitted(ray.direction) * passed;
        self.meet_emitter(radiance, weight);
    }

    /// Adds the `radiance` of an emitter that it meets; `weight` as for [`Self::meet_background`].
    #[inline(always)]
    pub fn meet_emitter(&mut self, radiance: Vec3, weight: f32) {
        let radiance = self.throughput * radiance * weight;
        self.gathered.add_light(self.beginning, radiance);
    }

    /// Leaves out what is absorbed on the way to `point`, which it meets.
    #[inline(always)]
    pub fn absorb(&mut self, point: &SurfacePoint) {
        if self.scene.absorbs() {
            self.throughput *= self.media.transmittance_from(self.scene, point, self.start);
        }
    }

    /// Ends it where no bounce is left for the surface of this `material` that it meets; whether that is so.
    #[inline(always)]
    pub fn end_if_spent(&mut self, material: &PreparedMaterial) -> bool {
        let is_spent = self.bounce == self.scene.settings().max_bounces;
        if is_spent {
            self.gathered.is_depth_limited =
                self.throughput != Vec3::ZERO && material.albedo() != Vec3::ZERO;
        }
        is_spent
    }

    /// Turns to where a mirror or glass sends light on from `point`.
    #[inline(always)]
    pub fn deflect(
        &mut self,
        specular: &Specular,
        point: &SurfacePoint,
        sampler: &Sampler,
        tally: &mut K::Tally,
    ) -> Onward {
        let dimension = Dimension::at(Decision::Boundary, self.bounce);
        let onward = specular.onward(point, || tally.draw_1d(sampler, dimension));
        self.texturing.deflect(point);
        self.throughput *= onward.throughput;
        if onward.layer == Layer::Refraction {
            self.media.cross(point);
        }
        self.beginning = self.beginning.then_specular(onward.layer);
        self.ray = onward.ray;
        onward
    }

    /// Traces [`Self::ray`], which has left a surface; `false` where the path ends instead, or is stopped. The last ray is there for what
    /// shines alone.
    #[inline(always)]
    pub fn go_on(&mut self, tally: &mut K::Tally) -> bool {
        let scene = self.scene;
        self.bounce += 1;
        if !self.stops.lets_go_on(self.bounce) {
            return false;
        }
        if self.bounce == scene.settings().max_bounces
            && !scene.may_meet_light(&self.ray)
            && !scene.does(Feature::DarkRays)
        {
            self.gathered.is_depth_limited = true;
            return false;
        }
        self.start = 0.0;
        self.hit = scene.hit(&self.ray);
        tally.note(RayPurpose::Bounce, || NotedRay::nearest(self.ray, self.hit));
        true
    }
}
