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
        let mut lines = Vec::new();
        for device in devices {
            lines.push(match device.lacks {
                Some(lacks) => format!("{}  (cannot be used: {lacks})", device.summary),
                None => device.summary,
            });
            lines.extend(device.limits);
        }
        streams::answer(&lines.join("\n"))?;
        Ok(Outcome::Done)
    }
}
