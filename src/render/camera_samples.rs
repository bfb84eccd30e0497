//! Where samples begin: their rays from the eye, and what those hit first.

use std::hint::black_box;

use super::camera::CameraRay;
use super::filter;
use super::plan::Feature;
use super::prepare::PreparedScene;
use super::sampler::{Decision, Dimension, Sampler};
use super::tally::{NotedRay, RayPurpose, Tally};
use crate::accel::{Hit, Packet};
use crate::math::{DVec3, Vec2, Vec3};

/// A sample of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SampleId {
    /// Column and row in the full picture.
    pub pixel: (u32, u32),
    /// Its number among those of the pixel.
    pub index: u32,
}

/// Where a sample begins: everything up to what it sees first.
#[derive(Clone, Copy, Debug)]
pub struct CameraSample {
    pub id: SampleId,
    pub sampler: Sampler,
    /// Unit.
    pub direction: Vec3,
    /// `None` where it misses everything.
    pub ray: Option<CameraRay>,
    /// What the ray hits first, lights aside.
    pub hit: Option<Hit>,
}

impl CameraSample {
    /// What there is to note of the ray from the eye.
    fn noted(&self) -> NotedRay {
        match self.ray {
            Some(CameraRay { ray, start }) => NotedRay {
                start,
                ..NotedRay::nearest(ray, self.hit)
            },
            None => NotedRay::passing_by(self.direction),
        }
    }
}

/// Begins samples, in memory that serves one batch after the other.
#[derive(Debug, Default)]
pub struct CameraSamples {
    begun: Vec<CameraSample>,
    /// One sample for each pixel, whose ray the others of the pixel share.
    lines: Vec<CameraSample>,
}

impl CameraSamples {
    /// Forgets the last batch.
    pub fn forget(&mut self) {
        self.begun.clear();
    }

    /// Where each of the samples `ids`, at least one, begins; those of one pixel come one after the other. Where all samples of a pixel
    /// share one ray, it is traced once, and not again where the last batch ended with that pixel.
    pub fn begin(
        &mut self,
        scene: &PreparedScene,
        ids: &[SampleId],
        tally: &mut impl Tally,
    ) -> &[CameraSample] {
        let Self { begun, lines } = self;
        if scene.does(Feature::EyeRays) {
            begun.clear();
            scene.begin_each(ids.iter().copied(), tally, begun);
            return begun;
        }
        let by_pixel = ids.chunk_by(|a, b| a.pixel == b.pixel);
        let known = begun.last().filter(|last| last.id.pixel == ids[0].pixel);
        lines.clear();
        lines.extend(known);
        let new = by_pixel.clone().skip(lines.len()).map(|ids| ids[0]);
        scene.begin_each(new, tally, lines);
        begun.clear();
        for (line, ids) in lines.iter().zip(by_pixel) {
            begun.extend(ids.iter().map(|&id| scene.along(line, id)));
        }
        begun
    }
}

impl PreparedScene {
    /// Adds where each of the samples `ids` begins to `begun`.
    fn begin_each(
        &self,
        ids: impl Iterator<Item = SampleId>,
        tally: &mut impl Tally,
        begun: &mut Vec<CameraSample>,
    ) {
        let first = begun.len();
        begun.extend(ids.map(|id| self.looking(id, tally)));
        for packet in begun[first..].chunks_mut(Packet::MOST_RAYS) {
            self.look(packet, tally);
        }
    }

    /// Where one sample begins.
    pub(super) fn begin(&self, id: SampleId, tally: &mut impl Tally) -> CameraSample {
        let mut begun = [self.looking(id, tally)];
        self.look(&mut begun, tally);
        begun[0]
    }

    /// Where the sample `id` begins, which looks along the line of `other`.
    pub(super) fn along(&self, other: &CameraSample, id: SampleId) -> CameraSample {
        CameraSample {
            id,
            sampler: self.sampler(id),
            ..*other
        }
    }

    /// Finds what the rays of at most [`Packet::MOST_RAYS`] samples hit.
    fn look(&self, samples: &mut [CameraSample], tally: &mut impl Tally) {
        let known = self.primary_hits();
        if let Some(known) = known
            && samples.iter().all(|sample| known.knows(sample.id.pixel))
        {
            for sample in samples {
                sample.hit = known.of(sample.id.pixel);
            }
            return;
        }
        let mut packet = Packet::empty();
        for camera_ray in samples.iter().filter_map(|sample| sample.ray.as_ref()) {
            packet.push(&camera_ray.ray, f32::INFINITY);
        }
        let hits = self.accelerator().intersect_packet(&packet);
        let with_ray = samples.iter_mut().filter(|sample| sample.ray.is_some());
        for (sample, hit) in with_ray.zip(hits) {
            sample.hit = hit;
        }
        for sample in samples {
            tally.note(RayPurpose::Camera, || sample.noted());
            if let Some(known) = known {
                known.keep(sample.id.pixel, sample.hit);
            }
        }
    }

    /// A sample, before it is known what it hits.
    fn looking(&self, id: SampleId, tally: &mut impl Tally) -> CameraSample {
        let sampler = self.sampler(id);
        let (eye, direction) = self.line_of_sight(id.pixel, &sampler, tally);
        CameraSample {
            id,
            sampler,
            direction: direction.as_vec3(),
            ray: self.camera().ray_from(eye, direction),
            hit: None,
        }
    }

    pub(super) fn sampler(&self, id: SampleId) -> Sampler {
        let settings = self.settings();
        Sampler::new(settings.sampler, settings.seed, id.pixel, id.index)
    }

    /// Where a sample of a pixel looks from, and along which unit vector, in prepared units.
    #[inline]
    pub(super) fn line_of_sight(
        &self,
        (x, y): (u32, u32),
        sampler: &Sampler,
        tally: &mut impl Tally,
    ) -> (DVec3, DVec3) {
        let in_pixel = self.point_for(Feature::PixelPoints, Decision::Pixel, sampler, tally);
        let on_lens = self.point_for(Feature::Lens, Decision::Lens, sampler, tally);
        let offset = if self.needs(Feature::PixelPoints) {
            filter::offset(self.settings().filter, in_pixel)
        } else {
            Vec2::ZERO
        };
        let (x, y) = (
            f64::from(x) + 0.5 + f64::from(offset.x),
            f64::from(y) + 0.5 + f64::from(offset.y),
        );
        self.camera().through_lens(x, y, on_lens)
    }

    /// A point of the unit square for a feature of the camera; 0 where it is not needed.
    #[expect(clippy::inline_always, reason = "each form of the code calls it once")]
    #[inline(always)]
    fn point_for(
        &self,
        feature: Feature,
        decision: Decision,
        sampler: &Sampler,
        tally: &mut impl Tally,
    ) -> Vec2 {
        if !self.does(feature) {
            return Vec2::ZERO;
        }
        let u = tally.draw_2d(sampler, Dimension::once(decision));
        if self.needs(feature) {
            u
        } else {
            black_box(u);
            Vec2::ZERO
        }
    }
}
