//! When the frame loop ends: what it asks of the error and of the clock between two runs.
//!
//! Comes in: the film after a run, the rules, the time. Goes out: how long the next run may be, whether a target is met, and the
//! figures of the error in the report. Nothing here changes a picture but by its number of samples.

use std::time::{Duration, Instant};

use crate::film::PictureError;
use crate::interface::BLOCK_SAMPLES;
use crate::render::frames::Renderer;
use crate::render::report::{ErrorReport, Observer, StopReason};
use crate::render::stop::{DEFAULT_CONFIDENCE, TimeRule};
use crate::settings::Sampler;

/// What estimating the error has cost so far, and when it is due again, since the first dispatch.
#[derive(Default)]
pub(super) struct EstimateClock {
    cost: Duration,
    due: Duration,
}

impl EstimateClock {
    pub(super) fn cost(&self) -> Duration {
        self.cost
    }
}

impl Renderer {
    /// Estimates the error, if it is time: the estimate reads the whole film, and shall cost less than 2 % of the render.
    pub(super) fn estimate_error(&mut self, elapsed: Duration) {
        if self.settings.sampler == Sampler::Table || elapsed < self.estimate.due {
            return;
        }
        let start = Instant::now();
        self.report.relative_rmse = self.film.relative_rmse();
        self.estimate.cost += start.elapsed();
        self.estimate.due = elapsed.max(self.estimate.cost * 50);
    }

    /// Samples of the run that begins at sample `done`: fewer where the time limit is near; `None` where not even one would end
    /// before it.
    pub(super) fn next_run(&self, done: u32) -> Option<u32> {
        let samples = self.run_length.next(done, self.settings.spp);
        let Some(time) = self.rules.time.filter(|_| self.may_give_up(done)) else {
            return Some(samples);
        };
        let left = time.aim.saturating_duration_since(Instant::now()).as_secs_f64();
        if done == 0 {
            return (left > 0.0).then_some(samples);
        }
        let affordable = (left / self.report.seconds_per_sample.max(1e-9)).min(f64::from(BLOCK_SAMPLES)) as u32;
        (affordable > 0).then_some(samples.min(affordable))
    }

    /// Share of the time limit that has gone by since the first dispatch, 0 without one.
    pub(super) fn time_share(&self, start: Instant) -> f64 {
        let elapsed = start.elapsed().as_secs_f64();
        let left = |time: TimeRule| time.aim.saturating_duration_since(Instant::now()).as_secs_f64();
        self.rules.time.map_or(0.0, |time| elapsed / (elapsed + left(time)).max(1e-9))
    }

    /// Whether a run that begins at sample `done` need not be finished.
    pub(super) fn may_give_up(&self, done: u32) -> bool {
        done > 0 || self.rules.whole_or_nothing
    }

    /// Whether a run is to be given up: what the last whole run left is kept.
    pub(super) fn is_given_up(&self, observer: &dyn Observer) -> bool {
        observer.stop_requested() || self.rules.time.is_some_and(|time| Instant::now() > time.latest)
    }

    pub(super) fn why_given_up(&self, observer: &dyn Observer) -> StopReason {
        if observer.stop_requested() { StopReason::Interrupted } else { StopReason::TimeLimit }
    }

    /// Looks at the error for the target's sake, where a look is due; whether the target is met. A heavy tail is not trusted.
    pub(super) fn look(&mut self, done: u32, elapsed: Duration) -> bool {
        let Some(target) = self.rules.target.filter(|_| self.looks.due(done)) else {
            return false;
        };
        let start = Instant::now();
        let error = self.film.error();
        self.estimate.cost += start.elapsed();
        let Some(error) = error else {
            return false;
        };
        let alpha = self.looks.take(done, 1.0 - target.confidence);
        let upper = error.upper(alpha);
        let exponent = self.settings.sampler.convergence();
        let (elapsed, pace) = (elapsed.as_secs_f64(), self.report.seconds_per_sample);
        let forecast = self.looks.forecast(&error, target, done, exponent, elapsed, pace);
        self.forecasts = Some((self.forecasts.map_or(forecast, |(first, _)| first), forecast));
        self.report.relative_rmse = Some(error.relative_rmse);
        let met = upper <= target.error && !error.is_heavy_tailed();
        if met {
            self.report.error = Some(self.error_report(error, upper));
        }
        met
    }

    /// The error of the picture as it ends: what the look that met the target saw, or one more look.
    pub(super) fn last_look(&mut self, done: u32) {
        if self.settings.sampler == Sampler::Table || self.report.error.is_some() {
            return;
        }
        let alpha = match self.rules.target {
            Some(target) => self.looks.take(done, 1.0 - target.confidence),
            None => 1.0 - DEFAULT_CONFIDENCE,
        };
        let start = Instant::now();
        let error = self.film.error();
        self.estimate.cost += start.elapsed();
        self.report.relative_rmse = error.map(|error| error.relative_rmse);
        self.report.error = error.map(|error| self.error_report(error, error.upper(alpha)));
    }

    fn error_report(&self, picture: PictureError, upper: f64) -> ErrorReport {
        ErrorReport {
            picture,
            upper,
            confidence: self.rules.target.map_or(DEFAULT_CONFIDENCE, |target| target.confidence),
            target: self.rules.target.map(|target| target.error),
            looks: self.looks.taken(),
            heavy_tailed: picture.is_heavy_tailed(),
            forecast: self.forecasts.map(|(first, _)| first),
        }
    }
}
