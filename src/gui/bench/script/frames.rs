//! What frames take of the processor while a render runs.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use eframe::egui_wgpu::{Callback, CallbackResources, CallbackTrait};
use eframe::wgpu;
use egui::{Key, Vec2};

use super::super::figures::{FrameFigures, Spread};
use super::hands::Hands;
use super::milliseconds;

/// Frames of one repeat, and how long they may take.
const MOST_FRAMES: usize = 120;
const FRAMES_TIME: Duration = Duration::from_secs(6);
/// The first frames, in which what is done begins, do not count.
const FIRST_FRAMES: usize = 3;

/// What the user does while frames are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doing {
    Watching,
    Pointing,
    Orbiting,
    /// With Live on.
    Editing,
}

impl Doing {
    pub const ALL: [Self; 4] = [
        Self::Watching,
        Self::Pointing,
        Self::Orbiting,
        Self::Editing,
    ];

    pub fn in_words(self) -> &'static str {
        match self {
            Self::Watching => "watches",
            Self::Pointing => "points at pixels",
            Self::Orbiting => "drags the camera",
            Self::Editing => "edits with Live on",
        }
    }
}

/// What a frame took.
#[derive(Clone, Copy, Debug)]
pub struct FrameTime {
    /// Processor time of the window's thread.
    pub cpu: Duration,
    /// Of it, until all was laid out.
    pub layout_cpu: Option<Duration>,
    /// Of it, until all was handed to the driver.
    pub own_cpu: Option<Duration>,
    /// Time until the next frame began.
    pub interval: Duration,
}

/// What many frames took, in milliseconds.
#[derive(Debug, Default)]
pub struct FrameTimes {
    cpu: Vec<f64>,
    layout_cpu: Vec<f64>,
    own_cpu: Vec<f64>,
    intervals: Vec<f64>,
}

impl FrameTimes {
    /// Counts a frame.
    pub fn push(&mut self, frame: FrameTime) {
        self.cpu.push(milliseconds(frame.cpu));
        self.layout_cpu.extend(frame.layout_cpu.map(milliseconds));
        self.own_cpu.extend(frame.own_cpu.map(milliseconds));
        self.intervals.push(milliseconds(frame.interval));
    }

    /// What they took while the user did `doing`.
    pub fn figures(self, doing: Doing) -> FrameFigures {
        FrameFigures {
            while_user: doing.in_words(),
            cpu_ms: Spread::of(self.cpu),
            layout_cpu_ms: Spread::of(self.layout_cpu),
            own_cpu_ms: Spread::of(self.own_cpu),
            interval_ms: Spread::of(self.intervals),
        }
    }
}

/// A mark that is drawn last, and takes note when that is: what is drawn comes to the driver together, after it.
#[derive(Clone, Debug, Default)]
struct HandedOver(Arc<Mutex<Option<Duration>>>);

impl CallbackTrait for HandedOver {
    fn paint(
        &self,
        _: egui::PaintCallbackInfo,
        _: &mut wgpu::RenderPass<'static>,
        _: &CallbackResources,
    ) {
        let now = ThreadTime::now().as_duration();
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(now);
    }
}

/// Times frames, from the start of one to the start of the next.
#[derive(Debug, Default)]
pub struct FrameClock {
    /// Processor time of this thread, and time, at the start of the last frame.
    started: Option<(Duration, Instant)>,
    /// Processor time when the last frame was laid out.
    laid_out: Option<Duration>,
    /// The same when it was handed to the driver; `None` where it was not drawn.
    handed_over: HandedOver,
}

impl FrameClock {
    /// A frame begins; what the one before took.
    pub fn begin(&mut self) -> Option<FrameTime> {
        let now = (ThreadTime::now().as_duration(), Instant::now());
        let handed_over = &self.handed_over.0;
        let handed_over = handed_over
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        let laid_out = self.laid_out.take();
        let (cpu, at) = self.started.replace(now)?;
        let since = |then: Duration| then.saturating_sub(cpu);
        Some(FrameTime {
            cpu: since(now.0),
            layout_cpu: laid_out.map(since),
            own_cpu: handed_over.map(since),
            interval: now.1 - at,
        })
    }

    /// The frame is laid out.
    pub fn lay_out(&mut self, ctx: &egui::Context) {
        self.laid_out = Some(ThreadTime::now().as_duration());
        let mark = Callback::new_paint_callback(ctx.content_rect(), self.handed_over.clone());
        ctx.debug_painter().add(mark);
    }
}

/// Frames while the user does something and a render runs.
#[derive(Debug)]
pub struct Frames {
    pub doing: Doing,
    is_asked: bool,
    /// How many there were since the render had its first tile, and when that was.
    count: usize,
    since: Option<Instant>,
}

impl Frames {
    pub fn new(doing: Doing) -> Self {
        Self {
            doing,
            is_asked: false,
            count: 0,
            since: None,
        }
    }

    /// A frame begins, before which `last` passed. Returns whether these are enough.
    pub fn begin(
        &mut self,
        hands: &mut Hands<'_>,
        last: Option<FrameTime>,
        times: &mut FrameTimes,
    ) -> bool {
        let Some(since) = self.since else {
            self.start(hands);
            return false;
        };
        self.count += 1;
        if self.doing != Doing::Watching {
            let turn = self.count as f32 * 0.1;
            hands.point_at(hands.middle() + 90.0 * Vec2::angled(turn));
            hands.go_on();
        }
        if let Some(last) = last.filter(|_| self.count > FIRST_FRAMES) {
            times.push(last);
        }
        let is_over = self.count > MOST_FRAMES || since.elapsed() > FRAMES_TIME;
        if is_over {
            if self.doing == Doing::Orbiting {
                hands.hold(false);
            }
            hands.press(Key::Escape);
            hands.go_on();
        }
        is_over
    }

    /// Has a render run, and begins what the user does once it has a tile.
    fn start(&mut self, hands: &mut Hands<'_>) {
        hands.go_on();
        let picture = hands.app.picture();
        let running = picture.filter(|picture| picture.is_running());
        let has_tile = running.is_some_and(|picture| picture.first_tile.is_some());
        if running.is_none() && !self.is_asked {
            self.is_asked = true;
            hands.press(Key::F5);
        } else if has_tile {
            self.since = Some(Instant::now());
            if self.doing == Doing::Orbiting {
                hands.press(Key::Num1);
                hands.point_at(hands.middle());
                hands.hold(true);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_lasts_until_the_next_and_its_parts_until_they_are_done() {
        let mut clock = FrameClock::default();
        assert!(clock.begin().is_none(), "there was none before the first");
        let ctx = egui::Context::default();
        let mut drawn = ctx.run_ui(egui::RawInput::default(), |ui| clock.lay_out(ui.ctx()));
        drawn.textures_delta.clear();
        // Nothing has drawn the mark.
        let undrawn = clock.begin().expect("the first frame");
        assert!(undrawn.own_cpu.is_none() && undrawn.layout_cpu <= Some(undrawn.cpu));
        *clock.handed_over.0.lock().unwrap() = Some(ThreadTime::now().as_duration());
        let drawn = clock.begin().expect("the second");
        assert!(drawn.layout_cpu.is_none(), "nothing was laid out");
        assert!(drawn.own_cpu.is_some_and(|own| own <= drawn.cpu));

        let mut times = FrameTimes::default();
        times.push(undrawn);
        times.push(drawn);
        let figures = times.figures(Doing::Watching);
        let counts = [
            figures.cpu_ms,
            figures.layout_cpu_ms,
            figures.own_cpu_ms,
            figures.interval_ms,
        ];
        assert_eq!(counts.map(|spread| spread.count), [2, 1, 1, 2]);
    }
}
