//! The thread that takes a running render to disk: none that renders or draws waits for a disk, however long one takes.
//!
//! ```text
//! render threads ──begin_log, log, keep_rules, keep──▶ channel ──▶ writer ──▶ scene, logs of blocks
//!                  never wait                                       └────▶ a thread for each checkpoint
//! ```
//!
//! What is handed over is written in that order, but for checkpoints, which take seconds: the log that was begun before each goes on beside it.
//! Blocks that would wait behind too many others are left out, and taken anew when the render goes on. The writer ends with the render, when all is
//! written, or at once where the place is [given up](KeptRender::give_up): what waits is dropped then. As long as it writes it holds the place,
//! which is not removed under its hands.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;

use super::render::KeptRender;
use crate::control::CancelToken;
use crate::io::{block_record, describe_render};
use crate::render::{Block, Checkpoint, Layer, LiveRules, Region, StopRules, panic_message};
use crate::scene::{RenderSettings, Scene};

/// The most bytes of blocks that wait to be written, but for one: those of the time that a disk takes to begin a file.
pub const MOST_WAITING_BYTES: u64 = 1 << 25;

/// What a render is of, as it is told on disk.
#[derive(Debug)]
pub struct Subject {
    scene: Scene,
    region: Region,
    layers: Vec<Layer>,
    rules: LiveRules,
    /// `None` when cancelled before it was there.
    description: OnceLock<Option<String>>,
}

impl Subject {
    /// Of a render of `region` of `scene` that keeps `layers` and ends by `rules`.
    #[must_use]
    pub fn new(scene: Scene, region: Region, layers: Vec<Layer>, rules: LiveRules) -> Self {
        Self {
            scene,
            region,
            layers,
            rules,
            description: OnceLock::new(),
        }
    }

    /// What the render is of, see [`describe_render`]; `None` when cancelled. Where meshes are large, the first call takes time.
    pub fn description(&self, cancel: &CancelToken) -> Option<&str> {
        let description = self.description.get_or_init(|| {
            // By which rules it ends may change on the way.
            let mut scene = self.scene.clone();
            let any = RenderSettings {
                samples_per_pixel: RenderSettings::MAX_SAMPLES,
                ..RenderSettings::default()
            };
            StopRules::of(&any).put_into(&mut scene.render);
            describe_render(&scene, self.region, &self.layers, cancel)
        });
        description.as_deref()
    }

    /// What is rendered, with the rules as they are now.
    fn scene(&self) -> Scene {
        let mut scene = self.scene.clone();
        self.rules.get().put_into(&mut scene.render);
        scene
    }
}

/// What is to be written.
#[derive(Debug)]
enum Message {
    Log,
    Block(Vec<u8>),
    Rules,
    Checkpoint {
        checkpoint: Box<Checkpoint>,
        needs_old: bool,
    },
}

/// What the threads that hand over and the one that writes know of one another.
#[derive(Debug)]
struct State {
    /// Bytes of blocks that wait.
    waiting: AtomicU64,
    /// Whether the log that was begun last is there, as far as is known.
    has_log: AtomicBool,
    /// Nanoseconds of processor time that blocks took, of those who pack and of the one who writes, and their bytes.
    blocks_took: AtomicU64,
    block_bytes: AtomicU64,
    /// What the last checkpoint took, with the log that was begun before it; `None` while one waits or is written. Held for a moment.
    checkpoint_took: Mutex<Option<Duration>>,
}

impl State {
    fn checkpoint_took(&self) -> MutexGuard<'_, Option<Duration>> {
        let took = self.checkpoint_took.lock();
        took.unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes note that nobody writes any more: no checkpoint waits.
    fn end(&self) {
        *self.checkpoint_took() = Some(Duration::ZERO);
    }

    /// Counts the time of this thread since it `started` with a block. Where it waits, for the disk or for a core, others go on.
    fn add_time_of_block(&self, started: ThreadTime) {
        let nanos = u64::try_from(started.elapsed().as_nanos()).unwrap_or(u64::MAX);
        self.blocks_took.fetch_add(nanos, Ordering::Relaxed);
    }
}

/// Takes one render to disk while it runs. Nothing here waits for that. Once it is dropped, what was handed over is still written.
#[derive(Debug)]
pub struct RenderWriter {
    sender: Sender<Message>,
    state: Arc<State>,
}

impl RenderWriter {
    /// Begins to write to `kept` what a render of `subject` reaches. `tell` is told once, in words, that a checkpoint cannot be kept.
    pub fn begin(
        kept: Arc<KeptRender>,
        subject: Arc<Subject>,
        tell: impl Fn(String) + Send + Sync + 'static,
    ) -> Self {
        let state = Arc::new(State {
            waiting: AtomicU64::new(0),
            has_log: AtomicBool::new(true),
            blocks_took: AtomicU64::new(0),
            block_bytes: AtomicU64::new(0),
            checkpoint_took: Mutex::new(Some(Duration::ZERO)),
        });
        let (sender, messages) = channel();
        let writing = kept.session().begin_writing();
        let known = Arc::clone(&state);
        let rules = subject.rules.get();
        let thread = WriterThread {
            kept,
            subject,
            state: Arc::clone(&state),
        };
        thread::spawn(move || {
            let is_told = AtomicBool::new(false);
            let tell_once = |reason| {
                if !is_told.swap(true, Ordering::Relaxed) {
                    tell(reason);
                }
            };
            let write = || thread.write(messages, rules, &tell_once);
            if let Err(payload) = catch_unwind(AssertUnwindSafe(write)) {
                tell_once(panic_message(payload.as_ref()));
            }
            known.end();
            drop(writing);
        });
        Self { sender, state }
    }

    /// Begins a log of blocks for those that follow. Before the first block that is not asked for.
    pub fn begin_log(&self) {
        self.send(Message::Log);
    }

    /// Adds `block` to the log that was begun last. It is left out where there is none, or where too many wait.
    pub fn log(&self, block: &Block<'_>) {
        let state = &*self.state;
        let is_full = state.waiting.load(Ordering::Relaxed) >= MOST_WAITING_BYTES;
        if is_full || !state.has_log.load(Ordering::Relaxed) {
            return;
        }
        let started = ThreadTime::now();
        let record = block_record(block);
        let bytes = record.len() as u64;
        state.waiting.fetch_add(bytes, Ordering::Relaxed);
        state.block_bytes.fetch_add(bytes, Ordering::Relaxed);
        self.send(Message::Block(record));
        state.add_time_of_block(started);
    }

    /// The processor time that packing and writing blocks took so far, and their bytes.
    #[must_use]
    pub fn spent_on_blocks(&self) -> (Duration, u64) {
        let state = &self.state;
        let took = Duration::from_nanos(state.blocks_took.load(Ordering::Relaxed));
        (took, state.block_bytes.load(Ordering::Relaxed))
    }

    /// Takes the rules by which the render ends to disk, where they are others than those that are there.
    pub fn keep_rules(&self) {
        self.send(Message::Rules);
    }

    /// Keeps `checkpoint` in place of the last one, and the rules. `needs_old`: see [`KeptRender::keep`]. There may be no other that is not
    /// [kept](Self::checkpoint_took) yet: it is dropped otherwise.
    pub fn keep(&self, checkpoint: Checkpoint, needs_old: bool) {
        if self.state.checkpoint_took().take().is_none() {
            return;
        }
        let message = Message::Checkpoint {
            checkpoint: Box::new(checkpoint),
            needs_old,
        };
        if self.sender.send(message).is_err() {
            self.state.end();
        }
    }

    /// How long the last checkpoint took to be written, zero before the first; `None` as long as it is not.
    #[must_use]
    pub fn checkpoint_took(&self) -> Option<Duration> {
        *self.state.checkpoint_took()
    }

    fn send(&self, message: Message) {
        // Where the place is given up, nobody writes any more.
        let _ = self.sender.send(message);
    }
}

/// What the thread that writes has.
struct WriterThread {
    kept: Arc<KeptRender>,
    subject: Arc<Subject>,
    state: Arc<State>,
}

impl WriterThread {
    /// Writes what comes, until nothing does, or the place is given up. `rules`: those on disk, once something is there.
    fn write(
        self,
        messages: Receiver<Message>,
        mut rules: StopRules,
        tell: &(dyn Fn(String) + Sync),
    ) {
        thread::scope(|scope| {
            let this = &self;
            let mut has_begun = false;
            let mut log_took = Duration::ZERO;
            for message in messages {
                if this.kept.given_up().is_cancelled() {
                    break;
                }
                match message {
                    Message::Log => {
                        let started = Instant::now();
                        this.begin_log();
                        has_begun = true;
                        log_took = started.elapsed();
                    }
                    Message::Block(record) => {
                        if !std::mem::replace(&mut has_begun, true) {
                            this.begin_log();
                        }
                        this.log(&record);
                    }
                    Message::Rules => this.keep_rules(&mut rules),
                    Message::Checkpoint {
                        checkpoint,
                        needs_old,
                    } => {
                        this.keep_rules(&mut rules);
                        scope.spawn(move || {
                            let started = Instant::now();
                            if let Err(error) = this.keep(&checkpoint, needs_old) {
                                tell(error);
                            }
                            // There may be another once it is told that this one is done with.
                            drop(checkpoint);
                            *this.state.checkpoint_took() = Some(log_took + started.elapsed());
                        });
                    }
                }
            }
        });
        self.kept.end_log();
    }

    /// Begins a log of blocks. That it cannot be is not told: of a checkpoint it will be.
    fn begin_log(&self) {
        let Some(description) = self.subject.description(self.kept.given_up()) else {
            return;
        };
        let begun = self.kept.begin_log(&self.subject.scene(), description);
        self.state.has_log.store(begun.is_ok(), Ordering::Relaxed);
    }

    fn log(&self, record: &[u8]) {
        let started = ThreadTime::now();
        self.kept.log_block(record);
        let bytes = record.len() as u64;
        self.state.waiting.fetch_sub(bytes, Ordering::Relaxed);
        self.state.add_time_of_block(started);
    }

    fn keep_rules(&self, known: &mut StopRules) {
        let rules = self.subject.rules.get();
        if *known != rules && self.kept.keep_scene_anew(&self.subject.scene()).is_ok() {
            *known = rules;
        }
    }

    fn keep(&self, checkpoint: &Checkpoint, needs_old: bool) -> Result<(), String> {
        let cancel = self.kept.given_up();
        let Some(description) = self.subject.description(cancel) else {
            return Ok(());
        };
        let scene = self.subject.scene();
        self.kept
            .keep(&scene, description, checkpoint, needs_old, cancel)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;
    use std::path::PathBuf;

    use super::super::{Begun, RenderAbout, Session, begin};
    use super::*;
    use crate::control::Progress;
    use crate::io::{LoggedBlocks, demo_scene};
    use crate::render::{
        BlockHeader, BlockStore, CheckpointKeeper, PreparedScene, RenderProgress, RunConfig, Watch,
        render_watched,
    };

    const SIZE: [u32; 2] = [96, 64];

    /// A render that has a place on disk.
    struct Place {
        data: tempfile::TempDir,
        session: Arc<Session>,
        kept: Arc<KeptRender>,
        subject: Arc<Subject>,
    }

    impl Place {
        fn new() -> (Self, RenderWriter) {
            let data = tempfile::tempdir().expect("a temporary folder");
            let Begun { session, .. } = begin(data.path()).expect("can be written");
            let session = Arc::new(session);
            let mut scene = demo_scene();
            [scene.render.width, scene.render.height] = SIZE;
            scene.render.samples_per_pixel = 4;
            let region = Region::full(SIZE[0], SIZE[1]);
            let kept = Arc::new(session.place_render(RenderAbout {
                name: "demo".to_owned(),
                path: None,
                region,
            }));
            let rules = LiveRules::new(StopRules::of(&scene.render));
            let subject = Arc::new(Subject::new(scene, region, Vec::new(), rules));
            let tell = |reason| panic!("{reason}");
            let writer = RenderWriter::begin(Arc::clone(&kept), Arc::clone(&subject), tell);
            let place = Self {
                data,
                session,
                kept,
                subject,
            };
            (place, writer)
        }

        /// Does `work` while the disk does not answer.
        fn while_disk_hangs<T>(&self, work: impl FnOnce() -> T) -> T {
            let mut done = None;
            let hang = || {
                done = Some(work());
                Ok(())
            };
            self.session.move_render(hang).expect("nothing fails");
            done.expect("it is done")
        }

        /// What is there of renders.
        fn files(&self) -> Vec<PathBuf> {
            let entries = |folder: PathBuf| {
                let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
                entries.map(|entry| entry.path())
            };
            let sessions = entries(self.data.path().join("sessions"));
            sessions.flat_map(entries).flat_map(entries).collect()
        }

        /// Waits until nobody writes any more.
        fn wait(&self) {
            let deadline = Instant::now() + Duration::from_mins(1);
            while self.session.has_writers() {
                assert!(Instant::now() < deadline, "somebody writes for ever");
                thread::sleep(Duration::from_millis(1));
            }
        }

        /// What whoever goes on would find.
        fn read(&self) -> (Option<Checkpoint>, LoggedBlocks) {
            let never = CancelToken::new();
            let description = self.subject.description(&never).expect("nobody cancels");
            let read = self
                .kept
                .read(description, u64::MAX, &never, &Progress::new());
            read.expect("is right").expect("nobody cancels")
        }
    }

    /// Hands every block over so many times.
    struct Store<'a> {
        writer: &'a RenderWriter,
        times: usize,
        blocks: Mutex<HashSet<(u32, u32)>>,
    }

    impl BlockStore for Store<'_> {
        fn begin_anew(&self) {
            self.writer.begin_log();
        }

        fn keep(&self, block: &Block<'_>) {
            let BlockHeader { pass, tile, .. } = block.header;
            let mut blocks = self.blocks.lock().expect("no panic");
            blocks.insert((pass, tile));
            for _ in 0..self.times {
                self.writer.log(block);
            }
        }

        fn recall(&self, _pass: u32, _tile: u32) -> Option<Block<'static>> {
            None
        }
    }

    /// Renders all of it, with checkpoints as often as can be, and hands every block over so many times. Returns which blocks there were.
    fn render(place: &Place, writer: &RenderWriter, times: usize) -> HashSet<(u32, u32)> {
        let prepared = PreparedScene::prepare(&place.subject.scene, None, &CancelToken::new());
        let prepared = prepared.expect("can be rendered").expect("nobody cancels");
        let store = Store {
            writer,
            times,
            blocks: Mutex::default(),
        };
        let keep = |checkpoint| writer.keep(checkpoint, false);
        let took = || writer.checkpoint_took();
        let watch = Watch {
            checkpoints: Some(CheckpointKeeper {
                every: Duration::ZERO,
                most_share: f64::INFINITY,
                keep: &keep,
                in_background: Some(&took),
            }),
            blocks: Some(&store),
            ..Watch::default()
        };
        let (run, progress) = (RunConfig::default(), RenderProgress::default());
        render_watched(&prepared, None, &run, &progress, watch).expect("nobody cancels");
        store.blocks.into_inner().expect("no panic")
    }

    #[test]
    fn a_render_does_not_wait_for_a_disk_and_all_of_it_gets_there() {
        let (place, writer) = Place::new();
        let blocks = place.while_disk_hangs(|| {
            let blocks = render(&place, &writer, 1);
            assert_eq!(writer.checkpoint_took(), None);
            assert_eq!(place.files(), Vec::<PathBuf>::new());
            // As a render does that ends.
            drop(writer);
            blocks
        });
        place.wait();
        let (checkpoint, logged) = place.read();
        let checkpoint = checkpoint.expect("there is one");
        let (known, others): (Vec<_>, Vec<_>) = blocks
            .into_iter()
            .partition(|&(pass, tile)| !checkpoint.lacks(pass, tile));
        assert!(!known.is_empty() && others.len() > 4);
        for (pass, tile) in others {
            assert!(logged.find(pass, tile).is_some(), "{tile} of pass {pass}");
        }
        let superseded = place
            .files()
            .into_iter()
            .find(|it| it.ends_with("blocks-1"));
        assert_eq!(superseded, None);
    }

    #[test]
    fn what_is_given_up_while_a_disk_hangs_leaves_nothing() {
        let (mut place, writer) = Place::new();
        let other = place.session.place_render(place.kept.about().clone());
        place.while_disk_hangs(|| {
            render(&place, &writer, 1);
            place.kept.give_up();
            drop(writer);
        });
        place.kept = Arc::new(other);
        place.wait();
        assert_eq!(place.files(), Vec::<PathBuf>::new());
    }

    #[test]
    fn blocks_that_a_disk_is_too_slow_for_are_left_out() {
        let (place, writer) = Place::new();
        place.while_disk_hangs(|| render(&place, &writer, 4000));
        let (_, bytes) = writer.spent_on_blocks();
        let most = MOST_WAITING_BYTES + (1 << 20);
        assert!((MOST_WAITING_BYTES..most).contains(&bytes), "{bytes}");
        // Later ones are taken again.
        let deadline = Instant::now() + Duration::from_mins(1);
        while writer.state.waiting.load(Ordering::Relaxed) > 0 {
            assert!(Instant::now() < deadline, "they wait for ever");
            thread::sleep(Duration::from_millis(1));
        }
        render(&place, &writer, 1);
        assert!(writer.spent_on_blocks().1 > bytes);
        drop(writer);
        place.wait();
        assert!(place.read().0.is_some());
    }
}
