//! The median and the range of repeated measurements, which assume nothing about their distribution.

/// The middle and the ends of repeated measurements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// As many are smaller as are larger; of an even number the mean of the two in the middle.
    pub median: f64,
    /// The smallest.
    pub min: f64,
    /// The largest.
    pub max: f64,
}

impl Spread {
    /// The spread of these values; `None` where there are none.
    #[must_use]
    pub fn of(mut values: Vec<f64>) -> Option<Self> {
        values.sort_by(f64::total_cmp);
        let (&min, &max) = (values.first()?, values.last()?);
        let last = values.len() - 1;
        Some(Self {
            median: f64::midpoint(values[last / 2], values[last.div_ceil(2)]),
            min,
            max,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(Spread::of(vec![]), None);
        for (values, median) in [
            (vec![3.0], 3.0),
            (vec![4.0, 1.0], 2.5),
            (vec![5.0, 1.0, 2.0], 2.0),
            (vec![5.0, 1.0, 2.0, 4.0], 3.0),
        ] {
            let spread = Spread::of(values.clone()).expect("has values");
            assert_eq!(spread.median, median, "{values:?}");
            assert!(values.contains(&spread.min) && values.contains(&spread.max));
            assert!(values.iter().all(|v| (spread.min..=spread.max).contains(v)));
        }
    }
}
