//! Blocks of samples that outlive the process: what a tile got in a pass, kept as soon as it is there.
//!
//! A render that goes on takes them in place of sampling anew. Which block belongs where, and what is in it, follows from the scene alone,
//! so any number of them may be missing: the picture has the same bits, only later.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::film::TileSums;
use super::layers::Layer;
use super::tile_samples::{PixelSamples, SampleCounts, TileBlock};

/// Keeps blocks of one render, and knows those that were kept before.
pub trait BlockStore: Sync {
    /// Keeps `block`, or leaves it. Called by the thread that took its samples.
    fn keep(&self, block: &Block<'_>);

    /// The block of a tile in a pass, if it was kept before the render went on.
    fn recall(&self, pass: u32, tile: u32) -> Option<Block<'static>>;
}

/// Which block it is, and when it was there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BlockHeader {
    /// Number of the pass.
    pub pass: u32,
    /// Number of the tile in the region.
    pub tile: u32,
    /// Samples of all its pixels.
    pub samples: u64,
    /// Wall time of the render until then.
    pub seconds: f64,
    /// Processor time of the threads that render until then.
    pub cpu_seconds: f64,
}

/// What a tile got in a pass.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Block<'a> {
    /// In front, so that it can be read alone.
    pub header: BlockHeader,
    samples: Cow<'a, [PixelSamples]>,
    sums: Cow<'a, TileSums>,
    counts: SampleCounts,
}

impl<'a> Block<'a> {
    /// What is in `block`: of the tile number `tile` in pass number `pass`, at that time.
    pub(super) fn new(
        pass: u32,
        tile: u32,
        [seconds, cpu_seconds]: [f64; 2],
        block: &'a TileBlock,
    ) -> Self {
        let taken = block.samples.iter().map(|pixel| u64::from(pixel.count));
        Self {
            header: BlockHeader {
                pass,
                tile,
                samples: taken.sum(),
                seconds,
                cpu_seconds,
            },
            samples: Cow::Borrowed(&block.samples),
            sums: Cow::Borrowed(&block.sums),
            counts: block.counts,
        }
    }

    /// Puts it in place of what `block` holds, if it is of the very samples that `block` is to take, and keeps `layers`. Returns whether
    /// it is.
    pub(super) fn put_into(self, block: &mut TileBlock, layers: &[Layer]) -> bool {
        let fits = *self.samples == *block.samples && self.sums.is_of(&block.samples, layers);
        if fits {
            block.sums = self.sums.into_owned();
            block.counts = self.counts;
        }
        fits
    }
}
