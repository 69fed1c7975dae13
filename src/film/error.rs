//! How wrong a picture is, by its own samples: an estimate, and a bound that the true error is below with a stated confidence.
//!
//! Comes in: means and variances of the pixels. Goes out: a [`PictureError`]. It is about noise alone: what a bounce cap cuts off is
//! bias, which no spread of samples shows.
//!
//! The bound takes two precautions that the estimate does not. A pixel's variance counts as at least half of its neighbourhood's:
//! one that has missed its rare bright path looks better than it is. And the estimate is itself an estimate: what two pixels side by
//! side differ by in their squared errors is noise, so the n pairs of neighbours give its standard error, √(Σ d²) / pixels. Where few pairs
//! bring most of it, it is less certain itself: Student's t has (Σ d²)² / Σ d⁴ degrees of freedom (after Satterthwaite 1946).

use rayon::prelude::*;
use serde::Serialize;

use super::estimate::{DENOMINATOR_FLOOR, Estimate};
use super::{Film, neighbourhood};
use crate::statistics::distributions::student_critical;

/// Share of its neighbourhood's variance that a pixel has at least, in the bound.
const NEIGHBOURS_SHARE: f64 = 0.5;
/// Share of the pixels that may hold at most [`HEAVY_SHARE`] of the squared error.
const FEW_PIXELS: f64 = 1e-3;
/// Degrees of freedom from which Student's t is a normal number.
const MANY_DEGREES: f64 = 1e6;
/// Above this share the tail is heavy: a few pixels rule the error, and more like them may not have been met yet.
const HEAVY_SHARE: f64 = 0.5;

/// The error of a picture by its own samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PictureError {
    /// Estimated relative RMSE ([`Estimate::relative_rmse`]), a ratio.
    pub relative_rmse: f64,
    /// Share of the squared error that the 0.1 % of pixels with most of it hold, 0 to 1. 1 for a picture without any light: its
    /// samples agree, but what they have all missed is all there is.
    pub heavy_share: f64,
    /// Pixels without any light beside a pixel with some: shadows, or paths that have not been found yet.
    pub dark_pixels: u64,
    /// Mean square of the relative error, variances no less than half of the neighbourhood's.
    #[serde(skip)]
    guarded_square: f64,
    /// Standard error of `guarded_square`.
    #[serde(skip)]
    standard_error: f64,
    /// Degrees of freedom of `standard_error`, at least 1; 0 where there are no neighbours.
    #[serde(skip)]
    degrees: f64,
}

impl PictureError {
    /// A bound that the relative RMSE exceeds with probability `alpha`, in (0, 0.5]; infinite for a picture of one column.
    pub fn upper(&self, alpha: f64) -> f64 {
        if self.guarded_square == 0.0 {
            return 0.0;
        }
        // No neighbours, or a picture that is too bright for f32.
        if self.guarded_square.is_nan() || self.degrees.is_nan() || self.degrees < 1.0 {
            return f64::INFINITY;
        }
        // One-sided: either side of a two-sided interval has half of its probability.
        let t = if alpha < 0.5 { student_critical(2.0 * alpha, self.degrees) } else { 0.0 };
        let bound = (self.guarded_square + t * self.standard_error).sqrt();
        if bound.is_nan() { f64::INFINITY } else { bound }
    }

    /// Whether so few pixels hold so much of the error that neither estimate nor bound can be relied on.
    pub fn is_heavy_tailed(&self) -> bool {
        self.heavy_share > HEAVY_SHARE
    }
}

impl Film {
    /// [`Estimate::error`] of this film; `None` before every pixel has two closed blocks. It reads the whole film (some 0.15 s for
    /// 800 x 600 pixels on two cores).
    pub fn error(&self) -> Option<PictureError> {
        if self.replicates < 2 || !self.has_blocks(2) {
            return None;
        }
        self.held.during(|| self.estimate().error())
    }
}

impl Estimate {
    /// The error of this picture; `None` where no pixel has two replicates.
    pub fn error(&self) -> Option<PictureError> {
        let (width, height) = (self.width as usize, self.height as usize);
        let near = self.neighbourhood_means();
        let relative_rmse = self.relative_rmse_by(&near)?;
        // A pixel without a variance, all of whose samples were left out but those of one replicate, takes its neighbours'.
        let variance = |pixel: usize| self.variance[pixel].map(|v| if v.is_nan() { 0.0 } else { v });
        let near_variance = neighbourhood::means(width, height, variance);
        let squares = |pixel: usize| {
            let (own, around) = (variance(pixel), near_variance[pixel]);
            let denominator = near[pixel].map(|mean| mean * mean + DENOMINATOR_FLOOR);
            let square = |c: usize| own[c] / denominator[c];
            let guarded = |c: usize| own[c].max(NEIGHBOURS_SHARE * around[c]) / denominator[c];
            ((square(0) + square(1) + square(2)) / 3.0, (guarded(0) + guarded(1) + guarded(2)) / 3.0)
        };
        let (own, guarded): (Vec<f64>, Vec<f64>) = (0..width * height).into_par_iter().map(squares).unzip();
        let (standard_error, degrees) = noise(&own, width);
        Some(PictureError {
            relative_rmse,
            heavy_share: if self.mean.iter().all(|mean| *mean == [0.0; 3]) { 1.0 } else { share_of_few(own) },
            dark_pixels: self.dark_pixels(),
            guarded_square: guarded.iter().sum::<f64>() / guarded.len() as f64,
            standard_error,
            degrees,
        })
    }

    fn dark_pixels(&self) -> u64 {
        let (width, height) = (self.width as usize, self.height as usize);
        let dark = |pixel: usize| self.mean[pixel] == [0.0; 3];
        let beside_light = |pixel: usize| {
            let (x, y) = (pixel % width, pixel / width);
            let mut around = (y.saturating_sub(1)..(y + 2).min(height))
                .flat_map(|y| (x.saturating_sub(1)..(x + 2).min(width)).map(move |x| (x, y)));
            around.any(|(x, y)| !dark(y * width + x))
        };
        (0..width * height).into_par_iter().filter(|&pixel| dark(pixel) && beside_light(pixel)).count() as u64
    }
}

/// Standard error of the mean of `values`, rows of `width`, and its degrees of freedom, from pairs of neighbours in a row.
fn noise(values: &[f64], width: usize) -> (f64, f64) {
    let pairs = values.chunks_exact(width).flat_map(|row| row.chunks_exact(2));
    let (squares, fourths) = pairs.fold((0.0, 0.0), |(squares, fourths), pair| {
        let square = (pair[0] - pair[1]).powi(2);
        (squares + square, fourths + square * square)
    });
    let degrees = match (width > 1, fourths == 0.0) {
        (false, _) => 0.0,
        // No pair differs: nothing is uncertain.
        (true, true) => MANY_DEGREES,
        (true, false) => (squares * squares / fourths).clamp(1.0, MANY_DEGREES),
    };
    (squares.sqrt() / values.len() as f64, degrees)
}

/// Share of the sum that the 0.1 % largest of `values` hold, at least one of them.
fn share_of_few(mut values: Vec<f64>) -> f64 {
    let total: f64 = values.iter().sum();
    if total == 0.0 {
        return 0.0;
    }
    let few = ((values.len() as f64 * FEW_PIXELS) as usize).max(1);
    let (_, _, _) = values.select_nth_unstable_by(few - 1, |a, b| b.total_cmp(a));
    values[..few].iter().sum::<f64>() / total
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture of mean 1 whose pixels have these variances in every channel.
    fn estimate(width: u32, variance: Vec<f64>) -> Estimate {
        let height = variance.len() as u32 / width;
        let variance: Vec<[f64; 3]> = variance.into_iter().map(|v| [v; 3]).collect();
        Estimate { width, height, mean: vec![[1.0; 3]; variance.len()], variance }
    }

    #[test]
    fn an_even_picture_is_bounded_by_its_error() {
        let error = estimate(64, vec![0.0101; 64 * 64]).error().unwrap();
        assert!((error.relative_rmse - 0.1).abs() < 1e-12);
        assert!((error.upper(0.05) - 0.1).abs() < 1e-9, "no pixel differs");
        assert!((error.heavy_share - 4.0 / 4096.0).abs() < 1e-12 && !error.is_heavy_tailed());
        assert_eq!(error.dark_pixels, 0);
    }

    #[test]
    fn a_bound_grows_with_confidence_and_with_the_noise_of_pixels() {
        // Of 256 pairs two differ, by v and by 2 v: standard error √5 v / 512, 25 / 17 degrees of freedom.
        let v = 0.01 * 1.01;
        let mut picture = vec![v; 512];
        (picture[8], picture[300]) = (2.0 * v, 3.0 * v);
        let (standard_error, degrees) = noise(&picture, 32);
        assert!((standard_error - 5f64.sqrt() * v / 512.0).abs() < 1e-15 && (degrees - 25.0 / 17.0).abs() < 1e-9);
        let error = estimate(32, picture).error().unwrap();
        assert!(error.upper(0.01) > error.upper(0.05) && error.upper(0.05) > error.relative_rmse);
        assert_eq!(error.upper(0.5), error.guarded_square.sqrt());
        // A tilt from pixel to pixel is no noise where pairs of neighbours agree; t of many degrees is a normal number's.
        let (flat, degrees) = noise(&[1.0, 1.0, 5.0, 5.0], 4);
        assert_eq!((flat, degrees), (0.0, MANY_DEGREES));
        let even: Vec<f64> = (0..4096).map(|pixel| if pixel % 2 == 0 { v } else { 3.0 * v }).collect();
        let error = estimate(64, even).error().unwrap();
        let square = error.upper(0.05).powi(2) - error.guarded_square;
        assert!((square / error.standard_error - 1.645).abs() < 2e-3, "2,048 pairs of one difference");
        let mut infinite = estimate(32, vec![v; 512]);
        infinite.mean[7] = [f32::INFINITY; 3];
        infinite.variance[7] = [f64::INFINITY; 3];
        assert_eq!(infinite.error().unwrap().upper(0.05), f64::INFINITY, "a pixel above what f32 holds");
        assert_eq!(estimate(1, vec![v; 256]).error().unwrap().upper(0.05), f64::INFINITY, "no pixel has a neighbour");
    }

    #[test]
    fn a_pixel_that_missed_its_light_borrows_its_neighbours_variance() {
        let mut variance = vec![1.01; 32 * 32];
        variance[16 * 32 + 16] = 0.0;
        let error = estimate(32, variance).error().unwrap();
        let missing = 1.0 - 0.5 * 24.0 / 25.0;
        assert!((error.guarded_square - (1.0 - missing / 1024.0)).abs() < 1e-9);
        assert!((error.relative_rmse.powi(2) - (1.0 - 1.0 / 1024.0)).abs() < 1e-9);
    }

    #[test]
    fn few_pixels_with_most_of_the_error_are_a_heavy_tail() {
        let mut variance = vec![0.01; 2000];
        variance[777] = 25.0;
        variance[1234] = 5.0;
        let error = estimate(50, variance).error().unwrap();
        assert!(error.is_heavy_tailed() && (error.heavy_share - 30.0 / (30.0 + 19.98)).abs() < 1e-9);
        assert_eq!(estimate(50, vec![0.0; 2000]).error().unwrap().heavy_share, 0.0);
        let black = Estimate { mean: vec![[0.0; 3]; 2000], ..estimate(50, vec![0.0; 2000]) };
        assert!(black.error().unwrap().is_heavy_tailed(), "no path has met the light yet");
    }

    #[test]
    fn darkness_counts_beside_light() {
        let mut picture = estimate(40, vec![0.01; 40 * 40]);
        for pixel in [0, 1, 40, 41, 820] {
            picture.mean[pixel] = [0.0; 3];
        }
        // Of the four dark pixels of the corner, the corner itself has dark neighbours alone.
        assert_eq!(picture.error().unwrap().dark_pixels, 4);
    }
}
