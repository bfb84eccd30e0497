//! What tests of every mesh reader do.

use super::Malformed;
use crate::control::{CancelToken, Progress};
use crate::geometry::shapes::{self, Random};
use crate::geometry::{TriangleMesh, face_normal};
use crate::io::mesh_file::MeshFile;
use std::io::{self, Write};
use std::time::Instant;

/// A reader.
pub type Parse = fn(&[u8], &CancelToken, &Progress) -> Result<Option<MeshFile>, Malformed>;

/// What the reader makes of the bytes. The mesh keeps its invariant and has no triangle without area; progress ends at the end.
pub fn read(parse: Parse, bytes: &[u8]) -> Result<MeshFile, Malformed> {
    let progress = Progress::new();
    let file = parse(bytes, &CancelToken::new(), &progress)?.expect("nobody cancelled");
    assert_eq!(file.mesh.validate(), Ok(()));
    for index in 0..file.mesh.triangles.len() {
        assert!(face_normal(file.mesh.corners(index)).is_some(), "{index}");
    }
    assert_eq!(progress.done(), bytes.len() as u64);
    Ok(file)
}

/// [`read`] of bytes that are right.
pub fn read_right(parse: Parse, bytes: &[u8]) -> MeshFile {
    read(parse, bytes)
        .unwrap_or_else(|error| panic!("{error} in {}", String::from_utf8_lossy(bytes)))
}

/// Meshes that are written read back the same.
pub fn assert_written_is_read(
    write: fn(&TriangleMesh, &mut dyn Write) -> io::Result<()>,
    parse: Parse,
) {
    for mesh in [shapes::icosphere(2), TriangleMesh::default()] {
        let mut bytes = Vec::new();
        write(&mesh, &mut bytes).expect("a vector takes all");
        assert_eq!(read_right(parse, &bytes).mesh, mesh);
    }
}

/// What the reader says is wrong with the bytes.
pub fn error(parse: Parse, bytes: &[u8]) -> String {
    match read(parse, bytes) {
        Ok(file) => panic!("{file:?} from {}", String::from_utf8_lossy(bytes)),
        Err(error) => error.to_string(),
    }
}

/// The area of a closed surface, and the volume inside.
pub fn area_and_volume(file: &MeshFile) -> (f64, f64) {
    let corners = (0..file.mesh.triangles.len()).map(|index| file.mesh.corners(index));
    corners.fold((0.0, 0.0), |(area, volume), [a, b, c]| {
        let double_area = (b - a).cross(c - a).length();
        (area + double_area / 2.0, volume + a.dot(b.cross(c)) / 6.0)
    })
}

/// The corners of a cube of edge 1 in the order of x, y, z as bits, and its middle.
pub const CUBE: [[f64; 3]; 9] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [0.0, 1.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.5, 0.5, 0.5],
];

/// Three ways to fill it with tetrahedra, of no common orientation: one amid four corners; around a diagonal; around the middle.
pub const FILLINGS: [&[[u32; 4]]; 3] = [
    &[
        [0, 3, 5, 6],
        [1, 0, 3, 5],
        [2, 0, 3, 6],
        [4, 0, 5, 6],
        [7, 3, 5, 6],
    ],
    &[
        [0, 1, 3, 7],
        [0, 1, 5, 7],
        [0, 2, 3, 7],
        [0, 2, 6, 7],
        [0, 4, 5, 7],
        [0, 4, 6, 7],
    ],
    &[
        [8, 0, 1, 3],
        [8, 0, 2, 3],
        [8, 4, 5, 7],
        [8, 4, 6, 7],
        [8, 0, 1, 5],
        [8, 0, 4, 5],
        [8, 2, 3, 7],
        [8, 2, 6, 7],
        [8, 0, 2, 6],
        [8, 0, 4, 6],
        [8, 1, 3, 7],
        [8, 1, 5, 7],
    ],
];

/// Cancelling stops the reader.
pub fn assert_cancels(parse: Parse, bytes: &[u8]) {
    let cancel = CancelToken::new();
    cancel.cancel();
    assert_eq!(parse(bytes, &cancel, &Progress::new()), Ok(None));
}

/// Reads the files with pieces replaced by `scraps` and other bytes: none panics or hangs, and what is taken is valid.
pub fn assert_mutations_are_read_or_refused(parse: Parse, files: &[Vec<u8>], scraps: &[&[u8]]) {
    for_mutations(files, scraps, |bytes| {
        let _ = read(parse, bytes);
    });
}

/// Calls `check` with the files with pieces replaced by `scraps` and other bytes; none hangs.
pub fn for_mutations(files: &[Vec<u8>], scraps: &[&[u8]], check: impl Fn(&[u8])) {
    let mut random = Random::new(7);
    let mut below = |bound: usize| {
        usize::try_from(random.bits() % bound as u64).expect("below a number of that type")
    };
    let start = Instant::now();
    for _ in 0..20_000 {
        let mut bytes = files[below(files.len())].clone();
        for _ in 0..=below(4) {
            let from = below(bytes.len() + 1);
            let to = (from + below(5)).min(bytes.len());
            let any = u8::try_from(below(256)).expect("a byte");
            let scrap = match below(scraps.len() + 1) {
                0 => &[any],
                scrap => scraps[scrap - 1],
            };
            bytes.splice(from..to, scrap.iter().copied());
        }
        check(&bytes);
    }
    assert!(start.elapsed().as_secs() < 60);
}
