//! What becomes of meshes that were read: they join the scene, or make one of their own.

use std::path::PathBuf;

use super::App;
use super::opening::{cannot_open, what};
use crate::gui::dialogs::import::{Import, ImportDecision, Unit};
use crate::gui::dialogs::{Dialog, Intent, Opened};
use crate::gui::jobs::Lane;
use crate::gui::selection::Selection;
use crate::gui::worker;
use crate::io::{self, Model};
use crate::math::{DBounds, DVec3};
use crate::scene::{Scene, presets};

impl App {
    /// Reads meshes, to ask then what becomes of them. `replaces`: whether they are likely to take the place of the scene.
    pub(super) fn import(&mut self, paths: Vec<PathBuf>, replaces: bool) {
        let progress = self.begin_loading(what(&paths));
        self.jobs.start(Lane::Load, move |job| {
            worker::load_models(job, paths, replaces, &progress);
        });
    }

    pub(super) fn models_loaded(
        &mut self,
        paths: Vec<PathBuf>,
        replaces: bool,
        result: Result<Vec<Model>, String>,
    ) {
        self.loading = None;
        match result {
            Ok(models) if models.iter().all(|model| model.facts.triangles == 0) => {
                let warnings = models.into_iter().flat_map(|model| model.warnings);
                let reasons: Vec<String> = warnings.collect();
                self.not_opened(&paths, &reasons.join("\n"));
            }
            Ok(models) => {
                self.messages.withdraw(&cannot_open(&paths));
                let import = Box::new(Import::new(paths, models, replaces));
                if self.document.scene.objects.is_empty() {
                    self.add(*import);
                } else {
                    self.viewport.release();
                    self.ask(Dialog::Import(import));
                }
            }
            Err(error) => self.not_opened(&paths, &error),
        }
    }

    /// Does what the user decided about meshes that were read.
    pub(super) fn decide_about_import(&mut self, import: Box<Import>, decision: ImportDecision) {
        match decision {
            ImportDecision::None => self.dialog = Some(Dialog::Import(import)),
            ImportDecision::Cancel => {}
            ImportDecision::Add => self.add(*import),
            ImportDecision::Replace if self.document.is_modified() => {
                self.ask(Dialog::Unsaved(Intent::Import(import)));
            }
            ImportDecision::Replace => self.replace_by(*import),
        }
    }

    /// Makes a scene of what was read in place of the present one.
    pub(super) fn replace_by(&mut self, mut import: Import) {
        let factor = import.factor(None);
        let models = import.take_models(factor);
        let made = io::scene_of_models(models).map_err(|error| error.to_string());
        let paths = import.paths;
        match made {
            Ok(loaded) => self.put_opened(Opened {
                paths,
                loaded,
                picture: None,
                moved: None,
            }),
            Err(error) => self.not_opened(&paths, &error),
        }
    }

    /// Adds what was read to the scene.
    fn add(&mut self, mut import: Import) {
        self.document.record_edit(&self.selection);
        let factor = import.factor(Some(&self.document.scene));
        let what = import.what();
        let is_first =
            self.document.scene.objects.is_empty() && self.document.scene.lights.is_empty();
        let first = self.document.scene.objects.len();
        let resting_place = resting_place(&self.document.scene);
        let mut warnings = Vec::new();
        for mut model in import.take_models(factor) {
            warnings.append(&mut model.warnings);
            add_model(&mut self.document.scene, model.scene, model.up, is_first);
        }
        let scene = &mut self.document.scene;
        if let (Unit::Fitted, Some(place)) = (import.unit, resting_place) {
            place_upon(scene, first, place);
        }
        if is_first && let Err(error) = presets::light_and_frame(scene, import.up) {
            let title = "The scene cannot be framed and lit";
            self.messages.error(title, error.to_string());
        }
        if !warnings.is_empty() {
            let title = format!("Added {what} with remarks");
            self.messages.warning(title, warnings.join("\n"));
        }
        self.selection = Selection::Object(first).within(&self.document.scene);
        self.show_camera_view();
    }
}

/// Adds the objects of a model to `scene`, turned to what is up there.
fn add_model(scene: &mut Scene, model: Scene, up: presets::UpAxis, is_first: bool) {
    // The preset's own material where the scene has it, else the one used first.
    let material = presets::object()
        .material
        .filter(|name| is_first || scene.materials.contains_key(name))
        .or_else(|| scene.materials.keys().next().cloned());
    let turn = if is_first {
        0.0
    } else {
        up.turn_to(scene.camera.up)
    };
    let first = scene.join(model);
    presets::show_colors(scene, first);
    for object in &mut scene.objects[first..] {
        object.turn_about_x(turn);
        object.material = object.material.take().or_else(|| material.clone());
    }
}

/// The axis that is most nearly up in a scene, and which way along it.
fn up_of(scene: &Scene) -> DVec3 {
    let up = scene.camera.up;
    let largest = up.abs().max_element();
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let axis = axes.into_iter().find(|axis| up.abs().dot(*axis) >= largest);
    axis.map_or(DVec3::Z, |axis| axis * up.dot(axis).signum())
}

/// The middle of the lowest side of all objects; `None` where there are none.
fn resting_place(scene: &Scene) -> Option<DVec3> {
    let bounds = scene.bounds();
    (!bounds.is_empty()).then(|| lowest(&bounds, up_of(scene)))
}

fn lowest(bounds: &DBounds, up: DVec3) -> DVec3 {
    bounds.center() - up * up.abs().dot((bounds.max - bounds.min) * 0.5)
}

/// Moves the objects from number `first` on so that the middle of their lowest side is at `place`.
fn place_upon(scene: &mut Scene, first: usize, place: DVec3) {
    let boxes = scene.objects[first..].iter().filter_map(|object| {
        let mesh = scene.meshes.get(&object.mesh)?;
        Some(object.bounds_of(mesh))
    });
    let bounds = boxes.fold(DBounds::EMPTY, DBounds::union);
    if bounds.is_empty() {
        return;
    }
    let way = place - lowest(&bounds, up_of(scene));
    for object in &mut scene.objects[first..] {
        object.translate += way;
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::geometry::shapes;
    use crate::scene::Object;

    #[test]
    fn what_is_fitted_stands_in_the_middle_of_the_floor() {
        let mut scene = Scene::default();
        let mesh = shapes::cuboid(DVec3::new(2.0, 3.0, 5.0), DVec3::new(4.0, 9.0, 6.0));
        scene.meshes.insert("box".into(), Arc::new(mesh));
        for _ in 0..2 {
            scene.objects.push(Object {
                mesh: "box".into(),
                ..Object::default()
            });
        }
        for (up, bottom) in [
            (DVec3::new(0.1, -0.2, 0.9), DVec3::new(3.0, 6.0, 5.0)),
            (DVec3::Y, DVec3::new(3.0, 3.0, 5.5)),
            (-DVec3::Y, DVec3::new(3.0, 9.0, 5.5)),
        ] {
            scene.camera.up = up;
            scene.objects[1].translate = DVec3::ZERO;
            assert_eq!(resting_place(&scene), Some(bottom));
            place_upon(&mut scene, 1, DVec3::ZERO);
            assert_eq!(scene.objects[1].translate, -bottom, "{up}");
            assert_eq!(scene.objects[0].translate, DVec3::ZERO);
        }
    }
}
