//! What is wrong with a file, and where: told whatever its size.

use super::*;
use crate::io::random_edits;

fn message(text: &str) -> String {
    parse(text).expect_err("the file is wrong").to_string()
}

#[test]
#[expect(clippy::too_many_lines, reason = "a table")]
fn mistakes_name_place_and_expectation() {
    let cases = [
        (
            "[[lights]]\nkind = \"disk\"\ntarget = [0, 0, 1]\nnormal = [0, 0, 1]",
            "4:1: `normal` says the same as `target`; leave one of them out",
        ),
        (
            "[[lights]]\nkind = \"disk\"\nradius = 0",
            "3:10: `lights.0.radius` is 0; expected a finite number above 0",
        ),
        (
            "[[lights]]\nkind = \"disk\"\ntarget = [0, 0, 0]",
            "3:10: lights.0.target is [0, 0, 0]; expected a point other than the center",
        ),
        (
            "[camera]\nfocus_distance = 0",
            "2:18: `camera.focus_distance` is 0; expected a number above 0, or inf",
        ),
        (
            "[materials.a]\nkind = \"mirror\"\ndiffuse = [1, 1, 1]",
            "3:1: unknown key `diffuse`",
        ),
        (
            "[render]\nmode = \"path\"\nphong = \"classic\"",
            "3:9: render.phong is classic; expected modified in mode path",
        ),
        (
            "[camera]\neye = [0, 0]",
            "test.toml:2:7: `camera.eye` is [0, 0]; expected [x, y, z]",
        ),
        (
            "[camera]\nvertical_fov = 180",
            "2:16: `camera.vertical_fov` is 180; expected a number above 0 and below 180",
        ),
        (
            "[camera]\nvertical_fov = nan",
            "2:16: `camera.vertical_fov` is NaN; expected a number above 0",
        ),
        (
            "[camera]\nfov = 40",
            "2:1: unknown key `fov`; here it is called `vertical_fov`",
        ),
        (
            "[camera]\nwidth = 40",
            "2:1: unknown key `width`; known here: eye, target, up, vertical_fov",
        ),
        (
            "[camera]\nvertical_fow = 40",
            "unknown key `vertical_fow`; the nearest known one is `vertical_fov`",
        ),
        (
            "[camera]\nup = [0, -6, 2.5]",
            "2:6: camera.up is [0, -6, 2.5]; expected a direction that is not parallel",
        ),
        (
            "[camera]\ntarget = [0, -6, 2.5]",
            "2:10: camera.target is [0, -6, 2.5]; expected a point other than the eye",
        ),
        ("camera = 3", "1:10: `camera` is 3; expected a table"),
        (
            "[materails.clay]\n",
            "1:2: unknown key `materails`; the nearest known one is `materials`",
        ),
        (
            "[materials.clay]\ndifuse = [1,1,1]",
            "2:1: unknown key `difuse`; the nearest known one is `diffuse`",
        ),
        (
            "[materials.clay]\ndiffuse = [1, -1, 1]",
            "2:11: `materials.clay.diffuse` is [1, -1, 1]; expected [red, green, blue]",
        ),
        (
            "[materials.clay]\nkind = \"phong \"",
            "2:8: `materials.clay.kind` is \"phong \"; expected one of \"phong\", \"mirror\"",
        ),
        (
            "[[objects]]\nname = \"x\"",
            "1:1: the key `mesh` is missing here",
        ),
        (
            "[objects]\nmesh = \"x\"",
            "1:1: `objects` is a table; expected a list: write [[objects]]",
        ),
        (
            "[[objects]]\nmesh = \"x\"\nscale = 0",
            "3:9: `objects.0.scale` is 0; expected a finite number other than 0",
        ),
        (
            "[[objects]]\nmesh = \"x\"\nscale = \"2\"",
            "`objects.0.scale` is \"2\"; expected",
        ),
        (
            "[materials.clay]\n[[objects]]\nmesh = \"x\"\nmaterial = \"glay\"",
            "4:12: material \"glay\" is not defined; the nearest defined one is \"clay\"",
        ),
        (
            "[[objects]]\nmesh = \"x\"\ncopies = { count = [1, 0, 1] }",
            "`objects.0.copies.count` is [1, 0, 1]; expected three",
        ),
        (
            "[[lights]]\nkind = \"spot\"",
            "2:8: `lights.0.kind` is \"spot\"; expected one of \"point\", \"disk\"",
        ),
        (
            "[[lights]]\nintensity = [1, 1, inf]",
            "`lights.0.intensity` is [1, 1, inf]; expected [red, green, blue]",
        ),
        (
            "[render]\nsampler = \"halton\"",
            "2:11: `render.sampler` is \"halton\"; expected one of \"sobol\", \"independent\"",
        ),
        (
            "[render]\nwidth = 0",
            "2:9: `render.width` is 0; expected a whole number from 1 to 65536",
        ),
        (
            "[render]\nwidth = 640.5",
            "2:9: `render.width` is 640.5; expected a whole number",
        ),
        (
            "[render]\nwidth = 65536\nheight = 65536",
            "render.width is 65536; expected width × height of at most",
        ),
        (
            "[render]\nmode = \"drect\"",
            "2:8: `render.mode` is \"drect\"; expected one of \"direct\"",
        ),
        (
            "[render]\nantialiasing = 1",
            "`render.antialiasing` is 1; expected true or false",
        ),
        (
            "[background]\nradiance = [1,1,1]\nzenith = [1,1,1]",
            "2:1: `radiance` is for a background that is the same",
        ),
        (
            "[background]\nradiance = [1,1,1]\nimage = \"sky.exr\"",
            "2:1: `radiance` is for a background that is the same everywhere; leave it out beside an image",
        ),
        (
            "[background]\nimage = \"sky.exr\"\nground = [1,1,1]",
            "3:1: `ground` is for a gradient; leave it out beside an image",
        ),
        (
            "[background]\nrotation = 20",
            "2:1: `rotation` is for a background with an `image`",
        ),
        (
            "[background]\nimage = \"sky.exr\"\nscale = -1",
            "3:9: `background.scale` is -1; expected a finite number of at least 0",
        ),
        (
            "[background]\nimage = 3",
            "2:9: `background.image` is 3; expected a text in quotes",
        ),
        (
            "[background]\nimage = \"sky.exr\"\nup = [0, 0, 0]",
            "3:6: background.up is [0, 0, 0]; expected a direction",
        ),
        (
            "[background]\nimge = \"sky.exr\"",
            "2:1: unknown key `imge`; the nearest known one is `image`",
        ),
        (
            "[background]\nzenit = [1,1,1]",
            "2:1: unknown key `zenit`; the nearest known one is `zenith`",
        ),
        (
            "[output]\npng_bits = 12",
            "`output.png_bits` is 12; expected 8 or 16",
        ),
        (
            "[render]\nseed = -1",
            "`render.seed` is -1; expected a whole number from 0",
        ),
        ("[render\n", "test.toml:1:8: "),
        ("x = 1979-05-27", "a date has no meaning in a scene"),
        (
            "[render]\nwidth = 99999999999999999999",
            "does not fit a 64-bit integer",
        ),
    ];
    for (text, expected) in cases {
        let found = message(text);
        assert!(
            found.contains(expected),
            "{text:?}\n  found:    {found}\n  expected: {expected}"
        );
    }
}

#[test]
fn columns_count_characters_not_bytes() {
    assert!(message("[materials.\"ä\"]\ndiffuse = { \"ö\" = 1 }").starts_with("test.toml:2:11:"));
    assert!(message("# ü\nü = 1").starts_with("test.toml:2:1:"));
}

/// Keys are not visited in their order in the text.
#[test]
fn columns_are_right_in_any_order() {
    let keys: Vec<String> = (0..2000).rev().map(|i| format!("\"é{i}\"")).collect();
    let pairs: Vec<String> = keys.iter().map(|key| format!("{key} = 7")).collect();
    let text = format!("x = {{ {} }}\n", pairs.join(", "));
    let tree = Node::parse(&text, "").expect("is TOML");
    for key in &keys {
        let before = text.split_once(&format!("{key} = ")).expect("is there").0;
        let place = tree.place_of(&format!("x.{}", key.trim_matches('"')));
        let expected = before.chars().count() + key.chars().count() + " = ".len() + 1;
        assert_eq!((place.line, place.column), (1, expected), "{key}");
    }
}

#[test]
fn a_long_line_is_read_and_its_columns_are_right() {
    // Keys in another order than they are asked for, and so many that counting columns from the start for each would not end.
    let light = "{ position = [1, 2, 3], kind = \"point\", intensity = [1, 1, 1] }, ";
    let text = format!("lights = [{}{{ intensity = 1 }}]", light.repeat(50_000));
    let error = SceneFile::parse(&text, "test.toml").expect_err("is wrong");
    let column = text.chars().count() - "1 }]".len() + 1;
    assert!(
        error.to_string().contains(&format!(":1:{column}: ")),
        "{error}"
    );
}

/// To compare two words takes the product of their lengths: a scene of some megabytes could ask for all memory there is.
#[test]
fn words_of_any_length_are_compared_in_little_memory() {
    let long = "k".repeat(1 << 20);
    let materials = format!("[materials.clay]\n[materials.l{long}]\n");
    let object = format!("[[objects]]\nmesh = \"a.off\"\nmaterial = \"{long}\"\n");
    for (text, expected) in [
        (format!("{long} = 1\n"), "test.toml:1:1: unknown key `kkkk"),
        (format!("[render]\n{long} = 1\n"), "test.toml:2:1: "),
        (
            format!("{materials}{object}"),
            "test.toml:5:12: material \"kkkk",
        ),
    ] {
        let found = message(&text);
        assert!(found.starts_with(expected), "{found}");
        assert!(found.len() < 1000, "{} bytes", found.len());
    }
}

/// Whatever a file holds, what is said about it fits on a screen.
#[test]
fn messages_show_the_beginning_of_what_is_long() {
    let list = format!("[{}]", "1, ".repeat(5000));
    let text = "é".repeat(5000);
    let huge = format!("[1e308, {}0.5]", "-1e308, ".repeat(20));
    for (value, shown) in [
        (list.clone(), "[1, 1, 1, 1, 1, 1, 1, 1, …]"),
        (format!("[{list}, 2]"), "[a list, 2]"),
        (
            huge,
            "[1e308, -1e308, -1e308, -1e308, -1e308, -1e308, -1e308, -1e308, …]",
        ),
        (format!("\"{text}\""), &format!("\"{}…\"", "é".repeat(60))),
    ] {
        assert_eq!(
            message(&format!("camera.eye = {value}")),
            format!(
                "test.toml:1:14: `camera.eye` is {shown}; expected [x, y, z], each a finite number"
            )
        );
    }
}

#[test]
fn random_edits_never_panic() {
    let base =
        write(&parse("[[objects]]\nmesh = \"x\"\n[[lights]]\n[materials.a]").expect("is right"));
    let mut next = random_edits::numbers();
    for _ in 0..3000 {
        let mut bytes = base.clone().into_bytes();
        for _ in 0..=next(3) {
            if bytes.is_empty() {
                break;
            }
            let at = next(bytes.len());
            match next(3) {
                0 => bytes[at] = b"[]{}=\".,#-0\n"[next(12)],
                1 => drop(bytes.remove(at)),
                _ => bytes.truncate(at + 1),
            }
        }
        let _ = parse(&String::from_utf8_lossy(&bytes));
    }
}
