//! A line scan of an OBJ file that owns every refusal: `tobj` gives no line numbers, and has holes.
//!
//! Comes in: the text of an OBJ file. Goes out: an [`ObjScan`], whose canonical text holds nothing but checked `v`,
//! `vt`, `vn`, `f` and numbered `usemtl` lines, points before faces, so that none of `tobj`'s habits (triangles made of
//! `l`, names cut at a tab, vertex colours out of step, normals that a corner does not have taken from another) can be
//! met. What reads the canonical text may assume that every index is in range.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use glam::DVec3;

use super::census::Census;
use super::obj_points::Points;
use super::obj_words::{Corner, corner, rest, room_for};
use super::polygon::{Split, Splitter};
use super::refusals::Refusals;
use super::warnings::{Tally, Warnings};
use crate::{Error, Result};

/// Statements of the OBJ format that say nothing about the surface of polygons.
const SILENT: [&str; 13] =
    ["o", "g", "l", "p", "mg", "bevel", "c_interp", "d_interp", "lod", "maplib", "usemap", "shadow_obj", "trace_obj"];

/// Longest corner that is written anew, in bytes: three indices of ten digits.
const MAX_CORNER_BYTES: usize = 33;

/// What the scan found.
pub(super) struct ObjScan {
    /// The checked points.
    pub points: String,
    /// The checked faces, with `usemtl 1` for the first material named, and so on; 0 is no material.
    pub faces: String,
    /// Materials by number; 0 is that of the faces without one.
    pub parts: Vec<Part>,
    /// What `mtllib` statements name, with their lines; none twice.
    pub libraries: Vec<(String, usize)>,
}

/// The faces of one material.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// Name of the material; empty for the faces without one.
    pub name: String,
    /// Line of the first `usemtl` that names it.
    pub line: usize,
    /// Faces that use it.
    pub faces: usize,
}

impl Part {
    fn new(name: &str, line: usize) -> Part {
        Part { name: name.to_owned(), line, faces: 0 }
    }
}

/// Scans `text`, which `path` holds and whose statements were counted.
pub(super) fn scan(path: &Path, text: &str, census: &Census, warnings: &mut Warnings) -> Result<ObjScan> {
    let mut refusals = Refusals::default();
    let points = Points::read(path, text, census, &mut refusals);
    let mut scanner = Scanner {
        points,
        above: [0; 3],
        part: 0,
        parts: vec![Part::new("", 0)],
        part_of_name: HashMap::new(),
        libraries: Vec::new(),
        library_names: HashSet::new(),
        faces: String::with_capacity(text.len() / 2 + 64),
        corners: Vec::new(),
        positions: Vec::new(),
        splitter: Splitter::new(),
        unknown: Tally::default(),
        curved: Tally::default(),
        bent: Tally::default(),
        overlapping: Tally::default(),
        nameless: Tally::default(),
        smoothing: false,
        smoothed: Tally::default(),
    };
    for (line, number) in text.lines().zip(1..) {
        if let Err((line, message)) = scanner.statement(line, number) {
            refusals.add(Error::scene(path, line.unwrap_or(number), message));
        }
    }
    refusals.in_order_of_lines();
    refusals.finish()?;
    scanner.finish(path, warnings)
}

/// The message of a refusal, and its line where that is not the statement's.
type Refused = (Option<usize>, String);

struct Scanner<'a> {
    points: Points,
    /// Positions, texture coordinates and normals above the line at hand.
    above: [usize; 3],
    part: usize,
    parts: Vec<Part>,
    part_of_name: HashMap<&'a str, usize>,
    libraries: Vec<(String, usize)>,
    library_names: HashSet<&'a str>,
    faces: String,
    /// The face at hand; kept to spare allocations for every one.
    corners: Vec<Corner>,
    positions: Vec<DVec3>,
    splitter: Splitter,
    unknown: Tally,
    curved: Tally,
    bent: Tally,
    overlapping: Tally,
    nameless: Tally,
    /// Whether a smoothing group is on, and faces of such that have no normals.
    smoothing: bool,
    smoothed: Tally,
}

impl<'a> Scanner<'a> {
    fn statement(&mut self, line: &'a str, number: usize) -> std::result::Result<(), Refused> {
        let mut words = line.split_ascii_whitespace();
        let Some(keyword) = words.next() else { return Ok(()) };
        match keyword {
            "v" => self.above[0] += 1,
            "vt" => self.above[1] += 1,
            "vn" => self.above[2] += 1,
            // In the first version of the format, a face was "fo".
            "f" | "fo" => return self.face(words, keyword, number),
            "s" => self.smoothing = !matches!(words.next(), None | Some("off" | "0")),
            "usemtl" => return self.use_material(rest(line, keyword), number).map_err(|message| (None, message)),
            "mtllib" => match rest(line, keyword) {
                "" => self.nameless.add(number, ""),
                name => {
                    if self.library_names.insert(name) {
                        self.libraries.push((name.to_owned(), number));
                    }
                }
            },
            _ if keyword.starts_with('#') || SILENT.contains(&keyword) => {}
            "vp" | "deg" | "bmat" | "step" | "cstype" | "curv" | "curv2" | "surf" | "parm" | "trim" | "hole"
            | "scrv" | "sp" | "end" | "con" | "ctech" | "stech" | "call" | "csh" => self.curved.add(number, keyword),
            _ => self.unknown.add(number, keyword),
        }
        Ok(())
    }

    fn face(
        &mut self,
        words: impl Iterator<Item = &'a str>,
        keyword: &str,
        line: usize,
    ) -> std::result::Result<(), Refused> {
        self.corners.clear();
        self.positions.clear();
        let counts = [self.points.positions.len(), self.points.uvs, self.points.normals];
        for word in words {
            // A comment may end the line.
            let (word, ends) = word.split_once('#').map_or((word, false), |(word, _)| (word, true));
            if !(ends && word.is_empty()) {
                let corner = corner(word, counts, self.above).map_err(|message| (None, message))?;
                self.corners.push(corner);
                self.positions.push(self.points.positions[corner.position]);
            }
            if ends {
                break;
            }
        }
        let count = self.corners.len();
        if count < 3 {
            return Err((None, format!("{keyword} with {count} corners; allowed are 3 or more")));
        }
        for corner in &self.corners {
            // Refused once, at the line of the vertex.
            if let Some((line, message)) = self.points.unusable.remove(&corner.position) {
                return Err((Some(line), message));
            }
        }
        let part = &mut self.parts[self.part];
        room_for(part.faces, "faces").map_err(|message| (None, message))?;
        part.faces += 1;
        self.write_face(line).map_err(|message| (None, message))
    }

    /// Writes the face at hand: as it is where a fan covers it, else as triangles.
    fn write_face(&mut self, line: usize) -> std::result::Result<(), String> {
        let smooth = self.points.normals > 0 && self.corners.iter().all(|corner| corner.normal.is_some());
        if self.smoothing && !smooth {
            self.smoothed.add(line, "");
        }
        let mapped = smooth && self.corners.iter().all(|corner| corner.uv.is_some());
        // What a file has normals for must be said of every corner; those of corners without stand behind the others.
        let (no_uv, no_normal) = (self.points.uvs, self.points.normals);
        let with_normals = self.points.normals > 0;
        let write = |corner: &Corner, faces: &mut String| {
            faces.push(' ');
            push_index(faces, corner.position);
            if with_normals {
                faces.push('/');
                push_index(faces, corner.uv.filter(|_| mapped).unwrap_or(no_uv));
                faces.push('/');
                push_index(faces, corner.normal.filter(|_| smooth).unwrap_or(no_normal));
            }
        };
        let split = self.splitter.split(&self.positions);
        let (Split::Fan { bent, .. } | Split::Ears { bent, .. }) = split;
        if bent {
            self.bent.add(line, "");
        }
        let written = if let Split::Ears { triangles, .. } = split { 3 * triangles.len() } else { self.corners.len() };
        let refused = |_| "the faces, written anew, do not fit in memory".to_owned();
        self.faces.try_reserve((MAX_CORNER_BYTES + 4) * written).map_err(refused)?;
        match split {
            Split::Fan { overlaps, .. } => {
                if overlaps {
                    self.overlapping.add(line, "");
                }
                self.faces.push('f');
                self.corners.iter().for_each(|corner| write(corner, &mut self.faces));
                self.faces.push('\n');
            }
            Split::Ears { triangles, .. } => {
                for triangle in triangles {
                    self.faces.push('f');
                    triangle.iter().for_each(|&place| write(&self.corners[place], &mut self.faces));
                    self.faces.push('\n');
                }
            }
        }
        Ok(())
    }

    fn use_material(&mut self, name: &'a str, line: usize) -> std::result::Result<(), String> {
        self.part = match self.part_of_name.get(name) {
            // What exporters write for no material.
            _ if name.is_empty() || name.starts_with('#') => 0,
            Some(&part) => part,
            None => {
                self.parts.push(Part::new(name, line));
                self.part_of_name.insert(name, self.parts.len() - 1);
                self.parts.len() - 1
            }
        };
        let refused = |_| "the faces, written anew, do not fit in memory".to_owned();
        self.faces.try_reserve(MAX_CORNER_BYTES).map_err(refused)?;
        self.faces.push_str("usemtl ");
        self.faces.push_str(&self.part.to_string());
        self.faces.push('\n');
        Ok(())
    }

    fn finish(self, path: &Path, warnings: &mut Warnings) -> Result<ObjScan> {
        if self.parts.iter().all(|part| part.faces == 0) {
            return Err(Error::scene(path, 0, "no face (f) in the file; allowed is an OBJ file with at least one"));
        }
        self.unknown.warn(
            path,
            warnings,
            "unknown statements",
            "{word} is no statement of the OBJ format: {n} such lines ignored (the first is here)",
        );
        self.curved.warn(
            path,
            warnings,
            "curves",
            "{word}: {n} lines of curves and curved surfaces ignored (the first is here)",
        );
        self.nameless.warn(
            path,
            warnings,
            "mtllib statements without a file name",
            "mtllib without a file name ({n} such lines, the first is here)",
        );
        self.bent.warn(
            path,
            warnings,
            "polygons that are not planar",
            "{n} polygons are not planar and were split into fans (the first is here)",
        );
        self.overlapping.warn(
            path,
            warnings,
            "polygons that cross themselves",
            "{n} polygons cross themselves or have too many corners, and the fans they were split into overlap \
             (the first is here)",
        );
        self.smoothed.warn(
            path,
            warnings,
            "smoothing groups",
            "{n} faces without normals (vn) are flat, though a smoothing group (s) is on (the first is here)",
        );
        self.points.warn(path, warnings);
        let (points, faces) = (self.points.canonical, self.faces);
        Ok(ObjScan { points, faces, parts: self.parts, libraries: self.libraries })
    }
}

/// Appends an index, which counts from 1 in the format.
fn push_index(text: &mut String, index: usize) {
    let mut digits = [0; 20];
    let mut first = digits.len();
    let mut left = index + 1;
    while left > 0 {
        first -= 1;
        digits[first] = b'0' + (left % 10) as u8;
        left /= 10;
    }
    text.push_str(std::str::from_utf8(&digits[first..]).unwrap_or_default());
}
