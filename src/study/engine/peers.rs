//! Other renderers on the same scenes and cores, through scripts that the user points to.
//!
//! Comes in: a folder with `mitsuba_render.py` and `cycles_render.py`, a scene of one OBJ file. Goes out: the figures that a script leaves in
//! OUT.json (`mpaths_s`, `spp`, `s_render`) and the picture in OUT.exr. A peer that is not installed is left out, and said.

use std::path::{Path, PathBuf};
use std::process::Command;

use exr::prelude::read_first_rgba_layer_from_file;
use serde_json::Value;

use crate::scene::Scene;
use crate::study::engine::subprocess::number;
use crate::{Error, Result};

/// A renderer, in one of its configurations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Peer {
    /// Mitsuba 3, LLVM and Embree, independent samples.
    Mitsuba,
    /// The same without Russian roulette.
    MitsubaNoRoulette,
    /// Mitsuba 3, correlated multi-jittered samples.
    MitsubaMultijitter,
    /// Blender's Cycles, as its script sets it up.
    Cycles,
}

/// What one run gave.
#[derive(Debug)]
pub struct PeerRun {
    /// Millions of paths a second, without loading and compiling.
    pub mpaths_per_second: f64,
    /// Samples a pixel that it made (some samplers round them up).
    pub spp: f64,
    /// Seconds of the timed render.
    pub seconds: f64,
    /// The picture, in the scene's units.
    pub picture: Vec<[f32; 3]>,
}

/// Where the peers are.
#[derive(Clone, Debug)]
pub struct Peers {
    /// Folder of the scripts.
    pub scripts: PathBuf,
    /// A Python that has Mitsuba.
    pub python: PathBuf,
}

impl Peer {
    /// All of them.
    pub const ALL: [Peer; 4] = [Peer::Mitsuba, Peer::MitsubaNoRoulette, Peer::MitsubaMultijitter, Peer::Cycles];

    /// Its name in rows and tables.
    pub fn name(self) -> &'static str {
        match self {
            Peer::Mitsuba => "mitsuba",
            Peer::MitsubaNoRoulette => "mitsuba-no-roulette",
            Peer::MitsubaMultijitter => "mitsuba-multijitter",
            Peer::Cycles => "cycles",
        }
    }

    /// What its script is given beside the scene.
    fn arguments(self) -> &'static [&'static str] {
        match self {
            Peer::Mitsuba => &["--variant", "llvm_ad_rgb"],
            Peer::MitsubaNoRoulette => &["--variant", "llvm_ad_rgb", "--rr-depth", "1000"],
            Peer::MitsubaMultijitter => &["--variant", "llvm_ad_rgb", "--sampler", "multijitter"],
            Peer::Cycles => &[],
        }
    }
}

impl Peers {
    /// The peers that can be run here; of each that cannot, why.
    pub fn installed(&self) -> (Vec<Peer>, Vec<String>) {
        let runs = |program: &Path, arguments: &[&str]| {
            let output = Command::new(program).args(arguments).output();
            output.is_ok_and(|output| output.status.success())
        };
        let mitsuba = runs(&self.python, &["-c", "import mitsuba, numpy"]);
        let cycles = runs(Path::new("blender"), &["--version"]);
        let mut missing = Vec::new();
        if !mitsuba {
            missing.push(format!("{} has no mitsuba and numpy (set MITSUBA_PYTHON): left out", self.python.display()));
        }
        if !cycles {
            missing.push("blender is not installed: Cycles is left out".into());
        }
        let here = |peer: &Peer| if *peer == Peer::Cycles { cycles } else { mitsuba };
        (Peer::ALL.into_iter().filter(here).collect(), missing)
    }

    /// One render; the scripts' own box filter.
    pub fn render(
        &self,
        peer: Peer,
        scene: &Scene,
        [width, height]: [u32; 2],
        spp: u32,
        max_bounces: u32,
        seed: u32,
    ) -> Result<PeerRun> {
        let obj = mesh(scene)?;
        let folder = tempfile::tempdir().map_err(|error| Error::output(std::env::temp_dir(), error.to_string()))?;
        let out = folder.path().join("peer");
        let mut command = match peer {
            Peer::Cycles => {
                let mut command = Command::new("blender");
                command
                    .args(["-b", "--factory-startup", "--python"])
                    .arg(self.scripts.join("cycles_render.py"))
                    .arg("--");
                command
            }
            _ => {
                let mut command = Command::new(&self.python);
                command.arg(self.scripts.join("mitsuba_render.py"));
                command
            }
        };
        command.env("PYTHONDONTWRITEBYTECODE", "1").arg("--obj").arg(obj).arg("--out").arg(&out);
        command.args(peer.arguments()).args(camera(scene));
        for (name, value) in
            [("--width", width), ("--height", height), ("--spp", spp), ("--bounces", max_bounces), ("--seed", seed)]
        {
            command.arg(name).arg(value.to_string());
        }
        let output =
            command.output().map_err(|error| Error::Usage(format!("{}: cannot be started: {error}", peer.name())))?;
        let complaint = String::from_utf8_lossy(&output.stderr);
        let failed = |why: &str| Error::Usage(format!("{}: {why}: {}", peer.name(), last_line(&complaint)));
        let text = std::fs::read_to_string(out.with_extension("json")).map_err(|_| failed("no figures"))?;
        let figures: Value = serde_json::from_str(&text).map_err(|_| failed("figures that are not JSON"))?;
        let figure = |name: &str| number(&figures, &[name]).map_err(|_| failed(&format!("no {name}")));
        Ok(PeerRun {
            mpaths_per_second: figure("mpaths_s")?,
            spp: figure("spp")?,
            seconds: figure("s_render")?,
            picture: read_exr(&out.with_extension("exr"))?,
        })
    }
}

/// The scene's only mesh file. A peer reads nothing of the scene but this and the camera.
fn mesh(scene: &Scene) -> Result<&Path> {
    let meshes =
        || scene.report.files.iter().filter(|file| file.extension().is_some_and(|extension| extension == "obj"));
    match (meshes().next(), meshes().count()) {
        (Some(only), 1) => Ok(only),
        _ => Err(Error::Usage(format!("{}: peers need a scene of one .obj file", scene.path.display()))),
    }
}

/// The camera in the file's units, as the scripts take it.
fn camera(scene: &Scene) -> Vec<String> {
    let scale = 2f64.powi(-scene.scaling.length_exponent);
    let point = |p: glam::DVec3| (p * scale + scene.scaling.centre).to_array();
    let mut arguments = Vec::new();
    for (name, value) in [
        ("--origin", point(scene.camera.origin)),
        ("--target", point(scene.camera.target)),
        ("--up", scene.camera.up.to_array()),
    ] {
        arguments.push(name.into());
        arguments.extend(value.map(|x| format!("{x:.12}")));
    }
    arguments.extend(["--vfov".into(), format!("{:.9}", scene.camera.vfov)]);
    arguments
}

fn last_line(text: &str) -> &str {
    text.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or("no message")
}

fn read_exr(path: &Path) -> Result<Vec<[f32; 3]>> {
    let image = read_first_rgba_layer_from_file(
        path,
        |size, _| (size.0, vec![[0.0; 3]; size.0 * size.1]),
        |(width, pixels): &mut (usize, Vec<[f32; 3]>), at, (r, g, b, _): (f32, f32, f32, f32)| {
            pixels[at.1 * *width + at.0] = [r, g, b];
        },
    )
    .map_err(|error| Error::Usage(format!("{}: no picture: {error}", path.display())))?;
    Ok(image.layer_data.channel_data.pixels.1)
}
