//! Effects: the least set that a scene calls for, each with the reason it is on.
//!
//! Comes in: a scene and settings. Goes out: the values of the effect specialisation constants. An effect that is off leaves
//! neither code nor buffers behind; the picture is the same bit for bit as with every effect on.

use std::fmt;

pub use crate::interface::EFFECT_NAMES;
use crate::interface::{EffectKind, NO_INDEX};
use crate::named::Named;
use crate::quote::shown;
use crate::scene::{Filter, Material, MaterialKind, Scene};
use crate::settings::Settings;

/// Whether an effect is on, and why.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Effect {
    /// Name, one of [`EFFECT_NAMES`].
    pub name: &'static str,
    /// Whether the kernel contains it.
    pub on: bool,
    /// What in the scene calls for it, or that nothing does.
    pub reason: String,
}

/// The effects of a render, one of each.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Effects(Vec<Effect>);

impl Effects {
    /// The least set of effects that gives the scene's picture; all of them where the settings ask for that.
    pub fn of(scene: &Scene, settings: &Settings) -> Effects {
        let counts = triangles_by_material(scene);
        let effect = |&kind: &EffectKind| {
            let name = EFFECT_NAMES[kind as usize];
            match reason(kind, scene, settings, &counts) {
                Some(reason) => Effect { name, on: true, reason },
                None if settings.all_effects => Effect { name, on: true, reason: "asked for by --effects all".into() },
                None => Effect { name, on: false, reason: "nothing calls for it".into() },
            }
        };
        Effects(EffectKind::ALL.iter().map(effect).collect())
    }

    /// Every effect with its state and reason.
    pub fn iter(&self) -> impl Iterator<Item = &Effect> {
        self.0.iter()
    }

    /// Names of the effects that are on.
    pub fn names(&self) -> Vec<&'static str> {
        self.iter().filter(|effect| effect.on).map(|effect| effect.name).collect()
    }

    /// Whether the effect with number `effect` (an `interface::EFFECT_*`) is on; a number that no effect has is not.
    pub fn is_on(&self, effect: u32) -> bool {
        self.0.get(effect as usize).is_some_and(|effect| effect.on)
    }

    /// The same set with one effect taken out, for the control of the test that the least set suffices: the picture must
    /// change where the scene calls for it.
    pub fn without(mut self, effect: u32) -> Effects {
        if let Some(effect) = self.0.get_mut(effect as usize) {
            effect.on = false;
            effect.reason = "taken out".into();
        }
        self
    }

    /// The same set with one effect more, for the study of what an effect costs where nothing calls for it; the picture stays.
    pub fn with(mut self, effect: u32) -> Effects {
        if let Some(effect) = self.0.get_mut(effect as usize).filter(|effect| !effect.on) {
            effect.on = true;
            effect.reason = "put in".into();
        }
        self
    }
}

impl fmt::Display for Effects {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for effect in self.iter() {
            writeln!(f, "{:<15} {:<4} {}", effect.name, if effect.on { "on" } else { "off" }, effect.reason)?;
        }
        Ok(())
    }
}

/// What calls for an effect, if anything does; `counts` are the triangles of each material.
fn reason(effect: EffectKind, scene: &Scene, settings: &Settings, counts: &[usize]) -> Option<String> {
    let by_material = |noun: &str, wanted: &dyn Fn(&Material) -> bool| {
        let (index, material) = (0..).zip(&scene.materials).find(|(i, m)| counts[*i] > 0 && wanted(m))?;
        Some(format!("{noun}: material `{}`, {}", shown(&material.name), triangles(counts[index])))
    };
    match effect {
        EffectKind::Emitters => by_material("emission", &Material::emits),
        EffectKind::Sky => {
            scene.sky.filter(|sky| sky.iter().any(|&c| c > 0.0)).map(|_| "the scene has an environment".into())
        }
        EffectKind::Mirror => by_material("mirror", &|m| matches!(m.kind, MaterialKind::Mirror { .. })),
        EffectKind::Glass => by_material("glass", &|m| matches!(m.kind, MaterialKind::Glass { .. })),
        EffectKind::SmoothNormals => {
            let smooth = scene.triangles.iter().filter(|t| t.corners != NO_INDEX).count();
            (smooth > 0).then(|| format!("vertex normals: {}", triangles(smooth)))
        }
        EffectKind::PixelFilter => {
            (settings.filter != Filter::Box).then(|| format!("filter `{}`", settings.filter.name()))
        }
    }
}

fn triangles_by_material(scene: &Scene) -> Vec<usize> {
    let mut counts = vec![0; scene.materials.len()];
    for triangle in &scene.triangles {
        // A material that is not there is refused when the scene is packed.
        if let Some(count) = counts.get_mut(triangle.material as usize) {
            *count += 1;
        }
    }
    counts
}

fn triangles(count: usize) -> String {
    format!("{count} triangle{}", if count == 1 { "" } else { "s" })
}
