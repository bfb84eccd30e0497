//! The built program as a user calls it: pictures, stats, facts, exit codes and messages.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use raymini::io::read_image;
use raymini::render::Image;
use serde_json::Value;
use tempfile::TempDir;

/// A folder with a small scene: a tetrahedron over a floor under two lights.
pub fn folder() -> TempDir {
    let folder = TempDir::new().expect("a folder");
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("is written");
    };
    write(
        "tetra.off",
        "OFF 4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n",
    );
    write(
        "floor.off",
        "OFF\n4 1 0\n-3 -3 0\n3 -3 0\n3 3 0\n-3 3 0\n4 0 1 2 3\n",
    );
    write(
        "scene.toml",
        r#"
[camera]
eye = [2, -4, 2]
[[objects]]
mesh = "tetra.off"
[[objects]]
mesh = "floor.off"
[[lights]]
position = [3, -3, 6]
intensity = [40, 40, 40]
[[lights]]
position = [-3, -3, 3]
intensity = [10, 10, 10]
[render]
width = 64
height = 48
shadows = "hard"
"#,
    );
    folder
}

pub fn raymini(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_raymini"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("starts")
}

/// Runs the program where it must succeed; what it printed.
pub fn succeed(folder: &Path, arguments: &[&str]) -> String {
    let output = raymini(folder, arguments);
    assert!(
        output.status.success(),
        "{arguments:?}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).expect("is text")
}

/// Runs the program where it must fail with `code`; its complaint.
pub fn fail(folder: &Path, code: i32, arguments: &[&str]) -> String {
    let output = raymini(folder, arguments);
    assert_eq!(
        output.status.code(),
        Some(code),
        "{arguments:?}: {}",
        String::from_utf8_lossy(&output.stdout)
    );
    String::from_utf8(output.stderr).expect("is text")
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).expect("exists")).expect("is JSON")
}

pub fn facts(folder: &Path, file: &str) -> Value {
    serde_json::from_str(&succeed(folder, &["info", file, "--json"])).expect("is JSON")
}

/// Renders with stats; the hash.
fn hash(folder: &Path, arguments: &[&str]) -> String {
    let mut all = vec![
        "render",
        "scene.toml",
        "-o",
        "out.png",
        "--stats",
        "stats.json",
    ];
    all.extend(arguments);
    succeed(folder, &all);
    json(&folder.join("stats.json"))["image_hash"]
        .as_str()
        .expect("a hash")
        .to_owned()
}

#[test]
fn render_writes_a_picture_and_says_what_it_took() {
    let folder = folder();
    let text = succeed(
        folder.path(),
        &[
            "render",
            "scene.toml",
            "-o",
            "out.png",
            "--stats",
            "stats.json",
        ],
    );
    assert!(
        text.starts_with("out.png: 64×48 pixels, 16 samples, "),
        "{text}"
    );

    let stats = json(&folder.path().join("stats.json"));
    assert_eq!(stats["triangles"], 6);
    assert_eq!(stats["samples_per_pixel"], 16);
    assert_eq!(stats["rays"]["camera"], 64 * 48 * 16);
    assert!(stats["rays"]["shadow"].as_u64().expect("a count") > 0);
    assert_eq!(stats["rays"]["bounce"], 0);
    assert_eq!(stats["non_finite_samples"], 0);
    for key in [
        "load_seconds",
        "build_seconds",
        "render_seconds",
        "first_tile_seconds",
    ] {
        assert!(stats[key].as_f64().expect("a time") >= 0.0, "{key}");
    }

    let picture = facts(folder.path(), "out.png");
    assert_eq!(
        (&picture["width"], &picture["height"]),
        (&64.into(), &48.into())
    );
    assert_eq!(picture["image_hash"], stats["image_hash"]);
    let pixels = image::open(folder.path().join("out.png"))
        .expect("is a picture")
        .into_rgb8();
    assert!(
        pixels.pixels().any(|pixel| pixel.0[0] > 100),
        "something is lit"
    );
}

#[test]
fn exr_holds_the_same_radiance() {
    let folder = folder();
    let expected = hash(folder.path(), &[]);
    succeed(folder.path(), &["render", "scene.toml", "-o", "out.exr"]);
    assert_eq!(
        facts(folder.path(), "out.exr")["image_hash"],
        expected.as_str()
    );
}

#[test]
fn threads_and_structures_give_the_same_hash_and_seeds_another() {
    let folder = folder();
    let expected = hash(folder.path(), &[]);
    for arguments in [
        ["--threads", "1"],
        ["--threads", "7"],
        ["--set", "render.accelerator=brute-force"],
    ] {
        assert_eq!(hash(folder.path(), &arguments), expected, "{arguments:?}");
    }
    assert_ne!(hash(folder.path(), &["--seed", "1"]), expected);
    assert_ne!(
        hash(folder.path(), &["--set", "lights.0.intensity=[1,2,3]"]),
        expected
    );
}

#[test]
fn flags_change_size_samples_mode_and_region() {
    let folder = folder();
    hash(
        folder.path(),
        &["--size", "31x17", "--spp", "2", "--mode", "normals"],
    );
    let picture = facts(folder.path(), "out.png");
    assert_eq!(
        (&picture["width"], &picture["height"]),
        (&31.into(), &17.into())
    );
    hash(folder.path(), &["--region", "10,20,30,5"]);
    let picture = facts(folder.path(), "out.png");
    assert_eq!(
        (&picture["width"], &picture["height"]),
        (&30.into(), &5.into())
    );
    assert_eq!(
        (&picture["region"]["x"], &picture["region"]["y"]),
        (&10.into(), &20.into())
    );
    hash(folder.path(), &["--set", "output.png_bits=16"]);
    let picture = image::open(folder.path().join("out.png")).expect("is a picture");
    assert_eq!(picture.color(), image::ColorType::Rgb16);
}

/// The same picture, not one of all that its scene says, which would take the place of the part.
#[test]
fn the_picture_of_a_region_is_rendered_again_as_the_part_it_is() {
    let folder = folder();
    let path = folder.path();
    let hash_of = |file: &str| facts(path, file)["image_hash"].clone();
    for part in ["part.exr", "part.png"] {
        succeed(
            path,
            &["render", "scene.toml", "-o", part, "--region", "10,20,30,5"],
        );
        let before = facts(path, part);
        succeed(path, &["render", part, "-o", "again.exr"]);
        assert_eq!(hash_of("again.exr"), before["image_hash"]);
        let run = raymini(path, &["render", part, "-o", part]);
        let said = String::from_utf8(run.stderr).expect("is text");
        let expected = format!(
            "{part}: rendering the part 10,20,30,5 again; --region 0,0,64,48 renders all\n"
        );
        assert_eq!(said, expected);
        let after = facts(path, part);
        for key in ["image_hash", "region", "width", "height"] {
            assert_eq!(after[key], before[key], "{part} {key}");
        }

        let other_size = ["render", part, "-o", "other.png", "--size", "32x24"];
        let said = fail(path, 1, &other_size);
        assert!(
            said.contains("this is the part 10,20,30,5 of a 64×48 picture"),
            "{said}"
        );
        succeed(
            path,
            &[&other_size[..], &["--region", "0,0,32,24"]].concat(),
        );
        assert_eq!(facts(path, "other.png")["width"], 32);
        succeed(
            path,
            &["render", part, "-o", "all.exr", "--region", "0,0,64,48"],
        );
        succeed(path, &["render", "scene.toml", "-o", "whole.exr"]);
        assert_eq!(hash_of("all.exr"), hash_of("whole.exr"));
    }
}

#[test]
fn a_bare_mesh_is_framed_and_lit() {
    let folder = folder();
    let render = |mode: &str| {
        let arguments = [
            "render",
            "tetra.off",
            "-o",
            "out.png",
            "--size",
            "64x64",
            "--mode",
            mode,
        ];
        succeed(folder.path(), &arguments);
        image::open(folder.path().join("out.png"))
            .expect("is a picture")
            .into_rgb8()
    };
    let objects = render("object");
    let on_mesh = |x: u32, y: u32| objects.get_pixel(x, y).0 != [0; 3];
    let count = objects
        .enumerate_pixels()
        .filter(|&(x, y, _)| on_mesh(x, y))
        .count();
    assert!(
        (600..2500).contains(&count),
        "{count} of 4096 pixels show the mesh"
    );
    let rim = (0..64).flat_map(|i| [(i, 0), (i, 63), (0, i), (63, i)]);
    assert_eq!(
        rim.filter(|&(x, y)| on_mesh(x, y)).count(),
        0,
        "nothing is cut off"
    );
    let picture = render("direct");
    let lit = picture
        .enumerate_pixels()
        .filter(|&(x, y, pixel)| on_mesh(x, y) && pixel.0[0] > 60);
    assert!(lit.count() * 2 > count, "most of the mesh is lit");
}

#[test]
fn info_says_what_a_mesh_and_a_scene_hold() {
    let folder = folder();
    let mesh = facts(folder.path(), "tetra.off");
    assert_eq!(mesh["format"], "OFF");
    assert_eq!(
        (&mesh["vertices"], &mesh["triangles"]),
        (&4.into(), &4.into())
    );
    assert_eq!(mesh["bounds"]["max"], serde_json::json!([1.0, 1.0, 1.0]));
    assert_eq!(mesh["dropped"]["degenerate"], 0);
    let scene = facts(folder.path(), "scene.toml");
    assert_eq!(
        (&scene["triangles"], &scene["lights"]),
        (&6.into(), &2.into())
    );
    let text = succeed(folder.path(), &["info", "tetra.off"]);
    assert!(text.contains("triangles   4\n"), "{text}");
}

#[test]
fn mistakes_are_told_with_file_and_line_and_exit_code_1() {
    let folder = folder();
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("is written");
    };
    write("key.toml", "[render]\nwidht = 3\n");
    write("mesh.toml", "\n[[objects]]\nmesh = \"none.off\"\n");
    write("sky.toml", "\n[background]\nimage = \"none.exr\"\n");
    write(
        "paint.toml",
        "[materials.clay]\nkind = \"phong\"\ndiffuse_image = \"none.png\"\n",
    );
    write(
        "tiny.toml",
        "[[objects]]\nmesh = \"tetra.off\"\nscale = 1e-30\n[[lights]]\nposition = [0, 0, 3]\nintensity = [1, 1, 1]\n",
    );
    // The box of the mesh is a cube of side 1, which is √3 across.
    let beside =
        "tiny.toml: lights.0 is too large a number beside objects 1.73e-30 across; expected ";
    write("broken.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n");
    write("broken.toml", "[[objects]]\nmesh = \"broken.off\"\n");
    let cases: [(&[&str], &str); 15] = [
        (&["render", "tiny.toml", "-o", "x.png"], beside),
        (&["check", "tiny.toml"], beside),
        (&["plan", "tiny.toml"], beside),
        (
            &[
                "render",
                "--set",
                "render.width=abc",
                "-o",
                "x.png",
                "--size",
                "8x8",
            ],
            "--set render.width=abc: `render.width` is \"abc\"; expected ",
        ),
        (
            &["render", "key.toml", "-o", "x.png"],
            "key.toml:2:1: unknown key `widht`; the nearest known one is `width`",
        ),
        (&["render", "mesh.toml", "-o", "x.png"], "mesh.toml:3:8: "),
        (&["render", "sky.toml", "-o", "x.png"], "sky.toml:3:9: "),
        (
            &["render", "paint.toml", "-o", "x.png"],
            "paint.toml:3:17: ",
        ),
        (&["render", "broken.off", "-o", "x.png"], "broken.off:6: "),
        (&["render", "broken.toml", "-o", "x.png"], "broken.off:6: "),
        (
            &["render", "none.toml", "-o", "x.png"],
            "none.toml: there is no such file",
        ),
        (
            &["render", "scene.toml", "-o", "x.jpg"],
            "x.jpg: pictures are written as .png or .exr",
        ),
        (
            &["render", "scene.toml", "-o", "no/x.png", "--spp", "1"],
            "no/x.png: cannot write the picture",
        ),
        (
            &[
                "render",
                "scene.toml",
                "-o",
                "x.png",
                "--region",
                "60,0,10,10",
            ],
            "does not lie in the 64×48 picture",
        ),
        (&["info", "none.off"], "none.off"),
    ];
    for (arguments, expected) in cases {
        let complaint = fail(folder.path(), 1, arguments);
        assert!(
            complaint.starts_with("error: ") && complaint.contains(expected),
            "{arguments:?}: {complaint}"
        );
        assert!(!folder.path().join("x.png").exists());
    }
}

#[test]
fn wrong_usage_is_exit_code_2() {
    let folder = folder();
    let cases: [(&[&str], &str); 5] = [
        (&["render", "scene.toml"], "--output"),
        (
            &["render", "scene.toml", "-o", "x.png", "--size", "0x4"],
            "640x480",
        ),
        (
            &["render", "scene.toml", "-o", "x.png", "--mode", "drect"],
            "direct",
        ),
        (
            &["render", "scene.toml", "-o", "x.png", "--threads", "0"],
            "--threads",
        ),
        (
            &["render", "scene.toml", "-o", "x.png", "--bogus"],
            "--bogus",
        ),
    ];
    for (arguments, expected) in cases {
        let complaint = fail(folder.path(), 2, arguments);
        assert!(complaint.contains(expected), "{arguments:?}: {complaint}");
    }
}

/// Whoever types a number wrong is told which one is right, in the words of this program.
#[test]
fn wrong_values_are_answered_by_what_was_expected() {
    let folder = folder();
    let samples = "expected a whole number from 1 to 16777216";
    let threads = "expected a whole number from 1 to 1024";
    let pairs = "expected a whole number from 6 to 1000";
    let name = "one that begins with a dash is given as ./-";
    let cases = [
        ("render -o x.png", "--spp abc", samples),
        ("render -o x.png", "--spp -3", samples),
        ("render -o x.png", "--spp 0", samples),
        (
            "render -o x.png",
            "--seed 1.5",
            "from 0 to 9223372036854775807",
        ),
        ("render -o x.png", "--threads many", threads),
        ("render -o x.png", "--costs=5", pairs),
        ("render -o x.png", "--size -8x8", "such as 640x480"),
        ("render -o x.png", "--stats -s.json", name),
        ("render", "-o -x.png", name),
        ("render", "--output --spp", name),
        ("render --pixel 1,1", "--sample -1", "from 0 to 16777215"),
        (
            "render",
            "--pixel -1,3",
            "expected column and row of a pixel, such as 320,240",
        ),
        ("render -o x.png", "--checkpoint -c", name),
        (
            "render -o x.png --checkpoint c",
            "--checkpoint-every -1",
            "expected a number of seconds",
        ),
        ("plan", "--spp 1e3", samples),
        ("plan", "--measure=x", pairs),
        (
            "plan --contributions d",
            "--contribution-side 0",
            "from 1 to 65536",
        ),
        ("report -o d", "--spp 15", "from 16 to 16777216"),
        ("report -o d", "--seeds -1", "from 1 to 1000"),
        ("report -o d", "--threads -1", threads),
        (
            "report -o d",
            "--exact -1,0,0",
            "expected red, green, blue, each at least 0",
        ),
        ("report -o d", "--reference-samples 0", samples),
        ("report", "-o -d", name),
        ("report -o d", "--reference -r.exr", name),
        ("plan", "--contributions -d", name),
        ("bench", "--repeats 2.5", "from 1 to 1000"),
        ("bench", "--threads 2000", threads),
        ("bench", "--rays -a.npy", name),
        ("bench", "--write -d", name),
        ("compare a.png b.png", "-o -d.png", name),
        (
            "convert a.off b.off",
            "--scale -1",
            "expected a number above 0",
        ),
    ];
    for (command, option, expected) in cases {
        let arguments: Vec<_> = command.split(' ').chain(option.split(' ')).collect();
        let complaint = fail(folder.path(), 2, &arguments);
        let found = complaint.contains(expected) && complaint.starts_with("error: invalid value");
        assert!(found, "{arguments:?}: {complaint}");
    }
}

#[test]
fn a_picture_that_is_certainly_black_is_warned_of() {
    let folder = folder();
    let nothing =
        "warning: the picture is black: no light and no object shines, and the background is black";
    let unlit = "[[objects]]\nmesh = \"tetra.off\"\n";
    let lamp = "[[lights]]\nposition = [3, -3, 3]\n";
    let disk = "[[lights]]\nkind = \"disk\"\ncenter = [0, 0, 4]\n";
    let sky = "[background]\nradiance = [0, 0, 1e-3]\n";
    let path = "[render]\nmode = \"path\"\n";
    let no_bounce = "[render]\nmax_bounces = 0\n";
    let cases = [
        (unlit.to_owned(), Some(nothing)),
        (format!("{unlit}{path}"), Some(nothing)),
        (
            format!("{unlit}{lamp}intensity = [0, 0, 0]\n"),
            Some(nothing),
        ),
        (
            format!("{unlit}{lamp}{no_bounce}"),
            Some(
                "warning: the picture is black: render.max_bounces is 0, and rays meet nothing that shines",
            ),
        ),
        (
            lamp.to_owned(),
            Some(
                "warning: the picture is black: nothing scatters light, and rays meet nothing that shines",
            ),
        ),
        (format!("{unlit}{lamp}"), None),
        (format!("{unlit}{disk}{no_bounce}"), None),
        (
            format!("{unlit}{disk}visible = false\n{no_bounce}"),
            Some("render.max_bounces is 0"),
        ),
        (format!("{unlit}{sky}"), None),
        (format!("{unlit}[render]\nmode = \"normals\"\n"), None),
        (
            format!("{unlit}material = \"lamp\"\n[materials.lamp]\nkind = \"emitter\"\n"),
            None,
        ),
    ];
    for (scene, expected) in cases {
        std::fs::write(folder.path().join("dark.toml"), &scene).expect("is written");
        for command in [
            &["render", "dark.toml", "-o", "dark.exr"][..],
            &["plan", "dark.toml"],
        ] {
            let small = ["--size", "8x8", "--spp", "1"];
            let output = raymini(folder.path(), &[command, &small].concat());
            assert!(output.status.success(), "{scene}");
            let complaint = String::from_utf8_lossy(&output.stderr);
            match expected {
                Some(expected) => assert!(complaint.contains(expected), "{scene}: {complaint}"),
                None => assert!(!complaint.contains("black"), "{scene}: {complaint}"),
            }
        }
        let picture = read_image(&folder.path().join("dark.exr")).expect("is right");
        if expected.is_some() {
            assert_eq!(picture.image, Image::black(8, 8), "{scene}");
        }
    }
}

#[test]
fn a_step_between_no_copies_is_warned_of() {
    let folder = folder();
    let scene = |copies: &str| {
        let text = format!("[[objects]]\nmesh = \"tetra.off\"\ncopies = {{ {copies} }}\n");
        std::fs::write(folder.path().join("copies.toml"), text).expect("is written");
        succeed(folder.path(), &["info", "copies.toml"])
    };
    let warning = "copies.step of object \"tetra\" moves nothing";
    assert!(scene("step = [1, 0, 0]").contains(warning));
    for right in ["count = [2, 1, 1], step = [1, 0, 0]", "count = [1, 1, 1]"] {
        assert!(!scene(right).contains("moves nothing"), "{right}");
    }
}

#[test]
fn a_failed_write_leaves_no_temporary_file() {
    let folder = folder();
    let target = folder.path().join("folder.png");
    std::fs::create_dir(&target).expect("a folder");
    fail(
        folder.path(),
        1,
        &["render", "scene.toml", "-o", "folder.png", "--spp", "1"],
    );
    let left: Vec<PathBuf> = std::fs::read_dir(folder.path())
        .expect("can be listed")
        .map(|entry| entry.expect("is there").path())
        .collect();
    assert_eq!(left.len(), 4, "no temporary file is left: {left:?}");
}

/// Numbers by name, under a structure's key.
fn by_set<'a>(structure: &'a Value, key: &str) -> &'a serde_json::Map<String, Value> {
    structure[key]
        .as_object()
        .unwrap_or_else(|| panic!("{key}: {structure}"))
}

#[test]
fn bench_measures_every_structure_on_the_same_rays() {
    let folder = folder();
    let bench = |more: &[&str]| -> Value {
        let mut arguments = vec!["bench", "scene.toml", "--json", "--repeats", "1"];
        arguments.extend(more);
        serde_json::from_str(&succeed(folder.path(), &arguments)).expect("is JSON")
    };
    let facts = bench(&["--write", "rays", "--threads", "2"]);
    assert_eq!(facts["triangles"], 6);
    assert_eq!(
        (&facts["threads"], &facts["repeats"]),
        (&2.into(), &1.into())
    );
    assert_eq!(facts["version"], env!("CARGO_PKG_VERSION"));
    let sets = ["camera", "shadow", "ambient_occlusion", "bounce"];
    let rays = facts["rays"].as_array().expect("a list");
    assert!(rays.iter().map(|set| &set["name"]).eq(&sets));
    let (camera, hits) = (&rays[0], rays[0]["hits"].as_u64().expect("a count"));
    assert!(hits > 500 && hits <= camera["rays"].as_u64().expect("a count"));
    assert!(rays[1..].iter().all(|set| set["rays"] == hits));

    let structures = facts["structures"].as_array().expect("a list");
    let names = ["wide", "wide-fast", "kd-tree", "brute-force"];
    assert!(
        structures
            .iter()
            .map(|structure| &structure["name"])
            .eq(&names)
    );
    for structure in structures {
        for key in [
            "build_seconds",
            "build_seconds_one_thread",
            "bytes_per_triangle",
            "references_per_triangle",
            "sah_cost",
        ] {
            assert!(structure[key].as_f64().expect(key) >= 0.0, "{key}");
        }
        assert!(structure["references_per_triangle"].as_f64() >= Some(1.0));
        for key in [
            "mrays_per_second",
            "mrays_per_second_all_threads",
            "blocks_per_ray",
            "nodes_per_ray",
        ] {
            let values = by_set(structure, key);
            assert!(sets.iter().all(|set| values[*set].is_f64()), "{values:?}");
        }
        let packets = by_set(structure, "mrays_per_second_packets");
        assert!(packets["camera"].is_f64() && packets["shadow"].is_null());
        for key in ["mrays_per_second", "mrays_per_second_all_threads"] {
            let ranges = by_set(structure, &format!("{key}_range"));
            for (set, value) in by_set(structure, key) {
                let range = &ranges[set];
                assert!(
                    range["min"].as_f64() <= value.as_f64()
                        && value.as_f64() <= range["max"].as_f64()
                );
            }
        }
    }

    // The written rays are the generated ones, bit for bit.
    let files = ["camera", "lights_shadow", "occlusion_shadow", "bounce"];
    let paths = files.map(|name| format!("rays/{name}.npy"));
    let again = paths.iter().flat_map(|path| ["--rays", path]);
    let again = bench(&again.chain(["--structure", "kd-tree"]).collect::<Vec<_>>());
    for (index, set) in again["rays"].as_array().expect("a list").iter().enumerate() {
        assert_eq!(set["name"], files[index]);
        for key in ["rays", "hits", "any_hit"] {
            assert_eq!(set[key], rays[index][key], "{}: {key}", files[index]);
        }
    }
    let structures = again["structures"].as_array().expect("a list");
    assert_eq!(structures.len(), 1);
    let kept = by_set(&structures[0], "mrays_per_second");
    assert!(kept.keys().all(|key| files.contains(&&**key)) && kept.len() == 4);

    let mesh = std::fs::read(folder.path().join("rays/mesh.ply")).expect("is written");
    assert!(mesh.starts_with(b"ply\nformat binary_little_endian 1.0\nelement vertex 8\n"));
    assert_eq!(
        std::fs::read_dir(folder.path().join("rays"))
            .expect("a folder")
            .count(),
        5
    );
}

#[test]
fn bench_prints_tables_for_people() {
    let folder = folder();
    let text = succeed(
        folder.path(),
        &["bench", "tetra.off", "--size", "40x30", "--repeats", "1"],
    );
    for expected in [
        "tetra.off: 4 triangles",
        "brute-force",
        "refs/tri",
        "ambient_occlusion",
        "Mrays/s, one thread",
    ] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
}

#[test]
fn bench_refuses_what_it_cannot_measure() {
    let folder = folder();
    let write = |name: &str, bytes: &[u8]| {
        std::fs::write(folder.path().join(name), bytes).expect("is written");
    };
    write("other.npy", b"PK");
    write("empty.toml", b"");
    write(
        "away.toml",
        b"[camera]\neye = [0, -9, 0]\ntarget = [0, -99, 0]\n[[objects]]\nmesh = \"tetra.off\"\n",
    );
    let cases: [(&[&str], i32, &str); 8] = [
        (
            &["scene.toml", "--rays", "other.npy"],
            1,
            "other.npy: byte 0: expected an array of NumPy",
        ),
        (
            &["scene.toml", "--rays", "no.npy"],
            1,
            "no.npy: there is no such file",
        ),
        (&["empty.toml"], 1, "no triangles"),
        (
            &["scene.toml", "--set", "objects.0.scale=0"],
            1,
            "--set objects.0.scale=0: `objects.0.scale` is 0; expected",
        ),
        (&["away.toml"], 1, "no ray of the picture"),
        (&["scene.toml", "--structure", "octree"], 2, "kd-tree"),
        (&["scene.toml", "--repeats", "0"], 2, "--repeats"),
        (
            &["scene.toml", "--rays", "a.npy", "--write", "b"],
            2,
            "--write",
        ),
    ];
    for (arguments, code, expected) in cases {
        let complaint = fail(folder.path(), code, &[&["bench"], arguments].concat());
        assert!(complaint.contains(expected), "{arguments:?}: {complaint}");
    }
}

#[test]
fn a_plan_says_what_is_left_out_and_why_and_what_it_costs() {
    let folder = folder();
    let text = succeed(folder.path(), &["plan", "scene.toml", "--spp", "1"]);
    for line in [
        "mode direct, 64×48 pixels, 1 sample per pixel",
        "left out   points within a pixel       one sample per pixel takes the middle",
        "left out   points on lights            render.shadows is hard",
        "needed     shadow rays",
        "random numbers of a sample: none",
        "render time: about ",
    ] {
        assert!(text.contains(line), "{line}\n{text}");
    }

    let measure = [
        "plan",
        "--measure=6",
        "scene.toml",
        "--size",
        "80x60",
        "--json",
    ];
    let facts: Value = serde_json::from_str(&succeed(folder.path(), &measure)).expect("is JSON");
    assert_eq!(
        (&facts["width"], &facts["height"]),
        (&80.into(), &60.into())
    );
    let features = facts["features"].as_array().expect("a list");
    let [low, time, high] = ["low", "value", "high"].map(|key| {
        let time = facts["estimated_seconds"][key].as_f64();
        time.expect("a number")
    });
    assert!(0.0 < low && low < time && time < high, "{facts}");
    assert_eq!(facts["is_bound"], false);
    let by_name = |name: &str| {
        let feature = features.iter().find(|feature| feature["feature"] == name);
        feature.unwrap_or_else(|| panic!("{name}: {facts}"))
    };
    assert_eq!(by_name("shadow rays")["needed"], true);
    assert_eq!(
        by_name("light through glass")["reason"],
        "nothing is of glass"
    );
    // Every pixel that sees the floor or the tetrahedron sees light: at most one ray to each light, on average less.
    let shadow_rays = facts["per_sample"]["shadow_rays"]
        .as_f64()
        .expect("a number");
    assert!(shadow_rays > 0.2 && shadow_rays <= 2.0, "{shadow_rays}");
    assert_eq!(facts["per_sample"]["camera_rays"], 1.0);
    let has_shadows = |costs: &Value| {
        assert_eq!(costs["pairs"], 6);
        let effects = costs["effects"].as_array().expect("a list").iter();
        let shadows = effects.filter(|effect| effect["name"] == "shadows");
        let intervals = shadows.map(|effect| effect["interval"].as_array().map(Vec::len));
        assert_eq!(intervals.collect::<Vec<_>>(), [Some(2)], "{costs}");
    };
    has_shadows(&facts["costs"]);

    // After a render, the same for its stats file.
    let render = ["render", "scene.toml", "-o", "a.png", "--stats", "a.json"];
    let text = succeed(folder.path(), &[&render[..], &["--costs=6"]].concat());
    assert!(
        text.contains("what leaving out saves, medians of 6 pairs (95 %): it would add"),
        "{text}"
    );
    let stats = json(&folder.path().join("a.json"));
    assert_eq!(stats["plan"], facts["features"]);
    assert_eq!(stats["used"], facts["used"]);
    assert_eq!(facts["used"]["lights"], serde_json::json!([2, 2]));
    has_shadows(&stats["costs"]);
    succeed(folder.path(), &render);
    assert_eq!(json(&folder.path().join("a.json"))["costs"], Value::Null);
}

/// Two lights and nothing else that shines: together they bring the whole picture, and shadows take from it.
#[test]
fn what_lights_and_shadows_bring_is_written_as_pictures_and_figures() {
    let folder = folder();
    let path = folder.path();
    let text = succeed(
        path,
        &["plan", "scene.toml", "--contributions", "out", "--json"],
    );
    let facts: Value = serde_json::from_str(&text).expect("is JSON");
    let written = std::fs::read_to_string(path.join("out/contributions.json")).expect("is there");
    let written: Value = serde_json::from_str(&written).expect("is JSON");
    assert_eq!(facts["contributions"], written);
    assert_eq!(
        (&written["width"], &written["height"]),
        (&64.into(), &48.into())
    );
    let contributions = written["contributions"].as_array().expect("a list");
    let share = |name: &str| {
        let mut all = contributions.iter();
        let found = all.find(|contribution| contribution["name"] == name);
        found.expect("is listed")["mean_share"]
            .as_f64()
            .expect("a number")
    };
    let lights = share("light 1") + share("light 2");
    assert!((lights - 1.0).abs() < 1e-5, "{lights}");
    assert!(share("shadows") < 0.0);
    for contribution in contributions {
        for file in ["change", "radiance", "without"] {
            let name = contribution[file].as_str().expect("a name");
            assert!(path.join("out").join(name).is_file(), "{name}");
        }
    }
    assert!(path.join("out/whole.png").is_file());
    let complaint = fail(path, 1, &["plan", "--contributions", "scene.toml"]);
    assert!(
        complaint.contains("scene.toml: cannot make the folder"),
        "{complaint}"
    );
}

/// Not even a warning that nobody can read ends a render.
#[test]
#[cfg(target_os = "linux")]
fn warnings_that_cannot_be_written_stop_nothing() {
    let folder = folder();
    let full = std::fs::File::options().write(true).open("/dev/full");
    let status = Command::new(env!("CARGO_BIN_EXE_raymini"))
        .current_dir(folder.path())
        .args([
            "render",
            "scene.toml",
            "-o",
            "out.png",
            "--spp",
            "1",
            "--noise",
            "1e-9",
        ])
        .stdout(std::process::Stdio::null())
        .stderr(full.expect("every Linux has it"))
        .status();
    assert!(status.expect("starts").success());
    assert!(folder.path().join("out.png").is_file());
}

/// Numbers mean what they say however they are written, and complaints name what was typed.
#[test]
fn numbers_of_options_are_numbers() {
    let folder = folder();
    let render = ["render", "scene.toml", "-o", "out.png", "--spp", "1"];
    succeed(
        folder.path(),
        &[&render[..], &["--seconds", "1e20"]].concat(),
    );
    for (option, number) in [("--noise", "nan"), ("--seconds", "inf"), ("--noise", "0")] {
        let complaint = fail(folder.path(), 2, &[&render[..], &[option, number]].concat());
        assert!(complaint.contains(option) && complaint.contains("expected a number above 0"));
    }
}

/// A picture that has no sample of most pixels when the time is up takes the place of none.
#[test]
fn what_the_clock_leaves_unfinished_is_called_so() {
    let folder = folder();
    let render = "render scene.toml -o out.png --size 1000x750 --mode ao --seconds 0.3 --stats stats.json \
                  --set render.ambient_occlusion.samples=4000";
    let arguments: Vec<&str> = render.split_whitespace().collect();
    let complaint = fail(folder.path(), 1, &arguments);
    assert!(complaint.contains("the time was up"), "{complaint}");
    assert!(!folder.path().join("out.png").exists());
    assert!(folder.path().join("out.unfinished.png").is_file());
    let stats = json(&folder.path().join("stats.json"));
    assert_eq!(stats["ending"], "time");
    assert_eq!(stats["is_cut_short"], true);
}

/// What a scene is read from is not written over.
#[test]
fn no_input_is_written_over() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    // A mesh by a name that figures may have.
    std::fs::rename(path("tetra.off"), path("tetra.json")).expect("is renamed");
    let text = std::fs::read_to_string(path("scene.toml")).expect("exists");
    let text = text.replace("tetra.off", "tetra.json");
    std::fs::write(path("scene.toml"), text).expect("is written");
    let mut cases = vec!["tetra.json"];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("scene.toml", path("link.json")).expect("a link");
        cases.push("link.json");
    }
    for stats in cases {
        let before = std::fs::read(path(stats)).expect("exists");
        let render = ["render", "scene.toml", "-o", "out.png", "--stats", stats];
        let complaint = fail(folder.path(), 1, &render);
        assert!(
            complaint.contains("the scene is read from it"),
            "{complaint}"
        );
        let after = std::fs::read(path(stats)).expect("exists");
        assert_eq!(before, after);
    }
}

/// A slip of the hand must not turn a picture into figures.
#[test]
fn figures_and_checkpoints_take_the_place_of_nothing_else() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    for name in ["a.png", "b.EXR", "scene.toml", "tetra.off"] {
        std::fs::write(path(name), "precious").expect("is written");
        let render = ["render", "-o", "out.png", "--size", "8x8", "--stats", name];
        let expected = format!(
            "error: {name}: the figures of --stats are JSON: expected the extension .json\n"
        );
        assert_eq!(fail(folder.path(), 1, &render), expected);
        assert_eq!(std::fs::read(path(name)).expect("exists"), b"precious");
    }
    for name in ["new.png", "new.EXR"] {
        let render = [
            "render",
            "-o",
            "out.png",
            "--size",
            "8x8",
            "--checkpoint",
            name,
        ];
        let complaint = fail(folder.path(), 1, &render);
        let expected = format!(
            "error: {name}: a checkpoint is no picture: expected another extension, or none\n"
        );
        assert_eq!(complaint, expected);
        assert!(!path(name).exists());
    }
    for name in ["figures.JSON", "figures"] {
        succeed(
            folder.path(),
            &["render", "-o", "out.png", "--size", "8x8", "--stats", name],
        );
        assert_eq!(json(&path(name))["ending"], "samples");
    }
}

#[test]
#[cfg(unix)]
fn one_file_is_not_asked_to_be_two() {
    let folder = folder();
    let path = folder.path().join("a.png");
    std::fs::write(&path, "precious").expect("is written");
    std::os::unix::fs::symlink("a.png", folder.path().join("a.json")).expect("a link");
    let render = ["render", "scene.toml", "-o", "a.png", "--stats", "a.json"];
    let complaint = fail(folder.path(), 1, &render);
    assert!(complaint.contains("cannot hold both the picture and the figures"));
    assert_eq!(std::fs::read(&path).expect("exists"), b"precious");
}
