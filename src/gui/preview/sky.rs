//! The background's image on the GPU.
//!
//! A worker uploads the texels once per image, smaller where the image is larger than a preview needs; axes and factor are a
//! uniform, so that turning and scaling the image cost nothing. The layouts mirror `sky.wgsl`.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use eframe::wgpu;
use eframe::wgpu::util::{DeviceExt, TextureDataOrder};
use half::f16;

use super::sky_light;
use super::uniforms::vec4;
use crate::math::DVec3;
use crate::scene::{Background, ImageAxes, RadianceMap, Scene};

/// Most texels of a row: more than a screen shows of a whole turn at usual angles.
const MOST_WIDTH: u32 = 4096;

/// Half the bytes of `f32`, and far finer than a screen.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// An image on the GPU.
#[derive(Debug)]
pub struct GpuSky {
    /// What it was made of.
    pub(super) source: Arc<RadianceMap>,
    texels: wgpu::TextureView,
    light: [DVec3; 9],
}

impl GpuSky {
    /// Uploads `map`. May be called from any thread.
    #[must_use]
    pub fn upload(device: &wgpu::Device, queue: &wgpu::Queue, map: &Arc<RadianceMap>) -> Self {
        let limit = MOST_WIDTH.min(device.limits().max_texture_dimension_2d);
        let smaller = shrunk(map, limit);
        let shown = smaller.as_ref().unwrap_or(map);
        Self {
            source: Arc::clone(map),
            texels: texture(device, queue, shown),
            light: sky_light::irradiance(shown),
        }
    }

    /// The image it shows.
    #[must_use]
    pub fn source(&self) -> &Arc<RadianceMap> {
        &self.source
    }
}

/// `map` with sides of at most `limit`, each texel the mean of those it stands for; `None` where it is small enough.
fn shrunk(map: &RadianceMap, limit: u32) -> Option<RadianceMap> {
    let (width, height) = (map.width().min(limit), map.height().min(limit));
    if (width, height) == (map.width(), map.height()) {
        return None;
    }
    let span = |index: u32, to: u32, from: u32| {
        let edge = |index: u32| u64::from(index) * u64::from(from) / u64::from(to);
        // As long as `to ≤ from`, no span is empty.
        edge(index)..edge(index + 1)
    };
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    for y in 0..height {
        for x in 0..width {
            let (rows, columns) = (span(y, height, map.height()), span(x, width, map.width()));
            let count = (rows.end - rows.start) * (columns.end - columns.start);
            let mut sum = DVec3::ZERO;
            for row in rows {
                let row = map.row(u32::try_from(row).expect("a row of the image"));
                #[expect(clippy::cast_possible_truncation, reason = "columns of the image")]
                for pixel in &row[columns.start as usize..columns.end as usize] {
                    sum += DVec3::from_array(pixel.map(f64::from));
                }
            }
            pixels.push((sum / count as f64).as_vec3().to_array());
        }
    }
    Some(RadianceMap::cleaned(width, height, pixels).0)
}

fn texture(device: &wgpu::Device, queue: &wgpu::Queue, map: &RadianceMap) -> wgpu::TextureView {
    // Brighter than the format holds is white on any screen.
    let narrow = |value: f32| f16::from_f32(value.min(f16::MAX.to_f32())).to_bits();
    let texels: Vec<[u16; 4]> = map
        .pixels()
        .iter()
        .map(|&[r, g, b]| [narrow(r), narrow(g), narrow(b), 0])
        .collect();
    let descriptor = wgpu::TextureDescriptor {
        label: Some("preview sky"),
        size: wgpu::Extent3d {
            width: map.width(),
            height: map.height(),
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    let order = TextureDataOrder::LayerMajor;
    device
        .create_texture_with_data(queue, &descriptor, order, bytemuck::cast_slice(&texels))
        .create_view(&wgpu::TextureViewDescriptor::default())
}

/// The shader's `SkyImage`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct SkyUniform {
    front: [f32; 4],
    left: [f32; 4],
    up: [f32; 4],
    light: [[f32; 4]; 9],
}

impl SkyUniform {
    /// The uniform of `scene`'s image as `sky` holds it: of no image where the background is none or `sky` is of another.
    pub(super) fn new(scene: &Scene, sky: Option<&GpuSky>) -> Self {
        let (
            &Background::Image {
                up,
                rotation,
                scale,
                ..
            },
            Ok(Some(map)),
        ) = (&scene.background, scene.background_image())
        else {
            return Self::zeroed();
        };
        let (Some(sky), Some(axes)) = (
            sky.filter(|sky| Arc::ptr_eq(&sky.source, map)),
            ImageAxes::new(up, rotation),
        ) else {
            return Self::zeroed();
        };
        Self {
            front: vec4(axes.front, 1.0),
            left: vec4(axes.left, scale),
            up: vec4(axes.up, 0.0),
            light: sky.light.map(|coefficient| vec4(coefficient, 0.0)),
        }
    }
}

/// How the shader finds the image: the uniform, and the texture of the present image or a black one.
#[derive(Debug)]
pub(super) struct SkyBinding {
    pub(super) layout: wgpu::BindGroupLayout,
    pub(super) bind_group: wgpu::BindGroup,
    uniform: wgpu::Buffer,
    /// Whose texture is bound.
    bound: Option<Arc<GpuSky>>,
    black: wgpu::TextureView,
}

impl SkyBinding {
    pub(super) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty,
            count: None,
        };
        let buffer = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let image = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("preview sky"),
            entries: &[entry(0, buffer), entry(1, image)],
        });
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("preview sky"),
            size: size_of::<SkyUniform>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let (pixel, _) = RadianceMap::cleaned(1, 1, vec![[0.0; 3]]);
        let black = texture(device, queue, &pixel);
        Self {
            bind_group: bind(device, &layout, &uniform, &black),
            layout,
            uniform,
            bound: None,
            black,
        }
    }

    /// Hands the GPU what has changed.
    pub(super) fn update(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        values: &SkyUniform,
        sky: Option<&Arc<GpuSky>>,
    ) {
        queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(values));
        if self.bound.as_ref().map(Arc::as_ptr) != sky.map(Arc::as_ptr) {
            let texels = sky.map_or(&self.black, |sky| &sky.texels);
            self.bind_group = bind(device, &self.layout, &self.uniform, texels);
            self.bound = sky.cloned();
        }
    }
}

fn bind(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    uniform: &wgpu::Buffer,
    texels: &wgpu::TextureView,
) -> wgpu::BindGroup {
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("preview sky"),
        layout,
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: uniform.as_entire_binding(),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: wgpu::BindingResource::TextureView(texels),
            },
        ],
    })
}
