//! Colours that vary over objects: those of vertices, and images.
//!
//! A worker uploads them beside the triangles: where corners lie on images and which colours they have, as far as something of it shows
//! on an object; and every image once, at every size but those larger than a preview needs. A scene without has none of it. The layouts
//! mirror `shader.wgsl`.

use std::collections::HashMap;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use eframe::wgpu;
use eframe::wgpu::util::{DeviceExt, TextureDataOrder};
use half::f16;
use rayon::prelude::*;

use super::geometry::{Draw, vertex_buffer};
use crate::control::CancelToken;
use crate::geometry::TriangleMesh;
use crate::gui::worker::Gpu;
use crate::math::color::srgb_from_linear;
use crate::math::{DVec2, Vec3};
use crate::render::{Meaning, Pyramid};
use crate::scene::{Object, Scene, Texels, TextureImage};

/// Most texels along a side of an image: about what a screen shows of one.
const MOST_SIDE: usize = 4096;
/// At how many places along a line the GPU looks for a pixel that sees a surface from the side.
const ANISOTROPY: u16 = 8;

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
    corners: HashMap<CornersKey, wgpu::Buffer>,
}

/// What varies over an object.
#[derive(Debug)]
struct ObjectPaint {
    /// As it was loaded.
    source: Arc<TriangleMesh>,
    /// As it is shown.
    mesh: Arc<TriangleMesh>,
    is_mirrored: bool,
    image: Arc<GpuImage>,
}

/// What tells the corners of a draw from others: the address of their mesh, whether two of each three were swapped, number of the first
/// among those of the object, and how many there are.
type CornersKey = (usize, bool, usize, usize);

/// An image on the GPU, as a shader finds it.
#[derive(Debug)]
pub(super) struct GpuImage {
    /// What it was made of; `None` is white.
    source: Option<Arc<TextureImage>>,
    pub(super) bind_group: wgpu::BindGroup,
}

/// What varies over an object of a scene.
struct Wanted<'a> {
    /// As it was loaded.
    mesh: &'a Arc<TriangleMesh>,
    image: Option<&'a Arc<TextureImage>>,
    has_colors: bool,
}

impl<'a> Wanted<'a> {
    /// `None` where nothing varies.
    fn of(scene: &'a Scene, object: &Object) -> Option<Self> {
        let textures = scene.materials.get(object.material.as_ref()?)?.textures()?;
        let mesh = scene.meshes.get(&object.mesh)?;
        let name = textures.diffuse_image.as_ref();
        let name = name.filter(|_| mesh.texture_coordinates.is_some());
        let image = name.and_then(|name| scene.textures.get(name));
        let has_colors = textures.vertex_colors && mesh.colors.is_some();
        (image.is_some() || has_colors).then_some(Self {
            mesh,
            image,
            has_colors,
        })
    }
}

/// Whether the same images and colours vary over the objects of two scenes, which have the same meshes. Images are compared by identity.
#[must_use]
pub fn same_paint(a: &Scene, b: &Scene) -> bool {
    let paint = |scene: &Scene, index: usize| {
        let wanted = Wanted::of(scene, &scene.objects[index]);
        wanted.map(|wanted| (wanted.image.map(Arc::as_ptr), wanted.has_colors))
    };
    a.objects.len() == b.objects.len()
        && (0..a.objects.len()).all(|index| paint(a, index) == paint(b, index))
}

impl GpuPaint {
    /// What varies over the objects of `scene`, whose triangles are drawn by `draws`. What is the same as in `previous` is kept.
    /// `None` when cancelled.
    pub(super) fn upload<'a>(
        gpu: &Gpu,
        scene: &Scene,
        draws: impl Iterator<Item = &'a Draw>,
        previous: &Self,
        cancel: &CancelToken,
    ) -> Option<Self> {
        let mut images: Vec<Arc<GpuImage>> = Vec::new();
        let mut objects = Vec::with_capacity(scene.objects.len());
        for object in &scene.objects {
            let Some(wanted) = Wanted::of(scene, object) else {
                objects.push(None);
                continue;
            };
            let is_it = |image: &&Arc<GpuImage>| image.is_of(wanted.image);
            let known = images.iter().find(is_it);
            let known = known.or_else(|| previous.images().find(is_it)).cloned();
            let image = match known {
                Some(known) => known,
                None => Arc::new(GpuImage::upload(gpu, wanted.image, cancel)?),
            };
            images.push(Arc::clone(&image));
            let shown = scene.shown_mesh_of(object);
            objects.push(Some(ObjectPaint {
                source: Arc::clone(wanted.mesh),
                mesh: shown.unwrap_or_else(|_| Arc::clone(wanted.mesh)),
                is_mirrored: object.placement().linear.determinant() < 0.0,
                image,
            }));
        }
        if images.is_empty() {
            return Some(Self::default());
        }
        let mut corners = HashMap::new();
        for draw in draws {
            let Some(paint) = objects.get(draw.object as usize).and_then(Option::as_ref) else {
                continue;
            };
            if cancel.is_cancelled() {
                return None;
            }
            let key = paint.key_of(draw);
            corners.entry(key).or_insert_with(|| {
                let known = previous.corners.get(&key).cloned();
                known.unwrap_or_else(|| {
                    let vertices = paint.vertices(key);
                    vertex_buffer(&gpu.device, "preview paint", &vertices)
                })
            });
        }
        Some(Self { objects, corners })
    }

    /// Whether nothing varies over any object.
    pub(super) fn is_empty(&self) -> bool {
        self.objects.is_empty()
    }

    fn images(&self) -> impl Iterator<Item = &Arc<GpuImage>> {
        self.objects.iter().flatten().map(|paint| &paint.image)
    }

    /// What a draw needs beside its triangles; `None` where nothing varies.
    pub(super) fn of_draw(&self, draw: &Draw) -> Option<(&wgpu::Buffer, &GpuImage)> {
        let paint = self.objects.get(draw.object as usize)?.as_ref()?;
        Some((self.corners.get(&paint.key_of(draw))?, &paint.image))
    }

    /// Whether the image that lies on object `index` of `scene` now is here, and whether its vertices' colours are and count.
    pub(super) fn shows(&self, scene: &Scene, index: usize) -> [bool; 2] {
        let paint = self.objects.get(index).and_then(Option::as_ref);
        let wanted = scene.objects.get(index);
        let wanted = wanted.and_then(|object| Wanted::of(scene, object));
        paint.zip(wanted).map_or([false; 2], |(paint, wanted)| {
            let is_same = Arc::ptr_eq(&paint.source, wanted.mesh);
            let has_image = wanted.image.is_some() && paint.image.is_of(wanted.image);
            [is_same && has_image, is_same && wanted.has_colors]
        })
    }
}

impl ObjectPaint {
    fn key_of(&self, draw: &Draw) -> CornersKey {
        let is_swapped = self.is_mirrored && !draw.is_shared;
        let address = Arc::as_ptr(&self.mesh).addr();
        (address, is_swapped, draw.first, draw.corners.len())
    }

    fn vertices(&self, (_, is_swapped, first, count): CornersKey) -> Vec<PaintVertex> {
        let triangles = &self.mesh.triangles;
        // Copies follow each other.
        let corners = |triangle: usize| {
            let [a, b, c] = triangles[triangle % triangles.len()];
            if is_swapped { [a, c, b] } else { [a, b, c] }
        };
        let numbers = (first / 3)..(first + count).div_ceil(3);
        numbers
            .into_par_iter()
            .flat_map_iter(|number| triangle_of(&self.mesh, corners(number)))
            .collect()
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

impl GpuImage {
    /// `None` when cancelled.
    fn upload(gpu: &Gpu, source: Option<&Arc<TextureImage>>, cancel: &CancelToken) -> Option<Self> {
        let Gpu { device, queue, .. } = gpu;
        let texture = match source {
            None => {
                let white = [Level {
                    size: [1, 1],
                    bytes: vec![255; 4],
                }];
                texture(device, queue, wgpu::TextureFormat::Rgba8UnormSrgb, &white)
            }
            Some(image) => {
                let pyramid = Pyramid::new(image, Meaning::Color, cancel)?;
                let limit = device.limits().max_texture_dimension_2d as usize;
                let levels = levels_of(&pyramid, limit.min(MOST_SIDE));
                texture(device, queue, format_of(image), &levels)
            }
        };
        // An adapter in software pays for each place, and blurs what it need not.
        let is_software = device.adapter_info().device_type == wgpu::DeviceType::Cpu;
        let anisotropy = if is_software { 1 } else { ANISOTROPY };
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("preview paint"),
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            anisotropy_clamp: anisotropy,
            ..wgpu::SamplerDescriptor::default()
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("preview paint"),
            layout: &layout(device),
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(&view),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::Sampler(&sampler),
                },
            ],
        });
        Some(Self {
            source: source.cloned(),
            bind_group,
        })
    }

    fn is_of(&self, source: Option<&Arc<TextureImage>>) -> bool {
        self.source.as_ref().map(Arc::as_ptr) == source.map(Arc::as_ptr)
    }
}

/// How a shader finds an image.
pub(super) fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty,
        count: None,
    };
    let image = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: true },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("preview paint"),
        entries: &[entry(0, image), entry(1, sampler)],
    })
}

/// An image at one size, as its texture holds it.
struct Level {
    size: [usize; 2],
    bytes: Vec<u8>,
}

/// Floats may be brighter than 1; the others are on a screen as they are.
fn format_of(image: &TextureImage) -> wgpu::TextureFormat {
    match image.texels() {
        Texels::Bytes(_) | Texels::Words(_) => wgpu::TextureFormat::Rgba8UnormSrgb,
        Texels::Floats(_) => wgpu::TextureFormat::Rgba16Float,
    }
}

/// All sizes of an image whose sides are `most` at the most.
fn levels_of(pyramid: &Pyramid, most: usize) -> Vec<Level> {
    let levels = (0..pyramid.level_count()).filter(|&level| {
        let (width, height) = pyramid.size(level);
        width.max(height) <= most
    });
    levels.map(|level| Level::of(pyramid, level)).collect()
}

impl Level {
    fn of(pyramid: &Pyramid, level: usize) -> Self {
        let (width, height) = pyramid.size(level);
        let texels = (0..width * height).into_par_iter();
        let texels = texels.map(|index| pyramid.texel(level, index % width, index / width));
        let bytes = if let Texels::Floats(_) = pyramid.image().texels() {
            let half = |value: f32| f16::from_f32(value.min(f16::MAX.to_f32())).to_le_bytes();
            let bytes = |texel: Vec3| {
                let [[r0, r1], [g0, g1], [b0, b1]] = texel.to_array().map(half);
                [r0, r1, g0, g1, b0, b1, 0, 0]
            };
            texels.flat_map_iter(bytes).collect()
        } else {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "encoded values are in 0..=1"
            )]
            let byte = |linear: f32| (srgb_from_linear(linear) * 255.0 + 0.5) as u8;
            let bytes = |texel: Vec3| {
                let [r, g, b] = texel.to_array().map(byte);
                [r, g, b, 255]
            };
            texels.flat_map_iter(bytes).collect()
        };
        Self {
            size: [width, height],
            bytes,
        }
    }
}

/// `levels`: the largest first, each half of the one before.
fn texture(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    format: wgpu::TextureFormat,
    levels: &[Level],
) -> wgpu::Texture {
    let side = |side: usize| u32::try_from(side).expect("a side of a texture");
    let [width, height] = levels[0].size.map(side);
    let descriptor = wgpu::TextureDescriptor {
        label: Some("preview paint"),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: side(levels.len()),
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    let bytes: Vec<u8> = levels
        .iter()
        .flat_map(|level| &level.bytes)
        .copied()
        .collect();
    device.create_texture_with_data(queue, &descriptor, TextureDataOrder::LayerMajor, &bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pyramid(width: u32, texels: Texels) -> Pyramid {
        let height = u32::try_from(texels.len()).unwrap() / width;
        let image = Arc::new(TextureImage::new(width, height, texels));
        Pyramid::new(&image, Meaning::Color, &CancelToken::new()).unwrap()
    }

    #[test]
    fn codes_stay_as_they_are_and_smaller_sizes_hold_the_mean_of_the_light() {
        let codes: Vec<[u8; 3]> = (0..=255).map(|code| [code, 255 - code, 0]).collect();
        let levels = levels_of(&pyramid(16, Texels::Bytes(codes.clone())), 16);
        assert_eq!(levels.len(), 5);
        let expected: Vec<u8> = codes.iter().flat_map(|&[r, g, b]| [r, g, b, 255]).collect();
        assert_eq!(levels[0].bytes, expected);

        // Half of the light is code 188.
        let chequers = (0..64).map(|i| [if (i + i / 8) % 2 == 0 { 0 } else { 255 }; 3]);
        let levels = levels_of(&pyramid(8, Texels::Bytes(chequers.collect())), 8);
        for level in &levels[1..] {
            assert!(
                level
                    .bytes
                    .chunks(4)
                    .all(|texel| texel == [188, 188, 188, 255])
            );
        }
    }

    #[test]
    fn what_is_larger_than_the_limit_is_left_out() {
        let levels = levels_of(&pyramid(20, Texels::Bytes(vec![[9; 3]; 100])), 10);
        assert_eq!(levels[0].size, [10, 2]);
        let floats = levels_of(&pyramid(2, Texels::Floats(vec![[4.0, 1e9, 0.5]; 2])), 1);
        let halves = [4.0, 65_504.0, 0.5, 0.0].map(f16::from_f32);
        let expected: Vec<u8> = halves.iter().flat_map(|half| half.to_le_bytes()).collect();
        assert_eq!((floats.len(), &floats[0].bytes), (1, &expected));
    }

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
