//! What of a light reaches a surface point: rays to it, alone or together, past what is in the way and through glass.

use super::aiming::ShadowRay;
use super::shading::Shading;
use crate::math::{Ray, Vec3};
use crate::render::fresnel::fresnel;
use crate::render::kernel::Kernel;
use crate::render::layers::{ByLobe, Parts};
use crate::render::material::PreparedMaterial;
use crate::render::plan::Feature;
use crate::render::shadow_ray;
use crate::render::specular::Specular;
use crate::render::tally::{NotedRay, RayPurpose, Tally};
use std::hint::black_box;

/// Rays from one point to one light that wait to be traced together.
pub struct ShadowRays {
    directions: [Vec3; Self::MOST],
    lights: [ByLobe; Self::MOST],
    count: usize,
}

impl ShadowRays {
    /// Few, as room for so many is cleared for every light.
    const MOST: usize = 18;

    #[inline]
    pub fn new() -> Self {
        Self {
            directions: [Vec3::ZERO; Self::MOST],
            lights: [ByLobe::default(); Self::MOST],
            count: 0,
        }
    }

    /// Whether there may be no room for what aiming once adds.
    #[inline]
    pub fn is_full(&self) -> bool {
        self.count + 2 > Self::MOST
    }

    #[inline]
    pub fn extend(&mut self, rays: [Option<ShadowRay>; 2]) {
        for ShadowRay { direction, light } in rays.into_iter().flatten() {
            self.directions[self.count] = direction;
            self.lights[self.count] = light;
            self.count += 1;
        }
    }

    /// All of them, directions and lights; leaves none.
    #[inline]
    fn take(&mut self) -> (&[Vec3], &[ByLobe]) {
        let count = std::mem::take(&mut self.count);
        (&self.directions[..count], &self.lights[..count])
    }
}

impl<K: Kernel> Shading<'_, K> {
    /// What `ray` brings, where nothing is in the way but the light number `light`.
    pub fn light_along(&mut self, ray: &ShadowRay, light: Option<u32>) -> ByLobe {
        ray.light * self.visible(&self.point.ray_above(ray.direction), light)
    }

    /// [`Self::light_along`] for all of `shadow_rays`, which are taken out.
    pub fn light_along_all(&mut self, shadow_rays: &mut ShadowRays, light: Option<u32>) -> ByLobe {
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
        let mut media = *self.media;
        let mut faces = 0;
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
            faces += 1;
            if passed == Vec3::ZERO || !self.stops.lets_go_on(faces) {
                return passed;
            }
            ray = point.ray_through_to(target);
        }
    }
}
