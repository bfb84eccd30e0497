//! Error against run time: renders a scene again and again, measures each render as it goes on, and tells people and programs
//! what came out: [`Study`] measures, [`to_json`] and its neighbours write. Reads and writes no files.

mod chart;
mod csv;
mod digits;
mod fit;
mod json;
mod markdown;
mod reference;
mod study;
mod summary;
mod svg;
#[cfg(test)]
mod test_data;
mod trial;

pub use chart::{Axis, Chart, Curve, Level, Line, Point, Unit};
pub use csv::to_csv;
pub use digits::{percent, three_digits};
pub use fit::TimeTo;
pub use json::to_json;
pub use markdown::to_markdown;
pub use reference::{Origin, Reference};
pub use study::{Machine, Study, Variant};
pub use summary::{Efficiency, Estimated, Honesty, Summary, SummaryPoint};
pub use svg::to_chart;
pub use trial::{Measurement, Trial, TrueErrors};
