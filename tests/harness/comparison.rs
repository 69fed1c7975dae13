//! Two pictures held against each other, tile by tile, by their variances.
//!
//! Comes in: two [`Estimate`]s of one size, in the same units. Goes out: a [`Comparison`]: each tile's z in each
//! channel, and which tiles say nothing. Assumes independent pixels (box filter) and independent pictures.

use super::statistics::{ROUNDING, critical_z};
use super::tracer::Estimate;

/// One tile of two pictures in one channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tile {
    /// Left edge, in pixels.
    pub x: usize,
    /// Upper edge, in pixels.
    pub y: usize,
    /// Channel: red, green, blue.
    pub channel: usize,
    /// Means of the two pictures over the tile.
    pub means: [f64; 2],
    /// Standard errors between them; what lies within [`ROUNDING`] counts as none.
    pub z: f64,
    /// One pixel in a hundred (at least one) holds more than half of the variance, so that z is not normal.
    pub inconclusive: bool,
}

/// All tiles of two pictures.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Every tile and channel.
    pub tiles: Vec<Tile>,
    /// Mean of the first picture over that of the second, a channel each.
    pub mean_ratio: [f64; 3],
    /// Standard error of `mean_ratio`, a channel each.
    pub ratio_error: [f64; 3],
}

/// Compares two pictures of `width` pixels in tiles of `side` pixels: z of the difference of the tile's means, by the
/// variances of both pictures summed over the tile.
pub fn compare(a: &Estimate, b: &Estimate, width: usize, side: usize) -> Comparison {
    assert_eq!(a.mean.len(), b.mean.len(), "pictures of one size");
    let height = a.mean.len() / width;
    let mut tiles = Vec::new();
    for (y, x) in (0..height).step_by(side).flat_map(|y| (0..width).step_by(side).map(move |x| (y, x))) {
        let rows = y..(y + side).min(height);
        let inside = rows.flat_map(|row| (x..(x + side).min(width)).map(move |column| row * width + column));
        let pixels: Vec<usize> = inside.collect();
        for channel in 0..3 {
            tiles.push(tile(a, b, &pixels, x, y, channel));
        }
    }
    let total = |values: &[[f64; 3]], channel: usize| values.iter().map(|value| value[channel]).sum::<f64>();
    let mean_ratio = std::array::from_fn(|c| total(&a.mean, c) / total(&b.mean, c));
    let ratio_error = std::array::from_fn(|c| {
        let relative = |of: &Estimate| total(&of.variance_of_mean, c) / total(&of.mean, c).powi(2);
        (relative(a) + relative(b)).sqrt()
    });
    Comparison { tiles, mean_ratio, ratio_error }
}

fn tile(a: &Estimate, b: &Estimate, pixels: &[usize], x: usize, y: usize, channel: usize) -> Tile {
    let count = pixels.len() as f64;
    let mean = |of: &Estimate| pixels.iter().map(|&pixel| of.mean[pixel][channel]).sum::<f64>() / count;
    let means = [mean(a), mean(b)];
    let variance = |&pixel: &usize| a.variance_of_mean[pixel][channel] + b.variance_of_mean[pixel][channel];
    let mut variances: Vec<f64> = pixels.iter().map(variance).collect();
    variances.sort_by(|a, b| b.total_cmp(a));
    let total: f64 = variances.iter().sum();
    let few = pixels.len().div_ceil(100);
    let excess = ((means[0] - means[1]).abs() - ROUNDING * means[1].abs()).max(0.0);
    let z = if excess == 0.0 { 0.0 } else { excess / (total.sqrt() / count) };
    Tile { x, y, channel, means, z, inconclusive: variances[..few].iter().sum::<f64>() > total / 2.0 }
}

impl Comparison {
    /// Tiles that say nothing.
    pub fn inconclusive(&self) -> impl Iterator<Item = &Tile> {
        self.tiles.iter().filter(|tile| tile.inconclusive)
    }

    /// The conclusive tile with the largest z, if there is one.
    pub fn worst(&self) -> Option<&Tile> {
        self.tiles.iter().filter(|tile| !tile.inconclusive).max_by(|a, b| a.z.total_cmp(&b.z))
    }

    /// Panics, naming `what`, where a conclusive tile's z is above the critical one of all tiles (one false alarm in
    /// a million runs), or where more than the share `inconclusive` of the tiles says nothing.
    pub fn assert(&self, what: &str, inconclusive: f64) {
        let silent: Vec<_> = self.inconclusive().map(|tile| (tile.x, tile.y, tile.channel)).collect();
        let allowed = inconclusive * self.tiles.len() as f64;
        assert!(silent.len() as f64 <= allowed, "{what}: tiles (x, y, channel) that say nothing: {silent:?}");
        let worst = self.worst().expect("some tile says something");
        let critical = critical_z(self.tiles.len());
        assert!(worst.z <= critical, "{what}: z above {critical:.3} at {worst:?}; mean ratios {:?}", self.mean_ratio);
    }
}
