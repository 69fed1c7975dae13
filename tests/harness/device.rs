//! One device a test program, under validation with synchronisation validation, and renders on it.
//!
//! Comes in: scenes and settings. Goes out: finished renders; any validation message fails the test that finds it. A missing
//! driver or layer fails too, in the words of the library's own error, which says what to install.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use texray::gpu::{Context, ContextOptions};
use texray::render::{Rendered, Renderer, Tuning};
use texray::scene::Scene;
use texray::selftest::kit::probe::Probe;
#[allow(unused_imports)]
pub use texray::selftest::kit::test_bench::{Silent, plain_settings};
use texray::settings::Settings;
use texray::texels::Texel;

use super::tracer::Estimate;

/// The device of this test program.
pub fn context() -> &'static Context {
    static CONTEXT: OnceLock<Context> = OnceLock::new();
    CONTEXT.get_or_init(|| {
        Context::new(&ContextOptions { validation: true, ..ContextOptions::default() })
            .unwrap_or_else(|error| panic!("the tests need a device and the validation layer: {error}"))
    })
}

/// Fails on any validation message so far.
pub fn assert_valid(context: &Context) {
    let report = context.validation();
    assert!(report.is_clean(), "validation messages: {report:#?}");
}

/// Runs a probe; any validation message fails the test.
pub fn run_probe(probe: &Probe) -> Vec<Texel> {
    let answers = probe.run(context()).expect("the probe runs");
    assert_valid(context());
    answers
}

/// Renders with sizes of the library's own choice.
pub fn render(scene: &Scene, settings: &Settings) -> Rendered {
    render_tuned(scene, settings, &Tuning::default())
}

/// Renders with pinned sizes.
pub fn render_tuned(scene: &Scene, settings: &Settings, tuning: &Tuning) -> Rendered {
    let renderer = Renderer::new(context(), scene, settings, tuning).expect("the scene can be rendered");
    let rendered = renderer.render(&mut Silent).expect("the render ends");
    assert_valid(context());
    rendered
}

/// The picture's bits, for tests of equality.
pub fn bits(rendered: &Rendered) -> Vec<[u32; 3]> {
    rendered.film.mean().into_iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

/// Fails where two pictures differ in a bit, saying where first and in how many pixels.
pub fn assert_same(a: &[[u32; 3]], b: &[[u32; 3]], what: &str) {
    assert_eq!(a.len(), b.len(), "{what}: sizes differ");
    let differing = a.iter().zip(b).filter(|(a, b)| a != b).count();
    if let Some(first) = a.iter().zip(b).position(|(a, b)| a != b) {
        let floats = |pixel: [u32; 3]| pixel.map(f32::from_bits);
        let (a, b) = (floats(a[first]), floats(b[first]));
        panic!("{what}: {differing} pixels differ, the first is {first}: {a:?} against {b:?}");
    }
}

/// Mean and variance of the mean in scaled radiance, from the replicates of one render.
/// True for independent samples; replicates of a Sobol' sequence are independent too.
pub fn estimate(scene: &Scene, settings: &Settings) -> Estimate {
    let rendered = render(scene, settings);
    assert!(rendered.report.invalid_samples.values().all(|&count| count == 0), "samples were left out");
    let estimate = rendered.film.estimate();
    let scale = 2f64.powi(scene.scaling.radiance_exponent);
    Estimate {
        mean: estimate.mean.iter().map(|rgb| rgb.map(|value| f64::from(value) * scale)).collect(),
        variance_of_mean: estimate.variance.iter().map(|rgb| rgb.map(|value| value * scale * scale)).collect(),
    }
}

/// Every scene of the repository.
pub fn scene_files() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .expect("scenes/ is there")
        .map(|entry| entry.expect("scenes/ can be read").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .collect();
    files.sort();
    assert!(!files.is_empty(), "scenes/ holds no scene");
    files
}

/// A scene of the repository by name.
pub fn load(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(format!("{name}.toml"));
    Scene::load(&path).unwrap_or_else(|error| panic!("{error}"))
}
