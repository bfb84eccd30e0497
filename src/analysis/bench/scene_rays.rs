//! Rays as rendering a scene traces them: from the eye, and from every point that those meet.

use super::ray_set::{self, RayError, RaySet};
use crate::io::npy::RayRow;
use crate::math::{DVec3, Ray, SceneFrame, Vec3, warp};
use crate::render::{Decision, Dimension, PreparedScene, Sampler, SurfacePoint};
use crate::scene::{Facing, Light, Rgb, SamplerChoice, Scene};

/// Start of the random numbers. Rays are part of what is compared, so it is the same for all.
const SEED: u64 = 0;

/// Side of the tiles whose camera rays follow each other, in pixels.
const TILE_SIDE: u32 = 16;

/// Side of the blocks within a tile, whose rays make a packet.
const BLOCK_SIDE: u32 = 4;

/// Why a ray is traced, of those that are generated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    /// From the eye through the middle of each pixel, where that passes the scene's box.
    Camera,
    /// From each hit of those to a light.
    Shadow,
    /// From each hit into the hemisphere, no further than the scene's occlusion radius.
    AmbientOcclusion,
    /// From each hit into the hemisphere, without end.
    Bounce,
}

impl RayKind {
    /// In the order of reports.
    pub const ALL: [Self; 4] = [
        Self::Camera,
        Self::Shadow,
        Self::AmbientOcclusion,
        Self::Bounce,
    ];

    /// The name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Shadow => "shadow",
            Self::AmbientOcclusion => "ambient_occlusion",
            Self::Bounce => "bounce",
        }
    }

    /// The name of the file that holds such rays. Its end says whether any hit is asked for.
    #[must_use]
    pub fn file_name(self) -> &'static str {
        match self {
            Self::Camera => "camera.npy",
            Self::Shadow => "lights_shadow.npy",
            Self::AmbientOcclusion => "occlusion_shadow.npy",
            Self::Bounce => "bounce.npy",
        }
    }

    /// Whether any hit is asked for; the nearest otherwise.
    #[must_use]
    pub fn any_hit(self) -> bool {
        matches!(self, Self::Shadow | Self::AmbientOcclusion)
    }
}

/// The scene with a light to aim at: where it has none, a disk one diagonal above its middle, a tenth of the diagonal in
/// radius, facing down. Above is where the camera's up is.
#[must_use]
pub fn with_lamp(scene: &Scene) -> Scene {
    let mut lit = scene.clone();
    let bounds = scene.bounds();
    if scene.lights.is_empty() && !bounds.is_empty() {
        let up = scene.camera.up.try_normalize().unwrap_or(DVec3::Z);
        // A single point has no diagonal.
        let diagonal = bounds.diagonal().max(f64::MIN_POSITIVE);
        lit.lights.push(Light::Disk {
            center: bounds.center() + up * diagonal,
            facing: Facing::Normal(-up),
            radius: diagonal / 10.0,
            radiance: Rgb::ONE,
            visible: false,
        });
    }
    lit
}

/// The rays of every kind, in the order of [`RayKind::ALL`]: camera rays in tiles of 16 × 16 pixels, by blocks of 4 × 4, and from each of
/// their hits one ray of every other kind, in the same order. Shadow rays take the lights in turns, pixel after pixel, and go to a random
/// point of those with area; there are none in a scene without lights, see [`with_lamp`].
///
/// Rays start where the renderer's would, rounded away from the surface to what a file in world units holds. Shadow
/// rays end where their parameter is 1, directions of all others are unit vectors.
///
/// # Errors
/// A ray that `f32` cannot hold in world units.
pub fn generate(scene: &PreparedScene) -> Result<[RaySet; 4], RayError> {
    let frame = scene.geometry().frame();
    let mut rows: [Vec<RayRow>; 4] = Default::default();
    let (width, height) = (scene.settings().width, scene.settings().height);
    for top in (0..height).step_by(TILE_SIDE as usize) {
        for left in (0..width).step_by(TILE_SIDE as usize) {
            let (right, bottom) = (width.min(left + TILE_SIDE), height.min(top + TILE_SIDE));
            for block_top in (top..bottom).step_by(BLOCK_SIDE as usize) {
                for block_left in (left..right).step_by(BLOCK_SIDE as usize) {
                    for y in block_top..bottom.min(block_top + BLOCK_SIDE) {
                        for x in block_left..right.min(block_left + BLOCK_SIDE) {
                            add_pixel(scene, (x, y), &mut rows)?;
                        }
                    }
                }
            }
        }
    }
    let [camera, shadow, occlusion, bounce] = rows;
    let set = |kind: RayKind, rows| RaySet::new(kind.name(), kind.any_hit(), rows, frame);
    Ok([
        set(RayKind::Camera, camera)?,
        set(RayKind::Shadow, shadow)?,
        set(RayKind::AmbientOcclusion, occlusion)?,
        set(RayKind::Bounce, bounce)?,
    ])
}

/// Adds the rays of a pixel.
fn add_pixel(
    scene: &PreparedScene,
    (x, y): (u32, u32),
    [camera, shadow, occlusion, bounce]: &mut [Vec<RayRow>; 4],
) -> Result<(), RayError> {
    let frame = scene.geometry().frame();
    let center = |pixel: u32| f64::from(pixel) + 0.5;
    let Some(camera_ray) = scene.camera().ray(center(x), center(y)) else {
        return Ok(());
    };
    let Ray { origin, direction } = camera_ray.ray;
    let origin = frame.world_from_prepared(origin.as_dvec3());
    let row = ray_set::row(origin, Vec3::ZERO, direction, f32::INFINITY);
    camera.push(row);
    // What the file's ray meets, which is rounded once more. A unit vector, for the surface point.
    let (rounded, _) = ray_set::prepared(&row, frame).map_err(|expected| RayError {
        set: RayKind::Camera.name().to_owned(),
        index: camera.len() - 1,
        expected,
        found: format!("{row:?}"),
    })?;
    let ray = Ray::new(rounded.origin, direction);
    let Some(point) = scene.surface_along(&ray, f32::INFINITY) else {
        return Ok(());
    };

    let sampler = Sampler::new(SamplerChoice::Sobol, SEED, (x, y), 0);
    let numbers = |decision| sampler.next_2d(Dimension::once(decision));
    let around_normal = warp::Frame::around(point.shading_normal);
    let cosine_distributed =
        |decision| around_normal.world_from_local(warp::cosine_hemisphere(numbers(decision)));

    let wi = cosine_distributed(Decision::Direction);
    bounce.push(row_above(&point, frame, wi, f32::INFINITY));

    let wi = cosine_distributed(Decision::AmbientOcclusion);
    #[expect(clippy::cast_possible_truncation, reason = "rays are f32")]
    let radius = (f64::from(scene.occlusion_radius()) / frame.scale()) as f32;
    occlusion.push(row_above(&point, frame, wi, radius));

    if scene.light_count() > 0 {
        let pixel = u64::from(y) * u64::from(scene.settings().width) + u64::from(x);
        let light = usize::try_from(pixel % scene.light_count() as u64).expect("less than a usize");
        let target = scene.point_on_light(light, point.shading_position, numbers(Decision::Light));
        let [ox, oy, oz, ..] = row_above(&point, frame, point.ray_to(target).direction, 1.0);
        let target = frame.world_from_prepared(target.as_dvec3());
        let direction = target - Vec3::new(ox, oy, oz).as_dvec3();
        let [dx, dy, dz] = direction.as_vec3().to_array();
        shadow.push([ox, oy, oz, dx, dy, dz, 1.0]);
    }
    Ok(())
}

/// The row of [`SurfacePoint::ray_above`].
fn row_above(point: &SurfacePoint, frame: &SceneFrame, wi: Vec3, t_max: f32) -> RayRow {
    let ray = point.ray_above(wi);
    let origin = frame.world_from_prepared(ray.origin.as_dvec3());
    ray_set::row(origin, point.geometric_normal(), wi, t_max)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::control::CancelToken;
    use crate::geometry::shapes;
    use crate::scene::{Camera, Object, RenderSettings};

    /// A ball of triangles at that place, under that many point lights.
    fn scene(place: DVec3, lights: usize) -> Scene {
        let mut scene = Scene {
            camera: Camera {
                eye: place + DVec3::new(0.0, -3.0, 1.0),
                target: place,
                ..Camera::default()
            },
            render: RenderSettings {
                width: 50,
                height: 40,
                ..RenderSettings::default()
            },
            ..Scene::default()
        };
        let ball = Arc::new(shapes::icosphere(3));
        scene.meshes.insert("ball".into(), ball);
        scene.objects.push(Object {
            name: "ball".into(),
            mesh: "ball".into(),
            translate: place,
            ..Object::default()
        });
        let light = |index| Light::Point {
            position: place + DVec3::new(4.0, index as f64, 5.0),
            intensity: Rgb::ONE,
        };
        scene.lights = (0..lights).map(light).collect();
        scene
    }

    fn prepared(scene: &Scene) -> PreparedScene {
        let prepared = PreparedScene::prepare(scene, None, &CancelToken::new());
        prepared.expect("is right").expect("nobody cancels")
    }

    #[test]
    fn every_hit_has_one_ray_of_each_kind() {
        let scene = prepared(&scene(DVec3::ZERO, 3));
        let sets = generate(&scene).expect("fits");
        let [camera, others @ ..] = &sets;
        let hits = camera.rays().iter().filter(|(ray, t_max)| {
            let hit = scene.geometry().accelerator().intersect(ray, *t_max);
            hit.is_some()
        });
        let hits = hits.count();
        assert!(hits > 200 && hits < camera.rays().len() && camera.rays().len() <= 50 * 40);
        assert!(others.iter().all(|set| set.rays().len() == hits));
        for (set, kind) in sets.iter().zip(RayKind::ALL) {
            assert_eq!((set.name(), set.any_hit()), (kind.name(), kind.any_hit()));
            assert_eq!(kind.file_name().ends_with("_shadow.npy"), kind.any_hit());
        }
        let again = generate(&scene).expect("fits");
        for (set, again) in sets.iter().zip(&again) {
            assert_eq!(set.rows(), again.rows());
        }
    }

    /// On the outside of a ball no ray may meet the ball again, whatever digits its place takes; where shading normals are
    /// those of the triangles, all directions lead away.
    #[test]
    fn rays_start_off_the_surface() {
        for place in [DVec3::ZERO, DVec3::new(1000.0, -3.0, 0.1)] {
            let scene = prepared(&scene(place, 1));
            let [_, _, occlusion, bounce] = generate(&scene).expect("fits");
            for set in [occlusion, bounce] {
                for (ray, t_max) in set.rays() {
                    let hit = scene.geometry().accelerator().intersect(ray, *t_max);
                    assert_eq!(hit, None, "{} at {place}: {ray:?}", set.name());
                }
            }
        }
    }

    #[test]
    fn lights_take_turns_and_a_dark_scene_gets_a_lamp() {
        let shadow_rays = |scene: &Scene| {
            let [_, shadow, ..] = generate(&prepared(scene)).expect("fits");
            shadow.rows().to_vec()
        };
        let end = |row: &RayRow, axis: usize| row[axis] + row[axis + 3];
        let rows = shadow_rays(&scene(DVec3::ZERO, 3));
        for light in [0.0, 1.0, 2.0] {
            let at_light = rows.iter().filter(|row| {
                (end(row, 0) - 4.0).abs() < 1e-4 && (end(row, 1) - light).abs() < 1e-4
            });
            let share = at_light.count() as f64 / rows.len() as f64;
            assert!((share - 1.0 / 3.0).abs() < 0.02, "light {light}: {share}");
        }

        let dark = scene(DVec3::ZERO, 0);
        assert!(shadow_rays(&dark).is_empty());
        let lit = with_lamp(&dark);
        let rows = shadow_rays(&lit);
        let diagonal = 12_f32.sqrt();
        assert!(!rows.is_empty());
        for row in &rows {
            assert!((end(row, 2) - diagonal).abs() < 1e-3, "{row:?}");
            assert!(end(row, 0).hypot(end(row, 1)) < diagonal * 0.101, "{row:?}");
        }
        assert_eq!(with_lamp(&lit), lit);
    }
}
