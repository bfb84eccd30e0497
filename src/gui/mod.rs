//! The window.
pub mod orbit;
pub mod preview;
