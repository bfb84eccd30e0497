//! The window, driven by the names on its controls, by keys and by the mouse: the parts of it one by one, and the real program.
//!
//! Tests that draw run on software Vulkan without a display, and fail without an adapter.
#![cfg(feature = "gui")]

mod closing;
mod compare;
mod contributions;
mod driver;
mod dropping;
mod edit;
mod everyday;
mod import;
mod keeping;
mod live;
mod materials;
mod missing;
mod mouse;
mod names;
mod noise;
mod panel;
mod pictures;
mod preview;
mod real;
mod region;
mod reload;
mod renders;
mod reports;
mod restoring;
mod seeing;
mod shortcuts;
mod slow_disk;
mod start;
mod stopping;
mod tools;
mod tree;
