//! Curves on two logarithmic axes, as error against run time is shown: data in, an SVG picture out.
//!
//! The picture has a white ground, no scripts and nothing from outside, and the same chart gives the same bytes. The legend
//! stands beside the plot, where it covers no data. Fonts differ between viewers, so places are kept for wide ones.

mod drawing;
mod layout;
mod scale;

use crate::analysis::bench::Spread;
use layout::Layout;
pub use scale::Unit;

/// What a picture shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// The line above the plot.
    pub title: String,
    /// From left to right.
    pub x: Axis,
    /// From bottom to top.
    pub y: Axis,
    /// In the legend's order; later ones are drawn over earlier ones. The legend leaves out those without anything to show.
    pub curves: Vec<Curve>,
    /// Heights to compare the curves with.
    pub levels: Vec<Level>,
    /// Small lines below the plot: the machine, versions, settings. They are not wrapped; a long one widens the picture.
    pub caption: Vec<String>,
}

/// What an axis stands for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axis {
    /// Its name; the unit is at the numbers.
    pub label: String,
    /// How its numbers are written.
    pub unit: Unit,
}

/// Points joined by a line, with a marker at each.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// What the legend calls it.
    pub name: String,
    /// A second, smaller line in the legend, such as a fitted slope.
    pub note: Option<String>,
    /// Chooses colour and shape of the markers, so that curves that belong together can share both; 28 of them differ.
    pub color: usize,
    /// How it is drawn. Markers are filled on solid lines and hollow on others.
    pub line: Line,
    /// Whether the points' ranges are shown: as a band along the curve, or as a bar where there is but one point.
    pub band: bool,
    /// In the order in which they are joined.
    pub points: Vec<Point>,
}

/// Repeated measurements at one place of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// From left to right.
    pub x: f64,
    /// From bottom to top: the marker is at the median. An end of the range that a logarithmic axis has no place for is at
    /// the plot's edge.
    pub y: Spread,
}

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Line {
    /// Without gaps.
    #[default]
    Solid,
    /// Strokes.
    Dashed,
    /// Dots.
    Dotted,
}

/// A dashed horizontal line.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Where it is.
    pub y: f64,
    /// What stands at its right end, such as "3 %".
    pub label: String,
}

impl Chart {
    /// The picture, an SVG document: about 900 by 560, and larger only where texts need it.
    ///
    /// Never panics. Points and levels that are not above zero, not finite, or outside their own range are left out, and
    /// the caption says how many.
    #[must_use]
    pub fn to_svg(&self) -> String {
        drawing::draw(self, &Layout::of(self))
    }

    /// The curves of which there is something to show.
    fn shown_curves(&self) -> impl Iterator<Item = &Curve> {
        let curves = self.curves.iter();
        curves.filter(|curve| curve.shown().next().is_some())
    }

    /// The levels that are drawn.
    fn shown_levels(&self) -> impl Iterator<Item = &Level> {
        self.levels.iter().filter(|level| has_place(level.y))
    }

    /// Points and levels that are left out.
    fn left_out(&self) -> usize {
        let points = self.curves.iter();
        let points = points.map(|curve| curve.points.len() - curve.shown().count());
        points.sum::<usize>() + self.levels.len() - self.shown_levels().count()
    }
}

impl Curve {
    /// The points that are drawn.
    pub fn shown(&self) -> impl Iterator<Item = &Point> {
        self.points.iter().filter(|Point { x, y }| {
            // Also tells ranges with an end that is not a number.
            let in_range = y.min <= y.median && y.median <= y.max;
            has_place(*x) && has_place(y.median) && in_range
        })
    }
}

/// Whether a logarithmic axis has a place for a number.
fn has_place(value: f64) -> bool {
    value > 0.0 && value.is_finite()
}

#[cfg(test)]
mod tests;
