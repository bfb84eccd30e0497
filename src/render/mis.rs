//! Multiple importance sampling.

/// Weight of a sample taken with density `pdf` where another strategy would have taken it with density `other`.
///
/// Source: Veach, Robust Monte Carlo Methods for Light Transport Simulation, 1997: the power heuristic of exponent 2.
pub fn power_heuristic(pdf: f32, other: f32) -> f32 {
    // As a ratio, so that large densities do not overflow.
    let ratio = other / pdf;
    1.0 / (1.0 + ratio * ratio)
}
