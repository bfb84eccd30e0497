//! Background work: one lane per kind of work, of whose jobs the newest counts, results by channel.
//!
//! ```text
//! window ──start(lane, work)──▶ thread ──send(event)──▶ channel ──next_event()──▶ window
//!            cancels the lane's     wakes the window         drops what an older
//!            older job              (request_repaint)        generation still says
//! ```
//!
//! The window thread never waits for a job to end, only for a first look at a picture, and not for long ([`Jobs::wait_for`]). Starting a job in a lane, or cancelling the lane, raises the lane's
//! generation: whatever an older job still sends is dropped, so the window never shows a result it no longer wants. Jobs that must
//! end, such as those that write files, are not given up for one that is started after them: they run one after another, and what
//! each has to say is heard. A job that panics is reported in words like any other failure; the window and its scene go on.

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::control::CancelToken;
use crate::render::panic_message;

/// Time between two looks at whether something that is waited for is cancelled.
const LOOK_INTERVAL: Duration = Duration::from_millis(2);

/// A kind of background work. Work in different lanes runs at the same time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lane {
    /// Reading scenes, meshes and images.
    Load,
    /// Placing triangles, building their tree, uploading them for the preview.
    Prepare,
    /// Rendering the picture.
    Render,
    /// Converting a finished picture for the screen after a display setting changed.
    Encode,
    /// Making small pictures of renders.
    Thumbnails,
    /// Counting how bright a picture is.
    Histogram,
    /// Measuring how far two pictures are apart.
    Compare,
    /// Converting the picture that is compared with for the screen.
    EncodeOther,
    /// Reading a picture to compare with.
    CompareFile,
    /// Writing the scene.
    SaveScene,
    /// Writing the picture.
    SavePicture,
    /// Waiting for the desktop's file dialog.
    Dialog,
    /// Reading a folder for the path field.
    List,
    /// Looking where missing files are.
    Locate,
    /// Measuring error against run time.
    Report,
    /// Measuring what effects cost.
    Costs,
    /// Finding out how long a render will take.
    Time,
    /// Rendering balls of materials.
    Balls,
    /// Rendering what effects and lights bring.
    Contributions,
    /// Taking a camera sample again.
    Trace,
    /// Waiting for the desktop to show a folder.
    ShowFolder,
    /// Looking for what earlier windows left.
    Begin,
    /// Writing unsaved work, or removing it.
    Keep,
    /// Removing work that is not wanted.
    Discard,
    /// Writing the list of files opened last.
    Recent,
    /// Writing what the window looks like.
    Layout,
    /// Looking whether files have changed.
    Watch,
    /// Reading those that have.
    Reload,
}

const LANES: usize = 28;

impl Lane {
    /// Whether a job of this lane must end on its own, also when the window closes or another is started after it: half a file is worse
    /// than none.
    fn must_end(self) -> bool {
        matches!(
            self,
            Self::SaveScene
                | Self::SavePicture
                | Self::Report
                | Self::Keep
                | Self::Discard
                | Self::Recent
                | Self::Layout
        )
    }
}

/// What the window holds of its background work. `E` is what jobs have to say.
#[derive(Debug)]
pub struct Jobs<E> {
    wake: Wake,
    sender: Sender<Message<E>>,
    receiver: Receiver<Message<E>>,
    /// What came while something was waited for.
    early: VecDeque<Message<E>>,
    lanes: [LaneState; LANES],
}

#[derive(Debug, Default)]
struct LaneState {
    generation: u64,
    cancel: CancelToken,
    /// How many jobs of the present generation have not ended: one at most, unless they [must end](Lane::must_end).
    unended: usize,
    /// How many jobs were started.
    started: u64,
    /// Threads of this lane that have not ended, cancelled ones included.
    threads: Arc<AtomicUsize>,
    /// The newest of those that [must end](Lane::must_end) before the program does; it waits for the others.
    must_end: Option<JoinHandle<()>>,
}

#[derive(Debug)]
struct Message<E> {
    lane: Lane,
    generation: u64,
    content: Content<E>,
}

#[derive(Debug)]
enum Content<E> {
    Event(E),
    Ended,
    Panicked(String),
}

/// What the window learns from its jobs.
#[derive(Debug, PartialEq)]
pub enum News<E> {
    /// A running job has something to say.
    Event(E),
    /// A job ended by a fault of the program, with this message.
    Panicked(Lane, String),
}

/// What a job holds of the window.
#[derive(Debug)]
pub struct Job<E> {
    /// Set when the window no longer wants the job's result.
    pub cancel: CancelToken,
    lane: Lane,
    generation: u64,
    sender: Sender<Message<E>>,
    wake: Wake,
}

/// One says what it has to say in the name of the other.
impl<E> Clone for Job<E> {
    fn clone(&self) -> Self {
        Self {
            cancel: self.cancel.clone(),
            lane: self.lane,
            generation: self.generation,
            sender: self.sender.clone(),
            wake: self.wake.clone(),
        }
    }
}

/// The window to wake when there is news, which may become another one.
#[derive(Clone, Debug)]
struct Wake(Arc<Mutex<egui::Context>>);

impl Wake {
    fn window(&self) -> MutexGuard<'_, egui::Context> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<E> Job<E> {
    /// Tells the window, and wakes it.
    pub fn send(&self, event: E) {
        self.send_and_wake(Content::Event(event), Duration::ZERO);
    }

    /// Tells the window, and wakes it after `delay` at the latest: news that come in crowds share a frame.
    pub fn send_within(&self, event: E, delay: Duration) {
        self.send_and_wake(Content::Event(event), delay);
    }

    fn send_and_wake(&self, content: Content<E>, delay: Duration) {
        let message = Message {
            lane: self.lane,
            generation: self.generation,
            content,
        };
        // A closed window does not listen any more, which is fine.
        if self.sender.send(message).is_ok() {
            self.wake.window().request_repaint_after(delay);
        }
    }
}

impl<E: Send + 'static> Jobs<E> {
    /// No job yet. `wake`: the window to wake when there is news.
    #[must_use]
    pub fn new(wake: egui::Context) -> Self {
        let (sender, receiver) = channel();
        Self {
            wake: Wake(Arc::new(Mutex::new(wake))),
            sender,
            receiver,
            early: VecDeque::new(),
            lanes: Default::default(),
        }
    }

    /// From now on another window is woken, by what runs already too.
    pub fn set_window(&mut self, window: egui::Context) {
        *self.wake.window() = window;
    }

    /// Runs `work` on a thread of its own: in place of what the lane was doing, or after that where it must end.
    pub fn start(&mut self, lane: Lane, work: impl FnOnce(&Job<E>) + Send + 'static) {
        if !lane.must_end() {
            self.cancel(lane);
        }
        let state = &mut self.lanes[lane as usize];
        state.unended += 1;
        state.started += 1;
        let job = Job {
            cancel: state.cancel.clone(),
            lane,
            generation: state.generation,
            sender: self.sender.clone(),
            wake: self.wake.clone(),
        };
        let threads = Arc::clone(&state.threads);
        threads.fetch_add(1, Ordering::Relaxed);
        let before = state.must_end.take();
        let thread = std::thread::spawn(move || {
            // Files are written in the order in which they were asked for: what is written last stays.
            if let Some(before) = before {
                // A job catches its own panics.
                let _ = before.join();
            }
            let result = catch_unwind(AssertUnwindSafe(|| work(&job)));
            threads.fetch_sub(1, Ordering::Relaxed);
            let content = match result {
                Ok(()) => Content::Ended,
                Err(payload) => Content::Panicked(panic_message(payload.as_ref())),
            };
            job.send_and_wake(content, Duration::ZERO);
        });
        if lane.must_end() {
            self.lanes[lane as usize].must_end = Some(thread);
        }
    }

    /// Asks the lane's jobs to stop, and forgets them.
    pub fn cancel(&mut self, lane: Lane) {
        let state = &mut self.lanes[lane as usize];
        state.cancel.cancel();
        state.cancel = CancelToken::new();
        state.generation += 1;
        state.unended = 0;
    }

    /// Whether the lane has a job that was not cancelled.
    #[must_use]
    pub fn is_busy(&self, lane: Lane) -> bool {
        self.lanes[lane as usize].unended > 0
    }

    /// How many jobs of the lane were started so far.
    #[must_use]
    pub fn started(&self, lane: Lane) -> u64 {
        self.lanes[lane as usize].started
    }

    /// Threads of the lane that still run: its job, and cancelled ones that have not noticed yet.
    #[must_use]
    pub fn running_threads(&self, lane: Lane) -> usize {
        self.lanes[lane as usize].threads.load(Ordering::Relaxed)
    }

    /// Waits for the job of the lane to say something, or to end, but no longer than `most`.
    pub fn wait_for(&mut self, lane: Lane, most: Duration) {
        let end = Instant::now() + most;
        let generation = self.lanes[lane as usize].generation;
        while self.is_busy(lane)
            && let Ok(message) = self
                .receiver
                .recv_timeout(end.saturating_duration_since(Instant::now()))
        {
            let is_it = message.lane == lane && message.generation == generation;
            self.early.push_back(message);
            if is_it {
                return;
            }
        }
    }

    /// The next thing a job that is still wanted has to say, if there is one. Never waits.
    pub fn next_event(&mut self) -> Option<News<E>> {
        let mut unwanted = Vec::new();
        let news = self.next_wanted(&mut unwanted);
        if !unwanted.is_empty() {
            // Pixels of a render that was given up, say, are its threads' last memory.
            drop_elsewhere(unwanted);
        }
        news
    }

    /// [`Self::next_event`], with what nobody wants to hear of put aside.
    fn next_wanted(&mut self, unwanted: &mut Vec<Content<E>>) -> Option<News<E>> {
        loop {
            let Message {
                lane,
                generation,
                content,
            } = match self.early.pop_front() {
                Some(message) => message,
                None => self.receiver.try_recv().ok()?,
            };
            let state = &mut self.lanes[lane as usize];
            if generation != state.generation {
                unwanted.push(content);
                continue;
            }
            match content {
                Content::Event(event) => return Some(News::Event(event)),
                Content::Ended => state.unended -= 1,
                Content::Panicked(message) => {
                    state.unended -= 1;
                    return Some(News::Panicked(lane, message));
                }
            }
        }
    }
}

impl<E> Drop for Jobs<E> {
    /// Closing the window stops the work nobody will see, and waits for files to be written whole.
    fn drop(&mut self) {
        for state in &self.lanes {
            state.cancel.cancel();
        }
        for thread in self
            .lanes
            .iter_mut()
            .filter_map(|state| state.must_end.take())
        {
            let _ = thread.join();
        }
    }
}

/// Gives back memory on another thread: for triangles, trees and pictures that takes longer than the window has for a frame.
pub fn drop_elsewhere(what: impl Send + 'static) {
    rayon::spawn(move || drop(what));
}

/// Gives back memory, and waits until it is there again, unless cancelled: gigabytes take longer than a cancel may.
pub fn drop_unless_cancelled(what: impl Send + 'static, cancel: &CancelToken) {
    let (holds, is_held) = channel::<()>();
    // On a thread of its own: what is waited for must not wait for other work.
    std::thread::spawn(move || {
        drop(what);
        drop(holds);
    });
    while !cancel.is_cancelled()
        && is_held.recv_timeout(LOOK_INTERVAL) == Err(RecvTimeoutError::Timeout)
    {}
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::RenderFault;

    fn wait_for<E: Send + 'static>(jobs: &mut Jobs<E>) -> News<E> {
        let deadline = Instant::now() + Duration::from_secs(10);
        loop {
            if let Some(news) = jobs.next_event() {
                return news;
            }
            assert!(Instant::now() < deadline, "no news");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// To free the last memory of a thread that renders takes longer than a frame has.
    #[test]
    fn what_nobody_wants_to_hear_of_is_dropped_on_another_thread() {
        struct Said(Sender<std::thread::ThreadId>);
        impl Drop for Said {
            fn drop(&mut self) {
                let _ = self.0.send(std::thread::current().id());
            }
        }
        let (sender, dropped) = channel();
        let mut jobs = Jobs::new(egui::Context::default());
        jobs.start(Lane::Render, move |job| job.send(Said(sender)));
        jobs.wait_for(Lane::Render, Duration::from_secs(10));
        jobs.cancel(Lane::Render);
        assert!(jobs.next_event().is_none());
        let by = dropped.recv_timeout(Duration::from_secs(10));
        assert_ne!(by.expect("it is dropped"), std::thread::current().id());
    }

    /// What is rendered next may need it; who cancels waits for nobody.
    #[test]
    fn memory_that_is_given_back_is_waited_for_unless_cancelled() {
        struct Slow(Receiver<()>, Sender<()>);
        impl Drop for Slow {
            fn drop(&mut self) {
                let _ = self.0.recv();
                std::thread::sleep(Duration::from_millis(20));
                let _ = self.1.send(());
            }
        }
        let (sender, dropped) = channel();
        let slow = || {
            let (release, wait) = channel();
            (release, Slow(wait, sender.clone()))
        };
        let cancel = CancelToken::new();
        let (release, what) = slow();
        drop(release);
        drop_unless_cancelled(what, &cancel);
        assert_eq!(dropped.try_recv(), Ok(()));
        let (release, what) = slow();
        cancel.cancel();
        drop_unless_cancelled(what, &cancel);
        assert!(dropped.try_recv().is_err());
        drop(release);
        assert_eq!(dropped.recv_timeout(Duration::from_secs(10)), Ok(()));
    }

    #[test]
    fn results_of_a_replaced_job_are_dropped() {
        let mut jobs = Jobs::new(egui::Context::default());
        let (release, wait) = channel::<()>();
        jobs.start(Lane::Load, move |job| {
            let _ = wait.recv();
            assert!(job.cancel.is_cancelled());
            job.send("old");
        });
        jobs.start(Lane::Load, |job| job.send("new"));
        release.send(()).unwrap();
        assert_eq!(wait_for(&mut jobs), News::Event("new"));
        while jobs.running_threads(Lane::Load) > 0 {
            std::thread::sleep(Duration::from_millis(1));
        }
        // The end of a job is news to the lane alone.
        let deadline = Instant::now() + Duration::from_secs(10);
        while jobs.is_busy(Lane::Load) && Instant::now() < deadline {
            assert_eq!(jobs.next_event(), None);
        }
        assert!(!jobs.is_busy(Lane::Load));
    }

    #[test]
    fn a_panic_is_news_and_frees_the_lane() {
        let mut jobs = Jobs::<()>::new(egui::Context::default());
        jobs.start(Lane::Prepare, |_| {
            panic!("a triangle has {} corners", 4);
        });
        let expected = News::Panicked(Lane::Prepare, "a triangle has 4 corners".to_owned());
        assert_eq!(wait_for(&mut jobs), expected);
        assert!(!jobs.is_busy(Lane::Prepare));
    }

    #[test]
    fn a_sample_at_which_a_render_fails_is_named() {
        let mut jobs = Jobs::<()>::new(egui::Context::default());
        let fault = RenderFault {
            pixel: (3, 4),
            sample: 5,
            message: "as the test wants".to_owned(),
        };
        let said = fault.to_string();
        assert!(said.ends_with("raymini render SCENE --pixel 3,4 --sample 5"));
        jobs.start(Lane::Render, |_| std::panic::resume_unwind(Box::new(fault)));
        assert_eq!(wait_for(&mut jobs), News::Panicked(Lane::Render, said));
        assert!(!jobs.is_busy(Lane::Render));
    }

    #[test]
    fn closing_waits_for_files_to_be_written() {
        let mut jobs = Jobs::<()>::new(egui::Context::default());
        let written = Arc::new(AtomicUsize::new(0));
        let counter = Arc::clone(&written);
        jobs.start(Lane::SaveScene, move |_| {
            std::thread::sleep(Duration::from_millis(30));
            counter.fetch_add(1, Ordering::Relaxed);
        });
        drop(jobs);
        assert_eq!(written.load(Ordering::Relaxed), 1);
    }

    #[test]
    fn files_are_written_in_the_order_asked_for() {
        let mut jobs = Jobs::<()>::new(egui::Context::default());
        let written = Arc::new(Mutex::new(Vec::new()));
        for (number, time) in [(1, 30), (2, 10), (3, 0)] {
            let written = Arc::clone(&written);
            jobs.start(Lane::SaveScene, move |_| {
                std::thread::sleep(Duration::from_millis(time));
                written.lock().unwrap().push(number);
            });
        }
        drop(jobs);
        assert_eq!(*written.lock().unwrap(), [1, 2, 3]);
    }

    #[test]
    fn each_of_several_files_is_told_of() {
        let mut jobs = Jobs::new(egui::Context::default());
        let (release, wait) = channel::<()>();
        jobs.start(Lane::SavePicture, move |job| {
            let _ = wait.recv();
            assert!(!job.cancel.is_cancelled());
            job.send("the first cannot be written");
        });
        jobs.start(Lane::SavePicture, |job| job.send("the second is written"));
        release.send(()).unwrap();
        assert_eq!(
            wait_for(&mut jobs),
            News::Event("the first cannot be written")
        );
        assert_eq!(wait_for(&mut jobs), News::Event("the second is written"));
        let deadline = Instant::now() + Duration::from_secs(10);
        while jobs.is_busy(Lane::SavePicture) {
            assert!(Instant::now() < deadline, "both have ended");
            assert_eq!(jobs.next_event(), None);
        }
    }

    #[test]
    fn what_comes_while_another_is_waited_for_is_not_lost() {
        let mut jobs = Jobs::new(egui::Context::default());
        jobs.start(Lane::Load, |job| job.send("scene"));
        let first = wait_for(&mut jobs);
        assert_eq!(first, News::Event("scene"));
        let (release, wait) = channel::<()>();
        jobs.start(Lane::Render, move |job| {
            let _ = wait.recv();
            job.send("picture");
        });
        let started = Instant::now();
        jobs.wait_for(Lane::Render, Duration::from_millis(20));
        assert!(
            started.elapsed() >= Duration::from_millis(20),
            "it says nothing"
        );
        jobs.start(Lane::SaveScene, move |job| {
            job.send("saved");
            release.send(()).unwrap();
        });
        jobs.wait_for(Lane::Render, Duration::from_secs(10));
        let news = [wait_for(&mut jobs), wait_for(&mut jobs)];
        assert_eq!(news, [News::Event("saved"), News::Event("picture")]);
    }

    #[test]
    fn lanes_do_not_disturb_each_other() {
        let mut jobs = Jobs::new(egui::Context::default());
        let (release, wait) = channel::<()>();
        jobs.start(Lane::Render, move |job| {
            let _ = wait.recv();
            job.send("picture");
        });
        jobs.start(Lane::SavePicture, |job| job.send("saved"));
        assert_eq!(wait_for(&mut jobs), News::Event("saved"));
        assert!(jobs.is_busy(Lane::Render));
        release.send(()).unwrap();
        assert_eq!(wait_for(&mut jobs), News::Event("picture"));
    }
}
