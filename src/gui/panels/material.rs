//! The properties of a material. Objects refer to it by name, so names are unique and a new one goes to its objects too.

use std::ops::RangeInclusive;
use std::path::Path;

use egui::{Event, Id, Key, RichText, Ui, Vec2};

use super::presets::{NEW_MATERIAL, has_usual_name, presets_ui};
use super::{NAME_FIELD, PanelState, command_button_ui};
use crate::analysis::contributions::Contributor;
use crate::gui::commands::{Command, TextureUse};
use crate::gui::edit;
use crate::gui::selection::Selection;
use crate::gui::widgets::{
    Number, color_row_ui, combo_row_ui, light_row_ui, number_row_ui, row_ui, switch_row_ui,
};
use crate::scene::{Material, Rgb, Scene, Textures, free_name};

/// Largest exponent the window offers; files may hold more.
const MOST_SHININESS: f64 = 1e7;
/// Indices of refraction the window offers; files may hold others.
const IORS: RangeInclusive<f64> = 0.1..=10.0;

/// A named material's properties.
pub fn material_ui(ui: &mut Ui, state: &mut PanelState<'_>, name: &str) {
    if let Some(new_name) = name_ui(ui, state.scene, name) {
        rename(state.scene, name, &new_name);
        *state.selection = Selection::Material(new_name);
        return;
    }
    let Some(material) = state.scene.materials.get_mut(name) else {
        return;
    };
    let taken = presets_ui(ui, state.balls, name, material);
    let asked = reflectance_ui(ui, material);
    state.commands.extend(asked);
    if let Some(preset) = taken {
        let name = take_preset_name(state.scene, name, preset);
        *state.selection = Selection::Material(name);
        return;
    }
    let contributor = Contributor::Emitter(name.to_owned());
    let contributions = &mut *state.contributions;
    contributions.row_ui(ui, &contributor, None, "Of the light in the picture");
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        command_button_ui(
            ui,
            state,
            "Duplicate material",
            Command::Duplicate,
            "Make a copy of this material under another name",
        );
        let is_removable = edit::is_removable(state.scene, state.selection);
        let remove = ui
            .add_enabled(is_removable, egui::Button::new("Remove material"))
            .on_hover_text("Take this material out of the scene")
            .on_disabled_hover_text(
                "An object uses this material; give the object another one first",
            );
        if remove.clicked() {
            state.commands.push(Command::Remove);
        }
    });
}

/// The kinds of material on offer.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Phong,
    Mirror,
    Glass,
    Emitter,
}

/// What the surface does with light; returns a command that was asked for.
pub fn reflectance_ui(ui: &mut Ui, material: &mut Material) -> Option<Command> {
    let before = match material {
        Material::Phong { .. } => Kind::Phong,
        Material::Mirror { .. } => Kind::Mirror,
        Material::Glass { .. } => Kind::Glass,
        Material::Emitter { .. } => Kind::Emitter,
    };
    let mut kind = before;
    let kinds = [
        (Kind::Phong, "Phong".to_owned()),
        (Kind::Mirror, "Mirror".to_owned()),
        (Kind::Glass, "Glass".to_owned()),
        (Kind::Emitter, "Emitter".to_owned()),
    ];
    combo_row_ui(
        ui,
        "Kind",
        "What the surface does with light",
        &mut kind,
        &kinds,
    );
    if kind != before {
        *material = match kind {
            Kind::Phong => Material::default(),
            Kind::Mirror => Material::mirror(),
            Kind::Glass => Material::glass(),
            Kind::Emitter => Material::emitter(),
        };
    }
    match material {
        Material::Phong {
            diffuse,
            specular,
            shininess,
            textures,
        } => {
            phong_ui(ui, diffuse, specular, shininess);
            return textures_ui(ui, textures);
        }
        Material::Mirror { reflectance } => {
            color_row_ui(
                ui,
                "Reflectance",
                "Share of the light that is reflected, per channel (linear, 0 to 1)",
                reflectance,
            );
        }
        Material::Glass { ior, attenuation } => {
            number_row_ui(
                ui,
                "Refraction",
                "Index of refraction: 1.33 is water, 1.5 window glass, 2.4 diamond; below 1 is a bubble",
                ior,
                &Number::within(IORS, 0.005),
            );
            light_row_ui(
                ui,
                "Absorption",
                "What the inside takes from each channel, per scene unit: light fades by exp(-absorption × distance)",
                attenuation,
                " / unit",
            );
        }
        Material::Emitter { radiance } => {
            light_row_ui(
                ui,
                "Radiance",
                "Colour, and emitted radiance in watts per square unit and steradian, on both sides",
                radiance,
                " W/m²/sr",
            );
        }
    }
    None
}

fn phong_ui(ui: &mut Ui, diffuse: &mut Rgb, specular: &mut Rgb, shininess: &mut f64) {
    color_row_ui(
        ui,
        "Diffuse",
        "Share of the light that leaves in all directions, per channel (linear, 0 to 1)",
        diffuse,
    );
    color_row_ui(
        ui,
        "Specular",
        "Share of the light that leaves in the highlight, per channel (linear, 0 to 1)",
        specular,
    );
    number_row_ui(
        ui,
        "Shininess",
        "Exponent of the highlight: larger is smaller and sharper",
        shininess,
        &Number::within(0.0..=MOST_SHININESS, (*shininess * 0.01).max(0.1)),
    );
    let total = (*diffuse + *specular).max_element();
    if total > Material::MAX_REFLECTANCE {
        ui.label(
            RichText::new("Diffuse and specular together reflect more light than arrives.")
                .small()
                .color(ui.visuals().warn_fg_color),
        );
    }
}

/// What varies over the surface; returns a command that was asked for.
fn textures_ui(ui: &mut Ui, textures: &mut Textures) -> Option<Command> {
    let diffuse = image_ui(
        ui,
        "Image",
        "Its colours multiply Diffuse, where the mesh has texture coordinates",
        &mut textures.diffuse_image,
    );
    let normals = image_ui(
        ui,
        "Normals",
        "Image of normals, by which the surface is bumpy where the mesh has texture coordinates",
        &mut textures.normal_image,
    );
    switch_row_ui(
        ui,
        "Vertex colours",
        "Whether the colours of the mesh's vertices, where it has some, multiply Diffuse",
        &mut textures.vertex_colors,
    );
    let asked = [
        (diffuse, TextureUse::Diffuse),
        (normals, TextureUse::Normals),
    ];
    let asked = asked.into_iter().find(|(asked, _)| *asked);
    asked.map(|(_, texture)| Command::SetTexture(texture))
}

/// The name of an image as a button that asks for another, and one that takes it off; returns whether another is asked for.
fn image_ui(ui: &mut Ui, label: &str, tooltip: &str, image: &mut Option<String>) -> bool {
    let path = image.clone();
    let name = path.as_ref().map(Path::new).and_then(Path::file_name);
    let name = name.map_or("none".into(), |name| name.to_string_lossy());
    let full = path.as_deref().unwrap_or("No image");
    let tooltip = format!("{full}\n{tooltip}. Click to choose one (.png, .jpg, .exr, .hdr)");
    let height = ui.spacing().interact_size.y;
    let response = row_ui(ui, label, &tooltip, |ui| {
        if image.is_some() {
            let off = ui.add(egui::Button::new("✖").min_size(Vec2::splat(height)));
            let off = off.on_hover_text("Take the image off");
            if off.accessible_name(format!("Take off {label}")).clicked() {
                *image = None;
            }
        }
        let size = Vec2::new(ui.available_width(), height);
        ui.add(egui::Button::new(name).truncate().min_size(size))
    });
    response.clicked()
}

/// A name that is being typed, and the material that is to have it.
#[derive(Clone, Debug)]
struct TypedName {
    material: String,
    text: String,
}

impl TypedName {
    fn id() -> Id {
        Id::unique("typed name of a material")
    }

    /// The name, where the material may have it: `None` where it has it already, or another one has.
    fn wanted(&self, scene: &Scene) -> Option<String> {
        let name = self.text.trim();
        let is_free = !name.is_empty() && !scene.materials.contains_key(name);
        is_free.then(|| name.to_owned())
    }
}

/// Gives a material the name that was typed for it, where another part was selected before that was confirmed.
pub fn settle_name(ui: &Ui, scene: &mut Scene, selection: &Selection) {
    let typed = ui.data(|data| data.get_temp::<TypedName>(TypedName::id()));
    let left = typed
        .filter(|typed| !matches!(selection, Selection::Material(name) if *name == typed.material));
    if let Some(typed) = left {
        ui.data_mut(|data| data.remove::<TypedName>(TypedName::id()));
        if let Some(name) = typed.wanted(scene) {
            rename(scene, &typed.material, &name);
        }
    }
}

/// The name as a text field; returns a new one that was confirmed and is free.
fn name_ui(ui: &mut Ui, scene: &Scene, name: &str) -> Option<String> {
    let id = TypedName::id();
    let typed = ui.data(|data| data.get_temp::<TypedName>(id));
    let mut typed = typed.unwrap_or_else(|| TypedName {
        material: name.to_owned(),
        text: name.to_owned(),
    });
    let response = row_ui(ui, "Name", "What objects call this material", |ui| {
        let field = egui::TextEdit::singleline(&mut typed.text).id(Id::unique(NAME_FIELD));
        ui.add(field.desired_width(f32::INFINITY))
    });
    let wanted = typed.text.trim();
    if wanted != name && scene.materials.contains_key(wanted) {
        let warning = "Another material has this name.";
        ui.label(
            RichText::new(warning)
                .small()
                .color(ui.visuals().warn_fg_color),
        );
    }
    if response.lost_focus() {
        ui.data_mut(|data| data.remove::<TypedName>(id));
        // It stands for a command too, which has taken it.
        let is_escape = |event: &Event| {
            matches!(
                event,
                Event::Key {
                    key: Key::Escape,
                    pressed: true,
                    ..
                }
            )
        };
        let is_given_up = ui.input(|input| input.raw.events.iter().any(is_escape));
        return typed.wanted(scene).filter(|_| !is_given_up);
    }
    if response.changed() {
        ui.data_mut(|data| data.insert_temp(id, typed));
    }
    None
}

/// Calls the material `from` `to`, in the objects too.
fn rename(scene: &mut Scene, from: &str, to: &str) {
    if let Some(material) = scene.materials.remove(from) {
        scene.materials.insert(to.to_owned(), material);
    }
    for object in &mut scene.objects {
        if object.material.as_deref() == Some(from) {
            object.material = Some(to.to_owned());
        }
    }
}

/// Calls the material `name` what the preset is called that it has become, unless somebody gave it that name; returns its name.
pub fn take_preset_name(scene: &mut Scene, name: &str, preset: &str) -> String {
    if !has_usual_name(name) {
        return name.to_owned();
    }
    let is_taken = |other: &str| other != name && scene.materials.contains_key(other);
    let new = free_name(preset, is_taken);
    rename(scene, name, &new);
    new
}

/// Adds a material, a copy of the one called `like` or the default one, and returns its name.
pub fn new_material(scene: &mut Scene, like: Option<&str>) -> String {
    let base = like.unwrap_or(NEW_MATERIAL);
    let material = like
        .and_then(|name| scene.materials.get(name).cloned())
        .unwrap_or_default();
    let name = free_name(base, |name| scene.materials.contains_key(name));
    scene.materials.insert(name.clone(), material);
    name
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Object;

    #[test]
    fn renaming_a_material_keeps_its_objects() {
        let mut scene = Scene::default();
        let clay = new_material(&mut scene, None);
        scene.objects.push(Object {
            material: Some(clay.clone()),
            ..Object::default()
        });
        rename(&mut scene, &clay, "terracotta");
        assert_eq!(scene.objects[0].material.as_deref(), Some("terracotta"));
        assert!(scene.material_of(&scene.objects[0]).is_ok());
        assert!(!scene.materials.contains_key(&clay));
        assert_eq!(new_material(&mut scene, Some("terracotta")), "terracotta 2");
    }

    #[test]
    fn a_preset_brings_its_name_unless_somebody_gave_one() {
        let mut scene = Scene::default();
        let new = new_material(&mut scene, None);
        scene.objects.push(Object {
            material: Some(new.clone()),
            ..Object::default()
        });
        assert_eq!(take_preset_name(&mut scene, &new, "Gold"), "Gold");
        assert_eq!(scene.objects[0].material.as_deref(), Some("Gold"));
        assert_eq!(take_preset_name(&mut scene, "Gold", "Gold"), "Gold");
        let second = new_material(&mut scene, None);
        assert_eq!(take_preset_name(&mut scene, &second, "Gold"), "Gold 2");
        scene.materials.insert("clear".into(), Material::glass());
        assert_eq!(take_preset_name(&mut scene, "clear", "Gold"), "clear");
        assert_eq!(scene.materials.len(), 3);
    }
}
