//! How near a triangle comes to a disk, seen from the disk.

use crate::math::DVec3;

/// The coordinates of a disk: the unit circle around the origin of x and y is its rim, z its height in radii, positive in front.
#[derive(Clone, Copy, Debug)]
pub struct DiskSpace {
    center: DVec3,
    /// Unit vectors.
    axes: [DVec3; 3],
    radius: f64,
}

impl DiskSpace {
    /// The coordinates of the disk around `center` with a unit normal and a radius above 0.
    pub fn new(center: DVec3, normal: DVec3, radius: f64) -> Self {
        let x = normal.any_orthonormal_vector();
        Self {
            center,
            axes: [x, normal.cross(x), normal],
            radius,
        }
    }

    /// The middle of the disk.
    pub fn center(&self) -> DVec3 {
        self.center
    }

    /// Between which heights the part of a triangle lies that is right over or under the disk and no higher or lower than
    /// `limit` radii; `None` where no part is.
    pub fn heights(&self, corners: [DVec3; 3], limit: f64) -> Option<[f64; 2]> {
        let local = corners.map(|corner| {
            let from_center = (corner - self.center) / self.radius;
            DVec3::from_array(self.axes.map(|axis| from_center.dot(axis)))
        });
        let below = clipped(&local, |p| limit - p.z);
        let polygon = clipped(&below, |p| limit + p.z);
        let heights = heights_in_unit_circle(&polygon);
        let lowest = heights.iter().copied().reduce(f64::min)?;
        let highest = heights.iter().copied().reduce(f64::max)?;
        Some([lowest, highest])
    }
}

/// The part of a convex polygon where `inside` is not negative.
///
/// Source: Sutherland & Hodgman, Reentrant Polygon Clipping, 1974.
fn clipped(polygon: &[DVec3], inside: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut result = Vec::with_capacity(polygon.len() + 1);
    for (index, &b) in polygon.iter().enumerate() {
        let a = polygon[(index + polygon.len() - 1) % polygon.len()];
        let (at_a, at_b) = (inside(a), inside(b));
        if (at_a < 0.0) != (at_b < 0.0) {
            result.push(a + (b - a) * (at_a / (at_a - at_b)));
        }
        if at_b >= 0.0 {
            result.push(b);
        }
    }
    result
}

/// Heights z of a flat convex polygon at points over the unit circle's disk, the lowest and the highest among them: at its
/// corners, where its edges pass the circle, and where its plane is lowest and highest over the circle.
fn heights_in_unit_circle(polygon: &[DVec3]) -> Vec<f64> {
    let over_disk = |p: &&DVec3| p.x * p.x + p.y * p.y <= 1.0;
    let mut heights: Vec<f64> = polygon.iter().filter(over_disk).map(|p| p.z).collect();
    for (index, &b) in polygon.iter().enumerate() {
        let a = polygon[(index + polygon.len() - 1) % polygon.len()];
        for t in passes_of_unit_circle(a, b) {
            heights.push(a.z + (b.z - a.z) * t);
        }
    }
    let Some(normal) = normal_of(polygon).filter(|normal| normal.z != 0.0) else {
        return heights;
    };
    let slope = [-normal.x / normal.z, -normal.y / normal.z];
    let steepness = slope[0].hypot(slope[1]);
    // Any point will do where the plane is level.
    let towards = if steepness > 0.0 {
        slope.map(|part| part / steepness)
    } else {
        [0.0, 0.0]
    };
    for sign in [-1.0, 1.0] {
        let [x, y] = towards.map(|part| part * sign);
        if has_over(polygon, x, y) {
            let from = polygon[0];
            heights.push(from.z + slope[0] * (x - from.x) + slope[1] * (y - from.y));
        }
    }
    heights
}

/// A normal of any length; `None` where there is no area.
fn normal_of(polygon: &[DVec3]) -> Option<DVec3> {
    let &from = polygon.first()?;
    let sum = polygon
        .windows(2)
        .map(|pair| (pair[0] - from).cross(pair[1] - from))
        .sum::<DVec3>();
    (sum != DVec3::ZERO).then_some(sum)
}

/// At which shares of the way from `a` to `b` the unit circle is passed, seen along z.
fn passes_of_unit_circle(a: DVec3, b: DVec3) -> impl Iterator<Item = f64> {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let (square, half) = (dx * dx + dy * dy, a.x * dx + a.y * dy);
    let root = (half * half - square * (a.x * a.x + a.y * a.y - 1.0)).sqrt();
    // NaN where it is not passed.
    [(-half - root) / square, (-half + root) / square]
        .into_iter()
        .filter(|t| (0.0..=1.0).contains(t))
}

/// Whether a convex polygon has the point (x, y), seen along z.
fn has_over(polygon: &[DVec3], x: f64, y: f64) -> bool {
    let side = |index: usize| {
        let a = polygon[(index + polygon.len() - 1) % polygon.len()];
        let b = polygon[index];
        (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x)
    };
    let sides = || (0..polygon.len()).map(side);
    sides().all(|side| side >= 0.0) || sides().all(|side| side <= 0.0)
}

/// The distance of a point to a triangle.
pub fn distance_to_triangle(point: DVec3, corners: [DVec3; 3]) -> f64 {
    (point - nearest_on_triangle(point, corners)).length()
}

/// The point of a triangle that is nearest to `point`.
///
/// Source: Ericson, Real-Time Collision Detection, 2004, 5.1.5, with the edges by themselves.
pub fn nearest_on_triangle(point: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let normal = (b - a).cross(c - a);
    let is_over = |from: DVec3, to: DVec3| normal.dot((to - from).cross(point - from)) >= 0.0;
    if normal != DVec3::ZERO && is_over(a, b) && is_over(b, c) && is_over(c, a) {
        let normal = normal.normalize_or_zero();
        return point - normal * normal.dot(point - a);
    }
    let on_edge = |from: DVec3, to: DVec3| {
        let along = to - from;
        let t = (point - from).dot(along) / along.length_squared();
        // An edge without length is its start.
        let t = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) };
        from + along * t
    };
    let nearer = |p: DVec3, q: DVec3| {
        if point.distance_squared(q) < point.distance_squared(p) {
            q
        } else {
            p
        }
    };
    nearer(nearer(on_edge(a, b), on_edge(b, c)), on_edge(c, a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::Random;

    /// Against many points of the triangle.
    #[test]
    fn heights_and_distances_are_those_of_the_nearest_points() {
        const STEPS: u32 = 300;
        let mut random = Random::new(5);
        let mut found = 0;
        for _ in 0..300 {
            let mut point = || random.in_cube() * 2.0;
            let (center, normal, corners) =
                (point(), point().normalize(), [point(), point(), point()]);
            let (radius, limit) = (0.5 + random.unit(), 0.05 + random.unit());
            let space = DiskSpace::new(center, normal, radius);
            let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
            let mut nearest = f64::INFINITY;
            for i in 0..=STEPS {
                for j in 0..=STEPS - i {
                    let (u, v) = (
                        f64::from(i) / f64::from(STEPS),
                        f64::from(j) / f64::from(STEPS),
                    );
                    let p = corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v;
                    nearest = nearest.min((p - center).length());
                    let height = (p - center).dot(normal) / radius;
                    let aside = (p - center - normal * (height * radius)).length() / radius;
                    if aside <= 1.0 && height.abs() <= limit {
                        lowest = lowest.min(height);
                        highest = highest.max(height);
                    }
                }
            }
            let distance = distance_to_triangle(center, corners);
            assert!(distance <= nearest + 1e-12 && nearest < distance + 0.02);
            match space.heights(corners, limit) {
                None => assert_eq!(lowest, f64::INFINITY),
                Some([low, high]) => {
                    found += 1;
                    assert!(low <= lowest + 1e-12 && highest <= high + 1e-12);
                    // Thin pieces slip through the points.
                    if highest - lowest > 0.1 {
                        assert!(lowest < low + 0.05 && high < highest + 0.05);
                    }
                }
            }
        }
        assert!(found > 30, "{found}");
    }

    #[test]
    fn a_level_triangle_far_larger_than_the_disk_has_one_height() {
        let space = DiskSpace::new(DVec3::Z, DVec3::NEG_Z, 0.1);
        let corners = [
            DVec3::X * 100.0,
            DVec3::Y * 100.0,
            DVec3::new(-90.0, -90.0, 0.0),
        ];
        let [low, high] = space.heights(corners, 20.0).expect("is under the disk");
        assert!((low - 10.0).abs() < 1e-12 && (high - 10.0).abs() < 1e-12);
        assert_eq!(space.heights(corners, 9.0), None);
    }
}
