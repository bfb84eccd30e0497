//! Colours that vary over objects: those of vertices, and images.
//!
//! A worker uploads them beside the triangles: where corners lie on images and which colours they have, as far as something of it shows
//! on an object; and every image once (`image`). A scene without has none of it. The layouts mirror `shader.wgsl`.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use eframe::wgpu;
use half::f16;
use rayon::prelude::*;

use super::geometry::{GpuLevel, GpuPart, Piece, vertex_buffer};
use super::image::{self, GpuImage};
use crate::control::CancelToken;
use crate::geometry::TriangleMesh;
use crate::gui::worker::Gpu;
use crate::math::{DVec2, Vec3};
use crate::render::Meaning;
use crate::scene::{Object, Scene, TextureImage, is_absent};

/// A corner's place on the image, and its colour, linear in 16 bits per channel.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct PaintVertex {
    on_image: [f32; 2],
    color: [u16; 4],
}

/// What varies over the objects of a scene, on the GPU.
#[derive(Debug, Default)]
pub(super) struct GpuPaint {
    /// One per object, or none at all; `None` where nothing varies over it.
    objects: Vec<Option<ObjectPaint>>,
    corners: HashMap<CornersKey, Corners>,
}

/// What varies over an object.
#[derive(Debug)]
struct ObjectPaint {
    /// As it was loaded.
    source: Arc<TriangleMesh>,
    /// As it is shown.
    mesh: Arc<TriangleMesh>,
    /// Whether two corners of each triangle are swapped.
    is_swapped: bool,
    coat: Coat,
}

/// What tells corners from others: the addresses of their mesh and of the numbers of their triangles, where they are not all in their order;
/// whether two of each three are swapped; which triangles they are.
type CornersKey = (usize, usize, bool, Range<usize>);

/// What varies over corners.
#[derive(Clone, Debug)]
struct Corners {
    buffer: wgpu::Buffer,
    /// Kept, for no others to come to its address.
    _sources: Option<Arc<[u32]>>,
}

/// What a shader finds of the images that lie on an object.
#[derive(Debug)]
pub(super) struct Coat {
    color: Arc<GpuImage>,
    normals: Arc<GpuImage>,
    pub(super) bind_group: wgpu::BindGroup,
}

impl Coat {
    fn new(device: &wgpu::Device, color: Arc<GpuImage>, normals: Arc<GpuImage>) -> Self {
        Self {
            bind_group: image::bind_group(device, &color, &normals),
            color,
            normals,
        }
    }

    /// Whether an image of normals is among them.
    pub(super) fn has_normals(&self) -> bool {
        self.normals.is_some()
    }
}

/// What varies over an object of a scene.
struct Wanted<'a> {
    /// As it was loaded.
    mesh: &'a Arc<TriangleMesh>,
    image: Option<&'a Arc<TextureImage>>,
    normals: Option<&'a Arc<TextureImage>>,
    has_colors: bool,
}

impl<'a> Wanted<'a> {
    /// `None` where nothing varies.
    fn of(scene: &'a Scene, object: &Object) -> Option<Self> {
        let textures = scene.materials.get(object.material.as_ref()?)?.textures()?;
        let mesh = scene.meshes.get(&object.mesh)?;
        let is_mapped = mesh.texture_coordinates.is_some();
        let image = |name: &Option<String>| scene.textures.get(name.as_ref()?);
        let of = |name| image(name).filter(|image| is_mapped && !is_absent(image));
        let (image, normals) = (of(&textures.diffuse_image), of(&textures.normal_image));
        let has_colors = textures.vertex_colors && mesh.colors.is_some();
        let varies = image.is_some() || normals.is_some() || has_colors;
        varies.then_some(Self {
            mesh,
            image,
            normals,
            has_colors,
        })
    }
}

/// Whether the same images and colours vary over the objects of two scenes, which have the same meshes. Images are compared by identity.
#[must_use]
pub fn same_paint(a: &Scene, b: &Scene) -> bool {
    let paint = |scene: &Scene, index: usize| {
        let wanted = Wanted::of(scene, &scene.objects[index]);
        let images =
            |wanted: &Wanted<'_>| [wanted.image, wanted.normals].map(|i| i.map(Arc::as_ptr));
        wanted.map(|wanted| (images(&wanted), wanted.has_colors))
    };
    a.objects.len() == b.objects.len()
        && (0..a.objects.len()).all(|index| paint(a, index) == paint(b, index))
}

impl GpuPaint {
    /// What varies over the objects of `scene`, whose triangles are in `parts`, one per object. What is the same as in `previous` is kept.
    /// `None` when cancelled.
    pub(super) fn upload<'a>(
        gpu: &Gpu,
        scene: &Scene,
        parts: impl Iterator<Item = &'a GpuPart>,
        previous: &Self,
        cancel: &CancelToken,
    ) -> Option<Self> {
        let mut images: Vec<Arc<GpuImage>> = Vec::new();
        let mut objects = Vec::with_capacity(scene.objects.len());
        let parts: Vec<&GpuPart> = parts.collect();
        for (object, part) in scene.objects.iter().zip(&parts) {
            let Some(wanted) = Wanted::of(scene, object) else {
                objects.push(None);
                continue;
            };
            let mut image_of = |source, meaning| {
                let is_it = |image: &&Arc<GpuImage>| image.is_of(source, meaning);
                let known = images.iter().find(is_it);
                let known = known.or_else(|| previous.images().find(is_it)).cloned();
                let image = match known {
                    Some(known) => known,
                    None => Arc::new(GpuImage::upload(gpu, source, meaning, cancel)?),
                };
                images.push(Arc::clone(&image));
                Some(image)
            };
            let color = image_of(wanted.image, Meaning::Color)?;
            let normals = image_of(wanted.normals, Meaning::Normal)?;
            let shown = scene.shown_mesh_of(object);
            objects.push(Some(ObjectPaint {
                source: Arc::clone(wanted.mesh),
                mesh: shown.unwrap_or_else(|_| Arc::clone(wanted.mesh)),
                is_swapped: !part.is_shared && object.placement().linear.determinant() < 0.0,
                coat: Coat::new(&gpu.device, color, normals),
            }));
        }
        if images.is_empty() {
            return Some(Self::default());
        }
        let mut corners = HashMap::new();
        let painted = objects.iter().zip(&parts);
        let painted = painted.filter_map(|(paint, part)| Some((paint.as_ref()?, part)));
        for (paint, part) in painted {
            for level in &part.levels {
                for piece in &level.pieces {
                    if cancel.is_cancelled() {
                        return None;
                    }
                    let key = paint.key_of(level, piece);
                    corners.entry(key.clone()).or_insert_with(|| {
                        let known = previous.corners.get(&key).cloned();
                        known.unwrap_or_else(|| paint.corners(gpu, level, piece))
                    });
                }
            }
        }
        Some(Self { objects, corners })
    }

    /// Whether nothing varies over any object.
    pub(super) fn is_empty(&self) -> bool {
        self.objects.is_empty()
    }

    fn images(&self) -> impl Iterator<Item = &Arc<GpuImage>> {
        let coats = self.objects.iter().flatten().map(|paint| &paint.coat);
        coats.flat_map(|coat| [&coat.color, &coat.normals])
    }

    /// Whether anything varies over object `index`.
    pub(super) fn varies_over(&self, index: usize) -> bool {
        self.objects.get(index).is_some_and(Option::is_some)
    }

    /// What drawing a piece of object `index` needs beside its triangles; `None` where nothing varies.
    pub(super) fn of(
        &self,
        index: usize,
        level: &GpuLevel,
        piece: &Piece,
    ) -> Option<(&wgpu::Buffer, &Coat)> {
        let paint = self.objects.get(index)?.as_ref()?;
        let corners = self.corners.get(&paint.key_of(level, piece))?;
        Some((&corners.buffer, &paint.coat))
    }

    /// Whether an image of normals lies on an object.
    pub(super) fn has_normals(&self) -> bool {
        let mut paints = self.objects.iter().flatten();
        paints.any(|paint| paint.coat.has_normals())
    }

    /// Whether the image that lies on object `index` of `scene` now is here, whether its vertices' colours are and count, and whether its
    /// image of normals is here.
    pub(super) fn shows(&self, scene: &Scene, index: usize) -> [bool; 3] {
        let paint = self.objects.get(index).and_then(Option::as_ref);
        let wanted = scene.objects.get(index);
        let wanted = wanted.and_then(|object| Wanted::of(scene, object));
        paint.zip(wanted).map_or([false; 3], |(paint, wanted)| {
            let is_same = Arc::ptr_eq(&paint.source, wanted.mesh);
            let Coat { color, normals, .. } = &paint.coat;
            let has_image = wanted.image.is_some() && color.is_of(wanted.image, Meaning::Color);
            let has_normals =
                wanted.normals.is_some() && normals.is_of(wanted.normals, Meaning::Normal);
            [has_image, wanted.has_colors, has_normals].map(|has| is_same && has)
        })
    }
}

impl ObjectPaint {
    fn key_of(&self, level: &GpuLevel, piece: &Piece) -> CornersKey {
        let sources = level.sources.as_ref();
        let order = sources.map_or(0, |sources| sources.as_ptr().addr());
        let mesh = Arc::as_ptr(&self.mesh).addr();
        (mesh, order, self.is_swapped, piece.triangles.clone())
    }

    fn corners(&self, gpu: &Gpu, level: &GpuLevel, piece: &Piece) -> Corners {
        let sources = level.sources.clone();
        let number = |triangle: usize| match &sources {
            Some(sources) => sources[triangle] as usize,
            None => triangle,
        };
        let triangles = &self.mesh.triangles;
        // Copies follow each other.
        let corners = |triangle: usize| {
            let [a, b, c] = triangles[triangle % triangles.len()];
            if self.is_swapped {
                [a, c, b]
            } else {
                [a, b, c]
            }
        };
        let numbers = piece.triangles.clone().into_par_iter();
        let vertices: Vec<PaintVertex> = numbers
            .flat_map_iter(|triangle| triangle_of(&self.mesh, corners(number(triangle))))
            .collect();
        Corners {
            buffer: vertex_buffer(&gpu.device, "preview paint", &vertices),
            _sources: sources,
        }
    }
}

/// The corners of a triangle of `mesh`.
fn triangle_of(mesh: &TriangleMesh, corners: [u32; 3]) -> [PaintVertex; 3] {
    let (colors, coordinates) = (mesh.colors.as_ref(), mesh.texture_coordinates.as_ref());
    let colors = corners.map(|i| colors.map_or(Vec3::ONE, |colors| colors[i as usize]));
    let places = corners.map(|i| coordinates.map_or(DVec2::ZERO, |all| all[i as usize]));
    // Images repeat, and near 0 numbers have the most digits.
    let base = places[0].min(places[1]).min(places[2]).floor();
    let half = |value: f32| f16::from_f32(value.min(f16::MAX.to_f32())).to_bits();
    std::array::from_fn(|i| {
        let [r, g, b] = colors[i].to_array().map(half);
        let place = (places[i] - base).as_vec2();
        PaintVertex {
            // Rows of an image begin at its top.
            on_image: [place.x, -place.y],
            color: [r, g, b, 0],
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_keep_their_digits_far_from_the_image() {
        let far = 1e7;
        let mesh = TriangleMesh {
            triangles: vec![[0, 1, 2]],
            texture_coordinates: Some(vec![
                DVec2::new(far + 0.125, far + 0.5),
                DVec2::new(far + 1.25, far + 0.25),
                DVec2::new(far, far),
            ]),
            ..TriangleMesh::default()
        };
        let textures = [[0.125, -0.5], [1.25, -0.25], [0.0, 0.0]];
        let found = triangle_of(&mesh, [0, 1, 2]);
        assert_eq!(found.map(|vertex| vertex.on_image), textures);
        let white = [
            f16::ONE.to_bits(),
            f16::ONE.to_bits(),
            f16::ONE.to_bits(),
            0,
        ];
        assert!(found.iter().all(|vertex| vertex.color == white));
    }
}
