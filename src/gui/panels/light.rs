//! The properties of a light, and where a new one is put.

use std::f64::consts::PI;

use egui::Ui;

use super::{NAME_FIELD, PanelState, command_button_ui};
use crate::analysis::contributions::Contributor;
use crate::gui::commands::Command;
use crate::gui::edit;
use crate::gui::orbit;
use crate::gui::preview::uniforms::picture_size;
use crate::gui::widgets::{
    Number, choice_row_ui, light_row_ui, number_row_ui, row_ui, switch_row_ui, vector_row_ui,
};
use crate::math::{DVec2, DVec3};
use crate::scene::{Camera, Choice, Facing, Light, Rgb, Scene};

/// The kinds of light on offer.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Point,
    Disk,
}

impl Choice for Kind {
    const ALL: &'static [(Self, &'static str)] = &[(Self::Point, "point"), (Self::Disk, "disk")];
}

/// A light's name.
fn name_ui(ui: &mut Ui, scene: &mut Scene, index: usize) {
    let mut name = scene.light_name(index).to_owned();
    let response = row_ui(ui, "Name", "What the light is called", |ui| {
        let field = egui::TextEdit::singleline(&mut name)
            .id(egui::Id::unique(NAME_FIELD))
            .hint_text(edit::usual_light_name(index));
        ui.add(field.desired_width(f32::INFINITY))
    });
    if response.changed() {
        scene.name_light(index, name);
    }
}

/// A light's properties.
pub fn light_ui(ui: &mut Ui, state: &mut PanelState<'_>, index: usize) {
    let length = Number::any(state.length_speed());
    let camera = state.scene.camera;
    if index >= state.scene.lights.len() {
        return;
    }
    name_ui(ui, state.scene, index);
    let light = &mut state.scene.lights[index];
    let before = match light {
        Light::Point { .. } => Kind::Point,
        Light::Disk { .. } => Kind::Disk,
    };
    let mut kind = before;
    choice_row_ui(
        ui,
        "Kind",
        "A point casts sharp shadows, a disk soft ones",
        &mut kind,
        |kind| match kind {
            Kind::Point => ("Point", "Shines from one point in all directions"),
            Kind::Disk => (
                "Disk",
                "Shines from one side of a disk, which is seen itself",
            ),
        },
    );
    if kind != before {
        *light = of_other_kind(light, &camera);
    }
    match light {
        Light::Point {
            position,
            intensity,
        } => {
            vector_row_ui(
                ui,
                "Position",
                "Where the light is, in scene units; its marker in the preview can be dragged",
                position,
                &length,
            );
            light_row_ui(
                ui,
                "Intensity",
                "Colour, and radiant intensity in watts per steradian; what arrives falls with the squared distance",
                intensity,
                " W/sr",
            );
        }
        Light::Disk {
            center,
            facing,
            radius,
            radiance,
            visible,
        } => {
            vector_row_ui(
                ui,
                "Center",
                "Middle of the disk, in scene units; its marker in the preview can be dragged",
                center,
                &length,
            );
            facing_ui(ui, *center, facing, &length);
            number_row_ui(
                ui,
                "Radius",
                "Radius of the disk, in scene units: larger casts softer shadows",
                radius,
                &Number {
                    range: f64::MIN_POSITIVE..=f64::MAX,
                    ..length
                },
            );
            light_row_ui(
                ui,
                "Radiance",
                "Colour, and emitted radiance in watts per square unit and steradian",
                radiance,
                " W/m²/sr",
            );
            switch_row_ui(
                ui,
                "Visible",
                "Whether the disk itself is seen, in the picture and in mirrors",
                visible,
            );
        }
    }
    let contributor = Contributor::Light(index);
    let contributions = &mut *state.contributions;
    contributions.row_ui(ui, &contributor, None, "Of the light in the picture");
    copy_and_remove_ui(ui, state);
}

fn copy_and_remove_ui(ui: &mut Ui, state: &mut PanelState<'_>) {
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        for (name, command, tooltip) in [
            (
                "Duplicate light",
                Command::Duplicate,
                "Add a light like this one at the same place",
            ),
            (
                "Remove light",
                Command::Remove,
                "Take this light out of the scene",
            ),
        ] {
            command_button_ui(ui, state, name, command, tooltip);
        }
    });
}

/// Where a disk shines. A direction that is none is not taken over.
fn facing_ui(ui: &mut Ui, center: DVec3, facing: &mut Facing, length: &Number) {
    let mut wanted = *facing;
    match &mut wanted {
        Facing::Target(target) => vector_row_ui(
            ui,
            "Aims at",
            "The point the disk shines towards, in scene units",
            target,
            length,
        ),
        Facing::Normal(normal) => vector_row_ui(
            ui,
            "Direction",
            "Where the disk shines; any length",
            normal,
            &Number::any(0.01),
        ),
    };
    if wanted.normal(center).is_some() {
        *facing = wanted;
    }
}

/// The light of the other kind in the same place, about as bright from a distance; a disk is a tenth as wide as the
/// camera's target is away, and faces that target.
fn of_other_kind(light: &Light, camera: &Camera) -> Light {
    match *light {
        Light::Point {
            position,
            intensity,
        } => {
            let radius = 0.05 * camera.eye.distance(camera.target);
            let facing = match Facing::Target(camera.target) {
                facing if facing.normal(position).is_some() => facing,
                _ => Facing::Normal(-camera.up),
            };
            Light::Disk {
                center: position,
                facing,
                radius,
                radiance: intensity / (PI * radius * radius),
                visible: true,
            }
        }
        Light::Disk {
            center,
            radius,
            radiance,
            ..
        } => Light::Point {
            position: center,
            intensity: radiance * (PI * radius * radius),
        },
    }
}

/// A light that the camera sees, up and to the right before its target, and about as bright there as a lit room.
pub fn new_light(scene: &Scene) -> Light {
    const PLACE: DVec2 = DVec2::new(0.65, 0.18);
    const DEPTH: f64 = 0.8;
    let camera = &scene.camera;
    let distance = camera.eye.distance(camera.target);
    let size = picture_size(scene);
    let place = PLACE * DVec2::new(size.width, size.height);
    let direction = orbit::view_direction(camera, size, place).unwrap_or(DVec3::ZERO);
    let position = camera.eye + direction * (distance * DEPTH);
    // Irradiance 2 at the target, for a surface that faces the light.
    let intensity = Rgb::splat(2.0 * position.distance_squared(camera.target));
    Light::Point {
        position,
        intensity,
    }
}
