//! Looking at the renderer from outside: what it takes and how it compares. Knows scenes and what rendering makes of them;
//! prints nothing.

pub mod bench;
pub mod contributions;
pub mod cost;
mod difference;
mod flip;
pub mod hazards;
pub mod matrix;
mod metrics;
pub mod pilot;
pub mod proofs;
pub mod report;

pub use difference::{scaled_difference, signed_difference};
pub use flip::{mean_flip, mean_flip_unless};
pub use metrics::{LocatedDifference, Metrics, SizesDiffer, SquaredErrors, percentile_999_between};
