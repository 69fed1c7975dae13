//! What `max_bounces` cuts off: light of longer paths, which is missing in every sample and so shows in no spread of samples.
//!
//! Comes in: a scene and the settings of its render. Goes out: a [`CapBias`]. A small picture of the same view is rendered twice with
//! the same random numbers, once with the cap and once with a far higher one. All that both have in common cancels in their
//! difference, pixel by pixel: what is left is the light of the paths in between.

use std::time::{Duration, Instant};

use serde::Serialize;

use crate::error::Result;
use crate::gpu::Context;
use crate::render::renderer::Renderer;
use crate::render::report::Observer;
use crate::render::stop::{StopRules, TimeRule};
use crate::render::tuning::Tuning;
use crate::scene::{Filter, Scene};
use crate::settings::{MAX_BOUNCES, Roulette, Settings};

/// Pixels of the small picture, about.
const PIXELS: f64 = 64.0 * 48.0;
/// Samples a pixel of it.
const SPP: u32 = 32;
/// Bounces of the longer paths: so many times the cap, and so many more.
const FACTOR: u32 = 8;
const BEYOND: u32 = 64;
/// Share of a render's work that this may take where nobody asked for it.
const COST_SHARE: f64 = 0.02;
/// Paths as costly as starting a render of a scene anew is, and as each of its triangles is then, about (two cores, lavapipe).
const PATHS_TO_START: f64 = 4e5;
const PATHS_PER_TRIANGLE: f64 = 2.0;

/// Light that the bounce cap cuts off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CapBias {
    /// Share of the picture's light (its luminance, summed over pixels) that longer paths would bring, 0 to 1.
    pub bounce_cap: f64,
    /// Standard error of that share.
    pub standard_error: f64,
    /// Bounces up to which longer paths were looked at.
    pub up_to_bounces: u32,
}

impl CapBias {
    /// A bound that the share is below with 95 % confidence.
    pub fn upper(&self) -> f64 {
        self.bounce_cap + 1.645 * self.standard_error
    }
}

/// Whether the estimate costs little beside a render of `spp` samples: a function of scene and settings, so that equal renders say
/// equal things.
pub fn is_cheap(scene: &Scene, settings: &Settings, spp: u32) -> bool {
    let [_, _, width, height] = settings.region();
    let paths = f64::from(width) * f64::from(height) * f64::from(spp);
    let start = PATHS_TO_START + PATHS_PER_TRIANGLE * scene.triangles.len() as f64;
    2.0 * (start + 2.0 * PIXELS * f64::from(SPP)) <= COST_SHARE * paths
}

/// Estimates what the cap of `settings` cuts off; `None` where the observer stopped it, or it would not have ended
/// before `ends`.
pub fn cap_bias(
    context: &Context,
    scene: &Scene,
    settings: &Settings,
    ends: Option<Instant>,
    observer: &mut dyn Observer,
) -> Result<Option<CapBias>> {
    settings.check()?;
    // Paths without an end take for ever: half of a picture says nothing, and its first samples are given up like any
    // other.
    let time = ends.map(|ends| TimeRule { aim: ends, latest: ends });
    let rules = StopRules { time, whole_or_nothing: true, ..StopRules::default() };
    let up_to_bounces = settings.max_bounces.saturating_mul(FACTOR).saturating_add(BEYOND).min(MAX_BOUNCES);
    let small = small(settings);
    let mut set_up = Duration::ZERO;
    let mut luminance = |max_bounces: u32| -> Result<Option<Vec<f64>>> {
        let settings = Settings { max_bounces, ..small.clone() };
        // Setting a render up cannot be cut short, and the second one takes as long as the first.
        if ends.is_some_and(|ends| Instant::now() + set_up > ends) {
            return Ok(None);
        }
        let begun = Instant::now();
        let renderer = Renderer::new(context, scene, &settings, &Tuning::default())?;
        set_up = begun.elapsed();
        let rendered = renderer.stop_by(rules).render(observer)?;
        let whole = rendered.report.spp == SPP;
        Ok(whole.then(|| rendered.film.mean().into_iter().map(luminance_of).collect()))
    };
    let (Some(capped), Some(longer)) = (luminance(settings.max_bounces)?, luminance(up_to_bounces)?) else {
        return Ok(None);
    };
    Ok(Some(compare(&capped, &longer, up_to_bounces)))
}

/// The same view with few pixels; roulette where there was none, since long paths without it would take for ever.
fn small(settings: &Settings) -> Settings {
    let [x, y, width, height] = settings.region();
    let scale = (PIXELS / (f64::from(width) * f64::from(height))).sqrt().min(1.0);
    let side = |pixels: u32| ((f64::from(pixels) * scale).round() as u32).max(1);
    let full = [side(settings.width), side(settings.height)];
    // The window's place on the small picture, inside it whatever the rounding.
    let place = |first: u32, count: u32, all: u32| {
        let count = side(count).min(all);
        [((f64::from(first) * scale).round() as u32).min(all - count), count]
    };
    let ([x, width], [y, height]) = (place(x, width, full[0]), place(y, height, full[1]));
    Settings {
        width: full[0],
        height: full[1],
        crop: settings.crop.map(|_| [x, y, width, height]),
        filter: Filter::Box,
        spp: SPP,
        roulette: if settings.roulette == Roulette::Off { Roulette::Throughput } else { settings.roulette },
        ..settings.clone()
    }
}

/// The share, and its standard error from the differences of neighbours: two pixels side by side expect nearly the same, so their
/// difference is noise, with the variance of both.
fn compare(capped: &[f64], longer: &[f64], up_to_bounces: u32) -> CapBias {
    let difference: Vec<f64> = longer.iter().zip(capped).map(|(longer, capped)| longer - capped).collect();
    let light: f64 = longer.iter().sum();
    if light == 0.0 {
        return CapBias { bounce_cap: 0.0, standard_error: 0.0, up_to_bounces };
    }
    let variance: f64 = difference.chunks_exact(2).map(|pair| (pair[0] - pair[1]).powi(2)).sum();
    CapBias {
        bounce_cap: difference.iter().sum::<f64>() / light,
        standard_error: variance.sqrt() / light,
        up_to_bounces,
    }
}

/// Luminance of linear Rec. 709.
fn luminance_of([r, g, b]: [f32; 3]) -> f64 {
    0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_and_its_error() {
        let bias = compare(&[1.0, 1.0, 1.0, 1.0], &[1.1, 1.3, 1.2, 1.2], 128);
        assert!((bias.bounce_cap - 0.8 / 4.8).abs() < 1e-12);
        assert!((bias.standard_error - 0.2 / 4.8).abs() < 1e-12);
        assert!((bias.upper() - (0.8 + 0.329) / 4.8).abs() < 1e-12);
        assert_eq!(
            compare(&[0.0; 4], &[0.0; 4], 9),
            CapBias { bounce_cap: 0.0, standard_error: 0.0, up_to_bounces: 9 }
        );
    }
}
