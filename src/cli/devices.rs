//! `texray devices`: what there is to render on.

use clap::Args;
use serde::Serialize;
use texray::Result;

use super::engine::{self, DeviceLine};
use super::{Outcome, streams};

/// List the Vulkan devices, numbered as --device takes them, with the limits that matter
#[derive(Args)]
pub struct DevicesArgs {
    /// Print one JSON document with all that is known of them on stdout
    #[arg(long)]
    json: bool,
    /// Also run the start-up probe on each usable device and print what it found (--json always does)
    #[arg(short, long)]
    verbose: bool,
}

#[derive(Serialize)]
struct Document {
    schema: u32,
    devices: Vec<DeviceLine>,
}

impl DevicesArgs {
    /// Lists them on stdout.
    pub fn run(&self) -> Result<Outcome> {
        let devices = engine::devices(self.json || self.verbose)?;
        if self.json {
            streams::answer_json(&Document { schema: 1, devices })?;
            return Ok(Outcome::Done);
        }
        let mut lines = Vec::new();
        for device in devices {
            lines.push(match device.lacks {
                Some(lacks) => format!("{}  (cannot be used: {lacks})", device.summary),
                None => device.summary,
            });
            lines.extend(device.limits);
            for probe in device.startup.into_iter().flatten() {
                let verdict = if probe.passes { "" } else { "; FAILED: this device is refused" };
                let line = format!("   probe: {:<20} {}; expected {}{verdict}", probe.what, probe.got, probe.expected);
                lines.push(streams::folded(&line, 31));
            }
            lines.extend(device.startup_error.map(|error| streams::folded(&format!("   probe: {error}"), 10)));
        }
        streams::answer(&lines.join("\n"))?;
        Ok(Outcome::Done)
    }
}
