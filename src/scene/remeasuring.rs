//! Changing the unit and the axes of a scene without changing its picture. Lengths scale by a factor, intensities by its square,
//! absorption by its inverse; radiance stays.

use super::{Background, Camera, Copies, Facing, Light, Material, Object, Scene, rotation_degrees};
use crate::math::{DMat3, DVec3};

/// Another unit and other axes for a scene: every point `p` becomes `turn · (scale · p)`, and what is seen stays as it was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Remeasure {
    /// A rotation that takes axes to axes.
    pub turn: DMat3,
    /// New units per old one, more than 0.
    pub scale: f64,
}

impl Default for Remeasure {
    fn default() -> Self {
        Self {
            turn: DMat3::IDENTITY,
            scale: 1.0,
        }
    }
}

impl Remeasure {
    /// Where `point` is then.
    #[must_use]
    pub fn point(&self, point: DVec3) -> DVec3 {
        self.turn * (point * self.scale)
    }

    /// Where `direction` points then.
    #[must_use]
    pub fn direction(&self, direction: DVec3) -> DVec3 {
        self.turn * direction
    }

    /// Remeasures objects, lights, cameras, glass and background of a scene.
    pub fn apply(&self, scene: &mut Scene) {
        for object in &mut scene.objects {
            self.object(object);
        }
        for light in &mut scene.lights {
            self.light(light);
        }
        let bookmarks = scene.bookmarks.iter_mut();
        let bookmarks = bookmarks.map(|bookmark| &mut bookmark.camera);
        for camera in bookmarks.chain([&mut scene.camera]) {
            self.camera(camera);
        }
        for material in scene.materials.values_mut() {
            if let Material::Glass { attenuation, .. } = material {
                *attenuation /= self.scale;
            }
        }
        match &mut scene.background {
            Background::Constant { .. } => {}
            Background::Gradient { up, .. } | Background::Image { up, .. } => {
                *up = self.direction(*up);
            }
        }
    }

    fn object(&self, object: &mut Object) {
        let rotation = object.placement().linear * (1.0 / object.scale);
        object.rotate = rotation_degrees(&(self.turn * rotation));
        object.scale *= self.scale;
        object.translate = self.point(object.translate);
        object.copies = self.copies(&object.copies);
    }

    /// The grid of copies, along the axes that its own become.
    fn copies(&self, copies: &Copies) -> Copies {
        let columns = self.turn.to_cols_array_2d();
        let before = |axis: usize| {
            let largest = |&a: &usize, &b: &usize| {
                let [a, b] = [a, b].map(|from| columns[from][axis].abs());
                a.total_cmp(&b)
            };
            (0..3).max_by(largest).unwrap_or(axis)
        };
        Copies {
            count: std::array::from_fn(|axis| copies.count[before(axis)]),
            step: self.point(copies.step),
        }
    }

    fn light(&self, light: &mut Light) {
        light.move_to(self.point(light.position()));
        match light {
            Light::Point { intensity, .. } => *intensity *= self.scale * self.scale,
            Light::Disk { facing, radius, .. } => {
                *radius *= self.scale;
                *facing = match *facing {
                    Facing::Target(target) => Facing::Target(self.point(target)),
                    Facing::Normal(normal) => Facing::Normal(self.direction(normal)),
                };
            }
        }
    }

    /// Remeasures a camera of the scene.
    pub fn camera(&self, camera: &mut Camera) {
        camera.eye = self.point(camera.eye);
        camera.target = self.point(camera.target);
        camera.up = self.direction(camera.up);
        camera.aperture_radius *= self.scale;
        if let Some(distance) = &mut camera.focus_distance {
            *distance *= self.scale;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Rgb;

    /// Z up becomes Y up, metres become millimetres.
    const UP_AND_MILLIMETRES: Remeasure = Remeasure {
        turn: DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y),
        scale: 1000.0,
    };

    #[test]
    fn points_of_objects_move_as_points_do() {
        let mut scene = Scene {
            objects: vec![Object {
                scale: -2.0,
                rotate: DVec3::new(20.0, -50.0, 110.0),
                translate: DVec3::new(1.0, 2.0, 3.0),
                copies: Copies {
                    count: [2, 3, 1],
                    step: DVec3::new(4.0, -1.0, 0.5),
                },
                ..Object::default()
            }],
            ..Scene::default()
        };
        let placed = |scene: &Scene| -> Vec<DVec3> {
            let object = &scene.objects[0];
            let placement = object.placement();
            let copies = object.copies.offsets();
            let corners = |offset| {
                [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z]
                    .map(|p| placement.world_from_object(p) + offset)
            };
            copies.flat_map(corners).collect()
        };
        let before = placed(&scene);
        UP_AND_MILLIMETRES.apply(&mut scene);
        let after = placed(&scene);
        assert_eq!(before.len(), after.len());
        for expected in before.into_iter().map(|p| UP_AND_MILLIMETRES.point(p)) {
            let mut distances = after.iter().map(|p| (*p - expected).length());
            assert!(distances.any(|distance| distance < 1e-9), "{expected}");
        }
    }

    /// Coordinates only trade places.
    #[test]
    fn quarter_turns_are_exact() {
        let mut scene = Scene {
            objects: vec![Object::default()],
            ..Scene::default()
        };
        let turn = Remeasure {
            scale: 1.0,
            ..UP_AND_MILLIMETRES
        };
        turn.apply(&mut scene);
        let point = DVec3::new(0.1, 0.2, 0.3);
        let placed = scene.objects[0].placement().world_from_object(point);
        assert_eq!(placed, DVec3::new(0.1, 0.3, -0.2));
        assert_eq!(turn.point(point), placed);
    }

    /// What light arrives at a surface, and what of it glass lets through, stays as it was.
    #[test]
    fn light_stays_as_it_was() {
        let mut scene = Scene {
            lights: vec![Light::Point {
                position: DVec3::new(0.0, 3.0, 4.0),
                intensity: Rgb::splat(50.0),
            }],
            ..Scene::default()
        };
        let glass = Material::Glass {
            ior: 1.5,
            attenuation: Rgb::splat(2.0),
        };
        scene.materials.insert("glass".into(), glass);
        UP_AND_MILLIMETRES.apply(&mut scene);
        let Light::Point {
            position,
            intensity,
        } = scene.lights[0]
        else {
            unreachable!("a point");
        };
        assert_eq!(position, DVec3::new(0.0, 4000.0, -3000.0));
        assert_eq!(intensity.x / position.length_squared(), 50.0 / 25.0);
        let Material::Glass { attenuation, .. } = scene.materials["glass"] else {
            unreachable!("glass");
        };
        assert_eq!(attenuation, Rgb::splat(0.002));
    }
}
