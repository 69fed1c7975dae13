//! What a render that was cut short may not replace: a better picture of the same subject.
//!
//! Comes in: where a picture is to go, what it is of, and its samples. Goes out: another name for it, where a file with
//! more samples of the same subject is there.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use super::{Metadata, Stored};

/// Longest name of a file in bytes on the file systems in use.
const LONGEST_NAME: usize = 255;
/// Names that are tried for a free one.
const MOST_TRIES: u32 = 999;

/// Where a picture of `spp` samples that was cut short goes instead of `path`; `None` where nothing better is there.
pub fn beside_better(path: &Path, metadata: &Metadata, spp: u32) -> Option<PathBuf> {
    let stored = Stored::read(path);
    let better = stored.get("spp").and_then(|spp| spp.parse::<u32>().ok()).is_some_and(|there| there > spp);
    if !better || !metadata.has_subject_of(&stored) {
        return None;
    }
    // What has the name already is replaced only if it is the same picture.
    let free = |place: &PathBuf| place.symlink_metadata().is_err() || metadata.has_subject_of(&Stored::read(place));
    (1..=MOST_TRIES)
        .map(|count| partial(path, spp, count))
        .find(free)
        .or_else(|| Some(partial(path, spp, MOST_TRIES + 1)))
}

/// `NAME.partial-Nspp.EXT` beside `NAME.EXT`, with `-COUNT` after it from the second on; a name that would be too long
/// loses the end of NAME.
fn partial(path: &Path, spp: u32, count: u32) -> PathBuf {
    let counted = if count > 1 { format!("-{count}") } else { String::new() };
    let mut end = OsString::from(format!(".partial-{spp}spp{counted}"));
    if let Some(extension) = path.extension() {
        end.push(".");
        end.push(extension);
    }
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    if name.len() + end.len() > LONGEST_NAME {
        let mut text = name.to_string_lossy().into_owned();
        while text.len() + end.len() > LONGEST_NAME && text.pop().is_some() {}
        name = text.into();
    }
    name.push(end);
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_partial_picture_stands_beside_the_whole_one() {
        assert_eq!(partial(Path::new("a/b.c.exr"), 16, 1), Path::new("a/b.c.partial-16spp.exr"));
        assert_eq!(partial(Path::new("b"), 16, 2), Path::new("b.partial-16spp-2"));
        let long = PathBuf::from(format!("{}.png", "ä".repeat(125)));
        let name = partial(&long, 4_294_967_295, 1);
        let name = name.to_str().unwrap();
        assert!(name.len() <= LONGEST_NAME && name.ends_with("ä.partial-4294967295spp.png"), "{name}");
    }
}
