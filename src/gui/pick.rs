//! What lies under the mouse: one ray into the prepared scene, from the camera of the moment.

use super::orbit::PictureSize;
use crate::math::{Bounds, DBounds, DVec2, DVec3, SceneFrame};
use crate::render::{PreparedCamera, PreparedGeometry};
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
    let (width, height) = (settings.width, settings.height);
    let bounds = geometry.accelerator().bounds();
    let prepared = PreparedCamera::new(camera, geometry.frame(), &[bounds], width, height)?;
    let x = position.x / size.width * f64::from(width);
    let y = position.y / size.height * f64::from(height);
    let camera_ray = prepared.ray(x, y)?;
    let hit = geometry
        .accelerator()
        .intersect(&camera_ray.ray, f32::INFINITY)?;
    let distance = (camera_ray.start + f64::from(hit.t)) / geometry.frame().scale();
    let point = camera.eye + prepared.direction(x, y) * distance;
    point.is_finite().then(|| Picked {
        object: geometry.object_of(hit.triangle),
        triangle: hit.triangle,
        point,
    })
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
