//! Pictures from files, to be measured: PNG, OpenEXR and Radiance HDR, by this program or any other.
//!
//! Values come as they stand in the file, negative and not finite ones too. A PNG is taken as sRGB and decoded to linear
//! values; of alpha nothing is applied.

use std::io::Cursor;
use std::path::Path;

use super::origin::WrittenOrigin;
use super::radiance_file::{
    Named, RawFile, RawImage, Reading, no_memory, read_values, refuse_size, too_short,
};
use super::whole_file::read_file;
use crate::control::{CancelToken, Progress};
use crate::math::color::linear_from_srgb;
use crate::render::{Image, Layer};

/// The formats that have a reader, for messages.
pub const PICTURE_FORMATS: &str = "PNG (.png), OpenEXR (.exr) and Radiance HDR (.hdr)";

/// What a picture's file held.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureFile {
    /// Its pixels, in linear RGB.
    pub image: Image,
    /// Short name of the format, as people write it.
    pub format: &'static str,
    /// Whether the file holds the light itself, and not what a screen shows of it.
    pub is_linear: bool,
    /// What looks wrong or was left out, in sentences.
    pub warnings: Vec<String>,
}

/// What the file of a render held.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderFile {
    /// The picture.
    pub picture: PictureFile,
    /// Its layers, as [`write_image`](super::write_image) writes them: the radiance itself. Formats that hold none have none. Else why there
    /// is no room for them, in a plain sentence.
    pub layers: Result<Vec<(Layer, Image)>, String>,
    /// What it tells of how it came to be.
    pub origin: WrittenOrigin,
}

/// Why a picture could not be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{name}: {reason}")]
pub struct PictureError {
    /// The file, as it was asked for.
    pub name: String,
    /// What is wrong and what was expected, in a plain sentence.
    pub reason: String,
}

/// Reads the picture at `path`. The content says which format it is; the name may say what it likes.
///
/// # Errors
/// When the file cannot be read, is of a format without reader, is malformed or ends early, or holds a size that cannot be
/// held.
#[expect(clippy::missing_panics_doc, reason = "nobody cancels")]
pub fn read_image(path: &Path) -> Result<PictureFile, PictureError> {
    let read = read_image_unless(path, &CancelToken::new(), &Progress::new());
    read.map(|file| file.expect("nobody cancels"))
}

/// [`read_image`], unless it is cancelled, which is `None`. `progress` advances by bytes, each once when it is read and once when it is
/// understood; setting its total is the caller's.
///
/// # Errors
/// Those of [`read_image`].
pub fn read_image_unless(
    path: &Path,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<PictureFile>, PictureError> {
    read(path, cancel, progress, |bytes| {
        let read = parse(bytes, &[], cancel, progress)?;
        Ok(read.map(|(picture, _)| picture))
    })
}

/// The picture of a render at `path`, with all else that its file holds. `None` when cancelled; `progress` advances like that of
/// [`read_image_unless`].
///
/// # Errors
/// Those of [`read_image`].
pub fn read_render(
    path: &Path,
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<RenderFile>, PictureError> {
    read(path, cancel, progress, |bytes| {
        render_of(bytes, cancel, progress)
    })
}

/// The render in `bytes`, which are those of a whole file.
fn render_of(bytes: &[u8], cancel: &CancelToken, progress: &Progress) -> Reading<RenderFile> {
    let names = Layer::ALL.map(Layer::name);
    let read = parse(bytes, &names, cancel, progress)?;
    let layer = |(place, image): (usize, RawImage)| (Layer::ALL[place], image.into());
    Ok(read.map(|(picture, named)| RenderFile {
        picture,
        layers: named.map(|images| images.into_iter().map(layer).collect()),
        // A picture that says nothing of it is one all the same.
        origin: WrittenOrigin::of_bytes(bytes).unwrap_or_default(),
    }))
}

/// What `understand` makes of the file at `path`; errors name it.
fn read<T>(
    path: &Path,
    cancel: &CancelToken,
    progress: &Progress,
    understand: impl FnOnce(&[u8]) -> Reading<T>,
) -> Result<Option<T>, PictureError> {
    let bytes = read_file(path, "a picture", cancel, progress);
    let read = bytes.and_then(|bytes| match bytes {
        Some(bytes) => understand(&bytes),
        None => Ok(None),
    });
    read.map_err(|reason| PictureError {
        name: path.display().to_string(),
        reason,
    })
}

/// The picture in `bytes`, which are those of a whole file; `name` stands for the path in messages.
///
/// # Errors
/// Those of [`read_image`] that are about the content.
pub fn parse_image(name: &str, bytes: &[u8]) -> Result<PictureFile, PictureError> {
    let parsed = parse(bytes, &[], &CancelToken::new(), &Progress::new());
    whole(
        name,
        parsed.map(|parsed| parsed.map(|(picture, _)| picture)),
    )
}

/// The render in `bytes`, like [`parse_image`].
///
/// # Errors
/// Those of [`parse_image`].
pub fn parse_render(name: &str, bytes: &[u8]) -> Result<RenderFile, PictureError> {
    let parsed = render_of(bytes, &CancelToken::new(), &Progress::new());
    whole(name, parsed)
}

/// What was read while nobody could cancel; errors name it.
fn whole<T>(name: &str, read: Reading<T>) -> Result<T, PictureError> {
    let read = read.map(|read| read.expect("nobody cancels"));
    read.map_err(|reason| PictureError {
        name: name.to_owned(),
        reason,
    })
}

fn is_png(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x89PNG")
}

/// The picture in `bytes`, which are those of a whole file, and the images beside it that are called by one of `names`.
fn parse(
    bytes: &[u8],
    names: &[&str],
    cancel: &CancelToken,
    progress: &Progress,
) -> Reading<(PictureFile, Named)> {
    let values = if is_png(bytes) {
        let linear = |code, most| linear_from_srgb(code as f32 / most as f32);
        let image = read_png(bytes, linear)?;
        progress.advance(bytes.len() as u64);
        Some(RawFile {
            format: "PNG",
            image,
            named: Ok(Vec::new()),
        })
    } else {
        read_values(bytes, names, PICTURE_FORMATS, cancel, progress)?
    };
    Ok(values.map(|values| {
        let RawFile {
            format,
            mut image,
            named,
        } = values;
        let picture = PictureFile {
            warnings: std::mem::take(&mut image.warnings),
            image: image.into(),
            format,
            is_linear: !is_png(bytes),
        };
        (picture, named)
    }))
}

impl From<RawImage> for Image {
    fn from(raw: RawImage) -> Self {
        Self {
            width: raw.width,
            height: raw.height,
            pixels: raw.pixels,
        }
    }
}

/// Most bytes that one byte of a PNG's compressed data can stand for.
///
/// Source: zlib's technical details: the limit of deflate is 1032:1.
const MOST_DEFLATED: u64 = 1032;

/// Reads a PNG of any kind. Of an animation the first frame is taken. `value_of`: what a sample's code, of which the second number
/// is the largest, 255 or 65535, becomes.
///
/// # Errors
/// What is wrong with the file, in a plain sentence.
pub fn read_png<T: Copy>(
    bytes: &[u8],
    value_of: impl Fn(usize, usize) -> T,
) -> Result<RawImage<T>, String> {
    let in_words = |error: png::DecodingError| format!("not a whole PNG file: {error}");
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    // Palettes become colours, and fewer than 8 bits become 8.
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(in_words)?;
    let info = reader.info();
    // The decoder counts on whole colours.
    if info
        .palette
        .as_ref()
        .is_some_and(|palette| palette.len() % 3 != 0)
    {
        return Err("the palette has a colour of less than three bytes".to_owned());
    }
    let length = bytes.len() as u64;
    let (width, height) = refuse_size(info.width.into(), info.height.into(), length)?;
    let stored = info.raw_row_length() as u64 * u64::from(height);
    if stored > MOST_DEFLATED * length {
        return Err(too_short(length, width, height));
    }
    let is_whole = |frame: &png::FrameControl| (frame.width, frame.height) == (width, height);
    if !info.frame_control.as_ref().is_none_or(is_whole) {
        return Err("the first frame of its animation is not the whole picture".to_owned());
    }
    let mut warnings = color_warnings(info);
    let is_interlaced = info.interlaced;
    let (color, depth) = reader.output_color_type();
    let mut pixels = Pixels::new((width, height), color, depth, value_of);
    if is_interlaced {
        let length = reader
            .output_buffer_size()
            .ok_or_else(|| no_memory(width, height))?;
        let mut encoded = Vec::new();
        encoded
            .try_reserve_exact(length)
            .map_err(|_| no_memory(width, height))?;
        encoded.resize(length, 0);
        reader.next_frame(&mut encoded).map_err(in_words)?;
        pixels.push(&encoded)?;
    } else {
        while let Some(row) = reader.next_row().map_err(in_words)? {
            pixels.push(row.data())?;
        }
    }
    // To the end, so that a file cut off there is noticed.
    reader.finish().map_err(in_words)?;

    if !pixels.is_opaque {
        warnings.push("some pixels are not opaque; their colours are taken as written".to_owned());
    }
    Ok(RawImage {
        width,
        height,
        pixels: pixels.decoded,
        warnings,
    })
}

/// Pixels of a PNG as they are decoded. Room is made for those that are there, not for those that a header claims.
struct Pixels<T> {
    width: u32,
    height: u32,
    color: png::ColorType,
    depth: png::BitDepth,
    /// What each code becomes.
    values: Vec<T>,
    decoded: Vec<[T; 3]>,
    /// Whether alpha, where there is one, is opaque throughout.
    is_opaque: bool,
}

impl<T: Copy> Pixels<T> {
    /// None yet of an image of this size; `depth` is that of a sample, 8 or 16 bits.
    fn new(
        (width, height): (u32, u32),
        color: png::ColorType,
        depth: png::BitDepth,
        value_of: impl Fn(usize, usize) -> T,
    ) -> Self {
        let most = most_code(depth);
        Self {
            width,
            height,
            color,
            depth,
            values: (0..=most).map(|code| value_of(code, most)).collect(),
            decoded: Vec::new(),
            is_opaque: true,
        }
    }

    /// Decodes whole rows.
    fn push(&mut self, encoded: &[u8]) -> Result<(), String> {
        /// What is there vouches for as much again, so many times over.
        const GROWTH: usize = 8;
        let samples = self.color.samples();
        let bytes = usize::from(most_code(self.depth) > usize::from(u8::MAX)) + 1;
        let (have, more) = (self.decoded.len(), encoded.len() / (samples * bytes));
        if self.decoded.capacity() - have < more {
            let all = self.width as usize * self.height as usize;
            let room = (GROWTH * have).min(all).max(have + more);
            self.decoded
                .try_reserve_exact(room - have)
                .map_err(|_| no_memory(self.width, self.height))?;
        }
        if bytes == 2 {
            let codes = encoded.as_chunks().0.iter();
            self.decode(
                codes.map(|&pair| usize::from(u16::from_be_bytes(pair))),
                more,
            );
        } else {
            self.decode(encoded.iter().map(|&code| usize::from(code)), more);
        }
        Ok(())
    }

    /// Decodes `count` pixels from as many codes as they have channels.
    fn decode(&mut self, mut codes: impl Iterator<Item = usize>, count: usize) {
        let colors = match self.color {
            png::ColorType::Grayscale | png::ColorType::GrayscaleAlpha => 1,
            png::ColorType::Rgb | png::ColorType::Rgba | png::ColorType::Indexed => 3,
        };
        let has_alpha = self.color.samples() > colors;
        let most = self.values.len() - 1;
        for _ in 0..count {
            let mut next = || codes.next().expect("whole pixels");
            self.decoded.push(match colors {
                1 => [self.values[next()]; 3],
                _ => [
                    self.values[next()],
                    self.values[next()],
                    self.values[next()],
                ],
            });
            if has_alpha {
                self.is_opaque &= next() == most;
            }
        }
    }
}

/// The largest code of a sample.
fn most_code(depth: png::BitDepth) -> usize {
    usize::from(match depth {
        png::BitDepth::Sixteen => u16::MAX,
        _ => u16::from(u8::MAX),
    })
}

/// What is said where a PNG may mean other colours than sRGB.
fn color_warnings(info: &png::Info) -> Vec<String> {
    /// What encoders write for sRGB: 1/2.2, in hundred thousandths.
    const SRGB_GAMMA: u32 = 45_455;
    /// Code points of ITU-T H.273: primaries of Rec. 709, transfer curve of sRGB.
    const SRGB_CODE_POINTS: (u8, u8) = (1, 13);

    let code_points = info
        .coding_independent_code_points
        .map(|points| (points.color_primaries, points.transfer_function));
    let gamma = info.gama_chunk.map(png::ScaledFloat::into_scaled);
    let claim = if code_points.is_some_and(|points| points != SRGB_CODE_POINTS) {
        "names another colour space"
    } else if info.icc_profile.is_some() {
        "has a colour profile"
    } else if info.srgb.is_none() && gamma.is_some_and(|gamma| gamma != SRGB_GAMMA) {
        "names another gamma"
    } else {
        return Vec::new();
    };
    vec![format!(
        "the file {claim}, which is not applied: its values are taken as sRGB"
    )]
}

#[cfg(test)]
mod tests;
