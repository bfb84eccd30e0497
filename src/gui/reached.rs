//! What a render had reached when it ended, for one that goes on from there by other rules.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::jobs::drop_elsewhere;
use crate::render::Checkpoint;
use crate::scene::Scene;

/// The most that what a render reached may take of memory to be copied, in bytes: that takes less than a second.
pub const MOST_BYTES: u64 = 1 << 30;

/// A place for what a render has reached. Clones are one and the same.
#[derive(Clone, Debug, Default)]
pub struct Reached(Arc<Mutex<Slot>>);

/// What a render takes up where it goes on with another that has ended.
#[derive(Clone, Debug)]
pub struct TakenUp {
    /// What that has reached.
    pub reached: Reached,
    /// Whether it ends by other rules than that did.
    pub has_other_rules: bool,
}

#[derive(Debug, Default)]
struct Slot {
    checkpoint: Option<Box<Checkpoint>>,
    /// Whether nobody will go on from there, so that what comes later is not kept.
    is_closed: bool,
}

impl Drop for Slot {
    fn drop(&mut self) {
        if let Some(checkpoint) = self.checkpoint.take() {
            drop_elsewhere(checkpoint);
        }
    }
}

impl Reached {
    /// Puts it there, unless somebody has [taken](Self::take) it before it came.
    pub fn set(&self, checkpoint: Checkpoint) {
        let mut slot = self.lock();
        if slot.is_closed {
            drop_elsewhere(checkpoint);
        } else {
            slot.checkpoint = Some(Box::new(checkpoint));
        }
    }

    /// Whether it is there.
    #[must_use]
    pub fn is_there(&self) -> bool {
        self.lock().checkpoint.is_some()
    }

    /// Whether a render of `after` that goes on from there ends with another picture than one from the start would; `before`: what it is of, which
    /// differs in nothing but when it ends.
    #[must_use]
    pub fn leads_elsewhere(&self, before: &Scene, after: &Scene) -> bool {
        let slot = self.lock();
        let reached = slot.checkpoint.as_ref();
        reached.is_some_and(|reached| reached.leads_elsewhere(&before.render, &after.render))
    }

    /// Takes it away for good.
    #[must_use]
    pub fn take(&self) -> Option<Box<Checkpoint>> {
        let mut slot = self.lock();
        slot.is_closed = true;
        slot.checkpoint.take()
    }

    /// Puts what is there in another place, for good.
    pub fn hand_on_to(&self, other: &Self) {
        if let Some(checkpoint) = self.take() {
            other.set(*checkpoint);
        }
    }

    fn lock(&self) -> MutexGuard<'_, Slot> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
