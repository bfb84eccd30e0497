//! Reading binary STL, little-endian: a title, the number of triangles, and 50 bytes for each.

use super::weld::Weld;
use crate::geometry::TriangleMesh;
use crate::io::mesh_file::MeshFile;
use crate::io::mesh_reading::{Malformed, Place, Seen, Tally, Watch, numbers};
use crate::math::DVec3;

/// Bytes before the number of triangles.
pub const TITLE: usize = 80;
/// Bytes before the first triangle.
const START: usize = TITLE + 4;
/// Bytes of a triangle.
pub const FACET: usize = 50;
/// Where its corners begin and end.
const CORNERS: std::ops::Range<usize> = 12..48;

/// The number of triangles that the file states, and the bytes that follow.
fn split(bytes: &[u8]) -> Option<(u32, &[u8])> {
    let (count, facets) = bytes.get(TITLE..)?.split_first_chunk()?;
    Some((u32::from_le_bytes(*count), facets))
}

/// Whether the file is as long as a binary STL file with its number of triangles, of which it has some.
#[must_use]
pub fn has_length(bytes: &[u8]) -> bool {
    split(bytes).is_some_and(|(count, facets)| {
        let (whole, rest) = facets.as_chunks::<FACET>();
        rest.is_empty() && !whole.is_empty() && whole.len() as u64 == u64::from(count)
    })
}

/// Reads a binary file; `None` when cancelled.
pub fn parse(bytes: &[u8], mut watch: Watch) -> Result<Option<MeshFile>, Malformed> {
    let at = |byte: usize, expected: String, found: String| {
        Malformed::at(Place::Byte(byte as u64), expected, found)
    };
    let Some((count, rest)) = split(bytes) else {
        let expected = format!("the {START} bytes before the triangles of a binary STL file");
        let found = numbers(bytes.len(), "byte");
        return Err(at(bytes.len(), expected, found));
    };
    let count = count as usize;
    let (facets, _) = rest.as_chunks::<FACET>();
    if facets.len() < count {
        let expected = format!("{} of {FACET} bytes", numbers(count, "triangle"));
        return Err(at(START, expected, numbers(rest.len(), "byte")));
    }
    let mut weld = Weld::default();
    let mut tally = Tally::default();
    let mut triangles = Vec::with_capacity(count);
    let mut corners = Vec::with_capacity(3);
    let mut attributes = Seen::default();
    for (index, facet) in (0..).zip(&facets[..count]) {
        let start = START + FACET * usize::try_from(index).unwrap_or(usize::MAX);
        if watch.report_item(index, start).is_none() {
            return Ok(None);
        }
        corners.clear();
        let (numbers, _) = facet[CORNERS].as_chunks().0.as_chunks::<3>();
        for (corner, bytes) in numbers.iter().enumerate() {
            let [x, y, z] = bytes.map(|bytes| f64::from(f32::from_le_bytes(bytes)));
            let position = DVec3::new(x, y, z);
            if !position.is_finite() {
                let place = start + CORNERS.start + 12 * corner;
                let found = format!("({x}, {y}, {z})");
                return Err(at(place, "finite coordinates".to_owned(), found));
            }
            let vertex = weld.vertex(position);
            corners.push(vertex.ok_or_else(|| too_many_vertices(Place::Byte(start as u64)))?);
        }
        let place = Place::Byte(start as u64);
        if facet[CORNERS.end..] != [0, 0] {
            attributes.at(place);
        }
        tally.add_face(place, &mut corners, &weld.positions, &mut triangles);
    }
    // Cancelling comes too late here: the work is done.
    let _ = watch.report(bytes.len());
    let trailing = rest.len() - FACET * count;
    let warnings = [
        attributes.found("attributes, which may be colours, are ignored"),
        (trailing > 0).then(|| {
            format!(
                "{} after the last triangle are ignored",
                numbers(trailing, "byte")
            )
        }),
    ];
    let mesh = TriangleMesh {
        positions: weld.positions,
        triangles,
        ..TriangleMesh::default()
    };
    Ok(Some(tally.into_file(
        "STL",
        mesh,
        warnings.into_iter().flatten(),
    )))
}

/// The error at the corner for which there is no index left.
pub fn too_many_vertices(place: Place) -> Malformed {
    Malformed::at(place, "fewer than 2^32 vertices", "another")
}
