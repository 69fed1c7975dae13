//! What a picture file that is there says of itself.
//!
//! Comes in: a path. Goes out: the facts that texray once wrote into the file, by key. Only the beginning of the file
//! is read, and whatever is not a picture of texray has no facts.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::{Format, exr, hdr, png};

/// Bytes of a file that its facts stand in: headers of texray's pictures have some kilobytes.
const HEAD_BYTES: u64 = 1 << 18;

/// Facts by key, in the order of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stored(Vec<(String, String)>);

impl Stored {
    /// The facts of the picture at `path`, whose extension says its format. None where there is no regular file, or
    /// none of texray.
    pub fn read(path: &Path) -> Stored {
        let head = || -> Option<Vec<u8>> {
            if !path.metadata().ok()?.is_file() {
                return None;
            }
            let mut head = Vec::new();
            File::open(path).ok()?.take(HEAD_BYTES).read_to_end(&mut head).ok()?;
            Some(head)
        };
        let (Ok(format), Some(head)) = (Format::of(path), head()) else { return Stored::default() };
        Stored(match format {
            Format::Exr => exr::facts(&head),
            Format::Png => png::facts(&head),
            Format::Hdr => hdr::facts(&head),
        })
    }

    /// The value of `key`.
    pub fn get(&self, key: &str) -> Option<&String> {
        self.0.iter().find(|(known, _)| known == key).map(|(_, value)| value)
    }
}
