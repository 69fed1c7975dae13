//! What a render tells its caller: progress while it runs, and figures when it is done.

use std::collections::BTreeMap;

use serde::Serialize;

use super::counters::Counts;
use super::effects::Effects;
use super::kernel::ReadAs;
use super::stop::{Forecast, Target};
use crate::bvh::TreeStats;
use crate::film::{Film, PictureError};
use crate::gpu::Ledger;
use crate::interface::{CAUSE_NAMES, COUNTER_NODES, COUNTER_RAYS, COUNTER_TRIANGLES, INVALID_KIND_NAMES};
use crate::settings::Buffers;

/// State of a render at a run boundary or between two slices of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// Samples a pixel that every pixel has finished.
    pub spp_done: u32,
    /// Samples a pixel asked for.
    pub spp_target: u32,
    /// Share of all the work that is done, 0 to 1, slices of the current run included.
    pub fraction: f64,
    /// Paths traced so far.
    pub paths: u64,
    /// Seconds since the first dispatch.
    pub seconds: f64,
    /// Estimated relative RMSE of the picture so far, once there are two blocks.
    pub relative_rmse: Option<f64>,
    /// The error to reach, where there is one, and when it will be, once there are two blocks.
    pub target: Option<(Target, Option<Forecast>)>,
}

/// Watches a render and may stop it.
pub trait Observer {
    /// Called at least once a slice (some 0.1 to 0.5 seconds).
    fn progress(&mut self, progress: &Progress);
    /// Asked as often: whether to stop now. What the last whole run left is kept.
    fn stop_requested(&self) -> bool;
}

/// Why a render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum StopReason {
    /// The samples asked for are done.
    Spp,
    /// The error is below the target, with the confidence asked for.
    TargetError,
    /// Another run would end after the time limit.
    TimeLimit,
    /// The observer asked for it.
    Interrupted,
}

/// The error of the picture as it ended.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorReport {
    /// The estimate.
    #[serde(flatten)]
    pub picture: PictureError,
    /// The relative RMSE is at most this, with probability `confidence`; infinite (null in JSON) for pictures of one column.
    pub upper: f64,
    /// The confidence of `upper`, all looks of a target together.
    pub confidence: f64,
    /// The target, where there was one.
    pub target: Option<f64>,
    /// Looks taken at the error for the target's sake.
    pub looks: u32,
    /// Whether a few pixels hold most of the error, so that none of this can be relied on.
    pub heavy_tailed: bool,
    /// What the first look forecast of the target.
    pub forecast: Option<Forecast>,
}

/// Seconds of wall time by stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct StageSeconds {
    /// Reading and checking the scene.
    pub load: f64,
    /// Building the tree.
    pub bvh: f64,
    /// Packing texels and copying them to the device.
    pub upload: f64,
    /// Making the pipeline (the driver's compiler included, as far as it runs then) and the path states' memory.
    pub pipeline: f64,
    /// From the first dispatch to the end of the last run and of the last look at the error.
    pub render: f64,
    /// Estimating the error; part of `render`.
    pub estimate: f64,
    /// Waiting for and adding up what came back; part of it overlaps `render`.
    pub readback: f64,
    /// Writing pictures.
    pub write: f64,
    /// From the start of the process (or of the call) to the end.
    pub total: f64,
}

/// Bytes moved and held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Bytes {
    /// Copied from host to device.
    pub uploaded: u64,
    /// Copied from device to host.
    pub read_back: u64,
    /// Allocated on the device at most.
    pub device: u64,
}

/// Figures of a finished render.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderReport {
    /// Samples that every pixel has.
    pub spp: u32,
    /// Why it ended.
    pub stop_reason: StopReason,
    /// Seconds by stage; `load`, `write` and `total` are the caller's to fill.
    pub seconds: StageSeconds,
    /// Paths traced.
    pub paths: u64,
    /// Rays traced, extension and shadow.
    pub rays: u64,
    /// Node visits of all rays.
    pub node_visits: u64,
    /// Triangle tests of all rays.
    pub triangle_tests: u64,
    /// How the records were read: storage buffers where one is too large for the device's texel buffers.
    pub buffers: Buffers,
    /// How the path states were read: the same, for a tile of them.
    pub path_buffers: Buffers,
    /// Estimated relative RMSE of the picture; `None` before every pixel has two blocks, and for the `table` sampler, whose
    /// replicates share one table and are not independent.
    pub relative_rmse: Option<f64>,
    /// The same with its bound.
    pub error: Option<ErrorReport>,
    /// Seconds that a sample of every pixel took, by the last run.
    pub seconds_per_sample: f64,
    /// Figures of the tree.
    pub tree: TreeStats,
    /// Names of the effects that were on.
    pub effects: Vec<&'static str>,
    /// Samples left out, by cause: the first stage of the path or lobe whose numbers were invalid (`camera`, `emission`,
    /// `sky`, `light`, `lambert`, `mirror`, `glass`; `sum` where only the sum of them was). Every cause is listed.
    pub invalid_samples: BTreeMap<&'static str, u64>,
    /// The same samples by kind (`nan`, `infinite`, `negative`), every kind listed.
    pub invalid_kinds: BTreeMap<&'static str, u64>,
    /// Times that the table of random numbers wrapped around for a pixel (0 for other samplers).
    pub table_wraps: u64,
    /// Bytes moved and held.
    pub bytes: Bytes,
}

impl RenderReport {
    /// The report of a picture of which nothing has been rendered.
    pub(super) fn of_nothing(
        effects: &Effects,
        seconds: StageSeconds,
        read_as: ReadAs,
        tree: TreeStats,
    ) -> RenderReport {
        RenderReport {
            spp: 0,
            stop_reason: StopReason::Spp,
            seconds,
            paths: 0,
            rays: 0,
            node_visits: 0,
            triangle_tests: 0,
            buffers: read_as.records,
            path_buffers: read_as.paths,
            relative_rmse: None,
            error: None,
            seconds_per_sample: 0.0,
            tree,
            effects: effects.names(),
            invalid_samples: CAUSE_NAMES.into_iter().map(|cause| (cause, 0)).collect(),
            invalid_kinds: INVALID_KIND_NAMES.into_iter().map(|kind| (kind, 0)).collect(),
            table_wraps: 0,
            bytes: Bytes::default(),
        }
    }

    /// Adds what the kernel counted in a run.
    pub(super) fn add(&mut self, counts: &Counts) {
        self.rays += counts.of(COUNTER_RAYS);
        self.paths += counts.paths();
        self.node_visits += counts.of(COUNTER_NODES);
        self.triangle_tests += counts.of(COUNTER_TRIANGLES);
        counts.invalid_kinds().for_each(|(kind, count)| *self.invalid_kinds.entry(kind).or_default() += count);
        counts.causes().for_each(|(cause, count)| *self.invalid_samples.entry(cause).or_default() += count);
    }
}

/// A finished render.
pub struct Rendered {
    /// The film: sums in scaled radiance, from which picture and error are read.
    pub film: Film,
    /// Figures of the render.
    pub report: RenderReport,
    /// Every copy between CPU and GPU.
    pub ledger: Ledger,
    /// The effects that were on, and why.
    pub effects: Effects,
}
