//! Lights as rendering reads them, and points on them to aim shadow rays at. Positions are in prepared units, densities per
//! steradian seen from the point that is lit.

use std::f32::consts::PI;

use super::light_tree::{Luminary, Receiver, Shines};
use crate::math::{Bounds, DVec3, Ray, SceneFrame, Vec2, Vec3, color::luminance, robust, warp};
use crate::scene::Light;

/// A light in the prepared scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PreparedLight {
    Point {
        position: Vec3,
        /// Radiant intensity × (prepared units per world unit)², so that dividing by the prepared distance squared gives
        /// the irradiance of the world.
        intensity: Vec3,
    },
    Disk(PreparedDisk),
}

/// A disk light in the prepared scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreparedDisk {
    center: Vec3,
    /// Unit; the disk shines on its side.
    normal: Vec3,
    radius: f32,
    area: f32,
    radiance: Vec3,
    visible: bool,
    /// Two radii at right angles.
    radii: [Vec3; 2],
    /// `axis · p = height` for the points of its plane; in `f64`, so that whether a grazing ray meets the rim does not depend on
    /// how far away it starts.
    axis: DVec3,
    height: f64,
    /// How far a rounded point of the disk is moved to lie in front of it, wherever it is on the disk.
    lift: f32,
}

/// What a point of a light sends to a point of a surface.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// The point of the light.
    pub position: Vec3,
    /// Towards it; unit where the light shines that way.
    pub wi: Vec3,
    /// The solid angle that the whole light counts as, seen from here: one over the density of `wi`, per steradian. 0 for points, and where
    /// the light does not shine.
    pub solid_angle: f32,
    /// Irradiance on a surface that faces the light's point, divided by the density with which that point was chosen;
    /// black where the light does not shine that way.
    pub irradiance: Vec3,
}

impl PreparedLight {
    pub fn new(light: &Light, frame: &SceneFrame) -> Self {
        match *light {
            Light::Point {
                position,
                intensity,
            } => Self::Point {
                position: frame.narrow(position),
                intensity: (intensity * (frame.scale() * frame.scale())).as_vec3(),
            },
            Light::Disk {
                center,
                facing,
                radius,
                radiance,
                visible,
            } => {
                let normal = facing.normal(center).unwrap_or_default().as_vec3();
                #[expect(clippy::cast_possible_truncation, reason = "rendering is f32")]
                let radius = (radius * frame.scale()) as f32;
                Self::Disk(PreparedDisk {
                    visible,
                    ..PreparedDisk::new(frame.narrow(center), normal, radius, radiance.as_vec3())
                })
            }
        }
    }

    /// What it emits in all, up to a factor common to all lights: W of the prepared scene.
    pub fn power(&self) -> f64 {
        use std::f64::consts::PI;
        match self {
            Self::Point { intensity, .. } => 4.0 * PI * f64::from(luminance(*intensity)),
            Self::Disk(disk) => {
                let area = PI * f64::from(disk.radius).powi(2);
                PI * area * f64::from(luminance(disk.radiance))
            }
        }
    }

    /// What a choice by place and direction needs to know of it.
    pub fn luminary(&self) -> Luminary {
        match self {
            Self::Point {
                position,
                intensity,
            } => Luminary {
                bounds: Bounds::of_points([*position]),
                shines: Shines::Everywhere,
                intensity: f64::from(luminance(*intensity)),
            },
            Self::Disk(disk) => Luminary {
                bounds: disk.bounds(),
                shines: Shines::OneSide(disk.normal),
                intensity: self.power() / std::f64::consts::PI,
            },
        }
    }

    /// The disk, if this is one that rays meet.
    pub fn visible_disk(&self) -> Option<&PreparedDisk> {
        match self {
            Self::Disk(disk) if disk.visible => Some(disk),
            _ => None,
        }
    }

    /// Whether it has an area, so that samples of it differ.
    pub fn has_area(&self) -> bool {
        matches!(self, Self::Disk(_))
    }

    /// Whether it gives no light.
    pub fn is_black(&self) -> bool {
        match self {
            Self::Point { intensity, .. } => *intensity == Vec3::ZERO,
            Self::Disk(disk) => disk.radiance == Vec3::ZERO,
        }
    }

    /// Whether its numbers fit the precision of rendering.
    pub fn is_finite(&self) -> bool {
        match self {
            Self::Point {
                position,
                intensity,
            } => position.is_finite() && intensity.is_finite(),
            Self::Disk(disk) => {
                let area = disk.radius * disk.radius;
                let bounds = disk.bounds();
                area.is_finite()
                    && disk.radiance.is_finite()
                    && bounds.min.is_finite()
                    && bounds.max.is_finite()
            }
        }
    }

    /// The whole light as one point at its centre.
    pub fn center(&self, from: Vec3) -> LightSample {
        match self {
            Self::Point {
                position,
                intensity,
            } => {
                let towards = *position - from;
                let distance_squared = towards.length_squared();
                LightSample {
                    position: *position,
                    wi: towards / distance_squared.sqrt(),
                    solid_angle: 0.0,
                    irradiance: *intensity / distance_squared,
                }
            }
            Self::Disk(disk) => disk.seen_from(from, disk.center),
        }
    }

    /// A point of the light, uniform over its area by `u`.
    #[inline]
    pub fn sample(&self, from: Vec3, u: Vec2) -> LightSample {
        match self {
            Self::Point { .. } => self.center(from),
            Self::Disk(disk) => disk.sample(from, u),
        }
    }
}

impl LightSample {
    /// No light, from somewhere at `position`.
    fn nothing(position: Vec3) -> Self {
        Self {
            position,
            wi: Vec3::ZERO,
            solid_angle: 0.0,
            irradiance: Vec3::ZERO,
        }
    }
}

impl PreparedDisk {
    /// A visible disk.
    fn new(center: Vec3, normal: Vec3, radius: f32, radiance: Vec3) -> Self {
        let (x, y) = warp::tangents(normal);
        // A point of the disk is rounded four times, and once more when it is lifted; the rest is for the normal.
        let error = (center.abs() + radius) * robust::gamma(6);
        Self {
            center,
            normal,
            radius,
            area: PI * radius * radius,
            radiance,
            visible: true,
            radii: [x * radius, y * radius],
            axis: normal.as_dvec3(),
            height: normal.as_dvec3().dot(center.as_dvec3()),
            lift: normal.abs().dot(error),
        }
    }

    /// A point of the disk, uniform over its area by `u`.
    #[inline]
    fn sample(&self, from: Vec3, u: Vec2) -> LightSample {
        let [x, y] = self.radii;
        let place = warp::concentric_disk(u);
        self.seen_from(from, self.center + x * place.x + y * place.y)
    }

    /// What the disk's point `position`, standing for the whole area, sends to `from`.
    fn seen_from(&self, from: Vec3, position: Vec3) -> LightSample {
        let position = self.in_front(position, from);
        let towards = position - from;
        let per_distance = towards.length_recip();
        let wi = towards * per_distance;
        let cosine = -self.normal.dot(wi);
        let solid_angle = if cosine > 0.0 {
            self.area * cosine * per_distance * per_distance
        } else {
            0.0
        };
        LightSample {
            position,
            wi,
            solid_angle,
            irradiance: self.radiance * solid_angle,
        }
    }

    /// A point of the disk as seen from `from`, in front of it by more than what rounding may have moved it, so that a ceiling it lies
    /// in does not shadow it.
    pub fn in_front(&self, position: Vec3, from: Vec3) -> Vec3 {
        position + self.normal * self.lift_at(position, from)
    }

    /// How far [`Self::in_front`] moves. Of a disk larger than the scene, what rounds at its rim could reach through the whole scene:
    /// there, what counts is what rounds at `position`, on the way to it, and of corners, of which none is beyond 1.
    fn lift_at(&self, position: Vec3, from: Vec3) -> f32 {
        if self.radius <= 1.0 {
            return self.lift;
        }
        let largest = |v: Vec3| v.abs().max_element();
        let size = 1.0 + largest(self.center) + largest(position) + largest(position - from);
        let there = self.normal.abs().element_sum() * size * robust::gamma(6);
        self.lift.min(there)
    }

    /// A box around the disk and around the points that [`PreparedLight::sample`] gives, which are off the disk by their rounding, as are
    /// surfaces in its plane.
    pub fn bounds(&self) -> Bounds {
        // 1 − n² per axis, but from the other two: near an axis that has more digits.
        let squares = self.normal.as_dvec3() * self.normal.as_dvec3();
        let others = DVec3::new(
            squares.y + squares.z,
            squares.z + squares.x,
            squares.x + squares.y,
        );
        let across = (others / squares.element_sum()).map(f64::sqrt);
        let rounding = (1.0 + self.center.abs().max_element() + self.radius) * robust::gamma(16);
        let reach = (across * f64::from(self.radius)).as_vec3() + rounding;
        Bounds {
            min: self.center - reach,
            max: self.center + reach,
        }
    }

    /// The parameter `t` at which `ray` meets the disk, from either side, if `0 < t < t_max`.
    pub fn intersect(&self, ray: &Ray, t_max: f32) -> Option<f32> {
        self.intersect_plane(ray, t_max).filter(|&t| t < t_max)
    }

    /// [`Self::intersect`] where a surface was met at `t_max`: of a ceiling and a lamp in its plane, the lamp's bright side is in
    /// front.
    pub fn intersect_before(&self, ray: &Ray, t_max: f32) -> Option<f32> {
        let t = self.intersect_plane(ray, f32::INFINITY)?;
        let along = self.normal.dot(ray.direction);
        // How far behind the surface the disk lies there, against what rounds: corners, of which none is beyond 1, the
        // disk's centre, its plane as far from that as the ray meets it, and distances.
        let behind = (t - t_max) * -along;
        let from_center = if self.radius > 1.0 {
            self.radius.min(ray.at(t).distance(self.center))
        } else {
            self.radius
        };
        let rounded = 1.0 + self.center.abs().max_element() + from_center - t * along;
        (t < t_max || (along < 0.0 && behind <= rounded * robust::gamma(8))).then_some(t)
    }

    /// Where `ray` meets the disk; nothing is missed up to `t_max`.
    #[inline]
    fn intersect_plane(&self, ray: &Ray, t_max: f32) -> Option<f32> {
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let along = self.axis.dot(direction);
        let height = self.height - self.axis.dot(origin);
        // Behind the start, or further than any rounding of t reaches: most disks, for most rays.
        let reach = f64::from(t_max) * (1.0 + f64::from(f32::EPSILON));
        if height * along <= 0.0 || height.abs() > along.abs() * reach {
            return None;
        }
        let t = height / along;
        let from_center = origin + direction * t - self.center.as_dvec3();
        let inside = from_center.length_squared() <= f64::from(self.radius).powi(2);
        #[expect(clippy::cast_possible_truncation, reason = "rendering is f32")]
        let t = t as f32;
        (inside && t > 0.0).then_some(t)
    }

    /// Radiance that leaves the disk against a ray along `direction`: black on its back.
    pub fn emitted(&self, direction: Vec3) -> Vec3 {
        if self.normal.dot(direction) < 0.0 {
            self.radiance
        } else {
            Vec3::ZERO
        }
    }

    /// A point of the disk by `u`, for light on `at` that nothing else can find. Where the disk is near, half of the samples are directions
    /// of the hemisphere over `at` instead, drawn by the cosine. Each sample counts by the density of both ways together (Veach's balance
    /// heuristic for one sample), so that no point counts for more than twice the hemisphere; the irradiance is 0 where a direction misses
    /// the disk.
    pub fn sample_alone(&self, at: &Receiver, u: Vec2) -> LightSample {
        if !self.is_near(at.position) {
            return self.sample(at.position, u);
        }
        let twice = u.x * 2.0;
        let by_area = if twice < 1.0 {
            self.sample(at.position, Vec2::new(twice, u.y))
        } else {
            let u = Vec2::new(twice - 1.0, u.y);
            let wi = warp::around(at.normal, warp::cosine_hemisphere(u));
            let ray = Ray::new(at.position, wi);
            let Some(t) = self.intersect(&ray, f32::INFINITY) else {
                return LightSample::nothing(self.center);
            };
            self.seen_from(at.position, ray.at(t))
        };
        if by_area.solid_angle == 0.0 {
            return LightSample::nothing(self.center);
        }
        let by_cosine = warp::cosine_pdf_around(at.normal, by_area.wi);
        let solid_angle = 2.0 / (by_area.solid_angle.recip() + by_cosine);
        LightSample {
            solid_angle,
            irradiance: self.radiance * solid_angle,
            ..by_area
        }
    }

    /// Density with which [`PreparedLight::sample`] chooses the direction of `ray` that meets the disk at `t`, per
    /// steradian.
    pub fn pdf_solid_angle(&self, ray: &Ray, t: f32) -> f32 {
        let length = ray.direction.length();
        let cosine = self.normal.dot(ray.direction).abs() / length;
        let distance = t * length;
        distance * distance / (cosine * self.area)
    }

    /// Whether the disk is so near to `from`, for its size, that sampling its area alone is noisy: 1/d² varies by more than
    /// an order of magnitude over it.
    pub fn is_near(&self, from: Vec3) -> bool {
        from.distance_squared(self.center) < 4.0 * self.radius * self.radius
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::Random;

    #[test]
    fn the_box_of_a_disk_holds_its_points_and_little_else() {
        let mut random = Random::new(4);
        for turn in 0..2000 {
            let normal = match turn % 3 {
                0 => Vec3::AXES[turn % 9 / 3],
                // A hair off an axis, where 1 − n² has no digits.
                1 => (Vec3::Z + random.in_cube().as_vec3() * 1e-4).normalize(),
                _ => random.in_cube().normalize().as_vec3(),
            };
            #[expect(clippy::cast_possible_truncation, reason = "rendering is f32")]
            let radius = random.unit().powi(9) as f32;
            let disk = PreparedDisk::new(random.in_cube().as_vec3(), normal, radius, Vec3::ONE);
            let bounds = disk.bounds();
            for _ in 0..50 {
                let u = random.in_cube().as_vec3().truncate() * 0.5 + 0.5;
                let sample = PreparedLight::Disk(disk).sample(Vec3::splat(9.0), u);
                assert!(bounds.contains(sample.position), "{disk:?}: {sample:?}");
            }
            // Its rim touches all six sides.
            let n = normal.as_dvec3();
            for axis in 0..3 {
                let exact = f64::from(disk.radius) * (1.0 - n[axis] * n[axis]).max(0.0).sqrt();
                let half = f64::from(bounds.size()[axis]) / 2.0;
                assert!(
                    (half - exact).abs()
                        < 4e-6 + 1e-3 * f64::from(disk.radius) * f64::from(turn % 3 == 1),
                    "{disk:?}"
                );
            }
        }
    }
}
