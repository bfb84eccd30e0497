//! What handles look like: lines on the screen of the same size wherever the part is, and which of them is under the mouse.
//!
//! Places are in points from the top left corner of the frame.

use egui::{Color32, Painter, Pos2, Rect, Stroke, Vec2};

use super::{Axes, Axis, Handle};
use crate::gui::orbit::{self, PictureSize};
use crate::gui::tool::Tool;
use crate::math::{DVec2, DVec3};
use crate::scene::Camera;

/// Length of an arrow, in points.
pub const LENGTH: f64 = 84.0;
/// Radius of the rings about the axes, as a share of that length.
pub const RING: f64 = 0.9;
/// Radius of the ring about the line of sight.
const OUTER_RING: f64 = 1.12;
/// Where arrows begin, and between what the squares of the planes lie.
const ARROW_START: f64 = 0.2;
const SQUARE: [f64; 2] = [0.34, 0.56];
/// Radius of the disk that moves in all directions, in points.
const DISK_RADIUS: f64 = 8.0;
/// Corners of a ring.
const CORNERS: u32 = 72;
/// Within this distance of a line it is hit, in points.
const REACH: f64 = 7.0;
/// Length of an arrow's head beyond its line, in points.
const HEAD: f32 = 13.0;
/// Shortest arrow that is drawn, and narrowest plane (as a cosine): those seen from their ends have no use.
const SHORTEST: f64 = 14.0;
const NARROWEST: f64 = 0.12;
/// The handle that is under the mouse or held.
const BRIGHT: Color32 = Color32::from_rgb(0xff, 0xd8, 0x4a);

/// A handle on the screen.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Which handle it is.
    pub handle: Handle,
    /// Its lines, that can be hit.
    lines: Vec<[DVec2; 2]>,
    /// Lines on its far side, that are only seen.
    faint: Vec<[DVec2; 2]>,
    /// Corners of what is filled and can be hit too.
    area: Vec<DVec2>,
    /// What is at the end of its last line.
    end: End,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum End {
    None,
    Arrow,
    Square,
}

/// From where a gizmo is looked at.
#[derive(Clone, Copy, Debug)]
pub struct Viewed<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// Of the frame, in points.
    pub size: PictureSize,
    /// Where the gizmo is, in the world.
    pub pivot: DVec3,
    /// Along which its handles go.
    pub axes: Axes,
}

impl Viewed<'_> {
    fn project(&self, point: DVec3) -> Option<DVec2> {
        orbit::project(self.camera, self.size, point).map(|(position, _)| position)
    }

    /// Length in the world of an arrow; `None` where the gizmo is behind the eye.
    #[must_use]
    pub fn length(&self) -> Option<f64> {
        let (_, depth) = orbit::project(self.camera, self.size, self.pivot)?;
        let half_height = (self.camera.vertical_fov.radians() / 2.0).tan();
        let length = LENGTH * 2.0 * half_height * depth / self.size.height;
        (length > 0.0 && length.is_finite()).then_some(length)
    }

    /// The unit vector from the gizmo to the eye.
    #[must_use]
    pub fn to_eye(&self) -> DVec3 {
        let offset = self.camera.eye - self.pivot;
        offset.try_normalize().unwrap_or(DVec3::Z)
    }

    /// The handles of `tool`; none where they are not seen.
    #[must_use]
    pub fn shapes(&self, tool: Tool) -> Vec<Shape> {
        let (Some(length), Some(middle)) = (self.length(), self.project(self.pivot)) else {
            return Vec::new();
        };
        match tool {
            Tool::Select | Tool::Focus | Tool::Rays => Vec::new(),
            Tool::Move => {
                let disk = circle(middle, DISK_RADIUS);
                let mut shapes = vec![Shape {
                    area: disk.iter().map(|[from, _]| *from).collect(),
                    lines: disk,
                    ..Shape::new(Handle::Free)
                }];
                shapes.extend(
                    Axis::ALL
                        .iter()
                        .filter_map(|&axis| self.square(axis, length)),
                );
                shapes.extend(
                    Axis::ALL
                        .iter()
                        .filter_map(|&axis| self.arrow(axis, length)),
                );
                shapes
            }
            Tool::Rotate => {
                let mut shapes: Vec<Shape> = Axis::ALL
                    .iter()
                    .map(|&axis| self.ring(axis, length * RING))
                    .collect();
                shapes.push(Shape {
                    lines: circle(middle, LENGTH * OUTER_RING),
                    ..Shape::new(Handle::Free)
                });
                shapes
            }
            Tool::Scale => {
                let end = middle + DVec2::new(1.0, -1.0) * (LENGTH * RING / 2_f64.sqrt());
                let mut lines = circle(middle, LENGTH * RING);
                lines.push([middle, end]);
                vec![Shape {
                    lines,
                    end: End::Square,
                    ..Shape::new(Handle::Free)
                }]
            }
        }
    }

    fn arrow(&self, axis: Axis, length: f64) -> Option<Shape> {
        let at =
            |share: f64| self.project(self.pivot + self.axes.direction(axis) * (length * share));
        let line = [at(ARROW_START)?, at(1.0)?];
        (line[0].distance(line[1]) >= SHORTEST).then(|| Shape {
            lines: vec![line],
            end: End::Arrow,
            ..Shape::new(Handle::Along(axis))
        })
    }

    /// A square in the plane across `axis`.
    fn square(&self, axis: Axis, length: f64) -> Option<Shape> {
        if self.to_eye().dot(self.axes.direction(axis)).abs() < NARROWEST {
            return None;
        }
        let [u, v] = axis.others().map(|other| self.axes.direction(other));
        let [near, far] = SQUARE;
        let corners = [(near, near), (far, near), (far, far), (near, far)];
        let corners = corners.map(|(a, b)| self.project(self.pivot + (u * a + v * b) * length));
        let area: Vec<DVec2> = corners.into_iter().collect::<Option<_>>()?;
        let lines = (0..4).map(|i| [area[i], area[(i + 1) % 4]]).collect();
        Some(Shape {
            lines,
            area,
            ..Shape::new(Handle::Across(axis))
        })
    }

    /// A ring about `axis`, of which the half before the part can be hit.
    fn ring(&self, axis: Axis, radius: f64) -> Shape {
        let [u, v] = axis.others().map(|other| self.axes.direction(other));
        let to_eye = self.to_eye();
        let mut shape = Shape::new(Handle::Along(axis));
        let spoke = |corner: u32| {
            let angle = std::f64::consts::TAU * f64::from(corner) / f64::from(CORNERS);
            u * angle.cos() + v * angle.sin()
        };
        for corner in 0..CORNERS {
            let spokes = [spoke(corner), spoke(corner + 1)];
            let [from, to] = spokes.map(|spoke| self.project(self.pivot + spoke * radius));
            let (Some(from), Some(to)) = (from, to) else {
                continue;
            };
            // A ring that faces the eye is all before the part.
            let is_front = spokes.iter().all(|spoke| spoke.dot(to_eye) > -0.02);
            let lines = if is_front {
                &mut shape.lines
            } else {
                &mut shape.faint
            };
            lines.push([from, to]);
        }
        shape
    }
}

impl Shape {
    fn new(handle: Handle) -> Self {
        Self {
            handle,
            lines: Vec::new(),
            faint: Vec::new(),
            area: Vec::new(),
            end: End::None,
        }
    }

    /// Distance of `position` from what can be hit; 0 inside a filled area.
    fn distance(&self, position: DVec2) -> f64 {
        if is_inside(&self.area, position) {
            return 0.0;
        }
        let distances = self.lines.iter().map(|line| distance_to(line, position));
        let tip = self.lines.last().filter(|_| self.end == End::Arrow);
        let tip = tip.map(|&[from, to]| to + (to - from).normalize_or_zero() * f64::from(HEAD));
        let distances = distances.chain(tip.map(|tip| tip.distance(position)));
        distances.fold(f64::INFINITY, f64::min)
    }

    /// Draws it into `frame`; `is_bright`: under the mouse or held.
    pub fn paint(&self, painter: &Painter, frame: Rect, is_bright: bool) {
        let color = if is_bright {
            BRIGHT
        } else {
            self.handle.color()
        };
        let on_screen = |point: DVec2| on_screen(frame, point);
        for line in &self.faint {
            let stroke = Stroke::new(1.0, color.gamma_multiply(0.35));
            painter.line_segment(line.map(on_screen), stroke);
        }
        if self.area.len() > 2 {
            let corners = self.area.iter().map(|&corner| on_screen(corner));
            let fill = color.gamma_multiply(if is_bright { 0.75 } else { 0.4 });
            painter.add(egui::Shape::convex_polygon(
                corners.collect(),
                fill,
                Stroke::NONE,
            ));
        }
        // Dark around it, so that it is seen before anything.
        for stroke in [
            Stroke::new(4.4, Color32::from_black_alpha(90)),
            Stroke::new(2.4, color),
        ] {
            for line in &self.lines {
                painter.line_segment(line.map(on_screen), stroke);
            }
        }
        let Some([from, to]) = self.lines.last().map(|line| line.map(on_screen)) else {
            return;
        };
        match self.end {
            End::None => {}
            End::Arrow => {
                let along = (to - from).normalized();
                let across = along.rot90() * 5.5;
                let corners = vec![to + along * HEAD, to + across, to - across];
                painter.add(egui::Shape::convex_polygon(corners, color, Stroke::NONE));
            }
            End::Square => {
                let square = Rect::from_center_size(to, Vec2::splat(12.0));
                painter.rect_filled(square, 2.0, color);
            }
        }
    }
}

/// The handle under `position`: the nearest of several.
#[must_use]
pub fn handle_at(shapes: &[Shape], position: DVec2) -> Option<Handle> {
    let distances = shapes.iter().map(|shape| (shape, shape.distance(position)));
    distances
        .filter(|(_, distance)| *distance <= REACH)
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(shape, _)| shape.handle)
}

fn circle(middle: DVec2, radius: f64) -> Vec<[DVec2; 2]> {
    let at = |corner: u32| {
        let angle = std::f64::consts::TAU * f64::from(corner) / f64::from(CORNERS);
        middle + DVec2::from_angle(angle) * radius
    };
    (0..CORNERS)
        .map(|corner| [at(corner), at(corner + 1)])
        .collect()
}

fn distance_to(&[from, to]: &[DVec2; 2], position: DVec2) -> f64 {
    let along = to - from;
    let squared = along.length_squared();
    let share = if squared > 0.0 {
        ((position - from).dot(along) / squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    position.distance(from + along * share)
}

/// Whether `position` lies in the convex polygon of `corners`.
fn is_inside(corners: &[DVec2], position: DVec2) -> bool {
    let sides = (0..corners.len()).map(|index| {
        let (from, to) = (corners[index], corners[(index + 1) % corners.len()]);
        (to - from).perp_dot(position - from)
    });
    let (mut has_left, mut has_right) = (false, false);
    for side in sides {
        has_left |= side > 0.0;
        has_right |= side < 0.0;
    }
    corners.len() > 2 && !(has_left && has_right)
}

#[expect(clippy::cast_possible_truncation, reason = "screen positions are f32")]
fn on_screen(frame: Rect, point: DVec2) -> Pos2 {
    frame.min + Vec2::new(point.x as f32, point.y as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: PictureSize = PictureSize {
        width: 900.0,
        height: 600.0,
    };

    fn camera(scale: f64) -> Camera {
        Camera {
            eye: DVec3::new(3.0, -6.0, 2.5) * scale,
            target: DVec3::ZERO,
            ..Camera::default()
        }
    }

    #[test]
    fn handles_have_one_size_wherever_they_are() {
        for scale in [1e-20, 1.0, 1e20] {
            let camera = camera(scale);
            for pivot in [DVec3::ZERO, DVec3::new(1.0, 4.0, -0.5) * scale] {
                let view = Viewed {
                    axes: Axes::WORLD,
                    camera: &camera,
                    size: SIZE,
                    pivot,
                };
                let middle = view.project(pivot).unwrap();
                // Across the line of sight an arrow would be as long as it is said.
                let across = camera.axes().unwrap().right * view.length().unwrap();
                let end = view.project(pivot + across).unwrap();
                assert!((middle.distance(end) - LENGTH).abs() < 1e-6);
                for tool in [Tool::Move, Tool::Rotate, Tool::Scale] {
                    let shapes = view.shapes(tool);
                    assert!(!shapes.is_empty());
                    let far = shapes.iter().flat_map(|shape| shape.lines.iter().flatten());
                    let far = far.map(|point| point.distance(middle)).fold(0.0, f64::max);
                    assert!(far < 1.5 * LENGTH, "{tool:?} {far}");
                }
            }
        }
        let behind = Viewed {
            axes: Axes::WORLD,
            camera: &camera(1.0),
            size: SIZE,
            pivot: DVec3::new(6.0, -12.0, 5.0),
        };
        assert!(behind.shapes(Tool::Move).is_empty());
    }

    #[test]
    fn what_is_drawn_is_what_is_hit() {
        let camera = camera(1.0);
        let view = Viewed {
            axes: Axes::WORLD,
            camera: &camera,
            size: SIZE,
            pivot: DVec3::ZERO,
        };
        let length = view.length().unwrap();
        let at = |point: DVec3| view.project(point * length).unwrap();
        let shapes = view.shapes(Tool::Move);
        for axis in Axis::ALL {
            let found = handle_at(&shapes, at(axis.direction() * 0.85));
            assert_eq!(found, Some(Handle::Along(axis)));
            let [u, v] = axis.others().map(Axis::direction);
            let found = handle_at(&shapes, at((u + v) * 0.45));
            assert_eq!(found, Some(Handle::Across(axis)));
        }
        assert_eq!(handle_at(&shapes, at(DVec3::ZERO)), Some(Handle::Free));
        assert_eq!(handle_at(&shapes, at(DVec3::ONE * 3.0)), None);

        let rings = view.shapes(Tool::Rotate);
        let front = DVec3::new(0.0, -RING, 0.0);
        let towards = (front + DVec3::X * RING).normalize() * RING;
        assert_eq!(handle_at(&rings, at(towards)), Some(Handle::Along(Axis::Z)));
        assert_eq!(handle_at(&rings, at(-towards)), None, "its far side");
        let outer = at(DVec3::ZERO) + DVec2::Y * (LENGTH * OUTER_RING);
        assert_eq!(handle_at(&rings, outer), Some(Handle::Free));
    }

    #[test]
    fn an_axis_seen_from_its_end_has_no_arrow() {
        let camera = Camera {
            eye: DVec3::new(0.0, -6.0, 0.0),
            target: DVec3::ZERO,
            ..Camera::default()
        };
        let view = Viewed {
            axes: Axes::WORLD,
            camera: &camera,
            size: SIZE,
            pivot: DVec3::ZERO,
        };
        let handles: Vec<Handle> = view.shapes(Tool::Move).iter().map(|s| s.handle).collect();
        assert!(!handles.contains(&Handle::Along(Axis::Y)));
        assert!(!handles.contains(&Handle::Across(Axis::X)));
        assert!(handles.contains(&Handle::Across(Axis::Y)));
        assert!(handles.contains(&Handle::Along(Axis::X)));
    }
}
