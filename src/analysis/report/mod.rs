//! What was measured, for people to look at: plain data in, text out. Reads and writes no files.

mod chart;

pub use chart::{Axis, Chart, Curve, Level, Line, Point, Unit};
