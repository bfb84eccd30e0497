use std::io::Cursor;

use ::exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image as ExrImage,
    ImageAttributes, IntegerBounds, Layer, LayerAttributes, LineOrder, Vec2, WritableImage, f16,
};

use super::*;
use crate::io::random_edits;
use crate::render::Image;
use crate::scene::{Display, Output};

const SIZE: (u32, u32) = (24, 12);

/// Values that 16 bits hold exactly.
fn value(x: usize, y: usize) -> [f32; 3] {
    [x as f32, 0.25 * y as f32, 100.0 + (x * y) as f32]
}

fn expected() -> Vec<[f32; 3]> {
    let (width, height) = (SIZE.0 as usize, SIZE.1 as usize);
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    pixels.map(|(x, y)| value(x, y)).collect()
}

fn parse(bytes: &[u8]) -> Result<RadianceFile, String> {
    let parsed = super::parse(bytes, &CancelToken::new(), &Progress::new());
    parsed.map(|file| file.expect("nobody cancels"))
}

/// The bytes of an OpenEXR file.
fn exr_bytes(image: &ExrImage<Layer<AnyChannels<FlatSamples>>>) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    image.write().to_buffered(&mut file).expect("is written");
    file.into_inner()
}

/// An OpenEXR file of these channels, in alphabetical order.
fn with_channels(channels: &[(&str, FlatSamples)], encoding: Encoding) -> Vec<u8> {
    let channels = channels.iter();
    let list = channels.map(|(name, samples)| AnyChannel::new(*name, samples.clone()));
    exr_bytes(&ExrImage::from_layer(Layer::new(
        (SIZE.0 as usize, SIZE.1 as usize),
        LayerAttributes::named("sky"),
        encoding,
        AnyChannels::sort(list.collect()),
    )))
}

fn channel(index: usize) -> FlatSamples {
    FlatSamples::F32(expected().iter().map(|pixel| pixel[index]).collect())
}

fn rgb_exr(compression: Compression, blocks: Blocks) -> Vec<u8> {
    let encoding = Encoding {
        compression,
        blocks,
        line_order: LineOrder::Increasing,
    };
    let channels = [
        ("A", channel(0)),
        ("B", channel(2)),
        ("G", channel(1)),
        ("R", channel(0)),
    ];
    with_channels(&channels, encoding)
}

fn hdr_bytes(pixels: &[[f32; 3]], (width, height): (u32, u32)) -> Vec<u8> {
    let mut bytes = Vec::new();
    let pixels: Vec<_> = pixels.iter().map(|&p| image::Rgb(p)).collect();
    image::codecs::hdr::HdrEncoder::new(&mut bytes)
        .encode(&pixels, width as usize, height as usize)
        .expect("is written");
    bytes
}

#[test]
fn openexr_is_read_in_every_lossless_compression_and_block_shape() {
    let tiles = Blocks::Tiles(Vec2(7, 5));
    for compression in [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
    ] {
        for blocks in [Blocks::ScanLines, tiles] {
            let file = parse(&rgb_exr(compression, blocks)).expect("is right");
            assert_eq!((file.format, file.cleaned), ("OpenEXR", 0));
            assert_eq!(file.map.pixels(), expected(), "{compression:?} {blocks:?}");
            assert_eq!(file.warnings, Vec::<String>::new());
        }
    }
}

#[test]
fn openexr_is_read_in_every_sample_type() {
    let half = |i: usize| {
        let values = expected().into_iter().map(|pixel| f16::from_f32(pixel[i]));
        FlatSamples::F16(values.collect())
    };
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "whole numbers of a hundred"
    )]
    let whole = FlatSamples::U32(expected().iter().map(|pixel| pixel[0] as u32).collect());
    let channels = [("B", half(2)), ("G", channel(1)), ("R", whole)];
    let file = parse(&with_channels(&channels, Encoding::FAST_LOSSLESS)).expect("is right");
    assert_eq!(file.map.pixels(), expected());
}

#[test]
fn luminance_is_grey_and_missing_colours_are_said() {
    let only =
        |channels: &[(&str, FlatSamples)]| parse(&with_channels(channels, Encoding::FAST_LOSSLESS));
    let grey = only(&[("Y", channel(2)), ("Z", channel(0))]).expect("is right");
    assert_eq!(grey.map.row(2)[3], [106.0; 3]);
    let red = only(&[("R", channel(2)), ("Y", channel(1))]).expect("is right");
    assert_eq!(red.map.row(2)[3], [106.0, 0.0, 0.0]);
    let missing = |name| format!("there is no {name} channel; it is taken as 0");
    assert_eq!(red.warnings, ["green", "blue"].map(missing));
    let none = only(&[("A", channel(0)), ("depth", channel(1))]);
    assert_eq!(
        none.expect_err("has no colour"),
        "the file has the channels A, depth; expected R, G and B, or Y, of a flat layer"
    );
}

/// Programs that name every channel, and whose first picture by the alphabet is another.
#[test]
fn openexr_with_names_before_the_colours_is_read() {
    let of = |pictures: &[(&'static str, [&'static str; 3])]| {
        let names: Vec<(String, usize)> = pictures
            .iter()
            .flat_map(|(prefix, colors)| (0..3).map(move |i| (format!("{prefix}{}", colors[i]), i)))
            .collect();
        let channels: Vec<_> = names
            .iter()
            .map(|(name, index)| (name.as_str(), channel(*index)))
            .collect();
        parse(&with_channels(&channels, Encoding::FAST_LOSSLESS))
    };
    // Red and blue of the others are swapped, to tell them apart.
    let (right, swapped) = (["R", "G", "B"], ["B", "G", "R"]);
    for (pictures, warning) in [
        (vec![("", ["r", "g", "b"])], None),
        (vec![("View.Any.", right)], None),
        (vec![("", right), ("Beauty.", swapped)], None),
        (
            vec![("View.AO.", swapped), ("View.Combined.", right)],
            Some("the file holds several pictures; View.Combined is read, not View.AO"),
        ),
        (
            vec![("one.", right), ("two.", swapped)],
            Some("the file holds several pictures; one is read, not two"),
        ),
    ] {
        let file = of(&pictures).expect("is right");
        assert_eq!(file.map.pixels(), expected(), "{pictures:?}");
        assert!(file.warnings.iter().map(String::as_str).eq(warning));
    }
    let normals = of(&[("N.", ["X", "Y", "Z"])]).expect_err("has no colour");
    assert!(normals.starts_with("the file has the channels N.X, N.Y, N.Z;"));
}

/// Blocks of pixels that say that they are of the other layer, whose channels are others, and every other byte that is wrong.
#[test]
fn a_block_of_another_layer_is_no_block_of_this_one() {
    let layer = |name: &str, names: &[&str]| {
        let list = names
            .iter()
            .map(|&name| AnyChannel::new(name, FlatSamples::F32(vec![0.5; 8])));
        Layer::new(
            (2, 4),
            LayerAttributes::named(name),
            Encoding::UNCOMPRESSED,
            AnyChannels::sort(list.collect()),
        )
    };
    let image = ExrImage::from_layers(
        ImageAttributes::new(IntegerBounds::from_dimensions((2, 4))),
        vec![
            layer("color", &["B", "G", "R"]),
            layer("more", &["A", "R", "U", "V", "Z"]),
        ],
    );
    let mut file = Cursor::new(Vec::new());
    image.write().to_buffered(&mut file).expect("is written");
    let whole = file.into_inner();
    assert_eq!(parse(&whole).expect("is right").map.pixels(), [[0.5; 3]; 8]);
    let mut others = 0;
    for at in 0..whole.len() {
        for changed in [0, 1] {
            let mut bytes = whole.clone();
            bytes[at] = changed;
            let pixels = parse(&bytes).map(|file| file.map.pixels().to_vec());
            others += usize::from(pixels.is_ok_and(|pixels| pixels != [[0.5; 3]; 8]));
        }
    }
    assert!(others > 0, "some of it is seen");
}

/// A picture saved by the program is a background, bit for bit.
#[test]
fn a_rendered_picture_can_be_a_background() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("sky.exr");
    let image = Image {
        width: SIZE.0,
        height: SIZE.1,
        pixels: expected(),
    };
    let (display, output) = (Display::default(), Output::default());
    crate::io::write_image(&image, &[], &display, &output, &path).expect("is written");
    let progress = Progress::new();
    let file = load_radiance(&path, &CancelToken::new(), &progress);
    let file = file.expect("is right").expect("nobody cancels");
    assert_eq!(file.map.pixels(), expected());
    let length = std::fs::metadata(&path).expect("exists").len();
    assert_eq!(progress.done(), 2 * length);
    let cancelled = CancelToken::new();
    cancelled.cancel();
    assert_eq!(load_radiance(&path, &cancelled, &progress), Ok(None));
}

#[test]
fn radiance_hdr_is_read_with_its_exposure_undone() {
    let bytes = hdr_bytes(&expected(), SIZE);
    let file = parse(&bytes).expect("is right");
    assert_eq!(file.format, "Radiance HDR");
    let near = |found: &[f32; 3], expected: &[f32; 3], factor: f32| {
        let largest = expected.iter().fold(0.0_f32, |a, &b| a.max(b));
        (0..3).all(|i| (found[i] * factor - expected[i]).abs() <= largest / 128.0)
    };
    let pairs = file.map.pixels().iter().zip(expected());
    assert!(
        pairs
            .clone()
            .all(|(found, expected)| near(found, &expected, 1.0))
    );

    let text = String::from_utf8_lossy(&bytes).into_owned();
    let header = text.find('\n').expect("a first line") + 1;
    let mut exposed = b"#?RGBE\nEXPOSURE=4\nEXPOSURE=0.5\nCOLORCORR=1 1 1\n".to_vec();
    exposed.extend(&bytes[header..]);
    let brighter = parse(&exposed).expect("is right");
    let pairs = brighter.map.pixels().iter().zip(expected());
    assert!(
        pairs
            .clone()
            .all(|(found, expected)| near(found, &expected, 2.0))
    );
}

#[test]
fn what_is_no_radiance_is_cleaned_and_said() {
    let mut red = vec![1.0; 8];
    red[2] = f32::NAN;
    red[3] = -2.0;
    red[5] = f32::INFINITY;
    let layer = Layer::new(
        (2, 4),
        LayerAttributes::named("sky"),
        Encoding::UNCOMPRESSED,
        AnyChannels::sort(std::iter::once(AnyChannel::new("Y", FlatSamples::F32(red))).collect()),
    );
    let file = parse(&exr_bytes(&ExrImage::from_layer(layer))).expect("is right");
    assert_eq!(file.cleaned, 3);
    let expected =
        "in 3 of 8 pixels a value is negative, infinite or not a number; it is taken as 0";
    assert_eq!(file.warnings, [expected]);
    let said = crate::io::image_warnings("sky", &file);
    assert!(said[0].starts_with("sky: in 3 of 8") && said[1].starts_with("sky: the image is 2×4;"));
    assert_eq!(file.map.row(1), [[0.0; 3]; 2]);
}

#[test]
fn other_files_are_refused_by_name() {
    let cases: [(&[u8], &str); 4] = [
        (b"", "the file is empty"),
        (b"\x89PNG\r\n", "this is a PNG picture; expected OpenEXR"),
        (
            b"\xff\xd8\xff\xe0",
            "this is a JPEG picture; expected OpenEXR",
        ),
        (
            b"OFF\n",
            "this is not a known kind of image; expected OpenEXR (.exr) and",
        ),
    ];
    for (bytes, expected) in cases {
        let found = parse(bytes).expect_err("is refused");
        assert!(found.starts_with(expected), "{found}");
    }
    let missing = load_radiance(
        Path::new("/nowhere/sky.exr"),
        &CancelToken::new(),
        &Progress::new(),
    );
    assert_eq!(
        missing.expect_err("is not there").to_string(),
        "/nowhere/sky.exr: there is no such file"
    );
}

/// Sizes that a header claims and the file cannot mean.
#[test]
fn forged_sizes_are_refused_before_they_are_believed() {
    for (line, expected) in [
        (
            "-Y 0 +X 4",
            "the image is said to be 4×0; expected sides of 1 to",
        ),
        ("-Y 70000 +X 4", "the image is said to be 4×70000; expected"),
        (
            "-Y 60000 +X 60000",
            "the image is said to be 60000×60000; expected",
        ),
        (
            "-Y 4294967295 +X 4294967295",
            "not a whole Radiance HDR file",
        ),
        ("-Y 2000 +X 60000", "the file is too short"),
        ("-Y 1 +X 60000", "the file is too short"),
        ("+Y 4 +X 4", "not a whole Radiance HDR file"),
        ("-Y -4 +X 4", "not a whole Radiance HDR file"),
    ] {
        let text = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{line}\n");
        let found = parse(text.as_bytes()).expect_err("is refused");
        assert!(found.starts_with(expected), "{line}: {found}");
    }

    let mut honest = rgb_exr(Compression::ZIP16, Blocks::ScanLines);
    let after = |bytes: &[u8], name: &[u8]| {
        let at = bytes.windows(name.len()).position(|w| w == name);
        at.expect("the attribute") + name.len()
    };
    // A count that need not be there and would betray the size at once.
    let count = after(&honest, b"chunkCount");
    honest[count - 1] = b'x';
    let window = after(&honest, b"dataWindow\0box2i\0") + 4;
    for (corners, expected) in [
        ([0, 0, -1, -1], "not a whole OpenEXR file"),
        (
            [0, 0, 99_999, 11],
            "the image is said to be 100000×12; expected",
        ),
        (
            [0, 0, 40_000, 40_000],
            "the image is said to be 40001×40001",
        ),
        ([0, 0, 23, 60_000], "the file ends early"),
        (
            [i32::MIN, i32::MIN, i32::MAX, i32::MAX],
            "not a whole OpenEXR file",
        ),
    ] {
        let mut forged = honest.clone();
        for (i, corner) in corners.into_iter().enumerate() {
            forged[window + 4 * i..][..4].copy_from_slice(&i32::to_le_bytes(corner));
        }
        let found = parse(&forged).expect_err("is refused");
        assert!(found.starts_with(expected), "{corners:?}: {found}");
    }
}

#[test]
fn truncated_files_are_errors() {
    let exr = rgb_exr(Compression::ZIP16, Blocks::ScanLines);
    let hdr = hdr_bytes(&expected(), SIZE);
    for bytes in [exr, hdr] {
        for length in (0..bytes.len()).step_by(3) {
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
    let tiles = Blocks::Tiles(Vec2(7, 5));
    let mut bases: Vec<Vec<u8>> = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
        Compression::B44A,
    ]
    .into_iter()
    .flat_map(|compression| [Blocks::ScanLines, tiles].map(|blocks| rgb_exr(compression, blocks)))
    .collect();
    bases.push(hdr_bytes(&expected(), SIZE));
    random_edits::for_each(&bases, 400, |bytes| {
        let _ = parse(&bytes);
    });
}
