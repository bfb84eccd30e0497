//! What is done in the window, one task after the other, by the events that keys and mouse would bring.
//!
//! Edits with Live on are the exception: they change the scene as a panel would, with a move of the mouse.
//!
//! - `hands`: the window as a task finds it, with keys and mouse
//! - `frames`, `cancel`, `restart`, `loss`: the tasks, and what each measures

mod cancel;
mod frames;
mod hands;
mod loss;
mod restart;

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use egui::Event;

use super::figures::{Spread, WindowFigures};
use crate::gui::app::App;
use crate::scene::{RenderSettings, Stop};
use cancel::Cancel;
use frames::{Doing, FrameClock, FrameTime, FrameTimes, Frames};
use hands::Hands;
use loss::Loss;
use restart::{Edit, Restart, RestartTimes};

/// Frames that are drawn before anything is measured: shaders are made, fonts are drawn.
const WARM_UP: usize = 12;
/// Cancels of one repeat.
const CANCELS: usize = 4;
/// Edits of one kind in one repeat.
const EDITS: usize = 4;
/// Nothing takes that long, unless something is wrong.
const PATIENCE: Duration = Duration::from_mins(2);

/// How measuring ended.
#[derive(Debug)]
pub enum Ending {
    /// With these figures.
    Measured(Box<WindowFigures>),
    /// Something did not come about, in words.
    Stuck(String),
}

/// One thing to do.
#[derive(Debug)]
enum Task {
    /// Wait until the scene is there, and set it up to be rendered for hours. How many frames were drawn of it.
    SetUp(usize),
    Frames(Frames),
    Cancel(Cancel),
    Restart(Restart),
    Loss(Loss),
}

impl Task {
    /// What it waits for, in words that follow "waited in vain for".
    fn in_words(&self) -> String {
        match self {
            Self::SetUp(_) => "the scene to be there".to_owned(),
            Self::Frames(frames) => {
                format!("frames while the user {}", frames.doing.in_words())
            }
            Self::Cancel(_) => "a cancelled render to end".to_owned(),
            Self::Restart(restart) => format!("what {} changes", restart.edit.in_words()),
            Self::Loss(_) => "a window after the graphics device was lost".to_owned(),
        }
    }
}

/// What was found so far.
#[derive(Debug, Default)]
struct Findings {
    frames: [FrameTimes; Doing::ALL.len()],
    cancels: Vec<f64>,
    restarts: [RestartTimes; Edit::ALL.len()],
    losses: Vec<f64>,
    is_software: bool,
}

impl Findings {
    fn figures(self) -> WindowFigures {
        let frames = Doing::ALL.into_iter().zip(self.frames);
        let restarts = Edit::ALL.into_iter().zip(self.restarts);
        WindowFigures {
            is_software: self.is_software,
            frames: frames.map(|(doing, times)| times.figures(doing)).collect(),
            cancel_ms: Spread::of(self.cancels),
            loss_ms: Spread::of(self.losses),
            restarts: restarts
                .filter_map(|(edit, times)| times.figures(edit))
                .collect(),
            ..WindowFigures::default()
        }
    }

    /// A frame passed: counts it, where it is one between an edit and what shows it.
    fn note(&mut self, task: &Task, last: FrameTime) {
        if let Task::Restart(restart) = task
            && restart.note(last, &mut self.restarts[restart.edit as usize])
        {
            self.frames[Doing::Editing as usize].push(last);
        }
    }
}

/// The tasks, and what was found.
#[derive(Debug)]
pub struct Script {
    task: Task,
    rest: VecDeque<Task>,
    /// When the task began.
    begun: Instant,
    clock: FrameClock,
    findings: Findings,
    /// When the next frame is to come, whether or not the window wants one.
    wake: Option<Duration>,
    is_over: bool,
    ending: Option<Ending>,
}

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// What is done in the repeat of that number.
fn tasks_of_repeat(repeat: usize) -> impl Iterator<Item = Task> {
    let doings = [Doing::Watching, Doing::Pointing, Doing::Orbiting];
    let frames = doings.map(|doing| Task::Frames(Frames::new(doing)));
    let cancels = (0..CANCELS).map(move |number| Cancel::new(repeat * CANCELS + number));
    let edits = Edit::ALL.repeat(EDITS).into_iter().enumerate();
    let last = EDITS * Edit::ALL.len() - 1;
    let restarts = edits.map(move |(number, edit)| Restart::new(edit, number == last));
    frames
        .into_iter()
        .chain(cancels.map(Task::Cancel))
        .chain(restarts.map(Task::Restart))
        .chain([Task::Loss(Loss::new(repeat % 2 == 1))])
}

impl Script {
    /// Everything, so many times.
    pub fn new(repeats: usize) -> Self {
        Self {
            task: Task::SetUp(0),
            rest: (0..repeats).flat_map(tasks_of_repeat).collect(),
            begun: Instant::now(),
            clock: FrameClock::default(),
            findings: Findings::default(),
            wake: None,
            is_over: false,
            ending: None,
        }
    }

    /// Whether nothing is left to do.
    pub fn is_over(&self) -> bool {
        self.is_over
    }

    /// How it ended, once.
    pub fn take_ending(&mut self) -> Option<Ending> {
        self.ending.take()
    }

    fn end(&mut self, ending: Ending) {
        self.is_over = true;
        self.ending = Some(ending);
    }

    fn next_task(&mut self) {
        self.begun = Instant::now();
        if let Some(task) = self.rest.pop_front() {
            self.task = task;
        } else {
            let figures = std::mem::take(&mut self.findings).figures();
            self.end(Ending::Measured(Box::new(figures)));
        }
    }

    /// A frame begins: takes note of the one before, and brings the events of this one.
    pub fn begin_frame(&mut self, app: &mut App, ctx: &egui::Context, events: &mut Vec<Event>) {
        if self.is_over {
            return;
        }
        let last = self.clock.begin();
        if let Some(reason) = self.why_stuck(app) {
            return self.end(Ending::Stuck(reason));
        }
        if let Some(last) = last {
            self.findings.note(&self.task, last);
        }
        let hands = &mut Hands::new(app, ctx, events, &mut self.wake);
        let findings = &mut self.findings;
        let is_done = match &mut self.task {
            Task::SetUp(frames) => set_up(hands, frames, findings),
            Task::Frames(frames) => {
                let times = &mut findings.frames[frames.doing as usize];
                frames.begin(hands, last, times)
            }
            Task::Cancel(cancel) => cancel.begin(hands),
            Task::Restart(restart) => {
                let times = &mut findings.restarts[restart.edit as usize];
                restart.begin(hands, times)
            }
            Task::Loss(loss) => loss.begin(hands, &mut findings.losses),
        };
        if is_done {
            self.next_task();
            self.wake = Some(Duration::ZERO);
        }
    }

    /// Why it cannot go on.
    fn why_stuck(&self, app: &App) -> Option<String> {
        if self.begun.elapsed() > PATIENCE {
            return Some(format!("waited in vain for {}", self.task.in_words()));
        }
        let message = app.messages().banners().first()?;
        Some(format!("{}: {}", message.title, message.text))
    }

    /// What is measured goes on in another window.
    pub fn window_moved(&mut self, app: &mut App) {
        if let Task::Loss(loss) = &mut self.task {
            loss.window_moved(app);
        }
    }

    /// A frame is drawn as far as the window itself does that; the graphics driver comes next.
    pub fn end_frame(&mut self, app: &App, ctx: &egui::Context) {
        if let Some(delay) = self.wake.take() {
            ctx.request_repaint_after(delay);
        }
        self.clock.lay_out(ctx);
        let findings = &mut self.findings;
        match &mut self.task {
            Task::Loss(loss) => loss.end(app),
            Task::Cancel(cancel) => cancel.end(app, ctx, &mut findings.cancels),
            Task::Restart(restart) => {
                let times = &mut findings.restarts[restart.edit as usize];
                restart.end(app, ctx, times);
            }
            Task::SetUp(_) | Task::Frames(_) => {}
        }
    }
}

/// Waits until the scene is there and `frames` of it were drawn, and sets it up to be rendered for hours; whether all is ready.
fn set_up(hands: &mut Hands<'_>, frames: &mut usize, findings: &mut Findings) -> bool {
    hands.go_on();
    let app = &mut *hands.app;
    let is_there = !app.is_settling() && !app.document().scene.objects.is_empty();
    // What is kept on disk is part of what a frame takes.
    if !is_there || !app.is_keeping() {
        return false;
    }
    *frames += 1;
    findings.is_software = app.is_drawn_by_processor();
    let render = &mut app.document_mut().scene.render;
    render.stop = Stop::default();
    render.samples_per_pixel = RenderSettings::MAX_SAMPLES;
    *frames > WARM_UP
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_repeat_has_all_that_is_measured_and_every_second_one_loses_the_device_in_a_frame() {
        let tasks: Vec<Vec<Task>> = (0..2).map(|n| tasks_of_repeat(n).collect()).collect();
        for tasks in &tasks {
            let is_of = |edit| move |task: &&Task| matches!(task, Task::Restart(restart) if restart.edit == edit);
            for edit in Edit::ALL {
                assert_eq!(tasks.iter().filter(is_of(edit)).count(), EDITS, "{edit:?}");
            }
            let frames = tasks.iter().filter(|task| matches!(task, Task::Frames(_)));
            let cancels = tasks.iter().filter(|task| matches!(task, Task::Cancel(_)));
            assert_eq!((frames.count(), cancels.count()), (3, CANCELS));
        }
        let losses = tasks.iter().map(|tasks| match tasks.last() {
            Some(Task::Loss(loss)) => loss.is_in_frame,
            _ => panic!("it loses no device"),
        });
        assert_eq!(losses.collect::<Vec<_>>(), [false, true]);
    }
}
