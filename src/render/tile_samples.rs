//! Sampling one tile.

use serde::{Deserialize, Serialize};

use super::camera_samples::{CameraSamples, SampleId};
use super::fault::SampleNote;
use super::film::{Film, TileSums, block_after};
use super::kernel::Kernel;
use super::layers::{Gathered, Layer, Parts};
use super::prepare::PreparedScene;
use super::progress::RenderProgress;
use super::run::{Clamped, RayCounts};
use super::stops::Stops;
use super::tally::Tally;
use super::tiles::Region;
use crate::accel::Packet;
use crate::math::color::luminance;

/// Side of the blocks of pixels whose samples are taken one after the other.
const PACKET_SIDE: u32 = 4;
const _: () = assert!(
    (PACKET_SIDE * PACKET_SIDE) as usize == Packet::MOST_RAYS,
    "full packets"
);

/// Which samples a pass takes.
#[derive(Clone, Copy, Debug)]
pub struct PassWork<'a> {
    /// Whether each pixel takes part; all do, where there is no choice.
    pub selected: Option<&'a [bool]>,
    /// Whether pixels take part whose number of samples is a power of two; otherwise only those do that are on the way to the next one.
    pub begins_round: bool,
    /// The most samples of one pixel in this pass.
    pub longest: u32,
    /// The most samples of one pixel in all.
    pub most: u32,
}

/// The samples of one pixel in a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PixelSamples {
    /// Index of the first.
    pub first: u32,
    /// Their number.
    pub count: u32,
}

impl PassWork<'_> {
    fn of_pixel(&self, film: &Film, index: usize) -> PixelSamples {
        let first = film.samples(index);
        let takes_part = self.selected.is_none_or(|selected| selected[index])
            && (self.begins_round || !first.is_power_of_two());
        let count = if takes_part {
            block_after(first)
                .min(self.longest)
                .min(self.most.saturating_sub(first))
        } else {
            0
        };
        PixelSamples { first, count }
    }

    /// Puts the samples of each pixel of `tile`, row by row, in place of what `samples` holds.
    pub fn of_tile(&self, film: &Film, tile: Region, samples: &mut Vec<PixelSamples>) {
        samples.clear();
        samples.extend(self.in_tile(film, tile));
    }

    fn in_tile(&self, film: &Film, tile: Region) -> impl Iterator<Item = PixelSamples> {
        let rows = (0..tile.height as usize).map(move |row| film.row_start(tile, row));
        let indices = rows.flat_map(move |start| start..start + tile.width as usize);
        indices.map(|index| self.of_pixel(film, index))
    }

    /// How many samples it takes in `tile`.
    pub fn samples_in(&self, film: &Film, tile: Region) -> u64 {
        let counts = self.in_tile(film, tile);
        counts.map(|pixel| u64::from(pixel.count)).sum()
    }

    /// How many samples it takes.
    pub fn samples(&self, film: &Film) -> u64 {
        let indices = 0..film.region().pixel_count();
        indices
            .map(|index| u64::from(self.of_pixel(film, index).count))
            .sum()
    }

    /// Whether there is anything to do.
    pub fn has_pixels(&self, film: &Film) -> bool {
        (0..film.region().pixel_count()).any(|index| self.of_pixel(film, index).count > 0)
    }
}

/// What is counted about samples.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct SampleCounts {
    pub rays: RayCounts,
    pub non_finite: u64,
    pub negative: u64,
    pub depth_limited: u64,
    clamped: u64,
    /// Luminance of all samples, and of what clamping took from them.
    luminance: f64,
    removed: f64,
}

impl SampleCounts {
    pub fn add(&mut self, other: &Self) {
        self.rays.add(&other.rays);
        self.non_finite += other.non_finite;
        self.negative += other.negative;
        self.depth_limited += other.depth_limited;
        self.clamped += other.clamped;
        self.luminance += other.luminance;
        self.removed += other.removed;
    }

    pub fn clamped(&self) -> Clamped {
        Clamped {
            samples: self.clamped,
            energy_share: if self.removed > 0.0 {
                self.removed / self.luminance
            } else {
                0.0
            },
        }
    }

    fn count_failures<P: Parts>(&mut self, sample: &Gathered<P>) {
        self.non_finite += u64::from(!sample.radiance.is_finite());
        self.negative += u64::from(sample.radiance.min_element() < 0.0);
        self.depth_limited += u64::from(sample.is_depth_limited);
    }

    /// Scales a sample down to `most` in its brightest channel, and keeps account of what that removes.
    fn clamp<P: Parts>(&mut self, sample: &mut Gathered<P>, most: f32) {
        let before = f64::from(luminance(sample.radiance));
        self.luminance += before;
        if sample.limit(most) {
            self.clamped += 1;
            self.removed += before - f64::from(luminance(sample.radiance));
        }
    }
}

/// One pass over one tile. A thread has one for all its tiles, so that a tile needs no memory of its own.
#[derive(Debug, Default)]
pub struct TileBlock {
    /// What it is to take.
    pub samples: Vec<PixelSamples>,
    pub sums: TileSums,
    pub counts: SampleCounts,
    /// Those that are taken next.
    ids: Vec<SampleId>,
    beginnings: CameraSamples,
}

/// Takes the samples of every pixel of `tile` that `block` asks for, and writes in `note` at which it is; `None` when stopped.
pub fn sample_tile<K: Kernel>(
    scene: &PreparedScene,
    tile: Region,
    block: &mut TileBlock,
    layers: &[Layer],
    stops: &Stops<'_>,
    progress: &RenderProgress,
    note: &SampleNote,
) -> Option<()> {
    let TileBlock {
        samples,
        sums,
        counts,
        ids,
        beginnings,
    } = block;
    beginnings.forget();
    sums.reset(layers, tile.pixel_count());
    *counts = SampleCounts::default();
    let mut tally = K::Tally::default();
    let place = |(x, y): (u32, u32)| ((y - tile.y) * tile.width + x - tile.x) as usize;
    for part in tile.cut(PACKET_SIDE) {
        let traced_before = tally.rays().total();
        let mut taken = 0;
        let mut left = part.pixels().flat_map(|pixel| {
            let PixelSamples { first, count } = samples[place(pixel)];
            (first..first + count).map(move |index| SampleId { pixel, index })
        });
        loop {
            ids.clear();
            ids.extend(left.by_ref().take(Packet::MOST_RAYS));
            let Some(&first) = ids.first() else {
                break;
            };
            note.set(first);
            let begun = beginnings.begin(scene, ids, &mut tally);
            for begun in begun {
                note.set(begun.id);
                let before = tally.rays().total();
                let mut sample = scene.gathered::<K>(begun, stops, &mut tally)?;
                // With the one from the eye, whether it was traced or known: what a sample is worth must not depend on that.
                let traced = 1 + tally.rays().total() - before;
                counts.count_failures(&sample);
                if let Some(most) = scene.clamp() {
                    counts.clamp(&mut sample, most);
                }
                sums.add(place(begun.id.pixel), layers, &sample, few(traced));
            }
            taken += ids.len() as u64;
        }
        progress.samples.advance(taken);
        progress.count_rays(tally.rays().total() - traced_before);
    }
    counts.rays = *tally.rays();
    Some(())
}

/// A number of rays; what is more than the largest gives that.
fn few(rays: u64) -> u32 {
    u32::try_from(rays).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::render::layers::NoParts;

    #[test]
    fn what_clamping_removes_is_accounted_for() {
        let mut counts = SampleCounts::default();
        for value in [1.0, 3.0, 10.0] {
            let mut sample = Gathered::<NoParts>::seen(Vec3::splat(value));
            counts.clamp(&mut sample, 4.0);
            assert!((sample.radiance.x - value.min(4.0)).abs() < 1e-6);
        }
        let Clamped {
            samples,
            energy_share,
        } = counts.clamped();
        assert_eq!(samples, 1);
        assert!((energy_share - 6.0 / 14.0).abs() < 1e-6);
    }

    #[test]
    fn infinite_and_negative_samples_are_counted() {
        let mut counts = SampleCounts::default();
        for value in [1.0, f32::NAN, f32::INFINITY, -1.0, 0.0] {
            counts.count_failures(&Gathered::<NoParts>::seen(Vec3::new(1.0, value, 0.0)));
        }
        assert_eq!((counts.non_finite, counts.negative), (2, 1));
    }
}
