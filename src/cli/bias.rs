//! What the bounce cap cuts off, as the end of a render has it.
//!
//! Comes in: a device, a scene, and how much time there is. Goes out: a [`Bias`]: the estimate, or in words why there
//! is none. The pictures are saved by then, so nothing that goes wrong here can lose them.

use std::time::{Duration, Instant};

use texray::render::{CapBias, Observer, Settings, StageSeconds};
use texray::scene::Scene;

use super::engine::Engine;

/// What is known of the light that longer paths would bring.
pub enum Bias {
    /// Nothing: nobody asked, or a signal came first.
    Unknown,
    /// The estimate.
    Known(CapBias),
    /// Nothing, though it was to be estimated, and why.
    Missing(String),
}

impl Bias {
    /// Estimates it before `ends`, if there is such a time. `seconds` are those of the render, whose set-up takes as
    /// long.
    pub fn estimate(
        engine: &Engine,
        scene: &Scene,
        settings: &Settings,
        ends: Option<Instant>,
        seconds: &StageSeconds,
        observer: &mut dyn Observer,
    ) -> Bias {
        // A small render is set up anew, which nothing can cut short.
        let set_up = Duration::from_secs_f64(seconds.bvh + seconds.upload);
        let late = "the time limit ended before it could be estimated";
        if ends.is_some_and(|ends| Instant::now() + set_up > ends) {
            return Bias::Missing(late.into());
        }
        match engine.cap_bias(scene, settings, ends, observer) {
            Ok(Some(bias)) => Bias::Known(bias),
            Ok(None) if observer.stop_requested() => Bias::Unknown,
            Ok(None) => Bias::Missing(late.into()),
            Err(error) => Bias::Missing(error.to_string()),
        }
    }

    /// The estimate, if there is one.
    pub fn known(&self) -> Option<CapBias> {
        match self {
            Bias::Known(bias) => Some(*bias),
            Bias::Unknown | Bias::Missing(_) => None,
        }
    }

    /// A warning where the estimate is missing.
    pub fn warning(&self) -> Option<String> {
        match self {
            Bias::Missing(why) => Some(format!("warning: what the bounce cap cuts off is not known: {why}")),
            Bias::Known(_) | Bias::Unknown => None,
        }
    }
}
