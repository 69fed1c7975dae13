//! Stages 4 and 5: the scene on the device, and the frame loop that accumulates samples into a film.
//!
//! Comes in: a checked scene and settings. Goes out: a [`Rendered`], the film with the figures of the render and the ledger
//! of every copy. The stages stand one after another in [`Renderer::new`] and [`Renderer::render`].

pub mod bounce_cap;
pub mod effects;
mod ending;
pub mod frames;
pub mod guard;
pub mod kernel;
pub mod pace;
pub mod pass;
mod path_buffers;
pub mod report;
mod setup;
pub mod startup;
pub mod stop;
pub mod tiles;
mod tuning;
pub mod upload;

pub use bounce_cap::CapBias;
pub use effects::{Effect, Effects};
pub use frames::Renderer;
pub use guard::Guard;
pub use report::{Bytes, ErrorReport, Observer, Progress, RenderReport, StageSeconds, StopReason};
pub use stop::{Forecast, StopRules, Target, TimeRule};
pub use tuning::{MOST_TILES, Tuning};

pub use crate::settings::{
    AccelKind, Buffers, Hemisphere, Intersector, LightPick, Lights, Roulette, Sampler, Settings,
};

use crate::bvh::{Accel, BinaryBvh, WideBvh};
use crate::error::Result;
use crate::film::Film;
use crate::gpu::{Context, Ledger};
use crate::scene::Scene;

/// A finished render.
pub struct Rendered {
    /// The film: sums in scaled radiance, from which picture and error are read.
    pub film: Film,
    /// Figures of the render.
    pub report: RenderReport,
    /// Every copy between CPU and GPU.
    pub ledger: Ledger,
    /// The effects that were on, and why.
    pub effects: Effects,
}

/// Renders `scene` as `settings` ask, telling `observer` how it goes.
pub fn render(context: &Context, scene: &Scene, settings: &Settings, observer: &mut dyn Observer) -> Result<Rendered> {
    Renderer::new(context, scene, settings, &Tuning::default())?.render(observer)
}

/// The tree, or its absence, that the settings ask for.
pub fn build_accel(scene: &Scene, settings: &Settings) -> Accel {
    match settings.accel {
        AccelKind::Brute => Accel::Brute,
        AccelKind::Binary => Accel::Binary(BinaryBvh::build(&scene.triangles, settings.builder)),
        AccelKind::Wide => Accel::Wide(WideBvh::build(&scene.triangles, settings.builder)),
    }
}
