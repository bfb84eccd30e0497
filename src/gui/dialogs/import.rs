//! The question what becomes of meshes that were read: whether they join the scene, in what unit they are, and which way is up.

use std::path::PathBuf;

use egui::RichText;

use super::{buttons_ui, modal_ui};
use crate::gui::document::name_of;
use crate::gui::widgets::{
    choice_row_ui, combo_row_ui, counted, format_number, primary_button, switch_row_ui,
};
use crate::io::Model;
use crate::math::{DBounds, DVec3};
use crate::scene::Scene;
use crate::scene::presets::UpAxis;

/// Meshes that were read.
#[derive(Clone, Debug)]
pub struct Import {
    /// Where each is from.
    pub paths: Vec<PathBuf>,
    /// What is in each.
    pub models: Vec<Model>,
    /// The unit of their numbers.
    pub unit: Unit,
    /// Which way is up in them.
    pub up: UpAxis,
    /// Whether their triangles are turned so that each surface has one outer side.
    pub repair_winding: bool,
    /// Whether they are likely to take the place of the scene.
    replaces: bool,
    bounds: DBounds,
    triangles: u64,
}

/// What a number in a mesh is, in units of the scene. Those are metres where lights are in watts per square metre.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// A unit of the scene.
    Scene,
    /// A thousandth.
    Millimetre,
    /// A hundredth.
    Centimetre,
    /// 25.4 thousandths.
    Inch,
    /// Twelve inches.
    Foot,
    /// What makes all meshes together as large as the middle one of the scene's objects, or of size 1 where they take its place.
    Fitted,
}

/// What the user decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImportDecision {
    /// Nothing yet.
    None,
    /// The meshes join the scene.
    Add,
    /// They take its place.
    Replace,
    /// Everything stays as it is.
    Cancel,
}

impl Unit {
    const ALL: [(Self, &'static str); 6] = [
        (Self::Scene, "As in the file: 1 is 1 of the scene"),
        (Self::Millimetre, "Millimetres: 1 becomes 0.001"),
        (Self::Centimetre, "Centimetres: 1 becomes 0.01"),
        (Self::Inch, "Inches: 1 becomes 0.0254"),
        (Self::Foot, "Feet: 1 becomes 0.3048"),
        (Self::Fitted, "Fitted: as large as other objects"),
    ];
}

impl Import {
    /// The question about `models`, which are from `paths`. `replaces`: whether they are likely to take the place of the scene.
    #[must_use]
    pub fn new(paths: Vec<PathBuf>, models: Vec<Model>, replaces: bool) -> Self {
        let boxes = models.iter().map(|model| model.facts.bounds);
        Self {
            unit: Unit::Scene,
            up: models
                .first()
                .map_or_else(UpAxis::default, |model| model.up),
            repair_winding: false,
            replaces,
            bounds: boxes.fold(DBounds::EMPTY, DBounds::union),
            triangles: models.iter().map(|model| model.facts.triangles).sum(),
            paths,
            models,
        }
    }

    /// What their numbers are multiplied by to become those of `scene`; of a scene of their own where that is `None`.
    #[must_use]
    pub fn factor(&self, scene: Option<&Scene>) -> f64 {
        match self.unit {
            Unit::Scene => 1.0,
            Unit::Millimetre => 1e-3,
            Unit::Centimetre => 1e-2,
            Unit::Inch => 0.0254,
            Unit::Foot => 0.3048,
            Unit::Fitted => {
                let wanted = scene.and_then(middle_size).unwrap_or(1.0);
                let factor = wanted / self.bounds.diagonal();
                if factor.is_finite() && factor > 0.0 {
                    factor
                } else {
                    1.0
                }
            }
        }
    }

    /// Asks. `scene`: what is there already.
    #[must_use]
    pub fn decide_ui(&mut self, ctx: &egui::Context, scene: &Scene) -> ImportDecision {
        let response = modal_ui(ctx, "import", 460.0, |ui| {
            ui.heading(format!("Import {}", self.what()));
            ui.add_space(4.0);
            let parts: usize = self
                .models
                .iter()
                .map(|model| model.scene.objects.len())
                .sum();
            let parts = counted(parts, "object", "objects");
            let triangles = usize::try_from(self.triangles).unwrap_or(usize::MAX);
            let triangles = counted(triangles, "triangle", "triangles");
            ui.label(RichText::new(format!("{parts}, {triangles}")).weak());
            ui.add_space(6.0);
            combo_row_ui(
                ui,
                "Unit",
                "What a number in the file is, in units of the scene: those are metres where lights are in watts per square metre",
                &mut self.unit,
                &Unit::ALL.map(|(unit, name)| (unit, name.to_owned())),
            );
            choice_row_ui(
                ui,
                "Up axis",
                "Which way is up in the file; the mesh is turned by a quarter where another way is up in the scene",
                &mut self.up,
                |up| match up {
                    UpAxis::Y => ("Y", "As most OBJ and glTF files have it"),
                    UpAxis::Z => ("Z", "As most OFF, PLY and STL files have it"),
                },
            );
            switch_row_ui(
                ui,
                "Repair winding",
                "Turn triangles so that each surface has one outer side and closed ones look outwards, as glass needs it; it can be \
                 switched off for each object later",
                &mut self.repair_winding,
            );
            ui.add_space(4.0);
            self.sizes_ui(ui, scene);
            self.buttons_ui(ui)
        });
        match response.inner {
            ImportDecision::None if response.should_close() => ImportDecision::Cancel,
            decision => decision,
        }
    }

    /// What was read, as it was decided: its numbers times `factor`.
    pub fn take_models(&mut self, factor: f64) -> Vec<Model> {
        let mut models = std::mem::take(&mut self.models);
        for model in &mut models {
            model.up = self.up;
            model.scale_by(factor);
            for object in &mut model.scene.objects {
                object.repair_winding |= self.repair_winding;
            }
        }
        models
    }

    /// What is imported, in words.
    #[must_use]
    pub fn what(&self) -> String {
        match self.paths.as_slice() {
            [path] => path
                .file_name()
                .map_or_else(|| name_of(path), |name| name.to_string_lossy().into_owned()),
            paths => counted(paths.len(), "mesh", "meshes"),
        }
    }

    fn sizes_ui(&self, ui: &mut egui::Ui, scene: &Scene) {
        let size = extent(&self.bounds);
        egui::Grid::new("sizes").num_columns(2).show(ui, |ui| {
            let mut row = |name: &str, size: DVec3| {
                ui.label(RichText::new(name).weak());
                ui.label(in_words(size));
                ui.end_row();
            };
            row("Size in the file", size);
            let turned = if self.up.turn_to(scene.camera.up) == 0.0 {
                size
            } else {
                DVec3::new(size.x, size.z, size.y)
            };
            row("Added, it is", turned * self.factor(Some(scene)));
            row("The scene is", extent(&scene.bounds()));
        });
    }

    fn buttons_ui(&self, ui: &mut egui::Ui) -> ImportDecision {
        let add = (
            "Add to scene",
            "Keep the scene and add what was read as new objects; it can be undone",
            ImportDecision::Add,
        );
        let replace = (
            "Replace",
            "Make a new scene of what was read, framed and lit",
            ImportDecision::Replace,
        );
        let [likely, other] = if self.replaces {
            [replace, add]
        } else {
            [add, replace]
        };
        buttons_ui(ui, |ui| {
            let mut decision = ImportDecision::None;
            for (button, tooltip, meaning) in [
                (primary_button(likely.0), likely.1, likely.2),
                (egui::Button::new(other.0), other.1, other.2),
                (
                    egui::Button::new("Cancel"),
                    "Leave everything as it is",
                    ImportDecision::Cancel,
                ),
            ] {
                let response = ui.add(button).on_hover_text(tooltip);
                if response.clicked() {
                    decision = meaning;
                }
                // Enter does what is likely wanted.
                if meaning == likely.2 && ui.memory(|memory| memory.focused().is_none()) {
                    response.request_focus();
                }
            }
            decision
        })
    }
}

/// The diagonal of the middle one of the objects by size, the smaller of two; `None` where no object has a size.
fn middle_size(scene: &Scene) -> Option<f64> {
    let sizes = scene.objects.iter().filter_map(|object| {
        let mesh = scene.meshes.get(&object.mesh)?;
        let bounds = object.bounds_of(mesh);
        Some(bounds.diagonal()).filter(|size| !bounds.is_empty() && *size > 0.0)
    });
    let mut sizes: Vec<f64> = sizes.collect();
    sizes.sort_by(f64::total_cmp);
    sizes.get(sizes.len().saturating_sub(1) / 2).copied()
}

/// The sides of a box; none of an empty one.
fn extent(bounds: &DBounds) -> DVec3 {
    if bounds.is_empty() {
        DVec3::ZERO
    } else {
        bounds.max - bounds.min
    }
}

fn in_words(size: DVec3) -> String {
    let [x, y, z] = size.to_array().map(|side| format_number(side, 3));
    format!("{x} × {y} × {z}")
}
