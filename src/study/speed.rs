//! The study of speed: how many paths a second, what a sample is worth, and what both are beside other renderers.
//!
//! Comes in: scenes and a device. Goes out: rows (`speed.json`, `speed.csv`) and a summary. All pictures have the box filter and the
//! scene's bounces. Cases of a scene, in turn until every repeat is done:
//!
//! - `no-roulette`, `default`: a render of some seconds, timed without loading and compiling;
//! - `error`: 64 samples against a reference of 2,048 (1,024), on a smaller picture, each repeat another seed;
//! - `start`, `start-cold`: from the start of a process to the first sample of every pixel, with the driver's cache of
//!   compiled shaders and without;
//! - `threads-1`, `threads-all`: one thread of the driver and all of them (CPU devices);
//! - a case for each peer and, NAME followed by `error`, its error against the same reference.

mod measure;
mod summary;

use std::path::PathBuf;

use super::child::Child;
use super::peers::{Peer, Peers};
use super::{Rows, Watch};
use crate::gpu::{Context, DeviceKind};
use crate::{Error, Result};

pub use summary::summary;

/// What is to be measured.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Scene files.
    pub scenes: Vec<PathBuf>,
    /// How much of it.
    pub scale: Scale,
    /// The program itself, for processes of their own.
    pub child: Child,
    /// Where the peers are, if they are asked for.
    pub peers: Option<Peers>,
}

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
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
    /// Samples of a peer's timed render.
    pub peer_spp: u32,
}

impl Scale {
    /// Some minutes a scene.
    pub const FULL: Scale = Scale {
        size: [800, 600],
        error_size: [400, 300],
        seconds: 4.0,
        repeats: 5,
        error_seeds: 2,
        reference_spp: 2048,
        peer_spp: 32,
    };
    /// Less than a minute a scene.
    pub const QUICK: Scale = Scale {
        size: [400, 300],
        error_size: [160, 120],
        seconds: 1.0,
        repeats: 3,
        error_seeds: 1,
        reference_spp: 1024,
        peer_spp: 8,
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

/// How a study ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// Everything is measured.
    Whole,
    /// Stopped by the watch; what there is is on disk.
    Stopped,
}

/// Measures what `rows` lack.
pub fn run(context: &Context, plan: &Plan, rows: &mut Rows, watch: &mut dyn Watch) -> Result<Ended> {
    if plan.scenes.is_empty() {
        return Err(Error::Usage("no scene to study".into()));
    }
    let peers = match &plan.peers {
        None => Vec::new(),
        Some(peers) => {
            let (installed, missing) = peers.installed();
            missing.iter().for_each(|line| watch.warn(line));
            installed
        }
    };
    let threads = context.device_info().kind == DeviceKind::Cpu;
    let schedule = schedule(plan.scale, &peers, threads);
    let total = schedule.len() * plan.scenes.len();
    let mut done = 0;
    let mut names: Vec<String> = Vec::new();
    for path in &plan.scenes {
        let mut bench = measure::SceneBench::load(context, plan, path)?;
        // Rows go by the scene's name.
        if names.iter().any(|name| name == bench.name()) {
            return Err(Error::Usage(format!("{}: there are two scenes named {}", path.display(), bench.name())));
        }
        names.push(bench.name().into());
        for &(case, repeat) in &schedule {
            done += 1;
            if rows.has(bench.name(), &case.name(), repeat) {
                continue;
            }
            if watch.stop_requested() {
                return Ok(Ended::Stopped);
            }
            let Some(row) = bench.measure(case, repeat, watch)? else { return Ok(Ended::Stopped) };
            let line = format!("{} {} {}", row.scene, row.case, summary::headline(&row));
            rows.add(row)?;
            watch.measured(done, total, line.trim_end());
        }
    }
    Ok(Ended::Whole)
}

/// All cases of a scene, repeat by repeat.
fn schedule(scale: Scale, peers: &[Peer], threads: bool) -> Vec<(Case, u32)> {
    let mut timed = vec![Case::NoRoulette, Case::Default, Case::Start { cold: false }, Case::Start { cold: true }];
    if threads {
        timed.extend([Case::Threads { one: true }, Case::Threads { one: false }]);
    }
    timed.extend(peers.iter().map(|&peer| Case::Peer(peer)));
    let mut errors = vec![Case::Error];
    // Roulette or not, the peer's error is measured as it comes by default.
    errors.extend(peers.iter().filter(|&&peer| peer != Peer::MitsubaNoRoulette).map(|&peer| Case::PeerError(peer)));
    let of = |cases: &[Case], repeats| {
        (0..repeats)
            .flat_map(|repeat| cases.iter().map(move |&case| (case, repeat)).collect::<Vec<_>>())
            .collect::<Vec<_>>()
    };
    [of(&errors, scale.error_seeds), of(&timed, scale.repeats)].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeats_go_through_all_cases_before_any_comes_again() {
        let schedule = schedule(Scale::QUICK, &[Peer::MitsubaNoRoulette, Peer::Mitsuba], true);
        let names: Vec<_> = schedule.iter().map(|(case, repeat)| format!("{} {repeat}", case.name())).collect();
        assert_eq!(names[..3], ["error 0", "mitsuba error 0", "no-roulette 0"]);
        assert_eq!(schedule.len(), 2 + 3 * 8);
        let first = |name: &str| names.iter().position(|n| n == name).unwrap();
        assert!(first("mitsuba 0") < first("no-roulette 1") && first("threads-all 1") < first("default 2"));
    }
}
