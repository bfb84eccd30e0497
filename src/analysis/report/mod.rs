//! Error against run time: renders a scene again and again, measures each render as it goes on, and tells people and programs
//! what came out. [`ReportOptions`] say what is wanted, a [`ReportPlan`] makes renders of it and carries them out, [`Study`]
//! measures, [`to_json`] and its neighbours write.

mod chart;
mod csv;
mod date;
mod digits;
mod error;
mod files;
mod fit;
mod honesty;
mod json;
mod markdown;
mod options;
mod picture;
mod plan;
mod progress;
mod reference;
mod reference_file;
mod study;
mod summary;
mod svg;
mod target;
#[cfg(test)]
mod test_data;
mod trial;

pub use chart::{Axis, Chart, Curve, Level, Line, Point, Unit};
pub use csv::to_csv;
pub use error::{ComparisonError, ReportError};
pub use files::REPORT_FILES;
pub use fit::TimeTo;
pub use honesty::Honesty;
pub use json::to_json;
pub use markdown::to_markdown;
pub use options::{ReferenceOptions, ReportOptions, parse_radiance};
pub use plan::ReportPlan;
pub use progress::ReportProgress;
pub use reference::{Origin, Reference};
pub use study::{Machine, Study, Variant};
pub use summary::{Efficiency, Estimated, Slope, Summary, SummaryPoint};
pub use svg::to_chart;
pub use target::{Target, Took};
pub use trial::{Measurement, Trial, TrueErrors};
