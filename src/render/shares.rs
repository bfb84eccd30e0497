//! Drawing one of many items by cumulative shares. Unlike an alias table it keeps neighbours together and gives back the unused
//! part of the random number, so that well-spread points stay well spread.

/// Appends to `shares`, for each of `weights` (finite, not negative), the share of the total in it and those before it; zeros
/// where the total is 0. Returns the total.
pub fn append_shares(weights: &[f64], shares: &mut Vec<f32>) -> f64 {
    let total: f64 = weights.iter().sum();
    let mut sum = 0.0;
    let share = |weight: &f64| {
        sum += weight;
        #[expect(clippy::cast_possible_truncation, reason = "a share")]
        let share = if total > 0.0 {
            (sum / total) as f32
        } else {
            0.0
        };
        share
    };
    shares.extend(weights.iter().map(share));
    total
}

/// The item that `u`, uniform in `[0, 1)`, stands for by cumulative `shares`, and how far into its own share `u` is: uniform in
/// `[0, 1)` again. An item without a share is never drawn, unless no item has any.
pub fn draw(shares: &[f32], u: f32) -> (usize, f32) {
    let last = shares.len() - 1;
    let item = shares.partition_point(|&share| share <= u).min(last);
    let before = if item == 0 { 0.0 } else { shares[item - 1] };
    let own = share_of(shares, item);
    let rest = if own > 0.0 { (u - before) / own } else { 0.0 };
    (item, rest.min(ONE_MINUS))
}

/// The probability that [`draw`] gives `item`.
pub fn share_of(shares: &[f32], item: usize) -> f32 {
    let before = if item == 0 { 0.0 } else { shares[item - 1] };
    shares[item] - before
}

/// The largest number below 1.
const ONE_MINUS: f32 = 1.0 - f32::EPSILON / 2.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_are_drawn_by_their_weights_and_the_rest_is_even() {
        let weights = [0.0, 3.0, 0.0, 1.0, 4.0, 0.0];
        let mut shares = Vec::new();
        assert!((append_shares(&weights, &mut shares) - 8.0).abs() < 1e-12);
        let mut counts = [0_u32; 6];
        let mut rests = [0.0; 6];
        let steps = 8000_u16;
        for step in 0..steps {
            let (item, rest) = draw(&shares, f32::from(step) / f32::from(steps));
            assert!((0.0..1.0).contains(&rest));
            counts[item] += 1;
            rests[item] += rest;
        }
        assert_eq!(counts, [0, 3000, 0, 1000, 4000, 0]);
        for item in [1, 3, 4] {
            assert!((rests[item] / counts[item] as f32 - 0.5).abs() < 1e-3);
        }
    }

    #[test]
    fn the_ends_of_the_interval_are_safe() {
        let mut shares = Vec::new();
        append_shares(&[0.0, 1e-30, 1.0, 0.0], &mut shares);
        assert_eq!(draw(&shares, 0.0).0, 1, "rare, but not impossible");
        assert_eq!(draw(&shares, f32::EPSILON).0, 2);
        assert_eq!(draw(&shares, ONE_MINUS).0, 2);
        let mut none = Vec::new();
        assert!(append_shares(&[0.0; 3], &mut none) <= 0.0);
        assert_eq!(draw(&none, 0.5), (2, 0.0));
    }
}
