//! What measuring the window finds.

use serde::Serialize;

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
    /// Of it, the time until all is laid out. What follows is its drawing: shapes become triangles, and new pixels go to the device.
    pub layout_cpu_ms: Spread,
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
    /// Processor time of the frames between the two, of the thread that draws the window, until each is laid out.
    pub layout_cpu_ms: Spread,
    /// The same until each is handed to the graphics driver.
    pub own_cpu_ms: Spread,
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
    /// From the loss of the graphics device until all is there again, in a new window. In the first repeat, and in every second one from there on,
    /// it is lost between two frames, in the others in the middle of one.
    pub loss_ms: Spread,
    /// From an edit to the new picture.
    pub restarts: Vec<RestartFigures>,
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
}
