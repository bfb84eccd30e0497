//! Scenes some of whose meshes and images are not there.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::contents::named_from_root;
use super::warnings::{image_warnings, texture_warnings};
use super::{LoadError, LoadedScene, forget_unused, load_file, read_text, text_of_render};
use crate::control::{CancelToken, Progress};
use crate::geometry::TriangleMesh;
use crate::io::builtin;
use crate::io::model_loading::load_again;
use crate::io::part_name::{file_and_part, with_part};
use crate::io::radiance_file::load_radiance;
use crate::io::scene_file::SceneFile;
use crate::io::scene_paths::is_render_file;
use crate::io::texture_loader::load_textures_again;
use crate::scene::{Absent, Background, RadianceMap, Scene, TextureImage, Textures};

/// Where files are that are not where a scene names them.
pub type Moves = BTreeMap<PathBuf, PathBuf>;

/// What a scene takes from a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MissingKind {
    /// Meshes, and images too where the file holds both.
    Mesh,
    /// The image of the background.
    Background,
    /// Images of materials.
    Texture,
}

/// A file that a scene names, and that is not there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MissingFile {
    /// Where it was looked for.
    pub path: PathBuf,
    /// What is in it.
    pub kind: MissingKind,
    /// What lacks it, in words: one at least.
    users: Vec<String>,
}

impl MissingFile {
    /// What lacks it, in words.
    #[must_use]
    pub fn users(&self) -> String {
        match &self.users[..] {
            [first, _, ..] => format!("{first} and {} more", self.users.len() - 1),
            users => users.concat(),
        }
    }

    /// What is to be said where the scene is opened without it.
    fn warning(&self) -> String {
        let (users, path) = (self.users(), self.path.display());
        let are_several = self.users.len() > 1;
        let what = match self.kind {
            MissingKind::Mesh if are_several => "have no triangles",
            MissingKind::Mesh => "has no triangles",
            MissingKind::Background => "is black",
            MissingKind::Texture if are_several => "show their plain colours",
            MissingKind::Texture => "shows its plain colour",
        };
        format!("{users} {what}: there is no file {path}")
    }
}

/// A scene that was loaded without files that are not there.
#[derive(Clone, Debug)]
pub struct LoadedWithout {
    /// The scene as its file says it. What stands for the files that are not there is [`Absent`].
    pub loaded: LoadedScene,
    /// The files that are nowhere.
    pub missing: Vec<MissingFile>,
    /// The same with the files that were found elsewhere, by their new names; `None` where none was.
    pub moved: Option<Scene>,
}

impl LoadedWithout {
    /// What is to be said of the files that are nowhere.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        self.missing.iter().map(MissingFile::warning).collect()
    }
}

/// The files of meshes and images that the scene at `path`, a scene file or a picture that tells what was rendered, names and that are not
/// there: those of meshes first, in the order of objects. None where it cannot be understood.
#[must_use]
pub fn missing_files(path: &Path, cancel: &CancelToken) -> Vec<MissingFile> {
    let file = parse(path, cancel).ok().flatten();
    file.map_or_else(Vec::new, |file| {
        missing_in(&named_from_root(&file, folder_of(path)))
    })
}

/// Where other `missing` files are if the one at `from` is at `to` now: those that were in the folders that moved with it, as far as they
/// are there.
#[must_use]
pub fn moved_along(from: &Path, to: &Path, missing: &[MissingFile]) -> Moves {
    let mut folders = (from.parent(), to.parent());
    // What both paths end with moved as a whole.
    while let (Some(old), Some(new)) = folders
        && from.file_name() == to.file_name()
        && old.file_name().is_some()
        && old.file_name() == new.file_name()
    {
        folders = (old.parent(), new.parent());
    }
    let (Some(old), Some(new)) = folders else {
        return Moves::new();
    };
    let others = missing.iter().filter(|file| file.path != from);
    let moved = others.filter_map(|MissingFile { path, .. }| {
        let moved = new.join(path.strip_prefix(old).ok()?);
        moved.is_file().then(|| (path.clone(), moved))
    });
    moved.collect()
}

/// Loads the scene at `path`, a scene file or a picture that tells what was rendered. Of files that are not there, those in `moves` are
/// looked for where that says; [something](Absent) stands for the others. `progress` counts bytes of meshes and images. `None` when
/// cancelled.
///
/// # Errors
/// What else cannot be read or understood, with file and line.
pub fn load_scene_without_missing(
    path: &Path,
    moves: &Moves,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<LoadedWithout>, LoadError> {
    let Some(mut file) = parse(path, cancel)? else {
        return Ok(None);
    };
    let named = named_from_root(&file, folder_of(path));
    let mut missing = missing_in(&named);
    let mut moves = moves.clone();
    moves.retain(|from, _| missing.iter().any(|file| file.path == *from));
    missing.retain(|file| !moves.contains_key(&file.path));

    file.scene = renamed(&named, &moves);
    let absent = missing.iter().map(|file| &*file.path).collect();
    put_absent(&mut file.scene, &absent);
    let Some(mut loaded) = load_file(&file, path, cancel, progress)? else {
        return Ok(None);
    };
    let moved = (!moves.is_empty()).then(|| {
        let named = with_contents_of(named, &loaded.scene);
        std::mem::replace(&mut loaded.scene, named)
    });
    Ok(Some(LoadedWithout {
        loaded,
        missing,
        moved,
    }))
}

fn folder_of(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new("."))
}

fn parse(path: &Path, cancel: &CancelToken) -> Result<Option<SceneFile>, LoadError> {
    let (text, name) = if is_render_file(path) {
        let (text, name) = text_of_render(path)?;
        (Some(text), name)
    } else {
        (read_text(path, cancel)?, path.display().to_string())
    };
    let Some(text) = text else {
        return Ok(None);
    };
    Ok(Some(SceneFile::parse(&text, &name)?))
}

/// What a scene takes from files that were found elsewhere than it names them.
#[derive(Clone, Debug)]
pub struct Found {
    /// Where they are.
    pub moves: Moves,
    /// What is to be said of them, in sentences.
    pub warnings: Vec<String>,
    /// Meshes and images by their new names, and nothing else.
    contents: Scene,
}

impl Found {
    /// Reads what `scene`, which names files from the root, takes from the files in `moves`. `None` when cancelled.
    ///
    /// # Errors
    /// What cannot be read or understood.
    pub fn read(
        scene: &Scene,
        moves: Moves,
        cancel: &CancelToken,
    ) -> Result<Option<Self>, LoadError> {
        let scene = renamed(scene, &moves);
        let mut contents = Scene::default();
        let mut warnings = Vec::new();
        let meshes: BTreeSet<&String> = scene.objects.iter().map(|object| &object.mesh).collect();
        let textures = scene.texture_names();
        for path in moves.values() {
            let is_in = |name: &&String| Path::new(file_and_part(name).0) == path;
            let meshes: Vec<String> = meshes.iter().copied().filter(is_in).cloned().collect();
            let textures: Vec<String> = textures.iter().filter(is_in).cloned().collect();
            if !meshes.is_empty() {
                let Some(read) = load_again(path, &meshes, cancel)? else {
                    return Ok(None);
                };
                contents.meshes.extend(read.meshes);
                warnings.extend(read.warnings);
            }
            if !textures.is_empty() {
                let Some(read) = load_textures_again(&textures, cancel)? else {
                    return Ok(None);
                };
                for (name, file) in read {
                    warnings.extend(texture_warnings(&name, &file));
                    contents.textures.insert(name, Arc::new(file.image));
                }
            }
            if let Background::Image { image, .. } = &scene.background
                && is_in(&image)
            {
                let Some(file) = load_radiance(path, cancel, &Progress::new())? else {
                    return Ok(None);
                };
                warnings.extend(image_warnings(image, &file));
                contents.images.insert(image.clone(), Arc::new(file.map));
            }
        }
        Ok(Some(Self {
            moves,
            warnings,
            contents,
        }))
    }

    /// `scene` with what was read, by the new names of files.
    #[must_use]
    pub fn put_into(&self, scene: &Scene) -> Scene {
        let mut moved = renamed(scene, &self.moves);
        let Scene {
            meshes,
            images,
            textures,
            ..
        } = self.contents.clone();
        moved.meshes.extend(meshes);
        moved.images.extend(images);
        moved.textures.extend(textures);
        forget_unused(&mut moved);
        moved
    }
}

/// The files that `scene` lacks, which names them from the root: those of meshes first, in the order of objects.
#[must_use]
pub fn missing_in(scene: &Scene) -> Vec<MissingFile> {
    let mut missing = MissingFiles::default();
    for (index, object) in scene.objects.iter().enumerate() {
        missing.look_for(&object.mesh, MissingKind::Mesh, || {
            if object.name.is_empty() {
                format!("object {}", index + 1)
            } else {
                object.name.clone()
            }
        });
    }
    if let Background::Image { image, .. } = &scene.background {
        let name = || "the background".to_owned();
        missing.look_for(image, MissingKind::Background, name);
    }
    for (name, material) in &scene.materials {
        let images = material.textures().into_iter().flat_map(Textures::images);
        // Both may be one.
        for image in images.collect::<BTreeSet<_>>() {
            let name = || format!("material {name}");
            missing.look_for(image, MissingKind::Texture, name);
        }
    }
    missing.files
}

/// Files that are not there, and which files were looked for: there may be many more objects than files.
#[derive(Default)]
struct MissingFiles {
    files: Vec<MissingFile>,
    /// Places in `files`, and of those that are there none.
    known: HashMap<PathBuf, Option<usize>>,
}

impl MissingFiles {
    /// Takes in that `user` takes what is called `name` from a file.
    fn look_for(&mut self, name: &str, kind: MissingKind, user: impl Fn() -> String) {
        if name.starts_with(builtin::PREFIX) {
            return;
        }
        let path = PathBuf::from(file_and_part(name).0);
        let place = self.known.entry(path).or_insert_with_key(|path| {
            if path.exists() {
                return None;
            }
            self.files.push(MissingFile {
                path: path.clone(),
                kind,
                users: Vec::new(),
            });
            Some(self.files.len() - 1)
        });
        if let Some(place) = *place {
            self.files[place].users.push(user());
        }
    }
}

/// The names of all meshes and images in `scene`, to be changed.
fn names_mut(scene: &mut Scene) -> impl Iterator<Item = &mut String> {
    let meshes = scene.objects.iter_mut().map(|object| &mut object.mesh);
    let background = match &mut scene.background {
        Background::Image { image, .. } => Some(image),
        _ => None,
    };
    let materials = scene.materials.values_mut();
    let textures = materials.filter_map(|material| material.textures_mut());
    let textures = textures.flat_map(Textures::images_mut);
    meshes.chain(background).chain(textures)
}

/// `scene` with the new names of files in `moves`.
fn renamed(scene: &Scene, moves: &Moves) -> Scene {
    let mut scene = scene.clone();
    for name in names_mut(&mut scene) {
        let (file, part) = file_and_part(name);
        if let Some(moved) = moves.get(Path::new(file)) {
            let moved = moved.to_string_lossy();
            *name = part.map_or_else(|| moved.to_string(), |part| with_part(&moved, part));
        }
    }
    scene
}

/// Puts what stands for them in place of what `scene` takes from the files in `absent`.
fn put_absent(scene: &mut Scene, absent: &HashSet<&Path>) {
    let is_absent = |name: &String| absent.contains(Path::new(file_and_part(name).0));
    let meshes = scene.objects.iter().map(|object| object.mesh.clone());
    for name in meshes.filter(is_absent) {
        scene
            .meshes
            .insert(name, Arc::clone(TriangleMesh::absent()));
    }
    if let Background::Image { image, .. } = &scene.background
        && is_absent(image)
    {
        let absent = Arc::clone(RadianceMap::absent());
        scene.images.insert(image.clone(), absent);
    }
    for name in scene.texture_names().into_iter().filter(is_absent) {
        let absent = Arc::clone(TextureImage::absent());
        scene.textures.insert(name, absent);
    }
}

/// `scene`, which has no contents yet, with those of `other` that are called the same there; what stands for them in place of the rest.
fn with_contents_of(mut scene: Scene, other: &Scene) -> Scene {
    for object in &scene.objects {
        let mesh = found_or_absent(&other.meshes, &object.mesh);
        scene.meshes.insert(object.mesh.clone(), mesh);
    }
    if let Background::Image { image, .. } = &scene.background {
        let map = found_or_absent(&other.images, image);
        scene.images.insert(image.clone(), map);
    }
    for name in scene.texture_names() {
        let texture = found_or_absent(&other.textures, &name);
        scene.textures.insert(name, texture);
    }
    scene
}

fn found_or_absent<T: Absent>(things: &BTreeMap<String, Arc<T>>, name: &str) -> Arc<T> {
    things.get(name).unwrap_or(T::absent()).clone()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::save_scene;

    const TRIANGLE: &str = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

    fn missing(path: &Path) -> MissingFile {
        MissingFile {
            path: path.to_owned(),
            kind: MissingKind::Mesh,
            users: vec!["ram".to_owned()],
        }
    }

    #[test]
    fn what_lay_in_folders_that_moved_is_found_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::create_dir_all(path("new/house/meshes")).unwrap();
        for name in ["meshes/a.off", "meshes/c.off", "sky.exr"] {
            std::fs::write(path("new/house").join(name), "").unwrap();
        }
        let old = ["meshes/a.off", "meshes/b.off", "meshes/c.off", "sky.exr"];
        let old = old.map(|name| path("old/house").join(name));
        let elsewhere = path("older/house/meshes/c.off");
        let others: Vec<_> = old.iter().chain([&elsewhere]).map(|p| missing(p)).collect();
        let moved = |to: &str| moved_along(&old[0], &path(to), &others);
        let c = (old[2].clone(), path("new/house/meshes/c.off"));
        let sky = (old[3].clone(), path("new/house/sky.exr"));
        // The whole of `old` is at `new`, but for what is in neither.
        assert_eq!(
            moved("new/house/meshes/a.off"),
            [c.clone(), sky.clone()].into()
        );
        // Called otherwise, it tells where its folder is and no more.
        assert_eq!(moved("new/house/meshes/z.off"), [c].into());
        assert_eq!(moved("new/house/a.off"), Moves::new());
        let at_root = moved_along(Path::new("/a.off"), Path::new("/z/a.off"), &others);
        assert_eq!(at_root, Moves::new());
    }

    /// As it is, and with what was found elsewhere. Saved, the one is what it was and the other has the new names.
    #[test]
    fn a_scene_keeps_what_is_missing_and_takes_what_was_found() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let text = "[background]\nimage = \"sky.exr\"\n\
            [materials.clay]\nkind = \"phong\"\ndiffuse_image = \"maps/clay.png\"\nnormal_image = \"maps/bumps.png\"\n\
            [[objects]]\nname = \"ram\"\nmesh = \"gone/ram.off\"\nmaterial = \"clay\"\ntranslate = [1.0, 2.0, 3.0]\n\
            [[objects]]\nmesh = \"gone/cow.off\"\n[[objects]]\nmesh = \"gone/ram.off\"\n[[objects]]\nmesh = \"there.off\"\n";
        std::fs::write(path("scene.toml"), text).unwrap();
        std::fs::write(path("there.off"), TRIANGLE).unwrap();
        std::fs::create_dir(path("found")).unwrap();
        std::fs::write(path("found/ram.off"), TRIANGLE).unwrap();

        let never = CancelToken::new();
        let scene = path("scene.toml");
        let lacks = missing_files(&scene, &never);
        let lacks: Vec<_> = lacks.iter().map(|file| (file.users(), file.kind)).collect();
        let expected = [
            ("ram and 1 more", MissingKind::Mesh),
            ("cow", MissingKind::Mesh),
            ("the background", MissingKind::Background),
            ("material clay", MissingKind::Texture),
            ("material clay", MissingKind::Texture),
        ];
        assert_eq!(lacks, expected.map(|(users, kind)| (users.into(), kind)));

        let load = |moves: &Moves| {
            let loaded = load_scene_without_missing(&scene, moves, &never, &Progress::new());
            loaded.unwrap().unwrap()
        };
        let without = load(&Moves::new());
        assert!(without.moved.is_none());
        assert_eq!(without.warnings().len(), 5);
        let triangles = |scene: &Scene| {
            let objects = scene.objects.iter();
            let counts = objects.map(|object| scene.triangles_of(object));
            counts.collect::<Vec<_>>()
        };
        assert_eq!(triangles(&without.loaded.scene), [0, 0, 0, 1]);
        assert!(without.loaded.scene.absent_background().is_some());
        let written = |scene: &Scene| {
            save_scene(scene, &path("saved.toml")).unwrap();
            std::fs::read_to_string(path("saved.toml")).unwrap()
        };
        let saved = written(&without.loaded.scene);
        let names = ["gone/ram.off", "gone/cow.off", "sky.exr", "maps/clay.png"];
        for name in names.iter().chain(&["maps/bumps.png"]) {
            assert!(saved.contains(&format!("\"{name}\"")), "{name} in {saved}");
        }

        let moves = [(path("gone/ram.off"), path("found/ram.off"))].into();
        let LoadedWithout { loaded, moved, .. } = load(&moves);
        assert_eq!(loaded.scene, without.loaded.scene);
        let moved = moved.unwrap();
        assert_eq!(triangles(&moved), [1, 0, 1, 1]);
        assert_eq!(
            written(&moved),
            saved.replace("gone/ram.off", "found/ram.off")
        );
    }
}
