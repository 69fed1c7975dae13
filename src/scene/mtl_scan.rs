//! A line scan of an MTL file that owns every refusal; `tobj` never sees the file (it panics at `Kd 0.5 0.5`).
//!
//! Comes in: the text of an MTL file. Goes out: an [`MtlScan`] of the materials it defines and of the images it names.
//! What is wrong with a value, or cannot be shown, is kept with its material: whoever looks a material up for a face
//! refuses what the look hangs on, and warns of the rest ([`super::looks`]).

use std::collections::{BTreeSet, HashMap};
use std::path::Path;

use super::obj_words::rest;
use super::recipe::{Quantity, Recipe};
use super::statements::uncommented;
use super::warnings::{Tally, Warnings};
use crate::quote::{self, quoted};

/// Statements that change nothing for the materials there are; `Ns` says how sharp the highlights of `Ks` are, the last
/// two how those of `Pc` and `aniso` are.
const SILENT: [&str; 9] = ["Ka", "Ns", "Km", "sharpness", "map_Ka", "map_aat", "map_Ns", "Pcr", "anisor"];

/// Statements of the MTL format and its extension for physically based shading that would change the look.
const LOOKS: [&str; 11] = ["Pr", "Pm", "Ps", "Pc", "aniso", "norm", "bump", "disp", "decal", "refl", "Kt"];

/// Statements of those whose value 0 is that of any other surface.
const NOTHING_AT_0: [&str; 4] = ["Pm", "Ps", "Pc", "aniso"];

/// Statements that name an image, beside all that begin with `map_`.
const IMAGES: [&str; 5] = ["norm", "bump", "disp", "decal", "refl"];

/// Most words that the name of an image may have: a name may hold blanks, and options stand before it.
const MOST_WORDS: usize = 16;

/// Names of statements that one warning shows.
pub(super) const NAMES_SHOWN: usize = 16;

/// What one MTL file says.
#[derive(Default)]
pub(super) struct MtlScan {
    /// Materials in the order of the file, by name.
    pub materials: Vec<(String, MtlMaterial)>,
    /// What may be the name of an image: the last words of a statement, as many as there are and fewer.
    pub images: BTreeSet<String>,
}

/// One material of an MTL file.
#[derive(Clone, Debug, Default)]
pub(super) struct MtlMaterial {
    /// Line of its `newmtl`.
    pub line: usize,
    /// What its statements say.
    pub recipe: Recipe,
    /// Values that cannot be read or are out of range: the quantity, its line, the message of the refusal.
    pub wrong: Vec<(Quantity, usize, String)>,
    /// Values a rounding out of range.
    pub rounded: Vec<(Quantity, usize)>,
    /// Lines of colours in forms that are not supported.
    pub forms: Vec<usize>,
    /// Statements that would change the look, the first few by name, with their lines.
    pub ignored: Vec<(String, usize)>,
}

/// Scans `text`, which `path` holds. A material that is defined again starts anew, with a warning.
pub(super) fn scan(path: &Path, text: &str, warnings: &mut Warnings) -> MtlScan {
    let mut found = MtlScan::default();
    let mut index: HashMap<&str, usize> = HashMap::new();
    let mut current: Option<usize> = None;
    let mut unknown = Statements::default();
    let mut astray = Tally::default();
    for (line, number) in text.lines().zip(1..) {
        let mut words = line.split_ascii_whitespace();
        let Some(keyword) = words.next() else { continue };
        if keyword.starts_with('#') || SILENT.contains(&keyword) {
            continue;
        }
        if keyword == "newmtl" {
            // One without a name is nobody's: `usemtl` without a name means no material.
            let name = rest(line, keyword);
            let place = *index.entry(name).or_insert(found.materials.len());
            found.begin(place, name, number, path, warnings);
            current = Some(place);
            continue;
        }
        let material = current.and_then(|current| found.materials.get_mut(current)).map(|(_, material)| material);
        if let Some(quantity) = Quantity::of_statement(keyword) {
            match material {
                Some(material) => material.state(quantity, keyword, uncommented(rest(line, keyword)), number),
                None => astray.add(number, keyword),
            }
        } else if keyword.starts_with("map_") || LOOKS.contains(&keyword) {
            let is_nothing = NOTHING_AT_0.contains(&keyword) && words.next().map(str::parse::<f64>) == Some(Ok(0.0));
            if let Some(material) = material.filter(|_| !is_nothing) {
                material.ignore(keyword, number);
            }
            if keyword.starts_with("map_") || IMAGES.contains(&keyword) {
                found.name_images(rest(line, keyword));
            }
        } else {
            unknown.add(keyword, number);
        }
    }
    astray.warn(
        path,
        warnings,
        "statements above any newmtl",
        "{n} statements stand above any newmtl and are ignored (the first is here: {word})",
    );
    unknown.warn(path, "no statements of the MTL format, ignored", warnings);
    found
}

impl MtlMaterial {
    /// What a statement of numbers says; the last of several counts.
    fn state(&mut self, quantity: Quantity, keyword: &str, words: &str, line: usize) {
        let words = words.split_ascii_whitespace().take(8).collect::<Vec<_>>();
        self.wrong.retain(|(wrong, ..)| *wrong != quantity);
        self.rounded.retain(|(rounded, _)| *rounded != quantity);
        if matches!(words.first(), Some(&("spectral" | "xyz"))) && quantity.numbers() == 3 {
            if self.forms.len() < NAMES_SHOWN {
                self.forms.push(line);
            }
            return;
        }
        self.recipe.state(quantity, line);
        match quantity.set_stated(&mut self.recipe, keyword, &words) {
            Ok(false) => {}
            Ok(true) => self.rounded.push((quantity, line)),
            Err(message) => self.wrong.push((quantity, line, message)),
        }
    }

    fn ignore(&mut self, name: &str, line: usize) {
        if self.ignored.len() < NAMES_SHOWN && !self.ignored.iter().any(|(known, _)| known == name) {
            self.ignored.push((name.to_owned(), line));
        }
    }
}

impl MtlScan {
    /// Begins the material at `place`: the next one, or one that was there.
    fn begin(&mut self, place: usize, name: &str, line: usize, path: &Path, warnings: &mut Warnings) {
        let new = MtlMaterial { line, ..MtlMaterial::default() };
        match self.materials.get_mut(place) {
            Some((_, again)) => {
                if !name.is_empty() {
                    warn_again(path, line, name, warnings);
                }
                *again = new;
            }
            None => self.materials.push((name.to_owned(), new)),
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
        let scan = scan(Path::new("a.mtl"), text, &mut warnings);
        (scan, warnings.finish())
    }

    fn material<'a>(scan: &'a MtlScan, name: &str) -> &'a MtlMaterial {
        &scan.materials.iter().find(|(known, _)| known == name).unwrap().1
    }

    fn recipe<'a>(scan: &'a MtlScan, name: &str) -> &'a Recipe {
        &material(scan, name).recipe
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
    fn what_would_change_the_look_is_kept_with_its_material() {
        let text = "newmtl a\nPm 0\nPr 0.5\nmap_Kd x.png\nPr 0.5\nKa 1 1 1\nKd 0 2 0\nKs 1.00001\nKe spectral a.rfl\n";
        let (scan, warnings) = scanned(text);
        let a = material(&scan, "a");
        assert_eq!(a.ignored, [("Pr".to_owned(), 3), ("map_Kd".to_owned(), 4)]);
        assert_eq!((a.wrong[0].0, a.wrong[0].1), (Quantity::Kd, 7));
        assert_eq!((&a.rounded[..], &a.forms[..]), (&[(Quantity::Ks, 8)][..], &[9][..]));
        assert_eq!((a.recipe.line(Quantity::Kd), a.recipe.line(Quantity::D)), (7, 0));
        assert!(warnings.is_empty(), "{warnings:?}");
        let (again, _) = scanned(&format!("{text}Kd 0.1\n"));
        assert!(material(&again, "a").wrong.is_empty(), "the last of several counts");
    }

    #[test]
    fn what_belongs_to_no_material_is_ignored() {
        let (scan, warnings) = scanned("Kd 1 1 1\nd 1\nnewmtl\nKd 9\nnewmtl a\nKd 0.5 # half\n");
        assert_eq!((scan.materials.len(), recipe(&scan, "a").kd), (2, [0.5; 3]));
        let text = "a.mtl:1: 2 statements stand above any newmtl and are ignored (the first is here: \"Kd\")";
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
