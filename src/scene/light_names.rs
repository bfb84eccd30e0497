//! What people call the lights of a scene. No picture depends on it.

use super::{Light, Scene, free_name};

/// A light and its name, which is empty where the light goes by its number.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NamedLight {
    /// Its name, or an empty one.
    pub name: String,
    /// The light.
    pub light: Light,
}

impl Scene {
    /// The name of light number `index`, from 0 on; empty where it has none.
    #[must_use]
    pub fn light_name(&self, index: usize) -> &str {
        self.light_names.get(index).map_or("", String::as_str)
    }

    /// What to call light number `index`: its name, or "light 1" where it has none.
    #[must_use]
    pub fn light_label(&self, index: usize) -> String {
        match self.light_name(index) {
            name if name.trim().is_empty() => format!("light {}", index + 1),
            name => name.to_owned(),
        }
    }

    /// Calls light number `index` otherwise; an empty name takes away what it has.
    pub fn name_light(&mut self, index: usize, name: String) {
        if self.light_names.len() <= index {
            self.light_names.resize(index + 1, String::new());
        }
        self.light_names[index] = name;
        // The same names are the same list.
        while self.light_names.last().is_some_and(String::is_empty) {
            self.light_names.pop();
        }
    }

    /// Adds a light under its name, or one like it where that is taken, and returns its number.
    pub fn add_light(&mut self, NamedLight { name, light }: NamedLight) -> usize {
        let index = self.lights.len();
        self.light_names.truncate(index);
        self.lights.push(light);
        if !name.is_empty() {
            let is_taken = |name: &str| self.light_names.iter().any(|other| other == name);
            let name = free_name(&name, is_taken);
            self.name_light(index, name);
        }
        index
    }

    /// Takes light number `index` out; those after it keep their names.
    ///
    /// # Panics
    /// When there is none.
    pub fn remove_light(&mut self, index: usize) {
        self.lights.remove(index);
        if index < self.light_names.len() {
            self.light_names.remove(index);
        }
    }

    /// Its lights with their names.
    #[must_use]
    pub fn named_lights(&self) -> Vec<NamedLight> {
        let named = |(index, &light): (usize, &Light)| NamedLight {
            name: self.light_name(index).to_owned(),
            light,
        };
        self.lights.iter().enumerate().map(named).collect()
    }

    /// Takes these lights in place of its own.
    pub fn set_named_lights(&mut self, lights: Vec<NamedLight>) {
        self.lights.clear();
        self.light_names.clear();
        for (index, NamedLight { name, light }) in lights.into_iter().enumerate() {
            self.lights.push(light);
            self.name_light(index, name);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_keep_their_names_when_others_come_and_go() {
        let named = |name: &str| NamedLight {
            name: name.to_owned(),
            light: Light::default(),
        };
        let mut scene = Scene::default();
        for name in ["", "key", "", "key"] {
            scene.add_light(named(name));
        }
        let labels = |scene: &Scene| -> Vec<String> {
            let lights = 0..scene.lights.len();
            lights.map(|index| scene.light_label(index)).collect()
        };
        assert_eq!(labels(&scene), ["light 1", "key", "light 3", "key 2"]);
        scene.remove_light(0);
        assert_eq!(labels(&scene), ["key", "light 2", "key 2"]);
        scene.name_light(2, String::new());
        assert_eq!(labels(&scene), ["key", "light 2", "light 3"]);
        assert_eq!(scene.light_names, ["key"]);
        let mut same = Scene::default();
        same.set_named_lights(scene.named_lights());
        assert_eq!(same, scene);
        // Lights that were taken away by others take their names along.
        scene.lights.clear();
        assert_eq!(scene.add_light(named("")), 0);
        assert_eq!(labels(&scene), ["light 1"]);
    }
}
