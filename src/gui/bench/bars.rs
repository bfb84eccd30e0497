//! The bars that the figures are to keep, and all of it as a table for people and as JSON for programs.

use std::fmt::Write as _;

use serde::Serialize;

use super::figures::{Spread, WindowFigures};

/// Processor time of the interface in a frame, in milliseconds.
const FRAME_BAR: f64 = 4.0;
/// Time from asking for a cancel until no thread renders, in milliseconds.
const CANCEL_BAR: f64 = 50.0;
/// Time from an edit to the first new tile, and until that is drawn, in milliseconds.
const RESTART_BAR: f64 = 100.0;

/// A line of the table.
struct Row<'a> {
    name: String,
    spread: &'a Spread,
    /// What 99 of 100 are to be at most.
    bar: Option<f64>,
}

impl<'a> Row<'a> {
    fn new(name: impl Into<String>, spread: &'a Spread, bar: Option<f64>) -> Self {
        Self {
            name: name.into(),
            spread,
            bar,
        }
    }

    fn kept(&self) -> Option<Kept> {
        let bar = self.bar?;
        let measured = (self.spread.count > 0).then_some(self.spread.p99);
        Some(Kept {
            name: self.name.clone(),
            measured,
            bar,
            // No figure is no pass.
            passed: measured.is_some_and(|measured| measured <= bar),
        })
    }

    fn line(&self) -> String {
        let Spread {
            count,
            median,
            p99,
            largest,
        } = self.spread;
        let verdict = self.kept().map_or_else(String::new, |kept| {
            let verdict = if kept.passed { "kept" } else { "missed" };
            format!("  ≤ {:3} {verdict}", kept.bar)
        });
        format!(
            "{:58}{count:6}{median:9.2}{p99:9.2}{largest:9.2}{verdict}",
            self.name
        )
    }
}

/// Whether a bar is kept.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Kept {
    /// Of what.
    pub name: String,
    /// What 99 of 100 are at most, in milliseconds; `None` where nothing was measured.
    pub measured: Option<f64>,
    /// What it may be, in milliseconds.
    pub bar: f64,
    /// Whether it is no more.
    pub passed: bool,
}

impl WindowFigures {
    fn rows(&self) -> Vec<Row<'_>> {
        let mut rows = Vec::new();
        let bar = Some(FRAME_BAR);
        for frames in &self.frames {
            let name = format!(
                "processor time of a frame while the user {}",
                frames.while_user
            );
            rows.push(Row::new(name, &frames.cpu_ms, bar));
        }
        for frames in &self.frames {
            let name = format!(
                "of it without the driver's while the user {}",
                frames.while_user
            );
            rows.push(Row::new(name, &frames.own_cpu_ms, bar));
        }
        for frames in &self.frames {
            let name = format!("time between frames while the user {}", frames.while_user);
            rows.push(Row::new(name, &frames.interval_ms, None));
        }
        let name = "from cancel until nothing renders";
        rows.push(Row::new(name, &self.cancel_ms, Some(CANCEL_BAR)));
        let bar = Some(RESTART_BAR);
        for restart in &self.restarts {
            let name = format!("from {} to the first new tile", restart.edit);
            rows.push(Row::new(name, &restart.tile_ms, bar));
        }
        for restart in &self.restarts {
            let name = format!("from {} until that is drawn", restart.edit);
            rows.push(Row::new(name, &restart.screen_ms, bar));
        }
        let name = "from losing the graphics device until all is there again";
        rows.push(Row::new(name, &self.loss_ms, None));
        rows
    }

    /// All bars, and whether each is kept.
    #[must_use]
    pub fn bars(&self) -> Vec<Kept> {
        self.rows().iter().filter_map(Row::kept).collect()
    }

    /// Whether all are.
    #[must_use]
    pub fn keeps_all_bars(&self) -> bool {
        self.bars().iter().all(|bar| bar.passed)
    }

    /// All of it as a table.
    #[must_use]
    pub fn describe(&self) -> String {
        let software = if self.is_software {
            ", which is the processor"
        } else {
            ""
        };
        let [width, height] = self.window;
        let mut text = format!(
            "RayMini {}, {}: {} triangles, in a window of {width} × {height} pixels\n{}\ndrawn by {}{software}\n\n",
            env!("CARGO_PKG_VERSION"),
            self.scene,
            self.triangles,
            self.machine,
            self.adapter,
        );
        let [count, median, p99, largest] = ["count", "median", "99 %", "largest"];
        let _ = writeln!(
            text,
            "{:58}{count:>6}{median:>9}{p99:>9}{largest:>9}  bar for 99 %",
            "milliseconds"
        );
        for row in self.rows() {
            let _ = writeln!(text, "{}", row.line());
        }
        let bars = self.bars();
        let kept = bars.iter().filter(|bar| bar.passed).count();
        let _ = writeln!(text, "\n{kept} of {} bars are kept", bars.len());
        text
    }

    /// The same for programs: the figures, and `bars`.
    #[must_use]
    pub fn for_programs(&self) -> impl Serialize {
        #[derive(Serialize)]
        struct Told<'a> {
            #[serde(flatten)]
            figures: &'a WindowFigures,
            bars: Vec<Kept>,
        }
        Told {
            figures: self,
            bars: self.bars(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::figures::FrameFigures;
    use super::*;

    /// Frames of at most 5 ms, of which 3 are the window's own, and cancels of 12 ms.
    fn figures() -> WindowFigures {
        WindowFigures {
            scene: "room.toml".to_owned(),
            window: [1280, 800],
            frames: vec![FrameFigures {
                while_user: "watches",
                cpu_ms: Spread::of(vec![1.0, 5.0]),
                layout_cpu_ms: Spread::of(vec![0.5, 2.0]),
                own_cpu_ms: Spread::of(vec![1.0, 3.0]),
                interval_ms: Spread::of(vec![33.0]),
            }],
            cancel_ms: Spread::of(vec![12.0]),
            ..WindowFigures::default()
        }
    }

    #[test]
    fn figures_are_told_beside_their_bars() {
        let text = figures().describe();
        let line = |start: &str| text.lines().find(|line| line.starts_with(start)).unwrap();
        assert!(line("milliseconds").ends_with("bar for 99 %"));
        assert!(
            line("processor time of a frame while the user watches")
                .ends_with("5.00  ≤   4 missed")
        );
        assert!(line("of it without the driver's").ends_with("3.00  ≤   4 kept"));
        assert!(line("time between frames").ends_with("33.00"));
        assert!(line("from cancel").ends_with("12.00  ≤  50 kept"));
        assert!(text.ends_with("\n2 of 3 bars are kept\n"), "{text}");
    }

    #[test]
    fn one_missed_bar_is_told_to_programs_and_what_was_not_measured_is_missed() {
        let mut figures = figures();
        let told = serde_json::to_value(figures.for_programs()).unwrap();
        assert_eq!(told["cancel_ms"]["largest"], 12.0);
        let passed = told["bars"].as_array().unwrap().iter();
        let passed: Vec<_> = passed.map(|bar| bar["passed"].as_bool()).collect();
        assert_eq!(passed, [Some(false), Some(true), Some(true)]);
        assert!(!figures.keeps_all_bars());
        figures.frames[0].cpu_ms = Spread::of(vec![4.0]);
        assert!(figures.keeps_all_bars(), "a bar itself is kept");
        figures.cancel_ms = Spread::default();
        assert_eq!(figures.bars()[2].measured, None);
        assert!(!figures.keeps_all_bars());
    }
}
