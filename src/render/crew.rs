//! The threads of a render: they share out pieces of work, end when somebody asks, and report the first fault.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use super::fault::{RenderFault, SampleNote, caught};
use super::run::RunConfig;
use super::stops::Stops;
use crate::control::CancelToken;

/// What ends a render in the middle of a pass.
pub enum Cut {
    Cancelled,
    Interrupted,
    TimeUp,
    Failed(RenderFault),
}

/// See the module's description.
pub struct Crew<'a> {
    run: &'a RunConfig,
    pool: rayon::ThreadPool,
    threads: usize,
    /// The first sample at which the program failed.
    fault: Mutex<Option<RenderFault>>,
    /// Ends the work of the other threads then.
    halt: CancelToken,
}

impl<'a> Crew<'a> {
    /// As many threads as `run` wants.
    pub fn new(run: &'a RunConfig) -> Self {
        let threads = run.thread_count();
        Self {
            run,
            pool: rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .expect("threads can be started"),
            threads,
            fault: Mutex::new(None),
            halt: CancelToken::new(),
        }
    }

    /// Number of threads.
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// The threads, for work that is not cut into pieces here.
    pub fn pool(&self) -> &rayon::ThreadPool {
        &self.pool
    }

    /// Calls `work` once for every number below `count`, or for fewer when it is cut, with the number, that of the thread, and a `T` that
    /// the thread keeps. Who interrupts it when all is done does not cut it.
    pub fn for_each<T: Default>(
        &self,
        count: usize,
        work: &(dyn Fn(usize, usize, &mut T) -> Option<()> + Sync),
    ) -> Result<(), Cut> {
        let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let is_cut = || {
            [&self.run.cancel, &self.run.interrupt, &self.halt]
                .iter()
                .any(|token| token.is_cancelled())
        };
        let is_over = || next.load(Ordering::Relaxed) >= count || is_cut();
        self.pool.broadcast(|thread| {
            let mut own = T::default();
            loop {
                self.run.throttle.wait_for_turn(thread.index(), is_over);
                let number = next.fetch_add(1, Ordering::Relaxed);
                if number >= count || is_cut() || work(number, thread.index(), &mut own).is_none() {
                    break;
                }
                done.fetch_add(1, Ordering::Relaxed);
            }
            // The others need not wait for their turn any more.
            self.run.throttle.wake();
        });
        let fault = self.fault.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(fault) = &*fault {
            return Err(Cut::Failed(fault.clone()));
        }
        if self.run.cancel.is_cancelled() {
            return Err(Cut::Cancelled);
        }
        if self.run.interrupt.is_cancelled() && done.into_inner() < count {
            return Err(Cut::Interrupted);
        }
        Ok(())
    }

    /// Calls `take`, which takes samples and notes at which it is; `None` when it is stopped, or the program fails at a sample.
    pub fn sample<T>(&self, take: impl FnOnce(&Stops<'_>, &SampleNote) -> Option<T>) -> Option<T> {
        let note = SampleNote::default();
        let stops = Stops {
            cancel: &self.run.cancel,
            halt: &self.halt,
            throttle: &self.run.throttle,
        };
        caught(&note, || take(&stops, &note)).unwrap_or_else(|found| {
            let mut fault = self.fault.lock().unwrap_or_else(PoisonError::into_inner);
            fault.get_or_insert(found);
            self.halt.cancel();
            None
        })
    }
}
