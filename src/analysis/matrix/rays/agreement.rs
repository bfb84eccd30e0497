//! The trees against brute force, which must answer with the same bits.

use std::sync::atomic::{AtomicU64, Ordering};

use super::aims::{Surroundings, lattice_direction};
use super::scenes::{
    Build, brute_force, kd_tree, placed_copies, scenes, trees, wide_tree, without_copies,
};
use super::{below, count_over};
use crate::accel::{Assembly, BruteForce, Fan, Hit, Packet};
use crate::analysis::matrix::Effort;
use crate::analysis::matrix::meshes::{narrowed, stadium};
use crate::geometry::Triangle;
use crate::geometry::shapes::{self, Random};
use crate::math::{DVec3, Ray, Vec3};

/// A scene by brute force and by either tree, which must answer alike.
struct Twins {
    /// Where its rays may aim; those of copies are rounded.
    triangles: Vec<Triangle>,
    all: Assembly,
    trees: [Assembly; 2],
}

impl Twins {
    fn new(scene: impl Fn(Build) -> Assembly) -> Self {
        let all = scene(brute_force);
        let ids = 0..all.triangle_count();
        Self {
            triangles: ids.map(|id| all.triangle(id).in_scene()).collect(),
            trees: [scene(kd_tree), scene(wide_tree)],
            all,
        }
    }

    /// How many of these rays, asked for alone and as one packet, a tree answers differently; and how many of them hit.
    fn different_and_hits(&self, rays: &[(Ray, f32)]) -> [u64; 2] {
        let packet = Packet::new(rays);
        let packets = self.trees.each_ref();
        let packets = packets.map(|tree| tree.intersect_packet(&packet));
        let (mut different, mut hits) = (0, 0);
        for (index, &(ray, t_max)) in rays.iter().enumerate() {
            let expected = self.all.intersect(&ray, t_max);
            let differs = self.trees.iter().zip(&packets).any(|(tree, in_packet)| {
                bits(tree.intersect(&ray, t_max)) != bits(expected)
                    || bits(in_packet[index]) != bits(expected)
                    || tree.occluded(&ray, t_max) != expected.is_some()
            });
            different += u64::from(differs);
            hits += u64::from(expected.is_some());
        }
        [different, hits]
    }

    /// How many rays of a fan a tree answers differently.
    fn different_in_fan(&self, fan: &Fan<'_>) -> u64 {
        let expected = fan.each(|ray| self.all.occluded(ray, 1.0));
        let trees = self.trees.iter();
        let wrong = trees.fold(0, |wrong, tree| wrong | (tree.occluded_fan(fan) ^ expected));
        u64::from(wrong.count_ones())
    }
}

pub fn bits(hit: Option<Hit>) -> Option<(u32, u32, [u32; 3])> {
    hit.map(|hit| {
        let weights = hit.barycentrics.map(f32::to_bits);
        (hit.triangle, hit.t.to_bits(), weights)
    })
}

pub fn unlike_brute_force(effort: Effort) -> f64 {
    let scenes = scenes();
    let once = scenes.iter();
    let once = once.map(|triangles| Twins::new(|build| without_copies(triangles, build)));
    let scenes: Vec<_> = once.chain([Twins::new(placed_copies)]).collect();
    let rays_each = effort.pick(100_000, 100_000_000) / scenes.len() as u64;
    // So many packets as the rays come, for one packet and one fan of rays that belong together.
    let rarity = effort.pick(4, 32);
    let tested = rays_each * scenes.len() as u64;
    let hits = AtomicU64::new(0);
    let mut count = 0.0;
    for scene in &scenes {
        let around = Surroundings::of(&scene.triangles);
        count += count_over(rays_each, |random, count| {
            let (mut different, mut left, mut turn) = (0, count, 0);
            while left > 0 {
                let some = left.min(Packet::MOST_RAYS as u64);
                left -= some;
                let rays: Vec<_> = (0..some)
                    .map(|_| (around.ray(random), f32::INFINITY))
                    .collect();
                let [wrong, met] = scene.different_and_hits(&rays);
                different += wrong;
                hits.fetch_add(met, Ordering::Relaxed);
                if turn % rarity == 0 {
                    let [wrong, _] = scene.different_and_hits(&around.packet(random));
                    let (origin, normal, directions) = around.fan(random);
                    let fan = Fan::new(origin, normal, &directions);
                    different += wrong + scene.different_in_fan(&fan);
                }
                turn += 1;
            }
            different
        });
    }
    let hits = hits.into_inner();
    assert!(
        (tested / 20..tested - tested / 20).contains(&hits),
        "{hits} of {tested} rays hit"
    );
    count
}

pub fn along_the_axes(effort: Effort) -> f64 {
    let meshes = [
        shapes::axis_aligned(400, 8, 3),
        shapes::grid(12),
        shapes::cuboid(DVec3::NEG_ONE, DVec3::ONE),
        stadium(),
    ];
    let mut count = 0.0;
    for mesh in &meshes {
        let triangles = narrowed(mesh);
        let (trees, all) = (trees(&triangles), BruteForce::new(triangles.clone()));
        let around = Surroundings::of(&triangles);
        count += count_over(effort.pick(5_000, 200_000), |random, count| {
            let differs = |random: &mut Random| {
                let mut of_corner = || triangles[below(random, triangles.len())].corners[1];
                let mut origin = Vec3::new(of_corner().x, of_corner().y, of_corner().z);
                let direction = lattice_direction(below(random, 64));
                if direction == Vec3::ZERO {
                    return false;
                }
                if random.bits().is_multiple_of(2) {
                    origin -= (direction.as_dvec3() * (around.size * 4.0)).as_vec3();
                }
                let ray = Ray::new(origin, direction);
                let expected = bits(all.intersect(&ray, f32::INFINITY));
                trees
                    .iter()
                    .any(|tree| bits(tree.intersect(&ray, f32::INFINITY)) != expected)
            };
            (0..count).map(|_| u64::from(differs(random))).sum()
        });
    }
    count
}

pub fn scaled_directions(effort: Effort) -> f64 {
    let triangles = narrowed(&shapes::soup(300, 0.3, 4));
    let trees = trees(&triangles);
    let around = Surroundings::of(&triangles);
    count_over(effort.pick(20_000, 2_000_000), |random, count| {
        let differs = |random: &mut Random| {
            let ray = around.ray(random);
            let base = trees[0].intersect(&ray, f32::INFINITY);
            [-40, 40].into_iter().any(|exponent| {
                let factor = 2_f32.powi(exponent);
                let scaled = Ray::new(ray.origin, ray.direction * factor);
                let back = |hit: Hit| Hit {
                    t: hit.t * factor,
                    ..hit
                };
                trees.iter().any(|tree| {
                    bits(tree.intersect(&scaled, f32::INFINITY).map(back)) != bits(base)
                })
            })
        };
        (0..count).map(|_| u64::from(differs(random))).sum()
    })
}
