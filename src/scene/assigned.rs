//! Which material a face has: that of the MTL files, the scene's own, or both together.
//!
//! Comes in: the name that a `[[mesh]]` or `usemtl` gives. Goes out: the material's number in the [`RawScene`], or the
//! refusal of a name that the scene file gives and nothing defines; one in an OBJ file is a warning.
//!
//! [`RawScene`]: super::assemble::RawScene

use std::collections::HashSet;
use std::path::Path;

use super::assemble::Assembly;
use super::library::{FoundMaterial, Library};
use super::looks::Looks;
use super::mtl_scan::MtlMaterial;
use super::nearest::known_names;
use super::placement::Materials;
use super::recipe::Recipe;
use super::refusals::Refusals;
use super::scene_file::{MaterialEntry, MeshEntry};
use super::statements::bare_name;
use crate::quote::quoted;
use crate::{Error, Result};

/// Names that are looked for among all that are defined; of others, among as many.
const SEARCHES: usize = 32;

impl Assembly<'_> {
    /// Materials of a mesh; those of a file's parts are to be put back.
    pub(super) fn materials_of(&mut self, entry: &MeshEntry, file: usize) -> Result<Materials> {
        Ok(match &entry.material {
            Some((name, line)) => Materials::Whole(self.whole_mesh_material(name, *line, file)?),
            None => Materials::Parts(self.take_part_materials(file)?),
        })
    }

    /// Materials of a file's parts, looked up once; taken from the file while they are used.
    fn take_part_materials(&mut self, file: usize) -> Result<Vec<u32>> {
        if let Some(materials) = self.sources[file].materials.take() {
            return Ok(materials);
        }
        let count = self.sources[file].mesh.parts.len();
        let mut materials = Vec::with_capacity(count);
        let mut refusals = Refusals::default();
        for part in 0..count {
            let of = &self.sources[file].mesh.parts[part];
            // The part of faces without a material always is there; others may be what the scene changes.
            let unused = of.faces == 0 && of.name.is_empty();
            let material = if unused { Some(0) } else { refusals.keep(self.part_material(file, part)) };
            materials.push(material.unwrap_or(0));
        }
        refusals.finish()?;
        Ok(materials)
    }

    /// The material that a `[[mesh]]` names for all its faces: the scene's own, or else the MTL file's.
    fn whole_mesh_material(&mut self, name: &str, line: usize, file: usize) -> Result<u32> {
        if let Some(&material) = self.material_of_name.get(name) {
            let entry = &self.materials[material];
            let mut recipe = Recipe::default();
            entry.apply(&mut recipe);
            self.touched.insert(&entry.name);
            look_at(&mut self.looks, &mut self.looked_at, self.path, None, Some(entry), &recipe)?;
            return Ok(self.material((None, name.to_owned()), recipe));
        }
        let key = (Some(file), name.to_owned());
        if let Some(&known) = self.index.get(&key) {
            return Ok(known);
        }
        let library = self.sources[file].library.as_ref();
        let found = library.and_then(|library| self.libraries.find(library, name, &mut self.raw.warnings));
        if let Some(found) = found {
            let recipe = found.material.recipe.clone();
            look_at(&mut self.looks, &mut self.looked_at, self.path, Some(found), None, &recipe)?;
            return Ok(self.material(key, recipe));
        }
        self.searched += 1;
        let looked_at = if self.searched <= SEARCHES { usize::MAX } else { SEARCHES };
        let library = self.sources[file].library.as_ref();
        let names = self.known_names(library).take(looked_at);
        let known = known_names(name, names, "the nearest that is defined is", "defined are");
        let allowed = known.unwrap_or_else(|| "none is defined by [material.NAME] or the mesh's MTL file".to_owned());
        Err(Error::scene(self.path, line, format!("material {}: no such material; {allowed}", quoted(name))))
    }

    /// Names of the scene's materials and of those in the MTL files.
    fn known_names<'b>(&'b self, library: Option<&'b Library>) -> impl Iterator<Item = &'b str> {
        let of_scene = self.materials.iter().map(|material| material.name.as_str());
        of_scene.chain(library.into_iter().flat_map(|library| self.libraries.names(library)))
    }

    /// The material of one part of an OBJ file, as MTL file and scene define it together. Where neither does, a warning
    /// and the format's own.
    fn part_material(&mut self, file: usize, part: usize) -> Result<u32> {
        let source = &self.sources[file];
        let part = &source.mesh.parts[part];
        let library = source.library.as_ref();
        let found = library.and_then(|library| self.libraries.find(library, &part.name, &mut self.raw.warnings));
        let of_scene = |name: &str| self.material_of_name.get(name).map(|&material| &self.materials[material]);
        let changed = of_scene(&part.name).or_else(|| of_scene(bare_name(&part.name)));
        if found.is_none() && changed.is_none() && !part.name.is_empty() && part.faces > 0 {
            let mut warnings = std::mem::take(&mut self.raw.warnings);
            let known = || self.known_names(source.library.as_ref());
            warnings.add("materials that are not there", || source.mesh.missing_material(part, known()));
            self.raw.warnings = warnings;
        }
        let mut recipe = found.as_ref().map(|found| found.material.recipe.clone()).unwrap_or_default();
        if let Some(entry) = changed {
            entry.apply(&mut recipe);
            self.touched.insert(&entry.name);
        }
        if part.faces > 0 {
            look_at(&mut self.looks, &mut self.looked_at, self.path, found, changed, &recipe)?;
        }
        let key = (Some(file), part.name.clone());
        Ok(self.material(key, recipe))
    }

    fn material(&mut self, key: (Option<usize>, String), recipe: Recipe) -> u32 {
        let materials = &mut self.raw.materials;
        let name = key.1.clone();
        *self.index.entry(key).or_insert_with(|| {
            materials.push((name, recipe));
            (materials.len() - 1) as u32
        })
    }
}

/// Looks at a material that faces use, unless it was looked at before.
fn look_at(
    looks: &mut Looks,
    looked_at: &mut HashSet<(Option<usize>, usize)>,
    scene: &Path,
    found: Option<FoundMaterial>,
    changed: Option<&MaterialEntry>,
    recipe: &Recipe,
) -> Result<()> {
    let nothing = MtlMaterial::default();
    let (file, path, stated) = match &found {
        Some(found) => (Some(found.file), found.path, found.material),
        None => (None, scene, &nothing),
    };
    let line = if found.is_some() { stated.line } else { changed.map_or(0, |entry| entry.line) };
    if !looked_at.insert((file, line)) {
        return Ok(());
    }
    looks.add(scene, path, stated, recipe, |quantity| changed.is_some_and(|entry| entry.changes(quantity)))
}
