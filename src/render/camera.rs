//! Rays from the eye: through a pinhole or a thin lens, in prepared units.

use crate::math::{Bounds, DBounds, DVec2, DVec3, Ray, SceneFrame, Vec2, length_of, warp};
use crate::scene::{Camera, CameraAxes, SceneError};

/// A camera in the prepared scene. Rays are made in `f64`, so that a thousandth of a degree still has as many directions as
/// pixels, and start near the scene, so that a distant eye costs no digits.
#[derive(Clone, Debug, PartialEq)]
pub struct PreparedCamera {
    eye: DVec3,
    axes: CameraAxes,
    /// Half the picture's height and width at distance 1.
    half_height: f64,
    half_width: f64,
    /// From pixels to halves of the picture.
    per_pixel: DVec2,
    /// Boxes around all there is to meet, a little larger so that rounding loses no hit; none lies in another.
    boxes: Vec<MetBox>,
    /// `None` for a pinhole.
    lens: Option<Lens>,
}

/// A box around things to meet.
#[derive(Clone, Debug, PartialEq)]
struct MetBox {
    bounds: DBounds,
    /// Length of its space diagonal.
    diagonal: f64,
}

/// A thin lens, in prepared units.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Lens {
    radius: f64,
    /// Along the view axis.
    focus_distance: f64,
}

/// A camera ray that may meet the scene.
#[derive(Clone, Copy, Debug)]
pub struct CameraRay {
    /// In the prepared scene; unit direction.
    pub ray: Ray,
    /// Distance from the eye to the ray's origin, in prepared units.
    pub start: f64,
}

/// Farthest eye from the middle of the objects, in prepared units: from farther away, the digits of a double no longer tell
/// whether a ray meets them.
const MOST_DISTANCE: f64 = 1e15;
/// Largest lens, in prepared units: rays from the rim of a larger one would miss their place on the objects by more than an `f32`
/// rounds.
const MOST_APERTURE: f64 = 1e9;
/// Nearest focus, in prepared units: the squares of a nearer one vanish.
const LEAST_FOCUS: f64 = 1e-100;
/// From this distance on, in prepared units, the rays to one point of the focus plane are parallel in every digit.
const PARALLEL_FOCUS: f64 = 1e100;

impl PreparedCamera {
    /// Whether the numbers of `camera` can be computed with at the scene's scale.
    ///
    /// # Errors
    /// The first key whose value is out of range, and its range.
    pub fn check(camera: &Camera, frame: &SceneFrame) -> Result<(), SceneError> {
        let require = |holds: bool, key: &str, value: String, expected: String| {
            let key = key.to_owned();
            holds.then_some(()).ok_or(SceneError::BadValue {
                key,
                value,
                expected,
            })
        };
        let scale = frame.scale();
        let distance = length_of(frame.prepared_from_world(camera.eye));
        require(
            distance <= MOST_DISTANCE,
            "camera.eye",
            format!("{:.1e} away from the objects", distance / scale),
            format!(
                "at most {:.1e}, 1e15 times their size",
                MOST_DISTANCE / scale
            ),
        )?;
        if camera.aperture_radius == 0.0 {
            return Ok(());
        }
        require(
            camera.aperture_radius * scale <= MOST_APERTURE,
            "camera.aperture_radius",
            format!("{:e}", camera.aperture_radius),
            format!(
                "at most {:.1e}, 1e9 times the objects' size",
                MOST_APERTURE / scale
            ),
        )?;
        require(
            camera.focus() * scale >= LEAST_FOCUS,
            "camera.focus_distance",
            format!("{:e}", camera.focus()),
            format!(
                "at least {:.1e}, 1e-100 times the objects' size",
                LEAST_FOCUS / scale
            ),
        )
    }

    /// The camera for a `width` × `height` picture of what lies in `boxes` (prepared units). `None` where the camera has
    /// no direction, see [`Camera::axes`].
    #[must_use]
    pub fn new(
        camera: &Camera,
        frame: &SceneFrame,
        boxes: &[Bounds],
        width: u32,
        height: u32,
    ) -> Option<Self> {
        let (width, height) = (f64::from(width), f64::from(height));
        let half_height = libm::tan(camera.vertical_fov.radians() / 2.0);
        // Scene coordinates are at most 1: a few of their last digits.
        let margin = DVec3::splat(f64::from(4.0 * f32::EPSILON));
        let grown = |bounds: &Bounds| {
            let bounds = DBounds {
                min: bounds.min.as_dvec3() - margin,
                max: bounds.max.as_dvec3() + margin,
            };
            let diagonal = bounds.diagonal();
            MetBox { bounds, diagonal }
        };
        let is_within_another = |(index, inner): (usize, &Bounds)| {
            boxes.iter().enumerate().any(|(other, outer)| {
                let holds = outer.contains(inner.min) && outer.contains(inner.max);
                // Of equal boxes the first stays.
                holds && (inner != outer || other < index)
            })
        };
        let outermost = boxes
            .iter()
            .enumerate()
            .filter(|&(index, bounds)| !bounds.is_empty() && !is_within_another((index, bounds)));
        Some(Self {
            eye: frame.prepared_from_world(camera.eye),
            axes: camera.axes()?,
            half_height,
            half_width: half_height * width / height,
            per_pixel: 2.0 / DVec2::new(width, height),
            boxes: outermost.map(|(_, bounds)| grown(bounds)).collect(),
            lens: (camera.aperture_radius > 0.0).then(|| Lens {
                radius: camera.aperture_radius * frame.scale(),
                focus_distance: (camera.focus() * frame.scale()).min(PARALLEL_FOCUS),
            }),
        })
    }

    /// Unit direction through the point `(x, y)` of the picture: pixels from its top left corner.
    #[must_use]
    pub fn direction(&self, x: f64, y: f64) -> DVec3 {
        let right = self.axes.right * ((x * self.per_pixel.x - 1.0) * self.half_width);
        let up = self.axes.up * ((1.0 - y * self.per_pixel.y) * self.half_height);
        (self.axes.forward + right + up).normalize()
    }

    /// The ray through the point `(x, y)` of the picture and the middle of the lens, or `None` when it misses the scene's
    /// box.
    #[must_use]
    pub fn ray(&self, x: f64, y: f64) -> Option<CameraRay> {
        self.ray_from(self.eye, self.direction(x, y))
    }

    /// Whether rays through one point of the picture differ by where they pass the lens.
    #[must_use]
    pub fn has_lens(&self) -> bool {
        self.lens.is_some()
    }

    /// Origin and unit direction of the ray through the point `(x, y)` of the picture and the point of the lens that `u`, uniform
    /// over the unit square, stands for. All rays of one point meet at the focus distance.
    #[must_use]
    pub fn through_lens(&self, x: f64, y: f64, u: Vec2) -> (DVec3, DVec3) {
        let direction = self.direction(x, y);
        let Some(lens) = self.lens else {
            return (self.eye, direction);
        };
        let on_lens = warp::concentric_disk(u).as_dvec2() * lens.radius;
        let offset = self.axes.right * on_lens.x + self.axes.up * on_lens.y;
        let to_focus = direction * (lens.focus_distance / direction.dot(self.axes.forward));
        (self.eye + offset, (to_focus - offset).normalize())
    }

    /// The ray from `eye`, a point in `f64`, along the unit vector `direction`, started near the scene; `None` when it misses the
    /// scene's box.
    #[must_use]
    pub fn ray_from(&self, eye: DVec3, direction: DVec3) -> Option<CameraRay> {
        let starts = self
            .boxes
            .iter()
            .filter_map(|met| met.start_before(eye, direction));
        let start = starts.reduce(f64::min)?;
        let origin = (eye + direction * start).as_vec3();
        Some(CameraRay {
            ray: Ray::new(origin, direction.as_vec3()),
            start,
        })
    }

    /// How a ray's unit `direction` changes from a pixel to the next on the right, and to the one below, through the same point of the
    /// lens: the derivative with respect to the place on the picture. It depends on the direction alone, as rays through one point of the
    /// lens diverge in front of it as those of a pinhole do.
    #[must_use]
    pub fn spread(&self, direction: DVec3) -> [DVec3; 2] {
        let right = self.axes.right * (self.per_pixel.x * self.half_width);
        let down = self.axes.up * (-self.per_pixel.y * self.half_height);
        let depth = direction.dot(self.axes.forward);
        [right, down].map(|change| (change - direction * direction.dot(change)) * depth)
    }

    /// The world's unit vectors to the right, up and into the picture.
    #[must_use]
    pub fn axes(&self) -> &CameraAxes {
        &self.axes
    }
}

impl MetBox {
    /// Where on the ray from `eye` along the unit vector `direction` to begin looking for what lies in the box; `None` when the
    /// ray misses it. One diagonal before the box: near enough to keep the digits, and clear of everything in it.
    #[inline]
    fn start_before(&self, eye: DVec3, direction: DVec3) -> Option<f64> {
        let (enter, exit) = crossing(&self.bounds, eye, direction);
        (enter <= exit && exit >= 0.0).then(|| (enter - self.diagonal).max(0.0))
    }
}

/// Where the line from `eye` along `direction` enters and leaves the box; the first is larger than the second where it misses the box.
#[inline]
fn crossing(bounds: &DBounds, eye: DVec3, direction: DVec3) -> (f64, f64) {
    let per_direction = direction.recip();
    let low = (bounds.min - eye) * per_direction;
    let high = (bounds.max - eye) * per_direction;
    // Along an axis that the line keeps its place on, it is between the sides or in one of them everywhere, or nowhere.
    // Denormal numbers are as good as 0: their reciprocals may be infinite.
    let keeps_place = direction.abs().cmplt(DVec3::splat(f64::MIN_POSITIVE));
    let is_between = bounds.min.cmple(eye) & eye.cmple(bounds.max);
    let end = DVec3::select(is_between, DVec3::INFINITY, DVec3::NEG_INFINITY);
    let enter = DVec3::select(keeps_place, -end, low.min(high));
    let exit = DVec3::select(keeps_place, end, low.max(high));
    (enter.max_element(), exit.min_element())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Degrees, Vec3};

    fn camera(description: Camera, width: u32, height: u32) -> PreparedCamera {
        let world = DBounds {
            min: DVec3::splat(-1.0),
            max: DVec3::splat(1.0),
        };
        let frame = SceneFrame::around(&world);
        let bounds = Bounds {
            min: frame.narrow(world.min),
            max: frame.narrow(world.max),
        };
        PreparedCamera::new(&description, &frame, &[bounds], width, height)
            .expect("the camera has a direction")
    }

    #[test]
    fn the_field_of_view_spans_the_full_height() {
        let eye = DVec3::new(0.0, -4.0, 0.0);
        let camera = camera(
            Camera {
                eye,
                vertical_fov: Degrees(60.0),
                ..Camera::default()
            },
            400,
            100,
        );
        let top = camera.direction(200.0, 0.0);
        assert!((top.angle_between(DVec3::Y) - 30_f64.to_radians()).abs() < 1e-12);
        assert!(top.z > 0.0);
        // Square pixels: four times as wide as high, to the right for larger x.
        let right = camera.direction(400.0, 50.0);
        assert!((right.x / right.y - 4.0 * 30_f64.to_radians().tan()).abs() < 1e-12);
        assert!(camera.direction(200.0, 50.0).abs_diff_eq(DVec3::Y, 1e-15));
    }

    #[test]
    fn a_focus_at_infinity_blurs_by_the_lens_everywhere() {
        let through = |focus_distance| {
            let description = Camera {
                eye: DVec3::new(0.0, -4.0, 0.0),
                aperture_radius: 0.5,
                focus_distance: Some(focus_distance),
                ..Camera::default()
            };
            let camera = camera(description, 100, 100);
            [Vec2::new(0.1, 0.9), Vec2::new(0.7, 0.4)].map(|u| camera.through_lens(20.0, 70.0, u))
        };
        let [(eye_a, a), (eye_b, b)] = through(f64::INFINITY);
        assert!(eye_a.distance(eye_b) > 0.1);
        assert!(a.is_normalized() && a.abs_diff_eq(b, 1e-15));
        for far in [1e30, 1e160, f64::MAX] {
            let [(_, near_a), (_, near_b)] = through(far);
            assert!(near_a.abs_diff_eq(a, 1e-15) && near_b.abs_diff_eq(b, 1e-15));
        }
    }

    #[test]
    fn cameras_beyond_what_digits_tell_are_refused_by_name() {
        let frame = SceneFrame::around(&DBounds {
            min: DVec3::splat(-1.0),
            max: DVec3::splat(1.0),
        });
        let with_lens = Camera {
            aperture_radius: 0.1,
            ..Camera::default()
        };
        let refused =
            |camera: Camera| PreparedCamera::check(&camera, &frame).map_err(|e| e.to_string());
        assert_eq!(refused(with_lens), Ok(()));
        let eye = DVec3::new(0.0, 1e149, 0.0);
        let expected = "camera.eye is 1.0e149 away from the objects; expected at most 2.0e15, 1e15 times their size";
        let far = Camera { eye, ..with_lens };
        assert_eq!(refused(far), Err(expected.to_owned()));
        let expected =
            "camera.aperture_radius is 1e80; expected at most 2.0e9, 1e9 times the objects' size";
        let wide = Camera {
            aperture_radius: 1e80,
            ..with_lens
        };
        assert_eq!(refused(wide), Err(expected.to_owned()));
        let close = Camera {
            focus_distance: Some(1e-200),
            ..with_lens
        };
        assert!(
            refused(close)
                .expect_err("too close")
                .contains("camera.focus_distance is 1e-200")
        );
        let pinhole = Camera {
            aperture_radius: 0.0,
            ..close
        };
        assert_eq!(refused(pinhole), Ok(()));
    }

    #[test]
    fn rays_beside_the_scene_are_not_traced() {
        let camera = camera(
            Camera {
                eye: DVec3::new(0.0, -4.0, 0.0),
                ..Camera::default()
            },
            100,
            100,
        );
        assert!(camera.ray(50.0, 50.0).is_some());
        assert!(camera.ray(0.0, 0.0).is_none());
    }

    /// 1,024 pixels across a thousandth of a degree are 1,024 different rays.
    #[test]
    fn a_tiny_field_of_view_has_a_ray_for_every_pixel() {
        // From 10⁵ away, the field of view frames the scene.
        let eye = DVec3::new(3.0, -5.0, 2.0).normalize() * 1e5;
        let camera = camera(
            Camera {
                eye,
                vertical_fov: Degrees(0.001),
                ..Camera::default()
            },
            1024,
            1024,
        );
        let rays: Vec<Ray> = (0..1024)
            .map(|x| camera.ray(f64::from(x) + 0.5, 512.0).expect("hits").ray)
            .collect();
        // Where the ray passes the middle of the scene, all places differ.
        let depth = rays[0].origin.length();
        let places: std::collections::BTreeSet<_> = rays
            .iter()
            .map(|ray| ray.at(depth).to_array().map(f32::to_bits))
            .collect();
        assert_eq!(places.len(), 1024);
    }

    #[test]
    fn an_empty_scene_is_never_met() {
        let frame = SceneFrame::around(&DBounds::EMPTY);
        let camera = PreparedCamera::new(&Camera::default(), &frame, &[Bounds::EMPTY], 10, 10)
            .expect("has a direction");
        assert!(camera.ray(5.0, 5.0).is_none());
    }

    #[test]
    fn origins_stay_before_the_scene() {
        let camera = camera(
            Camera {
                eye: DVec3::new(0.0, -1e6, 0.0),
                vertical_fov: Degrees(1e-4),
                ..Camera::default()
            },
            8,
            8,
        );
        let CameraRay { ray, start } = camera.ray(4.0, 4.0).expect("hits");
        assert!(
            ray.origin.y < -1.0 && ray.origin.y > -10.0,
            "{}",
            ray.origin
        );
        assert!(start > 1e5);
        assert_eq!(ray.direction, Vec3::Y);
    }

    /// Lines that come from 4 before the middle of a box with corners at ±1, along an axis.
    fn assert_crossing(eye: DVec3, direction: DVec3, crosses: bool) {
        let bounds = DBounds {
            min: DVec3::NEG_ONE,
            max: DVec3::ONE,
        };
        let (enter, exit) = crossing(&bounds, eye, direction);
        if crosses {
            assert_eq!((enter, exit), (3.0, 5.0), "from {eye} along {direction}");
        } else {
            assert!(enter > exit, "from {eye} along {direction}");
        }
    }

    #[test]
    fn lines_within_a_side_of_a_box_cross_it() {
        for axis in 0..3 {
            let [across, along] = [(axis + 1) % 3, (axis + 2) % 3];
            for (side, zero) in [(-1.0, 0.0), (-1.0, -0.0), (1.0, 0.0), (1.0, -0.0)] {
                for (offset, crosses) in [(0.5, true), (1.0, true), (-1.0, true), (1.5, false)] {
                    let mut eye = DVec3::ZERO;
                    eye[axis] = side;
                    eye[across] = offset;
                    eye[along] = -4.0;
                    let mut direction = DVec3::splat(zero);
                    direction[along] = 1.0;
                    assert_crossing(eye, direction, crosses);
                }
            }
        }
    }

    #[test]
    fn denormal_parts_of_a_direction_count_as_none() {
        for part in [f64::from_bits(1), f64::MIN_POSITIVE.next_down()] {
            for (x, crosses) in [(-1.0, true), (0.0, true), (1.0, true), (1.5, false)] {
                let eye = DVec3::new(x, -4.0, 0.0);
                assert_crossing(eye, DVec3::new(part, 1.0, 0.0), crosses);
                assert_crossing(eye, DVec3::new(-part, 1.0, 0.0), crosses);
            }
        }
    }
}
