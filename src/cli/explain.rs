//! `texray explain SCENE`: which effects a scene calls for, and why.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;
use texray::Result;
use texray::named::Named;
use texray::render::{Effect, LightPick};
use texray::scene::{Filter, Scene};

use super::engine;
use super::settings::{EffectsChoice, SettingsArgs};
use super::{Outcome, choices, streams};

/// Print the effects that a scene calls for, each with the reason
#[derive(Args)]
pub struct ExplainArgs {
    /// The scene: a .toml scene or a bare .obj
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// Pixel filter [default: the scene's, else blackman-harris]
    #[arg(long, value_parser = choices::of::<Filter>())]
    filter: Option<Filter>,
    /// Effects compiled into the kernel
    #[arg(long, value_enum, default_value_t)]
    effects: EffectsChoice,
    /// Exit with code 3 if loading warns of anything
    #[arg(long)]
    deny_warnings: bool,
    /// Print one JSON document on stdout instead of a table
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Document {
    schema: u32,
    scene: String,
    triangles: usize,
    effects: Vec<Effect>,
    emissive_triangles: usize,
    light_pick: LightPick,
}

impl ExplainArgs {
    /// Prints set and reasons on stdout.
    pub fn run(&self) -> Result<Outcome> {
        let scene = Scene::load(&self.scene)?;
        streams::tell_loading(&scene.report, self.deny_warnings, false);
        if self.deny_warnings {
            scene.deny_warnings()?;
        }
        let arguments = SettingsArgs::of_effects(self.filter, self.effects);
        let settings = arguments.settings(&scene)?;
        let effects: Vec<_> = engine::effects(&scene, &settings).iter().cloned().collect();
        let (emissive_triangles, light_pick) = (scene.emissive_triangles(), settings.light_pick);
        if self.json {
            let document = Document {
                schema: 1,
                scene: scene.name.clone(),
                triangles: scene.triangles.len(),
                effects,
                emissive_triangles,
                light_pick,
            };
            streams::answer_json(&document)?;
            return Ok(Outcome::Done);
        }
        let mut lines = table(&effects);
        lines.push(format!("light pick: {}, for {emissive_triangles} emissive triangles", light_pick.name()));
        streams::answer(&lines.join("\n"))?;
        Ok(Outcome::Done)
    }
}

/// One line an effect: name, on or off, reason.
pub fn table(effects: &[Effect]) -> Vec<String> {
    let width = effects.iter().map(|effect| effect.name.len()).max().unwrap_or(0);
    let line = |effect: &Effect| {
        format!("{:width$}  {:3}  {}", effect.name, if effect.on { "on" } else { "off" }, effect.reason)
    };
    effects.iter().map(line).collect()
}
