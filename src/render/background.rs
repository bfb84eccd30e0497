//! The background as rendering reads it: radiance by direction, means over hemispheres, and directions drawn in proportion to an
//! image's luminance.

use std::f32::consts::PI;
use std::sync::Arc;

use super::radiance_image::RadianceImage;
use crate::control::CancelToken;
use crate::math::{DVec3, Vec2, Vec3, direction_of};
use crate::scene::{Background, ImageAxes, Scene, SceneError};

/// The background in `f32`. Directions are unit vectors.
#[derive(Clone, Debug)]
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
    Image(ImageBackground),
}

/// An image around the scene.
#[derive(Clone, Debug)]
pub struct ImageBackground {
    /// Shared with whatever was prepared of the same pixels: another rotation, scale or up costs nothing.
    image: Arc<RadianceImage>,
    axes: ImageAxes,
    scale: f32,
}

/// A direction of the background aimed at.
#[derive(Clone, Copy, Debug)]
pub struct SkySample {
    /// Unit.
    pub direction: Vec3,
    /// What is seen there.
    pub radiance: Vec3,
    /// Density of the direction, per steradian.
    pub pdf_solid_angle: f32,
}

impl PreparedBackground {
    /// Prepares the background of a validated `scene`; keeps the image of `previous` where it is the same, and makes none for a picture
    /// that does not show it. `is_aimed_at`: whether directions are drawn by what it shows. `None` when cancelled.
    ///
    /// # Errors
    /// An image that is not loaded, or too bright for 32 bits.
    pub fn new(
        scene: &Scene,
        previous: Option<&Self>,
        is_aimed_at: bool,
        cancel: &CancelToken,
    ) -> Result<Option<Self>, SceneError> {
        Ok(Some(match scene.background {
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
                up: direction_of(up).unwrap_or(DVec3::Z).as_vec3(),
            },
            Background::Image { .. } => {
                let known = ImageBackground::known(scene, previous, is_aimed_at)?;
                let is_black = scene.background.is_black()
                    || scene.background_image()?.is_some_and(|map| map.is_black());
                let is_seen = scene.render.mode.shows_light() && !is_black;
                if known.is_none() && !is_seen {
                    return Ok(Some(Self::Constant(Vec3::ZERO)));
                }
                let image = ImageBackground::new(scene, known, is_aimed_at, cancel)?;
                return Ok(image.map(Self::Image));
            }
        }))
    }

    /// The image that can be aimed at: one that gives light.
    pub fn image(&self) -> Option<&ImageBackground> {
        match self {
            Self::Image(image) if !self.is_black() => Some(image),
            _ => None,
        }
    }

    /// Whether it gives no light at all.
    pub fn is_black(&self) -> bool {
        match *self {
            Self::Constant(radiance) => radiance == Vec3::ZERO,
            Self::Image(ref image) => image.mean_luminance() <= 0.0,
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
            Self::Image(ref image) => image.radiance(direction),
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
    /// `None` for an image, which has no closed form.
    ///
    /// A gradient is `horizon` plus multiples of the two halves of the cosine to `up`. The mean of such a half is
    /// `2/(3π) · (sin γ + (π − γ) cos γ)`, where γ is the angle between `normal` and the half's axis: the directional albedo
    /// of a Phong lobe of exponent 1 (Lafortune & Willems 1994) but for its factor.
    pub fn mean_over_hemisphere(&self, normal: Vec3) -> Option<Vec3> {
        Some(match *self {
            Self::Constant(radiance) => radiance,
            Self::Image(_) => return None,
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
        })
    }
}

impl ImageBackground {
    /// The image of the scene's background as `previous` has prepared it, if it did so with the tables that aiming takes where
    /// `is_aimed_at`.
    fn known(
        scene: &Scene,
        previous: Option<&PreparedBackground>,
        is_aimed_at: bool,
    ) -> Result<Option<Arc<RadianceImage>>, SceneError> {
        let map = scene.background_image()?;
        Ok(match previous {
            Some(PreparedBackground::Image(known))
                if map.is_some_and(|map| Arc::ptr_eq(known.image.map(), map))
                    && (known.image.can_be_sampled() || !is_aimed_at) =>
            {
                Some(Arc::clone(&known.image))
            }
            _ => None,
        })
    }

    fn new(
        scene: &Scene,
        known: Option<Arc<RadianceImage>>,
        is_aimed_at: bool,
        cancel: &CancelToken,
    ) -> Result<Option<Self>, SceneError> {
        let (
            Some(map),
            &Background::Image {
                up,
                rotation,
                scale,
                ..
            },
        ) = (scene.background_image()?, &scene.background)
        else {
            unreachable!("only an image is prepared as one");
        };
        let made = || RadianceImage::new(map, is_aimed_at, cancel).map(Arc::new);
        let Some(image) = known.or_else(made) else {
            return Ok(None);
        };
        #[expect(clippy::cast_possible_truncation, reason = "rendering is f32")]
        let narrow_scale = scale as f32;
        if !(image.largest() * narrow_scale).is_finite() {
            return Err(SceneError::BadValue {
                key: "background.scale".to_owned(),
                value: scale.to_string(),
                expected: format!(
                    "a factor that leaves the brightest pixel, {:e}, below what 32 bits can hold",
                    image.largest()
                ),
            });
        }
        Ok(Some(Self {
            image,
            axes: ImageAxes::new(up, rotation).expect("a validated background has an up"),
            scale: narrow_scale,
        }))
    }

    /// Radiance seen along `direction`.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        self.image.radiance(self.local(direction)) * self.scale
    }

    /// [`Self::radiance`], and the density of [`Self::sample`] at `direction`, per steradian.
    pub fn radiance_and_pdf(&self, direction: Vec3) -> (Vec3, f32) {
        let radiance = self.image.radiance(self.local(direction));
        let pdf_solid_angle = self.image.pdf_solid_angle(radiance);
        (radiance * self.scale, pdf_solid_angle)
    }

    /// A direction drawn in proportion to the luminance seen there; `u`: uniform over the unit square. `None` for a black image.
    pub fn sample(&self, u: Vec2) -> Option<SkySample> {
        let ImageAxes { front, left, up } = self.axes;
        let local = self.image.sample(u)?;
        let direction = front * local.x + left * local.y + up * local.z;
        // Of the direction as drawn, before it is narrowed: a cell's edge is not rounded across.
        let radiance = self.image.radiance(local);
        let pdf_solid_angle = self.image.pdf_solid_angle(radiance);
        (pdf_solid_angle > 0.0).then_some(SkySample {
            direction: direction.as_vec3(),
            radiance: radiance * self.scale,
            pdf_solid_angle,
        })
    }

    /// Bytes of the tables that [`Self::sample`] takes.
    pub fn table_bytes(&self) -> usize {
        self.image.table_bytes()
    }

    /// Luminance averaged over all directions.
    pub fn mean_luminance(&self) -> f64 {
        self.image.integral() * f64::from(self.scale) / (4.0 * std::f64::consts::PI)
    }

    fn local(&self, direction: Vec3) -> DVec3 {
        let direction = direction.as_dvec3();
        let ImageAxes { front, left, up } = self.axes;
        DVec3::new(direction.dot(front), direction.dot(left), direction.dot(up))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    fn gradient() -> PreparedBackground {
        let background = Background::Gradient {
            zenith: DVec3::new(1.0, 0.0, 0.25),
            horizon: DVec3::new(0.5, 1.0, 0.25),
            ground: DVec3::new(0.0, 0.5, 0.25),
            up: DVec3::new(0.0, 0.0, 2.0),
        };
        let scene = Scene {
            background,
            ..Scene::default()
        };
        PreparedBackground::new(&scene, None, true, &CancelToken::new())
            .expect("can be rendered")
            .expect("nobody cancels")
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
            let closed = sky
                .mean_over_hemisphere(normal)
                .expect("a closed form")
                .as_dvec3();
            assert!(
                closed.abs_diff_eq(quadrature, 2e-5),
                "tilt {tilt}: {closed} against {quadrature}"
            );
        }
    }
}
