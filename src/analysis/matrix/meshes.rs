//! Meshes that nobody would draw and everybody has: slivers, repeats, coinciding and empty ones.

use cpu_time::ProcessTime;

use super::stage::{
    add, different_pixels, improper_pixels, joined, largest, mapped, matt, phong, picture, point,
    prepared, rectangle, run, run_on, still,
};
use super::{Bar, Case, Effort};
use crate::accel::{Accelerator, BuildQuality, KdParameters, KdTree, WideTree};
use crate::control::{CancelToken, Progress};
use crate::geometry::shapes::{self, Random};
use crate::geometry::{Triangle, TriangleMesh};
use crate::math::{DMat3, DVec3, Degrees, Ray, SceneFrame};
use crate::memory::peak_bytes;
use crate::render::Image;
use crate::scene::{AcceleratorChoice, Background, Camera, Material, Mode, Rgb, Scene, Textures};

pub const CASES: &[Case] = &[
    Case {
        name: "slivers of aspect 1e-6",
        tried: "pictures of the normals of single slivers: largest angle to the exact normal, in degrees",
        bar: Bar::AtMost(0.01),
        is_timed: false,
        measure: sliver_normals,
    },
    Case {
        name: "repeated faces and faces without area",
        tried: "a smooth and a flat ball with faces repeated, turned and collapsed: pixels that are not those of the clean one",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: repeated_faces,
    },
    Case {
        name: "coinciding faces of several materials",
        tried: "three overlapping squares in one plane, level and oblique, by every structure, 1 and 2 threads: pixels that differ",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: coinciding_faces,
    },
    Case {
        name: "hostile triangles: references",
        tried: "identical, in a fan, flat, needles, all at one spot: most references of the kd-tree per triangle",
        bar: Bar::AtMost(8.0),
        is_timed: false,
        measure: references,
    },
    Case {
        name: "hostile triangles: depth",
        tried: "the same: by how much the deepest kd-tree exceeds 8 + 1.3 log₂ N levels",
        bar: Bar::AtMost(0.0),
        is_timed: false,
        measure: depth,
    },
    Case {
        name: "hostile triangles: build time",
        tried: "identical, in a fan, all at one spot, by either tree: the longest build over that of as many triangles apart, in processor time",
        bar: Bar::AtMost(5.0),
        is_timed: true,
        measure: build_time,
    },
    Case {
        name: "a teapot in a stadium",
        tried: "a ball on a ground a million times its size: references of the kd-tree per triangle",
        bar: Bar::AtMost(2.0),
        is_timed: false,
        measure: stadium_references,
    },
    Case {
        name: "10 million triangles",
        tried: "a hilly land of 100,000, with --long of so many and in at most 8 GiB, built as by default: rays aimed at the middle of a triangle that meet another or none",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: hilly_land,
    },
    Case {
        name: "empty scene",
        tried: "no object, no triangle, a triangle out of sight: pixels that are not the background, and rays but the camera's",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: empty_scene,
    },
];

fn sliver_normals(effort: Effort) -> f64 {
    let mut random = Random::new(21);
    let (mut largest_angle, mut seen) = (0.0_f64, 0);
    let count = effort.pick(30, 1000);
    for turn in 0..count {
        let aspect = [1e-3, 1e-4, 1e-5, 1e-6][turn % 4];
        let along = random.in_cube().normalize();
        let across = along.cross(random.in_cube()).normalize();
        let normal = along.cross(across);
        let corner = random.in_cube();
        let corners = [
            corner,
            corner + along,
            corner + along * 0.4 + across * aspect,
        ];
        let mut scene = still(1, 1);
        let sliver = TriangleMesh {
            positions: corners.into(),
            triangles: vec![[0, 1, 2]],
            ..TriangleMesh::default()
        };
        add(&mut scene, "sliver", sliver, matt(0.5));
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        scene.camera = Camera {
            eye: middle + normal * 3.0 + along * 0.5,
            target: middle,
            up: across,
            vertical_fov: Degrees(1e-5),
            ..Camera::default()
        };
        scene.render.mode = Mode::Normals;
        let pixel = picture(&scene)
            .pixel(0, 0)
            .map(|c| f64::from(c) * 2.0 - 1.0);
        let found = DVec3::from_array(pixel);
        // Black is where the eye looks past it.
        if found != DVec3::NEG_ONE {
            seen += 1;
            let angle = libm::atan2(found.cross(normal).length(), found.dot(normal));
            largest_angle = largest_angle.max(angle.to_degrees());
        }
    }
    assert!(2 * seen > count, "only {seen} of {count} slivers are seen");
    largest_angle
}

/// A ball lit from one side.
fn ball(mesh: TriangleMesh, smooth: bool, material: Material) -> Scene {
    let mut scene = still(96, 72);
    add(&mut scene, "ball", mesh, material);
    scene.objects[0].smooth = smooth;
    scene.lights = vec![point(DVec3::new(3.0, -4.0, 5.0), 60.0)];
    scene.background = Background::Constant {
        radiance: Rgb::new(0.1, 0.2, 0.3),
    };
    scene.camera.vertical_fov = Degrees(24.0);
    scene.render.samples_per_pixel = 4;
    scene
}

fn repeated_faces(_: Effort) -> f64 {
    let clean = shapes::icosphere(2);
    let mut repeated = clean.clone();
    for (index, &[a, b, c]) in clean.triangles.iter().enumerate() {
        let more = [[a, b, c], [b, c, a], [a, c, b], [a, b, b], [a, a, a]];
        repeated.triangles.extend(&more[index % 3..]);
    }
    let mut different = 0.0;
    for material in [phong(0.5, 0.4, 30.0), Material::mirror(), Material::glass()] {
        for smooth in [false, true] {
            let pictures = [&clean, &repeated]
                .map(|mesh| picture(&ball(mesh.clone(), smooth, material.clone())));
            different += different_pixels(&pictures[0], &pictures[1]);
        }
    }
    different
}

fn coinciding_faces(_: Effort) -> f64 {
    // In an oblique plane corners are rounded, so that the squares cut each other; the picture must be one and the same there, too.
    let oblique = DMat3::from_rotation_z(0.7) * DMat3::from_rotation_x(0.4);
    let turns = [DMat3::IDENTITY, oblique];
    turns.map(differences_of_coinciding_faces).iter().sum()
}

/// How many pixels of three overlapping squares in one plane, turned this way, depend on the structure or the threads.
fn differences_of_coinciding_faces(turn: DMat3) -> f64 {
    let mut scene = still(64, 48);
    for (number, name) in (0..).zip(["red", "green", "blue"]) {
        let center = DVec3::new(f64::from(number) * 0.3, f64::from(number) * 0.17, 0.0);
        let (u, v) = (DVec3::new(1.0, 0.2, 0.0), DVec3::new(-0.3, 0.9, 0.0));
        let color = Rgb::from_array([0, 1, 2].map(|c| if c == number { 0.8 } else { 0.1 }));
        let material = Material::Phong {
            diffuse: color,
            specular: Rgb::ZERO,
            shininess: 1.0,
            textures: Textures::default(),
        };
        // Cut into many, so that the trees have something to arrange.
        let square = mapped(shapes::grid(8), |p| turn * (center + u * p.x + v * p.y));
        add(&mut scene, name, square, material);
    }
    scene.render.samples_per_pixel = 4;
    let mut different = 0.0;
    for mode in [Mode::Albedo, Mode::Object] {
        scene.render.mode = mode;
        let pictures = by_every_structure(&mut scene);
        let channels = pictures[0].pixels.iter().flatten();
        let brightest = largest(channels.map(|&channel| f64::from(channel)));
        assert!(brightest > 0.1, "the squares are seen: {brightest}");
        different += pictures[1..]
            .iter()
            .map(|other| different_pixels(&pictures[0], other))
            .sum::<f64>();
    }
    different
}

/// The picture by each structure, with one thread and two.
pub fn by_every_structure(scene: &mut Scene) -> Vec<Image> {
    let mut pictures = Vec::new();
    for structure in [
        AcceleratorChoice::BruteForce,
        AcceleratorChoice::KdTree,
        AcceleratorChoice::Wide,
    ] {
        scene.render.accelerator = structure;
        pictures.extend([1, 2].map(|threads| run_on(scene, threads).image));
    }
    pictures
}

/// The mesh as rendering stores it.
pub fn narrowed(mesh: &TriangleMesh) -> Vec<Triangle> {
    let frame = SceneFrame::around(&mesh.bounds());
    let corners = (0..mesh.triangles.len()).map(|index| mesh.corners(index));
    corners
        .map(|corners| Triangle {
            corners: corners.map(|corner| frame.narrow(corner)),
        })
        .collect()
}

/// A ball a million times smaller than the ground it stands on.
pub fn stadium() -> TriangleMesh {
    stadium_of(24, 3)
}

/// The same, of a grid and an icosphere of that fineness.
pub fn stadium_of(cells: u32, subdivisions: u32) -> TriangleMesh {
    let ball = mapped(shapes::icosphere(subdivisions), |p| {
        p * 1e-6 + DVec3::Z * 1e-6
    });
    joined([shapes::grid(cells), ball])
}

fn kd_tree(mesh: &TriangleMesh) -> KdTree {
    kd_tree_by(mesh, &KdParameters::default())
}

fn kd_tree_by(mesh: &TriangleMesh, parameters: &KdParameters) -> KdTree {
    let tree = KdTree::build(&narrowed(mesh), parameters, &CancelToken::new());
    tree.expect("nobody cancels")
}

/// How many triangles a hostile mesh has.
fn hostile_count(effort: Effort) -> u32 {
    effort.pick(4000, 100_000)
}

fn hostile(effort: Effort) -> [TriangleMesh; 6] {
    let count = hostile_count(effort);
    let identical = TriangleMesh {
        triangles: vec![[0, 1, 2]; count as usize],
        ..shapes::soup(1, 1.0, 3)
    };
    [
        identical,
        shapes::vertex_fan(count, 7),
        shapes::flat_overlap(count, 8),
        shapes::one_spot(count, 10),
        shapes::slivers(count, 1e-6, 6),
        shapes::axis_aligned(count, 32, 9),
    ]
}

fn references(effort: Effort) -> f64 {
    largest(hostile(effort).iter().map(|mesh| {
        let tree = kd_tree(mesh);
        tree.statistics().references as f64 / tree.triangle_count() as f64
    }))
}

fn depth(effort: Effort) -> f64 {
    largest(hostile(effort).iter().map(|mesh| {
        let tree = kd_tree(mesh);
        let most = 8.0 + 1.3 * (tree.triangle_count() as f64).log2();
        f64::from(tree.statistics().max_depth) - most
    }))
}

fn build_time(effort: Effort) -> f64 {
    let [identical, fan, _, one_spot, ..] = hostile(effort);
    // As large as the space that each has.
    let count = hostile_count(effort);
    let apart = shapes::soup(count, 1.0 / libm::cbrt(count.into()), 5);
    let ratios = |build: fn(&[Triangle]) -> usize| {
        let ordinary = shortest_build(&apart, build);
        [&identical, &fan, &one_spot].map(|mesh| shortest_build(mesh, build) / ordinary)
    };
    let by_kd_tree = |triangles: &[Triangle]| {
        let tree = KdTree::build(triangles, &KdParameters::default(), &CancelToken::new());
        tree.expect("nobody cancels").triangle_count()
    };
    let by_wide_tree = |triangles: &[Triangle]| {
        let (cancel, progress) = (CancelToken::new(), Progress::new());
        let tree = WideTree::build(triangles, BuildQuality::Best, &cancel, &progress);
        tree.expect("nobody cancels").triangle_count()
    };
    let both = [ratios(by_kd_tree), ratios(by_wide_tree)];

    largest(both.into_iter().flatten())
}

/// Seconds of processor time: the least of three, as whatever else the machine does makes them more.
fn shortest_build(mesh: &TriangleMesh, build: fn(&[Triangle]) -> usize) -> f64 {
    let triangles = narrowed(mesh);
    let build = || {
        let started = ProcessTime::now();
        assert_eq!(build(&triangles), triangles.len());
        started.elapsed().as_secs_f64()
    };
    (0..3).map(|_| build()).fold(f64::INFINITY, f64::min)
}

fn stadium_references(_: Effort) -> f64 {
    let quality = Accelerator::KdTree(kd_tree(&stadium())).quality();
    quality.references as f64 / quality.triangles as f64
}

fn hilly_land(effort: Effort) -> f64 {
    /// The steepest slope has 42°, and rays come from at least 65° above the ground: nothing is in their way.
    const HEIGHT: f64 = 0.1;
    const ASIDE: f64 = 0.3;
    let height = |p: DVec3| HEIGHT * libm::sin(7.0 * p.x) * libm::cos(5.0 * p.y);
    let land = mapped(shapes::grid(effort.pick(224, 2237)), |p| {
        p.with_z(height(p))
    });
    let count = land.triangles.len() as u64;
    assert!(
        count >= effort.pick(100_000, 10_000_000),
        "{count} triangles"
    );
    let mut scene = still(1, 1);
    add(&mut scene, "land", land, matt(0.5));
    let scene = prepared(&scene);
    let geometry = scene.geometry();
    let mut random = Random::new(23);
    let is_missed = |_: &u32| {
        let id = u32::try_from(random.bits() % count).expect("ids are 32 bits long");
        let [a, b, c] = geometry.triangle(id).in_scene().corners;
        let target = ((a.as_dvec3() + b.as_dvec3() + c.as_dvec3()) / 3.0).as_vec3();
        let away = (random.in_cube() * ASIDE).with_z(1.0).as_vec3();
        let hit = geometry
            .accelerator()
            .intersect(&Ray::new(target + away, -away), f32::INFINITY);
        hit.is_none_or(|hit| hit.triangle != id)
    };
    let missed = (0..effort.pick(10_000, 100_000)).filter(is_missed).count();
    if effort == Effort::Long {
        let peak = peak_bytes().unwrap_or(0);
        assert!(peak <= 8 << 30, "the process has taken {peak} bytes");
    }
    missed as f64
}

fn empty_scene(_: Effort) -> f64 {
    let mut count = 0.0;
    let background = Rgb::new(0.25, 0.5, 2.0);
    for mode in [Mode::Direct, Mode::Path] {
        for content in 0..3 {
            let mut scene = still(16, 12);
            scene.background = Background::Constant {
                radiance: background,
            };
            scene.lights = vec![point(DVec3::Z, 1.0)];
            scene.render.mode = mode;
            if content == 1 {
                add(&mut scene, "empty", TriangleMesh::default(), matt(0.5));
            }
            if content == 2 {
                let behind = rectangle(DVec3::NEG_Y * 50.0, DVec3::X, DVec3::Z);
                add(&mut scene, "behind", behind, matt(0.5));
            }
            let outcome = run(&scene);
            let rays = outcome.stats.rays;
            count += (rays.total() - rays.camera) as f64;
            let wrong = |pixel: &&[f32; 3]| pixel.map(f64::from) != background.to_array();
            count += outcome.image.pixels.iter().filter(wrong).count() as f64;
            count += improper_pixels(&outcome.image);
        }
    }
    count
}

#[cfg(test)]
mod controls {
    use super::*;

    #[test]
    fn a_tree_without_a_budget_is_noticed() {
        let parameters = KdParameters {
            reference_budget: f64::INFINITY,
            ..KdParameters::default()
        };
        let tree = kd_tree_by(&shapes::flat_overlap(1000, 8), &parameters);
        let references = tree.statistics().references as f64 / 1000.0;
        assert!(references > 8.0, "{references} per triangle");
    }
}
