//! What must hold of every reader of meshes.

use raymini::control::{CancelToken, Progress};
use raymini::geometry::{TriangleMesh, face_normal};
use raymini::io::{MeshFile, MeshFormat, gmsh, medit, obj, off, ply, stl};

use super::{assert_memory, assert_message, measured};

/// Reads `bytes` as OFF. A corner of a polygon stands in two bytes, and cutting the polygon takes 110.
pub fn check_off(bytes: &[u8]) {
    check(MeshFormat::Off, 96, bytes);
}

/// Reads `bytes` as OBJ. A corner of a polygon stands in two bytes, and cutting the polygon takes 130.
pub fn check_obj(bytes: &[u8]) {
    check(MeshFormat::Obj, 128, bytes);
}

/// Reads `bytes` as PLY. A corner of a polygon stands in one byte, and cutting the polygon takes 110.
pub fn check_ply(bytes: &[u8]) {
    check(MeshFormat::Ply, 192, bytes);
}

/// Reads `bytes` as STL. A vertex stands in 12 bytes; it and its place among all take up to 200.
pub fn check_stl(bytes: &[u8]) {
    check(MeshFormat::Stl, 48, bytes);
}

/// Reads `bytes` as a mesh of Medit. A tetrahedron stands in ten bytes; it and its faces take 280.
pub fn check_medit(bytes: &[u8]) {
    check(MeshFormat::Medit, 96, bytes);
}

/// Reads `bytes` as a mesh of Gmsh. A node stands in eight bytes; it and its place among all take up to 200.
pub fn check_gmsh(bytes: &[u8]) {
    check(MeshFormat::Gmsh, 96, bytes);
}

/// Reads `bytes`, taking at most `memory` bytes for each. The mesh keeps its invariant, has no more than the file, and is the same
/// when written and read again.
fn check(format: MeshFormat, memory: usize, bytes: &[u8]) {
    // Any file may be asked whether it is of any format.
    let _ = off::has_keyword(bytes) | obj::has_keyword(bytes) | ply::has_keyword(bytes);
    let _ = stl::has_keyword(bytes) | stl::has_length(bytes);
    let _ = medit::has_keyword(bytes) | gmsh::has_keyword(bytes);
    let progress = Progress::new();
    let (read, peak) = measured(|| format.parse(bytes, &CancelToken::new(), &progress));
    assert_memory(peak, memory, bytes.len());
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

    let mut written = Vec::new();
    format
        .write(mesh, &mut written)
        .expect("a vector takes all");
    let again = format.parse(&written, &CancelToken::new(), &Progress::new());
    let again = again.unwrap_or_else(|error| panic!("what is written: {error}"));
    let again = again.expect("nobody cancels");
    if format == MeshFormat::Stl {
        // It holds triangles alone.
        assert_eq!(corners(&again.mesh), corners(mesh));
    } else {
        assert_eq!(again.mesh, *mesh);
    }
    assert_eq!(again.dropped.total(), 0);

    // Of a file without vertices and faces there is nothing to cancel.
    if !mesh.positions.is_empty() {
        let cancelled = CancelToken::new();
        cancelled.cancel();
        assert_eq!(format.parse(bytes, &cancelled, &Progress::new()), Ok(None));
    }
}

fn corners(mesh: &TriangleMesh) -> Vec<impl PartialEq + std::fmt::Debug> {
    let triangles = 0..mesh.triangles.len();
    triangles.map(|index| mesh.corners(index)).collect()
}
