//! What is told of every ray of a sample as it is traced: counted always, kept where somebody wants to look at it.

use super::run::RayCounts;
use crate::accel::Hit;
use crate::math::{Ray, Vec3};

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
    /// The parameter up to which it was looked along.
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
    /// One whose nearest hit was asked for.
    pub fn nearest(ray: Ray, hit: Option<Hit>) -> Self {
        Self {
            ray,
            start: 0.0,
            reach: f32::INFINITY,
            end: NotedEnd::Nearest(hit),
        }
    }

    /// One from the eye along that unit vector that passes by all there is to meet. Where it starts nobody asks.
    pub fn passing_by(direction: Vec3) -> Self {
        Self {
            end: NotedEnd::PassesBy,
            ..Self::nearest(Ray::new(Vec3::ZERO, direction), None)
        }
    }

    /// One that lets this share of light pass up to its parameter `reach`.
    pub fn passing(ray: Ray, reach: f32, share: Vec3) -> Self {
        Self {
            ray,
            start: 0.0,
            reach,
            end: NotedEnd::Passed(share),
        }
    }

    /// One of a fan, `number`, along which something is in the way where the bit is set.
    pub fn of_fan(ray: Ray, number: usize, occluded: u64) -> Self {
        let is_free = occluded >> number & 1 == 0;
        Self::passing(ray, 1.0, Vec3::splat(f32::from(u8::from(is_free))))
    }
}

/// Counts rays as they are traced; keeps them as well where somebody wants to look at them.
#[derive(Clone, Debug, Default)]
pub struct RayTally {
    pub counts: RayCounts,
    /// In the order in which they were traced.
    kept: Option<Vec<(RayPurpose, NotedRay)>>,
}

impl RayTally {
    /// One that keeps all rays.
    pub fn keeping() -> Self {
        Self {
            kept: Some(Vec::new()),
            ..Self::default()
        }
    }

    /// What it has kept.
    pub fn into_kept(self) -> Vec<(RayPurpose, NotedRay)> {
        self.kept.unwrap_or_default()
    }

    /// A ray is traced. What it was is asked for only where rays are kept, so that counting costs next to no more than that.
    #[inline]
    pub fn note(&mut self, purpose: RayPurpose, ray: impl FnOnce() -> NotedRay) {
        *self.counts.of(purpose) += 1;
        if let Some(kept) = &mut self.kept {
            keep(kept, purpose, ray);
        }
    }

    /// As many rays are traced together.
    #[inline]
    pub fn note_all(&mut self, purpose: RayPurpose, count: usize, ray: impl Fn(usize) -> NotedRay) {
        *self.counts.of(purpose) += count as u64;
        if let Some(kept) = &mut self.kept {
            for number in 0..count {
                keep(kept, purpose, || ray(number));
            }
        }
    }
}

/// Out of line: where rays are only counted, nothing of this may be in the way.
#[cold]
#[inline(never)]
fn keep(
    kept: &mut Vec<(RayPurpose, NotedRay)>,
    purpose: RayPurpose,
    ray: impl FnOnce() -> NotedRay,
) {
    kept.push((purpose, ray()));
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
