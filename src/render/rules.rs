//! The rules by which a render ends. They may be changed while it runs.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::scene::{RenderSettings, Stop};

/// When a render ends: whichever comes first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopRules {
    /// The most samples of a pixel, at least 1.
    pub samples_per_pixel: u32,
    /// What ends it before.
    pub stop: Stop,
}

impl StopRules {
    /// Those that `settings` hold.
    #[must_use]
    pub fn of(settings: &RenderSettings) -> Self {
        Self {
            samples_per_pixel: settings.samples_per_pixel,
            stop: settings.stop,
        }
    }

    /// Puts them in place of those that `settings` hold.
    pub fn put_into(self, settings: &mut RenderSettings) {
        settings.samples_per_pixel = self.samples_per_pixel;
        settings.stop = self.stop;
    }

    /// Whether a render that was begun with `settings` can end by these rules: what it measures and what it leaves out of a sample stay the
    /// same.
    #[must_use]
    pub fn suit(self, settings: &RenderSettings) -> bool {
        let mut changed = settings.clone();
        self.put_into(&mut changed);
        let has_one = |settings: &RenderSettings| settings.samples_per_pixel == 1;
        changed.measures_error() == settings.measures_error()
            && has_one(&changed) == has_one(settings)
    }
}

/// Rules that somebody may change while a render goes by them; clones are one and the same. Time is looked at all the while, all else when a
/// pass is over.
#[derive(Clone, Debug)]
pub struct LiveRules(Arc<Mutex<Live>>);

#[derive(Debug)]
struct Live {
    rules: StopRules,
    is_of_its_own: bool,
}

impl LiveRules {
    /// These, until others are set.
    #[must_use]
    pub fn new(rules: StopRules) -> Self {
        Self(Arc::new(Mutex::new(Live {
            rules,
            is_of_its_own: false,
        })))
    }

    /// From now on `rules` hold.
    ///
    /// They must [suit](StopRules::suit) the settings that the render was begun with.
    pub fn set(&self, rules: StopRules) {
        self.lock().rules = rules;
    }

    /// Those that hold now.
    #[must_use]
    pub fn get(&self) -> StopRules {
        self.lock().rules
    }

    /// Whether rules were changed so late that the picture is no longer, bit for bit, that of a render by the last ones from the start: where
    /// pixels had been chosen by those before, or would have been by those after.
    #[must_use]
    pub fn lead_elsewhere(&self) -> bool {
        self.lock().is_of_its_own
    }

    /// Says that they [lead elsewhere](Self::lead_elsewhere).
    pub fn set_lead_elsewhere(&self) {
        self.lock().is_of_its_own = true;
    }

    fn lock(&self) -> MutexGuard<'_, Live> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
