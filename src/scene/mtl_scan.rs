//! A line scan of an MTL file that owns every refusal; `tobj` never sees the file (it panics at `Kd 0.5 0.5`).
//!
//! Comes in: the text of an MTL file. Goes out: the materials it defines, checked, and warnings. One warning names the
//! statements that would change the look and are not supported.

use std::path::{Path, PathBuf};

use super::obj_scan::rest;
use super::recipe::{Quantity, Recipe};
use super::refusals::Refusals;
use super::source_text::quoted;
use crate::{Error, Result};

/// Statements that change nothing for the materials there are.
const SILENT: [&str; 5] = ["Ka", "Ns", "Km", "sharpness", "Tf"];

/// Statements of the MTL format and its extension for physically based shading that would change the look.
const LOOKS: [&str; 13] =
    ["Pr", "Pm", "Ps", "Pc", "Pcr", "aniso", "anisor", "norm", "bump", "disp", "decal", "refl", "Tr"];

/// The materials of one or more MTL files.
#[derive(Default)]
pub(super) struct Library {
    /// Materials by name, in the order of the files.
    pub recipes: Vec<(String, Recipe)>,
    /// The files that were read.
    pub files: Vec<PathBuf>,
    /// Warnings with file and line.
    pub warnings: Vec<String>,
}

impl Library {
    /// The material of this name.
    pub(super) fn find(&self, name: &str) -> Option<&Recipe> {
        self.recipes.iter().find(|(known, _)| known == name).map(|(_, recipe)| recipe)
    }

    /// Adds the materials in `text`, which `path` holds. A name that is defined again is replaced, with a warning.
    pub(super) fn scan(&mut self, path: &Path, text: &str) -> Result<()> {
        self.files.push(path.to_owned());
        let mut current: Option<usize> = None;
        let mut ignored: Vec<(String, usize)> = Vec::new();
        let mut unknown: Vec<(String, usize)> = Vec::new();
        let mut refusals = Refusals::default();
        for (index, line) in text.lines().enumerate() {
            let number = index + 1;
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
                current = Some(self.begin(path, number, name));
            } else if let Some(quantity) = Quantity::of_statement(keyword) {
                let Some(current) = current else {
                    let message = format!("{keyword} above any newmtl; allowed is {keyword} below newmtl NAME");
                    refusals.add(refuse(message));
                    continue;
                };
                let values = words.collect::<Vec<_>>();
                refusals.keep(quantity.set(&mut self.recipes[current].1, keyword, &values).map_err(refuse));
            } else if keyword.starts_with("map_") || LOOKS.contains(&keyword) {
                // `Tr 0` is what exporters write beside `d 1`.
                let harmless = keyword == "Tr" && words.next().and_then(|word| word.parse::<f64>().ok()) == Some(0.0);
                if !harmless && !ignored.iter().any(|(known, _)| known == keyword) {
                    ignored.push((keyword.to_owned(), number));
                }
            } else if !unknown.iter().any(|(known, _)| known == keyword) {
                unknown.push((keyword.to_owned(), number));
            }
        }
        refusals.finish()?;
        self.warn(path, &ignored, "not supported yet and ignored, though they would change the look");
        self.warn(path, &unknown, "no statements of the MTL format, ignored");
        Ok(())
    }

    fn begin(&mut self, path: &Path, line: usize, name: &str) -> usize {
        if let Some(again) = self.recipes.iter().position(|(known, _)| known == name) {
            self.warnings.push(format!(
                "{}:{line}: material {} is defined again; this one counts",
                path.display(),
                quoted(name)
            ));
            self.recipes[again].1 = Recipe::default();
            return again;
        }
        self.recipes.push((name.to_owned(), Recipe::default()));
        self.recipes.len() - 1
    }

    fn warn(&mut self, path: &Path, statements: &[(String, usize)], text: &str) {
        if let Some((_, line)) = statements.first() {
            let names = statements.iter().take(16).map(|(name, _)| quoted(name)).collect::<Vec<_>>().join(", ");
            self.warnings.push(format!("{}:{line}: {names}: {text}", path.display()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scan(text: &str) -> Result<Library> {
        let mut library = Library::default();
        library.scan(Path::new("a.mtl"), text).map(|()| library)
    }

    #[test]
    fn statements_fill_the_recipe_of_their_material() {
        let library = scan("# c\nnewmtl a b\n\tKd .1 .2 .3\nillum 7\nNi 1.5\nnewmtl c\nKe 1 2 3\nd 0.5\n").unwrap();
        let a = library.find("a b").unwrap();
        assert_eq!((a.kd, a.illum, a.ni, a.ke, a.d), ([0.1, 0.2, 0.3], 7, 1.5, [0.0; 3], 1.0));
        assert_eq!(library.find("c").map(|c| (c.ke, c.d)), Some(([1.0, 2.0, 3.0], 0.5)));
        assert!(library.warnings.is_empty());
    }

    #[test]
    fn one_warning_names_what_is_ignored() {
        let library = scan("newmtl a\nTr 0\nPr 0.5\nmap_Kd x.png\nPr 0.5\nKa 1 1 1\n").unwrap();
        let text = "a.mtl:3: \"Pr\", \"map_Kd\": not supported yet and ignored, though they would change the look";
        assert_eq!(library.warnings, [text]);
    }

    #[test]
    fn a_material_defined_again_starts_anew() {
        let library = scan("newmtl a\nKd 0 0 0\nnewmtl a\nNi 2\n").unwrap();
        assert_eq!(library.recipes.len(), 1);
        assert_eq!(library.find("a").map(|a| a.kd), Some([0.8; 3]));
        assert_eq!(library.warnings, ["a.mtl:3: material \"a\" is defined again; this one counts"]);
    }
}
