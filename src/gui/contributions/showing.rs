//! Pictures of what effects and lights bring: beside their switches, larger under the mouse, and in a window of their own.

use std::sync::Arc;

use egui::text::LayoutJob;
use egui::{
    Align, Color32, ColorImage, CornerRadius, FontSelection, Layout, Pos2, Rect, Response,
    RichText, Sense, Stroke, StrokeKind, TextureHandle, TextureOptions, Ui, Vec2,
};

use super::{Contributions, Shown};
use crate::analysis::contributions::{Contribution, Contributor, Figures, color_of_share};
use crate::gui::costs::{self, EffectCost};
use crate::gui::theme;
use crate::gui::widgets::{format_number, percent};
use crate::render::{Image, display};
use crate::scene::Display;

/// Height of a picture in a row, and the most of its width, in points.
const THUMBNAIL: Vec2 = Vec2::new(72.0, 36.0);
/// The same of the larger one under the mouse, and of that in a window.
const LARGER: Vec2 = Vec2::new(320.0, 240.0);
const LARGEST: Vec2 = Vec2::new(560.0, 420.0);
/// Parts of the legend's bar.
const PARTS: u16 = 32;

/// What a window of its own shows.
pub(super) struct Opened {
    contributor: Contributor,
    view: OpenedView,
    /// The picture with and without, of what and as what they are shown.
    pictures: Option<(Arc<Contribution>, Display, [TextureHandle; 2])>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum OpenedView {
    Change,
    With,
    Without,
}

impl Contributions {
    /// A row of the panel with what `contributor` brings at its right, and what it takes of the time; the row alone where that is nothing.
    pub fn beside_ui(
        &mut self,
        ui: &mut Ui,
        contributor: &Contributor,
        cost: Option<EffectCost>,
        row: impl FnOnce(&mut Ui),
    ) {
        if !self.present.contains(contributor) {
            return costs::beside_ui(ui, cost, row);
        }
        let size = Vec2::new(ui.available_width(), THUMBNAIL.y);
        ui.allocate_ui_with_layout(size, Layout::right_to_left(Align::Center), |ui| {
            self.picture_ui(ui, contributor);
            self.share_ui(ui, contributor, cost);
            ui.with_layout(Layout::left_to_right(Align::Center), row);
        });
    }

    /// A row that says in numbers what `contributor` brings and takes, with `text` as what that is, and shows it at its right; nothing where
    /// it brings and takes nothing.
    pub fn row_ui(
        &mut self,
        ui: &mut Ui,
        contributor: &Contributor,
        cost: Option<EffectCost>,
        text: &str,
    ) {
        if cost.is_some() || self.present.contains(contributor) {
            self.beside_ui(ui, contributor, cost, |ui| {
                ui.add(egui::Label::new(text).truncate());
            });
        }
    }

    /// The mean change that `contributor` brings, and below it what it takes of the time.
    fn share_ui(&self, ui: &mut Ui, contributor: &Contributor, cost: Option<EffectCost>) {
        let known = self.known(contributor);
        let share = known.map_or_else(|| "…".to_owned(), |known| signed_share(&known.figures));
        let error = known.and_then(|known| error_of_share(&known.figures));
        let error = error.map_or_else(String::new, |error| {
            format!("; noise puts it off by {error} at most, in 95 of 100 cases")
        });
        let mut tooltip =
            format!("Mean of the change, as a share of the mean of the picture{error}");
        let mut text = LayoutJob::default();
        let mut add = |line: RichText| {
            line.append_to(&mut text, ui.style(), FontSelection::Default, Align::Center);
        };
        add(RichText::new(share).weak());
        if let Some(cost) = cost {
            add(RichText::new("\n").small());
            add(cost.text(ui));
            tooltip = format!("{tooltip}\n\n{}", cost.explanation());
        }
        ui.label(text).on_hover_text(tooltip);
    }

    /// The small picture of what `contributor` brings: larger under the mouse, in a window of its own by a click.
    fn picture_ui(&mut self, ui: &mut Ui, contributor: &Contributor) {
        let size = self.fitted(THUMBNAIL);
        let (rect, response) = ui.allocate_exact_size(size, Sense::click());
        let name = self.name_of(contributor);
        response.widget_info(|| {
            let label = format!("Contribution of {name}");
            egui::WidgetInfo::labeled(egui::Role::Button, ui.is_enabled(), label)
        });
        let known = self.find(contributor);
        let is_current = known.is_some_and(|known| known.is_current);
        let shown = known.and_then(|known| known.shown.clone());
        // Of rows that are scrolled out of sight, nothing is rendered.
        if !ui.is_rect_visible(rect) {
            return;
        }
        paint(ui, rect, &response, shown.as_ref(), is_current);
        if !is_current && !self.missing.contains(contributor) {
            self.missing.push(contributor.clone());
        }
        let Some(shown) = shown else {
            response.on_hover_text(if is_current {
                "It cannot be rendered without"
            } else {
                "Rendered with and without, when nothing else is rendered and you rest"
            });
            return;
        };
        if response.clicked() {
            self.opened = Some(Opened {
                contributor: contributor.clone(),
                view: OpenedView::Change,
                pictures: None,
            });
        }
        let larger = self.fitted(LARGER);
        response.on_hover_ui(|ui| {
            ui.set_max_width(larger.x);
            ui.label(RichText::new(format!("Contribution of {name}")).strong());
            ui.image((shown.change.id(), larger));
            details_ui(ui, &shown.contribution.figures, larger.x);
            ui.label(
                RichText::new("Click for a window of its own")
                    .weak()
                    .small(),
            );
        });
    }

    /// The largest size of the picture's shape within `most`.
    fn fitted(&self, most: Vec2) -> Vec2 {
        let size = self.scene.as_ref().map_or(Vec2::new(16.0, 9.0), |scene| {
            Vec2::new(scene.render.width as f32, scene.render.height as f32)
        });
        size * (most / size).min_elem()
    }

    /// Whether what was clicked last has a window.
    #[must_use]
    pub fn is_window_open(&self) -> bool {
        self.opened.is_some()
    }

    /// Closes that window.
    pub fn close_window(&mut self) {
        self.opened = None;
    }

    /// The window of what was clicked last. `display`: how pictures are shown.
    pub fn window_ui(&mut self, ctx: &egui::Context, display: &Display) {
        let Some(mut opened) = self.opened.take() else {
            return;
        };
        let mut is_open = self.present.contains(&opened.contributor);
        let known = self.find(&opened.contributor);
        let is_current = known.is_some_and(|known| known.is_current);
        let Some(shown) = known
            .and_then(|known| known.shown.clone())
            .filter(|_| is_open)
        else {
            return;
        };
        if !is_current && !self.missing.contains(&opened.contributor) {
            self.missing.push(opened.contributor.clone());
        }
        if let Some(whole) = self.whole.get() {
            opened.encode(ctx, whole.image(), &shown.contribution, display);
        }
        let size = self.fitted(LARGEST);
        let title = format!("Contribution of {}", self.name_of(&opened.contributor));
        egui::Window::new(title)
            .id(egui::Id::unique("contribution"))
            .open(&mut is_open)
            .resizable(false)
            .collapsible(false)
            .default_pos(ctx.content_rect().center() - size / 2.0 - Vec2::new(160.0, 40.0))
            .show(ctx, |ui| {
                ui.set_max_width(size.x);
                opened.views_ui(ui);
                let texture = opened.texture(&shown);
                let tint = tint(is_current);
                ui.add(egui::Image::new((texture.id(), size)).tint(tint));
                details_ui(ui, &shown.contribution.figures, size.x);
            });
        self.opened = Some(opened).filter(|_| is_open);
    }
}

impl Opened {
    /// Makes the pictures with and without of `contribution`, where they are not there.
    fn encode(
        &mut self,
        ctx: &egui::Context,
        whole: &Image,
        contribution: &Arc<Contribution>,
        display: &Display,
    ) {
        let is_there = self
            .pictures
            .as_ref()
            .is_some_and(|(of, shown_as, _)| Arc::ptr_eq(of, contribution) && shown_as == display);
        if !is_there {
            let textures = [whole, &contribution.without].map(|image| {
                let image = color_image(image, |pixel| display::encode_8(pixel, display));
                ctx.load_texture("with or without", image, TextureOptions::LINEAR)
            });
            self.pictures = Some((Arc::clone(contribution), *display, textures));
        }
    }

    fn views_ui(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            for (view, name, meaning) in [
                (
                    OpenedView::Change,
                    "Change",
                    "The picture with it minus the picture without",
                ),
                (OpenedView::With, "With", "The picture as it is"),
                (OpenedView::Without, "Without", "The picture without it"),
            ] {
                let button = egui::Button::new(name).selected(self.view == view);
                let response = ui.add(button);
                let response = response.accessible_name(format!("Show: {name}"));
                if response.on_hover_text(meaning).clicked() {
                    self.view = view;
                }
            }
        });
    }

    fn texture<'a>(&'a self, shown: &'a Shown) -> &'a TextureHandle {
        match (&self.pictures, self.view) {
            (Some((_, _, [with, _])), OpenedView::With) => with,
            (Some((_, _, [_, without])), OpenedView::Without) => without,
            _ => &shown.change,
        }
    }
}

pub(super) fn color_image(image: &Image, color: impl Fn([f32; 3]) -> [u8; 3]) -> ColorImage {
    let color = |&pixel: &[f32; 3]| {
        let [r, g, b] = color(pixel);
        Color32::from_rgb(r, g, b)
    };
    let pixels = image.pixels.iter().map(color).collect();
    ColorImage::new([image.width as usize, image.height as usize], pixels)
}

/// What is of the scene before the last changes is dimmed.
fn tint(is_current: bool) -> Color32 {
    Color32::from_gray(if is_current { 255 } else { 120 })
}

fn paint(ui: &Ui, rect: Rect, response: &Response, shown: Option<&Shown>, is_current: bool) {
    let painter = ui.painter();
    let radius = CornerRadius::same(2);
    if let Some(shown) = shown {
        let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
        painter.image(shown.change.id(), rect, whole, tint(is_current));
    } else {
        painter.rect_filled(rect, radius, ui.visuals().extreme_bg_color);
        let text = if is_current { "–" } else { "…" };
        let font = egui::FontId::proportional(13.0);
        let ink = ui.visuals().weak_text_color();
        painter.text(rect.center(), egui::Align2::CENTER_CENTER, text, font, ink);
    }
    let stroke = if response.hovered() || response.has_focus() {
        Stroke::new(1.5, theme::ACCENT)
    } else {
        Stroke::new(1.0, ui.visuals().widgets.noninteractive.bg_stroke.color)
    };
    painter.rect_stroke(rect, radius, stroke, StrokeKind::Inside);
}

/// What the colours mean, and the figures.
fn details_ui(ui: &mut Ui, figures: &Figures, width: f32) {
    legend_ui(ui, figures.scale, width);
    let unit = "W/m²/sr";
    let signed = |value: f64| {
        let sign = if value > 0.0 { "+" } else { "" };
        format!("{sign}{}", format_number(value, 4))
    };
    egui::Grid::new("figures of a contribution")
        .num_columns(2)
        .show(ui, |ui| {
            let mut row = |name: &str, value: String| {
                ui.label(RichText::new(name).weak());
                ui.label(value);
                ui.end_row();
            };
            let [r, g, b] = figures.mean.map(signed);
            let error = error_of_share(figures);
            let error = error.map_or_else(String::new, |error| format!(" ± {error}"));
            row(
                "Mean change",
                format!("{}{error}   ({r}, {g}, {b} {unit})", signed_share(figures)),
            );
            let largest = figures.largest.map_or_else(
                || "–".to_owned(),
                |largest| {
                    let value = signed(largest.value);
                    format!(
                        "{value} {unit} at {}, {} of the small picture",
                        largest.x, largest.y
                    )
                },
            );
            row("Largest change", largest);
            row("relMSE without", format_number(figures.relmse, 5));
        });
}

/// How far noise puts the mean change off, as a share of the mean of the picture; `None` where that is not known.
fn error_of_share(figures: &Figures) -> Option<String> {
    figures.mean_share_error.map(percent)
}

/// The mean change as a share of the mean of the picture.
fn signed_share(figures: &Figures) -> String {
    let share = figures.mean_share;
    if !share.is_finite() {
        return "–".to_owned();
    }
    let sign = if share > 0.0 { "+" } else { "" };
    format!("{sign}{}", percent(share))
}

fn legend_ui(ui: &mut Ui, scale: f32, width: f32) {
    let (rect, _) = ui.allocate_exact_size(Vec2::new(width, 26.0), Sense::hover());
    let bar = Rect::from_min_size(rect.min, Vec2::new(width, 9.0));
    let mut mesh = egui::Mesh::default();
    for (corner, part) in (0..).step_by(2).zip(0..=PARTS) {
        let share = f32::from(part) / f32::from(PARTS);
        let x = egui::lerp(bar.x_range(), share);
        let [r, g, b] = color_of_share(2.0 * share - 1.0);
        for y in [bar.top(), bar.bottom()] {
            mesh.colored_vertex(Pos2::new(x, y), Color32::from_rgb(r, g, b));
        }
        if part > 0 {
            mesh.add_triangle(corner - 2, corner - 1, corner);
            mesh.add_triangle(corner - 1, corner, corner + 1);
        }
    }
    let painter = ui.painter();
    painter.add(mesh);
    let ink = ui.visuals().weak_text_color();
    let size = format_number(f64::from(scale), 4);
    for (place, align, text) in [
        (
            bar.left_bottom(),
            egui::Align2::LEFT_TOP,
            format!("-{size} or less: darker with it"),
        ),
        (
            bar.center_bottom(),
            egui::Align2::CENTER_TOP,
            "0".to_owned(),
        ),
        (
            bar.right_bottom(),
            egui::Align2::RIGHT_TOP,
            format!("brighter: {size} or more"),
        ),
    ] {
        let place = place + Vec2::new(0.0, 2.0);
        painter.text(place, align, text, egui::FontId::proportional(11.0), ink);
    }
}
