//! What is done in the window, one task after the other, by the events that keys and mouse would bring.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use eframe::egui_wgpu::{Callback, CallbackResources, CallbackTrait};
use eframe::wgpu;
use egui::{Event, Key, Modifiers, PointerButton, Pos2, Vec2};

use super::figures::{FrameFigures, RestartFigures, Spread, WindowFigures};
use crate::gui::app::App;
use crate::gui::document::same_picture;
use crate::gui::picture::Picture;
use crate::scene::{Light, Material, Mode, RenderSettings, Rgb, Scene, Stop};

/// Frames that are drawn before anything is measured: shaders are made, fonts are drawn.
const WARM_UP: usize = 12;
/// Frames of one repeat, and how long they may take.
const MOST_FRAMES: usize = 120;
const FRAMES_TIME: Duration = Duration::from_secs(6);
/// Cancels of one repeat.
const CANCELS: usize = 4;
/// Edits of one kind in one repeat.
const EDITS: usize = 4;
/// What the picture is left to itself before the next edit.
const REST: Duration = Duration::from_millis(300);
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

/// What the user does while frames are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Doing {
    Watching,
    Pointing,
    Orbiting,
    /// With Live on.
    Editing,
}

impl Doing {
    const ALL: [Self; 4] = [
        Self::Watching,
        Self::Pointing,
        Self::Orbiting,
        Self::Editing,
    ];

    fn in_words(self) -> &'static str {
        match self {
            Self::Watching => "watches",
            Self::Pointing => "points at pixels",
            Self::Orbiting => "drags the camera",
            Self::Editing => "edits with Live on",
        }
    }
}

/// What is edited while Live is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Edit {
    Camera,
    Light,
    Object,
    Material,
    Effect,
}

impl Edit {
    const ALL: [Self; 5] = [
        Self::Camera,
        Self::Light,
        Self::Object,
        Self::Material,
        Self::Effect,
    ];

    fn in_words(self) -> &'static str {
        match self {
            Self::Camera => "moving the camera",
            Self::Light => "changing a light",
            Self::Object => "moving an object",
            Self::Material => "changing a material",
            Self::Effect => "switching an effect",
        }
    }

    /// Changes `scene` a little; whether there was something to change.
    fn make(self, scene: &mut Scene) -> bool {
        let step = scene.camera.eye.distance(scene.camera.target) * 1e-3;
        match self {
            Self::Camera => scene.camera.eye.x += step,
            Self::Light => match scene.lights.first_mut() {
                Some(
                    Light::Point {
                        intensity: emission,
                        ..
                    }
                    | Light::Disk {
                        radiance: emission, ..
                    },
                ) => {
                    *emission *= 1.001;
                }
                None => return false,
            },
            Self::Object => match scene.objects.first_mut() {
                Some(object) => object.translate.x += step,
                None => return false,
            },
            Self::Material => {
                let mut materials = scene.materials.values_mut();
                let diffuse = materials.find_map(|material| match material {
                    Material::Phong { diffuse, .. } if *diffuse != Rgb::ZERO => Some(diffuse),
                    _ => None,
                });
                match diffuse {
                    Some(diffuse) => *diffuse *= 0.999,
                    None => return false,
                }
            }
            Self::Effect => {
                let settings = &mut scene.render;
                // Each mode has one of them that it uses.
                let switch = match settings.mode {
                    Mode::Direct => &mut settings.ambient_occlusion.enabled,
                    _ => &mut settings.antialiasing,
                };
                *switch = !*switch;
            }
        }
        true
    }
}

/// One thing to do, and how far it is.
#[derive(Debug)]
enum Task {
    /// Wait until the scene is there, and set it up to be rendered for hours.
    SetUp {
        frames: usize,
    },
    Frames {
        doing: Doing,
        frames: usize,
        since: Option<Instant>,
    },
    Cancel(CancelPhase),
    Restart {
        edit: Edit,
        phase: RestartPhase,
    },
    Loss(LossPhase),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum LossPhase {
    Start,
    /// It goes in the middle of this frame, when all is ready to be drawn.
    InFrame,
    /// The graphics device is gone since.
    Lost(Instant),
    /// A window is there again; the preview is still to come.
    Moved(Instant),
    Done,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum CancelPhase {
    Start,
    /// The render is to run for so long after its first tile.
    Run(Duration, Option<Instant>),
    Asked(Instant),
    Done,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum RestartPhase {
    /// Live is to be on, and the picture to have rested.
    Rest(Option<Instant>),
    Edited(Instant),
    /// The frame that shows the first tile is drawn.
    Shown(Instant),
    Done,
}

/// The tasks, and what was found.
#[derive(Debug)]
pub struct Script {
    task: Task,
    rest: VecDeque<Task>,
    is_over: bool,
    ending: Option<Ending>,
    /// When the task began.
    begun: Instant,
    /// Processor time of this thread and time at the start of the last frame.
    last_frame: Option<(Duration, Instant)>,
    /// Processor time of this thread when the last frame was handed to the driver.
    handed_over: HandedOver,
    cpu: [Vec<f64>; Doing::ALL.len()],
    own_cpu: [Vec<f64>; Doing::ALL.len()],
    intervals: [Vec<f64>; Doing::ALL.len()],
    cancels: Vec<f64>,
    losses: Vec<f64>,
    tiles: [Vec<f64>; Edit::ALL.len()],
    screens: [Vec<f64>; Edit::ALL.len()],
    is_software: bool,
    /// When the next frame is to come, whether or not the window wants one.
    wake: Option<Duration>,
}

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// A mark that is drawn last, and takes note when that is: what is drawn comes to the driver together, after it.
#[derive(Clone, Debug, Default)]
struct HandedOver(Arc<Mutex<Option<Duration>>>);

impl HandedOver {
    /// Processor time of the window's thread when the frame before was handed over; `None` where it was not drawn.
    fn take(&self) -> Option<Duration> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

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

/// What a frame took.
#[derive(Clone, Copy, Debug)]
struct FrameTime {
    cpu: Duration,
    /// Until it was handed to the driver.
    own_cpu: Option<Duration>,
    interval: Duration,
}

/// Presses and releases a key.
fn press(events: &mut Vec<Event>, key: Key) {
    events.extend([true, false].map(|pressed| Event::Key {
        key,
        physical_key: None,
        pressed,
        repeat: false,
        modifiers: Modifiers::NONE,
    }));
}

impl Script {
    /// Everything, so many times.
    pub fn new(repeats: usize) -> Self {
        let mut tasks = VecDeque::from([Task::SetUp { frames: 0 }]);
        for _ in 0..repeats {
            let doings = [Doing::Watching, Doing::Pointing, Doing::Orbiting];
            tasks.extend(doings.map(|doing| Task::Frames {
                doing,
                frames: 0,
                since: None,
            }));
            tasks.extend((0..CANCELS).map(|_| Task::Cancel(CancelPhase::Start)));
            let edits = (0..EDITS).flat_map(|_| Edit::ALL);
            tasks.extend(edits.map(|edit| Task::Restart {
                edit,
                phase: RestartPhase::Rest(None),
            }));
            tasks.push_back(Task::Loss(LossPhase::Start));
        }
        Self {
            task: tasks.pop_front().expect("there is one"),
            rest: tasks,
            is_over: false,
            ending: None,
            begun: Instant::now(),
            last_frame: None,
            handed_over: HandedOver::default(),
            cpu: Default::default(),
            own_cpu: Default::default(),
            intervals: Default::default(),
            cancels: Vec::new(),
            losses: Vec::new(),
            tiles: Default::default(),
            screens: Default::default(),
            is_software: false,
            wake: None,
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
            let figures = Box::new(self.figures());
            self.end(Ending::Measured(figures));
        }
    }

    fn figures(&mut self) -> WindowFigures {
        let take = |values: &mut Vec<f64>| Spread::of(std::mem::take(values));
        WindowFigures {
            is_software: self.is_software,
            frames: Doing::ALL
                .map(|doing| FrameFigures {
                    while_user: doing.in_words(),
                    cpu_ms: take(&mut self.cpu[doing as usize]),
                    own_cpu_ms: take(&mut self.own_cpu[doing as usize]),
                    interval_ms: take(&mut self.intervals[doing as usize]),
                })
                .into(),
            cancel_ms: take(&mut self.cancels),
            loss_ms: take(&mut self.losses),
            restarts: Edit::ALL
                .into_iter()
                .filter(|edit| !self.tiles[*edit as usize].is_empty())
                .collect::<Vec<_>>()
                .into_iter()
                .map(|edit| RestartFigures {
                    edit: edit.in_words(),
                    tile_ms: take(&mut self.tiles[edit as usize]),
                    screen_ms: take(&mut self.screens[edit as usize]),
                })
                .collect(),
            ..WindowFigures::default()
        }
    }

    /// A frame begins: takes note of the one before, and brings the events of this one.
    pub fn begin_frame(&mut self, app: &mut App, ctx: &egui::Context, events: &mut Vec<Event>) {
        if self.is_over {
            return;
        }
        let now = (ThreadTime::now().as_duration(), Instant::now());
        let before = self.last_frame.replace(now);
        if self.begun.elapsed() > PATIENCE {
            let text = format!("{:?} has not come to an end", self.task);
            return self.end(Ending::Stuck(text));
        }
        if let Some(message) = app.messages().banners().first() {
            let text = format!("{}: {}", message.title, message.text);
            return self.end(Ending::Stuck(text));
        }
        let handed_over = self.handed_over.take();
        let last = before.map(|(cpu, at)| FrameTime {
            cpu: now.0.saturating_sub(cpu),
            own_cpu: handed_over.map(|handed_over| handed_over.saturating_sub(cpu)),
            interval: now.1 - at,
        });
        if let (Some(last), Task::Restart { phase, .. }) = (last, &self.task)
            && matches!(phase, RestartPhase::Edited(_) | RestartPhase::Shown(_))
        {
            self.take_frame(Doing::Editing, last);
        }
        let is_done = match &mut self.task {
            Task::SetUp { .. } => self.set_up(app),
            Task::Frames { .. } => self.measure_frame(app, ctx, events, last),
            Task::Cancel(_) => self.begin_cancel(app, events),
            Task::Restart { .. } => self.begin_restart(app, ctx, events),
            Task::Loss(_) => self.begin_loss(app),
        };
        if is_done {
            self.next_task();
            self.wake = Some(Duration::ZERO);
        }
    }

    fn take_frame(&mut self, doing: Doing, frame: FrameTime) {
        self.cpu[doing as usize].push(milliseconds(frame.cpu));
        self.own_cpu[doing as usize].extend(frame.own_cpu.map(milliseconds));
        self.intervals[doing as usize].push(milliseconds(frame.interval));
    }

    fn set_up(&mut self, app: &mut App) -> bool {
        let Task::SetUp { frames } = &mut self.task else {
            return true;
        };
        self.wake = Some(Duration::ZERO);
        if app.is_settling() || app.document().scene.objects.is_empty() {
            return false;
        }
        *frames += 1;
        self.is_software = app.is_drawn_by_processor();
        let render = &mut app.document_mut().scene.render;
        render.stop = Stop::default();
        render.samples_per_pixel = RenderSettings::MAX_SAMPLES;
        *frames > WARM_UP
    }

    /// A frame while a render runs.
    fn measure_frame(
        &mut self,
        app: &App,
        ctx: &egui::Context,
        events: &mut Vec<Event>,
        last: Option<FrameTime>,
    ) -> bool {
        let Task::Frames {
            doing,
            frames,
            since,
        } = &mut self.task
        else {
            return true;
        };
        let doing = *doing;
        let middle = center(ctx);
        let Some(started) = *since else {
            if !app.picture().is_some_and(Picture::is_running) {
                if app.picture().is_none_or(|picture| !picture.is_running()) && *frames == 0 {
                    press(events, Key::F5);
                    *frames = 1;
                }
                self.wake = Some(Duration::ZERO);
                return false;
            }
            if app.picture().is_some_and(|p| p.first_tile.is_some()) {
                *since = Some(Instant::now());
                *frames = 0;
                if doing == Doing::Orbiting {
                    press(events, Key::Num1);
                    events.push(Event::PointerMoved(middle));
                    events.push(button(middle, true));
                }
            }
            self.wake = Some(Duration::ZERO);
            return false;
        };
        *frames += 1;
        if doing != Doing::Watching {
            let turn = *frames as f32 * 0.1;
            events.push(Event::PointerMoved(middle + 90.0 * Vec2::angled(turn)));
            self.wake = Some(Duration::ZERO);
        }
        let is_over = *frames > MOST_FRAMES || started.elapsed() > FRAMES_TIME;
        // What was done to begin does not count.
        if *frames > 3
            && let Some(last) = last
        {
            self.take_frame(doing, last);
        }
        if is_over {
            if doing == Doing::Orbiting {
                events.push(button(middle, false));
            }
            press(events, Key::Escape);
            self.wake = Some(Duration::ZERO);
        }
        is_over
    }

    fn begin_cancel(&mut self, app: &App, events: &mut Vec<Event>) -> bool {
        let Task::Cancel(phase) = &mut self.task else {
            return true;
        };
        match *phase {
            CancelPhase::Start => {
                if app.render_threads() == 0 {
                    press(events, Key::F5);
                    // At different moments of a pass.
                    let turn = u32::try_from(self.cancels.len() % 7).unwrap_or_default();
                    *phase = CancelPhase::Run(Duration::from_millis(37) * turn, None);
                }
                self.wake = Some(Duration::ZERO);
            }
            CancelPhase::Run(time, since) => {
                let picture = app.picture().filter(|picture| picture.is_running());
                let has_tile = picture.is_some_and(|picture| picture.first_tile.is_some());
                match since {
                    None if has_tile => *phase = CancelPhase::Run(time, Some(Instant::now())),
                    Some(since) if since.elapsed() >= time => {
                        press(events, Key::Escape);
                        *phase = CancelPhase::Asked(Instant::now());
                    }
                    _ => {}
                }
                self.wake = Some(Duration::ZERO);
            }
            CancelPhase::Asked(_) => {}
            CancelPhase::Done => return true,
        }
        false
    }

    fn begin_restart(
        &mut self,
        app: &mut App,
        ctx: &egui::Context,
        events: &mut Vec<Event>,
    ) -> bool {
        let place = center(ctx);
        let Task::Restart { edit, phase } = &mut self.task else {
            return true;
        };
        match *phase {
            RestartPhase::Rest(None) => {
                if !app.is_live() {
                    press(events, Key::L);
                }
                *phase = RestartPhase::Rest(Some(Instant::now()));
                self.wake = Some(REST);
            }
            RestartPhase::Rest(Some(since)) => {
                let is_shown = shows_present(app);
                if is_shown && since.elapsed() >= REST {
                    let edit = *edit;
                    *phase = RestartPhase::Edited(Instant::now());
                    // As every edit does, it comes with something from the mouse.
                    events.push(Event::PointerMoved(place));
                    // Where there is nothing to edit, nothing is measured.
                    return !edit.make(&mut app.document_mut().scene);
                }
                self.wake = Some(REST);
            }
            // The window is left to itself: what the render sends wakes it.
            RestartPhase::Edited(_) => self.wake = Some(REST),
            RestartPhase::Shown(asked) => {
                self.screens[*edit as usize].push(milliseconds(asked.elapsed()));
                *phase = RestartPhase::Done;
                if !matches!(self.rest.front(), Some(Task::Restart { .. })) {
                    press(events, Key::L);
                    press(events, Key::Escape);
                }
                return true;
            }
            RestartPhase::Done => return true,
        }
        false
    }

    fn begin_loss(&mut self, app: &App) -> bool {
        let Task::Loss(phase) = &mut self.task else {
            return true;
        };
        self.wake = Some(Duration::ZERO);
        match *phase {
            LossPhase::Start if self.losses.len().is_multiple_of(2) => {
                *phase = LossPhase::Lost(Instant::now());
                app.lose_device();
            }
            LossPhase::Start => *phase = LossPhase::InFrame,
            // The preview was drawn by the frame before.
            LossPhase::Moved(lost) if !app.is_settling() => {
                self.losses.push(milliseconds(lost.elapsed()));
                *phase = LossPhase::Done;
                return true;
            }
            LossPhase::InFrame | LossPhase::Lost(_) | LossPhase::Moved(_) => {}
            LossPhase::Done => return true,
        }
        false
    }

    /// What is measured goes on in another window.
    pub fn window_moved(&mut self, app: &mut App) {
        if let Task::Loss(phase) = &mut self.task
            && let LossPhase::Lost(lost) = *phase
        {
            *phase = LossPhase::Moved(lost);
            app.dismiss_messages();
        }
    }

    /// A frame is drawn as far as the window itself does that; the graphics driver comes next.
    pub fn end_frame(&mut self, app: &App, ctx: &egui::Context) {
        if let Some(delay) = self.wake.take() {
            ctx.request_repaint_after(delay);
        }
        let mark = Callback::new_paint_callback(ctx.content_rect(), self.handed_over.clone());
        ctx.debug_painter().add(mark);
        match &mut self.task {
            Task::Loss(phase) if *phase == LossPhase::InFrame => {
                *phase = LossPhase::Lost(Instant::now());
                app.lose_device();
            }
            Task::Cancel(phase) => {
                if let CancelPhase::Asked(asked) = *phase {
                    while app.render_threads() > 0 && asked.elapsed() < PATIENCE {
                        std::thread::sleep(Duration::from_micros(100));
                    }
                    self.cancels.push(milliseconds(asked.elapsed()));
                    *phase = CancelPhase::Done;
                    ctx.request_repaint();
                }
            }
            Task::Restart { edit, phase } => {
                if let RestartPhase::Edited(asked) = *phase
                    && shows_present(app)
                {
                    self.tiles[*edit as usize].push(milliseconds(asked.elapsed()));
                    *phase = RestartPhase::Shown(asked);
                    ctx.request_repaint();
                }
            }
            Task::SetUp { .. } | Task::Frames { .. } | Task::Loss(_) => {}
        }
    }
}

/// Whether a tile of the scene as it is has come.
fn shows_present(app: &App) -> bool {
    app.picture().is_some_and(|picture| {
        picture.first_tile.is_some() && same_picture(&picture.scene, &app.document().scene)
    })
}

/// A place in the middle of the picture.
fn center(ctx: &egui::Context) -> Pos2 {
    let window = ctx.content_rect();
    window.min + window.size() * Vec2::new(0.37, 0.42)
}

fn button(pos: Pos2, pressed: bool) -> Event {
    Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::demo_scene;

    #[test]
    fn every_edit_makes_another_picture_and_none_an_invalid_one() {
        let mut scene = demo_scene();
        for edit in Edit::ALL.repeat(3) {
            let before = scene.clone();
            assert!(edit.make(&mut scene), "{edit:?}");
            assert!(!same_picture(&before, &scene), "{edit:?}");
            assert_eq!(scene.validate(), Ok(()), "{edit:?}");
        }
        // Where there is nothing to edit, nothing is measured.
        let mut empty = Scene::default();
        for (edit, is_there) in Edit::ALL.into_iter().zip([true, false, false, false, true]) {
            assert_eq!(edit.make(&mut empty), is_there, "{edit:?}");
        }
    }
}
