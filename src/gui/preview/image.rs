//! Images of objects on the GPU, at every size but those larger than a preview needs: of colours, and of normals.

use std::sync::Arc;

use eframe::wgpu;
use eframe::wgpu::util::{DeviceExt, TextureDataOrder};
use half::f16;
use rayon::prelude::*;

use crate::control::CancelToken;
use crate::gui::worker::Gpu;
use crate::math::Vec3;
use crate::math::color::srgb_from_linear;
use crate::render::{Meaning, Pyramid};
use crate::scene::{Texels, TextureImage};

/// Most texels along a side of an image: about what a screen shows of one.
const MOST_SIDE: usize = 4096;
/// At how many places along a line the GPU looks for a pixel that sees a surface from the side.
const ANISOTROPY: u16 = 8;

/// An image on the GPU.
#[derive(Debug)]
pub(super) struct GpuImage {
    /// What it was made of; `None` changes nothing.
    source: Option<Arc<TextureImage>>,
    meaning: Meaning,
    view: wgpu::TextureView,
}

impl GpuImage {
    /// `None` when cancelled.
    pub(super) fn upload(
        gpu: &Gpu,
        source: Option<&Arc<TextureImage>>,
        meaning: Meaning,
        cancel: &CancelToken,
    ) -> Option<Self> {
        let Gpu { device, queue, .. } = gpu;
        let texture = match source {
            None => {
                let neutral = Level {
                    size: [1, 1],
                    bytes: match meaning {
                        Meaning::Color => vec![255; 4],
                        Meaning::Normal => vec![0, 0, 127, 0],
                    },
                };
                let format = format_of(None, meaning);
                texture(device, queue, format, &[neutral])
            }
            Some(image) => {
                let pyramid = Pyramid::new(image, meaning, cancel)?;
                let limit = device.limits().max_texture_dimension_2d as usize;
                let levels = levels_of(&pyramid, limit.min(MOST_SIDE));
                texture(device, queue, format_of(Some(image), meaning), &levels)
            }
        };
        Some(Self {
            source: source.cloned(),
            meaning,
            view: texture.create_view(&wgpu::TextureViewDescriptor::default()),
        })
    }

    /// Whether it was made of that.
    pub(super) fn is_of(&self, source: Option<&Arc<TextureImage>>, meaning: Meaning) -> bool {
        let is_same = self.source.as_ref().map(Arc::as_ptr) == source.map(Arc::as_ptr);
        is_same && self.meaning == meaning
    }

    /// Whether it was made of an image.
    pub(super) fn is_some(&self) -> bool {
        self.source.is_some()
    }
}

/// What a shader finds of an image of colours and one of normals.
pub(super) fn bind_group(
    device: &wgpu::Device,
    color: &GpuImage,
    normals: &GpuImage,
) -> wgpu::BindGroup {
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
    let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("preview paint"),
        layout: &layout(device),
        entries: &[
            entry(0, wgpu::BindingResource::TextureView(&color.view)),
            entry(1, wgpu::BindingResource::Sampler(&sampler)),
            entry(2, wgpu::BindingResource::TextureView(&normals.view)),
        ],
    })
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
        entries: &[entry(0, image), entry(1, sampler), entry(2, image)],
    })
}

/// An image at one size, as its texture holds it.
struct Level {
    size: [usize; 2],
    bytes: Vec<u8>,
}

/// Colours of floats may be brighter than 1; the others are on a screen as they are. Normals in bytes keep their codes.
fn format_of(image: Option<&TextureImage>, meaning: Meaning) -> wgpu::TextureFormat {
    match (image.map(TextureImage::texels), meaning) {
        (None | Some(Texels::Bytes(_) | Texels::Words(_)), Meaning::Color) => {
            wgpu::TextureFormat::Rgba8UnormSrgb
        }
        (None | Some(Texels::Bytes(_)), Meaning::Normal) => wgpu::TextureFormat::Rgba8Snorm,
        _ => wgpu::TextureFormat::Rgba16Float,
    }
}

/// All sizes of an image whose sides are `most` at the most.
fn levels_of(pyramid: &Pyramid, most: usize) -> Vec<Level> {
    let levels = (0..pyramid.level_count()).filter(|&level| {
        let (width, height) = pyramid.size(level);
        width.max(height) <= most
    });
    let format = format_of(Some(pyramid.image()), pyramid.meaning());
    levels
        .map(|level| Level::of(pyramid, level, format))
        .collect()
}

impl Level {
    fn of(pyramid: &Pyramid, level: usize, format: wgpu::TextureFormat) -> Self {
        let (width, height) = pyramid.size(level);
        let texels = (0..width * height).into_par_iter();
        let texels = texels.map(|index| pyramid.texel(level, index % width, index / width));
        let bytes = match format {
            wgpu::TextureFormat::Rgba16Float => {
                let most = f16::MAX.to_f32();
                let half = |value: f32| f16::from_f32(value.clamp(-most, most)).to_le_bytes();
                let bytes = |texel: Vec3| {
                    let [[r0, r1], [g0, g1], [b0, b1]] = texel.to_array().map(half);
                    [r0, r1, g0, g1, b0, b1, 0, 0]
                };
                texels.flat_map_iter(bytes).collect()
            }
            wgpu::TextureFormat::Rgba8Snorm => {
                #[expect(clippy::cast_possible_truncation, reason = "values are in −1..=1")]
                let byte = |value: f32| ((value * 127.0).round() as i8).cast_unsigned();
                let bytes = |texel: Vec3| {
                    let [x, y, z] = texel.to_array().map(byte);
                    [x, y, z, 0]
                };
                texels.flat_map_iter(bytes).collect()
            }
            _ => {
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
            }
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
    fn normals_keep_their_codes() {
        let codes = vec![
            [128, 128, 255],
            [0, 1, 128],
            [255, 129, 127],
            [64, 200, 220],
        ];
        let image = Arc::new(TextureImage::new(4, 1, Texels::Bytes(codes.clone())));
        let pyramid = Pyramid::new(&image, Meaning::Normal, &CancelToken::new()).unwrap();
        let levels = levels_of(&pyramid, 4);
        // 128 is 0, and nothing is below −127.
        let code = |code: u8| (i16::from(code) - 128).max(-127).to_le_bytes()[0];
        let expected = codes
            .iter()
            .flat_map(|&[x, y, z]| [code(x), code(y), code(z), 0]);
        assert!(levels[0].bytes.iter().copied().eq(expected));
    }
}
