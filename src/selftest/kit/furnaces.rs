//! Furnaces: scenes whose radiance is a geometric series, or 1.
//!
//! Comes in: an albedo. Goes out: a scene, what it should show, and how a render compares.

use crate::Result;
use crate::scene::Scene;
use crate::selftest::kit::TestBench;
use crate::selftest::kit::scenes::{SceneBuilder, camera, glass, lambert, mirror};
use crate::settings::Settings;
use crate::statistics::Finding;
use crate::statistics::Moments;

/// A closed cube that emits 1 and reflects `albedo`, diffuse or, with `mirrors`, two facing walls of it as mirrors do.
pub fn furnace(albedo: f32, mirrors: bool) -> Scene {
    let mut builder = SceneBuilder::new();
    let walls = builder.material(lambert(albedo, 1.0));
    let sides = if mirrors { builder.material(mirror(albedo, 1.0)) } else { walls };
    let (low, [x, y, z]) = ([-1.0; 3], [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]]);
    builder.quad(low, y, z, sides);
    builder.quad([1.0, -1.0, -1.0], z, y, sides);
    builder.quad(low, z, x, walls);
    builder.quad([-1.0, 1.0, -1.0], x, z, walls);
    builder.quad(low, x, y, walls);
    builder.quad([-1.0, -1.0, 1.0], y, x, walls);
    builder.finish(camera([0.1, 0.2, 0.3], [1.0, 0.0, 0.0], 70.0), None)
}

/// Radiance of a furnace after `bounces` scatterings; `albedo` as f32 has it.
pub fn series(albedo: f32, bounces: u32) -> f64 {
    let a = f64::from(albedo);
    (1.0 - a.powi(bounces as i32 + 1)) / (1.0 - a)
}

/// The mean over a picture whose pixels have one expectation.
pub fn mean(bench: &TestBench, what: String, scene: &Scene, settings: &Settings, expected: f64) -> Result<Finding> {
    let rendered = bench.render(scene, settings)?;
    let pixels = Moments::of(rendered.film.mean().into_iter().map(|pixel| f64::from(pixel[0])));
    Ok(Finding::mean(what, expected, &pixels))
}

/// Furnaces of every material, closed, open, and lit by a small light.
pub fn furnaces() -> Vec<(&'static str, Scene)> {
    let mut closed = SceneBuilder::new();
    let walls = closed.material(lambert(0.9, 1.0));
    closed.cuboid([-1.0; 3], [1.0; 3], walls, true);
    let mut open = SceneBuilder::new();
    let [white, shiny, clear] =
        [lambert(1.0, 0.0), mirror(1.0, 0.0), glass(1.5)].map(|material| open.material(material));
    open.sphere([-0.7, 0.0, 0.0], 0.5, 3, white, true);
    open.sphere([0.7, 0.0, 0.0], 0.5, 3, clear, true);
    open.cuboid([-2.0, -1.0, -1.0], [2.0, -0.6, 1.0], shiny, false);
    vec![
        ("mixed box", mixed_box()),
        ("closed furnace", closed.finish(camera([0.1, 0.2, 0.3], [1.0, 0.0, 0.0], 70.0), None)),
        ("open furnace", open.finish(camera([0.0, 1.0, -4.0], [0.0; 3], 50.0), Some([1.0; 3]))),
    ]
}

fn mixed_box() -> Scene {
    let mut builder = SceneBuilder::new();
    let [walls, mirrors, body, light] =
        [lambert(0.5, 1.0), mirror(0.9, 0.0), glass(1.5), lambert(0.5, 4.0)].map(|material| builder.material(material));
    builder.cuboid([-1.0; 3], [1.0; 3], walls, true);
    builder.sphere([-0.4, 0.0, 0.3], 0.3, 3, body, true);
    builder.sphere([0.4, 0.0, 0.3], 0.3, 2, mirrors, false);
    builder.quad([-0.2, 0.99, -0.2], [0.4, 0.0, 0.0], [0.0, 0.0, 0.4], light);
    builder.finish(camera([0.0, 0.0, -0.9], [0.0, 0.0, 1.0], 70.0), None)
}
