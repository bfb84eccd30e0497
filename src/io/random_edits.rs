//! Files changed at random, for tests that nothing they say breaks a reader.

/// Numbers below what is asked for, the same in every run. Source: Numerical Recipes (linear congruential generator).
pub fn numbers() -> impl FnMut(usize) -> usize {
    let mut state = 1_u32;
    move |below| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as usize % below
    }
}

/// Calls `check` with each of the `files` after a few edits, so many `times` with others: bytes and bits changed, bytes left out, the
/// end cut off.
pub fn for_each<B: AsRef<[u8]>>(files: &[B], times: usize, mut check: impl FnMut(Vec<u8>)) {
    let mut next = numbers();
    for file in files {
        for _ in 0..times {
            let mut bytes = file.as_ref().to_vec();
            for _ in 0..=next(3) {
                let at = next(bytes.len());
                match next(4) {
                    0 => bytes[at] = [0, 1, 0x7f, 0x80, 0xff][next(5)],
                    1 => bytes[at] ^= 1 << next(8),
                    2 => drop(bytes.remove(at)),
                    // Enough is left for the edits that follow.
                    _ => bytes.truncate(at + 4),
                }
            }
            check(bytes);
        }
    }
}
