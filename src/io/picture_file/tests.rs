use super::*;
use crate::io::{random_edits, write_image};
use crate::scene::{Display, Output, PngBits};

/// Palette of 2 bits: black, (255, 0, 10), (188, 128, 255); a row of its numbers 2, 0, 1, 2. Made with zlib, by no PNG library.
const PALETTE: &[u8] = b"\x89PNG\x0d\x0a\x1a\x0a\x00\x00\x00\x0dIHDR\x00\x00\x00\x04\x00\x00\x00\x01\x02\x03\x00\x00\x00\x84R\xe7^\
\x00\x00\x00\x09PLTE\x00\x00\x00\xff\x00\x0a\xbc\x80\xff\xd2\xdf\xd2\xda\
\x00\x00\x00\x0aIDATx\xdach\x03\x00\x00\x88\x00\x87\xb8%Zv\x00\x00\x00\x00IEND\xaeB`\x82";

/// Grey, 8 bits, interlaced: rows (10, 188) and (128, 255). Made likewise.
const INTERLACED: &[u8] = b"\x89PNG\x0d\x0a\x1a\x0a\x00\x00\x00\x0dIHDR\x00\x00\x00\x02\x00\x00\x00\x02\x08\x00\x00\x00\x01 \xdabn\
\x00\x00\x00\x0fIDATx\xdac\xe0b\xd8\xc3\xd0\xf0\x1f\x00\x052\x02F\x92\xb7\x0c\xb6\x00\x00\x00\x00IEND\xaeB`\x82";

/// RGBA, 16 bits, with a gamma of 1: (0, 32768, 65535, 65535), (48316, 2570, 257, 30000). Made likewise.
const DEEP: &[u8] = b"\x89PNG\x0d\x0a\x1a\x0a\x00\x00\x00\x0dIHDR\x00\x00\x00\x02\x00\x00\x00\x01\x10\x06\x00\x00\x00\xa4\xb2\xa3\xc9\
\x00\x00\x00\x04gAMA\x00\x01\x86\xa01\xe8\x96_\
\x00\x00\x00\x18IDATx\xdacd`h`\xf8\x0f\x04{\xf6tq11\x95\x19\x02\x00@\x95\x075\x0a\x9a\x99\xbd\x00\x00\x00\x00IEND\xaeB`\x82";

/// Codes of 8 bits in linear light, by the formula of IEC 61966-2-1 in `f64`.
const LINEAR_1: f32 = 3.035_27e-4;
const LINEAR_10: f32 = 3.035_27e-3;
const LINEAR_128: f32 = 0.215_860_5;
const LINEAR_188: f32 = 0.502_886_5;

fn parse(bytes: &[u8]) -> Result<PictureFile, String> {
    parse_image("a", bytes).map_err(|error| error.reason)
}

fn assert_near(file: &PictureFile, expected: &[[f32; 3]]) {
    assert_eq!(file.image.pixels.len(), expected.len());
    for (found, expected) in file.image.pixels.iter().zip(expected) {
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() <= 1e-6 * expected, "{file:?}");
        }
    }
}

#[test]
fn png_by_others_is_read_in_every_layout() {
    let palette = parse(PALETTE).expect("is right");
    let last = [LINEAR_188, LINEAR_128, 1.0];
    assert_near(&palette, &[last, [0.0; 3], [1.0, 0.0, LINEAR_10], last]);
    assert_eq!((palette.format, palette.warnings.len()), ("PNG", 0));

    let grey = parse(INTERLACED).expect("is right");
    let codes = [LINEAR_10, LINEAR_188, LINEAR_128, 1.0];
    assert_near(&grey, &codes.map(|value| [value; 3]));
    assert_eq!((grey.image.width, grey.image.height), (2, 2));

    let deep = parse(DEEP).expect("is right");
    let half = 0.214_048_2;
    assert_near(
        &deep,
        &[[0.0, half, 1.0], [LINEAR_188, LINEAR_10, LINEAR_1]],
    );
    assert_eq!(
        deep.warnings,
        [
            "the file names another gamma, which is not applied: its values are taken as sRGB",
            "some pixels are not opaque; their colours are taken as written"
        ]
    );
}

/// Each kind of pixel, as the `image` crate writes it.
#[test]
fn png_is_read_in_every_pixel_type() {
    use image::DynamicImage;
    let expected = [LINEAR_188, LINEAR_128, LINEAR_10];
    let (rgb, wide) = ([188, 128, 10], [188 * 257, 128 * 257, 10 * 257_u16]);
    let with_alpha = |[r, g, b]: [u8; 3]| [r, g, b, 255];
    let with_wide_alpha = |[r, g, b]: [u16; 3]| [r, g, b, u16::MAX];
    for (picture, expected) in [
        (
            DynamicImage::ImageRgb8(image::RgbImage::from_pixel(3, 2, image::Rgb(rgb))),
            expected,
        ),
        (
            DynamicImage::ImageRgba8(image::RgbaImage::from_pixel(
                3,
                2,
                image::Rgba(with_alpha(rgb)),
            )),
            expected,
        ),
        (
            DynamicImage::ImageRgb16(image::ImageBuffer::from_pixel(3, 2, image::Rgb(wide))),
            expected,
        ),
        (
            DynamicImage::ImageRgba16(image::ImageBuffer::from_pixel(
                3,
                2,
                image::Rgba(with_wide_alpha(wide)),
            )),
            expected,
        ),
        (
            DynamicImage::ImageLuma8(image::GrayImage::from_pixel(3, 2, image::Luma([188]))),
            [LINEAR_188; 3],
        ),
        (
            DynamicImage::ImageLumaA16(image::ImageBuffer::from_pixel(
                3,
                2,
                image::LumaA([128 * 257, u16::MAX]),
            )),
            [LINEAR_128; 3],
        ),
    ] {
        let mut bytes = Cursor::new(Vec::new());
        picture
            .write_to(&mut bytes, image::ImageFormat::Png)
            .expect("is written");
        let file = parse(bytes.get_ref()).expect("is right");
        assert_eq!((file.image.width, file.image.height), (3, 2));
        assert_near(&file, &[expected; 6]);
        assert_eq!(file.warnings, Vec::<String>::new());
    }
}

/// What the program writes comes back: every code of 8 bits, and codes of 16 bits from the whole range.
#[test]
fn png_round_trips_to_the_same_codes() {
    let folder = tempfile::tempdir().expect("a folder");
    for (png_bits, step) in [(PngBits::Eight, 257), (PngBits::Sixteen, 251)] {
        let values = (0..=u16::MAX).step_by(step);
        let pixels: Vec<[f32; 3]> = values
            .map(|code| [linear_from_srgb(f32::from(code) / 65_535.0); 3])
            .collect();
        let image = Image {
            width: u32::try_from(pixels.len()).expect("few"),
            height: 1,
            pixels,
        };
        let path = folder.path().join("a.png");
        let output = Output {
            png_bits,
            ..Output::default()
        };
        write_image(&image, &[], &Display::default(), &output, &path).expect("is written");
        let file = read_image(&path).expect("is right");
        assert_eq!(file.image.hash(), image.hash(), "{png_bits:?}");
    }
}

#[test]
fn exr_round_trips_bit_for_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.exr");
    let image = Image {
        width: 1,
        height: 3,
        pixels: vec![
            [f32::NAN, -0.0, 1e-40],
            [f32::INFINITY, f32::NEG_INFINITY, -3.5],
            [f32::MAX, 0.1, 1e30],
        ],
    };
    write_image(&image, &[], &Display::default(), &Output::default(), &path).expect("is written");
    let file = read_image(&path).expect("is right");
    assert_eq!(file.image.hash(), image.hash());
    assert_eq!((file.format, file.warnings.len()), ("OpenEXR", 0));
}

/// An uncompressed OpenEXR file put together from the specification: 2×2 pixels away from the origin, the channels of 16-bit
/// float, 32-bit whole and 32-bit float numbers.
fn plain_exr(names: [&str; 3]) -> Vec<u8> {
    let mut channels = Vec::new();
    for (name, kind) in names.iter().zip([1_u32, 0, 2]) {
        channels.extend(name.as_bytes());
        channels.push(0);
        for number in [kind, 0, 1, 1] {
            channels.extend(number.to_le_bytes());
        }
    }
    channels.push(0);
    let window: Vec<u8> = [5_i32, -3, 6, -2]
        .iter()
        .flat_map(|corner| corner.to_le_bytes())
        .collect();

    let mut bytes = b"\x76\x2f\x31\x01\x02\0\0\0".to_vec();
    for (name, value) in [
        ("channels\0chlist", &channels[..]),
        ("compression\0compression", &[0]),
        ("dataWindow\0box2i", &window),
        ("displayWindow\0box2i", &window),
        ("lineOrder\0lineOrder", &[0]),
        ("pixelAspectRatio\0float", &1_f32.to_le_bytes()),
        ("screenWindowCenter\0v2f", &[0; 8]),
        ("screenWindowWidth\0float", &1_f32.to_le_bytes()),
    ] {
        bytes.extend(name.as_bytes());
        bytes.push(0);
        bytes.extend(u32::try_from(value.len()).expect("short").to_le_bytes());
        bytes.extend(value);
    }
    bytes.push(0);
    // A table of where each row is, then the rows: number, length, and the channels one after the other.
    let row_bytes = 2 * (2 + 4 + 4);
    let first = bytes.len() as u64 + 16;
    for row in 0..2 {
        bytes.extend((first + row * (8 + row_bytes)).to_le_bytes());
    }
    for row in 0..2_u16 {
        bytes.extend((i32::from(row) - 3).to_le_bytes());
        bytes.extend(20_u32.to_le_bytes());
        // Of 16 bits: 1, 1.5 and 2, 3 by sign, exponent and fraction.
        let halves = [[0x3c00_u16, 0x3e00], [0x4000, 0x4200]][usize::from(row)];
        bytes.extend(halves.iter().flat_map(|half| half.to_le_bytes()));
        let whole = [7_u32, 100_000 + u32::from(row)];
        bytes.extend(whole.iter().flat_map(|number| number.to_le_bytes()));
        let float = [-0.25_f32, 1e30];
        bytes.extend(float.iter().flat_map(|number| number.to_le_bytes()));
    }
    bytes
}

#[test]
fn exr_by_others_is_read_in_every_sample_type_and_naming() {
    for names in [
        ["B", "G", "R"],
        ["View.Combined.B", "View.Combined.G", "View.Combined.R"],
        ["rgba.b", "rgba.g", "rgba.r"],
    ] {
        let file = parse(&plain_exr(names)).expect("is right");
        assert_eq!((file.image.width, file.image.height), (2, 2));
        assert_eq!(
            file.image.pixels,
            [
                [-0.25, 7.0, 1.0],
                [1e30, 100_000.0, 1.5],
                [-0.25, 7.0, 2.0],
                [1e30, 100_001.0, 3.0],
            ],
            "{names:?}"
        );
        assert_eq!(file.warnings, Vec::<String>::new());
    }
    let grey = parse(&plain_exr(["A", "Y", "Z"])).expect("is right");
    assert_eq!(grey.image.pixels[3], [100_001.0; 3]);
    let none = parse(&plain_exr(["U", "V", "X"])).expect_err("has no colour");
    assert!(
        none.starts_with("the file has the channels U, V, X; expected"),
        "{none}"
    );
}

/// A picture of 5 × 4 pixels that no other looks like.
fn numbered(seed: u8) -> Image {
    let pixels = (0..20).map(|i| [f32::from(seed), i as f32, -0.125 * i as f32]);
    Image {
        width: 5,
        height: 4,
        pixels: pixels.collect(),
    }
}

#[test]
fn layers_are_read_as_they_were_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let written = |name: &str, layers: &[(Layer, Image)]| {
        let path = folder.path().join(name);
        let (display, output) = (Display::default(), Output::default());
        write_image(&numbered(0), layers, &display, &output, &path).expect("is written");
        path
    };
    let read = |path: &Path, cancel: &CancelToken| {
        let progress = Progress::new();
        let render = read_render(path, cancel, &progress).expect("is right")?;
        let length = std::fs::metadata(path).expect("exists").len();
        assert_eq!(progress.done(), 2 * length, "read once, understood once");
        assert_eq!(read_image(path).expect("is right"), render.picture);
        Some(render.layers.expect("there is room"))
    };
    let layers = [
        (Layer::Refraction, numbered(1)),
        (Layer::Emission, numbered(2)),
        (Layer::Error, numbered(3)),
    ];
    let path = written("layers.exr", &layers);
    let found = read(&path, &CancelToken::new()).expect("nobody cancels");
    let in_order = [1, 0, 2].map(|place| layers[place].clone());
    assert_eq!(found, in_order);
    assert_eq!(read_image(&path).expect("is right").image, numbered(0));

    for plain in [written("plain.exr", &[]), written("plain.png", &layers)] {
        assert_eq!(read(&plain, &CancelToken::new()), Some(Vec::new()));
    }
    let cancelled = CancelToken::new();
    cancelled.cancel();
    assert_eq!(read(&path, &cancelled), None);
    assert_eq!(
        read_image_unless(&path, &cancelled, &Progress::new()),
        Ok(None)
    );
    let missing = read_render(Path::new("/nowhere/a.exr"), &cancelled, &Progress::new());
    assert_eq!(
        missing.expect_err("is not there").to_string(),
        "/nowhere/a.exr: there is no such file"
    );
}

/// Channels of another program that are called like a layer but are no colours.
#[test]
fn what_is_called_like_a_layer_and_has_no_three_colors_is_none() {
    let read = |names: [&str; 3]| {
        let render = parse_render("a", &plain_exr(names)).expect("is right");
        render.layers.expect("there is room")
    };
    assert!(read(["G", "emission.B", "emission.G"]).is_empty());
    let whole = read(["emission.B", "emission.G", "emission.R"]);
    let [(Layer::Emission, image)] = &whole[..] else {
        panic!("{whole:?}");
    };
    assert_eq!(image.pixels[0], [-0.25, 7.0, 1.0]);
}

#[test]
fn radiance_hdr_is_read() {
    let mut bytes = Vec::new();
    // Values that 8 bits and a common exponent hold.
    let pixels = [[1.0, 0.5, 0.25], [96.0, 3.0, 0.0]];
    image::codecs::hdr::HdrEncoder::new(&mut bytes)
        .encode(&pixels.map(image::Rgb), 1, 2)
        .expect("is written");
    let file = parse(&bytes).expect("is right");
    assert_eq!((file.image.width, file.image.height), (1, 2));
    assert_eq!(file.format, "Radiance HDR");
    assert_near(&file, &pixels);
}

#[test]
fn what_is_no_picture_is_refused_by_name() {
    for (bytes, expected) in [
        (&b""[..], "the file is empty"),
        (b"GIF89a", "this is not a known kind of image; expected PNG"),
        (
            b"\xff\xd8\xff\xe0",
            "this is a JPEG picture; expected PNG (.png), OpenEXR (.exr) and Radiance HDR (.hdr)",
        ),
        (b"\x89PNG\r\n", "not a whole PNG file: "),
    ] {
        let found = parse(bytes).expect_err("is refused");
        assert!(found.starts_with(expected), "{found}");
    }
    let missing = read_image(Path::new("/nowhere/a.png")).expect_err("is not there");
    assert_eq!(missing.to_string(), "/nowhere/a.png: there is no such file");
    let folder = tempfile::tempdir().expect("a folder");
    let error = read_image(folder.path()).expect_err("is a folder");
    assert_eq!(error.reason, "this is a folder, a picture was expected");
}

/// The check of PNG chunks, bit by bit.
fn crc(bytes: &[u8]) -> u32 {
    let mut crc = u32::MAX;
    for &byte in bytes {
        crc ^= u32::from(byte);
        for _ in 0..8 {
            crc = (crc >> 1) ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 };
        }
    }
    !crc
}

/// A header may claim what it likes: memory is taken for what the file can hold.
#[test]
fn forged_png_sizes_are_refused_before_they_are_believed() {
    for ((width, height), expected) in [
        ((16_384_u32, 16_384_u32), "the file is too short: 72 bytes"),
        ((1, 30_000), "not a whole PNG file: "),
        ((70_000, 1), "the image is said to be 70000×1; expected"),
        ((60_000, 60_000), "the image is said to be 60000×60000"),
        ((0x7fff_ffff, 0x7fff_ffff), "not a whole PNG file: "),
        ((u32::MAX, u32::MAX), "not a whole PNG file: "),
        ((0, 4), "not a whole PNG file: "),
    ] {
        let mut forged = INTERLACED.to_vec();
        forged[16..20].copy_from_slice(&width.to_be_bytes());
        forged[20..24].copy_from_slice(&height.to_be_bytes());
        let check = crc(&forged[12..29]);
        forged[29..33].copy_from_slice(&check.to_be_bytes());
        let found = parse(&forged).expect_err("is refused");
        assert!(found.starts_with(expected), "{width}×{height}: {found}");
    }
}

#[test]
fn truncated_files_are_errors() {
    let exr = plain_exr(["B", "G", "R"]);
    for bytes in [PALETTE, INTERLACED, DEEP, &exr] {
        for length in 0..bytes.len() {
            assert!(
                parse(&bytes[..length]).is_err(),
                "{length} of {}",
                bytes.len()
            );
        }
    }
}

#[test]
fn random_edits_never_panic() {
    let exr = plain_exr(["B", "G", "R"]);
    random_edits::for_each(&[PALETTE, INTERLACED, DEEP, &exr], 2000, |mut bytes| {
        // A header that is wrong in itself but not in its check reaches further.
        if bytes.len() > 33 && bytes.starts_with(b"\x89PNG") {
            let check = crc(&bytes[12..29]);
            bytes[29..33].copy_from_slice(&check.to_be_bytes());
        }
        let _ = parse(&bytes);
    });
}
