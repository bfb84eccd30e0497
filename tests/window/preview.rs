//! The preview and the picture frame the same things, to the pixel; and the preview's colours are those of a render
//! without shadows. Runs on software Vulkan without a display, and fails without an adapter.

use std::sync::Arc;

use eframe::wgpu;
use raymini::control::CancelToken;
use raymini::geometry::{TriangleMesh, shapes};
use raymini::gui::focus::{FocusAid, blur_diameter};
use raymini::gui::orbit::PictureSize;
use raymini::gui::pick;
use raymini::gui::preview::Preview;
use raymini::gui::preview::geometry::{GpuGeometry, PreviewMesh};
use raymini::gui::preview::sky::GpuSky;
use raymini::gui::worker::{Gpu, preview_mesh};
use raymini::io;
use raymini::math::{DVec2, DVec3, Degrees};
use raymini::render::{self, PreparedScene, RenderProgress, RunConfig, display};
use raymini::scene::Move;
use raymini::scene::{
    Background, Camera, Copies, ImageAxes, Material, Mode, Object, PhongModel, RadianceMap, Scene,
    Shadows, Texels, TextureImage, Textures, ToneCurve,
};

/// How near to an edge a pixel's centre may be for preview and picture to differ there, in pixels.
const EDGE: f64 = 1.0 / 128.0;

fn gpu() -> (wgpu::Device, wgpu::Queue) {
    pollster::block_on(async {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let adapter = instance
            .request_adapter(&wgpu::RequestAdapterOptions::default())
            .await
            .expect("an adapter; on Debian: apt install mesa-vulkan-drivers");
        adapter
            .request_device(&wgpu::DeviceDescriptor::default())
            .await
            .expect("a device")
    })
}

struct Drawn {
    preview: Preview,
    geometry: Arc<GpuGeometry>,
    prepared: PreparedScene,
}

fn drawn(scene: &Scene) -> Drawn {
    let (device, queue) = gpu();
    let prepared = prepared(scene);
    let mesh = preview_mesh(prepared.geometry(), u64::MAX, &CancelToken::new());
    let mesh = mesh.expect("nobody cancels");
    let geometry = Arc::new(GpuGeometry::upload(&device, mesh));
    let gpu = Gpu {
        device: device.clone(),
        queue: queue.clone(),
        number: 0,
    };
    let geometry = geometry.painted(&gpu, scene, None, &CancelToken::new());
    let geometry = geometry.expect("nobody cancels");
    let map = scene.background_image().expect("is loaded");
    let sky = map.map(|map| Arc::new(GpuSky::upload(&device, &queue, map)));
    let mut preview = Preview::new(device, queue, true);
    preview.set_sky(sky);
    Drawn {
        preview,
        geometry,
        prepared,
    }
}

fn prepared(scene: &Scene) -> PreparedScene {
    PreparedScene::prepare(scene, None, &CancelToken::new())
        .expect("the scene can be rendered")
        .expect("nobody cancels")
}

/// Every pixel shows the same object in the preview as the ray through its centre finds; where rays an [`EDGE`] away
/// disagree among themselves, the centre is on an edge and either answer is right.
fn assert_same_frame(scene: &Scene) {
    let mut drawn = drawn(scene);
    let (width, height) = (scene.render.width, scene.render.height);
    let shown = drawn
        .preview
        .object_ids(scene, &drawn.geometry, [width, height])
        .expect("ids can be read back");
    assert_eq!(shown.len(), (width * height) as usize);

    let mut on_edges = 0;
    let mut wrong = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let (cx, cy) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
            let traced = drawn.prepared.object_at(cx, cy);
            let drawn_there = shown[(y * width + x) as usize];
            if drawn_there == traced {
                continue;
            }
            let mut nearby = (0..9).map(|i| {
                let (dx, dy) = (f64::from(i % 3 - 1) * EDGE, f64::from(i / 3 - 1) * EDGE);
                drawn.prepared.object_at(cx + dx, cy + dy)
            });
            if nearby.all(|object| object == traced) {
                wrong.push((x, y, drawn_there, traced));
            } else {
                on_edges += 1;
            }
        }
    }
    let camera = &scene.camera;
    assert!(
        wrong.is_empty(),
        "{width}×{height}, {camera:?}: {} pixels differ, such as {:?}",
        wrong.len(),
        &wrong[..wrong.len().min(8)]
    );
    let share = f64::from(on_edges) / f64::from(width * height);
    assert!(share < 0.001, "{share} of all pixels differ on edges");
    let objects: std::collections::BTreeSet<_> = shown.iter().flatten().collect();
    assert!(objects.len() > 1, "{camera:?} sees {objects:?} only");
}

fn scene_at(size: (u32, u32), eye: DVec3, target: DVec3, up: DVec3, fov: f64) -> Scene {
    let mut scene = io::demo_scene();
    (scene.render.width, scene.render.height) = size;
    scene.camera = Camera {
        eye,
        target,
        up,
        vertical_fov: Degrees(fov),
        ..Camera::default()
    };
    scene
}

const SIZES: [(u32, u32); 3] = [(333, 217), (320, 180), (101, 257)];

#[test]
fn the_demo_is_framed_alike_from_its_own_camera() {
    for size in SIZES {
        let mut scene = io::demo_scene();
        (scene.render.width, scene.render.height) = size;
        assert_same_frame(&scene);
    }
}

#[test]
fn a_narrow_view_is_framed_alike() {
    let target = DVec3::new(0.0, 0.0, 0.5);
    for size in SIZES {
        let eye = DVec3::new(3.0, -14.0, 5.0);
        assert_same_frame(&scene_at(size, eye, target, DVec3::Z, 10.0));
    }
}

/// A wide view from among the objects: triangles reach behind the eye.
#[test]
fn a_wide_view_among_the_objects_is_framed_alike() {
    for size in SIZES {
        let eye = DVec3::new(0.7, -1.6, 0.9);
        let target = DVec3::new(0.2, 0.0, 0.5);
        assert_same_frame(&scene_at(size, eye, target, DVec3::Z, 120.0));
    }
}

/// The frame follows any `up`, and a camera that looks straight down.
#[test]
fn tilted_and_vertical_views_are_framed_alike() {
    let eye = DVec3::new(-1.0, -4.0, 3.0);
    let target = DVec3::new(0.0, 0.0, 0.4);
    assert_same_frame(&scene_at(
        (333, 217),
        eye,
        target,
        DVec3::new(0.6, 0.1, 0.7),
        40.0,
    ));
    let above = DVec3::new(0.1, 0.2, 9.0);
    assert_same_frame(&scene_at((217, 333), above, DVec3::ZERO, DVec3::Y, 40.0));
}

/// A scene far from the origin and tiny: both sides see the same narrowed triangles.
#[test]
fn a_tiny_scene_far_out_is_framed_alike() {
    let mut scene = io::demo_scene();
    let (scale, offset) = (1e-4, DVec3::new(12.0, -30.0, 7.0));
    for object in &mut scene.objects {
        object.scale *= scale;
        object.translate = object.translate * scale + offset;
    }
    let camera = &mut scene.camera;
    camera.eye = camera.eye * scale + offset;
    camera.target = camera.target * scale + offset;
    (scene.render.width, scene.render.height) = (333, 217);
    assert_same_frame(&scene);
}

/// The demo with more rams and gargoyles, which share their triangles: turned, mirrored, among single objects.
fn demo_with_copies() -> Scene {
    let mut scene = io::demo_scene();
    let find = |scene: &Scene, name: &str| {
        let index = scene.objects.iter().position(|object| object.name == name);
        index.expect("the demo has it")
    };
    let ram = find(&scene, "ram");
    scene.objects[ram].copies = Copies {
        count: [1, 3, 2],
        step: DVec3::new(0.0, 1.3, 0.9),
    };
    let gargoyle = find(&scene, "gargoyle");
    let mirrored = Object {
        name: "mirrored".into(),
        scale: -0.5,
        rotate: DVec3::new(180.0, 0.0, 25.0),
        translate: DVec3::new(0.2, -1.2, 0.0),
        smooth: false,
        ..scene.objects[gargoyle].clone()
    };
    scene.objects.insert(1, mirrored);
    scene
}

#[test]
fn copies_are_framed_alike() {
    for size in SIZES {
        let mut scene = demo_with_copies();
        (scene.render.width, scene.render.height) = size;
        assert_same_frame(&scene);
    }
    // From among them, far from the origin.
    let mut scene = demo_with_copies();
    let offset = DVec3::new(1e5, -3e4, 7e3);
    for object in &mut scene.objects {
        object.translate += offset;
    }
    scene.camera.eye = offset + DVec3::new(-1.2, -1.6, 1.0);
    scene.camera.target = offset + DVec3::new(-1.7, 1.0, 0.7);
    scene.camera.vertical_fov = Degrees(90.0);
    (scene.render.width, scene.render.height) = (333, 217);
    assert_same_frame(&scene);
}

#[test]
fn copies_have_the_colors_of_a_render() {
    let mut base = demo_with_copies();
    (base.render.width, base.render.height) = (161, 97);
    base.render.samples_per_pixel = 1;
    base.render.antialiasing = false;
    base.render.shadows = Shadows::Off;
    for mode in [Mode::Direct, Mode::Normals, Mode::Facing, Mode::Depth] {
        base.render.mode = mode;
        assert_same_colors(&base);
    }
}

/// What is in the hand is drawn where it is, before its triangles are prepared anew.
#[test]
fn moved_objects_are_drawn_where_they_are() {
    let mut before = demo_with_copies();
    (before.render.width, before.render.height) = (333, 217);
    let mut after = before.clone();
    let index = |name: &str| before.objects.iter().position(|object| object.name == name);
    let [rhino, ram, mirrored] = ["rhinoceros", "ram", "mirrored"].map(|name| index(name).unwrap());
    after.objects[rhino].rotate.z += 40.0;
    after.objects[rhino].scale *= -1.2;
    after.objects[rhino].translate.z += 0.8;
    after.objects[ram].translate.x -= 0.4;
    after.objects[mirrored].rotate = DVec3::new(100.0, 10.0, 0.0);
    let moves = before.objects.iter().zip(&after.objects);
    let moves: Vec<_> = moves.map(|(a, b)| Move::between(a, b)).collect();
    assert_eq!(moves.iter().flatten().count(), 3);

    let size = [333, 217];
    let mut moved = drawn(&before);
    let still = moved.preview.object_ids(&after, &moved.geometry, size);
    moved.preview.set_moves(moves);
    let found = moved.preview.object_ids(&after, &moved.geometry, size);
    let mut anew = drawn(&after);
    let expected = anew
        .preview
        .object_ids(&after, &anew.geometry, size)
        .unwrap();
    let differing = |ids: Vec<Option<usize>>| {
        let pairs = ids.into_iter().zip(&expected);
        pairs.filter(|(a, b)| a != *b).count()
    };
    assert!(differing(still.unwrap()) > 2000, "they are elsewhere");
    let differ = differing(found.unwrap());
    assert!(
        differ < 30,
        "{differ} pixels differ: more than some on edges"
    );

    // Shaded as they are now: sides, normals.
    for mode in [Mode::Facing, Mode::Normals] {
        after.render.mode = mode;
        let colors = [&mut moved, &mut anew].map(|drawn| {
            drawn.preview.draw(&after, &drawn.geometry, size).unwrap();
            drawn.preview.read_color().unwrap()
        });
        let pairs = colors[0].iter().zip(&colors[1]);
        let differ = pairs.filter(|(a, b)| (0..3).any(|c| a[c].abs_diff(b[c]) > 3));
        let differ = differ.count();
        assert!(differ < 60, "{mode:?}: {differ} pixels differ");
    }
}

/// The plane of focus is a line where it cuts things; what is before and behind it has colours of its own, as far as it is blurred.
#[test]
fn what_is_sharp_is_seen_in_the_preview() {
    let mut scene = io::demo_scene();
    (scene.render.width, scene.render.height) = (320, 180);
    let camera = &mut scene.camera;
    camera.aperture_radius = 0.1;
    let focus = camera.eye.distance(camera.target);
    let forward = camera.axes().unwrap().forward;
    let size = [320, 180];
    let mut drawn = drawn(&scene);
    let mut colors = |scene: &Scene, aid: FocusAid| {
        drawn.preview.set_focus_aid(aid);
        drawn.preview.draw(scene, &drawn.geometry, size).unwrap();
        drawn.preview.read_color().unwrap()
    };
    let plain = colors(&scene, FocusAid::Off);
    let plane = colors(&scene, FocusAid::Plane);
    let blur = colors(&scene, FocusAid::Blur);
    let prepared = prepared(&scene);
    let picture = PictureSize {
        width: 320.0,
        height: 180.0,
    };
    let mut counts = [0; 3];
    for (index, ((plain, plane), blur)) in plain.iter().zip(&plane).zip(&blur).enumerate() {
        let (x, y) = ((index % 320) as f64 + 0.5, (index / 320) as f64 + 0.5);
        let position = DVec2::new(x, y);
        let settings = &scene.render;
        let geometry = prepared.geometry();
        let picked = pick::pick(geometry, &scene.camera, settings, picture, position);
        let Some(picked) = picked else {
            assert_eq!(plain, blur, "the sky is left as it is");
            continue;
        };
        let depth = forward.dot(picked.point - scene.camera.eye);
        let is_marked = plain != plane;
        // Along the ground one pixel is a hundredth of the distance at most.
        if is_marked {
            counts[0] += 1;
            assert!((depth / focus - 1.0).abs() < 0.2, "{x} {y}: {depth}");
        }
        let diameter = blur_diameter(&scene.camera, 180.0, depth);
        if diameter < 0.9 && !is_marked {
            assert_eq!(plain, blur, "{x} {y} is sharp");
        } else if diameter > 4.0 {
            let redder = i32::from(blur[0]) - i32::from(plain[0]);
            let bluer = i32::from(blur[2]) - i32::from(plain[2]);
            let is_before = depth < focus;
            counts[1 + usize::from(is_before)] += 1;
            assert_eq!(redder > bluer, is_before, "{x} {y}: {depth}");
        }
    }
    assert!(counts.iter().all(|&count| count > 100), "{counts:?}");
    let mut pinhole = scene.clone();
    pinhole.camera.aperture_radius = 0.0;
    assert_eq!(
        colors(&pinhole, FocusAid::Blur),
        plane,
        "nothing is blurred"
    );
    pinhole.camera.focus_distance = Some(f64::INFINITY);
    assert_eq!(colors(&pinhole, FocusAid::Blur), plain, "nothing is cut");
}

/// What the preview holds grows with meshes and places, not with what is drawn.
#[test]
fn shared_triangles_are_uploaded_once() {
    let mut scene = io::demo_scene();
    scene.objects.retain(|object| object.name == "ram");
    let packed = |scene: &Scene| {
        let mesh = preview_mesh(prepared(scene).geometry(), u64::MAX, &CancelToken::new());
        mesh.expect("nobody cancels")
    };
    let vertices = |mesh: &PreviewMesh| -> usize {
        let levels = mesh.parts.iter().flat_map(|part| &part.levels);
        levels.map(|level| level.vertices.len()).sum()
    };
    let once = vertices(&packed(&scene));
    scene.objects[0].copies = Copies {
        count: [100, 100, 1],
        step: DVec3::new(2.0, 2.0, 0.0),
    };
    let mesh = packed(&scene);
    assert_eq!(vertices(&mesh), once);
    let groups = mesh.objects[0].groups.iter();
    assert_eq!(
        groups.map(|group| group.places.len()).sum::<usize>(),
        10_000
    );
}

/// What is too much for a frame is drawn in fewer triangles, which cover the same pixels but for those at outlines, wherever one looks from.
#[test]
fn what_is_simplified_covers_the_same_pixels() {
    let mut scene = io::demo_scene();
    scene.objects.retain(|object| object.name == "ram");
    scene.objects[0].copies = Copies {
        count: [10, 10, 1],
        step: DVec3::new(1.5, 1.5, 0.0),
    };
    scene.background = Background::Constant {
        radiance: DVec3::ZERO,
    };
    // Every object is white, and what is behind black.
    scene.render.mode = Mode::Object;
    (scene.render.width, scene.render.height) = (240, 160);
    let size = [240, 160];
    let (device, queue) = gpu();
    let prepared = prepared(&scene);
    let mesh = preview_mesh(prepared.geometry(), 1, &CancelToken::new());
    let mesh = mesh.expect("nobody cancels");
    let geometry = Arc::new(GpuGeometry::upload(&device, mesh));
    let mut preview = Preview::new(device, queue, true);
    let mut simplified = 0;
    for (eye, target) in [
        (DVec3::new(-8.0, -20.0, 12.0), DVec3::new(6.0, 6.0, 0.0)),
        (DVec3::new(-2.0, -3.0, 1.0), DVec3::new(5.0, 6.0, 0.5)),
        (DVec3::new(6.7, 6.7, 60.0), DVec3::new(6.8, 6.8, 0.0)),
    ] {
        (scene.camera.eye, scene.camera.target) = (eye, target);
        preview.draw(&scene, &geometry, size).expect("a camera");
        simplified += u32::from(preview.omission().is_any());
        let shown = preview.read_color().expect("it was drawn");
        let ids = preview.object_ids(&scene, &geometry, size);
        let ids = ids.expect("ids can be read back");
        let covered = ids.iter().filter(|id| id.is_some()).count();
        let is_other = |(color, id): &(&[u8; 4], &Option<usize>)| (color[0] > 0) != id.is_some();
        let other = shown.iter().zip(&ids).filter(is_other).count();
        assert!(covered > 1500, "{covered}");
        assert!(other * 10 < covered, "{other} of {covered} from {eye}");
    }
    assert!(simplified > 0);
}

/// Without shadows and with one sample at each pixel's centre, preview and picture differ by rounding only: same shading,
/// same background, same exposure and tone curve, in every mode.
#[test]
fn the_preview_looks_like_a_render_without_shadows() {
    let mut base = io::demo_scene();
    (base.render.width, base.render.height) = (161, 97);
    base.render.samples_per_pixel = 1;
    base.render.antialiasing = false;
    base.render.shadows = Shadows::Off;
    let gradient = Background::Gradient {
        zenith: DVec3::new(0.1, 0.3, 0.8),
        horizon: DVec3::new(0.6, 0.5, 0.4),
        ground: DVec3::new(0.1, 0.2, 0.05),
        up: DVec3::new(0.2, 0.0, 1.0),
    };
    let modes = [
        Mode::Direct,
        Mode::Normals,
        Mode::Depth,
        Mode::Albedo,
        Mode::Facing,
        Mode::Object,
    ];
    for mode in modes {
        let mut scene = base.clone();
        scene.render.mode = mode;
        scene.background = gradient.clone();
        assert_same_colors(&scene);
    }
    let mut scene = base.clone();
    scene.render.phong = PhongModel::Classic;
    scene.display.exposure = -0.7;
    scene.display.tone_curve = ToneCurve::Aces;
    assert_same_colors(&scene);
    let flat = |object: &Object| Object {
        smooth: false,
        ..object.clone()
    };
    base.objects = base.objects.iter().map(flat).collect();
    base.display.exposure = 0.5;
    assert_same_colors(&base);
}

fn assert_same_colors(scene: &Scene) {
    assert_same_colors_within(scene, 3, 0.004);
}

/// Writes preview, picture, and twenty times their difference side by side, to see what is wrong.
fn leave_behind(scene: &Scene, shown: &[[u8; 4]], rendered: &[[f32; 3]]) {
    let (width, height) = (scene.render.width, scene.render.height);
    let mut sheet = image::RgbImage::new(3 * width, height);
    for (index, (shown, rendered)) in (0..).zip(shown.iter().zip(rendered)) {
        let (x, y) = (index % width, index / width);
        let rendered = display::encode_8(*rendered, &scene.display);
        let shown = [shown[0], shown[1], shown[2]];
        let difference = std::array::from_fn(|i| shown[i].abs_diff(rendered[i]).saturating_mul(20));
        for (number, color) in (0..).zip([shown, rendered, difference]) {
            sheet.put_pixel(number * width + x, y, image::Rgb(color));
        }
    }
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("preview.png");
    sheet.save(&path).unwrap();
    eprintln!("preview, picture, difference: {}", path.display());
}

/// All but a share of `most_far_off` of the pixels are the same up to so many of 255 `steps`.
fn assert_same_colors_within(scene: &Scene, steps: u8, most_far_off: f64) {
    let mut drawn = drawn(scene);
    let size = [scene.render.width, scene.render.height];
    drawn
        .preview
        .draw(scene, &drawn.geometry, size)
        .expect("the camera has a direction");
    let shown = drawn.preview.read_color().expect("pixels can be read back");
    let outcome = render::render(
        &drawn.prepared,
        None,
        &RunConfig::default(),
        &RenderProgress::default(),
        None,
    )
    .expect("nobody cancels");

    // Silhouettes fall to either side; a highlight as sharp as the demo's moves with the last digit of a normal.
    let far_off = shown
        .iter()
        .zip(&outcome.image.pixels)
        .filter(|(shown, rendered)| {
            let rendered = display::encode_8(**rendered, &scene.display);
            (0..3).any(|channel| shown[channel].abs_diff(rendered[channel]) > steps)
        })
        .count();
    let share = far_off as f64 / shown.len() as f64;
    if share >= most_far_off {
        leave_behind(scene, &shown, &outcome.image.pixels);
    }
    assert!(
        share < most_far_off,
        "{:?} {:?}: {far_off} of {} pixels have another colour",
        scene.render.mode,
        scene.render.phong,
        shown.len()
    );
}

/// A floor under an image, a ball with the colours of its vertices, mirrored copies of both, all of it lit by the demo's lights.
fn painted(texels: Texels, width: u32) -> Scene {
    let mut scene = io::demo_scene();
    (scene.render.width, scene.render.height) = (161, 97);
    scene.render.samples_per_pixel = 1;
    scene.render.antialiasing = false;
    scene.render.shadows = Shadows::Off;
    scene.objects.clear();
    let height = u32::try_from(texels.len()).unwrap() / width;
    let image = TextureImage::new(width, height, texels);
    scene.textures.insert("image".into(), Arc::new(image));

    let mut floor = shapes::grid(4);
    let coordinates = floor.positions.iter().map(|p| DVec2::new(p.x, p.y) * 0.3);
    // Far from 0, where images repeat.
    let coordinates = coordinates.map(|place| place + DVec2::new(1e6, -3e6));
    floor.texture_coordinates = Some(coordinates.collect());
    let mut ball = shapes::icosphere(4);
    let color = |p: &DVec3| (*p * 0.5 + 0.5).as_vec3();
    ball.colors = Some(ball.positions.iter().map(color).collect());
    let mut add = |name: &str, mesh: TriangleMesh, textures: Textures| {
        scene.meshes.insert(name.into(), Arc::new(mesh));
        let mut material = Material::default();
        *material.textures_mut().unwrap() = textures;
        scene.materials.insert(name.into(), material);
        let object = Object {
            name: name.into(),
            mesh: name.into(),
            material: Some(name.into()),
            smooth: true,
            ..Object::default()
        };
        let mut mirrored = object.clone();
        mirrored.scale = -0.7;
        mirrored.rotate = DVec3::new(180.0, 0.0, 30.0);
        mirrored.translate = DVec3::new(1.4, 0.9, 0.4);
        scene.objects.extend([object, mirrored]);
    };
    let imaged = Textures {
        diffuse_image: Some("image".into()),
        ..Textures::default()
    };
    let colored = Textures {
        vertex_colors: true,
        ..Textures::default()
    };
    add("floor", floor, imaged);
    add("ball", ball, colored);
    scene.objects[2].translate.z = 0.5;
    scene.objects[2].scale = 0.5;
    // Not along the floor, where ways of filtering differ.
    scene.camera.eye = DVec3::new(0.9, -3.0, 6.0);
    scene.camera.target = DVec3::new(0.7, 0.4, 0.2);
    scene
}

/// A smooth image, so that ways of filtering it do not differ by more than a few steps.
fn waves(width: u32, height: u32) -> Vec<[f32; 3]> {
    let wave = |x: u32, width: u32, turns: f32| {
        let angle = std::f32::consts::TAU * turns * (x as f32 + 0.5) / width as f32;
        0.5 + 0.4 * angle.sin()
    };
    let texel = |x, y| {
        [
            wave(x, width, 1.0),
            wave(y, height, 2.0),
            wave(x, width, 2.0) * wave(y, height, 1.0),
        ]
    };
    let rows = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    rows.map(|(x, y)| texel(x, y)).collect()
}

/// Images of every kind and colours of vertices look as in a render, also on what is mirrored, moved by hand, and shared by copies.
#[test]
fn images_and_colors_of_vertices_look_as_in_a_render() {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "waves are in 0..=1"
    )]
    let word = |value: f32| (value * 65_535.0).round() as u16;
    let byte = |value: f32| u8::try_from(word(value) / 257).unwrap();
    let texels = [
        Texels::Bytes(waves(64, 48).iter().map(|texel| texel.map(byte)).collect()),
        Texels::Words(waves(64, 48).iter().map(|texel| texel.map(word)).collect()),
        Texels::Floats(waves(64, 48)),
    ];
    for texels in texels {
        assert_same_colors_within(&painted(texels, 64), 4, 0.01);
    }
    let mut scene = painted(Texels::Floats(waves(64, 48)), 64);
    scene.render.mode = Mode::Albedo;
    assert_same_colors_within(&scene, 4, 0.01);
    // Enough triangles for copies to share them.
    let ball = Arc::clone(&scene.meshes["ball"]);
    assert!(ball.triangles.len() * 3 > 4096);
    for object in &mut scene.objects[2..] {
        object.scale *= 0.4;
        object.copies = Copies {
            count: [2, 2, 1],
            step: DVec3::new(0.9, 0.8, 0.0),
        };
    }
    assert!(
        prepared(&scene)
            .geometry()
            .accelerator()
            .copies_of(2)
            .is_some()
    );
    assert_same_colors_within(&scene, 4, 0.01);
}

/// Images of normals turn them as in a render, also on what is mirrored, beside an image of colours or alone.
#[test]
fn images_of_normals_emboss_as_in_a_render() {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "waves are in 0..=1"
    )]
    let byte = |value: f32| (128.0 + (value - 0.5) * 120.0).round() as u8;
    let normal = |[x, y, _]: &[f32; 3]| [byte(*x), byte(*y), 240];
    let bytes = Texels::Bytes(waves(64, 48).iter().map(normal).collect());
    let floats = waves(64, 48).into_iter();
    let floats = floats
        .map(|[x, y, _]| [0.25 + x / 2.0, 0.25 + y / 2.0, 0.95])
        .collect();
    for (texels, keeps_color) in [(bytes, true), (Texels::Floats(floats), false)] {
        let mut scene = painted(texels, 64);
        let floor = scene.materials.get_mut("floor").unwrap();
        let textures = floor.textures_mut().unwrap();
        textures.normal_image = textures.diffuse_image.clone();
        if !keeps_color {
            textures.diffuse_image = None;
        }
        for mode in [Mode::Direct, Mode::Normals] {
            scene.render.mode = mode;
            assert_same_colors_within(&scene, 4, 0.01);
        }
        let flat = {
            let mut flat = scene.clone();
            let floor = flat.materials.get_mut("floor").unwrap();
            floor.textures_mut().unwrap().normal_image = None;
            colors_of(&flat)
        };
        let other = colors_of(&scene).into_iter().zip(flat);
        let other = other.filter(|(a, b)| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 8));
        assert!(other.count() > 2000, "normals are turned");
    }
}

fn colors_of(scene: &Scene) -> Vec<[u8; 4]> {
    let mut drawn = drawn(scene);
    let size = [scene.render.width, scene.render.height];
    let shown = drawn.preview.draw(scene, &drawn.geometry, size);
    assert!(shown.is_some());
    drawn.preview.read_color().expect("it was drawn")
}

/// Far away, an image is its mean; one of thin stripes too, whose texels alone are black or white.
#[test]
fn a_far_image_is_its_mean_and_does_not_sparkle() {
    let stripes = (0..256 * 256_u32).map(|i| [if i % 2 == 0 { 0 } else { 255 }; 3]);
    let mut scene = painted(Texels::Bytes(stripes.collect()), 256);
    scene.objects.truncate(1);
    scene.render.mode = Mode::Albedo;
    scene.camera.eye = DVec3::new(0.0, 0.0, 30.0);
    scene.camera.target = DVec3::ZERO;
    scene.camera.up = DVec3::Y;
    scene.camera.vertical_fov = Degrees(5.0);
    let mut drawn = drawn(&scene);
    let size = [scene.render.width, scene.render.height];
    drawn.preview.draw(&scene, &drawn.geometry, size).unwrap();
    let shown = drawn.preview.read_color().unwrap();
    // Half of the light of 0.8.
    let expected = display::encode_8([0.4; 3], &scene.display)[0];
    let middle = &shown[97 / 2 * 161 + 60..][..40];
    assert!(
        middle.iter().all(|pixel| pixel[0].abs_diff(expected) <= 2),
        "{middle:?}"
    );
}

/// A scene without images and colours of vertices has the triangles alone, also where meshes have coordinates and colours that no material
/// shows; until an image is uploaded, its mean is seen.
#[test]
fn what_shows_no_image_has_none_on_the_gpu() {
    let mut scene = painted(Texels::Bytes(vec![[188; 3]; 4]), 2);
    scene.objects.retain(|object| object.scale > 0.0);
    let painted = drawn(&scene).geometry;
    let [image, colors] = ["floor", "ball"].map(|name| scene.materials[name].clone());
    for name in ["floor", "ball"] {
        scene.materials.insert(name.into(), Material::default());
    }
    let mut plain = drawn(&scene);
    let (device, queue) = gpu();
    let gpu = Gpu {
        device,
        queue,
        number: 0,
    };
    let again = plain
        .geometry
        .painted(&gpu, &scene, None, &CancelToken::new());
    assert!(Arc::ptr_eq(&again.unwrap(), &plain.geometry));
    assert!(!Arc::ptr_eq(&painted, &plain.geometry));

    // The preview of the scene with an image on triangles without.
    scene.materials.insert("floor".into(), image);
    scene.materials.insert("ball".into(), colors);
    scene.render.mode = Mode::Albedo;
    let corner = DVec3::new(0.9, 0.9, 0.0);
    scene.camera.eye = corner + DVec3::Z;
    scene.camera.target = corner;
    scene.camera.up = DVec3::Y;
    plain
        .preview
        .draw(&scene, &plain.geometry, [11, 11])
        .unwrap();
    let shown = plain.preview.read_color().unwrap();
    let expected = display::encode_8([0.8 * 0.503; 3], &scene.display)[0];
    assert!(
        shown[60][0].abs_diff(expected) <= 1,
        "{:?}, {expected}",
        shown[60]
    );
}

/// The demo under an image of `pixel`s, turned and tilted.
fn under_sky(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [f32; 3]) -> Scene {
    let mut scene = io::demo_scene();
    (scene.render.width, scene.render.height) = (161, 97);
    scene.render.samples_per_pixel = 1;
    scene.render.antialiasing = false;
    scene.render.shadows = Shadows::Off;
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let (map, _) = RadianceMap::cleaned(width, height, pixels.map(|(x, y)| pixel(x, y)).collect());
    scene.images.insert("sky".into(), Arc::new(map));
    scene.background = Background::Image {
        image: "sky".into(),
        up: DVec3::new(0.2, -0.1, 1.0),
        rotation: Degrees(130.0),
        scale: 0.8,
    };
    scene
}

/// The preview's picture of a scene under an image, and the render's in the values of the screen.
fn sky_pictures(scene: &Scene) -> (Vec<[u8; 4]>, Vec<[u8; 3]>, Drawn) {
    let mut drawn = drawn(scene);
    let size = [scene.render.width, scene.render.height];
    drawn.preview.draw(scene, &drawn.geometry, size).unwrap();
    let shown = drawn.preview.read_color().unwrap();
    let progress = RenderProgress::default();
    let run = RunConfig::default();
    let outcome = render::render(&drawn.prepared, None, &run, &progress, None);
    let image = outcome.expect("nobody cancels").image;
    let encode = |&pixel: &[f32; 3]| display::encode_8(pixel, &scene.display);
    (shown, image.pixels.iter().map(encode).collect(), drawn)
}

/// The sky is the same to a few of 255 steps, and objects are lit about as brightly.
#[test]
fn an_image_is_seen_and_lights_as_in_a_render() {
    let mut scene = under_sky(32, 16, |x, y| {
        [
            0.05 + 0.01 * x as f32,
            0.4 / (1.0 + y as f32),
            0.05 * ((x + y) % 5) as f32,
        ]
    });
    scene.lights.clear();
    scene.render.ambient_occlusion.samples = 256;
    let (shown, rendered, drawn) = sky_pictures(&scene);
    let (mut sky, mut off, mut lit) = (0, 0, [0.0; 2]);
    for (index, (shown, rendered)) in (0..161 * 97_u32).zip(shown.iter().zip(&rendered)) {
        let (x, y) = (f64::from(index % 161) + 0.5, f64::from(index / 161) + 0.5);
        if drawn.prepared.object_at(x, y).is_none() {
            sky += 1;
            off += u32::from((0..3).any(|c| shown[c].abs_diff(rendered[c]) > 2));
        } else {
            lit[0] += f64::from(shown[0]);
            lit[1] += f64::from(rendered[0]);
        }
    }
    assert!(sky > 1000 && off < sky / 200, "{off} of {sky} differ");
    assert!((lit[0] / lit[1] - 1.0).abs() < 0.05, "{lit:?}");
}

/// The brightest pixel of a sun is at the same place in both pictures, give or take one.
#[test]
fn the_sun_is_where_the_render_has_it() {
    for sun in [(40, 20), (118, 25), (84, 27)] {
        let mut scene = under_sky(
            128,
            64,
            |x, y| {
                if (x, y) == sun { [1.0; 3] } else { [0.01; 3] }
            },
        );
        let map = scene.background_image().unwrap().unwrap();
        // Looked at from below, so that nothing is before it.
        let Background::Image { up, rotation, .. } = scene.background else {
            unreachable!("an image was set")
        };
        let axes = ImageAxes::new(up, rotation).unwrap();
        let angle = std::f64::consts::TAU * (0.5 - (f64::from(sun.0) + 0.5) / 128.0);
        let (sine, cosine) = map.polar_angle(sun.1).sin_cos();
        let level = axes.front * angle.cos() + axes.left * angle.sin();
        let towards = axes.up * cosine + level * sine;
        scene.camera.eye = DVec3::new(0.0, 0.0, 50.0);
        scene.camera.target = scene.camera.eye + towards + DVec3::new(0.02, 0.1, -0.05);
        scene.camera.vertical_fov = Degrees(40.0);
        let (shown, rendered, _) = sky_pictures(&scene);
        let brightest = |values: &mut dyn Iterator<Item = u8>| {
            let (index, _) = (0..161 * 97_i32)
                .zip(values)
                .max_by_key(|&(index, value)| (value, -index))
                .unwrap();
            (index % 161, index / 161)
        };
        let a = brightest(&mut shown.iter().map(|pixel| pixel[0]));
        let b = brightest(&mut rendered.iter().map(|pixel| pixel[0]));
        assert!(
            (a.0 - b.0).abs() <= 1 && (a.1 - b.1).abs() <= 1,
            "{sun:?}: {a:?}, {b:?}"
        );
        assert!(
            (10..150).contains(&a.0) && (10..87).contains(&a.1),
            "{sun:?}: {a:?}"
        );
    }
}

/// Lights beyond what the preview shows are left out there, and nothing fails.
#[test]
fn more_lights_than_the_preview_shows_are_drawn_without_the_rest() {
    let mut scene = io::demo_scene();
    (scene.render.width, scene.render.height) = (40, 30);
    let light = scene.lights[0];
    scene.lights = vec![light; 1000];
    let mut drawn = drawn(&scene);
    assert!(
        drawn
            .preview
            .draw(&scene, &drawn.geometry, [40, 30])
            .is_some()
    );
    assert!(drawn.preview.read_color().is_ok());
}

#[test]
fn a_camera_without_direction_draws_nothing() {
    let mut scene = io::demo_scene();
    let mut drawn = drawn(&scene);
    scene.camera.target = scene.camera.eye;
    assert!(
        drawn
            .preview
            .draw(&scene, &drawn.geometry, [40, 30])
            .is_none()
    );
}
