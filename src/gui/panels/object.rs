//! The properties of an object, and those of its material.

use std::path::Path;

use egui::{RichText, Ui};

use super::material::{new_material, reflectance_ui, take_preset_name};
use super::presets::presets_ui;
use super::{NAME_FIELD, PanelState, command_button_ui};
use crate::gui::commands::Command;
use crate::gui::widgets::{
    Number, combo_row_ui, number_row_ui, row_ui, switch_row_ui, vector_row_ui,
};
use crate::scene::{Object, Scene};

/// An object's properties, and those of its material.
pub fn object_ui(ui: &mut Ui, state: &mut PanelState<'_>, index: usize) {
    let speed = state.length_speed();
    if index >= state.scene.objects.len() {
        return;
    }
    identity_ui(ui, &mut state.scene.objects[index]);
    shape_ui(ui, &mut state.scene.objects[index], speed);
    material_choice_ui(ui, state.scene, index);
    if let Some(lost) = state.scene.lost_texture(&state.scene.objects[index]) {
        let text = format!("The material has {lost}: it does not show here");
        let color = ui.visuals().warn_fg_color;
        ui.label(RichText::new(text).small().color(color));
    }

    let object = &state.scene.objects[index];
    if let Some(name) = object.material.clone()
        && let Some(material) = state.scene.materials.get_mut(&name)
    {
        let taken = presets_ui(ui, state.balls, &name, material);
        let asked = reflectance_ui(ui, material);
        state.commands.extend(asked);
        if let Some(preset) = taken {
            take_preset_name(state.scene, &name, preset);
        }
    }
    ui.add_space(4.0);
    ui.horizontal_wrapped(|ui| {
        if ui
            .button("New material")
            .on_hover_text("Give this object a material of its own, a copy of the present one")
            .clicked()
        {
            let object = &state.scene.objects[index];
            let name = new_material(state.scene, object.material.clone().as_deref());
            state.scene.objects[index].material = Some(name);
        }
        for (name, command, tooltip) in [
            (
                "Duplicate object",
                Command::Duplicate,
                "Add an object like this one at the same place; they share their triangles",
            ),
            (
                "Remove object",
                Command::Remove,
                "Take this object out of the scene; its file stays",
            ),
        ] {
            command_button_ui(ui, state, name, command, tooltip);
        }
    });
}

fn identity_ui(ui: &mut Ui, object: &mut Object) {
    row_ui(ui, "Name", "What the object is called", |ui| {
        let id = egui::Id::unique(NAME_FIELD);
        let field = egui::TextEdit::singleline(&mut object.name).id(id);
        ui.add(field.desired_width(f32::INFINITY))
    });
    let file = Path::new(&object.mesh).file_name();
    let short = file.map_or_else(
        || object.mesh.clone(),
        |name| name.to_string_lossy().into_owned(),
    );
    row_ui(ui, "Mesh", &format!("From {}", object.mesh), |ui| {
        ui.add(egui::Label::new(RichText::new(short).weak()).truncate())
    });
}

fn shape_ui(ui: &mut Ui, object: &mut Object, length_speed: f64) {
    vector_row_ui(
        ui,
        "Position",
        "Moves the object, in scene units",
        &mut object.translate,
        &Number::any(length_speed),
    );
    let degrees = Number {
        decimals: 1,
        ..Number::any(0.5).with_suffix("°")
    };
    vector_row_ui(
        ui,
        "Rotation",
        "Turns about X, then Y, then Z, in degrees",
        &mut object.rotate,
        &degrees,
    );
    let before = object.scale;
    number_row_ui(
        ui,
        "Scale",
        "Size as a factor; a negative one mirrors",
        &mut object.scale,
        &Number::any((before.abs() * 0.005).max(1e-6)),
    );
    if object.scale == 0.0 || !object.scale.is_finite() {
        object.scale = before;
    }
    switch_row_ui(
        ui,
        "Smooth",
        "Shade across faces as if the surface were curved; off shows every face flat",
        &mut object.smooth,
    );
    if object.smooth {
        number_row_ui(
            ui,
            "Crease angle",
            "Edges whose faces meet at more than this angle stay sharp; 180° keeps none sharp",
            &mut object.crease_angle.0,
            &Number {
                decimals: 1,
                ..Number::within(0.0..=180.0, 0.5).with_suffix("°")
            },
        );
    }
    switch_row_ui(
        ui,
        "Repair winding",
        "Turn triangles so that each surface has one outer side and closed ones look outwards, as glass needs it; the file stays as it is",
        &mut object.repair_winding,
    );
}

fn material_choice_ui(ui: &mut Ui, scene: &mut Scene, index: usize) {
    let mut choices = vec![(None, "Default grey".to_owned())];
    choices.extend(
        scene
            .materials
            .keys()
            .map(|name| (Some(name.clone()), name.clone())),
    );
    combo_row_ui(
        ui,
        "Material",
        "How the surface reflects light; objects may share a material",
        &mut scene.objects[index].material,
        &choices,
    );
}
