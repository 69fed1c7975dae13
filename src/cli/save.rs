//! Which files a render writes, and what they say about it.
//!
//! Comes in: paths from the command line, then a finished render. Goes out: checked files, then the files themselves.

use std::path::{Path, PathBuf};

use texray::output::{Display, Metadata, OutputFile, Picture};
use texray::render::{CapBias, RenderReport, Settings};
use texray::scene::Scene;
use texray::{Error, Result};

use super::engine::DeviceLine;
use super::settings::{name, roulette_name};

/// Checks the pictures asked for with `-o`; without any, SCENE.exr and SCENE.png in the working directory.
pub fn check(paths: &[PathBuf], scene_name: Option<&str>, no_clobber: bool) -> Result<Vec<OutputFile>> {
    let default: Vec<PathBuf>;
    let paths = match scene_name {
        Some(scene) if paths.is_empty() => {
            default = ["exr", "png"].map(|extension| PathBuf::from(format!("{scene}.{extension}"))).into();
            &default
        }
        _ => paths,
    };
    paths.iter().map(|path| OutputFile::check(path, no_clobber)).collect()
}

/// Refuses two outputs with one name, and an output that is one of the files the scene is made of.
pub fn check_distinct(scene: &[&Path], outputs: &[&Path]) -> Result<()> {
    for (i, path) in outputs.iter().enumerate() {
        if scene.iter().any(|file| same(path, file)) {
            return Err(Error::Usage(format!("{}: the output is a file of the scene itself", path.display())));
        }
        if outputs[..i].iter().any(|earlier| same(earlier, path)) {
            return Err(Error::Usage(format!("{}: two outputs have this name", path.display())));
        }
    }
    Ok(())
}

/// Whether two paths name the same file, be it there already or not.
pub fn same(a: &Path, b: &Path) -> bool {
    let resolved = |path: &Path| {
        path.canonicalize().ok().or_else(|| {
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
            Some(folder.canonicalize().ok()?.join(path.file_name()?))
        })
    };
    a == b || resolved(a).is_some_and(|a| Some(a) == resolved(b))
}

/// Writes every file; one that fails does not keep the others from being written.
pub fn write(files: &[OutputFile], picture: &Picture, display: &Display, metadata: &Metadata) -> Result<()> {
    let written: Vec<Result<()>> = files.iter().map(|file| file.write(picture, display, metadata)).collect();
    written.into_iter().collect()
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
    metadata
        .fixed("version", env!("CARGO_PKG_VERSION"))
        .fixed("scene", &scene.name)
        .fixed("triangles", scene.triangles.len())
        .fixed("size", format!("{}x{}", settings.width, settings.height))
        .fixed("spp", report.spp)
        .fixed("max_bounces", settings.max_bounces)
        .fixed("seed", settings.seed)
        .fixed("filter", name(&settings.filter))
        .fixed("sampler", name(&settings.sampler))
        .fixed("accel", name(&settings.accel))
        .fixed("builder", name(&settings.builder))
        .fixed("intersector", name(&settings.intersector))
        .fixed("lights", name(&settings.lights))
        .fixed("light_pick", name(&settings.light_pick))
        .fixed("hemisphere", name(&settings.hemisphere))
        .fixed("roulette", roulette_name(settings.roulette))
        .fixed("buffers", name(&report.buffers))
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
    if let Some([x, y, w, h]) = settings.crop {
        metadata.fixed("crop", format!("{x},{y},{w},{h}"));
    }
    metadata
        .varying("seconds_render", report.seconds.render)
        .varying("seconds_bvh", report.seconds.bvh)
        .varying("seconds_load", report.seconds.load);
    metadata
}
