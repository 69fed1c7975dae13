//! `texray render SCENE`: the picture.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use texray::render::bounce_cap::is_cheap;
use texray::render::{Settings, StopReason, StopRules, TimeRule};
use texray::scene::Scene;
use texray::{Error, Result};

use super::bias::Bias;
use super::document::{Document, Facts};
use super::dry_run::{DryRun, PILOT_SECONDS, PILOT_SPP};
use super::engine::{self, Engine, FinishedRender};
use super::outputs::{Ending, OutputArgs, Outputs, Saved};
use super::progress::Reporter;
use super::settings::SettingsArgs;
use super::signals::Signals;
use super::stop::{Limits, StopArgs};
use super::streams::{answer_json, say, tell_loading};
use super::{Outcome, explain, save, summary};

/// Render a scene to picture files
#[derive(Args)]
pub struct RenderArgs {
    /// The scene: a .toml scene or a bare .obj
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    #[command(flatten)]
    outputs: OutputArgs,
    #[command(flatten)]
    settings: SettingsArgs,
    #[command(flatten)]
    stop: StopArgs,
    #[command(flatten)]
    running: RunningArgs,
}

/// Options about where and how it runs, and what it tells.
#[derive(Args)]
#[command(next_help_heading = "Running and reporting")]
struct RunningArgs {
    /// Device, by the number or name that `texray devices` lists [default: discrete, integrated, virtual, then CPU]
    #[arg(long, value_name = "N|NAME")]
    device: Option<String>,
    /// Run under the Vulkan validation layers; a message is an internal error
    #[arg(long)]
    validation: bool,
    /// Exit with code 7 if any sample was invalid
    #[arg(long)]
    strict: bool,
    /// Exit with code 3 if loading the scene warns of anything
    #[arg(long)]
    deny_warnings: bool,
    /// Print one JSON document about the render on stdout
    #[arg(long)]
    json: bool,
    /// No progress and no summary, only warnings and errors
    #[arg(short, long, conflicts_with = "verbose")]
    quiet: bool,
    /// Also print the effects with their reasons, figures of the tree, and the ledger of transfers
    #[arg(short, long)]
    verbose: bool,
}

impl RenderArgs {
    /// Renders and writes. `started` is when the process began.
    pub fn run(&self, started: Instant) -> Result<Outcome> {
        let signals = Signals::watch()?;
        self.outputs.check_early(&self.scene)?;
        let (scene, seconds_load) = self.load()?;
        if let Some(signal) = signals.received() {
            return Ok(Outcome::Signal(signal));
        }
        let mut settings = self.settings.settings(&scene)?;
        if !self.settings.gives_spp() && (self.stop.time_limit.is_some() || self.stop.target().is_some()) {
            settings.spp = u32::MAX;
        }
        let limits = self.stop.limits(&settings, started)?;
        let outputs = self.outputs.outputs(&scene)?;
        let engine = Engine::open(self.running.device.as_deref(), self.running.validation)?;
        self.tell_before(&scene, &settings, &engine);
        let mut reporter = Reporter::new(self.running.quiet, signals.clone());
        if self.stop.dry_run {
            let pilot = self.pilot(&engine, &scene, &settings, &mut reporter);
            reporter.finish();
            let effects = engine::effects(&scene, &settings);
            DryRun::new(&settings, self.stop.target(), &pilot?, effects.iter().collect()).tell(self.running.json)?;
            return Ok(signals.received().map_or(Outcome::Done, Outcome::Signal));
        }
        // Held until the pictures are saved: the memory for that is not the driver's to take.
        let reserved = outputs.reserve(&settings)?;
        let rendered = engine.render(&scene, &settings, limits.rules, &mut reporter);
        reporter.finish();
        drop(reserved);
        let mut rendered = rendered?;
        rendered.report.seconds.load = seconds_load;
        let of = Ended { started, ended: Instant::now(), scene: &scene, settings: &settings, engine: &engine };
        let mut saved = of.save(&outputs, &mut rendered)?;
        // All that is optional comes after the pictures are safe.
        let bias = self.bias(&of, &limits, &rendered, &signals);
        of.save_bias(&bias, &rendered, &mut saved);
        self.tell_after(&of, &mut rendered, &bias, &saved)?;
        self.outcome(&signals, &rendered, &bias, &saved)
    }

    /// The first few samples of a render, for a dry run.
    fn pilot(
        &self,
        engine: &Engine,
        scene: &Scene,
        settings: &Settings,
        reporter: &mut Reporter,
    ) -> Result<FinishedRender> {
        let end = Instant::now() + Duration::from_secs_f64(PILOT_SECONDS);
        let time = Some(TimeRule { aim: end, latest: end });
        let settings = Settings { spp: settings.spp.min(PILOT_SPP), ..settings.clone() };
        engine.render(scene, &settings, StopRules { time, ..StopRules::default() }, reporter)
    }

    /// What the bounce cap cuts off, where it was asked for or costs little, and nobody waits for the end.
    fn bias(&self, of: &Ended<'_>, limits: &Limits, rendered: &FinishedRender, signals: &Signals) -> Bias {
        let (report, asked) = (&rendered.report, self.stop.max_bias.is_some());
        let unasked = self.stop.time_limit.is_none() && is_cheap(of.scene, of.settings, report.spp);
        if report.spp == 0 || signals.received().is_some() || !(asked || unasked) {
            return Bias::Unknown;
        }
        let mut reporter = Reporter::new(true, signals.clone());
        Bias::estimate(of.engine, of.scene, of.settings, limits.bias_ends, &report.seconds, &mut reporter)
    }

    fn load(&self) -> Result<(Scene, f64)> {
        let started = Instant::now();
        let scene = Scene::load(&self.scene)?;
        tell_loading(&scene.report, self.running.deny_warnings, self.running.quiet);
        if self.running.deny_warnings {
            scene.deny_warnings()?;
        }
        if !self.settings.allow_black {
            scene.check_emits()?;
        }
        Ok((scene, started.elapsed().as_secs_f64()))
    }

    fn tell_before(&self, scene: &Scene, settings: &Settings, engine: &Engine) {
        if !self.running.quiet {
            say(&format!("device {}", engine.device().summary));
        }
        if self.running.verbose {
            explain::table(&engine::effects(scene, settings).iter().cloned().collect::<Vec<_>>())
                .iter()
                .for_each(|line| say(line));
        }
    }

    fn tell_after(&self, of: &Ended<'_>, rendered: &mut FinishedRender, bias: &Bias, saved: &Saved) -> Result<()> {
        rendered.report.seconds.total = of.started.elapsed().as_secs_f64();
        let facts = Facts {
            scene: of.scene,
            settings: of.settings,
            device: of.engine.device(),
            report: &rendered.report,
            relative_rmse: rendered.report.relative_rmse,
            cap_bias: bias.known(),
            black: rendered.film.is_black(),
            empty_pixels: rendered.film.empty_pixels(),
            outputs: saved.files.clone(),
            not_written: saved.failures.iter().map(Error::to_string).collect(),
        };
        let warnings =
            summary::warnings(&facts).into_iter().chain(bias.warning()).chain(saved.warnings.iter().cloned());
        warnings.for_each(|line| say(&line));
        if !self.running.quiet {
            if self.running.verbose {
                say(&rendered.report.tree.to_string());
                say(rendered.ledger_table.trim_end());
            }
            summary::lines(&facts).iter().for_each(|line| say(line));
            let reason = self.stop.reason(facts.report, facts.settings.spp, of.ended - of.started);
            let files = if facts.outputs.is_empty() { "nothing".into() } else { facts.outputs.join(", ") };
            say(&format!("{reason}; wrote {files}"));
        }
        saved.failures.iter().for_each(|failure| say(&format!("error: {failure}")));
        if self.running.json { answer_json(&Document::new(facts)) } else { Ok(()) }
    }

    /// How it ended; what is worse goes before what is less bad.
    fn outcome(&self, signals: &Signals, rendered: &FinishedRender, bias: &Bias, saved: &Saved) -> Result<Outcome> {
        let validation = &rendered.validation;
        if !validation.is_empty() {
            validation.iter().for_each(|message| say(&format!("validation: {message}")));
            return Err(Error::Internal(format!("{} validation messages", validation.len())));
        }
        let invalid = rendered.report.invalid_samples.values().sum();
        Ok(match signals.received() {
            _ if !saved.failures.is_empty() => Outcome::NotWritten,
            Some(signal) => Outcome::Signal(signal),
            None if self.running.strict && invalid > 0 => Outcome::InvalidSamples(invalid),
            None => self.stop.missed(&rendered.report, bias).map_or(Outcome::Done, Outcome::TargetMissed),
        })
    }
}

/// A render that has ended, and what it was of.
struct Ended<'a> {
    /// When the process began.
    started: Instant,
    /// When the last sample was finished.
    ended: Instant,
    scene: &'a Scene,
    settings: &'a Settings,
    engine: &'a Engine,
}

impl Ended<'_> {
    /// Writes the files. Stopped before the first sample, there is no picture to save.
    fn save(&self, outputs: &Outputs<'_>, rendered: &mut FinishedRender) -> Result<Saved> {
        let writing = Instant::now();
        let report = &rendered.report;
        let cut_short = matches!(report.stop_reason, StopReason::TimeLimit | StopReason::Interrupted);
        let (settings, film, ledger) = (self.settings, &rendered.film, &rendered.ledger);
        let ending = Ending { settings, film, ledger, spp: report.spp, cut_short };
        let metadata = save::metadata(self.scene, settings, self.engine.device(), report, None);
        let saved = outputs.write(&ending, &metadata)?;
        rendered.report.seconds.write = writing.elapsed().as_secs_f64();
        Ok(saved)
    }

    /// Writes the pictures once more where they can say what the bounce cap cuts off.
    fn save_bias(&self, bias: &Bias, rendered: &FinishedRender, saved: &mut Saved) {
        if let Some(known) = bias.known() {
            let device = self.engine.device();
            saved.rewrite(&save::metadata(self.scene, self.settings, device, &rendered.report, Some(known)));
        }
    }
}
