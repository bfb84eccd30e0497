//! Forecasts for a running render: how many samples and seconds, from the start on, until its noise is down to a target.

use super::{Allotment, ErrorEstimator, Interval};
use crate::scene::RenderSettings;

/// What is to come of a render, as far as can be told from what is there.
#[derive(Clone, Copy, Debug)]
pub struct Outlook<'a> {
    /// What is known.
    pub estimator: &'a ErrorEstimator,
    /// Where the next samples go; `None` where all pixels get the same number.
    pub allotment: Option<&'a Allotment>,
    /// Samples taken so far.
    pub samples: f64,
    /// Time taken so far.
    pub seconds: f64,
}

impl Outlook<'_> {
    /// The samples, from the start on, after which noise is down to `target` if no pixel gets more than `most`, and the interval
    /// for it; `None` where noise is there already or will never be.
    pub fn samples_to(&self, target: f64, most: u32) -> Option<Interval> {
        let relmse = self.estimator.estimate()?.relmse;
        let goal = target * target;
        if relmse.value <= goal {
            return None;
        }
        let samples = |present: f64| self.samples_for_share((goal / present).min(1.0), most);
        Some(Interval {
            value: samples(relmse.value)?,
            low: samples(relmse.low)?,
            // Where it is not sure to get there, the time for all samples is the end of the interval.
            high: samples(relmse.high).unwrap_or_else(|| self.estimator.pixels() * f64::from(most)),
        })
    }

    /// The seconds, from the start on, for that many samples.
    pub fn seconds_for(&self, samples: Interval) -> Interval {
        let scale = self.seconds / self.samples;
        Interval {
            value: samples.value * scale,
            low: samples.low * scale,
            high: samples.high * scale,
        }
    }

    /// When noise is down to `target` if pixels may get any number of samples.
    pub fn time_to(&self, target: f64) -> Option<Interval> {
        let samples = self.samples_to(target, RenderSettings::MAX_SAMPLES)?;
        Some(self.seconds_for(samples))
    }

    /// The samples, from the start on, after which the variance is `share` of what it is.
    fn samples_for_share(&self, share: f64, most: u32) -> Option<f64> {
        if let Some(allotment) = self.allotment {
            let forecast = allotment.for_variance(share, most);
            return forecast
                .is_reached
                .then_some(self.samples + forecast.samples);
        }
        let present = self.estimator.noisiest_samples()?;
        let decay = self.estimator.decay();
        let goal = share * decay.variance(present);
        // Between the powers of two before and after, on the straight line in logarithms.
        let (mut before, mut after) = (present, present);
        while decay.variance(after) > goal {
            if after >= most {
                return None;
            }
            (before, after) = (after, after.saturating_mul(2));
        }
        let [high, low] = [before, after].map(|samples| libm::log(decay.variance(samples)));
        let way = if high > low {
            (high - libm::log(goal)) / (high - low)
        } else {
            0.0
        };
        let needed = f64::from(before) * libm::pow(f64::from(after) / f64::from(before), way);
        let limited = needed <= f64::from(most);
        limited.then_some(self.samples * needed / f64::from(present))
    }
}
