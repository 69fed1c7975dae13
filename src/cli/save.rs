//! Which files a render may write, and what they say about it.
//!
//! Comes in: paths from the command line, then a finished render. Goes out: a refusal, then the facts of the picture.

use std::path::Path;

use texray::named::Named;
use texray::output::{Metadata, target_of};
use texray::render::{CapBias, RenderReport, Settings};
use texray::scene::Scene;
use texray::{Error, Result, quote};

use super::engine::DeviceLine;
use super::settings::roulette_name;

/// Refuses two outputs with one name, and an output that is one of the files the scene is made of.
pub fn check_distinct(scene: &[&Path], outputs: &[&Path]) -> Result<()> {
    for (i, path) in outputs.iter().enumerate() {
        if scene.iter().any(|file| same(path, file)) {
            return Err(Error::Usage(format!("{}: the output is a file of the scene itself", quote::path(path))));
        }
        if outputs[..i].iter().any(|earlier| same(earlier, path)) {
            return Err(Error::Usage(format!("{}: two outputs have this name", quote::path(path))));
        }
    }
    Ok(())
}

/// Whether two paths name the same file, be it there already or not.
pub fn same(a: &Path, b: &Path) -> bool {
    let resolved = |path: &Path| {
        let path = &target_of(path);
        path.canonicalize().ok().or_else(|| {
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
            Some(folder.canonicalize().ok()?.join(path.file_name()?))
        })
    };
    a == b || resolved(a).is_some_and(|a| Some(a) == resolved(b)) || is_one_file(a, b)
}

/// Whether two names (hard links, say) are of one file. What is written to a device does not meet what else is.
#[cfg(unix)]
fn is_one_file(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let file =
        |path: &Path| path.metadata().ok().filter(std::fs::Metadata::is_file).map(|file| (file.dev(), file.ino()));
    file(a).is_some_and(|a| Some(a) == file(b))
}

#[cfg(not(unix))]
fn is_one_file(_: &Path, _: &Path) -> bool {
    false
}

/// What a picture file says about itself.
pub fn metadata(
    scene: &Scene,
    settings: &Settings,
    device: &DeviceLine,
    report: &RenderReport,
    cap_bias: Option<CapBias>,
) -> Metadata {
    let mut metadata = Metadata::new();
    let invalid: u64 = report.invalid_samples.values().sum();
    let [x, y, width, height] = settings.region();
    metadata
        .subject("scene_digest", scene.digest())
        .subject("size", format!("{}x{}", settings.width, settings.height))
        .subject("region", format!("{x},{y},{width},{height}"))
        .subject("max_bounces", settings.max_bounces)
        .subject("seed", settings.seed)
        .subject("filter", settings.filter.name())
        .subject("sampler", settings.sampler.name())
        .subject("intersector", settings.intersector.name())
        .subject("lights", settings.lights.name())
        .subject("light_pick", settings.light_pick.name())
        .subject("hemisphere", settings.hemisphere.name())
        .subject("roulette", roulette_name(settings.roulette))
        .fixed("version", env!("CARGO_PKG_VERSION"))
        .fixed("scene", &scene.name)
        .fixed("triangles", scene.triangles.len())
        .fixed("spp", report.spp)
        .fixed("accel", settings.accel.name())
        .fixed("builder", settings.builder.name())
        .fixed("buffers", report.buffers.name())
        .fixed("effects", report.effects.join(" "))
        .fixed("device", &device.name)
        .fixed("driver", &device.driver)
        .fixed("invalid_samples", invalid)
        .fixed("relative_rmse", report.relative_rmse.map_or("unknown".into(), |error| error.to_string()));
    if let Some(error) = report.error {
        metadata.fixed("relative_rmse_upper", error.upper).fixed("confidence", error.confidence);
    }
    if let Some(bias) = cap_bias {
        metadata.fixed("bias_bounce_cap", bias.bounce_cap).fixed("bias_standard_error", bias.standard_error);
    }
    metadata
        .varying("seconds_render", report.seconds.render)
        .varying("seconds_bvh", report.seconds.bvh)
        .varying("seconds_load", report.seconds.load);
    metadata
}
