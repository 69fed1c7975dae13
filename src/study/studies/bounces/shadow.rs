//! Where a picture shows a shadow that bounces fill.
//!
//! Comes in: a scene. Goes out: a window of a quarter of the picture's width and height, where direct light and shadows meet along the
//! longest lines and the shadows are brightest once there are bounces.

use crate::Result;
use crate::render::Tuning;
use crate::settings::Settings;
use crate::study::engine::Watch;
use crate::study::engine::subject::Subject;

/// Samples of the two pictures that the window is chosen by.
const SPP: u32 = 32;
/// The picture's width over the window's, and its height.
const SHARE: u32 = 4;
/// Direct light below this part of the picture's mean counts as none.
const DARK: f32 = 0.02;

/// The window `[x, y, width, height]` in pixels of a picture of `size`; `None` where the watch stopped it. The same for the same
/// scene, size and device.
pub fn window(subject: &Subject, size: [u32; 2], longest: u32, watch: &dyn Watch) -> Result<Option<[u32; 4]>> {
    let settings = |max_bounces| Settings { max_bounces, ..subject.settings(size, SPP) };
    let mut greys = Vec::new();
    for bounces in [1, longest] {
        let Some(rendered) = subject.render(&settings(bounces), &Tuning::default(), watch)? else { return Ok(None) };
        greys.push(rendered.film.mean().iter().map(|rgb| rgb.iter().sum::<f32>() / 3.0).collect::<Vec<f32>>());
    }
    Ok(Some(best(&greys[0], &greys[1], size)))
}

/// The window with the highest score, among those a quarter of its own size apart.
fn best(direct: &[f32], full: &[f32], [width, height]: [u32; 2]) -> [u32; 4] {
    let [w, h] = [(width / SHARE).max(1), (height / SHARE).max(1)];
    let dark = DARK * direct.iter().sum::<f32>() / direct.len().max(1) as f32;
    let shadowed = |x: u32, y: u32| direct[(y * width + x) as usize] <= dark;
    let score = |x: u32, y: u32| {
        let (mut pixels, mut fill, mut edges) = (0u32, 0.0, 0u32);
        for (column, row) in (y..y + h).flat_map(|row| (x..x + w).map(move |column| (column, row))) {
            let here = shadowed(column, row);
            edges += u32::from(column + 1 < x + w && here != shadowed(column + 1, row));
            edges += u32::from(row + 1 < y + h && here != shadowed(column, row + 1));
            if here {
                pixels += 1;
                fill += full[(row * width + column) as usize];
            }
        }
        f64::from(edges) * f64::from(fill) / f64::from(pixels.max(1))
    };
    let places = |extent: u32, part: u32| (0..=extent - part).step_by((part / 4).max(1) as usize);
    let mut best = (f64::NEG_INFINITY, [0, 0, w, h]);
    for y in places(height, h) {
        for x in places(width, w) {
            let score = score(x, y);
            if score > best.0 {
                best = (score, [x, y, w, h]);
            }
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_window_lies_on_the_edge_of_the_brightest_shadow() {
        let (width, height) = (32, 32);
        // Direct light left of x = 16. Bounces fill the dark right half, most below y = 16.
        let pixels = || (0..width * height).map(|pixel| (pixel % width, pixel / width));
        let direct: Vec<f32> = pixels().map(|(x, _)| if x < 16 { 1.0 } else { 0.0 }).collect();
        let full: Vec<f32> = pixels()
            .map(|(x, y)| {
                if x < 16 {
                    1.2
                } else if y < 16 {
                    0.1
                } else {
                    0.5
                }
            })
            .collect();
        assert_eq!(best(&direct, &full, [width, height]), [10, 16, 8, 8]);
    }
}
