//! Where the cases run: a device, how much is to be sampled, and perhaps a guard that is out.

use crate::Result;
use crate::gpu::Context;
use crate::interface::BLOCK_SAMPLES;
use crate::render::{Guard, Observer, Progress, Rendered, Renderer, Tuning};
use crate::scene::{Filter, Scene};
use crate::selftest::kit::probe::Probe;
use crate::settings::{Roulette, Sampler, Settings};
use crate::texels::Texel;

/// How much is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tier {
    /// A minute on two cores.
    Fast,
    /// Ten minutes on two cores.
    Full,
}

/// A device under test.
#[derive(Clone, Debug)]
pub struct TestBench {
    context: Context,
    tier: Tier,
    without: Option<Guard>,
}

impl TestBench {
    /// A bench with every guard in place.
    pub fn new(context: &Context, tier: Tier) -> TestBench {
        TestBench { context: context.clone(), tier, without: None }
    }

    /// The same bench with a guard taken out, where something ought to fail.
    pub fn without(&self, guard: Guard) -> TestBench {
        TestBench { without: Some(guard), ..self.clone() }
    }

    /// The device.
    pub fn context(&self) -> &Context {
        &self.context
    }

    /// Whether this guard is in place.
    pub fn has(&self, guard: Guard) -> bool {
        self.without != Some(guard)
    }

    /// How much is sampled.
    pub fn tier(&self) -> Tier {
        self.tier
    }

    /// A number of samples by tier.
    pub fn count(&self, fast: usize, full: usize) -> usize {
        match self.tier {
            Tier::Fast => fast,
            Tier::Full => full,
        }
    }

    /// Runs a probe kernel.
    pub fn probe(&self, probe: Probe) -> Result<Vec<Texel>> {
        Probe { without_guard: self.without, ..probe }.run(&self.context)
    }

    /// Runs a probe kernel several times over the same output, which is zero at first.
    pub fn probe_repeated(&self, probe: Probe, dispatches: u32) -> Result<Vec<Texel>> {
        Probe { without_guard: self.without, ..probe }.run_repeated(&self.context, dispatches)
    }

    /// Renders.
    pub fn render(&self, scene: &Scene, settings: &Settings) -> Result<Rendered> {
        self.render_tuned(scene, settings, &Tuning::default())
    }

    /// Renders with pinned sizes.
    pub fn render_tuned(&self, scene: &Scene, settings: &Settings, tuning: &Tuning) -> Result<Rendered> {
        let tuning = Tuning { without_guard: self.without, ..tuning.clone() };
        Renderer::new(&self.context, scene, settings, &tuning)?.render(&mut Silent)
    }
}

/// Settings for a test: box filter, independent samples, no roulette, as many replicates as blocks (up to 64).
pub fn plain_settings(scene: &Scene, width: u32, height: u32, spp: u32) -> Settings {
    Settings {
        width,
        height,
        spp,
        filter: Filter::Box,
        sampler: Sampler::Independent,
        roulette: Roulette::Off,
        replicates: Some((spp / BLOCK_SAMPLES).clamp(2, 64)),
        ..Settings::for_scene(scene)
    }
}

/// Watches nothing and never stops a render.
pub struct Silent;

impl Observer for Silent {
    fn progress(&mut self, _progress: &Progress) {}

    fn stop_requested(&self) -> bool {
        false
    }
}
