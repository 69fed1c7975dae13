//! A line scan of an OBJ file that owns every refusal: `tobj` gives no line numbers, and has holes.
//!
//! Comes in: the text of an OBJ file. Goes out: an [`ObjScan`], whose canonical text holds nothing but checked `v`, `vt`,
//! `vn`, `f` and numbered `usemtl` lines, so that none of `tobj`'s habits (triangles made of `l`, names cut at a tab,
//! vertex colours out of step) can be met. What reads the canonical text may assume that every index is in range.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use glam::DVec3;

use super::census::Census;
use super::number::in_range;
use super::obj_words::{MAX_COUNT, index, numbers, push_numbers, push_words, rest, room_for};
use super::polygon::{Flaw, flaw};
use super::refusals::Refusals;
use super::warnings::Warnings;
use crate::quote::{self, quoted};
use crate::{Error, Result};

/// Longest statement of numbers that are written anew, in bytes.
const MAX_NUMBERS_BYTES: usize = 96;

/// Statements of the OBJ format that say nothing about the surface of polygons.
const SILENT: [&str; 14] = [
    "o",
    "g",
    "s",
    "l",
    "p",
    "mg",
    "bevel",
    "c_interp",
    "d_interp",
    "lod",
    "maplib",
    "usemap",
    "shadow_obj",
    "trace_obj",
];

/// What the scan found.
pub(super) struct ObjScan {
    /// The checked statements, with `usemtl 1` for the first material named, and so on.
    pub canonical: String,
    /// Materials by number; 0 is that of the faces above any `usemtl`.
    pub parts: Vec<Part>,
    /// What `mtllib` statements name, with their lines; none twice.
    pub libraries: Vec<(String, usize)>,
}

/// The faces of one material.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// Name of the material; empty for the faces above any `usemtl`.
    pub name: String,
    /// Line of the first `usemtl` that names it.
    pub line: usize,
    /// Faces that use it.
    pub faces: usize,
    /// Whether every corner of those faces has a normal.
    pub all_normals: bool,
    /// Whether every corner of those faces has a texture coordinate.
    pub all_uvs: bool,
}

impl Part {
    fn new(name: &str, line: usize) -> Part {
        Part { name: name.to_owned(), line, faces: 0, all_normals: true, all_uvs: true }
    }
}

/// Scans `text`, which `path` holds and whose statements were counted.
pub(super) fn scan(path: &Path, text: &str, census: &Census, warnings: &mut Warnings) -> Result<ObjScan> {
    let mut scanner = Scanner {
        positions: Vec::with_capacity(census.positions),
        uvs: 0,
        normals: 0,
        part: 0,
        parts: vec![Part::new("", 0)],
        part_of_name: HashMap::new(),
        libraries: Vec::new(),
        library_names: HashSet::new(),
        canonical: String::with_capacity(text.len() + 64),
        corners: Vec::new(),
        unknown: Tally::default(),
        curved: Tally::default(),
        bent: Tally::default(),
        folded: Tally::default(),
    };
    let mut refusals = Refusals::default();
    for (index, line) in text.lines().enumerate() {
        if let Err(message) = scanner.statement(line, index + 1) {
            refusals.add(Error::scene(path, index + 1, message));
            scanner.count_refused(line);
        }
    }
    refusals.finish()?;
    scanner.finish(path, warnings)
}

/// How often something was met, and where first.
#[derive(Default)]
struct Tally {
    count: usize,
    line: usize,
    word: String,
}

impl Tally {
    fn add(&mut self, line: usize, word: &str) {
        if self.count == 0 {
            self.line = line;
            self.word = word.to_owned();
        }
        self.count += 1;
    }
}

struct Scanner<'a> {
    positions: Vec<DVec3>,
    uvs: usize,
    normals: usize,
    part: usize,
    parts: Vec<Part>,
    part_of_name: HashMap<&'a str, usize>,
    libraries: Vec<(String, usize)>,
    library_names: HashSet<&'a str>,
    canonical: String,
    /// Positions of the face at hand, kept to spare an allocation a face.
    corners: Vec<DVec3>,
    unknown: Tally,
    curved: Tally,
    bent: Tally,
    folded: Tally,
}

impl<'a> Scanner<'a> {
    fn statement(&mut self, line: &'a str, number: usize) -> std::result::Result<(), String> {
        let mut words = line.split_ascii_whitespace();
        let Some(keyword) = words.next() else { return Ok(()) };
        match keyword {
            "v" => self.vertex(rest(line, keyword)),
            "vt" => self.uv(rest(line, keyword)),
            "vn" => self.normal(rest(line, keyword)),
            "f" => self.face(words, number),
            "usemtl" => self.use_material(rest(line, keyword), number),
            "mtllib" => match rest(line, keyword) {
                "" => Err("mtllib without a file name; allowed is mtllib FILE".to_owned()),
                name => {
                    if self.library_names.insert(name) {
                        self.libraries.push((name.to_owned(), number));
                    }
                    Ok(())
                }
            },
            _ if keyword.starts_with('#') || SILENT.contains(&keyword) => Ok(()),
            "vp" | "deg" | "bmat" | "step" | "cstype" | "curv" | "curv2" | "surf" | "parm" | "trim" | "hole"
            | "scrv" | "sp" | "end" | "con" | "ctech" | "stech" | "call" | "csh" => {
                self.curved.add(number, keyword);
                Ok(())
            }
            _ => {
                self.unknown.add(number, keyword);
                Ok(())
            }
        }
    }

    /// Counts what a refused line would have defined, so that faces below it are not refused for its want.
    fn count_refused(&mut self, line: &str) {
        match line.split_ascii_whitespace().next() {
            Some("v") if self.positions.len() < MAX_COUNT => self.positions.push(DVec3::ZERO),
            Some("vt") => self.uvs += 1,
            Some("vn") => self.normals += 1,
            _ => {}
        }
    }

    fn vertex(&mut self, body: &str) -> std::result::Result<(), String> {
        let (values, count) = numbers::<7>(body.split_ascii_whitespace())?;
        if !matches!(count, 3 | 4 | 6 | 7) {
            return Err(format!("v with {count} numbers; allowed are 3 (x y z), 4 (with w) or 6 (with a colour)"));
        }
        let w = if count == 4 { values[3] } else { 1.0 };
        self.room_to_write()?;
        let position = DVec3::new(values[0], values[1], values[2]) / w;
        if !in_range(position) {
            return Err(format!("v with w = {w:e}; allowed is a w that keeps x/w, y/w and z/w within 1e100"));
        }
        room_for(self.positions.len(), "vertices")?;
        self.positions.push(position);
        match count {
            3 => push_words(&mut self.canonical, "v", body),
            _ => push_numbers(&mut self.canonical, "v", &position.to_array()),
        }
        Ok(())
    }

    fn uv(&mut self, body: &str) -> std::result::Result<(), String> {
        let (values, count) = numbers::<3>(body.split_ascii_whitespace())?;
        if count == 0 {
            return Err("vt with 0 numbers; allowed are 1 to 3 (u v w)".to_owned());
        }
        room_for(self.uvs, "texture coordinates")?;
        self.room_to_write()?;
        self.uvs += 1;
        match count {
            2 => push_words(&mut self.canonical, "vt", body),
            _ => push_numbers(&mut self.canonical, "vt", &values[..2]),
        }
        Ok(())
    }

    fn normal(&mut self, body: &str) -> std::result::Result<(), String> {
        let (_, count) = numbers::<3>(body.split_ascii_whitespace())?;
        if count != 3 {
            return Err(format!("vn with {count} numbers; allowed are 3 (x y z)"));
        }
        room_for(self.normals, "normals")?;
        self.normals += 1;
        push_words(&mut self.canonical, "vn", body);
        Ok(())
    }

    fn face(&mut self, words: impl Iterator<Item = &'a str>, line: usize) -> std::result::Result<(), String> {
        self.corners.clear();
        let (mut all_uvs, mut all_normals) = (true, true);
        self.canonical.push('f');
        for word in words {
            let mut fields = word.split('/');
            let position = fields.next().unwrap_or("");
            let uv = fields.next().unwrap_or("");
            let normal = fields.next().unwrap_or("");
            if fields.next().is_some() {
                return Err(format!(
                    "corner {} has more than 3 indices; allowed is v, v/vt, v//vn or v/vt/vn",
                    quoted(word)
                ));
            }
            let position = index(position, word, self.positions.len(), "vertex", "vertices")?;
            if uv.is_empty() {
                all_uvs = false;
            } else {
                index(uv, word, self.uvs, "texture coordinate", "texture coordinates")?;
            }
            if normal.is_empty() {
                all_normals = false;
            } else {
                index(normal, word, self.normals, "normal", "normals")?;
            }
            self.corners.push(self.positions[position]);
            self.canonical.push(' ');
            self.canonical.push_str(word);
        }
        self.canonical.push('\n');
        if self.corners.len() < 3 {
            return Err(format!("f with {} corners; allowed are 3 or more", self.corners.len()));
        }
        match flaw(&self.corners) {
            Some(Flaw::Bent) => self.bent.add(line, ""),
            Some(Flaw::Folded) => self.folded.add(line, ""),
            None => {}
        }
        let part = &mut self.parts[self.part];
        room_for(part.faces, "faces")?;
        part.faces += 1;
        part.all_uvs &= all_uvs;
        part.all_normals &= all_normals;
        Ok(())
    }

    /// Refuses a text that grows beyond memory when its numbers are written anew.
    fn room_to_write(&mut self) -> std::result::Result<(), String> {
        let refused = |_| "the text, with its numbers written anew, does not fit in memory".to_owned();
        self.canonical.try_reserve(MAX_NUMBERS_BYTES).map_err(refused)
    }

    fn use_material(&mut self, name: &'a str, line: usize) -> std::result::Result<(), String> {
        if name.is_empty() {
            return Err("usemtl without a name; allowed is usemtl NAME".to_owned());
        }
        self.part = match self.part_of_name.get(name) {
            Some(&part) => part,
            None => {
                self.parts.push(Part::new(name, line));
                self.part_of_name.insert(name, self.parts.len() - 1);
                self.parts.len() - 1
            }
        };
        self.room_to_write()?;
        self.canonical.push_str("usemtl ");
        self.canonical.push_str(&self.part.to_string());
        self.canonical.push('\n');
        Ok(())
    }

    fn finish(self, path: &Path, warnings: &mut Warnings) -> Result<ObjScan> {
        if self.parts.iter().all(|part| part.faces == 0) {
            return Err(Error::scene(path, 0, "no face (f) in the file; allowed is an OBJ file with at least one"));
        }
        let mut warn = |tally: &Tally, kind: &'static str, text: &str| {
            if tally.count > 0 {
                let (line, count, word) = (tally.line, tally.count, quoted(&tally.word));
                // The word comes last: what it holds is not looked at.
                let text = text.replace("{n}", &count.to_string()).replace("{word}", &word);
                warnings.add(kind, || format!("{}:{line}: {text}", quote::path(path)));
            }
        };
        warn(
            &self.unknown,
            "unknown statements",
            "{word} is no statement of the OBJ format: {n} such lines ignored (the first is here)",
        );
        warn(&self.curved, "curves", "{word}: {n} lines of curves and curved surfaces ignored (the first is here)");
        warn(
            &self.bent,
            "polygons that are not planar",
            "{n} polygons are not planar and were split into fans (the first is here)",
        );
        warn(
            &self.folded,
            "concave polygons",
            "{n} polygons are concave, and the fans they were split into overlap (the first is here)",
        );
        Ok(ObjScan { canonical: self.canonical, parts: self.parts, libraries: self.libraries })
    }
}
