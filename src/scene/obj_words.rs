//! The words of an OBJ statement: read with a refusal for each, and written anew.
//!
//! Comes in: the words behind a keyword. Goes out: numbers and places of lists, or the message of the refusal.

use super::number::{is_not_finite, parse_number};
use crate::quote::quoted;

/// Most vertices, normals or corners: their indices are kept as `u32`, and a device has no room for more.
pub(super) const MAX_COUNT: usize = 1 << 31;

/// The part of the line after its keyword, without surrounding blanks.
pub(super) fn rest<'a>(line: &'a str, keyword: &str) -> &'a str {
    line.trim_start().strip_prefix(keyword).unwrap_or("").trim()
}

/// Up to `N` numbers, their count, and the refusal of the first that is none (`nan`, `1.#IND`, `1e400`), if there is
/// one; in its place stands NaN. The rest of the array is zero, and a word too many is refused.
pub(super) fn numbers_or_none<'a, const N: usize>(
    words: impl Iterator<Item = &'a str>,
) -> std::result::Result<([f64; N], usize, Option<String>), String> {
    let mut values = [0.0; N];
    let mut count = 0;
    let mut none = None;
    for word in words {
        let value = match parse_number(word) {
            Ok(value) => value,
            Err(message) if is_not_finite(word) => {
                none.get_or_insert(message);
                f64::NAN
            }
            Err(message) => return Err(message),
        };
        if count == N {
            return Err(format!("more than {N} numbers, the next is {}", quoted(word)));
        }
        values[count] = value;
        count += 1;
    }
    Ok((values, count, none))
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

/// One corner of a face: places in the lists, from 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    /// Of its position.
    pub position: usize,
    /// Of its texture coordinate, if it has one.
    pub uv: Option<usize>,
    /// Of its normal, if it has one.
    pub normal: Option<usize>,
}

/// Nouns of positions, texture coordinates and normals.
const NOUNS: [[&str; 2]; 3] =
    [["vertex", "vertices"], ["texture coordinate", "texture coordinates"], ["normal", "normals"]];

/// The corner that a word means. `counts` are the lengths of the lists, `above` how much of them stands above the line.
pub(super) fn corner(word: &str, counts: [usize; 3], above: [usize; 3]) -> std::result::Result<Corner, String> {
    let mut fields = word.split('/');
    let texts = [0, 1, 2].map(|_| fields.next().unwrap_or(""));
    if fields.next().is_some() {
        return Err(format!("corner {} has more than 3 indices; allowed is v, v/vt, v//vn or v/vt/vn", quoted(word)));
    }
    let place = |list: usize| index(texts[list], word, counts[list], above[list], NOUNS[list]);
    // Left out, or 0, as Cinema 4D and openMVS write it.
    let optional = |list: usize| match texts[list] {
        "" | "0" => Ok(None),
        _ => place(list).map(Some),
    };
    Ok(Corner { position: place(0)?, uv: optional(1)?, normal: optional(2)? })
}

/// Place, from 0, that an index of a face means; indices count from 1, or backwards from -1 above the line.
fn index(
    text: &str,
    corner: &str,
    count: usize,
    above: usize,
    [noun, nouns]: [&str; 2],
) -> std::result::Result<usize, String> {
    let in_range = match text.parse::<i64>() {
        Ok(value) if value > 0 => usize::try_from(value - 1).ok(),
        Ok(value) if value < 0 => usize::try_from(value.unsigned_abs()).ok().and_then(|back| above.checked_sub(back)),
        _ => None,
    };
    if let Some(place) = in_range.filter(|&place| place < count) {
        return Ok(place);
    }
    let what = format!("{noun} index {} in corner {}", quoted(text), quoted(corner));
    match above {
        _ if count == 0 => Err(format!("{what}: the file has no {nouns}")),
        0 => Err(format!("{what}; allowed are 1 to {count}, the {nouns} of the file")),
        _ if above == count => {
            Err(format!("{what}; allowed are 1 to {count} and -{count} to -1, the {nouns} above this line"))
        }
        _ => Err(format!(
            "{what}; allowed are 1 to {count}, the {nouns} of the file, and -{above} to -1, those above this line"
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
