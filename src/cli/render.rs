//! `texray render SCENE`: the picture.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::{ArgAction, Args};
use texray::film::{Film, error_map};
use texray::output::{
    Aov, Display, Format, Layer, OutputFile, Picture, Tonemap, check_writable, encode_indexed_png, write_whole,
};
use texray::render::bounce_cap;
use texray::render::{CapBias, Settings, StopRules, TimeRule};
use texray::scene::Scene;
use texray::{Error, Result};

use super::document::{Document, Facts};
use super::dry_run::{DryRun, PILOT_SECONDS, PILOT_SPP};
use super::engine::{self, Engine, Rendered};
use super::progress::Reporter;
use super::settings::SettingsArgs;
use super::signals::Signals;
use super::stop::StopArgs;
use super::streams::{answer_json, json, say};
use super::{Outcome, explain, parse, save, summary};

/// Render a scene to picture files
#[derive(Args)]
pub struct RenderArgs {
    /// The scene: a .toml scene or a bare .obj
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// Picture file, .exr, .png or .hdr; may be given several times [default: SCENE.exr and SCENE.png, here]
    #[arg(short, long, value_name = "FILE", action = ArgAction::Append)]
    output: Vec<PathBuf>,
    /// Further layers of EXR files, separated by commas
    #[arg(long, value_enum, value_delimiter = ',')]
    aov: Vec<Aov>,
    /// Also write the standard error of each pixel as a picture of colours, .png (its text says what they mean)
    #[arg(long, value_name = "FILE", value_parser = parse::png)]
    error_map: Option<PathBuf>,
    /// Do not overwrite files
    #[arg(long)]
    no_clobber: bool,
    #[command(flatten)]
    settings: SettingsArgs,
    #[command(flatten)]
    stop: StopArgs,
    #[command(flatten)]
    display: DisplayArgs,
    #[command(flatten)]
    running: RunningArgs,
}

/// Options that change 8-bit pictures only.
#[derive(Args)]
#[command(next_help_heading = "8-bit pictures")]
struct DisplayArgs {
    /// Exposure of 8-bit pictures in stops, -100 to 100
    #[arg(long, value_name = "STOPS", default_value = "0", value_parser = parse::exposure, allow_negative_numbers = true)]
    exposure: f64,
    /// Tone map of 8-bit pictures
    #[arg(long, value_enum, default_value_t)]
    tonemap: Tonemap,
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
    /// Write the ledger of all transfers between CPU and GPU to this JSON file
    #[arg(long, value_name = "FILE")]
    ledger: Option<PathBuf>,
    /// Exit with code 7 if any sample was invalid
    #[arg(long)]
    strict: bool,
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
        self.check_files(None, &[])?;
        let (scene, seconds_load) = self.load()?;
        if let Some(signal) = signals.received() {
            return Ok(Outcome::Signal(signal));
        }
        let mut settings = self.settings.settings(&scene)?;
        if !self.settings.gives_spp() && (self.stop.time_limit.is_some() || self.stop.target().is_some()) {
            settings.spp = u32::MAX;
        }
        let rules = self.stop.rules(&settings, started)?;
        let files = self.check_files(Some(&scene.name), &scene.report.files)?;
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
        let rendered = engine.render(&scene, &settings, rules, &mut reporter);
        reporter.finish();
        let mut rendered = rendered?;
        rendered.report.seconds.load = seconds_load;
        rendered.cap_bias = self.cap_bias(&engine, &scene, &settings, rendered.report.spp, &signals)?;
        self.finish(started, &scene, &settings, &engine, &files, &mut rendered)?;
        if !rendered.validation.is_empty() {
            rendered.validation.iter().for_each(|message| say(&format!("validation: {message}")));
            return Err(Error::Internal(format!("{} validation messages", rendered.validation.len())));
        }
        let invalid = rendered.report.invalid_samples.values().sum();
        Ok(match signals.received() {
            Some(signal) => Outcome::Signal(signal),
            None if self.running.strict && invalid > 0 => Outcome::InvalidSamples(invalid),
            None => self.stop.missed(&rendered.report, rendered.cap_bias).map_or(Outcome::Done, Outcome::TargetMissed),
        })
    }

    /// The first few samples of a render, for a dry run.
    fn pilot(&self, engine: &Engine, scene: &Scene, settings: &Settings, reporter: &mut Reporter) -> Result<Rendered> {
        let end = Instant::now() + Duration::from_secs_f64(PILOT_SECONDS);
        let rules = StopRules { target: None, time: Some(TimeRule { aim: end, latest: end }) };
        let settings = Settings { spp: settings.spp.min(PILOT_SPP), ..settings.clone() };
        engine.render(scene, &settings, rules, reporter)
    }

    /// What the bounce cap cuts off, where it was asked for or costs little, and nobody waits for the end.
    fn cap_bias(
        &self,
        engine: &Engine,
        scene: &Scene,
        settings: &Settings,
        spp: u32,
        signals: &Signals,
    ) -> Result<Option<CapBias>> {
        let unasked = self.stop.time_limit.is_none() && bounce_cap::is_cheap(scene, settings, spp);
        if signals.received().is_some() || !(unasked || self.stop.max_bias.is_some()) {
            return Ok(None);
        }
        engine.cap_bias(scene, settings, &mut Reporter::new(true, signals.clone()))
    }

    /// Checks the files that will be written. Without `-o` their names are known once the scene's is, and the files that
    /// the scene names (`meshes`) once it is read.
    fn check_files(&self, scene_name: Option<&str>, meshes: &[PathBuf]) -> Result<Vec<OutputFile>> {
        let files = save::check(&self.output, scene_name, self.no_clobber)?;
        let ledger = self.running.ledger.as_deref();
        let error_map = self.error_map.as_deref();
        let paths: Vec<_> = files.iter().map(OutputFile::path).chain(ledger).chain(error_map).collect();
        if !self.aov.is_empty() && scene_name.is_some() && files.iter().all(|file| file.format() != Format::Exr) {
            return Err(Error::Usage("--aov: layers are for .exr files, and none is written".into()));
        }
        let scene: Vec<_> = std::iter::once(&self.scene).chain(meshes).map(PathBuf::as_path).collect();
        save::check_distinct(&scene, &paths)?;
        for path in ledger.into_iter().chain(error_map) {
            check_writable(path, self.no_clobber)?;
        }
        Ok(files)
    }

    fn load(&self) -> Result<(Scene, f64)> {
        let started = Instant::now();
        let scene = Scene::load(&self.scene)?;
        for warning in &scene.report.warnings {
            say(&format!("warning: {warning}"));
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

    /// Writes pictures and ledger, then tells about the render.
    fn finish(
        &self,
        started: Instant,
        scene: &Scene,
        settings: &Settings,
        engine: &Engine,
        files: &[OutputFile],
        rendered: &mut Rendered,
    ) -> Result<()> {
        let writing = Instant::now();
        let relative_rmse = rendered.report.relative_rmse;
        // Stopped before the first sample: there is no picture to save.
        let files = if rendered.report.spp == 0 { &[] } else { files };
        if !files.is_empty() {
            let picture = self.picture(settings, &rendered.film)?;
            let display = Display { exposure_stops: self.display.exposure, tonemap: self.display.tonemap };
            let metadata = save::metadata(scene, settings, engine.device(), &rendered.report, rendered.cap_bias);
            save::write(files, &picture, &display, &metadata)?;
        }
        if let Some(path) = &self.running.ledger {
            write_whole(path, self.no_clobber, json(&rendered.ledger)?.as_bytes())?;
        }
        rendered.report.seconds.write = writing.elapsed().as_secs_f64();
        rendered.report.seconds.total = started.elapsed().as_secs_f64();
        let facts = Facts {
            scene,
            settings,
            device: engine.device(),
            report: &rendered.report,
            relative_rmse,
            cap_bias: rendered.cap_bias,
            empty_pixels: rendered.film.empty_pixels(),
            outputs: self.written(files),
        };
        self.tell_after(&facts, rendered);
        if self.running.json { answer_json(&Document::new(facts)) } else { Ok(()) }
    }

    /// Names of the pictures that were written.
    fn written(&self, files: &[OutputFile]) -> Vec<String> {
        let map = self.error_map.as_deref().filter(|_| !files.is_empty());
        files.iter().map(OutputFile::path).chain(map).map(|path| path.display().to_string()).collect()
    }

    /// The picture with the layers asked for; writes the error map on the way.
    fn picture(&self, settings: &Settings, film: &Film) -> Result<Picture> {
        if self.aov.is_empty() && self.error_map.is_none() {
            return Picture::new(settings.width, settings.height, settings.crop, film.mean());
        }
        let estimate = film.estimate();
        if let Some(path) = &self.error_map {
            let (palette, map) = (error_map::palette(), error_map::error_map(&estimate));
            let png = encode_indexed_png(estimate.width, estimate.height, &palette, error_map::LEGEND, &map);
            write_whole(path, self.no_clobber, &png.map_err(|message| Error::output(path, message))?)?;
        }
        let mut aov = self.aov.clone();
        aov.dedup();
        let layers = aov.into_iter().map(|aov| Layer::of(aov, film, &estimate)).collect();
        Picture::new(settings.width, settings.height, settings.crop, estimate.mean)?.with_layers(layers)
    }

    fn tell_after(&self, facts: &Facts, rendered: &Rendered) {
        summary::warnings(facts).iter().for_each(|line| say(line));
        if self.running.quiet {
            return;
        }
        if self.running.verbose {
            say(&rendered.report.tree.to_string());
            say(rendered.ledger_table.trim_end());
        }
        summary::lines(facts).iter().for_each(|line| say(line));
        let reason = self.stop.reason(facts.report, facts.settings.spp);
        let files = if facts.outputs.is_empty() { "nothing".into() } else { facts.outputs.join(", ") };
        say(&format!("{reason}; wrote {files}"));
    }
}
