//! On which side of a line a point lies, with an exact sign: what triangulation rests on.

use crate::math::DVec2;

/// Twice the signed area of the triangle `a`, `b`, `c`: positive when they run counter-clockwise.
///
/// The sign is exact unless a product underflows, the magnitude is rounded. Coordinates should be near 1.
/// Source: Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates, 1997 (the bound
/// and the expansion sums; the stages between the first and the exact one are left out).
pub(super) fn orientation(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    const UNIT_ROUNDOFF: f64 = f64::EPSILON * 0.5;
    const BOUND: f64 = (3.0 + 16.0 * UNIT_ROUNDOFF) * UNIT_ROUNDOFF;
    let left = (a.x - c.x) * (b.y - c.y);
    let right = (a.y - c.y) * (b.x - c.x);
    let difference = left - right;
    if difference.abs() >= BOUND * (left.abs() + right.abs()) {
        difference
    } else {
        exact_orientation(a, b, c)
    }
}

/// The same by exact arithmetic; the value is the leading term of the exact sum.
fn exact_orientation(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let products = [
        (a.x, b.y),
        (-a.y, b.x),
        (b.x, c.y),
        (-b.y, c.x),
        (c.x, a.y),
        (-c.y, a.x),
    ];
    // Terms that do not overlap, in increasing magnitude; their sum is exact.
    let mut sum = [0.0; 12];
    let mut terms = 0;
    for (p, q) in products {
        let (high, low) = exact_product(p, q);
        for mut carry in [low, high] {
            for term in &mut sum[..terms] {
                (carry, *term) = exact_sum(carry, *term);
            }
            sum[terms] = carry;
            terms += 1;
        }
    }
    let leading = sum.iter().rev().find(|&&term| term != 0.0);
    leading.copied().unwrap_or(0.0)
}

/// `p · q` as a rounded product and its error.
fn exact_product(p: f64, q: f64) -> (f64, f64) {
    let product = p * q;
    (product, p.mul_add(q, -product))
}

/// `p + q` as a rounded sum and its error (Knuth's two-sum).
fn exact_sum(p: f64, q: f64) -> (f64, f64) {
    let sum = p + q;
    let q_part = sum - p;
    let p_part = sum - q_part;
    (sum, (p - p_part) + (q - q_part))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points one or two units in the last place off a line, where rounded arithmetic errs: integers give the truth.
    #[test]
    fn the_sign_is_that_of_exact_integers() {
        const UNIT: f64 = 1.0 / (1_u64 << 52) as f64;
        let base: i128 = 1 << 51;
        let (b, c) = (
            [12 * (1 << 48), 12 * (1 << 48)],
            [24 * (1 << 47) + 3, 24 * (1 << 47) + 3],
        );
        for dx in 0..64 {
            for dy in 0..64 {
                let a: [i128; 2] = [base + dx, base + dy];
                let expected = (a[0] - c[0]) * (b[1] - c[1]) - (a[1] - c[1]) * (b[0] - c[0]);
                let point = |p: [i128; 2]| DVec2::new(p[0] as f64, p[1] as f64) * UNIT;
                for value in [
                    orientation(point(a), point(b), point(c)),
                    exact_orientation(point(a), point(b), point(c)),
                ] {
                    assert_eq!(value.total_cmp(&0.0), expected.cmp(&0), "{dx} {dy}");
                }
            }
        }
    }
}
