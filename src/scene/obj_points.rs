//! The positions, texture coordinates and normals of an OBJ file, read before its faces: a face may stand above them.
//!
//! Comes in: the text of an OBJ file. Goes out: [`Points`], in canonical text for `tobj` and, as far as faces are
//! looked at, in memory. A number that is none (`nan`, `1.#IND`, `1e400`) is refused where the picture hangs on it: in
//! the position of a corner. A texture coordinate is 0 then, a normal has no length.

use std::collections::BTreeMap;
use std::path::Path;

use glam::DVec3;

use super::census::Census;
use super::number::in_range;
use super::obj_words::{MAX_COUNT, numbers_or_none, push_numbers, push_words, rest, room_for};
use super::refusals::Refusals;
use super::statements::uncommented;
use super::warnings::{Tally, Warnings};
use crate::Error;

/// Longest statement of numbers that are written anew, in bytes.
const MAX_NUMBERS_BYTES: usize = 96;

/// The points that faces name.
pub(super) struct Points {
    /// Positions in the order of the file.
    pub positions: Vec<DVec3>,
    /// Number of texture coordinates.
    pub uvs: usize,
    /// Number of normals.
    pub normals: usize,
    /// Checked `v` statements; where the file has normals, also `vt` and `vn`, then a texture coordinate of zeros and a
    /// normal that is no number: those of corners that have none.
    pub canonical: String,
    /// Positions that no corner may have: line of each, and why.
    pub unusable: BTreeMap<usize, (usize, String)>,
    with_normals: bool,
    coloured: Tally,
    no_uvs: Tally,
    no_normals: Tally,
}

impl Points {
    /// Reads those of `text`, which `path` holds and whose statements were counted.
    pub(super) fn read(path: &Path, text: &str, census: &Census, refusals: &mut Refusals) -> Points {
        let mut points = Points {
            positions: Vec::with_capacity(census.positions),
            uvs: 0,
            normals: 0,
            canonical: String::with_capacity(text.len() / 2 + 64),
            unusable: BTreeMap::new(),
            with_normals: census.normals > 0,
            coloured: Tally::default(),
            no_uvs: Tally::default(),
            no_normals: Tally::default(),
        };
        for (line, number) in text.lines().zip(1..) {
            let line = line.trim_ascii_start();
            let keyword = match line.as_bytes() {
                [b'v', blank, ..] if blank.is_ascii_whitespace() => "v",
                [b'v', b't', blank, ..] if blank.is_ascii_whitespace() => "vt",
                [b'v', b'n', blank, ..] if blank.is_ascii_whitespace() => "vn",
                b"v" | b"vt" | b"vn" => line,
                _ => continue,
            };
            let body = uncommented(rest(line, keyword));
            let read = match keyword {
                "v" => points.position(body, number),
                "vt" => points.uv(body, number),
                _ => points.normal(body, number),
            };
            if let Err(message) = read {
                refusals.add(Error::scene(path, number, message));
                points.count_refused(keyword);
            }
        }
        if points.with_normals {
            points.canonical.push_str("vt 0 0\nvn NaN NaN NaN\n");
        }
        points
    }

    /// Counts what a refused line would have defined, so that faces are not refused for its want.
    fn count_refused(&mut self, keyword: &str) {
        match keyword {
            "v" if self.positions.len() < MAX_COUNT => self.positions.push(DVec3::ZERO),
            "vt" => self.uvs += 1,
            "vn" => self.normals += 1,
            _ => {}
        }
    }

    fn position(&mut self, body: &str, line: usize) -> std::result::Result<(), String> {
        let (values, count, none) = numbers_or_none::<7>(body.split_ascii_whitespace())?;
        if !matches!(count, 3 | 4 | 6 | 7) {
            return Err(format!("v with {count} numbers; allowed are 3 (x y z), 4 (with w) or 6 (with a colour)"));
        }
        let w = if count == 4 { values[3] } else { 1.0 };
        self.room_to_write()?;
        room_for(self.positions.len(), "vertices")?;
        let mut position = DVec3::new(values[0], values[1], values[2]) / w;
        if !in_range(position) {
            let message = match none {
                Some(message) if values[..3].iter().any(|value| value.is_nan()) || w.is_nan() => message,
                _ => format!("v with w = {w:e}; allowed is a w that keeps x/w, y/w and z/w within 1e100"),
            };
            self.unusable.insert(self.positions.len(), (line, message));
            position = DVec3::ZERO;
        }
        self.positions.push(position);
        // White takes nothing from the colour of a material.
        if count > 4 && values[3..6] != [1.0; 3] {
            self.coloured.add(line, "");
        }
        match count {
            3 if none_of_these(&values[..3]) => push_words(&mut self.canonical, "v", body),
            _ => push_numbers(&mut self.canonical, "v", &position.to_array()),
        }
        Ok(())
    }

    fn uv(&mut self, body: &str, line: usize) -> std::result::Result<(), String> {
        let (values, count, none) = numbers_or_none::<3>(body.split_ascii_whitespace())?;
        if count == 0 {
            return Err("vt with 0 numbers; allowed are 1 to 3 (u v w)".to_owned());
        }
        room_for(self.uvs, "texture coordinates")?;
        self.room_to_write()?;
        self.uvs += 1;
        if none.is_some() {
            self.no_uvs.add(line, "");
        }
        match count {
            _ if !self.with_normals => {}
            2 if none.is_none() => push_words(&mut self.canonical, "vt", body),
            _ => {
                let number = |value: f64| if value.is_nan() { 0.0 } else { value };
                push_numbers(&mut self.canonical, "vt", &[number(values[0]), number(values[1])]);
            }
        }
        Ok(())
    }

    fn normal(&mut self, body: &str, line: usize) -> std::result::Result<(), String> {
        let (_, count, none) = numbers_or_none::<3>(body.split_ascii_whitespace())?;
        if count != 3 {
            return Err(format!("vn with {count} numbers; allowed are 3 (x y z)"));
        }
        room_for(self.normals, "normals")?;
        self.room_to_write()?;
        self.normals += 1;
        if none.is_some() {
            self.no_normals.add(line, "");
        }
        push_words(&mut self.canonical, "vn", if none.is_some() { "0 0 0" } else { body });
        Ok(())
    }

    /// Refuses a text that grows beyond memory when its numbers are written anew.
    fn room_to_write(&mut self) -> std::result::Result<(), String> {
        let refused = |_| "the text, with its numbers written anew, does not fit in memory".to_owned();
        self.canonical.try_reserve(MAX_NUMBERS_BYTES).map_err(refused)
    }

    /// Warns of what was left out, once all faces are read.
    pub(super) fn warn(&self, path: &Path, warnings: &mut Warnings) {
        self.coloured.warn(
            path,
            warnings,
            "vertex colours",
            "colours of {n} vertices are ignored: a surface has the colour of its material (the first is here)",
        );
        self.no_uvs.warn(
            path,
            warnings,
            "texture coordinates that are no numbers",
            "{n} texture coordinates (vt) are no numbers, and 0 is taken (the first is here)",
        );
        self.no_normals.warn(
            path,
            warnings,
            "normals that are no numbers",
            "{n} normals (vn) are no numbers, and count as of length 0 (the first is here)",
        );
        let mut unusable = Tally::default();
        self.unusable.values().for_each(|(line, _)| unusable.add(*line, ""));
        unusable.warn(
            path,
            warnings,
            "vertices that are no numbers",
            "{n} vertices are no numbers; no face names them (the first is here)",
        );
    }
}

fn none_of_these(values: &[f64]) -> bool {
    !values.iter().any(|value| value.is_nan())
}
