use std::io::Cursor;

use super::*;
use crate::geometry::shapes::Random;

fn read(bytes: &[u8]) -> Result<TextureFile, String> {
    let (cancel, progress) = (CancelToken::new(), Progress::new());
    let file = parse_texture("a", bytes, &cancel, &progress).map_err(|error| error.to_string())?;
    assert_eq!(progress.done(), bytes.len() as u64);
    Ok(file.expect("nobody cancels"))
}

/// The bytes of a PNG file of these bytes of data, in rows of `width`.
fn png_bytes(width: u32, color: png::ColorType, depth: png::BitDepth, data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let per_sample = if depth == png::BitDepth::Sixteen {
        2
    } else {
        1
    };
    let height = data.len() / (width as usize * color.samples() * per_sample);
    let height = u32::try_from(height).expect("is small");
    let mut encoder = png::Encoder::new(Cursor::new(&mut bytes), width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    let mut writer = encoder.write_header().expect("can be written");
    writer.write_image_data(data).expect("can be written");
    writer.finish().expect("can be written");
    bytes
}

#[test]
fn values_are_kept_as_they_stand() {
    let (eight, sixteen) = (png::BitDepth::Eight, png::BitDepth::Sixteen);
    let colored = png_bytes(2, png::ColorType::Rgb, eight, &[1, 2, 3, 255, 0, 128]);
    let image = read(&colored).expect("is right").image;
    assert_eq!((image.width(), image.height()), (2, 1));
    assert_eq!(
        *image.texels(),
        Texels::Bytes(vec![[1, 2, 3], [255, 0, 128]])
    );
    let grey = png_bytes(1, png::ColorType::Grayscale, sixteen, &[1, 2, 255, 255]);
    let image = read(&grey).expect("is right").image;
    assert_eq!((image.width(), image.height()), (1, 2));
    assert_eq!(*image.texels(), Texels::Words(vec![[258; 3], [65535; 3]]));
    // What is not opaque is said.
    let clear = png_bytes(1, png::ColorType::Rgba, eight, &[1, 2, 3, 4]);
    let file = read(&clear).expect("is right");
    assert_eq!(*file.image.texels(), Texels::Bytes(vec![[1, 2, 3]]));
    assert_eq!(file.warnings.len(), 1);
}

/// A JPEG of 8 × 8 pixels by hand: one block of which only the mean is not 0, and tables of one code each.
fn jpeg_of_one_block() -> Vec<u8> {
    let mut bytes = vec![0xff, 0xd8];
    // Quantisation by 1 throughout.
    bytes.extend([0xff, 0xdb, 0, 67, 0]);
    bytes.extend([1; 64]);
    // Baseline, 8 bits, 8 × 8, one component.
    bytes.extend([0xff, 0xc0, 0, 11, 8, 0, 8, 0, 8, 1, 1, 0x11, 0]);
    // The mean has the code 0, of 10 bits; what follows has the code 0, the end of the block.
    for (class, symbol) in [(0x00, 10), (0x10, 0)] {
        bytes.extend([0xff, 0xc4, 0, 20, class, 1]);
        bytes.extend([0; 15]);
        bytes.push(symbol);
    }
    bytes.extend([0xff, 0xda, 0, 8, 1, 1, 0, 0, 63, 0]);
    // 0, then 600 in 10 bits, then 0, filled up with ones: 0 1001011000 0 1111.
    bytes.extend([0b0100_1011, 0b0000_1111]);
    bytes.extend([0xff, 0xd9]);
    bytes
}

/// The mean coefficient is eight times the mean, from 128 on.
#[test]
fn a_jpeg_is_read() {
    let bytes = jpeg_of_one_block();
    let file = read(&bytes).expect("is right");
    assert_eq!((file.image.width(), file.image.height()), (8, 8));
    assert_eq!(*file.image.texels(), Texels::Bytes(vec![[128 + 75; 3]; 64]));
    assert_eq!((file.format, file.warnings), ("JPEG", Vec::new()));
    let cut = read(&bytes[..bytes.len() - 2]).expect("is right");
    assert_eq!(cut.warnings.len(), 1);
}

#[test]
fn sizes_that_a_file_can_hardly_mean_are_refused() {
    let mut bytes = jpeg_of_one_block();
    let size = bytes.array_windows().position(|w| *w == [8, 0, 8, 0, 8]);
    let size = size.expect("is there") + 1;
    bytes[size..size + 4].copy_from_slice(&[0xff, 0xff, 0xff, 0xff]);
    let error = read(&bytes).expect_err("absurd");
    assert!(error.contains("65535×65535"), "{error}");
    bytes[size..size + 4].copy_from_slice(&[0x2f, 0xff, 0x3f, 0xff]);
    let error = read(&bytes).expect_err("absurd");
    assert!(error.contains("the file is too short"), "{error}");
}

/// The header of a frame of this size, progressive or not, whose components are sampled by `factors`: horizontal and vertical ones in the
/// halves of a byte.
fn frame(marker: u8, height: u16, width: u16, factors: &[u8]) -> Vec<u8> {
    let count = u8::try_from(factors.len()).expect("few");
    let mut bytes = vec![0xff, marker, 0, 8 + 3 * count, 8];
    bytes.extend(height.to_be_bytes());
    bytes.extend(width.to_be_bytes());
    bytes.push(count);
    for (id, factors) in (1..).zip(factors) {
        bytes.extend([id, *factors, 0]);
    }
    bytes
}

/// [`jpeg_of_one_block`] with another frame.
fn jpeg_of(frame: &[u8]) -> Vec<u8> {
    let mut bytes = jpeg_of_one_block();
    let start = bytes
        .array_windows()
        .position(|w| *w == [0xff, 0xc0, 0, 11]);
    let start = start.expect("is there");
    bytes.splice(start..start + 13, frame.iter().copied());
    bytes
}

/// Decoding takes memory for whole blocks: a row of pixels takes as much as sixteen.
#[test]
fn a_row_of_pixels_that_a_file_can_hardly_mean_is_refused() {
    for marker in [0xc0, 0xc2] {
        let wide = jpeg_of(&frame(marker, 1, 60_000, &[0x22, 0x11, 0x11]));
        let error = read(&wide).expect_err("absurd");
        assert!(error.contains("the file is too short"), "{error}");
    }
}

#[test]
fn components_that_are_sampled_oddly_are_refused() {
    for factors in [
        // A later component finer than the first, not a divisor of it, none at all, more than there may be.
        &[0x22, 0x11, 0x41][..],
        &[0x33, 0x22, 0x11],
        &[0x22, 0x11, 0x10],
        &[0x51, 0x11, 0x11],
        &[0x00],
    ] {
        let error = read(&jpeg_of(&frame(0xc0, 8, 8, factors))).expect_err("odd");
        assert!(error.contains("sampled in a way"), "{factors:x?}: {error}");
    }
    let none = read(&jpeg_of(&frame(0xc0, 8, 8, &[]))).expect_err("no component");
    assert!(none.contains("no components"), "{none}");
    // Bytes that fill up in front of a marker, or stand there for no reason, are none of this.
    for before in [&[0xff, 0xff, 0xff][..], &[0], &[0xff, 0, 7]] {
        let padded = [before, &frame(0xc0, 8, 8, &[0x11])].concat();
        read(&jpeg_of(&padded)).expect("is right");
        let padded = [before, &frame(0xc0, 8, 8, &[0x11, 0x21])].concat();
        read(&jpeg_of(&padded)).expect_err("odd");
    }
    let short = [
        &[0xff, 0xe0, 0, 6, 1, 2, 3, 4][..],
        &frame(0xc0, 8, 8, &[0x11]),
    ]
    .concat();
    let error = read(&jpeg_of(&short)).expect_err("no identifier");
    assert!(error.contains("APP0"), "{error}");
    let cut = read(&jpeg_of_one_block()[..80]).expect_err("cut off");
    assert!(cut.contains("it ends before"), "{cut}");
    let scan = jpeg_of(&[]);
    let error = read(&scan).expect_err("no frame");
    assert!(error.contains("has no header"), "{error}");
}

#[test]
fn what_is_no_image_is_named() {
    let expected = format!("a: this is not a known kind of image; expected {TEXTURE_FORMATS}");
    assert_eq!(read(b"OFF\n"), Err(expected));
    let tiff = format!("a: this is a TIFF picture; expected {TEXTURE_FORMATS}");
    assert_eq!(read(b"II*\0"), Err(tiff));
    let error = read(&jpeg_of_one_block()[..100]).expect_err("cut off");
    assert!(error.starts_with("a: not a whole JPEG file: "), "{error}");
}

/// Files of the corpus with bytes changed, cut out and put in: none panics, and all are read or refused in words.
#[test]
fn random_mutations_never_panic() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus/texture");
    let entries = std::fs::read_dir(folder).expect("the corpus is part of the repository");
    let mut paths: Vec<_> = entries
        .map(|entry| entry.expect("an entry").path())
        .collect();
    paths.sort();
    let files: Vec<_> = paths
        .iter()
        .map(|path| std::fs::read(path).expect("is there"))
        .collect();
    let mut random = Random::new(11);
    let mut below = |bound: usize| {
        usize::try_from(random.bits() % bound as u64).expect("below a number of that type")
    };
    for _ in 0..4000 {
        let mut bytes = files[below(files.len())].clone();
        for _ in 0..=below(4) {
            let from = below(bytes.len() + 1);
            let to = (from + below(4)).min(bytes.len());
            let scrap =
                [0, 1, 0x7f, 0xff, below(256)].map(|byte| u8::try_from(byte).expect("a byte"));
            let start = below(scrap.len());
            bytes.splice(from..to, scrap[start..].iter().take(below(3)).copied());
        }
        if let Err(error) = read(&bytes) {
            assert!(
                error.starts_with("a: ") && error.len() < 500 && !error.contains('\n'),
                "{error}"
            );
        }
    }
}
