//! Rays that aim at the cracks of a closed body from within.

use super::scenes::trees;
use super::{below, count_over};
use crate::accel::{Accelerator, Fan, Packet};
use crate::analysis::matrix::Effort;
use crate::analysis::matrix::meshes::narrowed;
use crate::analysis::matrix::stage::mapped;
use crate::geometry::Triangle;
use crate::geometry::shapes::{self, Random};
use crate::math::{DVec3, Ray, Vec3};

/// A closed body with a rough surface, placed by `change`, and rays at its weakest points.
pub struct RoughBody {
    pub triangles: Vec<Triangle>,
    middle: DVec3,
    /// Of its largest radius.
    size: f64,
}

impl RoughBody {
    pub fn new(change: impl Fn(Vec3) -> Vec3) -> Self {
        let mut random = Random::new(5);
        let rough = mapped(shapes::icosphere(3), |p| p * (0.5 + 0.5 * random.unit()));
        let placed = |t: &Triangle| Triangle {
            corners: t.corners.map(&change),
        };
        Self {
            triangles: narrowed(&rough).iter().map(placed).collect(),
            middle: change(Vec3::ZERO).as_dvec3(),
            size: f64::from((change(Vec3::X) - change(Vec3::ZERO)).length()),
        }
    }

    /// A place near the middle.
    fn origin(&self, random: &mut Random) -> Vec3 {
        (self.middle + random.in_cube() * 0.1 * self.size).as_vec3()
    }

    /// A corner of a triangle, or a point on an edge of it.
    fn target(&self, triangle: usize, random: &mut Random) -> Vec3 {
        let corners = self.triangles[triangle].corners;
        let [a, b, _] = corners.map(Vec3::as_dvec3);
        let share = if random.bits().is_multiple_of(2) {
            0.0
        } else {
            random.unit()
        };
        (a + (b - a) * share).as_vec3()
    }

    /// From near the middle to a corner or an edge.
    fn ray(&self, random: &mut Random) -> Ray {
        let origin = self.origin(random);
        let triangle = below(random, self.triangles.len());
        Ray::new(origin, self.target(triangle, random) - origin)
    }

    /// How many of `rays` get out without meeting anything.
    pub fn escapes(&self, rays: u64, meets: impl Fn(&Ray) -> bool + Sync) -> f64 {
        count_over(rays, |random, count| {
            let escapes = (0..count).filter(|_| !meets(&self.ray(random)));
            escapes.count() as u64
        })
    }

    /// The same of packets of rays from one place to triangles that mostly lie next to each other.
    fn escapes_in_packets(&self, rays: u64, tree: &Accelerator) -> f64 {
        count_over(rays, |random, count| {
            let packets = count.div_ceil(Packet::MOST_RAYS as u64);
            let escapes = (0..packets).map(|_| {
                let origin = self.origin(random);
                let first = below(random, self.triangles.len());
                let rays: Vec<_> = (first..first + Packet::MOST_RAYS)
                    .map(|triangle| {
                        let target = self.target(triangle % self.triangles.len(), random);
                        (Ray::new(origin, target - origin), f32::INFINITY)
                    })
                    .collect();
                let hits = tree.intersect_packet(&Packet::new(&rays));
                (rays.len() - hits.iter().flatten().count()) as u64
            });
            escapes.sum()
        })
    }

    /// The same of fans of rays that end outside, from one place to all that lies on one side of it.
    fn escapes_in_fans(&self, rays: u64, tree: &Accelerator) -> f64 {
        /// The body is between 0.5 and 1 times its size around the middle and rays start less than 0.2 from it, so that this many times the
        /// way to any of its points leads out of it.
        const BEYOND: f32 = 4.0;
        count_over(rays, |random, count| {
            let fans = count.div_ceil(Fan::MOST_RAYS as u64);
            let escapes = (0..fans).map(|_| {
                let origin = self.origin(random);
                let normal = random.in_cube().as_vec3();
                let outwards = || {
                    let triangle = below(random, self.triangles.len());
                    (self.target(triangle, random) - origin) * BEYOND
                };
                let directions: Vec<_> = std::iter::repeat_with(outwards)
                    .filter(|direction| direction.dot(normal) >= 0.0)
                    .take(Fan::MOST_RAYS)
                    .collect();
                let met = tree.occluded_fan(&Fan::new(origin, normal, &directions));
                directions.len() as u64 - u64::from(met.count_ones())
            });
            escapes.sum()
        })
    }
}

pub fn escapes(effort: Effort) -> f64 {
    let changes: [fn(Vec3) -> Vec3; 5] = [
        |p| p,
        |p| p + 1000.0,
        |p| p + Vec3::new(-30.0, 4e4, 0.7),
        |p| p * 2_f32.powi(-60),
        |p| p * 2_f32.powi(60),
    ];
    let mut count = 0.0;
    for change in changes {
        let body = RoughBody::new(change);
        for tree in &trees(&body.triangles) {
            count += body.escapes(effort.pick(100_000, 100_000_000) / 10, |ray| {
                tree.intersect(ray, f32::INFINITY).is_some() && tree.occluded(ray, f32::INFINITY)
            });
            let together = effort.pick(10_000, 1_000_000);
            count += body.escapes_in_packets(together, tree);
            count += body.escapes_in_fans(together, tree);
        }
    }
    count
}
