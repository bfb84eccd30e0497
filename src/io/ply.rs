//! PLY, the Polygon File Format of Stanford: a header in text, then the data as text or binary of either byte order.
//!
//! ```text
//! ply
//! format ascii 1.0               # or binary_little_endian, binary_big_endian
//! comment any words
//! element vertex 3
//! property double x
//! property double y
//! property double z
//! element face 1
//! property list uchar int vertex_indices
//! end_header
//! 0 0 0
//! 1 0 0
//! 0 1 0
//! 3 0 1 2
//! ```
//!
//! - Of the element `vertex`, `x`, `y`, `z` are read, and the normal `nx`, `ny`, `nz`, the texture coordinates `s`, `t` (or `u`, `v`,
//!   with or without `texture_` before) and the colour `red`, `green`, `blue` where all of them are there; of the elements `face`
//!   and `tristrips`, the list `vertex_indices` or `vertex_index`. Each may have any type. `vertex` comes first.
//! - A list `texcoord` of `face` has the texture coordinates of its corners: a vertex becomes several where they differ. Those of
//!   vertices do not count then.
//! - Comments such as `comment TextureFile wood.png` name images; `texnumber` of `face` says which of them it shows, from 0, and all
//!   show the first where it is not there. The faces of an image are a part of the file that is called so.
//! - Colours are sRGB: numbers with a point from 0 to 1, whole ones up to the largest of their type.
//! - In `tristrips`, a triangle ends at every index from the third on, each second one turned over; −1 begins a new strip, and
//!   triangles with an index repeated only lead from one part to the next.
//! - Normals that are not finite are left to the faces around, with a warning. Colours of faces are ignored
//!   with a warning, as are elements of other names; other properties are skipped.
//! - In text, an item that finds too few values on its line goes on with the next lines; nothing may follow it on its last.
//! - What follows the last element is ignored with a warning, but numbers in a text are an error: a count is wrong then.
//!
//! Counts are never trusted: memory grows with the bytes that are there.
//!
//! Source: Greg Turk, The PLY Polygon File Format, 1994; `tristrips` as in the files of the Stanford 3D Scanning Repository;
//! `texcoord`, `texnumber` and `TextureFile` as `MeshLab` writes them.

mod body;
mod header;
mod values;
mod write;

#[cfg(test)]
mod tests;

pub use write::{write, write_triangles};

use super::mesh_file::MeshFile;
use super::mesh_reading::{Cursor, Malformed, Watch};
use crate::control::{CancelToken, Progress};
use body::read_body;
use header::{Encoding, Header};
use values::{BinaryValues, TextValues};

/// Whether the bytes begin as a PLY file does.
#[must_use]
pub fn has_keyword(bytes: &[u8]) -> bool {
    Cursor::new(bytes).word() == Some(b"ply")
}

/// Reads a PLY file from its bytes.
///
/// `progress` advances by the bytes read; setting its total is the caller's. Returns `None` when cancelled.
///
/// # Errors
/// The first place that breaks the rules above: a line of the header or the text, or a byte of binary data.
pub fn parse(
    bytes: &[u8],
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<MeshFile>, Malformed> {
    let mut cursor = Cursor::new(bytes);
    let header = Header::read(&mut cursor)?;
    let watch = Watch::new(cancel, progress);
    match header.encoding {
        Encoding::Text => read_body(&header, TextValues::new(cursor), watch),
        Encoding::LittleEndian => {
            let values = BinaryValues::<false>::new(bytes, header.body);
            read_body(&header, values, watch)
        }
        Encoding::BigEndian => {
            let values = BinaryValues::<true>::new(bytes, header.body);
            read_body(&header, values, watch)
        }
    }
}
