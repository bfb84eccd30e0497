//! STL, the stereolithography format of 3D Systems, as text or binary: triangles that share no corners.
//!
//! ```text
//! solid any name
//!   facet normal 0 0 1
//!     outer loop
//!       vertex 0 0 0
//!       vertex 1 0 0
//!       vertex 0 1 0
//!     endloop
//!   endfacet
//! endsolid any name
//! ```
//!
//! Binary: 80 bytes of any content, the number of triangles as `u32`, then 50 bytes for each: its normal and its corners as
//! twelve `f32`, and an attribute of 16 bits. All is little endian.
//!
//! - Corners of the very same position become one vertex; 0 and −0 are the same. Nothing else joins triangles in STL.
//! - Normals of facets are ignored: the order of the corners says the same, and more reliably.
//! - Binary files may begin with `solid`, too. A file is binary if its length is that of the number of triangles it states; else
//!   `solid` makes it a text, unless there is a zero byte where such a text has its first facet.
//! - In text, keywords may be capital, a loop may have more than three corners, and several solids may follow each other. Of a
//!   text that ends after a whole facet, a missing `endsolid` is a warning.
//! - Attributes, which some programs use for colours, are ignored with a warning where they are not 0.
//!
//! Source: Marshall Burns, Automated Fabrication, 1993, section 6.5.

mod binary;
mod text;
mod weld;
mod write;

#[cfg(test)]
mod tests;

pub use binary::has_length;
pub use text::has_keyword;
pub use write::write;

use super::mesh_file::MeshFile;
use super::mesh_reading::{Malformed, Watch};
use crate::control::{CancelToken, Progress};

/// Reads an STL file from its bytes.
///
/// `progress` advances by the bytes read; setting its total is the caller's. Returns `None` when cancelled.
///
/// # Errors
/// The first line of a text, or byte of a binary file, that breaks the rules above.
pub fn parse(
    bytes: &[u8],
    cancel: &CancelToken,
    progress: &Progress,
) -> Result<Option<MeshFile>, Malformed> {
    let watch = Watch::new(cancel, progress);
    if has_length(bytes) || !has_keyword(bytes) {
        binary::parse(bytes, watch)
    } else {
        text::parse(bytes, watch)
    }
}
