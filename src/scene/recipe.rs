//! A material as MTL statements or a `[material.NAME]` table state it, in the file's units.
//!
//! Comes in: the words of one statement, or the number or numbers of one key. Goes out: a [`Recipe`] whose values are in
//! range, and from it the kind of material that the rule of the scene contract makes of it.

use super::material::MaterialKind;
use super::number::parse_number;
use crate::quote::quoted;

/// The quantities of a material; each has its MTL default until it is stated.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Recipe {
    /// Diffuse reflectance.
    pub kd: [f64; 3],
    /// Specular reflectance.
    pub ks: [f64; 3],
    /// Emitted radiance.
    pub ke: [f64; 3],
    /// Illumination model.
    pub illum: u32,
    /// Index of refraction.
    pub ni: f64,
    /// Dissolve: 1 is opaque.
    pub d: f64,
}

impl Default for Recipe {
    fn default() -> Recipe {
        Recipe { kd: [0.8; 3], ks: [1.0; 3], ke: [0.0; 3], illum: 2, ni: 1.0, d: 1.0 }
    }
}

impl Recipe {
    /// How a surface of this recipe scatters. What emits reflects diffusely, whatever its illumination model.
    pub(super) fn kind(&self) -> MaterialKind {
        let emits = self.ke.iter().any(|&channel| channel > 0.0);
        match self.illum {
            _ if emits => MaterialKind::Lambert { albedo: self.kd.map(|channel| channel as f32) },
            3 | 5 => MaterialKind::Mirror { reflectance: self.ks.map(|channel| channel as f32) },
            4 | 6 | 7 if self.ni != 1.0 || self.d < 1.0 => MaterialKind::Glass { ior: self.ni as f32 },
            _ => MaterialKind::Lambert { albedo: self.kd.map(|channel| channel as f32) },
        }
    }
}

/// One quantity of a recipe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    Kd,
    Ks,
    Ke,
    Illum,
    Ni,
    D,
}

impl Quantity {
    /// The quantity that an MTL statement sets.
    pub(super) fn of_statement(keyword: &str) -> Option<Quantity> {
        Some(match keyword {
            "Kd" => Quantity::Kd,
            "Ks" => Quantity::Ks,
            "Ke" => Quantity::Ke,
            "illum" => Quantity::Illum,
            "Ni" => Quantity::Ni,
            "d" => Quantity::D,
            _ => return None,
        })
    }

    /// The quantity that a key of a `[material.NAME]` table sets: the MTL names in lower case.
    pub(super) fn of_key(key: &str) -> Option<Quantity> {
        Some(match key {
            "kd" => Quantity::Kd,
            "ks" => Quantity::Ks,
            "ke" => Quantity::Ke,
            "illum" => Quantity::Illum,
            "ni" => Quantity::Ni,
            "d" => Quantity::D,
            _ => return None,
        })
    }

    /// How many numbers it takes.
    pub(super) fn numbers(self) -> usize {
        match self {
            Quantity::Kd | Quantity::Ks | Quantity::Ke => 3,
            Quantity::Illum | Quantity::Ni | Quantity::D => 1,
        }
    }

    /// Sets the quantity from the words of a statement; the error is the message of the refusal.
    pub(super) fn set(self, recipe: &mut Recipe, keyword: &str, words: &[&str]) -> std::result::Result<(), String> {
        let needed = self.numbers();
        if words.len() != needed {
            return Err(format!("{keyword} with {} numbers; allowed are {needed}", words.len()));
        }
        let mut values = [0.0; 3];
        for (value, word) in values.iter_mut().zip(words) {
            *value = parse_number(word).map_err(|_| self.refusal(keyword, word))?;
            if !self.allows(*value) {
                return Err(self.refusal(keyword, word));
            }
        }
        match self {
            Quantity::Kd => recipe.kd = values,
            Quantity::Ks => recipe.ks = values,
            Quantity::Ke => recipe.ke = values,
            // In range by `allows`: an integer from 0 to 10.
            Quantity::Illum => recipe.illum = values[0] as u32,
            Quantity::Ni => recipe.ni = values[0],
            Quantity::D => recipe.d = values[0],
        }
        Ok(())
    }

    fn refusal(self, keyword: &str, word: &str) -> String {
        format!("{keyword} has the value {}; {}", quoted(word), self.allowed())
    }

    fn allows(self, value: f64) -> bool {
        match self {
            Quantity::Kd | Quantity::Ks | Quantity::D => (0.0..=1.0).contains(&value),
            Quantity::Ke => (0.0..=1e36).contains(&value),
            Quantity::Illum => (0.0..=10.0).contains(&value) && value.fract() == 0.0,
            Quantity::Ni => (0.001..=1000.0).contains(&value),
        }
    }

    fn allowed(self) -> &'static str {
        match self {
            Quantity::Kd | Quantity::Ks | Quantity::D => "allowed are numbers from 0 to 1",
            Quantity::Ke => "allowed are numbers from 0 to 1e36",
            Quantity::Illum => "allowed are the integers from 0 to 10",
            Quantity::Ni => "allowed are numbers from 0.001 to 1000",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recipe(statements: &[(&str, &[&str])]) -> Recipe {
        let mut recipe = Recipe::default();
        for (keyword, words) in statements {
            Quantity::of_statement(keyword).unwrap().set(&mut recipe, keyword, words).unwrap();
        }
        recipe
    }

    #[test]
    fn the_rule_of_the_contract_decides_the_kind() {
        let lambert = MaterialKind::Lambert { albedo: [0.8; 3] };
        assert_eq!(recipe(&[]).kind(), lambert);
        for illum in ["0", "1", "2", "8", "9", "10"] {
            assert_eq!(recipe(&[("illum", &[illum]), ("Ni", &["1.5"]), ("d", &["0"])]).kind(), lambert);
        }
        for illum in ["3", "5"] {
            assert_eq!(recipe(&[("illum", &[illum])]).kind(), MaterialKind::Mirror { reflectance: [1.0; 3] });
        }
        for illum in ["4", "6", "7"] {
            assert_eq!(recipe(&[("illum", &[illum])]).kind(), lambert);
            assert_eq!(recipe(&[("illum", &[illum]), ("Ni", &["1.5"])]).kind(), MaterialKind::Glass { ior: 1.5 });
            assert_eq!(recipe(&[("illum", &[illum]), ("d", &["0.9"])]).kind(), MaterialKind::Glass { ior: 1.0 });
            let shining = recipe(&[("illum", &[illum]), ("Ni", &["1.5"]), ("Ke", &["0", "0", "1e-30"])]);
            assert_eq!(shining.kind(), lambert);
        }
    }
}
