use egui::{Align, Color32, Layout, Rect, RichText, Ui, Vec2};

use super::PanelState;
use super::light::new_light;
use super::material::new_material;
use crate::gui::commands::Command;
use crate::gui::edit;
use crate::gui::icons::{self, Icon, color_of, hue_of};
use crate::gui::preview::uniforms::MAX_LIGHTS;
use crate::gui::selection::Selection;
use crate::gui::widgets::{counted, faint_text, grouped};
use crate::scene::{Background, Light, Material, NamedLight, Rgb, Scene};

/// Most points of height the tree takes before it scrolls.
const MOST_HEIGHT: f32 = 320.0;

/// The scene's parts: a click selects.
pub fn tree_ui(ui: &mut Ui, state: &mut PanelState<'_>) {
    egui::ScrollArea::vertical()
        .id_salt("scene tree")
        .max_height(MOST_HEIGHT)
        .auto_shrink([false, true])
        .show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 1.0;
            part_ui(ui, state, &Selection::Camera, Icon::Camera, "Camera", "");
            let background = background_icon(state.scene);
            part_ui(
                ui,
                state,
                &Selection::Background,
                background,
                "Background",
                "",
            );
            let count = state.scene.objects.len();
            if group_ui(ui, "Objects", count, true, "Add object", |ui| {
                objects_ui(ui, state);
            }) {
                state.commands.push(Command::AddMesh);
            }
            let count = state.scene.lights.len();
            if group_ui(ui, "Lights", count, true, "Add light", |ui| {
                lights_ui(ui, state);
            }) {
                let light = new_light(state.scene);
                let light = state.scene.add_light(NamedLight {
                    name: String::new(),
                    light,
                });
                *state.selection = Selection::Light(light);
            }
            let count = state.scene.materials.len();
            if group_ui(ui, "Materials", count, false, "Add material", |ui| {
                materials_ui(ui, state);
            }) {
                let name = new_material(state.scene, None);
                *state.selection = Selection::Material(name);
            }
        });
}

fn objects_ui(ui: &mut Ui, state: &mut PanelState<'_>) {
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
        let material = state.scene.material_of(object).unwrap_or_default();
        let icon = Icon::Object(material_color(&material));
        let detail = format!("{} triangles", grouped(triangles));
        part_ui(ui, state, &Selection::Object(index), icon, &name, &detail);
    }
}

fn lights_ui(ui: &mut Ui, state: &mut PanelState<'_>) {
    if state.scene.lights.len() > MAX_LIGHTS {
        let note = format!("The preview shows the first {MAX_LIGHTS}, the picture all.");
        ui.label(RichText::new(note).weak().small());
    }
    for index in 0..state.scene.lights.len() {
        let name = match state.scene.light_name(index) {
            "" => format!("Light {}", index + 1),
            name => name.to_owned(),
        };
        let light = state.scene.lights[index];
        let icon = Icon::Light(hue_of(light.emission()));
        let kind = match light {
            Light::Point { .. } => "point",
            Light::Disk { .. } => "disk",
        };
        part_ui(ui, state, &Selection::Light(index), icon, &name, kind);
    }
}

fn materials_ui(ui: &mut Ui, state: &mut PanelState<'_>) {
    let names: Vec<String> = state.scene.materials.keys().cloned().collect();
    for name in names {
        let detail = match users(state.scene, &name) {
            0 => "unused".to_owned(),
            users => counted(users, "object", "objects"),
        };
        let material = &state.scene.materials[&name];
        // Of rows that are scrolled out of sight, nothing is rendered.
        let row = Rect::from_min_size(ui.cursor().min, Vec2::splat(icons::SIDE));
        let is_seen = ui.is_rect_visible(row);
        let ball = is_seen.then(|| state.balls.texture(Some(&name), material));
        let icon = match ball.flatten() {
            Some(ball) => Icon::Ball(ball),
            None => Icon::Material(material_color(material)),
        };
        let part = Selection::Material(name.clone());
        part_ui(ui, state, &part, icon, &name, &detail);
    }
}

/// How many objects use the material called `name`.
fn users(scene: &Scene, name: &str) -> usize {
    let uses = |object: &&crate::scene::Object| object.material.as_deref() == Some(name);
    scene.objects.iter().filter(uses).count()
}

/// A group of parts that folds. `add`: what its button to add one is called. Returns whether one is to be added.
fn group_ui(
    ui: &mut Ui,
    title: &str,
    count: usize,
    open: bool,
    add: &str,
    parts: impl FnOnce(&mut Ui),
) -> bool {
    ui.add_space(3.0);
    let id = ui.make_persistent_id(("group", title));
    let state =
        egui::collapsing_header::CollapsingState::load_with_default_open(ui.ctx(), id, open);
    let (_, header, _) = state
        .show_header(ui, |ui| {
            ui.label(RichText::new(format!("{title}  {count}")).weak());
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                ui.add(egui::Button::new(RichText::new("+ Add").small()).small())
                    .accessible_name(add)
                    .on_hover_text(add)
                    .clicked()
            })
            .inner
        })
        .body_unindented(parts);
    header.inner
}

/// A row that selects a part of the scene.
fn part_ui(
    ui: &mut Ui,
    state: &mut PanelState<'_>,
    part: &Selection,
    icon: Icon,
    name: &str,
    detail: &str,
) {
    let is_selected = state.selection == part;
    let width = ui.available_width();
    // Room for the icon, which is painted over it.
    let room = egui::AtomExt::atom_size("", Vec2::splat(icons::SIDE));
    let button = egui::Button::selectable(is_selected, (room, name))
        .right_text(faint_text(ui, detail, is_selected).small())
        .truncate()
        .min_size(Vec2::new(width, 22.0));
    let response = ui.add(button).accessible_name(format!("Select {name}"));
    let ink = ui.style().interact_selectable(&response, is_selected);
    let center = response.rect.left_center() + Vec2::new(8.0 + icons::SIDE / 2.0, 0.0);
    icon.paint(ui.painter(), center, ink.text_color());
    if response.clicked() || response.secondary_clicked() {
        *state.selection = part.clone();
    }
    if edit::name_of(state.scene, part).is_some() {
        response.context_menu(|ui| part_menu_ui(ui, state, part));
    }
}

/// What can be done with a part.
fn part_menu_ui(ui: &mut Ui, state: &mut PanelState<'_>, part: &Selection) {
    for command in [
        Command::Copy,
        Command::Duplicate,
        Command::Rename,
        Command::Remove,
    ] {
        let can = match command {
            Command::Rename => part.has_name(),
            Command::Remove => edit::is_removable(state.scene, part),
            _ => true,
        };
        let button = egui::Button::new(command.label());
        let button = button.shortcut_text(command.shortcut_text(ui.ctx()));
        let response = ui.add_enabled(can, button);
        let response = response.accessible_name(command.label());
        if response.on_hover_text(command.description()).clicked() {
            state.commands.push(command);
            ui.close();
        }
    }
}

fn material_color(material: &Material) -> Color32 {
    color_of(material.color())
}

fn background_icon(scene: &Scene) -> Icon {
    let (sky, ground) = match &scene.background {
        Background::Constant { radiance } => (*radiance, *radiance),
        Background::Gradient { zenith, ground, .. } => (*zenith, *ground),
        Background::Image { scale, .. } => {
            let map = scene.background_image().ok().flatten();
            // Halfway up and halfway down, straight ahead.
            let [above, below] = [1, 3].map(|quarter| {
                map.map_or(Rgb::ZERO, |map| {
                    let row = map.row(map.height() * quarter / 4);
                    let pixel = row[row.len() / 2];
                    Rgb::from_array(pixel.map(f64::from)) * *scale
                })
            });
            (above, below)
        }
    };
    Icon::Background {
        sky: color_of(sky),
        ground: color_of(ground),
    }
}
