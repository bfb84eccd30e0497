//! That what a scene does not need is left out: what `raymini plan --proofs` measures.
//!
//! A [`Case`] changes a scene so that something is not needed, and counts how often it is done all the same: never. Then it does what is
//! not needed: the picture must be the same bits, and the time it takes is what leaving it out saves.

mod features;
mod once;
mod structure;

use cpu_time::ProcessTime;

use super::cost::{Share, Trial};
use crate::control::CancelToken;
use crate::render::{
    Feature, PreparedScene, RenderOutcome, RenderProgress, RunConfig, Work, render,
};
use crate::scene::{Scene, SceneError};

/// Something that is left out, and when.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// What is left out.
    pub left_out: &'static str,
    /// When it is.
    pub when: &'static str,
    /// What is counted.
    pub counted: &'static str,
    proof: Proof,
}

/// How a case is measured.
#[derive(Clone, Copy, Debug)]
enum Proof {
    /// By the work of a render that is planned, and of one that does a feature, or everything, whether needed or not.
    Planned {
        feature: Option<Feature>,
        count: fn(&Work) -> u64,
        change: fn(&mut Scene),
    },
    /// In its own way.
    Own(fn(&Bench<'_>) -> Measured),
}

/// What a case is measured on.
#[derive(Clone, Copy, Debug)]
pub struct Bench<'a> {
    /// A scene in mode `direct` of matt objects that are lit and stand before a background of one colour or a gradient, without mirror and
    /// glass, with several samples per pixel: cases change it to their needs.
    pub scene: &'a Scene,
    /// Pairs of renders for each saving.
    pub pairs: usize,
}

/// What came out.
type Measured = Result<Finding, SceneError>;

/// What was found of a case.
#[derive(Clone, Copy, Debug)]
pub struct Finding {
    /// How often it was done: 0.
    pub count: u64,
    /// How often it is done where it is needed, or done for nothing.
    pub otherwise: u64,
    /// Whether the picture is the same bits with it; `None` where it is another picture.
    pub same_bits: Option<bool>,
    /// What doing it adds to the time; `None` where it cannot be done for nothing.
    pub saving: Option<Share>,
}

impl Finding {
    /// Whether it shows what it is to show.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.count == 0 && self.otherwise > 0 && self.same_bits != Some(false)
    }
}

/// Every case, in the order in which a sample comes to them, and those about what is made once.
pub fn cases() -> impl Iterator<Item = &'static Case> {
    let of_a_sample = features::CASES.iter().chain(structure::CASES);
    of_a_sample.chain(once::CASES)
}

impl Case {
    /// Measures it.
    ///
    /// # Errors
    /// What about the scene cannot be rendered.
    pub fn run(&self, bench: &Bench<'_>) -> Measured {
        match self.proof {
            Proof::Planned {
                feature,
                count,
                change,
            } => features::prove(bench, feature, count, change),
            Proof::Own(measure) => measure(bench),
        }
    }
}

impl Bench<'_> {
    /// The scene, changed.
    fn changed(&self, change: impl FnOnce(&mut Scene)) -> Scene {
        let mut scene = self.scene.clone();
        change(&mut scene);
        scene
    }
}

const NOBODY_CANCELS: &str = "nobody cancels";

fn prepare(scene: &Scene, previous: Option<&PreparedScene>) -> Result<PreparedScene, SceneError> {
    let prepared = PreparedScene::prepare(scene, previous, &CancelToken::new())?;
    Ok(prepared.expect(NOBODY_CANCELS))
}

fn trial_of(scene: &Scene) -> Result<Trial, SceneError> {
    let trial = Trial::new(scene, None, &CancelToken::new())?;
    Ok(trial.expect(NOBODY_CANCELS))
}

fn outcome_of(scene: &PreparedScene, layers: bool) -> RenderOutcome {
    let run = RunConfig {
        threads: 1,
        layers,
        ..RunConfig::default()
    };
    let outcome = render(scene, None, &run, &RenderProgress::default(), None);
    outcome.expect(NOBODY_CANCELS)
}

/// Processor time, on all cores.
fn seconds_of<T>(work: impl FnOnce() -> T) -> f64 {
    let started = ProcessTime::now();
    let made = std::hint::black_box(work());
    let seconds = started.elapsed().as_secs_f64();
    drop(made);
    seconds
}
