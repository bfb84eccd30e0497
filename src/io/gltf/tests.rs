use super::*;
use crate::geometry::shapes;
use crate::io::mesh_reading::trials;
use crate::math::{DMat3, DVec2, DVec3, Degrees, Vec3};
use crate::scene::{Facing, Rgb};

/// Reads a document whose first buffer is `binary`.
fn read(json: &str, binary: &[u8]) -> Result<Gltf, Malformed> {
    let bytes = glb(json, binary);
    let progress = Progress::new();
    let mut load = |name: &str| Err(format!("{name} is not there"));
    let read = parse(&bytes, &mut load, &CancelToken::new(), &progress)?;
    assert_eq!(progress.done(), bytes.len() as u64);
    let gltf = read.expect("nobody cancels");
    for mesh in gltf.parts.values() {
        assert_eq!(mesh.validate(), Ok(()));
    }
    Ok(gltf)
}

fn glb(json: &str, binary: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let word = |length: usize| u32::try_from(length).expect("is short").to_le_bytes();
    let length = 12 + 8 + json.len() + 8 + binary.len();
    let parts: [&[u8]; 9] = [
        b"glTF",
        &2_u32.to_le_bytes(),
        &word(length),
        &word(json.len()),
        b"JSON",
        &json,
        &word(binary.len()),
        b"BIN\0",
        binary,
    ];
    parts.concat()
}

fn floats(values: &[f32]) -> Vec<u8> {
    values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect()
}

/// Four corners of a square, as floats, and its two triangles, as bytes: 48 and 6 bytes.
fn square() -> Vec<u8> {
    let mut binary = floats(&[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]);
    binary.extend([0, 1, 2, 0, 2, 3, 0, 0]);
    binary
}

/// A document of a square with these nodes, and what else it says.
fn of_square(nodes: &str, more: &str) -> String {
    let comma = if more.is_empty() { "" } else { "," };
    format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{nodes}],
        "meshes":[{{"name":"square","primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}},
                     {{"bufferView":1,"componentType":5121,"count":6,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":6}}],
        "buffers":[{{"byteLength":56}}]{comma}{more}}}"#
    )
}

fn read_square(nodes: &str, more: &str) -> Gltf {
    let json = of_square(nodes, more);
    read(&json, &square()).unwrap_or_else(|error| panic!("{error} in {json}"))
}

/// The corners of the triangles of an object, in the world.
fn corners(gltf: &Gltf, object: usize) -> Vec<[DVec3; 3]> {
    let object = &gltf.objects[object];
    let mesh = &gltf.parts[&object.mesh];
    let placement = object.placement();
    let corners = (0..mesh.triangles.len()).map(|index| mesh.corners(index));
    corners
        .map(|corners| corners.map(|corner| placement.world_from_object(corner)))
        .collect()
}

fn close(a: &[[DVec3; 3]], b: &[[DVec3; 3]]) -> bool {
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    a.len() == b.len() && pairs.into_iter().all(|(a, b)| (*a - *b).length() < 1e-12)
}

#[test]
fn nodes_place_meshes_and_share_them() {
    let half = 0.5_f64.sqrt();
    let gltf = read_square(
        &format!(
            r#"{{"name":"root","translation":[10,0,0],"rotation":[0,0,{half},{half}],"scale":[2,2,2],"children":[1,2]}},
            {{"name":"a","mesh":0}},
            {{"mesh":0,"matrix":[0,1,0,0, -1,0,0,0, 0,0,1,0, 0,0,5,1]}}"#
        ),
        "",
    );
    assert_eq!(gltf.warnings, Vec::<String>::new());
    let names: Vec<_> = gltf
        .objects
        .iter()
        .map(|object| (object.name.as_str(), object.mesh.as_str()))
        .collect();
    assert_eq!(names, [("a", "square"), ("square", "square")]);
    assert_eq!(gltf.parts.len(), 1);
    assert_eq!((gltf.nodes, gltf.faces), (3, 2));
    // A quarter turn about Z, twice as large, moved.
    let world = |p: DVec3| DVec3::new(10.0 - 2.0 * p.y, 2.0 * p.x, 2.0 * p.z);
    let inner = |p: DVec3| DVec3::new(-p.y, p.x, p.z + 5.0);
    let mesh = &gltf.parts["square"];
    let expected =
        |place: &dyn Fn(DVec3) -> DVec3| [0, 1].map(|index| mesh.corners(index).map(place));
    assert!(close(&corners(&gltf, 0), &expected(&world)));
    assert!(close(&corners(&gltf, 1), &expected(&|p| world(inner(p)))));
    assert_eq!(gltf.objects[0].rotate, DVec3::Z * 90.0);
    assert_eq!(gltf.objects[0].scale, 2.0);
}

/// What rotation, even scale and translation cannot do is done to the vertices, and triangles still face the same way.
#[test]
fn uneven_transforms_are_worked_into_the_vertices() {
    let gltf = read_square(
        r#"{"name":"wide","mesh":0,"scale":[-3,1,1],"translation":[0,0,2]},{"mesh":0,"scale":[-1,-1,-1]},{"mesh":0,"scale":[0,1,1]}"#,
        "",
    );
    assert_eq!(gltf.objects[0].mesh, "square@wide");
    assert_eq!(gltf.objects[0].placement().linear, DMat3::IDENTITY);
    let moved = corners(&gltf, 0);
    let area: f64 = moved
        .iter()
        .map(|[a, b, c]| (*b - *a).cross(*c - *a).z / 2.0)
        .sum();
    assert_eq!(area, 3.0, "seen from above as before");
    assert!(
        moved
            .as_flattened()
            .iter()
            .all(|p| p.z == 2.0 && (-3.0..=0.0).contains(&p.x))
    );
    // A mirrored node is an object of negative scale.
    assert_eq!(
        (gltf.objects[1].mesh.as_str(), gltf.objects[1].scale),
        ("square", -1.0)
    );
    // Nothing is left of the flat one.
    assert_eq!(gltf.parts["square@2"].triangles, [[0; 3]; 0]);
}

#[test]
fn primitives_make_parts_by_material_and_strips_and_fans_are_cut() {
    let json = r#"{"asset":{"version":"2.0"},"nodes":[{"name":"n","mesh":0}],
        "materials":[{"name":"red"},{"name":"red"}],
        "meshes":[{"name":"m","primitives":[
            {"attributes":{"POSITION":0},"mode":5,"material":1},
            {"attributes":{"POSITION":0},"mode":6},
            {"attributes":{"POSITION":0},"indices":1,"material":1},
            {"attributes":{"POSITION":0},"mode":1}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},
                     {"bufferView":0,"byteOffset":48,"componentType":5121,"count":3,"type":"SCALAR"}],
        "bufferViews":[{"buffer":0,"byteLength":54}],"buffers":[{"byteLength":56}]}"#;
    let gltf = read(json, &square()).expect("is right");
    let objects: Vec<_> = gltf
        .objects
        .iter()
        .map(|o| (o.name.as_str(), o.mesh.as_str(), o.material.as_deref()))
        .collect();
    let expected = [("n/red", "m/red", Some("red")), ("n/", "m/", None)];
    assert_eq!(objects, expected);
    // The strip's second triangle is turned; then that of the indices, of vertices of its own.
    assert_eq!(
        gltf.parts["m/red"].triangles,
        [[0, 1, 2], [1, 3, 2], [4, 5, 6]]
    );
    // The fan begins with its second corner.
    assert_eq!(gltf.parts["m/"].triangles, [[0, 1, 2], [1, 3, 2]]);
    assert_eq!(
        gltf.warnings,
        ["1 mesh has lines or points, which are ignored (meshes[0])"]
    );
}

#[test]
fn attributes_are_read_in_every_type() {
    // Positions as normalised shorts with a stride, normals as bytes, coordinates as words, colours with alpha.
    let mut binary = Vec::new();
    for (x, y) in [(0_i16, 0_i16), (32767, 0), (0, 32767)] {
        for value in [x, y, -32768, 99] {
            binary.extend(value.to_le_bytes());
        }
    }
    binary.extend([0, 0, 127, 9, 0, 0, 127, 9, 0, 0, 127, 9]);
    for value in [0_u16, 0, 65535, 0, 0, 65535] {
        binary.extend(value.to_le_bytes());
    }
    binary.extend([255, 0, 0, 7, 0, 255, 0, 7, 0, 0, 51, 7]);
    let json = r#"{"asset":{"version":"2.0"},"extensionsRequired":["KHR_mesh_quantization"],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2,"COLOR_0":3}}]}],
        "accessors":[{"bufferView":0,"componentType":5122,"normalized":true,"count":3,"type":"VEC3"},
                     {"bufferView":1,"componentType":5120,"normalized":true,"count":3,"type":"VEC3"},
                     {"bufferView":2,"componentType":5123,"normalized":true,"count":3,"type":"VEC2"},
                     {"bufferView":3,"componentType":5121,"normalized":true,"count":3,"type":"VEC4"}],
        "bufferViews":[{"buffer":0,"byteLength":24,"byteStride":8},{"buffer":0,"byteOffset":24,"byteLength":12,"byteStride":4},
                       {"buffer":0,"byteOffset":36,"byteLength":12},{"buffer":0,"byteOffset":48,"byteLength":12}],
        "buffers":[{"byteLength":60}]}"#;
    let gltf = read(json, &binary).expect("is right");
    let mesh = &gltf.parts["mesh 0"];
    assert_eq!(
        mesh.positions,
        [
            DVec3::new(0.0, 0.0, -1.0),
            DVec3::new(1.0, 0.0, -1.0),
            DVec3::new(0.0, 1.0, -1.0)
        ]
    );
    assert_eq!(mesh.normals, Some(vec![DVec3::Z; 3]));
    // Images begin at the top there.
    assert_eq!(
        mesh.texture_coordinates,
        Some(vec![DVec2::new(0.0, 1.0), DVec2::ONE, DVec2::ZERO])
    );
    assert_eq!(mesh.colors, Some(vec![Vec3::X, Vec3::Y, Vec3::Z * 0.2]));
    assert!(gltf.objects[0].smooth);
}

#[test]
fn sparse_accessors_replace_values() {
    let mut binary = square();
    binary.extend([2, 0, 0, 0]);
    binary.extend(floats(&[7., 8., 9.]));
    let json = of_square(r#"{"mesh":0}"#, "").replace(
        r#""count":4,"type":"VEC3""#,
        r#""count":4,"type":"VEC3","sparse":{"count":1,"indices":{"bufferView":2,"componentType":5121},"values":{"bufferView":2,"byteOffset":4}}"#,
    );
    let json = json.replace(
        r#""byteLength":6}]"#,
        r#""byteLength":6},{"buffer":0,"byteOffset":56,"byteLength":16}]"#,
    );
    let gltf = read(&json, &binary).expect("is right");
    assert_eq!(gltf.parts["square"].positions[2], DVec3::new(7.0, 8.0, 9.0));
    assert_eq!(gltf.parts["square"].positions[1], DVec3::X);
    // Without a view, all values but those are 0.
    let json = json.replace(
        r#""bufferView":0,"componentType":5126"#,
        r#""componentType":5126"#,
    );
    let gltf = read(&json, &binary).expect("is right");
    assert_eq!(gltf.dropped.degenerate, 2);
}

#[test]
fn lights_and_the_camera_are_placed() {
    let half = 0.5_f64.sqrt();
    // The nodes look down: -Z turned by -90° about X.
    let turn = format!(r#""rotation":[{},0,0,{half}]"#, -half);
    let light =
        |index: u32| format!(r#""extensions":{{"KHR_lights_punctual":{{"light":{index}}}}}"#);
    let gltf = read_square(
        &format!(
            r#"{{"mesh":0}},{{"translation":[1,2,3],{}}},{{"translation":[0,4,0],{turn},{}}},{{{turn},{}}},
            {{"camera":1}},{{"translation":[0,7,0],{turn},"camera":0}}"#,
            light(0),
            light(1),
            light(2)
        ),
        r#""extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","color":[1,0.5,0],"intensity":20},
            {"type":"spot","intensity":30,"spot":{}},{"type":"directional","intensity":3}]}},
           "cameras":[{"type":"perspective","perspective":{"yfov":0.5,"znear":0.1}},{"type":"orthographic","orthographic":{}}]"#,
    );
    let [
        Light::Point {
            position,
            intensity,
        },
        Light::Disk {
            center,
            facing: Facing::Normal(normal),
            radius,
            radiance,
            visible: false,
        },
        Light::Point {
            position: far,
            intensity: strong,
        },
    ] = &gltf.lights[..]
    else {
        panic!("{:?}", gltf.lights);
    };
    assert_eq!(
        (*position, *intensity),
        (DVec3::new(1.0, 2.0, 3.0), Rgb::new(20.0, 10.0, 0.0))
    );
    assert_eq!(*center, DVec3::Y * 4.0);
    assert!((*normal + DVec3::Y).length() < 1e-15);
    // Radiance times area is the intensity along the axis.
    assert!((radiance.x * std::f64::consts::PI * radius * radius - 30.0).abs() < 1e-12);
    // Far from the square, however large that is.
    let from_square = *far - DVec3::new(0.5, 0.5, 0.0);
    assert!((strong.x / from_square.length_squared() - 3.0).abs() < 1e-12);
    assert!((from_square.y / 2.0_f64.sqrt() - 1e4).abs() < 1e-8);
    let camera = gltf.camera.expect("there is one");
    assert_eq!(
        (camera.eye, camera.vertical_fov),
        (DVec3::Y * 7.0, Degrees(0.5_f64.to_degrees()))
    );
    let axes = camera.axes().expect("looks somewhere");
    assert!((axes.forward + DVec3::Y).length() < 1e-15 && (axes.up + DVec3::Z).length() < 1e-15);
    assert_eq!(gltf.warnings.len(), 3);
}

/// The material of a square that says this, and what is warned of.
fn material(says: &str) -> (Material, Vec<String>) {
    let json = of_square(
        r#"{"mesh":0}"#,
        &format!(r#""materials":[{{"name":"m"{says}}}]"#),
    );
    let json = json.replace(r#""indices":1"#, r#""indices":1,"material":0"#);
    let gltf = read(&json, &square()).unwrap_or_else(|error| panic!("{error} in {json}"));
    (gltf.materials["m"].clone(), gltf.warnings)
}

fn pbr(values: &str) -> String {
    format!(r#","pbrMetallicRoughness":{{{values}}}"#)
}

#[test]
fn materials_become_the_nearest_of_the_scene() {
    let phong = |says: &str| match material(says) {
        (
            Material::Phong {
                diffuse,
                specular,
                shininess,
                ..
            },
            _,
        ) => (diffuse, specular, shininess),
        other => panic!("{other:?}"),
    };
    let near = |a: Rgb, b: [f64; 3]| assert!((a - Rgb::from(b)).length() < 1e-15, "{a} {b:?}");
    // Plastic: 0.04 is reflected, the rest is diffuse.
    let (diffuse, specular, shininess) = phong(&pbr(
        r#""baseColorFactor":[0.5,0.25,0,1],"metallicFactor":0,"roughnessFactor":0.5"#,
    ));
    near(diffuse, [0.48, 0.24, 0.0]);
    near(specular, [0.04; 3]);
    assert_eq!(shininess, 7.5, "(1/0.5⁴ − 1)/2");
    // Half metal.
    let (diffuse, specular, shininess) = phong(&pbr(
        r#""baseColorFactor":[0.5,0.25,0,1],"metallicFactor":0.5"#,
    ));
    near(diffuse, [0.24, 0.12, 0.0]);
    near(specular, [0.27, 0.145, 0.02]);
    assert_eq!(shininess, 0.0);
    let (_, specular, _) = phong(&format!(
        r#"{},"extensions":{{"KHR_materials_specular":{{"specularFactor":0.5,"specularColorFactor":[1,0,5]}}}}"#,
        pbr(r#""metallicFactor":0"#)
    ));
    near(specular, [0.02, 0.0, 0.1]);

    let mirror = material(&pbr(
        r#""baseColorFactor":[0.9,0.8,0.7,1],"roughnessFactor":0.01"#,
    ))
    .0;
    assert_eq!(
        mirror,
        Material::Mirror {
            reflectance: Rgb::new(0.9, 0.8, 0.7)
        }
    );
    let glass = material(r#","extensions":{"KHR_materials_transmission":{"transmissionFactor":1},"KHR_materials_ior":{"ior":1.3},
        "KHR_materials_volume":{"attenuationDistance":2,"attenuationColor":[1,0.5,0]}}"#).0;
    let Material::Glass {
        ior: 1.3,
        attenuation,
    } = glass
    else {
        panic!("{glass:?}")
    };
    // After 2 units, half of the green is left.
    assert_eq!(attenuation.x, 0.0);
    assert!(((-2.0 * attenuation.y).exp() - 0.5).abs() < 1e-15 && attenuation.z > 6.0);
    let emitter = material(r#","emissiveFactor":[1,0.5,0],"extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":8}}"#).0;
    assert_eq!(
        emitter,
        Material::Emitter {
            radiance: Rgb::new(8.0, 4.0, 0.0)
        }
    );

    let (_, warnings) = material(&format!(
        r#"{},"emissiveFactor":[0.1,0,0],"alphaMode":"BLEND""#,
        pbr(r#""metallicFactor":0,"metallicRoughnessTexture":{"index":0}"#)
    ));
    let said = [
        "metal and roughness by an image are not shown; it is taken for no metal",
        "shines less than it reflects; it only reflects here",
        "lets light through without being glass; it is opaque here",
    ];
    assert_eq!(warnings, said.map(|what| format!("material \"m\": {what}")));
}

#[test]
fn images_are_named_as_files_or_by_their_number() {
    let says = format!(
        r#"{},"normalTexture":{{"index":1}}"#,
        pbr(r#""baseColorTexture":{"index":0}"#)
    );
    let json = of_square(
        r#"{"mesh":0}"#,
        &format!(
            r#""materials":[{{"name":"m"{says}}}],"textures":[{{"source":1}},{{"source":0}}],
        "images":[{{"uri":"my%20normals.png"}},{{"bufferView":1,"mimeType":"image/png"}},{{"uri":"data:image/png;base64,AAEC"}}]"#
        ),
    );
    let json = json.replace(r#""indices":1"#, r#""indices":1,"material":0"#);
    let gltf = read(&json, &square()).expect("is right");
    let textures = gltf.materials["m"].textures().expect("is Phong");
    let images: Vec<_> = textures.images().collect();
    assert_eq!(images, ["#image 1", "my normals.png"]);
    assert_eq!(within(images[0]).and_then(image_number), Some(1));
    let bytes = glb(&json, &square());
    let mut load = |name: &str| Err(format!("{name} is not there"));
    let mut file = ImageFile::new(bytes).expect("is right");
    let mut image = |number| file.image(number, &mut load);
    assert_eq!(image(1), Ok(Some(vec![0, 1, 2, 0, 2, 3])));
    assert_eq!(image(2), Ok(Some(vec![0, 1, 2])));
    assert!(image(0).is_err() && image(3).is_err());
}

/// Other files with images are read once, however many images they hold.
#[test]
fn buffers_of_images_are_read_once() {
    let json = of_square(
        r#"{"mesh":0}"#,
        r#""images":[{"bufferView":0},{"bufferView":1},{"bufferView":0}]"#,
    );
    let json = json.replace(r#""byteLength":56"#, r#""uri":"a.bin","byteLength":56"#);
    let mut asked = 0;
    let mut load = |_: &str| {
        asked += 1;
        Ok(Some(square()))
    };
    let mut file = ImageFile::new(json.into_bytes()).expect("is right");
    for number in [1, 0, 2] {
        let bytes = file.image(number, &mut load).expect("is there");
        let expected = if number == 1 {
            &square()[48..54]
        } else {
            &square()[..48]
        };
        assert_eq!(bytes.as_deref(), Some(expected));
    }
    assert_eq!(asked, 1);
}

/// A square whose corners lie on the image as in space, with a material that says `texture` of its image.
fn mapped_square(texture: &str) -> (Vec<DVec2>, Vec<String>) {
    let json = of_square(
        r#"{"mesh":0}"#,
        &format!(
            r#""materials":[{{"name":"m"{}}}],"textures":[{{"source":0,"sampler":0}}],"images":[{{"uri":"a.png"}}],
            "samplers":[{{"wrapS":10497}},{{"wrapT":33071}}]"#,
            pbr(&format!(r#""baseColorTexture":{{"index":0{texture}}}"#))
        ),
    );
    let json = json
        .replace(r#""POSITION":0}"#, r#""POSITION":0,"TEXCOORD_0":2},"material":0"#)
        .replace(
            r#""count":6,"type":"SCALAR"}"#,
            r#""count":6,"type":"SCALAR"},{"bufferView":2,"componentType":5126,"count":4,"type":"VEC2"}"#,
        )
        .replace(
            r#""byteOffset":48,"byteLength":6}"#,
            r#""byteOffset":48,"byteLength":6},{"buffer":0,"byteLength":48,"byteStride":12}"#,
        );
    let gltf = read(&json, &square()).unwrap_or_else(|error| panic!("{error} in {json}"));
    let mesh = &gltf.parts["square"];
    (
        mesh.texture_coordinates.clone().expect("some"),
        gltf.warnings,
    )
}

/// In the file the origin is the image's upper left corner and v points down; here it is the lower left one.
#[test]
fn images_are_where_they_are_moved() {
    let transform = |says: &str| {
        mapped_square(&format!(
            r#","extensions":{{"KHR_texture_transform":{{{says}}}}}"#
        ))
        .0
    };
    let near = |found: &[DVec2], expected: [(f64, f64); 4]| {
        for (found, (u, v)) in found.iter().zip(expected) {
            let expected = DVec2::new(u, 1.0 - v);
            assert!((*found - expected).length() < 1e-12, "{found} {expected}");
        }
    };
    near(
        &mapped_square("").0,
        [(0., 0.), (1., 0.), (1., 1.), (0., 1.)],
    );
    near(&transform(""), [(0., 0.), (1., 0.), (1., 1.), (0., 1.)]);
    near(
        &transform(r#""offset":[0.5,2]"#),
        [(0.5, 2.), (1.5, 2.), (1.5, 3.), (0.5, 3.)],
    );
    near(
        &transform(r#""scale":[2,0.5]"#),
        [(0., 0.), (2., 0.), (2., 0.5), (0., 0.5)],
    );
    // A quarter counter-clockwise: what lay to the right now lies upwards, which is −v.
    let quarter = r#""rotation":1.5707963267948966"#;
    near(
        &transform(quarter),
        [(0., 0.), (0., -1.), (1., -1.), (1., 0.)],
    );
    let all = format!(r#"{quarter},"scale":[2,3],"offset":[10,20]"#);
    near(
        &transform(&all),
        [(10., 20.), (10., 18.), (13., 18.), (13., 20.)],
    );
}

#[test]
fn what_of_images_is_not_heeded_is_said() {
    assert_eq!(mapped_square("").1, Vec::<String>::new());
    let textures = r#""textures":[{"source":0,"sampler":0}],"images":[{"uri":"a.png"}],"samplers":[{"wrapS":33071}]"#;
    let material = |says: &str| {
        let json = of_square(
            r#"{"mesh":0}"#,
            &format!(r#""materials":[{{"name":"m"{says}}}],{textures}"#),
        );
        let json = json.replace(r#""indices":1"#, r#""indices":1,"material":0"#);
        read(&json, &square()).expect("is right").warnings
    };
    let ends =
        "material \"m\": has an image that ends or is mirrored at its edges; it repeats here";
    assert_eq!(material(&pbr(r#""baseColorTexture":{"index":0}"#)), [ends]);
    assert_eq!(
        material(r#","normalTexture":{"index":0,"scale":0.5}"#),
        [
            "material \"m\": has normals that are to be made steeper or flatter, which is not heeded",
            ends,
        ]
    );
    let moved =
        r#""baseColorTexture":{"index":0,"extensions":{"KHR_texture_transform":{"scale":[2,2]}}}"#;
    let both = format!(r#"{},"normalTexture":{{"index":0}}"#, pbr(moved));
    assert_eq!(
        material(&both)[0],
        "material \"m\": has an image of normals that is moved otherwise than that of colours; both are moved alike here"
    );
}

#[test]
fn older_files_say_what_is_glossy() {
    let glossy = r#","extensions":{"KHR_materials_pbrSpecularGlossiness":
        {"diffuseFactor":[0.8,0.4,0.2,1],"specularFactor":[0.5,0.25,0],"glossinessFactor":0.5}}"#;
    let (found, warnings) = material(glossy);
    let Material::Phong {
        diffuse,
        specular,
        shininess,
        ..
    } = found
    else {
        panic!("{found:?}");
    };
    assert_eq!(
        (diffuse, specular),
        (Rgb::new(0.4, 0.2, 0.1), Rgb::new(0.5, 0.25, 0.0))
    );
    // Roughness 0.5: (1/0.5⁴ − 1)/2.
    assert_eq!((shininess, warnings), (7.5, Vec::new()));
}

#[test]
fn what_is_compressed_is_refused_by_name() {
    let error = |json: String| read(&json, &square()).expect_err("is refused").to_string();
    let needs = |name: &str| {
        error(of_square(
            "",
            &format!(r#""extensionsRequired":["{name}"]"#),
        ))
    };
    let begin = "line 1: expected a file that needs no extension unknown here, found that it needs";
    for (name, why) in [
        (
            "KHR_draco_mesh_compression",
            ": compressed meshes are not read",
        ),
        (
            "EXT_meshopt_compression",
            ": compressed meshes are not read",
        ),
        ("KHR_texture_basisu", ": images of this format are not read"),
        ("ACME_teapots", ""),
    ] {
        assert_eq!(needs(name), format!("{begin} {name}{why}"));
    }
    // Used and not needed, but nothing else is there.
    let json = of_square(r#"{"mesh":0}"#, "")
        .replace(r#"{"bufferView":0,"#, "{")
        .replace(
            r#""indices":1"#,
            r#""indices":1,"extensions":{"KHR_draco_mesh_compression":{"bufferView":1}}"#,
        );
    assert_eq!(
        error(json),
        "meshes[0]: expected a mesh that is not compressed, found one compressed by Draco"
    );
    let json = of_square(
        r#"{"mesh":0}"#,
        r#""extensionsUsed":["EXT_meshopt_compression"]"#,
    )
    .replace(
        r#"{"byteLength":56}"#,
        r#"{"byteLength":56},{"byteLength":99}"#,
    );
    assert_eq!(
        error(json),
        "buffers[1]: expected a buffer with a uri, found none, as the meshes are compressed by meshopt"
    );
}

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

/// A node begins in three bytes, and takes many more.
#[test]
fn memory_is_foreseen_of_many_small_records() {
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{{}}{}]}}"#,
        ",{}".repeat(9999)
    );
    let foreseen = memory_of_records(json.as_bytes());
    let of_nodes = 10_000 * (size_of::<document::Node>() + size_of::<Placed>()) as u64;
    assert!(
        foreseen > 2 * of_nodes && foreseen < 20 * of_nodes,
        "{foreseen} {of_nodes}"
    );
    assert_eq!(memory_of_records(&glb(&json, &[b'{'; 100])), foreseen);
}

#[test]
fn buffers_are_in_the_text_or_in_files() {
    let data = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAAAAgD8AAAAAAAECAAIDAAA=";
    let text = |uri: &str| {
        of_square(r#"{"mesh":0}"#, "").replace(
            r#""byteLength":56"#,
            &format!(r#""uri":"{uri}","byteLength":56"#),
        )
    };
    let mut asked = Vec::new();
    for uri in [
        &format!("data:application/octet-stream;base64,{data}"),
        "my%20square.bin",
    ] {
        let mut load = |name: &str| {
            asked.push(name.to_owned());
            Ok(Some(square()))
        };
        let read = parse(
            text(uri).as_bytes(),
            &mut load,
            &CancelToken::new(),
            &Progress::new(),
        );
        let gltf = read.expect("is right").expect("nobody cancels");
        assert_eq!(gltf.parts["square"].triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(gltf.parts["square"].positions[2], DVec3::new(1.0, 1.0, 0.0));
    }
    assert_eq!(asked, ["my square.bin"]);
}

#[test]
#[expect(clippy::too_many_lines, reason = "a table of cases")]
fn what_is_wrong_is_named_with_its_place() {
    let square_json = of_square(r#"{"mesh":0}"#, "");
    let with = |from: &str, to: &str| {
        assert!(square_json.contains(from), "{from}");
        square_json.replace(from, to)
    };
    let cases = [
        (
            "{".to_owned(),
            "line 1: expected JSON of glTF, found EOF while parsing an object",
        ),
        (
            "{\n\"nodes\": 3}".into(),
            "line 2: expected a sequence, found integer `3`",
        ),
        (
            "{}".into(),
            "line 1: expected glTF of version 2, found version none",
        ),
        (
            with("2.0", "1.0"),
            "line 1: expected glTF of version 2, found version 1.0",
        ),
        (
            with(
                r#""nodes""#,
                r#""extensionsRequired":["KHR_draco_mesh_compression"],"nodes""#,
            ),
            "line 1: expected a file that needs no extension unknown here, found that it needs KHR_draco_mesh_compression: compressed meshes are not read",
        ),
        (
            with(r#"{"mesh":0}"#, r#"{"mesh":9}"#),
            "meshes[9]: expected one of 1 meshes, found none of that number",
        ),
        (
            with(r#"{"mesh":0}"#, r#"{"children":[0]}"#),
            "the scene has no meshes",
        ),
        (
            with(r#"{"mesh":0}"#, r#"{"children":[1,1]},{}"#),
            "nodes[1]: expected a node with one parent, found another one",
        ),
        (
            with(r#""nodes""#, r#""scenes":[{"nodes":[0,0]}],"nodes""#),
            "nodes[0]: expected a node with one parent, found another one",
        ),
        (
            with(r#"{"mesh":0}"#, r#"{"mesh":0,"translation":[1e999,0,0]}"#),
            "line 1: expected JSON of glTF, found number out of range",
        ),
        (
            with(
                r#"{"mesh":0}"#,
                r#"{"mesh":0,"scale":[1e200,1e200,1e200],"children":[1]},{"scale":[1e200,1,1]}"#,
            ),
            "nodes[1]: expected a transform of finite numbers, found others",
        ),
        (
            with(r#""count":6"#, r#""count":7"#),
            "accessors[1]: expected elements within the 6 bytes of its view, found bytes 0 to 7",
        ),
        (
            with(r#""count":6"#, r#""count":99999999999"#),
            "accessors[1]: expected no more elements than a file of this size accounts for, found 99999999999",
        ),
        (
            with(
                r#""byteOffset":48,"byteLength":6"#,
                r#""byteOffset":48,"byteLength":600"#,
            ),
            "bufferViews[1]: expected at most 56 bytes, those of its buffer, found bytes 48 to 648",
        ),
        (
            with(
                r#"{"buffer":0,"byteLength":48}"#,
                r#"{"buffer":0,"byteLength":48,"byteStride":4}"#,
            ),
            "bufferViews[0]: expected a stride of at least 12 bytes, found 4",
        ),
        (
            with(r#""count":4"#, r#""count":3"#),
            "accessors[1]: expected indices below 3, found 3",
        ),
        (
            with(r#""type":"VEC3""#, r#""type":"VEC2""#),
            "accessors[0]: expected positions of type VEC3, found those of type VEC2",
        ),
        (
            with("5126", "5130"),
            "accessors[0]: expected a component type from 5120 to 5126, found 5130",
        ),
        (
            with("5121", "5126"),
            "accessors[1]: expected indices of an unsigned type, found component type 5126",
        ),
        (
            with(r#""byteLength":56"#, r#""byteLength":57"#),
            "buffers[0]: expected 57 bytes, as its byteLength says, found 56",
        ),
        (
            with(r#""byteLength":56"#, r#""byteLength":56,"uri":"a.bin""#),
            "buffers[0]: expected the file \"a.bin\", found a.bin is not there",
        ),
        (
            with(r#""byteLength":56"#, r#""byteLength":56,"uri":"data:,a""#),
            "buffers[0]: expected data in base64, found data that is not in base64",
        ),
    ];
    for (json, expected) in cases {
        match read(&json, &square()) {
            Err(error) => assert_eq!(error.to_string(), expected, "{json}"),
            Ok(gltf) => assert_eq!(gltf.warnings, [expected], "{json}"),
        }
    }
}

#[test]
fn a_container_that_is_cut_is_refused() {
    let whole = glb(&of_square(r#"{"mesh":0}"#, ""), &square());
    let mut load = |_: &str| Ok(None);
    for length in 0..whole.len() {
        let read = parse(
            &whole[..length],
            &mut load,
            &CancelToken::new(),
            &Progress::new(),
        );
        assert!(read.is_err(), "{length}");
    }
    let cancel = CancelToken::new();
    cancel.cancel();
    assert!(matches!(
        parse(&whole, &mut load, &cancel, &Progress::new()),
        Ok(None)
    ));
}

/// However often a file says to read the same, it is read no more often than its size accounts for.
#[test]
fn many_copies_of_much_are_refused() {
    let mut binary = square();
    binary.resize(1 << 20, 0);
    let primitives: Vec<String> = (0..500)
        .map(|i| format!(r#"{{"attributes":{{"POSITION":0}},"indices":{}}}"#, i + 1))
        .collect();
    let accessors: Vec<String> = (0..500).map(|i| format!(r#"{{"bufferView":0,"byteOffset":{i},"componentType":5121,"count":1000000,"type":"SCALAR"}}"#)).collect();
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":1000,"type":"VEC3"}},{}],
        "bufferViews":[{{"buffer":0,"byteLength":1048576}}],"buffers":[{{"byteLength":1048576}}]}}"#,
        primitives.join(","),
        accessors.join(",")
    );
    let error = read(&json, &binary).expect_err("is too much").to_string();
    assert!(
        error.ends_with(
            "expected no more elements than a file of this size accounts for, found 1000000"
        ),
        "{error}"
    );
}

/// A scene with everything that a GLB holds.
fn full_scene() -> Scene {
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
    assert_eq!(gltf.lights, scene.lights);
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

#[test]
fn random_mutations_never_panic() {
    let mut written = Vec::new();
    write(&full_scene(), None, &mut written).expect("a vector takes all");
    let files = [
        glb(
            &of_square(r#"{"mesh":0,"rotation":[0,0,1,1]}"#, ""),
            &square(),
        ),
        of_square(r#"{"mesh":0}"#, "").into_bytes(),
        written,
    ];
    let scraps: [&[u8]; 14] = [
        b"",
        b"0",
        b"1",
        b"-1",
        b"4294967295",
        b"1e300",
        b"null",
        b"{}",
        b"[]",
        b",",
        b"\"",
        b"9",
        b"5121",
        b"\"VEC2\"",
    ];
    trials::for_mutations(&files, &scraps, |bytes| {
        let mut load = |_: &str| Ok(Some(square()));
        let read = parse(bytes, &mut load, &CancelToken::new(), &Progress::new());
        if let Ok(Some(gltf)) = read {
            for mesh in gltf.parts.values() {
                assert_eq!(mesh.validate(), Ok(()));
            }
            let _ = (gltf.scene(str::to_owned).bounds(), gltf.whole());
        }
        let images = ImageFile::new(bytes.to_vec());
        let _ = images.and_then(|mut images| images.image(0, &mut load));
    });
}
