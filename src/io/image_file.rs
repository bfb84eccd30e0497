//! Pictures to files: PNG as a screen shows them, OpenEXR with the radiance itself.

use std::io::{self, Cursor, Write};
use std::path::{Path, PathBuf};

use exr::image::write::layers::WritableLayers;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image as ExrImage, ImageAttributes,
    IntegerBounds, Layer as ExrLayer, LayerAttributes, SmallVec, SpecificChannels, Vec2 as ExrVec2,
    WritableImage,
};

use super::atomic::{check_writable, write_atomically};
use super::origin::{HASH_KEYWORD, Origin, OriginTexts};
use super::unless::{Unless, check};
use crate::control::CancelToken;
use crate::render::display::{encode_8, encode_16};
use crate::render::{Image, Layer};
use crate::scene::{Display, Output, PngBits, Scene};

/// Why a picture could not be written.
#[derive(Debug, thiserror::Error)]
pub enum ImageFileError {
    /// The name's extension is that of no format that can be written.
    #[error("{}: pictures are written as .png or .exr, by the name's extension", path.display())]
    UnknownFormat {
        /// The name asked for.
        path: PathBuf,
    },
    /// The file could not be written; an old file of that name is as it was.
    #[error("{}: cannot write the picture: {reason}", path.display())]
    Unwritable {
        /// The name asked for.
        path: PathBuf,
        /// What the system said.
        reason: io::Error,
    },
}

/// A format of picture files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Png,
    Exr,
}

/// Says whether `path` has the extension of a format that can be written, and is a place where that can be begun, before work is
/// spent on the picture.
///
/// # Errors
/// An unknown extension, or what the system says.
pub fn check_image_path(path: &Path) -> Result<(), ImageFileError> {
    format_of(path)?;
    check_writable(path).map_err(|reason| unwritable(path, reason))
}

/// Whether the format that `path` is written in holds layers.
#[must_use]
pub fn holds_layers(path: &Path) -> bool {
    matches!(format_of(path), Ok(Format::Exr))
}

/// Writes `image` to `path`, as PNG with `display` applied or as OpenEXR with the radiance and, as channels `NAME.R`, `NAME.G`,
/// `NAME.B`, the `layers`. The extension decides; the file appears whole or not at all.
///
/// # Errors
/// An unknown extension, or what the system says.
pub fn write_image(
    image: &Image,
    layers: &[(Layer, Image)],
    display: &Display,
    output: &Output,
    path: &Path,
) -> Result<(), ImageFileError> {
    let texts = OriginTexts::default();
    let never = CancelToken::new();
    write(image, layers, (display, output), &texts, path, &never).map(|_| ())
}

/// [`write_image`] of a render, as its scene says; the file tells what was rendered, so that it can be opened.
///
/// # Errors
/// Those of [`write_image`].
pub fn write_render(
    image: &Image,
    layers: &[(Layer, Image)],
    origin: &Origin<'_>,
    path: &Path,
) -> Result<(), ImageFileError> {
    write_render_unless(image, layers, origin, path, &CancelToken::new()).map(|_| ())
}

/// [`write_render`], unless it is cancelled, which is `None`: an old file of that name is as it was then.
///
/// # Errors
/// Those of [`write_image`].
pub fn write_render_unless(
    image: &Image,
    layers: &[(Layer, Image)],
    origin: &Origin<'_>,
    path: &Path,
    cancel: &CancelToken,
) -> Result<Option<()>, ImageFileError> {
    let Scene {
        display, output, ..
    } = origin.scene;
    let texts = origin.texts(path);
    write(image, layers, (display, output), &texts, path, cancel)
}

fn write(
    image: &Image,
    layers: &[(Layer, Image)],
    (display, output): (&Display, &Output),
    texts: &OriginTexts<'_>,
    path: &Path,
    cancel: &CancelToken,
) -> Result<Option<()>, ImageFileError> {
    let format = format_of(path)?;
    if cancel.is_cancelled() {
        return Ok(None);
    }
    let written = match format {
        Format::Png => write_atomically(path, |file| {
            let file = Unless {
                cancel,
                inner: file,
            };
            write_png(image, display, *output, texts, file)
        }),
        Format::Exr => exr_bytes(image, layers, texts, cancel).and_then(|bytes| {
            write_atomically(path, |inner| Unless { cancel, inner }.write_all(&bytes))
        }),
    };
    match written {
        Ok(()) => Ok(Some(())),
        // Failing is how the writing ends then.
        Err(_) if cancel.is_cancelled() => Ok(None),
        Err(reason) => Err(unwritable(path, reason)),
    }
}

/// Writes a picture that could not be written to `path` to a new file in the system's folder for temporary files, in the same
/// format, so that it is not lost. Returns that file's name.
///
/// # Errors
/// Those of [`write_image`].
pub fn rescue_render(
    image: &Image,
    layers: &[(Layer, Image)],
    origin: &Origin<'_>,
    path: &Path,
) -> Result<PathBuf, ImageFileError> {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    let folder = std::env::temp_dir();
    let file = tempfile::Builder::new()
        .prefix(&rescue_prefix(path))
        .suffix(&format!(".{extension}"))
        .tempfile_in(&folder)
        .map_err(|reason| unwritable(&folder, reason))?
        .into_temp_path();
    write_render(image, layers, origin, &file)?;
    let kept = file.keep();
    kept.map_err(|error| unwritable(&error.path, error.error))
}

/// How the name begins under which what was meant for `path` is kept elsewhere: short, as the name may be why it is.
#[must_use]
pub fn rescue_prefix(path: &Path) -> String {
    /// Characters, of up to 4 bytes each, of the 255 bytes that most file systems allow.
    const MOST: usize = 40;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let short: String = stem.chars().take(MOST).collect();
    format!("{short}-")
}

fn unwritable(path: &Path, reason: io::Error) -> ImageFileError {
    ImageFileError::Unwritable {
        path: path.to_owned(),
        reason,
    }
}

fn format_of(path: &Path) -> Result<Format, ImageFileError> {
    let extension = path
        .extension()
        .map(|extension| extension.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("png") => Ok(Format::Png),
        Some("exr") => Ok(Format::Exr),
        _ => Err(ImageFileError::UnknownFormat {
            path: path.to_owned(),
        }),
    }
}

fn write_png(
    image: &Image,
    display: &Display,
    output: Output,
    texts: &OriginTexts<'_>,
    file: Unless<'_, &mut dyn Write>,
) -> io::Result<()> {
    let cancel = file.cancel;
    let mut encoder = png::Encoder::new(file, image.width, image.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(match output.png_bits {
        PngBits::Eight => png::BitDepth::Eight,
        PngBits::Sixteen => png::BitDepth::Sixteen,
    });
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.add_text_chunk(
        "Software".to_owned(),
        format!("RayMini {}", env!("CARGO_PKG_VERSION")),
    )?;
    if let Some(hash) = texts.png_hash(image, cancel)? {
        encoder.add_text_chunk(HASH_KEYWORD.to_owned(), hash)?;
    }
    let mut writer = encoder.write_header()?;
    for chunk in texts.png_chunks() {
        writer.write_text_chunk(&chunk)?;
    }
    let mut rows = writer.stream_writer()?;
    for row in image.pixels.chunks_exact(image.width as usize) {
        // Rows of little content are many before a byte of them is written.
        check(cancel)?;
        let encoded: Vec<u8> = match output.png_bits {
            PngBits::Eight => row.iter().flat_map(|&rgb| encode_8(rgb, display)).collect(),
            PngBits::Sixteen => row
                .iter()
                .flat_map(|&rgb| encode_16(rgb, display))
                .flat_map(u16::to_be_bytes)
                .collect(),
        };
        rows.write_all(&encoded)?;
    }
    rows.finish()?;
    Ok(writer.finish()?)
}

fn exr_bytes(
    image: &Image,
    layers: &[(Layer, Image)],
    texts: &OriginTexts<'_>,
    cancel: &CancelToken,
) -> io::Result<Vec<u8>> {
    let size = (image.width as usize, image.height as usize);
    if layers.is_empty() {
        // Read where it is: channels apart would take as much memory again.
        let pixel = |at: ExrVec2<usize>| image.pixels[at.y() * size.0 + at.x()].into();
        let image = exr_image(size, SpecificChannels::rgb(pixel), texts);
        return exr_file(&image, cancel);
    }
    let named = layers
        .iter()
        .map(|(layer, image)| (format!("{}.", layer.name()), image));
    let planes = std::iter::once((String::new(), image)).chain(named);
    let channels: SmallVec<[_; 4]> = planes
        .flat_map(|(prefix, image)| {
            ["R", "G", "B"]
                .into_iter()
                .enumerate()
                .map(move |(axis, color)| {
                    let name = format!("{prefix}{color}");
                    let samples = image.pixels.iter().map(|rgb| rgb[axis]).collect();
                    AnyChannel::new(name.as_str(), FlatSamples::F32(samples))
                })
        })
        .collect();
    let image = exr_image(size, AnyChannels::sort(channels), texts);
    exr_file(&image, cancel)
}

fn exr_image<C>(
    size: (usize, usize),
    channels: C,
    texts: &OriginTexts<'_>,
) -> ExrImage<ExrLayer<C>> {
    ExrImage {
        attributes: ImageAttributes::new(IntegerBounds::from_dimensions(size)),
        layer_data: ExrLayer {
            channel_data: channels,
            attributes: LayerAttributes {
                other: texts.exr_attributes().collect(),
                ..LayerAttributes::default()
            },
            size: size.into(),
            encoding: Encoding::SMALL_LOSSLESS,
        },
    }
}

/// The bytes of the file.
fn exr_file<'a, L: WritableLayers<'a>>(
    image: &'a ExrImage<L>,
    cancel: &CancelToken,
) -> io::Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    let inner = &mut bytes;
    image
        .write()
        .to_buffered(Unless { cancel, inner })
        .map_err(|error| io::Error::other(error.to_string()))?;
    let mut bytes = bytes.into_inner();
    sort_attributes(&mut bytes);
    Ok(bytes)
}

/// Puts the attributes of an OpenEXR file of one part into the order of their names: the library writes them in a random one, and the same
/// picture is to be the same file.
///
/// Source: The OpenEXR file layout: after eight bytes, attributes of name, type, each ended by a zero, length in four bytes, and value, up to
/// one without a name.
fn sort_attributes(file: &mut [u8]) {
    let Some(header) = file.get_mut(8..) else {
        return;
    };
    let mut attributes: Vec<Vec<u8>> = Vec::new();
    let mut end = 0;
    while let Some(length) = attribute_length(&header[end..]) {
        attributes.push(header[end..end + length].to_vec());
        end += length;
    }
    // Each begins with its name and a zero.
    attributes.sort();
    header[..end].copy_from_slice(&attributes.concat());
}

/// The bytes of the attribute that `bytes` begin with, where there is one.
fn attribute_length(bytes: &[u8]) -> Option<usize> {
    let mut texts = bytes.splitn(3, |&byte| byte == 0);
    let name = texts.next().filter(|name| !name.is_empty())?;
    let (kind, rest) = (texts.next()?, texts.next()?);
    let length = u32::from_le_bytes(*rest.first_chunk()?);
    let all = name.len() + kind.len() + 6 + usize::try_from(length).ok()?;
    (all <= bytes.len()).then_some(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::{Values, WrittenError, read_image};
    use crate::render::Region;

    fn gradient() -> Image {
        let pixels = (0..35)
            .map(|i| [i as f32 / 34.0, 2.0 - i as f32 * 1e-3, 1e-20 * i as f32])
            .collect();
        Image {
            width: 7,
            height: 5,
            pixels,
        }
    }

    fn written(extension: &str, output: Output) -> tempfile::TempPath {
        let path = tempfile::Builder::new()
            .suffix(extension)
            .tempfile()
            .expect("a file")
            .into_temp_path();
        write_image(&gradient(), &[], &Display::default(), &output, &path).expect("is written");
        path
    }

    /// Whatever order the library writes attributes in: sixteen files would be alike by chance once in 6¹⁵ times.
    #[test]
    fn the_same_picture_is_the_same_openexr_file() {
        let region = Region {
            x: 1,
            y: 2,
            width: 7,
            height: 5,
        };
        let error = WrittenError {
            rmse: 0.1,
            relmse: 0.2,
            samples_per_pixel: 3.0,
        };
        let origin = Origin {
            scene: &Scene::default(),
            error: Some(error),
            region: Some(region),
            values: Values::Rendered,
        };
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("same.exr");
        let file = || {
            write_render(&gradient(), &[], &origin, &path).expect("is written");
            std::fs::read(&path).expect("is there")
        };
        let first = file();
        let read = read_image(&path).expect("can be read");
        assert_eq!(read.image, gradient());
        for _ in 1..16 {
            assert!(file() == first);
        }
    }

    #[test]
    fn png_holds_the_display_values_and_the_hash() {
        for (png_bits, depth) in [
            (PngBits::Eight, png::BitDepth::Eight),
            (PngBits::Sixteen, png::BitDepth::Sixteen),
        ] {
            let path = written(
                ".png",
                Output {
                    png_bits,
                    ..Output::default()
                },
            );
            let decoder = png::Decoder::new(io::BufReader::new(
                std::fs::File::open(&path).expect("exists"),
            ));
            let mut reader = decoder.read_info().expect("is a PNG");
            assert_eq!(
                (
                    reader.info().width,
                    reader.info().height,
                    reader.info().bit_depth
                ),
                (7, 5, depth)
            );
            let text = &reader.info().uncompressed_latin1_text;
            assert!(
                text.iter()
                    .any(|chunk| chunk.keyword == HASH_KEYWORD && chunk.text == gradient().hash())
            );
            let mut pixels = vec![0; reader.output_buffer_size().expect("fits")];
            reader.next_frame(&mut pixels).expect("has a frame");
            let last = gradient().pixels[34];
            match png_bits {
                PngBits::Eight => assert_eq!(pixels[34 * 3..], encode_8(last, &Display::default())),
                PngBits::Sixteen => {
                    let expected: Vec<u8> = encode_16(last, &Display::default())
                        .into_iter()
                        .flat_map(u16::to_be_bytes)
                        .collect();
                    assert_eq!(pixels[34 * 6..], expected);
                }
            }
        }
    }

    #[test]
    fn exr_holds_the_radiance_bit_for_bit() {
        let path = written(".exr", Output::default());
        let image = exr::prelude::read_first_rgba_layer_from_file(
            &path,
            |size, _| Image {
                width: u32::try_from(size.0).expect("small"),
                height: u32::try_from(size.1).expect("small"),
                pixels: vec![[0.0; 3]; size.area()],
            },
            |image, position, (r, g, b, _): (f32, f32, f32, f32)| {
                let index = position.y() * image.width as usize + position.x();
                image.pixels[index] = [r, g, b];
            },
        )
        .expect("is an EXR");
        assert_eq!(
            image.layer_data.channel_data.pixels.hash(),
            gradient().hash()
        );
    }

    /// A file that is cancelled by what is written to it.
    struct CancelledByWriting<'a>(&'a CancelToken);

    impl Write for CancelledByWriting<'_> {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.cancel();
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_cancelled_picture_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let scene = Scene::default();
        let origin = Origin {
            scene: &scene,
            error: None,
            region: None,
            values: Values::Rendered,
        };
        let cancelled = CancelToken::new();
        cancelled.cancel();
        for name in ["picture.png", "picture.exr"] {
            let path = folder.path().join(name);
            std::fs::write(&path, "old").expect("written");
            let written = write_render_unless(&gradient(), &[], &origin, &path, &cancelled);
            assert_eq!(written.expect("no failure"), None, "{name}");
            let there = std::fs::read_to_string(&path).expect("a file");
            assert_eq!(there, "old");
        }
        let files = std::fs::read_dir(folder.path()).expect("a folder");
        assert_eq!(files.count(), 2);

        // In the middle, writing ends.
        let texts = OriginTexts::default();
        let cancel = CancelToken::new();
        let mut inner = CancelledByWriting(&cancel);
        let file = Unless {
            cancel: &cancel,
            inner: &mut inner as &mut dyn Write,
        };
        let (display, output) = (Display::default(), Output::default());
        assert!(write_png(&gradient(), &display, output, &texts, file).is_err());
        assert!(exr_bytes(&gradient(), &[], &texts, &cancel).is_err());
    }

    #[test]
    fn what_has_a_long_name_is_kept_under_a_short_one() {
        let scene = Scene::default();
        let origin = Origin {
            scene: &scene,
            error: None,
            region: None,
            values: Values::Rendered,
        };
        for name in ["a".repeat(250), "\u{1f40f}".repeat(80)] {
            let path = Path::new("none").join(format!("{name}.exr"));
            let kept = rescue_render(&gradient(), &[], &origin, &path).expect("is kept");
            let is_there = kept.is_file();
            std::fs::remove_file(&kept).expect("is removed");
            assert!(is_there && holds_layers(&kept));
            assert_eq!(rescue_prefix(&path).chars().count(), 41);
        }
        assert_eq!(rescue_prefix(Path::new("a/full.exr")), "full-");
    }

    #[test]
    fn an_unknown_extension_is_refused_by_name() {
        let error = write_image(
            &gradient(),
            &[],
            &Display::default(),
            &Output::default(),
            Path::new("out.jpg"),
        );
        assert_eq!(
            error.expect_err("is refused").to_string(),
            "out.jpg: pictures are written as .png or .exr, by the name's extension"
        );
    }
}
