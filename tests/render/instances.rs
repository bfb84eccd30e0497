//! Copies share their triangles: the same scene written with copies, which share a mesh, and with meshes that hold every
//! copy's own triangles shows the same.

use std::sync::Arc;

use crate::common::{diffuse, picture, rectangle};
use raymini::control::{CancelToken, Progress};
use raymini::geometry::{TriangleMesh, shapes};
use raymini::math::{DVec3, Degrees};
use raymini::render::{
    PreparedGeometry, PreparedObject, PreparedScene, RenderProgress, RunConfig, render,
};
use raymini::scene::{
    AcceleratorChoice, Background, Camera, Copies, Light, LightSampling, Material, Mode, Object,
    RenderSettings, Rgb, Scene,
};

fn prepare(scene: &Scene, previous: Option<&PreparedScene>) -> PreparedScene {
    PreparedScene::prepare(scene, previous, &CancelToken::new())
        .expect("can be rendered")
        .expect("nobody cancels")
}

/// A rough ball of 1,280 triangles, of which a few copies are worth sharing.
fn ball() -> TriangleMesh {
    let mut mesh = shapes::icosphere(3);
    for (index, position) in mesh.positions.iter_mut().enumerate() {
        *position *= 1.0 + 0.04 * (index as f64 * 2.399).sin();
    }
    mesh
}

/// Balls over a floor: two objects of copies, one of them mirrored, and a turned single one, all of one mesh.
fn balls() -> Scene {
    let mut scene = Scene::default();
    scene.meshes.insert("ball".into(), Arc::new(ball()));
    scene.meshes.insert(
        "floor".into(),
        Arc::new(rectangle(
            DVec3::new(0.0, 0.0, -1.0),
            DVec3::X * 30.0,
            DVec3::Y * 30.0,
        )),
    );
    scene.materials.insert("grey".into(), diffuse(0.7));
    let object = |name: &str| Object {
        name: name.into(),
        mesh: "ball".into(),
        material: Some("grey".into()),
        smooth: true,
        ..Object::default()
    };
    scene.objects = vec![
        Object {
            translate: DVec3::new(-7.0, -3.0, 0.0),
            copies: Copies {
                count: [5, 4, 1],
                step: DVec3::new(2.3, 2.6, 0.1),
            },
            ..object("grid")
        },
        Object {
            mesh: "floor".into(),
            smooth: false,
            ..object("floor")
        },
        Object {
            scale: -0.6,
            rotate: DVec3::new(20.0, -50.0, 130.0),
            translate: DVec3::new(4.5, -2.0, 0.3),
            copies: Copies {
                count: [1, 3, 2],
                step: DVec3::new(0.0, 2.0, 1.9),
            },
            smooth: false,
            ..object("mirrored")
        },
        Object {
            rotate: DVec3::new(0.0, 0.0, 33.0),
            scale: 1.7,
            translate: DVec3::new(7.5, 4.0, 0.9),
            ..object("single")
        },
    ];
    scene.lights.push(Light::Point {
        position: DVec3::new(-5.0, -12.0, 14.0),
        intensity: Rgb::splat(900.0),
    });
    scene.background = Background::Constant {
        radiance: Rgb::splat(0.3),
    };
    scene.camera = Camera {
        eye: DVec3::new(-3.0, -16.0, 6.0),
        target: DVec3::new(0.0, 1.0, 0.0),
        vertical_fov: Degrees(45.0),
        ..Camera::default()
    };
    scene.render = RenderSettings {
        width: 160,
        height: 100,
        samples_per_pixel: 1,
        antialiasing: false,
        ..RenderSettings::default()
    };
    scene
}

/// The scene with every copy's triangles written out in a mesh of its object's own.
fn written_out(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    for (index, object) in scene.objects.iter_mut().enumerate() {
        let mesh = &scene.meshes[&object.mesh];
        let placement = object.placement();
        let mut all = TriangleMesh::default();
        for offset in object.copies.offsets() {
            let first = u32::try_from(all.positions.len()).unwrap();
            let positions = mesh.positions.iter();
            all.positions
                .extend(positions.map(|&p| placement.world_from_object(p) + offset));
            let is_mirrored = placement.linear.determinant() < 0.0;
            all.triangles.extend(mesh.triangles.iter().map(|t| {
                let [a, b, c] = t.map(|vertex| vertex + first);
                if is_mirrored { [a, c, b] } else { [a, b, c] }
            }));
        }
        let name = format!("written out {index}");
        scene.meshes.insert(name.clone(), Arc::new(all));
        *object = Object {
            name: object.name.clone(),
            mesh: name,
            material: object.material.clone(),
            smooth: object.smooth,
            ..Object::default()
        };
    }
    scene
}

fn bytes(scene: &PreparedScene) -> usize {
    scene.geometry().accelerator().bytes()
}

#[test]
fn copies_look_like_the_same_triangles_written_out() {
    let scene = balls();
    assert!(bytes(&prepare(&scene, None)) < bytes(&prepare(&written_out(&scene), None)) / 10);
    let modes = [
        (Mode::Depth, 1e-4),
        (Mode::Normals, 1e-4),
        (Mode::Facing, 1e-3),
        (Mode::Object, 0.0),
        (Mode::Direct, 1e-3),
    ];
    for (mode, tolerance) in modes {
        let mut scene = scene.clone();
        scene.render.mode = mode;
        let shared = picture(&scene);
        let flat = picture(&written_out(&scene));
        // Silhouettes may fall to either side of a pixel's centre.
        let differ = |(a, b): &(&[f32; 3], &[f32; 3])| {
            (0..3).any(|i| (a[i] - b[i]).abs() > tolerance * b[i].abs().max(1.0))
        };
        let pixels = shared.pixels.iter().zip(&flat.pixels);
        let count = pixels.filter(differ).count();
        assert!(count <= 4, "{mode:?}: {count} of 16,000 pixels differ");
        let lowest = shared.pixels.iter().map(|rgb| rgb[1]);
        assert!(lowest.fold(f32::INFINITY, f32::min) < 0.5 * shared.pixel(80, 90)[1].max(1.0));
    }
}

#[test]
fn structures_and_threads_give_the_same_bits() {
    let mut scene = balls();
    scene.render.ambient_occlusion.enabled = true;
    scene.render.ambient_occlusion.samples = 2;
    scene.render.ambient_occlusion.radius = 0.1;
    (scene.render.width, scene.render.height) = (64, 40);
    scene.render.mode = Mode::Path;
    scene.render.max_bounces = 2;
    let hash = |structure, threads| {
        let mut scene = scene.clone();
        scene.render.accelerator = structure;
        let run = RunConfig {
            threads,
            ..RunConfig::default()
        };
        let progress = RenderProgress::default();
        let outcome = render(&prepare(&scene, None), None, &run, &progress, None);
        outcome.expect("nobody cancels").image.hash()
    };
    let expected = hash(AcceleratorChoice::KdTree, 1);
    assert_eq!(hash(AcceleratorChoice::KdTree, 3), expected);
    assert_eq!(hash(AcceleratorChoice::Wide, 1), expected);
    assert_eq!(hash(AcceleratorChoice::Wide, 3), expected);
    assert_eq!(hash(AcceleratorChoice::BruteForce, 2), expected);
}

/// One mesh, a place for each copy, and no more.
#[test]
fn a_thousand_copies_take_about_the_memory_of_one() {
    let mut scene = balls();
    scene.objects.truncate(1);
    scene.objects[0].copies = Copies::default();
    let alone = bytes(&prepare(&scene, None));
    scene.objects[0].copies = Copies {
        count: [10, 10, 10],
        step: DVec3::splat(2.5),
    };
    let many = prepare(&scene, None);
    let accelerator = many.geometry().accelerator();
    assert_eq!(accelerator.triangle_count(), 1000 * 1280);
    assert!(accelerator.bytes() < alone + 1000 * 100, "{alone} alone");
}

#[test]
fn small_meshes_are_not_shared() {
    let mut scene = balls();
    let wall = |x| Object {
        mesh: "floor".into(),
        translate: DVec3::X * x,
        ..Object::default()
    };
    scene.objects = vec![wall(0.0), wall(1.0)];
    let prepared = prepare(&scene, None);
    assert!(prepared.geometry().accelerator().copies_of(0).is_none());
}

#[test]
fn moving_an_object_keeps_the_structures_of_shared_meshes() {
    let mut scene = balls();
    let before = prepare(&scene, None);
    scene.objects[0].translate.x += 1.0;
    scene.objects[3].rotate.z += 10.0;
    let after = prepare(&scene, Some(&before));
    let structure = |prepared: &PreparedScene, object| {
        let accelerator = prepared.geometry().accelerator();
        Arc::clone(accelerator.copies_of(object).expect("it is shared").0)
    };
    for object in [0, 2, 3] {
        let (old, new) = (structure(&before, object), structure(&after, object));
        assert!(Arc::ptr_eq(&old, &new));
    }
    let picture = |prepared: &PreparedScene| {
        let (run, progress) = (RunConfig::default(), RenderProgress::default());
        let outcome = render(prepared, None, &run, &progress, None);
        outcome.expect("nobody cancels").image.hash()
    };
    assert_eq!(picture(&after), picture(&prepare(&scene, None)));
}

/// Scenes are drawn before their trees are there. What is drawn answers as what is rendered, which keeps its triangles, its normals and the
/// structures that are there already.
#[test]
fn a_scene_that_is_placed_first_is_the_same() {
    let mut scene = balls();
    let before = prepare(&scene, None);
    scene.objects[1].translate.z += 0.5;
    let cancel = CancelToken::new();
    let place = |known: Option<&Arc<PreparedGeometry>>| {
        let placed = PreparedGeometry::place(&scene, known, &cancel);
        placed.expect("can be placed").expect("nobody cancels")
    };
    let direct = prepare(&scene, None);
    for known in [None, Some(before.geometry())] {
        let placed = place(known);
        for object in [0, 2, 3] {
            let structure = |geometry: &PreparedGeometry| {
                let accelerator = geometry.accelerator();
                Arc::as_ptr(accelerator.copies_of(object).expect("it is shared").0)
            };
            let is_kept = structure(&placed) == structure(before.geometry());
            assert_eq!(is_kept, known.is_some());
        }
        let progress = Progress::new();
        let prepared = PreparedScene::prepare_placed(&scene, &placed, None, &cancel, &progress);
        let prepared = prepared.expect("can be rendered").expect("nobody cancels");
        let geometry = prepared.geometry();
        assert_eq!(geometry.accelerator().name(), "wide");
        assert!(progress.fraction() >= 1.0);
        for (drawn, rendered) in placed.objects().iter().zip(geometry.objects()) {
            let address = |object: &PreparedObject| object.normals.as_ref().map(Arc::as_ptr);
            assert_eq!(address(drawn), address(rendered));
        }
        for pixel in 0..64 * 40 {
            let [x, y] = [pixel % 64, pixel / 64].map(|i| f64::from(i) + 0.5);
            let Some(from_eye) = prepared.camera().ray(x, y) else {
                continue;
            };
            let hit = |geometry: &PreparedGeometry| {
                let hit = geometry
                    .accelerator()
                    .intersect(&from_eye.ray, f32::INFINITY);
                hit.map(|hit| (hit.triangle, hit.t.to_bits()))
            };
            let expected = hit(direct.geometry());
            assert_eq!(hit(&placed), expected, "{x}, {y}");
            assert_eq!(hit(geometry), expected, "{x}, {y}");
        }
        assert!(Arc::ptr_eq(&place(Some(geometry)), geometry));
    }
}

/// Every object is found where it is, flat ones between copies included.
#[test]
fn objects_are_told_apart() {
    let scene = balls();
    let (shared, flat) = (prepare(&scene, None), prepare(&written_out(&scene), None));
    let mut seen = std::collections::BTreeSet::new();
    for y in 0..100 {
        for x in 0..160 {
            let at = |scene: &PreparedScene| scene.object_at(f64::from(x), f64::from(y));
            assert_eq!(at(&shared), at(&flat), "at {x}, {y}");
            seen.extend(at(&shared));
        }
    }
    assert_eq!(seen.len(), 4);
}

/// Copies that shine give the light of the same triangles written out, however it is found. In the middle of the scene, where
/// points are rounded least, no lamp shadows the points on it that are aimed at: then the two would not lose the same.
#[test]
fn shining_copies_give_the_light_of_their_triangles() {
    let mut scene = balls();
    scene.materials.insert(
        "lamp".into(),
        Material::Emitter {
            radiance: Rgb::new(4.0, 3.0, 2.0),
        },
    );
    // Small balls around the middle of the scene, where coordinates have the most digits.
    scene.objects[0] = Object {
        material: Some("lamp".into()),
        scale: 0.05,
        translate: DVec3::new(-0.2, -0.1, 0.0),
        copies: Copies {
            count: [3, 2, 1],
            step: DVec3::new(0.2, 0.2, 0.0),
        },
        ..scene.objects[0].clone()
    };
    scene.lights.clear();
    scene.background = Background::default();
    (scene.render.width, scene.render.height) = (40, 25);
    let mean = |scene: &Scene| {
        let image = picture(scene);
        let sum: f64 = image.pixels.iter().map(|rgb| f64::from(rgb[0])).sum();
        sum / image.pixels.len() as f64
    };
    for (mode, sampling) in [
        (Mode::Direct, LightSampling::Mis),
        (Mode::Path, LightSampling::Nee),
        (Mode::Path, LightSampling::Mis),
    ] {
        let mut scene = scene.clone();
        scene.render.mode = mode;
        scene.render.max_bounces = 1;
        scene.render.light_sampling = sampling;
        scene.render.samples_per_pixel = 16;
        let (shared, flat) = (mean(&scene), mean(&written_out(&scene)));
        assert!(
            (shared / flat - 1.0).abs() < 1e-4,
            "{mode:?}, {sampling:?}: {shared}, not {flat}"
        );
    }
}

/// However many copies there are of nothing, they are nothing.
#[test]
fn copies_of_an_empty_mesh_take_no_time() {
    let mut scene = Scene::default();
    let meshes = [
        ("ball", shapes::icosphere(0)),
        ("empty", TriangleMesh::default()),
    ];
    for (name, mesh) in meshes {
        scene.meshes.insert(name.into(), Arc::new(mesh));
        scene.objects.push(Object {
            mesh: name.into(),
            ..Object::default()
        });
    }
    scene.objects[1].copies.count = [1_000_000; 3];
    let prepared = PreparedScene::prepare(&scene, None, &CancelToken::new());
    assert!(prepared.expect("can be rendered").is_some());
}
