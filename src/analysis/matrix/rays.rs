//! Rays that graze, aim at cracks, run along planes and start on what they left.
//!
//! [`scenes`] has what they meet and [`aims`] where they go; [`escapes`], [`self_hits`], [`agreement`] and [`double_precision`] have
//! the measurements, and `controls` what these must notice.

mod agreement;
mod aims;
#[cfg(test)]
mod controls;
mod double_precision;
mod escapes;
mod scenes;
mod self_hits;

use rayon::prelude::*;

use super::meshes::by_every_structure;
use super::stage::{different_pixels, glass, improper_pixels, phong, showroom};
use super::{Bar, Case, Effort};
use crate::geometry::shapes::Random;
use crate::math::DVec3;
use crate::scene::Mode;

pub const CASES: &[Case] = &[
    Case {
        name: "no ray escapes a closed body",
        tried: "rays aimed at edges and corners from within, alone, in packets and in fans, at several offsets and sizes, both trees: rays that get out",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: escapes::escapes,
    },
    Case {
        name: "no ray hits what it leaves",
        tried: "reflected rays off triangles up to 10,000 of their sizes from the middle: rays that meet their own triangle",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: self_hits::self_hits,
    },
    Case {
        name: "the trees answer like brute force",
        tried: "rays that miss, hit, graze and run along 22 scenes, one of them of copies, alone, in packets and in fans: answers of either tree that are not the same bits",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: agreement::unlike_brute_force,
    },
    Case {
        name: "brute force in double precision",
        tried: "rays at 24 scenes by another test of triangles, but for at most 1 % that pass within 1e-6 of a size from an edge: answers that differ",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: double_precision::unlike_double_precision,
    },
    Case {
        name: "slivers in double precision",
        tried: "rays at and beside slivers of aspect 1e-6, by another test of triangles: share of answers that are not the same triangle",
        bar: Bar::AtMost(1e-5),
        is_timed: false,
        measure: double_precision::slivers_unlike_double_precision,
    },
    Case {
        name: "rays along the axes",
        tried: "26 directions with both zeros, origins on the planes of the tree: answers that are not those of brute force",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: agreement::along_the_axes,
    },
    Case {
        name: "length of directions",
        tried: "directions times 2^±40: answers other than the same triangle at the same point",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: agreement::scaled_directions,
    },
    Case {
        name: "eye on and in geometry",
        tried: "eyes inside bodies, on faces, edges and corners, every structure: pixels that differ or are no light",
        bar: Bar::Exactly(0.0),
        is_timed: false,
        measure: eye_in_geometry,
    },
];

/// A random index below `count`.
fn below(random: &mut Random, count: usize) -> usize {
    usize::try_from(random.bits() % count as u64).expect("below a usize")
}

/// Counts over `count` rays, in parallel, each lot of them with random numbers of its own.
fn count_over(count: u64, of_lot: impl Fn(&mut Random, u64) -> u64 + Sync) -> f64 {
    const LOT: u64 = 4096;
    let lots = count.div_ceil(LOT);
    let sum: u64 = (0..lots)
        .into_par_iter()
        .map(|lot| of_lot(&mut Random::new(lot ^ 0x5eed), LOT.min(count - lot * LOT)))
        .sum();
    sum as f64
}

fn eye_in_geometry(_: Effort) -> f64 {
    let mut count = 0.0;
    for material in [phong(0.5, 0.4, 30.0), glass(1.5)] {
        for mode in [Mode::Direct, Mode::Path, Mode::Normals] {
            let mut scene = showroom(24, 18);
            scene.materials.insert("matt".into(), material.clone());
            scene.render.mode = mode;
            let mesh = &scene.meshes["matt"];
            let [a, b, c] = mesh.corners(17);
            let eyes = [
                a,
                (a + b) / 2.0,
                (a + b + c) / 3.0,
                DVec3::new(-1.3, 0.2, -0.3),
            ];
            for eye in eyes {
                scene.camera.eye = eye;
                scene.camera.target = DVec3::new(1.2, 0.9, -0.2);
                let pictures = by_every_structure(&mut scene);
                count += improper_pixels(&pictures[0]);
                let others = pictures[1..].iter();
                count += others
                    .map(|other| different_pixels(&pictures[0], other))
                    .sum::<f64>();
            }
        }
    }
    count
}
