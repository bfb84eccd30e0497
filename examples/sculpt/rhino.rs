//! The rhinoceros: a great barrel in folded armour on stubby legs, a horn on its nose.

use crate::Sculpture;
use crate::field::{
    Ball, Tube, at, ball, bell, carve, chain, ellipsoid, frame, in_frame, join, lumps, mirrored,
    ramp, round_cone, sphere, turned,
};
use glam::DVec3;

pub struct Rhino {
    horns: [Tube; 2],
    tail: Tube,
}

impl Rhino {
    pub fn new() -> Self {
        let great = Tube::through(&[
            ball(0.0, -1.06, 0.66, 0.125),
            ball(0.0, -1.14, 0.80, 0.088),
            ball(0.0, -1.185, 0.95, 0.056),
            ball(0.0, -1.185, 1.10, 0.028),
            ball(0.0, -1.15, 1.23, 0.010),
        ]);
        let small = Tube::through(&[
            ball(0.0, -0.89, 0.80, 0.095),
            ball(0.0, -0.92, 0.90, 0.055),
            ball(0.0, -0.925, 1.01, 0.012),
        ]);
        let tail = Tube::through(&[
            ball(0.0, 0.98, 0.90, 0.06),
            ball(0.0, 1.07, 0.78, 0.036),
            ball(0.01, 1.09, 0.60, 0.026),
            ball(0.02, 1.08, 0.48, 0.024),
            ball(0.025, 1.08, 0.42, 0.040),
            ball(0.03, 1.09, 0.34, 0.010),
        ]);
        Self {
            horns: [great, small],
            tail,
        }
    }

    fn head(&self, p: DVec3) -> f64 {
        let m = mirrored(p);
        let d = face(m);
        let d = join(d, self.horns[0].distance(p), 0.05);
        join(d, self.horns[1].distance(p), 0.05)
    }
}

impl Sculpture for Rhino {
    const BOX: [DVec3; 2] = [at(-0.75, -1.3, 0.0), at(0.75, 1.2, 1.4)];
    const TRIANGLES: usize = 34_000;

    fn field(&self, p: DVec3) -> f64 {
        let p = p - at(0.0, 0.04, 0.0);
        let on_head = turned(p, at(0.0, -0.40, 0.0), 0.25 * ramp(-0.30, -0.70, p.y));
        let m = mirrored(p);
        let trunk = hide(p, m, on_head);
        let d = join(trunk, legs(m), 0.07);
        let d = join(d, self.tail.distance(p), 0.04);
        join(d, self.head(on_head), 0.06)
    }
}

/// The trunk with its plates of armour.
fn hide(p: DVec3, m: DVec3, head: DVec3) -> f64 {
    let barrel = ellipsoid(p, at(0.0, 0.24, 0.69), at(0.47, 0.62, 0.42));
    let shoulder = ellipsoid(m, at(0.12, -0.22, 0.74), at(0.33, 0.33, 0.42));
    let hump = ellipsoid(p, at(0.0, -0.28, 0.98), at(0.20, 0.26, 0.20));
    let rump = ellipsoid(m, at(0.10, 0.68, 0.74), at(0.34, 0.33, 0.40));
    let thigh = round_cone(
        m,
        ball(0.25, 0.66, 0.60, 0.22),
        ball(0.26, 0.66, 0.34, 0.155),
    );
    let arm = round_cone(
        m,
        ball(0.25, -0.26, 0.56, 0.20),
        ball(0.26, -0.28, 0.34, 0.15),
    );
    let neck = round_cone(
        head,
        ball(0.0, -0.36, 0.78, 0.33),
        ball(0.0, -0.66, 0.76, 0.25),
    );
    let trunk = [shoulder, hump, rump, thigh, arm]
        .iter()
        .fold(barrel, |d, &part| join(d, part, 0.14));
    let trunk = join(trunk, neck, 0.16);
    if trunk.abs() > 0.15 {
        return trunk;
    }
    trunk - folds(m) - 0.006 * lumps(p, 0.055)
}

/// Relief of the armour: each plate swells towards its edge and drops into a groove.
fn folds(m: DVec3) -> f64 {
    let lean = 0.25 * (m.z - 0.7);
    let arch = libm::cos((m.z - 0.72) * 3.5);
    let shoulder = plate(m.y - 0.03 - 0.09 * arch);
    let rump = plate(0.47 - 0.09 * arch - m.y);
    let collar = plate(m.y + 0.50 + lean);
    let throat = plate(m.y + 0.68 + lean);
    let flank = ramp(0.12, 0.26, m.x);
    let elbow =
        plate(0.47 + 0.15 * (m.y + 0.25) - m.z) * ramp(0.02, -0.06, m.y) * ramp(-0.52, -0.42, m.y);
    let knee = plate(0.52 - 0.20 * (m.y - 0.65) - m.z) * ramp(0.42, 0.52, m.y);
    (shoulder + rump + 0.9 * collar + 0.6 * throat) * ramp(0.30, 0.46, m.z)
        + 0.8 * flank * (elbow + knee)
}

/// The step from a plate (at negative `d`) down into its groove.
fn plate(d: f64) -> f64 {
    let edge = ramp(0.028, -0.028, d);
    0.034 * edge * libm::exp((d / 0.10).min(0.0)) - 0.026 * bell(d - 0.022, 0.034)
}

fn legs(m: DVec3) -> f64 {
    let fore = leg(
        m,
        &[
            ball(0.26, -0.28, 0.50, 0.17),
            ball(0.26, -0.27, 0.30, 0.130),
            ball(0.26, -0.29, 0.12, 0.125),
        ],
    );
    let hind = leg(
        m,
        &[
            ball(0.27, 0.64, 0.50, 0.20),
            ball(0.27, 0.72, 0.30, 0.130),
            ball(0.27, 0.68, 0.12, 0.125),
        ],
    );
    fore.min(hind)
}

/// A pillar of a leg on a round foot with three great nails.
fn leg(m: DVec3, joints: &[Ball; 3]) -> f64 {
    let ankle = joints[2].centre;
    let pad = round_cone(
        m,
        Ball {
            centre: ankle + at(0.0, -0.005, -0.04),
            radius: 0.125,
        },
        Ball {
            centre: ankle + at(0.0, -0.02, -0.12),
            radius: 0.150,
        },
    );
    let mut d = join(chain(m, joints), pad, 0.05);
    d += 0.005 * libm::sin(m.z * 95.0) * bell(m.z - 0.24, 0.08);
    for angle in [-0.85_f64, 0.0, 0.85] {
        let outward = at(libm::sin(angle), -libm::cos(angle), 0.0);
        let q = in_frame(
            m,
            ankle + outward * 0.142 + at(0.0, -0.02, -0.12),
            frame(outward + 0.25 * DVec3::Z, DVec3::Z),
        );
        let nail = ellipsoid(q, DVec3::ZERO, at(0.036, 0.085, 0.052));
        d = join(d, nail, 0.004);
    }
    d
}

fn face(m: DVec3) -> f64 {
    let skull = round_cone(
        m,
        ball(0.0, -0.64, 0.80, 0.215),
        ball(0.0, -0.82, 0.70, 0.175),
    );
    let muzzle = round_cone(
        m,
        ball(0.0, -0.80, 0.68, 0.165),
        ball(0.0, -1.08, 0.55, 0.135),
    );
    let cheek = ellipsoid(m, at(0.09, -0.74, 0.64), at(0.11, 0.16, 0.15));
    let lip = ellipsoid(m, at(0.0, -1.15, 0.50), at(0.105, 0.10, 0.085));
    let chin = round_cone(
        m,
        ball(0.04, -0.86, 0.54, 0.10),
        ball(0.02, -1.07, 0.45, 0.07),
    );
    let brow = round_cone(
        m,
        ball(0.125, -0.93, 0.785, 0.032),
        ball(0.165, -0.82, 0.81, 0.036),
    );
    let mut d = join(skull, muzzle, 0.08);
    d = join(d, cheek, 0.08);
    d = join(d, join(lip, chin, 0.03), 0.05);
    d = join(d, brow, 0.06);
    d = carve(
        d,
        ellipsoid(m, at(0.185, -0.905, 0.735), at(0.05, 0.065, 0.042)),
        0.03,
    );
    d = join(d, sphere(m, ball(0.140, -0.880, 0.738, 0.042)), 0.012);
    let mouth = chain(
        m,
        &[
            ball(0.0, -1.27, 0.47, 0.008),
            ball(0.12, -1.12, 0.475, 0.008),
            ball(0.165, -0.98, 0.53, 0.006),
        ],
    );
    d = carve(d, mouth, 0.03);
    d = carve(
        d,
        ellipsoid(m, at(0.105, -1.175, 0.585), at(0.030, 0.042, 0.026)),
        0.03,
    );
    join(d, ear(m), 0.03)
}

/// A trumpet-shaped ear, open to the front and the side.
fn ear(m: DVec3) -> f64 {
    let axes = frame(at(0.45, 0.12, 0.88), at(0.5, -0.85, 0.0));
    let q = in_frame(m, at(0.13, -0.56, 0.93), axes);
    let cup = ellipsoid(q, at(0.12, 0.0, 0.0), at(0.15, 0.055, 0.072));
    let hollow = ellipsoid(q, at(0.15, 0.050, 0.0), at(0.11, 0.050, 0.048));
    carve(cup, hollow, 0.02)
}
