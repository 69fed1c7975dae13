//! The JSON document of a render.
//!
//! Comes in: a finished render and what was asked for. Goes out: one value to print. Figures that cannot be known yet
//! are null, never left out.

use std::collections::BTreeMap;

use serde::Serialize;
use texray::render::{
    Buffers, Bytes, CapBias, ErrorReport, LightPick, RenderReport, Settings, StageSeconds, StopReason,
};
use texray::scene::Scene;

use super::engine::DeviceLine;
use super::process;

/// What `render --json` prints. Times are in seconds of wall time, sizes in bytes.
#[derive(Serialize)]
pub struct Document<'a> {
    schema: u32,
    scene: String,
    device: &'a str,
    driver: &'a str,
    width: u32,
    height: u32,
    crop: Option<[u32; 4]>,
    spp: u32,
    max_bounces: u32,
    seed: u64,
    triangles: usize,
    effects: &'a [&'static str],
    light_pick: LightPick,
    buffers: Buffers,
    path_buffers: Buffers,
    stop_reason: StopReason,
    seconds: StageSeconds,
    paths: u64,
    rays: u64,
    paths_per_second: Option<f64>,
    rays_per_second: Option<f64>,
    node_visits: u64,
    triangle_tests: u64,
    error: Option<ErrorReport>,
    bias: Bias,
    invalid_samples: &'a BTreeMap<&'static str, u64>,
    invalid_kinds: &'a BTreeMap<&'static str, u64>,
    empty_pixels: usize,
    table_wraps: u64,
    bytes: Bytes,
    peak_rss_bytes: Option<u64>,
    outputs: Vec<String>,
    not_written: Vec<String>,
    warnings: &'a [String],
}

/// Energy lost on purpose; null where it was not estimated.
#[derive(Serialize)]
struct Bias {
    bounce_cap: Option<f64>,
    standard_error: Option<f64>,
    up_to_bounces: Option<u32>,
}

/// What a document is made of.
pub struct Facts<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// What was asked for.
    pub settings: &'a Settings,
    /// The device.
    pub device: &'a DeviceLine,
    /// Figures, with the caller's times filled in.
    pub report: &'a RenderReport,
    /// Estimated relative RMSE.
    pub relative_rmse: Option<f64>,
    /// What the bounce cap cuts off, where it was estimated.
    pub cap_bias: Option<CapBias>,
    /// Whether every pixel is black.
    pub black: bool,
    /// Pixels without a valid sample.
    pub empty_pixels: usize,
    /// Files written.
    pub outputs: Vec<String>,
    /// Why other files were not.
    pub not_written: Vec<String>,
}

impl<'a> Document<'a> {
    /// The document of a render.
    pub fn new(facts: Facts<'a>) -> Document<'a> {
        let Facts { scene, settings, device, report, .. } = facts;
        let per_second = |count: u64| (report.seconds.render > 0.0).then(|| count as f64 / report.seconds.render);
        Document {
            schema: 1,
            scene: scene.path.display().to_string(),
            device: &device.name,
            driver: &device.driver,
            width: settings.width,
            height: settings.height,
            crop: settings.crop,
            spp: report.spp,
            max_bounces: settings.max_bounces,
            seed: settings.seed,
            triangles: scene.triangles.len(),
            effects: &report.effects,
            light_pick: settings.light_pick,
            buffers: report.buffers,
            path_buffers: report.path_buffers,
            stop_reason: report.stop_reason,
            seconds: report.seconds,
            paths: report.paths,
            rays: report.rays,
            paths_per_second: per_second(report.paths),
            rays_per_second: per_second(report.rays),
            node_visits: report.node_visits,
            triangle_tests: report.triangle_tests,
            error: report.error,
            bias: Bias {
                bounce_cap: facts.cap_bias.map(|bias| bias.bounce_cap),
                standard_error: facts.cap_bias.map(|bias| bias.standard_error),
                up_to_bounces: facts.cap_bias.map(|bias| bias.up_to_bounces),
            },
            invalid_samples: &report.invalid_samples,
            invalid_kinds: &report.invalid_kinds,
            empty_pixels: facts.empty_pixels,
            table_wraps: report.table_wraps,
            bytes: report.bytes,
            peak_rss_bytes: process::peak_rss_bytes(),
            outputs: facts.outputs,
            not_written: facts.not_written,
            warnings: &scene.report.warnings,
        }
    }
}
