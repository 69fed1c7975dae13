//! The MTL files of a scene, each read once, and which of them an OBJ file names.
//!
//! Comes in: the names in `mtllib` statements. Goes out: materials by name. A name is looked up in one table of all
//! files, so neither many files nor many materials make a look-up longer than the shorter of two lists: the files that
//! define the name, and the files that the OBJ file names.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::census::Census;
use super::mtl_scan::{scan, warn_again};
use super::obj_mesh::ObjMesh;
use super::recipe::Recipe;
use super::source_text::{self, Folders, Named, check_memory};
use super::warnings::Warnings;
use crate::quote::quoted;
use crate::{Error, Result};

/// All MTL files that were read.
#[derive(Default)]
pub(super) struct Libraries {
    files: Vec<MtlFile>,
    file_of_path: HashMap<PathBuf, usize>,
    /// Definitions of each name, in the order in which their files were read.
    definitions: HashMap<Arc<str>, Vec<Definition>>,
}

/// One MTL file.
struct MtlFile {
    path: PathBuf,
    /// Materials in the order of the file.
    names: Vec<Arc<str>>,
}

/// One definition of a name.
struct Definition {
    file: usize,
    line: usize,
    recipe: Recipe,
}

/// The MTL files that one OBJ file names.
#[derive(Default)]
pub(super) struct Library {
    /// Files in the order of the statements, none twice.
    files: Vec<usize>,
    /// Place of a file in that order.
    place: HashMap<usize, usize>,
}

impl Libraries {
    /// Reads the files that `mesh` names, beside it, as far as they are not read yet. What may be files, read or not,
    /// is added to `named`.
    pub(super) fn of(
        &mut self,
        mesh: &ObjMesh,
        folders: &mut Folders,
        named: &mut Named,
        warnings: &mut Warnings,
    ) -> Result<Library> {
        let mut library = Library::default();
        let folder = mesh.path.parent().unwrap_or(Path::new(""));
        for (names, line) in &mesh.libraries {
            // The format separates several names by blanks, and exporters write single names that hold blanks.
            let whole = folder.join(names).exists();
            let names = if whole { vec![names.as_str()] } else { names.split_ascii_whitespace().collect() };
            for name in names {
                let path = folder.join(name);
                let key = folders.key(&path);
                let file = match self.file_of_path.get(&key) {
                    Some(&file) => file,
                    None => {
                        let bytes = source_text::read_bytes(&path).map_err(|reason| {
                            Error::scene(&mesh.path, *line, format!("mtllib {}: {reason}", quoted(name)))
                        })?;
                        let file = self.add(&path, &source_text::decode(&path, bytes)?, named, warnings)?;
                        self.file_of_path.insert(key, file);
                        file
                    }
                };
                library.add(file);
            }
        }
        Ok(library)
    }

    /// Adds the materials in `text`, which `path` holds. Goes out: the number of the file.
    fn add(&mut self, path: &Path, text: &str, named: &mut Named, warnings: &mut Warnings) -> Result<usize> {
        check_memory(path, 0, "its materials", Census::of(text).mtl_bytes())?;
        let found = scan(path, text, warnings)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        named.extend(found.images.iter().map(|image| folder.join(image).into_os_string()));
        let file = self.files.len();
        let mut names = Vec::with_capacity(found.materials.len());
        for material in found.materials {
            let name: Arc<str> = material.name.into();
            let definition = Definition { file, line: material.line, recipe: material.recipe };
            match self.definitions.get_mut(&name) {
                Some(definitions) => definitions.push(definition),
                None => drop(self.definitions.insert(name.clone(), vec![definition])),
            }
            names.push(name);
        }
        self.files.push(MtlFile { path: path.to_owned(), names });
        Ok(file)
    }

    /// The material of this name in the files of `library`: the last that is defined, with a warning where there are
    /// several.
    pub(super) fn find(&self, library: &Library, name: &str, warnings: &mut Warnings) -> Option<&Recipe> {
        let definitions = self.definitions.get(name)?;
        let mut found: Vec<&Definition> = match definitions.len() <= library.files.len() {
            true => definitions.iter().filter(|definition| library.place.contains_key(&definition.file)).collect(),
            false => {
                let of_file = |file: &usize| definitions.binary_search_by_key(file, |definition| definition.file).ok();
                library.files.iter().filter_map(of_file).map(|place| &definitions[place]).collect()
            }
        };
        found.sort_by_key(|definition| library.place.get(&definition.file));
        for again in found.iter().skip(1) {
            warn_again(&self.files[again.file].path, again.line, name, warnings);
        }
        found.last().map(|definition| &definition.recipe)
    }

    /// Names of all materials of `library`, in the order of its files.
    pub(super) fn names<'a>(&'a self, library: &'a Library) -> impl Iterator<Item = &'a str> {
        library.files.iter().flat_map(|&file| &self.files[file].names).map(AsRef::as_ref)
    }
}

impl Library {
    fn add(&mut self, file: usize) {
        if !self.place.contains_key(&file) {
            self.place.insert(file, self.files.len());
            self.files.push(file);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_file_that_an_obj_names_counts() {
        let mut libraries = Libraries::default();
        let mut warnings = Warnings::default();
        let mut add =
            |path: &str, text: &str| libraries.add(Path::new(path), text, &mut Named::new(), &mut warnings).unwrap();
        let files =
            [add("a.mtl", "newmtl m\nNi 2\n"), add("b.mtl", "newmtl m\nNi 3\nnewmtl n\n"), add("c.mtl", "newmtl m\n")];
        let library = |order: &[usize]| {
            let mut library = Library::default();
            order.iter().for_each(|&file| library.add(files[file]));
            library
        };
        for (order, ni) in [(vec![0], 2.0), (vec![0, 1], 3.0), (vec![1, 0], 2.0), (vec![0, 1, 1, 0], 3.0)] {
            let found = libraries.find(&library(&order), "m", &mut Warnings::default());
            assert_eq!(found.map(|recipe| recipe.ni), Some(ni), "{order:?}");
        }
        let mut warnings = Warnings::default();
        assert!(libraries.find(&library(&[1, 0]), "m", &mut warnings).is_some());
        assert!(libraries.find(&library(&[0, 2]), "n", &mut warnings).is_none());
        assert_eq!(warnings.finish(), ["a.mtl:1: material \"m\" is defined again; this one counts"]);
        assert_eq!(libraries.names(&library(&[1, 0])).collect::<Vec<_>>(), ["m", "n", "m"]);
    }
}
