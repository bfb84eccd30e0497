//! The GPU programs of the preview: sky, objects in colour, and objects as ids.

use eframe::wgpu;

use super::geometry::Vertex;
use super::sky::SkyBinding;
use super::uniforms::{ObjectInstance, ViewUniform};

/// Format of the coloured picture: egui shows it as it is, so the shader encodes it for the screen.
pub(super) const COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Format of the picture of object ids.
pub(super) const ID_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
/// Format of the depth buffer, read from far (0) to near (1).
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// The compiled programs and the uniform they read.
#[derive(Debug)]
pub(super) struct Pipelines {
    pub(super) sky: wgpu::RenderPipeline,
    pub(super) objects: wgpu::RenderPipeline,
    pub(super) object_ids: wgpu::RenderPipeline,
    pub(super) view: wgpu::Buffer,
    pub(super) bind_group: wgpu::BindGroup,
    pub(super) sky_image: SkyBinding,
}

impl Pipelines {
    /// Compiles everything. `samples`: of the coloured picture, per pixel.
    pub(super) fn new(device: &wgpu::Device, queue: &wgpu::Queue, samples: u32) -> Self {
        let source = concat!(include_str!("shader.wgsl"), include_str!("sky.wgsl"));
        let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("preview"),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let sky_image = SkyBinding::new(device, queue);
        let bind_group_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("preview view"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            }],
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("preview"),
            bind_group_layouts: &[Some(&bind_group_layout), Some(&sky_image.layout)],
            immediate_size: 0,
        });
        let view = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("preview view"),
            size: size_of::<ViewUniform>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("preview view"),
            layout: &bind_group_layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: view.as_entire_binding(),
            }],
        });
        let program = |program: &Program<'_>| program.compile(device, &shader, &layout);
        let objects = Program {
            label: "preview objects",
            vertex: "vertex",
            buffers: &[Some(vertex_layout()), Some(instance_layout())],
            fragment: "color",
            format: COLOR_FORMAT,
            samples,
            depth: (true, wgpu::CompareFunction::Greater),
        };
        Self {
            sky: program(&Program {
                label: "preview sky",
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
            objects: program(&objects),
            view,
            bind_group,
            sky_image,
        }
    }
}

/// What tells one pipeline from another.
#[derive(Clone, Copy)]
struct Program<'a> {
    label: &'a str,
    vertex: &'a str,
    buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    fragment: &'a str,
    format: wgpu::TextureFormat,
    samples: u32,
    /// Whether it writes depth, and when it passes.
    depth: (bool, wgpu::CompareFunction),
}

impl Program<'_> {
    fn compile(
        &self,
        device: &wgpu::Device,
        shader: &wgpu::ShaderModule,
        layout: &wgpu::PipelineLayout,
    ) -> wgpu::RenderPipeline {
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(self.label),
            layout: Some(layout),
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

/// The layout of [`ObjectInstance`].
const fn instance_layout() -> wgpu::VertexBufferLayout<'static> {
    const ATTRIBUTES: [wgpu::VertexAttribute; 4] =
        wgpu::vertex_attr_array![2 => Float32x4, 3 => Float32x4, 4 => Float32x4, 5 => Uint32x2];
    wgpu::VertexBufferLayout {
        array_stride: size_of::<ObjectInstance>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &ATTRIBUTES,
    }
}
