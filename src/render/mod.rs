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
pub mod stop;
pub mod tiles;
pub mod upload;

pub use bounce_cap::CapBias;
pub use effects::{Effect, Effects};
pub use frames::Renderer;
pub use guard::Guard;
pub use report::{Bytes, ErrorReport, Observer, Progress, RenderReport, StageSeconds, StopReason};
pub use stop::{Forecast, StopRules, Target, TimeRule};

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

/// Sizes that no picture depends on: they trade memory, speed and responsiveness. Tests pin them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tuning {
    /// Tile size in pixels; otherwise the largest that fits.
    pub tile: Option<[u32; 2]>,
    /// Step budget of an invocation in a dispatch, 64 to 8191, less on a CPU whose vectors have more than 8 lanes; otherwise by the
    /// clock.
    pub budget: Option<u32>,
    /// Samples of a run, 1 to 16; otherwise by the clock.
    pub run_samples: Option<u32>,
    /// Lanes refill when fewer than this many eighths of them still trace, 0 to 8.
    pub refill_eighths: Option<u32>,
    /// Pixels of a submit (render/pass.rs rounds them); otherwise by the clock.
    pub slice_pixels: Option<u32>,
    /// Paths are left for the next pass when fewer than this many eighths of the lanes have samples left, 0 to 8.
    pub leave_eighths: Option<u32>,
    /// Triangles tested between two node visits, 1 or 2, or 0 for all of them; otherwise by the tree.
    pub tests_a_visit: Option<u32>,
    /// How path states are read, where they fit; otherwise as the settings say.
    pub path_buffers: Option<Buffers>,
    /// An effect (`interface::EFFECT_*`) to leave out though the scene calls for it: the control of the effects test.
    pub without_effect: Option<u32>,
    /// An effect to have though nothing calls for it: what its code alone costs.
    pub with_effect: Option<u32>,
    /// The module that leaves NaN to the driver, though the device can be asked to keep it.
    pub nan_by_driver: bool,
    /// A guard to leave out, to show what it is for. Unlike the sizes above, it changes pictures.
    pub without_guard: Option<Guard>,
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
