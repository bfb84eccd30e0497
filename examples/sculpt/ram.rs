//! The ram: a woolly barrel on thin legs, a bare face with a Roman nose, and great curled horns.

use crate::Sculpture;
use crate::field::{
    Ball, Tube, at, ball, carve, chain, ellipsoid, frame, in_frame, join, lumps, mirrored, ramp,
    round_cone, sphere, turned,
};
use glam::DVec3;
use std::f64::consts::TAU;

pub struct Ram {
    horn: Tube,
}

impl Ram {
    pub fn new() -> Self {
        Self {
            horn: Tube::new(horn_nodes()),
        }
    }

    fn head(&self, p: DVec3) -> f64 {
        let m = mirrored(p);
        let forelock =
            ellipsoid(p, at(0.0, -0.82, 1.315), at(0.07, 0.12, 0.055)) - 0.016 * lumps(p, 0.055);
        join(join(face(m), forelock, 0.02), self.horn(m), 0.02)
    }

    /// The horn with its growth rings, which fade out towards the smooth tip.
    fn horn(&self, p: DVec3) -> f64 {
        const RINGS: f64 = 30.0;
        let near = self.horn.nearest(p);
        let groove = (0.5 + 0.5 * libm::cos(RINGS * TAU * near.along)).powi(2);
        near.distance + 0.013 * groove * ramp(1.0, 0.6, near.along)
    }
}

impl Sculpture for Ram {
    const BOX: [DVec3; 2] = [at(-0.75, -1.0, 0.0), at(0.75, 1.1, 1.6)];
    const TRIANGLES: usize = 38_000;

    fn field(&self, p: DVec3) -> f64 {
        let p = p - at(0.0, 0.15, 0.0);
        let on_head = turned(p, at(0.0, -0.50, 0.0), 0.22 * ramp(-0.45, -0.70, p.y));
        let body = fleece(p, mirrored(p));
        let body = join(body, legs(mirrored(p)), 0.03);
        join(body, self.head(on_head), 0.025)
    }
}

/// A spiral that leaves the top of the skull backwards, curls down and forward past the cheek,
/// and drifts outwards all the while.
fn horn_nodes() -> Vec<Ball> {
    const NODES: usize = 56;
    const TURNS: f64 = 1.15;
    let [axis, up, back] = frame(at(0.92, -0.36, -0.06), at(0.0, -0.25, 1.0));
    let base = at(0.098, -0.80, 1.325);
    let wide = 0.235;
    let hub = base - up * wide;
    let node = |i: usize| {
        let t = i as f64 / (NODES - 1) as f64;
        let (sine, cosine) = libm::sincos(TAU * TURNS * t);
        let swing = wide - 0.095 * t;
        let centre = hub + axis * (0.40 * t) + (up * cosine - back * sine) * swing;
        Ball {
            centre,
            radius: 0.012 + 0.074 * libm::pow(1.0 - t, 0.70),
        }
    };
    (0..NODES).map(node).collect()
}

fn fleece(p: DVec3, m: DVec3) -> f64 {
    let barrel = ellipsoid(p, at(0.0, 0.12, 0.77), at(0.36, 0.58, 0.35));
    let rump = ellipsoid(p, at(0.0, 0.44, 0.80), at(0.33, 0.32, 0.35));
    let chest = ellipsoid(p, at(0.0, -0.30, 0.78), at(0.31, 0.31, 0.38));
    let thigh = round_cone(
        m,
        ball(0.19, 0.44, 0.66, 0.19),
        ball(0.19, 0.53, 0.46, 0.09),
    );
    let upper_arm = round_cone(
        m,
        ball(0.18, -0.30, 0.66, 0.17),
        ball(0.165, -0.32, 0.46, 0.08),
    );
    let neck = round_cone(
        p,
        ball(0.0, -0.36, 0.90, 0.29),
        ball(0.0, -0.68, 1.14, 0.165),
    );
    let tail = round_cone(p, ball(0.0, 0.70, 0.90, 0.08), ball(0.0, 0.78, 0.68, 0.06));
    let trunk = [rump, chest, thigh, upper_arm, neck]
        .iter()
        .fold(barrel, |d, &part| join(d, part, 0.12));
    let trunk = join(trunk, tail, 0.05);
    if trunk > 0.1 {
        return trunk;
    }
    trunk - 0.045 * lumps(p, 0.105) + 0.015
}

fn legs(m: DVec3) -> f64 {
    let fore = leg(
        m,
        &[
            ball(0.165, -0.31, 0.56, 0.09),
            ball(0.160, -0.335, 0.35, 0.056),
            ball(0.160, -0.325, 0.29, 0.041),
            ball(0.160, -0.30, 0.13, 0.038),
        ],
    );
    let hind = leg(
        m,
        &[
            ball(0.19, 0.50, 0.56, 0.11),
            ball(0.185, 0.635, 0.37, 0.056),
            ball(0.185, 0.625, 0.31, 0.043),
            ball(0.185, 0.58, 0.13, 0.038),
        ],
    );
    fore.min(hind)
}

/// A leg down to the fetlock, with a cloven hoof under it.
fn leg(m: DVec3, joints: &[Ball; 4]) -> f64 {
    let fetlock = joints[3].centre;
    let below = |y: f64, z: f64, radius: f64| Ball {
        centre: fetlock + at(0.0, y, z),
        radius,
    };
    let hoof = round_cone(m, below(-0.015, -0.055, 0.042), below(-0.045, -0.13, 0.062));
    let cleft = round_cone(m, below(-0.075, -0.045, 0.008), below(-0.11, -0.14, 0.018));
    let foot = carve(
        join(hoof, sphere(m, below(0.0, 0.0, 0.045)), 0.015),
        cleft,
        0.012,
    );
    join(chain(m, joints), foot, 0.02)
}

fn face(m: DVec3) -> f64 {
    let skull = round_cone(
        m,
        ball(0.0, -0.74, 1.23, 0.135),
        ball(0.0, -0.87, 1.18, 0.115),
    );
    let nose = round_cone(
        m,
        ball(0.0, -0.88, 1.19, 0.095),
        ball(0.0, -1.065, 1.00, 0.062),
    );
    let bridge = ellipsoid(m, at(0.0, -0.985, 1.135), at(0.048, 0.10, 0.07));
    let jaw = round_cone(
        m,
        ball(0.03, -0.81, 1.10, 0.085),
        ball(0.015, -1.04, 0.945, 0.046),
    );
    let brow = round_cone(
        m,
        ball(0.080, -0.915, 1.265, 0.032),
        ball(0.115, -0.82, 1.28, 0.04),
    );
    let mut d = join(join(skull, nose, 0.06), jaw, 0.05);
    d = join(d, bridge, 0.05);
    d = join(d, brow, 0.03);
    d = carve(
        d,
        ellipsoid(m, at(0.140, -0.920, 1.213), at(0.036, 0.060, 0.036)),
        0.025,
    );
    d = join(d, sphere(m, ball(0.098, -0.908, 1.215, 0.040)), 0.010);
    let mouth = chain(
        m,
        &[
            ball(0.0, -1.13, 0.948, 0.008),
            ball(0.055, -1.06, 0.955, 0.008),
            ball(0.085, -0.97, 1.00, 0.005),
        ],
    );
    d = carve(d, mouth, 0.02);
    let nostril = round_cone(
        m,
        ball(0.016, -1.125, 1.00, 0.009),
        ball(0.045, -1.11, 1.03, 0.011),
    );
    d = carve(d, nostril, 0.02);
    join(d, ear(m), 0.03)
}

/// A leaf-shaped ear, standing out sideways below the horn.
fn ear(m: DVec3) -> f64 {
    let axes = frame(at(0.80, 0.12, -0.50), at(0.1, -0.85, 0.5));
    let q = in_frame(m, at(0.10, -0.79, 1.20), axes);
    let leaf = ellipsoid(q, at(0.10, 0.0, 0.0), at(0.12, 0.030, 0.052));
    let hollow = ellipsoid(q, at(0.12, 0.034, 0.0), at(0.085, 0.028, 0.032));
    carve(leaf, hollow, 0.015)
}
