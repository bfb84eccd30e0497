//! The scene being edited: what it was when it was last on disk, and whether it has changed since.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::selection::Selection;
use super::undo::{Snapshot, UndoHistory};
use crate::geometry::TriangleMesh;
use crate::scene::{Camera, Material, Object, RadianceMap, Scene, TextureImage};

/// A scene, the file it belongs to, and its last saved state.
#[derive(Clone, Debug)]
pub struct Document {
    /// What the window shows and edits.
    pub scene: Scene,
    /// What was opened, one after the other: undoing leads back to them.
    files: Vec<File>,
    /// Number of the one that the scene belongs to.
    file: usize,
    undo: UndoHistory,
}

/// What a scene was opened from.
#[derive(Clone, Debug)]
struct File {
    name: String,
    path: Option<PathBuf>,
    /// The scene as it was when it was last on disk.
    saved: Scene,
    /// The camera to go back to: the file's own.
    home: Camera,
}

impl File {
    /// One that holds `scene`.
    fn of(scene: &Scene, name: String, path: Option<PathBuf>) -> Self {
        Self {
            name,
            path,
            saved: scene.clone(),
            home: scene.camera,
        }
    }
}

impl Document {
    /// An unchanged document. `path`: the scene file that saving writes to; `None` for the demo and for bare meshes.
    #[must_use]
    pub fn new(scene: Scene, name: String, path: Option<PathBuf>) -> Self {
        Self {
            undo: UndoHistory::new(scene.clone()),
            files: vec![File::of(&scene, name, path)],
            file: 0,
            scene,
        }
    }

    /// Work that was never saved. `saved`: what its file holds, nothing where that is not known.
    #[must_use]
    pub fn restored(scene: Scene, name: String, path: Option<PathBuf>, saved: Scene) -> Self {
        let mut document = Self::new(scene, name, path);
        document.files[0].saved = saved;
        document
    }

    /// Puts another scene in place of the present one, as a step to undo. The arguments are those of [`Document::new`], and what is selected
    /// now.
    pub fn open(
        &mut self,
        scene: Scene,
        name: String,
        path: Option<PathBuf>,
        selection: &Selection,
    ) {
        let step = format!("opening {name}");
        self.put(scene, (name, path), selection, step);
    }

    /// [`Document::open`], of work that was never saved.
    pub fn open_restored(
        &mut self,
        scene: Scene,
        (name, path): (String, Option<PathBuf>),
        saved: Scene,
        selection: &Selection,
    ) {
        let step = format!("restoring {name}");
        self.put(scene, (name, path), selection, step);
        self.file_mut().saved = saved;
    }

    /// Puts the scene of another file in place of the present one, as the step to undo that is called `step`.
    fn put(
        &mut self,
        scene: Scene,
        (name, path): (String, Option<PathBuf>),
        selection: &Selection,
        step: String,
    ) {
        self.record_edit(selection);
        self.files.push(File::of(&scene, name, path));
        self.turn_to(self.files.len() - 1, scene, step);
    }

    /// Goes back to a `scene` that was rendered, as the step to undo that is called `step`. `file`: the [number](Self::file_number) of what it
    /// belonged to, which was called `name`. Where that is on disk and not what is edited now, the scene is of that name and in no file
    /// yet: what is on disk may be newer.
    pub fn restore_rendered(
        &mut self,
        scene: Scene,
        (file, name): (usize, String),
        selection: &Selection,
        step: String,
    ) {
        self.record_edit(selection);
        if file == self.file {
            self.scene = scene;
            return self.record_edit_as(selection, step);
        }
        let is_on_disk = |file: &File| file.path.is_some();
        if self.files.get(file).is_none_or(is_on_disk) {
            let saved = Scene::default();
            let file = File::of(&scene, name, None);
            self.files.push(File { saved, ..file });
            self.turn_to(self.files.len() - 1, scene, step);
        } else {
            self.turn_to(file, scene, step);
        }
    }

    /// Puts `scene`, which belongs to file number `file`, in place of one that belongs to another, as the step to undo that is called `step`.
    fn turn_to(&mut self, file: usize, scene: Scene, step: String) {
        self.file = file;
        let now = Snapshot {
            scene: scene.clone(),
            selection: Selection::default(),
            file,
        };
        self.scene = scene;
        self.undo.go_on(now, step);
        // What no step leads to any more may be large.
        for (index, file) in self.files.iter_mut().enumerate() {
            if !self.undo.leads_to(index) {
                file.saved = Scene::default();
            }
        }
    }

    fn file(&self) -> &File {
        &self.files[self.file]
    }

    fn file_mut(&mut self) -> &mut File {
        &mut self.files[self.file]
    }

    /// What people call it: the file's name without extension.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.file().name
    }

    /// The scene file, if it has one.
    #[must_use]
    pub fn path(&self) -> Option<&Path> {
        self.file().path.as_deref()
    }

    /// The camera to go back to: the file's own.
    #[must_use]
    pub fn home(&self) -> Camera {
        self.file().home
    }

    /// The scene as it was last on disk; an empty one where that is not known, as of work that was restored.
    #[must_use]
    pub fn saved(&self) -> &Scene {
        &self.file().saved
    }

    /// Which of what was opened the scene belongs to.
    #[must_use]
    pub fn file_number(&self) -> usize {
        self.file
    }

    /// Whether closing it would lose work.
    ///
    /// Looking around is work where there is a scene file, whose camera it is. The demo and bare meshes are merely looked
    /// at until something else changes.
    #[must_use]
    pub fn is_modified(&self) -> bool {
        let File { path, saved, .. } = self.file();
        let camera_counts = path.is_some();
        !same_but_camera(&self.scene, saved) || (camera_counts && self.scene.camera != saved.camera)
    }

    /// Takes note of what was edited since the last call as one step to undo; `selection`: what is selected now. Returns whether
    /// anything was.
    pub fn record_edit(&mut self, selection: &Selection) -> bool {
        self.undo.record(&self.scene, selection)
    }

    /// [`Document::record_edit`] of an edit that is called `name`.
    pub fn record_edit_as(&mut self, selection: &Selection, name: String) {
        self.undo.record_as(&self.scene, selection, Some(name));
    }

    /// What can be undone and done again.
    #[must_use]
    pub fn undo_history(&self) -> &UndoHistory {
        &self.undo
    }

    /// Takes back the last edit; returns what was selected then.
    pub fn undo(&mut self) -> Option<Selection> {
        let snapshot = self.undo.undo()?.clone();
        Some(self.restore(snapshot))
    }

    /// Does again what was undone last; returns what was selected then.
    pub fn redo(&mut self) -> Option<Selection> {
        let snapshot = self.undo.redo()?.clone();
        Some(self.restore(snapshot))
    }

    fn restore(&mut self, snapshot: Snapshot) -> Selection {
        self.scene = snapshot.scene;
        self.file = snapshot.file;
        snapshot.selection
    }

    /// Puts `mesh` in place of that called `name`, in every step to undo too: its file is another one now.
    pub fn replace_mesh(&mut self, name: &str, mesh: &Arc<TriangleMesh>) {
        self.change_all(|scene| replace(&mut scene.meshes, name, mesh));
    }

    /// [`Document::replace_mesh`], of an image.
    pub fn replace_image(&mut self, name: &str, image: &Arc<RadianceMap>) {
        self.change_all(|scene| replace(&mut scene.images, name, image));
    }

    /// [`Document::replace_mesh`], of an image of materials.
    pub fn replace_texture(&mut self, name: &str, image: &Arc<TextureImage>) {
        self.change_all(|scene| replace(&mut scene.textures, name, image));
    }

    /// Changes the scene, as it is, was saved and ever was.
    fn change_all(&mut self, change: impl Fn(&mut Scene)) {
        change(&mut self.scene);
        for file in &mut self.files {
            change(&mut file.saved);
        }
        self.undo.change_all(change);
    }

    /// Takes the scene that the file holds now, as a step to undo. Where the file's camera is the same, one keeps looking from where one
    /// does.
    pub fn reload(&mut self, scene: Scene, selection: &Selection) {
        self.record_edit(selection);
        let camera = if scene.camera == self.file().saved.camera {
            self.scene.camera
        } else {
            scene.camera
        };
        let file = self.file_mut();
        file.home = scene.camera;
        file.saved = scene.clone();
        let name = format!("reading {} again", file.name);
        self.scene = Scene { camera, ..scene };
        self.record_edit_as(selection, name);
    }

    /// Takes note that `scene`, which belongs to [file number](Self::file_number) `file`, is what `path` now holds. Edits made since it
    /// was handed to the writer stay unsaved.
    pub fn set_saved(&mut self, file: usize, scene: Scene, path: PathBuf) {
        if let Some(file) = self.files.get_mut(file) {
            *file = File {
                name: name_of(&path),
                path: Some(path),
                home: scene.camera,
                saved: scene,
            };
        }
    }
}

/// Whether two scenes make the same picture, shown the same way. Meshes are compared by identity, which is quick.
#[must_use]
pub fn same_scene(a: &Scene, b: &Scene) -> bool {
    a.camera == b.camera && same_but_camera(a, b)
}

/// [`same_scene`], wherever the camera is.
#[must_use]
pub fn same_but_camera(a: &Scene, b: &Scene) -> bool {
    a.background == b.background
        && a.bookmarks == b.bookmarks
        && a.materials == b.materials
        && a.objects == b.objects
        && a.lights == b.lights
        && a.light_names == b.light_names
        && a.render == b.render
        && a.display == b.display
        && a.output == b.output
        && same_shared(&a.meshes, &b.meshes)
        && same_shared(&a.textures, &b.textures)
        && same_image(a, b)
}

/// Whether two scenes make the same linear picture: display and file format do not count, nor what things are called.
#[must_use]
pub fn same_picture(a: &Scene, b: &Scene) -> bool {
    a.camera == b.camera && same_picture_but_camera(a, b)
}

/// [`same_picture`], wherever the camera is.
#[must_use]
pub fn same_picture_but_camera(a: &Scene, b: &Scene) -> bool {
    a.render == b.render && same_picture_but_render(a, b)
}

/// [`same_picture_but_camera`], whatever the settings of the render are.
#[must_use]
pub fn same_picture_but_render(a: &Scene, b: &Scene) -> bool {
    a.background == b.background
        && a.lights == b.lights
        && same_objects(a, b)
        && same_shared(&a.meshes, &b.meshes)
        && same_shared(&a.textures, &b.textures)
        && same_image(a, b)
}

/// Whether the objects of two scenes are the same and of the same materials, whatever they and those are called.
fn same_objects(a: &Scene, b: &Scene) -> bool {
    if a.objects.len() != b.objects.len() {
        return false;
    }
    // Many objects share few materials, and those that do often follow one another.
    let mut known_same = None;
    for (x, y) in a.objects.iter().zip(&b.objects) {
        let names = (x.material.as_deref(), y.material.as_deref());
        if known_same != Some(names) && material_called(a, names.0) != material_called(b, names.1) {
            return false;
        }
        known_same = Some(names);
        if !same_but_names(x, y) {
            return false;
        }
    }
    true
}

/// The material of that name, if there is one; the outer `None` where nothing is named.
#[expect(
    clippy::option_option,
    reason = "no name and the name of nothing differ"
)]
fn material_called<'a>(scene: &'a Scene, name: Option<&str>) -> Option<Option<&'a Material>> {
    name.map(|name| scene.materials.get(name))
}

/// Whether two objects are the same but for their names and materials.
fn same_but_names(x: &Object, y: &Object) -> bool {
    let key = |object: &Object| {
        let Object {
            name: _,
            mesh: _,
            material: _,
            smooth,
            crease_angle,
            repair_winding,
            scale,
            rotate,
            translate,
            copies,
        } = *object;
        let shape = (smooth, crease_angle, repair_winding);
        (shape, scale, rotate, translate, copies)
    };
    x.mesh == y.mesh && key(x) == key(y)
}

/// Whether two scenes have the same triangles in the same structure.
#[must_use]
pub fn same_geometry(a: &Scene, b: &Scene) -> bool {
    let place = |object: &Object| (object.placement(), object.copies);
    let pairs = || a.objects.iter().zip(&b.objects);
    same_geometry_but_places(a, b) && pairs().all(|(x, y)| place(x) == place(y))
}

/// [`same_geometry`], wherever the objects are.
#[must_use]
pub fn same_geometry_but_places(a: &Scene, b: &Scene) -> bool {
    let shape = |object: &Object| {
        let smooth = object.smooth.then_some(object.crease_angle);
        (smooth, object.repair_winding)
    };
    a.objects.len() == b.objects.len()
        && a.render.accelerator == b.render.accelerator
        && a.render.accelerator_build == b.render.accelerator_build
        && a.objects
            .iter()
            .zip(&b.objects)
            .all(|(x, y)| x.mesh == y.mesh && shape(x) == shape(y))
        && same_shared(&a.meshes, &b.meshes)
}

/// Whether two scenes have the same image as background, or none. Images are compared by identity.
#[must_use]
pub fn same_image(a: &Scene, b: &Scene) -> bool {
    let image = |scene: &Scene| scene.background_image().ok().flatten().map(Arc::as_ptr);
    image(a) == image(b)
}

/// Puts `new` in place of what is called `name`, where there is such a thing.
fn replace<T>(things: &mut BTreeMap<String, Arc<T>>, name: &str, new: &Arc<T>) {
    if let Some(there) = things.get_mut(name) {
        there.clone_from(new);
    }
}

/// Whether both hold the same things under the same names, by identity.
fn same_shared<T>(a: &BTreeMap<String, Arc<T>>, b: &BTreeMap<String, Arc<T>>) -> bool {
    a.len() == b.len()
        && a.iter()
            .zip(b)
            .all(|((a_name, a), (b_name, b))| a_name == b_name && Arc::ptr_eq(a, b))
}

/// What people call a file: its name without extension.
#[must_use]
pub fn name_of(path: &Path) -> String {
    path.file_stem().map_or_else(
        || "untitled".to_owned(),
        |stem| stem.to_string_lossy().into_owned(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::DVec3;
    use crate::scene::{Light, Object, Texels};

    fn scene() -> Scene {
        Scene {
            objects: vec![Object {
                mesh: "a".into(),
                ..Object::default()
            }],
            meshes: [("a".to_owned(), Arc::new(TriangleMesh::default()))].into(),
            ..Scene::default()
        }
    }

    fn light() -> Light {
        Light::Point {
            position: DVec3::ONE,
            intensity: DVec3::ONE,
        }
    }

    #[test]
    fn looking_at_a_bare_mesh_is_not_an_edit_but_moving_a_files_camera_is() {
        let mut bare = Document::new(scene(), "bunny".into(), None);
        let mut file = Document::new(scene(), "room".into(), Some("room.toml".into()));
        for document in [&mut bare, &mut file] {
            assert!(!document.is_modified());
            document.scene.camera.eye.x += 1.0;
        }
        assert!(!bare.is_modified());
        assert!(file.is_modified());
        bare.scene.lights.push(light());
        assert!(bare.is_modified());
    }

    #[test]
    fn a_mesh_that_changed_on_disk_is_new_in_every_step_and_no_edit() {
        let mut document = Document::new(scene(), "room".into(), Some("room.toml".into()));
        document.scene.lights.push(light());
        document.record_edit(&Selection::Camera);
        let mesh = Arc::new(TriangleMesh {
            positions: vec![DVec3::ONE],
            ..TriangleMesh::default()
        });
        document.replace_mesh("a", &mesh);
        document.replace_mesh("b", &mesh);
        let is_new =
            |scene: &Scene| Arc::ptr_eq(&scene.meshes["a"], &mesh) && scene.meshes.len() == 1;
        document.record_edit(&Selection::Camera);
        assert_eq!(document.undo_history().next_undo(), Some("adding light 1"));
        assert!(is_new(&document.scene));
        document.undo();
        assert!(is_new(&document.scene) && !document.is_modified());
        document.redo();
        assert!(is_new(&document.scene) && document.is_modified());
    }

    #[test]
    fn a_file_that_changed_is_new_also_in_steps_that_alone_have_it() {
        let mut document = Document::new(scene(), "room".into(), Some("room.toml".into()));
        document.scene.objects.clear();
        document.scene.meshes.clear();
        document.record_edit(&Selection::Camera);
        let mesh = Arc::new(TriangleMesh::default());
        document.replace_mesh("a", &mesh);
        assert!(document.scene.meshes.is_empty());
        document.undo();
        assert!(Arc::ptr_eq(&document.scene.meshes["a"], &mesh));
        assert!(!document.is_modified());
    }

    #[test]
    fn another_image_of_a_material_makes_another_picture() {
        let image = |value| {
            let texels = Texels::Bytes(vec![[value; 3]]);
            Arc::new(TextureImage::new(1, 1, texels))
        };
        let mut before = scene();
        before.textures.insert("paint".into(), image(9));
        let mut after = before.clone();
        assert!(same_picture(&before, &after) && same_scene(&before, &after));
        after.textures.insert("paint".into(), image(200));
        assert!(!same_picture(&before, &after) && !same_but_camera(&before, &after));
        let mut document = Document::new(before, "room".into(), Some("room.toml".into()));
        document.replace_texture("paint", &after.textures["paint"]);
        assert!(same_scene(&document.scene, &after) && !document.is_modified());
    }

    #[test]
    fn reading_the_file_again_can_be_undone_and_leaves_the_view() {
        let mut document = Document::new(scene(), "room".into(), Some("room.toml".into()));
        document.scene.lights.push(light());
        document.scene.camera.eye.x += 1.0;
        let mine = document.scene.clone();
        let mut file = scene();
        file.objects[0].name = "ram".into();
        document.reload(file.clone(), &Selection::Camera);
        assert_eq!(document.scene.camera, mine.camera);
        assert!(same_but_camera(&document.scene, &file));
        assert_eq!(
            document.undo_history().next_undo(),
            Some("reading room again")
        );
        document.undo();
        assert!(same_scene(&document.scene, &mine) && document.is_modified());
        file.camera.eye.y += 2.0;
        document.reload(file.clone(), &Selection::Camera);
        assert_eq!(document.scene.camera, file.camera);
        assert!(!document.is_modified());
    }

    #[test]
    fn opening_another_scene_can_be_undone_with_all_that_was_done_before() {
        let mut document = Document::new(scene(), "room".into(), Some("room.toml".into()));
        document.scene.lights.push(light());
        let mine = document.scene.clone();
        let selected = Selection::Light(0);
        let mut other = Scene::default();
        other.camera.eye.x += 3.0;
        document.open(other.clone(), "bunny".into(), None, &selected);
        assert_eq!((document.name(), document.path()), ("bunny", None));
        assert!(!document.is_modified() && document.home() == other.camera);
        assert_eq!(document.undo_history().next_undo(), Some("opening bunny"));

        assert_eq!(document.undo(), Some(selected));
        assert!(same_scene(&document.scene, &mine) && document.is_modified());
        assert_eq!(document.path(), Some(Path::new("room.toml")));
        assert_eq!(document.home(), mine.camera);
        // A mesh that changed meanwhile is new there too.
        document.redo();
        assert_eq!(document.name(), "bunny");
        let mesh = Arc::new(TriangleMesh::default());
        document.replace_mesh("a", &mesh);
        document.undo();
        assert!(Arc::ptr_eq(&document.scene.meshes["a"], &mesh));
        document.undo();
        assert!(!document.is_modified(), "it is as its file");
        assert!(document.undo().is_none());
    }

    #[test]
    fn edits_made_while_saving_stay_unsaved() {
        let mut document = Document::new(scene(), "bunny".into(), None);
        document.scene.lights.push(light());
        let handed_over = document.scene.clone();
        document.scene.lights.push(light());
        document.set_saved(0, handed_over, "scenes/two lights.toml".into());
        assert!(document.is_modified());
        assert_eq!(document.name(), "two lights");
        document.scene.lights.pop();
        assert!(!document.is_modified());
    }

    #[test]
    fn what_things_are_called_makes_no_other_picture() {
        let mut before = scene();
        before.objects.push(before.objects[0].clone());
        before.objects[1].material = Some("clay".into());
        before.materials.insert("clay".into(), Material::default());
        let mut after = before.clone();
        after.objects[0].name = "ram".into();
        let clay = after.materials.remove("clay").expect("is there");
        after.materials.insert("loam".into(), clay);
        after.objects[1].material = Some("loam".into());
        after.light_names.push("lamp".into());
        after.materials.insert("unused".into(), Material::mirror());
        assert!(same_picture(&before, &after) && !same_scene(&before, &after));
        after.materials.insert("loam".into(), Material::mirror());
        assert!(!same_picture(&before, &after));
        after.objects[1].material = None;
        assert!(!same_picture(&before, &after));
    }

    #[test]
    fn materials_and_lights_change_the_picture_but_not_the_geometry() {
        let before = scene();
        let mut after = before.clone();
        after.lights.push(light());
        after.objects[0].material = Some("clay".into());
        assert!(same_geometry(&before, &after) && !same_picture(&before, &after));
        after.objects[0].scale = 2.0;
        assert!(!same_geometry(&before, &after));
        let mut brighter = before.clone();
        brighter.display.exposure = 1.0;
        assert!(same_picture(&before, &brighter) && !same_scene(&before, &brighter));
        brighter.camera.eye.x += 1.0;
        assert!(!same_picture(&before, &brighter) && same_picture_but_camera(&before, &brighter));
    }
}
