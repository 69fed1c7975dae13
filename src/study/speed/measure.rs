//! One measurement of a scene at a time.

use std::path::Path;

use super::super::child::number;
use super::super::peers::{Peer, PeerRun};
use super::super::relative_error::{mean, relative_mse};
use super::super::{Row, Watch};
use super::{Case, ERROR_SPP, Plan};
use crate::gpu::Context;
use crate::interface::TRIANGLE_TEXELS;
use crate::render::{Observer, Progress, Rendered, Renderer, StopReason, Tuning};
use crate::scene::{Filter, Scene};
use crate::settings::{Roulette, Settings};
use crate::{Error, Result};

/// Seed of references: no picture that is compared with them has it.
const REFERENCE_SEED: u64 = 1 << 32;

/// A scene with what is known of it so far.
pub struct SceneBench<'a> {
    context: &'a Context,
    plan: &'a Plan,
    scene: Scene,
    /// Samples of a timed render, once the device has been warmed up.
    timed_spp: Vec<(Case, u32)>,
    reference: Option<Vec<[f32; 3]>>,
}

/// Passes on the wish to stop.
struct Stopping<'a>(&'a dyn Watch);

impl Observer for Stopping<'_> {
    fn progress(&mut self, _progress: &Progress) {}

    fn stop_requested(&self) -> bool {
        self.0.stop_requested()
    }
}

impl<'a> SceneBench<'a> {
    pub fn load(context: &'a Context, plan: &'a Plan, path: &Path) -> Result<SceneBench<'a>> {
        Ok(SceneBench { context, plan, scene: Scene::load(path)?, timed_spp: Vec::new(), reference: None })
    }

    pub fn name(&self) -> &str {
        &self.scene.name
    }

    /// One row; `None` where the watch stopped it.
    pub fn measure(&mut self, case: Case, repeat: u32, watch: &mut dyn Watch) -> Result<Option<Row>> {
        let values = match case {
            Case::NoRoulette | Case::Default => self.timed(case, watch)?,
            Case::Error => self.error(repeat, watch)?,
            Case::Start { cold } => Some(self.start(cold)?),
            Case::Threads { one } => self.threads(one, watch)?,
            Case::Peer(peer) => Some(self.peer(peer)?),
            Case::PeerError(peer) => self.peer_error(peer, repeat, watch)?,
        };
        let row = |values| Row { scene: self.scene.name.clone(), case: case.name(), repeat, values };
        Ok(values.map(|values: Vec<(&str, f64)>| {
            row(values.into_iter().map(|(name, value)| (name.to_string(), value)).collect())
        }))
    }

    fn settings(&self, case: Case, [width, height]: [u32; 2], spp: u32) -> Settings {
        let roulette = if case == Case::NoRoulette { Roulette::Off } else { Roulette::default() };
        Settings { width, height, spp, roulette, filter: Filter::Box, ..Settings::for_scene(&self.scene) }
    }

    fn render(&self, settings: &Settings, watch: &dyn Watch) -> Result<Option<Rendered>> {
        let renderer = Renderer::new(self.context, &self.scene, settings, &Tuning::default())?;
        let rendered = renderer.render(&mut Stopping(watch))?;
        Ok((rendered.report.stop_reason != StopReason::Interrupted).then_some(rendered))
    }

    /// Samples that take the wanted time. The first call compiles, and times a second render.
    fn timed_spp(&mut self, case: Case, watch: &dyn Watch) -> Result<Option<u32>> {
        if let Some(&(_, spp)) = self.timed_spp.iter().find(|timed| timed.0 == case) {
            return Ok(Some(spp));
        }
        let settings = self.settings(case, self.plan.scale.size, 2);
        let (Some(_), Some(warm)) = (self.render(&settings, watch)?, self.render(&settings, watch)?) else {
            return Ok(None);
        };
        let wanted = self.plan.scale.seconds * 2.0 / warm.report.seconds.render.max(1e-3);
        let spp = (wanted.round() as u32).clamp(1, 4096);
        self.timed_spp.push((case, spp));
        Ok(Some(spp))
    }

    fn timed(&mut self, case: Case, watch: &dyn Watch) -> Result<Option<Vec<(&'static str, f64)>>> {
        let Some(spp) = self.timed_spp(case, watch)? else { return Ok(None) };
        let Some(rendered) = self.render(&self.settings(case, self.plan.scale.size, spp), watch)? else {
            return Ok(None);
        };
        let report = rendered.report;
        let (seconds, rays) = (report.seconds.render, report.rays as f64);
        let triangles = report.tree.triangles as f64;
        let tree_bytes = (report.tree.node_bytes + report.tree.triangles * TRIANGLE_TEXELS as usize * 16) as f64;
        Ok(Some(vec![
            ("spp", f64::from(spp)),
            ("seconds", seconds),
            ("mpaths_per_second", report.paths as f64 / seconds / 1e6),
            ("mrays_per_second", rays / seconds / 1e6),
            ("rays_per_path", rays / report.paths as f64),
            ("node_visits_per_ray", report.node_visits as f64 / rays),
            ("triangle_tests_per_ray", report.triangle_tests as f64 / rays),
            ("triangles", triangles),
            ("bytes_per_triangle", tree_bytes / triangles.max(1.0)),
            ("seconds_bvh", report.seconds.bvh),
            ("seconds_upload", report.seconds.upload),
        ]))
    }

    /// The reference, rendered once.
    fn reference(&mut self, watch: &dyn Watch) -> Result<Option<&[[f32; 3]]>> {
        if self.reference.is_none() {
            let scale = self.plan.scale;
            let settings = self.settings(Case::Error, scale.error_size, scale.reference_spp);
            let Some(rendered) = self.render(&Settings { seed: REFERENCE_SEED, ..settings }, watch)? else {
                return Ok(None);
            };
            self.reference = Some(rendered.film.mean());
        }
        Ok(self.reference.as_deref())
    }

    fn error(&mut self, seed: u32, watch: &dyn Watch) -> Result<Option<Vec<(&'static str, f64)>>> {
        let settings = self.settings(Case::Error, self.plan.scale.error_size, ERROR_SPP);
        let Some(rendered) = self.render(&Settings { seed: u64::from(seed), ..settings }, watch)? else {
            return Ok(None);
        };
        self.compared(&rendered.film.mean(), f64::from(ERROR_SPP), watch)
    }

    /// relMSE of a picture of `spp` samples, the reference's own share taken out (independent errors, falling as 1/spp).
    fn compared(
        &mut self,
        picture: &[[f32; 3]],
        spp: f64,
        watch: &dyn Watch,
    ) -> Result<Option<Vec<(&'static str, f64)>>> {
        let reference_spp = f64::from(self.plan.scale.reference_spp);
        let Some(reference) = self.reference(watch)? else { return Ok(None) };
        let error = relative_mse(picture, reference)
            .ok_or_else(|| Error::Internal("pictures of different sizes were compared".into()))?;
        let corrected = error / (1.0 + spp / reference_spp);
        Ok(Some(vec![
            ("spp", spp),
            ("relative_mse", corrected),
            ("relative_mse_spp", corrected * spp),
            ("mean_to_reference", mean(picture) / mean(reference)),
        ]))
    }

    fn arguments(&self, spp: u32) -> Vec<String> {
        let [width, height] = self.plan.scale.size;
        ["--filter", "box", "--size", &format!("{width}x{height}"), "--spp", &spp.to_string()]
            .map(String::from)
            .to_vec()
    }

    fn start(&self, cold: bool) -> Result<Vec<(&'static str, f64)>> {
        // Mesa's caches: on disk, and the one in memory that goes with the process anyway.
        let variables: &[(&str, &str)] = if cold { &[("MESA_SHADER_CACHE_DISABLE", "true")] } else { &[] };
        let document = self.plan.child.render(&self.scene.path, &self.arguments(1), variables)?;
        let names = [
            ("seconds_load", ["seconds", "load"]),
            ("seconds_bvh", ["seconds", "bvh"]),
            ("seconds_upload", ["seconds", "upload"]),
            ("seconds_pipeline", ["seconds", "pipeline"]),
            ("seconds_render", ["seconds", "render"]),
            ("seconds_write", ["seconds", "write"]),
            ("seconds_total", ["seconds", "total"]),
            ("bytes_device", ["bytes", "device"]),
        ];
        let mut values =
            names.into_iter().map(|(name, keys)| Ok((name, number(&document, &keys)?))).collect::<Result<Vec<_>>>()?;
        // On the host: what is left then is the file.
        let write = number(&document, &["seconds", "write"])?;
        values.push(("seconds_first_picture", number(&document, &["seconds", "total"])? - write));
        // Not every system tells.
        values.extend(number(&document, &["peak_rss_bytes"]).map(|bytes| ("bytes_peak_rss", bytes)));
        Ok(values)
    }

    fn threads(&mut self, one: bool, watch: &dyn Watch) -> Result<Option<Vec<(&'static str, f64)>>> {
        let Some(spp) = self.timed_spp(Case::Default, watch)? else { return Ok(None) };
        let variables: &[(&str, &str)] = if one { &[("LP_NUM_THREADS", "1")] } else { &[] };
        let document = self.plan.child.render(&self.scene.path, &self.arguments(spp), variables)?;
        Ok(Some(vec![("mpaths_per_second", number(&document, &["paths_per_second"])? / 1e6)]))
    }

    fn peer(&self, peer: Peer) -> Result<Vec<(&'static str, f64)>> {
        let scale = self.plan.scale;
        let run = self.peer_run(peer, scale.size, scale.peer_spp, 0)?;
        Ok(vec![("spp", run.spp), ("seconds", run.seconds), ("mpaths_per_second", run.mpaths_per_second)])
    }

    fn peer_error(&mut self, peer: Peer, seed: u32, watch: &mut dyn Watch) -> Result<Option<Vec<(&'static str, f64)>>> {
        let run = self.peer_run(peer, self.plan.scale.error_size, ERROR_SPP, seed)?;
        let values = self.compared(&run.picture, run.spp, watch)?;
        let ratio = values.iter().flatten().find(|value| value.0 == "mean_to_reference").map_or(1.0, |value| value.1);
        if (ratio - 1.0).abs() > 0.01 {
            let (scene, peer) = (&self.scene.name, peer.name());
            watch.warn(&format!("{scene}: {peer}'s picture is {ratio:.3} times as bright: not the same scene?"));
        }
        Ok(values)
    }

    fn peer_run(&self, peer: Peer, size: [u32; 2], spp: u32, seed: u32) -> Result<PeerRun> {
        let peers = self.plan.peers.as_ref().ok_or_else(|| Error::Internal("a peer that was not asked for".into()))?;
        let max_bounces = Settings::for_scene(&self.scene).max_bounces;
        peers.render(peer, &self.scene, size, spp, max_bounces, seed)
    }
}
