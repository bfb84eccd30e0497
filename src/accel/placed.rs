//! Between the prepared scene and the local space of a copy: rays one way, points and normals the other.
//!
//! The way there and back is computed in `f64` from the `f32` numbers at its ends, so that only two roundings count: of a
//! ray's origin and direction when they become local, and of a point when it becomes one of the scene. Bounds below leave
//! the roundings of `f64` to the reserve of [`gamma`], which is a hundred million times as large.

use crate::geometry::Triangle;
use crate::math::robust::gamma;
use crate::math::{DVec3, Ray, ScaledRotation, Vec3};

/// Where a copy is: `scene = turn · local + translation`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place<'a> {
    pub turn: &'a ScaledRotation,
    pub translation: DVec3,
}

impl Place<'_> {
    /// `ray` in local space; its parameter means the same. `None` where `f32` cannot hold it: a copy so much smaller than the
    /// scene is nowhere as wide as a digit of the scene's coordinates.
    ///
    /// Where the turn is a power of two alone, the direction loses no digit.
    #[inline]
    pub fn local_ray(&self, ray: &Ray) -> Option<Ray> {
        let origin = self.turn.undo(ray.origin.as_dvec3() - self.translation);
        let direction = self.turn.undo(ray.direction.as_dvec3());
        let local = Ray::new(origin.as_vec3(), direction.as_vec3());
        let usable = local.origin.is_finite()
            && local.direction.is_finite()
            && local.direction != Vec3::ZERO;
        usable.then_some(local)
    }

    fn point(&self, local: DVec3) -> DVec3 {
        self.turn.apply(local) + self.translation
    }
}

/// A triangle of the scene: itself, or a shared one and where this copy of it is.
#[derive(Clone, Copy, Debug)]
pub struct PlacedTriangle<'a> {
    /// Number of its part of the scene.
    pub part: usize,
    /// Its number within that part.
    pub number: u32,
    /// Local where there is a place; corners in the order of [`PlacedTriangle::in_scene`].
    pub(super) triangle: Triangle,
    pub(super) place: Option<Place<'a>>,
}

impl PlacedTriangle<'_> {
    /// The triangle in the prepared scene: counter-clockwise seen from outside, in the order of a hit's weights. Corners of
    /// copies are rounded; see [`PlacedTriangle::point`] for how far from what rays meet.
    #[must_use]
    #[inline]
    pub fn in_scene(&self) -> Triangle {
        let Some(place) = &self.place else {
            return self.triangle;
        };
        let corner = |local: Vec3| place.point(local.as_dvec3()).as_vec3();
        Triangle {
            corners: self.triangle.corners.map(corner),
        }
    }

    /// The point with these weights of the corners, and a bound for each coordinate on how far it may seem to lie off the
    /// triangle. A ray that starts further away, above or below, cannot meet the triangle again.
    #[must_use]
    #[inline]
    pub fn point(&self, weights: [f32; 3]) -> (Vec3, Vec3) {
        let Some(place) = &self.place else {
            return self.triangle.point(weights);
        };
        let [a, b, c] = self.triangle.corners.map(Vec3::as_dvec3);
        let [_, v, w] = weights.map(f64::from);
        let local = a + (b - a) * v + (c - a) * w;
        let point = place.point(local).as_vec3();
        // Rounding the point counts once. Once local again, a ray's origin is rounded, and its direction, which moves the ray
        // by as much again over the width of the triangle. So do, for rays along the surface, the normal that tells above
        // from below (1 rounding) and its product with the direction (3); the rest is for terms of second order.
        let local_error = local.abs() * f64::from(gamma(2)) + self.width() * f64::from(gamma(7));
        let error = point.abs() * gamma(1) + place.turn.largest(local_error).as_vec3();
        (point, error)
    }

    /// How far a ray aimed at a point of [`PlacedTriangle::in_scene`] may miss it.
    #[must_use]
    pub fn aiming_error(&self) -> AimingError {
        let Some(place) = &self.place else {
            return AimingError {
                near: Vec3::ZERO,
                per_distance: gamma(1),
            };
        };
        // The corners' rounding on the way into the scene, and that of a local ray near the triangle.
        let [a, b, c] = self.triangle.corners.map(|corner| corner.abs().as_dvec3());
        let local = a.max(b).max(c) * f64::from(gamma(2));
        let [a, b, c] = self.in_scene().corners.map(Vec3::abs);
        AimingError {
            near: place.turn.largest(local).as_vec3() + a.max(b).max(c) * gamma(1),
            per_distance: gamma(3),
        }
    }

    /// The unit normal on the outside; zero for a triangle without area.
    #[must_use]
    #[inline]
    pub fn normal(&self) -> Vec3 {
        let Some(place) = &self.place else {
            return self.triangle.normal();
        };
        let [a, b, c] = self.triangle.corners.map(Vec3::as_dvec3);
        let (ab, ac) = (place.turn.apply(b - a), place.turn.apply(c - a));
        // Lengths near 1 first: the square of a tiny copy's area could vanish.
        let share = place.turn.scale().recip();
        (ab * share).cross(ac * share).normalize_or_zero().as_vec3()
    }

    /// Unit vectors that belong to the corners of the triangle as it is stored, such as shading normals, turned into the
    /// prepared scene and in the order of its corners there.
    #[must_use]
    #[inline]
    pub fn directions_in_scene(&self, stored: [Vec3; 3]) -> [Vec3; 3] {
        let Some(Place { turn, .. }) = &self.place else {
            return stored;
        };
        let share = turn.scale().recip();
        let turned = stored.map(|v| (turn.apply(v.as_dvec3()) * share).as_vec3());
        outward(turned, turn.is_mirrored())
    }

    /// Edge lengths of the box around the stored triangle.
    fn width(&self) -> DVec3 {
        self.triangle.bounds().size().as_dvec3()
    }
}

/// Bound on how far, along each axis, a ray may miss a point of a triangle that it is aimed at, beyond the rounding of that
/// point. A light's point this much in front of the light is not shadowed by it.
#[derive(Clone, Copy, Debug)]
pub struct AimingError {
    near: Vec3,
    /// The way to the point is rounded when it becomes a direction; so are origin and direction of a local ray.
    per_distance: f32,
}

impl AimingError {
    /// The bound for a ray from `distance` away.
    #[must_use]
    pub fn from(&self, distance: f32) -> Vec3 {
        self.near + distance * self.per_distance
    }
}

/// Three things that belong to corners, in the order that is counter-clockwise seen from outside: mirroring turns
/// triangles inside out, and swapping two corners turns them back.
pub(super) fn outward<T: Copy>([a, b, c]: [T; 3], is_mirrored: bool) -> [T; 3] {
    if is_mirrored { [a, c, b] } else { [a, b, c] }
}
