//! `render --dry-run`: what a render would take, by its first few samples.
//!
//! Comes in: a pilot render. Goes out: a table, or one JSON document. Nothing is written.

use serde::Serialize;
use texray::Result;
use texray::film::Film;
use texray::render::stop::{DEFAULT_CONFIDENCE, Looks};
use texray::render::{Effect, RenderReport, Settings, Target};

use super::engine::FinishedRender;
use super::explain;
use super::progress::{duration, percent};
use super::streams::{answer, answer_json};

/// Samples of a pilot: a block of each of two replicates.
pub const PILOT_SPP: u32 = 32;
/// Seconds that a pilot may render.
pub const PILOT_SECONDS: f64 = 10.0;
/// Errors that are forecast where none was asked for.
const ERRORS: [f64; 4] = [0.1, 0.03, 0.01, 0.003];

/// What `render --dry-run --json` prints.
#[derive(Serialize)]
pub struct DryRun<'a> {
    schema: u32,
    dry_run: bool,
    pilot: Pilot,
    /// The samples asked for; absent where they have no end.
    asked: Option<Asked>,
    /// Errors to reach; empty where the pilot is too short to know.
    targets: Vec<Reached>,
    bytes: Bytes,
    effects: Vec<&'a Effect>,
}

#[derive(Serialize)]
struct Pilot {
    spp: u32,
    seconds: f64,
    seconds_per_sample: f64,
    relative_rmse: Option<f64>,
}

#[derive(Serialize)]
struct Asked {
    spp: u32,
    seconds: f64,
    relative_rmse: Option<f64>,
}

#[derive(Serialize)]
struct Reached {
    error: f64,
    confidence: f64,
    spp: u64,
    seconds: f64,
}

#[derive(Serialize)]
struct Bytes {
    film: u64,
    device: u64,
}

impl<'a> DryRun<'a> {
    /// From a pilot of the render that `settings` ask for; `effects` are all of them, on or off.
    pub fn new(
        settings: &Settings,
        target: Option<Target>,
        pilot: &FinishedRender,
        effects: Vec<&'a Effect>,
    ) -> DryRun<'a> {
        let report = &pilot.report;
        let film = &pilot.film;
        DryRun {
            schema: 1,
            dry_run: true,
            pilot: Pilot {
                spp: report.spp,
                seconds: report.seconds.render,
                seconds_per_sample: report.seconds_per_sample,
                relative_rmse: report.relative_rmse,
            },
            asked: (settings.spp < u32::MAX).then(|| asked(settings.spp, settings.sampler.convergence(), report)),
            targets: reached(target, settings.sampler.convergence(), report),
            bytes: Bytes {
                film: Film::bytes(film.pixels() as u64, film.replicate_count()),
                device: report.bytes.device,
            },
            effects,
        }
    }

    /// Prints it on stdout.
    pub fn tell(&self, json: bool) -> Result<()> {
        if json {
            return answer_json(self);
        }
        let pilot = &self.pilot;
        let mut lines = vec![match pilot.relative_rmse {
            Some(error) => format!("pilot: {} spp in {}, error {}", pilot.spp, duration(pilot.seconds), percent(error)),
            None => format!("pilot: {} spp in {}, too few to know the error", pilot.spp, duration(pilot.seconds)),
        }];
        if let Some(asked) = &self.asked {
            let error =
                asked.relative_rmse.map(|error| format!(", error about {}", percent(error))).unwrap_or_default();
            lines.push(format!("{} spp: about {} to render{error}", asked.spp, duration(asked.seconds)));
        }
        for reached in &self.targets {
            let (error, time) = (percent(reached.error), duration(reached.seconds));
            lines.push(format!("error {error}: about {time} to render, {} spp", reached.spp));
        }
        let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
        lines.push(format!("memory: film {:.1} MiB, device {:.1} MiB", mib(self.bytes.film), mib(self.bytes.device)));
        lines.extend(explain::table(&self.effects.iter().map(|effect| (*effect).clone()).collect::<Vec<_>>()));
        answer(&lines.join("\n"))
    }
}

/// Time and error at `spp`: time grows with the samples, the squared error falls as they do to the power `-exponent`.
fn asked(spp: u32, exponent: f64, report: &RenderReport) -> Asked {
    let more = f64::from(spp) - f64::from(report.spp);
    let fewer = (f64::from(report.spp) / f64::from(spp)).powf(exponent / 2.0);
    Asked {
        spp,
        seconds: (report.seconds.render + more * report.seconds_per_sample).max(0.0),
        relative_rmse: report.relative_rmse.map(|error| error * fewer),
    }
}

fn reached(target: Option<Target>, exponent: f64, report: &RenderReport) -> Vec<Reached> {
    let Some(error) = &report.error else {
        return Vec::new();
    };
    let targets = match target {
        Some(target) => vec![target, Target { error: target.error / 2.0, ..target }],
        None => ERRORS.map(|error| Target { error, confidence: DEFAULT_CONFIDENCE }).to_vec(),
    };
    let reach = |target: Target| {
        let looks = Looks::new();
        let (seconds, pace) = (report.seconds.render, report.seconds_per_sample);
        let at = looks.forecast(&error.picture, target, report.spp, exponent, seconds, pace);
        Reached { error: target.error, confidence: target.confidence, spp: at.spp, seconds: at.seconds }
    };
    targets.into_iter().map(reach).collect()
}
