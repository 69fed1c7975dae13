//! Reading a film out: mean, variance of the mean, and the error of the whole picture.
//!
//! Comes in: the sums and counts of a film, open blocks included. Goes out: an [`Estimate`] in the file's radiance
//! units. All arithmetic is f64, in an order fixed by pixel and replicate alone, whatever the number of threads.
//!
//! With S_r and n_r the sum and count of replicate r, N = Σ n_r and K the number of replicates with n_r > 0, a channel
//! of a pixel has the mean m = Σ S_r / N, and the variance of that mean is estimated without bias by
//! Σ n_r (S_r / n_r - m)² / ((K - 1) N), where a replicate's mean has a variance that falls as 1 / n_r. It is computed
//! in two passes and is exactly 0 where all replicates have the same mean, as in a constant picture of whole blocks.

use rayon::prelude::*;

use super::{Film, fixed, neighbourhood};

/// Added to the squared mean in the denominator of the relative error, in the file's units of radiance squared: keeps
/// dark pixels from ruling the figure (a pixel of radiance 0.1 weighs half of its relative error).
pub const DENOMINATOR_FLOOR: f64 = 0.01;
/// Bytes a pixel that reading out takes at most: means and variances, neighbourhood means of both with the sums on the way to
/// the second, and two squares of the error.
pub const READ_OUT_BYTES: usize = size_of::<[f32; 3]>() + 4 * size_of::<[f64; 3]>() + 2 * size_of::<f64>();

/// Mean of every pixel and the variance of that mean.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Mean radiance, linear Rec. 709 in the file's units, in rows from the top; 0 for a pixel without valid samples.
    pub mean: Vec<[f32; 3]>,
    /// Estimated variance of the mean, in the square of those units; not a number where fewer than two replicates have
    /// samples.
    pub variance: Vec<[f64; 3]>,
}

impl Film {
    /// Mean radiance of each pixel, linear Rec. 709 in the file's units, in rows from the top.
    pub fn mean(&self) -> Vec<[f32; 3]> {
        let mut mean = vec![[0.0; 3]; self.pixels()];
        mean.par_chunks_mut(self.width as usize).enumerate().for_each_init(Vec::new, |shares, (y, mean)| {
            for (mean, pixel) in mean.iter_mut().zip(self.read_row(y, shares)) {
                *mean = pixel.mean.map(|mean| mean as f32);
            }
        });
        mean
    }

    /// Whether the mean of every pixel is 0.
    pub fn is_black(&self) -> bool {
        let black = |shares: &mut Vec<_>, y| self.read_row(y, shares).all(|pixel| pixel.mean == [0.0; 3]);
        (0..self.height as usize).into_par_iter().map_init(Vec::new, black).all(|black| black)
    }

    /// Mean of each pixel and the variance of that mean.
    pub fn estimate(&self) -> Estimate {
        let row = self.width as usize;
        let mut mean = vec![[0.0; 3]; self.pixels()];
        let mut variance = vec![[0.0; 3]; self.pixels()];
        let rows = mean.par_chunks_mut(row).zip(variance.par_chunks_mut(row)).enumerate();
        rows.for_each_init(Vec::new, |shares, (y, (mean, variance))| {
            for ((mean, variance), pixel) in mean.iter_mut().zip(variance).zip(self.read_row(y, shares)) {
                *mean = pixel.mean.map(|mean| mean as f32);
                *variance = pixel.variance();
            }
        });
        Estimate { width: self.width, height: self.height, mean, variance }
    }

    /// [`Estimate::relative_rmse`] of this film; `None` before every pixel has two closed blocks. It reads the whole film
    /// (some 0.1 s for 800 x 600 pixels on two cores): the frame loop asks as often as 2 % of its time allow.
    pub fn relative_rmse(&self) -> Option<f64> {
        if self.replicates < 2 || !self.has_blocks(2) {
            return None;
        }
        self.held.during(|| self.estimate().relative_rmse())
    }

    /// The pixels of row `y`, their shares kept in `shares`.
    fn read_row<'a>(&self, y: usize, shares: &'a mut Vec<Share>) -> impl Iterator<Item = Pixel<'a>> {
        let (width, replicates) = (self.width as usize, self.replicates as usize);
        let scale = 2f64.powi(-self.radiance_exponent);
        shares.clear();
        for pixel in y * width..(y + 1) * width {
            for replicate in 0..replicates {
                let at = replicate * self.pixels() + pixel;
                let mut share = Share::new(u64::from(self.counts[at]), self.sums[at]);
                if let Some(open) = self.open.get(pixel).filter(|open| open.replicate as usize == replicate) {
                    let open_sum = open.sum.map(|sum| fixed::from_f32(sum).unwrap_or(0));
                    let sum = [0, 1, 2].map(|c| self.sums[at][c].saturating_add(open_sum[c]));
                    share = Share::new(u64::from(self.counts[at]) + u64::from(open.count), sum);
                }
                shares.push(share);
            }
        }
        shares.chunks_exact(replicates).map(move |shares| Pixel::new(shares, scale))
    }
}

/// What one replicate has of one pixel, in scaled radiance.
#[derive(Clone, Copy)]
struct Share {
    count: f64,
    sum: [f64; 3],
}

impl Share {
    fn new(count: u64, sum: [i128; 3]) -> Share {
        Share { count: count as f64, sum: sum.map(fixed::to_f64) }
    }
}

/// One pixel read out: its mean in the file's units and what its variance is computed from.
struct Pixel<'a> {
    shares: &'a [Share],
    count: f64,
    mean: [f64; 3],
    scale: f64,
}

impl<'a> Pixel<'a> {
    fn new(shares: &'a [Share], scale: f64) -> Pixel<'a> {
        let (count, sum) =
            shares.iter().fold((0.0, [0.0; 3]), |(count, sum), share| (count + share.count, add(sum, share.sum)));
        let mean = if count > 0.0 { sum.map(|sum| sum / count * scale) } else { [0.0; 3] };
        Pixel { shares, count, mean, scale }
    }

    fn variance(&self) -> [f64; 3] {
        let (mut spread, mut used) = ([0.0; 3], 0u32);
        for share in self.shares.iter().filter(|share| share.count > 0.0) {
            let deviation = [0, 1, 2].map(|c| share.sum[c] / share.count * self.scale - self.mean[c]);
            spread = add(spread, deviation.map(|deviation| share.count * deviation * deviation));
            used += 1;
        }
        let divisor = if used < 2 { f64::NAN } else { f64::from(used - 1) * self.count };
        spread.map(|spread| spread / divisor)
    }
}

impl Estimate {
    /// Estimated relative RMSE of the picture: the square root of the mean, over pixels and channels, of
    /// `variance / (m² + 0.01)`. m is the mean over the 5 x 5 neighbourhood, so that a pixel that has missed its rare
    /// bright path borrows the brightness of its neighbours. It estimates the root of relMSE = mean((x - ref)² /
    /// (ref² + 0.01)) against the exact picture. `None` where no pixel has two replicates.
    pub fn relative_rmse(&self) -> Option<f64> {
        self.relative_rmse_by(&self.neighbourhood_means())
    }

    /// Mean radiance of the 5 x 5 neighbourhood of each pixel.
    pub(super) fn neighbourhood_means(&self) -> Vec<[f64; 3]> {
        let mean = |pixel: usize| self.mean[pixel].map(f64::from);
        neighbourhood::means(self.width as usize, self.height as usize, mean)
    }

    /// [`Self::relative_rmse`] where `near` are the means of the neighbourhoods.
    pub(super) fn relative_rmse_by(&self, near: &[[f64; 3]]) -> Option<f64> {
        let width = self.width as usize;
        self.pooled(|x, y| near[y * width + x].map(|mean| mean * mean + DENOMINATOR_FLOOR))
    }

    /// Estimated RMSE of the picture in the file's units: the square root of the mean variance over pixels and
    /// channels. `None` where no pixel has two replicates.
    pub fn rmse(&self) -> Option<f64> {
        self.pooled(|_, _| [1.0; 3])
    }

    /// Square root of the mean of variance / denominator over the pixels that have a variance. Rows are summed apart
    /// and then in order, so the figure does not depend on threads.
    fn pooled(&self, denominator: impl Fn(usize, usize) -> [f64; 3] + Sync) -> Option<f64> {
        let width = self.width as usize;
        let rows: Vec<(f64, u64)> = self
            .variance
            .par_chunks(width)
            .enumerate()
            .map(|(y, row)| {
                let known = row.iter().enumerate().filter(|(_, variance)| !variance[0].is_nan());
                known.fold((0.0, 0), |(sum, count), (x, variance)| {
                    let denominator = denominator(x, y);
                    let ratio = (0..3).map(|c| variance[c] / denominator[c]).sum::<f64>();
                    (sum + ratio, count + 3)
                })
            })
            .collect();
        let (sum, count) = rows.iter().fold((0.0, 0), |(sum, count), row| (sum + row.0, count + row.1));
        (count > 0).then(|| (sum / count as f64).sqrt())
    }
}

fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}
