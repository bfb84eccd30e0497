//! Smooth noise for images that examples make.

/// Noise from 0 to 1 that is smooth between whole coordinates, where it is what `hash` gives.
pub fn smooth(x: f64, y: f64, hash: impl Fn(f64, f64) -> f64) -> f64 {
    let (column, row) = (x.floor(), y.floor());
    let ease = |t: f64| t * t * (3.0 - 2.0 * t);
    let (u, v) = (ease(x - column), ease(y - row));
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let above = mix(hash(column, row), hash(column + 1.0, row), u);
    let below = mix(hash(column, row + 1.0), hash(column + 1.0, row + 1.0), u);
    mix(above, below, v)
}

/// A number of `[0, 1)` that looks as if drawn at random for each `state`.
pub fn scrambled(mut state: u64) -> f64 {
    for _ in 0..3 {
        state ^= state >> 29;
        state = state.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    }
    (state >> 11) as f64 / 9_007_199_254_740_992.0
}
