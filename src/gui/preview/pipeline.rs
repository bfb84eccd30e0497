//! The GPU programs of the preview: sky, objects in colour, and objects as ids.

use eframe::wgpu;

use super::geometry::{Place, Vertex};
use super::image;
use super::paint::PaintVertex;
use super::sky::SkyBinding;
use super::uniforms::{ObjectUniform, ViewUniform};

/// Format of the coloured picture: egui shows it as it is, so the shader encodes it for the screen.
pub(super) const COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Format of the picture of object ids.
pub(super) const ID_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
/// Format of the depth buffer, read from far (0) to near (1).
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// The compiled programs and the uniforms they read.
#[derive(Debug)]
pub(super) struct Pipelines {
    pub(super) sky: wgpu::RenderPipeline,
    pub(super) objects: wgpu::RenderPipeline,
    /// Objects over which images or colours vary.
    pub(super) painted_objects: wgpu::RenderPipeline,
    /// Objects with an image of normals.
    pub(super) embossed_objects: wgpu::RenderPipeline,
    pub(super) object_ids: wgpu::RenderPipeline,
    pub(super) view: wgpu::Buffer,
    pub(super) bind_group: wgpu::BindGroup,
    pub(super) sky_image: SkyBinding,
    object_layout: wgpu::BindGroupLayout,
}

impl Pipelines {
    /// Compiles everything. `samples`: of the coloured picture, per pixel.
    pub(super) fn new(device: &wgpu::Device, queue: &wgpu::Queue, samples: u32) -> Self {
        let source = concat!(include_str!("shader.wgsl"), include_str!("sky.wgsl"));
        let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("preview"),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let view_layout = uniform_layout(device, "preview view", false);
        let sky_image = SkyBinding::new(device, queue);
        let object_layout = uniform_layout(device, "preview object", true);
        let layout = |groups: &[Option<&wgpu::BindGroupLayout>]| {
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("preview"),
                bind_group_layouts: groups,
                immediate_size: 0,
            })
        };
        let paint_layout = image::layout(device);
        let groups = [
            &view_layout,
            &sky_image.layout,
            &object_layout,
            &paint_layout,
        ]
        .map(Some);
        let [sky_layout, objects_layout, painted_layout] =
            [2, 3, 4].map(|count| layout(&groups[..count]));
        let view = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("preview view"),
            size: size_of::<ViewUniform>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("preview view"),
            layout: &view_layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: view.as_entire_binding(),
            }],
        });
        let program = |program: &Program<'_>| program.compile(device, &shader);
        let objects = Program {
            label: "preview objects",
            layout: &objects_layout,
            vertex: "vertex",
            buffers: &[Some(vertex_layout()), Some(place_layout())],
            fragment: "color",
            format: COLOR_FORMAT,
            samples,
            depth: (true, wgpu::CompareFunction::Greater),
        };
        let painted_buffers = [
            Some(vertex_layout()),
            Some(place_layout()),
            Some(paint_vertex_layout()),
        ];
        let painted = Program {
            label: "preview painted objects",
            layout: &painted_layout,
            vertex: "painted_vertex",
            buffers: &painted_buffers,
            fragment: "painted_color",
            ..objects
        };
        Self {
            sky: program(&Program {
                label: "preview sky",
                layout: &sky_layout,
                vertex: "sky_vertex",
                buffers: &[],
                fragment: "sky_color",
                depth: (false, wgpu::CompareFunction::Always),
                ..objects
            }),
            object_ids: program(&Program {
                label: "preview object ids",
                fragment: "object_id",
                format: ID_FORMAT,
                samples: 1,
                ..objects
            }),
            painted_objects: program(&painted),
            embossed_objects: program(&Program {
                label: "preview embossed objects",
                fragment: "embossed_color",
                ..painted
            }),
            objects: program(&objects),
            view,
            bind_group,
            sky_image,
            object_layout,
        }
    }

    /// Room for the uniforms of `count` objects.
    pub(super) fn object_uniforms(&self, device: &wgpu::Device, count: usize) -> ObjectUniforms {
        let alignment = device.limits().min_uniform_buffer_offset_alignment;
        let size = size_of::<ObjectUniform>();
        let stride = size.next_multiple_of(alignment as usize);
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("preview objects"),
            size: (stride * count) as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("preview objects"),
            layout: &self.object_layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer: &buffer,
                    offset: 0,
                    size: wgpu::BufferSize::new(size as u64),
                }),
            }],
        });
        ObjectUniforms {
            buffer,
            bind_group,
            stride,
            count,
        }
    }
}

/// The uniforms of all objects in one buffer; a draw chooses one by its offset.
#[derive(Debug)]
pub(super) struct ObjectUniforms {
    buffer: wgpu::Buffer,
    bind_group: wgpu::BindGroup,
    stride: usize,
    pub(super) count: usize,
}

impl ObjectUniforms {
    /// Hands the GPU the uniforms, for which there is room.
    pub(super) fn write(&self, queue: &wgpu::Queue, uniforms: &[ObjectUniform]) {
        let mut bytes = vec![0; self.stride * uniforms.len()];
        for (slot, uniform) in bytes.chunks_exact_mut(self.stride).zip(uniforms) {
            slot[..size_of::<ObjectUniform>()].copy_from_slice(bytemuck::bytes_of(uniform));
        }
        queue.write_buffer(&self.buffer, 0, &bytes);
    }

    /// Makes the uniform of object `index` the one that the next draw reads.
    pub(super) fn choose(&self, pass: &mut wgpu::RenderPass<'_>, index: u32) {
        let offset = u32::try_from(self.stride).unwrap_or(u32::MAX) * index;
        pass.set_bind_group(2, &self.bind_group, &[offset]);
    }
}

/// The layout of one uniform, or of one of many that a draw chooses by an offset.
fn uniform_layout(device: &wgpu::Device, label: &str, is_chosen: bool) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some(label),
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: is_chosen,
                min_binding_size: None,
            },
            count: None,
        }],
    })
}

/// What tells one pipeline from another.
#[derive(Clone, Copy)]
struct Program<'a> {
    label: &'a str,
    layout: &'a wgpu::PipelineLayout,
    vertex: &'a str,
    buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    fragment: &'a str,
    format: wgpu::TextureFormat,
    samples: u32,
    /// Whether it writes depth, and when it passes.
    depth: (bool, wgpu::CompareFunction),
}

impl Program<'_> {
    fn compile(&self, device: &wgpu::Device, shader: &wgpu::ShaderModule) -> wgpu::RenderPipeline {
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(self.label),
            layout: Some(self.layout),
            vertex: wgpu::VertexState {
                module: shader,
                entry_point: Some(self.vertex),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: self.buffers,
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(self.depth.0),
                depth_compare: Some(self.depth.1),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState {
                count: self.samples,
                ..wgpu::MultisampleState::default()
            },
            fragment: Some(wgpu::FragmentState {
                module: shader,
                entry_point: Some(self.fragment),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(self.format.into())],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// The layout of [`Vertex`].
const fn vertex_layout() -> wgpu::VertexBufferLayout<'static> {
    const ATTRIBUTES: [wgpu::VertexAttribute; 2] =
        wgpu::vertex_attr_array![0 => Float32x3, 1 => Snorm16x4];
    wgpu::VertexBufferLayout {
        array_stride: size_of::<Vertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &ATTRIBUTES,
    }
}

/// The layout of [`Place`].
const fn place_layout() -> wgpu::VertexBufferLayout<'static> {
    const ATTRIBUTES: [wgpu::VertexAttribute; 2] =
        wgpu::vertex_attr_array![2 => Float32x3, 3 => Float32x3];
    wgpu::VertexBufferLayout {
        array_stride: size_of::<Place>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &ATTRIBUTES,
    }
}

/// The layout of [`PaintVertex`].
const fn paint_vertex_layout() -> wgpu::VertexBufferLayout<'static> {
    const ATTRIBUTES: [wgpu::VertexAttribute; 2] =
        wgpu::vertex_attr_array![4 => Float32x2, 5 => Float16x4];
    wgpu::VertexBufferLayout {
        array_stride: size_of::<PaintVertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &ATTRIBUTES,
    }
}
