//! The study of speed: how many paths a second, what a sample is worth, and what both are beside other renderers.
//!
//! Comes in: scenes and a device. Goes out: rows (`speed.json`, `speed.csv`) and a summary. All pictures have the box filter and the
//! scene's bounces. Cases of a scene, in turn until every repeat is done:
//!
//! - `no-roulette`, `default`: a render of some seconds, timed without loading and compiling;
//! - `error`: 64 samples against a reference of 1,024, on a smaller picture, each repeat another seed;
//! - `start`, `start-cold`: from the start of a process to the first sample of every pixel, with the driver's cache of
//!   compiled shaders and without;
//! - `threads-1`, `threads-all`: one thread of the driver and all of them (CPU devices);
//! - a case for each peer and, NAME followed by `error`, its error against the same reference.

mod measure;
mod summary;

pub use summary::summary;

use crate::Result;
use crate::gpu::{Context, DeviceKind};
use crate::study::engine::peers::Peer;
use crate::study::engine::schedule::interleaved;
use crate::study::engine::subject::{Subject, Subjects};
use crate::study::engine::{Kind, Plan, Row, Scenes, Step, Study, Values, Watch};

use measure::Meter;

/// What is stated of it.
pub const KIND: Kind = Kind {
    name: "speed",
    help: "Paths a second, the error of a sample, start-up; beside other renderers with --peers",
    title: "Speed",
    scenes: Scenes::Chosen {
        full: &["cornell-box", "fetched/dragon-res2", "fetched/dragon"],
        quick: &["cornell-box", "fetched/dragon-res2", "fetched/dragon"],
    },
    summary: |rows, _| summary(rows),
    opens: |context, plan, watch| Ok(Box::new(Speed::new(context, plan, watch)?)),
};

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedWorkload {
    /// Picture size of what is timed.
    pub size: [u32; 2],
    /// Picture size of what is compared with a reference.
    pub error_size: [u32; 2],
    /// Wanted seconds of a timed render.
    pub seconds: f64,
    /// Times that a timed case comes.
    pub repeats: u32,
    /// Seeds of the error.
    pub error_seeds: u32,
    /// Samples of the reference.
    pub reference_spp: u32,
    /// Samples of a peer's timed render, and the fewest of our own.
    pub peer_spp: u32,
}

impl SpeedWorkload {
    /// Some minutes a scene.
    pub const FULL: SpeedWorkload = SpeedWorkload {
        size: [800, 600],
        error_size: [400, 300],
        seconds: 4.0,
        repeats: 5,
        error_seeds: 2,
        reference_spp: 1024,
        peer_spp: 16,
    };
    /// Less than a minute a scene.
    pub const QUICK: SpeedWorkload = SpeedWorkload {
        size: [400, 300],
        error_size: [160, 120],
        seconds: 1.0,
        repeats: 3,
        error_seeds: 1,
        reference_spp: 1024,
        peer_spp: 8,
    };
    /// Shows that it runs.
    pub const LEAST: SpeedWorkload = SpeedWorkload {
        size: [8, 6],
        error_size: [8, 6],
        seconds: 1e-3,
        repeats: 1,
        error_seeds: 1,
        reference_spp: 64,
        peer_spp: 1,
    };
}

/// Samples of a picture whose error is measured.
pub const ERROR_SPP: u32 = 64;

/// What is measured of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Case {
    /// Without Russian roulette.
    NoRoulette,
    /// As texray does it by default.
    Default,
    /// relMSE of the default.
    Error,
    /// A process to its first picture.
    Start {
        /// Without the driver's cache of compiled shaders.
        cold: bool,
    },
    /// One driver thread, or all.
    Threads {
        /// Just one.
        one: bool,
    },
    /// Another renderer's speed.
    Peer(Peer),
    /// Another renderer's relMSE.
    PeerError(Peer),
}

impl Case {
    /// Its name in rows.
    pub fn name(self) -> String {
        match self {
            Case::NoRoulette => "no-roulette".into(),
            Case::Default => "default".into(),
            Case::Error => "error".into(),
            Case::Start { cold: false } => "start".into(),
            Case::Start { cold: true } => "start-cold".into(),
            Case::Threads { one: true } => "threads-1".into(),
            Case::Threads { one: false } => "threads-all".into(),
            Case::Peer(peer) => peer.name().into(),
            Case::PeerError(peer) => format!("{} error", peer.name()),
        }
    }
}

/// The study.
pub struct Speed {
    subjects: Subjects,
    meter: Meter,
    cases: Vec<Case>,
    workload: SpeedWorkload,
}

impl Speed {
    /// Peers that are asked for and not there are told to the watch, and left out.
    pub fn new(context: &Context, plan: &Plan, watch: &mut dyn Watch) -> Result<Speed> {
        let workload = plan.amount.of(SpeedWorkload::FULL, SpeedWorkload::QUICK, SpeedWorkload::LEAST);
        let peers = plan.peers.as_ref().map_or_else(Vec::new, |peers| {
            let (installed, missing) = peers.installed();
            missing.iter().for_each(|line| watch.warn(line));
            installed
        });
        let threads = context.device_info().kind == DeviceKind::Cpu;
        Ok(Speed {
            subjects: Subjects::new(context, &plan.scenes)?,
            meter: Meter::new(workload, plan),
            cases: cases(&peers, threads),
            workload,
        })
    }
}

impl Study for Speed {
    fn scenes(&self) -> &[String] {
        self.subjects.names()
    }

    fn case(&self, case: usize) -> String {
        self.cases[case].name()
    }

    fn schedule(&self) -> Vec<Step> {
        schedule(self.subjects.names().len(), &self.cases, self.workload)
    }

    fn measure(&mut self, step: Step, watch: &mut dyn Watch) -> Result<Option<Values>> {
        let subject: &mut Subject = self.subjects.at(step.scene)?;
        self.meter.measure(subject, self.cases[step.case], step.repeat, watch)
    }

    fn headline(&self, row: &Row) -> String {
        summary::headline(row)
    }
}

/// All cases, errors first: they are of other pictures than what is timed.
fn cases(peers: &[Peer], threads: bool) -> Vec<Case> {
    let mut cases = vec![Case::Error];
    // Roulette or not, the peer's error is measured as it comes by default.
    cases.extend(peers.iter().filter(|&&peer| peer != Peer::MitsubaNoRoulette).map(|&peer| Case::PeerError(peer)));
    cases.extend([Case::NoRoulette, Case::Default, Case::Start { cold: false }, Case::Start { cold: true }]);
    if threads {
        cases.extend([Case::Threads { one: true }, Case::Threads { one: false }]);
    }
    cases.extend(peers.iter().map(|&peer| Case::Peer(peer)));
    cases
}

/// A scene after the other: errors, then what is timed, each repeat by repeat.
fn schedule(scenes: usize, cases: &[Case], workload: SpeedWorkload) -> Vec<Step> {
    let is_error = |case: Case| matches!(case, Case::Error | Case::PeerError(_));
    let (errors, timed): (Vec<usize>, Vec<usize>) = (0..cases.len()).partition(|&case| is_error(cases[case]));
    let of = |scene, cases: &[usize], repeats| {
        interleaved(1, cases, repeats).into_iter().map(move |step| Step { scene, ..step }).collect::<Vec<_>>()
    };
    (0..scenes)
        .flat_map(|scene| [of(scene, &errors, workload.error_seeds), of(scene, &timed, workload.repeats)].concat())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_come_first_and_repeats_go_through_all_cases() {
        let cases = cases(&[Peer::MitsubaNoRoulette, Peer::Mitsuba], true);
        let schedule = schedule(2, &cases, SpeedWorkload::QUICK);
        let names: Vec<_> =
            schedule.iter().map(|step| format!("{} {}", cases[step.case].name(), step.repeat)).collect();
        assert_eq!(names[..3], ["error 0", "mitsuba error 0", "no-roulette 0"]);
        assert_eq!(schedule.len(), 2 * (2 + 3 * 8));
        assert!(schedule[26..].iter().all(|step| step.scene == 1));
        let first = |name: &str| names.iter().position(|n| n == name).unwrap();
        assert!(first("mitsuba 0") < first("no-roulette 1") && first("threads-all 1") < first("default 2"));
    }
}
