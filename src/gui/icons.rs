//! Small pictures drawn with the painter, so that they are sharp at every scale and show the colours of what they stand
//! for.

use egui::{Color32, CornerRadius, Painter, Pos2, Rect, Stroke, TextureId, Vec2};

use crate::scene::Rgb;

/// What a row of the scene tree shows in front of its name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Icon {
    /// A film camera.
    Camera,
    /// Sky over ground.
    Background {
        /// Colour above.
        sky: Color32,
        /// Colour below.
        ground: Color32,
    },
    /// A cube of the object's colour.
    Object(Color32),
    /// A sun of the light's colour.
    Light(Color32),
    /// A ball of the material's colour.
    Material(Color32),
    /// A ball as it is rendered.
    Ball(TextureId),
}

/// Side of the square an icon is drawn in, in points.
pub const SIDE: f32 = 16.0;

impl Icon {
    /// Draws the icon around `center`; `ink` is the colour of text beside it.
    pub fn paint(self, painter: &Painter, center: Pos2, ink: Color32) {
        let square = |side: f32| Rect::from_center_size(center, Vec2::splat(side));
        let edge = Stroke::new(1.0, ink.gamma_multiply(0.6));
        match self {
            Self::Camera => {
                let body =
                    Rect::from_center_size(center - Vec2::new(2.0, 0.0), Vec2::new(9.0, 8.0));
                painter.rect_filled(body, CornerRadius::same(2), ink);
                let lens = [
                    Pos2::new(body.right() + 1.0, center.y),
                    Pos2::new(body.right() + 4.5, center.y - 3.5),
                    Pos2::new(body.right() + 4.5, center.y + 3.5),
                ];
                painter.add(egui::Shape::convex_polygon(
                    lens.to_vec(),
                    ink,
                    Stroke::NONE,
                ));
            }
            Self::Background { sky, ground } => {
                let whole = square(12.0);
                let (above, below) = whole.split_top_bottom_at_fraction(0.55);
                painter.rect_filled(
                    above,
                    CornerRadius {
                        nw: 2,
                        ne: 2,
                        sw: 0,
                        se: 0,
                    },
                    sky,
                );
                painter.rect_filled(
                    below,
                    CornerRadius {
                        nw: 0,
                        ne: 0,
                        sw: 2,
                        se: 2,
                    },
                    ground,
                );
                painter.rect_stroke(whole, CornerRadius::same(2), edge, egui::StrokeKind::Middle);
            }
            Self::Object(color) => cube(painter, center, color, edge),
            Self::Light(color) => sun(painter, center, 3.0, color, edge.color),
            Self::Ball(texture) => ball(painter, square(16.0), texture),
            Self::Material(color) => {
                painter.circle(center, 5.5, color, edge);
                let shine = center - Vec2::new(1.8, 1.8);
                painter.circle_filled(shine, 1.5, Color32::from_white_alpha(150));
            }
        }
    }
}

/// A picture of a ball, as round as the ball, in `square`.
pub fn ball(painter: &Painter, square: Rect, texture: TextureId) {
    let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
    // Cut a little inside of the ball's edge, so that no ring of its surroundings is seen.
    let inside = whole.shrink((1.0 - super::balls::SHARE) / 2.0);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a size in points"
    )]
    let radius = (square.width() / 2.0).min(127.0) as u8;
    let shape = egui::epaint::RectShape::filled(square, CornerRadius::same(radius), Color32::WHITE);
    painter.add(shape.with_texture(texture, inside));
}

/// A cube seen from a corner: three faces, the upper one lighter, the right one darker.
fn cube(painter: &Painter, center: Pos2, color: Color32, edge: Stroke) {
    let at = |x: f32, y: f32| center + Vec2::new(x, y);
    let (top, left, right) = (at(0.0, -6.0), at(-5.5, -3.0), at(5.5, -3.0));
    let (low_left, low_right, bottom) = (at(-5.5, 3.0), at(5.5, 3.0), at(0.0, 6.0));
    let face = |corners: [Pos2; 4], fill: Color32| {
        painter.add(egui::Shape::convex_polygon(corners.to_vec(), fill, edge));
    };
    face(
        [top, right, center, left],
        color.lerp_to_gamma(Color32::WHITE, 0.25),
    );
    face([left, center, bottom, low_left], color);
    face(
        [center, right, low_right, bottom],
        color.lerp_to_gamma(Color32::BLACK, 0.35),
    );
}

/// A disc of `radius` with rays.
pub fn sun(painter: &Painter, center: Pos2, radius: f32, fill: Color32, edge: Color32) {
    for step in 0..8_u8 {
        let direction = Vec2::angled(f32::from(step) * std::f32::consts::FRAC_PI_4);
        let (from, to) = (
            center + direction * (radius * 1.45),
            center + direction * (radius * 2.1),
        );
        painter.line_segment([from, to], Stroke::new(radius * 0.65, edge));
        painter.line_segment([from, to], Stroke::new(radius * 0.32, fill));
    }
    painter.circle(center, radius, fill, Stroke::new(radius * 0.35, edge));
}

/// The screen's colour for a linear one, brighter than 1 scaled down to fit.
#[must_use]
pub fn color_of(linear: Rgb) -> Color32 {
    let fitting = linear / linear.max_element().max(1.0);
    let [r, g, b] = fitting.as_vec3().to_array();
    egui::Rgba::from_rgb(r, g, b).into()
}

/// The screen's colour for light: its hue at full brightness.
#[must_use]
pub fn hue_of(light: Rgb) -> Color32 {
    let largest = light.max_element();
    if largest > 0.0 && largest.is_finite() {
        color_of(light / largest)
    } else {
        Color32::BLACK
    }
}
