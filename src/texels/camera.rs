//! The camera record and the pixel filter's table.
//!
//! A filter is drawn from, not weighted with: the table holds its inverse distribution, so that a pixel's samples are its own
//! and pixels stay independent (Ernst, Stamminger, Greiner, "Filter importance sampling", 2006).

use super::Texel;
use crate::interface::{FILTER_BOX, FILTER_ENTRIES, FILTER_TABLE};
use crate::scene::{Camera, Filter};

/// The four texels of the camera for a picture of `width` x `height` pixels.
pub fn camera_texels(camera: &Camera, width: u32, height: u32, filter: Filter) -> [Texel; 4] {
    let basis = camera.basis(height);
    let kind = if filter == Filter::Box { FILTER_BOX } else { FILTER_TABLE };
    let texel = |v: glam::DVec3, word: u32| {
        let v = v.as_vec3();
        [v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), word]
    };
    [
        texel(camera.origin, kind),
        texel(basis.forward, (width as f32).to_bits()),
        texel(basis.right, (height as f32).to_bits()),
        texel(basis.down, 0),
    ]
}

/// The filter's inverse distribution at `i / (FILTER_ENTRIES - 1)`, offsets in pixels, four a texel.
pub fn filter_texels(filter: Filter) -> Vec<Texel> {
    let offsets = inverse_distribution(filter);
    offsets.chunks_exact(4).map(|four| [four[0], four[1], four[2], four[3]].map(|x| (x as f32).to_bits())).collect()
}

/// Value of the filter, not normalised, at `x` pixels from the centre; 0 beyond its radius.
fn value(filter: Filter, x: f64) -> f64 {
    use std::f64::consts::PI;
    match filter {
        Filter::Box => f64::from(u8::from(x.abs() <= 0.5)),
        Filter::Tent => (1.0 - x.abs()).max(0.0),
        // Standard deviation 0.5 pixels.
        Filter::Gaussian => (-2.0 * x * x).exp(),
        // Harris 1978, the four-term window of -92 dB.
        Filter::BlackmanHarris => {
            let t = 2.0 * PI * (x / 3.0 + 0.5);
            0.35875 - 0.48829 * t.cos() + 0.14128 * (2.0 * t).cos() - 0.01168 * (3.0 * t).cos()
        }
    }
}

fn radius(filter: Filter) -> f64 {
    match filter {
        Filter::Box => 0.5,
        Filter::Tent => 1.0,
        Filter::Gaussian | Filter::BlackmanHarris => 1.5,
    }
}

fn inverse_distribution(filter: Filter) -> Vec<f64> {
    const CELLS: usize = 1 << 16;
    let radius = radius(filter);
    let width = 2.0 * radius / CELLS as f64;
    // Midpoint rule: the error of a cell is of the order of width^3, below f32 after 65,536 of them.
    let mut cumulative = vec![0.0; CELLS + 1];
    for i in 0..CELLS {
        cumulative[i + 1] = cumulative[i] + value(filter, -radius + (i as f64 + 0.5) * width);
    }
    let total = cumulative[CELLS];
    let mut cell = 0;
    (0..FILTER_ENTRIES)
        .map(|entry| {
            let target = total * f64::from(entry) / f64::from(FILTER_ENTRIES - 1);
            while cell + 1 < CELLS && cumulative[cell + 1] < target {
                cell += 1;
            }
            let share = cumulative[cell + 1] - cumulative[cell];
            let inside = if share > 0.0 { ((target - cumulative[cell]) / share).clamp(0.0, 1.0) } else { 0.0 };
            -radius + (cell as f64 + inside) * width
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distributions_are_symmetric_and_rise() {
        for filter in [Filter::Box, Filter::Tent, Filter::Gaussian, Filter::BlackmanHarris] {
            let offsets = inverse_distribution(filter);
            assert_eq!(offsets.len(), FILTER_ENTRIES as usize);
            for (i, pair) in offsets.windows(2).enumerate() {
                assert!(pair[0] <= pair[1], "{filter:?} falls at {i}");
            }
            for (low, high) in offsets.iter().zip(offsets.iter().rev()) {
                assert!((low + high).abs() < 2e-3, "{filter:?} is not symmetric: {low} {high}");
            }
        }
    }

    #[test]
    fn the_tents_quartile_is_its_closed_form() {
        // P(x < -r) = (1 - r)^2 / 2 = 1/4 at r = 1 - sqrt(1/2).
        let offsets = inverse_distribution(Filter::Tent);
        let quartile = f64::from(FILTER_ENTRIES - 1) / 4.0;
        let (low, t) = (quartile.floor() as usize, quartile.fract());
        let found = offsets[low] * (1.0 - t) + offsets[low + 1] * t;
        assert!((found + 1.0 - 0.5f64.sqrt()).abs() < 1e-5);
    }
}
