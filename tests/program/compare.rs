//! `raymini compare` as a user calls it: numbers, difference pictures, exit codes and messages.

use std::path::Path;
use std::process::{Command, Output};

use raymini::io::{read_image, write_image};
use raymini::render::Image;
use raymini::scene::{Display, Output as Storage};
use serde_json::{Value, json};
use tempfile::TempDir;

/// A folder with a reference of 4×2 pixels, all grey of 0.5, and a picture with two other pixels, as EXR.
fn folder() -> TempDir {
    let folder = TempDir::new().expect("a folder");
    let reference = Image {
        width: 4,
        height: 2,
        pixels: vec![[0.5; 3]; 8],
    };
    let mut picture = reference.clone();
    picture.pixels[2] = [0.75, 0.5, 0.25];
    picture.pixels[5] = [0.5, 0.5, 0.500_01];
    write(folder.path(), "a.exr", &picture);
    write(folder.path(), "b.exr", &reference);
    write(folder.path(), "small.png", &Image::black(3, 2));
    folder
}

fn write(folder: &Path, name: &str, image: &Image) {
    let (display, storage) = (Display::default(), Storage::default());
    write_image(image, &[], &display, &storage, &folder.join(name)).expect("is written");
}

fn compare(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_raymini"))
        .current_dir(folder)
        .arg("compare")
        .args(arguments)
        .output()
        .expect("starts")
}

/// Runs the program where it must succeed; what it printed.
fn succeed(folder: &Path, arguments: &[&str]) -> String {
    let output = compare(folder, arguments);
    assert!(
        output.status.success(),
        "{arguments:?}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).expect("is text")
}

fn facts(folder: &Path, arguments: &[&str]) -> Value {
    let text = succeed(folder, &[arguments, &["--json"]].concat());
    serde_json::from_str(&text).expect("is JSON")
}

/// By hand: two channels of 24 differ by 1/4 (and one by next to nothing), so the mean square is 1/192; relative to
/// 0.25 + 0.01, it is that over 0.26.
#[test]
fn compare_prints_the_numbers_worked_out_by_hand() {
    let folder = folder();
    let facts = facts(folder.path(), &["a.exr", "b.exr"]);
    for (key, expected) in [
        ("mse", 1.0 / 192.0),
        ("rmse", (1.0_f64 / 192.0).sqrt()),
        ("relmse", 1.0 / 192.0 / 0.26),
        ("noise", (1.0_f64 / 192.0 / 0.26).sqrt()),
    ] {
        let found = facts[key].as_f64().expect("a number");
        assert!((found / expected - 1.0).abs() < 1e-7, "{key}: {found}");
    }
    assert_eq!((&facts["width"], &facts["height"]), (&4.into(), &2.into()));
    assert_eq!(facts["identical"], false);
    assert_eq!(facts["largest"], json!({"value": 0.25, "x": 2, "y": 0}));
    assert_eq!(facts["percentile_999"], 0.25);
    assert_eq!(facts["mean"]["a"][0], 0.5 + 0.25 / 8.0);
    assert_eq!(facts["mean"]["b"], json!([0.5, 0.5, 0.5]));
    assert_eq!(facts["mean"]["relative"][0], 0.0625);
    assert_eq!(facts["differing_pixels"], 2);
    assert_eq!(facts["visibly_differing_pixels"], 1);
    assert_eq!(facts["non_finite"], json!({"a": 0, "b": 0}));
    assert_eq!(facts["warnings"], json!([]));
}

#[test]
fn compare_prints_aligned_lines_for_people() {
    let folder = folder();
    let text = succeed(folder.path(), &["a.exr", "b.exr"]);
    assert!(
        text.starts_with("A: a.exr\nB: b.exr, the reference\n"),
        "{text}"
    );
    for expected in [
        "  size              4×2                             linear values",
        "  identical         no                              every value the same",
        "  differing pixels  2 (25.000 %)                    by however little",
        "  RMSE              0.072169                        root of MSE",
        "  noise             14.153 %                        root of relMSE",
        "  largest |A − B|   0.25000                         at pixel (2, 0)",
        "  A brighter by     +6.250 %  +0.000 %  -6.250 %    of B's mean",
        "  not finite        0 in A, 0 in B",
    ] {
        assert!(
            text.lines().any(|line| line.starts_with(expected)),
            "{expected}: {text}"
        );
    }
    assert!(!text.contains("warning"), "{text}");
    assert!(text.lines().count() <= 24, "one screen: {text}");
}

#[test]
fn a_picture_is_identical_to_itself() {
    let folder = folder();
    for file in ["a.exr", "small.png"] {
        let facts = facts(folder.path(), &[file, file]);
        assert_eq!(facts["identical"], true);
        assert_eq!(
            (&facts["rmse"], &facts["noise"]),
            (&0.0.into(), &0.0.into())
        );
        assert_eq!(facts["differing_pixels"], 0);
    }
    let text = succeed(folder.path(), &["a.exr", "a.exr"]);
    assert!(text.contains("  identical         yes"), "{text}");
}

/// A PNG holds grey of 0.5 as code 188, which is 0.502886458 in linear light; pictures are `f32`.
#[test]
fn png_is_compared_with_exr_in_linear_light() {
    let folder = folder();
    let reference = read_image(&folder.path().join("b.exr")).expect("is right");
    write(folder.path(), "b.png", &reference.image);
    let facts = facts(folder.path(), &["b.png", "b.exr"]);
    let rmse = facts["rmse"].as_f64().expect("a number");
    assert!((rmse - 0.002_886_458).abs() < 3e-7, "{rmse}");
    assert_eq!(facts["differing_pixels"], 8);
    assert_eq!(facts["visibly_differing_pixels"], 0);
    let warning = facts["warnings"][0].as_str().expect("a warning");
    assert!(
        warning.starts_with("a PNG holds what a screen shows"),
        "{warning}"
    );
}

#[test]
fn the_difference_is_signed_in_exr_and_bright_in_png() {
    let folder = folder();
    let exr = facts(folder.path(), &["a.exr", "b.exr", "-o", "d.exr"]);
    assert_eq!(exr["difference"], json!({"file": "d.exr", "white": null}));
    let signed = read_image(&folder.path().join("d.exr")).expect("is right");
    assert_eq!(signed.image.pixels[2], [0.25, 0.0, -0.25]);
    assert_eq!(signed.image.pixels[0], [0.0; 3]);

    let png = facts(folder.path(), &["a.exr", "b.exr", "-o", "d.png"]);
    assert_eq!(png["difference"], json!({"file": "d.png", "white": 0.25}));
    let picture = image::open(folder.path().join("d.png")).expect("is a picture");
    let picture = picture.into_rgb8();
    assert_eq!(picture.get_pixel(2, 0).0, [255, 0, 255]);
    assert_eq!(picture.get_pixel(0, 0).0, [0; 3]);
    let text = succeed(folder.path(), &["a.exr", "b.exr", "-o", "d.png"]);
    assert!(text.contains("|A − B|; white is 0.25000"), "{text}");

    let same = facts(folder.path(), &["a.exr", "a.exr", "-o", "same.png"]);
    assert_eq!(same["difference"]["white"], 1.0);
    let black = read_image(&folder.path().join("same.png")).expect("is right");
    assert_eq!(black.image, Image::black(4, 2));
}

/// One pixel of two thousand is beyond the percentile; drawn against it the picture would be divided by zero.
#[test]
fn a_single_wild_pixel_is_seen_in_the_difference() {
    let folder = folder();
    let black = Image::black(50, 40);
    let mut wild = black.clone();
    wild.pixels[1234] = [0.0, 8.0, 0.0];
    write(folder.path(), "black.exr", &black);
    write(folder.path(), "wild.exr", &wild);
    let facts = facts(folder.path(), &["wild.exr", "black.exr", "-o", "d.png"]);
    assert_eq!(facts["percentile_999"], 0.0);
    assert_eq!(facts["difference"]["white"], 8.0);
    let picture = read_image(&folder.path().join("d.png")).expect("is right");
    assert_eq!(picture.image.pixels[1234], [0.0, 1.0, 0.0]);
}

#[test]
fn values_that_are_not_finite_are_counted_and_warned_about() {
    let folder = folder();
    let mut picture = read_image(&folder.path().join("b.exr"))
        .expect("is right")
        .image;
    picture.pixels[3] = [f32::NAN, 0.5, 0.5];
    picture.pixels[4] = [0.5, f32::INFINITY, 0.5];
    write(folder.path(), "nan.exr", &picture);
    let facts = facts(folder.path(), &["nan.exr", "b.exr", "-o", "d.png"]);
    assert_eq!(facts["non_finite"], json!({"a": 2, "b": 0}));
    assert_eq!(facts["compared_pixels"], 6);
    assert_eq!(facts["rmse"], 0.0);
    assert_eq!(facts["identical"], false);
    assert_eq!(
        (&facts["flip"], &facts["differing_pixels"]),
        (&0.0.into(), &2.into())
    );
    let warning = "nan.exr: 2 of 8 pixels hold a value that is infinite or not a number; only the counts of differing pixels have them";
    assert_eq!(facts["warnings"], json!([warning]));
    let marked = image::open(folder.path().join("d.png")).expect("is a picture");
    assert_eq!(marked.into_rgb8().get_pixel(3, 0).0, [255, 0, 255]);
    let text = succeed(folder.path(), &["nan.exr", "b.exr"]);
    assert!(
        text.contains("not finite        2 in A, 0 in B") && text.contains(warning),
        "{text}"
    );

    // Where nothing is left there are no numbers, and no 0 that would look like success.
    picture.pixels = vec![[f32::NAN; 3]; 8];
    write(folder.path(), "nan.exr", &picture);
    let none = self::facts(folder.path(), &["nan.exr", "b.exr"]);
    for key in ["rmse", "relmse", "noise", "largest", "percentile_999"] {
        assert_eq!(none[key], Value::Null, "{key}");
    }
}

#[test]
fn the_difference_takes_the_place_of_no_picture_that_is_compared() {
    let folder = folder();
    let read = |name: &str| std::fs::read(folder.path().join(name)).expect("is there");
    let before = ["a.exr", "b.exr"].map(read);
    for output in ["a.exr", "./b.exr"] {
        let output = compare(folder.path(), &["a.exr", "b.exr", "-o", output]);
        let complaint = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{complaint}");
        let expected = "it is compared; the difference would take its place";
        assert!(complaint.contains(expected), "{complaint}");
    }
    assert!(before == ["a.exr", "b.exr"].map(read));
}

/// A region has the bits of the whole picture there; of another picture it is no part.
#[test]
fn a_region_is_compared_with_its_part_of_the_whole_picture() {
    let folder = folder();
    let scene = "[[objects]]\nmesh = \"builtin:ram\"\n[background]\nzenith = [0, 0, 1]\nhorizon = [1, 1, 1]\n";
    std::fs::write(folder.path().join("scene.toml"), scene).expect("is written");
    let render = |output: &str, more: &str| {
        let arguments = format!("render scene.toml -o {output} --spp 2 {more}");
        let status = Command::new(env!("CARGO_BIN_EXE_raymini"))
            .current_dir(folder.path())
            .args(arguments.split(' '))
            .status();
        assert!(status.expect("starts").success());
    };
    for format in ["exr", "png"] {
        let [whole, part] = ["whole", "part"].map(|name| format!("{name}.{format}"));
        render(&whole, "--size 32x24");
        render(&part, "--size 32x24 --region 10,5,16,9");
        let region = json!({"x": 10, "y": 5, "width": 16, "height": 9});
        for (a, b, of) in [(&part, &whole, "b"), (&whole, &part, "a")] {
            let facts = facts(folder.path(), &[a, b]);
            assert_eq!(facts["identical"], true, "{facts}");
            assert_eq!(facts["part"], json!({"of": of, "region": region}));
            assert_eq!((&facts["width"], &facts["height"]), (&16.into(), &9.into()));
        }
        let text = succeed(folder.path(), &[&part, &whole]);
        assert!(
            text.contains("from pixel (10, 5) on") && text.contains("of B, which is larger"),
            "{text}"
        );
        assert_eq!(facts(folder.path(), &[&part, &part])["part"], Value::Null);
    }
    render("other.exr", "--size 40x24");
    let output = compare(folder.path(), &["part.exr", "other.exr"]);
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        complaint.contains("the sizes differ: 16×9 and 40×24"),
        "{complaint}"
    );
}

#[test]
fn mistakes_are_told_with_exit_codes_1_and_2() {
    let folder = folder();
    let bytes = std::fs::read(folder.path().join("a.exr")).expect("exists");
    std::fs::write(folder.path().join("cut.exr"), &bytes[..bytes.len() - 9]).expect("is written");
    std::fs::write(folder.path().join("text.png"), "not a picture").expect("is written");
    let cases: [(&[&str], i32, &str); 8] = [
        (
            &["small.png", "b.exr"],
            1,
            "error: small.png and b.exr cannot be compared: the sizes differ: 3×2 and 4×2 pixels",
        ),
        (&["none.png", "b.exr"], 1, "none.png: there is no such file"),
        (
            &["cut.exr", "b.exr"],
            1,
            "cut.exr: not a whole OpenEXR file",
        ),
        (
            &["a.exr", "text.png"],
            1,
            "text.png: this is not a known kind of image; expected PNG (.png), OpenEXR",
        ),
        (
            &["a.exr", "b.exr", "-o", "d.jpg"],
            1,
            "d.jpg: pictures are written as .png or .exr",
        ),
        (
            &["a.exr", "b.exr", "-o", "no/d.png"],
            1,
            "no/d.png: cannot write the picture",
        ),
        (&["a.exr"], 2, "<B>"),
        (&["a.exr", "b.exr", "--bogus"], 2, "--bogus"),
    ];
    for (arguments, code, expected) in cases {
        let output = compare(folder.path(), arguments);
        let complaint = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{complaint}");
        assert!(complaint.contains(expected), "{arguments:?}: {complaint}");
    }
}
