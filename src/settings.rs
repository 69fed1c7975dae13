//! What a render is asked to do: checked values, from the command line and the scene's defaults. Every stage may read them.

pub use crate::bvh::{Builder, Intersector};
use crate::scene::{Filter, Scene};

/// Settings of a render. Everything here is checked: ranges are those stated at the fields.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Picture width in pixels, 1 to 16384.
    pub width: u32,
    /// Picture height in pixels, 1 to 16384.
    pub height: u32,
    /// Part of the picture to render, `[x, y, width, height]` in pixels, inside the picture and not empty.
    pub crop: Option<[u32; 4]>,
    /// Pixel filter.
    pub filter: Filter,
    /// Samples a pixel, at least 1.
    pub spp: u32,
    /// Surface scatterings a path may have, 1 to 65535.
    pub max_bounces: u32,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Random-number scheme.
    pub sampler: Sampler,
    /// What finds hits.
    pub accel: AccelKind,
    /// Which builder makes the tree.
    pub builder: Builder,
    /// Triangle test.
    pub intersector: Intersector,
    /// How light is gathered.
    pub lights: Lights,
    /// How a light is chosen.
    pub light_pick: LightPick,
    /// How diffuse directions are drawn.
    pub hemisphere: Hemisphere,
    /// Russian roulette.
    pub roulette: Roulette,
    /// How records and path states are read.
    pub buffers: Buffers,
    /// `true`: every effect on, whatever the scene calls for.
    pub all_effects: bool,
    /// Render even where nothing can emit.
    pub allow_black: bool,
    /// Independently scrambled sets of samples that the film keeps apart, at least 2; the error estimate rests on them.
    /// `None`: as many as the film's rule gives a picture of this size.
    pub replicates: Option<u32>,
}

impl Settings {
    /// The defaults for a scene: its size, filter and `[render]` table, and this program's choices for the rest.
    pub fn for_scene(scene: &Scene) -> Settings {
        Settings {
            width: scene.film.width,
            height: scene.film.height,
            crop: None,
            filter: scene.film.filter,
            spp: scene.render.spp.unwrap_or(256),
            max_bounces: scene.render.max_bounces.unwrap_or(8),
            seed: 0,
            sampler: Sampler::default(),
            accel: AccelKind::default(),
            builder: Builder::default(),
            intersector: Intersector::default(),
            lights: Lights::default(),
            light_pick: LightPick::for_lights(scene.emissive_triangles()),
            hemisphere: Hemisphere::default(),
            roulette: Roulette::default(),
            buffers: Buffers::default(),
            all_effects: false,
            allow_black: false,
            replicates: None,
        }
    }

    /// How a light is chosen; without light samples nothing asks for a tree, so there is none.
    pub fn effective_light_pick(&self) -> LightPick {
        match (self.lights, self.light_pick) {
            (Lights::Bsdf, LightPick::Tree) => LightPick::Power,
            (_, pick) => pick,
        }
    }

    /// The part of the picture that is rendered, `[x, y, width, height]` in pixels.
    pub fn region(&self) -> [u32; 4] {
        self.crop.unwrap_or([0, 0, self.width, self.height])
    }
}

/// Random-number scheme.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sampler {
    /// Shuffled, Owen-scrambled Sobol' points in padded pairs of dimensions.
    #[default]
    Sobol,
    /// Independent numbers by a hash.
    Independent,
    /// Numbers made by the host and read from a table, as in the thesis; the table wraps around.
    Table,
}

impl Sampler {
    /// Power of the number of samples that the squared error falls with, which forecasts go by: 1 for independent samples. For
    /// Sobol' points it is what scenes showed (`docs/accuracy.md`), which no theorem gives for pictures with edges.
    pub fn convergence(self) -> f64 {
        match self {
            Sampler::Sobol => 1.1,
            Sampler::Independent | Sampler::Table => 1.0,
        }
    }
}

/// What finds hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum AccelKind {
    /// Compressed 8-wide tree.
    #[default]
    Wide,
    /// Binary tree.
    Binary,
    /// No tree.
    Brute,
}

/// How light is gathered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Lights {
    /// Next-event estimation and BSDF sampling, combined by the power heuristic.
    #[default]
    Mis,
    /// Next-event estimation only.
    Area,
    /// BSDF sampling only.
    Bsdf,
}

/// How a light is chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LightPick {
    /// In proportion to emitted power, with a floor so that no light starves.
    #[default]
    Power,
    /// In proportion to area, as in the thesis.
    Area,
    /// By what each may contribute to the point that is lit: a descent of a tree over the lights.
    Tree,
}

/// From as many emissive triangles on, a light is chosen by the light tree; measured in docs/performance.md.
const TREE_FROM_LIGHTS: usize = 16;

impl LightPick {
    /// The default for as many emissive triangles.
    pub fn for_lights(lights: usize) -> LightPick {
        if lights >= TREE_FROM_LIGHTS { LightPick::Tree } else { LightPick::Power }
    }
}

/// How diffuse directions are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Hemisphere {
    /// In proportion to the cosine.
    #[default]
    Cosine,
    /// Uniformly.
    Uniform,
}

/// Russian roulette.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Roulette {
    /// Survive with five times the largest throughput for probability, kept within [0.05, 1].
    #[default]
    Throughput,
    /// None.
    Off,
    /// Survive with this fixed probability, 0.001 to 1, from the first bounce on (the thesis's).
    Fixed(f32),
}

/// How a kernel reads records and path states.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Buffers {
    /// Uniform texel buffers.
    #[default]
    Texel,
    /// Storage buffers.
    Storage,
}
