//! Keys that are set from outside of the file.

use super::*;

#[test]
fn overrides_change_any_key() {
    let scene = parse("[[objects]]\nmesh = \"x\"\n[[lights]]").expect("is right");
    let set = |assignment: &str| apply_overrides(&scene, &[assignment.to_owned()]);
    assert_eq!(set("render.width=17").expect("is right").render.width, 17);
    assert_eq!(
        set("render.mode = normals").expect("is right").render.mode,
        Mode::Normals
    );
    assert_eq!(
        set("render.mode=\"depth\"").expect("is right").render.mode,
        Mode::Depth
    );
    assert_eq!(
        set("objects.0.scale=2").expect("is right").objects[0]
            .scale
            .to_bits(),
        2.0_f64.to_bits()
    );
    let lit = set("lights.0.intensity=[1, 2, 3]").expect("is right");
    assert_eq!(
        lit.lights,
        [Light::Point {
            position: DVec3::ZERO,
            intensity: DVec3::new(1.0, 2.0, 3.0)
        }]
    );
    assert_eq!(
        set("materials.red.diffuse=[1,0,0]")
            .expect("is right")
            .materials
            .len(),
        1
    );

    // What excludes each other makes way, and order does not matter where the end is right.
    let disk = set("lights.0.kind=disk").expect("is right");
    assert!(matches!(disk.lights[0], Light::Disk { .. }));
    let sky = set("background.zenith=[1, 1, 1]")
        .expect("is right")
        .background;
    assert!(matches!(sky, Background::Gradient { .. }));
    let image = |assignments: &[&str]| {
        let all: Vec<String> = assignments.iter().map(ToString::to_string).collect();
        apply_overrides(&scene, &all).expect("is right").background
    };
    let up = DVec3::new(0.0, 0.0, 1.0);
    let expected = Background::Image {
        image: "sky.hdr".into(),
        up,
        rotation: Degrees(20.0),
        scale: 1.0,
    };
    let assignments = ["background.image=sky.hdr", "background.rotation=20"];
    assert_eq!(image(&assignments), expected);
    let back = [
        assignments[0],
        assignments[1],
        "background.radiance=[1, 1, 1]",
    ];
    assert_eq!(
        image(&back),
        Background::Constant {
            radiance: DVec3::ONE
        }
    );
    let aimed = ["lights.0.kind=disk", "lights.0.target=[0, 0, -3]"].map(str::to_owned);
    assert!(apply_overrides(&scene, &aimed).is_ok());
    let from_above = [
        "camera.eye=[0, 0, 5]",
        "camera.target=[0, 0, 0]",
        "camera.up=[0, 1, 0]",
    ]
    .map(str::to_owned);
    assert!(apply_overrides(&scene, &from_above).is_ok());
}

#[test]
fn wrong_overrides_are_told_with_what_was_expected() {
    let scene = parse("[[objects]]\nmesh = \"x\"\n[[lights]]").expect("is right");
    let cases = [
        (
            "render.wdith=3",
            "--set render.wdith=3: unknown key `wdith`; the nearest known one is `width`",
        ),
        (
            "render.width=x",
            "`render.width` is \"x\"; expected a whole number",
        ),
        (
            "objects.1.scale=2",
            "\"1\" is not one of the 1 items, numbered from 0",
        ),
        (
            "render.width.x=2",
            "\"x\" asks for a part of 640, which has none",
        ),
        ("render.width", "expected KEY=VALUE"),
        (
            "render.width=[",
            "\"[\" is no value; expected one such as 2.5, true",
        ),
        ("camera.eye=1,2,3", "\"1,2,3\" is no value; expected"),
        ("=1", "--set =1: expected KEY=VALUE"),
        (
            "spp=1",
            "--set spp=1: unknown key `spp`; known here: camera, ",
        ),
        (
            "samples_per_pixel=1",
            "unknown key `samples_per_pixel`; there is `render.samples_per_pixel`",
        ),
        ("scale=1", "unknown key `scale`; there is `objects.0.scale`"),
        (
            "render.sampels=1",
            "unknown key `sampels`; the nearest known one is `samples_per_pixel`",
        ),
        (
            "render.qqqq=1",
            "unknown key `qqqq`; the nearest of the 24 known here are mode, seed, stop",
        ),
    ];
    for (assignment, expected) in cases {
        let found = apply_overrides(&scene, &[assignment.to_owned()]);
        let found = found.expect_err("is wrong").to_string();
        assert!(found.contains(expected), "{assignment}: {found}");
    }
}

/// Of several assignments the wrong one is named; all of them where what is wrong then was there before.
#[test]
fn the_assignment_to_blame_is_named() {
    let scene = parse("").expect("is right");
    let found_in = |scene: &Scene, assignments: &[&str]| {
        let assignments: Vec<String> = assignments.iter().map(|&text| text.to_owned()).collect();
        let error = apply_overrides(scene, &assignments).expect_err("is wrong");
        error.at
    };
    let found = |assignments: &[&str]| found_in(&scene, assignments);
    let [right, also] = ["render.height=8", "camera.up=[0, 1, 0]"];
    for wrong in [
        "render.wdith=3",
        "render.width=x",
        "render.width=",
        "camera.vertical_fov=200",
        "background={ zenit = [1, 1, 1] }",
        "materials.clay.diffuse=[1, -1, 1]",
        "camera.target=[0, -6, 2.5]",
    ] {
        for assignments in [[wrong, right, also], [right, also, wrong]] {
            assert_eq!(found(&assignments), format!("--set {wrong}"));
        }
    }
    // Also where another one says the same key again, rightly.
    for (wrong, again) in [
        ("render.width=x", "render.width=8"),
        ("camera.vertical_fov=200", "camera.vertical_fov=20"),
        (
            "materials.clay.diffuse=[1, -1, 1]",
            "materials.clay.diffuse=[1, 1, 1]",
        ),
    ] {
        assert_eq!(found(&[right, wrong, again]), format!("--set {wrong}"));
    }
    let together = ["render.mode=path", "render.phong=classic"];
    assert_eq!(found(&together), "--set render.phong=classic");
    // Each is right by itself, and what is wrong with both goes.
    let again = [
        "render.phong=classic",
        "render.mode=path",
        "render.mode=direct",
    ];
    let again = again.map(str::to_owned);
    assert!(apply_overrides(&scene, &again).is_ok());
    // What the second is about is no longer there.
    let spoiled = ["render=3", "render.width=96"];
    assert_eq!(found(&spoiled), "--set render=3");
    assert_eq!(
        found(&["render.mode=ao", spoiled[1], "render.width.x=2"]),
        "--set render.width.x=2"
    );
    let classic = parse("[render]\nphong = \"classic\"").expect("is right");
    let found = found_in(&classic, &["render.mode=path", right]);
    assert_eq!(found, "--set render.mode=path --set render.height=8");
}
