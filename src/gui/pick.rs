//! What lies under the mouse: one ray into the prepared scene, from the camera of the moment.

use super::orbit::PictureSize;
use crate::accel::Visits;
use crate::math::{Bounds, DBounds, DVec2, DVec3, SceneFrame};
use crate::render::{CameraRay, PreparedCamera, PreparedGeometry, SurfacePoint};
use crate::scene::{Camera, RenderSettings};

/// The surface under a picture position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picked {
    /// Index of the object in the description.
    pub object: usize,
    /// Which triangle of the prepared scene.
    pub triangle: u32,
    /// Where, in world space.
    pub point: DVec3,
    /// What shading takes for the normal, on the side that is seen; unit.
    pub normal: DVec3,
}

/// The nearest surface under `position`, in pixels of `size`, seen from `camera` with the frame of `settings`' picture.
#[must_use]
pub fn pick(
    geometry: &PreparedGeometry,
    camera: &Camera,
    settings: &RenderSettings,
    size: PictureSize,
    position: DVec2,
) -> Option<Picked> {
    let (camera_ray, direction) = ray_through(geometry, camera, settings, size, position)?;
    let hit = geometry
        .accelerator()
        .intersect(&camera_ray.ray, f32::INFINITY)?;
    let distance = (camera_ray.start + f64::from(hit.t)) / geometry.frame().scale();
    let point = camera.eye + direction * distance;
    point.is_finite().then(|| Picked {
        object: geometry.object_of(hit.triangle),
        triangle: hit.triangle,
        point,
        normal: SurfacePoint::new(geometry, &camera_ray.ray, &hit)
            .shading_normal
            .as_dvec3(),
    })
}

/// What the ray of [`pick`] visits of the structure; nothing where it passes by everything.
#[must_use]
pub fn visits(
    geometry: &PreparedGeometry,
    camera: &Camera,
    settings: &RenderSettings,
    size: PictureSize,
    position: DVec2,
) -> Visits {
    let ray = ray_through(geometry, camera, settings, size, position);
    ray.map_or_else(Visits::default, |(ray, _)| {
        geometry
            .accelerator()
            .visits(&ray.ray, f32::INFINITY, false)
    })
}

/// The ray through `position`, and its direction in `f64`; `None` where it passes by everything.
fn ray_through(
    geometry: &PreparedGeometry,
    camera: &Camera,
    settings: &RenderSettings,
    size: PictureSize,
    position: DVec2,
) -> Option<(CameraRay, DVec3)> {
    let (width, height) = (settings.width, settings.height);
    let bounds = geometry.accelerator().bounds();
    let prepared = PreparedCamera::new(camera, geometry.frame(), &[bounds], width, height)?;
    let x = position.x / size.width * f64::from(width);
    let y = position.y / size.height * f64::from(height);
    Some((prepared.ray(x, y)?, prepared.direction(x, y)))
}

/// The world box of the prepared triangles.
#[must_use]
pub fn world_bounds(geometry: &PreparedGeometry) -> DBounds {
    to_world(geometry.frame(), &geometry.accelerator().bounds())
}

/// A box of the prepared scene, in the world.
#[must_use]
pub fn to_world(frame: &SceneFrame, bounds: &Bounds) -> DBounds {
    if bounds.is_empty() {
        return DBounds::EMPTY;
    }
    DBounds {
        min: frame.world_from_prepared(bounds.min.as_dvec3()),
        max: frame.world_from_prepared(bounds.max.as_dvec3()),
    }
}
