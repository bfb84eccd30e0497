//! What is written is what was there.

use super::*;

#[test]
fn numbers_beyond_32_bits_are_refused() {
    let mut scene = full_scene();
    let mesh = scene.meshes.values_mut().next().expect("there is one");
    Arc::make_mut(mesh).positions[0].x = 1e39;
    let error = write(&scene, None, &mut Vec::new()).expect_err("is refused");
    assert_eq!(
        error.to_string(),
        "it has coordinates beyond 3.4e38, the largest number of glTF"
    );
}

/// A scene with everything that a GLB holds.
pub fn full_scene() -> Scene {
    let mut round = shapes::icosphere(1);
    for position in &mut round.positions {
        *position = position.as_vec3().as_dvec3();
    }
    let mut mapped = round.clone();
    mapped.normals = Some(
        round
            .positions
            .iter()
            .map(|p| p.normalize().as_vec3().as_dvec3())
            .collect(),
    );
    mapped.texture_coordinates = Some(
        round
            .positions
            .iter()
            .map(|p| DVec2::new(p.x, 1.0 - p.y))
            .collect(),
    );
    mapped.colors = Some(round.positions.iter().map(|p| p.as_vec3().abs()).collect());
    let phong = |specular: f64, shininess: f64| Material::Phong {
        diffuse: Rgb::new(0.5, 0.25, 0.0),
        specular: Rgb::new(specular, 0.0, 0.1),
        shininess,
        textures: Textures::default(),
    };
    let object = |name: &str, mesh: &str, material: Option<&str>| Object {
        name: name.to_owned(),
        mesh: mesh.to_owned(),
        material: material.map(str::to_owned),
        ..Object::default()
    };
    let mut turned = object("c", "/a/x.glb#round", Some("matt"));
    turned.rotate = DVec3::new(20.0, -35.0, 110.0);
    turned.scale = -2.0;
    turned.translate = DVec3::new(0.1, 0.2, 0.3);
    let mut mirrored = object("d", "/a/x.glb#mapped", Some("mirror"));
    mirrored.smooth = true;
    Scene {
        objects: vec![
            object("a", "/a/x.glb#round", None),
            object("b", "/a/x.glb#round", Some("glass")),
            turned,
            mirrored,
            object("e", "/a/x.glb#round", Some("lamp")),
        ],
        meshes: [
            ("/a/x.glb#round".to_owned(), Arc::new(round)),
            ("/a/x.glb#mapped".to_owned(), Arc::new(mapped)),
        ]
        .into(),
        materials: [
            ("matt".to_owned(), phong(0.2, 60.0)),
            (
                "glass".to_owned(),
                Material::Glass {
                    ior: 1.33,
                    attenuation: Rgb::new(20.0, 0.5, 0.0),
                },
            ),
            (
                "mirror".to_owned(),
                Material::Mirror {
                    reflectance: Rgb::new(0.9, 0.8, 0.7),
                },
            ),
            (
                "lamp".to_owned(),
                Material::Emitter {
                    radiance: Rgb::new(17.0, 12.0, 4.0),
                },
            ),
        ]
        .into(),
        lights: vec![Light::Point {
            position: DVec3::new(1.0, 2.0, 3.0),
            intensity: Rgb::new(20.0, 10.0, 0.0),
        }],
        light_names: vec!["key".to_owned()],
        ..Scene::default()
    }
}

#[test]
fn what_is_written_reads_back_the_same() {
    let scene = full_scene();
    let camera = Camera {
        eye: DVec3::new(1.0, -5.0, 2.0),
        ..Camera::default()
    };
    let mut bytes = Vec::new();
    write(&scene, Some(&camera), &mut bytes).expect("a vector takes all");
    assert_eq!(losses(&scene), Vec::<String>::new());
    let mut load = |_: &str| Ok(None);
    let gltf = parse(&bytes, &mut load, &CancelToken::new(), &Progress::new());
    let gltf = gltf.expect("is right").expect("nobody cancels");
    assert_eq!(gltf.warnings, Vec::<String>::new());
    for (read, written) in gltf.objects.iter().zip(&scene.objects) {
        assert_eq!(
            (&read.name, &read.material, read.smooth),
            (&written.name, &written.material, written.smooth)
        );
        assert_eq!(*gltf.parts[&read.mesh], *scene.meshes[&written.mesh]);
        let (a, b) = (read.placement(), written.placement());
        assert!(
            a.linear.abs_diff_eq(b.linear, 1e-14) && a.translate == b.translate,
            "{}",
            read.name
        );
    }
    assert_eq!(gltf.objects.len(), 5);
    let colors = |material: &Material| match material {
        Material::Phong {
            diffuse,
            specular,
            shininess,
            ..
        } => (0, *diffuse, *specular, *shininess),
        Material::Mirror { reflectance } => (1, *reflectance, Rgb::ZERO, 0.0),
        Material::Glass { ior, attenuation } => (2, *attenuation, Rgb::ZERO, *ior),
        Material::Emitter { radiance } => (3, *radiance, Rgb::ZERO, 0.0),
    };
    for (name, material) in &gltf.materials {
        let (kind, a, b, c) = colors(material);
        let (expected_kind, x, y, z) = colors(&scene.materials[name]);
        assert_eq!(kind, expected_kind, "{name}");
        assert!(
            (a - x).length() < 1e-12 && (b - y).length() < 1e-12 && (c - z).abs() < 1e-9,
            "{name} {material:?}"
        );
    }
    assert_eq!(gltf.materials.len(), 4);
    assert_eq!(gltf.lights, scene.named_lights());
    let (read, written) = (gltf.camera.and_then(|camera| camera.axes()), camera.axes());
    let (read, written) = (read.expect("there is one"), written.expect("it looks"));
    assert!(
        (read.forward - written.forward).length() < 1e-14
            && (read.up - written.up).length() < 1e-14
    );

    let mut fine = scene;
    let mut mesh = shapes::icosphere(1);
    mesh.positions[0].x = 0.1;
    fine.meshes.insert("/a/x.glb#round".into(), Arc::new(mesh));
    assert_eq!(
        losses(&fine),
        ["positions are rounded to 32 bits, as glTF holds them"]
    );
}
