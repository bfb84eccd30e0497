//! Counting sort, for lookups from a key to all items that have it, such as from a vertex to its edges.

/// Items sorted into buckets by counting: all items of a key beside each other, in the order given, in two flat arrays.
pub struct Buckets<T = u32> {
    /// Where each bucket begins in `items`; one more entry at the end.
    starts: Vec<u32>,
    items: Vec<T>,
}

impl<T: Copy + Default> Buckets<T> {
    /// The items, each with its key below `keys`.
    ///
    /// # Panics
    /// When there are 2³² items, or a key is too large.
    pub fn new(keys: usize, items: impl Iterator<Item = (u32, T)> + Clone) -> Self {
        let mut starts = vec![0_u32; keys + 1];
        for (key, _) in items.clone() {
            starts[key as usize + 1] = starts[key as usize + 1]
                .checked_add(1)
                .expect("fewer than 2^32 items");
        }
        let mut end = 0_u32;
        for start in &mut starts {
            end = end.checked_add(*start).expect("fewer than 2^32 items");
            *start = end;
        }
        // Filled, each start moves to the end of its bucket, which is where the next one began.
        let mut sorted = vec![T::default(); end as usize];
        for (key, item) in items {
            let start = &mut starts[key as usize];
            sorted[*start as usize] = item;
            *start += 1;
        }
        starts.rotate_right(1);
        starts[0] = 0;
        Self {
            starts,
            items: sorted,
        }
    }

    /// The items of `key`.
    ///
    /// # Panics
    /// When it is too large.
    #[must_use]
    pub fn of(&self, key: usize) -> &[T] {
        &self.items[self.starts[key] as usize..self.starts[key + 1] as usize]
    }

    /// Whether there is no key.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of keys.
    #[must_use]
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_of_a_key_are_together_and_in_order() {
        let items = [(2, 10), (0, 11), (2, 12), (3, 13), (0, 14)];
        let buckets = Buckets::new(5, items.into_iter());
        let found: Vec<_> = (0..buckets.len()).map(|key| buckets.of(key)).collect();
        let expected: [&[u32]; 5] = [&[11, 14], &[], &[10, 12], &[13], &[]];
        assert_eq!(found, expected);
        assert_eq!(Buckets::<u32>::new(0, std::iter::empty()).len(), 0);
    }
}
