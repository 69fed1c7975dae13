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

use super::nearest::nearest;
use super::recipe::{Quantity, Recipe};
use super::refusals::Refusals;
use super::source_text::check_memory;
use super::toml_source::Source;
use super::toml_table::{Entry, Table};
use super::transform::{Transform, rotation};
use super::{Camera, FilmSettings, Filter, RenderDefaults, foreign_format};
use crate::interface::{MAX_BOUNCES, MAX_SIDE};
use crate::quote::{self, quoted};
use crate::{Error, Result};

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
    /// Whether the table states the quantity.
    pub(super) fn changes(&self, quantity: Quantity) -> bool {
        self.changes.iter().any(|(changed, ..)| *changed == quantity)
    }

    /// Overrides what the table states.
    pub(super) fn apply(&self, recipe: &mut Recipe) {
        for (quantity, key, words) in &self.changes {
            let words = words.iter().map(String::as_str).collect::<Vec<_>>();
            // Every value was checked by the same function when the table was read.
            let checked = quantity.set(recipe, key, &words);
            debug_assert!(checked.is_ok());
            recipe.state(*quantity, self.line);
        }
    }
}

/// Reads `text`, which `path` holds. All that is wrong is refused at once.
pub(super) fn read(path: &Path, text: &str) -> Result<SceneFile> {
    let source = Source::new(path, text);
    check_memory(path, 0, "its tables", source.memory_bytes())?;
    let parsed = source.parse()?;
    let mut refusals = Refusals::default();
    let file = read_root(&Table::root(&source, &parsed), path, &mut refusals);
    refusals.in_order_of_lines();
    refusals.finish()?;
    // What was not refused was read.
    file.ok_or_else(|| Error::Internal(format!("{}: neither read nor refused", quote::path(path))))
}

fn read_root(root: &Table, path: &Path, refusals: &mut Refusals) -> Option<SceneFile> {
    let known = ["camera", "film", "render", "mesh", "material", "environment"];
    root.unknown_keys(&known, &[]).into_iter().for_each(|error| refusals.add(error));
    let folder = path.parent().unwrap_or(Path::new(""));
    let meshes = root.get("mesh").map(|meshes| meshes.items("tables [[mesh]]"));
    let meshes = meshes.and_then(|meshes| refusals.keep(meshes)).unwrap_or_default();
    let meshes: Vec<_> = meshes.iter().map(|entry| read_mesh(entry, folder, refusals)).collect();
    let materials = root.get("material").and_then(|all| refusals.keep(all.table("[material.NAME]")));
    let materials = materials.map_or(Vec::new(), |materials| materials.entries());
    let materials: Vec<_> = materials.iter().map(|entry| read_material(entry, refusals)).collect();
    let film = root.get("film").map_or(Some(DEFAULT_FILM), |film| read_film(&film, refusals));
    let render = root.get("render").map_or(Some(RenderDefaults::default()), |render| read_render(&render, refusals));
    let sky = root.get("environment").map_or(Some(None), |sky| read_sky(&sky, refusals).map(Some));
    let camera_entry = need(root, "camera", &known, refusals)?;
    let camera = read_camera(&camera_entry, refusals);
    Some(SceneFile {
        camera: camera?,
        camera_line: camera_entry.line,
        film: film?,
        render: render?,
        meshes: meshes.into_iter().collect::<Option<_>>()?,
        materials: materials.into_iter().collect::<Option<_>>()?,
        sky: sky?,
    })
}

/// The entry of a key that a table must have. Where a key that is not known is a slip of it, that was refused already.
fn need<'a>(table: &Table<'a>, key: &str, known: &[&str], refusals: &mut Refusals) -> Option<Entry<'a>> {
    let slip =
        |entry: &Entry| !known.contains(&entry.key()) && nearest(entry.key(), known.iter().copied()) == Some(key);
    match table.get(key) {
        None if table.entries().iter().any(slip) => None,
        found => found.or_else(|| refusals.keep(table.need(key))),
    }
}

/// The table of `entry`, with a refusal of each key that is neither `known` nor `unbuilt`, and of each that is
/// `unbuilt`.
fn open<'a>(
    entry: &Entry<'a>,
    name: &'a str,
    known: &[&str],
    unbuilt: &[&str],
    refusals: &mut Refusals,
) -> Option<Table<'a>> {
    let table = refusals.keep(entry.table(name))?;
    let unknown = table.unknown_keys(known, unbuilt);
    unknown.into_iter().chain(table.unbuilt_keys(unbuilt)).for_each(|error| refusals.add(error));
    Some(table)
}

/// The film of a scene that does not say.
pub(super) const DEFAULT_FILM: FilmSettings = FilmSettings { width: 800, height: 600, filter: Filter::BlackmanHarris };

fn read_camera(entry: &Entry, refusals: &mut Refusals) -> Option<Camera> {
    let known = ["origin", "target", "up", "vfov"];
    let table = open(entry, "[camera]", &known, &["aperture_radius", "focus_distance"], refusals)?;
    let [origin, target, up, vfov] = known.map(|key| need(&table, key, &known, refusals));
    let origin = origin.and_then(|entry| refusals.keep(entry.vector()));
    let target = target.and_then(|entry| refusals.keep(entry.vector()));
    let up = up.and_then(|entry| refusals.keep(entry.direction()));
    let degrees = |entry: Entry| entry.number("degrees above 0 and below 180", |v| (1e-6..=180.0 - 1e-6).contains(&v));
    let vfov = vfov.and_then(|entry| refusals.keep(degrees(entry)));
    let camera = Camera { origin: origin?, target: target?, up: up?, vfov: vfov? };
    refusals.keep(checked_camera(&table, camera))
}

/// The camera with an `up` of length 1, if it looks somewhere and knows what is up there.
fn checked_camera(table: &Table, camera: Camera) -> Result<Camera> {
    let Camera { origin, target, up, vfov } = camera;
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

fn read_film(entry: &Entry, refusals: &mut Refusals) -> Option<FilmSettings> {
    let table = open(entry, "[film]", &["width", "height", "filter"], &[], refusals)?;
    let size = |key, default| table.get(key).map_or(Ok(default), |entry| entry.integer(1, MAX_SIDE));
    let (width, height) = (size("width", DEFAULT_FILM.width), size("height", DEFAULT_FILM.height));
    let (width, height) = (refusals.keep(width), refusals.keep(height));
    let filter = table.get("filter").map_or(Ok(DEFAULT_FILM.filter), |entry| read_filter(&entry));
    Some(FilmSettings { filter: refusals.keep(filter)?, width: width?, height: height? })
}

fn read_filter(entry: &Entry) -> Result<Filter> {
    let allowed = "\"box\", \"tent\", \"gaussian\" or \"blackman-harris\"";
    Ok(match entry.text(allowed)? {
        "box" => Filter::Box,
        "tent" => Filter::Tent,
        "gaussian" => Filter::Gaussian,
        "blackman-harris" => Filter::BlackmanHarris,
        _ => return Err(entry.refuse(allowed)),
    })
}

fn read_render(entry: &Entry, refusals: &mut Refusals) -> Option<RenderDefaults> {
    let table = open(entry, "[render]", &["spp", "max_bounces"], &[], refusals)?;
    let value = |key, most| table.get(key).map(|entry| entry.integer(1, most)).transpose();
    let (spp, max_bounces) = (refusals.keep(value("spp", u32::MAX)), refusals.keep(value("max_bounces", MAX_BOUNCES)));
    Some(RenderDefaults { spp: spp?, max_bounces: max_bounces? })
}

fn read_sky(entry: &Entry, refusals: &mut Refusals) -> Option<[f64; 3]> {
    let known = ["color", "strength"];
    let table = open(entry, "[environment]", &known, &["image", "rotate"], refusals)?;
    let allowed = "[r, g, b] of numbers from 0 to 1e36";
    let colour = |entry: Entry| entry.numbers::<3>(allowed, |channel| (0.0..=1e36).contains(&channel));
    let radiance = need(&table, "color", &known, refusals).and_then(|entry| refusals.keep(colour(entry)));
    let Some(strength) = table.get("strength") else { return radiance };
    let factor = strength.number("a number from 0 to 1e36", |factor| (0.0..=1e36).contains(&factor));
    let factor = refusals.keep(factor)?;
    let radiance = radiance?.map(|channel| channel * factor);
    if radiance.iter().any(|&channel| channel > 1e36) {
        refusals.add(strength.refuse("a number that keeps color times strength within 1e36"));
    }
    Some(radiance)
}

fn read_mesh(entry: &Entry, folder: &Path, refusals: &mut Refusals) -> Option<MeshEntry> {
    let known = ["file", "scale", "rotate", "translate", "matrix", "material"];
    let table = open(entry, "[[mesh]]", &known, &[], refusals)?;
    let file = need(&table, "file", &known, refusals).and_then(|file| refusals.keep(mesh_file(&file, folder)));
    let named = |entry: Entry| Ok((entry.text("the name of a material, in quotes")?.to_owned(), entry.line));
    let material = refusals.keep(table.get("material").map(named).transpose());
    let transform = read_transform(&table, refusals);
    let (file, line) = file?;
    Some(MeshEntry { file, line, transform: transform?, material: material? })
}

/// The mesh's file and the line that names it.
fn mesh_file(entry: &Entry, folder: &Path) -> Result<(PathBuf, usize)> {
    let file = folder.join(entry.text("the name of an OBJ file, in quotes")?);
    match foreign_format(&file) {
        Some(what) => Err(entry.error(format!("mesh file {}: {what}", quoted(&file.display().to_string())))),
        None => Ok((file, entry.line)),
    }
}

fn read_transform(table: &Table, refusals: &mut Refusals) -> Option<Transform> {
    if let Some(matrix) = table.get("matrix") {
        return refusals.keep(read_matrix(table, &matrix));
    }
    let scale = table.get("scale").map_or(Ok(DVec3::ONE), |scale| read_scale(&scale));
    let scale = refusals.keep(scale);
    let turn = table.get("rotate").map_or(Some(DMat3::IDENTITY), |turn| read_rotation(&turn, refusals));
    let translation = table.get("translate").map_or(Ok(DVec3::ZERO), |translate| translate.vector());
    let translation = refusals.keep(translation);
    // Rotations and scalings by numbers other than 0 can always be inverted.
    let transform = Transform::new(turn? * DMat3::from_diagonal(scale?), translation?);
    refusals.keep(transform.ok_or_else(|| table.refuse("the mesh's scale cannot be inverted".to_owned())))
}

fn read_matrix(table: &Table, matrix: &Entry) -> Result<Transform> {
    if let Some(step) = ["scale", "rotate", "translate"].iter().find_map(|key| table.get(key)) {
        return Err(step.error(format!("\"{}\" beside \"matrix\"; allowed is one or the other", step.key())));
    }
    let allowed = "16 finite numbers, row by row, that can be inverted and end in 0, 0, 0, 1";
    let m: [f64; 16] = matrix.numbers(allowed, |_| true)?;
    let linear = DMat3::from_cols_array(&[m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]]);
    let transform = Transform::new(linear, DVec3::new(m[3], m[7], m[11])).filter(|_| m[12..] == [0.0, 0.0, 0.0, 1.0]);
    transform.ok_or_else(|| matrix.refuse(allowed))
}

fn read_scale(scale: &Entry) -> Result<DVec3> {
    let allowed = "a finite number other than 0, or [x, y, z] of such numbers";
    let fits = |factor: f64| factor.abs() >= 1e-100;
    Ok(match scale.is_number() {
        true => DVec3::splat(scale.number(allowed, fits)?),
        false => DVec3::from_array(scale.numbers(allowed, fits)?),
    })
}

fn read_rotation(rotate: &Entry, refusals: &mut Refusals) -> Option<DMat3> {
    let known = ["axis", "degrees"];
    let turn = open(rotate, "{ axis = [x, y, z], degrees = D }", &known, &[], refusals)?;
    let [axis, degrees] = known.map(|key| need(&turn, key, &known, refusals));
    let axis = axis.and_then(|axis| refusals.keep(axis.direction()));
    let degrees = degrees.and_then(|entry| refusals.keep(entry.number("a finite number of degrees", |_| true)));
    Some(rotation(axis?, degrees?))
}

fn read_material(entry: &Entry, refusals: &mut Refusals) -> Option<MaterialEntry> {
    let table = open(entry, "[material]", &["kd", "ks", "ke", "illum", "ni", "d"], &[], refusals)?;
    // Every known key of the table is a quantity.
    let known = table.entries().into_iter().filter_map(|entry| Some((Quantity::of_key(entry.key())?, entry)));
    // All of them are read before one that is refused ends the material.
    let changes: Vec<_> = known.map(|(quantity, entry)| refusals.keep(read_change(quantity, &entry))).collect();
    let changes = changes.into_iter().collect::<Option<_>>()?;
    Some(MaterialEntry { name: entry.key().to_owned(), line: entry.line, changes })
}

/// What a material's key says, checked.
fn read_change(quantity: Quantity, entry: &Entry) -> Result<(Quantity, String, Vec<String>)> {
    let words = entry.words(quantity.numbers())?;
    let as_words = words.iter().map(String::as_str).collect::<Vec<_>>();
    quantity.set(&mut Recipe::default(), entry.key(), &as_words).map_err(|message| entry.error(message))?;
    Ok((quantity, entry.key().to_owned(), words))
}
