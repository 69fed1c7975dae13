//! Meshes placed in one scene, with materials by name.
//!
//! Comes in: a scene file's description. Goes out: a [`RawScene`] in file units and f64: triangles in the order of the
//! meshes and, within a mesh, of its OBJ file; normals on the side of their triangle's front. What follows may assume
//! finite coordinates up to 1e100 and triangles with an area in f64.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};

use super::batches::in_batches;
use super::library::{Libraries, Library};
use super::looks::Looks;
use super::need::Need;
use super::obj_mesh::{ObjMesh, ObjTriangle};
use super::placement::{Materials, PlacedPart, overflow};
use super::recipe::Recipe;
use super::refusals::Refusals;
use super::scene_file::{MaterialEntry, MeshEntry};
use super::source_text::{Folders, Named, check_memory};
use super::warnings::Warnings;
use crate::interface::NO_INDEX;
use crate::quote::{self, quoted};
use crate::{Error, Result, memory};

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
    /// Files that the scene names, read or not.
    pub files: Vec<PathBuf>,
    /// Warnings with file and line.
    pub warnings: Warnings,
    /// What was taken for granted, with file and line.
    pub notes: Warnings,
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
///
/// All files are read before anything is placed: what the scene asks for is known then, and refused where it is too
/// much.
pub(super) fn assemble(path: &Path, meshes: &[MeshEntry], materials: &[MaterialEntry]) -> Result<RawScene> {
    let mut assembly = Assembly::new(path, materials);
    let mut refusals = Refusals::default();
    let files: Vec<usize> =
        meshes.iter().filter_map(|entry| refusals.keep(assembly.look_up(entry)).flatten()).collect();
    refusals.finish()?;
    let mut need = Need::default();
    for (entry, &file) in meshes.iter().zip(&files) {
        need.add(path, entry, &assembly.sources[file].mesh)?;
    }
    assembly.place_all(meshes, &files, &need)?;
    let touched = std::mem::take(&mut assembly.touched);
    for unused in materials.iter().filter(|material| !touched.contains(material.name.as_str())) {
        let text = || {
            let (path, name) = (quote::path(path), quoted(&unused.name));
            format!("{path}:{}: no mesh uses the material {name}", unused.line)
        };
        assembly.raw.warnings.add("unused materials", text);
    }
    Ok(assembly.finish())
}

/// A bare OBJ file as it stands.
pub(super) fn assemble_bare(path: &Path) -> Result<RawScene> {
    let mut assembly = Assembly::new(path, &[]);
    let mesh = ObjMesh::load(path, None, &mut assembly.raw.warnings)?;
    let transform = super::transform::Transform::IDENTITY;
    let entry = MeshEntry { file: path.to_owned(), line: 0, transform, material: None };
    let mut need = Need::default();
    need.add(path, &entry, &mesh)?;
    let file = assembly.add(mesh);
    assembly.read_library(file)?;
    assembly.place_all(&[entry], &[file], &need)?;
    Ok(assembly.finish())
}

/// What placing the meshes has led to so far.
pub(super) struct Assembly<'a> {
    pub(super) path: &'a Path,
    pub(super) materials: &'a [MaterialEntry],
    /// Place of each name in `materials`.
    pub(super) material_of_name: HashMap<&'a str, usize>,
    pub(super) raw: RawScene,
    /// OBJ files, in the order in which the meshes name them.
    pub(super) sources: Vec<Source>,
    pub(super) source_of_path: HashMap<PathBuf, usize>,
    pub(super) looks: Looks,
    /// Materials that were looked at: number of the MTL file, none for the scene's own, and line.
    pub(super) looked_at: HashSet<(Option<usize>, usize)>,
    /// Names that were looked for among all others: of more than are told, it would take long.
    pub(super) searched: usize,
    /// OBJ files that were refused, with what they need.
    pub(super) refused: HashSet<PathBuf>,
    pub(super) folders: Folders,
    pub(super) libraries: Libraries,
    pub(super) named: Named,
    /// Index of a material by the OBJ file it belongs to (none for the scene's own) and its name.
    pub(super) index: HashMap<(Option<usize>, String), u32>,
    pub(super) touched: HashSet<&'a str>,
}

/// An OBJ file.
pub(super) struct Source {
    pub(super) mesh: ObjMesh,
    /// The MTL files that it names, where they were needed.
    pub(super) library: Option<Library>,
    /// Material of each part, once a mesh has asked for them.
    pub(super) materials: Option<Vec<u32>>,
}

impl<'a> Assembly<'a> {
    fn new(path: &'a Path, materials: &'a [MaterialEntry]) -> Assembly<'a> {
        Assembly {
            path,
            materials,
            material_of_name: materials.iter().zip(0..).map(|(material, i)| (material.name.as_str(), i)).collect(),
            raw: RawScene::default(),
            sources: Vec::new(),
            source_of_path: HashMap::new(),
            looks: Looks::default(),
            looked_at: HashSet::new(),
            searched: 0,
            refused: HashSet::new(),
            folders: Folders::default(),
            libraries: Libraries::default(),
            named: Named::new(),
            index: HashMap::new(),
            touched: HashSet::new(),
        }
    }

    /// Reads what the mesh needs and was not read before, and looks its materials up. Goes out: the number of its OBJ
    /// file; none where that was refused for another mesh.
    fn look_up(&mut self, entry: &MeshEntry) -> Result<Option<usize>> {
        let key = self.folders.key(&entry.file);
        if self.refused.contains(&key) {
            return Ok(None);
        }
        match self.read(entry, &key) {
            Ok(file) => self.materials_of(entry, file).map(|materials| {
                self.put_back(file, materials);
                Some(file)
            }),
            Err(error) => {
                // What the scene file's line is at fault for, such as a name without a file, is told of each line.
                if !matches!(&error, Error::Scene { path, .. } if path == self.path) {
                    self.refused.insert(key);
                }
                Err(error)
            }
        }
    }

    /// Reads what the mesh needs and was not read before. Goes out: the number of its OBJ file.
    fn read(&mut self, entry: &MeshEntry, key: &Path) -> Result<usize> {
        let file = match self.source_of_path.get(key) {
            Some(&file) => file,
            None => {
                let mesh = ObjMesh::load(&entry.file, Some((self.path, entry.line)), &mut self.raw.warnings)?;
                self.named.insert(entry.file.clone().into_os_string());
                let file = self.add(mesh);
                self.source_of_path.insert(key.to_owned(), file);
                file
            }
        };
        // A mesh whose one material stands in the scene file needs no MTL file.
        let in_scene = |(name, _): &(String, usize)| self.material_of_name.contains_key(name.as_str());
        if !entry.material.as_ref().is_some_and(in_scene) {
            self.read_library(file)?;
        }
        Ok(file)
    }

    fn add(&mut self, mesh: ObjMesh) -> usize {
        self.named.extend(mesh.library_paths().map(PathBuf::into_os_string));
        self.sources.push(Source { mesh, library: None, materials: None });
        self.sources.len() - 1
    }

    fn read_library(&mut self, file: usize) -> Result<()> {
        let source = &mut self.sources[file];
        if source.library.is_none() {
            let RawScene { warnings, notes, .. } = &mut self.raw;
            let library = self.libraries.of(&source.mesh, &mut self.folders, &mut self.named, warnings, notes)?;
            source.library = Some(library);
        }
        Ok(())
    }

    fn finish(mut self) -> RawScene {
        self.looks.warn(&mut self.raw.warnings);
        self.raw.files = self.named.into_iter().map(PathBuf::from).collect();
        self.raw
    }

    /// Places the meshes, each of the OBJ file of that number.
    fn place_all(&mut self, meshes: &[MeshEntry], files: &[usize], need: &Need) -> Result<()> {
        let line = self.exceeding(meshes, files)?;
        let what = format!("memory for {} triangles", need.triangles);
        check_memory(self.path, line, &what, need.bytes())?;
        let refused = |_| Error::scene(self.path, line, format!("{what} cannot be had"));
        self.raw.triangles.try_reserve_exact(need.triangles as usize).map_err(refused)?;
        self.raw.corners.try_reserve_exact(need.smooth as usize).map_err(refused)?;
        let mut refusals = Refusals::default();
        for (entry, &file) in meshes.iter().zip(files) {
            let materials = self.materials_of(entry, file)?;
            refusals.keep(self.place(entry, file, &materials));
            self.put_back(file, materials);
        }
        refusals.finish()
    }

    fn put_back(&mut self, file: usize, materials: Materials) {
        if let Materials::Parts(materials) = materials {
            self.sources[file].materials = Some(materials);
        }
    }

    /// Line of the mesh with which memory is exceeded; 0 where none is.
    fn exceeding(&self, meshes: &[MeshEntry], files: &[usize]) -> Result<usize> {
        let Some((have, _)) = memory::available() else { return Ok(0) };
        let mut need = Need::default();
        for (entry, &file) in meshes.iter().zip(files) {
            need.add(self.path, entry, &self.sources[file].mesh)?;
            if need.bytes() > have {
                return Ok(entry.line);
            }
        }
        Ok(0)
    }

    fn place(&mut self, entry: &MeshEntry, file: usize, materials: &Materials) -> Result<()> {
        let mesh = &self.sources[file].mesh;
        let mut zero_normals = 0;
        let corners_of = |triangle: &ObjTriangle| mesh.corners.get(triangle.corners as usize);
        let raw = &mut self.raw;
        let path = self.path;
        in_batches(
            &mesh.triangles,
            |_, triangles| PlacedPart::of(entry, triangles, materials, corners_of),
            |part| {
                if let Some(triangle) = part.overflows {
                    return Err(overflow(path, entry, &triangle));
                }
                let first = raw.corners.len() as u32;
                raw.corners.extend(part.corners);
                raw.triangles.extend(part.triangles.into_iter().map(|triangle| match triangle.corners {
                    NO_INDEX => triangle,
                    corners => RawTriangle { corners: first + corners, ..triangle },
                }));
                raw.degenerate += part.degenerate;
                zero_normals += part.zero_normals;
                Ok(())
            },
        )?;
        if zero_normals > 0 {
            raw.warnings.add("normals of length 0", || {
                let path = quote::path(&mesh.path);
                format!("{path}: {zero_normals} corners have a normal of length 0 and take that of their triangle")
            });
        }
        Ok(())
    }
}
