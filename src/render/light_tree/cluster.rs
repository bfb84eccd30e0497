//! What bounds the things below a node, and what that says they may give a point.

use super::cut::Tally;
use super::{CHUNK, Item, Luminary, Receiver, Shines};
use crate::control::CancelToken;
use crate::math::{Bounds, DVec3, Vec3};

/// Cosines nearer to 0 than this, about a quarter of a degree from edge-on, count as this. It is far more than the rounding,
/// in `f32`, of what lights are then found to give, so that nothing is taken to be dark that is not, and it leaves light at
/// grazing incidence to models that reflect it without a cosine.
const LEAST_COSINE: f64 = 1.0 / 256.0;

/// What bounds some things that shine.
#[derive(Clone, Copy, Debug)]
pub struct Cluster {
    pub bounds: Bounds,
    /// Sum of the intensities.
    pub intensity: f64,
    /// All normals lie in the cone about this unit vector; where `both_sides`, they or their opposites do.
    axis: Vec3,
    /// Cosine and sine of the cone's half angle; π for what shines everywhere.
    cone: [f32; 2],
    both_sides: bool,
}

impl Cluster {
    /// What bounds `items`. Not meaningful when cancelled.
    pub fn around(items: &[Item], cancel: &CancelToken) -> Self {
        let items = || {
            let chunks = items.chunks(CHUNK);
            chunks.take_while(|_| !cancel.is_cancelled()).flatten()
        };
        let mut tally = Tally::EMPTY;
        for (_, luminary) in items() {
            tally = tally.with(&Tally::of(luminary));
        }
        let axis = tally.normals.as_dvec3().normalize_or(DVec3::Z);
        let cosine_to_axis = |luminary: &Luminary| match luminary.shines {
            Shines::Everywhere => -1.0,
            Shines::OneSide(normal) | Shines::BothSides(normal) => {
                let cosine = axis.dot(normal.as_dvec3());
                if tally.both_sides {
                    cosine.abs()
                } else {
                    cosine
                }
            }
        };
        // Wider by what the narrowing of axis and normals may have moved them.
        let rounding = 4.0 * f64::from(f32::EPSILON);
        let cosines = items().map(|(_, luminary)| cosine_to_axis(luminary));
        let cosine = cosines.fold(1.0, f64::min) - rounding;
        let cosine = cosine.max(-1.0);
        let sine = (1.0 - cosine * cosine).sqrt();
        #[expect(clippy::cast_possible_truncation, reason = "widened above")]
        let cone = [cosine as f32, sine as f32];
        Self {
            bounds: tally.bounds,
            intensity: tally.intensity,
            axis: axis.as_vec3(),
            cone,
            both_sides: tally.both_sides,
        }
    }

    /// What the cluster may give `at`, as a numerator and the square of a distance: intensity times the largest cosines that
    /// any of it may have at both ends, over the distance to its middle, no nearer than its size. 0 where it gives nothing.
    pub fn importance(&self, at: &Receiver) -> (f64, f64) {
        let (min, max) = (self.bounds.min.as_dvec3(), self.bounds.max.as_dvec3());
        let half = (max - min) * 0.5;
        let towards = (min + max) * 0.5 - at.position.as_dvec3();
        let (distance_squared, radius_squared) = (towards.length_squared(), half.length_squared());
        // The last digit of f32 stands for points that coincide.
        let apart = f64::from(f32::MIN_POSITIVE).powi(2);
        let measured = distance_squared.max(radius_squared).max(apart);
        let distance = measured.sqrt();

        let normal = at.normal.as_dvec3();
        let height = normal.dot(towards);
        // All corners of the box lie behind the surface.
        if height + normal.abs().dot(half) < -LEAST_COSINE * distance {
            return (0.0, measured);
        }
        // Within the ball around the box, any direction may be towards a light.
        if measured > distance_squared || radius_squared == distance_squared {
            return (self.intensity, measured);
        }

        let per_distance = 1.0 / distance;
        let ball = Angle::of_sine(radius_squared.sqrt() * per_distance);
        let received = Angle::of_cosine(height * per_distance).less(ball).cosine;
        let [cosine, sine] = self.cone.map(f64::from);
        let emitted = if cosine == -1.0 {
            1.0
        } else {
            let along = -self.axis.as_dvec3().dot(towards) * per_distance;
            let from_axis = Angle::of_cosine(if self.both_sides { along.abs() } else { along });
            from_axis.less(Angle { cosine, sine }).less(ball).cosine
        };
        if emitted < -LEAST_COSINE {
            return (0.0, measured);
        }
        let cosines = received.max(LEAST_COSINE) * emitted.max(LEAST_COSINE);
        (self.intensity * cosines, measured)
    }
}

/// An angle between 0 and π.
#[derive(Clone, Copy)]
struct Angle {
    cosine: f64,
    sine: f64,
}

impl Angle {
    fn of_cosine(cosine: f64) -> Self {
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        Self { cosine, sine }
    }

    /// The one up to π/2.
    fn of_sine(sine: f64) -> Self {
        let cosine = (1.0 - sine * sine).max(0.0).sqrt();
        Self { cosine, sine }
    }

    /// The difference, or 0 where `other` is larger.
    fn less(self, other: Self) -> Self {
        if self.cosine >= other.cosine {
            return Self {
                cosine: 1.0,
                sine: 0.0,
            };
        }
        Self {
            cosine: self.cosine * other.cosine + self.sine * other.sine,
            sine: self.sine * other.cosine - self.cosine * other.sine,
        }
    }
}
