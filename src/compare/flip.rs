//! FLIP: how much a person sees who flips between two pictures (Andersson et al., "FLIP: A Difference Evaluator for
//! Alternating Images", HPG 2020), and HDR-FLIP, its maximum over the exposures at which the reference can be shown
//! (Andersson et al., "Visualizing Errors in Rendered High Dynamic Range Images", Eurographics Short Papers 2021).
//!
//! Comes in: two pictures of linear radiance. Goes out: a number from 0 (no difference is seen) to 1. The observer is
//! that of the reference code: [`PIXELS_PER_DEGREE`], 0.7 m before a screen of 0.7 m and 3840 pixels; the tone map is
//! ACES.

use rayon::prelude::*;
use serde::Serialize;

use super::colour::{from_ycxcz, hunt_lab, hyab, ycxcz};
use super::convolve::Plane;
use super::difference::luminance;
use crate::memory;

/// Pixels that a degree of the observer's view has: 3840 · π / 180.
pub const PIXELS_PER_DEGREE: f64 = 67.020_643_276_582_25;
/// Exposures that are tried at the most, should the reference's median be all but black.
const MOST_EXPOSURES: usize = 64;
/// Share of the display's range that the brightest pixel (first exposure) and the median (last one) are mapped to.
const SHOWN: f64 = 0.85;
/// Contrast sensitivity: weight and width of the Gaussians, a1 b1 a2 b2, of lightness, red-green, blue-yellow.
const SENSITIVITY: [[f64; 4]; 3] = [[1.0, 0.0047, 0.0, 1e-5], [1.0, 0.0053, 0.0, 1e-5], [34.1, 0.04, 13.5, 0.025]];
/// Width of edges and points in degrees.
const FEATURE_WIDTH: f64 = 0.082;
const COLOUR_EXPONENT: f64 = 0.7;
const FEATURE_EXPONENT: f64 = 0.5;
/// Share of the largest colour difference below which differences take [`SMALL_RANGE`] of the scale.
const SMALL: f64 = 0.4;
const SMALL_RANGE: f64 = 0.95;

/// HDR-FLIP of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HdrFlip {
    /// Mean over the pixels.
    pub mean: f64,
    /// Largest of the pixels.
    pub largest: f64,
    /// First exposure in stops: the reference's brightest pixel is shown at 85 % of the display's range.
    pub start_stops: f64,
    /// Last one: the median is, or where that is black the median of what is not.
    pub stop_stops: f64,
    /// Exposures tried, evenly spaced; 0 where the pictures are equal and show nothing at any.
    pub exposures: usize,
}

/// Bytes that a pixel takes while two pictures are looked at: their shown, opponent, filtered and seen colours in f64.
const PIXEL_BYTES: u64 = 240;

/// HDR-FLIP of `picture` against `reference`, of `[width, height]` pixels, or why there is none: sizes do not fit, no
/// pixel is finite in both, memory is short, or the reference is black where the pictures differ from each other.
///
/// Pixels that are not finite in either picture are left out of the mean; to their neighbours they look black in both.
/// Pictures that are equal in all other pixels have a FLIP of 0 at every exposure, also where none can be chosen.
pub fn hdr(picture: &[[f32; 3]], reference: &[[f32; 3]], [width, height]: [usize; 2]) -> Result<HdrFlip, String> {
    if picture.len() != width * height || reference.len() != picture.len() || picture.is_empty() {
        return Err("the pictures have no pixels in common".into());
    }
    memory::check("memory", PIXEL_BYTES.saturating_mul(picture.len() as u64)).map_err(|error| error.to_string())?;
    let kept: Vec<bool> = picture.iter().zip(reference).map(|(a, b)| super::finite(a) && super::finite(b)).collect();
    let count = kept.iter().filter(|&&kept| kept).count();
    if count == 0 {
        return Err("no pixel is finite in both pictures".into());
    }
    let Some((start_stops, stop_stops)) = exposures(reference, &kept) else {
        let mut pairs = picture.iter().zip(reference).zip(&kept).filter(|(_, kept)| **kept);
        return match pairs.all(|((a, b), _)| a == b) {
            true => Ok(HdrFlip { mean: 0.0, largest: 0.0, start_stops: 0.0, stop_stops: 0.0, exposures: 0 }),
            false => Err("no luminance of the reference is above 0".into()),
        };
    };
    let exposures = ((stop_stops - start_stops).ceil().max(2.0) as usize).min(MOST_EXPOSURES);
    let observer = Observer::new();
    let mut most = vec![0.0; picture.len()];
    for i in 0..exposures {
        let stops = start_stops + (stop_stops - start_stops) * i as f64 / (exposures - 1) as f64;
        let show = |pixels: &[[f32; 3]]| -> Vec<[f64; 3]> {
            let of = |(&rgb, &kept): (&[f32; 3], &bool)| if kept { shown(rgb, stops) } else { [0.0; 3] };
            pixels.par_iter().zip(&kept).map(of).collect()
        };
        let errors = observer.ldr(&show(picture), &show(reference), width, height);
        most.iter_mut().zip(errors).for_each(|(most, error): (&mut f64, f64)| *most = most.max(error));
    }
    let of_kept = || most.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(most, _)| *most);
    let mean = of_kept().sum::<f64>() / count as f64;
    Ok(HdrFlip { mean, largest: of_kept().fold(0.0, f64::max), start_stops, stop_stops, exposures })
}

/// The range of exposures in stops (section 3 of the paper of 2021), over the pixels that are kept. The paper takes the
/// median of all luminances; where that is not above 0, as half the picture or more is black, no exposure would show
/// it, and the median of those above 0 is taken in its place. `None` where there is none.
fn exposures(reference: &[[f32; 3]], kept: &[bool]) -> Option<(f64, f64)> {
    let kept = reference.iter().zip(kept).filter(|(_, kept)| **kept);
    let mut luminances: Vec<f64> = kept.map(|(&rgb, _)| luminance(rgb)).collect();
    luminances.sort_unstable_by(f64::total_cmp);
    let median = |sorted: &[f64]| {
        let upper = sorted.len() / 2;
        let lower = sorted.len().checked_sub(1)? / 2;
        Some((sorted.get(lower)? + sorted.get(upper)?) / 2.0)
    };
    let shining = luminances.partition_point(|&luminance| luminance <= 0.0);
    let median = median(&luminances).filter(|&median| median > 0.0).or_else(|| median(&luminances[shining..]))?;
    let brightest = *luminances.last()?;
    // The x that the tone map takes to SHOWN: the positive root of a quadratic.
    let [k0, k1, k2, k3, k4, k5] = ACES;
    let (a, b, c) = (k0 - SHOWN * k3, k1 - SHOWN * k4, k2 - SHOWN * k5);
    let x = (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a);
    let ends = ((x / brightest).log2(), (x / median).log2());
    (ends.0.is_finite() && ends.1.is_finite()).then_some(ends)
}

/// Narkowicz's fit (2015) of the ACES curve, with his pre-exposure of 0.6 in the coefficients, as a quotient of
/// quadratics.
const ACES: [f64; 6] = [0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.0, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14];

/// A pixel as the display shows it at an exposure: linear light in [0, 1].
fn shown(rgb: [f32; 3], stops: f64) -> [f64; 3] {
    let [k0, k1, k2, k3, k4, k5] = ACES;
    rgb.map(|channel| {
        // Far above 1 the curve is flat; the bound keeps squares finite.
        let x = (f64::from(channel) * stops.exp2()).clamp(-1e30, 1e30);
        ((k0 * x * x + k1 * x + k2) / (k3 * x * x + k4 * x + k5)).clamp(0.0, 1.0)
    })
}

/// A filter as products of two kernels, along x and along y.
type Products = Vec<(Vec<f64>, Vec<f64>)>;

/// What the eye's filters are for one distance and screen.
struct Observer {
    contrast: [Products; 3],
    edge: [Vec<f64>; 2],
    point: [Vec<f64>; 2],
    largest_colour: f64,
}

impl Observer {
    fn new() -> Observer {
        let [edge, point, smooth] = features();
        let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(hunt_lab);
        Observer {
            contrast: SENSITIVITY.map(contrast),
            edge: [edge, smooth.clone()],
            point: [point, smooth],
            largest_colour: hyab(green, blue).powf(COLOUR_EXPONENT),
        }
    }

    /// LDR-FLIP of each pixel; the pictures are linear light in [0, 1].
    fn ldr(&self, picture: &[[f64; 3]], reference: &[[f64; 3]], width: usize, height: usize) -> Vec<f64> {
        let [a, b] = [picture, reference].map(|pixels| self.seen(pixels, width, height));
        let error = |i: usize| {
            let colour = self.colour_error(hyab(a.colours[i], b.colours[i]));
            let feature = (a.edges[i] - b.edges[i]).abs().max((a.points[i] - b.points[i]).abs());
            colour.powf(1.0 - (feature / std::f64::consts::SQRT_2).powf(FEATURE_EXPONENT).min(1.0))
        };
        (0..picture.len()).into_par_iter().map(error).collect()
    }

    /// The colour difference on a scale from 0 to 1 on which small ones take most of the room.
    fn colour_error(&self, hyab: f64) -> f64 {
        let error = hyab.powf(COLOUR_EXPONENT);
        let small = SMALL * self.largest_colour;
        match error < small {
            true => SMALL_RANGE / small * error,
            false => SMALL_RANGE + (error - small) / (self.largest_colour - small) * (1.0 - SMALL_RANGE),
        }
    }

    fn seen(&self, pixels: &[[f64; 3]], width: usize, height: usize) -> Seen {
        let opponent: Vec<[f64; 3]> = pixels.par_iter().map(|&rgb| ycxcz(rgb)).collect();
        let plane = |of: &dyn Fn(&[f64; 3]) -> f64| Plane { width, height, values: opponent.iter().map(of).collect() };
        let filtered = [0, 1, 2].map(|channel| {
            let plane = plane(&|colour| colour[channel]);
            let mut sum = vec![0.0; opponent.len()];
            for (along_x, along_y) in &self.contrast[channel] {
                let part = plane.convolved(along_x, along_y);
                sum.iter_mut().zip(part.values).for_each(|(sum, value)| *sum += value);
            }
            sum
        });
        let colour = |i: usize| {
            let rgb = from_ycxcz([filtered[0][i], filtered[1][i], filtered[2][i]]);
            hunt_lab(rgb.map(|channel| channel.clamp(0.0, 1.0)))
        };
        let lightness = plane(&|colour| (colour[0] + 16.0) / 116.0);
        let norm = |[across, along]: &[Vec<f64>; 2]| -> Vec<f64> {
            let x = lightness.convolved(across, along);
            let y = lightness.convolved(along, across);
            x.values.iter().zip(y.values).map(|(x, y)| x.hypot(y)).collect()
        };
        Seen {
            colours: (0..opponent.len()).into_par_iter().map(colour).collect(),
            edges: norm(&self.edge),
            points: norm(&self.point),
        }
    }
}

/// What is seen of one picture, a pixel each.
struct Seen {
    colours: Vec<[f64; 3]>,
    edges: Vec<f64>,
    points: Vec<f64>,
}

/// The contrast sensitivity of one channel as Gaussians, of sum 1 together, on the radius that all channels share.
fn contrast([a1, b1, a2, b2]: [f64; 4]) -> Products {
    let pi = std::f64::consts::PI;
    let widest = SENSITIVITY.iter().flat_map(|[_, b1, _, b2]| [*b1, *b2]).fold(0.0, f64::max);
    let radius = (3.0 * (widest / (2.0 * pi * pi)).sqrt() * PIXELS_PER_DEGREE).ceil() as i32;
    let gaussian = |b: f64| -> Vec<f64> {
        let at = |x: i32| (-pi * pi * (f64::from(x) / PIXELS_PER_DEGREE).powi(2) / b).exp();
        (-radius..=radius).map(at).collect()
    };
    let parts = [(a1, b1), (a2, b2)].into_iter().filter(|(a, _)| *a > 0.0);
    let parts: Vec<(f64, Vec<f64>)> = parts.map(|(a, b)| (a * (pi / b).sqrt(), gaussian(b))).collect();
    let total: f64 = parts.iter().map(|(weight, kernel)| weight * kernel.iter().sum::<f64>().powi(2)).sum();
    let product = |(weight, kernel): (f64, Vec<f64>)| {
        let scaled = kernel.iter().map(|value| value * weight / total).collect();
        (scaled, kernel)
    };
    parts.into_iter().map(product).collect()
}

/// Kernels of edges and points across, and the Gaussian along. Positive weights sum to 1, negative ones to -1, over the
/// whole plane of the filter.
fn features() -> [Vec<f64>; 3] {
    let deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as i32;
    let gaussian = |x: i32| (-f64::from(x * x) / (2.0 * deviation * deviation)).exp();
    let smooth: Vec<f64> = (-radius..=radius).map(gaussian).collect();
    let along: f64 = smooth.iter().sum();
    let normalised = |weight: &dyn Fn(f64) -> f64| -> Vec<f64> {
        let raw: Vec<f64> = (-radius..=radius).map(|x| weight(f64::from(x)) * gaussian(x)).collect();
        let sum = |sign: f64| raw.iter().map(|value| (sign * value).max(0.0)).sum::<f64>() * along;
        let (positive, negative) = (sum(1.0), sum(-1.0));
        raw.into_iter().map(|value| if value < 0.0 { value / negative } else { value / positive }).collect()
    };
    let edge = normalised(&|x| -x);
    let point = normalised(&|x| x * x / (deviation * deviation) - 1.0);
    [edge, point, smooth]
}
