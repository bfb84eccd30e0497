//! What readers of mesh formats share: a place in a text, the error that names a place, what becomes of faces, warnings, and
//! reports of how far reading came.

mod colors;
mod cursor;
mod malformed;
mod notes;
mod solid;
mod split;
mod tally;
#[cfg(test)]
pub mod trials;
mod watch;

pub use colors::Colors;
pub use cursor::{Cursor, number, whole};
pub use malformed::{List, Malformed, Place};
pub use notes::{Seen, numbers};
pub use solid::{Solid, all_faces};
pub use split::{Attribute, TooMany, split};
pub use tally::{Corner, Tally};
pub use watch::{Watch, capacity};
