//! Mirrors and glass: where light that meets them goes on.

use super::fresnel::{fresnel, refract};
use super::layers::Layer;
use super::surface::SurfacePoint;
use crate::math::{Ray, Vec3};

/// A surface that sends light on in one direction.
#[derive(Clone, Copy, Debug)]
pub enum Specular {
    Mirror {
        reflectance: Vec3,
    },
    Glass {
        ior: f32,
        /// Of the inside, per prepared unit.
        attenuation: Vec3,
    },
}

/// How light goes on from a mirror or glass.
#[derive(Clone, Copy, Debug)]
pub struct Onward {
    pub ray: Ray,
    /// Share of the radiance that is kept.
    pub throughput: Vec3,
    /// By how much radiance is concentrated behind the boundary, which `throughput` undoes: the square of the relative index of
    /// refraction, 1 where light is reflected.
    pub concentration: f32,
    /// [`Layer::Reflection`] or [`Layer::Refraction`].
    pub layer: Layer,
}

impl Specular {
    /// Follows light on from `point`. `u`: uniform in `[0, 1)`, asked for where there is a choice.
    ///
    /// Glass is never split in two: it reflects with the probability that Fresnel's equations give, else refracts. The share
    /// chosen cancels its probability. What refraction keeps is radiance over the square of the index of refraction.
    /// Source: Veach, Robust Monte Carlo Methods for Light Transport Simulation, 1997, section 5.2.
    pub fn onward(&self, point: &SurfacePoint, u: impl FnOnce() -> f32) -> Onward {
        let reflected = |throughput| Onward {
            ray: point.ray_above(point.mirror_direction()),
            throughput,
            concentration: 1.0,
            layer: Layer::Reflection,
        };
        match *self {
            Self::Mirror { reflectance } => reflected(reflectance),
            Self::Glass { ior, .. } => {
                let normal = point.specular_normal;
                let eta = if point.front { ior } else { 1.0 / ior };
                let boundary = fresnel(normal.dot(point.wo), eta);
                if u() < boundary.reflectance {
                    return reflected(Vec3::ONE);
                }
                let direction = refract(point.wo, normal, eta, boundary.cos_transmitted);
                Onward {
                    ray: point.ray_through(direction),
                    throughput: Vec3::splat(1.0 / (eta * eta)),
                    concentration: eta * eta,
                    layer: Layer::Refraction,
                }
            }
        }
    }
}
