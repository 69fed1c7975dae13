//! What a render that was cut short may not replace: a better picture of the same subject.
//!
//! Comes in: where a picture is to go, what it is of, and its samples. Goes out: another name for it, where a file with more samples
//! of the same subject is there.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use super::{Metadata, Stored};

/// Longest name of a file in bytes on the file systems in use.
const LONGEST_NAME: usize = 255;

/// Where a picture of `spp` samples that was cut short goes instead of `path`; `None` where nothing better is there.
pub fn beside_better(path: &Path, metadata: &Metadata, spp: u32) -> Option<PathBuf> {
    let stored = Stored::read(path);
    let better = stored.get("spp").and_then(|spp| spp.parse::<u32>().ok()).is_some_and(|there| there > spp);
    (better && metadata.has_subject_of(&stored)).then(|| partial(path, spp))
}

/// `NAME.partial-Nspp.EXT` beside `NAME.EXT`; a name that would be too long loses the end of NAME.
fn partial(path: &Path, spp: u32) -> PathBuf {
    let mut end = OsString::from(format!(".partial-{spp}spp"));
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
        assert_eq!(partial(Path::new("a/b.c.exr"), 16), Path::new("a/b.c.partial-16spp.exr"));
        let long = PathBuf::from(format!("{}.png", "ä".repeat(125)));
        let name = partial(&long, 4_294_967_295);
        let name = name.to_str().unwrap();
        assert!(name.len() <= LONGEST_NAME && name.ends_with("ä.partial-4294967295spp.png"), "{name}");
    }
}
