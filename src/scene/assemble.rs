//! Meshes placed in one scene, with materials by name.
//!
//! Comes in: a scene file's description. Goes out: a [`RawScene`] in file units and f64: triangles in the order of the
//! meshes and, within a mesh, of its OBJ file; normals on the side of their triangle's front. What follows may assume
//! finite coordinates up to 1e100 and triangles with an area in f64.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};

use super::batches::in_batches;
use super::mtl_scan::Library;
use super::nearest::known_names;
use super::number::in_range;
use super::obj_mesh::{ObjCorners, ObjMesh, ObjTriangle};
use super::recipe::Recipe;
use super::refusals::Refusals;
use super::scene_file::{MaterialEntry, MeshEntry};
use super::source_text::quoted;
use crate::interface::NO_INDEX;
use crate::{Error, Result};

/// A normal this close to the geometric one shades as the flat triangle does, so the triangle needs none.
const SAME_NORMAL: f64 = 1e-6;

/// Triangles and materials in file units.
#[derive(Default)]
pub(super) struct RawScene {
    /// Triangles in file order.
    pub triangles: Vec<RawTriangle>,
    /// Attributes of smooth triangles.
    pub corners: Vec<RawCorners>,
    /// Materials by name.
    pub materials: Vec<(String, Recipe)>,
    /// Triangles left out for want of an area.
    pub degenerate: usize,
    /// OBJ and MTL files that were read.
    pub files: Vec<PathBuf>,
    /// Warnings with file and line.
    pub warnings: Vec<String>,
}

/// One triangle.
#[derive(Clone, Copy)]
pub(super) struct RawTriangle {
    /// Corner positions.
    pub positions: [DVec3; 3],
    /// Index of its material.
    pub material: u32,
    /// Index into [`RawScene::corners`], or `NO_INDEX`.
    pub corners: u32,
}

/// Attributes of a smooth triangle.
#[derive(Clone, Copy)]
pub(super) struct RawCorners {
    /// Unit normals on the side of the front.
    pub normals: [DVec3; 3],
    /// Texture coordinates.
    pub uvs: [DVec2; 3],
}

/// Places `meshes`, which the scene file `path` lists beside `materials`.
pub(super) fn assemble(path: &Path, meshes: &[MeshEntry], materials: &[MaterialEntry]) -> Result<RawScene> {
    assemble_with(path, meshes, materials, &mut ObjFiles::new())
}

/// OBJ files that were read, each with its MTL files where they were needed.
pub(super) type ObjFiles = HashMap<PathBuf, (ObjMesh, Option<Library>)>;

/// As [`assemble`], but reads only those files that `files` lacks.
pub(super) fn assemble_with(
    path: &Path,
    meshes: &[MeshEntry],
    materials: &[MaterialEntry],
    files: &mut ObjFiles,
) -> Result<RawScene> {
    let mut assembly =
        Assembly { path, materials, raw: RawScene::default(), index: HashMap::new(), touched: HashSet::new() };
    let mut refusals = Refusals::default();
    let mut add = |entry: &MeshEntry| {
        if !files.contains_key(entry.file.as_path()) {
            let mesh = ObjMesh::load(&entry.file, Some((path, entry.line)))?;
            assembly.raw.warnings.extend(mesh.warnings.iter().cloned());
            assembly.raw.files.push(entry.file.clone());
            files.insert(entry.file.clone(), (mesh, None));
        }
        let Some((mesh, library)) = files.get_mut(entry.file.as_path()) else { return Ok(()) };
        // A mesh whose one material stands in the scene file needs no MTL file.
        let in_scene = |(name, _): &(String, usize)| materials.iter().any(|material| material.name == *name);
        if library.is_none() && !entry.material.as_ref().is_some_and(in_scene) {
            let read = mesh.library()?;
            assembly.raw.warnings.extend(read.warnings.iter().cloned());
            assembly.raw.files.extend(read.files.iter().cloned());
            *library = Some(read);
        }
        assembly.place(entry, mesh, library.as_ref())
    };
    meshes.iter().for_each(|entry| _ = refusals.keep(add(entry)));
    refusals.finish()?;
    for unused in materials.iter().filter(|material| !assembly.touched.contains(material.name.as_str())) {
        let text = format!("{}:{}: no mesh uses the material {}", path.display(), unused.line, quoted(&unused.name));
        assembly.raw.warnings.push(text);
    }
    Ok(assembly.raw)
}

/// A bare OBJ file as it stands.
pub(super) fn assemble_bare(path: &Path) -> Result<RawScene> {
    let mut assembly =
        Assembly { path, materials: &[], raw: RawScene::default(), index: HashMap::new(), touched: HashSet::new() };
    let mesh = ObjMesh::load(path, None)?;
    let library = mesh.library()?;
    assembly.raw.warnings.extend(mesh.warnings.iter().chain(&library.warnings).cloned());
    assembly.raw.files.extend(library.files.iter().cloned());
    let transform = super::transform::Transform::IDENTITY;
    let entry = MeshEntry { file: path.to_owned(), line: 0, transform, material: None };
    assembly.place(&entry, &mesh, Some(&library))?;
    Ok(assembly.raw)
}

/// What placing the meshes has led to so far.
struct Assembly<'a> {
    path: &'a Path,
    materials: &'a [MaterialEntry],
    raw: RawScene,
    /// Index of a material by the OBJ file it belongs to (none for the scene's own) and its name.
    index: HashMap<(Option<PathBuf>, String), u32>,
    touched: HashSet<&'a str>,
}

impl<'a> Assembly<'a> {
    fn place(&mut self, entry: &MeshEntry, mesh: &ObjMesh, library: Option<&Library>) -> Result<()> {
        let whole = match &entry.material {
            Some((name, line)) => Some(self.whole_mesh_material(name, *line, mesh, library)?),
            None => None,
        };
        let mut material_of_part = Vec::with_capacity(mesh.parts.len());
        let mut refusals = Refusals::default();
        for part in &mesh.parts {
            material_of_part.push(match (whole, library) {
                (Some(material), _) => material,
                // A part without faces needs no material, but a name that is nowhere defined is refused all the same.
                (None, Some(_)) if part.faces == 0 && part.name.is_empty() => 0,
                (None, library) => refusals.keep(self.part_material(mesh, part, library)).unwrap_or(0),
            });
        }
        refusals.finish()?;
        // One material makes one part of the whole mesh, smooth only where all of it has normals.
        let smooth = whole.is_none() || mesh.parts.iter().all(|part| part.faces == 0 || part.all_normals);
        let mut zero_normals = 0;
        self.raw.triangles.reserve(mesh.triangles.len());
        let corners_of = |triangle: &ObjTriangle| mesh.corners.get(triangle.corners as usize).filter(|_| smooth);
        in_batches(
            &mesh.triangles,
            |_, triangles| PlacedPart::of(entry, triangles, &material_of_part, corners_of),
            |part| {
                if let Some(triangle) = part.overflows {
                    return Err(self.overflow(entry, &triangle));
                }
                let first = self.raw.corners.len() as u32;
                self.raw.corners.extend(part.corners);
                self.raw.triangles.extend(part.triangles.into_iter().map(|triangle| match triangle.corners {
                    NO_INDEX => triangle,
                    corners => RawTriangle { corners: first + corners, ..triangle },
                }));
                self.raw.degenerate += part.degenerate;
                zero_normals += part.zero_normals;
                Ok(())
            },
        )?;
        if self.raw.triangles.len() >= 1 << 31 {
            return Err(Error::scene(self.path, entry.line, "more than 2147483647 triangles; allowed are as many"));
        }
        if zero_normals > 0 {
            let text = format!(
                "{}: {zero_normals} corners have a normal of length 0 and take that of their triangle",
                mesh.path.display()
            );
            self.raw.warnings.push(text);
        }
        Ok(())
    }

    /// The refusal of a triangle that the mesh's transform moves out of range.
    fn overflow(&self, entry: &MeshEntry, triangle: &ObjTriangle) -> Error {
        let moved = triangle.positions.map(|point| entry.transform.point(point));
        let reach = moved.into_iter().map(|point| point.abs().max_element()).fold(0.0, f64::max);
        let message = format!("the mesh's transform moves a corner to {reach:e}; allowed are coordinates up to 1e100");
        Error::scene(self.path, entry.line, message)
    }

    /// The material that a `[[mesh]]` names for all its faces: the scene's own, or else the MTL file's.
    fn whole_mesh_material(
        &mut self,
        name: &str,
        line: usize,
        mesh: &ObjMesh,
        library: Option<&Library>,
    ) -> Result<u32> {
        if let Some(entry) = self.materials.iter().find(|material| material.name == name) {
            let mut recipe = Recipe::default();
            entry.apply(&mut recipe);
            self.touched.insert(&entry.name);
            return Ok(self.material((None, name.to_owned()), recipe));
        }
        if let Some(recipe) = library.and_then(|library| library.find(name)) {
            return Ok(self.material((Some(mesh.path.clone()), name.to_owned()), recipe.clone()));
        }
        let of_library = library.iter().flat_map(|library| &library.recipes).map(|(known, _)| known.as_str());
        let of_scene = self.materials.iter().map(|material| material.name.as_str());
        let known = known_names(name, of_scene.chain(of_library), "the nearest that is defined is", "defined are");
        let allowed = known.unwrap_or_else(|| "none is defined by [material.NAME] or the mesh's MTL file".to_owned());
        Err(Error::scene(self.path, line, format!("material {}: no such material; {allowed}", quoted(name))))
    }

    /// The material of one part of an OBJ file, as MTL file and scene define it together.
    fn part_material(
        &mut self,
        mesh: &ObjMesh,
        part: &super::obj_scan::Part,
        library: Option<&Library>,
    ) -> Result<u32> {
        let defined = library.and_then(|library| library.find(&part.name));
        let changed = self.materials.iter().find(|material| material.name == part.name);
        if defined.is_none() && changed.is_none() && !part.name.is_empty() {
            let of_library = library.iter().flat_map(|library| &library.recipes).map(|(name, _)| name.as_str());
            let of_scene = self.materials.iter().map(|material| material.name.as_str());
            return Err(mesh.unknown_material(part, of_library.chain(of_scene)));
        }
        let mut recipe = defined.cloned().unwrap_or_default();
        if let Some(entry) = changed {
            entry.apply(&mut recipe);
            self.touched.insert(&entry.name);
        }
        Ok(self.material((Some(mesh.path.clone()), part.name.clone()), recipe))
    }

    fn material(&mut self, key: (Option<PathBuf>, String), recipe: Recipe) -> u32 {
        let materials = &mut self.raw.materials;
        let name = key.1.clone();
        *self.index.entry(key).or_insert_with(|| {
            materials.push((name, recipe));
            (materials.len() - 1) as u32
        })
    }
}

/// Triangles of a mesh, placed; `corners` of a triangle count from the part's first.
#[derive(Default)]
struct PlacedPart {
    triangles: Vec<RawTriangle>,
    corners: Vec<RawCorners>,
    degenerate: usize,
    zero_normals: usize,
    /// The first triangle with a corner out of range; those after it are not placed.
    overflows: Option<ObjTriangle>,
}

impl PlacedPart {
    fn of<'c>(
        entry: &MeshEntry,
        triangles: &[ObjTriangle],
        material_of_part: &[u32],
        corners_of: impl Fn(&ObjTriangle) -> Option<&'c ObjCorners>,
    ) -> PlacedPart {
        let mut part = PlacedPart { triangles: Vec::with_capacity(triangles.len()), ..PlacedPart::default() };
        for triangle in triangles {
            let positions = placed(entry, triangle);
            if !positions.into_iter().all(in_range) {
                part.overflows = Some(*triangle);
                break;
            }
            let Some(front) = unit_normal(positions) else {
                part.degenerate += 1;
                continue;
            };
            let placed =
                corners_of(triangle).and_then(|corners| placed_corners(entry, corners, front, &mut part.zero_normals));
            let corners = placed.map_or(NO_INDEX, |corners| {
                part.corners.push(corners);
                (part.corners.len() - 1) as u32
            });
            let material = material_of_part[triangle.part as usize];
            part.triangles.push(RawTriangle { positions, material, corners });
        }
        part
    }
}

/// Positions in the scene.
fn placed(entry: &MeshEntry, triangle: &ObjTriangle) -> [DVec3; 3] {
    let [a, b, c] = triangle.positions.map(|position| entry.transform.point(position));
    // A mirrored triangle turns the other way round: two corners are swapped to keep its front.
    if entry.transform.mirrors() { [a, c, b] } else { [a, b, c] }
}

/// Unit normal of a triangle of any size, or nothing where its area is zero.
pub(super) fn unit_normal([a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    let (ab, ac) = (b - a, c - a);
    // Scaled by a power of two, as products of the smallest legal edges would vanish.
    let size = ab.abs().max(ac.abs()).max_element();
    if size == 0.0 {
        return None;
    }
    let scale = super::normalise::power_of_two(-super::normalise::exponent(size));
    (ab * scale).cross(ac * scale).try_normalize()
}

/// The unit vector nearest to `normal` on the side of `front`; both are unit vectors.
fn onto_front(normal: DVec3, front: DVec3) -> DVec3 {
    let height = normal.dot(front);
    if height >= 0.0 {
        return normal;
    }
    (normal - height * front).try_normalize().unwrap_or(front)
}

/// Unit normals on the side of the front, or nothing where all of them are the triangle's own.
fn placed_corners(
    entry: &MeshEntry,
    corners: &ObjCorners,
    front: DVec3,
    zero_normals: &mut usize,
) -> Option<RawCorners> {
    let mut normals = corners.normals.map(|normal| {
        let size = normal.abs().max_element();
        let turned = if size > 0.0 { entry.transform.normal(normal / size).try_normalize() } else { None };
        turned.unwrap_or_else(|| {
            *zero_normals += 1;
            front
        })
    });
    // Normals of the wrong sign are so for the triangle as a whole: turned corner by corner, those of a triangle on a
    // silhouette would point to opposite sides.
    if (normals[0] + normals[1] + normals[2]).dot(front) < 0.0 {
        normals = normals.map(|normal| -normal);
    }
    normals = normals.map(|normal| onto_front(normal, front));
    if normals.iter().all(|&normal| (normal - front).abs().max_element() <= SAME_NORMAL) {
        return None;
    }
    let mut uvs = corners.uvs;
    if entry.transform.mirrors() {
        normals.swap(1, 2);
        uvs.swap(1, 2);
    }
    Some(RawCorners { normals, uvs })
}
