//! How the mouse moves the camera: pure maths on [`Camera`], in `f64` and world units, with no window in sight.
//!
//! Every function takes a camera and returns the moved one. Where the result would not be a camera (not finite, eye on
//! target, view along `up`), or the input is none, the camera comes back as it was, so that no sequence of moves ends in
//! NaN. Picture positions are in pixels of a [`PictureSize`], y down, `(0, 0)` the top left corner of the top left pixel.

use crate::math::{DBounds, DVec2, DVec3, direction_of};
use crate::scene::{Camera, CameraAxes};

/// Closest the view may come to the poles of the turntable, in radians.
const POLE_MARGIN: f64 = 0.01;
/// Room left around the objects by [`frame_all`], as a factor of the distance.
const FRAME_MARGIN: f64 = 1.08;

/// Width and height of the picture a position refers to, in pixels (of the screen or of the render: only the ratio
/// decides what is seen).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureSize {
    /// Pixels across; more than 0.
    pub width: f64,
    /// Pixels down; more than 0.
    pub height: f64,
}

impl PictureSize {
    /// Half the picture's extent on the plane at distance 1 before the eye.
    fn half_extent(self, camera: &Camera) -> DVec2 {
        let half_height = (camera.vertical_fov.radians() * 0.5).tan();
        DVec2::new(half_height * self.width / self.height, half_height)
    }
}

/// How far the eye may get from what it looks at, so that moves stay visible and numbers precise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceLimits {
    /// Smallest distance in world units.
    pub min: f64,
    /// Largest distance in world units.
    pub max: f64,
}

impl DistanceLimits {
    /// Limits for a scene inside `bounds`: from a millionth of its diagonal to ten thousand diagonals.
    #[must_use]
    pub fn of_scene(bounds: &DBounds) -> Self {
        let diagonal = bounds.diagonal();
        let size = if diagonal > 0.0 && diagonal.is_finite() {
            diagonal
        } else {
            1.0
        };
        // Far from the world's origin the spacing of the numbers themselves is the limit.
        let offset = if bounds.is_empty() {
            0.0
        } else {
            bounds.center().abs().max_element()
        };
        Self {
            min: (size * 1e-6).max(offset * 1e-13),
            max: size * 1e4,
        }
    }
}

/// Turns the camera about its target like a turntable whose axis is the camera's `up`.
///
/// `turn`: radians; a positive `x` moves the eye to the right around the axis, a positive `y` lifts it towards `up`, as
/// far as just before the pole.
#[must_use]
pub fn orbit(camera: &Camera, turn: DVec2) -> Camera {
    let (Some(axes), Some(up)) = (camera.axes(), direction_of(camera.up)) else {
        return *camera;
    };
    let offset = camera.eye - camera.target;
    let distance = offset.length();
    let polar = (offset / distance).dot(up).clamp(-1.0, 1.0).acos();
    // A camera that a file put nearer to the pole than the margin may stay there, but not go further.
    let margin = POLE_MARGIN.min(polar).min(std::f64::consts::PI - polar);
    let polar = (polar - turn.y).clamp(margin, std::f64::consts::PI - margin);
    // `right` is horizontal, so `up × …` gives the horizontal direction from the target to the eye.
    let outward = axes.right.cross(up);
    let (sin, cos) = turn.x.sin_cos();
    let outward = outward * cos + axes.right * sin;
    let direction = outward * polar.sin() + up * polar.cos();
    checked(
        camera,
        Camera {
            eye: camera.target + direction * distance,
            ..*camera
        },
    )
}

/// Moves the camera sideways so that what lies under the picture position `from`, at `depth` world units along the view
/// axis, comes to lie under `to`.
#[must_use]
pub fn pan(camera: &Camera, size: PictureSize, from: DVec2, to: DVec2, depth: f64) -> Camera {
    let (Some(from), Some(to)) = (
        view_direction(camera, size, from),
        view_direction(camera, size, to),
    ) else {
        return *camera;
    };
    let shift = (from - to) * depth;
    checked(
        camera,
        Camera {
            eye: camera.eye + shift,
            target: camera.target + shift,
            ..*camera
        },
    )
}

/// Scales the camera's distance to everything by `factor` about the world point `fixed`, which stays where it is in the
/// picture. Less than 1 comes nearer. The distance from the eye to `fixed` stays within `limits`.
#[must_use]
pub fn zoom(camera: &Camera, factor: f64, fixed: DVec3, limits: DistanceLimits) -> Camera {
    let distance = camera.eye.distance(fixed);
    if distance <= 0.0 || !distance.is_finite() || !factor.is_finite() || factor <= 0.0 {
        return *camera;
    }
    // A camera outside the limits may move towards them, and is not pulled inside at once.
    let min = limits.min.min(distance);
    let max = limits.max.max(distance);
    let factor = (distance * factor).clamp(min, max) / distance;
    let scaled = |point: DVec3| fixed + (point - fixed) * factor;
    checked(
        camera,
        Camera {
            eye: scaled(camera.eye),
            target: scaled(camera.target),
            ..*camera
        },
    )
}

/// Keeps the direction of view and moves the camera to where all of `bounds` is in the picture, centred.
#[must_use]
pub fn frame_all(camera: &Camera, size: PictureSize, bounds: &DBounds) -> Camera {
    let Some(axes) = camera.axes() else {
        return *camera;
    };
    if bounds.is_empty() {
        return *camera;
    }
    let center = bounds.center();
    let half = size.half_extent(camera);
    // Each corner asks for its own distance: |x| ≤ (distance + z) · tan of the half angle, with z along the view.
    let distance = corners(bounds)
        .map(|corner| {
            let offset = in_view(&axes, corner - center);
            let sideways = (offset.x.abs() / half.x).max(offset.y.abs() / half.y);
            // The second bound keeps a corner in front of the eye where the picture is very wide.
            (sideways * FRAME_MARGIN - offset.z).max(-offset.z * FRAME_MARGIN)
        })
        .fold(0.0, f64::max);
    // A single point has no size to frame: look at it from where the camera was.
    let distance = if distance > 0.0 {
        distance
    } else {
        camera.eye.distance(camera.target)
    };
    checked(
        camera,
        Camera {
            eye: center - axes.forward * distance,
            target: center,
            ..*camera
        },
    )
}

/// Whether `after` sees other places than `before`, or from elsewhere. The lens does not count: what is sharp is no question of place.
#[must_use]
pub fn is_moved(before: &Camera, after: &Camera) -> bool {
    let view = |camera: &Camera| (camera.eye, camera.target, camera.up, camera.vertical_fov);
    view(before) != view(after)
}

/// Looks at `point` from where the eye is, and orbits about it from now on.
#[must_use]
pub fn look_at(camera: &Camera, point: DVec3) -> Camera {
    checked(
        camera,
        Camera {
            target: point,
            ..*camera
        },
    )
}

/// The direction through a picture position, in world space, scaled to advance 1 along the view axis.
#[must_use]
pub fn view_direction(camera: &Camera, size: PictureSize, position: DVec2) -> Option<DVec3> {
    let axes = camera.axes()?;
    let half = size.half_extent(camera);
    let x = (2.0 * position.x / size.width - 1.0) * half.x;
    let y = (1.0 - 2.0 * position.y / size.height) * half.y;
    let direction = axes.forward + axes.right * x + axes.up * y;
    direction.is_finite().then_some(direction)
}

/// Where a world point is in the picture, and how far along the view axis; `None` behind the eye.
#[must_use]
pub fn project(camera: &Camera, size: PictureSize, point: DVec3) -> Option<(DVec2, f64)> {
    let offset = in_view(&camera.axes()?, point - camera.eye);
    if offset.z <= 0.0 {
        return None;
    }
    let half = size.half_extent(camera);
    let position = DVec2::new(
        (offset.x / (offset.z * half.x) + 1.0) * 0.5 * size.width,
        (1.0 - offset.y / (offset.z * half.y)) * 0.5 * size.height,
    );
    position.is_finite().then_some((position, offset.z))
}

/// Where the part of the line from `from` to `to` that lies before the eye is in the picture; `None` where all of it is behind.
#[must_use]
pub fn project_line(
    camera: &Camera,
    size: PictureSize,
    from: DVec3,
    to: DVec3,
) -> Option<[DVec2; 2]> {
    /// What is nearer than this share of the farther end's distance is cut off.
    const NEAREST: f64 = 1e-4;
    let axes = camera.axes()?;
    let depth = |point: DVec3| axes.forward.dot(point - camera.eye);
    let depths = [depth(from), depth(to)];
    let near = depths[0].max(depths[1]) * NEAREST;
    if near.is_nan() || near <= 0.0 {
        return None;
    }
    let cut = |end: DVec3, own: f64, other_end: DVec3, other: f64| {
        if own >= near {
            end
        } else {
            end.lerp(other_end, (near - own) / (other - own))
        }
    };
    let ends = [
        cut(from, depths[0], to, depths[1]),
        cut(to, depths[1], from, depths[0]),
    ];
    let [a, b] = ends.map(|end| project(camera, size, end));
    Some([a?.0, b?.0])
}

/// Distance of `point` from the eye along the view axis; `None` behind the eye.
#[must_use]
pub fn depth_of(camera: &Camera, point: DVec3) -> Option<f64> {
    let depth = camera.axes()?.forward.dot(point - camera.eye);
    (depth > 0.0 && depth.is_finite()).then_some(depth)
}

/// A vector's components to the right, up and forward.
fn in_view(axes: &CameraAxes, vector: DVec3) -> DVec3 {
    DVec3::new(
        vector.dot(axes.right),
        vector.dot(axes.up),
        vector.dot(axes.forward),
    )
}

/// The eight corners of a box.
fn corners(bounds: &DBounds) -> impl Iterator<Item = DVec3> + use<> {
    let (min, max) = (bounds.min, bounds.max);
    (0..8_u8).map(move |bits| {
        DVec3::select(
            glam::BVec3::new(bits & 1 != 0, bits & 2 != 0, bits & 4 != 0),
            max,
            min,
        )
    })
}

/// `moved` where it is a camera one can look through, else the one before.
fn checked(before: &Camera, moved: Camera) -> Camera {
    let finite = moved.eye.is_finite() && moved.target.is_finite();
    if finite && moved.axes().is_some() {
        moved
    } else {
        *before
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Degrees;

    const SIZE: PictureSize = PictureSize {
        width: 640.0,
        height: 480.0,
    };

    /// Cameras of every kind: up along each axis and askew, tiny and huge scenes, far out.
    fn cameras() -> Vec<Camera> {
        let mut cameras = Vec::new();
        for up in [
            DVec3::X,
            DVec3::Y,
            DVec3::Z,
            DVec3::NEG_Z,
            DVec3::new(0.3, -2.0, 0.7),
        ] {
            for scale in [1e-30, 1e-3, 1.0, 1e6, 1e30] {
                for offset in [0.0, 1e4] {
                    for fov in [1.0, 40.0, 120.0] {
                        let target = DVec3::new(0.2, -0.4, 0.9) * scale * (1.0 + offset);
                        cameras.push(Camera {
                            eye: target + DVec3::new(3.0, -5.0, 2.0) * scale,
                            target,
                            up,
                            vertical_fov: Degrees(fov),
                            ..Camera::default()
                        });
                    }
                }
            }
        }
        cameras
    }

    fn assert_sound(camera: &Camera) {
        assert!(
            camera.eye.is_finite() && camera.target.is_finite() && camera.axes().is_some(),
            "{camera:?}"
        );
    }

    #[test]
    fn a_full_turn_comes_back_and_keeps_the_distance() {
        for camera in cameras() {
            let mut turned = camera;
            for _ in 0..8 {
                turned = orbit(&turned, DVec2::new(std::f64::consts::FRAC_PI_4, 0.0));
                let distance = turned.eye.distance(turned.target);
                let before = camera.eye.distance(camera.target);
                assert!((distance / before - 1.0).abs() < 1e-9);
            }
            let error = turned.eye.distance(camera.eye) / camera.eye.distance(camera.target);
            assert!(error < 1e-9, "{camera:?}: {error}");
        }
    }

    #[test]
    fn a_positive_turn_goes_right_and_up() {
        let camera = Camera {
            eye: DVec3::new(0.0, -5.0, 0.0),
            target: DVec3::ZERO,
            up: DVec3::Z,
            vertical_fov: Degrees(40.0),
            ..Camera::default()
        };
        let right = orbit(&camera, DVec2::new(0.5, 0.0));
        assert!(right.eye.x > 0.0 && right.eye.z.abs() < 1e-12);
        let above = orbit(&camera, DVec2::new(0.0, 0.5));
        assert!(above.eye.z > 0.0 && above.eye.x.abs() < 1e-12);
    }

    #[test]
    fn the_poles_stop_the_turntable() {
        for camera in cameras() {
            for lift in [10.0, -10.0] {
                let mut lifted = orbit(&camera, DVec2::new(0.0, lift));
                assert_sound(&lifted);
                assert_ne!(lifted, camera, "the camera moves up to the pole");
                // It still turns there, and comes back down.
                lifted = orbit(&lifted, DVec2::new(1.0, -lift.signum()));
                assert_sound(&lifted);
                let up = lifted.up.normalize();
                let outward = (lifted.eye - lifted.target).normalize();
                assert!(outward.dot(up).abs() < 0.9);
            }
        }
    }

    #[test]
    fn panning_keeps_the_point_under_the_cursor() {
        let (from, to) = (DVec2::new(100.0, 400.0), DVec2::new(333.0, 21.0));
        for camera in cameras() {
            let depth = camera.eye.distance(camera.target) * 0.7;
            let point = camera.eye + view_direction(&camera, SIZE, from).unwrap() * depth;
            let moved = pan(&camera, SIZE, from, to, depth);
            let (position, new_depth) = project(&moved, SIZE, point).unwrap();
            assert!(position.distance(to) < 1e-6, "{camera:?}: {position}");
            assert!((new_depth / depth - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn zooming_keeps_the_point_under_the_cursor() {
        let cursor = DVec2::new(612.0, 33.0);
        for camera in cameras() {
            let distance = camera.eye.distance(camera.target);
            let limits = DistanceLimits {
                min: distance * 1e-3,
                max: distance * 1e3,
            };
            let point =
                camera.eye + view_direction(&camera, SIZE, cursor).unwrap() * (distance * 1.3);
            let mut zoomed = camera;
            for _ in 0..10 {
                zoomed = zoom(&zoomed, 0.8, point, limits);
            }
            assert!(zoomed.eye.distance(point) < camera.eye.distance(point) * 0.2);
            let (position, _) = project(&zoomed, SIZE, point).unwrap();
            assert!(position.distance(cursor) < 1e-5, "{camera:?}: {position}");
        }
    }

    #[test]
    fn zooming_stops_at_the_limits() {
        for camera in cameras() {
            let distance = camera.eye.distance(camera.target);
            let limits = DistanceLimits {
                min: distance * 0.5,
                max: distance * 2.0,
            };
            for (factor, end) in [(0.5, limits.min), (2.0, limits.max)] {
                let mut zoomed = camera;
                for _ in 0..200 {
                    zoomed = zoom(&zoomed, factor, camera.target, limits);
                    assert_sound(&zoomed);
                }
                let reached = zoomed.eye.distance(camera.target);
                assert!((reached / end - 1.0).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn framing_shows_every_corner_and_fills_the_picture() {
        for camera in cameras() {
            let scale = camera.eye.distance(camera.target);
            let bounds = DBounds {
                min: camera.target - DVec3::new(1.0, 0.1, 3.0) * scale,
                max: camera.target + DVec3::new(2.0, 0.4, 0.5) * scale,
            };
            for size in [
                SIZE,
                PictureSize {
                    width: 100.0,
                    height: 900.0,
                },
            ] {
                let framed = frame_all(&camera, size, &bounds);
                assert_sound(&framed);
                let mut nearest_edge = f64::INFINITY;
                for corner in corners(&bounds) {
                    let (p, _) = project(&framed, size, corner).expect("in front of the eye");
                    let to_edge = (p.x / size.width)
                        .min(1.0 - p.x / size.width)
                        .min(p.y / size.height)
                        .min(1.0 - p.y / size.height);
                    nearest_edge = nearest_edge.min(to_edge);
                }
                assert!(nearest_edge > 0.0, "cut off: {camera:?}");
                assert!(nearest_edge < 0.15, "lost in the middle: {nearest_edge}");
            }
        }
    }

    #[test]
    fn lines_are_cut_off_behind_the_eye() {
        for camera in cameras() {
            let axes = camera.axes().unwrap();
            let distance = camera.eye.distance(camera.target);
            let ahead = camera.target + axes.right * (distance * 0.1);
            let behind = camera.eye - axes.forward * distance + axes.up * (distance * 0.3);
            let [a, b] = project_line(&camera, SIZE, ahead, behind).unwrap();
            let (expected, _) = project(&camera, SIZE, ahead).unwrap();
            assert!(a.distance(expected) < 1e-6, "{a} {expected}");
            assert!(b.is_finite());
            // What is before the eye of the line lies on the line in the picture.
            let middle = ahead.lerp(behind, 0.3);
            let (middle, _) = project(&camera, SIZE, middle).unwrap();
            let off = (b - a).normalize().perp_dot(middle - a);
            assert!(off.abs() < 1e-3, "{off}");
            let behind_too = behind + axes.right * distance;
            assert_eq!(project_line(&camera, SIZE, behind, behind_too), None);
        }
    }

    #[test]
    fn framing_a_point_or_nothing_is_harmless() {
        for camera in cameras() {
            let point = DBounds {
                min: DVec3::ONE,
                max: DVec3::ONE,
            };
            assert_sound(&frame_all(&camera, SIZE, &point));
            assert_eq!(frame_all(&camera, SIZE, &DBounds::EMPTY), camera);
        }
    }

    #[test]
    fn no_input_ends_in_nan() {
        let wild = [
            0.0,
            -1.0,
            1e-300,
            1e300,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NAN,
        ];
        for camera in cameras() {
            for x in wild {
                for y in wild {
                    let limits = DistanceLimits {
                        min: 1e-9,
                        max: 1e9,
                    };
                    assert_sound(&orbit(&camera, DVec2::new(x, y)));
                    assert_sound(&pan(&camera, SIZE, DVec2::ZERO, DVec2::new(x, y), x));
                    assert_sound(&zoom(&camera, x, DVec3::splat(y), limits));
                    assert_sound(&look_at(&camera, DVec3::new(x, y, 0.0)));
                    let bounds = DBounds {
                        min: DVec3::splat(x),
                        max: DVec3::splat(y),
                    };
                    assert_sound(&frame_all(&camera, SIZE, &bounds));
                    let limits = DistanceLimits::of_scene(&bounds);
                    assert!(limits.min > 0.0 && limits.max > 0.0);
                }
            }
        }
        // A camera that is none stays as it is.
        let broken = Camera {
            target: DVec3::ZERO,
            eye: DVec3::ZERO,
            ..Camera::default()
        };
        assert_eq!(orbit(&broken, DVec2::ONE), broken);
    }
}
