//! The library as the commands use it: list, explain, render, self-test.
//!
//! Comes in: checked requests. Goes out: what the library answers, in the commands' words. Everything the commands need
//! of `gpu` and of the renderer goes through here.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::time::Instant;

use serde::Serialize;
use texray::film::Film;
use texray::gpu::{self, Context, ContextOptions, DeviceChoice, DeviceInfo};
use texray::render::bounce_cap::cap_bias;
use texray::render::startup;
use texray::render::{CapBias, Effects, Observer, RenderReport, Renderer, Settings, StopRules, Tuning};
use texray::scene::Scene;
use texray::selftest;
use texray::selftest::{Case, CaseReport, TestBench, Tier};
use texray::statistics::Finding;
use texray::study::{self, Ended, Kind, Plan, Rows, Watch};
use texray::{Error, Result};

use super::limits;

/// What a user is told of a device.
#[derive(Clone, Debug, Serialize)]
pub struct DeviceLine {
    /// Number for `--device`.
    pub index: usize,
    /// Name by the driver.
    pub name: String,
    /// Driver and its version.
    pub driver: String,
    /// One line about it.
    pub summary: String,
    /// The limits that matter, a line each.
    #[serde(skip)]
    pub limits: Vec<String>,
    /// Everything else that is known, for `--json`.
    pub details: serde_json::Value,
    /// What it lacks to be used, if anything.
    pub lacks: Option<String>,
    /// What the start-up probe found, where it was asked for.
    pub startup: Option<Vec<Finding>>,
    /// Why the start-up probe could not be run.
    pub startup_error: Option<String>,
}

impl DeviceLine {
    fn of(info: &DeviceInfo) -> Result<DeviceLine> {
        Ok(DeviceLine {
            index: info.index,
            name: info.name.clone(),
            driver: info.driver.clone(),
            summary: info.summary(),
            limits: limits::lines(info),
            details: to_json(info)?,
            lacks: info.lacks.clone(),
            startup: None,
            startup_error: None,
        })
    }

    /// Opens the device and asks it what every render asks first. A device that cannot answer says why; the others are
    /// listed all the same.
    fn probe(&mut self) {
        if self.lacks.is_none() {
            let device = DeviceChoice::Index(self.index);
            let context = Context::new(&ContextOptions { device, validation: false });
            match context.and_then(|context| startup::probe(&context)) {
                Ok(findings) => self.startup = Some(findings.to_vec()),
                Err(error) => self.startup_error = Some(error.to_string()),
            }
        }
    }
}

/// A finished render.
pub struct FinishedRender {
    /// What was accumulated.
    pub film: Film,
    /// Figures.
    pub report: RenderReport,
    /// Every transfer, for `--ledger`.
    pub ledger: serde_json::Value,
    /// The same as a table.
    pub ledger_table: String,
    /// What validation complained about; empty without `--validation`.
    pub validation: Vec<String>,
}

/// A device, open.
pub struct Engine {
    context: Context,
    device: DeviceLine,
}

/// Every Vulkan device, usable or not; `probed`: with what the start-up probe finds.
pub fn devices(probed: bool) -> Result<Vec<DeviceLine>> {
    let mut devices: Vec<_> = gpu::list_devices()?.iter().map(DeviceLine::of).collect::<Result<_>>()?;
    if probed {
        devices.iter_mut().for_each(DeviceLine::probe);
    }
    Ok(devices)
}

/// Every effect, on or off, with the reason.
pub fn effects(scene: &Scene, settings: &Settings) -> Effects {
    Effects::of(scene, settings)
}

impl Engine {
    /// Opens the device of that number or name; `None`: the best one.
    pub fn open(device: Option<&str>, validation: bool) -> Result<Engine> {
        let device = match device {
            None => DeviceChoice::Auto,
            Some(text) => text.parse().map_or_else(|_| DeviceChoice::Name(text.to_owned()), DeviceChoice::Index),
        };
        let context = Context::new(&ContextOptions { device, validation })?;
        let device = DeviceLine::of(context.device_info())?;
        Ok(Engine { context, device })
    }

    /// The device.
    pub fn device(&self) -> &DeviceLine {
        &self.device
    }

    /// Runs one hard case.
    pub fn run_case(&self, tier: Tier, case: &'static Case) -> CaseReport {
        selftest::run_case(&TestBench::new(&self.context, tier), case)
    }

    /// A hash of the path tracer's kernel, the same from run to run.
    pub fn kernel_hash(&self) -> String {
        let mut hasher = DefaultHasher::new();
        gpu::shaders::PATH_TRACE_KEEP_NAN.words().hash(&mut hasher);
        format!("{:016x}", hasher.finish())
    }

    /// Measures what the rows lack, on a device that passes the start-up probe.
    pub fn study(&self, kind: &Kind, plan: &Plan, rows: &mut Rows, watch: &mut dyn Watch) -> Result<Ended> {
        startup::check(&self.context)?;
        let mut study = kind.open(&self.context, plan, watch)?;
        study::run(study.as_mut(), rows, watch)
    }

    /// What validation has complained about so far.
    pub fn validation(&self) -> Vec<String> {
        self.context.validation().messages
    }

    /// What the bounce cap cuts off; `None` where the observer stopped it, or it would not have ended before `ends`.
    pub fn cap_bias(
        &self,
        scene: &Scene,
        settings: &Settings,
        ends: Option<Instant>,
        observer: &mut dyn Observer,
    ) -> Result<Option<CapBias>> {
        cap_bias(&self.context, scene, settings, ends, observer)
    }

    /// Renders until a rule ends it.
    pub fn render(
        &self,
        scene: &Scene,
        settings: &Settings,
        rules: StopRules,
        observer: &mut dyn Observer,
    ) -> Result<FinishedRender> {
        let renderer = Renderer::new(&self.context, scene, settings, &Tuning::default())?;
        let rendered = renderer.stop_by(rules).render(observer)?;
        Ok(FinishedRender {
            film: rendered.film,
            report: rendered.report,
            ledger: to_json(&rendered.ledger)?,
            ledger_table: rendered.ledger.table(),
            validation: self.validation(),
        })
    }
}

fn to_json(value: &impl Serialize) -> Result<serde_json::Value> {
    serde_json::to_value(value).map_err(|error| Error::Internal(format!("a report that is not JSON: {error}")))
}
