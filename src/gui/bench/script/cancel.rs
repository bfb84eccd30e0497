//! How long a cancelled render goes on.

use std::time::{Duration, Instant};

use egui::Key;

use super::hands::Hands;
use super::{PATIENCE, milliseconds};
use crate::gui::app::App;

/// A render that is cancelled once it has run for a while.
#[derive(Debug)]
pub struct Cancel {
    /// How long it runs after its first tile.
    run: Duration,
    phase: Phase,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    Start,
    /// The render runs, since then with a tile.
    Run(Option<Instant>),
    Asked(Instant),
    Done,
}

impl Cancel {
    /// The one of that number: each cancels at another moment of a pass.
    pub fn new(number: usize) -> Self {
        let turn = u32::try_from(number % 7).unwrap_or_default();
        Self {
            run: Duration::from_millis(37) * turn,
            phase: Phase::Start,
        }
    }

    /// A frame begins; whether all is done.
    pub fn begin(&mut self, hands: &mut Hands<'_>) -> bool {
        match self.phase {
            Phase::Start => {
                if hands.app.render_threads() == 0 {
                    hands.press(Key::F5);
                    self.phase = Phase::Run(None);
                }
                hands.go_on();
            }
            Phase::Run(None) => {
                let picture = hands.app.picture().filter(|picture| picture.is_running());
                if picture.is_some_and(|picture| picture.first_tile.is_some()) {
                    self.phase = Phase::Run(Some(Instant::now()));
                }
                hands.go_on();
            }
            Phase::Run(Some(since)) => {
                if since.elapsed() >= self.run {
                    hands.press(Key::Escape);
                    self.phase = Phase::Asked(Instant::now());
                }
                hands.go_on();
            }
            Phase::Asked(_) => {}
            Phase::Done => return true,
        }
        false
    }

    /// A frame is laid out, in which the key was heard: waits until nothing renders.
    pub fn end(&mut self, app: &App, ctx: &egui::Context, cancels: &mut Vec<f64>) {
        if let Phase::Asked(asked) = self.phase {
            while app.render_threads() > 0 && asked.elapsed() < PATIENCE {
                std::thread::sleep(Duration::from_micros(100));
            }
            cancels.push(milliseconds(asked.elapsed()));
            self.phase = Phase::Done;
            ctx.request_repaint();
        }
    }
}
