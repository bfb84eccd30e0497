use std::f32::consts::PI;

use crate::math::Vec3;
use crate::scene::Background;

/// The background in `f32`. Directions are unit vectors.
#[derive(Clone, Copy, Debug)]
pub enum PreparedBackground {
    /// The same from everywhere.
    Constant(Vec3),
    /// Linear in the cosine to `up`, above and below the horizon.
    Gradient {
        zenith: Vec3,
        horizon: Vec3,
        ground: Vec3,
        up: Vec3,
    },
}

impl PreparedBackground {
    pub fn new(background: &Background) -> Self {
        match *background {
            Background::Constant { radiance } => Self::Constant(radiance.as_vec3()),
            Background::Gradient {
                zenith,
                horizon,
                ground,
                up,
            } => Self::Gradient {
                zenith: zenith.as_vec3(),
                horizon: horizon.as_vec3(),
                ground: ground.as_vec3(),
                up: up.normalize_or(crate::math::DVec3::Z).as_vec3(),
            },
        }
    }

    /// Whether it gives no light at all.
    pub fn is_black(&self) -> bool {
        match *self {
            Self::Constant(radiance) => radiance == Vec3::ZERO,
            Self::Gradient {
                zenith,
                horizon,
                ground,
                ..
            } => [zenith, horizon, ground].iter().all(|&c| c == Vec3::ZERO),
        }
    }

    /// Radiance seen along `direction`.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        match *self {
            Self::Constant(radiance) => radiance,
            Self::Gradient {
                zenith,
                horizon,
                ground,
                up,
            } => {
                let t = direction.dot(up).clamp(-1.0, 1.0);
                if t >= 0.0 {
                    horizon.lerp(zenith, t)
                } else {
                    horizon.lerp(ground, -t)
                }
            }
        }
    }

    /// The cosine-weighted mean of the radiance over the hemisphere about `normal`, nothing being in the way: irradiance / π.
    ///
    /// A gradient is `horizon` plus multiples of the two halves of the cosine to `up`. The mean of such a half is
    /// `2/(3π) · (sin γ + (π − γ) cos γ)`, where γ is the angle between `normal` and the half's axis: the directional albedo
    /// of a Phong lobe of exponent 1 (Lafortune & Willems 1994) but for its factor.
    pub fn mean_over_hemisphere(&self, normal: Vec3) -> Vec3 {
        match *self {
            Self::Constant(radiance) => radiance,
            Self::Gradient {
                zenith,
                horizon,
                ground,
                up,
            } => {
                let cosine = normal.dot(up).clamp(-1.0, 1.0);
                let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
                let angle = libm::atan2f(sine, cosine);
                let mean_half =
                    |angle: f32, cosine: f32| 2.0 / (3.0 * PI) * (sine + (PI - angle) * cosine);
                let above = mean_half(angle, cosine);
                let below = mean_half(PI - angle, -cosine);
                horizon + (zenith - horizon) * above + (ground - horizon) * below
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::DVec3;

    fn gradient() -> PreparedBackground {
        PreparedBackground::new(&Background::Gradient {
            zenith: DVec3::new(1.0, 0.0, 0.25),
            horizon: DVec3::new(0.5, 1.0, 0.25),
            ground: DVec3::new(0.0, 0.5, 0.25),
            up: DVec3::new(0.0, 0.0, 2.0),
        })
    }

    #[test]
    fn gradient_mixes_from_the_horizon_up_and_down() {
        let sky = gradient();
        assert_eq!(sky.radiance(Vec3::Z), Vec3::new(1.0, 0.0, 0.25));
        assert_eq!(sky.radiance(Vec3::X), Vec3::new(0.5, 1.0, 0.25));
        assert_eq!(sky.radiance(-Vec3::Z), Vec3::new(0.0, 0.5, 0.25));
        let t = 0.6;
        assert!(
            sky.radiance(Vec3::new(0.8, 0.0, t))
                .abs_diff_eq(Vec3::new(0.8, 0.4, 0.25), 1e-6)
        );
    }

    /// Against midpoint quadrature over the hemisphere in (cos² θ, φ), where cosine weighting is uniform.
    #[test]
    fn hemisphere_mean_agrees_with_quadrature() {
        let sky = gradient();
        for tilt in [0.0_f32, 0.3, 1.0, 1.570_796_4, 2.0, 3.0, PI] {
            let normal = Vec3::new(tilt.sin(), 0.0, tilt.cos());
            let (u, v) = normal.any_orthonormal_pair();
            let steps = 400;
            let mut sum = DVec3::ZERO;
            for i in 0..steps {
                for j in 0..steps {
                    let cosine = ((i as f32 + 0.5) / steps as f32).sqrt();
                    let sine = (1.0 - cosine * cosine).sqrt();
                    let phi = 2.0 * PI * (j as f32 + 0.5) / steps as f32;
                    let direction = normal * cosine + (u * phi.cos() + v * phi.sin()) * sine;
                    sum += sky.radiance(direction).as_dvec3();
                }
            }
            let quadrature = sum / f64::from(steps * steps);
            let closed = sky.mean_over_hemisphere(normal).as_dvec3();
            assert!(
                closed.abs_diff_eq(quadrature, 2e-5),
                "tilt {tilt}: {closed} against {quadrature}"
            );
        }
    }
}
