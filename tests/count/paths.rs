//! A render in which nothing follows the clock: what `tests/count.sh` counts the instructions of.
//!
//! Comes in: a scene, a width, a height and samples per pixel. Goes out: the number of paths, on standard output. Run
//! length, slice, step budget and tile are fixed, so that the same dispatches follow one another on every machine and
//! at every speed.

use std::error::Error;
use std::path::Path;

use texray::gpu::{Context, ContextOptions};
use texray::render::{Observer, Progress, Renderer, Settings, Tuning};
use texray::scene::Scene;

struct Quiet;

impl Observer for Quiet {
    fn progress(&mut self, _: &Progress) {}
    fn stop_requested(&self) -> bool {
        false
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, width, height, spp] = &arguments[..] else {
        return Err("usage: count_paths SCENE WIDTH HEIGHT SPP".into());
    };
    let scene = Scene::load(Path::new(scene))?;
    let (width, height, spp) = (width.parse()?, height.parse()?, spp.parse()?);
    let settings = Settings { width, height, spp, ..Settings::for_scene(&scene) };
    let tuning = Tuning {
        tile: Some([width, height]),
        budget: Some(4000),
        run_samples: Some(16),
        slice_pixels: Some(width * height),
        ..Tuning::default()
    };
    let context = Context::new(&ContextOptions::default())?;
    let rendered = Renderer::new(&context, &scene, &settings, &tuning)?.render(&mut Quiet)?;
    println!("{}", rendered.report.paths);
    Ok(())
}
