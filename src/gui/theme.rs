//! Colours, spacing and type of the window, dark and light.

use egui::{Color32, CornerRadius, FontFamily, FontId, Margin, Stroke, TextStyle, Theme, Vec2};

/// The colour of the one thing to do next, of selection and of progress.
pub const ACCENT: Color32 = Color32::from_rgb(0x3d, 0x7e, 0xf0);
/// Text on [`ACCENT`].
pub const ON_ACCENT: Color32 = Color32::WHITE;
/// The colour of stopping.
pub const STOP: Color32 = Color32::from_rgb(0xc8, 0x4b, 0x47);

/// Width of the side panel, in points.
pub const PANEL_WIDTH: f32 = 332.0;
/// Height of buttons in the top bar, in points.
pub const BAR_BUTTON_HEIGHT: f32 = 28.0;

/// Sets both themes; which one shows is the user's or the desktop's choice.
pub fn install(ctx: &egui::Context) {
    ctx.style_mut_of(Theme::Dark, |style| {
        common(style);
        dark(&mut style.visuals);
    });
    ctx.style_mut_of(Theme::Light, |style| {
        common(style);
        light(&mut style.visuals);
    });
}

/// The ground that pictures lie on: neutral, so that it tints no colour beside it.
#[must_use]
pub fn backdrop(visuals: &egui::Visuals) -> Color32 {
    if visuals.dark_mode {
        Color32::from_gray(0x12)
    } else {
        Color32::from_gray(0xc4)
    }
}

fn common(style: &mut egui::Style) {
    let proportional = |size: f32| FontId::new(size, FontFamily::Proportional);
    style.text_styles = [
        (TextStyle::Small, proportional(11.0)),
        (TextStyle::Body, proportional(13.5)),
        (TextStyle::Button, proportional(13.5)),
        (TextStyle::Heading, proportional(17.0)),
        (
            TextStyle::Monospace,
            FontId::new(12.5, FontFamily::Monospace),
        ),
    ]
    .into();
    style.drag_value_text_style = TextStyle::Body;
    style.animation_time = 0.08;
    style.spacing.item_spacing = Vec2::new(6.0, 5.0);
    style.spacing.button_padding = Vec2::new(8.0, 3.0);
    style.spacing.interact_size = Vec2::new(36.0, 22.0);
    style.spacing.menu_margin = Margin::same(6);
    style.spacing.window_margin = Margin::same(16);
    style.spacing.icon_width = 16.0;
    style.spacing.icon_width_inner = 10.0;
    style.spacing.tooltip_width = 340.0;
    style.spacing.menu_width = 260.0;
    style.interaction.selectable_labels = false;
    style.visuals.handle_shape = egui::style::HandleShape::Circle;
    style.visuals.slider_trailing_fill = true;
    style.visuals.indent_has_left_vline = false;
    style.visuals.window_corner_radius = CornerRadius::same(10);
    style.visuals.menu_corner_radius = CornerRadius::same(8);
    let widgets = &mut style.visuals.widgets;
    for state in [
        &mut widgets.noninteractive,
        &mut widgets.inactive,
        &mut widgets.hovered,
        &mut widgets.active,
        &mut widgets.open,
    ] {
        state.corner_radius = CornerRadius::same(5);
        state.expansion = 0.0;
    }
}

fn dark(visuals: &mut egui::Visuals) {
    let gray = Color32::from_gray;
    visuals.panel_fill = gray(0x1e);
    visuals.window_fill = gray(0x26);
    visuals.window_stroke = Stroke::new(1.0, gray(0x3c));
    visuals.extreme_bg_color = gray(0x15);
    visuals.faint_bg_color = gray(0x24);
    visuals.hyperlink_color = Color32::from_rgb(0x7f, 0xae, 0xff);
    visuals.warn_fg_color = Color32::from_rgb(0xf0, 0xb4, 0x4c);
    visuals.error_fg_color = Color32::from_rgb(0xff, 0x7b, 0x72);
    visuals.weak_text_color = Some(gray(0x92));
    visuals.selection.bg_fill = Color32::from_rgb(0x2b, 0x55, 0xa0);
    visuals.selection.stroke = Stroke::new(1.0, Color32::WHITE);
    let widgets = &mut visuals.widgets;
    widgets.noninteractive.bg_stroke = Stroke::new(1.0, gray(0x32));
    widgets.noninteractive.fg_stroke = Stroke::new(1.0, gray(0xc8));
    widgets.inactive.weak_bg_fill = gray(0x32);
    widgets.inactive.bg_fill = gray(0x3a);
    widgets.inactive.fg_stroke = Stroke::new(1.0, gray(0xdc));
    widgets.hovered.weak_bg_fill = gray(0x3f);
    widgets.hovered.bg_fill = gray(0x48);
    widgets.hovered.bg_stroke = Stroke::new(1.0, gray(0x5c));
    widgets.hovered.fg_stroke = Stroke::new(1.0, gray(0xf4));
    widgets.active.weak_bg_fill = gray(0x2a);
    widgets.active.bg_fill = gray(0x50);
    widgets.active.bg_stroke = Stroke::new(1.0, ACCENT);
    widgets.active.fg_stroke = Stroke::new(1.0, Color32::WHITE);
    widgets.open.weak_bg_fill = gray(0x2c);
    widgets.open.bg_stroke = Stroke::new(1.0, gray(0x4a));
}

fn light(visuals: &mut egui::Visuals) {
    let gray = Color32::from_gray;
    visuals.panel_fill = gray(0xf3);
    visuals.window_fill = gray(0xfc);
    visuals.window_stroke = Stroke::new(1.0, gray(0xc4));
    visuals.extreme_bg_color = gray(0xff);
    visuals.faint_bg_color = gray(0xea);
    visuals.warn_fg_color = Color32::from_rgb(0x9a, 0x5b, 0x00);
    visuals.error_fg_color = Color32::from_rgb(0xb3, 0x26, 0x1e);
    visuals.weak_text_color = Some(gray(0x62));
    visuals.selection.bg_fill = Color32::from_rgb(0xbc, 0xd4, 0xff);
    visuals.selection.stroke = Stroke::new(1.0, Color32::from_rgb(0x0a, 0x2c, 0x6b));
    let widgets = &mut visuals.widgets;
    widgets.noninteractive.bg_stroke = Stroke::new(1.0, gray(0xd6));
    widgets.noninteractive.fg_stroke = Stroke::new(1.0, gray(0x2c));
    widgets.inactive.weak_bg_fill = gray(0xe0);
    widgets.inactive.bg_fill = gray(0xd4);
    widgets.inactive.fg_stroke = Stroke::new(1.0, gray(0x24));
    widgets.hovered.weak_bg_fill = gray(0xd4);
    widgets.hovered.bg_fill = gray(0xc8);
    widgets.hovered.bg_stroke = Stroke::new(1.0, gray(0xa0));
    widgets.hovered.fg_stroke = Stroke::new(1.0, Color32::BLACK);
    widgets.active.weak_bg_fill = gray(0xcc);
    widgets.active.bg_fill = gray(0xbe);
    widgets.active.bg_stroke = Stroke::new(1.0, ACCENT);
    widgets.active.fg_stroke = Stroke::new(1.0, Color32::BLACK);
    widgets.open.weak_bg_fill = gray(0xda);
    widgets.open.bg_stroke = Stroke::new(1.0, gray(0xb0));
}
