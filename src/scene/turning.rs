//! Another axis up: meshes do not say which way is up in them, so everything around them may have to be turned.

use super::{Background, Facing, Light, Scene, SceneError};
use crate::math::DVec3;

impl Scene {
    /// Turns camera, lights and background about the middle of the objects by a quarter, so that Y is up where Z was, and Z where
    /// anything else was.
    ///
    /// # Errors
    /// When the objects cannot be measured.
    pub fn turn_surroundings(&mut self) -> Result<(), SceneError> {
        let bounds = self.measured_bounds()?;
        let center = if bounds.is_empty() {
            DVec3::ZERO
        } else {
            bounds.center()
        };
        let up = self.camera.up;
        let is_z_up = up.z.abs() >= up.y.abs();
        let turned = |v: DVec3| {
            if is_z_up {
                DVec3::new(v.x, v.z, -v.y)
            } else {
                DVec3::new(v.x, -v.z, v.y)
            }
        };
        let moved = |place: DVec3| center + turned(place - center);
        let bookmarks = self.bookmarks.iter_mut();
        let bookmarks = bookmarks.map(|bookmark| &mut bookmark.camera);
        for camera in bookmarks.chain([&mut self.camera]) {
            camera.eye = moved(camera.eye);
            camera.target = moved(camera.target);
            camera.up = turned(camera.up);
        }
        for light in &mut self.lights {
            light.move_to(moved(light.position()));
            if let Light::Disk { facing, .. } = light {
                *facing = match *facing {
                    Facing::Target(target) => Facing::Target(moved(target)),
                    Facing::Normal(normal) => Facing::Normal(turned(normal)),
                };
            }
        }
        match &mut self.background {
            Background::Constant { .. } => {}
            Background::Gradient { up, .. } | Background::Image { up, .. } => *up = turned(*up),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes;
    use crate::scene::presets::{UpAxis, light_and_frame};
    use crate::scene::{Bookmark, Object, Rgb};
    use std::sync::Arc;

    /// A ball off the origin under the preset's light and a disk.
    fn lit_ball(up: UpAxis) -> Scene {
        let mut mesh = shapes::icosphere(1);
        for position in &mut mesh.positions {
            *position += DVec3::new(3.0, -1.0, 5.0);
        }
        let mut scene = Scene::default();
        scene.meshes.insert("ball".into(), Arc::new(mesh));
        scene.objects.push(Object {
            mesh: "ball".into(),
            ..Object::default()
        });
        light_and_frame(&mut scene, up).expect("can be measured");
        scene
    }

    #[test]
    fn what_is_turned_is_the_scene_with_the_other_axis_up() {
        let mut scene = lit_ball(UpAxis::Z);
        scene.bookmarks.push(Bookmark {
            name: "front".into(),
            camera: scene.camera,
        });
        let original = scene.clone();
        scene.turn_surroundings().expect("can be measured");
        let y_up = lit_ball(UpAxis::Y);
        let near = |a: DVec3, b: DVec3| assert!((a - b).length() < 1e-12, "{a} {b}");
        near(scene.camera.eye, y_up.camera.eye);
        assert_eq!(scene.bookmarks[0].camera, scene.camera);
        assert_eq!(scene.camera.up, y_up.camera.up);
        assert_eq!(scene.background, y_up.background);
        for (turned, expected) in scene.lights.iter().zip(&y_up.lights) {
            near(turned.position(), expected.position());
        }
        scene.turn_surroundings().expect("can be measured");
        near(scene.camera.eye, original.camera.eye);
        assert_eq!(scene.camera.up, original.camera.up);
    }

    #[test]
    fn disks_turn_where_they_shine() {
        let mut scene = lit_ball(UpAxis::Z);
        let disk = |facing| Light::Disk {
            center: DVec3::new(3.0, -1.0, 9.0),
            facing,
            radius: 1.0,
            radiance: Rgb::ONE,
            visible: true,
        };
        let middle = scene.bounds().center();
        scene.lights = vec![
            disk(Facing::Target(middle)),
            disk(Facing::Normal(-DVec3::Z)),
        ];
        scene.turn_surroundings().expect("can be measured");
        for light in &scene.lights {
            let Light::Disk { center, facing, .. } = *light else {
                unreachable!("both are disks");
            };
            assert!((center - (middle + DVec3::Y * 4.0)).length() < 1e-12);
            let normal = facing.normal(center).expect("it shines somewhere");
            assert!((normal + DVec3::Y).length() < 1e-12);
        }
    }
}
