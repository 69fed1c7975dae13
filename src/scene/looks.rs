//! What of a material's look cannot be shown, said once for all materials that faces use.
//!
//! Comes in: the materials of a scene, each as its file states it and with what the scene changes. Goes out: refusals
//! of values that the look hangs on, and a warning of each kind of look that is left out, with how many materials have
//! it. Values that change nothing (`Ks 0 0 0`, `d 1`, `Tf 1 1 1`) are not told of, nor those that an illumination model
//! does not show (`Ks` under `illum 1`).

use std::path::Path;

use super::material::MaterialKind;
use super::mtl_scan::{MtlMaterial, NAMES_SHOWN};
use super::recipe::{Quantity, Recipe};
use super::refusals::Refusals;
use super::warnings::Warnings;
use crate::quote::{self, quoted};
use crate::{Error, Result};

/// Kinds of what is left out: what, of what, and why.
const KINDS: [[&str; 2]; 9] = [
    ["Ks and Ns of", "ignored: there are no glossy surfaces yet"],
    ["d (or Tr) of", "ignored: see-through is only glass (illum 4, 6 or 7)"],
    ["Kd of", "ignored: a mirror (illum 3 or 5) reflects by its Ks alone"],
    ["Kd, Ks or Tf of", "ignored: glass (illum 4, 6 or 7) is clear and uncoloured"],
    ["Tf of", "ignored: what is opaque filters no light; glass has illum 4, 6 or 7 and Ni above 1"],
    ["illum 8, 9 or 10 of", "not supported: the surface is opaque and matte (glass has illum 4, 6 or 7)"],
    ["illum 3 to 7 of", "ignored: what emits (Ke) reflects diffusely"],
    ["spectral or xyz colours of", "not supported: their defaults are taken"],
    ["values of", "less than 1e-4 out of range: the nearest in range are taken"],
];

/// Looks left out so far.
#[derive(Default)]
pub(super) struct Looks {
    /// Materials of each kind, and where the first is.
    counts: [(usize, String); KINDS.len()],
    /// Statements that are not supported, by name, and where the first stands.
    ignored: Vec<String>,
    first_ignored: String,
}

impl Looks {
    /// Looks at a material that a face uses. `file` defines it, as `stated`; `recipe` is what the file `scene` makes of
    /// it, by a table that changes some quantities.
    pub(super) fn add(
        &mut self,
        scene: &Path,
        file: &Path,
        stated: &MtlMaterial,
        recipe: &Recipe,
        changes: impl Fn(Quantity) -> bool,
    ) -> Result<()> {
        let mut refusals = Refusals::default();
        for (quantity, line, message) in &stated.wrong {
            if recipe.uses(*quantity) && !changes(*quantity) {
                refusals.add(Error::scene(file, *line, message.clone()));
            }
        }
        refusals.finish()?;
        for (kind, cause) in left_out(stated, recipe, &changes) {
            let (count, first) = &mut self.counts[kind];
            if *count == 0 {
                let (file, line) = match cause {
                    Cause::Quantity(quantity) if changes(quantity) => (scene, recipe.line(quantity)),
                    Cause::Quantity(quantity) => (file, recipe.line(quantity)),
                    Cause::Line(line) => (file, line),
                };
                *first = format!("{}:{line}", quote::path(file));
            }
            *count += 1;
        }
        for (name, line) in &stated.ignored {
            if self.ignored.is_empty() {
                self.first_ignored = format!("{}:{line}", quote::path(file));
            }
            if self.ignored.len() < NAMES_SHOWN && !self.ignored.contains(name) {
                self.ignored.push(name.clone());
            }
        }
        Ok(())
    }

    /// Warns of them all.
    pub(super) fn warn(&self, warnings: &mut Warnings) {
        for ([what, why], (count, first)) in KINDS.iter().zip(&self.counts) {
            let (materials, are) = if *count == 1 { ("material", "is") } else { ("materials", "are") };
            let are =
                if what.contains(" and ") || what.contains("values") || what.contains("colours") { "are" } else { are };
            if *count > 0 {
                warnings.add("looks that are left out", || format!("{first}: {what} {count} {materials} {are} {why}"));
            }
        }
        if !self.ignored.is_empty() {
            let names = self.ignored.iter().map(|name| quoted(name)).collect::<Vec<_>>().join(", ");
            let text = "not supported yet and ignored, though they would change the look";
            warnings.add("looks that are left out", || format!("{}: {names}: {text}", self.first_ignored));
        }
    }
}

/// What a look that is left out stands in.
enum Cause {
    /// The statement or key of a quantity.
    Quantity(Quantity),
    /// A line of the MTL file.
    Line(usize),
}

/// Kinds of what is left out of a material's look, with the cause of each.
fn left_out(
    stated: &MtlMaterial,
    recipe: &Recipe,
    changes: &impl Fn(Quantity) -> bool,
) -> impl Iterator<Item = (usize, Cause)> {
    let is_stated = |quantity| recipe.line(quantity) > 0;
    let differs = |channels: [f64; 3], plain: f64| channels.iter().any(|&channel| channel != plain);
    let kind = recipe.kind();
    let (mirror, glass) = (matches!(kind, MaterialKind::Mirror { .. }), matches!(kind, MaterialKind::Glass { .. }));
    let matte = !mirror && !glass;
    let lamp = differs(recipe.ke, 0.0);
    let glossy = is_stated(Quantity::Ks) && differs(recipe.ks, 0.0);
    let coloured = is_stated(Quantity::Kd) && differs(recipe.kd, 0.0);
    let filters = is_stated(Quantity::Tf) && differs(recipe.tf, 1.0);
    // Of the two ways to say it, d is that of the format.
    let through = match is_stated(Quantity::D) {
        true if recipe.d < 1.0 => Some(Quantity::D),
        false if is_stated(Quantity::Tr) && recipe.tr > 0.0 => Some(Quantity::Tr),
        _ => None,
    };
    let newest = [Quantity::Kd, Quantity::Ks, Quantity::Tf].into_iter().zip([
        coloured,
        glossy && differs(recipe.ks, 1.0),
        filters,
    ]);
    let in_glass = newest.into_iter().find(|(_, is)| *is && glass).map(|(quantity, _)| quantity);
    let model = match recipe.illum {
        9 | 10 => true,
        8 => glossy,
        _ => false,
    };
    let rounded = stated.rounded.iter().find(|(quantity, _)| recipe.uses(*quantity) && !changes(*quantity));
    [
        (glossy && matte && recipe.illum > 1).then_some(Quantity::Ks).map(Cause::Quantity),
        through.filter(|_| !glass).map(Cause::Quantity),
        (mirror && coloured).then_some(Quantity::Kd).map(Cause::Quantity),
        in_glass.map(Cause::Quantity),
        (filters && matte && matches!(recipe.illum, 4 | 6 | 7 | 9)).then_some(Quantity::Tf).map(Cause::Quantity),
        (model && is_stated(Quantity::Illum)).then_some(Quantity::Illum).map(Cause::Quantity),
        (lamp && matches!(recipe.illum, 3..=7)).then_some(Quantity::Illum).map(Cause::Quantity),
        stated.forms.first().copied().map(Cause::Line),
        rounded.map(|(_, line)| *line).map(Cause::Line),
    ]
    .into_iter()
    .enumerate()
    .filter_map(|(kind, cause)| Some((kind, cause?)))
}
