//! One measurement of a scene at a time.

use super::{Case, ERROR_SPP, SpeedWorkload};
use crate::compare::relative_error::{mean, relative_mse};
use crate::interface::TRIANGLE_TEXELS;
use crate::render::{Rendered, Tuning};
use crate::settings::{Roulette, Settings};
use crate::study::engine::peers::{Peer, PeerRun, Peers};
use crate::study::engine::subject::{REFERENCE_SEED, Subject};
use crate::study::engine::subprocess::{Subprocess, number};
use crate::study::engine::{Plan, Values, Watch};
use crate::{Error, Result};

/// What measuring takes beside the scene, with what is known of the scene so far.
pub struct Meter {
    workload: SpeedWorkload,
    subprocess: Subprocess,
    peers: Option<Peers>,
    /// Name of the scene that the rest is about.
    scene: String,
    /// Samples of a timed render, once the device has been warmed up.
    timed_spp: Vec<(Case, u32)>,
    reference: Option<Vec<[f32; 3]>>,
}

impl Meter {
    pub fn new(workload: SpeedWorkload, plan: &Plan) -> Meter {
        Meter {
            workload,
            subprocess: plan.subprocess.clone(),
            peers: plan.peers.clone(),
            scene: String::new(),
            timed_spp: Vec::new(),
            reference: None,
        }
    }

    /// Figures of a row; `None` where the watch stopped it.
    pub fn measure(
        &mut self,
        subject: &Subject,
        case: Case,
        repeat: u32,
        watch: &mut dyn Watch,
    ) -> Result<Option<Values>> {
        if self.scene != subject.scene.name {
            self.scene.clone_from(&subject.scene.name);
            self.timed_spp.clear();
            self.reference = None;
        }
        Ok(match case {
            Case::NoRoulette | Case::Default => self.timed(subject, case, watch)?,
            Case::Error => self.error(subject, repeat, watch)?,
            Case::Start { cold } => Some(self.start(subject, cold)?),
            Case::Threads { one } => self.threads(subject, one, watch)?,
            Case::Peer(peer) => Some(self.peer(subject, peer)?),
            Case::PeerError(peer) => self.peer_error(subject, peer, repeat, watch)?,
        })
    }

    fn settings(&self, subject: &Subject, case: Case, size: [u32; 2], spp: u32) -> Settings {
        let roulette = if case == Case::NoRoulette { Roulette::Off } else { Roulette::default() };
        Settings { roulette, ..subject.settings(size, spp) }
    }

    fn render(&self, subject: &Subject, settings: &Settings, watch: &dyn Watch) -> Result<Option<Rendered>> {
        subject.render(settings, &Tuning::default(), watch)
    }

    /// Samples that take the wanted time, and those of a peer at least: short runs are slower, and a picture of fewer samples is another
    /// task. The first call compiles, and times a second render.
    fn timed_spp(&mut self, subject: &Subject, case: Case, watch: &dyn Watch) -> Result<Option<u32>> {
        if let Some(&(_, spp)) = self.timed_spp.iter().find(|timed| timed.0 == case) {
            return Ok(Some(spp));
        }
        let settings = self.settings(subject, case, self.workload.size, 2);
        let (Some(_), Some(warm)) = (self.render(subject, &settings, watch)?, self.render(subject, &settings, watch)?)
        else {
            return Ok(None);
        };
        let wanted = self.workload.seconds * 2.0 / warm.report.seconds.render.max(1e-3);
        let spp = (wanted.round() as u32).clamp(self.workload.peer_spp, 4096);
        self.timed_spp.push((case, spp));
        Ok(Some(spp))
    }

    fn timed(&mut self, subject: &Subject, case: Case, watch: &dyn Watch) -> Result<Option<Values>> {
        let Some(spp) = self.timed_spp(subject, case, watch)? else { return Ok(None) };
        let Some(rendered) = self.render(subject, &self.settings(subject, case, self.workload.size, spp), watch)?
        else {
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
    fn reference(&mut self, subject: &Subject, watch: &dyn Watch) -> Result<Option<&[[f32; 3]]>> {
        if self.reference.is_none() {
            let workload = self.workload;
            let settings = self.settings(subject, Case::Error, workload.error_size, workload.reference_spp);
            let Some(rendered) = self.render(subject, &Settings { seed: REFERENCE_SEED, ..settings }, watch)? else {
                return Ok(None);
            };
            self.reference = Some(rendered.film.mean());
        }
        Ok(self.reference.as_deref())
    }

    fn error(&mut self, subject: &Subject, seed: u32, watch: &dyn Watch) -> Result<Option<Values>> {
        let settings = self.settings(subject, Case::Error, self.workload.error_size, ERROR_SPP);
        let Some(rendered) = self.render(subject, &Settings { seed: u64::from(seed), ..settings }, watch)? else {
            return Ok(None);
        };
        self.compared(subject, &rendered.film.mean(), f64::from(ERROR_SPP), watch)
    }

    /// relMSE of a picture of `spp` samples, the reference's own share taken out (independent errors, falling as 1/spp).
    fn compared(
        &mut self,
        subject: &Subject,
        picture: &[[f32; 3]],
        spp: f64,
        watch: &dyn Watch,
    ) -> Result<Option<Values>> {
        let reference_spp = f64::from(self.workload.reference_spp);
        let Some(reference) = self.reference(subject, watch)? else { return Ok(None) };
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
        let [width, height] = self.workload.size;
        ["--filter", "box", "--size", &format!("{width}x{height}"), "--spp", &spp.to_string()]
            .map(String::from)
            .to_vec()
    }

    fn start(&self, subject: &Subject, cold: bool) -> Result<Values> {
        // Mesa's caches: on disk, and the one in memory that goes with the process anyway.
        let variables: &[(&str, &str)] = if cold { &[("MESA_SHADER_CACHE_DISABLE", "true")] } else { &[] };
        let document = self.subprocess.render(&subject.scene.path, &self.arguments(1), variables)?;
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

    fn threads(&mut self, subject: &Subject, one: bool, watch: &dyn Watch) -> Result<Option<Values>> {
        let Some(spp) = self.timed_spp(subject, Case::Default, watch)? else { return Ok(None) };
        let variables: &[(&str, &str)] = if one { &[("LP_NUM_THREADS", "1")] } else { &[] };
        let document = self.subprocess.render(&subject.scene.path, &self.arguments(spp), variables)?;
        Ok(Some(vec![("mpaths_per_second", number(&document, &["paths_per_second"])? / 1e6)]))
    }

    fn peer(&self, subject: &Subject, peer: Peer) -> Result<Values> {
        let workload = self.workload;
        let run = self.peer_run(subject, peer, workload.size, workload.peer_spp, 0)?;
        Ok(vec![("spp", run.spp), ("seconds", run.seconds), ("mpaths_per_second", run.mpaths_per_second)])
    }

    fn peer_error(
        &mut self,
        subject: &Subject,
        peer: Peer,
        seed: u32,
        watch: &mut dyn Watch,
    ) -> Result<Option<Values>> {
        let run = self.peer_run(subject, peer, self.workload.error_size, ERROR_SPP, seed)?;
        let values = self.compared(subject, &run.picture, run.spp, watch)?;
        let ratio = values.iter().flatten().find(|value| value.0 == "mean_to_reference").map_or(1.0, |value| value.1);
        if (ratio - 1.0).abs() > 0.01 {
            let (scene, peer) = (&subject.scene.name, peer.name());
            watch.warn(&format!("{scene}: {peer}'s picture is {ratio:.3} times as bright: not the same scene?"));
        }
        Ok(values)
    }

    fn peer_run(&self, subject: &Subject, peer: Peer, size: [u32; 2], spp: u32, seed: u32) -> Result<PeerRun> {
        let peers = self.peers.as_ref().ok_or_else(|| Error::Internal("a peer that was not asked for".into()))?;
        let max_bounces = Settings::for_scene(&subject.scene).max_bounces;
        peers.render(peer, &subject.scene, size, spp, max_bounces, seed)
    }
}
