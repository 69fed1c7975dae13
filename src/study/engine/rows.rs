//! The raw figures of a study, kept on disk as they come.
//!
//! Comes in: a folder, what is being measured where, rows. Goes out: `NAME.json` (everything) and `NAME.csv` (a line a row,
//! fractions to nine digits), written anew after each row, whole or not at all. A study of the same origin goes on from what it
//! finds there; rows of another device, driver, version, kernel or set of options are never mixed in: they are refused.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::output::write_whole;
use crate::study::engine::Spread;
use crate::{Error, Result};

/// What all rows of a study have in common.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// Name of the study.
    pub study: String,
    /// texray's version.
    pub version: String,
    /// Hash of the path tracer's kernel, which changes more often.
    pub kernel: String,
    /// The device, by its driver.
    pub device: String,
    /// The driver and its version.
    pub driver: String,
    /// Processor cores that the system offers.
    pub cores: usize,
    /// The command that remakes it.
    pub command: String,
}

/// One measurement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Name of the scene.
    pub scene: String,
    /// What was measured.
    pub case: String,
    /// Which time, from 0.
    pub repeat: u32,
    /// Figures by name, with units in the names.
    pub values: BTreeMap<String, f64>,
}

/// The rows of a study and their files.
#[derive(Debug)]
pub struct Rows {
    json: PathBuf,
    csv: PathBuf,
    document: Document,
}

#[derive(Debug, Serialize, Deserialize)]
struct Document {
    schema: u32,
    origin: Origin,
    /// The command as it can be typed again, with all of its options; where it is not known, that of the origin.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    remade_by: Option<String>,
    rows: Vec<Row>,
}

impl Origin {
    /// Whether rows of both may stand in one report: the same program on the same device.
    pub fn agrees(&self, other: &Origin) -> bool {
        let part = |origin: &Origin| Origin { study: String::new(), command: String::new(), ..origin.clone() };
        part(self) == part(other)
    }
}

impl Rows {
    /// Opens the study's files in `folder`, which is made if it is not there.
    ///
    /// Fails with [`Error::Output`] where the folder cannot be written, or holds rows of another origin.
    pub fn open(folder: &Path, origin: Origin, remade_by: Option<String>) -> Result<Rows> {
        std::fs::create_dir_all(folder).map_err(|error| Error::output(folder, error.to_string()))?;
        let json = folder.join(format!("{}.json", origin.study));
        let csv = json.with_extension("csv");
        let rows = match std::fs::read_to_string(&json) {
            Ok(text) => stored(&json, &text, &origin)?,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Vec::new(),
            Err(error) => return Err(Error::output(json, error.to_string())),
        };
        let rows = Rows { json, csv, document: Document { schema: 1, origin, remade_by, rows } };
        rows.write()?;
        Ok(rows)
    }

    /// The rows of `study` that are in `folder`, whatever made them; `None` where there are none that can be read.
    pub fn read(folder: &Path, study: &str) -> Option<Rows> {
        let json = folder.join(format!("{study}.json"));
        let document: Document = serde_json::from_str(&std::fs::read_to_string(&json).ok()?).ok()?;
        Some(Rows { csv: json.with_extension("csv"), json, document })
    }

    /// The rows, in the order in which they were measured.
    pub fn all(&self) -> &[Row] {
        &self.document.rows
    }

    /// The scenes by name, in the order in which they were measured.
    pub fn scenes(&self) -> Vec<&str> {
        let mut scenes: Vec<&str> = Vec::new();
        for row in self.all() {
            if !scenes.contains(&row.scene.as_str()) {
                scenes.push(&row.scene);
            }
        }
        scenes
    }

    /// The middle of figure `value` over all repeats of a case; `None` where it was not measured.
    pub fn median(&self, scene: &str, case: &str, value: &str) -> Option<f64> {
        self.spread(scene, case, value).map(|spread| spread.median)
    }

    /// Middle and range of figure `value` over all repeats of a case.
    pub fn spread(&self, scene: &str, case: &str, value: &str) -> Option<Spread> {
        Spread::of(self.values(scene, case, value))
    }

    /// What all have in common.
    pub fn origin(&self) -> &Origin {
        &self.document.origin
    }

    /// The command that remakes them.
    pub fn remade_by(&self) -> &str {
        self.document.remade_by.as_deref().unwrap_or(&self.document.origin.command)
    }

    /// Whether this has been measured.
    pub fn has(&self, scene: &str, case: &str, repeat: u32) -> bool {
        self.all().iter().any(|row| row.scene == scene && row.case == case && row.repeat == repeat)
    }

    /// Figure `value` of all repeats of a case.
    pub fn values<'a>(&'a self, scene: &'a str, case: &'a str, value: &'a str) -> impl Iterator<Item = f64> + 'a {
        let of_case = self.all().iter().filter(move |row| row.scene == scene && row.case == case);
        of_case.filter_map(move |row| row.values.get(value).copied())
    }

    /// Adds a row and writes the files.
    pub fn add(&mut self, row: Row) -> Result<()> {
        self.document.rows.push(row);
        self.write()
    }

    /// Rows that are nowhere on disk, to be summed up.
    #[cfg(test)]
    pub(in crate::study) fn synthetic(rows: &[tests::Synthetic<'_>]) -> Rows {
        let row = |&(scene, case, repeat, values): &tests::Synthetic<'_>| Row {
            scene: scene.into(),
            case: case.into(),
            repeat,
            values: values.iter().map(|&(name, value)| (name.into(), value)).collect(),
        };
        let mut all = tests::rows_of_nothing();
        all.document.rows = rows.iter().map(row).collect();
        all
    }

    fn write(&self) -> Result<()> {
        let text = serde_json::to_string_pretty(&self.document)
            .map_err(|error| Error::Internal(format!("rows that are not JSON: {error}")))?;
        write_whole(&self.json, false, text.as_bytes())?;
        write_whole(&self.csv, false, self.table().as_bytes())
    }

    /// A line a row; a figure that a row lacks is empty.
    fn table(&self) -> String {
        let names: BTreeSet<&String> = self.all().iter().flat_map(|row| row.values.keys()).collect();
        let mut text = String::from("scene,case,repeat");
        names.iter().for_each(|name| text += &format!(",{}", quoted(name)));
        for row in self.all() {
            text += &format!("\n{},{},{}", quoted(&row.scene), quoted(&row.case), row.repeat);
            for name in &names {
                text.push(',');
                if let Some(value) = row.values.get(*name) {
                    text += &nine_digits(*value);
                }
            }
        }
        text + "\n"
    }
}

/// The rows of the file, if they are of this origin.
fn stored(json: &Path, text: &str, origin: &Origin) -> Result<Vec<Row>> {
    let document: Document =
        serde_json::from_str(text).map_err(|error| Error::output(json, format!("no rows of a study: {error}")))?;
    if document.origin != *origin {
        let message = "holds rows of another device, driver, version, kernel or command; give another folder to --out";
        return Err(Error::output(json, message));
    }
    Ok(document.rows)
}

/// A field of CSV (RFC 4180).
fn quoted(field: &str) -> String {
    match field.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", field.replace('"', "\"\"")),
        false => field.into(),
    }
}

/// A whole number as it is, another one to nine digits: far finer than what a machine's noise leaves of a figure.
fn nine_digits(value: f64) -> String {
    if value.fract() == 0.0 {
        return value.to_string();
    }
    // What was printed is a number again, and its shortest form is short.
    format!("{value:.8e}").parse().unwrap_or(value).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Scene, case, repeat and figures of a row.
    pub(in crate::study) type Synthetic<'a> = (&'a str, &'a str, u32, &'a [(&'a str, f64)]);

    pub(super) fn rows_of_nothing() -> Rows {
        let document = Document { schema: 1, origin: origin("one"), remade_by: None, rows: Vec::new() };
        Rows { json: PathBuf::new(), csv: PathBuf::new(), document }
    }

    fn origin(device: &str) -> Origin {
        Origin {
            study: "speed".into(),
            version: "1".into(),
            kernel: "k".into(),
            device: device.into(),
            driver: "d".into(),
            cores: 2,
            command: "texray study speed".into(),
        }
    }

    fn row(case: &str, repeat: u32, name: &str, value: f64) -> Row {
        Row { scene: "a,b".into(), case: case.into(), repeat, values: BTreeMap::from([(name.into(), value)]) }
    }

    #[test]
    fn rows_come_back_and_others_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let mut rows = Rows::open(folder.path(), origin("one"), Some("a command".into())).unwrap();
        rows.add(row("x", 0, "seconds", 1.5)).unwrap();
        rows.add(row("x", 1, "bytes", 7.0)).unwrap();
        assert_eq!(Rows::read(folder.path(), "speed").unwrap().remade_by(), "a command");
        let again = Rows::open(folder.path(), origin("one"), None).unwrap();
        assert_eq!(again.remade_by(), "texray study speed");
        assert_eq!(again.all(), rows.all());
        assert!(again.has("a,b", "x", 1) && !again.has("a,b", "x", 2));
        assert_eq!(again.values("a,b", "x", "seconds").collect::<Vec<_>>(), [1.5]);
        let csv = std::fs::read_to_string(folder.path().join("speed.csv")).unwrap();
        assert_eq!(csv, "scene,case,repeat,bytes,seconds\n\"a,b\",x,0,,1.5\n\"a,b\",x,1,7,\n");
        assert_eq!(nine_digits(0.1 + 0.2), "0.3");
        assert_eq!(nine_digits(-1_234.567_891_234), "-1234.56789");
        assert_eq!(nine_digits(1.234_567_891_2e-5), "0.0000123456789");
        assert_eq!((nine_digits(12_345_678_912.0).as_str(), nine_digits(f64::NAN).as_str()), ("12345678912", "NaN"));
        let error = Rows::open(folder.path(), origin("two"), None).unwrap_err();
        assert!(error.to_string().contains("another device"), "{error}");
        std::fs::write(folder.path().join("speed.json"), "{}").unwrap();
        assert!(Rows::open(folder.path(), origin("one"), None).is_err());
    }
}
