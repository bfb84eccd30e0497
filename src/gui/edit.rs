//! Copying, pasting, duplicating and removing parts of a scene.

use std::collections::HashSet;
use std::sync::Arc;

use super::selection::Selection;
use crate::geometry::TriangleMesh;
use crate::scene::{Material, NamedLight, Object, Scene, free_name};

/// A part of a scene on its own: it can be pasted into any scene.
#[derive(Clone, Debug, PartialEq)]
pub enum Part {
    /// An object, its mesh and its material.
    Object {
        /// The object.
        object: Box<Object>,
        /// What its mesh is, where it is loaded.
        mesh: Option<Arc<TriangleMesh>>,
        /// What the material of its name is.
        material: Option<Material>,
    },
    /// A light and its name.
    Light(NamedLight),
    /// A material and its name.
    Material(String, Material),
}

/// What to call the selected part, where it is one that can be copied.
#[must_use]
pub fn name_of(scene: &Scene, selection: &Selection) -> Option<String> {
    match selection {
        Selection::Camera | Selection::Background => None,
        Selection::Object(index) => scene.objects.get(*index).map(|object| {
            if object.name.trim().is_empty() {
                format!("object {}", index + 1)
            } else {
                object.name.clone()
            }
        }),
        Selection::Light(index) => {
            let exists = *index < scene.lights.len();
            exists.then(|| scene.light_label(*index))
        }
        Selection::Material(name) => scene.materials.contains_key(name).then(|| name.clone()),
    }
}

/// Whether the selected part may be removed: a material that an object uses may not.
#[must_use]
pub fn is_removable(scene: &Scene, selection: &Selection) -> bool {
    match selection {
        Selection::Camera | Selection::Background => false,
        Selection::Object(_) | Selection::Light(_) => true,
        Selection::Material(name) => {
            let mut objects = scene.objects.iter();
            !objects.any(|object| object.material.as_ref() == Some(name))
        }
    }
}

/// The selected part; `None` where it cannot be copied, as there is only one.
#[must_use]
pub fn copy(scene: &Scene, selection: &Selection) -> Option<Part> {
    match selection {
        Selection::Camera | Selection::Background => None,
        Selection::Object(index) => {
            let object = scene.objects.get(*index)?;
            let material = object.material.as_ref();
            Some(Part::Object {
                mesh: scene.meshes.get(&object.mesh).cloned(),
                material: material.and_then(|name| scene.materials.get(name).cloned()),
                object: Box::new(object.clone()),
            })
        }
        Selection::Light(index) => scene.lights.get(*index).map(|&light| {
            let name = scene.light_name(*index).to_owned();
            Part::Light(NamedLight { name, light })
        }),
        Selection::Material(name) => {
            let material = scene.materials.get(name)?;
            Some(Part::Material(name.clone(), material.clone()))
        }
    }
}

/// Adds a copied part under a name that is free, and selects it. What an object brings along and the scene has already is shared.
pub fn paste(scene: &mut Scene, part: Part) -> Selection {
    match part {
        Part::Object {
            mut object,
            mesh,
            material,
        } => {
            object.name = free_object_name(scene, &object.name);
            if let Some(mesh) = mesh {
                scene.meshes.entry(object.mesh.clone()).or_insert(mesh);
            }
            if let (Some(name), Some(material)) = (&mut object.material, material)
                && scene.materials.get(name) != Some(&material)
            {
                *name = add_material(scene, name, material);
            }
            scene.objects.push(*object);
            Selection::Object(scene.objects.len() - 1)
        }
        Part::Light(light) => Selection::Light(add_light(scene, light)),
        Part::Material(name, material) => Selection::Material(add_material(scene, &name, material)),
    }
}

/// Adds a copy of the selected part, and selects it; `None` where there can be only one.
pub fn duplicate(scene: &mut Scene, selection: &Selection) -> Option<Selection> {
    let part = copy(scene, selection)?;
    Some(paste(scene, part))
}

/// Takes the selected part out of the scene and selects a neighbour; `None` where that may not be.
pub fn remove(scene: &mut Scene, selection: &Selection) -> Option<Selection> {
    if !is_removable(scene, selection) {
        return None;
    }
    let neighbour = |index: usize, left: usize| (left > 0).then(|| index.min(left - 1));
    let next = match selection {
        Selection::Object(index) if *index < scene.objects.len() => {
            let object = scene.objects.remove(*index);
            if !scene.objects.iter().any(|other| other.mesh == object.mesh) {
                scene.meshes.remove(&object.mesh);
            }
            neighbour(*index, scene.objects.len()).map(Selection::Object)
        }
        Selection::Light(index) if *index < scene.lights.len() => {
            // Those after it go on being called what they were.
            for later in index + 1..scene.lights.len() {
                if scene.light_name(later).is_empty() {
                    scene.name_light(later, usual_light_name(later));
                }
            }
            scene.remove_light(*index);
            neighbour(*index, scene.lights.len()).map(Selection::Light)
        }
        Selection::Material(name) => {
            scene.materials.remove(name)?;
            None
        }
        _ => return None,
    };
    Some(next.unwrap_or_default())
}

/// Adds a material called `name`, or nearly so, and returns its name.
fn add_material(scene: &mut Scene, name: &str, material: Material) -> String {
    let name = free_name(name, |name| scene.materials.contains_key(name));
    scene.materials.insert(name.clone(), material);
    name
}

/// What the window calls light number `index` where it has no name.
#[must_use]
pub fn usual_light_name(index: usize) -> String {
    format!("Light {}", index + 1)
}

/// Adds a light and returns its number; one without a name gets one where another light is called what it would be.
pub fn add_light(scene: &mut Scene, mut light: NamedLight) -> usize {
    if light.name.is_empty() {
        let usual = usual_light_name(scene.lights.len());
        let lights = 0..scene.lights.len();
        let labels = lights.map(|index| scene.light_label(index).to_lowercase());
        let labels: HashSet<String> = labels.collect();
        let is_taken = |name: &str| labels.contains(&name.to_lowercase());
        if is_taken(&usual) {
            light.name = free_name(&usual, is_taken);
        }
    }
    scene.add_light(light)
}

/// A name for a copy of the object called `name`; one without a name stays so.
fn free_object_name(scene: &Scene, name: &str) -> String {
    let is_taken = |name: &str| scene.objects.iter().any(|object| object.name == name);
    if name.is_empty() {
        String::new()
    } else {
        free_name(name, is_taken)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene() -> Scene {
        Scene {
            objects: vec![Object {
                name: "ram".into(),
                mesh: "ram.off".into(),
                material: Some("clay".into()),
                ..Object::default()
            }],
            materials: [("clay".to_owned(), Material::default())].into(),
            meshes: [("ram.off".to_owned(), Arc::new(TriangleMesh::default()))].into(),
            ..Scene::default()
        }
    }

    #[test]
    fn an_object_is_duplicated_and_removed() {
        let mut scene = scene();
        let copy = duplicate(&mut scene, &Selection::Object(0)).unwrap();
        assert_eq!(copy, Selection::Object(1));
        assert_eq!(scene.objects[1].name, "ram 2");
        assert_eq!((scene.materials.len(), scene.meshes.len()), (1, 1));
        let left = remove(&mut scene, &copy).unwrap();
        assert_eq!(left, Selection::Object(0));
        assert_eq!(scene.meshes.len(), 1);
        assert_eq!(remove(&mut scene, &left), Some(Selection::Camera));
        assert!(scene.meshes.is_empty());
        assert_eq!(remove(&mut scene, &Selection::Object(0)), None);
    }

    #[test]
    fn an_object_brings_what_it_needs_into_another_scene() {
        let part = copy(&scene(), &Selection::Object(0)).unwrap();
        let mut other = Scene::default();
        other.materials.insert("clay".into(), Material::mirror());
        assert_eq!(paste(&mut other, part), Selection::Object(0));
        assert_eq!(other.objects[0].material.as_deref(), Some("clay 2"));
        assert_eq!(other.materials["clay"], Material::mirror());
        assert!(other.meshes.contains_key("ram.off"));
    }

    #[test]
    fn a_copy_of_a_light_has_a_name_of_its_own() {
        let mut scene = scene();
        scene.add_light(NamedLight {
            name: "key".into(),
            ..NamedLight::default()
        });
        let copy = duplicate(&mut scene, &Selection::Light(0)).unwrap();
        assert_eq!(name_of(&scene, &copy).as_deref(), Some("key 2"));
        let left = remove(&mut scene, &Selection::Light(0)).unwrap();
        assert_eq!(name_of(&scene, &left).as_deref(), Some("key 2"));
    }

    #[test]
    fn lights_without_names_are_not_renumbered() {
        let mut scene = scene();
        for _ in 0..4 {
            add_light(&mut scene, NamedLight::default());
        }
        remove(&mut scene, &Selection::Light(2));
        let labels = |scene: &Scene| -> Vec<String> {
            let lights = 0..scene.lights.len();
            let label = |index| scene.light_label(index).to_lowercase();
            lights.map(label).collect()
        };
        assert_eq!(labels(&scene), ["light 1", "light 2", "light 4"]);
        // The next would be called like the last.
        duplicate(&mut scene, &Selection::Light(0)).unwrap();
        let mut names = labels(&scene);
        assert_eq!(names.len(), 4);
        names.sort();
        names.dedup();
        assert_eq!(names.len(), 4, "{names:?}");
    }

    #[test]
    fn a_material_in_use_stays() {
        let mut scene = scene();
        let clay = Selection::Material("clay".into());
        assert_eq!(remove(&mut scene, &clay), None);
        scene.objects.clear();
        assert_eq!(remove(&mut scene, &clay), Some(Selection::Camera));
        assert!(scene.materials.is_empty());
    }
}
