//! The description of a picture: plain data, in the units of the scene file, that files are read into, the window edits
//! and undo copies. It knows neither files nor how it is rendered.
//!
//! Right-handed world with no fixed up axis; lengths in scene units, angles in degrees, colour linear RGB.

mod absent;
mod background;
mod camera;
mod display;
mod joining;
mod light;
mod light_names;
mod material;
mod movement;
mod naming;
mod object;
pub mod presets;
mod radiance_map;
mod remeasuring;
mod repaired;
mod settings;
mod texture_image;
mod turning;
mod validate;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::geometry::TriangleMesh;
use crate::math::DBounds;

pub use absent::{Absent, is_absent};
pub use background::{Background, ImageAxes};
pub use camera::{Bookmark, Camera, CameraAxes};
pub use display::{Display, Output, PngBits, ToneCurve};
pub use light::{Facing, Light};
pub use light_names::NamedLight;
pub use material::{Material, Textures};
pub use movement::Move;
pub use naming::{UniqueNames, free_name};
pub use object::{Copies, Object, Placement, rotation_degrees};
pub use radiance_map::RadianceMap;
pub use remeasuring::Remeasure;
pub use settings::{
    AcceleratorBuild, AcceleratorChoice, AmbientOcclusion, Filter, LightSampling, Mode, PhongModel,
    RenderSettings, SamplerChoice, Shadows, Stop,
};
pub use texture_image::{Texels, TextureImage};

/// Scenes larger than this, or smaller than its reciprocal, are refused: beyond it, volumes soon leave the range of `f64`.
pub const LARGEST_EXTENT: f64 = 1e100;

/// Linear RGB: radiance, intensity or reflectance, as its field says.
pub type Rgb = crate::math::DVec3;

/// An enumeration whose values have names, in files and on screen.
pub trait Choice: Copy + PartialEq + 'static {
    /// Every value with its name in files, in the order in which to offer them.
    const ALL: &'static [(Self, &'static str)];

    /// The name of this value in files.
    ///
    /// # Panics
    /// When a value is missing in [`Choice::ALL`].
    fn name(self) -> &'static str {
        Self::ALL
            .iter()
            .find(|(value, _)| *value == self)
            .expect("ALL lists every value")
            .1
    }
}

/// Everything a picture depends on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Where the picture is taken from.
    pub camera: Camera,
    /// Cameras to come back to; no picture depends on them.
    pub bookmarks: Vec<Bookmark>,
    /// What rays see that hit nothing.
    pub background: Background,
    /// Materials by name.
    pub materials: BTreeMap<String, Material>,
    /// Placed meshes, in drawing order.
    pub objects: Vec<Object>,
    /// Light sources, in the order of the file.
    pub lights: Vec<Light>,
    /// Names of the lights, in their order; empty, or missing at the end, where a light goes by its number.
    pub light_names: Vec<String>,
    /// What to compute.
    pub render: RenderSettings,
    /// From radiance to what a screen shows.
    pub display: Display,
    /// How pictures are stored.
    pub output: Output,
    /// The geometry behind every [`Object::mesh`], shared with copies of the scene.
    pub meshes: BTreeMap<String, Arc<TriangleMesh>>,
    /// The pixels behind the image of a [`Background`], shared with copies of the scene.
    pub images: BTreeMap<String, Arc<RadianceMap>>,
    /// The texels behind every image of [`Textures`], shared with copies of the scene.
    pub textures: BTreeMap<String, Arc<TextureImage>>,
}

impl Scene {
    /// Whether `object` has a mesh with triangles, as far as it is loaded.
    #[must_use]
    pub fn has_triangles(&self, object: &Object) -> bool {
        let mesh = self.meshes.get(&object.mesh);
        mesh.is_some_and(|mesh| !mesh.triangles.is_empty())
    }

    /// The material of `object` as it looks: the default one where it names none, and without images whose files are not there.
    ///
    /// # Errors
    /// The name that no material has.
    pub fn material_of(&self, object: &Object) -> Result<Material, SceneError> {
        match &object.material {
            None => Ok(Material::default()),
            Some(name) => {
                let material = self.materials.get(name).cloned();
                material
                    .map(|material| self.without_absent_images(material))
                    .ok_or_else(|| SceneError::UnknownMaterial {
                        object: object.name.clone(),
                        material: name.clone(),
                        known: self.materials.keys().cloned().collect(),
                    })
            }
        }
    }

    /// The mesh of `object`.
    ///
    /// # Errors
    /// When it was not loaded.
    pub fn mesh_of(&self, object: &Object) -> Result<&Arc<TriangleMesh>, SceneError> {
        self.meshes
            .get(&object.mesh)
            .ok_or_else(|| SceneError::MeshNotLoaded {
                object: object.name.clone(),
                mesh: object.mesh.clone(),
            })
    }

    /// The mesh of `object` as it is shown: that of [`Scene::mesh_of`], its winding repaired where the object says so. A repaired mesh is
    /// the same one as long as anybody has it.
    ///
    /// # Errors
    /// When it was not loaded.
    pub fn shown_mesh_of(&self, object: &Object) -> Result<Arc<TriangleMesh>, SceneError> {
        let mesh = self.mesh_of(object)?;
        Ok(if object.repair_winding {
            repaired::repaired(mesh)
        } else {
            Arc::clone(mesh)
        })
    }

    /// The image of the background; `None` where that is none.
    ///
    /// # Errors
    /// When it was not loaded.
    pub fn background_image(&self) -> Result<Option<&Arc<RadianceMap>>, SceneError> {
        let Background::Image { image, .. } = &self.background else {
            return Ok(None);
        };
        let map = self.images.get(image);
        map.map(Some).ok_or_else(|| SceneError::ImageNotLoaded {
            image: image.clone(),
        })
    }

    /// The image that textures call `name`.
    ///
    /// # Errors
    /// When it was not loaded.
    pub fn texture(&self, name: &str) -> Result<&Arc<TextureImage>, SceneError> {
        let texture = self.textures.get(name);
        texture.ok_or_else(|| SceneError::TextureNotLoaded {
            image: name.to_owned(),
        })
    }

    /// The names of all images that materials are textured with, each once.
    #[must_use]
    pub fn texture_names(&self) -> BTreeSet<String> {
        let textures = self.materials.values().filter_map(Material::textures);
        let images = textures.flat_map(|textures| textures.images().map(str::to_owned));
        images.collect()
    }

    /// What varies over surfaces of each material, to be changed.
    pub fn material_textures_mut(&mut self) -> impl Iterator<Item = &mut Textures> {
        self.materials
            .values_mut()
            .filter_map(Material::textures_mut)
    }

    /// The world box of all objects with all their copies; lights do not count. Objects whose mesh is not loaded are
    /// left out.
    #[must_use]
    pub fn bounds(&self) -> DBounds {
        let object_bounds = |object: &Object| {
            let mesh = self.meshes.get(&object.mesh)?;
            Some(object.bounds_of(mesh))
        };
        self.objects
            .iter()
            .filter_map(object_bounds)
            .fold(DBounds::EMPTY, DBounds::union)
    }

    /// [`Scene::bounds`], if lengths, areas and volumes of that size stay within what `f64` can hold.
    ///
    /// # Errors
    /// [`SceneError::Extent`].
    pub fn measured_bounds(&self) -> Result<DBounds, SceneError> {
        let bounds = self.bounds();
        let extent = if bounds.is_empty() {
            0.0
        } else {
            bounds.size().max_element()
        };
        let farthest = if bounds.is_empty() {
            0.0
        } else {
            bounds.min.abs().max(bounds.max.abs()).max_element()
        };
        let measurable = extent == 0.0 || extent > 1.0 / LARGEST_EXTENT;
        if measurable && farthest < LARGEST_EXTENT {
            Ok(bounds)
        } else {
            Err(SceneError::Extent { extent, farthest })
        }
    }

    /// Triangles of all objects with all their copies.
    #[must_use]
    pub fn triangle_count(&self) -> u64 {
        let counts = self.objects.iter().map(|object| self.triangles_of(object));
        counts.fold(0, u64::saturating_add)
    }

    /// Triangles of `object`, copies counted; 0 where its mesh is not loaded.
    #[must_use]
    pub fn triangles_of(&self, object: &Object) -> u64 {
        let mesh = self.meshes.get(&object.mesh);
        let triangles = mesh.map_or(0, |mesh| mesh.triangles.len() as u64);
        triangles.saturating_mul(object.copies.total())
    }
}

/// Why a description cannot be rendered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// An object names a material that is not there.
    #[error("object \"{object}\" uses material \"{material}\", which is not defined; defined: {}", list(.known))]
    UnknownMaterial {
        /// The object's name.
        object: String,
        /// The name it asks for.
        material: String,
        /// The names there are.
        known: Vec<String>,
    },
    /// An object's mesh has not been loaded.
    #[error("the mesh \"{mesh}\" of object \"{object}\" is not loaded")]
    MeshNotLoaded {
        /// The object's name.
        object: String,
        /// The mesh it asks for.
        mesh: String,
    },
    /// The background's image has not been loaded.
    #[error("the image \"{image}\" of the background is not loaded")]
    ImageNotLoaded {
        /// The image it asks for.
        image: String,
    },
    /// The image of a texture has not been loaded.
    #[error("the image \"{image}\" of a material is not loaded")]
    TextureNotLoaded {
        /// The image it asks for.
        image: String,
    },
    /// Less memory than the sizes of a texture's image take.
    #[error(
        "the image \"{image}\" takes about {needed} of memory at all its sizes, {why}; make it smaller"
    )]
    TextureMemory {
        /// The image.
        image: String,
        /// How much it takes.
        needed: String,
        /// What is in the way.
        why: String,
    },
    /// More triangles than can be numbered.
    #[error("the scene has {count} triangles with all copies; at most {} can be rendered", u32::MAX / 2)]
    TooManyTriangles {
        /// Triangles of all objects with all their copies.
        count: u64,
    },
    /// Less memory than the triangles' structure takes while it is built.
    #[error(
        "the structure over {triangles} triangles takes about {needed} of memory while it is built, {why}; give simpler \
         meshes, or the same mesh to several objects, which share it"
    )]
    TooLittleMemory {
        /// Triangles that are stored.
        triangles: u64,
        /// How much it takes.
        needed: String,
        /// What is in the way.
        why: String,
    },
    /// Objects so large, so small or so far out that their volumes leave the range of `f64`.
    #[error(
        "the objects are {extent:e} across and reach {farthest:e} from the origin; \
         expected between {:e} and {LARGEST_EXTENT:e}",
        1.0 / LARGEST_EXTENT
    )]
    Extent {
        /// Largest edge of the scene's box.
        extent: f64,
        /// Largest coordinate.
        farthest: f64,
    },
    /// A value that its key may not have.
    #[error("{key} is {value}; expected {expected}")]
    BadValue {
        /// The key as in the scene file.
        key: String,
        /// What it holds.
        value: String,
        /// What it may hold.
        expected: String,
    },
}

impl SceneError {
    /// The key of the scene file that is wrong, where it is one key.
    #[must_use]
    pub fn key(&self) -> Option<&str> {
        match self {
            Self::BadValue { key, .. } => Some(key),
            _ => None,
        }
    }
}

/// Names for a message: "a, b, c", or "none".
fn list(names: &[String]) -> String {
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    }
}
