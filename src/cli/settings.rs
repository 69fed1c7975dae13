//! The options that decide what is computed: arguments and the scene's defaults to [`Settings`].
//!
//! Comes in: parsed options and a checked scene. Goes out: checked settings.

use clap::{Args, ValueEnum, value_parser};
use texray::bvh::Builder;
use texray::interface::MAX_BOUNCES;
use texray::render::{AccelKind, Buffers, Hemisphere, Intersector, LightPick, Lights, Roulette, Sampler, Settings};
use texray::scene::{Filter, Scene};
use texray::{Error, Result};

use super::{choices, parse};

/// Which effects are compiled into the kernel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum EffectsChoice {
    /// Those that the scene calls for.
    #[default]
    Auto,
    /// All of them; the picture is the same.
    All,
}

/// Options that decide what is computed.
#[derive(Args, Default)]
#[command(next_help_heading = "Picture")]
pub struct SettingsArgs {
    /// Samples a pixel, 1 to 4294967295 [default: the scene's, else 256; no end where another rule is given]
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..))]
    spp: Option<u32>,
    /// Picture size in pixels, each side 1 to 16384 [default: the scene's]
    #[arg(long, value_name = "WxH", value_parser = parse::size)]
    size: Option<[u32; 2]>,
    /// Render only this window of the picture, in pixels from the upper left corner; the same pixels as in the whole
    #[arg(long, value_name = "x,y,w,h", value_parser = parse::crop)]
    crop: Option<[u32; 4]>,
    /// Surface scatterings a path may have, 1 to 65535; 1 is direct light only [default: the scene's, else 8]
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=i64::from(MAX_BOUNCES)))]
    max_bounces: Option<u32>,
    /// Pixel filter [default: the scene's, else blackman-harris]
    #[arg(long, value_parser = choices::of::<Filter>())]
    filter: Option<Filter>,
    /// Render even where nothing can emit light
    #[arg(long)]
    pub allow_black: bool,

    /// Seed of all random numbers, 0 to 18446744073709551615
    #[arg(long, value_name = "N", default_value_t, help_heading = "Method")]
    seed: u64,
    /// Random-number scheme
    #[arg(long, value_parser = choices::of::<Sampler>(), default_value = choices::default::<Sampler>())]
    #[arg(help_heading = "Method")]
    sampler: Sampler,
    /// What finds the hits of rays
    #[arg(long, value_parser = choices::of::<AccelKind>(), default_value = choices::default::<AccelKind>())]
    #[arg(help_heading = "Method")]
    accel: AccelKind,
    /// What builds the tree
    #[arg(long, value_parser = choices::of::<Builder>(), default_value = choices::default::<Builder>())]
    #[arg(help_heading = "Method")]
    builder: Builder,
    /// Test of a ray against a triangle
    #[arg(long, value_parser = choices::of::<Intersector>(), default_value = choices::default::<Intersector>())]
    #[arg(help_heading = "Method")]
    intersector: Intersector,
    /// How light is gathered
    #[arg(long, value_parser = choices::of::<Lights>(), default_value = choices::default::<Lights>())]
    #[arg(help_heading = "Method")]
    lights: Lights,
    /// How one of several lights is chosen [default: by power, from 16 emissive triangles on by the tree]
    #[arg(long, value_parser = choices::of::<LightPick>(), help_heading = "Method")]
    light_pick: Option<LightPick>,
    /// How diffuse directions are drawn
    #[arg(long, value_parser = choices::of::<Hemisphere>(), default_value = choices::default::<Hemisphere>())]
    #[arg(help_heading = "Method")]
    hemisphere: Hemisphere,
    /// Russian roulette: by throughput, off, or a fixed probability of survival P, 0.001 to 1
    #[arg(long, value_name = "throughput|off|P", default_value = "throughput", value_parser = parse::roulette)]
    #[arg(help_heading = "Method")]
    roulette: Roulette,
    /// How records and path states are read: from texel buffers or storage buffers
    #[arg(long, value_parser = choices::of::<Buffers>(), default_value = choices::default::<Buffers>())]
    #[arg(help_heading = "Method")]
    buffers: Buffers,
    /// Effects compiled into the kernel
    #[arg(long, value_enum, default_value_t, help_heading = "Method")]
    effects: EffectsChoice,
}

impl SettingsArgs {
    /// Defaults, but for what the set of effects depends on.
    pub fn of_effects(filter: Option<Filter>, effects: EffectsChoice) -> SettingsArgs {
        SettingsArgs { filter, effects, ..SettingsArgs::default() }
    }

    /// Whether a number of samples was given.
    pub fn gives_spp(&self) -> bool {
        self.spp.is_some()
    }

    /// The settings for `scene`, its defaults filled in.
    pub fn settings(&self, scene: &Scene) -> Result<Settings> {
        let [width, height] = self.size.unwrap_or([scene.film.width, scene.film.height]);
        if let Some(crop) = self.crop {
            let inside = |first: u32, count: u32, all: u32| first.checked_add(count).is_some_and(|end| end <= all);
            if !inside(crop[0], crop[2], width) || !inside(crop[1], crop[3], height) {
                let [x, y, w, h] = crop;
                return Err(Error::Usage(format!(
                    "--crop {x},{y},{w},{h} reaches beyond the picture of {width}x{height}"
                )));
            }
        }
        let defaults = Settings::for_scene(scene);
        Ok(Settings {
            width,
            height,
            crop: self.crop,
            filter: self.filter.unwrap_or(defaults.filter),
            spp: self.spp.unwrap_or(defaults.spp),
            max_bounces: self.max_bounces.unwrap_or(defaults.max_bounces),
            seed: self.seed,
            sampler: self.sampler,
            accel: self.accel,
            builder: self.builder,
            intersector: self.intersector,
            lights: self.lights,
            light_pick: self.light_pick.unwrap_or(defaults.light_pick),
            hemisphere: self.hemisphere,
            roulette: self.roulette,
            buffers: self.buffers,
            all_effects: self.effects == EffectsChoice::All,
            allow_black: self.allow_black,
            ..defaults
        })
    }
}

/// The roulette as it is typed.
pub fn roulette_name(roulette: Roulette) -> String {
    match roulette {
        Roulette::Throughput => "throughput".into(),
        Roulette::Off => "off".into(),
        Roulette::Fixed(survival) => survival.to_string(),
    }
}
