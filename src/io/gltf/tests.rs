mod materials;
mod writing;

use super::*;
use crate::geometry::shapes;
use crate::io::mesh_reading::trials;
use crate::math::{DMat3, DVec2, DVec3, Degrees, Vec3};
use crate::scene::{Facing, Light, Rgb};

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
    let lights: Vec<_> = gltf.lights.iter().map(|named| named.light).collect();
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
    ] = &lights[..]
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

/// Each takes its vertices anew, and a file says it in some bytes.
#[test]
fn one_primitive_again_and_again_is_refused_where_it_makes_too_much() {
    let primitive = r#"{"attributes":{"POSITION":0}}"#;
    let document = |times: usize| {
        let primitives = vec![primitive; times].join(",");
        format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
            "meshes":[{{"primitives":[{primitives}]}}],
            "accessors":[{{"componentType":5126,"count":100000,"type":"VEC3"}}]}}"#
        )
    };
    assert!(read(&document(1), &[]).is_ok());
    let error = read(&document(1000), &[]).expect_err("is too much");
    let expected = "no more elements than a file of this size accounts for";
    assert!(error.to_string().contains(expected), "{error}");
}

#[test]
fn random_mutations_never_panic() {
    let mut written = Vec::new();
    write(&writing::full_scene(), None, &mut written).expect("a vector takes all");
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
