//! Meshes of several materials as a user meets them: opened, told of, saved and found again, rendered.

use std::fs;
use std::path::Path;
use std::process::Command;

use raymini::control::{CancelToken, Progress};
use raymini::io::{LoadedScene, load_scene, load_scenes, override_scene, save_scene};
use raymini::math::DVec3;
use raymini::scene::{Material, Rgb, Scene, Textures};
use tempfile::TempDir;

/// Two squares beside each other, the second one in two triangles of different materials, and a triangle without material.
const OBJ: &str = "mtllib chair.mtl\n\
    v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nv 0 0 1\n\
    f 1 2 7\nusemtl wood\nf 1 2 3 4\nusemtl chrome\nf 2 5 6\nusemtl wood\nf 2 6 3\n";
const MTL: &str = "newmtl wood\nKd 0.6 0.4 0.2\nKs 0.1 0.1 0.1\nNs 60\nnewmtl chrome\nKd 0 0 0\nKs 0.9 0.9 0.9\nillum 3\nnewmtl unused\nKd 1 0 0\n";

fn folder(files: &[(&str, &str)]) -> TempDir {
    let folder = TempDir::new().expect("a folder");
    for (name, text) in files {
        fs::write(folder.path().join(name), text).expect("is written");
    }
    folder
}

fn load(path: &Path) -> LoadedScene {
    let progress = Progress::new();
    let loaded = load_scene(path, &CancelToken::new(), &progress);
    let loaded = loaded.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(progress.done(), progress.total());
    loaded.expect("nobody cancels")
}

fn error(path: &Path) -> String {
    let loaded = load_scene(path, &CancelToken::new(), &Progress::new());
    loaded.expect_err("is wrong").to_string()
}

fn raymini(folder: &TempDir, arguments: &[&str]) -> (bool, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_raymini"));
    let run = command.current_dir(folder.path()).args(arguments).output();
    let run = run.expect("starts");
    let text = |bytes| String::from_utf8(bytes).expect("is text");
    (run.status.success(), text(run.stdout), text(run.stderr))
}

/// Names of objects, their parts and their materials.
fn objects(scene: &Scene) -> Vec<(&str, &str, Option<&str>)> {
    let object = |object: &'_ raymini::scene::Object| {
        let part = object.mesh.rsplit('/').next().expect("a name");
        (
            object.name.clone(),
            part.to_owned(),
            object.material.clone(),
        )
    };
    let leak = |text: String| -> &'static str { text.leak() };
    let objects = scene.objects.iter().map(object);
    objects
        .map(|(name, part, material)| (leak(name), leak(part), material.map(leak)))
        .collect()
}

#[test]
fn a_mesh_of_several_materials_opens_as_an_object_for_each() {
    let folder = folder(&[("chair.obj", OBJ), ("chair.mtl", MTL)]);
    let LoadedScene { scene, warnings } = load(&folder.path().join("chair.obj"));
    assert_eq!(warnings, Vec::<String>::new());
    let expected = [
        ("chair", "chair.obj#", Some("clay")),
        ("wood", "chair.obj#wood", Some("wood")),
        ("chrome", "chair.obj#chrome", Some("chrome")),
    ];
    assert_eq!(objects(&scene), expected);
    assert_eq!(
        scene.materials["wood"],
        Material::Phong {
            diffuse: Rgb::new(0.6, 0.4, 0.2),
            specular: Rgb::splat(0.1),
            shininess: 60.0,
            textures: Textures::default(),
        }
    );
    let reflectance = Rgb::splat(0.9);
    assert_eq!(scene.materials["chrome"], Material::Mirror { reflectance });
    assert!(!scene.materials.contains_key("unused"));
    // Together they are the whole, each with the vertices it uses.
    let area = |index: usize| {
        let mesh = scene.mesh_of(&scene.objects[index]).expect("is loaded");
        let area = |triangle| {
            let [a, b, c] = mesh.corners(triangle);
            (b - a).cross(c - a).length() / 2.0
        };
        let triangles = 0..mesh.triangles.len();
        (triangles.map(area).sum::<f64>(), mesh.positions.len())
    };
    assert_eq!([0, 1, 2].map(area), [(0.5, 3), (1.5, 5), (0.5, 3)]);
    let (min, max) = (DVec3::ZERO, DVec3::new(2.0, 1.0, 1.0));
    assert_eq!((scene.bounds().min, scene.bounds().max), (min, max));
    assert_eq!(scene.camera.up, DVec3::Y);
}

/// An image of heights beside one of normals; the first is still good for colours.
#[test]
fn images_of_heights_are_no_normals() {
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n\
               usemtl bumpy\nf 1/1 2/1 3/1\nusemtl right\nf 1/1 3/1 2/1\n";
    let mtl = "newmtl bumpy\nmap_Kd heights.png\nmap_Bump heights.png\n\
               newmtl right\nnorm normals.png\n";
    let folder = folder(&[("a.obj", obj), ("a.mtl", mtl)]);
    let write = |name: &str, texels: [[u8; 3]; 2]| {
        let image = image::RgbImage::from_fn(2, 1, |x, _| image::Rgb(texels[x as usize]));
        image.save(folder.path().join(name)).expect("is written");
    };
    write("heights.png", [[90; 3], [160; 3]]);
    write("normals.png", [[128, 128, 255], [140, 128, 250]]);
    let LoadedScene { scene, warnings } = load(&folder.path().join("a.obj"));
    let [warning] = &warnings[..] else {
        panic!("{warnings:?}")
    };
    assert!(
        warning.contains("heights.png: this is an image of heights"),
        "{warning}"
    );
    let images = |name: &str| {
        let textures = scene.materials[name].textures().expect("is of Phong");
        let of = |image: &Option<String>| {
            let name = image.as_deref().map(Path::new);
            name.and_then(Path::file_name)
                .map(|name| name.to_string_lossy().into_owned())
        };
        [of(&textures.diffuse_image), of(&textures.normal_image)]
    };
    assert_eq!(images("bumpy"), [Some("heights.png".to_owned()), None]);
    assert_eq!(images("right"), [None, Some("normals.png".to_owned())]);
    assert_eq!(scene.textures.len(), 2);
}

/// Two triangles whose corners have texture coordinates of their own, each of an image, as `MeshLab` writes them.
const TWO_IMAGES: &str = "ply\nformat ascii 1.0\ncomment TextureFile red.png\ncomment TextureFile gone.png\n\
    element vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n\
    property list uchar int vertex_indices\nproperty list uchar float texcoord\nproperty int texnumber\nend_header\n\
    0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 6 0 0 1 0 1 1 0\n3 0 2 3 6 0 0 1 1 0 1 1\n";

#[test]
fn a_ply_file_wears_the_images_that_it_names() {
    let folder = folder(&[("two.ply", TWO_IMAGES)]);
    let red = image::RgbImage::from_pixel(1, 1, image::Rgb([255, 0, 0]));
    red.save(folder.path().join("red.png")).expect("is written");
    let LoadedScene { scene, warnings } = load(&folder.path().join("two.ply"));
    let expected = [
        ("red.png", "two.ply#red.png", Some("red.png")),
        ("gone.png", "two.ply#gone.png", Some("gone.png")),
    ];
    assert_eq!(objects(&scene), expected);
    let image = |name: &str| {
        let textures = scene.materials[name].textures().expect("is Phong");
        textures
            .diffuse_image
            .as_deref()
            .and_then(|image| scene.textures.get(image))
    };
    let red = image("red.png").expect("is there");
    assert_eq!(red.mean_color(), Rgb::X);
    assert_eq!(image("gone.png"), None);
    let [warning] = &warnings[..] else {
        panic!("{warnings:?}")
    };
    assert!(
        warning.contains("gone.png: there is no such file"),
        "{warning}"
    );

    let path = folder.path().join("saved.toml");
    save_scene(&scene, &path).expect("is written");
    let again = load(&path).scene;
    assert_eq!(objects(&again), expected);
    assert_eq!(again.meshes.len(), 2);
}

/// The file's surface, and all faces of its two tetrahedra, for glass.
#[test]
fn the_inner_faces_of_cells_are_a_part() {
    let mesh = "MeshVersionFormatted 2\nDimension 3\nVertices\n5\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n1 1 1 0\n\
                Tetrahedra\n2\n1 2 3 4 0\n5 2 3 4 0\nEnd\n";
    let text = "[[objects]]\nmesh = \"a.mesh\"\n[[objects]]\nmesh = \"a.mesh#inner\"\n";
    let folder = folder(&[
        ("a.mesh", mesh),
        ("a.toml", text),
        ("b.toml", "[[objects]]\nmesh = \"a.mesh#outer\"\n"),
    ]);
    let scene = load(&folder.path().join("a.toml")).scene;
    let triangles = |object: usize| {
        let mesh = scene.mesh_of(&scene.objects[object]).expect("is loaded");
        mesh.triangles.len()
    };
    assert_eq!((triangles(0), triangles(1)), (6, 7));
    let said = error(&folder.path().join("b.toml"));
    assert!(
        said.contains("there is no part \"outer\"; the file has \"inner\""),
        "{said}"
    );
    let alone = load(&folder.path().join("a.mesh#inner")).scene;
    assert_eq!(alone.triangle_count(), 7);
    // A surface has no such part.
    fs::write(
        folder.path().join("a.mesh"),
        mesh.replace(
            "Tetrahedra\n2\n1 2 3 4 0\n5 2 3 4 0",
            "Triangles\n1\n1 2 3 0",
        ),
    )
    .expect("is written");
    let said = error(&folder.path().join("a.toml"));
    assert!(
        said.contains("there is no part \"inner\"; the file has no parts"),
        "{said}"
    );
}

#[test]
fn a_saved_scene_finds_its_parts_again() {
    let folder = folder(&[("chair.obj", OBJ), ("chair.mtl", MTL)]);
    let opened = load(&folder.path().join("chair.obj")).scene;
    fs::create_dir(folder.path().join("scenes")).expect("is made");
    let path = folder.path().join("scenes/room.toml");
    save_scene(&opened, &path).expect("is written");
    let text = fs::read_to_string(&path).expect("is there");
    assert!(text.contains("mesh = \"../chair.obj#wood\""), "{text}");
    // The scene file holds the materials: no other file is needed.
    fs::remove_file(folder.path().join("chair.mtl")).expect("is there");
    let LoadedScene { scene, warnings } = load(&path);
    assert_eq!((&scene, warnings), (&opened, vec![]));

    // The whole mesh, a part, and both again, from one file.
    let text = "[[objects]]\nmesh = \"chair.obj#wood\"\n[[objects]]\nmesh = \"chair.obj\"\n\
                [[objects]]\nmesh = \"./chair.obj#wood\"\nscale = 2\n";
    let path = folder.path().join("three.toml");
    fs::write(&path, text).expect("is written");
    let mut loaded = load(&path);
    let triangles = |scene: &Scene| {
        let of = |object| scene.mesh_of(object).expect("is loaded").triangles.len();
        scene.objects.iter().map(of).collect::<Vec<_>>()
    };
    assert_eq!(triangles(&loaded.scene), [3, 5, 3]);
    assert_eq!(loaded.scene.meshes.len(), 2);
    assert_eq!(objects(&loaded.scene)[0].0, "wood");
    let chrome = format!(
        "objects.0.mesh=\"{}#chrome\"",
        folder.path().join("chair.obj").display()
    );
    override_scene(&mut loaded, &[chrome], &CancelToken::new()).expect("is right");
    assert_eq!(triangles(&loaded.scene), [1, 5, 3]);
}

#[test]
fn a_part_that_is_not_there_is_an_error_at_its_place() {
    let text = "[[objects]]\nmesh = \"chair.obj\"\n[[objects]]\nmesh = \"chair.obj#wod\"\n";
    let folder = folder(&[
        ("chair.obj", OBJ),
        ("a.toml", text),
        ("plain.obj", "v 0 0 0\n"),
    ]);
    let path = folder.path().join("a.toml");
    let expected = format!(
        "{}:4:8: {}: there is no part \"wod\"; the file has \"\", \"wood\", \"chrome\"",
        path.display(),
        folder.path().join("chair.obj").display()
    );
    assert_eq!(error(&path), expected);
    let plain = folder.path().join("plain.obj#a");
    assert!(
        error(&plain)
            .ends_with("there is no part \"a\"; the file has no parts of different materials")
    );
    // A file that is called so is meant.
    fs::write(folder.path().join("chair.obj#wod"), OBJ).expect("is written");
    assert_eq!(load(&path).scene.triangle_count(), 10);
}

#[test]
fn missing_materials_are_warned_of() {
    let one = "mtllib none.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let folder = folder(&[("chair.obj", OBJ), ("one.obj", one)]);
    let path = |name: &str| folder.path().join(name);
    let LoadedScene { scene, warnings } = load(&path("chair.obj"));
    let shown = path("chair.obj");
    let shown = shown.display();
    let expected = [
        format!(
            "{shown}:1: the file of materials \"chair.mtl\" is left out: there is no such file"
        ),
        format!(
            "{shown}: material \"wood\" and 1 more: is not defined in any file of materials that was read; it is grey"
        ),
    ];
    assert_eq!(warnings, expected);
    assert_eq!(scene.materials["wood"], Material::default());
    assert_eq!(scene.objects.len(), 3);

    // One material that is not known is like none.
    let LoadedScene { scene, warnings } = load(&path("one.obj"));
    assert_eq!(objects(&scene), [("one", "one.obj", Some("clay"))]);
    assert_eq!(warnings.len(), 2);
}

/// Two files with materials of the same names.
#[test]
fn materials_of_several_files_keep_apart() {
    let red = MTL.replace("0.6 0.4 0.2", "0.9 0 0");
    let other = OBJ.replace("chair.mtl", "other.mtl");
    let files = [
        ("chair.obj", OBJ),
        ("chair.mtl", MTL),
        ("other.obj", &other),
        ("other.mtl", &red),
    ];
    let folder = folder(&files);
    let paths = ["chair.obj", "other.obj"].map(|name| folder.path().join(name));
    let loaded = load_scenes(&paths, &CancelToken::new(), &Progress::new());
    let scene = loaded.expect("is right").expect("nobody cancels").scene;
    let materials: Vec<_> = scene.materials.keys().map(String::as_str).collect();
    assert_eq!(materials, ["chrome", "clay", "wood", "wood 2"]);
    let worn: Vec<_> = objects(&scene)
        .into_iter()
        .map(|(name, _, material)| (name, material))
        .collect();
    assert_eq!(worn[4], ("wood 2", Some("wood 2")));
    assert_eq!(worn[5], ("chrome 2", Some("chrome")));
}

#[test]
fn info_tells_of_parts_and_materials() {
    let folder = folder(&[("chair.obj", OBJ), ("chair.mtl", MTL)]);
    let (_, said, _) = raymini(&folder, &["info", "chair.obj"]);
    for line in [
        "  vertices    7",
        "  faces       4, 1 of them with more than three corners",
        "  triangles   5",
        "  object      chair: 1 triangle",
        "  object      wood: 3 triangles, material wood",
        "  material    chrome: mirror",
        "  material    wood: phong",
    ] {
        assert!(said.lines().any(|said| said == line), "{line}\n{said}");
    }
    let (_, said, _) = raymini(&folder, &["info", "--json", "chair.obj"]);
    let facts: serde_json::Value = serde_json::from_str(&said).expect("is JSON");
    assert_eq!(facts["format"], "OBJ");
    assert_eq!(facts["triangles"], 5);
    assert_eq!(facts["objects"][2]["material"], "chrome");
    assert_eq!(facts["materials"][0]["kind"], "mirror");
}

/// The picture of the opened mesh is that of its saved scene, bit for bit.
#[test]
fn parts_are_rendered() {
    let folder = folder(&[("chair.obj", OBJ), ("chair.mtl", MTL)]);
    save_scene(
        &load(&folder.path().join("chair.obj")).scene,
        &folder.path().join("a.toml"),
    )
    .expect("is written");
    let hash = |scene: &str| {
        let (is_done, said, warned) = raymini(
            &folder,
            &[
                "render", scene, "-o", "a.png", "--size", "40x30", "--spp", "1",
            ],
        );
        assert!(is_done, "{warned}");
        said.rsplit(' ').next().expect("a hash").to_owned()
    };
    assert_eq!(hash("chair.obj"), hash("a.toml"));
}

#[test]
fn info_tells_what_vertices_carry() {
    let colored = "COFF 3 1 0\n0 0 0 255 0 0 255\n1 0 0 0 255 0 255\n0 1 0 0 0 255 255\n3 0 1 2\n";
    let folder = folder(&[("c.off", colored), ("t.obj", TEXTURED)]);
    for (file, line) in [
        ("c.off", "  vertices    3, with colours\n"),
        (
            "t.obj",
            "  vertices    3, with normals, texture coordinates\n",
        ),
    ] {
        let (_, said, _) = raymini(&folder, &["info", file]);
        assert!(said.contains(line), "{said}");
    }
}

const TEXTURED: &str =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/3/1\n";

/// Meshes that differ in their material have one list of vertices: what the file holds once is counted once.
#[test]
fn faces_that_meshes_share_are_counted_once() {
    let triangle =
        "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    let primitive = |material: u32| {
        format!(
            r#"{{ "primitives": [{{ "attributes": {{ "POSITION": 0 }}, "material": {material} }}] }}"#
        )
    };
    let text = format!(
        r#"{{ "asset": {{ "version": "2.0" }},
        "buffers": [{{ "byteLength": 36, "uri": "{triangle}" }}],
        "bufferViews": [{{ "buffer": 0, "byteLength": 36 }}],
        "accessors": [{{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] }}],
        "materials": [{{ "name": "red" }}, {{ "name": "blue" }}],
        "meshes": [{}, {}],
        "nodes": [{{ "mesh": 0 }}, {{ "mesh": 1, "translation": [2, 0, 0] }}, {{ "mesh": 1, "translation": [4, 0, 0] }}],
        "scenes": [{{ "nodes": [0, 1, 2] }}] }}"#,
        primitive(0),
        primitive(1)
    );
    let folder = folder(&[("shared.gltf", &text)]);
    let (is_right, said, complaint) = raymini(&folder, &["info", "shared.gltf", "--json"]);
    assert!(is_right, "{complaint}");
    let facts: serde_json::Value = serde_json::from_str(&said).expect("is JSON");
    for (key, expected) in [
        ("vertices", 3),
        ("faces", 1),
        ("triangles", 1),
        ("shown_triangles", 3),
    ] {
        assert_eq!(facts[key], expected, "{key}");
    }
}
