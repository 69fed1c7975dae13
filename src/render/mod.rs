//! Stages 4 and 5: the scene on the device, and the frame loop that accumulates samples into a film.
//!
//! Comes in: a checked scene and settings. Goes out: a [`Rendered`], the film with the figures of the render and the ledger
//! of every copy. The stages stand one after another in [`Renderer::new`] and [`Renderer::render`].
//!
//! ```text
//! renderer      the frame loop, from the nouns below
//! device_scene  the scene on the device: upload (records), path_buffers, tile_sums, kernel (pipeline), tiles
//! run           a run over all tiles: pass and slice (what a dispatch works on), work_size (how much), counters
//! stop_policy   when the loop ends: stop (rules and looks)
//! report        what a render tells its caller
//! ```

pub mod bounce_cap;
mod counters;
mod device_scene;
pub mod effects;
pub mod guard;
pub mod kernel;
pub mod pass;
mod path_buffers;
mod renderer;
pub mod report;
mod run;
pub mod slice;
pub mod startup;
pub mod stop;
mod stop_policy;
mod tile_sums;
pub mod tiles;
mod tuning;
pub mod upload;
pub mod work_size;

pub use bounce_cap::CapBias;
pub use device_scene::build_accel;
pub use effects::{Effect, Effects};
pub use guard::Guard;
pub use renderer::Renderer;
pub use report::{Bytes, ErrorReport, Observer, Progress, RenderReport, Rendered, StageSeconds, StopReason};
pub use stop::{Forecast, StopRules, Target, TimeRule};
pub use tuning::{MOST_TILES, Tuning};

pub use crate::settings::{
    AccelKind, Buffers, Hemisphere, Intersector, LightPick, Lights, Roulette, Sampler, Settings,
};

use crate::error::Result;
use crate::gpu::Context;
use crate::scene::Scene;

/// Renders `scene` as `settings` ask, telling `observer` how it goes.
pub fn render(context: &Context, scene: &Scene, settings: &Settings, observer: &mut dyn Observer) -> Result<Rendered> {
    Renderer::new(context, scene, settings, &Tuning::default())?.render(observer)
}
