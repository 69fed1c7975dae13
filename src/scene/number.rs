//! Numbers as OBJ, MTL and scene files hold them.
//!
//! Comes in: one word of a file. Goes out: a finite f64 of bounded magnitude, or the message that refuses the word.

use glam::DVec3;

use crate::quote::quoted;

/// Largest magnitude of a number in a file. Squares and products of three such numbers stay finite in f64.
pub(super) const MAX_MAGNITUDE: f64 = 1e100;

/// Parses one number; the error is the message of the refusal.
pub(super) fn parse_number(word: &str) -> std::result::Result<f64, String> {
    match word.parse::<f64>() {
        Ok(value) if value.abs() <= MAX_MAGNITUDE => Ok(value),
        _ => Err(format!("{} is not a number that can be used; allowed are finite numbers up to 1e100", quoted(word))),
    }
}

/// Whether a word stands for a number that is none or too large to be used, as programs write what they could not
/// compute: `nan`, `-nan(ind)`, `inf`, `1.#IND`, `1e400`.
pub(super) fn is_not_finite(word: &str) -> bool {
    if let Ok(value) = word.parse::<f64>() {
        return value.is_nan() || value.abs() > MAX_MAGNITUDE;
    }
    let word = word.trim_start_matches(['-', '+']).to_ascii_lowercase();
    let digits = word.trim_start_matches(|letter: char| letter.is_ascii_digit());
    word.starts_with("nan") || word.starts_with("inf") || (digits.len() < word.len() && digits.starts_with(".#"))
}

/// Whether every coordinate is a number of a file's range; NaN is not.
pub(super) fn in_range(point: DVec3) -> bool {
    point.abs().cmple(DVec3::splat(MAX_MAGNITUDE)).all()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_finite_numbers_pass() {
        assert_eq!(parse_number("-1.5e3"), Ok(-1500.0));
        assert!(in_range(DVec3::splat(-1e100)) && !in_range(DVec3::new(0.0, f64::NAN, 0.0)));
        for word in ["nan", "inf", "-infinity", "1e400", "1e101", "x", "", "1,5", "0x10", "#"] {
            assert!(parse_number(word).is_err(), "{word}");
        }
    }
}
