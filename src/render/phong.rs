//! The modified Phong BRDF (Lafortune & Willems 1994) with its sampling and density, and the classic Phong term.

use std::f32::consts::PI;

use super::layers::ByLobe;
use crate::math::{DVec3, Vec2, Vec3, color::luminance, robust, warp};
use crate::scene::PhongModel;

/// The Phong reflection models at a surface point. Directions are unit vectors that point away from it. `mirror` is the mirror
/// direction of `wo`.
#[derive(Clone, Copy, Debug)]
pub struct Phong {
    /// Diffuse reflectance.
    pub diffuse: Vec3,
    /// Specular reflectance.
    pub specular: Vec3,
    exponent: f32,
    /// How often the specular lobe is sampled; 0 and 1 where there is nothing to choose.
    specular_share: f32,
}

/// What the modified model does with light from one direction.
#[derive(Clone, Copy, Debug)]
pub struct Response {
    /// Per steradian, without the cosine.
    pub brdf: ByLobe,
    /// Density of [`Phong::sample`] at the direction, per steradian.
    pub pdf_solid_angle: f32,
}

impl Phong {
    /// Reflectances `0..=1` per channel, exponent 0 or more.
    pub fn new(diffuse: DVec3, specular: DVec3, shininess: f64) -> Self {
        let (diffuse, specular) = (diffuse.as_vec3(), specular.as_vec3());
        Self {
            diffuse,
            specular,
            #[expect(clippy::cast_possible_truncation, reason = "rendering is f32")]
            exponent: shininess as f32,
            specular_share: specular_share(diffuse, specular),
        }
    }

    /// The same with another diffuse reflectance.
    pub fn with_diffuse(&self, diffuse: Vec3) -> Self {
        Self {
            diffuse,
            specular_share: specular_share(diffuse, self.specular),
            ..*self
        }
    }

    /// Diffuse plus specular reflectance.
    pub fn albedo(&self) -> Vec3 {
        self.diffuse + self.specular
    }

    /// What stands in for a material that is switched off.
    pub fn grey() -> Self {
        Self::new(DVec3::splat(0.5), DVec3::ZERO, 1.0)
    }

    /// Whether nothing is reflected in any direction.
    pub fn is_black(&self) -> bool {
        self.diffuse == Vec3::ZERO && self.specular == Vec3::ZERO
    }

    /// The share that leaves along `wo`, per steradian, of the irradiance that light from `wi` would give a surface facing it: `f · cos θ`
    /// for the modified model, the whole classic term for the classic one. `mirror`: the mirror direction of `wo`; `cosine`: between `wi`
    /// and the normal, positive.
    pub fn reflected(&self, model: PhongModel, mirror: Vec3, wi: Vec3, cosine: f32) -> ByLobe {
        match model {
            PhongModel::Modified => self.brdf(self.lobe(mirror, wi)) * Vec3::splat(cosine),
            PhongModel::Classic => ByLobe {
                diffuse: self.diffuse * cosine,
                specular: self.specular * self.lobe(mirror, wi),
            },
        }
    }

    /// The modified model for light from `wi`, whose cosine to the normal is `cosine`, 0 or more.
    #[inline]
    pub fn response(&self, mirror: Vec3, wi: Vec3, cosine: f32) -> Response {
        let lobe = self.lobe(mirror, wi);
        let share = self.specular_share;
        let diffuse = if share < 1.0 { cosine / PI } else { 0.0 };
        let specular = warp::power_cosine_pdf(lobe, self.exponent);
        Response {
            brdf: self.brdf(lobe),
            pdf_solid_angle: diffuse * (1.0 - share) + specular * share,
        }
    }

    /// The modified model's BRDF, per steradian, without the cosine, where the lobe has this value.
    fn brdf(&self, lobe: f32) -> ByLobe {
        ByLobe {
            diffuse: self.diffuse / PI,
            specular: self.specular * ((self.exponent + 2.0) / (2.0 * PI) * lobe),
        }
    }

    /// A direction in which light may come from, about in proportion to what it adds; `None` where it would leave below
    /// the surface. `u`: uniform over the unit square.
    ///
    /// The lobe is chosen by a part of `u`, so that the directions of each lobe are as well spread as `u`.
    #[expect(clippy::inline_always, reason = "each form of the code calls it once")]
    #[inline(always)]
    pub fn sample(&self, normal: Vec3, mirror: Vec3, mut u: Vec2) -> Option<Scattered> {
        let share = self.specular_share;
        let wi = if u.x < share {
            u.x /= share;
            warp::around(mirror, warp::power_cosine(u, self.exponent))
        } else {
            u.x = (u.x - share) / (1.0 - share);
            warp::around(normal, warp::cosine_hemisphere(u))
        };
        let wi = wi.normalize();
        let cosine = normal.dot(wi);
        if cosine <= 0.0 {
            return None;
        }
        let Response {
            brdf,
            pdf_solid_angle,
        } = self.response(mirror, wi, cosine);
        (pdf_solid_angle > 0.0).then(|| Scattered {
            wi,
            weight: brdf * Vec3::splat(cosine / pdf_solid_angle),
            pdf_solid_angle,
        })
    }

    /// `cosˢ α`, α between `wi` and `mirror`; 0 where `cos α ≤ 0` and where nothing is specular.
    fn lobe(&self, mirror: Vec3, wi: Vec3) -> f32 {
        if self.specular == Vec3::ZERO {
            return 0.0;
        }
        robust::sharp_power((mirror - wi).length_squared() / 2.0, self.exponent)
    }
}

/// How often the specular lobe of these reflectances is sampled.
fn specular_share(diffuse: Vec3, specular: Vec3) -> f32 {
    let (dull, shiny) = (luminance(diffuse), luminance(specular));
    if shiny > 0.0 {
        shiny / (dull + shiny)
    } else {
        0.0
    }
}

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct Scattered {
    /// Where light may come from; unit.
    pub wi: Vec3,
    /// BRDF times cosine over density, by lobe.
    pub weight: ByLobe,
    /// Density of the direction, per steradian.
    pub pdf_solid_angle: f32,
}

#[cfg(test)]
mod tests {
    use super::super::fresnel::reflect;
    use super::*;

    fn phong(diffuse: f64, specular: f64, shininess: f64) -> Phong {
        Phong::new(DVec3::splat(diffuse), DVec3::splat(specular), shininess)
    }

    /// Unit sphere, orthographic view along −z, light at (3, 4, 5).
    #[test]
    fn sphere_pixels_match_the_published_values() {
        // (x, y), N·L, (R·V)^50
        let rows = [
            ((0.0, 0.0), 0.624_695_05, 6.072_998e-11),
            ((0.3, 0.4), 0.954_096_6, 0.297_144_53),
            ((0.25, 0.33), 0.914_833_9, 0.996_502_3),
        ];
        for ((x, y), n_l, power) in rows {
            let normal = Vec3::new(x, y, (1.0_f32 - x * x - y * y).sqrt());
            let wi = (Vec3::new(3.0, 4.0, 5.0) - normal).normalize();
            let cosine = normal.dot(wi);
            assert!((cosine - n_l).abs() < 1e-6, "N·L {cosine} {n_l}");
            let mirror = reflect(Vec3::Z, normal);
            let red = |phong: Phong, model| phong.reflected(model, mirror, wi, cosine).sum().x;
            let specular = phong(0.0, 1.0, 50.0);
            let classic = red(specular, PhongModel::Classic);
            assert!(
                (classic - power).abs() < 2e-5 * power.max(1e-6),
                "{classic} {power}"
            );
            let modified = red(specular, PhongModel::Modified);
            assert!((modified - power * 52.0 / (2.0 * PI) * n_l).abs() < 2e-5 * modified.max(1e-9));
            let diffuse = phong(0.5, 0.0, 1.0);
            let classic = red(diffuse, PhongModel::Classic);
            assert!((classic - 0.5 * n_l).abs() < 1e-6);
        }
    }

    /// As many as there are values to compute, and none where nothing is specular.
    #[test]
    fn powers_are_taken_for_the_specular_lobe_only() {
        let (mirror, wi) = (Vec3::Z, Vec3::new(0.6, 0.0, 0.8));
        let powers = |phong: Phong| {
            let before = robust::POWERS.get();
            let _ = phong.reflected(PhongModel::Modified, mirror, wi, wi.z);
            let _ = phong.reflected(PhongModel::Classic, mirror, wi, wi.z);
            let _ = phong.response(mirror, wi, wi.z);
            let sampled = phong.sample(Vec3::Z, mirror, Vec2::new(0.3, 0.6));
            assert!(sampled.is_some());
            robust::POWERS.get() - before
        };
        assert_eq!(powers(phong(0.5, 0.0, 9.0)), 0);
        assert_eq!(powers(phong(0.0, 0.5, 9.0)), 4);
        assert_eq!(powers(phong(0.5, 0.5, 9.0)), 4);
    }

    #[test]
    fn the_lobe_ends_at_a_right_angle() {
        let behind = Vec3::new(-0.8, 0.0, 0.6);
        let wo = Vec3::new(-0.8, 0.0, 0.6);
        // cos α = 0.6² − 0.8² < 0.
        let mirror = reflect(wo, Vec3::Z);
        let value = phong(0.0, 1.0, 0.0).reflected(PhongModel::Modified, mirror, behind, 0.6);
        assert_eq!(value.sum(), Vec3::ZERO);
    }
}
