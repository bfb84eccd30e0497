use raymini::control::{CancelToken, Progress};
use raymini::geometry::face_normal;
use raymini::io::off::{has_keyword, parse, write};
use raymini::io::{Malformed, MeshFile};

use super::{assert_memory, assert_message, measured};

/// Bytes of memory per byte of text: a corner of a polygon stands in two bytes, and cutting the polygon takes 110.
const MEMORY: usize = 96;

/// Reads `bytes` as OFF. The mesh keeps its invariant, has no more than the text, and is the same when written and read again.
pub fn check(bytes: &[u8]) {
    let _ = has_keyword(bytes);
    let progress = Progress::new();
    let (read, peak) = measured(|| parse(bytes, &CancelToken::new(), &progress));
    assert_memory(peak, MEMORY, bytes.len());
    let file = match read {
        Ok(file) => file.expect("nobody cancels"),
        Err(error) => return assert_message(&error.to_string()),
    };
    assert_eq!(progress.done(), bytes.len() as u64);
    let MeshFile {
        mesh,
        faces,
        polygons,
        dropped,
        warnings,
        ..
    } = &file;
    assert_eq!(mesh.validate(), Ok(()));
    for index in 0..mesh.triangles.len() {
        assert!(face_normal(mesh.corners(index)).is_some(), "{index}");
    }
    assert!(mesh.positions.len() + mesh.triangles.len() <= bytes.len());
    assert!(polygons + dropped.too_few_corners <= *faces && dropped.total() <= *faces);
    for warning in warnings {
        assert_message(warning);
    }

    let mut text = Vec::new();
    write(mesh, &mut text).expect("a vector takes all");
    let again = read_again(&text).unwrap_or_else(|error| panic!("what is written: {error}"));
    assert_eq!(again.mesh, *mesh);
    assert_eq!(again.dropped.total(), 0);

    // Of a file without vertices and faces there is nothing to cancel.
    if !mesh.positions.is_empty() {
        let cancelled = CancelToken::new();
        cancelled.cancel();
        assert_eq!(parse(bytes, &cancelled, &Progress::new()), Ok(None));
    }
}

fn read_again(text: &[u8]) -> Result<MeshFile, Malformed> {
    let read = parse(text, &CancelToken::new(), &Progress::new());
    read.map(|file| file.expect("nobody cancels"))
}
