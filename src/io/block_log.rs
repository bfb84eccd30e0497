//! Blocks of samples as a file that grows while they are taken: a line that names the format, what the render is of, and a record for each
//! block.
//!
//! A record is the length of what follows it, the CRC-32 of that, and the block. A process that is killed leaves the last one unfinished;
//! whoever reads goes as far as records are whole. What is lost with the rest is taken anew.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::whole_file::open_file;
use crate::control::{CancelToken, Progress};
use crate::render::{Block, BlockHeader};

/// The first line.
const FIRST_LINE: &[u8] = b"RayMini blocks 1\n";
/// Length and CRC-32, both little-endian.
const PREFIX_BYTES: usize = 8;

/// A file that takes the blocks of one render.
#[derive(Debug)]
pub struct BlockLog {
    file: File,
}

impl BlockLog {
    /// Begins a file at `path` for a render of that [description](super::describe_render), in place of what is there.
    ///
    /// # Errors
    /// What the system says.
    pub fn create(path: &Path, description: &str) -> io::Result<Self> {
        let mut file = File::create(path)?;
        let mut start = FIRST_LINE.to_vec();
        start.extend(record(description.as_bytes()));
        file.write_all(&start)?;
        Ok(Self { file })
    }

    /// Adds a [record](block_record). After an error nothing that follows would be read.
    ///
    /// # Errors
    /// What the system says.
    pub fn append(&mut self, record: &[u8]) -> io::Result<()> {
        self.file.write_all(record)
    }
}

/// The record of a block.
///
/// # Panics
/// When it takes 4 GiB, as no tile does.
#[must_use]
pub fn block_record(block: &Block<'_>) -> Vec<u8> {
    let bytes = postcard::to_stdvec(block).expect("memory takes all");
    record(&bytes)
}

fn record(bytes: &[u8]) -> Vec<u8> {
    let length = u32::try_from(bytes.len()).expect("a tile is small");
    let mut record = Vec::with_capacity(PREFIX_BYTES + bytes.len());
    record.extend(length.to_le_bytes());
    record.extend(crc32fast::hash(bytes).to_le_bytes());
    record.extend(bytes);
    record
}

/// Blocks in files that a render wrote before it was interrupted.
#[derive(Debug, Default)]
pub struct LoggedBlocks {
    files: Vec<Mutex<File>>,
    /// By pass and tile.
    places: HashMap<(u32, u32), Place>,
    headers: Vec<BlockHeader>,
}

/// Where the record of a block is.
#[derive(Clone, Copy, Debug)]
struct Place {
    file: usize,
    start: u64,
    end: u64,
}

impl LoggedBlocks {
    /// What can be read of the files at `paths`. Those that are of another render than that of the
    /// [description](super::describe_render), or nothing of the kind, hold nothing.
    #[must_use]
    #[expect(clippy::missing_panics_doc, reason = "nobody cancels")]
    pub fn read(paths: &[PathBuf], description: &str) -> Self {
        let read = Self::read_unless(paths, description, &CancelToken::new(), &Progress::new());
        read.expect("nobody cancels")
    }

    /// [`Self::read`], unless it is cancelled, which is `None`. `progress` advances by the bytes of what can be read; setting its total is the
    /// caller's.
    #[must_use]
    pub fn read_unless(
        paths: &[PathBuf],
        description: &str,
        cancel: &CancelToken,
        progress: &Progress,
    ) -> Option<Self> {
        let mut blocks = Self::default();
        for path in paths {
            // What cannot be read is not there.
            if let Ok(file) = open_file(path, "blocks of a render") {
                let _ = blocks.take_in(file, description, cancel, progress);
            }
        }
        (!cancel.is_cancelled()).then_some(blocks)
    }

    /// Which there are.
    #[must_use]
    pub fn headers(&self) -> &[BlockHeader] {
        &self.headers
    }

    /// The block of a tile in a pass, if it is there, and still whole: days may have gone by since the file was looked through.
    #[must_use]
    pub fn find(&self, pass: u32, tile: u32) -> Option<Block<'static>> {
        let place = self.places.get(&(pass, tile))?;
        let file = self.files[place.file].lock();
        let mut file = file.unwrap_or_else(PoisonError::into_inner);
        file.seek(SeekFrom::Start(place.start)).ok()?;
        let (mut bytes, mut end) = (Vec::new(), place.start);
        let is_whole = read_record(&mut *file, place.end, &mut end, &mut bytes).ok()?;
        drop(file);
        is_whole.then(|| postcard::from_bytes(&bytes).ok())?
    }

    fn take_in(
        &mut self,
        file: File,
        description: &str,
        cancel: &CancelToken,
        progress: &Progress,
    ) -> io::Result<()> {
        let size = file.metadata()?.len();
        let mut reader = io::BufReader::with_capacity(1 << 20, file);
        let mut first_line = [0; FIRST_LINE.len()];
        reader.read_exact(&mut first_line)?;
        let mut end = FIRST_LINE.len() as u64;
        let mut bytes = Vec::new();
        let is_known = first_line == FIRST_LINE
            && read_record(&mut reader, size, &mut end, &mut bytes)?
            && bytes == description.as_bytes();
        progress.advance(end);
        let mut start = end;
        while is_known
            && !cancel.is_cancelled()
            && read_record(&mut reader, size, &mut end, &mut bytes)?
        {
            let Ok((header, _)) = postcard::take_from_bytes::<BlockHeader>(&bytes) else {
                break;
            };
            let place = Place {
                file: self.files.len(),
                start,
                end,
            };
            progress.advance(end - start);
            start = end;
            let known = self.places.insert((header.pass, header.tile), place);
            if known.is_none() {
                self.headers.push(header);
            }
        }
        self.files.push(Mutex::new(reader.into_inner()));
        Ok(())
    }
}

/// Reads the record that begins `end` bytes into a file of which `size` bytes are looked at; `end` is where the next one begins then. Returns
/// whether it is whole.
fn read_record(
    reader: &mut impl Read,
    size: u64,
    end: &mut u64,
    bytes: &mut Vec<u8>,
) -> io::Result<bool> {
    let left = size.saturating_sub(*end);
    if left < PREFIX_BYTES as u64 {
        return Ok(false);
    }
    let mut word = || -> io::Result<u32> {
        let mut word = [0; 4];
        reader.read_exact(&mut word)?;
        Ok(u32::from_le_bytes(word))
    };
    let (length, crc) = (word()?, word()?);
    if u64::from(length) > left - PREFIX_BYTES as u64 {
        return Ok(false);
    }
    bytes.resize(length as usize, 0);
    reader.read_exact(bytes)?;
    *end += PREFIX_BYTES as u64 + u64::from(length);
    Ok(crc32fast::hash(bytes) == crc)
}
