//! The options that say when a render stops, and what its end says of them.
//!
//! Comes in: parsed options. Goes out: [`StopRules`], and words about them.

use std::time::{Duration, Instant};

use clap::Args;
use texray::render::{ErrorReport, RenderReport, Sampler, Settings, StopReason, StopRules, Target, TimeRule};
use texray::{Error, Result};

use super::bias::Bias;
use super::parse;
use super::progress::{duration, percent};

/// Seconds a pixel that reading out and writing the pictures take, at most, and seconds of that which do not depend on pixels.
const WRITING: [f64; 2] = [0.7e-6, 0.05];

/// Time of a limit that is left for estimating what the bounce cap cuts off, at most; otherwise a quarter of it.
const LONGEST_ESTIMATE: Duration = Duration::from_secs(10);

/// When a render ends, and what follows it.
pub struct Limits {
    /// Rules of the render.
    pub rules: StopRules,
    /// When the estimate of what the bounce cap cuts off has to have ended, if it has to.
    pub bias_ends: Option<Instant>,
}

/// When it ends; what comes first counts.
#[derive(Args)]
#[command(next_help_heading = "When to stop")]
pub struct StopArgs {
    /// Wall time from the start of the process, such as 90, 10s, 5m or 1h30m; the first sample is always finished
    #[arg(long, value_name = "TIME", value_parser = parse::duration)]
    pub time_limit: Option<Duration>,
    /// Stop once the relative RMSE of the picture is at most this, such as 1% or 0.01
    #[arg(long, value_name = "ERROR", value_parser = parse::ratio)]
    target_error: Option<f64>,
    /// Probability that the error is no larger than --target-error when it stops
    #[arg(long, value_name = "P", default_value = "95%", value_parser = parse::confidence, requires = "target_error")]
    confidence: f64,
    /// Exit with code 6 if the bounce cap may cut off more than this share of the light, such as 1% or 0.01
    #[arg(long, value_name = "SHARE", value_parser = parse::ratio)]
    pub max_bias: Option<f64>,
    /// Render a first few samples, say what the rest would take and write nothing
    #[arg(long)]
    pub dry_run: bool,
}

impl StopArgs {
    /// The target, if there is one.
    pub fn target(&self) -> Option<Target> {
        self.target_error.map(|error| Target { error, confidence: self.confidence })
    }

    /// The limits of a process that began at `started`.
    pub fn limits(&self, settings: &Settings, started: Instant) -> Result<Limits> {
        if self.target_error.is_some() && settings.sampler == Sampler::Table {
            let why = "the replicates of a table are not independent, so its error is not known";
            return Err(Error::Usage(format!("--target-error with --sampler table: {why}")));
        }
        let [_, _, width, height] = settings.region();
        let writing = Duration::from_secs_f64(f64::from(width) * f64::from(height) * WRITING[0] + WRITING[1]);
        let mut limits = Limits { rules: StopRules { target: self.target(), ..StopRules::default() }, bias_ends: None };
        if let Some(limit) = self.time_limit {
            let mut aim = limit.saturating_sub(writing);
            if self.max_bias.is_some() {
                // What the cap cuts off is estimated after the pictures are written, which are then written once more.
                limits.bias_ends = Some(started + aim);
                aim = aim.saturating_sub(writing + (limit / 4).min(LONGEST_ESTIMATE));
            }
            // Half of what a time limit may be late by; the other half is for what comes after.
            let grace = (limit / 40).max(Duration::from_millis(250));
            limits.rules.time = Some(TimeRule { aim: started + aim, latest: started + aim + grace });
        }
        Ok(limits)
    }

    /// Which rule ended the render, whose last sample was finished `after` the start of the process.
    pub fn reason(&self, report: &RenderReport, asked_spp: u32, after: Duration) -> String {
        let spp = report.spp;
        match (report.stop_reason, self.target()) {
            (StopReason::TargetError, Some(target)) => {
                format!("done: error at most {} at {spp} spp", percent(target.error))
            }
            (StopReason::Spp, _) => format!("done: all {spp} spp"),
            (StopReason::TimeLimit, _) if spp == 1 && self.time_limit.is_some_and(|limit| after > limit) => {
                let first = duration(after.as_secs_f64());
                format!("stopped by --time-limit at {spp} spp, late: the first sample was finished after {first}")
            }
            (StopReason::TimeLimit, _) => format!("stopped by --time-limit at {spp} spp"),
            (StopReason::Interrupted | StopReason::TargetError, _) => {
                format!("stopped by a signal at {spp}{} spp", of(asked_spp))
            }
        }
    }

    /// What is missing to the promises asked for, where they are not kept.
    pub fn missed(&self, report: &RenderReport, bias: &Bias) -> Option<String> {
        let missed: Vec<String> = self.missed_target(report).into_iter().chain(self.exceeded_bias(bias)).collect();
        (!missed.is_empty()).then(|| missed.join("; "))
    }

    fn exceeded_bias(&self, bias: &Bias) -> Option<String> {
        let most = self.max_bias?;
        match bias {
            Bias::Known(bias) if bias.upper() <= most => None,
            Bias::Known(bias) => {
                let (share, upper) = (percent(bias.bounce_cap), percent(bias.upper()));
                Some(format!(
                    "--max-bias {} is not kept: the bounce cap cuts off {share}, at most {upper}",
                    percent(most)
                ))
            }
            Bias::Missing(why) => Some(format!(
                "--max-bias {} is not met: what the bounce cap cuts off is not known: {why}",
                percent(most)
            )),
            Bias::Unknown => {
                Some(format!("--max-bias {} is not met: there is no picture to estimate it for", percent(most)))
            }
        }
    }

    fn missed_target(&self, report: &RenderReport) -> Option<String> {
        let target = percent(self.target()?.error);
        match &report.error {
            Some(error) if is_met(error) => None,
            Some(error) if error.heavy_tailed => Some(format!(
                "--target-error {target} is not met: the error has a heavy tail (see above), {} spp",
                report.spp
            )),
            Some(error) => Some(format!(
                "--target-error {target} is not met: the error is at most {} with {} confidence at {} spp",
                percent(error.upper),
                percent(error.confidence),
                report.spp
            )),
            None => {
                Some(format!("--target-error {target} is not met: {} spp are too few to know the error", report.spp))
            }
        }
    }
}

/// Whether a picture keeps its target.
fn is_met(error: &ErrorReport) -> bool {
    !error.heavy_tailed && error.target.is_none_or(|target| error.upper <= target)
}

/// ` of N` where a number of samples was asked for.
fn of(asked_spp: u32) -> String {
    if asked_spp == u32::MAX { String::new() } else { format!(" of {asked_spp}") }
}
