//! Materials, and the images that they wear.

use super::*;

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
