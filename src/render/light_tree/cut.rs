//! Where to cut a set of things that shine into two.

use super::{CHUNK, Item, Luminary, Shines};
use crate::control::CancelToken;
use crate::math::{Bounds, Vec3};

/// Cells per axis between which a node may be cut, as in the sources.
const BUCKETS: usize = 12;

/// What can be said of some things that shine by adding up what is known of each.
#[derive(Clone, Copy)]
pub struct Tally {
    pub bounds: Bounds,
    pub intensity: f64,
    /// Sum of the normals; those of things that shine on both sides count with the sign that makes it longer.
    pub normals: Vec3,
    pub both_sides: bool,
    count: u32,
}

impl Tally {
    pub const EMPTY: Self = Self {
        bounds: Bounds::EMPTY,
        intensity: 0.0,
        normals: Vec3::ZERO,
        both_sides: false,
        count: 0,
    };

    pub fn of(luminary: &Luminary) -> Self {
        let (normals, both_sides) = match luminary.shines {
            Shines::Everywhere => (Vec3::ZERO, false),
            Shines::OneSide(normal) => (normal, false),
            Shines::BothSides(normal) => (normal, true),
        };
        Self {
            bounds: luminary.bounds,
            intensity: luminary.intensity,
            normals,
            both_sides,
            count: 1,
        }
    }

    pub fn with(&self, other: &Self) -> Self {
        let against = other.both_sides && self.normals.dot(other.normals) < 0.0;
        Self {
            bounds: self.bounds.union(other.bounds),
            intensity: self.intensity + other.intensity,
            normals: if against {
                self.normals - other.normals
            } else {
                self.normals + other.normals
            },
            both_sides: self.both_sides || other.both_sides,
            count: self.count + other.count,
        }
    }

    /// How ill a node over these would tell lights apart: intensity, size and spread of the directions they shine in. The size
    /// is the squared diagonal, as areas vanish for lights in a row. The directions fill a solid angle from π, of one flat
    /// light, to 4π; the mean normal says about how much of that, and adds up, which a cone does not.
    fn cost(&self) -> f64 {
        if self.count == 0 {
            return 0.0;
        }
        let mean = self.normals.length() / self.count as f32;
        let solid_angle = f64::from(1.0 + 3.0 * (1.0 - mean));
        self.intensity * self.bounds.size().as_dvec3().length_squared() * solid_angle
    }
}

/// Reorders at least two `items` and returns where to cut: between cells along one axis where the cost of both sides is least,
/// or in the middle. Not meaningful when cancelled.
pub fn cut(items: &mut [Item], halve: bool, cancel: &CancelToken) -> usize {
    let middle = items.len() / 2;
    if halve || items.len() == 2 {
        return middle;
    }
    let center = |(_, luminary): &Item| luminary.bounds.center();
    let centers = Bounds::of_points(items.iter().map(center));
    let size = centers.size();
    let buckets = BUCKETS.min(items.len());
    let per_size = Vec3::splat(buckets as f32) / size;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a cell's number"
    )]
    let bucket = |item: &Item, axis: usize| {
        let along = (center(item)[axis] - centers.min[axis]) * per_size[axis];
        (along as usize).min(buckets - 1)
    };
    let mut tallies = [[Tally::EMPTY; BUCKETS]; 3];
    let chunks = items.chunks(CHUNK);
    for item in chunks.take_while(|_| !cancel.is_cancelled()).flatten() {
        let tally = Tally::of(&item.1);
        for axis in 0..3 {
            let cell = &mut tallies[axis][bucket(item, axis)];
            *cell = cell.with(&tally);
        }
    }
    // Cost, axis, first cell of the second side.
    let mut best = (f64::INFINITY, 0, 0);
    for axis in 0..3 {
        let tallies = &tallies[axis][..buckets];
        let mut after = [0.0; BUCKETS];
        let mut right = Tally::EMPTY;
        for (index, tally) in tallies.iter().enumerate().rev() {
            right = right.with(tally);
            after[index] = right.cost();
        }
        // Thin slices of long nodes cost more, as in the sources.
        let thinness = f64::from(size.max_element() / size[axis]);
        let mut left = Tally::EMPTY;
        for index in 1..buckets {
            left = left.with(&tallies[index - 1]);
            let cost = thinness * (left.cost() + after[index]);
            let splits = 0 < left.count && left.count < right.count;
            if splits && cost < best.0 {
                best = (cost, axis, index);
            }
        }
    }
    let (cost, axis, first) = best;
    if cost == f64::INFINITY || cancel.is_cancelled() {
        return middle;
    }
    let mut left = 0;
    for index in 0..items.len() {
        if bucket(&items[index], axis) < first {
            items.swap(left, index);
            left += 1;
        }
    }
    left
}
