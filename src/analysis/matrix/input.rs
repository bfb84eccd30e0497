//! Files and numbers that mean harm or make no sense.

use std::sync::Arc;

use super::{Bar, Case, Effort};
use crate::control::{CancelToken, Progress};
use crate::geometry::shapes::{self, Random};
use crate::io::{self, MeshFormat, scene_file};
use crate::render::PreparedScene;

pub const CASES: &[Case] = &[
    Case {
        name: "impossible meshes",
        tried: "numbers, counts and indices that no mesh can have: files that are taken",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: impossible_meshes,
    },
    Case {
        name: "impossible settings",
        tried: "not a number, infinite, negative and huge values of the keys that hold numbers: scenes that are taken, and possible values that are refused",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: impossible_settings,
    },
    Case {
        name: "damaged meshes",
        tried: "mutated files of every mesh format: files that are taken with an index out of range or a corner that is not finite",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: damaged_meshes,
    },
];

fn is_mesh(bytes: &[u8]) -> bool {
    matches!(
        io::off::parse(bytes, &CancelToken::new(), &Progress::new()),
        Ok(Some(_))
    )
}

fn impossible_meshes(_: Effort) -> f64 {
    let with_vertex = |text: &str| format!("OFF 3 1 0\n0 0 0\n1 0 0\n{text}\n3 0 1 2\n");
    let with_face = |text: &str| format!("OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n{text}\n");
    let mut files: Vec<String> = [
        "0 1 nan",
        "0 inf 0",
        "0 -inf 0",
        "0 1e400 0",
        "0 1",
        "0 one 0",
        "",
    ]
    .map(with_vertex)
    .into();
    files.extend(
        [
            "3 0 1 3",
            "3 0 1 -1",
            "3 0 1 2147483648",
            "3 0 1 4294967296",
            "3 0 1 1e20",
            "3 0 1 1.5",
            "3 0 1",
            "-3 0 1 2",
        ]
        .map(with_face),
    );
    for counts in [
        "1000000000000 1 0",
        "18446744073709551615 1 0",
        "1e30 1 0",
        "-1 1 0",
        "3 -1 0",
        "3",
        "",
    ] {
        files.push(format!("OFF {counts}\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"));
    }
    files.iter().filter(|text| is_mesh(text.as_bytes())).count() as f64
}

/// What the demo becomes before its keys are tried, so that every kind of material and light is in it.
const EVERY_KIND: &[&str] = &[
    "background.radiance=[0, 0, 0]",
    "lights.0.kind=disk",
    "materials.hide.kind=mirror",
    "materials.stone.kind=glass",
    "materials.earth.kind=emitter",
];

/// A key, a value that it may have, and values that it may not.
const KEYS: &[(&str, &str, &[&str])] = &[
    (
        "render.width",
        "64",
        &["0", "-1", "65537", "1.5", "nan", "1000000000000"],
    ),
    ("render.height", "64", &["0", "-1", "65537", "1.5", "nan"]),
    (
        "render.samples_per_pixel",
        "4",
        &["0", "-1", "0.5", "99999999999"],
    ),
    ("render.seed", "7", &["-1", "0.5", "1e400"]),
    ("render.max_bounces", "2", &["-1", "1048577", "inf"]),
    ("render.clamp", "10", &["0", "-1", "nan", "inf"]),
    ("render.stop.noise", "0.1", &["0", "-0.1", "nan", "inf"]),
    ("render.stop.seconds", "10", &["0", "-1", "nan", "inf"]),
    ("render.stop.passes", "1", &["0", "-1", "0.5"]),
    ("render.shadow_samples", "2", &["0", "-1", "70000"]),
    (
        "render.ambient_occlusion.samples",
        "2",
        &["0", "-1", "70000"],
    ),
    (
        "render.ambient_occlusion.radius",
        "0.1",
        &["0", "-1", "nan", "inf"],
    ),
    (
        "camera.eye",
        "[0, -6, 2.5]",
        &["[nan, 0, 0]", "[0, inf, 0]", "[0, 0]", "[1e200, 0, 0]"],
    ),
    (
        "camera.target",
        "[0, 1, 0]",
        &["[nan, 0, 0]", "[0, 0]", "[1e200, 0, 0]"],
    ),
    ("camera.up", "[0, 0, 2]", &["[0, 0, 0]", "[nan, 0, 1]"]),
    ("camera.vertical_fov", "30", &["0", "180", "-5", "nan"]),
    ("camera.aperture_radius", "0.1", &["-1", "nan", "inf"]),
    ("camera.focus_distance", "inf", &["0", "-1", "nan"]),
    (
        "background.radiance",
        "[1, 1, 1]",
        &["[1e39, 0, 0]", "[-1, 0, 0]", "[nan, 0, 0]"],
    ),
    (
        "lights.0.center",
        "[0, 0, 5]",
        &["[nan, 0, 0]", "[0, inf, 0]", "[0, 0]"],
    ),
    (
        "lights.0.normal",
        "[0, 0, -1]",
        &["[0, 0, 0]", "[nan, 0, 1]"],
    ),
    ("lights.0.radius", "0.5", &["0", "-1", "nan", "inf"]),
    (
        "lights.0.radiance",
        "[1, 2, 3]",
        &["[-1, 0, 0]", "[nan, 0, 0]", "[inf, 0, 0]", "[1e300, 0, 0]"],
    ),
    (
        "lights.1.position",
        "[0, 1, 5]",
        &["[nan, 0, 0]", "[0, inf, 0]", "[0, 0]"],
    ),
    (
        "lights.1.intensity",
        "[1, 2, 3]",
        &["[-1, 0, 0]", "[nan, 0, 0]", "[inf, 0, 0]", "[1e300, 0, 0]"],
    ),
    (
        "materials.fleece.diffuse",
        "[0.5, 0.5, 0.5]",
        &["[-1, 0, 0]", "[nan, 0, 0]", "[0, 0]", "[1e300, 0, 0]"],
    ),
    (
        "materials.fleece.specular",
        "[0.5, 0.5, 0.5]",
        &["[-1, 0, 0]", "[inf, 0, 0]", "[1e300, 0, 0]"],
    ),
    (
        "materials.fleece.shininess",
        "1e7",
        &["-1", "nan", "inf", "1e300"],
    ),
    (
        "materials.hide.reflectance",
        "[0.9, 0.9, 0.9]",
        &["[-1, 0, 0]", "[nan, 0, 0]", "[1e300, 0, 0]"],
    ),
    (
        "materials.stone.ior",
        "1.3",
        &["0", "-1", "nan", "inf", "1e300"],
    ),
    (
        "materials.stone.attenuation",
        "[0.1, 0, 0]",
        &["[-1, 0, 0]", "[nan, 0, 0]", "[inf, 0, 0]", "[1e300, 0, 0]"],
    ),
    (
        "materials.earth.radiance",
        "[1, 1, 1]",
        &["[-1, 0, 0]", "[nan, 0, 0]", "[1e300, 0, 0]"],
    ),
    ("objects.1.scale", "2", &["0", "nan", "inf"]),
    (
        "objects.1.rotate",
        "[10, 20, 30]",
        &["[nan, 0, 0]", "[0, inf, 0]", "[0, 0]"],
    ),
    (
        "objects.1.translate",
        "[1, 2, 3]",
        &["[nan, 0, 0]", "[0, inf, 0]", "[0, 0]"],
    ),
    ("objects.1.crease_angle", "30", &["-1", "181", "nan"]),
    (
        "objects.1.copies.count",
        "[2, 1, 1]",
        &["[0, 1, 1]", "[-1, 1, 1]", "[1, 1]"],
    ),
    (
        "objects.1.copies.step",
        "[3, 0, 0]",
        &["[nan, 0, 0]", "[0, 0]"],
    ),
    ("objects.1.material", "hide", &["nobody"]),
    ("display.exposure", "1", &["nan", "inf", "200"]),
    ("display.gamma", "2", &["0", "nan", "11"]),
    ("output.png_bits", "16", &["12", "-8"]),
];

fn impossible_settings(_: Effort) -> f64 {
    let mut demo = io::demo_scene();
    let meshes = demo.meshes.values_mut();
    meshes.for_each(|mesh| *mesh = Arc::new(shapes::icosphere(1)));
    let changes: Vec<_> = EVERY_KIND.iter().map(|&change| change.to_owned()).collect();
    let every_kind = scene_file::apply_overrides(&demo, &changes);
    let every_kind = every_kind.unwrap_or_else(|error| panic!("the demo has these: {error}"));
    let is_taken = |key: &str, value: &str| {
        let changes = [format!("{key}={value}")];
        let Ok(scene) = scene_file::apply_overrides(&every_kind, &changes) else {
            return false;
        };
        // Some numbers are only impossible together with the size of the scene.
        PreparedScene::prepare(&scene, None, &CancelToken::new()).is_ok()
    };
    let wrong = KEYS.iter().map(|(key, possible, impossible)| {
        let taken = impossible.iter().filter(|value| is_taken(key, value));
        taken.count() + usize::from(!is_taken(key, possible))
    });
    wrong.sum::<usize>() as f64
}

fn damaged_meshes(effort: Effort) -> f64 {
    let whole = MeshFormat::ALL.map(|format| {
        let mut bytes = Vec::new();
        let written = format.write(&shapes::icosphere(1), &mut bytes);
        written.expect("a vector takes all");
        (format, bytes)
    });
    let mut random = Random::new(31);
    let mut wrong = 0;
    for (format, whole) in whole.iter().cycle().take(effort.pick(2_000, 100_000)) {
        let mut bytes = whole.clone();
        for _ in 0..=random.bits() % 4 {
            let place = usize::try_from(random.bits() % bytes.len() as u64).expect("a small file");
            match random.bits() % 5 {
                0 => bytes[place] = random.bits().to_le_bytes()[0],
                1 => bytes.truncate(place + 1),
                2 => drop(bytes.drain(place..(place + 9).min(bytes.len() - 1).max(place))),
                3 => bytes.splice(place..place, *b" 1e999 -7 ").for_each(drop),
                _ => {
                    let [letter, ..] = random.bits().to_le_bytes();
                    bytes[place] = b"0123456789.-e \n"[usize::from(letter % 15)];
                }
            }
        }
        let Ok(Some(file)) = format.parse(&bytes, &CancelToken::new(), &Progress::new()) else {
            continue;
        };
        let mesh = &file.mesh;
        let count = mesh.positions.len();
        let in_range = mesh
            .triangles
            .iter()
            .flatten()
            .all(|&vertex| (vertex as usize) < count);
        let finite = mesh.positions.iter().all(|position| position.is_finite());
        wrong += u32::from(!(in_range && finite));
    }
    f64::from(wrong)
}
