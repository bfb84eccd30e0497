//! The extreme cases that break renderers, each tried on this one: what `raymini check` measures where no scene is named.
//!
//! A [`Case`] measures one figure and knows the bar it must stay within. The figures come from renders and rays of scenes that
//! the case makes itself, and are held against closed forms, brute force, or a picture that must be the same bits; never against
//! what this program gave before.

mod frame;
mod furnace;
mod glass;
mod input;
mod lens;
mod lights;
mod meshes;
mod phong;
mod picture;
mod rays;
mod stage;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

use crate::render::panic_message;

/// One way in which a renderer may fail, and how it shows.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// What it is about.
    pub name: &'static str,
    /// What is tried and what the measured figure is.
    pub tried: &'static str,
    /// What the figure must be.
    pub bar: Bar,
    /// Whether the figure is a time, which a busy machine makes larger.
    pub is_timed: bool,
    measure: fn(Effort) -> f64,
}

/// What a measured figure must be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bar {
    /// This, and nothing else.
    Exactly(f64),
    /// This or less.
    AtMost(f64),
}

/// How much is tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// Seconds in all.
    Quick,
    /// As many rays and samples as give the figures their meaning: minutes.
    Long,
}

/// What came out.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The figure; not a number where there is none.
    pub measured: f64,
    /// Whether it is what it must be.
    pub passed: bool,
    /// What it took.
    pub seconds: f64,
    /// What the program said when it broke down.
    pub panic: Option<String>,
}

/// Every case, in the order of what it is about.
pub fn cases() -> impl Iterator<Item = &'static Case> {
    let groups = [
        phong::CASES,
        furnace::CASES,
        lights::CASES,
        glass::CASES,
        frame::CASES,
        meshes::CASES,
        rays::CASES,
        lens::CASES,
        picture::CASES,
        input::CASES,
    ];
    groups.into_iter().flatten()
}

impl Case {
    /// Tries it.
    #[must_use]
    pub fn run(&self, effort: Effort) -> Finding {
        let started = Instant::now();
        let outcome = catch_unwind(AssertUnwindSafe(|| (self.measure)(effort)));
        let (measured, panic) = match outcome {
            Ok(measured) => (measured, None),
            Err(payload) => (f64::NAN, Some(panic_message(payload.as_ref()))),
        };
        Finding {
            measured,
            passed: self.bar.is_kept_by(measured),
            seconds: started.elapsed().as_secs_f64(),
            panic,
        }
    }
}

impl Bar {
    /// Whether `measured` is what it must be; nothing that is not a number is.
    #[must_use]
    pub fn is_kept_by(self, measured: f64) -> bool {
        match self {
            Self::Exactly(bar) => measured == bar,
            Self::AtMost(bar) => measured <= bar,
        }
    }

    /// The number in it.
    #[must_use]
    pub fn value(self) -> f64 {
        match self {
            Self::Exactly(bar) | Self::AtMost(bar) => bar,
        }
    }
}

impl Effort {
    /// One of two numbers.
    fn pick<T>(self, quick: T, long: T) -> T {
        match self {
            Self::Quick => quick,
            Self::Long => long,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn a_case_fails_by_its_figure_and_by_a_panic() {
        let case = |measure| Case {
            name: "",
            tried: "",
            bar: Bar::AtMost(1.0),
            is_timed: false,
            measure,
        };
        assert!(case(|_| 1.0).run(Effort::Quick).passed);
        assert!(!case(|_| 1.1).run(Effort::Quick).passed);
        assert!(!case(|_| f64::NAN).run(Effort::Quick).passed);
        let broken = case(|_| panic!("of {}", 3)).run(Effort::Quick);
        assert_eq!((broken.passed, broken.panic), (false, Some("of 3".into())));
    }

    #[test]
    fn names_are_unique() {
        let names: HashSet<_> = cases().map(|case| case.name).collect();
        assert_eq!(names.len(), cases().count());
    }
}
