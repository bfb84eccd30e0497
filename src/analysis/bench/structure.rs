//! What is measured against each other.

use crate::accel::Accelerator;
use crate::control::{CancelToken, Progress};
use crate::geometry::Triangle;
use crate::render::{StructureChoice, build_structure};
use crate::scene::{AcceleratorBuild, AcceleratorChoice, Choice};

/// A structure, and how it is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Structure {
    /// The wide tree, built for the fastest rays.
    Wide,
    /// The wide tree, built fast.
    WideFast,
    /// The kd-tree.
    KdTree,
    /// Brute force.
    BruteForce,
}

impl Choice for Structure {
    const ALL: &'static [(Self, &'static str)] = &[
        (Self::Wide, "wide"),
        (Self::WideFast, "wide-fast"),
        (Self::KdTree, "kd-tree"),
        (Self::BruteForce, "brute-force"),
    ];
}

impl Structure {
    /// The structure over these triangles.
    pub(super) fn build(self, triangles: Vec<Triangle>) -> Option<Accelerator> {
        let kind = match self {
            Self::Wide | Self::WideFast => AcceleratorChoice::Wide,
            Self::KdTree => AcceleratorChoice::KdTree,
            Self::BruteForce => AcceleratorChoice::BruteForce,
        };
        let build = if self == Self::WideFast {
            AcceleratorBuild::Fast
        } else {
            AcceleratorBuild::Best
        };
        let choice = StructureChoice { kind, build };
        build_structure(choice, triangles, &CancelToken::new(), &Progress::new())
    }
}
