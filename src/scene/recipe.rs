//! A material as MTL statements or a `[material.NAME]` table state it, in the file's units.
//!
//! Comes in: the words of one statement, or the number or numbers of one key. Goes out: a [`Recipe`] whose values are
//! in range, and from it the kind of material that the rule of the scene contract makes of it.

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
    /// Colour that light takes on its way through.
    pub tf: [f64; 3],
    /// Transparency: another name for 1 - d.
    pub tr: f64,
    /// Line of the statement of each quantity; 0 where it is not stated.
    pub stated: [usize; QUANTITIES],
}

impl Default for Recipe {
    fn default() -> Recipe {
        Recipe {
            kd: [0.8; 3],
            ks: [1.0; 3],
            ke: [0.0; 3],
            illum: 2,
            ni: 1.0,
            d: 1.0,
            tf: [1.0; 3],
            tr: 0.0,
            stated: [0; QUANTITIES],
        }
    }
}

impl Recipe {
    /// How a surface of this recipe scatters. What emits reflects diffusely, whatever its illumination model.
    pub(super) fn kind(&self) -> MaterialKind {
        match self.illum {
            _ if self.emits() => MaterialKind::Lambert { albedo: self.kd.map(|channel| channel as f32) },
            3 | 5 => MaterialKind::Mirror { reflectance: self.ks.map(|channel| channel as f32) },
            4 | 6 | 7 if self.ni != 1.0 || self.d < 1.0 => MaterialKind::Glass { ior: self.ni as f32 },
            _ => MaterialKind::Lambert { albedo: self.kd.map(|channel| channel as f32) },
        }
    }

    fn emits(&self) -> bool {
        self.ke.iter().any(|&channel| channel > 0.0)
    }

    /// Whether the look of the material hangs on the quantity.
    pub(super) fn uses(&self, quantity: Quantity) -> bool {
        let decides = !self.emits() && matches!(self.illum, 4 | 6 | 7);
        match (quantity, self.kind()) {
            (Quantity::Ke | Quantity::Illum, _) => true,
            (Quantity::Ni | Quantity::D, _) => decides,
            (Quantity::Kd, kind) => matches!(kind, MaterialKind::Lambert { .. }),
            (Quantity::Ks, kind) => matches!(kind, MaterialKind::Mirror { .. }),
            (Quantity::Tf | Quantity::Tr, _) => false,
        }
    }

    /// Line of the statement that set the quantity; 0 where there is none.
    pub(super) fn line(&self, quantity: Quantity) -> usize {
        self.stated[quantity as usize]
    }

    /// Notes the line of the statement that sets the quantity.
    pub(super) fn state(&mut self, quantity: Quantity, line: usize) {
        self.stated[quantity as usize] = line;
    }
}

/// How many quantities there are.
const QUANTITIES: usize = 8;

/// How far a value may be out of range to be taken as the nearest that is in range: a rounding.
const SLACK: f64 = 1e-4;

/// One quantity of a recipe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    Kd,
    Ks,
    Ke,
    Illum,
    Ni,
    D,
    Tf,
    Tr,
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
            "Tf" => Quantity::Tf,
            "Tr" => Quantity::Tr,
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
            Quantity::Kd | Quantity::Ks | Quantity::Ke | Quantity::Tf => 3,
            Quantity::Illum | Quantity::Ni | Quantity::D | Quantity::Tr => 1,
        }
    }

    /// Sets the quantity from the words of a key; the error is the message of the refusal.
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
        self.put(recipe, values);
        Ok(())
    }

    /// Sets the quantity from the words of an MTL statement, one of which may stand for three. Goes out: whether a
    /// value was a rounding out of range. Where it is refused, it stays as it was.
    pub(super) fn set_stated(
        self,
        recipe: &mut Recipe,
        keyword: &str,
        words: &[&str],
    ) -> std::result::Result<bool, String> {
        // The dissolve of a rim is that of the whole, as far as it is looked at.
        let words = if words.first() == Some(&"-halo") && self == Quantity::D { &words[1..] } else { words };
        let needed = self.numbers();
        // What stands behind the numbers is left out, as by other programs.
        let words = &words[..words.len().min(needed)];
        if words.len() != needed && words.len() != 1 {
            let allowed = if needed == 3 { "1 or 3" } else { "1" };
            return Err(format!("{keyword} with {} numbers; allowed are {allowed}", words.len()));
        }
        let mut values = [0.0; 3];
        let mut rounded = false;
        for (i, value) in values.iter_mut().enumerate().take(needed) {
            let word = words.get(i).unwrap_or(&words[0]);
            *value = parse_number(word).map_err(|_| self.refusal(keyword, word))?;
            if !self.allows(*value) {
                *value = self.nearest(*value).ok_or_else(|| self.refusal(keyword, word))?;
                rounded = true;
            }
        }
        self.put(recipe, values);
        Ok(rounded)
    }

    fn put(self, recipe: &mut Recipe, values: [f64; 3]) {
        match self {
            Quantity::Kd => recipe.kd = values,
            Quantity::Ks => recipe.ks = values,
            Quantity::Ke => recipe.ke = values,
            // In range by `allows`: an integer from 0 to 10.
            Quantity::Illum => recipe.illum = values[0] as u32,
            Quantity::Ni => recipe.ni = values[0],
            Quantity::D => recipe.d = values[0],
            Quantity::Tf => recipe.tf = values,
            Quantity::Tr => recipe.tr = values[0],
        }
    }

    /// The allowed value that a value out of range is a rounding of, if it is one.
    fn nearest(self, value: f64) -> Option<f64> {
        let (low, high) = match self {
            Quantity::Ke => (0.0, f64::INFINITY),
            Quantity::Illum | Quantity::Ni => return None,
            _ => (0.0, 1.0),
        };
        (value >= low - SLACK && value <= high + SLACK).then(|| value.clamp(low, high))
    }

    fn refusal(self, keyword: &str, word: &str) -> String {
        format!("{keyword} has the value {}; {}", quoted(word), self.allowed())
    }

    fn allows(self, value: f64) -> bool {
        match self {
            Quantity::Kd | Quantity::Ks | Quantity::D | Quantity::Tf | Quantity::Tr => (0.0..=1.0).contains(&value),
            Quantity::Ke => (0.0..=1e36).contains(&value),
            Quantity::Illum => (0.0..=10.0).contains(&value) && value.fract() == 0.0,
            Quantity::Ni => (0.001..=1000.0).contains(&value),
        }
    }

    fn allowed(self) -> &'static str {
        match self {
            Quantity::Kd | Quantity::Ks | Quantity::D | Quantity::Tf | Quantity::Tr => {
                "allowed are numbers from 0 to 1"
            }
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

    #[test]
    fn statements_are_read_as_programs_write_them() {
        let mut recipe = Recipe::default();
        assert_eq!(Quantity::Kd.set_stated(&mut recipe, "Kd", &["0.5"]), Ok(false));
        assert_eq!(Quantity::Ks.set_stated(&mut recipe, "Ks", &["-1e-5", "1.0001", "1"]), Ok(true));
        assert_eq!(Quantity::Ke.set_stated(&mut recipe, "Ke", &["1", "2", "3", "4"]), Ok(false));
        assert_eq!(Quantity::D.set_stated(&mut recipe, "d", &["-halo", "0.25"]), Ok(false));
        assert_eq!((recipe.kd, recipe.ks, recipe.ke, recipe.d), ([0.5; 3], [0.0, 1.0, 1.0], [1.0, 2.0, 3.0], 0.25));
        for words in [&["1.00011"][..], &["-0.00011"], &["0.5", "0.5"], &[], &["nan"], &["x", "0", "0"]] {
            assert!(Quantity::Kd.set_stated(&mut recipe, "Kd", words).is_err(), "{words:?}");
        }
        assert!(Quantity::Ni.set_stated(&mut recipe, "Ni", &["0.00099"]).is_err());
        assert_eq!(recipe.kd, [0.5; 3]);
    }

    #[test]
    fn a_material_uses_what_its_kind_shows() {
        use Quantity::*;
        for (statements, used) in [
            (&[("illum", &["2"] as &[&str])][..], vec![Kd, Ke, Illum]),
            (&[("illum", &["3"])], vec![Ks, Ke, Illum]),
            (&[("illum", &["7"]), ("Ni", &["1.5"])], vec![Ke, Illum, Ni, D]),
            (&[("illum", &["4"])], vec![Kd, Ke, Illum, Ni, D]),
            (&[("illum", &["5"]), ("Ke", &["1", "1", "1"])], vec![Kd, Ke, Illum]),
        ] {
            let recipe = recipe(statements);
            let found: Vec<_> = [Kd, Ks, Ke, Illum, Ni, D, Tf, Tr].into_iter().filter(|&q| recipe.uses(q)).collect();
            assert_eq!(found, used, "{statements:?}");
        }
    }
}
