//! What a render is asked to do: values from the command line and the scene's defaults. Every stage may read them.
//!
//! Goes out: settings that [`Settings::check`] has passed, since the renderer and the estimate of the bounce cap ask
//! it first.

pub use crate::bvh::{Builder, Intersector};
pub use crate::interface::{MAX_BOUNCES, MAX_REPLICATES, MAX_SIDE};
use crate::named::named;
use crate::scene::{Filter, Scene};
use crate::{Error, Result};

/// Settings of a render. Ranges are those stated at the fields.
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
    /// Independently scrambled sets of samples that the film keeps apart, 2 to 256; the error estimate rests on them.
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

    /// Refuses what is out of the range that its field states.
    pub fn check(&self) -> Result<()> {
        in_range("width", self.width, 1, MAX_SIDE)?;
        in_range("height", self.height, 1, MAX_SIDE)?;
        in_range("spp", self.spp, 1, u32::MAX)?;
        in_range("max_bounces", self.max_bounces, 1, MAX_BOUNCES)?;
        if let Some(replicates) = self.replicates {
            in_range("replicates", replicates, 2, MAX_REPLICATES)?;
        }
        if let Some([x, y, width, height]) = self.crop {
            let inside =
                |first: u32, count: u32, all: u32| count > 0 && first.checked_add(count).is_some_and(|end| end <= all);
            if !inside(x, width, self.width) || !inside(y, height, self.height) {
                return Err(Error::Usage(format!(
                    "crop {x},{y},{width},{height} (x, y, width, height) must be 1 pixel or more inside the \
                     picture of {}x{}",
                    self.width, self.height
                )));
            }
        }
        match self.roulette {
            // Also what is not a number.
            Roulette::Fixed(p) if !(0.001..=1.0).contains(&p) => {
                Err(Error::Usage(format!("roulette {p} is out of range: 0.001 to 1 is allowed")))
            }
            _ => Ok(()),
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

/// Refuses a `value` of the setting `name` outside `least` to `most`.
pub(crate) fn in_range(name: &str, value: u32, least: u32, most: u32) -> Result<()> {
    match (least..=most).contains(&value) {
        true => Ok(()),
        false => Err(Error::Usage(format!("{name} {value} is out of range: {least} to {most} is allowed"))),
    }
}

named! {
    /// Random-number scheme.
    pub enum Sampler = Sobol {
        /// Shuffled, Owen-scrambled Sobol' points in padded pairs of dimensions.
        Sobol = "sobol",
        /// Independent numbers by a hash.
        Independent = "independent",
        /// Numbers made by the host and read from a table, as in the thesis; the table wraps around.
        Table = "table",
    }
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

named! {
    /// What finds hits.
    pub enum AccelKind = Wide {
        /// Compressed 8-wide tree.
        Wide = "wide",
        /// Binary tree.
        Binary = "binary",
        /// No tree.
        Brute = "brute",
    }
}

named! {
    /// How light is gathered.
    pub enum Lights = Mis {
        /// Next-event estimation and BSDF sampling, combined by the power heuristic.
        Mis = "mis",
        /// Next-event estimation only.
        Area = "area",
        /// BSDF sampling only.
        Bsdf = "bsdf",
    }
}

named! {
    /// How a light is chosen.
    pub enum LightPick = Power {
        /// In proportion to emitted power, with a floor so that no light starves.
        Power = "power",
        /// In proportion to area, as in the thesis.
        Area = "area",
        /// By what each may contribute to the point that is lit: a descent of a tree over the lights.
        Tree = "tree",
    }
}

/// From as many emissive triangles on, a light is chosen by the light tree; measured in docs/performance.md.
const TREE_FROM_LIGHTS: usize = 16;

impl LightPick {
    /// The default for as many emissive triangles.
    pub fn for_lights(lights: usize) -> LightPick {
        if lights >= TREE_FROM_LIGHTS { LightPick::Tree } else { LightPick::Power }
    }
}

named! {
    /// How diffuse directions are drawn.
    pub enum Hemisphere = Cosine {
        /// In proportion to the cosine.
        Cosine = "cosine",
        /// Uniformly.
        Uniform = "uniform",
    }
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

named! {
    /// How a kernel reads records and path states.
    pub enum Buffers = Texel {
        /// Uniform texel buffers.
        Texel = "texel",
        /// Storage buffers.
        Storage = "storage",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::selftest::kit::probe_calls::nothing;
    use crate::selftest::kit::test_bench::plain_settings;

    fn settings() -> Settings {
        plain_settings(&nothing(), 32, 24, 16)
    }

    #[test]
    fn every_range_has_both_its_ends_and_nothing_beyond() {
        type Set = fn(&mut Settings, u32);
        let fields: [(&str, Set, u32, u32); 5] = [
            ("width", |settings, value| settings.width = value, 1, 16384),
            ("height", |settings, value| settings.height = value, 1, 16384),
            ("spp", |settings, value| settings.spp = value, 1, u32::MAX),
            ("max_bounces", |settings, value| settings.max_bounces = value, 1, 65535),
            ("replicates", |settings, value| settings.replicates = Some(value), 2, 256),
        ];
        for (name, set, least, most) in fields {
            let checked = |value: u32| {
                let mut settings = settings();
                set(&mut settings, value);
                settings.check()
            };
            assert!(checked(least).is_ok() && checked(most).is_ok(), "{name}");
            for value in [least.checked_sub(1), most.checked_add(1), (most < u32::MAX).then_some(u32::MAX)] {
                let Some(value) = value else { continue };
                let error = checked(value).unwrap_err();
                let said = error.to_string();
                assert!(matches!(error, Error::Usage(_)), "{error:?}");
                assert!(
                    said.contains(name) && said.contains(&value.to_string()) && said.contains(&most.to_string()),
                    "{said}"
                );
            }
        }
    }

    #[test]
    fn a_crop_is_a_part_of_the_picture() {
        let checked = |crop| Settings { crop: Some(crop), ..settings() }.check();
        for crop in [[0, 0, 32, 24], [31, 23, 1, 1], [3, 4, 5, 6]] {
            assert!(checked(crop).is_ok(), "{crop:?}");
        }
        for crop in [[0, 0, 0, 1], [0, 0, 1, 0], [32, 0, 1, 1], [0, 24, 1, 1], [1, 0, 32, 1], [u32::MAX, 0, 2, 1]] {
            let error = checked(crop).unwrap_err();
            assert!(matches!(&error, Error::Usage(said) if said.contains("32x24")), "{error}");
        }
    }

    #[test]
    fn a_survival_probability_is_one() {
        let checked = |p| Settings { roulette: Roulette::Fixed(p), ..settings() }.check();
        assert!([0.001, 0.5, 1.0].into_iter().all(|p| checked(p).is_ok()));
        for p in [0.0, 0.0009, 1.001, -0.5, f32::INFINITY, f32::NAN] {
            let error = checked(p).unwrap_err();
            assert!(matches!(&error, Error::Usage(said) if said.contains("0.001 to 1")), "{error}");
        }
    }
}
