//! Looking at the renderer from outside: what it takes and how it compares. Knows scenes and what rendering makes of them;
//! prints nothing.

pub mod bench;
pub mod report;
