//! A picture under two seeds: what a difference between two ways to render can be told by, apart from noise.
//!
//! Comes in: a scene, settings, the number of a repeat. Goes out: both pictures, what they took, and how two pairs differ.

use crate::compare::relative_error::{DENOMINATOR_FLOOR, mean};
use crate::render::Tuning;
use crate::settings::Settings;
use crate::study::engine::Watch;
use crate::study::engine::subject::Subject;
use crate::{Error, Result};

/// Two pictures of the same settings but for the seed, and what they took together.
#[derive(Clone, Debug, Default)]
pub struct SeedPair {
    /// Radiance, linear Rec. 709 in the file's units.
    pub pictures: [Vec<[f32; 3]>; 2],
    /// Seconds of rendering.
    pub seconds: f64,
    /// Rays.
    pub rays: f64,
    /// Paths.
    pub paths: f64,
    /// Samples that were left out.
    pub invalid_samples: f64,
}

impl SeedPair {
    /// Renders with the seeds of a repeat, the kernel compiled before; `None` where the watch stopped it.
    pub fn render(
        subject: &mut Subject,
        settings: &Settings,
        tuning: &Tuning,
        repeat: u32,
        watch: &dyn Watch,
    ) -> Result<Option<SeedPair>> {
        let mut pair = SeedPair::default();
        for (seed, picture) in (2 * u64::from(repeat)..).zip(&mut pair.pictures) {
            let settings = Settings { seed, ..settings.clone() };
            let Some(rendered) = subject.render_warm(&settings, tuning, watch)? else { return Ok(None) };
            *picture = rendered.film.mean();
            pair.seconds += rendered.report.seconds.render;
            pair.rays += rendered.report.rays as f64;
            pair.paths += rendered.report.paths as f64;
            pair.invalid_samples += rendered.report.invalid_samples.values().sum::<u64>() as f64;
        }
        Ok(Some(pair))
    }

    /// Microseconds of a path.
    pub fn us_per_path(&self) -> f64 {
        1e6 * self.seconds / self.paths
    }

    /// Mean of the two pictures.
    pub fn picture(&self) -> Vec<[f32; 3]> {
        let [one, other] = &self.pictures;
        one.iter().zip(other).map(|(a, b)| std::array::from_fn(|c| (a[c] + b[c]) / 2.0)).collect()
    }

    /// Mean over pixels, channels and both pictures.
    pub fn brightness(&self) -> f64 {
        (mean(&self.pictures[0]) + mean(&self.pictures[1])) / 2.0
    }

    /// Relative squared bias of `other` against this, without noise in its expectation ([`relative_bias_squared`]).
    pub fn bias_squared(&self, other: &SeedPair) -> Result<f64> {
        let ([a, b], [c, d]) = (&self.pictures, &other.pictures);
        relative_bias_squared([a, b], [c, d])
            .ok_or_else(|| Error::Internal("pictures of different sizes were compared".into()))
    }

    /// Share of the pixels whose bits differ.
    pub fn changed(&self, other: &SeedPair) -> f64 {
        let pairs = || self.pictures.iter().flatten().zip(other.pictures.iter().flatten());
        pairs().filter(|(a, b)| a != b).count() as f64 / pairs().count().max(1) as f64
    }
}

/// Relative squared bias between two ways to render a picture: each rendered twice, with the same two seeds. The differences of
/// the two seeds are independent, so the mean of their product over (r² + 0.01) has no noise in its expectation, whatever the
/// samples; it may come out negative where there is no bias. `r` is the mean of the first way's pictures. `None` where sizes differ
/// or there is no pixel.
pub fn relative_bias_squared(one: [&[[f32; 3]]; 2], other: [&[[f32; 3]]; 2]) -> Option<f64> {
    let pixels = one[0].len();
    if pixels == 0 || [one[1], other[0], other[1]].iter().any(|picture| picture.len() != pixels) {
        return None;
    }
    let channel = |picture: &[[f32; 3]], place: usize| f64::from(picture[place / 3][place % 3]);
    let sum: f64 = (0..3 * pixels)
        .map(|place| {
            let [a, b, c, d] = [one[0], one[1], other[0], other[1]].map(|picture| channel(picture, place));
            (a - c) * (b - d) / (((a + b) / 2.0).powi(2) + DENOMINATOR_FLOOR)
        })
        .sum();
    Some(sum / (3 * pixels) as f64)
}

/// A relative squared bias in per cent of the picture's values; an estimate below 0 is none.
pub fn bias_percent(squared: f64) -> f64 {
    100.0 * squared.max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bias_is_what_both_seeds_agree_on() {
        let (a, b) = ([[1.0f32, 1.0, 1.0]], [[1.0f32, 1.0, 1.0]]);
        // One channel is 0.2 too bright under both seeds, the others differ with opposite signs or under one seed alone.
        let (c, d) = ([[1.2f32, 1.5, 1.3]], [[1.2f32, 0.5, 1.0]]);
        let bias = relative_bias_squared([&a, &b], [&c, &d]).unwrap();
        assert!((bias - (0.04 - 0.25) / (3.0 * 1.01)).abs() < 1e-6, "{bias}");
        assert_eq!(relative_bias_squared([&a, &b], [&a, &b]), Some(0.0));
        assert_eq!(relative_bias_squared([&a, &b], [&c, &[]]), None);
    }

    #[test]
    fn pairs_differ_by_what_both_seeds_show() {
        let pair = |a: f32, b: f32| SeedPair { pictures: [vec![[a; 3]; 2], vec![[b; 3]; 2]], ..SeedPair::default() };
        let (one, other) = (pair(1.0, 1.0), pair(1.2, 1.0));
        assert_eq!(one.bias_squared(&other).unwrap(), 0.0);
        assert_eq!((one.changed(&other), one.changed(&one)), (0.5, 0.0));
        assert!((other.brightness() - 1.1).abs() < 1e-6);
        assert!((bias_percent(one.bias_squared(&pair(1.1, 1.1)).unwrap()) - 10.0 / 1.01f64.sqrt()).abs() < 1e-4);
        assert_eq!(bias_percent(-1.0), 0.0);
    }
}
