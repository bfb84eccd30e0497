//! `raymini report` as a user calls it: its four files, what is in them, exit codes and messages.

use std::f64::consts::PI;
use std::path::Path;
use std::process::{Command, Output};

use raymini::geometry::shapes;
use raymini::io::{off, read_image, write_image};
use raymini::render::Image;
use raymini::scene::{Display, Output as Storage};
use serde_json::{Value, json};
use tempfile::TempDir;

/// A folder with a tetrahedron under a light with a soft shadow, and a furnace: inside of a matt ball of radius 1 that reflects
/// half, with a point light of intensity π in its middle, every point has a radiance of 1. Roulette makes the noise.
fn folder() -> TempDir {
    let folder = TempDir::new().expect("a folder");
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("is written");
    };
    write(
        "tetra.off",
        "OFF 4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n",
    );
    write(
        "shadow.toml",
        r#"
[camera]
eye = [2, -4, 2]
[[objects]]
mesh = "tetra.off"
[[objects]]
mesh = "builtin:ground"
scale = 3
[[lights]]
kind = "disk"
center = [2, -2, 4]
target = [0, 0, 0]
radius = 1
radiance = [5, 5, 5]
[render]
width = 24
height = 16
samples_per_pixel = 8
"#,
    );
    let mut ball = Vec::new();
    off::write(&shapes::icosphere(4), &mut ball).expect("a vector takes all");
    write("ball.off", str::from_utf8(&ball).expect("text"));
    let furnace = format!(
        r#"
[camera]
eye = [0.3, 0.2, 0.1]
target = [1, 0, 0]
vertical_fov = 90
[materials.matt]
diffuse = [0.5, 0.5, 0.5]
[[objects]]
mesh = "ball.off"
material = "matt"
[[lights]]
position = [0, 0, 0]
intensity = [{PI}, {PI}, {PI}]
[render]
mode = "path"
width = 24
height = 16
samples_per_pixel = 32
max_bounces = 1000
seed = 5
"#
    );
    write("furnace.toml", &furnace);
    folder
}

fn report(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_raymini"))
        .current_dir(folder)
        .arg("report")
        .args(arguments)
        .output()
        .expect("starts")
}

/// Runs the program where it must succeed and write to `out`; the JSON it wrote there.
fn succeed(folder: &Path, arguments: &[&str]) -> Value {
    let output = report(folder, &[arguments, &["-o", "out"]].concat());
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {complaint}");
    serde_json::from_str(&text(folder, "report.json")).expect("is JSON")
}

fn text(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join("out").join(name)).expect("is written")
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is a number"))
}

#[test]
fn a_report_holds_every_point_of_every_seed_and_variant() {
    let folder = folder();
    let comparison = "render.filter=tent; render.samples_per_pixel=32";
    let facts = succeed(
        folder.path(),
        &["shadow.toml", "--seeds", "2", "--compare", comparison],
    );
    // From the scene's 8 samples up to the least that are enough.
    let samples: Vec<f64> = facts["points"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|point| number(&point["samples_per_pixel"]))
        .collect();
    assert_eq!(samples, [1.0, 2.0, 4.0, 8.0, 16.0]);
    let point = &facts["points"][4];
    for key in ["seconds", "cpu_seconds", "estimated_rmse", "true_rmse"] {
        let (value, range) = (number(&point[key]), &point[format!("{key}_range")]);
        assert!(value > 0.0, "{key}");
        assert!(
            (number(&range[0])..=number(&range[1])).contains(&value),
            "{key}: {range}"
        );
    }
    assert_eq!(facts["points"][1]["estimated_relmse"], Value::Null);
    assert!(number(&point["true_relmse"]) < number(&point["measured_relmse"]));
    assert!(number(&facts["slope"]) < 0.0 && number(&facts["noise_slope"]) < 0.0);
    assert!(number(&facts["build_seconds"]) > 0.0);
    for clock in ["wall", "cpu"] {
        assert!(number(&facts["efficiency"][clock]) > 0.0);
    }
    for noise in ["0.10", "0.03", "0.01"] {
        assert!(number(&facts["time_to"][noise]["seconds"]) > 0.0);
    }
    assert_eq!(facts["seeds"], json!([0, 1]));
    assert_eq!(facts["finished"], true);
    assert_eq!(facts["settings"]["samples_per_pixel"], 16);
    assert!(number(&facts["machine"]["threads"]) >= 1.0);
    for key in ["cpu", "os"] {
        let fact = facts["machine"][key].as_str().expect("a text");
        assert!(!fact.is_empty(), "{key}");
    }
    assert_eq!(facts["non_finite_samples"], 0);

    let reference = &facts["reference"];
    assert_eq!(reference["kind"], "rendered");
    assert_eq!(reference["samples_per_pixel"], 16 * 32);
    assert_eq!(reference["seed"], 2);
    assert_eq!(reference["light_sampling"], Value::Null);
    assert!(number(&reference["rmse"]) > 0.0);

    let variant = &facts["variants"][0];
    assert_eq!(variant["name"], comparison);
    assert_eq!(variant["settings"]["filter"], "tent");
    assert_eq!(variant["points"].as_array().expect("a list").len(), 6);

    let csv = text(folder.path(), "report.csv");
    assert_eq!(csv.lines().count(), 1 + 2 * (5 + 6));
    let columns = csv.lines().map(|line| line.split(',').count());
    assert!(columns.eq(std::iter::repeat_n(22, 23)), "{csv}");
    let svg = text(folder.path(), "report.svg");
    // Long names have several lines.
    let mut keys = comparison.split("; ");
    assert!(
        svg.starts_with("<svg") && keys.all(|key| svg.contains(key)),
        "{svg}"
    );
    let page = text(folder.path(), "report.md");
    assert!(page.contains("](report.svg)") && page.contains("estimated / true"));
    assert!(
        page.contains("(report.png)")
            && page
                .contains("\nraymini report shadow.toml --seeds 2 --compare 'render.filter=tent; ")
    );
    let small = read_image(&folder.path().join("out/report.png")).expect("is a picture");
    assert_eq!((small.image.width, small.image.height), (24, 16));
}

/// The ball's faces lie up to 0.4 % inside the sphere, less than the noise. Here the error falls fast at first and like that of
/// independent samples later; while it turns, estimates are too small, but the interval must hold the truth.
#[test]
fn estimates_agree_with_the_true_error_of_a_furnace() {
    let folder = folder();
    let exact = ["--seeds", "3", "--spp", "128", "--exact", "1,1,1"];
    let facts = succeed(folder.path(), &[&["furnace.toml"], &exact[..]].concat());
    assert_eq!(facts["seeds"], json!([5, 6, 7]));
    assert_eq!(facts["reference"]["kind"], "exact");
    assert_eq!(facts["reference"]["radiance"], json!([1.0, 1.0, 1.0]));
    for point in &facts["points"].as_array().expect("a list")[4..] {
        for error in ["rmse", "relmse"] {
            let found = number(&point[format!("true_{error}")]);
            assert_eq!(found, number(&point[format!("measured_{error}")]));
            let ratio = number(&point[format!("estimated_{error}")]) / found;
            let ratio = if error == "relmse" {
                ratio.sqrt()
            } else {
                ratio
            };
            let interval = &point[format!("estimated_{error}_interval")];
            let is_right = if number(&point["samples_per_pixel"]) < 128.0 {
                number(&interval[0]) <= found && found <= number(&interval[1])
            } else {
                (0.8..1.25).contains(&ratio)
            };
            assert!(is_right, "{error}: {ratio} at {point}");
        }
    }
}

#[test]
fn a_reference_comes_from_another_estimator_or_from_a_file() {
    let folder = folder();
    let few = ["furnace.toml", "--seeds", "1", "--spp", "16"];
    let rendered = succeed(
        folder.path(),
        &[&few[..], &["--reference-samples", "64"]].concat(),
    );
    assert_eq!(rendered["reference"]["light_sampling"], "nee");
    assert_eq!(rendered["reference"]["samples_per_pixel"], 64);

    let mut image = Image::black(24, 16);
    image.pixels.fill([1.0; 3]);
    let (display, storage) = (Display::default(), Storage::default());
    let path = folder.path().join("one.exr");
    write_image(&image, &[], &display, &storage, &path).expect("is written");
    let given = succeed(
        folder.path(),
        &[&few[..], &["--reference", "one.exr"]].concat(),
    );
    assert_eq!(given["reference"]["kind"], "file");
    assert_eq!(given["reference"]["file"], "one.exr");
    assert_eq!(given["reference"]["rmse"], Value::Null);
    assert!(number(&given["points"][0]["true_rmse"]) > 0.0);
}

/// The mean squares of independent renders go down as their samples go up, so that 4 samples are the worse from more than 4 on; whatever
/// made the reference, the renders tell.
#[test]
fn a_reference_that_is_worse_than_the_renders_is_told() {
    let folder = folder();
    let output = Command::new(env!("CARGO_BIN_EXE_raymini"))
        .current_dir(folder.path())
        .args([
            "render",
            "shadow.toml",
            "--spp",
            "4",
            "--seed",
            "9",
            "-o",
            "told.exr",
        ])
        .output()
        .expect("starts");
    assert!(output.status.success());
    let bad = read_image(&folder.path().join("told.exr")).expect("is right");
    let (display, storage) = (Display::default(), Storage::default());
    let silent = folder.path().join("silent.exr");
    write_image(&bad.image, &[], &display, &storage, &silent).expect("is written");
    for (file, is_known) in [("told.exr", true), ("silent.exr", false)] {
        let few = [
            "shadow.toml",
            "--seeds",
            "2",
            "--spp",
            "256",
            "--reference",
            file,
        ];
        let output = report(folder.path(), &[&few[..], &["-o", "out"]].concat());
        let complaint = String::from_utf8_lossy(&output.stderr);
        let said = "warning: as the scene says: from ";
        assert!(complaint.contains(said), "{file}: {complaint}");
        assert!(!complaint.contains("rendered with seed"), "{complaint}");
        assert!(text(folder.path(), "report.md").contains("samples per pixel on, more than half"));
        let facts: Value = serde_json::from_str(&text(folder.path(), "report.json")).expect("JSON");
        let from = number(&facts["reference_outweighs_from"]);
        assert!((4.0..=64.0).contains(&from), "{file}: {from}");
        assert_eq!(facts["reference"]["rmse"].is_number(), is_known);
    }
    let good = ["shadow.toml", "--seeds", "2", "--spp", "16"];
    let facts = succeed(folder.path(), &good);
    assert_eq!(facts["reference_outweighs_from"], Value::Null);

    // What shares its random numbers with a reference looks better than it is.
    for (seed, is_shared) in [("8", true), ("9", true), ("7", false), ("10", false)] {
        let set = format!("render.seed={seed}");
        let few = ["--seeds", "2", "--spp", "16", "--reference", "told.exr"];
        let others = ["--set", &set, "-o", "out"];
        let output = report(
            folder.path(),
            &[&["shadow.toml"], &few[..], &others].concat(),
        );
        let complaint = String::from_utf8_lossy(&output.stderr);
        let said =
            "warning: told.exr: the reference was rendered with seed 9, as one of the renders";
        assert_eq!(complaint.contains(said), is_shared, "{seed}: {complaint}");
    }
}

/// A sharp lobe under a wide disk: aimed at, the disk is rarely met where the lobe is bright, so that aiming alone is no
/// reference.
#[test]
fn a_reference_that_finds_the_light_badly_is_replaced() {
    let folder = folder();
    let scene = r#"
[camera]
eye = [2, -4, 2]
[materials.polished]
diffuse = [0, 0, 0]
specular = [0.9, 0.9, 0.9]
shininess = 1e5
[[objects]]
mesh = "builtin:ground"
material = "polished"
scale = 3
[[lights]]
kind = "disk"
center = [0, 0, 2]
normal = [0, 0, -1]
radius = 9
[render]
mode = "path"
width = 24
height = 16
"#;
    std::fs::write(folder.path().join("polished.toml"), scene).expect("is written");
    let facts = succeed(
        folder.path(),
        &["polished.toml", "--seeds", "1", "--spp", "16"],
    );
    assert_eq!(facts["reference"]["light_sampling"], "mis");
}

#[test]
fn an_adaptive_variant_has_points_at_its_rounds() {
    let folder = folder();
    let comparison = "render.stop.noise=0.02;render.samples_per_pixel=1024";
    let facts = succeed(
        folder.path(),
        &[
            "shadow.toml",
            "--seeds",
            "2",
            "--reference-samples",
            "256",
            "--compare",
            comparison,
        ],
    );
    let points = facts["variants"][0]["points"].as_array().expect("a list");
    assert!(points.len() >= 5, "{points:?}");
    let last = points.last().expect("is there");
    assert!(number(&last["samples_per_pixel"]) < 1024.0);
}

#[test]
fn mistakes_are_told_with_exit_codes_1_and_2() {
    let folder = folder();
    let (display, storage) = (Display::default(), Storage::default());
    let small = folder.path().join("small.exr");
    write_image(&Image::black(3, 2), &[], &display, &storage, &small).expect("is written");
    let cases: [(&[&str], i32, &str); 10] = [
        (&["none.toml"], 1, "none.toml"),
        (
            &["shadow.toml", "--reference", "small.exr"],
            1,
            "small.exr: the reference is 3×2 pixels, but the scene's picture is 24×16",
        ),
        (
            &["shadow.toml", "--reference", "no.exr"],
            1,
            "no.exr: there",
        ),
        (
            &["shadow.toml", "--compare", "render.filtre=tent"],
            1,
            "--compare render.filtre=tent: ",
        ),
        (
            &["shadow.toml", "--compare", "render.width=25"],
            1,
            "--compare render.width=25: all pictures must be of one size",
        ),
        (&["shadow.toml", "--compare", ";"], 1, "expected KEY=VALUE"),
        (&["shadow.toml", "--spp", "8"], 2, "--spp"),
        (&["shadow.toml", "--seeds", "0"], 2, "--seeds"),
        (
            &["shadow.toml", "--exact", "1,1"],
            2,
            "expected red, green, blue",
        ),
        (
            &[
                "shadow.toml",
                "--exact",
                "1,1,1",
                "--reference",
                "small.exr",
            ],
            2,
            "cannot be used with",
        ),
    ];
    for (arguments, code, expected) in cases {
        let output = report(folder.path(), &[arguments, &["-o", "out"]].concat());
        let complaint = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{complaint}");
        assert!(complaint.contains(expected), "{arguments:?}: {complaint}");
    }
    let output = report(folder.path(), &["shadow.toml", "-o", "tetra.off/out"]);
    assert_eq!(output.status.code(), Some(1));
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(
        complaint.contains("the folder cannot be made"),
        "{complaint}"
    );
}

#[test]
fn renders_that_stop_have_their_end_in_the_report() {
    let folder = folder();
    let run = |stop: &str| {
        let even = "render.adaptive=false";
        succeed(
            folder.path(),
            &[
                "furnace.toml",
                "--seeds",
                "2",
                "--exact",
                "1,1,1",
                "--set",
                stop,
                "--set",
                even,
            ],
        )
    };
    let samples = |facts: &Value| -> Vec<f64> {
        let points = facts["points"].as_array().expect("a list");
        points
            .iter()
            .map(|point| number(&point["samples_per_pixel"]))
            .collect()
    };
    // Passes end at 1, 2, 3, 4, 6, 8, 12, 16 and 24 samples.
    let facts = run("render.stop.passes=9");
    assert_eq!(samples(&facts), [1.0, 2.0, 4.0, 8.0, 16.0, 24.0]);
    assert_eq!(facts["target"], Value::Null);

    let facts = run("render.stop.noise=10");
    assert_eq!(samples(&facts), [1.0, 2.0, 4.0, 8.0, 16.0]);
    let target = &facts["target"];
    assert_eq!(
        (&target["reached"], &target["renders"]),
        (&json!(2), &json!(2))
    );
    assert_eq!(number(&target["took"]["samples_per_pixel"]), 16.0);
    let last = &facts["points"][4];
    assert!(number(&target["took"]["seconds"]) >= number(&last["seconds"]));
    let page = text(folder.path(), "report.md");
    assert!(page.contains("| 1000 % | 2 of 2 | 16 |"), "{page}");
}

/// A white furnace seen from within: a first hit of white in an even light of 1 is 1, to the last digit or nearly.
#[test]
fn an_exact_render_is_not_called_dishonest() {
    let folder = folder();
    let scene = r#"
[camera]
eye = [0, -4, 0]
target = [0, 0, 0]
[background]
radiance = [1, 1, 1]
[materials.white]
diffuse = [1, 1, 1]
[[objects]]
mesh = "ball.off"
material = "white"
[render]
mode = "path"
width = 24
height = 16
roulette = false
"#;
    std::fs::write(folder.path().join("white.toml"), scene).expect("is written");
    let few = [
        "white.toml",
        "--seeds",
        "2",
        "--exact",
        "1,1,1",
        "-o",
        "out",
    ];
    let output = report(folder.path(), &few);
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success() && !said.contains("inf") && !said.contains("NaN"),
        "{said}"
    );
    assert!(
        said.contains("4 pairs of estimated and true error are as exact as numbers are"),
        "{said}"
    );
    assert!(said.contains("no noise but that of rounding"), "{said}");
    let svg = text(folder.path(), "report.svg");
    assert!(
        !svg.contains("10⁻") && svg.contains("as exact as numbers are"),
        "{svg}"
    );
}

/// A picture without shadows comes no nearer to one with them, however long it is rendered.
#[test]
fn nobody_foresees_when_another_picture_becomes_this_one() {
    let folder = folder();
    let facts = succeed(
        folder.path(),
        &[
            "shadow.toml",
            "--seeds",
            "2",
            "--compare",
            "render.shadows=off",
        ],
    );
    assert_eq!(facts["shows_another_picture"], false);
    let variant = &facts["variants"][0];
    assert_eq!(variant["shows_another_picture"], true);
    assert_eq!(variant["time_to"]["0.01"], Value::Null);
    let page = text(folder.path(), "report.md");
    assert!(page.contains("| not by sampling |"), "{page}");
    assert!(text(folder.path(), "report.svg").contains("another picture"));
}

/// Independent samples under the curve of evenly spread ones: more noise at as many samples, and a slope of -0.5 over them, within 0.1.
#[test]
fn samplers_are_compared() {
    let folder = folder();
    let comparison = ["--compare", "render.sampler=independent"];
    let facts = succeed(
        folder.path(),
        &[
            &["shadow.toml", "--spp", "64", "--seeds", "2"],
            &comparison[..],
        ]
        .concat(),
    );
    let independent = &facts["variants"][0];
    assert_eq!(facts["settings"]["sampler"], "sobol");
    assert_eq!(independent["settings"]["sampler"], "independent");
    let error = |of: &Value, doublings: usize| number(&of["points"][doublings]["true_rmse"]);
    assert!(error(independent, 6) > error(&facts, 6));
    let slope = (error(independent, 6) / error(independent, 2)).log2() / 4.0;
    assert!((slope + 0.5).abs() < 0.1, "{slope}");

    let plan = Command::new(env!("CARGO_BIN_EXE_raymini"))
        .current_dir(folder.path())
        .args(["plan", "shadow.toml", "--set", "render.sampler=independent"])
        .output()
        .expect("starts");
    let text = String::from_utf8_lossy(&plan.stdout);
    let line = "random numbers of a sample: independent; point in the pixel 1.000";
    assert!(text.contains(line), "{text}");
}
