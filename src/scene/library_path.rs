//! Where the file is that an `mtllib` statement names: files come from other systems, in other folders.
//!
//! Comes in: the folder of the OBJ file and a name. Goes out: the path under which a file is there, and a note where
//! that is not the name as it stands. Tried are, in this order: the name, the name without quotes, with `\` between its
//! folders, its last part beside the OBJ file, and that in other letter case.

use std::path::{Path, PathBuf};

use crate::quote::{self, quoted};

/// Entries of a folder that are looked at for a name in other letter case.
const MOST_ENTRIES: usize = 1 << 14;

/// A file that is there.
pub(super) struct FoundPath {
    /// Its path.
    pub path: PathBuf,
    /// What a user should know of it.
    pub note: Option<String>,
}

/// The names that a statement holds: one, where a file of that very name is there, else its words; quotes keep words
/// together. The comment behind them is no part of either.
pub(super) fn names<'a>(folder: &Path, words: &'a str) -> Vec<&'a str> {
    let bare = super::statements::bare_name(words);
    for whole in [words, bare] {
        if find(folder, whole).is_some_and(|found| found.note.is_none()) {
            return vec![whole];
        }
    }
    let mut names = Vec::new();
    let mut rest = bare.trim_ascii();
    while !rest.is_empty() {
        let quote = rest.chars().next().filter(|first| matches!(first, '"' | '\''));
        let quoted = quote.and_then(|quote| Some(rest[1..].find(quote)? + 2));
        let end = quoted.unwrap_or_else(|| rest.find(|blank: char| blank.is_ascii_whitespace()).unwrap_or(rest.len()));
        names.push(&rest[..end]);
        rest = rest[end..].trim_ascii_start();
    }
    names
}

/// The file of this name, or of one that it may have been written for.
pub(super) fn find(folder: &Path, name: &str) -> Option<FoundPath> {
    let is_there = |name: &str| (!name.is_empty() && folder.join(name).exists()).then(|| folder.join(name));
    let plain = |path| FoundPath { path, note: None };
    if let Some(path) = is_there(name) {
        return Some(plain(path));
    }
    let unquoted = ['"', '\''].into_iter().find_map(|quote| name.strip_prefix(quote)?.strip_suffix(quote));
    let unquoted = unquoted.unwrap_or(name).trim_ascii();
    let slashed = unquoted.replace('\\', "/");
    if let Some(path) = is_there(unquoted).or_else(|| is_there(&slashed)) {
        return Some(plain(path));
    }
    let last = slashed.rsplit('/').next().unwrap_or_default();
    let beside = if last.is_empty() { None } else { is_there(last) };
    let path = beside.or_else(|| in_other_case(folder, &slashed)).or_else(|| in_other_case(folder, last))?;
    let note = Some(format!("mtllib {}: {} is read in its place", quoted(name), quote::path(&path)));
    Some(FoundPath { path, note })
}

/// The one file whose name differs by letter case alone.
fn in_other_case(folder: &Path, name: &str) -> Option<PathBuf> {
    let path = folder.join(name);
    let wanted = path.file_name()?.to_str()?.to_lowercase();
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let is_it =
        |entry: &std::fs::DirEntry| entry.file_name().to_str().is_some_and(|name| name.to_lowercase() == wanted);
    let mut found = std::fs::read_dir(folder).ok()?.take(MOST_ENTRIES).filter_map(Result::ok).filter(is_it);
    let (first, second) = (found.next()?, found.next());
    // Of several, none is meant more than another.
    second.is_none().then(|| path.with_file_name(first.file_name()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_found_under_the_names_of_other_systems() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("sub")).unwrap();
        for name in ["a b.mtl", "sub/m.mtl", "Case.MTL", "x.mtl"] {
            std::fs::write(at(name), "").unwrap();
        }
        let found = |name: &str| find(folder.path(), name).map(|found| (found.path, found.note.is_some()));
        for (name, path, noted) in [
            ("a b.mtl", "a b.mtl", false),
            ("\"a b.mtl\"", "a b.mtl", false),
            (".\\sub\\m.mtl", "./sub/m.mtl", false),
            ("sub\\m.mtl", "sub/m.mtl", false),
            ("C:\\models\\x.mtl", "x.mtl", true),
            ("/home/of/others/x.mtl", "x.mtl", true),
            ("case.mtl", "Case.MTL", true),
            ("SUB/M.mtl", "", false),
            ("sub/M.mtl", "sub/m.mtl", true),
        ] {
            let expected = (!path.is_empty()).then(|| (at(path), noted));
            assert_eq!(found(name), expected, "{name}");
        }
        assert!(["", "\"\"", "\\", "no.mtl", "."].iter().all(|name| found(name).is_none_or(|(path, _)| path.is_dir())));
        let split = |words| names(folder.path(), words);
        assert_eq!(split("a b.mtl"), ["a b.mtl"]);
        assert_eq!(split("a b.mtl # c"), ["a b.mtl"]);
        assert_eq!(split("x.mtl \"a b.mtl\" no.mtl # c"), ["x.mtl", "\"a b.mtl\"", "no.mtl"]);
        assert_eq!(split("# c"), [] as [&str; 0]);
    }
}
