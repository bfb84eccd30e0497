//! Bringing the objects of one scene into another.

use std::collections::HashMap;

use super::{Object, Scene, UniqueNames, free_name, rotation_degrees};
use crate::math::DVec3;

impl Scene {
    /// Adds the objects of `other` with their meshes, materials and images; its lights, camera and settings stay there. Objects get names
    /// that are free here, and so do materials, but those that are here already under the same name are shared. Of meshes and images of one
    /// name, the new one counts for all.
    ///
    /// Returns the index of the first object that was added.
    pub fn join(&mut self, other: Self) -> usize {
        let first = self.objects.len();
        let mut renamed = HashMap::new();
        for (name, material) in other.materials {
            if self.materials.get(&name) == Some(&material) {
                continue;
            }
            let free = free_name(&name, |name| self.materials.contains_key(name));
            self.materials.insert(free.clone(), material);
            renamed.insert(name, free);
        }
        let mut names = UniqueNames::default();
        names.take(self.objects.iter().map(|object| object.name.clone()));
        for mut object in other.objects {
            object.name = names.unique(&object.name);
            if let Some(name) = object.material.as_ref().and_then(|name| renamed.get(name)) {
                object.material = Some(name.clone());
            }
            self.objects.push(object);
        }
        self.meshes.extend(other.meshes);
        self.textures.extend(other.textures);
        first
    }
}

impl Object {
    /// Turns it about the X axis of the scene, by so many degrees.
    pub fn turn_about_x(&mut self, degrees: f64) {
        if degrees == 0.0 {
            return;
        }
        let turn = Self {
            rotate: DVec3::X * degrees,
            ..Self::default()
        };
        let turn = turn.placement().linear;
        self.rotate = if self.rotate == DVec3::ZERO {
            DVec3::X * degrees
        } else {
            rotation_degrees(&(turn * self.rotation()))
        };
        self.translate = turn * self.translate;
        self.copies.step = turn * self.copies.step;
    }

    /// Its rotation alone.
    fn rotation(&self) -> crate::math::DMat3 {
        let unscaled = Self {
            rotate: self.rotate,
            ..Self::default()
        };
        unscaled.placement().linear
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::TriangleMesh;
    use crate::scene::{Copies, Material};
    use std::sync::Arc;

    fn scene(material: Material) -> Scene {
        Scene {
            objects: vec![Object {
                name: "seat".into(),
                mesh: "a.obj#wood".into(),
                material: Some("wood".into()),
                ..Object::default()
            }],
            materials: [("wood".to_owned(), material)].into(),
            meshes: [("a.obj#wood".to_owned(), Arc::new(TriangleMesh::default()))].into(),
            ..Scene::default()
        }
    }

    #[test]
    fn what_is_the_same_is_shared_and_what_is_not_gets_another_name() {
        let mut joined = scene(Material::default());
        assert_eq!(joined.join(scene(Material::default())), 1);
        assert_eq!(joined.join(scene(Material::mirror())), 2);
        let objects = joined.objects.iter();
        let names: Vec<_> = objects
            .map(|object| (object.name.as_str(), object.material.as_deref()))
            .collect();
        let expected = [
            ("seat", Some("wood")),
            ("seat 2", Some("wood")),
            ("seat 3", Some("wood 2")),
        ];
        assert_eq!(names, expected);
        assert_eq!((joined.materials.len(), joined.meshes.len()), (2, 1));
        assert_eq!(joined.materials["wood 2"], Material::mirror());
    }

    #[test]
    fn an_object_turns_with_all_it_has() {
        let object = Object {
            scale: -2.0,
            rotate: DVec3::new(20.0, -35.0, 110.0),
            translate: DVec3::new(1.0, 2.0, 3.0),
            copies: Copies {
                count: [2, 1, 1],
                step: DVec3::new(0.0, 1.0, 0.0),
            },
            ..Object::default()
        };
        let mut turned = object.clone();
        turned.turn_about_x(90.0);
        let point = DVec3::new(0.3, -0.7, 0.2);
        let before = object.placement().world_from_object(point);
        let after = turned.placement().world_from_object(point);
        assert!((after - DVec3::new(before.x, -before.z, before.y)).length() < 1e-14);
        assert_eq!(turned.copies.step, DVec3::Z);
        let mut plain = Object::default();
        plain.turn_about_x(-90.0);
        assert_eq!(plain.rotate, DVec3::new(-90.0, 0.0, 0.0));
    }
}
