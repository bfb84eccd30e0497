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
    /// Is told before a checkpoint is taken: the blocks that were kept so far are in it, or in one before.
    fn begin_anew(&self);

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
    planes: Vec<Plane>,
    rays: Cow<'a, [u32]>,
    counts: SampleCounts,
}

/// A plane of sums, as short as it can be without loss: most parts of a picture are black in most tiles, and single samples are `f32`.
#[derive(Clone, Debug, Serialize, Deserialize)]
enum Plane {
    Black,
    Single(Vec<[f32; 3]>),
    Double(Vec<[f64; 3]>),
}

impl Plane {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "it is looked whether that is lossless"
    )]
    fn of(sums: &[[f64; 3]]) -> Self {
        // By their bits: a negative zero and what is not a number stay as they are.
        let values = || sums.as_flattened().iter();
        let is_single = |sum: &f64| f64::from(*sum as f32).to_bits() == sum.to_bits();
        if values().all(|sum| sum.to_bits() == 0) {
            Self::Black
        } else if values().all(is_single) {
            let single = sums.iter().map(|sum| sum.map(|sum| sum as f32));
            Self::Single(single.collect())
        } else {
            Self::Double(sums.to_vec())
        }
    }

    /// The sums of `pixels` pixels; `None` where there are not so many.
    fn into_sums(self, pixels: usize) -> Option<Vec<[f64; 3]>> {
        let sums = match self {
            Self::Black => vec![[0.0; 3]; pixels],
            Self::Single(sums) => sums.into_iter().map(|sum| sum.map(f64::from)).collect(),
            Self::Double(sums) => sums,
        };
        (sums.len() == pixels).then_some(sums)
    }
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
            planes: block
                .sums
                .planes
                .iter()
                .map(|sums| Plane::of(sums))
                .collect(),
            rays: Cow::Borrowed(&block.sums.rays),
            counts: block.counts,
        }
    }

    /// Puts it in place of what `block` holds, if it is of the very samples that `block` is to take, and keeps `layers`. Returns whether
    /// it is.
    pub(super) fn put_into(self, block: &mut TileBlock, layers: &[Layer]) -> bool {
        let pixels = block.samples.len();
        let has_all = self.planes.len() == 1 + layers.len() && self.rays.len() == pixels;
        if !has_all || *self.samples != *block.samples {
            return false;
        }
        let planes = self.planes.into_iter().map(|plane| plane.into_sums(pixels));
        let Some(planes) = planes.collect() else {
            return false;
        };
        block.sums = TileSums {
            planes,
            samples: block.samples.iter().map(|pixel| pixel.count).collect(),
            rays: self.rays.into_owned(),
        };
        block.counts = self.counts;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_kept_bit_for_bit_in_the_shortest_form() {
        let third = 1.0 / 3.0;
        let single = [0.1_f32, -0.0, 1e-40].map(f64::from);
        let odd = [f64::INFINITY, f64::NEG_INFINITY, 1e30_f32.into()];
        for (sums, bytes) in [
            (vec![[0.0; 3]; 4], 1),
            (vec![single, odd], 2 + 24),
            (vec![[0.0, 0.0, -0.0]], 2 + 12),
            (vec![single, [third, 0.0, 0.0]], 2 + 48),
            (vec![[1e300, 0.0, 0.0]], 2 + 24),
            (vec![[f64::NAN, 0.0, 0.0]], 2 + 12),
        ] {
            let plane = Plane::of(&sums);
            let encoded = postcard::to_stdvec(&plane).expect("memory takes all");
            assert_eq!(encoded.len(), bytes, "{sums:?}");
            let plane: Plane = postcard::from_bytes(&encoded).expect("is right");
            let again = plane.into_sums(sums.len()).expect("as many");
            let bits = |sums: &[[f64; 3]]| -> Vec<u64> {
                sums.as_flattened()
                    .iter()
                    .map(|sum| sum.to_bits())
                    .collect()
            };
            assert_eq!(bits(&again), bits(&sums));
        }
        assert!(Plane::Single(vec![[0.0; 3]; 3]).into_sums(4).is_none());
    }
}
