use super::*;
use crate::io::Remarks;
use crate::io::mesh_reading::trials;
use crate::math::DVec3;
use crate::scene::{Material, Textures};

fn read(text: &str) -> MtlFile {
    let progress = Progress::new();
    let file = parse(text.as_bytes(), &CancelToken::new(), &progress);
    assert_eq!(progress.done(), text.len() as u64);
    file.expect("is right").expect("nobody cancels")
}

/// The one material of a text, without warnings.
fn one(statements: &str) -> MtlMaterial {
    let file = read(&format!("newmtl a\n{statements}\n"));
    assert_eq!(file.warnings, Vec::<String>::new(), "{statements}");
    let [(_, material)] = &file.materials[..] else {
        panic!("{:?}", file.materials)
    };
    material.clone()
}

/// What the scene gets, and what is said of it.
fn mapped(statements: &str) -> (Material, Vec<String>) {
    let mut remarks = Remarks::of("material");
    let material = one(statements).to_material("a", &mut remarks);
    (material, remarks.sentences().collect())
}

fn phong(diffuse: [f64; 3], specular: [f64; 3], shininess: f64) -> Material {
    Material::Phong {
        diffuse: diffuse.into(),
        specular: specular.into(),
        shininess,
        textures: Textures::default(),
    }
}

#[test]
fn every_statement_is_understood_however_it_is_written() {
    let expected = MtlMaterial {
        diffuse: Some(DVec3::new(0.6, 0.4, 0.2)),
        specular: Some(DVec3::splat(0.1)),
        emission: Some(DVec3::ZERO),
        shininess: Some(60.0),
        ior: Some(1.5),
        opacity: Some(0.25),
        illumination: Some(2),
        diffuse_image: Some("my oak.png".into()),
        normal_image: Some("n.png".into()),
    };
    let plain = "Kd 0.6 0.4 0.2\nKs 0.1 0.1 0.1\nKe 0 0 0\nNs 60\nNi 1.5\nd 0.25\nillum 2\nmap_Kd my oak.png\nnorm n.png";
    let cases = [
        plain.to_owned(),
        plain.replace('\n', "\r\n  \t"),
        plain
            .replace("Kd", "KD")
            .replace("norm", "MAP_BUMP -bm 1.0"),
        plain.replace("d 0.25", "Tr 0.75"),
        plain.replace("d 0.25", "Tr 0.1\nd -halo 0.25"),
        plain.replace("d 0.25", "d 0.25\nTr 0.25"),
        plain.replace("0.1 0.1 0.1", "0.1"),
        plain.replace("my", "-s 1 1 -o 0 -clamp off -blendu off -mm 0 1 my"),
        plain.replace("n.png", "n.png\nbump other.png # n"),
        format!("Ka 1 1 1\nTf 1 1 1\nPr 0.3 # x\n{plain} # the end"),
    ];
    for text in cases {
        assert_eq!(one(&text), expected, "{text}");
    }
}

#[test]
fn options_of_images_that_would_be_seen_are_told_of() {
    let warnings = |options: &str| read(&format!("newmtl a\nmap_Kd {options} a.png\n")).warnings;
    for options in [
        "",
        "-s 1 1 1 -o 0 0",
        "-clamp off -bm 1",
        "-mm 0.5 2 -blendu on",
    ] {
        assert_eq!(warnings(options), Vec::<String>::new(), "{options}");
    }
    for options in [
        "-s 2 2",
        "-o 0 0.5",
        "-t 0.1 0 0",
        "-bm 0.3",
        "-s 1 1 -clamp on",
    ] {
        assert_eq!(
            warnings(options),
            [
                "images are not moved, scaled, cut off at their edges or made steeper, as options say (the first on line 2)"
            ],
            "{options}"
        );
    }
}

#[test]
fn names_may_hold_blanks_and_number_signs() {
    let file = read("newmtl Material #25  \nKd 0\nnewmtl b # of oak\nnewmtl b\nKd 1\nnewmtl\n");
    let names: Vec<_> = file
        .materials
        .iter()
        .map(|(name, _)| name.as_str())
        .collect();
    assert_eq!(names, ["Material #25", "b", ""]);
    assert_eq!(file.materials[1].1.diffuse, Some(Rgb::ONE));
    assert_eq!(
        file.warnings,
        ["1 material is there twice; the later one counts (line 4)"]
    );
}

#[test]
fn what_is_ignored_is_said_with_its_line() {
    let file = read(
        "Kd 1 1 1\nnewmtl a\nKd 0.5\nKd spectral a.rfl\nKd 1 2\nKd 1 -1 1\nNs nan\nd 1.5\nillum two\nmap_Kd\nmap_Ks a.png\nwhat 3\n",
    );
    assert_eq!(
        file.materials[0].1,
        MtlMaterial {
            diffuse: Some(Rgb::splat(0.5)),
            ..MtlMaterial::default()
        }
    );
    let expected = [
        "7 values that are no numbers in their range are ignored (the first on line 4)",
        "1 statement before the first newmtl is ignored (line 1)",
        "images other than those of Kd and of normals are ignored (the first on line 11)",
        "1 statement of another kind is ignored (line 12)",
    ];
    assert_eq!(file.warnings, expected);
    let error = parse(b"# x\nversion 2\n", &CancelToken::new(), &Progress::new());
    let expected = "line 2: expected newmtl or another keyword of MTL, found \"version\"";
    assert_eq!(error.expect_err("is no MTL").to_string(), expected);
    assert_eq!(read("").materials, []);
    let cancel = CancelToken::new();
    cancel.cancel();
    assert_eq!(parse(b"newmtl a\n", &cancel, &Progress::new()), Ok(None));
}

/// The rule, as the documentation of [`MtlMaterial::to_material`] has it.
#[test]
fn materials_become_the_nearest_of_the_scene() {
    let none = Vec::<String>::new;
    let said = |what: &str| vec![format!("material \"a\": {what}")];
    let glass = |ior| Material::Glass {
        ior,
        attenuation: Rgb::ZERO,
    };
    let mirror = |reflectance: [f64; 3]| Material::Mirror {
        reflectance: reflectance.into(),
    };
    let red = "Kd 0.8 0.1 0.1\nKs 0.1 0.2 0.3\nNs 60\n";
    let red_phong = phong([0.8, 0.1, 0.1], [0.1, 0.2, 0.3], 60.0);
    let opaque = said("lets light through without being glass; it is opaque here");
    let cases = [
        (String::new(), Material::default(), none()),
        (red.to_owned(), red_phong.clone(), none()),
        (
            format!("{red}illum 2\nd 1\nNi 1.45"),
            red_phong.clone(),
            none(),
        ),
        (
            format!("{red}illum 1"),
            phong([0.8, 0.1, 0.1], [0.0; 3], 60.0),
            none(),
        ),
        (
            "Kd 0.8 1.5 0\nKs 0.5 0.5 0.5\nNs 1e99".into(),
            phong([0.8, 1.0, 0.0], [1.0 - 0.8, 0.0, 0.5], 1e12),
            said(
                "reflects more light than arrives (Kd + Ks above 1); Ks is lowered to what Kd leaves",
            ),
        ),
        (
            format!("{red}Ke 17 12 4"),
            Material::Emitter {
                radiance: Rgb::new(17.0, 12.0, 4.0),
            },
            none(),
        ),
        (
            format!("{red}Ke 0.1 0 0"),
            red_phong.clone(),
            said("shines less than it reflects; it only reflects here"),
        ),
        (format!("{red}illum 3"), red_phong.clone(), none()),
        (
            "Kd 0.1\nKs 0.9 0.8 2\nillum 3".into(),
            mirror([0.9, 0.8, 1.0]),
            none(),
        ),
        ("Kd 0\nKs 0.9\nillum 5".into(), mirror([0.9; 3]), none()),
        (
            "Kd 0\nKs 0.9\nillum 2".into(),
            phong([0.0; 3], [0.9; 3], 40.0),
            none(),
        ),
        (format!("{red}d 0.1\nNi 1.3"), glass(1.3), none()),
        (format!("{red}Tr 0.9\nillum 4"), glass(1.5), none()),
        (format!("{red}illum 4"), red_phong.clone(), none()),
        (format!("{red}illum 7\nNi 2"), glass(2.0), none()),
        (format!("{red}illum 6\nNi 1"), glass(1.5), none()),
        (format!("{red}illum 6\nNi 1e9"), glass(1.5), none()),
        (
            format!("{red}d 0.1\nNi 1\nillum 2"),
            red_phong.clone(),
            opaque.clone(),
        ),
        (format!("{red}d 0"), red_phong.clone(), opaque),
    ];
    for (text, material, remarks) in cases {
        assert_eq!(mapped(&text), (material, remarks), "{text}");
    }
}

#[test]
fn images_multiply_the_diffuse_color() {
    let mapped = |statements: &str| match mapped(statements).0 {
        Material::Phong {
            diffuse, textures, ..
        } => (diffuse, textures),
        other => panic!("{other:?}"),
    };
    for (statements, expected) in [
        ("map_Kd a.png\nnorm n.png", Rgb::ONE),
        ("Kd 0 0 0\nmap_Kd a.png\nnorm n.png", Rgb::ONE),
        ("Kd 0.5\nmap_Kd a.png\nnorm n.png", Rgb::splat(0.5)),
    ] {
        let (diffuse, textures) = mapped(statements);
        assert_eq!(diffuse, expected, "{statements}");
        let images: Vec<_> = textures.images().collect();
        assert_eq!(images, ["a.png", "n.png"]);
    }
}

#[test]
fn random_mutations_never_panic() {
    let file: &[u8] = b"newmtl a b\nKd 0.1 0.2 0.3\nmap_Kd -s 1 1 1 -o 0 a.png\nd -halo 0.5\nillum 3\nnewmtl c # x\nNs 1e3\nKe 1\n";
    let scraps: [&[u8]; 8] = [
        b"",
        b"\n",
        b" ",
        b"#",
        b"-o",
        b"1e999",
        b"nan",
        b"\nnewmtl a b\n",
    ];
    trials::for_mutations(&[file.to_vec()], &scraps, |bytes| {
        let read = parse(bytes, &CancelToken::new(), &Progress::new());
        let Ok(Some(file)) = read else { return };
        let mut remarks = Remarks::of("material");
        for (name, material) in &file.materials {
            let _ = material.to_material(name, &mut remarks);
        }
    });
}
