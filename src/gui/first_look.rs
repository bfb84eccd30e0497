//! A render that has shown a first look rests until that is drawn: where the processor draws the window, the two would slow each other down, and the
//! user waits for the window.

use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::control::CancelToken;

/// How long a render rests at most: windows that nobody sees are not drawn.
const MOST: Duration = Duration::from_millis(150);
/// How often it looks whether it is cancelled.
const LOOK: Duration = Duration::from_millis(5);

/// Whether the first look of a render is drawn. Clones are one and the same.
#[derive(Clone, Debug, Default)]
pub struct FirstLook(Arc<(Mutex<bool>, Condvar)>);

impl FirstLook {
    /// It is drawn.
    pub fn set_drawn(&self) {
        let (is_drawn, changed) = &*self.0;
        *is_drawn.lock().unwrap_or_else(PoisonError::into_inner) = true;
        changed.notify_all();
    }

    /// Waits until it is, for a moment at most, or until `cancel` is asked for. Returns whether it is.
    pub fn wait(&self, cancel: &CancelToken) -> bool {
        let (is_drawn, changed) = &*self.0;
        let end = Instant::now() + MOST;
        let mut drawn = is_drawn.lock().unwrap_or_else(PoisonError::into_inner);
        while !*drawn && !cancel.is_cancelled() && Instant::now() < end {
            drawn = changed
                .wait_timeout(drawn, LOOK)
                .unwrap_or_else(PoisonError::into_inner)
                .0;
        }
        *drawn
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_render_rests_until_its_first_look_is_drawn_but_not_for_long() {
        let cancel = CancelToken::new();
        let look = FirstLook::default();
        let started = Instant::now();
        assert!(!look.wait(&cancel));
        assert!(started.elapsed() >= MOST);
        look.clone().set_drawn();
        assert!(look.wait(&cancel));
        cancel.cancel();
        assert!(!FirstLook::default().wait(&cancel));
    }
}
