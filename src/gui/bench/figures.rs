//! What measuring the window finds, for people and for programs.

use std::fmt::Write as _;

use serde::Serialize;

/// Processor time of the interface in a frame that is to be kept, in milliseconds.
const FRAME_BAR: f64 = 4.0;
/// Time from asking for a cancel until no thread renders, in milliseconds.
const CANCEL_BAR: f64 = 50.0;
/// Time from an edit to the first new tile, in milliseconds.
const RESTART_BAR: f64 = 100.0;

/// Measurements of one thing, in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// How many there are.
    pub count: usize,
    /// Half are at most this.
    pub median: f64,
    /// 99 of 100 are at most this; with fewer than 100 that is the largest.
    pub p99: f64,
    /// The largest.
    pub largest: f64,
}

impl Spread {
    /// The spread of `values`; all 0 where there are none.
    #[must_use]
    pub fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let Some(&largest) = values.last() else {
            return Self::default();
        };
        // The nearest rank.
        let rank = |share: f64| {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a rank from 1 to the count"
            )]
            let rank = (share * values.len() as f64).ceil() as usize;
            values[rank.clamp(1, values.len()) - 1]
        };
        Self {
            count: values.len(),
            median: rank(0.5),
            p99: rank(0.99),
            largest,
        }
    }
}

/// Frames while all cores render.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameFigures {
    /// What the user does meanwhile.
    pub while_user: &'static str,
    /// Processor time of the thread that draws the window, in a frame.
    pub cpu_ms: Spread,
    /// Of it, the time until the frame is handed to the graphics driver. The rest is the driver's: where the processor draws, it sends all
    /// pixels to the display on this thread, which takes the longer the less the display gets of the processor.
    pub own_cpu_ms: Spread,
    /// From the start of a frame to that of the next. Nobody waits for frames where the user only watches.
    pub interval_ms: Spread,
}

/// How quickly Live follows an edit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RestartFigures {
    /// What is edited.
    pub edit: &'static str,
    /// From the edit until the first new tile is in the window's hands.
    pub tile_ms: Spread,
    /// Until the frame that shows it is drawn.
    pub screen_ms: Spread,
}

/// All that was measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct WindowFigures {
    /// What was rendered.
    pub scene: String,
    /// Its triangles.
    pub triangles: u64,
    /// Processor, threads and system.
    pub machine: String,
    /// What draws the window.
    pub adapter: String,
    /// Whether that is the processor itself.
    pub is_software: bool,
    /// Size of the window in pixels.
    pub window: [u32; 2],
    /// Frames while all cores render.
    pub frames: Vec<FrameFigures>,
    /// From asking for a cancel until no thread renders.
    pub cancel_ms: Spread,
    /// From the loss of the graphics device until all is there again, in a new window. Half of them are lost between two frames, half in the
    /// middle of one.
    pub loss_ms: Spread,
    /// From an edit to the new picture.
    pub restarts: Vec<RestartFigures>,
}

impl WindowFigures {
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
        let mut row = |name: &str, spread: &Spread, bar: Option<f64>| {
            let bar = bar.map_or_else(String::new, |bar| {
                let verdict = if spread.p99 <= bar { "kept" } else { "missed" };
                format!("  ≤ {bar:3} {verdict}")
            });
            let _ = writeln!(
                text,
                "{name:58}{:6}{:9.2}{:9.2}{:9.2}{bar}",
                spread.count, spread.median, spread.p99, spread.largest
            );
        };
        let heading = ["count", "median", "99 %", "largest"];
        let mut lines = Vec::new();
        for FrameFigures {
            while_user, cpu_ms, ..
        } in &self.frames
        {
            let name = format!("processor time of a frame while the user {while_user}");
            lines.push((name, cpu_ms, Some(FRAME_BAR)));
        }
        for FrameFigures {
            while_user,
            own_cpu_ms,
            ..
        } in &self.frames
        {
            let name = format!("of it without the driver's while the user {while_user}");
            lines.push((name, own_cpu_ms, Some(FRAME_BAR)));
        }
        for FrameFigures {
            while_user,
            interval_ms,
            ..
        } in &self.frames
        {
            let name = format!("time between frames while the user {while_user}");
            lines.push((name, interval_ms, None));
        }
        let name = "from cancel until nothing renders".to_owned();
        lines.push((name, &self.cancel_ms, Some(CANCEL_BAR)));
        for RestartFigures { edit, tile_ms, .. } in &self.restarts {
            let name = format!("from {edit} to the first new tile");
            lines.push((name, tile_ms, Some(RESTART_BAR)));
        }
        for RestartFigures {
            edit, screen_ms, ..
        } in &self.restarts
        {
            let name = format!("from {edit} until that is drawn");
            lines.push((name, screen_ms, Some(RESTART_BAR)));
        }
        let name = "from losing the graphics device until all is there again".to_owned();
        lines.push((name, &self.loss_ms, None));
        for (name, spread, bar) in &lines {
            row(name, spread, *bar);
        }
        let [count, median, p99, largest] = heading;
        let heading = format!(
            "{:58}{count:>6}{median:>9}{p99:>9}{largest:>9}  bar for 99 %\n",
            "milliseconds"
        );
        let at = text.find("\n\n").map_or(0, |at| at + 2);
        text.insert_str(at, &heading);
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_those_of_the_values() {
        let spread = Spread::of((1..=200).rev().map(f64::from).collect());
        assert_eq!((spread.count, spread.median), (200, 100.0));
        assert_eq!((spread.p99, spread.largest), (198.0, 200.0));
        let few = Spread::of(vec![3.0, 1.0, 2.0]);
        assert_eq!((few.median, few.p99, few.largest), (2.0, 3.0, 3.0));
        assert_eq!(Spread::of(Vec::new()), Spread::default());
    }

    #[test]
    fn figures_are_told_beside_their_bars() {
        let figures = WindowFigures {
            scene: "room.toml".to_owned(),
            window: [1280, 800],
            frames: vec![FrameFigures {
                while_user: "watches",
                cpu_ms: Spread::of(vec![1.0, 5.0]),
                own_cpu_ms: Spread::of(vec![1.0, 3.0]),
                interval_ms: Spread::of(vec![33.0]),
            }],
            cancel_ms: Spread::of(vec![12.0]),
            ..WindowFigures::default()
        };
        let text = figures.describe();
        let line = |start: &str| text.lines().find(|line| line.starts_with(start)).unwrap();
        assert!(line("milliseconds").ends_with("bar for 99 %"));
        assert!(
            line("processor time of a frame while the user watches")
                .ends_with("5.00  ≤   4 missed")
        );
        assert!(line("of it without the driver's").ends_with("3.00  ≤   4 kept"));
        assert!(line("time between frames").ends_with("33.00"));
        assert!(line("from cancel").ends_with("12.00  ≤  50 kept"));
    }
}
