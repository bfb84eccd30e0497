//! In mode `path`: what a surface point aims at, the background's image or one of the emitters, and how likely it was to aim at light that
//! a path then meets by chance.

use super::background::ImageBackground;
use super::disks::DiskHit;
use super::light_tree::Receiver;
use super::prepare::PreparedScene;
use super::surface::SurfacePoint;
use crate::math::{Ray, Vec2, Vec3};

/// The least share of either where both give light: power as counted here says little about what one point sees, and neither should starve.
const LEAST_SHARE: f32 = 0.1;

/// How often each of the two is aimed at; the shares sum to 1. Without an image all is left to the emitters.
#[derive(Clone, Copy, Debug)]
pub struct AimShares {
    /// Probability of the background.
    pub background: f32,
    /// Probability of the emitters together.
    pub emitters: f32,
}

/// What is aimed at, and what is left of the number that chose it.
#[derive(Clone, Copy, Debug)]
enum Target {
    Background(f32),
    Emitter(f32),
}

impl AimShares {
    /// Shares in proportion to power. That of the background's image, where there is one to aim at, is what falls from it on the ball of
    /// this `radius` around the scene; that of the emitters is `emitters_power`, all that they emit.
    pub fn new(image: Option<&ImageBackground>, radius: f32, emitters_power: f64) -> Self {
        use std::f64::consts::PI;
        let Some(image) = image else {
            return Self {
                background: 0.0,
                emitters: 1.0,
            };
        };
        let cross_section = PI * f64::from(radius).powi(2);
        let power = cross_section * 4.0 * PI * image.mean_luminance();
        let background = if emitters_power > 0.0 {
            #[expect(clippy::cast_possible_truncation, reason = "a probability")]
            let share = (power / (power + emitters_power)) as f32;
            share.clamp(LEAST_SHARE, 1.0 - LEAST_SHARE)
        } else {
            1.0
        };
        Self {
            background,
            emitters: 1.0 - background,
        }
    }

    /// Chooses by `u`, uniform in `[0, 1)`; what is left of `u` is uniform again.
    fn choose(self, u: f32) -> Target {
        if u < self.background {
            Target::Background(u / self.background)
        } else {
            Target::Emitter((u - self.background) / self.emitters)
        }
    }
}

/// Light aimed at from a point.
#[derive(Clone, Copy, Debug)]
pub struct Aimed {
    /// Where it comes from; unit.
    pub wi: Vec3,
    /// On a surface that faces it, divided by the probability of all choices.
    pub irradiance: Vec3,
    /// Density of its direction with that of the choice, per steradian; `None` where no other strategy can find it.
    pub pdf_solid_angle: Option<f32>,
    /// Towards it; nothing may be in the way before `reach`, but for the light number `light`.
    pub ray: Ray,
    pub reach: f32,
    pub light: Option<u32>,
    /// Whether it is the background's.
    pub is_background: bool,
}

impl Aimed {
    /// Aims at the background or an emitter from `point`; `u`: uniform over the unit square; so is `choice`, for a choice among
    /// very many. `None` where there is nothing to aim at.
    ///
    /// What `u` has left after the choice finds the place to aim at, so that places are as well spread as `u` over all of them.
    #[expect(clippy::inline_always, reason = "each form of the code calls it once")]
    #[inline(always)]
    pub fn choose(
        scene: &PreparedScene,
        point: &SurfacePoint,
        choice: impl FnOnce() -> Vec2,
        u: Vec2,
    ) -> Option<Self> {
        match scene.aim_shares().choose(u.x) {
            Target::Background(rest) => Self::at_background(scene, point, Vec2::new(rest, u.y)),
            Target::Emitter(rest) => Self::at_emitter(scene, point, choice, Vec2::new(rest, u.y)),
        }
    }

    fn at_background(scene: &PreparedScene, point: &SurfacePoint, u: Vec2) -> Option<Self> {
        let sample = scene.background().image()?.sample(u)?;
        let pdf = sample.pdf_solid_angle * scene.aim_shares().background;
        Some(Self {
            wi: sample.direction,
            irradiance: sample.radiance / pdf,
            pdf_solid_angle: Some(pdf),
            ray: point.ray_above(sample.direction),
            reach: f32::INFINITY,
            light: None,
            is_background: true,
        })
    }

    #[expect(clippy::inline_always, reason = "each form of the code calls it once")]
    #[inline(always)]
    fn at_emitter(
        scene: &PreparedScene,
        point: &SurfacePoint,
        choice: impl FnOnce() -> Vec2,
        u: Vec2,
    ) -> Option<Self> {
        let share = scene.aim_shares().emitters;
        let (emitters, lights) = (scene.emitters(), scene.lights());
        let aim = emitters.aim(lights, &point.receiver(), choice, u)?;
        Some(Self {
            wi: aim.sample.wi,
            irradiance: aim.sample.irradiance * share.recip(),
            pdf_solid_angle: aim.pdf_solid_angle.map(|pdf| pdf * share),
            ray: point.ray_to(aim.sample.position),
            reach: 1.0,
            light: aim.light,
            is_background: false,
        })
    }
}

/// Radiance of the background along the unit vector `direction`, and the density with which any point aims there; `None` where
/// the background is not aimed at.
pub fn background_along(scene: &PreparedScene, direction: Vec3) -> (Vec3, Option<f32>) {
    let background = scene.background();
    let Some(image) = background.image() else {
        return (background.radiance(direction), None);
    };
    let (radiance, pdf) = image.radiance_and_pdf(direction);
    (radiance, Some(pdf * scene.aim_shares().background))
}

/// Density with which `from` aims along `ray` at the disk light that it meets, per steradian.
pub fn pdf_of_disk(scene: &PreparedScene, from: &Receiver, ray: &Ray, met: &DiskHit<'_>) -> f32 {
    let (emitters, lights) = (scene.emitters(), scene.lights());
    let pdf = emitters.pdf_of_disk(lights, from, met.light, (ray, met.t));
    pdf * scene.aim_shares().emitters
}

/// Density with which `from` aims along `ray` at the `point` of an emitting object that it meets, per steradian.
pub fn pdf_of_object(
    scene: &PreparedScene,
    from: &Receiver,
    ray: &Ray,
    point: &SurfacePoint,
) -> f32 {
    // What is black is not aimed at.
    if scene.material(point.object).emission() == Some(Vec3::ZERO) {
        return 0.0;
    }
    let pdf = scene.emitters().pdf_of_object(
        from,
        (point.object, point.triangle),
        point.geometric_normal(),
        point.position - ray.origin,
    );
    pdf * scene.aim_shares().emitters
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rest_of_the_number_is_even() {
        let shares = AimShares {
            background: 0.25,
            emitters: 0.75,
        };
        let steps = 1000_u16;
        let mut rests = Vec::new();
        for step in 0..steps {
            match shares.choose(f32::from(step) / f32::from(steps)) {
                Target::Background(rest) => assert!((0.0..1.0).contains(&rest)),
                Target::Emitter(rest) => rests.push(rest),
            }
        }
        assert_eq!(rests.len(), 750);
        assert!(rests.iter().all(|rest| (0.0..1.0).contains(rest)));
        let mean = rests.iter().sum::<f32>() / 750.0;
        assert!((mean - 0.5).abs() < 1e-3, "{mean}");
    }
}
