//! An OBJ file's triangles, built by `tobj` from the text that the scan checked.
//!
//! Comes in: an OBJ file. Goes out: an [`ObjMesh`] of triangles in file order (`tobj` keeps it: it closes a model at each
//! change of material, and numbers within a model do not reorder faces). Materials are numbers of parts until they are
//! looked up: a scene that gives the whole mesh a material of its own needs no MTL file.

use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};

use super::census::Census;
use super::nearest::known_names;
use super::obj_scan::{self, Part};
use super::source_text::{self, check_memory};
use super::statements::bare_name;
use super::warnings::Warnings;
use crate::interface::NO_INDEX;
use crate::quote::{self, quoted};
use crate::{Error, Result};

/// The triangles of one OBJ file, in its units.
pub(super) struct ObjMesh {
    /// The file.
    pub path: PathBuf,
    /// Triangles in file order.
    pub triangles: Vec<ObjTriangle>,
    /// Attributes of the triangles of faces that have normals on every corner.
    pub corners: Vec<ObjCorners>,
    /// Parts by number.
    pub parts: Vec<Part>,
    /// What `mtllib` statements name, with their lines; none twice.
    pub libraries: Vec<(String, usize)>,
}

/// One triangle of a part.
#[derive(Clone, Copy)]
pub(super) struct ObjTriangle {
    /// Corner positions.
    pub positions: [DVec3; 3],
    /// Number of its part.
    pub part: u32,
    /// Index into [`ObjMesh::corners`], or `NO_INDEX`.
    pub corners: u32,
}

/// Attributes of a triangle's corners, as the file has them.
#[derive(Clone, Copy)]
pub(super) struct ObjCorners {
    /// Normals of any length.
    pub normals: [DVec3; 3],
    /// Texture coordinates; zero where the face has not one on every corner.
    pub uvs: [DVec2; 3],
}

impl ObjMesh {
    /// Reads `path`. `named_by` is the file and line that ask for it, for the refusal of a file that is not there.
    pub(super) fn load(path: &Path, named_by: Option<(&Path, usize)>, warnings: &mut Warnings) -> Result<ObjMesh> {
        let bytes = source_text::read_bytes(path).map_err(|reason| match named_by {
            Some((file, line)) => {
                Error::scene(file, line, format!("mesh file {}: {reason}", quoted(&path.display().to_string())))
            }
            None => Error::scene(path, 0, reason),
        })?;
        let text = source_text::decode_statements(path, bytes)?;
        let census = Census::of(&text);
        check_memory(path, 0, "its faces", census.obj_bytes().saturating_add(text.len() as u64))?;
        let scan = obj_scan::scan(path, &text, &census, warnings)?;
        drop(text);
        let mut mesh = ObjMesh {
            path: path.to_owned(),
            triangles: Vec::new(),
            corners: Vec::new(),
            parts: scan.parts,
            libraries: scan.libraries,
        };
        mesh.build(&scan.points, &scan.faces)?;
        Ok(mesh)
    }

    /// Triangles from the canonical text.
    fn build(&mut self, points: &str, faces: &str) -> Result<()> {
        let options =
            tobj::LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..Default::default() };
        let count = self.parts.len();
        // The canonical text knows its materials by number; this is the library that tobj finds them in.
        let numbered = |_: &Path| {
            let material = |number: usize| tobj::Material { name: number.to_string(), ..Default::default() };
            Ok((
                (1..count).map(material).collect(),
                (1..count).map(|number| (number.to_string(), number - 1)).collect(),
            ))
        };
        let mut reader = Cursor::new("mtllib numbered\n").chain(Cursor::new(points)).chain(Cursor::new(faces));
        let (models, _) = tobj::load_obj_buf(&mut reader, &options, numbered).map_err(|error| {
            Error::Internal(format!("{}: the scan let pass what tobj refuses: {error}", quote::path(&self.path)))
        })?;
        self.triangles.reserve_exact(models.iter().map(|model| model.mesh.indices.len() / 3).sum());
        self.corners.reserve_exact(models.iter().map(|model| smooth_triangles(&model.mesh).count()).sum());
        for model in models {
            self.append(&model.mesh);
        }
        Ok(())
    }

    fn append(&mut self, mesh: &tobj::Mesh) {
        let part = mesh.material_id.map_or(0, |index| index + 1);
        let point = |data: &[f64], index: u32| DVec3::from_slice(&data[3 * index as usize..]);
        let mut smooth = smooth_triangles(mesh).peekable();
        for (triangle, indices) in mesh.indices.chunks_exact(3).enumerate() {
            let first = 3 * triangle;
            let corners = if smooth.next_if_eq(&triangle).is_some() {
                let normal = |corner: usize| point(&mesh.normals, mesh.normal_indices[first + corner]);
                // A face without them has the one of zeros, which the scan added.
                let uv = |corner: usize| {
                    DVec2::from_slice(&mesh.texcoords[2 * mesh.texcoord_indices[first + corner] as usize..])
                };
                self.corners.push(ObjCorners { normals: [0, 1, 2].map(normal), uvs: [0, 1, 2].map(uv) });
                (self.corners.len() - 1) as u32
            } else {
                NO_INDEX
            };
            let positions = [0, 1, 2].map(|corner: usize| point(&mesh.positions, indices[corner]));
            self.triangles.push(ObjTriangle { positions, part: part as u32, corners });
        }
    }

    /// What the `mtllib` statements may name, beside the OBJ file: all words of one together, and each of them.
    pub(super) fn library_paths(&self) -> impl Iterator<Item = PathBuf> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let names = |(names, _): &'_ (String, usize)| -> Vec<PathBuf> {
            std::iter::once(names.as_str())
                .chain(names.split_ascii_whitespace())
                .map(|name| folder.join(name))
                .collect()
        };
        self.libraries.iter().flat_map(names)
    }

    /// The warning of a `usemtl` whose name is in none of `known`.
    pub(super) fn missing_material<'a>(&self, part: &Part, known: impl Iterator<Item = &'a str>) -> String {
        let defined = match known_names(&part.name, known, "the nearest that is defined is", "defined are") {
            Some(names) => names,
            None if self.libraries.is_empty() => "the file has no mtllib, and the scene defines no material".to_owned(),
            None => "no material is defined".to_owned(),
        };
        let (path, name, faces) = (quote::path(&self.path), quoted(bare_name(&part.name)), part.faces);
        let faces = if faces == 1 { "1 face has".to_owned() } else { format!("{faces} faces have") };
        format!("{path}:{}: usemtl {name}: no such material; {faces} the format's own (Kd 0.8); {defined}", part.line)
    }
}

/// Triangles of a mesh whose face has normals on every corner; the corners of others have one that is no number, which
/// the scan added, or none where the whole file has none.
fn smooth_triangles(mesh: &tobj::Mesh) -> impl Iterator<Item = usize> {
    let is_number = |&index: &u32| mesh.normals.get(3 * index as usize).is_some_and(|x| !x.is_nan());
    let smooth = move |indices: &[u32]| indices.iter().all(is_number);
    let triangles = mesh.normal_indices.chunks_exact(3).enumerate();
    triangles.filter(move |(_, indices)| smooth(indices)).map(|(triangle, _)| triangle)
}
