//! The gargoyle: a horned, winged grotesque, squatting on its haunches, its forepaws planted
//! between its feet.

use crate::Sculpture;
use crate::field::{
    Ball, Tube, at, ball, bell, carve, chain, ellipsoid, frame, in_frame, join, meet, mirrored,
    polygon, ramp, round_cone, sphere, turned,
};
use glam::{DVec2, DVec3};

pub struct Gargoyle {
    horn: Tube,
    tail: Tube,
    wing: Wing,
}

impl Gargoyle {
    pub fn new() -> Self {
        let horn = Tube::through(&[
            ball(0.09, -0.24, 1.33, 0.058),
            ball(0.15, -0.22, 1.43, 0.046),
            ball(0.20, -0.13, 1.51, 0.033),
            ball(0.20, -0.02, 1.56, 0.020),
            ball(0.17, 0.07, 1.60, 0.010),
        ]);
        let tail = Tube::through(&[
            ball(0.0, 0.42, 0.20, 0.13),
            ball(0.06, 0.62, 0.08, 0.085),
            ball(0.30, 0.78, 0.06, 0.065),
            ball(0.62, 0.74, 0.05, 0.054),
            ball(0.84, 0.48, 0.05, 0.045),
            ball(0.90, 0.18, 0.07, 0.037),
            ball(0.86, -0.06, 0.18, 0.029),
            ball(0.80, -0.14, 0.33, 0.022),
        ]);
        Self {
            horn,
            tail,
            wing: Wing::new(),
        }
    }
}

impl Sculpture for Gargoyle {
    const BOX: [DVec3; 2] = [at(-1.15, -0.85, 0.0), at(1.15, 0.95, 1.95)];
    const TRIANGLES: usize = 44_000;

    fn field(&self, p: DVec3) -> f64 {
        let m = mirrored(p);
        let on_head = turned(p, at(0.0, -0.10, 0.0), 0.15 * ramp(0.95, 1.15, p.z));
        let mut d = torso(p, m);
        d = join(d, arm(m), 0.05);
        d = join(d, leg(m), 0.05);
        d = join(d, self.wing.field(m), 0.05);
        d = join(d, spines(p), 0.025);
        d = join(d, self.tail.distance(p).min(barb(p)), 0.05);
        let h = mirrored(on_head);
        let head = join(face(h), self.horn.distance(h), 0.025);
        join(d, head, 0.06)
    }
}

fn torso(p: DVec3, m: DVec3) -> f64 {
    let pelvis = ellipsoid(p, at(0.0, 0.26, 0.26), at(0.27, 0.28, 0.27));
    let belly = round_cone(p, ball(0.0, 0.24, 0.34, 0.25), ball(0.0, 0.06, 0.66, 0.235));
    let chest = ellipsoid(p, at(0.0, 0.02, 0.84), at(0.29, 0.24, 0.25));
    let pec = ellipsoid(m, at(0.11, -0.17, 0.84), at(0.13, 0.07, 0.10));
    let shoulder = ellipsoid(m, at(0.30, -0.01, 0.92), at(0.135, 0.14, 0.13));
    let hunch = ellipsoid(m, at(0.10, 0.15, 0.98), at(0.17, 0.15, 0.14));
    let neck = round_cone(
        p,
        ball(0.0, -0.02, 1.00, 0.17),
        ball(0.0, -0.18, 1.18, 0.13),
    );
    let mut d = join(pelvis, belly, 0.12);
    d = join(d, chest, 0.12);
    d = join(d, pec, 0.04);
    d = join(d, shoulder, 0.06);
    d = join(d, hunch, 0.06);
    d = join(d, neck, 0.08);
    // Ribs of the belly, like the scutes of a crocodile.
    let front = ramp(0.05, -0.12, p.y) * ramp(0.20, 0.10, m.x) * ramp(0.78, 0.70, p.z);
    d + 0.010 * front * (1.0 - libm::sin(p.z * 36.0).abs())
}

fn arm(m: DVec3) -> f64 {
    let upper = chain(
        m,
        &[
            ball(0.33, -0.02, 0.90, 0.11),
            ball(0.365, -0.02, 0.74, 0.100),
            ball(0.37, -0.04, 0.56, 0.068),
        ],
    );
    let biceps = ellipsoid(m, at(0.355, -0.09, 0.73), at(0.068, 0.055, 0.11));
    let triceps = ellipsoid(m, at(0.385, 0.055, 0.74), at(0.065, 0.055, 0.12));
    let elbow = round_cone(
        m,
        ball(0.375, 0.0, 0.56, 0.055),
        ball(0.39, 0.07, 0.55, 0.022),
    );
    let upper = join(join(join(upper, biceps, 0.03), triceps, 0.03), elbow, 0.03);
    let fore = chain(
        m,
        &[
            ball(0.37, -0.05, 0.55, 0.066),
            ball(0.34, -0.17, 0.39, 0.084),
            ball(0.24, -0.38, 0.12, 0.052),
        ],
    );
    let palm = ellipsoid(m, at(0.23, -0.43, 0.065), at(0.085, 0.09, 0.06));
    let mut d = join(join(upper, fore, 0.03), palm, 0.04);
    for (angle, reach) in [(-0.55_f64, 0.15), (-0.1, 0.17), (0.35, 0.16), (1.2, 0.12)] {
        d = join(d, toe(m, at(0.23, -0.45, 0.0), angle, reach), 0.02);
    }
    d
}

fn leg(m: DVec3) -> f64 {
    let thigh = chain(
        m,
        &[
            ball(0.20, 0.26, 0.26, 0.20),
            ball(0.36, 0.04, 0.40, 0.150),
            ball(0.46, -0.14, 0.45, 0.088),
        ],
    );
    let kneecap = ellipsoid(m, at(0.475, -0.205, 0.465), at(0.055, 0.045, 0.065));
    let shin = chain(
        m,
        &[
            ball(0.465, -0.14, 0.44, 0.085),
            ball(0.475, -0.05, 0.26, 0.070),
            ball(0.47, 0.02, 0.10, 0.056),
        ],
    );
    let calf = ellipsoid(m, at(0.49, 0.02, 0.28), at(0.075, 0.075, 0.12));
    let thigh = join(join(thigh, kneecap, 0.04), calf, 0.03);
    let foot = round_cone(
        m,
        ball(0.47, 0.02, 0.06, 0.065),
        ball(0.48, -0.20, 0.045, 0.075),
    );
    let mut d = join(join(thigh, shin, 0.03), foot, 0.04);
    for (angle, reach) in [(-0.40_f64, 0.17), (0.1, 0.19), (0.6, 0.17)] {
        d = join(d, toe(m, at(0.48, -0.22, 0.0), angle, reach), 0.02);
    }
    d
}

/// A knuckled toe and its claw, pointing `angle` away from straight ahead.
fn toe(m: DVec3, root: DVec3, angle: f64, reach: f64) -> f64 {
    let ahead = at(libm::sin(angle), -libm::cos(angle), 0.0);
    let joint = |along: f64, height: f64, radius: f64| Ball {
        centre: root + ahead * (along * reach) + at(0.0, 0.0, height),
        radius,
    };
    let digit = chain(
        m,
        &[
            joint(0.2, 0.05, 0.035),
            joint(0.65, 0.06, 0.036),
            joint(0.95, 0.03, 0.030),
        ],
    );
    let claw = chain(
        m,
        &[
            joint(1.0, 0.04, 0.022),
            joint(1.25, 0.03, 0.015),
            joint(1.5, 0.006, 0.004),
        ],
    );
    join(digit, claw, 0.008)
}

/// A crest of spikes down the back.
fn spines(p: DVec3) -> f64 {
    const ROW: [(f64, f64, f64); 6] = [
        (0.24, 1.10, 0.075),
        (0.31, 0.97, 0.085),
        (0.345, 0.83, 0.085),
        (0.40, 0.68, 0.08),
        (0.465, 0.53, 0.07),
        (0.53, 0.39, 0.06),
    ];
    ROW.iter()
        .map(|&(y, z, size)| {
            let root = ball(0.0, y - 0.03, z - 0.02, 0.5 * size);
            round_cone(p, root, ball(0.0, y + size, z + 0.7 * size, 0.006))
        })
        .fold(f64::INFINITY, f64::min)
}

/// The spade at the end of the tail.
fn barb(p: DVec3) -> f64 {
    let axes = frame(at(-0.30, -0.15, 0.94), at(0.3, -1.0, 0.0));
    let q = in_frame(p, at(0.80, -0.14, 0.33), axes);
    let half_width = 0.10 * (1.0 - q.x / 0.22) - 0.25 * ramp(0.04, -0.06, q.x);
    let thickness = 0.014 + 0.022 * bell(q.z, 0.03);
    meet(0.6 * (q.z.abs() - half_width), q.y.abs() - thickness, 0.015)
}

fn face(m: DVec3) -> f64 {
    let skull = ellipsoid(m, at(0.0, -0.24, 1.24), at(0.175, 0.19, 0.165));
    let muzzle = round_cone(
        m,
        ball(0.0, -0.36, 1.165, 0.105),
        ball(0.0, -0.47, 1.145, 0.090),
    );
    let snout = ellipsoid(m, at(0.0, -0.535, 1.20), at(0.065, 0.05, 0.045));
    let jaw = round_cone(
        m,
        ball(0.07, -0.28, 1.10, 0.085),
        ball(0.02, -0.49, 1.045, 0.060),
    );
    let cheek = ellipsoid(m, at(0.120, -0.33, 1.165), at(0.055, 0.085, 0.05));
    let brow = chain(
        m,
        &[
            ball(0.018, -0.42, 1.280, 0.030),
            ball(0.09, -0.405, 1.318, 0.034),
            ball(0.160, -0.325, 1.345, 0.018),
        ],
    );
    let mut d = join(skull, muzzle, 0.05);
    d = join(d, cheek, 0.08);
    d = join(d, snout, 0.03);
    d = join(d, jaw, 0.03);
    // Angry eyes: the sockets slant down towards the nose.
    let socket = in_frame(
        m,
        at(0.096, -0.415, 1.258),
        frame(at(0.9, 0.2, 0.35), DVec3::Z),
    );
    d = carve(
        d,
        ellipsoid(socket, DVec3::ZERO, at(0.072, 0.040, 0.055)),
        0.02,
    );
    d = join(d, brow, 0.035);
    let pupil = sphere(m, ball(0.092, -0.412, 1.252, 0.018));
    d = join(
        d,
        carve(sphere(m, ball(0.088, -0.368, 1.254, 0.046)), pupil, 0.006),
        0.006,
    );
    let mouth = chain(
        m,
        &[
            ball(0.0, -0.57, 1.105, 0.026),
            ball(0.07, -0.50, 1.105, 0.024),
            ball(0.14, -0.36, 1.145, 0.010),
        ],
    );
    d = carve(d, mouth, 0.012);
    let tusk = round_cone(
        m,
        ball(0.060, -0.525, 1.075, 0.022),
        ball(0.064, -0.535, 1.160, 0.005),
    );
    let fang = round_cone(
        m,
        ball(0.030, -0.535, 1.140, 0.017),
        ball(0.030, -0.540, 1.085, 0.004),
    );
    let molar = round_cone(
        m,
        ball(0.100, -0.445, 1.150, 0.018),
        ball(0.102, -0.455, 1.090, 0.004),
    );
    d = join(d, tusk.min(fang).min(molar), 0.005);
    d = carve(
        d,
        ellipsoid(m, at(0.032, -0.58, 1.205), at(0.018, 0.025, 0.015)),
        0.012,
    );
    join(d, ear(m), 0.03)
}

/// A long pointed ear, hollow towards the front.
fn ear(m: DVec3) -> f64 {
    let axes = frame(at(0.80, 0.25, 0.50), at(0.1, -0.95, 0.25));
    let q = in_frame(m, at(0.13, -0.22, 1.25), axes);
    let half_width = 0.085 * (1.0 - q.x / 0.30) * ramp(-0.08, 0.08, q.x);
    let cup = q.y - 2.5 * q.z * q.z;
    let blade = meet(q.z.abs() - half_width, cup.abs() - 0.018, 0.02);
    0.8 * meet(blade, -q.x - 0.02, 0.02)
}

/// A bat's wing, drawn flat and then bent: first axis outwards, second upwards, third its depth.
struct Wing {
    outline: Vec<DVec2>,
}

const SHOULDER: DVec2 = DVec2::new(0.0, 0.0);
const WRIST: DVec2 = DVec2::new(0.40, 0.66);
const THUMB: DVec2 = DVec2::new(0.44, 0.80);
/// Fingertips from the leading edge inwards; the last one is where the membrane meets the flank.
const TIPS: [DVec2; 5] = [
    DVec2::new(0.98, 0.56),
    DVec2::new(0.98, 0.10),
    DVec2::new(0.74, -0.24),
    DVec2::new(0.42, -0.38),
    DVec2::new(0.0, -0.42),
];

impl Wing {
    fn new() -> Self {
        const STEPS: usize = 10;
        /// How far the trailing edge is drawn in between two fingers, towards the wrist.
        const SCALLOP: f64 = 0.18;
        let mut outline = vec![SHOULDER, WRIST];
        for pair in TIPS.windows(2) {
            for i in 0..STEPS {
                let t = i as f64 / STEPS as f64;
                let chord = pair[0].lerp(pair[1], t);
                outline.push(chord.lerp(WRIST, SCALLOP * 4.0 * t * (1.0 - t)));
            }
        }
        outline.push(TIPS[4]);
        Self { outline }
    }

    fn field(&self, m: DVec3) -> f64 {
        let axes = frame(at(0.93, 0.36, 0.0), DVec3::Z);
        let mut q = in_frame(m, at(0.10, 0.20, 0.92), axes);
        // The wing bends back towards its tips and leans forward towards its top.
        let flat = q.truncate();
        q.z -= 0.22 * q.x * q.x - 0.06 * (q.y - 0.2);
        let skin = polygon(flat, &self.outline);
        if skin > 0.2 || q.z.abs() > 0.3 {
            return skin.max(q.z.abs() - 0.1);
        }
        let fingers = TIPS[..4].iter().map(|&tip| {
            let knuckle = WRIST.lerp(tip, 0.5) + (tip - WRIST).perp() * 0.05;
            chain(
                q,
                &[
                    on_wing(WRIST, 0.034),
                    on_wing(knuckle, 0.026),
                    on_wing(tip, 0.010),
                ],
            )
        });
        let fingers = fingers.fold(f64::INFINITY, f64::min);
        // The membrane sags back between the fingers.
        let sag = 0.035 * (1.0 - bell(fingers.max(0.0), 0.09));
        let sheet = meet(skin, (q.z + sag).abs() - 0.014, 0.012);
        let d = join(sheet, fingers, 0.035);
        let arm = chain(
            q,
            &[
                on_wing(SHOULDER, 0.075),
                on_wing(DVec2::new(0.24, 0.26), 0.055),
                on_wing(WRIST, 0.042),
            ],
        );
        let thumb = round_cone(q, on_wing(WRIST, 0.036), on_wing(THUMB, 0.010));
        0.85 * join(join(d, arm, 0.03), thumb, 0.02)
    }
}

fn on_wing(p: DVec2, radius: f64) -> Ball {
    Ball {
        centre: p.extend(0.0),
        radius,
    }
}
