//! The triangles of the preview: packed on a worker thread, uploaded once, drawn until the geometry changes. A mesh that
//! objects share is there once, with a place for every copy.

use std::ops::Range;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use eframe::wgpu;

use super::paint::{GpuImage, GpuPaint};
use crate::control::CancelToken;
use crate::gui::worker::Gpu;
use crate::math::{Bounds, DVec3, ScaledRotation, SceneFrame, Vec3};
use crate::scene::Scene;

/// A triangle's corner as the GPU reads it: position in the prepared scene, and a unit normal in 16 bits per axis.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Vertex {
    position: [f32; 3],
    normal: [i16; 4],
}

impl Vertex {
    /// A corner at `position` whose shading normal points along `normal` (any length but 0).
    #[must_use]
    pub fn new(position: Vec3, normal: Vec3) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "a unit vector's coordinates fit"
        )]
        let snorm = |x: f32| (x * f32::from(i16::MAX)).round() as i16;
        let n = normal.normalize_or_zero();
        Self {
            position: position.to_array(),
            normal: [snorm(n.x), snorm(n.y), snorm(n.z), 0],
        }
    }
}

/// Where a copy's local origin is in the prepared scene, as two numbers per axis so that a near eye loses no digit.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Place {
    high: [f32; 3],
    low: [f32; 3],
}

impl Place {
    /// The place `translation`.
    #[must_use]
    pub fn new(translation: DVec3) -> Self {
        let high = translation.as_vec3();
        Self {
            high: high.to_array(),
            low: (translation - high.as_dvec3()).as_vec3().to_array(),
        }
    }
}

/// Triangles of all objects, ready to upload.
#[derive(Clone, Debug)]
pub struct PreviewMesh {
    /// How the world became the prepared scene.
    pub frame: SceneFrame,
    /// The box around all triangles with all copies, in the prepared scene.
    pub bounds: Bounds,
    /// Three corners per triangle.
    pub vertices: Vec<Vertex>,
    /// Where copies are.
    pub places: Vec<Place>,
    /// The objects in the order of the scene.
    pub objects: Vec<PreviewObject>,
}

/// What is drawn of an object.
#[derive(Clone, Debug)]
pub struct PreviewObject {
    /// Its corners among all, which other objects may share.
    pub corners: Range<usize>,
    /// Its copies among all places.
    pub places: Range<u32>,
    /// From the corners' directions to those of the prepared scene.
    pub turn: ScaledRotation,
    /// Whether its corners are those of the mesh, rather than placed in the scene.
    pub is_shared: bool,
}

/// The triangles of one scene on the GPU.
#[derive(Debug)]
pub struct GpuGeometry {
    /// How the world became the prepared scene.
    pub(super) frame: SceneFrame,
    /// The box around all triangles, in the prepared scene.
    pub(super) bounds: Bounds,
    /// For each object, how its copies are turned.
    pub(super) turns: Vec<ScaledRotation>,
    places: wgpu::Buffer,
    chunks: Arc<[Chunk]>,
    paint: GpuPaint,
}

/// Part of the triangles: a GPU limits the size of one buffer.
#[derive(Debug)]
struct Chunk {
    buffer: wgpu::Buffer,
    draws: Vec<Draw>,
}

/// All copies of the part of one object that is in a chunk.
#[derive(Clone, Debug)]
pub(super) struct Draw {
    pub(super) object: u32,
    /// Corners within the chunk.
    pub(super) corners: Range<u32>,
    /// Number of the first among the corners of the object.
    pub(super) first: usize,
    /// Whether corners are those of the mesh, rather than placed in the scene.
    pub(super) is_shared: bool,
    places: Range<u32>,
}

impl GpuGeometry {
    /// Uploads `mesh`. May be called from any thread. Copies beyond what one buffer holds, some ten million, are left out.
    #[must_use]
    pub fn upload(device: &wgpu::Device, mesh: &PreviewMesh) -> Self {
        let largest = device.limits().max_buffer_size / size_of::<Vertex>() as u64;
        let per_chunk = usize::try_from(largest).unwrap_or(usize::MAX) / 3 * 3;
        let most_places = device.limits().max_buffer_size / size_of::<Place>() as u64;
        let most_places = u32::try_from(most_places).unwrap_or(u32::MAX);
        let places = mesh.places.len().min(most_places as usize);
        let chunks = (0..mesh.vertices.len())
            .step_by(per_chunk)
            .map(|start| {
                let range = start..(start + per_chunk).min(mesh.vertices.len());
                Chunk::upload(device, mesh, &range, most_places)
            })
            .collect();
        Self {
            frame: mesh.frame,
            bounds: mesh.bounds,
            turns: mesh.objects.iter().map(|object| object.turn).collect(),
            places: vertex_buffer(device, "preview places", &mesh.places[..places]),
            chunks,
            paint: GpuPaint::default(),
        }
    }

    /// The same triangles with the images and colours that vary over the objects of `scene`; what is the same as in `previous` is kept.
    /// `None` when cancelled.
    #[must_use]
    pub fn painted(
        self: &Arc<Self>,
        gpu: &Gpu,
        scene: &Scene,
        previous: Option<&Self>,
        cancel: &CancelToken,
    ) -> Option<Arc<Self>> {
        let draws = self.chunks.iter().flat_map(|chunk| &chunk.draws);
        let none = GpuPaint::default();
        let known = previous.map_or(&none, |previous| &previous.paint);
        let paint = GpuPaint::upload(gpu, scene, draws, known, cancel)?;
        if paint.is_empty() && self.paint.is_empty() {
            return Some(Arc::clone(self));
        }
        Some(Arc::new(Self {
            frame: self.frame,
            bounds: self.bounds,
            turns: self.turns.clone(),
            places: self.places.clone(),
            chunks: Arc::clone(&self.chunks),
            paint,
        }))
    }

    /// Whether the image that lies on object `index` of `scene` now is here, and whether its vertices' colours are and count.
    pub(super) fn shows(&self, scene: &Scene, index: usize) -> [bool; 2] {
        self.paint.shows(scene, index)
    }

    /// Draws every object with all copies, or only those over which nothing varies; `choose` makes an object's number its uniform.
    pub(super) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        only_plain: bool,
        choose: impl Fn(&mut wgpu::RenderPass<'_>, u32),
    ) {
        pass.set_vertex_buffer(1, self.places.slice(..));
        for chunk in &*self.chunks {
            pass.set_vertex_buffer(0, chunk.buffer.slice(..));
            for draw in &chunk.draws {
                if !only_plain || self.paint.of_draw(draw).is_none() {
                    choose(pass, draw.object);
                    pass.draw(draw.corners.clone(), draw.places.clone());
                }
            }
        }
    }

    /// Whether anything varies over an object.
    pub(super) fn is_painted(&self) -> bool {
        !self.paint.is_empty()
    }

    /// Draws all copies of the objects over which something varies; `choose` makes an object's number its uniform, and its image the
    /// texture.
    pub(super) fn draw_painted(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        choose: impl Fn(&mut wgpu::RenderPass<'_>, u32, &GpuImage),
    ) {
        pass.set_vertex_buffer(1, self.places.slice(..));
        for chunk in &*self.chunks {
            for draw in &chunk.draws {
                let Some((corners, image)) = self.paint.of_draw(draw) else {
                    continue;
                };
                choose(pass, draw.object, image);
                // Their corners are numbered from 0 in both buffers.
                let start = u64::from(draw.corners.start) * size_of::<Vertex>() as u64;
                pass.set_vertex_buffer(0, chunk.buffer.slice(start..));
                pass.set_vertex_buffer(2, corners.slice(..));
                let count = draw.corners.end - draw.corners.start;
                pass.draw(0..count, draw.places.clone());
            }
        }
    }
}

impl Chunk {
    fn upload(
        device: &wgpu::Device,
        mesh: &PreviewMesh,
        range: &Range<usize>,
        most_places: u32,
    ) -> Self {
        let draw_of = |(index, object): (usize, &PreviewObject)| {
            let start = object.corners.start.max(range.start);
            let end = object.corners.end.min(range.end);
            let places = object.places.start..object.places.end.min(most_places);
            let first = start - object.corners.start;
            let within = |corner: usize| u32::try_from(corner - range.start).ok();
            (start < end && !places.is_empty()).then_some(())?;
            Some(Draw {
                object: u32::try_from(index).ok()?,
                corners: within(start)?..within(end)?,
                first,
                is_shared: object.is_shared,
                places,
            })
        };
        Self {
            buffer: vertex_buffer(device, "preview triangles", &mesh.vertices[range.clone()]),
            draws: mesh
                .objects
                .iter()
                .enumerate()
                .filter_map(draw_of)
                .collect(),
        }
    }
}

/// A buffer of vertices.
pub(super) fn vertex_buffer<T: Pod>(
    device: &wgpu::Device,
    label: &str,
    content: &[T],
) -> wgpu::Buffer {
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: size_of_val(content) as u64,
        usage: wgpu::BufferUsages::VERTEX,
        mapped_at_creation: true,
    });
    if let Ok(mut mapped) = buffer.get_mapped_range_mut(..) {
        mapped.copy_from_slice(bytemuck::cast_slice(content));
    }
    buffer.unmap();
    buffer
}
