use crate::math::Vec2;

/// Draws one of many items with given probabilities in constant time.
///
/// Source: Walker's alias method in the form of Vose, A Linear Algorithm for Generating Random Numbers with a Given
/// Distribution, 1991.
#[derive(Clone, Debug, Default)]
pub struct AliasTable {
    slots: Vec<Slot>,
}

#[derive(Clone, Copy, Debug)]
struct Slot {
    /// Chance to stay with this item when its slot is drawn.
    stay: f64,
    /// The item to take otherwise.
    alias: u32,
    probability: f32,
}

impl AliasTable {
    /// A table of items with probabilities in proportion to `weights`, finite and not negative. Empty where all are 0.
    pub fn new(weights: &[f64]) -> Self {
        let total: f64 = weights.iter().sum();
        if total <= 0.0 {
            return Self::default();
        }
        let mean = total / weights.len() as f64;
        #[expect(clippy::cast_possible_truncation, reason = "a probability")]
        let mut slots: Vec<Slot> = (0..)
            .zip(weights)
            .map(|(index, weight)| Slot {
                stay: weight / mean,
                alias: index,
                probability: (weight / total) as f32,
            })
            .collect();
        let (mut small, mut large): (Vec<usize>, Vec<usize>) =
            (0..slots.len()).partition(|&i| slots[i].stay < 1.0);
        while let (Some(&poor), Some(&rich)) = (small.last(), large.last()) {
            small.pop();
            slots[poor].alias = u32::try_from(rich).expect("fewer than 2³² items");
            slots[rich].stay -= 1.0 - slots[poor].stay;
            if slots[rich].stay < 1.0 {
                large.pop();
                small.push(rich);
            }
        }
        // What is left is 1 but for rounding.
        for index in small.into_iter().chain(large) {
            slots[index].stay = 1.0;
        }
        Self { slots }
    }

    pub fn is_empty(&self) -> bool {
        self.slots.is_empty()
    }

    /// The item that `u`, uniform over the unit square, stands for: one number picks the slot, the other who has it, so
    /// that rare items are as rare as they should be.
    pub fn draw(&self, u: Vec2) -> usize {
        let count = self.slots.len();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "u is in [0, 1)"
        )]
        let index = ((f64::from(u.x) * count as f64) as usize).min(count - 1);
        let slot = &self.slots[index];
        if f64::from(u.y) < slot.stay {
            index
        } else {
            slot.alias as usize
        }
    }

    /// The probability of `item`.
    pub fn probability(&self, item: usize) -> f32 {
        self.slots[item].probability
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Exact up to the resolution of a grid over `u`.
    #[test]
    fn items_are_drawn_by_their_weights() {
        let weights = [3.0, 0.0, 1.0, 0.5, 5.5, 1e-9];
        let table = AliasTable::new(&weights);
        let mut counts = [0_u32; 6];
        let steps = 1000_u16;
        let unit = |step: u16| (f32::from(step) + 0.5) / f32::from(steps);
        for x in 0..steps {
            for y in 0..steps {
                counts[table.draw(Vec2::new(unit(x), unit(y)))] += 1;
            }
        }
        for (item, weight) in weights.iter().enumerate() {
            let expected = weight / 10.0;
            let found = f64::from(counts[item]) / f64::from(steps).powi(2);
            assert!((found - expected).abs() < 1e-3, "{counts:?}");
            assert!((f64::from(table.probability(item)) - expected).abs() < 1e-7);
        }
        assert_eq!(
            counts[5], 0,
            "one in ten thousand million is not met in a million"
        );
        assert_eq!(counts[1], 0);
        assert!(AliasTable::new(&[0.0, 0.0]).is_empty() && AliasTable::new(&[]).is_empty());
    }
}
