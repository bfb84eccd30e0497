//! How far from a hit neighbouring rays meet the surface, which says how much of an image to average: ray differentials
//! (Igehy 1999) for rays from the eye, ray cones (Amanatides 1984) from the first surface on. Lengths are in prepared units.

use crate::math::{DVec3, Vec3};
use crate::render::camera::{CameraRay, PreparedCamera};

/// How far apart neighbouring rays are, along one path.
///
/// - From the eye, by the exact derivative of the ray's direction with the place on the picture, through pinhole or lens.
/// - After a mirror or glass it is a cone as wide as the wider of both, which goes on to open by the length of the whole path, as after
///   a flat mirror.
/// - After a direction that was drawn, a cone that opens by [`Footprint::SCATTERED`]: such rays together look all around.
#[derive(Clone, Copy, Debug)]
pub struct Footprint {
    /// The change of the unit direction to the neighbours.
    spread: Spread,
    /// How long the path was before the ray begins.
    before: f32,
}

#[derive(Clone, Copy, Debug)]
enum Spread {
    /// To the neighbours on the right and below.
    Rays([Vec3; 2]),
    /// To all sides.
    Cone(f32),
}

impl Footprint {
    /// What each of many samples stands for, as a share of the pixel's width: small enough that their mean is not blurred, and large
    /// enough that 16 of them leave nothing out.
    pub const SHARE_OF_PIXEL: f32 = 0.25;
    /// The width of the cone of a scattered ray at distance 1: some 1600 of them fill a hemisphere.
    const SCATTERED: f32 = 1.0 / 16.0;

    /// The footprint of a ray from the eye; `share`: of the way to the next pixel.
    pub fn from_eye(camera: &PreparedCamera, ray: &CameraRay, share: f32) -> Self {
        let spread = camera.spread(ray.ray.direction.as_dvec3());
        #[expect(clippy::cast_possible_truncation, reason = "rendering is f32")]
        Self {
            spread: Spread::Rays(spread.map(|change| change.as_vec3() * share)),
            before: ray.start as f32,
        }
    }

    /// The ray ends after `distance`, and goes on elsewhere.
    pub fn deflect(&mut self, distance: f32) {
        self.before += distance;
        if let Spread::Rays([a, b]) = self.spread {
            self.spread = Spread::Cone(a.length().max(b.length()));
        }
    }

    /// The ray ends, and a scattered one begins.
    pub fn scatter(&mut self) {
        self.before = 0.0;
        self.spread = Spread::Cone(Self::SCATTERED);
    }

    /// How far beside the point that the ray meets after `distance`, along the unit vector `-wo`, its neighbours meet the plane with
    /// this `normal`, of any length.
    pub fn on_plane(&self, distance: f32, wo: Vec3, normal: DVec3) -> [DVec3; 2] {
        let direction = -wo.as_dvec3();
        let sides = match self.spread {
            Spread::Rays(sides) => sides.map(Vec3::as_dvec3),
            Spread::Cone(width) => {
                let (a, b) = direction.any_orthonormal_pair();
                [a, b].map(|side| side * f64::from(width))
            }
        };
        let length = f64::from(self.before) + f64::from(distance);
        let cosine = direction.dot(normal);
        sides.map(|side| {
            let beside = side * length;
            beside - direction * (beside.dot(normal) / cosine)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Bounds, DBounds, Degrees, SceneFrame, Vec2};
    use crate::scene::Camera;

    /// Against rays traced a thousandth of a pixel away, through pinhole and lens, near the middle and the edge.
    #[test]
    fn neighbours_meet_a_plane_where_they_should() {
        let world = DBounds {
            min: DVec3::splat(-1.0),
            max: DVec3::splat(1.0),
        };
        let frame = SceneFrame::around(&world);
        let bounds = Bounds {
            min: frame.narrow(world.min),
            max: frame.narrow(world.max),
        };
        for aperture_radius in [0.0, 0.3] {
            let description = Camera {
                eye: DVec3::new(1.0, -4.0, 2.0),
                vertical_fov: Degrees(50.0),
                aperture_radius,
                focus_distance: Some(3.0),
                ..Camera::default()
            };
            let camera = PreparedCamera::new(&description, &frame, &[bounds], 40, 30);
            let camera = camera.expect("has a direction");
            let normal = DVec3::new(0.3, -0.5, 0.8);
            for (x, y) in [(20.0, 15.0), (3.0, 4.0), (31.5, 28.0)] {
                let on_lens = Vec2::new(0.8, 0.3);
                let (eye, direction) = camera.through_lens(x, y, on_lens);
                // A plane through what lies three quarters of the way.
                let through = eye + direction * 0.75;
                let met = |x: f64, y: f64| {
                    let (eye, direction) = camera.through_lens(x, y, on_lens);
                    eye + direction * ((through - eye).dot(normal) / direction.dot(normal))
                };
                let step = 1e-3;
                let expected = [met(x + step, y), met(x, y + step)].map(|at| (at - through) / step);
                let footprint = Footprint {
                    spread: Spread::Rays(camera.spread(direction).map(DVec3::as_vec3)),
                    before: 0.25,
                };
                let found = footprint.on_plane(0.5, -direction.as_vec3(), normal * 7.0);
                for (found, expected) in found.iter().zip(expected) {
                    let error = found.distance(expected);
                    assert!(error < 2e-3 * expected.length(), "{found} {expected}");
                }
            }
        }
    }

    /// A cone of width w meets a plane at right angles in a square of side w, and a slanted one in one longer by 1/cos.
    #[test]
    fn cones_are_cut_by_planes() {
        let mut footprint = Footprint {
            spread: Spread::Rays([Vec3::X * 0.01, Vec3::Y * 0.02]),
            before: 1.0,
        };
        footprint.deflect(2.0);
        let sides = footprint.on_plane(1.0, Vec3::Z, DVec3::Z);
        assert!(sides.iter().all(|side| (side.length() - 0.08).abs() < 1e-8));
        assert!(sides[0].dot(sides[1]).abs() < 1e-12);
        let slanted = footprint.on_plane(1.0, Vec3::Z, DVec3::new(0.8, 0.0, 0.6));
        let area = slanted[0].cross(slanted[1]).length();
        assert!((area - 0.08 * 0.08 / 0.6).abs() < 1e-8, "{area}");
        footprint.scatter();
        let sides = footprint.on_plane(2.0, Vec3::Z, DVec3::Z);
        assert!((sides[0].length() - 0.125).abs() < 1e-8);
    }
}
