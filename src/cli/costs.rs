//! What the effects of a render cost and what leaving out saves, for people and programs.

use std::fmt::Write as _;

use serde::Serialize;

use crate::analysis::cost::{Costs, LAYERS, Share, Trial};
use crate::control::Progress;
use crate::scene::SceneError;

/// Fewer pairs than this have no interval.
const LEAST_PAIRS: u16 = 6;

/// Reads how many pairs there are to be.
pub(super) fn pairs(text: &str) -> Result<u16, String> {
    super::values::whole(LEAST_PAIRS..=1000)(text)
}

/// What was measured, by pairs of small renders.
#[derive(Debug, Serialize)]
pub(super) struct MeasuredCosts {
    pairs: usize,
    /// Of the time of a render.
    effects: Vec<MeasuredShare>,
    /// What it would add to that time.
    left_out: Vec<MeasuredShare>,
}

#[derive(Debug, Serialize)]
struct MeasuredShare {
    name: &'static str,
    /// The median of all pairs.
    share: f64,
    /// 95 % confidence; none for few pairs.
    #[serde(skip_serializing_if = "Option::is_none")]
    interval: Option<[f64; 2]>,
}

impl MeasuredCosts {
    /// Measures them, with the progress shown; `None` when cancelled.
    pub(super) fn of(trial: &Trial, pairs: u16) -> Result<Option<Self>, SceneError> {
        let progress = Progress::new();
        let how_far = || (progress.fraction(), "measuring costs".to_owned());
        let measure = || {
            trial.costs(pairs.into(), |done, all| {
                progress.set_total(all as u64);
                progress.advance(done as u64 - progress.done());
            })
        };
        let costs = super::progress_bar::show(how_far, measure)?;
        Ok(costs.as_ref().map(Self::new))
    }

    fn new(costs: &Costs) -> Self {
        let has_interval = costs.pairs >= LEAST_PAIRS.into();
        let measured = |(name, share): (&'static str, Share)| MeasuredShare {
            name,
            share: share.value,
            interval: has_interval.then_some(share.interval),
        };
        let effects = costs.effects.iter();
        Self {
            pairs: costs.pairs,
            effects: effects
                .map(|(effect, share)| measured((effect.name(), *share)))
                .collect(),
            left_out: costs.left_out().map(measured).collect(),
        }
    }

    /// Takes out what layers would add, for a render that keeps them.
    pub(super) fn forget_layers(&mut self) {
        self.left_out.retain(|share| share.name != LAYERS);
    }

    /// In words, line by line.
    pub(super) fn describe(&self) -> String {
        let what = if self.pairs >= LEAST_PAIRS.into() {
            format!("medians of {} pairs (95 %)", self.pairs)
        } else {
            format!("roughly, by {} pairs of small renders", self.pairs)
        };
        let mut text = String::new();
        if !self.effects.is_empty() {
            let _ = writeln!(text, "part of the time, {what}:");
            text.extend(self.effects.iter().map(MeasuredShare::line));
            text += "\n";
        }
        let _ = writeln!(text, "what leaving out saves, {what}: it would add");
        text.extend(self.left_out.iter().map(MeasuredShare::line));
        text
    }
}

impl MeasuredShare {
    fn line(&self) -> String {
        let percent = |share: f64, decimals| format!("{:+.decimals$} %", 100.0 * share);
        match self.interval {
            Some([low, high]) => format!(
                "{:>9}  ({} to {})  {}\n",
                percent(self.share, 1),
                percent(low, 1),
                percent(high, 1),
                self.name
            ),
            None => format!("{:>9}  {}\n", percent(self.share, 0), self.name),
        }
    }
}
