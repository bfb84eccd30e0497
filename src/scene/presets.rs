//! What a bare mesh gets to become a picture: a camera that frames it, light, and a material; and materials to begin with.

pub mod materials;

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{
    Background, Camera, Choice, Light, Material, Object, Rgb, Scene, SceneError, Textures,
    free_name,
};
use crate::geometry::TriangleMesh;
use crate::math::{DBounds, DVec3, Degrees};

/// Name of the material of bare meshes.
const MATERIAL: &str = "clay";

/// Name of that of bare meshes whose vertices have colours.
const COLORED: &str = "coloured";

/// Which way is up in a mesh. Files do not say it, but those who write them have habits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpAxis {
    /// +Y up, seen along −Z.
    Y,
    /// +Z up, seen along +Y.
    #[default]
    Z,
}

impl Choice for UpAxis {
    const ALL: &'static [(Self, &'static str)] = &[(Self::Y, "y"), (Self::Z, "z")];
}

impl UpAxis {
    /// The turn about X, in degrees, that makes what is up in a mesh point along `up`, where a quarter turn does so; otherwise 0.
    #[must_use]
    pub fn turn_to(self, up: DVec3) -> f64 {
        let points_along = |axis: DVec3| up.normalize_or_zero().dot(axis) > 0.9;
        match self {
            Self::Y if points_along(DVec3::Z) => 90.0,
            Self::Z if points_along(DVec3::Y) => -90.0,
            _ => 0.0,
        }
    }

    /// The direction that is `direction` where Z is up.
    fn turned(self, direction: DVec3) -> DVec3 {
        match self {
            Self::Y => DVec3::new(direction.x, direction.z, -direction.y),
            Self::Z => direction,
        }
    }
}

/// An object of the preset material with soft shading that keeps sharp edges.
#[must_use]
pub fn object() -> Object {
    Object {
        material: Some(MATERIAL.to_owned()),
        smooth: true,
        crease_angle: Degrees(60.0),
        ..Object::default()
    }
}

/// The material of vertices with colours of their own.
fn colored() -> Material {
    Material::Phong {
        diffuse: Rgb::ONE,
        specular: Rgb::splat(0.06),
        shininess: 40.0,
        textures: Textures {
            vertex_colors: true,
            ..Textures::default()
        },
    }
}

/// Gives the objects from number `first` on that have no material, and whose vertices have colours, one that shows these.
pub fn show_colors(scene: &mut Scene, first: usize) {
    let colored = colored();
    let is_taken = |name: &str| scene.materials.get(name).is_some_and(|m| *m != colored);
    let name = free_name(COLORED, is_taken);
    for object in &mut scene.objects[first..] {
        if object.material.is_none() && has_colors(&scene.meshes, object) {
            object.material = Some(name.clone());
            scene.materials.insert(name.clone(), colored.clone());
        }
    }
}

fn has_colors(meshes: &BTreeMap<String, Arc<TriangleMesh>>, object: &Object) -> bool {
    let mesh = meshes.get(&object.mesh);
    mesh.is_some_and(|mesh| mesh.colors.is_some())
}

/// Gives a scene of objects a camera in front of them, a key, a fill and a rim light, and a faint sky; and the preset material, where
/// an object wears it and the scene has none of its name. Objects of that material whose vertices have colours show these. Lights that
/// are there already stay alone, and the exposure follows them.
///
/// # Errors
/// When the objects are too large or too small to be measured.
pub fn light_and_frame(scene: &mut Scene, up: UpAxis) -> Result<(), SceneError> {
    let clay = Material::Phong {
        diffuse: Rgb::new(0.8, 0.62, 0.47),
        specular: Rgb::splat(0.06),
        shininess: 40.0,
        textures: Textures::default(),
    };
    let is_worn = scene.objects.is_empty()
        || scene
            .objects
            .iter()
            .any(|object| object.material.as_deref() == Some(MATERIAL));
    if is_worn {
        scene.materials.entry(MATERIAL.to_owned()).or_insert(clay);
    }
    for object in &mut scene.objects {
        if object.material.as_deref() == Some(MATERIAL) && has_colors(&scene.meshes, object) {
            object.material = Some(COLORED.to_owned());
            scene.materials.insert(COLORED.to_owned(), colored());
        }
    }
    let bounds = scene.measured_bounds()?;
    let has_lights = !scene.lights.is_empty();
    let stops = if has_lights {
        exposure(&scene.lights, center(&bounds))
    } else {
        0.0
    };
    if has_lights {
        scene.display.exposure = stops;
    }
    // The sky looks the same on screen, however the lights are.
    let sky = |r, g, b| Rgb::new(r, g, b) * libm::exp2(-stops);
    scene.background = Background::Gradient {
        zenith: sky(0.11, 0.14, 0.19),
        horizon: sky(0.23, 0.245, 0.26),
        ground: sky(0.06, 0.055, 0.05),
        up: up.turned(DVec3::Z),
    };
    let aspect = f64::from(scene.render.width) / f64::from(scene.render.height);
    scene.camera = framing(
        &bounds,
        up.turned(DVec3::new(-0.45, -1.0, 0.4)),
        up.turned(DVec3::Z),
        Degrees(35.0),
        aspect,
    );

    if has_lights {
        return Ok(());
    }
    let radius = radius(&bounds);
    let light = |direction: DVec3, irradiance: Rgb| {
        let distance = 3.0 * radius;
        Light::Point {
            position: center(&bounds) + up.turned(direction).normalize() * distance,
            // What arrives at the middle is then the same for any size of scene.
            intensity: irradiance * (distance * distance),
        }
    };
    scene.lights = vec![
        light(DVec3::new(0.6, -0.8, 1.0), Rgb::new(2.5, 2.36, 2.15)),
        light(DVec3::new(-1.0, -0.6, 0.3), Rgb::new(0.4, 0.47, 0.58)),
        light(DVec3::new(-0.3, 1.0, 0.8), Rgb::splat(1.0)),
    ];
    Ok(())
}

/// Stops by which light from `lights` is made brighter on screen, so that what is at `place` is neither black nor white: none where
/// their irradiance there is between a third and three times that of the preset lights.
fn exposure(lights: &[Light], place: DVec3) -> f64 {
    const USUAL: f64 = 3.0;
    let irradiance = |light: &Light| {
        let intensity = match *light {
            Light::Point { intensity, .. } => intensity,
            Light::Disk {
                radius, radiance, ..
            } => radiance * (std::f64::consts::PI * radius * radius),
        };
        intensity.max_element() / (light.position() - place).length_squared()
    };
    let total: f64 = lights.iter().map(irradiance).sum();
    let stops = libm::log2(USUAL / total);
    let is_dim_or_bright = stops.is_finite() && stops.abs() > libm::log2(3.0);
    // Halves of stops are what people set.
    if is_dim_or_bright {
        ((stops * 2.0).round() / 2.0).clamp(-MOST_STOPS, MOST_STOPS)
    } else {
        0.0
    }
}

/// Most stops that a preset makes brighter or darker.
const MOST_STOPS: f64 = 20.0;

/// `camera`, looking the same way, with its target as far away as the middle of `bounds`, if that lies in front of it: orbiting turns about
/// the target.
#[must_use]
pub fn aimed(camera: Camera, bounds: &DBounds) -> Camera {
    let Some(axes) = camera.axes() else {
        return camera;
    };
    let depth = (center(bounds) - camera.eye).dot(axes.forward);
    let distance = if depth > 0.0 { depth } else { radius(bounds) };
    Camera {
        target: camera.eye + axes.forward * distance,
        ..camera
    }
}

/// The camera that looks along `−direction` (from the side `direction` points to) and just holds the ball around `bounds`
/// in a picture of the given width to height.
#[must_use]
pub fn framing(
    bounds: &DBounds,
    direction: DVec3,
    up: DVec3,
    vertical_fov: Degrees,
    aspect: f64,
) -> Camera {
    let half_height = libm::tan(vertical_fov.radians() / 2.0);
    // The narrower of the two half angles decides.
    let half_angle = libm::atan(half_height * aspect.min(1.0));
    let target = center(bounds);
    let eye = target + direction.normalize() * (radius(bounds) / libm::sin(half_angle));
    Camera {
        eye,
        target,
        up,
        vertical_fov,
        ..Camera::default()
    }
}

/// Middle of the bounds; the origin of an empty scene.
fn center(bounds: &DBounds) -> DVec3 {
    if bounds.is_empty() {
        DVec3::ZERO
    } else {
        bounds.center()
    }
}

/// Radius of the ball around the bounds; 1 where they have no extent.
fn radius(bounds: &DBounds) -> f64 {
    let radius = bounds.diagonal() / 2.0;
    if radius > 0.0 { radius } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::math::Vec3;

    #[test]
    fn colors_of_vertices_are_shown() {
        let mut mesh = crate::geometry::shapes::icosphere(0);
        let mut scene = Scene::default();
        for name in ["plain", "coloured"] {
            scene.meshes.insert(name.into(), Arc::new(mesh.clone()));
            scene.objects.push(Object {
                mesh: name.into(),
                ..object()
            });
            mesh.colors = Some(vec![Vec3::ONE; mesh.positions.len()]);
        }
        light_and_frame(&mut scene, UpAxis::Z).expect("can be measured");
        let shows_colors = |index: usize| {
            let material = scene.material_of(&scene.objects[index]).expect("is there");
            material
                .textures()
                .is_some_and(|textures| textures.vertex_colors)
        };
        assert_eq!([0, 1].map(shows_colors), [false, true]);
    }

    #[test]
    fn framing_touches_the_ball_on_the_narrow_side() {
        let bounds = DBounds {
            min: DVec3::new(9.0, -1.0, -1.0),
            max: DVec3::new(11.0, 1.0, 1.0),
        };
        for aspect in [0.5, 2.0] {
            let camera = framing(&bounds, -DVec3::Y, DVec3::Z, Degrees(40.0), aspect);
            let distance = (camera.eye - DVec3::X * 10.0).length();
            let half_angle = (20_f64.to_radians().tan() * f64::min(aspect, 1.0)).atan();
            assert!((distance * half_angle.sin() - 3_f64.sqrt()).abs() < 1e-12);
            assert!(camera.axes().is_some());
        }
    }

    #[test]
    fn a_scene_without_extent_still_has_a_camera() {
        let mut scene = Scene::default();
        light_and_frame(&mut scene, UpAxis::Z).expect("nothing is too large");
        assert_eq!(scene.validate(), Ok(()));
        assert_eq!(scene.lights.len(), 3);
    }

    #[test]
    fn lights_that_are_there_stay_and_set_the_exposure() {
        let framed = |intensity: f64| {
            let mut scene = Scene {
                lights: vec![Light::Point {
                    position: DVec3::Z * 10.0,
                    intensity: Rgb::splat(intensity),
                }],
                ..Scene::default()
            };
            light_and_frame(&mut scene, UpAxis::Z).expect("nothing is too large");
            assert_eq!(scene.lights.len(), 1);
            scene.display.exposure
        };
        // 300 W/sr at 10 m give 3 W/m².
        assert_eq!(
            [300.0, 600.0, 300.0 * 64.0, 300.0 / 64.0, 0.0].map(framed),
            [0.0, 0.0, -6.0, 6.0, 0.0]
        );
    }

    #[test]
    fn a_camera_is_aimed_at_what_is_before_it() {
        let bounds = DBounds {
            min: DVec3::new(-1.0, 4.0, -1.0),
            max: DVec3::new(3.0, 6.0, 1.0),
        };
        let camera = Camera {
            eye: DVec3::ZERO,
            target: DVec3::Y,
            ..Camera::default()
        };
        assert_eq!(aimed(camera, &bounds).target, DVec3::Y * 5.0);
        let away = Camera {
            target: -DVec3::Y,
            ..camera
        };
        let target = aimed(away, &bounds).target;
        assert!(target.y < -1.0 && target.x == 0.0);
    }

    #[test]
    fn a_mesh_is_turned_to_stand_in_a_scene() {
        assert_eq!(UpAxis::Y.turn_to(DVec3::Z * 2.0), 90.0);
        assert_eq!(UpAxis::Z.turn_to(DVec3::Y), -90.0);
        for (mesh, up) in [
            (UpAxis::Y, DVec3::Y),
            (UpAxis::Z, DVec3::Z),
            (UpAxis::Y, DVec3::X),
        ] {
            assert_eq!(mesh.turn_to(up), 0.0);
        }
    }

    /// The scene with another axis up is the scene turned.
    #[test]
    fn everything_turns_with_the_axis() {
        let [z_up, y_up] = [UpAxis::Z, UpAxis::Y].map(|up| {
            let mut scene = Scene::default();
            light_and_frame(&mut scene, up).expect("nothing is too large");
            scene
        });
        // A quarter turn about X.
        let turn = |v: DVec3| DVec3::new(v.x, v.z, -v.y);
        assert_eq!(y_up.camera.up, DVec3::Y);
        assert!((y_up.camera.eye - turn(z_up.camera.eye)).length() < 1e-12);
        for (y_up, z_up) in y_up.lights.iter().zip(&z_up.lights) {
            assert!((y_up.position() - turn(z_up.position())).length() < 1e-12);
        }
    }
}
