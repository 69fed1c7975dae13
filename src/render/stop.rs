//! When a render stops: rules beside its number of samples, and what they will take.
//!
//! Comes in: the error of the picture so far and the time it took. Goes out: whether a rule is met, and a [`Forecast`]. No rule can
//! change a picture but by its number of samples.
//!
//! A target is a promise with a confidence 1 - α. Looking at the error often and stopping the first time that it is small would
//! stop at a lucky moment, so each look has its share of α (Bonferroni): look k has α / (k (k + 1)), which sum to α however many
//! there are. Looks are a quarter further apart each time: a stop is at most that late, and there are few of them.

use std::time::Instant;

use serde::Serialize;

use crate::error::{Error, Result};
use crate::film::PictureError;
use crate::interface::BLOCK_SAMPLES;

/// Blocks that each look has at least, times those of the look before.
const SPACING: f64 = 1.25;
/// Blocks before the first look: one to each of two replicates.
const FIRST_LOOK: u32 = 2;

/// Confidence of a bound that nobody asked for.
pub const DEFAULT_CONFIDENCE: f64 = 0.95;

/// Rules that end a render before its samples are done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StopRules {
    /// Stop once the relative RMSE is at most this.
    pub target: Option<Target>,
    /// Stop before this.
    pub time: Option<TimeRule>,
    /// A picture that has not all its samples is of no use: even the first may be given up.
    pub whole_or_nothing: bool,
}

impl StopRules {
    /// Refuses what is out of the range that its field states.
    pub fn check(&self) -> Result<()> {
        let Some(Target { error, confidence }) = self.target else { return Ok(()) };
        if error <= 0.0 || error.is_nan() {
            return Err(Error::Usage(format!("target error {error} is out of range: more than 0 is allowed")));
        }
        match (0.5..1.0).contains(&confidence) {
            true => Ok(()),
            false => {
                Err(Error::Usage(format!("confidence {confidence} is out of range: 0.5 to less than 1 is allowed")))
            }
        }
    }
}

/// An error to reach.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Target {
    /// Relative RMSE, above 0.
    pub error: f64,
    /// Probability that the error is no larger, in [0.5, 1).
    pub confidence: f64,
}

/// A time to keep. The first sample is finished all the same, but for [`StopRules::whole_or_nothing`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeRule {
    /// Runs are made to end before this.
    pub aim: Instant,
    /// A run that has not ended by then, since the machine got slower, is given up.
    pub latest: Instant,
}

/// Samples and time to a target, by the error so far.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Forecast {
    /// Samples a pixel that the forecast was made at.
    pub made_at_spp: u32,
    /// Samples a pixel at which the target will be met.
    pub spp: u64,
    /// Seconds from the first dispatch to then.
    pub seconds: f64,
}

/// The looks that a target takes at the error, and what they have shown.
#[derive(Clone, Copy, Debug)]
pub struct Looks {
    taken: u32,
    next: u32,
}

impl Looks {
    /// None taken yet.
    pub fn new() -> Looks {
        Looks { taken: 0, next: FIRST_LOOK }
    }

    /// Whether a look is due where every pixel has `spp` samples: at ends of blocks only.
    pub fn due(&self, spp: u32) -> bool {
        spp.is_multiple_of(BLOCK_SAMPLES) && spp / BLOCK_SAMPLES >= self.next
    }

    /// Takes a look at `spp` samples; the probability that its bound may fail with, of `alpha` for all looks together.
    pub fn take(&mut self, spp: u32, alpha: f64) -> f64 {
        self.taken += 1;
        self.next = after(spp / BLOCK_SAMPLES);
        share(self.taken, alpha)
    }

    /// Looks taken.
    pub fn taken(&self) -> u32 {
        self.taken
    }

    /// The look at which `target` will be met, if the squared error falls as samples to the power `-exponent`: from `spp` samples of
    /// `error`, each `seconds_per_sample`, `elapsed` seconds after the first dispatch.
    pub fn forecast(
        &self,
        error: &PictureError,
        target: Target,
        spp: u32,
        exponent: f64,
        elapsed: f64,
        seconds_per_sample: f64,
    ) -> Forecast {
        let (mut look, mut blocks) = (self.taken.max(1), u64::from((spp / BLOCK_SAMPLES).max(1)));
        let now = blocks as f64;
        let met = |look: u32, blocks: u64| {
            error.upper(share(look, 1.0 - target.confidence)) * (now / blocks as f64).powf(exponent / 2.0)
                <= target.error
        };
        // Ends: bounds grow with the logarithm of the looks, errors fall by a tenth each. An infinite bound has no end.
        while !met(look, blocks) && look < 500 {
            (look, blocks) = (look + 1, u64::from(after(u32::try_from(blocks).unwrap_or(u32::MAX))));
            if blocks >= u64::from(u32::MAX / BLOCK_SAMPLES) {
                break;
            }
        }
        let samples = blocks * u64::from(BLOCK_SAMPLES);
        let left = samples.saturating_sub(u64::from(spp)) as f64;
        Forecast { made_at_spp: spp, spp: samples, seconds: elapsed + left * seconds_per_sample }
    }
}

impl Default for Looks {
    fn default() -> Looks {
        Looks::new()
    }
}

/// Blocks of the look after one at `blocks`.
fn after(blocks: u32) -> u32 {
    ((f64::from(blocks) * SPACING).ceil() as u32).max(blocks.saturating_add(1)).max(FIRST_LOOK)
}

/// Share of `alpha` of look `k`, counted from 1.
fn share(k: u32, alpha: f64) -> f64 {
    alpha / (f64::from(k) * f64::from(k + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looks_are_at_ends_of_blocks_a_quarter_apart() {
        let mut looks = Looks::new();
        let mut at = Vec::new();
        for spp in 1..=1000 {
            if looks.due(spp) {
                looks.take(spp, 0.05);
                at.push(spp / BLOCK_SAMPLES);
            }
        }
        assert_eq!(at, [2, 3, 4, 5, 7, 9, 12, 15, 19, 24, 30, 38, 48, 60]);
        assert_eq!(looks.taken(), 14);
    }

    #[test]
    fn targets_out_of_range_are_refused() {
        let checked = |error, confidence| {
            StopRules { target: Some(Target { error, confidence }), ..StopRules::default() }
                .check()
                .map_err(|error| error.to_string())
        };
        assert!(StopRules::default().check().is_ok() && checked(1e-9, 0.5).is_ok());
        for error in [0.0, -1.0, f64::NAN] {
            assert!(checked(error, 0.95).unwrap_err().contains("more than 0"));
        }
        for confidence in [0.4999, 1.0, f64::NAN, f64::INFINITY] {
            assert!(checked(0.1, confidence).unwrap_err().contains("0.5 to less than 1"));
        }
    }

    #[test]
    fn all_looks_together_have_alpha() {
        let mut looks = Looks::new();
        let shares: Vec<f64> = (1..=10_000).map(|blocks| looks.take(blocks * BLOCK_SAMPLES, 0.05)).collect();
        assert!((shares[0] - 0.025).abs() < 1e-15 && (shares[2] - 0.05 / 12.0).abs() < 1e-15);
        let sum: f64 = shares.iter().sum();
        assert!(sum < 0.05 && sum > 0.0499);
    }
}
