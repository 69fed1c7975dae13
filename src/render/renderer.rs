//! Stage 5: the frame loop, a run at a time.
//!
//! Comes in: a checked scene and settings, then who watches. Goes out: after each run a film that can be looked at, and
//! at the end a [`Rendered`]. When a run is whole its sums enter the film, as a closed block or as the open one. So
//! every run boundary is a valid place to stop. [`Renderer::render`] goes to the end; whoever wants to do something
//! between two runs, as a window does, calls [`Renderer::step`].

use std::time::Instant;

use crate::error::Result;
use crate::film::{Film, replicate_of_block};
use crate::gpu::{Context, Ledger};
use crate::interface::{BLOCK_SAMPLES, PAIRS_PER_BOUNCE, RANDOM_TABLE_TEXELS};
use crate::render::device_scene::DeviceScene;
use crate::render::report::{Bytes, Observer, Progress, RenderReport, Rendered, StageSeconds, StopReason};
use crate::render::run::{Run, RunResult};
use crate::render::stop::StopRules;
use crate::render::stop_policy::StopPolicy;
use crate::render::tuning::Tuning;
use crate::scene::{Camera, Scene};
use crate::settings::{Sampler, Settings};

/// A scene on the device with the picture that is being rendered of it.
pub struct Renderer {
    context: Context,
    settings: Settings,
    scene: DeviceScene,
    run: Run,
    policy: StopPolicy,
    film: Film,
    report: RenderReport,
    ledger: Ledger,
    /// The first dispatch.
    started: Option<Instant>,
    /// Why the render has ended, if it has.
    ended: Option<StopReason>,
}

impl Renderer {
    /// Builds the tree, packs and copies the records, and makes the pipeline.
    pub fn new(context: &Context, scene: &Scene, settings: &Settings, tuning: &Tuning) -> Result<Renderer> {
        settings.check()?;
        let region = settings.region();
        let [_, _, width, height] = region;
        tuning.check([width, height])?;
        if !settings.allow_black {
            scene.check_emits()?;
        }
        let (mut seconds, mut ledger) = (StageSeconds::default(), Ledger::default());
        let pixels = u64::from(settings.width) * u64::from(settings.height);
        let replicates = settings.replicates.unwrap_or_else(|| Film::replicates(pixels));
        let run = Run::new(context.device_info(), region, tuning)?;
        let film = Film::new(width, height, replicates, scene.scaling.radiance_exponent)?;
        let scene = DeviceScene::new(context, scene, settings, tuning, replicates, &mut seconds, &mut ledger)?;
        Ok(Renderer {
            context: context.clone(),
            settings: settings.clone(),
            report: RenderReport::of_nothing(&scene.effects, seconds, scene.read_as, scene.tree.clone()),
            scene,
            run,
            policy: StopPolicy::new(settings, tuning),
            film,
            ledger,
            started: None,
            ended: None,
        })
    }

    /// Ends the render by these rules too.
    pub fn stop_by(mut self, rules: StopRules) -> Renderer {
        self.policy.rules = rules;
        self
    }

    /// Renders until the samples are done, a rule is met or the observer stops it, after the first whole run at the
    /// earliest.
    pub fn render(mut self, observer: &mut dyn Observer) -> Result<Rendered> {
        while self.step(observer)?.is_none() {}
        Ok(self.finish())
    }

    /// Renders one run, which is in the film then; why the render has ended, if it has. The first run is of one sample,
    /// so that there is a picture soon, later ones as long as ten seconds allow. The observer is told how it goes, and
    /// may stop the run: then the film has what the run before left. An error ends the render there, too.
    pub fn step(&mut self, observer: &mut dyn Observer) -> Result<Option<StopReason>> {
        if self.ended.is_none() {
            self.policy.check()?;
            let started = *self.started.get_or_insert_with(Instant::now);
            // A run that failed has left sums on the device that no other run can go on with.
            let ended = self.one_run(started, observer).inspect_err(|_| self.ended = Some(StopReason::Interrupted))?;
            self.ended = ended;
        }
        Ok(self.ended)
    }

    fn one_run(&mut self, started: Instant, observer: &mut dyn Observer) -> Result<Option<StopReason>> {
        let (done, run_start) = (self.report.spp, Instant::now());
        let Some(samples) = self.policy.next_run(done) else {
            return Ok(Some(StopReason::TimeLimit));
        };
        let (policy, report, pixels) = (&self.policy, &self.report, self.film.pixels());
        // What the run has already paid for in full is kept.
        let mut gives_up = |paths: u64, whole: bool| {
            observer.progress(&progress(policy, report, pixels, started, paths));
            policy.may_give_up(done) && !whole && policy.is_given_up(observer)
        };
        let run = self.run.trace(&mut self.scene, &mut self.ledger, [done, samples], &mut gives_up)?;
        let Some(result) = run else {
            return Ok(Some(self.policy.why_given_up(observer)));
        };
        commit(&mut self.film, &mut self.report, result, [done, samples])?;
        self.policy.note_run(samples, run_start.elapsed());
        let met = self.policy.look(&self.film, self.report.spp, started.elapsed());
        self.policy.tell(&mut self.report);
        observer.progress(&progress(&self.policy, &self.report, pixels, started, 0));
        Ok(if met {
            Some(StopReason::TargetError)
        } else if self.policy.is_done(self.report.spp) {
            Some(StopReason::Spp)
        } else {
            observer.stop_requested().then_some(StopReason::Interrupted)
        })
    }

    /// The film so far: what every whole run has brought. It can be looked at between two steps.
    pub fn film(&self) -> &Film {
        &self.film
    }

    /// Figures of the render so far.
    pub fn report(&self) -> &RenderReport {
        &self.report
    }

    /// Every copy between CPU and GPU for this picture.
    pub fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// Begins another picture of the scene, seen by this camera (in scaled units, as [`Scene::camera`] is). Nothing but
    /// the camera is copied to the device again. The film is empty then; report and ledger are of the new picture, with
    /// the seconds that setting up the scene has taken. A camera without a direction gives invalid samples of the cause
    /// `camera`.
    pub fn set_camera(&mut self, camera: &Camera) -> Result<()> {
        self.ledger = Ledger::default();
        self.film.clear();
        self.policy.restart();
        let StageSeconds { bvh, upload, pipeline, .. } = self.report.seconds;
        let seconds = StageSeconds { bvh, upload, pipeline, ..StageSeconds::default() };
        let scene = &self.scene;
        self.report = RenderReport::of_nothing(&scene.effects, seconds, scene.read_as, scene.tree.clone());
        (self.started, self.ended) = (None, None);
        self.scene.set_camera(camera, &self.settings, &mut self.ledger)
    }

    /// Ends the render where it is, with a last look at the error. It was interrupted, unless it has ended by itself.
    pub fn finish(mut self) -> Rendered {
        let spp = self.report.spp;
        self.policy.last_look(&self.film, spp);
        self.policy.tell(&mut self.report);
        self.report.stop_reason = self.ended.unwrap_or(StopReason::Interrupted);
        self.report.table_wraps = self.table_wraps(spp);
        self.report.seconds.render = self.started.map_or(0.0, |started| started.elapsed().as_secs_f64());
        self.report.bytes = Bytes {
            uploaded: self.ledger.bytes_up(),
            read_back: self.ledger.bytes_down(),
            device: self.context.device_bytes_peak(),
        };
        Rendered { film: self.film, report: self.report, ledger: self.ledger, effects: self.scene.effects }
    }

    /// Times that a pixel's samples went around the table of random numbers.
    fn table_wraps(&self, spp: u32) -> u64 {
        let stride = u64::from((PAIRS_PER_BOUNCE * (1 + self.settings.max_bounces)) | 1);
        match self.settings.sampler {
            Sampler::Table => u64::from(spp) * stride / u64::from(RANDOM_TABLE_TEXELS),
            _ => 0,
        }
    }
}

/// Enters a whole run into the film, and its counts into the report: what a stop throws away is not reported.
fn commit(film: &mut Film, report: &mut RenderReport, run: RunResult<'_>, [first, samples]: [u32; 2]) -> Result<()> {
    let start = Instant::now();
    report.add(&run.counts);
    let end = first + samples;
    let replicate = replicate_of_block(first / BLOCK_SAMPLES, film.replicate_count());
    let whole = [0, 0, film.width(), film.height()];
    if end.is_multiple_of(BLOCK_SAMPLES) {
        film.add_block(replicate, whole, run.sums)?;
    } else {
        film.set_open(replicate, whole, run.sums)?;
    }
    report.spp = end;
    report.seconds.readback += run.readback_seconds + start.elapsed().as_secs_f64();
    Ok(())
}

/// How a render goes where the run so far has ended `paths` paths.
fn progress(policy: &StopPolicy, report: &RenderReport, pixels: usize, started: Instant, paths: u64) -> Progress {
    let (pixels, spp_target) = (pixels as f64, policy.spp_target());
    let all = pixels * f64::from(spp_target);
    let share = (pixels * f64::from(report.spp) + paths as f64) / all;
    Progress {
        spp_done: report.spp,
        spp_target,
        fraction: share.max(policy.time_share(started)).min(1.0),
        paths: report.paths + paths,
        seconds: started.elapsed().as_secs_f64(),
        relative_rmse: report.relative_rmse,
        target: policy.target(),
    }
}
