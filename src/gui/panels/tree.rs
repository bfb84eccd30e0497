use egui::{Align, Layout, RichText, Ui};

use super::PanelState;
use super::light::new_light;
use super::material::new_material;
use crate::gui::selection::Selection;
use crate::gui::widgets::{counted, grouped};

/// Most points of height the tree takes before it scrolls.
const MOST_HEIGHT: f32 = 236.0;

/// The scene's parts: a click selects.
pub fn tree_ui(ui: &mut Ui, state: &mut PanelState<'_>) {
    egui::ScrollArea::vertical()
        .id_salt("scene tree")
        .max_height(MOST_HEIGHT)
        .auto_shrink([false, true])
        .show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 1.0;
            part_ui(ui, state, Selection::Camera, "🎥", "Camera", "");
            part_ui(ui, state, Selection::Background, "🌄", "Background", "");
            objects_ui(ui, state);
            lights_ui(ui, state);
            materials_ui(ui, state);
        });
}

fn objects_ui(ui: &mut Ui, state: &mut PanelState<'_>) {
    group_ui(ui, "Objects", state.scene.objects.len());
    for index in 0..state.scene.objects.len() {
        let object = &state.scene.objects[index];
        let triangles = state.scene.meshes.get(&object.mesh).map_or(0, |mesh| {
            (mesh.triangles.len() as u64).saturating_mul(object.copies.total())
        });
        let name = if object.name.is_empty() {
            format!("Object {}", index + 1)
        } else {
            object.name.clone()
        };
        let detail = format!("{} triangles", grouped(triangles));
        part_ui(ui, state, Selection::Object(index), "◼", &name, &detail);
    }
}

fn lights_ui(ui: &mut Ui, state: &mut PanelState<'_>) {
    let add = group_with_add_ui(ui, "Lights", state.scene.lights.len(), "Add light");
    if add {
        let light = new_light(state.scene, &state.bounds);
        state.scene.lights.push(light);
        *state.selection = Selection::Light(state.scene.lights.len() - 1);
    }
    for index in 0..state.scene.lights.len() {
        let name = format!("Light {}", index + 1);
        part_ui(ui, state, Selection::Light(index), "💡", &name, "point");
    }
}

fn materials_ui(ui: &mut Ui, state: &mut PanelState<'_>) {
    let add = group_with_add_ui(ui, "Materials", state.scene.materials.len(), "Add material");
    if add {
        let name = new_material(state.scene, None);
        *state.selection = Selection::Material(name);
    }
    let names: Vec<String> = state.scene.materials.keys().cloned().collect();
    for name in names {
        let users = state
            .scene
            .objects
            .iter()
            .filter(|object| object.material.as_ref() == Some(&name))
            .count();
        let detail = match users {
            0 => "unused".to_owned(),
            users => counted(users, "object", "objects"),
        };
        let part = Selection::Material(name.clone());
        part_ui(ui, state, part, "◑", &name, &detail);
    }
}

/// The heading of a group of parts.
fn group_ui(ui: &mut Ui, title: &str, count: usize) {
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        ui.label(RichText::new(format!("{title}  {count}")).weak().small());
    });
}

/// The heading of a group that can grow; returns whether it is to.
fn group_with_add_ui(ui: &mut Ui, title: &str, count: usize, add: &str) -> bool {
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        ui.label(RichText::new(format!("{title}  {count}")).weak().small());
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.add(egui::Button::new(RichText::new("+ Add").small()).small())
                .accessible_name(add)
                .on_hover_text(add)
                .clicked()
        })
        .inner
    })
    .inner
}

/// A row that selects a part of the scene.
fn part_ui(
    ui: &mut Ui,
    state: &mut PanelState<'_>,
    part: Selection,
    icon: &str,
    name: &str,
    detail: &str,
) {
    let is_selected = *state.selection == part;
    let width = ui.available_width();
    let text = RichText::new(format!("{icon}  {name}"));
    let button = egui::Button::selectable(is_selected, text)
        .right_text(RichText::new(detail).weak().small())
        .truncate()
        .min_size(egui::vec2(width, 22.0));
    let response = ui.add(button).accessible_name(format!("Select {name}"));
    if response.clicked() {
        *state.selection = part;
    }
}
