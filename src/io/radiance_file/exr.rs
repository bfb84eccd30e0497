//! OpenEXR: the first layer with colour, at full resolution, of any compression and sample type the `exr` crate reads.
//!
//! The colours are the channels R, G and B, or Y. Programs that put a name before every channel (`ViewLayer.Combined.R`) are
//! understood where no channel has a plain name.

use std::collections::BTreeSet;
use std::io::Cursor;

use exr::block::chunk::{Chunk, CompressedBlock};
use exr::block::reader::ChunksReader;
use exr::block::{self, UncompressedBlock, lines::LineRef};
use exr::compression::Compression;
use exr::meta::BlockDescription;
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use exr::prelude::f16;

use super::{Named, RawImage, Reading, black, refuse_size, too_short};
use crate::control::{CancelToken, Progress};
use crate::io::shorten::shortened;

/// Most bytes of one block of pixels: more than the largest image needs, less than a forged header may ask for.
const MOST_BLOCK_BYTES: u64 = 1 << 30;

/// A tile may be larger than the image, as those of small images are: by so many bytes, or so many times. The decoder makes room for
/// what a tile may take, whatever the file holds.
const LOOSE_TILE_BYTES: u64 = 16 << 20;
const LOOSENESS: u64 = 16;

/// Reads `bytes`; `progress` advances by as many, block by block. Beside the main image come those whose three channels are called by one of
/// `names`, a dot and the colour. Names that are not there are passed over, as are alpha and other channels.
pub fn read(
    bytes: &[u8],
    names: &[&str],
    cancel: &CancelToken,
    progress: &Progress,
) -> Reading<(RawImage, Named)> {
    let file = File::open(bytes)?;
    let headers = file.reader.headers();
    let color = find_color(headers).ok_or_else(|| no_color(headers))?;
    let found = (0..).zip(names);
    let found = found.filter_map(|(place, name)| Some((place, find_named(headers, name)?)));
    let (places, colors): (Vec<usize>, Vec<Color>) = found.unzip();
    let main = file.room_for(color)?;
    let named = colors.into_iter().map(|color| file.room_for(color));
    let (named, no_room) = match named.collect::<Result<Vec<Room>, String>>() {
        Ok(named) => (named, None),
        Err(reason) => (Vec::new(), Some(reason)),
    };
    let rooms = std::iter::once(main).chain(named).collect();
    let images = file.read_images(rooms, cancel, progress)?;
    Ok(images.map(|images| {
        let mut images = images.into_iter();
        let main = images.next().expect("there is room for it");
        let named = places.into_iter().zip(images).collect();
        (main, no_room.map_or(Ok(named), Err))
    }))
}

/// A file whose headers claim nothing that its length rules out.
struct File<'a> {
    bytes: &'a [u8],
    reader: block::reader::Reader<Cursor<&'a [u8]>>,
}

impl<'a> File<'a> {
    fn open(bytes: &'a [u8]) -> Result<Self, String> {
        let reader = block::read(Cursor::new(bytes), false).map_err(in_words)?;
        for header in reader.headers() {
            check_claims(header, bytes.len() as u64)?;
        }
        Ok(Self { bytes, reader })
    }

    /// Room for the image of these colours.
    fn room_for(&self, color: Color) -> Result<Room, String> {
        let Color {
            layer,
            roles,
            warnings,
        } = color;
        let size = self.reader.headers()[layer].layer_size;
        let length = self.bytes.len() as u64;
        let (width, height) = refuse_size(size.x() as u64, size.y() as u64, length)?;
        let image = RawImage {
            width,
            height,
            pixels: black(width, height)?,
            warnings,
        };
        Ok(Room {
            layer,
            roles,
            image,
        })
    }

    /// The images that there is room for, in one go.
    fn read_images(
        self,
        mut rooms: Vec<Room>,
        cancel: &CancelToken,
        progress: &Progress,
    ) -> Reading<Vec<RawImage>> {
        let length = self.bytes.len() as u64;
        let meta = self.reader.meta_data().clone();
        let is_wanted = |layer: usize| rooms.iter().any(|room| room.layer == layer);
        let chunks = self
            .reader
            .filter_chunks(false, |_, _, index| {
                is_wanted(index.layer) && index.level.x() == 0 && index.level.y() == 0
            })
            .map_err(in_words)?;
        let count = chunks.expected_chunk_count() as u64;
        let mut advanced = 0;
        for (done, chunk) in (1..=count).zip(chunks) {
            if cancel.is_cancelled() {
                return Ok(None);
            }
            let chunk = chunk.map_err(in_words)?;
            let (layer, header) = (chunk.layer_index, &meta.headers[chunk.layer_index]);
            check_counters(&chunk, header).map_err(in_words)?;
            let block =
                UncompressedBlock::decompress_chunk(chunk, &meta, false).map_err(in_words)?;
            for room in rooms.iter_mut().filter(|room| room.layer == layer) {
                take_block(&block, &header.channels, &room.roles, &mut room.image)?;
            }
            let share = length * done / count;
            progress.advance(share - advanced);
            advanced = share;
        }
        Ok(Some(rooms.into_iter().map(|room| room.image).collect()))
    }
}

#[expect(clippy::needless_pass_by_value, reason = "it is handed to `map_err`")]
fn in_words(error: exr::error::Error) -> String {
    format!("not a whole OpenEXR file: {error}")
}

/// Which of red, green and blue a channel is; a luminance is all three.
type Roles = Vec<[bool; 3]>;

/// Where the colours of a file are.
struct Color {
    layer: usize,
    roles: Roles,
    warnings: Vec<String>,
}

/// An image that is black until it is read.
struct Room {
    layer: usize,
    roles: Roles,
    image: RawImage,
}

/// The first flat layer with colours of plain names; else the picture that is most likely the main one of those whose channels
/// are called by a common name, a dot and the colour.
fn find_color(headers: &[Header]) -> Option<Color> {
    let flat = || {
        headers
            .iter()
            .enumerate()
            .filter(|(_, header)| !header.deep)
    };
    let plain = flat().find_map(|(layer, header)| Some((layer, roles(header, "")?)));
    if let Some((layer, roles)) = plain {
        return Some(Color {
            layer,
            warnings: missing(&roles),
            roles,
        });
    }
    let named: Vec<(usize, String)> = flat()
        .flat_map(|(layer, header)| prefixes(header).into_iter().map(move |p| (layer, p)))
        .collect();
    let (layer, prefix) = named
        .iter()
        .find(|(_, prefix)| is_main(prefix))
        .or(named.first())?;
    let others = named.iter().filter(|(_, other)| other != prefix);
    let others: Vec<&str> = others
        .map(|(_, other)| other.trim_end_matches('.'))
        .collect();
    let warnings = match &others[..] {
        [] => Vec::new(),
        _ => vec![format!(
            "the file holds several pictures; {} is read, not {}",
            shortened(prefix.trim_end_matches('.')),
            listed(&others)
        )],
    };
    Some(Color {
        layer: *layer,
        roles: roles(&headers[*layer], prefix)?,
        warnings,
    })
}

/// The first flat layer with three channels of that name; `None` where there is none.
fn find_named(headers: &[Header], name: &str) -> Option<Color> {
    let prefix = format!("{name}.");
    let whole = |header: &Header| {
        let roles = roles(header, &prefix)?;
        (!header.deep && missing(&roles).is_empty()).then_some(roles)
    };
    let mut headers = headers.iter().enumerate();
    let (layer, roles) = headers.find_map(|(layer, header)| Some((layer, whole(header)?)))?;
    Some(Color {
        layer,
        roles,
        warnings: Vec::new(),
    })
}

/// What the channels of a layer are whose names begin with `prefix`; `None` where there is no colour among them. A luminance
/// counts where nothing else does.
fn roles(header: &Header, prefix: &str) -> Option<Roles> {
    let names = header.channels.list.iter().map(|c| c.name.to_string());
    let color = |name: String| match name.strip_prefix(prefix) {
        Some("R" | "r") => [true, false, false],
        Some("G" | "g") => [false, true, false],
        Some("B" | "b") => [false, false, true],
        _ => [false; 3],
    };
    let luminance = |name: String| [name.strip_prefix(prefix) == Some("Y"); 3];
    [
        names.clone().map(color).collect::<Roles>(),
        names.map(luminance).collect(),
    ]
    .into_iter()
    .find(|roles| roles.iter().any(|role| *role != [false; 3]))
}

/// What stands before `R`, the dot included, where `G` and `B` are there with the same name.
fn prefixes(header: &Header) -> Vec<String> {
    let names = || header.channels.list.iter().map(|c| c.name.to_string());
    let known: BTreeSet<String> = names().collect();
    let has = |prefix: &str, colors: [char; 2]| {
        let mut names = colors.iter().map(|color| format!("{prefix}{color}"));
        names.any(|name| known.contains(&name))
    };
    let prefix = |name: String| {
        let prefix = name
            .strip_suffix(['R', 'r'])
            .filter(|prefix| prefix.ends_with('.'))?;
        (has(prefix, ['G', 'g']) && has(prefix, ['B', 'b'])).then(|| prefix.to_owned())
    };
    names().filter_map(prefix).collect()
}

/// Whether programs call their main picture so, as far as is known.
fn is_main(prefix: &str) -> bool {
    let name = prefix.trim_end_matches('.').rsplit('.').next();
    let known = ["combined", "beauty", "rgba", "rgb", "c", "ci"];
    name.is_some_and(|name| known.iter().any(|main| main.eq_ignore_ascii_case(name)))
}

/// What is said where a colour has no channel.
fn missing(roles: &Roles) -> Vec<String> {
    let names = ["red", "green", "blue"];
    let absent = (0..3).filter(|&i| !roles.iter().any(|role| role[i]));
    absent
        .map(|i| format!("there is no {} channel; it is taken as 0", names[i]))
        .collect()
}

fn no_color(headers: &[Header]) -> String {
    let names: Vec<String> = headers
        .iter()
        .flat_map(|header| &header.channels.list)
        .map(|channel| channel.name.to_string())
        .collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    format!(
        "the file has the channels {}; expected R, G and B, or Y, of a flat layer",
        listed(&names)
    )
}

/// The first of these names for a message; a file may have thousands.
fn listed(names: &[&str]) -> String {
    const MOST: usize = 12;
    let shown = names.iter().take(MOST).map(|name| shortened(name));
    let dots = (names.len() > MOST).then(|| "…".into());
    shown.chain(dots).collect::<Vec<_>>().join(", ")
}

/// Refuses sizes and counts that a file of `length` bytes cannot mean, before anything is allocated by them.
fn check_claims(header: &Header, length: u64) -> Result<(), String> {
    let size = header.layer_size;
    let (width, height) = refuse_size(size.x() as u64, size.y() as u64, length)?;
    // Every block has a place in a table of 8 bytes each.
    if header.chunk_count as u64 > length / 8 {
        return Err(format!(
            "the file ends early: {length} bytes cannot hold {} blocks of pixels",
            header.chunk_count
        ));
    }
    let most_bytes = most_expanded(header.compression).saturating_mul(length);
    let bytes_of = |pixels: Option<u64>| {
        pixels.and_then(|pixels| pixels.checked_mul(header.channels.bytes_per_pixel as u64))
    };
    let all_bytes = bytes_of(Some(u64::from(width) * u64::from(height)));
    if !header.deep && all_bytes.is_none_or(|bytes| bytes > most_bytes) {
        return Err(too_short(length, width, height));
    }
    let (block_width, block_height) = block_size(header);
    let block_bytes = bytes_of(block_width.checked_mul(block_height));
    let Some(block_bytes) = block_bytes.filter(|&bytes| bytes <= MOST_BLOCK_BYTES) else {
        return Err("its blocks of pixels are larger than any image needs".to_owned());
    };
    if let BlockDescription::Tiles(tiles) = header.blocks {
        let tile = (tiles.tile_size.x() as u64).checked_mul(tiles.tile_size.y() as u64);
        let most = LOOSE_TILE_BYTES.max(LOOSENESS * block_bytes);
        if bytes_of(tile).is_none_or(|bytes| bytes > most) {
            return Err("its tiles are far larger than the image".to_owned());
        }
    }
    Ok(())
}

/// Width and height of a block of pixels, cut off where the image ends.
fn block_size(header: &Header) -> (u64, u64) {
    let (width, height) = (header.layer_size.x() as u64, header.layer_size.y() as u64);
    match header.blocks {
        BlockDescription::Tiles(tiles) => (
            width.min(tiles.tile_size.x() as u64),
            height.min(tiles.tile_size.y() as u64),
        ),
        BlockDescription::ScanLines => {
            let lines = header.compression.scan_lines_per_block() as u64;
            (width, height.min(lines))
        }
    }
}

/// Refuses counters in a block of the compression DWA that its pixels do not explain: the decoder makes room for what they say.
///
/// Source: `internal_dwa_compressor.h` of OpenEXR, `DataSizesSingle`: eleven numbers, of which the 2nd, 7th and 8th are bytes of what is
/// not compressed, and the 9th and 10th are values of 8 × 8 pixels.
fn check_counters(chunk: &Chunk, header: &Header) -> exr::error::UnitResult {
    const SIZES: [usize; 5] = [1, 6, 7, 8, 9];
    /// Bytes of a value, and as much again for runs that compress badly.
    const MOST_PER_VALUE: u64 = 8;
    let is_dwa = matches!(
        header.compression,
        Compression::DWAA(_) | Compression::DWAB(_)
    );
    let bytes = match &chunk.compressed_block {
        CompressedBlock::Tile(block) => &block.compressed_pixels_le,
        CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
        _ => return Ok(()),
    };
    let place = header.get_block_data_indices(&chunk.compressed_block)?;
    let size = header.get_absolute_block_pixel_coordinates(place)?.size;
    let (width, height) = (size.width() as u64, size.height() as u64);
    let channels = &header.channels;
    let is_stored = bytes.len() as u64 == width * height * channels.bytes_per_pixel as u64;
    let values = width.next_multiple_of(8) * height.next_multiple_of(8);
    let most = MOST_PER_VALUE * values * channels.list.len() as u64;
    let (counters, _) = bytes.as_chunks();
    let is_too_large = |&number: &usize| {
        let counter = counters.get(number).map(|&bytes| u64::from_le_bytes(bytes));
        counter.is_some_and(|counter| counter > most)
    };
    if is_dwa && !is_stored && SIZES.iter().any(is_too_large) {
        let message = "a block of pixels says that it is larger than it can be";
        return Err(exr::error::Error::Invalid(message.into()));
    }
    Ok(())
}

/// Most bytes of pixels that one byte of the file can stand for, rounded up.
fn most_expanded(compression: Compression) -> u64 {
    /// zlib's technical details.
    const DEFLATE: u64 = 1032;
    match compression {
        Compression::Uncompressed => 1,
        // A run of 128 in two bytes.
        Compression::RLE => 64,
        Compression::ZIP1 | Compression::ZIP16 => DEFLATE,
        // 255 values of two bytes in nine bits.
        Compression::PIZ => 454,
        // Three bytes stand for four.
        Compression::PXR24 => DEFLATE * 4 / 3,
        // Sixteen values of two bytes in three.
        Compression::B44 | Compression::B44A => 11,
        // Runs of 128 deflated; the other parts of a block stand for less.
        _ => DEFLATE * 64,
    }
}

/// Puts the colours of one block into the image.
fn take_block(
    block: &UncompressedBlock,
    channels: &exr::meta::attribute::ChannelList,
    roles: &Roles,
    image: &mut RawImage,
) -> Result<(), String> {
    let width = image.width as usize;
    for line in block.lines(channels) {
        let role = roles[line.location.channel];
        if role == [false; 3] {
            continue;
        }
        let start = line.location.position.y() * width + line.location.position.x();
        let row = image
            .pixels
            .get_mut(start..start + line.location.sample_count)
            .ok_or("a block of pixels lies outside the image")?;
        let sample_type = channels.list[line.location.channel].sample_type;
        for (pixel, value) in row.iter_mut().zip(samples(&line, sample_type)) {
            for channel in 0..3 {
                if role[channel] {
                    pixel[channel] = value;
                }
            }
        }
    }
    Ok(())
}

/// The values of one line. Its bytes are in the order of this machine.
fn samples<'a>(line: &LineRef<'a>, sample_type: SampleType) -> Box<dyn Iterator<Item = f32> + 'a> {
    let bytes = line.value;
    match sample_type {
        SampleType::F16 => Box::new(
            bytes
                .as_chunks()
                .0
                .iter()
                .map(|&b| f16::from_ne_bytes(b).to_f32()),
        ),
        SampleType::F32 => Box::new(bytes.as_chunks().0.iter().map(|&b| f32::from_ne_bytes(b))),
        SampleType::U32 => Box::new(
            bytes
                .as_chunks()
                .0
                .iter()
                .map(|&b| u32::from_ne_bytes(b) as f32),
        ),
    }
}
