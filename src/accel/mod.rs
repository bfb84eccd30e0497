//! Placeholder until branch `accel` is merged.
#![allow(missing_docs, clippy::all, clippy::pedantic)]
use crate::control::CancelToken;
use crate::geometry::Triangle;
use crate::math::{Bounds, Ray};

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    pub t: f32,
    pub triangle: u32,
    pub barycentrics: [f32; 3],
}
#[derive(Debug)]
pub struct BruteForce(Vec<Triangle>);
impl BruteForce {
    pub fn new(t: Vec<Triangle>) -> Self {
        Self(t)
    }
}
#[derive(Debug, Default)]
pub struct KdParameters;
#[derive(Debug)]
pub struct KdTree(Vec<Triangle>);
impl KdTree {
    pub fn build(t: Vec<Triangle>, _: &KdParameters, _: &CancelToken) -> Option<Self> {
        Some(Self(t))
    }
}
#[derive(Debug)]
pub enum Accelerator {
    KdTree(KdTree),
    BruteForce(BruteForce),
}
impl Accelerator {
    pub fn triangles(&self) -> &[Triangle] {
        match self {
            Self::KdTree(k) => &k.0,
            Self::BruteForce(b) => &b.0,
        }
    }
    pub fn bounds(&self) -> Bounds {
        self.triangles()
            .iter()
            .fold(Bounds::EMPTY, |b, t| b.union(t.bounds()))
    }
    pub fn name(&self) -> &'static str {
        "stub"
    }
    pub fn bytes(&self) -> usize {
        0
    }
    pub fn intersect(&self, ray: &Ray, t_max: f32) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        for (i, t) in self.triangles().iter().enumerate() {
            let [a, b, c] = t.corners;
            let (e1, e2) = (b - a, c - a);
            let p = ray.direction.cross(e2);
            let det = e1.dot(p);
            let s = ray.origin - a;
            let u = s.dot(p) / det;
            let q = s.cross(e1);
            let v = ray.direction.dot(q) / det;
            let tt = e2.dot(q) / det;
            if u >= 0.0
                && v >= 0.0
                && u + v <= 1.0
                && tt > 0.0
                && tt < t_max
                && best.is_none_or(|h| tt < h.t)
            {
                best = Some(Hit {
                    t: tt,
                    triangle: i as u32,
                    barycentrics: [1.0 - u - v, u, v],
                });
            }
        }
        best
    }
    pub fn occluded(&self, ray: &Ray, t_max: f32) -> bool {
        self.intersect(ray, t_max).is_some()
    }
}
