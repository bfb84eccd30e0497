//! `raymini plan --proofs`: a table that shows of all that is left out that it is, and what that saves.

use std::fmt::Write as _;

use anyhow::{Result, bail};
use serde::Serialize;

use crate::analysis::proofs::{Bench, Case, Finding, cases};
use crate::analysis::report::Machine;
use crate::control::Progress;
use crate::io;
use crate::scene::SceneError;

/// What was found of one case.
#[derive(Debug, Serialize)]
struct Proof {
    left_out: &'static str,
    when: &'static str,
    counted: &'static str,
    count: u64,
    otherwise: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    same_bits: Option<bool>,
    /// What it would add to the time.
    #[serde(skip_serializing_if = "Option::is_none")]
    saving: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    interval: Option<[f64; 2]>,
    holds: bool,
}

#[derive(Debug, Serialize)]
struct Proofs {
    machine: Machine,
    pairs: usize,
    cases: Vec<Proof>,
}

impl Proof {
    fn new(case: &Case, finding: &Finding) -> Self {
        Self {
            left_out: case.left_out,
            when: case.when,
            counted: case.counted,
            count: finding.count,
            otherwise: finding.otherwise,
            same_bits: finding.same_bits,
            saving: finding.saving.map(|share| share.value),
            interval: finding.saving.map(|share| share.interval),
            holds: finding.holds(),
        }
    }

    /// A row of a table in Markdown.
    fn row(&self) -> String {
        let same_bits = match self.same_bits {
            Some(true) => "yes",
            Some(false) => "**no**",
            None => "",
        };
        let saving = self.saving.zip(self.interval).map(|(value, interval)| {
            let [low, high] = interval.map(in_words);
            format!("{} ({low} to {high})", in_words(value))
        });
        format!(
            "| {} | {} | {} | {} | {} | {same_bits} | {} |\n",
            self.left_out,
            self.when,
            self.counted,
            self.count,
            self.otherwise,
            saving.unwrap_or_default()
        )
    }
}

/// A share that is added: in per cent, or as a factor where it is many times the whole.
fn in_words(share: f64) -> String {
    if share < 10.0 {
        format!("{:+.1} %", 100.0 * share)
    } else {
        format!("× {:.0}", 1.0 + share)
    }
}

/// The picture that is measured, in pixels: large enough for quotients of times.
const SIZE: (u32, u32) = (240, 135);

/// Measures all proofs on the demo and prints them.
///
/// # Errors
/// That something is done that is not needed, or changes the picture.
pub(super) fn run(pairs: u16, json: bool) -> Result<()> {
    let mut scene = io::demo_scene();
    (scene.render.width, scene.render.height) = SIZE;
    let pairs = usize::from(pairs);
    let progress = Progress::new();
    progress.set_total(cases().count() as u64);
    let how_far = || (progress.fraction(), "measuring".to_owned());
    let measure = || -> Result<Vec<Proof>, SceneError> {
        let bench = Bench {
            scene: &scene,
            pairs,
        };
        let proof = |case: &Case| {
            let finding = case.run(&bench)?;
            progress.advance(1);
            Ok(Proof::new(case, &finding))
        };
        cases().map(proof).collect()
    };
    let proofs = Proofs {
        machine: Machine::this(1),
        pairs,
        cases: super::progress_bar::show(how_far, measure)?,
    };
    if json {
        super::say_json(&proofs)?;
    } else {
        super::say(proofs.describe().trim_end())?;
    }
    let wrong: Vec<_> = proofs.cases.iter().filter(|proof| !proof.holds).collect();
    if let [first, ..] = wrong[..] {
        bail!(
            "{} of {} are not left out as they should be, the first: {}",
            wrong.len(),
            proofs.cases.len(),
            first.left_out
        );
    }
    Ok(())
}

impl Proofs {
    fn describe(&self) -> String {
        let mut text = format!(
            "RayMini {}, {}; the demo, {}×{}; savings are medians of {} pairs (95 %)\n\n",
            env!("CARGO_PKG_VERSION"),
            self.machine.describe(),
            SIZE.0,
            SIZE.1,
            self.pairs
        );
        let _ = writeln!(
            text,
            "| left out | when | what is counted | count | otherwise | same bits | it would add |\n\
             |---|---|---|---|---|---|---|"
        );
        text.extend(self.cases.iter().map(Proof::row));
        text
    }
}
