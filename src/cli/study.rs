//! `texray study WHAT`: what a choice costs in time and what it buys, measured here.
//!
//! Comes in: a study's name, scenes, a folder. Goes out: raw rows in the folder, a summary (or one JSON document) on stdout.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use serde::Serialize;
use texray::study::{
    Amount, Ended, Kind, Origin, Plan, Row, Rows, Watch, page, peers::Peers, studies, subprocess::Subprocess,
};
use texray::{Error, Result};

use super::choices::{self, What};
use super::engine::Engine;
use super::progress::duration;
use super::signals::Signals;
use super::{Outcome, shell, streams};

/// Measure what a choice costs in time and what it buys
#[derive(Args)]
pub struct StudyArgs {
    /// What to study
    #[arg(value_parser = choices::study())]
    what: What,
    /// Scenes [default: some of scenes/, by the study; the dragons as far as fetch.sh has brought them]
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

#[derive(Serialize)]
struct Document {
    schema: u32,
    #[serde(flatten)]
    studied: Studied,
    stopped_by: Option<u8>,
}

/// The document of several studies.
#[derive(Serialize)]
struct Documents {
    schema: u32,
    studies: Vec<Studied>,
    stopped_by: Option<u8>,
}

/// A study that has been run, to its end or not.
#[derive(Serialize)]
struct Studied {
    origin: Origin,
    rows: Vec<Row>,
    summary: Vec<String>,
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
        let signals = Signals::watch()?;
        let (kinds, all): (Vec<&Kind>, bool) = match self.what {
            What::One(kind) => (vec![kind], false),
            What::All => (studies::ALL.iter().collect(), true),
        };
        let engine = Engine::open(self.device.as_deref(), false)?;
        let program = std::env::current_exe()
            .map_err(|error| Error::Internal(format!("this program's own file is not known: {error}")))?;
        let python = std::env::var_os("MITSUBA_PYTHON").map_or_else(|| "python3".into(), PathBuf::from);
        let plan = Plan {
            scenes: self.scenes.clone(),
            amount: if self.quick { Amount::Quick } else { Amount::Full },
            folder: self.out.clone(),
            subprocess: Subprocess { program, device: self.device.clone() },
            peers: self.peers.clone().map(|scripts| Peers { scripts, python }),
        };
        streams::say(&format!("device {}", engine.device().summary));
        let mut studies = Vec::new();
        let mut ended = Ended::Whole;
        for (index, &kind) in kinds.iter().enumerate() {
            let missing = |path: &PathBuf| !path.exists();
            if all && !kind.takes_scenes() && kind.default_scenes(plan.amount).iter().any(missing) {
                streams::say(&format!("study {} is left out: its scene is not here", kind.name));
                continue;
            }
            // A study with scenes of its own has no use for others, and is no reason for `all` to fail.
            let scenes = if all && !kind.takes_scenes() { Vec::new() } else { self.scenes.clone() };
            let plan = Plan { scenes, ..plan.clone() };
            let mut rows = Rows::open(&self.out, self.origin(&engine, kind, &plan), Some(self.remade_by(kind, &plan)))?;
            if kinds.len() > 1 {
                streams::say(&format!("study {} of {}: {}", index + 1, kinds.len(), kind.name));
            }
            let mut teller = Teller { signals: signals.clone(), started: Instant::now(), first_done: None };
            let how = engine.study(kind, &plan, &mut rows, &mut teller)?;
            page::write(&self.out, rows.origin())?;
            let summary = (kind.summary)(&rows, &self.out).lines();
            studies.push(Studied { origin: rows.origin().clone(), rows: rows.all().to_vec(), summary });
            ended = how;
            if ended == Ended::Stopped {
                break;
            }
        }
        let stopped_by = if ended == Ended::Stopped { signals.received() } else { None };
        self.tell(studies, stopped_by)?;
        Ok(stopped_by.map_or(Outcome::Done, Outcome::Signal))
    }

    /// The figures, and last where the report is: after a JSON document on stderr.
    fn tell(&self, studies: Vec<Studied>, stopped_by: Option<u8>) -> Result<()> {
        let report = (!studies.is_empty()).then(|| format!("report: {}", self.out.join(page::FILE).display()));
        if self.json {
            self.tell_json(studies, stopped_by)?;
            report.iter().for_each(|line| streams::say(line));
            return Ok(());
        }
        let text = studies.iter().map(|study| study.summary.join("\n")).chain(report);
        streams::answer(&text.collect::<Vec<_>>().join("\n\n"))
    }

    fn tell_json(&self, mut studies: Vec<Studied>, stopped_by: Option<u8>) -> Result<()> {
        match (self.what, studies.pop()) {
            (What::All, last) => {
                studies.extend(last);
                streams::answer_json(&Documents { schema: 1, studies, stopped_by })
            }
            (_, Some(studied)) => streams::answer_json(&Document { schema: 1, studied, stopped_by }),
            (_, None) => Ok(()),
        }
    }

    /// The command with all that was given to it, as a shell takes it; the program as it was started.
    fn remade_by(&self, kind: &Kind, plan: &Plan) -> String {
        let program = std::env::args_os().next().map_or("texray".into(), |name| name.to_string_lossy().into_owned());
        let path = |path: &PathBuf| path.to_string_lossy().into_owned();
        let mut words = vec![program, "study".into(), kind.name.into()];
        let scenes = if plan.scenes.is_empty() { kind.default_scenes(plan.amount) } else { plan.scenes.clone() };
        words.extend(scenes.iter().filter(|_| kind.takes_scenes()).map(path));
        words.extend(self.quick.then(|| "--quick".into()));
        let peers = self.peers.as_ref().map(path);
        for (option, value) in [("--peers", peers), ("--device", self.device.clone()), ("--out", Some(path(&self.out)))]
        {
            words.extend(value.into_iter().flat_map(|value| [option.into(), value]));
        }
        let command = words.iter().map(|word| shell::word(word)).collect::<Vec<_>>().join(" ");
        let python = self.peers.as_ref().and_then(|_| std::env::var("MITSUBA_PYTHON").ok());
        python.map_or(String::new(), |python| format!("MITSUBA_PYTHON={} ", shell::word(&python))) + &command
    }

    /// What makes rows comparable. The command names everything that changes what is measured; a study that is part of `all`
    /// has the command of its own, and goes on from rows that it left.
    fn origin(&self, engine: &Engine, kind: &Kind, plan: &Plan) -> Origin {
        let mut command = format!("texray study {}", kind.name);
        let scenes = if plan.scenes.is_empty() { kind.default_scenes(plan.amount) } else { plan.scenes.clone() };
        scenes.iter().for_each(|scene| command += &format!(" {}", shell::word(&scene.to_string_lossy())));
        if self.quick {
            command += " --quick";
        }
        Origin {
            study: kind.name.into(),
            version: env!("CARGO_PKG_VERSION").into(),
            kernel: engine.kernel_hash(),
            device: engine.device().name.clone(),
            driver: engine.device().driver.clone(),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            command,
        }
    }
}
