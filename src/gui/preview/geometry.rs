//! The triangles of the preview: packed on a worker thread, uploaded once, drawn until the geometry changes.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use eframe::wgpu;

use crate::math::{Bounds, SceneFrame, Vec3};

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

/// Triangles of all objects in the prepared scene, ready to upload.
#[derive(Clone, Debug)]
pub struct PreviewMesh {
    /// How the world became the prepared scene.
    pub frame: SceneFrame,
    /// Three corners per triangle.
    pub vertices: Vec<Vertex>,
    /// The corners of each object, by the object's place in the scene.
    pub objects: Vec<Range<usize>>,
}

impl PreviewMesh {
    /// The box around all corners.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        Bounds::of_points(self.vertices.iter().map(|v| Vec3::from_array(v.position)))
    }
}

/// The triangles of one scene on the GPU.
#[derive(Debug)]
pub struct GpuGeometry {
    /// How the world became the prepared scene.
    pub(super) frame: SceneFrame,
    /// The box around all triangles, in the prepared scene.
    pub(super) bounds: Bounds,
    /// Number of objects.
    pub(super) object_count: usize,
    chunks: Vec<Chunk>,
}

/// Part of the triangles: a GPU limits the size of one buffer.
#[derive(Debug)]
struct Chunk {
    buffer: wgpu::Buffer,
    /// Corners within the buffer, and whose they are.
    draws: Vec<(Range<u32>, u32)>,
}

impl GpuGeometry {
    /// Uploads `mesh`. May be called from any thread.
    #[must_use]
    pub fn upload(device: &wgpu::Device, mesh: &PreviewMesh) -> Self {
        let largest = device.limits().max_buffer_size / size_of::<Vertex>() as u64;
        let per_chunk = usize::try_from(largest).unwrap_or(usize::MAX) / 3 * 3;
        let chunks = (0..mesh.vertices.len())
            .step_by(per_chunk)
            .map(|start| {
                let range = start..(start + per_chunk).min(mesh.vertices.len());
                Chunk::upload(device, mesh, &range)
            })
            .collect();
        Self {
            frame: mesh.frame,
            bounds: mesh.bounds(),
            object_count: mesh.objects.len(),
            chunks,
        }
    }

    /// Draws every object; its material is the instance with the object's number.
    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        for chunk in &self.chunks {
            pass.set_vertex_buffer(0, chunk.buffer.slice(..));
            for (corners, object) in &chunk.draws {
                pass.draw(corners.clone(), *object..*object + 1);
            }
        }
    }
}

impl Chunk {
    fn upload(device: &wgpu::Device, mesh: &PreviewMesh, range: &Range<usize>) -> Self {
        let vertices = &mesh.vertices[range.clone()];
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("preview triangles"),
            size: size_of_val(vertices) as u64,
            usage: wgpu::BufferUsages::VERTEX,
            mapped_at_creation: true,
        });
        if let Ok(mut mapped) = buffer.get_mapped_range_mut(..) {
            mapped.copy_from_slice(bytemuck::cast_slice(vertices));
        }
        buffer.unmap();
        let draws = mesh
            .objects
            .iter()
            .enumerate()
            .filter_map(|(object, corners)| {
                let start = corners.start.max(range.start);
                let end = corners.end.min(range.end);
                let within = |corner: usize| u32::try_from(corner - range.start).ok();
                (start < end).then_some(())?;
                Some((within(start)?..within(end)?, u32::try_from(object).ok()?))
            })
            .collect();
        Self { buffer, draws }
    }
}
