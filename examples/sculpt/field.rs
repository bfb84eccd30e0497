//! The vocabulary of implicit surfaces the creatures are sculpted from.
//!
//! A field maps a point to a signed length: negative inside, positive outside, zero on the skin.
//! Most fields here are distances or close bounds of them; the mesher only needs the sign, and a
//! gradient near the skin that is not far from length one.

use glam::{DVec2, DVec3};

/// A sphere; also a joint of a limb or a node of a [`Tube`].
#[derive(Clone, Copy)]
pub struct Ball {
    pub centre: DVec3,
    pub radius: f64,
}

pub const fn ball(x: f64, y: f64, z: f64, radius: f64) -> Ball {
    Ball {
        centre: DVec3::new(x, y, z),
        radius,
    }
}

pub const fn at(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

pub fn sphere(p: DVec3, b: Ball) -> f64 {
    p.distance(b.centre) - b.radius
}

/// An axis-aligned ellipsoid: first-order distance, exact on the skin.
pub fn ellipsoid(p: DVec3, centre: DVec3, radii: DVec3) -> f64 {
    let scaled = (p - centre) / radii;
    let level = scaled.length();
    let slope = (scaled / radii).length();
    if slope < 1e-9 {
        return -radii.min_element();
    }
    level * (level - 1.0) / slope
}

/// The hull of two balls. See [`nearest_on_cone`].
pub fn round_cone(p: DVec3, a: Ball, b: Ball) -> f64 {
    nearest_on_cone(p, a, b).0
}

/// Distance to the hull of two balls, and where between them (0 to 1) it is measured.
///
/// The hull is the union of the balls interpolated from `a` to `b`; the nearest of them lies not
/// straight below the point but shifted towards the thicker end by the cone's slope.
fn nearest_on_cone(p: DVec3, a: Ball, b: Ball) -> (f64, f64) {
    let axis = b.centre - a.centre;
    let length = axis.length();
    let along = (p - a.centre).dot(axis) / length;
    let off = ((p - a.centre).length_squared() - along * along)
        .max(0.0)
        .sqrt();
    let sine = ((a.radius - b.radius) / length).clamp(-0.999, 0.999);
    let shifted = along - off * sine / (1.0 - sine * sine).sqrt();
    let t = (shifted / length).clamp(0.0, 1.0);
    let radius = a.radius + t * (b.radius - a.radius);
    let overshoot = along - t * length;
    // Not `hypot`: no overflow is near, and this is the innermost loop.
    ((overshoot * overshoot + off * off).sqrt() - radius, t)
}

/// A limb: round cones from joint to joint.
pub fn chain(p: DVec3, joints: &[Ball]) -> f64 {
    joints
        .windows(2)
        .map(|pair| round_cone(p, pair[0], pair[1]))
        .fold(f64::INFINITY, f64::min)
}

/// Union with a fillet about `blend` wide (polynomial smooth minimum).
pub fn join(a: f64, b: f64, blend: f64) -> f64 {
    let overlap = (blend - (a - b).abs()).max(0.0);
    a.min(b) - overlap * overlap / (4.0 * blend)
}

/// Intersection with a rounded edge.
pub fn meet(a: f64, b: f64, blend: f64) -> f64 {
    -join(-a, -b, blend)
}

/// Takes `tool` away from `body`, rounding the rim.
pub fn carve(body: f64, tool: f64, blend: f64) -> f64 {
    meet(body, -tool, blend)
}

/// Folds space so that what is modelled at positive x appears on both sides.
pub fn mirrored(p: DVec3) -> DVec3 {
    DVec3::new(p.x.abs(), p.y, p.z)
}

/// Rises smoothly from 0 at `from` to 1 at `to` (which may be the smaller).
pub fn ramp(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A bell of height one and the given half-width.
pub fn bell(x: f64, width: f64) -> f64 {
    libm::exp(-(x / width).powi(2))
}

/// Rotates `p` about the vertical through `pivot`.
pub fn turned(p: DVec3, pivot: DVec3, angle: f64) -> DVec3 {
    let flat = DVec2::from_angle(angle).rotate((p - pivot).truncate());
    flat.extend(p.z - pivot.z) + pivot
}

/// Coordinates of `p` in the orthonormal frame `axes` at `origin`.
pub fn in_frame(p: DVec3, origin: DVec3, axes: [DVec3; 3]) -> DVec3 {
    let d = p - origin;
    DVec3::new(d.dot(axes[0]), d.dot(axes[1]), d.dot(axes[2]))
}

/// Two more axes for a given first one; the second lies as near to `hint` as it can.
pub fn frame(first: DVec3, hint: DVec3) -> [DVec3; 3] {
    let first = first.normalize();
    let second = hint.reject_from_normalized(first).normalize();
    [first, second, first.cross(second)]
}

/// A tapered tube along a smooth curve: horns, tails.
pub struct Tube {
    nodes: Vec<Ball>,
    hull: Ball,
}

/// The nearest part of a [`Tube`].
pub struct OnTube {
    pub distance: f64,
    /// Arc parameter: 0 at the first node, 1 at the last.
    pub along: f64,
}

impl Tube {
    /// Beyond this distance a bounding ball stands in for the tube; no fillet reaches so far.
    const FAR: f64 = 0.25;

    pub fn new(nodes: Vec<Ball>) -> Self {
        let centre = nodes.iter().map(|n| n.centre).sum::<DVec3>() / nodes.len() as f64;
        let reach = |n: &Ball| n.centre.distance(centre) + n.radius;
        let radius = nodes.iter().map(reach).fold(0.0, f64::max);
        Self {
            nodes,
            hull: Ball { centre, radius },
        }
    }

    /// A Catmull-Rom curve through the given balls, their radii included.
    pub fn through(knots: &[Ball]) -> Self {
        const STEPS: usize = 8;
        let last = knots.len() - 1;
        let nodes = (0..=last * STEPS).map(|i| {
            let k = (i / STEPS).min(last - 1);
            let t = i as f64 / STEPS as f64 - k as f64;
            let around = [k.saturating_sub(1), k, k + 1, (k + 2).min(last)].map(|j| knots[j]);
            catmull_rom(around, t)
        });
        Self::new(nodes.collect())
    }

    pub fn nearest(&self, p: DVec3) -> OnTube {
        let bound = sphere(p, self.hull);
        if bound > Self::FAR {
            return OnTube {
                distance: bound,
                along: 0.0,
            };
        }
        let mut best = OnTube {
            distance: f64::INFINITY,
            along: 0.0,
        };
        for (i, pair) in self.nodes.windows(2).enumerate() {
            let (distance, t) = nearest_on_cone(p, pair[0], pair[1]);
            if distance < best.distance {
                best = OnTube {
                    distance,
                    along: i as f64 + t,
                };
            }
        }
        best.along /= (self.nodes.len() - 1) as f64;
        best
    }

    pub fn distance(&self, p: DVec3) -> f64 {
        self.nearest(p).distance
    }
}

fn catmull_rom([a, b, c, d]: [Ball; 4], t: f64) -> Ball {
    let weights = [
        -0.5 * t + t * t - 0.5 * t.powi(3),
        1.0 - 2.5 * t * t + 1.5 * t.powi(3),
        0.5 * t + 2.0 * t * t - 1.5 * t.powi(3),
        -0.5 * t * t + 0.5 * t.powi(3),
    ];
    let knots = [a, b, c, d];
    Ball {
        centre: knots.iter().zip(weights).map(|(k, w)| k.centre * w).sum(),
        radius: knots.iter().zip(weights).map(|(k, w)| k.radius * w).sum(),
    }
}

/// A flat polygon, signed distance in its plane.
pub fn polygon(p: DVec2, corners: &[DVec2]) -> f64 {
    let mut nearest = f64::INFINITY;
    let mut inside = false;
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let (edge, to_p) = (b - a, p - a);
        let t = (to_p.dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
        nearest = nearest.min(to_p.distance_squared(edge * t));
        let straddles = (a.y > p.y) != (b.y > p.y);
        if straddles && p.x < a.x + (p.y - a.y) / edge.y * edge.x {
            inside = !inside;
        }
    }
    if inside {
        -nearest.sqrt()
    } else {
        nearest.sqrt()
    }
}

/// Rounded lumps of about the given size, touching in creases: 1 on a lump's top, 0 or less in
/// the creases. Cellular noise after Worley, "A Cellular Texture Basis Function", 1996.
pub fn lumps(p: DVec3, size: f64) -> f64 {
    let q = p / size;
    let cell = q.floor();
    let mut nearest = f64::INFINITY;
    for i in 0..27 {
        let step = DVec3::new(f64::from(i % 3), f64::from(i / 3 % 3), f64::from(i / 9)) - 1.0;
        let corner = cell + step;
        nearest = nearest.min((corner + jitter(corner) - q).length_squared());
    }
    1.0 - nearest
}

/// A random but repeatable point of the unit cube for a lattice cell.
fn jitter(cell: DVec3) -> DVec3 {
    // Steele's SplitMix64, seeded with each coordinate in turn.
    let mut state = 0_u64;
    let mut next = |coordinate: f64| {
        state = (state ^ coordinate.to_bits()).wrapping_add(0x9e37_79b9_7f4a_7c15);
        state = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        state = (state ^ (state >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        state ^= state >> 31;
        (state >> 40) as f64 / f64::from(1 << 24)
    };
    // The third coordinate must reach all three results.
    next(cell.x);
    next(cell.y);
    DVec3::new(next(cell.z), next(0.0), next(0.0))
}
