//! Which threads render.

use std::sync::LazyLock;
use std::time::{Duration, Instant};

/// How long after the last key, click or move of the mouse the user counts as working in the window.
const REST: Duration = Duration::from_millis(500);

/// Which threads render.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Threads {
    /// One per core, and one fewer while the user works in the window.
    #[default]
    Courteous,
    /// One per core, always.
    All,
    /// So many.
    Fixed(usize),
}

impl Threads {
    /// The number as [`crate::render::RunConfig::threads`] wants it.
    #[must_use]
    pub fn count(self) -> usize {
        match self {
            Self::Courteous | Self::All => 0,
            Self::Fixed(count) => count,
        }
    }

    /// How many of them may work, on `cores` cores, while the user works in the window or does not.
    #[must_use]
    pub fn allowed(self, cores: usize, is_user_active: bool) -> usize {
        match self {
            Self::Courteous if is_user_active => cores.saturating_sub(1).max(1),
            _ => usize::MAX,
        }
    }
}

/// Processor cores, as far as the system tells.
#[must_use]
pub fn cores() -> usize {
    // The system reads files to tell, which is too slow for every frame.
    static CORES: LazyLock<usize> =
        LazyLock::new(|| std::thread::available_parallelism().map_or(1, usize::from));
    *CORES
}

/// When the user last did something in the window.
#[derive(Clone, Copy, Debug, Default)]
pub struct Attention(Option<Instant>);

impl Attention {
    /// Takes note of what came in with this frame.
    pub fn note(&mut self, ctx: &egui::Context) {
        if ctx.input(|input| !input.events.is_empty() || input.pointer.any_down()) {
            self.0 = Some(Instant::now());
        }
    }

    /// How long the user still counts as working in the window; `None` where nobody does.
    #[must_use]
    pub fn time_left(&self) -> Option<Duration> {
        REST.checked_sub(self.0?.elapsed())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_core_is_left_to_the_user_where_there_is_one_to_spare() {
        assert_eq!(Threads::Courteous.allowed(8, true), 7);
        assert_eq!(Threads::Courteous.allowed(8, false), usize::MAX);
        assert_eq!(Threads::Courteous.allowed(1, true), 1);
        for threads in [Threads::All, Threads::Fixed(2)] {
            assert_eq!(threads.allowed(8, true), usize::MAX);
        }
        assert_eq!((Threads::All.count(), Threads::Fixed(3).count()), (0, 3));
    }
}
