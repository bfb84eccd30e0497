//! Numbers every layer above agrees on: vectors, boxes, rays, frames, colour, robust small numerics, and numbers for people.
//!
//! Lengths are in scene units, angles in radians unless a type says [`Degrees`]. Points and directions of the
//! description are `f64` ([`DVec3`]); of the prepared scene `f32` ([`Vec3`]).

mod angle;
mod bounds;
pub mod color;
mod compensated_sum;
mod digits;
mod direction;
mod frame;
mod ray;
pub mod robust;
mod scaled_rotation;
pub mod warp;

pub use angle::Degrees;
pub use bounds::{Bounds, DBounds};
pub use compensated_sum::{CompensatedSum, two_sum};
pub use digits::{counted, percent, signed, three_digits, time_in_words};
pub use direction::{direction_of, length_of};
pub use frame::{SceneFrame, power_of_two};
pub use glam::{DMat3, DVec2, DVec3, Vec2, Vec3, Vec4, Vec4Swizzles};
pub use ray::Ray;
pub use scaled_rotation::ScaledRotation;
