//! What the window knows about what effects cost: measured in the background when somebody asks.

use crate::analysis::cost::Costs;
use crate::control::Progress;
use crate::scene::Scene;

/// Pairs of renders for each effect: enough for an interval, and few enough to wait for.
pub const PAIRS: usize = 8;

/// What is known.
#[derive(Debug, Default)]
pub enum CostState {
    /// Nothing.
    #[default]
    Unknown,
    /// They are being measured.
    Measuring(Progress),
    /// They were measured.
    Known {
        /// Of this scene.
        scene: Box<Scene>,
        /// What they are.
        costs: Box<Costs>,
    },
    /// They cannot be measured, for this reason.
    Failed(String),
}
