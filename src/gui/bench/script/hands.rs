//! What a task has at hand when a frame begins: the window, and keys and a mouse to work in it with.

use std::time::Duration;

use egui::{Event, Key, Modifiers, PointerButton, Pos2, Vec2};

use crate::gui::app::App;

/// The window, and who works in it.
pub struct Hands<'a> {
    /// What is in the window.
    pub app: &'a mut App,
    ctx: &'a egui::Context,
    /// What keys and mouse bring to the frame that begins.
    events: &'a mut Vec<Event>,
    wake: &'a mut Option<Duration>,
}

impl<'a> Hands<'a> {
    /// Hands that work by `events`. `wake`: when the next frame is to come, whether or not the window wants one.
    pub fn new(
        app: &'a mut App,
        ctx: &'a egui::Context,
        events: &'a mut Vec<Event>,
        wake: &'a mut Option<Duration>,
    ) -> Self {
        Self {
            app,
            ctx,
            events,
            wake,
        }
    }

    /// Presses and releases a key.
    pub fn press(&mut self, key: Key) {
        self.events.extend([true, false].map(|pressed| Event::Key {
            key,
            physical_key: None,
            pressed,
            repeat: false,
            modifiers: Modifiers::NONE,
        }));
    }

    /// Moves the mouse to a place.
    pub fn point_at(&mut self, place: Pos2) {
        self.events.push(Event::PointerMoved(place));
    }

    /// Presses or releases the button of the mouse in [the middle](Self::middle).
    pub fn hold(&mut self, pressed: bool) {
        self.events.push(Event::PointerButton {
            pos: self.middle(),
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        });
    }

    /// A place in the middle of the picture.
    pub fn middle(&self) -> Pos2 {
        let window = self.ctx.content_rect();
        window.min + window.size() * Vec2::new(0.37, 0.42)
    }

    /// Has the next frame come after `delay` at the latest.
    pub fn wake_after(&mut self, delay: Duration) {
        *self.wake = Some(delay);
    }

    /// Has the next frame come at once.
    pub fn go_on(&mut self) {
        self.wake_after(Duration::ZERO);
    }
}
