//! Forecasts for a running render: how many samples and seconds, from the start on, until its noise is down to a target.

use super::{Allotment, ErrorEstimator, Interval, NORMAL_95};

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

/// How far it is to a level of noise, from the start on.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    /// In samples of all pixels together.
    pub samples: Interval,
    /// In seconds.
    pub seconds: Interval,
}

/// The same without intervals, where time is in samples of the mean price of those taken so far.
#[derive(Clone, Copy)]
struct Needed {
    samples: f64,
    price: f64,
}

impl Outlook<'_> {
    /// The way to noise of `target` if every pixel gets at least `least` samples and none more than `most`; `None` where noise is there
    /// already or will never be.
    pub fn way_to(&self, target: f64, [least, most]: [u32; 2]) -> Option<Way> {
        let relmse = self.estimator.estimate()?.relmse;
        let goal = target * target;
        if relmse.value <= goal {
            return None;
        }
        let needed = |present: f64| self.needed((goal / present).min(1.0), [least, most]);
        let value = needed(relmse.value)?;
        // Neither the noise that is there is certain, nor how it falls: the error of one says nothing about that of the other.
        let growth = value.samples / self.samples;
        let ahead = f64::from(self.estimator.noisiest_samples()?) * growth;
        let fall = NORMAL_95 * self.estimator.decay().doubt_at(ahead);
        let low = libm::exp(-libm::log(relmse.value / relmse.low).hypot(fall));
        let high = libm::exp(libm::log(relmse.high / relmse.value).hypot(fall));
        let low = needed(relmse.value * low)?;
        // Where it is not sure to get there, the way of all samples is the end of the interval.
        let high = needed(relmse.value * high).unwrap_or_else(|| {
            let all = self.estimator.pixels() * f64::from(most);
            Needed {
                samples: all,
                price: all,
            }
        });
        let interval = |of: fn(Needed) -> f64, scale: f64| Interval {
            value: of(value) * scale,
            low: of(low) * scale,
            high: of(high) * scale,
        };
        Some(Way {
            samples: interval(|needed| needed.samples, 1.0),
            seconds: interval(|needed| needed.price, self.seconds / self.samples),
        })
    }

    /// What it takes until the variance is `share` of what it is.
    fn needed(&self, share: f64, [least, most]: [u32; 2]) -> Option<Needed> {
        if let Some(allotment) = self.allotment {
            let forecast = allotment.forecast(share, [least, most]);
            // A pass over all pixels may have come since they were judged.
            let judged = allotment.samples();
            return forecast.is_reached.then_some(Needed {
                samples: (judged + forecast.samples).max(self.samples),
                price: (judged + forecast.price).max(self.samples),
            });
        }
        let samples = self.even_samples(share, most)?;
        let samples = samples.max(self.estimator.pixels() * f64::from(least.min(most)));
        Some(Needed {
            samples,
            price: samples,
        })
    }

    /// Of the samples it takes to bring the variance down to `share` where all pixels get the same number, the part that it takes where they
    /// are chosen, by price: infinite where only even samples are enough, 0 where they are not.
    pub fn price_of_choice(&self, share: f64, limits: [u32; 2]) -> f64 {
        let even = Self {
            allotment: None,
            ..*self
        };
        match (self.needed(share, limits), even.needed(share, limits)) {
            (Some(chosen), Some(even)) => {
                (chosen.price - self.samples) / (even.price - self.samples)
            }
            (None, Some(_)) => f64::INFINITY,
            (_, None) => 0.0,
        }
    }

    /// The samples of all pixels together after which the variance is `share` of what it is, where all pixels get the same number.
    fn even_samples(&self, share: f64, most: u32) -> Option<f64> {
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

impl Way {
    /// The same where only some numbers of samples can be the end: `end_after` gives the first from one on.
    pub fn up_to(self, end_after: impl Fn(f64) -> f64) -> Self {
        let end = |samples: f64, seconds: f64| {
            let end = end_after(samples);
            (end, seconds * end / samples)
        };
        let Self { samples, seconds } = self;
        let value = end(samples.value, seconds.value);
        let low = end(samples.low, seconds.low);
        let high = end(samples.high, seconds.high);
        Self {
            samples: Interval {
                value: value.0,
                low: low.0,
                high: high.0,
            },
            seconds: Interval {
                value: value.1,
                low: low.1,
                high: high.1,
            },
        }
    }
}
