//! The words of an OBJ statement: read with a refusal for each, and written anew.
//!
//! Comes in: the words behind a keyword. Goes out: numbers and places of lists, or the message of the refusal.

use super::number::parse_number;
use crate::quote::quoted;

/// Most vertices, normals or corners: their indices are kept as `u32`, and a device has no room for more.
pub(super) const MAX_COUNT: usize = 1 << 31;

/// The part of the line after its keyword, without surrounding blanks.
pub(super) fn rest<'a>(line: &'a str, keyword: &str) -> &'a str {
    line.trim_start().strip_prefix(keyword).unwrap_or("").trim()
}

/// Up to `N` numbers and their count; the rest of the array is zero, and a word too many is refused by its count.
pub(super) fn numbers<'a, const N: usize>(
    words: impl Iterator<Item = &'a str>,
) -> std::result::Result<([f64; N], usize), String> {
    let mut values = [0.0; N];
    let mut count = 0;
    for word in words {
        let value = parse_number(word)?;
        if count == N {
            return Err(format!("more than {N} numbers, the next is {}", quoted(word)));
        }
        values[count] = value;
        count += 1;
    }
    Ok((values, count))
}

/// Appends a statement as the file has it: writing its numbers anew would take longer than reading them.
pub(super) fn push_words(canonical: &mut String, keyword: &str, words: &str) {
    for text in [keyword, " ", words, "\n"] {
        canonical.push_str(text);
    }
}

/// Appends a statement whose numbers read back as the same f64.
pub(super) fn push_numbers(canonical: &mut String, keyword: &str, values: &[f64]) {
    use std::fmt::Write;
    canonical.push_str(keyword);
    for value in values {
        // Writing to a String cannot fail.
        let _ = write!(canonical, " {value:e}");
    }
    canonical.push('\n');
}

/// Position, from 0, that an index of a face means; indices count from 1, or backwards from -1.
pub(super) fn index(
    text: &str,
    corner: &str,
    count: usize,
    noun: &str,
    nouns: &str,
) -> std::result::Result<usize, String> {
    let in_range = match text.parse::<i64>() {
        Ok(value) if value > 0 => usize::try_from(value - 1).ok(),
        Ok(value) if value < 0 => usize::try_from(value.unsigned_abs()).ok().and_then(|back| count.checked_sub(back)),
        _ => None,
    };
    match in_range {
        Some(position) if position < count => Ok(position),
        _ if count == 0 => {
            Err(format!("{noun} index {} in corner {}: no {nouns} stand above", quoted(text), quoted(corner)))
        }
        _ => Err(format!(
            "{noun} index {} in corner {}; allowed are 1 to {count} and -{count} to -1, the {nouns} above this line",
            quoted(text),
            quoted(corner)
        )),
    }
}

/// Refuses one more than can be numbered.
pub(super) fn room_for(count: usize, nouns: &str) -> std::result::Result<(), String> {
    if count >= MAX_COUNT {
        return Err(format!("more than {MAX_COUNT} {nouns}"));
    }
    Ok(())
}
