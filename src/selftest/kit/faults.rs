//! Scenes with faults in known places: numbers that are none, and who makes them first.
//!
//! Comes in: materials. Goes out: scenes. May be assumed: what is faulty fills whole pixels, and nothing else is.

use crate::scene::{Material, Scene};
use crate::selftest::kit::scenes::{SceneBuilder, camera, glass, lambert, mirror};

/// Pixels to a side of the pictures.
pub const SIDE: u32 = 8;

/// A black wall that emits 1, seen squarely, with a small quad of each of `materials` that fills one pixel: (1, 1), (3, 2),
/// (5, 3) ... A camera at distance 1 from the wall; the view is 2 wide.
pub fn spotted_wall(materials: &[Material], sky: Option<[f32; 3]>) -> Scene {
    let mut builder = SceneBuilder::new();
    let wall = builder.material(lambert(0.0, 1.0));
    builder.quad([2.0, -2.0, 1.0], [-4.0, 0.0, 0.0], [0.0, 4.0, 0.0], wall);
    for (index, material) in materials.iter().enumerate() {
        let spot = builder.material(material.clone());
        let [x, y] = spot_pixel(index).map(f64::from);
        let (pixel, distance) = (2.0 / f64::from(SIDE), 0.5);
        // The wall is 1 away and 2 wide; at half of it a pixel is half as wide. x grows to the right of a camera that looks
        // along +z with y up, which is -x.
        let corner = [(1.0 - x * pixel) * distance, (1.0 - y * pixel) * distance, distance];
        builder.quad(corner, [0.0, -pixel * distance, 0.0], [-pixel * distance, 0.0, 0.0], spot);
    }
    builder.finish(camera([0.0; 3], [0.0, 0.0, 1.0], 90.0), sky)
}

/// A black emitter whose red is `red`; the other channels are 1, so that it counts as a light whatever red is.
pub fn emitter(red: f32) -> Material {
    Material { emission: [red, 1.0, 1.0], ..lambert(0.0, 1.0) }
}

/// The pixel that spot `index` fills.
pub fn spot_pixel(index: usize) -> [u32; 2] {
    [1 + 2 * index as u32, 1 + index as u32]
}

/// For each cause a scene in which it is the first to make a NaN.
pub fn causes() -> Vec<(&'static str, Scene)> {
    let nan = f32::NAN;
    let mut scenes: Vec<_> = [("emission", emitter(nan)), ("mirror", mirror(nan, 0.0)), ("glass", glass(nan))]
        .into_iter()
        .map(|(cause, spot)| (cause, spotted_wall(&[spot], Some([1.0; 3]))))
        .collect();
    // A wall lit by the sky alone has no light samples, so its lobe is the first.
    for (cause, lamp) in [("lambert", false), ("light", true)] {
        let mut builder = SceneBuilder::new();
        let [wall, light] = [lambert(nan, 0.0), lambert(0.0, 1.0)].map(|material| builder.material(material));
        builder.quad([2.0, -2.0, 1.0], [-4.0, 0.0, 0.0], [0.0, 4.0, 0.0], wall);
        if lamp {
            builder.quad([1.0, -1.0, -1.0], [0.0, 2.0, 0.0], [-2.0, 0.0, 0.0], light);
        }
        scenes.push((cause, builder.finish(camera([0.0; 3], [0.0, 0.0, 1.0], 60.0), Some([1.0; 3]))));
    }
    let mut empty = SceneBuilder::new().finish(camera([0.0; 3], [0.0, 0.0, 1.0], 60.0), Some([1.0; 3]));
    empty.sky = Some([nan, 1.0, 1.0]);
    scenes.push(("sky", empty.clone()));
    empty.sky = Some([1.0; 3]);
    empty.camera.vfov = f64::NAN;
    scenes.push(("camera", empty));
    scenes
}
