//! Aiming at a point of a light, and looking for a light that is near: two ways to find the same, weighted by how likely each was.

use super::shading::Shading;
use crate::math::{Ray, Vec2, Vec3, warp};
use crate::render::kernel::Kernel;
use crate::render::layers::ByLobe;
use crate::render::light::{LightSample, PreparedDisk, PreparedLight};
use crate::render::mis::power_heuristic;
use crate::render::plan::Feature;
use crate::render::sampler::{Decision, Turns};
use crate::render::shadow_ray;
use crate::render::tally::Tally;
use crate::scene::Shadows;
use std::hint::black_box;

/// A ray from a surface point to a light, and what it brings where nothing is in the way.
#[derive(Clone, Copy)]
pub struct ShadowRay {
    /// As far as the light.
    pub direction: Vec3,
    pub light: ByLobe,
}

/// The random numbers for lights with area.
pub struct LightNumbers {
    /// For points on them.
    points: Turns,
    /// For directions in which near ones are looked for.
    directions: Turns,
}

impl LightNumbers {
    pub fn new<K: Kernel>(shading: &Shading<'_, K>, item: u32, count: u32) -> Self {
        Self {
            points: shading.turns(Decision::Light, item, count),
            directions: shading.turns(Decision::NearLight, item, count),
        }
    }
}

impl<K: Kernel> Shading<'_, K> {
    /// Whether the light shines from one point alone.
    pub fn is_point(&self, light: &PreparedLight) -> bool {
        !light.has_area() || self.scene.settings().shadows == Shadows::Hard
    }

    /// Aims at one point of the light and, where the light is near, also looks for it in one direction of the hemisphere.
    pub fn aim(
        &mut self,
        light: &PreparedLight,
        numbers: Option<&LightNumbers>,
        turn: u32,
    ) -> [Option<ShadowRay>; 2] {
        let from = self.point.shading_position;
        let point = numbers.map(|numbers| numbers.points.next_2d(turn));
        self.tally
            .note_draws(Decision::Light, u32::from(point.is_some()));
        let (Some(numbers), Some(point), false) = (numbers, point, self.is_point(light)) else {
            black_box(point);
            return [self.aim_at_sample(&light.center(from), |_| 1.0), None];
        };
        let sample = light.sample(from, point);
        if self.scene.settings().shadows == Shadows::Fraction {
            let ray = self.center_by_place(&light.center(from), sample.position);
            return [ray, None];
        }
        match light {
            PreparedLight::Disk(disk) if disk.is_near(from) => {
                let normal = self.point.shading_normal;
                let weight = |wi: Vec3| {
                    let towards = Ray::new(from, sample.position - from);
                    power_heuristic(
                        disk.pdf_solid_angle(&towards, 1.0),
                        warp::cosine_pdf_around(normal, wi),
                    )
                };
                self.tally.note_draws(Decision::NearLight, 1);
                let looked_for = self.look_for_disk(disk, numbers.directions.next_2d(turn));
                [self.aim_at_sample(&sample, weight), looked_for]
            }
            _ => [self.aim_at_sample(&sample, |_| 1.0), None],
        }
    }

    /// The rule of 2011: what the light's `center` would give, where `place` on the light is seen. Its mean is the light of the
    /// centre times the share of the light that is seen.
    fn center_by_place(&mut self, center: &LightSample, place: Vec3) -> Option<ShadowRay> {
        let wi = (center.position - self.point.shading_position).try_normalize()?;
        let reflected = self.reflected_share(wi);
        if reflected.sum() == Vec3::ZERO || center.irradiance == Vec3::ZERO {
            return self.nothing(place);
        }
        Some(ShadowRay {
            direction: self.point.ray_to(place).direction,
            light: reflected * center.irradiance,
        })
    }

    /// Reflected light of one point of a light, times what `weight` says of its direction.
    pub fn aim_at_sample(
        &mut self,
        sample: &LightSample,
        weight: impl Fn(Vec3) -> f32,
    ) -> Option<ShadowRay> {
        // No ray where nothing would be reflected anyway.
        let wi = (sample.position - self.point.shading_position).try_normalize()?;
        if sample.irradiance == Vec3::ZERO {
            return self.nothing(sample.position);
        }
        let reflected = self.reflected_share(wi);
        if reflected.sum() == Vec3::ZERO {
            return self.nothing(sample.position);
        }
        Some(ShadowRay {
            direction: self.point.ray_to(sample.position).direction,
            light: reflected * (sample.irradiance * weight(wi)),
        })
    }

    /// The result of aiming at a `place` that can bring nothing: no ray is needed.
    fn nothing(&mut self, place: Vec3) -> Option<ShadowRay> {
        if self.scene.does(Feature::DarkRays) {
            let ray = self.point.ray_to(place);
            black_box(shadow_ray::passed(self.scene, ray, 1.0, None, self.tally));
        }
        None
    }

    /// Reflected light of a near disk, looked for in a direction of the hemisphere: the other half of
    /// [`Self::aim_at_sample`], which is noisy where the light is near.
    fn look_for_disk(&self, disk: &PreparedDisk, u: Vec2) -> Option<ShadowRay> {
        let normal = self.point.shading_normal;
        let wi = warp::around(normal, warp::cosine_hemisphere(u));
        let reflected = self.reflected_share(wi);
        let ray = self.point.ray_above(wi);
        let emitted = disk.emitted(wi);
        let t = disk.intersect(&ray, f32::INFINITY)?;
        if reflected.sum() == Vec3::ZERO || emitted == Vec3::ZERO {
            return None;
        }
        let pdf = warp::cosine_pdf_around(normal, wi);
        let weight = power_heuristic(pdf, disk.pdf_solid_angle(&ray, t));
        let ray = self.point.ray_to(disk.in_front(ray.at(t), ray.origin));
        Some(ShadowRay {
            direction: ray.direction,
            light: reflected * (emitted * (weight / pdf)),
        })
    }

    /// What leaves towards `wo` of light from `wi`, per irradiance on a surface that faces it.
    fn reflected_share(&self, wi: Vec3) -> ByLobe {
        let cosine = self.point.cosine(wi);
        if cosine <= 0.0 {
            return ByLobe::default();
        }
        let model = self.scene.settings().phong;
        self.phong.reflected(model, self.mirror, wi, cosine)
    }
}
