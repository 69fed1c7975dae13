//! The known name that is nearest to a mistyped one.
//!
//! Comes in: a name and the known names. Goes out: the known name of the least edit distance, the first among equals;
//! none where the least distance is so large that another name must have been meant.

use crate::quote::quoted;

/// Known names that are looked at: all of them in files that people write, and no long wait in others.
const LOOKED_AT: usize = 1 << 15;
/// Names that a message lists where none is near,
const LISTED: usize = 12;
/// and about how many characters of them.
const LISTED_CHARACTERS: usize = 160;

/// The nearest of `known`, or `None` where none is near: up to a third of the longer name may differ, and one letter of
/// any name. Only the first 32768 are looked at.
pub(super) fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let known = known.into_iter().take(LOOKED_AT);
    let (candidate, distance) =
        known.map(|known| (known, edit_distance(name, known))).min_by_key(|(_, distance)| *distance)?;
    let longer = name.chars().count().max(candidate.chars().count());
    // Letters that all differ are no slip, however short the names are.
    (distance <= (longer / 3).max(1) && distance < longer).then_some(candidate)
}

/// What a message says of the known names: the nearest, or where none is near, all (of many, the first few); `None`
/// where there are none.
pub(super) fn known_names<'a>(
    name: &str,
    known: impl IntoIterator<Item = &'a str>,
    nearest_is: &str,
    all_are: &str,
) -> Option<String> {
    let mut names: Vec<&str> = Vec::new();
    let mut seen = std::collections::HashSet::new();
    names.extend(known.into_iter().filter(|known| seen.insert(*known)));
    if let Some(near) = nearest(name, names.iter().copied()) {
        return Some(format!("{nearest_is} {}", quoted(near)));
    }
    let mut listed: Vec<String> = Vec::new();
    let mut characters = 0;
    for name in names.iter().take(LISTED) {
        if characters >= LISTED_CHARACTERS {
            break;
        }
        let name = quoted(name);
        characters += name.chars().count();
        listed.push(name);
    }
    let rest = names.len().saturating_sub(listed.len());
    let more = if rest > 0 { format!(" and {rest} more") } else { String::new() };
    (!names.is_empty()).then(|| format!("{all_are} {}{more}", listed.join(", ")))
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
        assert_eq!(nearest("colour", ["strength", "color"]), Some("color"));
        assert_eq!((nearest("kD", ["ks", "kd"]), nearest("kf", ["ks", "kd"])), (Some("kd"), Some("ks")));
    }

    /// Another word for the thing, or a word for another thing, is no slip of a known name.
    #[test]
    fn a_name_that_is_not_near_is_not_suggested() {
        for (name, known) in [
            ("sphere", &["camera", "film", "render", "mesh", "material", "environment"][..]),
            ("metallic", &["kd", "ks", "ke", "illum", "ni", "d"]),
            ("look_at", &["origin", "target", "up", "vfov"]),
            ("roughness", &["kd", "ks", "ke", "illum", "ni", "d"]),
            ("fov", &["up"]),
            ("a", &["b"]),
        ] {
            assert_eq!(nearest(name, known.iter().copied()), None, "{name}");
            let text = known_names(name, known.iter().copied(), "near", "known are").unwrap();
            assert!(known.iter().all(|known| text.contains(&quoted(known))), "{text}");
        }
        let many: Vec<String> = (0..20).map(|i| format!("name{i}")).collect();
        let text = known_names("other", many.iter().map(String::as_str), "near", "known are").unwrap();
        assert!(text.ends_with("\"name11\" and 8 more"), "{text}");
        assert_eq!(known_names("x", ["x1", "x1", "x2"], "near is", ""), Some("near is \"x1\"".into()));
    }
}
