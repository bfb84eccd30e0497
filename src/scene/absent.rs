//! What stands for meshes and images whose files are not there.
//!
//! A scene keeps all that it says of them: objects and materials go on naming the file, whose place in [`Scene::meshes`],
//! [`Scene::images`] or [`Scene::textures`] is taken by what is here. An object has no triangles then, a material its plain colours, and
//! the background is black.

use std::sync::{Arc, LazyLock};

use super::{Background, Material, Object, RadianceMap, Scene, Texels, TextureImage, Textures};
use crate::geometry::TriangleMesh;

/// What scenes share, and what stands for it where its file is not there.
pub trait Absent: Sized + Send + Sync + 'static {
    /// What stands for all that are not there: always the same one, by which it is known.
    fn absent() -> &'static Arc<Self>;
}

impl Absent for TriangleMesh {
    /// A mesh of nothing.
    fn absent() -> &'static Arc<Self> {
        static ABSENT: LazyLock<Arc<TriangleMesh>> = LazyLock::new(Arc::default);
        &ABSENT
    }
}

impl Absent for RadianceMap {
    /// One black pixel.
    fn absent() -> &'static Arc<Self> {
        static ABSENT: LazyLock<Arc<RadianceMap>> =
            LazyLock::new(|| Arc::new(RadianceMap::cleaned(1, 1, vec![[0.0; 3]]).0));
        &ABSENT
    }
}

impl Absent for TextureImage {
    /// One white texel, which changes no colour it multiplies.
    fn absent() -> &'static Arc<Self> {
        static ABSENT: LazyLock<Arc<TextureImage>> =
            LazyLock::new(|| Arc::new(TextureImage::new(1, 1, Texels::Bytes(vec![[255; 3]]))));
        &ABSENT
    }
}

/// Whether `thing` stands for one whose file is not there.
#[must_use]
pub fn is_absent<T: Absent>(thing: &Arc<T>) -> bool {
    Arc::ptr_eq(thing, T::absent())
}

impl Scene {
    /// Whether the file of the mesh of `object` is not there.
    #[must_use]
    pub fn lacks_mesh(&self, object: &Object) -> bool {
        self.meshes.get(&object.mesh).is_some_and(is_absent)
    }

    /// The textures of `material` whose files are not there.
    pub fn absent_textures<'a>(&'a self, material: &'a Material) -> impl Iterator<Item = &'a str> {
        let images = material.textures().into_iter().flat_map(Textures::images);
        images.filter(move |image| self.lacks_texture(image))
    }

    fn lacks_texture(&self, name: &str) -> bool {
        self.textures.get(name).is_some_and(is_absent)
    }

    /// The image of the background, where its file is not there.
    #[must_use]
    pub fn absent_background(&self) -> Option<&str> {
        match &self.background {
            Background::Image { image, .. } if self.images.get(image).is_some_and(is_absent) => {
                Some(image)
            }
            _ => None,
        }
    }

    /// `material` as it looks: without the images whose files are not there.
    pub(super) fn without_absent_images(&self, mut material: Material) -> Material {
        if let Some(textures) = material.textures_mut() {
            for image in [&mut textures.diffuse_image, &mut textures.normal_image] {
                image.take_if(|image| self.lacks_texture(image));
            }
        }
        material
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_that_are_not_there_are_on_no_object_and_stay_in_their_material() {
        let names = ["paint", "bumps"].map(str::to_owned);
        let mut clay = Material::default();
        let [paint, bumps] = names.clone();
        *clay.textures_mut().expect("it can have some") = Textures {
            diffuse_image: Some(paint.clone()),
            normal_image: Some(bumps.clone()),
            vertex_colors: true,
        };
        let object = Object {
            material: Some("clay".into()),
            ..Object::default()
        };
        let mut scene = Scene::default();
        scene.materials.insert("clay".into(), clay.clone());
        let there = TextureImage::new(1, 1, Texels::Bytes(vec![[255; 3]]));
        scene.textures.insert(paint, Arc::new(there));
        scene
            .textures
            .insert(bumps.clone(), Arc::clone(TextureImage::absent()));
        let shown = scene.material_of(&object).expect("is there");
        let textures = shown.textures().expect("it has some");
        assert_eq!(textures.images().collect::<Vec<_>>(), ["paint"]);
        assert!(textures.vertex_colors);
        assert_eq!(scene.materials["clay"], clay);
        let absent: Vec<_> = scene.absent_textures(&clay).collect();
        assert_eq!(absent, [bumps]);
    }
}
