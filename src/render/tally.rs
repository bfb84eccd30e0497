//! What is told of every ray of a sample as it is traced, and of every random number: rays are counted always, the rest is kept where
//! somebody wants to look at it.

use super::run::RayCounts;
use super::sampler::{Decision, Dimension, Sampler};
use crate::accel::Hit;
use crate::math::{Ray, Vec2, Vec3};

/// What a ray is traced for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayPurpose {
    /// From the eye.
    Camera,
    /// To a light.
    Shadow,
    /// Into the hemisphere over a point.
    AmbientOcclusion,
    /// From a mirror or glass, or along a path.
    Bounce,
}

impl RayPurpose {
    /// Every one, as a path comes to them.
    pub const ALL: [Self; 4] = [
        Self::Camera,
        Self::Shadow,
        Self::AmbientOcclusion,
        Self::Bounce,
    ];

    /// In words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Shadow => "shadow",
            Self::AmbientOcclusion => "ambient occlusion",
            Self::Bounce => "bounce",
        }
    }
}

/// A ray in the prepared scene, and what became of it.
#[derive(Clone, Copy, Debug)]
pub struct NotedRay {
    pub ray: Ray,
    /// How far from the eye it starts; 0 for all but camera rays.
    pub start: f64,
    /// The parameter up to which it was traced.
    pub reach: f32,
    pub end: NotedEnd,
}

/// What became of a ray.
#[derive(Clone, Copy, Debug)]
pub enum NotedEnd {
    /// Its nearest hit was asked for, lights aside.
    Nearest(Option<Hit>),
    /// It passes by all there is to meet.
    PassesBy,
    /// It was asked whether anything is in the way: the share of light that comes through.
    Passed(Vec3),
}

impl NotedRay {
    /// A ray whose nearest hit was asked for.
    pub fn nearest(ray: Ray, hit: Option<Hit>) -> Self {
        Self {
            ray,
            start: 0.0,
            reach: f32::INFINITY,
            end: NotedEnd::Nearest(hit),
        }
    }

    /// A ray from the eye along a unit vector, past all there is to meet; where it starts does not matter.
    pub fn passing_by(direction: Vec3) -> Self {
        Self {
            end: NotedEnd::PassesBy,
            ..Self::nearest(Ray::new(Vec3::ZERO, direction), None)
        }
    }

    /// A ray along which this share of light passes up to the parameter `reach`.
    pub fn passing(ray: Ray, reach: f32, share: Vec3) -> Self {
        Self {
            ray,
            start: 0.0,
            reach,
            end: NotedEnd::Passed(share),
        }
    }

    /// Ray `number` of a fan, along which something is in the way if that bit of `occluded` is set.
    pub fn of_fan(ray: Ray, number: usize, occluded: u64) -> Self {
        let is_free = occluded >> number & 1 == 0;
        Self::passing(ray, 1.0, Vec3::splat(f32::from(u8::from(is_free))))
    }
}

/// Is told of every ray and of every random number.
pub trait Tally: Default {
    /// A ray is traced. What it was is asked for only where rays are kept.
    fn note(&mut self, purpose: RayPurpose, ray: impl FnOnce() -> NotedRay);

    /// `count` rays are traced together.
    fn note_all(&mut self, purpose: RayPurpose, count: usize, ray: impl Fn(usize) -> NotedRay);

    /// Random numbers are drawn for so many turns of a decision.
    fn note_draws(&mut self, decision: Decision, turns: u32);

    /// A ray to a light asks for the nearest hit, as it may be of glass.
    fn note_looking_for_glass(&mut self);

    /// The rays so far.
    fn rays(&self) -> &RayCounts;

    /// A number of a decision.
    #[inline]
    fn draw_1d(&mut self, sampler: &Sampler, dimension: Dimension) -> f32 {
        self.note_draws(dimension.decision(), 1);
        sampler.next_1d(dimension)
    }

    /// A pair of numbers of a decision.
    #[inline]
    fn draw_2d(&mut self, sampler: &Sampler, dimension: Dimension) -> Vec2 {
        self.note_draws(dimension.decision(), 1);
        sampler.next_2d(dimension)
    }
}

/// Counts rays: in every render.
impl Tally for RayCounts {
    #[inline]
    fn note(&mut self, purpose: RayPurpose, _: impl FnOnce() -> NotedRay) {
        *self.of(purpose) += 1;
    }

    #[inline]
    fn note_all(&mut self, purpose: RayPurpose, count: usize, _: impl Fn(usize) -> NotedRay) {
        *self.of(purpose) += count as u64;
    }

    #[inline]
    fn note_draws(&mut self, _: Decision, _: u32) {}

    #[inline]
    fn note_looking_for_glass(&mut self) {}

    #[inline]
    fn rays(&self) -> &RayCounts {
        self
    }
}

/// Keeps rays and counts random numbers, for whoever looks at single samples.
#[derive(Clone, Debug, Default)]
pub struct WorkTally {
    pub counts: RayCounts,
    /// In the order in which they were traced.
    pub kept: Vec<(RayPurpose, NotedRay)>,
    /// Pairs of random numbers by decision.
    pub draws: [u64; Decision::ALL.len()],
    /// Rays to lights that asked for the nearest hit.
    pub for_glass: u64,
}

impl Tally for WorkTally {
    fn note(&mut self, purpose: RayPurpose, ray: impl FnOnce() -> NotedRay) {
        *self.counts.of(purpose) += 1;
        self.kept.push((purpose, ray()));
    }

    fn note_all(&mut self, purpose: RayPurpose, count: usize, ray: impl Fn(usize) -> NotedRay) {
        *self.counts.of(purpose) += count as u64;
        self.kept
            .extend((0..count).map(|number| (purpose, ray(number))));
    }

    fn note_draws(&mut self, decision: Decision, turns: u32) {
        self.draws[decision as usize] += u64::from(turns);
    }

    fn note_looking_for_glass(&mut self) {
        self.for_glass += 1;
    }

    fn rays(&self) -> &RayCounts {
        &self.counts
    }
}

impl RayCounts {
    #[inline]
    fn of(&mut self, purpose: RayPurpose) -> &mut u64 {
        match purpose {
            RayPurpose::Camera => &mut self.camera,
            RayPurpose::Shadow => &mut self.shadow,
            RayPurpose::AmbientOcclusion => &mut self.ambient_occlusion,
            RayPurpose::Bounce => &mut self.bounce,
        }
    }
}
