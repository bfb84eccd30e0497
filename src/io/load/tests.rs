use super::*;
use crate::io::save_scene;
use crate::scene::Texels;

#[test]
fn progress_ends_at_its_total() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("a.off"), "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
        .expect("is written");
    let twice = "[[objects]]\nmesh = \"a.off\"\n[[objects]]\nmesh = \"builtin:ground\"\n[[objects]]\nmesh = \"a.off\"\n";
    std::fs::write(path("scene.toml"), twice).expect("is written");
    for name in ["a.off", "scene.toml"] {
        let progress = Progress::new();
        load_scene(&path(name), &CancelToken::new(), &progress)
            .expect("is right")
            .expect("nobody cancels");
        assert!(progress.total() > 0, "{name}");
        assert_eq!(progress.done(), progress.total(), "{name}");
    }
}

/// A folder with an image and a scene in a folder beside it that names the image.
fn scene_under_a_sky() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let image = crate::render::Image {
        width: 4,
        height: 2,
        pixels: (0..8_u8).map(|i| [f32::from(i); 3]).collect(),
    };
    let path = folder.path().join("sky.exr");
    let scene = Scene::default();
    crate::io::write_image(&image, &[], &scene.display, &scene.output, &path).expect("is written");
    std::fs::create_dir(folder.path().join("scenes")).expect("is made");
    let path = folder.path().join("scenes/a.toml");
    let text = "[background]\nimage = \"../sky.exr\"\nrotation = 30\n\
                [[objects]]\nmesh = \"builtin:ground\"\n";
    std::fs::write(&path, text).expect("is written");
    (folder, path)
}

fn load(path: &Path) -> Result<LoadedScene, LoadError> {
    let progress = Progress::new();
    let loaded = load_scene(path, &CancelToken::new(), &progress)?.expect("nobody cancels");
    assert_eq!(progress.done(), progress.total());
    Ok(loaded)
}

#[test]
fn a_background_image_is_loaded_saved_and_found_again() {
    let (folder, path) = scene_under_a_sky();
    let LoadedScene { scene, warnings } = load(&path).expect("is right");
    assert_eq!(warnings, Vec::<String>::new());
    let map = scene
        .background_image()
        .expect("is loaded")
        .expect("is one");
    assert_eq!(map.row(1)[2], [6.0; 3]);

    // Saved elsewhere, the scene still finds its image, by a path relative to itself.
    std::fs::create_dir_all(folder.path().join("b/c")).expect("is made");
    let other = folder.path().join("b/c/other.toml");
    save_scene(&scene, &other).expect("is written");
    let text = std::fs::read_to_string(&other).expect("is there");
    assert!(text.contains("image = \"../../sky.exr\""), "{text}");
    assert_eq!(load(&other).expect("is right").scene, scene);
}

#[test]
fn an_image_that_cannot_be_loaded_is_an_error_at_its_place() {
    let (folder, path) = scene_under_a_sky();
    std::fs::write(folder.path().join("sky.exr"), "OFF\n").expect("is written");
    let found = load(&path).expect_err("is no image").to_string();
    let at = format!("{}:2:9: ", path.display());
    let expected = "sky.exr: this is not a known kind of image; expected OpenEXR";
    assert!(
        found.starts_with(&at) && found.contains(expected),
        "{found}"
    );
}

#[test]
fn overrides_load_a_background_image() {
    let (folder, path) = scene_under_a_sky();
    let mut loaded = load(&path).expect("is right");
    let set = |loaded: &mut LoadedScene, assignment: String| {
        override_scene(loaded, &[assignment], &CancelToken::new())
    };
    set(&mut loaded, "background.radiance=[1,1,1]".into()).expect("is right");
    let sky = folder.path().join("sky.exr");
    loaded.scene.images.clear();
    let assignment = format!("background.image={}", sky.display());
    set(&mut loaded, assignment).expect("is right");
    assert!(
        loaded
            .scene
            .background_image()
            .is_ok_and(|map| map.is_some())
    );
    let error = set(&mut loaded, "background.image=/nowhere/a.exr".into());
    let error = error.expect_err("is not there").to_string();
    assert_eq!(error, "/nowhere/a.exr: there is no such file");
}

/// A folder with a texture of one white texel and a scene in a folder beside it that names it twice.
fn textured_scene() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let white = crate::render::Image {
        width: 1,
        height: 1,
        pixels: vec![[1.0; 3]],
    };
    let scene = Scene::default();
    let path = folder.path().join("white.png");
    crate::io::write_image(&white, &[], &scene.display, &scene.output, &path).expect("is written");
    std::fs::create_dir(folder.path().join("scenes")).expect("is made");
    let path = folder.path().join("scenes/a.toml");
    let text = "[materials.a]\ndiffuse_image = \"../white.png\"\n\
                normal_image = \"./../white.png\"\n[materials.b]\nspecular = [0, 0, 0]\n\
                [[objects]]\nmesh = \"builtin:ground\"\nmaterial = \"a\"\n";
    std::fs::write(&path, text).expect("is written");
    (folder, path)
}

#[test]
fn textures_are_loaded_once_saved_and_found_again() {
    let (folder, path) = textured_scene();
    let LoadedScene { scene, warnings } = load(&path).expect("is right");
    assert_eq!(warnings, Vec::<String>::new());
    assert_eq!(scene.textures.len(), 1);
    let names = scene.texture_names();
    let name = names.first().expect("one is named");
    let texture = scene.texture(name).expect("is loaded");
    assert_eq!(*texture.texels(), Texels::Bytes(vec![[255; 3]]));

    std::fs::create_dir_all(folder.path().join("b/c")).expect("is made");
    let other = folder.path().join("b/c/other.toml");
    save_scene(&scene, &other).expect("is written");
    let text = std::fs::read_to_string(&other).expect("is there");
    assert!(
        text.contains("diffuse_image = \"../../white.png\""),
        "{text}"
    );
    assert_eq!(load(&other).expect("is right").scene, scene);
}

#[test]
fn a_texture_that_cannot_be_loaded_is_an_error_at_its_place() {
    let (folder, path) = textured_scene();
    std::fs::remove_file(folder.path().join("white.png")).expect("is there");
    let found = load(&path).expect_err("is not there").to_string();
    let image = folder.path().join("white.png");
    let (path, image) = (path.display(), image.display());
    assert_eq!(
        found,
        format!("{path}:2:17: {image}: there is no such file")
    );
}

#[test]
fn overrides_load_textures() {
    let (folder, path) = textured_scene();
    let mut loaded = load(&path).expect("is right");
    loaded.scene.textures.clear();
    let image = folder.path().join("white.png");
    let assignment = format!("materials.b.diffuse_image={}", image.display());
    override_scene(&mut loaded, &[assignment], &CancelToken::new()).expect("is right");
    let material = &loaded.scene.materials["b"];
    let textures = material.textures().expect("phong");
    let image = textures.diffuse_image.as_deref().expect("is set");
    assert!(loaded.scene.texture(image).is_ok());
    let assignment = "materials.b.normal_image=/nowhere/a.png".to_owned();
    let error = override_scene(&mut loaded, &[assignment], &CancelToken::new());
    let error = error.expect_err("is not there").to_string();
    assert_eq!(error, "/nowhere/a.png: there is no such file");
}

/// A scene may name what lies beside it or beside its folder; reading anything else is said, links or not.
#[test]
fn what_a_scene_reads_from_far_away_is_said() {
    let root = tempfile::tempdir().expect("a folder");
    let path = |name: &str| root.path().join(name);
    for folder in ["project/scenes/parts", "project/assets", "private"] {
        std::fs::create_dir_all(path(folder)).expect("is made");
    }
    let triangle = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    for mesh in [
        "project/scenes/parts/a.off",
        "project/assets/a.off",
        "private/a.off",
    ] {
        std::fs::write(path(mesh), triangle).expect("is written");
    }
    let warnings = |mesh: &str| {
        let text = format!("[[objects]]\nmesh = {mesh:?}\n");
        std::fs::write(path("project/scenes/a.toml"), text).expect("is written");
        load(&path("project/scenes/a.toml"))
            .expect("is right")
            .warnings
    };
    let absolute = path("project/assets/a.off");
    for near in [
        "parts/a.off",
        "../assets/a.off",
        "builtin:ground",
        &absolute.to_string_lossy(),
    ] {
        assert_eq!(warnings(near), Vec::<String>::new(), "{near}");
    }
    let far = path("private/a.off");
    let far = far.to_string_lossy();
    let around = std::fs::canonicalize(path("project")).expect("exists");
    let expected = |read: &str| {
        let around = around.display();
        vec![format!(
            "{read}: the scene file reads this from outside of {around}"
        )]
    };
    for mesh in ["../../private/a.off", &far] {
        assert_eq!(warnings(mesh), expected(&far), "{mesh}");
    }
    #[cfg(unix)]
    {
        let link = path("project/scenes/link.off");
        std::os::unix::fs::symlink(path("private/a.off"), &link).expect("is made");
        assert_eq!(warnings("link.off"), expected(&link.to_string_lossy()));
    }

    // An image likewise.
    let image = crate::render::Image {
        width: 2,
        height: 1,
        pixels: vec![[1.0; 3]; 2],
    };
    let sky = path("private/sky.exr");
    let scene = Scene::default();
    crate::io::write_image(&image, &[], &scene.display, &scene.output, &sky).expect("is written");
    let text = "[background]\nimage = \"../../private/sky.exr\"\n";
    std::fs::write(path("project/scenes/b.toml"), text).expect("is written");
    let loaded = load(&path("project/scenes/b.toml")).expect("is right");
    assert_eq!(loaded.warnings, expected(&sky.to_string_lossy()));
}

#[test]
fn a_scene_that_is_read_again_keeps_the_meshes_it_still_has() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    for (mesh, x) in [("a.off", 1), ("b.off", 2), ("c.off", 3)] {
        let text = format!("OFF\n3 1 0\n0 0 0\n{x} 0 0\n0 1 0\n3 0 1 2\n");
        std::fs::write(path(mesh), text).expect("is written");
    }
    let write = |meshes: &[&str]| {
        let object = |mesh: &&str| format!("[[objects]]\nmesh = {mesh:?}\n");
        let text: String = meshes.iter().map(object).collect();
        std::fs::write(path("scene.toml"), text).expect("is written");
    };
    write(&["a.off", "b.off"]);
    let before = load(&path("scene.toml")).expect("is right").scene;
    // What has changed on disk is known from elsewhere, and read from there.
    std::fs::write(path("b.off"), "no mesh").expect("is written");
    write(&["b.off", "c.off"]);
    let again = reload_scene(&path("scene.toml"), &before, &CancelToken::new());
    let again = again.expect("is right").expect("nobody cancels").scene;
    let mesh = |scene: &Scene, name: &str| {
        let name = path(name).to_string_lossy().into_owned();
        scene.meshes.get(&name).cloned()
    };
    assert!(mesh(&again, "a.off").is_none() && again.meshes.len() == 2);
    let [old, new] = [&before, &again].map(|scene| mesh(scene, "b.off").expect("is there"));
    assert!(Arc::ptr_eq(&old, &new));
    assert_eq!(mesh(&again, "c.off").expect("is read").positions[1].x, 3.0);
}

#[test]
fn the_scenes_of_this_repository_load_without_a_warning() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let entries = std::fs::read_dir(folder).expect("a folder");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let scenes: Vec<PathBuf> = paths.filter(|path| is_scene_file(path)).collect();
    assert!(scenes.len() > 10);
    for path in scenes {
        let loaded = load(&path).expect("is right");
        assert_eq!(loaded.warnings, Vec::<String>::new(), "{}", path.display());
        assert!(
            !holds_other_scene(&path, &[loaded.scene]),
            "{}",
            path.display()
        );
    }
}

#[test]
fn a_scene_that_somebody_else_has_written_is_told_from_ones_own() {
    let (_folder, path) = scene_under_a_sky();
    let read = load(&path).expect("is right").scene;
    let mut edited = read.clone();
    edited.render.seed += 1;
    let known = [read.clone()];
    assert!(!holds_other_scene(&path, &known));
    save_scene(&edited, &path).expect("is saved");
    assert!(holds_other_scene(&path, &known));
    assert!(!holds_other_scene(&path, &[read.clone(), edited.clone()]));
    std::fs::write(&path, "[camera\n").expect("is written");
    assert!(holds_other_scene(&path, &[read.clone(), edited]));
    std::fs::remove_file(&path).expect("is removed");
    assert!(
        !holds_other_scene(&path, &[read]),
        "nothing is there to lose"
    );
}

#[test]
fn the_demo_scene_is_whole() {
    let scene = demo_scene();
    assert_eq!(scene.lights.len(), 4);
    assert_eq!(scene.objects.len(), 4);
    assert!(scene.triangle_count() > 30_000);
    assert_eq!(scene.validate(), Ok(()));
    let meshes = scene.meshes.values().map(|mesh| &**mesh);
    assert_eq!(lost_digits_warning("demo", meshes), None);
}

/// Of a file that several objects show, and of a mesh that is set by name.
#[test]
fn a_mesh_that_lost_digits_is_warned_of_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let mut ball = crate::geometry::shapes::icosphere(2);
    for p in &mut ball.positions {
        *p = (*p + crate::math::DVec3::X * 3e5).as_vec3().as_dvec3();
    }
    let mut bytes = Vec::new();
    crate::io::off::write(&ball, &mut bytes).expect("is written");
    std::fs::write(path("far.off"), bytes).expect("is written");
    let twice = "[[objects]]\nmesh = \"far.off\"\n[[objects]]\nmesh = \"far.off\"\n";
    std::fs::write(path("scene.toml"), twice).expect("is written");
    for name in ["far.off", "scene.toml"] {
        let warnings = load(&path(name)).expect("is right").warnings;
        assert_eq!(warnings.len(), 1, "{warnings:#?}");
        assert!(
            warnings[0].contains("far.off: the coordinates in the file were rounded to 32 bits")
        );
    }
    let near = "[[objects]]\nmesh = \"builtin:ground\"\n";
    std::fs::write(path("near.toml"), near).expect("is written");
    let mut loaded = load(&path("near.toml")).expect("is right");
    assert_eq!(loaded.warnings, Vec::<String>::new());
    let assignment = format!("objects.0.mesh={}", path("far.off").display());
    override_scene(&mut loaded, &[assignment], &CancelToken::new()).expect("is right");
    assert_eq!(loaded.warnings.len(), 1, "{:#?}", loaded.warnings);
}
