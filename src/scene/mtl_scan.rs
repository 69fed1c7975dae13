//! A line scan of an MTL file that owns every refusal; `tobj` never sees the file (it panics at `Kd 0.5 0.5`).
//!
//! Comes in: the text of an MTL file. Goes out: an [`MtlScan`] of the materials it defines, checked, and of the images
//! it names; warnings. One warning names the statements that would change the look and are not supported.

use std::collections::{BTreeSet, HashMap};
use std::path::Path;

use super::obj_words::rest;
use super::recipe::{Quantity, Recipe};
use super::refusals::Refusals;
use super::warnings::Warnings;
use crate::quote::{self, quoted};
use crate::{Error, Result};

/// Statements that change nothing for the materials there are.
const SILENT: [&str; 5] = ["Ka", "Ns", "Km", "sharpness", "Tf"];

/// Statements of the MTL format and its extension for physically based shading that would change the look.
const LOOKS: [&str; 13] =
    ["Pr", "Pm", "Ps", "Pc", "Pcr", "aniso", "anisor", "norm", "bump", "disp", "decal", "refl", "Tr"];

/// Statements that name an image, beside all that begin with `map_`.
const IMAGES: [&str; 5] = ["norm", "bump", "disp", "decal", "refl"];

/// Most words that the name of an image may have: a name may hold blanks, and options stand before it.
const MOST_WORDS: usize = 16;

/// Names of statements that one warning shows.
const NAMES_SHOWN: usize = 16;

/// What one MTL file says.
#[derive(Default)]
pub(super) struct MtlScan {
    /// Materials in the order of the file.
    pub materials: Vec<MtlMaterial>,
    /// What may be the name of an image: the last words of a statement, as many as there are and fewer.
    pub images: BTreeSet<String>,
}

/// One material of an MTL file.
#[derive(Debug)]
pub(super) struct MtlMaterial {
    /// Name.
    pub name: String,
    /// Line of its `newmtl`.
    pub line: usize,
    /// What its statements say.
    pub recipe: Recipe,
}

/// Scans `text`, which `path` holds. A material that is defined again starts anew, with a warning.
pub(super) fn scan(path: &Path, text: &str, warnings: &mut Warnings) -> Result<MtlScan> {
    let mut found = MtlScan::default();
    let mut index: HashMap<&str, usize> = HashMap::new();
    let mut current: Option<usize> = None;
    let mut ignored = Statements::default();
    let mut unknown = Statements::default();
    let mut refusals = Refusals::default();
    for (line, number) in text.lines().zip(1..) {
        let refuse = |message: String| Error::scene(path, number, message);
        let mut words = line.split_ascii_whitespace();
        let Some(keyword) = words.next() else { continue };
        if keyword.starts_with('#') || SILENT.contains(&keyword) {
            continue;
        }
        if keyword == "newmtl" {
            let name = rest(line, keyword);
            if name.is_empty() {
                refusals.add(refuse("newmtl without a name; allowed is newmtl NAME".to_owned()));
            }
            let place = *index.entry(name).or_insert(found.materials.len());
            found.begin(place, name, number, path, warnings);
            current = Some(place);
        } else if let Some(quantity) = Quantity::of_statement(keyword) {
            let Some(material) = current.and_then(|current| found.materials.get_mut(current)) else {
                let message = format!("{keyword} above any newmtl; allowed is {keyword} below newmtl NAME");
                refusals.add(refuse(message));
                continue;
            };
            let values = words.collect::<Vec<_>>();
            refusals.keep(quantity.set(&mut material.recipe, keyword, &values).map_err(refuse));
        } else if keyword.starts_with("map_") || LOOKS.contains(&keyword) {
            if keyword.starts_with("map_") || IMAGES.contains(&keyword) {
                found.name_images(rest(line, keyword));
            }
            // `Tr 0` is what exporters write beside `d 1`.
            let harmless = keyword == "Tr" && words.next().and_then(|word| word.parse::<f64>().ok()) == Some(0.0);
            if !harmless {
                ignored.add(keyword, number);
            }
        } else {
            unknown.add(keyword, number);
        }
    }
    refusals.finish()?;
    ignored.warn(path, "not supported yet and ignored, though they would change the look", warnings);
    unknown.warn(path, "no statements of the MTL format, ignored", warnings);
    Ok(found)
}

impl MtlScan {
    /// Begins the material at `place`: the next one, or one that was there.
    fn begin(&mut self, place: usize, name: &str, line: usize, path: &Path, warnings: &mut Warnings) {
        match self.materials.get_mut(place) {
            Some(again) => {
                warn_again(path, line, name, warnings);
                (again.line, again.recipe) = (line, Recipe::default());
            }
            None => self.materials.push(MtlMaterial { name: name.to_owned(), line, recipe: Recipe::default() }),
        }
    }

    /// Keeps what may be the name of an image in the words behind a statement.
    fn name_images(&mut self, words: &str) {
        let mut place = words.len();
        for word in words.split_ascii_whitespace().rev().take(MOST_WORDS) {
            // What is left before the words so far ends in this word.
            place = words[..place].trim_ascii_end().len() - word.len();
            self.images.insert(words[place..].to_owned());
        }
    }
}

/// Warns of a material that is defined again, in one file or in several of one OBJ file.
pub(super) fn warn_again(path: &Path, line: usize, name: &str, warnings: &mut Warnings) {
    warnings.add("materials defined again", || {
        format!("{}:{line}: material {} is defined again; this one counts", quote::path(path), quoted(name))
    });
}

/// Statements of one kind, the first few of them by name.
#[derive(Default)]
struct Statements<'a> {
    names: Vec<&'a str>,
    line: usize,
}

impl<'a> Statements<'a> {
    fn add(&mut self, name: &'a str, line: usize) {
        if self.names.is_empty() {
            self.line = line;
        }
        if self.names.len() < NAMES_SHOWN && !self.names.contains(&name) {
            self.names.push(name);
        }
    }

    fn warn(&self, path: &Path, text: &'static str, warnings: &mut Warnings) {
        if !self.names.is_empty() {
            let names = self.names.iter().map(|name| quoted(name)).collect::<Vec<_>>().join(", ");
            warnings.add(text, || format!("{}:{}: {names}: {text}", quote::path(path), self.line));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scanned(text: &str) -> (MtlScan, Vec<String>) {
        let mut warnings = Warnings::default();
        let scan = scan(Path::new("a.mtl"), text, &mut warnings).unwrap();
        (scan, warnings.finish())
    }

    fn recipe<'a>(scan: &'a MtlScan, name: &str) -> &'a Recipe {
        &scan.materials.iter().find(|material| material.name == name).unwrap().recipe
    }

    #[test]
    fn statements_fill_the_recipe_of_their_material() {
        let (scan, warnings) = scanned("# c\nnewmtl a b\n\tKd .1 .2 .3\nillum 7\nNi 1.5\nnewmtl c\nKe 1 2 3\nd 0.5\n");
        let a = recipe(&scan, "a b");
        assert_eq!((a.kd, a.illum, a.ni, a.ke, a.d), ([0.1, 0.2, 0.3], 7, 1.5, [0.0; 3], 1.0));
        let c = recipe(&scan, "c");
        assert_eq!((c.ke, c.d), ([1.0, 2.0, 3.0], 0.5));
        assert!(warnings.is_empty());
    }

    #[test]
    fn one_warning_names_what_is_ignored() {
        let (_, warnings) = scanned("newmtl a\nTr 0\nPr 0.5\nmap_Kd x.png\nPr 0.5\nKa 1 1 1\n");
        let text = "a.mtl:3: \"Pr\", \"map_Kd\": not supported yet and ignored, though they would change the look";
        assert_eq!(warnings, [text]);
    }

    #[test]
    fn a_material_defined_again_starts_anew() {
        let (scan, warnings) = scanned("newmtl a\nKd 0 0 0\nnewmtl b\nnewmtl a\nNi 2\n");
        assert_eq!(scan.materials.len(), 2);
        assert_eq!((recipe(&scan, "a").kd, recipe(&scan, "a").ni), ([0.8; 3], 2.0));
        assert_eq!(warnings, ["a.mtl:4: material \"a\" is defined again; this one counts"]);
    }

    #[test]
    fn every_end_of_an_image_statement_may_be_its_name() {
        let (scan, _) = scanned("newmtl a\nbump -bm 0.5 my wood.png \nmap_Kd x.png\nPr 0.5\n");
        let names = ["-bm 0.5 my wood.png", "0.5 my wood.png", "my wood.png", "wood.png", "x.png"];
        assert_eq!(scan.images.iter().map(String::as_str).collect::<Vec<_>>(), names);
        let (long, _) = scanned(&format!("norm {}\n", "a ".repeat(1000)));
        assert_eq!(long.images.len(), MOST_WORDS);
    }
}
