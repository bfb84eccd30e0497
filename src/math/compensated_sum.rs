//! Sums of `f64` whose error hardly grows with the number of terms, for means over all pixels of a picture.

/// A sum of many numbers that keeps what rounding takes from each addition and returns it at the end.
///
/// The error is about that of one rounding, however many numbers there are and in whatever order, unless they cancel.
///
/// Source: Ogita, Rump, Oishi, Accurate Sum and Dot Product, 2005, algorithm Sum2.
#[derive(Clone, Copy, Debug, Default)]
pub struct CompensatedSum {
    rounded: f64,
    lost: f64,
}

impl CompensatedSum {
    /// Adds a finite number.
    pub fn add(&mut self, value: f64) {
        let (rounded, lost) = two_sum(self.rounded, value);
        self.rounded = rounded;
        self.lost += lost;
    }

    /// The sum of all that was added.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.rounded + self.lost
    }
}

/// The rounded sum and what rounding lost, exactly. Source: Knuth, The Art of Computer Programming, vol. 2, 4.2.2.
#[inline]
#[must_use]
pub fn two_sum(p: f64, q: f64) -> (f64, f64) {
    let sum = p + q;
    let q_kept = sum - p;
    let p_kept = sum - q_kept;
    (sum, (p - p_kept) + (q - q_kept))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(values: impl IntoIterator<Item = f64>) -> f64 {
        let mut sum = CompensatedSum::default();
        values.into_iter().for_each(|value| sum.add(value));
        sum.total()
    }

    #[test]
    fn what_rounding_takes_is_not_lost() {
        // Each one alone is less than half a unit in the last place of 1e16.
        let ones = std::iter::repeat_n(1.0, 1000);
        assert_eq!(sum(std::iter::once(1e16).chain(ones)), 1e16 + 1000.0);
        assert_eq!(sum([1e60, 3.0, -1e60]), 3.0);
        assert_eq!(sum(std::iter::repeat_n(0.1, 1_000_000)), 100_000.0);
        assert_eq!(sum([]), 0.0);
    }
}
