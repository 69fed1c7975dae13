//! The known name that is nearest to a mistyped one.
//!
//! Comes in: a name and the known names. Goes out: the known name of the least edit distance, the first among equals.

/// Known names that are looked at: all of them in files that people write, and no long wait in others.
const LOOKED_AT: usize = 1 << 15;

/// The nearest of `known`, or `None` where there is none to choose from. Only the first 32768 are looked at.
pub(super) fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    known.into_iter().take(LOOKED_AT).min_by_key(|candidate| edit_distance(name, candidate))
}

/// Levenshtein distance over characters, blind to letter case. Only the first 64 characters count.
fn edit_distance(a: &str, b: &str) -> usize {
    let letters = |text: &str| text.chars().take(64).flat_map(char::to_lowercase).collect::<Vec<_>>();
    let (a, b) = (letters(a), letters(b));
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, &from) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &to) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(from != to);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_of_levenshtein() {
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("", "abc"), 3);
        assert_eq!(edit_distance("Kd", "kd"), 0);
    }

    #[test]
    fn the_nearest_name_is_found() {
        assert_eq!(nearest("orgin", ["up", "origin", "target"]), Some("origin"));
        assert_eq!(nearest("x", []), None);
    }
}
