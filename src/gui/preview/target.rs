//! Where the preview is drawn: textures of the picture's size, and the way back to the CPU for tests.

use eframe::wgpu;

use super::pipeline::{COLOR_FORMAT, DEPTH_FORMAT, ID_FORMAT};

/// The textures of one picture size.
#[derive(Debug)]
pub(super) struct Target {
    pub(super) size: [u32; 2],
    /// The finished picture, one sample per pixel.
    pub(super) color: wgpu::Texture,
    pub(super) color_view: wgpu::TextureView,
    /// The samples that are averaged into it, where there is more than one per pixel.
    pub(super) samples: Option<wgpu::TextureView>,
    pub(super) depth: wgpu::TextureView,
}

impl Target {
    /// Textures for a picture of `size` pixels.
    pub(super) fn new(device: &wgpu::Device, size: [u32; 2], samples: u32) -> Self {
        let color = texture(device, size, 1, COLOR_FORMAT);
        Self {
            size,
            color_view: view_of(&color),
            samples: (samples > 1).then(|| view_of(&texture(device, size, samples, COLOR_FORMAT))),
            depth: view_of(&texture(device, size, samples, DEPTH_FORMAT)),
            color,
        }
    }
}

/// Textures for a picture of object ids.
#[derive(Debug)]
pub(super) struct IdTarget {
    pub(super) ids: wgpu::Texture,
    pub(super) ids_view: wgpu::TextureView,
    pub(super) depth: wgpu::TextureView,
}

impl IdTarget {
    pub(super) fn new(device: &wgpu::Device, size: [u32; 2]) -> Self {
        let ids = texture(device, size, 1, ID_FORMAT);
        Self {
            ids_view: view_of(&ids),
            depth: view_of(&texture(device, size, 1, DEPTH_FORMAT)),
            ids,
        }
    }
}

fn texture(
    device: &wgpu::Device,
    [width, height]: [u32; 2],
    samples: u32,
    format: wgpu::TextureFormat,
) -> wgpu::Texture {
    let read_back = if samples == 1 && format != DEPTH_FORMAT {
        wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::TEXTURE_BINDING
    } else {
        wgpu::TextureUsages::empty()
    };
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("preview"),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | read_back,
        view_formats: &[],
    })
}

fn view_of(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// Waits for the GPU and copies a texture of four bytes per pixel to the CPU, rows from the top.
///
/// # Errors
/// What the GPU says, in words.
pub(super) fn read_back(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
) -> Result<Vec<[u8; 4]>, String> {
    let (width, height) = (texture.width(), texture.height());
    let row_bytes = width * 4;
    let padded = row_bytes.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("preview read back"),
        size: u64::from(padded) * u64::from(height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(padded),
                rows_per_image: None,
            },
        },
        texture.size(),
    );
    queue.submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |_| {});
    device
        .poll(wgpu::PollType::wait_indefinitely())
        .map_err(|error| error.to_string())?;
    let mapped = buffer
        .get_mapped_range(..)
        .map_err(|error| error.to_string())?;
    let pixels = mapped
        .chunks_exact(padded as usize)
        .flat_map(|row| row[..row_bytes as usize].chunks_exact(4))
        .map(|pixel| [pixel[0], pixel[1], pixel[2], pixel[3]])
        .collect();
    Ok(pixels)
}
