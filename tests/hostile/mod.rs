//! What must hold of a parser whatever bytes it is given. Each function panics where something does not.
//!
//! `tests/corpus.rs` runs them over the files in `fuzz/corpus`, and the targets in `fuzz/targets`, which include this module by
//! its path, over what the fuzzer thinks of.

pub mod gltf;
pub mod mesh;
pub mod mtl;
pub mod picture;
pub mod radiance;
pub mod rays;
pub mod scene;
pub mod texture;

use peak_alloc::PeakAlloc;

/// Counts what is allocated, whether it is touched or not.
#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// What parsers may take however small the file: tables, buffers, messages.
const FREE_BYTES: usize = 1 << 20;

/// Longest message about a file, in bytes: whatever the file holds, it can be read.
const LONGEST_MESSAGE: usize = 1000;

/// What `work` returns, and the most bytes that it had allocated at any one time. Other threads must not allocate meanwhile.
fn measured<T>(work: impl FnOnce() -> T) -> (T, usize) {
    MEMORY.reset_peak_usage();
    let before = MEMORY.current_usage();
    let result = work();
    (result, MEMORY.peak_usage().saturating_sub(before))
}

/// Panics where `peak` bytes are more than `per_byte` for each of `length` bytes read, beside [`FREE_BYTES`].
fn assert_memory(peak: usize, per_byte: usize, length: usize) {
    assert!(
        peak <= per_byte * length + FREE_BYTES,
        "{peak} bytes were allocated to read {length}, {} for each",
        peak / length.max(1)
    );
}

fn assert_message(message: &str) {
    let length = message.len();
    assert!(
        (1..=LONGEST_MESSAGE).contains(&length),
        "{length} bytes of message: {}",
        message.chars().take(LONGEST_MESSAGE).collect::<String>()
    );
}
