//! Where a picture is wrong: the relative standard error of each pixel as a colour.
//!
//! Comes in: means and variances of the pixels. Goes out: an index a pixel into a palette, which with it makes a PNG. The variance is meaned
//! over the 5 x 5 pixels around: a pixel alone has so few replicates that its own is mostly noise.

use rayon::prelude::*;

use super::estimate::{DENOMINATOR_FLOOR, Estimate};
use super::neighbourhood;

/// Relative standard error of the darkest colour.
const LEAST: f64 = 1e-3;
/// Relative standard error of the brightest colour.
const MOST: f64 = 1.0;
/// What the colours mean, in words.
pub const LEGEND: &str = "relative standard error of a pixel, variances meaned over 5x5 pixels, on a logarithmic scale: black 0.1 % and \
                          less, violet 1 %, orange 10 %, white 100 % and more; grey: not known";

/// Index of the colour of what is not known.
const UNKNOWN: u8 = 255;
const GREY: [u8; 3] = [128, 128, 128];
/// Colours at even steps of the scale: 0.1 %, 0.32 %, 1 %, and so on to 100 %. Their brightness rises evenly.
const STOPS: [[f64; 3]; 7] = [
    [0.0, 0.0, 0.0],
    [40.0, 20.0, 90.0],
    [110.0, 30.0, 130.0],
    [190.0, 55.0, 100.0],
    [245.0, 125.0, 40.0],
    [252.0, 200.0, 90.0],
    [255.0, 255.0, 255.0],
];

/// The map of a picture: for each pixel an index into [`palette`], in rows from the top.
pub fn error_map(estimate: &Estimate) -> Vec<u8> {
    let (width, height) = (estimate.width as usize, estimate.height as usize);
    let mean = neighbourhood::means(width, height, |pixel| estimate.mean[pixel].map(f64::from));
    let variance = neighbourhood::means(width, height, |pixel| estimate.variance[pixel]);
    let relative = |pixel: usize| {
        let square: f64 = (0..3).map(|c| variance[pixel][c] / (mean[pixel][c].powi(2) + DENOMINATOR_FLOOR)).sum();
        (square / 3.0).sqrt()
    };
    (0..width * height).into_par_iter().map(|pixel| index(relative(pixel))).collect()
}

/// Colours of the scale, from the least error to the most, and the colour of what is not known.
pub fn palette() -> Vec<[u8; 3]> {
    let colour = |index: u8| {
        let at = f64::from(index) / f64::from(UNKNOWN - 1) * (STOPS.len() - 1) as f64;
        let below = (at as usize).min(STOPS.len() - 2);
        let part = at - below as f64;
        std::array::from_fn(|c| (STOPS[below][c] * (1.0 - part) + STOPS[below + 1][c] * part).round() as u8)
    };
    (0..UNKNOWN).map(colour).chain([GREY]).collect()
}

fn index(error: f64) -> u8 {
    if error.is_nan() {
        return UNKNOWN;
    }
    let share = (error / LEAST).ln() / (MOST / LEAST).ln();
    (share.clamp(0.0, 1.0) * f64::from(UNKNOWN - 1)).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_those_of_the_legend() {
        let palette = palette();
        let colour = |error: f64| palette[usize::from(index(error))];
        assert_eq!(palette.len(), 256);
        assert_eq!((colour(0.0), colour(0.001), colour(1.0), colour(9.0)), ([0; 3], [0; 3], [255; 3], [255; 3]));
        assert_eq!(colour(f64::NAN), GREY);
        let near = |a: [u8; 3], b: [f64; 3]| (0..3).all(|c| (f64::from(a[c]) - b[c]).abs() < 2.0);
        assert!(near(colour(0.01), STOPS[2]) && near(colour(0.1), STOPS[4]));
    }

    #[test]
    fn a_pixel_takes_the_colour_of_its_error() {
        // Variance 1.01e-4 over a mean of 1: 1 %, in the left half; ten times the error in the right one.
        let variance = |pixel: usize| if pixel % 20 < 10 { [1.01e-4; 3] } else { [1.01e-2; 3] };
        let mut estimate =
            Estimate { width: 20, height: 8, mean: vec![[1.0; 3]; 160], variance: (0..160).map(variance).collect() };
        let map = error_map(&estimate);
        assert_eq!((map[0], map[19]), (index(0.01), index(0.1)));
        estimate.variance = vec![[f64::NAN; 3]; 160];
        assert!(error_map(&estimate).iter().all(|&index| index == UNKNOWN));
    }
}
