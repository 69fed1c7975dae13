//! `texray study WHAT`: what a choice costs in time and what it buys, measured here.
//!
//! Comes in: a study's name, scenes, a folder. Goes out: raw rows in the folder, a summary (or one JSON document) on stdout.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueEnum};
use serde::Serialize;
use texray::study::speed::{self, Ended, Plan, Scale};
use texray::study::{Origin, Row, Rows, Watch, child::Child, peers::Peers};
use texray::{Error, Result};

use super::engine::Engine;
use super::progress::duration;
use super::signals::Signals;
use super::{Outcome, streams};

/// Measure what a choice costs in time and what it buys
#[derive(Args)]
pub struct StudyArgs {
    /// What to study
    #[arg(value_enum)]
    what: What,
    /// Scenes [default: scenes/cornell-box.toml, and scenes/fetched/dragon*.toml as far as fetch.sh has brought them]
    #[arg(value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    /// Folder for the raw figures; a study that was stopped goes on from what it finds there
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Smaller pictures, fewer repeats
    #[arg(long)]
    quick: bool,
    /// Folder with mitsuba_render.py and cycles_render.py: measure these renderers too (Mitsuba by the Python that
    /// MITSUBA_PYTHON names, else python3)
    #[arg(long, value_name = "DIR")]
    peers: Option<PathBuf>,
    /// Device by number or name, as `texray devices` lists them [default: the best one]
    #[arg(long, value_name = "N|NAME")]
    device: Option<String>,
    /// Print one JSON document on stdout instead of the summary
    #[arg(long)]
    json: bool,
}

/// Studies.
#[derive(Clone, Copy, ValueEnum)]
enum What {
    /// Paths a second, the error of a sample, start-up; beside other renderers with --peers
    Speed,
}

#[derive(Serialize)]
struct Document<'a> {
    schema: u32,
    origin: &'a Origin,
    rows: &'a [Row],
    summary: Vec<String>,
    stopped_by: Option<u8>,
}

/// Tells what is measured and how long the rest will take.
struct Teller {
    signals: Signals,
    started: Instant,
    /// Measurements that were there before, or have been done.
    first_done: Option<usize>,
}

impl Watch for Teller {
    fn measured(&mut self, done: usize, total: usize, line: &str) {
        // What was there before took no time.
        let before = *self.first_done.get_or_insert(done - 1);
        let left = self.started.elapsed().as_secs_f64() / (done - before) as f64 * (total - done) as f64;
        streams::say(&format!("{done}/{total} {line}; about {} left", duration(left)));
    }

    fn warn(&mut self, line: &str) {
        streams::say(&format!("warning: {line}"));
    }

    fn stop_requested(&self) -> bool {
        self.signals.received().is_some()
    }
}

impl StudyArgs {
    /// Measures what the folder lacks, then prints.
    pub fn run(&self) -> Result<Outcome> {
        let What::Speed = self.what;
        let signals = Signals::watch()?;
        let scenes = if self.scenes.is_empty() { default_scenes() } else { self.scenes.clone() };
        let scale = if self.quick { Scale::QUICK } else { Scale::FULL };
        let engine = Engine::open(self.device.as_deref(), false)?;
        let program = std::env::current_exe()
            .map_err(|error| Error::Internal(format!("this program's own file is not known: {error}")))?;
        let python = std::env::var_os("MITSUBA_PYTHON").map_or_else(|| "python3".into(), PathBuf::from);
        let plan = Plan {
            scale,
            child: Child { program, device: self.device.clone() },
            peers: self.peers.clone().map(|scripts| Peers { scripts, python }),
            scenes,
        };
        let mut rows = Rows::open(&self.out, self.origin(&engine, &plan.scenes))?;
        streams::say(&format!("device {}", engine.device().summary));
        let mut teller = Teller { signals: signals.clone(), started: Instant::now(), first_done: None };
        let ended = engine.study_speed(&plan, &mut rows, &mut teller)?;
        let pixels = f64::from(scale.size[0]) * f64::from(scale.size[1]);
        let summary = speed::summary(&rows, pixels);
        let stopped_by = if ended == Ended::Stopped { signals.received() } else { None };
        if self.json {
            let document = Document { schema: 1, origin: rows.origin(), rows: rows.all(), summary, stopped_by };
            streams::answer_json(&document)?;
        } else {
            streams::answer(&summary.join("\n"))?;
        }
        Ok(stopped_by.map_or(Outcome::Done, Outcome::Signal))
    }

    /// What makes rows comparable. The command names everything that changes what is measured.
    fn origin(&self, engine: &Engine, scenes: &[PathBuf]) -> Origin {
        let mut command = String::from("texray study speed");
        scenes.iter().for_each(|scene| command += &format!(" {}", scene.display()));
        if self.quick {
            command += " --quick";
        }
        Origin {
            study: "speed".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            kernel: engine.kernel_hash(),
            device: engine.device().name.clone(),
            driver: engine.device().driver.clone(),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            command,
        }
    }
}

/// The repository's scenes, as far as they are there.
fn default_scenes() -> Vec<PathBuf> {
    let scenes = ["scenes/cornell-box.toml", "scenes/fetched/dragon-res2.toml", "scenes/fetched/dragon.toml"];
    // The first is kept, there or not: its absence is to be told.
    scenes
        .into_iter()
        .map(PathBuf::from)
        .enumerate()
        .filter(|(i, path)| *i == 0 || Path::exists(path))
        .map(|(_, path)| path)
        .collect()
}
