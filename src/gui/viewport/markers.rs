//! The markers of lights in the preview, where they are and what the mouse does with them, and the box around the selected object.

use egui::{Color32, Pos2, Rect, Stroke, Ui, Vec2};

use super::{on_screen, picture_size};
use crate::gui::icons;
use crate::gui::orbit::{self, PictureSize};
use crate::gui::selection::Selection;
use crate::gui::theme;
use crate::math::{DVec2, DVec3};
use crate::scene::{Light, Scene};

/// Radius within which a marker is hit, in points.
const MARKER_REACH: f32 = 11.0;

/// What a marker stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mark {
    /// The light's place in the scene.
    pub light: usize,
    /// Whether it is what the light is turned towards.
    pub is_target: bool,
}

/// Draws the markers of the lights over the preview.
pub fn markers_ui(ui: &Ui, frame: Rect, scene: &Scene, selection: &Selection) {
    let painter = ui.painter().with_clip_rect(frame);
    for (index, light) in scene.lights.iter().enumerate() {
        let is_selected = *selection == Selection::Light(index);
        rim_ui(&painter, frame, scene, light, is_selected);
        if is_selected {
            target_ui(&painter, frame, scene, light);
        }
        let Some((position, _)) = marker_position(scene, frame, light.position()) else {
            continue;
        };
        marker(&painter, position, light.emission(), is_selected);
    }
}

/// Puts a light, or its target, under `to` at `depth`; not where the light would shine nowhere then.
pub fn move_light(scene: &mut Scene, size: PictureSize, mark: Mark, depth: f64, to: DVec2) {
    let Some(direction) = orbit::view_direction(&scene.camera, size, to) else {
        return;
    };
    let place = scene.camera.eye + direction * depth;
    let Some(light) = scene.lights.get_mut(mark.light) else {
        return;
    };
    let mut moved = *light;
    if mark.is_target {
        moved.turn_to(place);
    } else {
        moved.move_to(place);
    }
    let shines = match moved {
        Light::Point { .. } => true,
        Light::Disk { center, facing, .. } => facing.normal(center).is_some(),
    };
    if place.is_finite() && shines {
        *light = moved;
    }
}

/// Where the marker of a place is on the screen, and its depth.
fn marker_position(scene: &Scene, frame: Rect, place: DVec3) -> Option<(Pos2, f64)> {
    let (position, depth) = orbit::project(&scene.camera, picture_size(frame), place)?;
    #[expect(clippy::cast_possible_truncation, reason = "screen positions are f32")]
    let offset = Vec2::new(position.x as f32, position.y as f32);
    let position = frame.min + offset;
    frame.contains(position).then_some((position, depth))
}

/// What the marker under `position` stands for, and its depth; the nearest marker of several. Lights have one each, the selected one
/// also where it is turned towards.
pub fn marker_at(
    scene: &Scene,
    selection: &Selection,
    frame: Rect,
    position: Pos2,
) -> Option<(Mark, f64)> {
    let lights = scene.lights.iter().enumerate();
    let marks = lights.flat_map(|(index, light)| {
        let target = light
            .target()
            .filter(|_| *selection == Selection::Light(index));
        let mark = |is_target| Mark {
            light: index,
            is_target,
        };
        let place = [(mark(false), Some(light.position())), (mark(true), target)];
        place
            .into_iter()
            .filter_map(|(mark, place)| Some((mark, place?)))
    });
    let markers = marks.filter_map(|(mark, place)| {
        let (marker, depth) = marker_position(scene, frame, place)?;
        Some((mark, depth, marker.distance(position)))
    });
    markers
        .filter(|(_, _, distance)| *distance <= MARKER_REACH)
        .min_by(|a, b| a.2.total_cmp(&b.2))
        .map(|(mark, depth, _)| (mark, depth))
}

/// Draws what the selected light is turned towards.
fn target_ui(painter: &egui::Painter, frame: Rect, scene: &Scene, light: &Light) {
    let Some(target) = light.target() else { return };
    let ends = [light.position(), target].map(|end| on_screen(scene, frame, end));
    if let [Some(from), Some(to)] = ends {
        let stroke = Stroke::new(1.2, theme::ACCENT);
        let dashes = egui::Shape::dashed_line(&[from, to], stroke, 6.0, 5.0);
        painter.extend(dashes);
    }
    if let Some((center, _)) = marker_position(scene, frame, target) {
        painter.circle(
            center,
            6.0,
            Color32::from_black_alpha(120),
            Stroke::new(1.6, theme::ACCENT),
        );
        painter.circle_filled(center, 2.0, theme::ACCENT);
    }
}

/// A small sun of the light's colour.
fn marker(painter: &egui::Painter, center: Pos2, intensity: DVec3, selected: bool) {
    let edge = if selected {
        theme::ACCENT
    } else {
        Color32::from_black_alpha(170)
    };
    icons::sun(painter, center, 4.5, icons::hue_of(intensity), edge);
    if selected {
        painter.circle_stroke(center, 12.5, Stroke::new(1.6, theme::ACCENT));
    }
}

/// Draws the rim of a disk light.
fn rim_ui(painter: &egui::Painter, frame: Rect, scene: &Scene, light: &Light, is_selected: bool) {
    const CORNERS: u32 = 64;
    let Light::Disk {
        center,
        facing,
        radius,
        ..
    } = *light
    else {
        return;
    };
    let Some((x, y)) = facing.normal(center).map(DVec3::any_orthonormal_pair) else {
        return;
    };
    let corner = |index: u32| {
        let angle = std::f64::consts::TAU * f64::from(index) / f64::from(CORNERS);
        on_screen(
            scene,
            frame,
            center + (x * angle.cos() + y * angle.sin()) * radius,
        )
    };
    let color = if is_selected {
        theme::ACCENT
    } else {
        icons::hue_of(light.emission())
    };
    for index in 0..CORNERS {
        if let (Some(a), Some(b)) = (corner(index), corner(index + 1)) {
            painter.line_segment([a, b], Stroke::new(1.4, color));
        }
    }
}

/// Draws the edges of a box in the world, the selected object's. Bit `n` of a corner's number says which end of axis `n` it is at.
pub fn box_ui(ui: &Ui, frame: Rect, scene: &Scene, corners: &[DVec3; 8]) {
    let painter = ui.painter().with_clip_rect(frame);
    let corners = corners.map(|corner| on_screen(scene, frame, corner));
    let stroke = Stroke::new(1.0, theme::ACCENT.gamma_multiply(0.9));
    for from in 0..8_usize {
        for axis in 0..3 {
            let to = from | 1 << axis;
            if to != from
                && let (Some(a), Some(b)) = (corners[from], corners[to])
            {
                painter.line_segment([a, b], stroke);
            }
        }
    }
}
