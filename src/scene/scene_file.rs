//! What a `.toml` scene says, before any mesh is read.
//!
//! Comes in: the text of a scene file. Goes out: a [`SceneFile`] whose numbers are in range. Keys:
//!
//! ```toml
//! [camera]            # origin, target, up, vfov (degrees)
//! [film]              # width, height, filter; left out: 800 x 600, Blackman-Harris
//! [render]            # spp, max_bounces
//! [[mesh]]            # file; scale, rotate = { axis, degrees }, translate, in this order, or matrix; material
//! [material.NAME]     # kd, ks, ke, illum, ni, d: the statements of MTL in lower case
//! [environment]       # color, strength
//! ```

use std::path::{Path, PathBuf};

use glam::{DMat3, DVec3};

use super::recipe::{Quantity, Recipe};
use super::source_text::check_memory;
use super::toml_source::Source;
use super::toml_table::{Entry, Table};
use super::transform::{Transform, rotation};
use super::{Camera, FilmSettings, Filter, RenderDefaults};
use crate::Result;

/// A scene file.
pub(super) struct SceneFile {
    /// The camera in file units.
    pub camera: Camera,
    /// Line of `[camera]`.
    pub camera_line: usize,
    /// Picture size and filter.
    pub film: FilmSettings,
    /// Samples and bounces asked for.
    pub render: RenderDefaults,
    /// Meshes in file order.
    pub meshes: Vec<MeshEntry>,
    /// Materials in file order.
    pub materials: Vec<MaterialEntry>,
    /// Radiance of the environment, in file units.
    pub sky: Option<[f64; 3]>,
}

/// One `[[mesh]]`.
pub(super) struct MeshEntry {
    /// The OBJ file, beside the scene file.
    pub file: PathBuf,
    /// Line of its `file`.
    pub line: usize,
    /// Where the mesh goes.
    pub transform: Transform,
    /// Material of the whole mesh, with its line.
    pub material: Option<(String, usize)>,
}

/// One `[material.NAME]`: quantities that override those of the MTL file's material of that name.
pub(super) struct MaterialEntry {
    /// Name.
    pub name: String,
    /// Its line.
    pub line: usize,
    changes: Vec<(Quantity, String, Vec<String>)>,
}

impl MaterialEntry {
    /// Overrides what the table states.
    pub(super) fn apply(&self, recipe: &mut Recipe) {
        for (quantity, key, words) in &self.changes {
            let words = words.iter().map(String::as_str).collect::<Vec<_>>();
            // Every value was checked by the same function when the table was read.
            let checked = quantity.set(recipe, key, &words);
            debug_assert!(checked.is_ok());
        }
    }
}

/// Reads `text`, which `path` holds.
pub(super) fn read(path: &Path, text: &str) -> Result<SceneFile> {
    let source = Source::new(path, text);
    check_memory(path, 0, "its tables", source.memory_bytes())?;
    let parsed = source.parse()?;
    let known = ["camera", "film", "render", "mesh", "material", "environment"];
    let root = Table::root(&source, &parsed, &known)?;
    let camera = root.need("camera")?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let meshes = match root.get("mesh") {
        Some(meshes) => {
            meshes.items("tables [[mesh]]")?.iter().map(|entry| read_mesh(entry, folder)).collect::<Result<_>>()?
        }
        None => Vec::new(),
    };
    let materials = match root.get("material") {
        Some(materials) => {
            materials.names("[material.NAME]")?.entries().iter().map(read_material).collect::<Result<_>>()?
        }
        None => Vec::new(),
    };
    Ok(SceneFile {
        camera: read_camera(&camera)?,
        camera_line: camera.line,
        film: root.get("film").map_or(Ok(DEFAULT_FILM), |film| read_film(&film))?,
        render: root.get("render").map_or(Ok(RenderDefaults::default()), |render| read_render(&render))?,
        meshes,
        materials,
        sky: root.get("environment").map_or(Ok(None), |environment| read_sky(&environment).map(Some))?,
    })
}

/// The film of a scene that does not say.
pub(super) const DEFAULT_FILM: FilmSettings = FilmSettings { width: 800, height: 600, filter: Filter::BlackmanHarris };

fn read_camera(entry: &Entry) -> Result<Camera> {
    let table = entry.table("[camera]", &["origin", "target", "up", "vfov", "aperture_radius", "focus_distance"])?;
    table.refuse_unbuilt(&["aperture_radius", "focus_distance"])?;
    let origin = table.need("origin")?.vector()?;
    let target = table.need("target")?.vector()?;
    let up = table.need("up")?.direction()?;
    let vfov = table.need("vfov")?.number("degrees above 0 and below 180", |v| (1e-6..=180.0 - 1e-6).contains(&v))?;
    // Lengths are compared after a division, as squares of the smallest legal numbers would vanish.
    let view = target - origin;
    let size = view.abs().max_element();
    if size < 1e-100 {
        return Err(table.need("target")?.refuse("a point other than the camera's origin"));
    }
    let up = (up / up.abs().max_element()).normalize();
    if (view / size).normalize().cross(up).length() < 1e-9 {
        return Err(table.need("up")?.refuse("a direction that is not parallel to the view"));
    }
    Ok(Camera { origin, target, up, vfov })
}

fn read_film(entry: &Entry) -> Result<FilmSettings> {
    let table = entry.table("[film]", &["width", "height", "filter"])?;
    let size = |key, default| table.get(key).map_or(Ok(default), |entry| entry.integer(1, 16384));
    let filter = match table.get("filter") {
        None => DEFAULT_FILM.filter,
        Some(entry) => {
            let allowed = "\"box\", \"tent\", \"gaussian\" or \"blackman-harris\"";
            match entry.text(allowed)? {
                "box" => Filter::Box,
                "tent" => Filter::Tent,
                "gaussian" => Filter::Gaussian,
                "blackman-harris" => Filter::BlackmanHarris,
                _ => return Err(entry.refuse(allowed)),
            }
        }
    };
    Ok(FilmSettings { width: size("width", DEFAULT_FILM.width)?, height: size("height", DEFAULT_FILM.height)?, filter })
}

fn read_render(entry: &Entry) -> Result<RenderDefaults> {
    let table = entry.table("[render]", &["spp", "max_bounces"])?;
    let value = |key, most| table.get(key).map(|entry| entry.integer(1, most)).transpose();
    Ok(RenderDefaults { spp: value("spp", u32::MAX)?, max_bounces: value("max_bounces", 65535)? })
}

fn read_sky(entry: &Entry) -> Result<[f64; 3]> {
    let table = entry.table("[environment]", &["color", "strength", "image", "rotate"])?;
    table.refuse_unbuilt(&["image", "rotate"])?;
    let allowed = "[r, g, b] of numbers from 0 to 1e36";
    let colour = table.need("color")?;
    let radiance = colour.numbers::<3>(allowed, |channel| (0.0..=1e36).contains(&channel))?;
    let Some(strength) = table.get("strength") else { return Ok(radiance) };
    let factor = strength.number("a number from 0 to 1e36", |factor| (0.0..=1e36).contains(&factor))?;
    let radiance = radiance.map(|channel| channel * factor);
    if radiance.iter().any(|&channel| channel > 1e36) {
        return Err(strength.refuse("a number that keeps color times strength within 1e36"));
    }
    Ok(radiance)
}

fn read_mesh(entry: &Entry, folder: &Path) -> Result<MeshEntry> {
    let table = entry.table("[[mesh]]", &["file", "scale", "rotate", "translate", "matrix", "material"])?;
    let file = table.need("file")?;
    let name = file.text("the name of an OBJ file, in quotes")?;
    let material = match table.get("material") {
        Some(entry) => Some((entry.text("the name of a material, in quotes")?.to_owned(), entry.line)),
        None => None,
    };
    Ok(MeshEntry { file: folder.join(name), line: file.line, transform: read_transform(&table)?, material })
}

fn read_transform(table: &Table) -> Result<Transform> {
    if let Some(matrix) = table.get("matrix") {
        if let Some(step) = ["scale", "rotate", "translate"].iter().find_map(|key| table.get(key)) {
            return Err(step.error(format!("\"{}\" beside \"matrix\"; allowed is one or the other", step.key())));
        }
        let allowed = "16 finite numbers, row by row, that can be inverted and end in 0, 0, 0, 1";
        let m: [f64; 16] = matrix.numbers(allowed, |_| true)?;
        let linear = DMat3::from_cols_array(&[m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]]);
        let transform =
            Transform::new(linear, DVec3::new(m[3], m[7], m[11])).filter(|_| m[12..] == [0.0, 0.0, 0.0, 1.0]);
        return transform.ok_or_else(|| matrix.refuse(allowed));
    }
    let mut linear = DMat3::IDENTITY;
    let mut translation = DVec3::ZERO;
    if let Some(scale) = table.get("scale") {
        let allowed = "a finite number other than 0, or [x, y, z] of such numbers";
        let fits = |factor: f64| factor.abs() >= 1e-100;
        let factors = match scale.is_number() {
            true => DVec3::splat(scale.number(allowed, fits)?),
            false => DVec3::from_array(scale.numbers(allowed, fits)?),
        };
        linear = DMat3::from_diagonal(factors);
    }
    if let Some(rotate) = table.get("rotate") {
        let turn = rotate.table("{ axis = [x, y, z], degrees = D }", &["axis", "degrees"])?;
        let degrees = turn.need("degrees")?.number("a finite number of degrees", |_| true)?;
        linear = rotation(turn.need("axis")?.direction()?, degrees) * linear;
    }
    if let Some(translate) = table.get("translate") {
        translation = translate.vector()?;
    }
    // Rotations and scalings by numbers other than 0 can always be inverted.
    Transform::new(linear, translation).ok_or_else(|| table.refuse("the mesh's scale cannot be inverted".to_owned()))
}

fn read_material(entry: &Entry) -> Result<MaterialEntry> {
    let table = entry.table("[material]", &["kd", "ks", "ke", "illum", "ni", "d"])?;
    let mut changes = Vec::new();
    for entry in table.entries() {
        // Every known key of the table is a quantity.
        let Some(quantity) = Quantity::of_key(entry.key()) else { continue };
        let words = entry.words(quantity.numbers())?;
        let as_words = words.iter().map(String::as_str).collect::<Vec<_>>();
        quantity.set(&mut Recipe::default(), entry.key(), &as_words).map_err(|message| entry.error(message))?;
        changes.push((quantity, entry.key().to_owned(), words));
    }
    Ok(MaterialEntry { name: entry.key().to_owned(), line: entry.line, changes })
}
