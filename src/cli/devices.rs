//! `texray devices`: what there is to render on.

use clap::Args;
use serde::Serialize;
use texray::Result;

use super::engine::{self, DeviceLine};
use super::{Outcome, streams};

/// List the Vulkan devices with the numbers and names that --device takes
#[derive(Args)]
pub struct DevicesArgs {
    /// Print one JSON document with all that is known of them on stdout
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Document {
    schema: u32,
    devices: Vec<DeviceLine>,
}

impl DevicesArgs {
    /// Lists them on stdout.
    pub fn run(&self) -> Result<Outcome> {
        let devices = engine::devices()?;
        if self.json {
            streams::answer_json(&Document { schema: 1, devices })?;
            return Ok(Outcome::Done);
        }
        let lines = devices.iter().map(|device| match &device.lacks {
            Some(lacks) => format!("{}  (cannot be used: {lacks})", device.summary),
            None => device.summary.clone(),
        });
        streams::answer(&lines.collect::<Vec<_>>().join("\n"))?;
        Ok(Outcome::Done)
    }
}
