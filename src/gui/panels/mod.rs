//! The side panel: the scene's parts, the properties of the selected one, and the settings of the picture. Panels edit
//! the scene in place; the app notices what changed.

mod background;
mod camera;
mod display;
mod light;
mod material;
mod object;
mod plan;
mod presets;
mod settings;
mod tree;

use std::path::{Path, PathBuf};

use egui::{Button, RichText, Ui};

pub(super) use background::with_image;
pub(super) use settings::StructureInUse;

use super::balls::Balls;
use super::box_view::BoxView;
use super::commands::Command;
use super::contributions::Contributions;
use super::costs::CostState;
use super::histogram::Histogram;
use super::look::Channels;
use super::region::RegionTool;
use super::selection::Selection;
use super::threads::Threads;
use super::widgets::section_ui;
use crate::io;
use crate::render::Layer;
use crate::scene::Scene;

/// The text field with the name of the selected part.
pub(super) const NAME_FIELD: &str = "name of the selected part";

/// What the panels edit.
#[derive(Debug)]
pub struct PanelState<'a> {
    /// The scene.
    pub scene: &'a mut Scene,
    /// The part whose properties show.
    pub selection: &'a mut Selection,
    /// Which threads render.
    pub threads: &'a mut Threads,
    /// Which part of the picture is rendered.
    pub region: &'a mut RegionTool,
    /// The layer of the picture that is shown; `None` shows all of it.
    pub shown_layer: &'a mut Option<Layer>,
    /// The channels of it that show.
    pub channels: &'a mut Channels,
    /// The layers that the picture has.
    pub layers: &'a [Layer],
    /// How bright the picture on the screen is.
    pub histogram: Option<&'a Histogram>,
    /// A pixel of it that is to be looked at.
    pub asked_pixel: &'a mut Option<[u32; 2]>,
    /// What rays look for triangles in, once it is there.
    pub structure: Option<StructureInUse>,
    /// What materials look like.
    pub balls: &'a mut Balls,
    /// What effects and lights bring.
    pub contributions: &'a mut Contributions,
    /// The boxes of the structure that the preview shows.
    pub boxes: &'a mut BoxView,
    /// What effects cost.
    pub costs: &'a CostState,
    /// Whether that can be measured now.
    pub can_measure_costs: bool,
    /// A missing file of which the user is to say where it is.
    pub sought: &'a mut Option<PathBuf>,
    /// What is asked for beside edits.
    pub commands: &'a mut Vec<Command>,
}

impl PanelState<'_> {
    /// Change of a length per point of dragging: what the eye sees as a small step from where the camera is.
    fn length_speed(&self) -> f64 {
        let distance = self.scene.camera.eye.distance(self.scene.camera.target);
        if distance > 0.0 && distance.is_finite() {
            distance / 500.0
        } else {
            0.01
        }
    }
}

/// Draws all panels, one below the other.
pub fn panels_ui(ui: &mut Ui, state: &mut PanelState<'_>) {
    section_ui(ui, "Scene", true, |ui| tree::tree_ui(ui, state));
    material::settle_name(ui, state.scene, state.selection);
    let title = match state.selection {
        Selection::Camera => "Camera",
        Selection::Background => "Background",
        Selection::Object(_) => "Object",
        Selection::Light(_) => "Light",
        Selection::Material(_) => "Material",
    };
    section_ui(ui, title, true, |ui| properties_ui(ui, state));
    section_ui(ui, "Image", true, |ui| {
        settings::image_ui(ui, state);
        state.boxes.choice_ui(ui);
    });
    section_ui(ui, "Effects", true, |ui| settings::effects_ui(ui, state));
    section_ui(ui, "Plan", false, |ui| plan::plan_ui(ui, state));
    section_ui(ui, "Display", true, |ui| {
        if let Some(histogram) = state.histogram {
            *state.asked_pixel = histogram.histogram_ui(ui);
        }
        display::layers_ui(ui, state);
        display::channels_ui(ui, state.channels);
        display::display_ui(ui, state.scene);
    });
}

/// The properties of the selected part.
fn properties_ui(ui: &mut Ui, state: &mut PanelState<'_>) {
    for path in missing_files(state.scene, state.selection) {
        let path = Path::new(io::file_and_part(path).0);
        if missing_file_ui(ui, path) {
            *state.sought = Some(path.to_owned());
        }
    }
    match state.selection.clone() {
        Selection::Camera => camera::camera_ui(ui, state),
        Selection::Background => background::background_ui(ui, state),
        Selection::Object(index) => object::object_ui(ui, state, index),
        Selection::Light(index) => light::light_ui(ui, state, index),
        Selection::Material(name) => material::material_ui(ui, state, &name),
    }
}

/// Says that the file at `path` is not there; returns whether the user wants to say where it is.
fn missing_file_ui(ui: &mut Ui, path: &Path) -> bool {
    let text = RichText::new(format!("File missing: {}", path.display())).small();
    ui.label(text.color(ui.visuals().warn_fg_color))
        .on_hover_text(
            "It shows as soon as the file is there; until then the scene keeps its path",
        );
    let name = path.file_name().unwrap_or(path.as_os_str());
    ui.add(Button::new("Locate…").small())
        .accessible_name(format!("Locate {}", name.to_string_lossy()))
        .on_hover_text("Say where this file is now; what moved with it is found, too")
        .clicked()
}

/// The files of the selected part that are not there.
fn missing_files<'a>(scene: &'a Scene, selection: &Selection) -> Vec<&'a str> {
    let (object, material) = match selection {
        Selection::Camera | Selection::Light(_) => return Vec::new(),
        Selection::Background => return scene.absent_background().into_iter().collect(),
        Selection::Material(name) => (None, Some(name)),
        Selection::Object(index) => {
            let object = scene.objects.get(*index);
            let material = object.and_then(|object| object.material.as_ref());
            (object, material)
        }
    };
    let mesh = object.filter(|object| scene.lacks_mesh(object));
    let mesh = mesh.map(|object| &*object.mesh);
    let material = material.and_then(|name| scene.materials.get(name));
    let textures = material.into_iter();
    let textures = textures.flat_map(|material| scene.absent_textures(material));
    mesh.into_iter().chain(textures).collect()
}

/// A button for a command about the selected part.
fn command_button_ui(
    ui: &mut Ui,
    state: &mut PanelState<'_>,
    name: &str,
    command: Command,
    tooltip: &str,
) {
    if ui.button(name).on_hover_text(tooltip).clicked() {
        state.commands.push(command);
    }
}
