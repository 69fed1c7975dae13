//! From a path to a [`Scene`].
//!
//! Comes in: the path of a `.toml` scene or a bare `.obj`. Goes out: a checked scene, or all that is refused in the
//! first file that is. A bare OBJ gets a camera that frames its bounds, and a white sky if nothing in it emits.

use std::path::Path;

use glam::DVec3;

use super::assemble::{RawScene, assemble, assemble_bare};
use super::normalise::{bounds, normalise};
use super::{Camera, LoadReport, MaterialKind, RenderDefaults, Scene, foreign_format, scene_file, source_text};
use crate::{Error, Result, quote};

/// Vertical field of view of the camera that frames a bare OBJ, in degrees.
const FRAMING_VFOV: f64 = 30.0;

impl Scene {
    /// Reads and checks a `.toml` scene or a bare `.obj`. A scene that cannot emit is loaded: see [`Scene::check_emits`].
    pub fn load(path: &Path) -> Result<Scene> {
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or("").to_ascii_lowercase();
        match extension.as_str() {
            "toml" => load_toml(path),
            "obj" => load_bare(path),
            _ => Err(Error::scene(
                path,
                0,
                foreign_format(path)
                    .unwrap_or_else(|| "not a scene; allowed are files that end in .toml or .obj".into()),
            )),
        }
    }

    /// Refuses a scene in which nothing can emit: its picture would be black.
    pub fn check_emits(&self) -> Result<()> {
        // Materials that no triangle uses are left out at load.
        if self.sky.is_some() || self.materials.iter().any(super::Material::emits) {
            return Ok(());
        }
        let message = "nothing in the scene emits light; allowed are a material with ke (Ke) above 0, or [environment]";
        Err(Error::scene(&self.path, 0, message))
    }
}

fn load_toml(path: &Path) -> Result<Scene> {
    let bytes = source_text::read_bytes(path).map_err(|reason| Error::scene(path, 0, reason))?;
    let text = source_text::decode(path, bytes)?;
    let file = scene_file::read(path, &text)?;
    let raw = assemble(path, &file.meshes, &file.materials)?;
    finish(path, raw, file.camera_line, file.camera, file.film, file.render, file.sky)
}

fn load_bare(path: &Path) -> Result<Scene> {
    let mut raw = assemble_bare(path)?;
    let emits = |triangle: &super::assemble::RawTriangle| raw.materials[triangle.material as usize].1.ke != [0.0; 3];
    let lamps = raw.triangles.iter().filter(|triangle| emits(triangle)).count();
    let sky = if lamps > 0 { None } else { Some([1.0; 3]) };
    let camera = framing(&raw);
    let file = quote::path(path);
    let [x, y, z] = camera.origin.to_array().map(|coordinate| format!("{coordinate:.4}"));
    raw.notes.add("cameras", || {
        format!("{file}: an OBJ file has no camera; one at ({x}, {y}, {z}) looks along -z, {FRAMING_VFOV} degrees high")
    });
    raw.notes.add("light", || match lamps {
        0 => format!("{file}: nothing in it emits; a white sky of radiance 1 lights it"),
        _ => format!("{file}: its {lamps} triangles that emit (Ke) light it; there is no sky"),
    });
    if lamps > 0 && shows_nothing(&raw, &camera) {
        raw.warnings.add("black pictures", || {
            format!(
                "{file}: the camera sees nothing but backs of lamps, which emit from their fronts alone (where the \
                 corners turn counter-clockwise): the picture is black; a .toml scene sets another camera"
            )
        });
    }
    finish(path, raw, 0, camera, scene_file::DEFAULT_FILM, RenderDefaults::default(), sky)
}

/// A camera in front of the scene (at +z, as modelling programs export) whose picture holds the sphere around its bounds.
fn framing(raw: &RawScene) -> Camera {
    let (low, high) = bounds(&raw.triangles).unwrap_or((DVec3::NEG_ONE, DVec3::ONE));
    let target = low + (high - low) / 2.0;
    let size = (high - low).max_element();
    let radius = size * ((high - low) / size / 2.0).length();
    // The default film is wider than high, so the height decides.
    let distance = radius / (FRAMING_VFOV / 2.0).to_radians().sin();
    Camera { origin: target + DVec3::Z * distance, target, up: DVec3::Y, vfov: FRAMING_VFOV }
}

/// Whether no front of a lamp faces the camera and nothing is there that a lamp could light.
fn shows_nothing(raw: &RawScene, camera: &Camera) -> bool {
    raw.triangles.iter().all(|triangle| {
        let recipe = &raw.materials[triangle.material as usize].1;
        let reflects = match recipe.kind() {
            MaterialKind::Lambert { albedo } => albedo != [0.0; 3],
            MaterialKind::Mirror { reflectance } => reflectance != [0.0; 3],
            _ => true,
        };
        let [a, b, c] = triangle.positions;
        let scale = (b - a).abs().max((c - a).abs()).max_element();
        let front = ((b - a) / scale).cross((c - a) / scale);
        !reflects && (recipe.ke == [0.0; 3] || front.dot(camera.origin - a) <= 0.0)
    })
}

fn finish(
    path: &Path,
    mut raw: RawScene,
    camera_line: usize,
    camera: Camera,
    film: super::FilmSettings,
    render: RenderDefaults,
    sky: Option<[f64; 3]>,
) -> Result<Scene> {
    let scaled = normalise(path, camera_line, &raw, &camera, sky)?;
    let files = std::mem::take(&mut raw.files);
    let mut warnings = std::mem::take(&mut raw.warnings).finish();
    let notes = std::mem::take(&mut raw.notes).finish();
    if scaled.degenerate > 0 {
        warnings.push(format!("{}: {} degenerate triangles removed", quote::path(path), scaled.degenerate));
    }
    Ok(Scene {
        name: path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned()),
        path: path.to_owned(),
        camera: scaled.camera,
        film,
        render,
        triangles: scaled.triangles,
        corners: scaled.corners,
        materials: scaled.materials,
        sky: scaled.sky,
        scaling: scaled.scaling,
        report: LoadReport { files, degenerate_triangles: scaled.degenerate, warnings, notes },
    })
}
