//! The list of the scene's parts: a click selects, a menu renames, copies and removes.

use std::collections::HashMap;
use std::ops::Range;

use egui::{Align, Color32, Id, Layout, Rangef, Rect, RichText, Ui, Vec2};

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
/// Height of a row, in points.
const ROW_HEIGHT: f32 = 22.0;
/// How long the list keeps to a part that was added, in seconds.
const REVEAL_SECS: f64 = 0.4;
/// Names of more letters may not be seen whole.
const LONG_NAME: usize = 20;
/// Most rows of a group that are all laid out, in about half a millisecond of a frame: who hears the window rather than seeing it finds
/// every part then, wherever the list is scrolled to. Of more, only those near the visible ones are there.
const MOST_ROWS: usize = 200;

/// What is said beside a part whose file is not there.
const FILE_MISSING: &str = "file missing";

/// The scene's parts: a click selects.
pub fn tree_ui(ui: &mut Ui, state: &mut PanelState<'_>) {
    egui::ScrollArea::vertical()
        .id_salt("scene tree")
        .max_height(MOST_HEIGHT)
        .auto_shrink([false, true])
        .show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 1.0;
            let added = Added::now(ui, state.selection);
            part_ui(ui, state, &Selection::Camera, Icon::Camera, "Camera", "");
            let background = background_icon(state.scene);
            let detail = state.scene.absent_background().map_or("", |_| FILE_MISSING);
            part_ui(
                ui,
                state,
                &Selection::Background,
                background,
                "Background",
                detail,
            );
            let count = state.scene.objects.len();
            let new = added.then(|| state.selection.object()).flatten();
            if group_ui(ui, ["Objects", "Add object"], count, (true, new), |ui| {
                rows_ui(ui, count, |ui, rows| objects_ui(ui, state, rows));
            }) {
                Added::expect(ui, state.selection);
                state.commands.push(Command::AddMesh);
            }
            let count = state.scene.lights.len();
            let new = added.then(|| state.selection.light()).flatten();
            if group_ui(ui, ["Lights", "Add light"], count, (true, new), |ui| {
                if count > MAX_LIGHTS {
                    let note =
                        format!("The preview shows the first {MAX_LIGHTS}, the picture all.");
                    ui.label(RichText::new(note).weak().small());
                }
                rows_ui(ui, count, |ui, rows| lights_ui(ui, state, rows));
            }) {
                Added::expect(ui, state.selection);
                let light = new_light(state.scene);
                let named = NamedLight {
                    name: String::new(),
                    light,
                };
                let light = edit::add_light(state.scene, named);
                *state.selection = Selection::Light(light);
            }
            let count = state.scene.materials.len();
            let new = added.then(|| place_of_material(state)).flatten();
            let names = ["Materials", "Add material"];
            if group_ui(ui, names, count, (false, new), |ui| {
                rows_ui(ui, count, |ui, rows| materials_ui(ui, state, rows));
            }) {
                Added::expect(ui, state.selection);
                let name = new_material(state.scene, None);
                *state.selection = Selection::Material(name);
            }
        });
}

/// That a part is being added by a button of the list: once it is selected, the list scrolls to it.
#[derive(Clone, Debug)]
struct Added {
    /// What was selected when the button was pressed.
    before: Selection,
    /// Since when the new part is selected, in seconds.
    since: Option<f64>,
}

impl Added {
    fn id() -> Id {
        Id::unique("part added by the list")
    }

    /// A button that adds a part was pressed.
    fn expect(ui: &Ui, selection: &Selection) {
        let added = Self {
            before: selection.clone(),
            since: None,
        };
        ui.data_mut(|data| data.insert_temp(Self::id(), added));
    }

    /// Whether the part that is selected was added just now.
    fn now(ui: &Ui, selection: &Selection) -> bool {
        let now = ui.input(|input| input.time);
        let Some(mut added) = ui.data(|data| data.get_temp::<Self>(Self::id())) else {
            return false;
        };
        if added.since.is_none() && added.before == *selection {
            return false;
        }
        // As long as the group takes to unfold.
        let is_done = now > *added.since.get_or_insert(now) + REVEAL_SECS;
        ui.data_mut(|data| {
            if is_done {
                data.remove::<Self>(Self::id());
            } else {
                data.insert_temp(Self::id(), added);
            }
        });
        if !is_done {
            ui.request_repaint();
        }
        !is_done
    }
}

/// The place of the selected material among all.
fn place_of_material(state: &PanelState<'_>) -> Option<usize> {
    let Selection::Material(selected) = &*state.selection else {
        return None;
    };
    let mut names = state.scene.materials.keys();
    names.position(|name| name == selected)
}

fn objects_ui(ui: &mut Ui, state: &mut PanelState<'_>, rows: Range<usize>) {
    for index in rows {
        let object = &state.scene.objects[index];
        let name = if object.name.trim().is_empty() {
            format!("Object {}", index + 1)
        } else {
            object.name.clone()
        };
        let material = state.scene.material_of(object).unwrap_or_default();
        let icon = Icon::Object(material_color(state.scene, &material));
        let detail = if state.scene.lacks_mesh(object) {
            FILE_MISSING.to_owned()
        } else {
            format!("{} triangles", grouped(state.scene.triangles_of(object)))
        };
        part_ui(ui, state, &Selection::Object(index), icon, &name, &detail);
    }
}

fn lights_ui(ui: &mut Ui, state: &mut PanelState<'_>, rows: Range<usize>) {
    for index in rows {
        let name = match state.scene.light_name(index) {
            name if name.trim().is_empty() => edit::usual_light_name(index),
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

fn materials_ui(ui: &mut Ui, state: &mut PanelState<'_>, rows: Range<usize>) {
    let names = state.scene.materials.keys().skip(rows.start);
    let names: Vec<String> = names.take(rows.len()).cloned().collect();
    let users = users_of(&names, state.scene);
    for (name, users) in names.iter().zip(users) {
        let detail = match users {
            0 => "unused".to_owned(),
            users => counted(users, "object", "objects"),
        };
        let material = &state.scene.materials[name];
        let is_bare = state.scene.absent_textures(material).next().is_some();
        let detail = if is_bare {
            FILE_MISSING.to_owned()
        } else {
            detail
        };
        // Of rows that are scrolled out of sight, nothing is rendered.
        let row = Rect::from_min_size(ui.cursor().min, Vec2::splat(icons::SIDE));
        let is_seen = ui.is_rect_visible(row);
        let ball = is_seen.then(|| state.balls.texture(Some(name), material));
        let icon = match ball.flatten() {
            Some(ball) => Icon::Ball(ball),
            None => Icon::Material(material_color(state.scene, material)),
        };
        let part = Selection::Material(name.clone());
        part_ui(ui, state, &part, icon, name, &detail);
    }
}

/// How many objects use each of the materials called `names`.
fn users_of(names: &[String], scene: &Scene) -> Vec<usize> {
    let places = names.iter().map(String::as_str).zip(0..);
    let places: HashMap<&str, usize> = places.collect();
    let mut users = vec![0; names.len()];
    let used = scene.objects.iter().filter_map(|o| o.material.as_deref());
    for place in used.filter_map(|name| places.get(name)) {
        users[*place] += 1;
    }
    users
}

/// Lays out a list of `count` rows: `parts` draws those of a range, the others only take their place.
fn rows_ui(ui: &mut Ui, count: usize, parts: impl FnOnce(&mut Ui, Range<usize>)) {
    let step = ROW_HEIGHT + ui.spacing().item_spacing.y;
    let rows = if count <= MOST_ROWS {
        0..count
    } else {
        // As much again above and below is there for keys and for who hears the window.
        let near = ui.clip_rect().y_range().expand(MOST_HEIGHT);
        rows_in(near, ui.cursor().top(), step, count)
    };
    let leave_out = |ui: &mut Ui, rows: usize| {
        if rows > 0 {
            ui.add_space(rows as f32 * step);
            // What is known of a row, such as whether it has the focus, is known by its place in the list.
            ui.skip_ahead_auto_ids(rows);
        }
    };
    leave_out(ui, rows.start);
    let rest = count - rows.end;
    parts(ui, rows);
    leave_out(ui, rest);
}

/// Which of `count` rows lie in `span`, where the first begins at `top` and each takes `step` points.
fn rows_in(span: Rangef, top: f32, step: f32, count: usize) -> Range<usize> {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "what is negative is before the first row"
    )]
    let rows_before = |y: f32, round: fn(f32) -> f32| (round((y - top) / step) as usize).min(count);
    let first = rows_before(span.min, f32::floor);
    first..rows_before(span.max, f32::ceil).max(first)
}

/// A group of parts that folds, and what its button to add one is called. `new`: the place of one that was just added and is to be seen.
/// Returns whether one is to be added.
fn group_ui(
    ui: &mut Ui,
    [title, add]: [&str; 2],
    count: usize,
    (open, new): (bool, Option<usize>),
    parts: impl FnOnce(&mut Ui),
) -> bool {
    ui.add_space(3.0);
    let id = ui.make_persistent_id(("group", title));
    let mut state =
        egui::collapsing_header::CollapsingState::load_with_default_open(ui.ctx(), id, open);
    if new.is_some() {
        state.set_open(true);
    }
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
        .body_unindented(|ui| {
            if let Some(place) = new {
                // Twice as high, as a note may stand before the rows.
                let step = ROW_HEIGHT + ui.spacing().item_spacing.y;
                let top = ui.cursor().min + Vec2::new(0.0, place as f32 * step);
                let row = Rect::from_min_size(top, Vec2::new(1.0, 2.0 * ROW_HEIGHT));
                ui.scroll_to_rect(row, None);
            }
            parts(ui);
        });
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
    // Of both, the name gives way where the room ends.
    let name_shown = egui::AtomExt::atom_shrink(name, true);
    let button = egui::Button::selectable(is_selected, (room, name_shown))
        .right_text(faint_text(ui, detail, is_selected).small())
        .truncate()
        .min_size(Vec2::new(width, ROW_HEIGHT));
    let mut response = ui.add(button).accessible_name(format!("Select {name}"));
    if name.chars().count() > LONG_NAME {
        response = response.on_hover_text(name);
    }
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

/// One colour to know a material by: with an image on it, that of all of it.
fn material_color(scene: &Scene, material: &Material) -> Color32 {
    let name = material.textures().and_then(|t| t.diffuse_image.as_ref());
    let image = name.and_then(|name| scene.textures.get(name));
    let tint = image.map_or(Rgb::ONE, |image| image.mean_color());
    color_of(material.color() * tint)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Object;

    #[test]
    fn rows_are_those_that_reach_into_what_is_seen() {
        let seen = |min, max| rows_in(Rangef::new(min, max), 100.0, 23.0, 1000);
        assert_eq!(seen(100.0, 123.0), 0..1);
        assert_eq!(seen(122.0, 124.0), 0..2);
        assert_eq!(seen(330.0, 653.0), 10..25);
        assert_eq!(seen(-300.0, 50.0), 0..0);
        assert_eq!(seen(23_000.0, 24_000.0), 995..1000);
        assert_eq!(seen(40_000.0, 40_100.0), 1000..1000);
        assert_eq!(seen(f32::INFINITY, f32::NEG_INFINITY), 1000..1000);
    }

    #[test]
    fn objects_are_counted_for_the_material_that_they_name() {
        let of = |material: Option<&str>| Object {
            material: material.map(str::to_owned),
            ..Object::default()
        };
        let materials = [Some("clay"), None, Some("clay"), Some("glass"), Some("tin")];
        let scene = Scene {
            objects: materials.map(of).into(),
            ..Scene::default()
        };
        let names = ["clay", "gold", "tin"].map(str::to_owned);
        assert_eq!(users_of(&names, &scene), [2, 0, 1]);
    }
}
