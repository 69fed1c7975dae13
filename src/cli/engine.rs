//! The library as the commands use it: load, list, explain, render.
//!
//! Comes in: checked requests. Goes out: what the library answers, in the commands' words. Everything the commands need
//! of `scene`, `gpu` and `render` goes through here.

use std::path::Path;

use serde::Serialize;
use texray::film::Film;
use texray::render::{Observer, RenderReport, Settings};
use texray::scene::Scene;
use texray::{Error, Result};

/// One line of the list of effects.
#[derive(Clone, Debug, Serialize)]
pub struct EffectLine {
    /// The effect's name.
    pub name: String,
    /// Whether it is compiled in.
    pub on: bool,
    /// Why it is on, or off.
    pub reason: String,
}

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
    /// Everything else that is known, for `--json`.
    pub details: serde_json::Value,
    /// What it lacks to be used, if anything.
    pub lacks: Option<String>,
}

/// A finished render.
pub struct Rendered {
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
    device: DeviceLine,
}

/// Loads and checks a scene.
pub fn load(path: &Path) -> Result<Scene> {
    Err(Error::scene(path, 0, NOT_JOINED))
}

/// Refuses a scene in which nothing can emit.
pub fn check_emits(scene: &Scene) -> Result<()> {
    Err(Error::scene(&scene.path, 0, NOT_JOINED))
}

/// Every Vulkan device, usable or not.
pub fn devices() -> Result<Vec<DeviceLine>> {
    Err(Error::NoDevice(NOT_JOINED.into()))
}

/// Every effect, on or off, with the reason.
pub fn effects(_scene: &Scene, _settings: &Settings) -> Vec<EffectLine> {
    Vec::new()
}

impl Engine {
    /// Opens the device of that number or name; `None`: the best one.
    pub fn open(_device: Option<&str>, _validation: bool) -> Result<Engine> {
        Err(Error::NoDevice(NOT_JOINED.into()))
    }

    /// The device.
    pub fn device(&self) -> &DeviceLine {
        &self.device
    }

    /// Renders.
    pub fn render(&self, _scene: &Scene, _settings: &Settings, _observer: &mut dyn Observer) -> Result<Rendered> {
        Err(Error::Internal(NOT_JOINED.into()))
    }
}

const NOT_JOINED: &str = "this part of texray is not joined to the command line yet";
