//! What varies over a surface: colours and normals from images, and the colours of vertices.
//!
//! The code that takes samples is compiled once with it and once without: a scene that needs nothing of it runs code that knows of
//! no texture, and has no pyramid of an image. Texture coordinates and colours of vertices are read from the mesh itself, which the
//! description holds in any case; nothing is copied.
//!
//! How much of an image a sample stands for is told by how far apart neighbouring rays are, see [`Footprint`].

mod footprint;
mod object;
mod pyramid;

use std::borrow::Borrow;
use std::sync::Arc;

use super::camera::CameraRay;
use super::phong::Phong;
use super::plan::Feature;
use super::prepare::PreparedScene;
use super::surface::SurfacePoint;
use crate::accel::Hit;
use crate::control::CancelToken;
use crate::memory::require;
use crate::scene::{Scene, SceneError, TextureImage};
use footprint::Footprint;
use object::TexturedObject;
pub use pyramid::{Meaning, Pyramid};

/// What a form of the code that takes samples knows of textures, along one path.
pub trait Texturing: Copy {
    /// The material at a point: the object's, or one of its own.
    type Phong<'a>: Borrow<Phong>;

    /// At the beginning of a path.
    fn from_eye(scene: &PreparedScene, ray: &CameraRay) -> Self;

    /// The material where the path makes `hit` with an object of the material `phong`; `point` gets its normals.
    fn at<'a>(
        &self,
        scene: &PreparedScene,
        phong: &'a Phong,
        point: &mut SurfacePoint,
        hit: Option<&Hit>,
    ) -> Self::Phong<'a>;

    /// The path goes on from `point` in a direction that the surface decides: mirrored or refracted.
    fn deflect(&mut self, point: &SurfacePoint);

    /// The path goes on in a direction that is drawn.
    fn scatter(&mut self);
}

/// Knows nothing of textures.
#[derive(Clone, Copy, Debug)]
pub struct Untextured;

impl Texturing for Untextured {
    type Phong<'a> = &'a Phong;

    #[inline]
    fn from_eye(_: &PreparedScene, _: &CameraRay) -> Self {
        Self
    }

    #[inline]
    fn at<'a>(
        &self,
        _: &PreparedScene,
        phong: &'a Phong,
        _: &mut SurfacePoint,
        _: Option<&Hit>,
    ) -> &'a Phong {
        phong
    }

    #[inline]
    fn deflect(&mut self, _: &SurfacePoint) {}

    #[inline]
    fn scatter(&mut self) {}
}

/// Knows all of textures.
#[derive(Clone, Copy, Debug)]
pub struct Textured(Footprint);

impl Texturing for Textured {
    type Phong<'a> = Phong;

    fn from_eye(scene: &PreparedScene, ray: &CameraRay) -> Self {
        // Where samples lie all over the pixel, each stands for a part of it.
        let share = if scene.needs(Feature::PixelPoints) {
            Footprint::SHARE_OF_PIXEL
        } else {
            1.0
        };
        Self(Footprint::from_eye(scene.camera(), ray, share))
    }

    fn at(
        &self,
        scene: &PreparedScene,
        phong: &Phong,
        point: &mut SurfacePoint,
        hit: Option<&Hit>,
    ) -> Phong {
        let object = scene.textures().of_object(point.object);
        match object.zip(hit) {
            Some((object, hit)) => object.at(scene.geometry(), &self.0, phong, point, hit),
            None => *phong,
        }
    }

    fn deflect(&mut self, point: &SurfacePoint) {
        self.0.deflect(point.distance);
    }

    fn scatter(&mut self) {
        self.0.scatter();
    }
}

/// Says whether there is memory for all sizes of the image called `name`.
fn require_pyramid(name: &str, image: &TextureImage) -> Result<(), SceneError> {
    require(Pyramid::foreseen_bytes(image)).map_err(|short| SceneError::TextureMemory {
        image: name.to_owned(),
        needed: short.needed_in_words(),
        why: short.why(),
    })
}

/// The textures of a scene, prepared.
#[derive(Debug, Default)]
pub struct PreparedTextures {
    /// One per object, or none at all; `None` where nothing varies over it.
    objects: Vec<Option<TexturedObject>>,
    pyramids: Vec<Arc<Pyramid>>,
}

impl PreparedTextures {
    /// The textures of `scene`, with the pyramids of `previous` where images are the same; `None` when cancelled.
    ///
    /// # Errors
    /// A mesh or an image that is not loaded.
    pub fn prepare(
        scene: &Scene,
        previous: Option<&Self>,
        cancel: &CancelToken,
    ) -> Result<Option<Self>, SceneError> {
        let mut pyramids: Vec<Arc<Pyramid>> = Vec::new();
        let mut objects = Vec::with_capacity(scene.objects.len());
        for object in &scene.objects {
            let material = scene.material_of(object)?;
            let mesh = scene.shown_mesh_of(object)?;
            let textures = material
                .textures()
                .filter(|textures| textures.vary_over(&mesh));
            let Some(textures) = textures else {
                objects.push(None);
                continue;
            };
            let mut pyramid = |image: Option<&String>, meaning| {
                let Some(image) = image.filter(|_| mesh.texture_coordinates.is_some()) else {
                    return Ok(Some(None));
                };
                let (name, image) = (image, scene.texture(image)?);
                let known = previous.iter().flat_map(|previous| &previous.pyramids);
                let mut known = pyramids.iter().chain(known);
                let pyramid =
                    if let Some(known) = known.find(|pyramid| pyramid.is_of(image, meaning)) {
                        Arc::clone(known)
                    } else {
                        require_pyramid(name, image)?;
                        match Pyramid::new(image, meaning, cancel) {
                            Some(pyramid) => Arc::new(pyramid),
                            None => return Ok(None),
                        }
                    };
                if !pyramids.iter().any(|known| Arc::ptr_eq(known, &pyramid)) {
                    pyramids.push(Arc::clone(&pyramid));
                }
                Ok(Some(Some(pyramid)))
            };
            let (Some(diffuse), Some(normals)) = (
                pyramid(textures.diffuse_image.as_ref(), Meaning::Color)?,
                pyramid(textures.normal_image.as_ref(), Meaning::Normal)?,
            ) else {
                return Ok(None);
            };
            objects.push(Some(TexturedObject {
                is_mirrored: object.placement().linear.determinant() < 0.0,
                diffuse,
                normals,
                has_colors: textures.vertex_colors && mesh.colors.is_some(),
                mesh,
            }));
        }
        Ok(Some(Self { objects, pyramids }))
    }

    /// What varies over an object, if anything does.
    fn of_object(&self, object: usize) -> Option<&TexturedObject> {
        self.objects.get(object)?.as_ref()
    }

    /// Memory beside that of meshes and images, in bytes.
    pub fn bytes(&self) -> usize {
        let pyramids = self.pyramids.iter().map(|pyramid| pyramid.bytes());
        size_of_val(&*self.objects) + pyramids.sum::<usize>()
    }
}
