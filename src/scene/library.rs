//! The MTL files of a scene, each read once, and which of them an OBJ file names.
//!
//! Comes in: the names in `mtllib` statements. Goes out: materials by name; a file that is not there is a warning. A
//! name is looked up in one table of all files, so neither many files nor many materials make a look-up longer than the
//! shorter of two lists: the files that define the name, and the files that the OBJ file names.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::census::Census;
use super::library_path::{find, names};
use super::mtl_scan::{MtlMaterial, scan, warn_again};
use super::obj_mesh::ObjMesh;
use super::source_text::{self, Folders, Named, check_memory};
use super::statements::bare_name;
use super::warnings::Warnings;
use crate::quote::{self, quoted};
use crate::{Error, Result};

/// All MTL files that were read.
#[derive(Default)]
pub(super) struct Libraries {
    files: Vec<MtlFile>,
    file_of_path: HashMap<PathBuf, usize>,
    /// Definitions of each name, in the order in which their files were read.
    definitions: HashMap<Arc<str>, Vec<Definition>>,
    /// Names that have a comment behind them, by what stands before it.
    commented: HashMap<Arc<str>, Arc<str>>,
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
    material: MtlMaterial,
}

/// A material that was found.
pub(super) struct FoundMaterial<'a> {
    /// Number of its file.
    pub file: usize,
    /// Its file.
    pub path: &'a Path,
    /// What the file says.
    pub material: &'a MtlMaterial,
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
    /// is added to `seen`.
    pub(super) fn of(
        &mut self,
        mesh: &ObjMesh,
        folders: &mut Folders,
        seen: &mut Named,
        warnings: &mut Warnings,
        notes: &mut Warnings,
    ) -> Result<Library> {
        let mut library = Library::default();
        let folder = mesh.path.parent().unwrap_or(Path::new(""));
        let at = |line: usize| format!("{}:{line}", quote::path(&mesh.path));
        let mut missing = None;
        for (words, line) in &mesh.libraries {
            let listed = names(folder, words);
            let found: Vec<_> = listed.iter().map(|name| find(folder, name)).collect();
            // Words of which none is a file may have been one name.
            let none = found.iter().all(Option::is_none) && !listed.is_empty();
            let named = if none { vec![(bare_name(words), None)] } else { listed.into_iter().zip(found).collect() };
            for (name, found) in named {
                let refuse = |reason| Error::scene(&mesh.path, *line, format!("mtllib {}: {reason}", quoted(name)));
                let Some(found) = found else {
                    // A name that no system takes is refused for that.
                    if let Err(error) = folder.join(name).metadata()
                        && error.kind() != std::io::ErrorKind::NotFound
                    {
                        return Err(refuse(error.to_string()));
                    }
                    missing.get_or_insert((name.to_owned(), *line));
                    warnings.add("libraries that are not there", || {
                        format!("{}: mtllib {}: no such file", at(*line), quoted(name))
                    });
                    continue;
                };
                let file = self.read(&found.path, folders, seen, warnings, refuse)?;
                if let Some(note) = found.note {
                    notes.add("names of libraries", || format!("{}: {note}", at(*line)));
                }
                library.add(file);
            }
        }
        // Where a library was renamed with its OBJ file, that is its name.
        let own = mesh.path.with_extension("mtl");
        if let Some((name, line)) = missing
            && own.is_file()
        {
            let refuse = |reason| Error::scene(&mesh.path, line, format!("mtllib {}: {reason}", quoted(&name)));
            let file = self.read(&own, folders, seen, warnings, refuse)?;
            seen.insert(own.clone().into_os_string());
            if library.add(file) {
                notes.add("names of libraries", || {
                    let (name, own) = (quoted(&name), quote::path(&own));
                    format!("{}: mtllib {name}: {own}, named as the OBJ file is, is read in its place", at(line))
                });
            }
        }
        Ok(library)
    }

    /// Reads the file `path`, if it was not read before. Goes out: its number.
    fn read(
        &mut self,
        path: &Path,
        folders: &mut Folders,
        seen: &mut Named,
        warnings: &mut Warnings,
        refuse: impl FnOnce(String) -> Error,
    ) -> Result<usize> {
        let key = folders.key(path);
        if let Some(&file) = self.file_of_path.get(&key) {
            return Ok(file);
        }
        let bytes = source_text::read_bytes(path).map_err(refuse)?;
        seen.insert(path.as_os_str().to_owned());
        // An empty library defines nothing.
        let text = if bytes.is_empty() { String::new() } else { source_text::decode_statements(path, bytes)? };
        let file = self.add(path, &text, seen, warnings)?;
        self.file_of_path.insert(key, file);
        Ok(file)
    }

    /// Adds the materials in `text`, which `path` holds. Goes out: the number of the file.
    fn add(&mut self, path: &Path, text: &str, named: &mut Named, warnings: &mut Warnings) -> Result<usize> {
        check_memory(path, 0, "its materials", Census::of(text).mtl_bytes())?;
        let found = scan(path, text, warnings);
        let folder = path.parent().unwrap_or(Path::new(""));
        named.extend(found.images.iter().map(|image| folder.join(image).into_os_string()));
        let file = self.files.len();
        let mut names = Vec::with_capacity(found.materials.len());
        for (name, material) in found.materials {
            let name: Arc<str> = name.into();
            let bare = bare_name(&name);
            if bare.len() < name.len() && !bare.is_empty() {
                self.commented.entry(bare.into()).or_insert_with(|| name.clone());
            }
            let definition = Definition { file, material };
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
    /// several. A comment may stand behind the name, here or there.
    pub(super) fn find(&self, library: &Library, name: &str, warnings: &mut Warnings) -> Option<FoundMaterial<'_>> {
        if name.is_empty() {
            return None;
        }
        let bare = bare_name(name);
        let commented = self.commented.get(bare).map(AsRef::as_ref);
        let mut names = [Some(name), Some(bare), commented].into_iter().flatten();
        names.find_map(|name| self.find_exactly(library, name, warnings))
    }

    fn find_exactly(&self, library: &Library, name: &str, warnings: &mut Warnings) -> Option<FoundMaterial<'_>> {
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
            warn_again(&self.files[again.file].path, again.material.line, name, warnings);
        }
        found.last().map(|definition| FoundMaterial {
            file: definition.file,
            path: &self.files[definition.file].path,
            material: &definition.material,
        })
    }

    /// Names of all materials of `library`, in the order of its files.
    pub(super) fn names<'a>(&'a self, library: &'a Library) -> impl Iterator<Item = &'a str> {
        library.files.iter().flat_map(|&file| &self.files[file].names).map(AsRef::as_ref)
    }
}

impl Library {
    /// Adds a file; whether it is new.
    fn add(&mut self, file: usize) -> bool {
        let new = !self.place.contains_key(&file);
        if new {
            self.place.insert(file, self.files.len());
            self.files.push(file);
        }
        new
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
            order.iter().for_each(|&file| _ = library.add(files[file]));
            library
        };
        for (order, ni) in [(vec![0], 2.0), (vec![0, 1], 3.0), (vec![1, 0], 2.0), (vec![0, 1, 1, 0], 3.0)] {
            let found = libraries.find(&library(&order), "m", &mut Warnings::default());
            assert_eq!(found.map(|found| found.material.recipe.ni), Some(ni), "{order:?}");
        }
        let mut warnings = Warnings::default();
        assert!(libraries.find(&library(&[1, 0]), "m", &mut warnings).is_some());
        assert!(libraries.find(&library(&[0, 2]), "n", &mut warnings).is_none());
        assert_eq!(warnings.finish(), ["a.mtl:1: material \"m\" is defined again; this one counts"]);
        assert_eq!(libraries.names(&library(&[1, 0])).collect::<Vec<_>>(), ["m", "n", "m"]);
    }
}
