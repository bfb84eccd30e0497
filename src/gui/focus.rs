//! What is sharp and how much the rest is blurred, in numbers and words.
//!
//! A thin lens of radius r that is focused at the distance f draws a point at the distance z (both along the view axis) as a disk
//! of the diameter 2r·|f − z|/z on the plane of focus. In pixels of a picture of H rows whose half height at distance 1 is t, that
//! is r·H/t·|1/z − 1/f|.

use super::widgets::format_number;
use crate::scene::{Camera, Scene};

/// What the preview shows of the focus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum FocusAid {
    /// Nothing.
    #[default]
    Off,
    /// Where the plane of focus cuts surfaces.
    Plane,
    /// The same, and by colours how much the rest is blurred.
    Blur,
}

/// Diameter of the blur in pixels of a picture of `height` rows, per difference of reciprocal distances: pixels times scene units.
#[must_use]
pub fn blur_scale(camera: &Camera, height: f64) -> f64 {
    let half_height = (camera.vertical_fov.radians() / 2.0).tan();
    camera.aperture_radius * height / half_height
}

/// Diameter in pixels of what becomes of a point at `depth` along the view axis, in a picture of `height` rows.
#[must_use]
pub fn blur_diameter(camera: &Camera, height: f64, depth: f64) -> f64 {
    blur_scale(camera, height) * (depth.recip() - camera.focus().recip()).abs()
}

/// A radius of the lens that blurs what is not sharp so that it is seen: a hundredth of the focus distance.
#[must_use]
pub fn wide_radius(camera: &Camera) -> f64 {
    (0.01 * camera.focus()).clamp(f64::MIN_POSITIVE, f64::MAX)
}

/// What to say of the focus of `scene`; `depth`: of what is under the mouse, along the view axis.
#[must_use]
pub fn in_words(scene: &Scene, depth: Option<f64>) -> Vec<String> {
    let camera = &scene.camera;
    let at_target = if camera.focus_distance.is_none() {
        " (the target)"
    } else {
        ""
    };
    let focus = format_number(camera.focus(), 3);
    let mut lines = vec![format!("Sharp at distance {focus}{at_target}")];
    if camera.aperture_radius == 0.0 {
        lines.push("Nothing is blurred: the lens radius is 0".to_owned());
    } else if !scene.render.depth_of_field {
        lines.push("Nothing is blurred: Depth of field is off".to_owned());
    } else {
        lines.push("Orange is blurred before it, blue behind".to_owned());
    }
    lines.push(match depth {
        Some(depth) => {
            let is_blurred = scene.render.depth_of_field;
            let height = f64::from(scene.render.height);
            let blur = if is_blurred {
                blur_diameter(camera, height, depth)
            } else {
                0.0
            };
            let (depth, blur) = (format_number(depth, 3), format_number(blur, 1));
            format!("Here: distance {depth}, blur {blur} px. Click to focus")
        }
        None => "Point at what is to be sharp, and click".to_owned(),
    });
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gui::orbit::{PictureSize, view_direction};
    use crate::math::{Bounds, DBounds, DVec2, DVec3, SceneFrame, Vec2, Vec3};
    use crate::render::PreparedCamera;

    fn camera() -> Camera {
        Camera {
            eye: DVec3::new(1.0, -6.0, 2.0),
            target: DVec3::new(0.2, 0.1, 0.4),
            aperture_radius: 0.15,
            focus_distance: Some(5.0),
            ..Camera::default()
        }
    }

    #[test]
    fn an_opened_lens_blurs_what_is_seen() {
        let mut camera = camera();
        camera.aperture_radius = wide_radius(&camera);
        let focus = camera.focus();
        assert_eq!(blur_diameter(&camera, 600.0, focus), 0.0);
        assert!(blur_diameter(&camera, 600.0, focus * 1.5) > 3.0);
        camera.focus_distance = Some(f64::INFINITY);
        assert!(wide_radius(&camera).is_finite());
    }

    /// The renderer's ray through the rim of the lens and the rim of the blur meets the point that is blurred.
    #[test]
    fn the_blur_is_that_of_the_renderers_lens() {
        let camera = camera();
        let (width, height) = (320, 240);
        let size = PictureSize {
            width: width.into(),
            height: height.into(),
        };
        let frame = SceneFrame::around(&DBounds {
            min: DVec3::splat(-8.0),
            max: DVec3::splat(8.0),
        });
        let bounds = Bounds {
            min: Vec3::NEG_ONE,
            max: Vec3::ONE,
        };
        let prepared = PreparedCamera::new(&camera, &frame, &[bounds], width, height).unwrap();
        let middle = DVec2::new(170.0, 101.0);
        for depth in [1.5, 4.0, 5.0, 9.0, 1e6] {
            let point = camera.eye + view_direction(&camera, size, middle).unwrap() * depth;
            let point = frame.prepared_from_world(point);
            let radius = blur_diameter(&camera, size.height, depth) / 2.0;
            // The right end of the lens; before the plane of focus the disk is upside down.
            let lens = Vec2::new(1.0, 0.5);
            let distance = |offset: f64| {
                let (origin, direction) = prepared.through_lens(middle.x + offset, middle.y, lens);
                let to_point = point - origin;
                to_point.cross(direction).length() / to_point.length()
            };
            let side = if depth < 5.0 { -radius } else { radius };
            assert!(distance(side) < 1e-6, "{depth}: {}", distance(side));
            assert!(radius == 0.0 || distance(side * 1.1) > 1e-6, "{depth}");
        }
        assert_eq!(blur_diameter(&camera, 240.0, 5.0), 0.0);
    }

    #[test]
    fn a_focus_at_infinity_blurs_what_is_near() {
        let far = Camera {
            focus_distance: Some(f64::INFINITY),
            ..camera()
        };
        assert_eq!(blur_diameter(&far, 240.0, f64::INFINITY), 0.0);
        let blur = blur_diameter(&far, 240.0, 2.0);
        assert!((blur / (blur_scale(&far, 240.0) / 2.0) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn the_note_says_why_nothing_is_blurred() {
        let mut scene = Scene {
            camera: camera(),
            ..Scene::default()
        };
        let said = |scene: &Scene, depth| in_words(scene, depth).join(" ");
        assert!(said(&scene, Some(5.0)).contains("blur 0 px"));
        assert!(!said(&scene, None).contains("Nothing"));
        scene.render.depth_of_field = false;
        assert!(said(&scene, Some(1.0)).contains("Depth of field is off"));
        assert!(said(&scene, Some(1.0)).contains("blur 0 px"));
        scene.camera.aperture_radius = 0.0;
        assert!(said(&scene, None).contains("radius is 0"));
    }
}
