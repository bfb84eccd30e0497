//! The meeting of one ray with one triangle, decided exactly.
//!
//! The corners and the ray are `f32`. Whether the ray meets the triangle, and whether it does so in front of its
//! origin, is answered as real arithmetic on those numbers would answer it; the hit's `t` is off by less than one unit
//! in the last place. Nearly every test is settled by `f64` arithmetic whose error bound says that it cannot be wrong;
//! the rest by exact sums. So meshes have no cracks, no answer depends on a scale, and any other structure or kernel
//! can be held to the same bits.

mod exact;

use crate::math::{Bounds, DVec3, Ray, Vec3, robust};

/// A triangle in the prepared scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// The corners, counter-clockwise seen from outside; finite.
    pub corners: [Vec3; 3],
}

impl Triangle {
    /// The box around the corners.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        Bounds::of_points(self.corners)
    }

    /// The unit normal on the side from which the corners turn counter-clockwise; zero for a triangle without area.
    #[must_use]
    #[inline]
    pub fn normal(&self) -> Vec3 {
        self.doubled_area_normal().normalize_or_zero().as_vec3()
    }

    /// The area.
    #[must_use]
    pub fn area(&self) -> f32 {
        narrowed(self.doubled_area_normal().length() / 2.0)
    }

    /// The point with these weights of the corners, and a bound on the rounding error of each of its coordinates. It lies
    /// far closer to the plane than `origin + t · direction` of a ray would.
    #[must_use]
    #[inline]
    pub fn point(&self, [u, v, w]: [f32; 3]) -> (Vec3, Vec3) {
        let [a, b, c] = self.corners;
        // Each coordinate is rounded four times: its weight, the product, two sums.
        let error = ((a * u).abs() + (b * v).abs() + (c * w).abs()) * robust::gamma(4);
        (a * u + b * v + c * w, error)
    }

    /// In f64, so that slivers have a normal too: edges of f32 corners are exact there but for a last digit.
    fn doubled_area_normal(&self) -> DVec3 {
        let [a, b, c] = self.corners.map(Vec3::as_dvec3);
        (b - a).cross(c - a)
    }
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Ray parameter, in multiples of the ray's direction; positive.
    pub t: f32,
    /// Weights of the three corners at the hit point: none negative, sum 1 up to rounding.
    pub barycentrics: [f32; 3],
}

impl TriangleHit {
    /// Every number rounded once; none where `t` rounds to 0 or is negative.
    #[inline]
    fn rounded(t: f64, weights: [f64; 3]) -> Option<Self> {
        Self::on_ray(narrowed(t), weights.map(narrowed))
    }

    /// None where `t` is 0 or negative.
    #[inline]
    pub(crate) fn on_ray(t: f32, barycentrics: [f32; 3]) -> Option<Self> {
        (0.0 < t).then_some(Self { t, barycentrics })
    }
}

/// A ray prepared for tests against many triangles.
///
/// The axes are renamed so that z is the one the direction is longest along, then space is moved and sheared so that
/// the ray starts at the origin and runs along z. What is left is the question whether the origin of the xy plane lies
/// in the projected triangle, answered by the signs of three edge functions.
///
/// An edge shared by two triangles gives both the same number with opposite signs, and edges count as inside: a ray
/// through an edge hits at least one of the two. A ray in the plane of a triangle does not hit it.
///
/// Source: Woop, Benthin, Wald, Watertight Ray/Triangle Intersection, JCGT 2(1), 2013, here in `f64`, with an error
/// bound and an exact last resort in place of their fallback.
#[derive(Clone, Copy, Debug)]
pub struct RayKernel {
    ray: Ray,
    /// Which axis of space is called x, y and z; a cyclic permutation.
    pub(crate) axes: [usize; 3],
    /// The ray's origin, axes renamed.
    pub(crate) origin: [f64; 3],
    /// Change of x and y per z along the ray; at most 1 in magnitude.
    pub(crate) shear: [f64; 2],
    /// The direction's z component, axes renamed.
    pub(crate) direction_z: f64,
}

impl RayKernel {
    /// Bounds the distance between an edge function as computed and its exact value.
    ///
    /// With u the unit roundoff, x, y, z a corner minus the origin (axes renamed), s the shear and p = x − s·z a sheared
    /// coordinate: each of the differences x and z carries a relative error u, s another, the product s·z another and the
    /// last difference another. As |s| ≤ 1 and |x| ≤ |p| + |z|, the error of p is at most u (2 |p| + 4 |z|) plus terms in u².
    /// Let P be the largest |p| of the triangle's six and Z the largest |z|. An edge function p₁p₂ − p₃p₄ inherits
    /// 4 P e + 2 e² from errors e of its factors and adds 4 u P² of its own. With h = 4 u (P + Z) ≥ u P + e, all of that is
    /// at most 4 h (P + h). The factor 4.01 in place of 4 pays for the terms in u² and for rounding in the bound itself.
    pub(crate) const EDGE_ERROR_PER_ROUNDOFF: f64 = 4.01;

    /// `h / (P + Z)` of that bound for `f64` arithmetic.
    pub(crate) const EDGE_ERROR: f64 = Self::EDGE_ERROR_PER_ROUNDOFF * (f64::EPSILON * 0.5);

    /// How much larger than its error bound the numerator of `t` must be for `t`, rounded to `f32`, to be off by less than one
    /// unit in the last place: the quotient is then right to 2⁻²⁵ of itself, at most half a unit, and rounding adds half.
    pub(crate) const CERTAIN_T: f64 = (1_u32 << 26) as f64;

    /// Prepares `ray`, whose direction must not be zero.
    #[must_use]
    #[inline]
    pub fn new(ray: &Ray) -> Self {
        Self::with_axes(ray, Self::axes_of(ray))
    }

    /// [`Self::new`], given what [`Self::axes_of`] says of the ray.
    #[inline]
    pub(crate) fn with_axes(ray: &Ray, axes: [usize; 3]) -> Self {
        let [x, y, z] = axes;
        let renamed = |v: [f32; 3]| [f64::from(v[x]), f64::from(v[y]), f64::from(v[z])];
        let direction = renamed(ray.direction.to_array());
        Self {
            ray: *ray,
            axes,
            origin: renamed(ray.origin.to_array()),
            shear: [direction[0] / direction[2], direction[1] / direction[2]],
            direction_z: direction[2],
        }
    }

    /// The hit with `triangle` if its `t`, rounded to `f32`, lies in `0 < t < t_max`.
    ///
    /// Both sides count. A triangle without area is never hit.
    #[must_use]
    pub fn intersect(&self, triangle: &Triangle, t_max: f32) -> Option<TriangleHit> {
        let [a, b, c] = triangle.corners;
        let (a, b, c) = (self.sheared(a), self.sheared(b), self.sheared(c));

        // Edge functions: twice the areas of the origin with each edge. A fused multiply-add here would round the two
        // products differently and open the shared edges.
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let extent = largest([a[0], a[1], b[0], b[1], c[0], c[1]]);
        let depth = largest([a[2], b[2], c[2]]);
        let h = Self::EDGE_ERROR * (extent + depth);
        let edge_error = 4.0 * h * (extent + h) + f64::MIN_POSITIVE;
        let (lowest, highest) = (u.min(v).min(w), u.max(v).max(w));
        if lowest < -edge_error && highest > edge_error {
            return None;
        }

        // z at the hit is a weighted mean of the corners' z. With E the bound on an edge function: as no two have different signs
        // beyond E, their magnitudes sum to at most |D| + 4 E. The determinant D inherits 3 E and is rounded twice, in all less
        // than 4 E, as E is at least 16 u P² and |D| at most 6 P². The weighted z inherits 3 E Z, and each of its terms is rounded
        // at most four times: 3 E Z + 4 u Z (|D| + 4 E) in all, which 4 E Z + 8 u Z |D| exceeds.
        let determinant = u + v + w;
        let weighted_z = u * a[2] + v * b[2] + w * c[2];
        let z_error = depth * (4.0 * edge_error + 4.0 * f64::EPSILON * determinant.abs());
        let denominator = determinant * self.direction_z;
        let behind = weighted_z * denominator < 0.0;
        if behind && determinant.abs() > 4.0 * edge_error && weighted_z.abs() > z_error {
            return None;
        }

        let inside = lowest > edge_error || highest < -edge_error;
        let (t, weights) = if inside && weighted_z.abs() > Self::CERTAIN_T * z_error {
            let share = determinant.recip();
            (weighted_z / denominator, [u * share, v * share, w * share])
        } else {
            exact::intersect(&self.ray, triangle)?
        };

        TriangleHit::rounded(t, weights).filter(|hit| hit.t < t_max)
    }

    /// Which axis of space the kernel of `ray` calls x, y and z; z is the one its direction is longest along.
    #[inline]
    pub(crate) fn axes_of(ray: &Ray) -> [usize; 3] {
        let length = ray.direction.abs();
        let x_or_y = usize::from(length.y > length.x);
        let longer = if length.y > length.x {
            length.y
        } else {
            length.x
        };
        let is_z = length.z > longer;
        Self::axes_along(if is_z { 2 } else { x_or_y })
    }

    /// [`Self::axes_of`] rays that are longest along this axis.
    #[inline]
    pub(crate) fn axes_along(longest: usize) -> [usize; 3] {
        // A table, as branches on random directions cannot be foreseen.
        const AXES: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];
        AXES[longest]
    }

    fn sheared(&self, corner: Vec3) -> [f64; 3] {
        let corner = corner.to_array();
        let [x, y, z] = self.axes;
        let z = f64::from(corner[z]) - self.origin[2];
        [
            (f64::from(corner[x]) - self.origin[0]) - self.shear[0] * z,
            (f64::from(corner[y]) - self.origin[1]) - self.shear[1] * z,
            z,
        ]
    }
}

fn largest<const N: usize>(values: [f64; N]) -> f64 {
    values.into_iter().fold(0.0, |m, value| value.abs().max(m))
}

/// The nearest `f32`.
#[expect(
    clippy::cast_possible_truncation,
    reason = "the rounding is the purpose"
)]
pub(super) fn narrowed(value: f64) -> f32 {
    value as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::Random;
    use crate::math::DVec3;

    type Point = [i128; 3];

    fn minus(p: Point, q: Point) -> Point {
        [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
    }

    fn determinant(p: Point, q: Point, r: Point) -> i128 {
        p[0] * (q[1] * r[2] - q[2] * r[1])
            + p[1] * (q[2] * r[0] - q[0] * r[2])
            + p[2] * (q[0] * r[1] - q[1] * r[0])
    }

    /// The exact answer for whole numbers: numerator and denominator of `t`.
    fn reference([o, d, a, b, c]: [Point; 5]) -> Option<(i128, i128)> {
        let [a, b, c] = [a, b, c].map(|p| minus(p, o));
        let edges = [
            determinant(d, b, c),
            determinant(d, c, a),
            determinant(d, a, b),
        ];
        let total: i128 = edges.iter().sum();
        let inside = edges.iter().all(|&e| e >= 0) || edges.iter().all(|&e| e <= 0);
        let t = (determinant(a, b, c), total);
        (inside && total != 0 && t.0 * t.1.signum() > 0).then_some(t)
    }

    /// Compares kernel and reference; returns whether it is a hit.
    fn assert_exact(points: [Point; 5]) -> bool {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "chosen to fit; checked here"
        )]
        let [o, d, a, b, c] = points.map(|p| {
            assert!(
                p.iter().all(|&x| (x as f32) as i128 == x),
                "{p:?} does not fit f32"
            );
            Vec3::from_array(p.map(|x| x as f32))
        });
        let triangle = Triangle { corners: [a, b, c] };
        let hit = RayKernel::new(&Ray::new(o, d)).intersect(&triangle, f32::INFINITY);
        let expected = reference(points).map(|(p, q)| p as f64 / q as f64);
        match (hit, expected) {
            (Some(hit), Some(t)) => {
                let (below, above) = (f64::from(hit.t.next_down()), f64::from(hit.t.next_up()));
                assert!(below < t && t < above, "{points:?}: {t}, not {}", hit.t);
                let weights: f32 = hit.barycentrics.iter().sum();
                assert!((weights - 1.0).abs() < 1e-6 && hit.barycentrics.iter().all(|&w| w >= 0.0));
            }
            (hit, expected) => {
                assert_eq!(
                    hit.is_some(),
                    expected.is_some(),
                    "{points:?}: {hit:?}, {expected:?}"
                );
            }
        }
        hit.is_some()
    }

    fn whole(random: &mut Random, below: u64) -> i128 {
        i128::from(random.bits() % (2 * below + 1)) - i128::from(below)
    }

    /// On a small lattice one ray in a few runs through an edge, a vertex, a plane, or starts on one of them.
    #[test]
    fn the_answer_is_exact_on_a_small_lattice() {
        let mut random = Random::new(1);
        let mut hits = 0;
        for _ in 0..400_000 {
            let points = [(); 5].map(|()| [(); 3].map(|()| whole(&mut random, 3)));
            if points[1] != [0, 0, 0] {
                hits += usize::from(assert_exact(points));
            }
        }
        assert!(hits > 15_000, "only {hits} hits");
    }

    /// Coordinates with 24 digits at different places, so that differences need more than `f32` holds.
    #[test]
    fn the_answer_is_exact_for_coordinates_of_many_sizes() {
        let mut random = Random::new(2);
        let mut hits = 0;
        for _ in 0..200_000 {
            let points = [(); 5].map(|()| {
                [(); 3].map(|()| whole(&mut random, (1 << 24) - 1) << (random.bits() % 12))
            });
            hits += usize::from(assert_exact(points));
        }
        assert!(hits > 5000, "only {hits} hits");
    }

    /// Rays in the triangle's plane or almost, through its edges and corners or almost: where `f64` cannot tell the signs.
    #[test]
    fn the_answer_is_exact_at_grazing_incidence() {
        let mut random = Random::new(3);
        let mut hits = 0;
        for _ in 0..400_000 {
            let mut far = || [(); 3].map(|()| whole(&mut random, (1 << 12) - 1));
            let (o, e, f) = (far(), far(), far());
            // A lattice of the plane through the origin, spanned by e and f; often left by a unit.
            let mut in_plane = |from: Point| {
                let (k, l) = (whole(&mut random, 40), whole(&mut random, 40));
                let off = whole(&mut random, 1) * whole(&mut random, 1);
                let axis = (random.bits() % 3) as usize;
                let mut point = [0, 1, 2].map(|i| from[i] + k * e[i] + l * f[i]);
                point[axis] += off;
                point
            };
            let (d, a, b, c) = (in_plane([0; 3]), in_plane(o), in_plane(o), in_plane(o));
            if d == [0; 3] {
                continue;
            }
            hits += usize::from(assert_exact([o, d, a, b, c]));
        }
        assert!(hits > 5000, "only {hits} hits");
    }

    #[test]
    fn both_orders_of_a_shared_edge_agree_and_the_edge_counts() {
        let mut random = Random::new(4);
        for _ in 0..100_000 {
            let [o, a, b] = [(); 3].map(|()| random.in_cube());
            let (c, d) = (random.in_cube(), random.in_cube());
            let [o, a, b, c, d] = [o, a, b, c, d].map(DVec3::as_vec3);
            // On either side of the edge as seen from the origin, so that both triangles together surround its middle.
            let normal = (a - o).cross(b - o);
            if (normal.dot(c - o) > 0.0) == (normal.dot(d - o) > 0.0) {
                continue;
            }
            let ray = Ray::new(o, (a + b) * 0.5 - o);
            let kernel = RayKernel::new(&ray);
            let hit = |corners| kernel.intersect(&Triangle { corners }, f32::INFINITY);
            assert!(
                hit([a, b, c]).is_some() || hit([b, a, d]).is_some(),
                "{ray:?} {a} {b} {c} {d}"
            );
        }
    }
}
