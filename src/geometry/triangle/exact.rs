//! Ray against triangle with no rounding before the last step, for the few tests that `f64` cannot settle.
//!
//! Products of three `f32` values are sums of two `f64` values without error; sums of those are kept as expansions,
//! lists of `f64` values that do not overlap.
//! Source: Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates, 1997.

use super::Triangle;
use crate::math::{Ray, Vec3, two_sum};

/// `t` and the corners' weights where the line through `ray` crosses the triangle, edges included, both to within a few
/// units in the last place of `f64`; `None` when it misses or lies in the triangle's plane.
#[cold]
#[inline(never)]
pub(super) fn intersect(ray: &Ray, triangle: &Triangle) -> Option<(f64, [f64; 3])> {
    let Ray {
        origin: o,
        direction: d,
    } = *ray;
    let [a, b, c] = triangle.corners;

    // Volumes spanned by the direction and each edge seen from the origin: det(d, p − o, q − o).
    let edge = |p, q| {
        let mut sum = Expansion::ZERO;
        sum.add_determinant(d, p, q);
        sum.add_determinant(d, o, p);
        sum.add_determinant(d, q, o);
        sum.value()
    };
    let edges = [edge(b, c), edge(c, a), edge(a, b)];
    let inside = edges.iter().all(|&e| e >= 0.0) || edges.iter().all(|&e| e <= 0.0);
    let total: f64 = edges.iter().sum();
    if !inside || total == 0.0 {
        return None;
    }

    // det(a − o, b − o, c − o)
    let mut volume = Expansion::ZERO;
    volume.add_determinant(a, b, c);
    volume.add_determinant(-o, b, c);
    volume.add_determinant(a, -o, c);
    volume.add_determinant(a, b, -o);
    Some((volume.value() / total, edges.map(|e| e / total)))
}

/// A sum without rounding: its terms do not overlap and grow in magnitude.
struct Expansion {
    terms: [f64; Expansion::CAPACITY],
    len: usize,
}

impl Expansion {
    /// Four determinants of six products, each of two terms.
    const CAPACITY: usize = 4 * 6 * 2;

    const ZERO: Self = Self {
        terms: [0.0; Self::CAPACITY],
        len: 0,
    };

    /// Adds the determinant of the matrix with rows `p`, `q`, `r`.
    fn add_determinant(&mut self, p: Vec3, q: Vec3, r: Vec3) {
        for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
            self.add_product(p[i], q[j], r[k]);
            self.add_product(-p[i], q[k], r[j]);
        }
    }

    fn add_product(&mut self, p: f32, q: f32, r: f32) {
        // 24 + 24 bits fit the 53 of an f64. Its upper 26 bits and the 22 left over each take another 24.
        const UPPER: u64 = !((1 << 27) - 1);
        let product = f64::from(q) * f64::from(r);
        let upper = f64::from_bits(product.to_bits() & UPPER);
        for part in [product - upper, upper] {
            let value = f64::from(p) * part;
            if value != 0.0 {
                self.add(value);
            }
        }
    }

    /// Shewchuk's Grow-Expansion, leaving out terms that are 0.
    fn add(&mut self, value: f64) {
        let mut sum = value;
        let mut kept = 0;
        for i in 0..self.len {
            let error;
            (sum, error) = two_sum(sum, self.terms[i]);
            if error != 0.0 {
                self.terms[kept] = error;
                kept += 1;
            }
        }
        if sum != 0.0 {
            self.terms[kept] = sum;
            kept += 1;
        }
        self.len = kept;
    }

    /// The sum rounded to a few units in the last place; its sign is exact.
    fn value(&self) -> f64 {
        self.terms[..self.len].iter().sum()
    }
}
