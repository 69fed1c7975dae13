//! Are two pictures the same but for noise? A z test a tile and channel.
//!
//! Comes in: pictures, one of them at least with the variance of its pixels' means. Goes out: a [`TileTest`]. Assumes
//! that pixels are independent of each other, as texray's are for every filter (its filters are sampled, not spread); a
//! renderer that spreads samples over pixels has tiles that vary more than their variances say, and seems to differ.

use serde::Serialize;

use super::read::ExrPicture;
use crate::statistics::{critical_z, z_test};

/// Side of a tile in pixels: so many that a sum of replicate variances, of one degree of freedom a pixel and more, is
/// known well, and that the mean is close to normal.
pub const TILE: usize = 16;

/// What the tiles showed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TileTest {
    /// Tests done: tiles times channels.
    pub tests: usize,
    /// Tests left out, as the tile has a pixel whose value or variance is not finite in one of the pictures. A pixel
    /// that is not finite in both says nothing of a difference: its tile is tested without it.
    pub left_out: usize,
    /// |z| above which one of so many tests is no chance: one false alarm in a million comparisons.
    pub critical_z: f64,
    /// Largest |z|; `None` without a test, or where a difference stands against a variance of 0.
    pub largest_z: Option<f64>,
    /// Tests that fail.
    pub failed: usize,
    /// Whether the reference counts as exact, as its file has no variance.
    pub exact_reference: bool,
    /// Whether the picture counts as exact, as its file has no variance.
    pub exact_picture: bool,
}

/// Tests the mean of every tile; `None` where neither file has a variance. The pictures have one window.
pub fn test(picture: &ExrPicture, reference: &ExrPicture) -> Option<TileTest> {
    if picture.variance.is_none() && reference.variance.is_none() {
        return None;
    }
    let (width, height) = (picture.window.width, picture.window.height);
    let (columns, rows) = (width.div_ceil(TILE), height.div_ceil(TILE));
    let all = columns * rows * 3;
    let mut sums = vec![[Sums::default(); 3]; columns * rows];
    for y in 0..height {
        for x in 0..width {
            let i = y * width + x;
            let tile = &mut sums[y / TILE * columns + x / TILE];
            for (channel, sums) in tile.iter_mut().enumerate() {
                sums.add(sample(picture, i, channel), sample(reference, i, channel));
            }
        }
    }
    let mut largest: f64 = 0.0;
    let (mut left_out, mut failed, mut tests) = (0, 0, 0);
    for sums in sums.into_iter().flatten() {
        let usable = sums.variance.is_finite() && sums.variance >= 0.0;
        if sums.in_one > 0 || (sums.pixels > 0 && !usable) {
            left_out += 1;
        } else if sums.pixels > 0 {
            // Sums rather than means: both sides of the quotient grow alike.
            let verdict = z_test(sums.picture, sums.variance, sums.reference);
            largest = largest.max(verdict.statistic.abs());
            failed += usize::from(!verdict.passes(all));
            tests += 1;
        }
    }
    Some(TileTest {
        tests,
        left_out,
        critical_z: critical_z(all),
        largest_z: (tests > 0 && largest.is_finite()).then_some(largest),
        failed,
        exact_reference: reference.variance.is_none(),
        exact_picture: picture.variance.is_none(),
    })
}

/// Sums of one channel over a tile.
#[derive(Clone, Copy, Default)]
struct Sums {
    picture: f64,
    reference: f64,
    variance: f64,
    pixels: usize,
    /// Pixels that are not finite in one of the pictures alone.
    in_one: usize,
}

impl Sums {
    fn add(&mut self, a: (f64, f64), b: (f64, f64)) {
        let finite = |(value, variance): (f64, f64)| value.is_finite() && variance.is_finite();
        match (finite(a), finite(b)) {
            (true, true) => {
                self.picture += a.0;
                self.reference += b.0;
                self.variance += a.1 + b.1;
                self.pixels += 1;
            }
            (false, false) => {}
            _ => self.in_one += 1,
        }
    }
}

/// Value and variance of one channel of a pixel; a file without variances is exact.
fn sample(picture: &ExrPicture, i: usize, channel: usize) -> (f64, f64) {
    let variance = picture.variance.as_ref().map_or(0.0, |variance| f64::from(variance[i][channel]));
    (f64::from(picture.rgb[i][channel]), variance)
}
