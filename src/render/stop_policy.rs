//! The stop policy: what a render asks of the error and of the clock between two runs.
//!
//! Comes in: the film after a run, the rules, the time. Goes out: how long the next run may be, whether a target is
//! met, and the figures of the error in the report. Nothing here changes a picture but by its number of samples.

use std::time::{Duration, Instant};

use crate::error::Result;
use crate::film::{Film, PictureError};
use crate::interface::BLOCK_SAMPLES;
use crate::render::report::{ErrorReport, Observer, RenderReport, StopReason};
use crate::render::stop::{DEFAULT_CONFIDENCE, Forecast, Looks, StopRules, Target, TimeRule};
use crate::render::tuning::Tuning;
use crate::render::work_size::RunLength;
use crate::settings::{Sampler, Settings};

/// When a render ends, and what it has seen so far.
pub(super) struct StopPolicy {
    spp: u32,
    sampler: Sampler,
    fixed_run: Option<u32>,
    /// Beside the number of samples.
    pub(super) rules: StopRules,
    seen: Seen,
}

/// What a picture has shown so far.
struct Seen {
    run_length: RunLength,
    looks: Looks,
    /// What the first look, and the last one, forecast of the target.
    forecasts: Option<(Forecast, Forecast)>,
    /// What estimating the error has cost, and when it is due again, since the first dispatch.
    estimate_cost: Duration,
    estimate_due: Duration,
    /// By the last run.
    seconds_per_sample: f64,
    relative_rmse: Option<f64>,
    error: Option<ErrorReport>,
}

impl Seen {
    fn nothing(fixed_run: Option<u32>) -> Seen {
        Seen {
            run_length: RunLength::new(fixed_run),
            looks: Looks::new(),
            forecasts: None,
            estimate_cost: Duration::ZERO,
            estimate_due: Duration::ZERO,
            seconds_per_sample: 0.0,
            relative_rmse: None,
            error: None,
        }
    }
}

impl StopPolicy {
    /// By the number of samples alone.
    pub(super) fn new(settings: &Settings, tuning: &Tuning) -> StopPolicy {
        StopPolicy {
            spp: settings.spp,
            sampler: settings.sampler,
            fixed_run: tuning.run_samples,
            rules: StopRules::default(),
            seen: Seen::nothing(tuning.run_samples),
        }
    }

    /// Forgets the picture so far: another one begins.
    pub(super) fn restart(&mut self) {
        self.seen = Seen::nothing(self.fixed_run);
    }

    /// Refuses rules that are out of range.
    pub(super) fn check(&self) -> Result<()> {
        self.rules.check()
    }

    /// Whether `done` samples are all that were asked for.
    pub(super) fn is_done(&self, done: u32) -> bool {
        done >= self.spp
    }

    /// Samples of the run that begins at sample `done`: fewer where the time limit is near; `None` where not even one
    /// would end before it.
    pub(super) fn next_run(&self, done: u32) -> Option<u32> {
        let samples = self.seen.run_length.next(done, self.spp);
        let Some(time) = self.rules.time.filter(|_| self.may_give_up(done)) else {
            return Some(samples);
        };
        let left = time.aim.saturating_duration_since(Instant::now()).as_secs_f64();
        if done == 0 {
            return (left > 0.0).then_some(samples);
        }
        let affordable = (left / self.seen.seconds_per_sample.max(1e-9)).min(f64::from(BLOCK_SAMPLES)) as u32;
        (affordable > 0).then_some(samples.min(affordable))
    }

    /// Share of the time limit that has gone by since the first dispatch, 0 without one.
    pub(super) fn time_share(&self, started: Instant) -> f64 {
        let elapsed = started.elapsed().as_secs_f64();
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

    /// Why a run was given up.
    pub(super) fn why_given_up(&self, observer: &dyn Observer) -> StopReason {
        if observer.stop_requested() { StopReason::Interrupted } else { StopReason::TimeLimit }
    }

    /// Takes note that a run of `samples` took `elapsed`.
    pub(super) fn note_run(&mut self, samples: u32, elapsed: Duration) {
        self.seen.run_length.note(samples, elapsed);
        self.seen.seconds_per_sample = elapsed.as_secs_f64() / f64::from(samples);
    }

    /// Looks at the film after a run, `elapsed` after the first dispatch; whether the target is met.
    pub(super) fn look(&mut self, film: &Film, done: u32, elapsed: Duration) -> bool {
        self.estimate_error(film, elapsed);
        self.look_for_target(film, done, elapsed)
    }

    /// Estimates the error, if it is time: the estimate reads the whole film, and shall cost less than 2 % of the
    /// render.
    fn estimate_error(&mut self, film: &Film, elapsed: Duration) {
        if self.sampler == Sampler::Table || elapsed < self.seen.estimate_due {
            return;
        }
        let start = Instant::now();
        self.seen.relative_rmse = film.relative_rmse();
        self.seen.estimate_cost += start.elapsed();
        self.seen.estimate_due = elapsed.max(self.seen.estimate_cost * 50);
    }

    /// Looks at the error for the target's sake, where a look is due; whether the target is met. A heavy tail is not
    /// trusted.
    fn look_for_target(&mut self, film: &Film, done: u32, elapsed: Duration) -> bool {
        let Some(target) = self.rules.target.filter(|_| self.seen.looks.due(done)) else {
            return false;
        };
        let Some(error) = self.error_of(film) else {
            return false;
        };
        let seen = &mut self.seen;
        let alpha = seen.looks.take(done, 1.0 - target.confidence);
        let upper = error.upper(alpha);
        let (exponent, elapsed) = (self.sampler.convergence(), elapsed.as_secs_f64());
        let forecast = seen.looks.forecast(&error, target, done, exponent, elapsed, seen.seconds_per_sample);
        seen.forecasts = Some((seen.forecasts.map_or(forecast, |(first, _)| first), forecast));
        seen.relative_rmse = Some(error.relative_rmse);
        let met = upper <= target.error && !error.is_heavy_tailed();
        if met {
            self.seen.error = Some(self.error_report(error, upper));
        }
        met
    }

    /// The error of the picture as it ends: what the look that met the target saw, or one more look.
    pub(super) fn last_look(&mut self, film: &Film, done: u32) {
        if self.sampler == Sampler::Table || self.seen.error.is_some() {
            return;
        }
        let alpha = match self.rules.target {
            Some(target) => self.seen.looks.take(done, 1.0 - target.confidence),
            None => 1.0 - DEFAULT_CONFIDENCE,
        };
        let error = self.error_of(film);
        self.seen.relative_rmse = error.map(|error| error.relative_rmse);
        self.seen.error = error.map(|error| self.error_report(error, error.upper(alpha)));
    }

    fn error_of(&mut self, film: &Film) -> Option<PictureError> {
        let start = Instant::now();
        let error = film.error();
        self.seen.estimate_cost += start.elapsed();
        error
    }

    fn error_report(&self, picture: PictureError, upper: f64) -> ErrorReport {
        ErrorReport {
            picture,
            upper,
            confidence: self.rules.target.map_or(DEFAULT_CONFIDENCE, |target| target.confidence),
            target: self.rules.target.map(|target| target.error),
            looks: self.seen.looks.taken(),
            heavy_tailed: picture.is_heavy_tailed(),
            forecast: self.seen.forecasts.map(|(first, _)| first),
        }
    }

    /// Samples a pixel that the render will take, by what is known now.
    pub(super) fn spp_target(&self) -> u32 {
        let forecast = self.seen.forecasts.map_or(u64::from(u32::MAX), |(_, last)| last.spp);
        forecast.min(u64::from(self.spp)) as u32
    }

    /// The target, and the last forecast of it.
    pub(super) fn target(&self) -> Option<(Target, Option<Forecast>)> {
        self.rules.target.map(|target| (target, self.seen.forecasts.map(|(_, last)| last)))
    }

    /// Writes what has been seen into the report.
    pub(super) fn tell(&self, report: &mut RenderReport) {
        report.seconds_per_sample = self.seen.seconds_per_sample;
        report.seconds.estimate = self.seen.estimate_cost.as_secs_f64();
        report.relative_rmse = self.seen.relative_rmse;
        report.error = self.seen.error;
    }
}
