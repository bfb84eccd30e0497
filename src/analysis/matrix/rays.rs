//! Rays that graze, aim at cracks, run along planes and start on what they left.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use super::meshes::{by_every_structure, narrowed, stadium, stadium_of};
use super::stage::{
    add, different_pixels, glass, improper_pixels, joined, mapped, phong, prepared, showroom, still,
};
use super::{Bar, Case, Effort};
use crate::accel::{
    Accelerator, Assembly, BruteForce, BuildQuality, Copies, Fan, Hit, KdParameters, KdTree,
    Packet, Part, WideTree,
};
use crate::control::{CancelToken, Progress};
use crate::geometry::shapes::{self, Random};
use crate::geometry::{Triangle, TriangleMesh};
use crate::math::{Bounds, DMat3, DVec3, Ray, ScaledRotation, Vec3, robust};
use crate::render::SurfacePoint;
use crate::scene::Mode;

pub const CASES: &[Case] = &[
    Case {
        name: "no ray escapes a closed body",
        tried: "rays aimed at edges and corners from within, alone, in packets and in fans, at several offsets and sizes, both trees: rays that get out",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: escapes,
    },
    Case {
        name: "no ray hits what it leaves",
        tried: "reflected rays off triangles up to 10,000 of their sizes from the middle: rays that meet their own triangle",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: self_hits,
    },
    Case {
        name: "the trees answer like brute force",
        tried: "rays that miss, hit, graze and run along 22 scenes, one of them of copies, alone, in packets and in fans: answers of either tree that are not the same bits",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: unlike_brute_force,
    },
    Case {
        name: "brute force in double precision",
        tried: "rays at 24 scenes by another test of triangles, but for at most 1 % that pass within 1e-6 of a size from an edge: answers that differ",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: unlike_double_precision,
    },
    Case {
        name: "slivers in double precision",
        tried: "rays at and beside slivers of aspect 1e-6, by another test of triangles: share of answers that are not the same triangle",
        bar: Bar::AtMost(1e-5),
        is_timed: false,
        measure: slivers_unlike_double_precision,
    },
    Case {
        name: "rays along the axes",
        tried: "26 directions with both zeros, origins on the planes of the tree: answers that are not those of brute force",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: along_the_axes,
    },
    Case {
        name: "length of directions",
        tried: "directions times 2^±40: answers other than the same triangle at the same point",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: scaled_directions,
    },
    Case {
        name: "eye on and in geometry",
        tried: "eyes inside bodies, on faces, edges and corners, every structure: pixels that differ or are no light",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: eye_in_geometry,
    },
];

/// Scenes of at most 160 triangles, few enough for brute force, as rendering stores them, or moved and scaled as it never does. The
/// first has none.
fn scenes() -> Vec<Vec<Triangle>> {
    let identical = TriangleMesh {
        triangles: vec![[0, 1, 2]; 60],
        ..shapes::soup(1, 1.0, 3)
    };
    let square = shapes::grid(3);
    let far_apart = joined([
        shapes::icosphere(1),
        mapped(shapes::icosphere(1), |p| p * 1e-3 + 30.0),
    ]);
    let meshes = [
        TriangleMesh::default(),
        shapes::soup(1, 1.0, 1),
        shapes::soup(2, 1.0, 2),
        shapes::icosphere(1),
        shapes::cuboid(DVec3::NEG_ONE, DVec3::ONE),
        shapes::soup(120, 0.2, 4),
        shapes::soup(60, 1.5, 5),
        shapes::slivers(80, 1e-6, 6),
        shapes::vertex_fan(60, 7),
        identical,
        shapes::flat_overlap(60, 8),
        shapes::axis_aligned(120, 16, 9),
        shapes::one_spot(60, 10),
        joined([square.clone(), square.clone(), square]),
        far_apart,
        stadium_of(4, 1),
    ];
    let mut scenes: Vec<_> = meshes.iter().map(narrowed).collect();
    let ball = narrowed(&shapes::icosphere(1));
    let changed = |f: &dyn Fn(Vec3) -> Vec3| {
        let triangles = ball.iter();
        triangles
            .map(|t| Triangle {
                corners: t.corners.map(f),
            })
            .collect()
    };
    scenes.push(changed(&|p| p + 1000.0));
    scenes.push(changed(&|p| p * 2_f32.powi(-20)));
    scenes.push(changed(&|p| p * 2_f32.powi(20)));
    scenes.push(changed(&|p| p * 2_f32.powi(-100)));
    scenes.push(changed(&|p| p + Vec3::new(1e5, -3e4, 7.0)));
    scenes
}

/// Builds a structure.
type Build = fn(&[Triangle]) -> Accelerator;

fn brute_force(triangles: &[Triangle]) -> Accelerator {
    Accelerator::BruteForce(BruteForce::new(triangles.to_vec()))
}

fn kd_tree(triangles: &[Triangle]) -> Accelerator {
    let tree = KdTree::build(triangles, &KdParameters::default(), &CancelToken::new());
    Accelerator::KdTree(tree.expect("nobody cancels"))
}

fn wide_tree(triangles: &[Triangle]) -> Accelerator {
    let (cancel, progress) = (CancelToken::new(), Progress::new());
    let tree = WideTree::build(triangles, BuildQuality::Best, &cancel, &progress);
    Accelerator::Wide(tree.expect("nobody cancels"))
}

/// The kd-tree and the wide tree.
fn trees(triangles: &[Triangle]) -> [Accelerator; 2] {
    [kd_tree(triangles), wide_tree(triangles)]
}

/// Triangles that occur once, as rays of a scene meet them.
fn without_copies(triangles: &[Triangle], build: Build) -> Assembly {
    let count = u32::try_from(triangles.len()).expect("few triangles");
    Assembly::new(build(triangles), Vec::new(), vec![Part::Flat(count)])
}

/// Copies of two meshes among triangles that occur once: turned, mirrored, tiny, and two in the same place.
fn placed_copies(build: Build) -> Assembly {
    let turned = |x: f64, z: f64, scale: f64| {
        ScaledRotation::new(DMat3::from_rotation_z(z) * DMat3::from_rotation_x(x) * scale)
    };
    let copies = |structure: usize, turn: ScaledRotation, translations: Vec<DVec3>| {
        Part::Copies(Copies {
            structure,
            turn,
            translations,
        })
    };
    let mut random = Random::new(3);
    let mut places = |count: u32| (0..count).map(|_| random.in_cube()).collect::<Vec<_>>();
    let once = narrowed(&shapes::soup(20, 0.2, 1));
    let shared = [shapes::icosphere(0), shapes::soup(12, 0.3, 2)];
    let shared = shared.map(|mesh| Arc::new(build(&narrowed(&mesh))));
    let parts = vec![
        copies(0, turned(0.3, 2.0, 0.12), places(3)),
        Part::Flat(20),
        copies(
            1,
            turned(0.0, 0.0, 0.25),
            vec![DVec3::new(0.2, 0.1, -0.3); 2],
        ),
        copies(1, turned(1.0, -0.2, -0.2), places(2)),
        copies(0, turned(0.1, 0.1, 1e-6), places(1)),
    ];
    Assembly::new(build(&once), shared.into(), parts)
}

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

/// Where rays to a scene may start and aim.
struct Surroundings<'a> {
    triangles: &'a [Triangle],
    center: DVec3,
    half: DVec3,
    size: f64,
}

impl<'a> Surroundings<'a> {
    fn of(triangles: &'a [Triangle]) -> Self {
        let bounds = Bounds::of_points(triangles.iter().flat_map(|t| t.corners));
        let (center, half) = if bounds.is_empty() {
            (DVec3::ZERO, DVec3::ONE)
        } else {
            (bounds.center().as_dvec3(), bounds.size().as_dvec3() * 0.5)
        };
        let size = half.max_element().max(f64::from(f32::MIN_POSITIVE));
        Self {
            triangles,
            center,
            half,
            size,
        }
    }

    /// One of the kinds of rays that find mistakes.
    fn ray(&self, random: &mut Random) -> Ray {
        loop {
            let ray = self.candidate(random);
            if ray.direction.is_finite() && ray.direction != Vec3::ZERO {
                return ray;
            }
        }
    }

    fn candidate(&self, random: &mut Random) -> Ray {
        let reach = [0.9, 3.0, 100.0][below(random, 3)];
        let origin = (self.center + random.in_cube() * self.size * reach).as_vec3();
        if self.triangles.is_empty() {
            return Ray::new(origin, random.in_cube().as_vec3());
        }
        let corners = self.triangles[below(random, self.triangles.len())].corners;
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let beside =
            a + (b - a) * (random.unit() * 6.0 - 3.0) + (c - a) * (random.unit() * 6.0 - 3.0);
        match below(random, 9) {
            0 => Ray::new(origin, random.in_cube().as_vec3()),
            1 => {
                let target = self.center + random.in_cube() * self.half;
                Ray::new(origin, target.as_vec3() - origin)
            }
            // At corners, at edges.
            2 => Ray::new(origin, corners[0] - origin),
            3 => Ray::new(origin, (a + (b - a) * random.unit()).as_vec3() - origin),
            // In the plane of a triangle, and from it.
            4 => Ray::new(beside.as_vec3(), (b - beside).as_vec3()),
            5 => Ray::new(beside.as_vec3(), (c - b).as_vec3()),
            6 => Ray::new(corners[0], (c - b).as_vec3()),
            7 => Ray::new(corners[0], random.in_cube().as_vec3()),
            // Along the lattice, with both zeros, from coordinates of corners, where planes are likely.
            _ => {
                let mut of_corner =
                    || self.triangles[below(random, self.triangles.len())].corners[0];
                let mut origin = Vec3::new(of_corner().x, of_corner().y, of_corner().z);
                let direction = lattice_direction(below(random, 64));
                if below(random, 2) == 0 {
                    origin -= (direction.as_dvec3() * (self.size * 4.0)).as_vec3();
                }
                Ray::new(origin, direction)
            }
        }
    }
}

impl Surroundings<'_> {
    /// Sixteen rays that go almost the same way, the first of them one of [`Self::ray`]: from its origin, from a lens around it, or beside
    /// each other. Every fifth goes not much further than the first aims.
    fn packet(&self, random: &mut Random) -> Vec<(Ray, f32)> {
        let first = self.ray(random);
        let spread = [1.0, 0.1, 1e-2, 1e-4, 1e-6][below(random, 5)];
        let [on_lens, in_direction] =
            [[0.0, spread], [spread, spread], [spread, 0.0]][below(random, 3)];
        let length = f64::from(first.direction.abs().max_element());
        let others = (1..Packet::MOST_RAYS).map(|index| {
            let offset = random.in_cube() * self.size * on_lens;
            let turn = random.in_cube() * length * in_direction;
            let ray = Ray::new(
                first.origin + offset.as_vec3(),
                first.direction + turn.as_vec3(),
            );
            let t_max = if index % 5 == 0 { 1.1 } else { f32::INFINITY };
            (ray, t_max)
        });
        let rays = std::iter::once((first, f32::INFINITY)).chain(others);
        rays.filter(|(ray, _)| ray.direction.is_finite() && ray.direction != Vec3::ZERO)
            .collect()
    }

    /// A point, the normal there, and directions to where rays from it end: on a triangle, just above one as where rendering looks for
    /// light and occlusion, or anywhere; into the hemisphere, to corners and beyond them.
    fn fan(&self, random: &mut Random) -> (Vec3, Vec3, Vec<Vec3>) {
        let corners = [Vec3::X, Vec3::Y, Vec3::Z];
        let nothing = Triangle { corners };
        let any = |random: &mut Random| {
            let index = below(random, self.triangles.len().max(1));
            self.triangles.get(index).copied().unwrap_or(nothing)
        };
        let from = any(random);
        let normal = from.normal();
        let (u, v) = (random.unit(), random.unit());
        let weights = DVec3::new(1.0 - u, u * (1.0 - v), u * v).as_vec3();
        let (point, error) = from.point(weights.to_array());
        let origin = match below(random, 3) {
            0 => point,
            1 => robust::offset_origin(point, error, normal, normal),
            _ => self.ray(random).origin,
        };
        let kind = below(random, 3);
        let mut direction = || {
            if kind > 0 {
                let aim = any(random).corners[0] - origin;
                return if kind == 1 { aim } else { aim * 2.0 };
            }
            let direction = (random.in_cube() * self.size).as_vec3();
            if direction.dot(normal) < 0.0 {
                -direction
            } else {
                direction
            }
        };
        let directions = (0..16).map(|_| direction());
        let directions = directions.filter(|d| d.is_finite() && *d != Vec3::ZERO);
        (origin, normal, directions.collect())
    }
}

/// A random index below `count`.
fn below(random: &mut Random, count: usize) -> usize {
    usize::try_from(random.bits() % count as u64).expect("below a usize")
}

/// Number `number` below 64 of the vectors of −1, −0, 0 and 1.
fn lattice_direction(number: usize) -> Vec3 {
    let values = [-1.0, -0.0, 0.0, 1.0];
    Vec3::new(
        values[number % 4],
        values[number / 4 % 4],
        values[number / 16],
    )
}

fn bits(hit: Option<Hit>) -> Option<(u32, u32, [u32; 3])> {
    hit.map(|hit| {
        let weights = hit.barycentrics.map(f32::to_bits);
        (hit.triangle, hit.t.to_bits(), weights)
    })
}

/// Counts over `count` rays, in parallel, each lot of them with random numbers of its own.
fn count_over(count: u64, of_lot: impl Fn(&mut Random, u64) -> u64 + Sync) -> f64 {
    const LOT: u64 = 4096;
    let lots = count.div_ceil(LOT);
    let sum: u64 = (0..lots)
        .into_par_iter()
        .map(|lot| of_lot(&mut Random::new(lot ^ 0x5eed), LOT.min(count - lot * LOT)))
        .sum();
    sum as f64
}

/// A closed body with a rough surface, placed by `change`, and rays at its weakest points.
struct RoughBody {
    triangles: Vec<Triangle>,
    middle: DVec3,
    /// Of its largest radius.
    size: f64,
}

impl RoughBody {
    fn new(change: impl Fn(Vec3) -> Vec3) -> Self {
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
    fn escapes(&self, rays: u64, meets: impl Fn(&Ray) -> bool + Sync) -> f64 {
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

fn escapes(effort: Effort) -> f64 {
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

fn self_hits(effort: Effort) -> f64 {
    self_hits_of_rays(effort, |point, onward| {
        [point.ray_above(onward), point.ray_through(-onward)]
    })
}

/// How many of the rays that `leave` makes, given the point and a direction above it, meet the triangle they leave.
fn self_hits_of_rays(
    effort: Effort,
    leave: impl Fn(&SurfacePoint, Vec3) -> [Ray; 2] + Sync,
) -> f64 {
    let rays_each = effort.pick(100_000, 30_000_000) / 3;
    let mut count = 0.0;
    for distance in [0.0, 100.0, 1e4] {
        // Many triangles of size 1 around two places.
        let soup = shapes::soup(2000, 0.7, 9);
        let apart = joined([
            mapped(soup.clone(), |p| p + distance),
            mapped(soup, |p| p - distance),
        ]);
        let mut scene = still(1, 1);
        add(&mut scene, "soup", apart, phong(0.5, 0.0, 1.0));
        let scene = prepared(&scene);
        let accelerator = scene.geometry().accelerator();
        let scale = scene.geometry().frame().scale();
        let left = AtomicU64::new(0);
        count += count_over(rays_each, |random, count| {
            let mut hits = 0;
            for _ in 0..count {
                let id = u32::try_from(random.bits() % 4000).expect("few");
                let [a, b, c] = scene
                    .geometry()
                    .triangle(id)
                    .in_scene()
                    .corners
                    .map(Vec3::as_dvec3);
                let (u, v) = (random.unit(), random.unit());
                let (u, v) = if u + v > 1.0 {
                    (1.0 - u, 1.0 - v)
                } else {
                    (u, v)
                };
                let aim = a + (b - a) * u + (c - a) * v;
                let away = random.in_cube().normalize();
                let ray = Ray::new((aim + away * (10.0 * scale)).as_vec3(), -away.as_vec3());
                let Some(point) = scene.surface_along(&ray, f32::INFINITY) else {
                    continue;
                };
                left.fetch_add(1, Ordering::Relaxed);
                let mut onward = random.in_cube().normalize().as_vec3();
                if onward.dot(point.geometric_normal()) < 0.0 {
                    onward = -onward;
                }
                for ray in leave(&point, onward) {
                    let met = accelerator.intersect(&ray, f32::INFINITY);
                    hits += u64::from(met.is_some_and(|hit| hit.triangle == point.triangle));
                }
            }
            hits
        });
        let left = left.into_inner();
        assert!(
            left > rays_each / 2,
            "only {left} of {rays_each} rays left a triangle"
        );
    }
    count
}

fn unlike_brute_force(effort: Effort) -> f64 {
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

/// Where a ray meets a triangle: the parameter, and the distance from the nearest edge over the longest one, negative outside.
/// Source: Möller, Trumbore, Fast, Minimum Storage Ray/Triangle Intersection, 1997; in `f64`, without a threshold.
fn by_barycentrics(ray: &Ray, triangle: &Triangle) -> Option<(f64, f64)> {
    let [a, b, c] = triangle.corners.map(Vec3::as_dvec3);
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let s = origin - a;
    let u = s.dot(p) / determinant;
    let q = s.cross(ab);
    let v = direction.dot(q) / determinant;
    let t = ac.dot(q) / determinant;
    let edges = [(u, ac), (v, ab), (1.0 - u - v, c - b)];
    let longest = edges
        .map(|(_, edge)| edge.length())
        .into_iter()
        .fold(0.0, f64::max);
    let doubled_area = ab.cross(ac).length();
    // A weight is the distance from its edge over the height on that edge.
    let inside = edges.map(|(weight, edge)| weight * doubled_area / edge.length() / longest);
    Some((t, inside.into_iter().fold(f64::INFINITY, f64::min)))
}

fn unlike_double_precision(effort: Effort) -> f64 {
    /// Of the longest edge: far above the rounding of the second test for rays of the scene's size.
    const NEAR_EDGE: f64 = 1e-6;
    let meshes = [
        shapes::icosphere(2),
        shapes::soup(300, 0.2, 4),
        shapes::cuboid(DVec3::NEG_ONE, DVec3::ONE),
        shapes::axis_aligned(300, 16, 9),
    ];
    let large = meshes
        .iter()
        .map(|mesh| (narrowed(mesh), effort.pick(10_000, 1_000_000)));
    // Those with triangles.
    let small = scenes().into_iter().skip(1);
    let small = small.map(|triangles| (triangles, effort.pick(5_000, 250_000)));
    let (mut count, mut tested) = (0.0, 0);
    let hits = AtomicU64::new(0);
    for (triangles, rays) in large.chain(small) {
        let all = BruteForce::new(triangles.clone());
        let around = Surroundings::of(&triangles);
        let skipped = AtomicU64::new(0);
        count += count_over(rays, |random, count| {
            let differs = |random: &mut Random| {
                let origin = (around.center + random.in_cube() * around.size * 3.0).as_vec3();
                let target = (around.center + random.in_cube() * around.half).as_vec3();
                let ray = Ray::new(origin, target - origin);
                let mut nearest = f64::INFINITY;
                for triangle in &triangles {
                    match by_barycentrics(&ray, triangle) {
                        Some((_, inside)) if inside.abs() < NEAR_EDGE => {
                            skipped.fetch_add(1, Ordering::Relaxed);
                            return false;
                        }
                        Some((t, inside)) if inside > 0.0 && t > 0.0 => nearest = nearest.min(t),
                        _ => {}
                    }
                }
                match all.intersect(&ray, f32::INFINITY) {
                    None => nearest.is_finite(),
                    Some(hit) => {
                        hits.fetch_add(1, Ordering::Relaxed);
                        (f64::from(hit.t) - nearest).abs() > 1e-6 * nearest
                    }
                }
            };
            (0..count).map(|_| u64::from(differs(random))).sum()
        });
        tested += rays;
        let skipped = skipped.into_inner();
        assert!(
            skipped <= rays / 100,
            "{skipped} of {rays} rays pass near an edge"
        );
    }
    let hits = hits.into_inner();
    assert!(hits > tested / 20, "only {hits} of {tested} rays hit");
    count
}

fn slivers_unlike_double_precision(effort: Effort) -> f64 {
    let triangles = narrowed(&shapes::slivers(60, 1e-6, 6));
    let trees = trees(&triangles);
    let around = Surroundings::of(&triangles);
    let rays = effort.pick(40_000, 4_000_000);
    let hits = AtomicU64::new(0);
    let different = count_over(rays, |random, count| {
        let differs = |random: &mut Random| {
            let [a, b, c] = triangles[below(random, triangles.len())].corners;
            let [a, b, c] = [a, b, c].map(Vec3::as_dvec3);
            let mut share = || random.unit() * 1.5 - 0.25;
            let target = a + (b - a) * share() + (c - a) * share();
            let origin = (around.center + random.in_cube() * around.size * 3.0).as_vec3();
            let ray = Ray::new(origin, target.as_vec3() - origin);
            let met = triangles.iter().zip(0_u32..).filter_map(|(triangle, id)| {
                let (t, inside) = by_barycentrics(&ray, triangle)?;
                (inside >= 0.0 && t > 0.0).then_some((t, id))
            });
            let nearest = met.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, id)| id);
            hits.fetch_add(u64::from(nearest.is_some()), Ordering::Relaxed);
            trees
                .iter()
                .any(|tree| tree.intersect(&ray, f32::INFINITY).map(|hit| hit.triangle) != nearest)
        };
        (0..count).map(|_| u64::from(differs(random))).sum()
    });
    let hits = hits.into_inner();
    assert!(hits > rays / 20, "only {hits} of {rays} rays hit");
    different / rays as f64
}

fn along_the_axes(effort: Effort) -> f64 {
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

fn scaled_directions(effort: Effort) -> f64 {
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

fn eye_in_geometry(_: Effort) -> f64 {
    let mut count = 0.0;
    for material in [phong(0.5, 0.4, 30.0), glass(1.5)] {
        for mode in [Mode::Direct, Mode::Path, Mode::Normals] {
            let mut scene = showroom(24, 18);
            scene.materials.insert("matt".into(), material.clone());
            scene.render.mode = mode;
            let mesh = &scene.meshes["matt"];
            let [a, b, c] = mesh.corners(17);
            let eyes = [
                a,
                (a + b) / 2.0,
                (a + b + c) / 3.0,
                DVec3::new(-1.3, 0.2, -0.3),
            ];
            for eye in eyes {
                scene.camera.eye = eye;
                scene.camera.target = DVec3::new(1.2, 0.9, -0.2);
                let pictures = by_every_structure(&mut scene);
                count += improper_pixels(&pictures[0]);
                let others = pictures[1..].iter();
                count += others
                    .map(|other| different_pixels(&pictures[0], other))
                    .sum::<f64>();
            }
        }
    }
    count
}

/// That the figures notice what they are there for: the same protocols with a weaker renderer.
#[cfg(test)]
mod controls {
    use super::*;

    /// The test that most renderers begin with, in single precision.
    fn meets_by_moller_trumbore(ray: &Ray, triangle: &Triangle) -> bool {
        let [a, b, c] = triangle.corners;
        let (ab, ac) = (b - a, c - a);
        let p = ray.direction.cross(ac);
        let s = ray.origin - a;
        let q = s.cross(ab);
        let inverse = 1.0 / ab.dot(p);
        let (u, v) = (s.dot(p) * inverse, ray.direction.dot(q) * inverse);
        u >= 0.0 && v >= 0.0 && u + v <= 1.0 && ac.dot(q) * inverse > 0.0
    }

    #[test]
    fn a_leaking_test_of_triangles_is_noticed() {
        let body = RoughBody::new(|p| p);
        let meets = |ray: &Ray| {
            let mut triangles = body.triangles.iter();
            triangles.any(|triangle| meets_by_moller_trumbore(ray, triangle))
        };
        let escaped = body.escapes(4096, meets);
        assert!(escaped > 100.0, "only {escaped} of 4096");
    }

    #[test]
    fn distances_to_planes_without_a_margin_are_noticed() {
        let triangles = narrowed(&shapes::cuboid(DVec3::NEG_ONE, DVec3::ONE));
        let tree = KdTree::build(&triangles, &KdParameters::default(), &CancelToken::new());
        let tree = tree.expect("nobody cancels");
        let all = BruteForce::new(triangles.clone());
        let around = Surroundings::of(&triangles);
        let mut random = Random::new(1);
        let (mut without, mut with) = (0, 0);
        for _ in 0..4096 {
            let ray = around.ray(&mut random);
            let expected = bits(all.intersect(&ray, f32::INFINITY));
            let found = tree.intersect_without_margin(&ray, f32::INFINITY);
            without += u32::from(bits(found) != expected);
            with += u32::from(bits(tree.intersect(&ray, f32::INFINITY)) != expected);
        }
        assert_eq!(with, 0);
        assert!(without > 10, "only {without} of 4096");
    }

    #[test]
    fn a_test_that_drops_slivers_is_noticed() {
        let triangles = narrowed(&shapes::slivers(60, 1e-6, 6));
        let mut random = Random::new(1);
        let missed = (0..4096).filter(|_| {
            let triangle = &triangles[below(&mut random, triangles.len())];
            let [a, b, c] = triangle.corners.map(Vec3::as_dvec3);
            let target = ((a + b + c) / 3.0).as_vec3();
            let origin = (random.in_cube() * 3.0).as_vec3();
            let ray = Ray::new(origin, target - origin);
            let exact = by_barycentrics(&ray, triangle).is_some_and(|(_, inside)| inside >= 0.0);
            exact != meets_by_moller_trumbore(&ray, triangle)
        });
        let missed = missed.count();
        assert!(missed > 100, "only {missed} of 4096");
    }

    #[test]
    fn rays_that_start_a_fixed_distance_away_are_noticed() {
        let hits = self_hits_of_rays(Effort::Quick, |point, onward| {
            let normal = point.geometric_normal();
            let start = |side: f32| point.position + normal * (1e-7 * side);
            [Ray::new(start(1.0), onward), Ray::new(start(-1.0), -onward)]
        });
        assert!(hits > 100.0, "only {hits}");
    }
}
