//! Finding what a ray hits among many triangles: the kd-tree, and brute force as its reference.
//!
//! Both answer with the same bits: which hit is nearest is decided by the shared kernel's `t`, then by the smaller
//! triangle id, never by the structure.

use crate::control::CancelToken;
use crate::geometry::Triangle;
use crate::math::Ray;

/// The nearest triangle along a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Ray parameter, in multiples of the ray's direction.
    pub t: f32,
    /// Index of the triangle in the order given to the builder.
    pub triangle: u32,
    /// Weights of the triangle's three corners at the hit point: none negative, sum 1 up to rounding.
    pub barycentrics: [f32; 3],
}

/// A structure over triangles that answers ray queries.
#[derive(Debug)]
pub enum Accelerator {}

impl Accelerator {
    /// The nearest hit with `0 < t < t_max`, ties going to the smaller triangle id.
    #[must_use]
    pub fn intersect(&self, _ray: &Ray, _t_max: f32) -> Option<Hit> {
        match *self {}
    }
}

#[expect(dead_code)]
fn build(_triangles: Vec<Triangle>, _cancel: &CancelToken) {}
