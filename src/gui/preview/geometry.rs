//! The triangles of the preview: packed on a worker thread, uploaded once, drawn until the geometry changes. A mesh that
//! objects share is there once, with a place for every copy; where all triangles are many, at several levels of detail.

use std::ops::Range;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use eframe::wgpu;

use super::ball::Ball;
use super::choice::{Grain, Group, Part, Pick, Placed, Stock};
use super::detail::Level;
use super::paint::{Coat, GpuPaint};
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

    /// Where it is.
    #[must_use]
    pub fn position(&self) -> Vec3 {
        Vec3::from_array(self.position)
    }

    /// Its shading normal, about a unit long.
    #[must_use]
    pub fn normal(&self) -> Vec3 {
        let [x, y, z, _] = self.normal.map(f32::from);
        Vec3::new(x, y, z) / f32::from(i16::MAX)
    }

    /// The same at another position.
    #[must_use]
    pub fn at(&self, position: Vec3) -> Self {
        Self {
            position: position.to_array(),
            ..*self
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
    /// What objects are made of.
    pub parts: Vec<PreviewPart>,
    /// Where copies are.
    pub places: Vec<Place>,
    /// The objects in the order of the scene.
    pub objects: Vec<PreviewObject>,
}

/// Triangles that objects may share.
#[derive(Clone, Debug)]
pub struct PreviewPart {
    /// All of them first, and then fewer and fewer.
    pub levels: Vec<Level>,
    /// Whether their corners are those of the mesh, rather than placed in the scene.
    pub is_shared: bool,
}

/// What is drawn of an object.
#[derive(Clone, Debug)]
pub struct PreviewObject {
    /// Number of its part.
    pub part: usize,
    /// Its copies, those together that are near each other.
    pub groups: Vec<Group>,
    /// From the corners' directions to those of the prepared scene.
    pub turn: ScaledRotation,
}

/// The triangles of one scene on the GPU.
#[derive(Debug)]
pub struct GpuGeometry {
    /// How the world became the prepared scene.
    pub(super) frame: SceneFrame,
    /// The box around all triangles, in the prepared scene.
    pub(super) bounds: Bounds,
    /// What may be drawn of it.
    pub(super) stock: Arc<Stock>,
    places: wgpu::Buffer,
    parts: Arc<[GpuPart]>,
    paint: GpuPaint,
}

/// A part on the GPU.
#[derive(Debug)]
pub(super) struct GpuPart {
    pub(super) levels: Vec<GpuLevel>,
    pub(super) is_shared: bool,
}

/// A level of detail on the GPU.
#[derive(Debug)]
pub(super) struct GpuLevel {
    pub(super) pieces: Vec<Piece>,
    /// For each triangle, which one of the mesh it was made of; `None` where they are those of the mesh, in their order.
    pub(super) sources: Option<Arc<[u32]>>,
}

/// Part of the triangles of a level: a GPU limits the size of one buffer.
#[derive(Debug)]
pub(super) struct Piece {
    buffer: wgpu::Buffer,
    pub(super) triangles: Range<usize>,
}

impl GpuGeometry {
    /// Uploads `mesh`. May be called from any thread. Copies beyond what one buffer holds, some ten million, are left out.
    #[must_use]
    pub fn upload(device: &wgpu::Device, mesh: PreviewMesh) -> Self {
        let most_places = device.limits().max_buffer_size / size_of::<Place>() as u64;
        let most_places = u32::try_from(most_places).unwrap_or(u32::MAX);
        let places = mesh.places.len().min(most_places as usize);
        let places = vertex_buffer(device, "preview places", &mesh.places[..places]);
        let placed = |object: PreviewObject| Placed {
            part: object.part,
            turn: object.turn,
            groups: within(object.groups, most_places),
        };
        let objects = mesh.objects.into_iter().map(placed).collect();
        let stock = Stock {
            parts: mesh.parts.iter().map(stock_of).collect(),
            objects,
        };
        let parts = mesh.parts.into_iter();
        Self {
            frame: mesh.frame,
            bounds: mesh.bounds,
            stock: Arc::new(stock),
            places,
            parts: parts.map(|part| GpuPart::upload(device, part)).collect(),
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
        let objects = self.stock.objects.iter();
        let parts = objects.map(|placed| &self.parts[placed.part]);
        let none = GpuPaint::default();
        let known = previous.map_or(&none, |previous| &previous.paint);
        let paint = GpuPaint::upload(gpu, scene, parts, known, cancel)?;
        if paint.is_empty() && self.paint.is_empty() {
            return Some(Arc::clone(self));
        }
        Some(Arc::new(Self {
            frame: self.frame,
            bounds: self.bounds,
            stock: Arc::clone(&self.stock),
            places: self.places.clone(),
            parts: Arc::clone(&self.parts),
            paint,
        }))
    }

    /// For each object, how its copies are turned.
    pub(super) fn turns(&self) -> impl Iterator<Item = &ScaledRotation> {
        self.stock.objects.iter().map(|placed| &placed.turn)
    }

    /// Whether the image that lies on object `index` of `scene` now is here, whether its vertices' colours are and count, and whether its
    /// image of normals is here.
    pub(super) fn shows(&self, scene: &Scene, index: usize) -> [bool; 3] {
        self.paint.shows(scene, index)
    }

    /// Draws `picks`, or only those of objects over which nothing varies; `choose` makes an object's number its uniform.
    pub(super) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        picks: &[Pick],
        only_plain: bool,
        choose: impl Fn(&mut wgpu::RenderPass<'_>, u32),
    ) {
        pass.set_vertex_buffer(1, self.places.slice(..));
        for pick in picks {
            if only_plain && self.paint.varies_over(pick.object) {
                continue;
            }
            choose(pass, number(pick.object));
            for (piece, corners) in self.pieces(pick) {
                pass.set_vertex_buffer(0, piece.buffer.slice(..));
                pass.draw(corners, pick.places.clone());
            }
        }
    }

    /// Whether anything varies over an object.
    pub(super) fn is_painted(&self) -> bool {
        !self.paint.is_empty()
    }

    /// Whether an image of normals lies on an object.
    pub(super) fn has_normals(&self) -> bool {
        self.paint.has_normals()
    }

    /// Draws those of `picks` that are of objects over which something varies, with an image of normals or without; `choose` makes an
    /// object's number its uniform, and its images the textures.
    pub(super) fn draw_painted(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        picks: &[Pick],
        with_normals: bool,
        choose: impl Fn(&mut wgpu::RenderPass<'_>, u32, &Coat),
    ) {
        pass.set_vertex_buffer(1, self.places.slice(..));
        for pick in picks {
            let level = &self.parts[self.stock.objects[pick.object].part].levels[pick.level];
            for (piece, corners) in self.pieces(pick) {
                let painted = self.paint.of(pick.object, level, piece);
                let Some((paint, coat)) =
                    painted.filter(|(_, coat)| coat.has_normals() == with_normals)
                else {
                    continue;
                };
                choose(pass, number(pick.object), coat);
                pass.set_vertex_buffer(0, piece.buffer.slice(..));
                pass.set_vertex_buffer(2, paint.slice(..));
                pass.draw(corners, pick.places.clone());
            }
        }
    }

    /// Where the triangles of `pick` are, and which corners there.
    fn pieces(&self, pick: &Pick) -> impl Iterator<Item = (&Piece, Range<u32>)> {
        let part = self.stock.objects[pick.object].part;
        let starts = &self.stock.parts[part].levels[pick.level].starts;
        let wanted = starts[pick.blocks.start]..starts[pick.blocks.end];
        let pieces = self.parts[part].levels[pick.level].pieces.iter();
        pieces.filter_map(move |piece| {
            let start = wanted.start.max(piece.triangles.start);
            let end = wanted.end.min(piece.triangles.end);
            let corner = |triangle: usize| number((triangle - piece.triangles.start) * 3);
            (start < end).then(|| (piece, corner(start)..corner(end)))
        })
    }
}

/// Numbers of objects, and of the corners in a buffer, have 32 bits.
fn number(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}

/// `groups` without the places from number `most` on.
fn within(groups: Vec<Group>, most: u32) -> Vec<Group> {
    let groups = groups.into_iter().map(|group| Group {
        places: group.places.start.min(most)..group.places.end.min(most),
        ..group
    });
    groups.filter(|group| !group.places.is_empty()).collect()
}

fn stock_of(part: &PreviewPart) -> Part {
    let blocks = part.levels[0].balls();
    let grain = |level: &Level| Grain {
        cell: level.cell,
        starts: level.starts.clone(),
    };
    let middle = blocks.iter().map(|ball| ball.center).sum::<DVec3>() / blocks.len() as f64;
    let reach = |ball: &Ball| ball.center.distance(middle) + ball.radius;
    Part {
        levels: part.levels.iter().map(grain).collect(),
        ball: Ball {
            center: middle,
            radius: blocks.iter().map(reach).fold(0.0, f64::max),
        },
        blocks,
    }
}

impl GpuPart {
    fn upload(device: &wgpu::Device, part: PreviewPart) -> Self {
        let levels = part.levels.into_iter();
        Self {
            levels: levels
                .map(|level| GpuLevel::upload(device, level))
                .collect(),
            is_shared: part.is_shared,
        }
    }
}

impl GpuLevel {
    fn upload(device: &wgpu::Device, level: Level) -> Self {
        let largest = device.limits().max_buffer_size / (3 * size_of::<Vertex>()) as u64;
        let per_piece = usize::try_from(largest).unwrap_or(usize::MAX);
        let count = level.vertices.len() / 3;
        let piece = |start: usize| {
            let triangles = start..start.saturating_add(per_piece).min(count);
            let corners = &level.vertices[triangles.start * 3..triangles.end * 3];
            Piece {
                buffer: vertex_buffer(device, "preview triangles", corners),
                triangles,
            }
        };
        Self {
            pieces: (0..count).step_by(per_piece).map(piece).collect(),
            sources: level.sources,
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
