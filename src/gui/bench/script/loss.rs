//! How soon a window is there again whose graphics device was lost.

use std::time::Instant;

use super::hands::Hands;
use super::milliseconds;
use crate::gui::app::App;
use crate::gui::picture::Picture;

/// A graphics device that is shut down.
#[derive(Debug)]
pub struct Loss {
    /// Whether it goes in the middle of a frame, when all is ready to be drawn, or before one.
    pub is_in_frame: bool,
    phase: Phase,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    Start,
    /// It goes at the end of this frame.
    InFrame,
    /// It is gone since.
    Lost(Instant),
    /// A window is there again; what was in it is still to come.
    Moved(Instant),
}

impl Loss {
    pub fn new(is_in_frame: bool) -> Self {
        Self {
            is_in_frame,
            phase: Phase::Start,
        }
    }

    /// A frame begins; whether all is done.
    pub fn begin(&mut self, hands: &mut Hands<'_>, losses: &mut Vec<f64>) -> bool {
        hands.go_on();
        match self.phase {
            Phase::Start if self.is_in_frame => self.phase = Phase::InFrame,
            Phase::Start => self.lose(hands.app),
            // The frame before has drawn it.
            Phase::Moved(lost) if is_back(hands.app) => {
                losses.push(milliseconds(lost.elapsed()));
                return true;
            }
            Phase::InFrame | Phase::Lost(_) | Phase::Moved(_) => {}
        }
        false
    }

    /// A frame is laid out.
    pub fn end(&mut self, app: &App) {
        if self.phase == Phase::InFrame {
            self.lose(app);
        }
    }

    fn lose(&mut self, app: &App) {
        self.phase = Phase::Lost(Instant::now());
        app.lose_device();
    }

    /// Another window is there.
    pub fn window_moved(&mut self, app: &mut App) {
        if let Phase::Lost(lost) = self.phase {
            self.phase = Phase::Moved(lost);
            // That it was lost is known here.
            app.dismiss_messages();
        }
    }
}

/// Whether the scene is on the device again, and the picture that is looked at is in the window.
fn is_back(app: &App) -> bool {
    !app.is_settling() && app.picture_on_screen().is_none_or(Picture::is_covered)
}
