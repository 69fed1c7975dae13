//! Stored references: small linear pictures by Mitsuba 3, with the variance of each of their numbers.
//!
//! Comes in: `tests/golden/NAME.json` and `NAME.bin`, as `tests/golden/mitsuba_golden.py` writes them, and the OBJ they
//! were made from. Goes out: a [`Golden`], its picture in file units or in a scene's scaled ones. A golden that is
//! missing, of the wrong size, or made from other geometry or materials is a failure that says how to make it anew.

use std::path::{Path, PathBuf};

use glam::DVec3;
use texray::scene::{Camera, Filter, Scaling, Scene};

use super::tracer::Estimate;

/// A stored reference, in the units of the scene's file.
#[derive(Clone, Debug)]
pub struct Golden {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Surface scatterings of a path.
    pub max_bounces: u32,
    /// The camera.
    pub camera: Camera,
    /// The picture (box filter) with its variances.
    pub picture: Estimate,
}

impl Golden {
    /// Loads the golden of that name, made from `scenes/NAME.obj` of this repository.
    pub fn load(name: &str) -> Result<Golden, String> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        Golden::read(&root.join("tests/golden").join(name), &root.join("scenes").join(format!("{name}.obj")))
    }

    /// Reads `BASE.json` and `BASE.bin`, and checks that they were made from the scene at `obj`.
    pub fn read(base: &Path, obj: &Path) -> Result<Golden, String> {
        let fail = |path: &Path, why: String| {
            format!(
                "{}: {why}\nmake it anew with: python tests/golden/mitsuba_golden.py --obj {} --out {}\n\
                 (needs: pip install mitsuba numpy; see the head of that file)",
                path.display(),
                obj.display(),
                base.display()
            )
        };
        let (json, bin) = (base.with_extension("json"), base.with_extension("bin"));
        let read = |path: &Path| std::fs::read(path).map_err(|error| fail(path, error.to_string()));
        let header: serde_json::Value =
            serde_json::from_slice(&read(&json)?).map_err(|error| fail(&json, error.to_string()))?;
        let number = |key: &str| header[key].as_u64().ok_or_else(|| fail(&json, format!("{key} is missing")));
        let vector = |key: &str| {
            let values: Vec<f64> =
                header["camera"][key].as_array()?.iter().filter_map(|value| value.as_f64()).collect();
            (values.len() == 3).then(|| DVec3::from_slice(&values))
        };
        let camera = || {
            let vfov = header["camera"]["vfov"].as_f64()?;
            Some(Camera { origin: vector("origin")?, target: vector("target")?, up: vector("up")?, vfov })
        };
        let (width, height) = (number("width")? as u32, number("height")? as u32);
        let content = content_hash(obj).map_err(|error| fail(obj, error.to_string()))?;
        if header["scene_content"].as_str() != Some(&content) {
            return Err(fail(&json, format!("made from another scene than {} is now ({content})", obj.display())));
        }
        let bytes = read(&bin)?;
        let pixels = width as usize * height as usize;
        if bytes.len() != pixels * 24 {
            let due = pixels * 24;
            return Err(fail(&bin, format!("{} bytes, but {width}x{height} pixels take {due}", bytes.len())));
        }
        let numbers: Vec<f64> = bytes.as_chunks::<4>().0.iter().map(|&word| f32::from_le_bytes(word).into()).collect();
        if let Some(wrong) = numbers.iter().find(|number| !number.is_finite() || **number < 0.0) {
            return Err(fail(&bin, format!("holds {wrong}")));
        }
        let mut colours = numbers.as_chunks::<3>().0.to_vec();
        let variance_of_mean = colours.split_off(pixels);
        Ok(Golden {
            width,
            height,
            max_bounces: number("max_bounces")? as u32,
            camera: camera().ok_or_else(|| fail(&json, "the camera is incomplete".into()))?,
            picture: Estimate { mean: colours, variance_of_mean },
        })
    }

    /// Gives a scene loaded from the same file the golden's camera, size and filter.
    pub fn prepare(&self, scene: &mut Scene) {
        let Scaling { centre, length_exponent, .. } = scene.scaling;
        let place = |position: DVec3| (position - centre) * 2f64.powi(length_exponent);
        scene.camera = Camera { origin: place(self.camera.origin), target: place(self.camera.target), ..self.camera };
        (scene.film.width, scene.film.height, scene.film.filter) = (self.width, self.height, Filter::Box);
    }

    /// The picture in scaled radiance.
    pub fn scaled(&self, scaling: &Scaling) -> Estimate {
        let factor = 2f64.powi(scaling.radiance_exponent);
        let times = |values: &[[f64; 3]], factor: f64| values.iter().map(|rgb| rgb.map(|c| c * factor)).collect();
        Estimate {
            mean: times(&self.picture.mean, factor),
            variance_of_mean: times(&self.picture.variance_of_mean, factor * factor),
        }
    }
}

/// What an OBJ and its MTL files say, as a 64-bit FNV-1a hash in hexadecimal: of every line that is neither empty nor
/// a comment, its words joined by single spaces, the OBJ first, then its MTL files in the order named.
pub fn content_hash(obj: &Path) -> std::io::Result<String> {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut libraries: Vec<PathBuf> = Vec::new();
    let mut take = |text: &str, libraries: &mut Vec<PathBuf>| {
        for line in text.lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            if words.is_empty() || words[0].starts_with('#') {
                continue;
            }
            if words[0] == "mtllib" {
                libraries.push(obj.with_file_name(words[1]));
            }
            for byte in words.join(" ").bytes().chain([b'\n']) {
                hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
            }
        }
    };
    take(&std::fs::read_to_string(obj)?, &mut libraries);
    for library in libraries.clone() {
        take(&std::fs::read_to_string(library)?, &mut Vec::new());
    }
    Ok(format!("{hash:016x}"))
}
