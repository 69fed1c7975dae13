//! A difference image: where a picture is darker or brighter than a reference, and by how much of it.
//!
//! Comes in: two pictures of one size. Goes out: a colour a pixel. Blue is darker, orange brighter, the background
//! none; the strength of the colour is the logarithm of the relative difference of luminance, from [`LEAST`] to 1, so
//! that a picture of ten samples and one of a thousand can be read on the same scale. Magenta marks what is not finite
//! in either picture.

use super::relative_error::DENOMINATOR_FLOOR;
use crate::output::{Metadata, encode_indexed_png};

/// Relative difference below which nothing is shown.
pub const LEAST: f64 = 1e-3;
/// What the colours mean, in words.
pub const LEGEND: &str = "difference of luminance relative to the reference's: blue darker, orange brighter, on a \
                          logarithmic scale from 0.1 % (black) to 100 % and more (full colour); magenta: not finite";

/// Strengths of either colour.
const STEPS: u8 = 120;
/// Index of the colour of what is not finite.
const NOT_FINITE: u8 = 2 * STEPS + 1;
const DARKER: [f64; 3] = [70.0, 160.0, 255.0];
const BRIGHTER: [f64; 3] = [255.0, 150.0, 30.0];
const MAGENTA: [u8; 3] = [255, 0, 255];

/// A colour a pixel, by index into [`palette`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// One a pixel.
    pub indices: Vec<u8>,
    /// Pixels where either picture is not finite.
    pub not_finite: usize,
}

impl Difference {
    /// Of pictures of one size; `None` where they differ in it.
    pub fn of(picture: &[[f32; 3]], reference: &[[f32; 3]]) -> Option<Difference> {
        if picture.len() != reference.len() {
            return None;
        }
        let indices: Vec<u8> = picture.iter().zip(reference).map(|(&a, &b)| index(a, b)).collect();
        let not_finite = indices.iter().filter(|&&index| index == NOT_FINITE).count();
        Some(Difference { indices, not_finite })
    }

    /// The bytes of a PNG file of this size, or why they cannot be made.
    pub fn png(&self, width: u32, height: u32) -> Result<Vec<u8>, String> {
        encode_indexed_png(width, height, &palette(), LEGEND, &self.indices, &Metadata::new())
    }
}

/// Luminance of linear Rec. 709 (its own weights).
pub fn luminance(rgb: [f32; 3]) -> f64 {
    let [r, g, b] = rgb.map(f64::from);
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// The strongest darker colour comes first, none in the middle, the strongest brighter one last but for magenta.
pub fn palette() -> Vec<[u8; 3]> {
    let shade = |colour: [f64; 3], step: u8| {
        let strength = f64::from(step) / f64::from(STEPS);
        colour.map(|channel| (channel * strength).round() as u8)
    };
    let darker = (1..=STEPS).rev().map(|step| shade(DARKER, step));
    let brighter = (1..=STEPS).map(|step| shade(BRIGHTER, step));
    darker.chain([[0; 3]]).chain(brighter).chain([MAGENTA]).collect()
}

fn index(picture: [f32; 3], reference: [f32; 3]) -> u8 {
    let (a, b) = (luminance(picture), luminance(reference));
    let relative = (a - b) / (b * b + DENOMINATOR_FLOOR).sqrt();
    if !relative.is_finite() {
        return NOT_FINITE;
    }
    let strength = (1.0 - relative.abs().max(LEAST).log10() / LEAST.log10()).min(1.0);
    // At most STEPS, as the strength is at most 1.
    let steps = (strength * f64::from(STEPS)).round() as u8;
    if relative < 0.0 { STEPS - steps } else { STEPS + steps }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn colour(picture: f32, reference: f32) -> [u8; 3] {
        palette()[usize::from(index([picture; 3], [reference; 3]))]
    }

    #[test]
    fn colours_mean_what_the_legend_says() {
        assert_eq!(palette().len(), usize::from(NOT_FINITE) + 1);
        assert_eq!(colour(1.0, 1.0), [0; 3]);
        assert_eq!(colour(1.0005, 1.0), [0; 3], "below a thousandth");
        assert_eq!(colour(5.0, 1.0), BRIGHTER.map(|channel| channel as u8));
        assert_eq!(colour(0.0, 100.0), DARKER.map(|channel| channel as u8));
        // A relative difference of 10^-1.5 is half the scale: at reference 100 the floor is 5e-7 of it.
        assert_eq!(
            colour(100.0 * (1.0 + 10f32.powf(-1.5)), 100.0),
            BRIGHTER.map(|channel| (channel / 2.0).round() as u8)
        );
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!((colour(bad, 1.0), colour(1.0, bad)), (MAGENTA, MAGENTA));
        }
    }

    #[test]
    fn pixels_that_are_not_finite_are_counted() {
        let picture = [[0.0, f32::NAN, 0.0], [1.0; 3]];
        assert_eq!(Difference::of(&picture, &[[1.0; 3]; 2]).map(|difference| difference.not_finite), Some(1));
        assert_eq!(Difference::of(&picture, &[]), None);
    }
}
