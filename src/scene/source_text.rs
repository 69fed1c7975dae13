//! The text of a scene, OBJ or MTL file.
//!
//! Comes in: a path. Goes out: text without control bytes, or the reason why there is none. What reads the text may
//! assume that it is UTF-8, not empty, and that no line is longer than [`MAX_LINE_BYTES`].

use std::collections::{BTreeSet, HashMap};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use super::statements::{end_lines, join_lines};
use crate::input_file::InputFile;
use crate::{Error, Result, memory};

/// Longest line that is read, in bytes: no program writes longer ones, and a message has to quote them.
pub(super) const MAX_LINE_BYTES: usize = 1 << 20;

/// Copies of a text that are held at a time: as it is read and as it is written anew, or decoded.
const COPIES: u64 = 2;

/// Bytes of the file, or in a few words why it cannot be read: the caller knows who names the file.
pub(super) fn read_bytes(path: &Path) -> std::result::Result<Vec<u8>, String> {
    let file = InputFile::open(path)?;
    memory::check("its text", file.bytes.saturating_mul(COPIES)).map_err(|error| error.to_string())?;
    file.read()
}

/// Refuses the file `path` where what its text asks for, by its statements, is more than there is.
pub(super) fn check_memory(path: &Path, line: usize, what: &str, need: u64) -> Result<()> {
    memory::check(what, need).map_err(|error| Error::scene(path, line, error.to_string()))
}

/// Paths that a scene names, in order and none twice; compared as text, which is faster than part by part.
pub(super) type Named = BTreeSet<OsString>;

/// Files told apart by the folder that they lie in, whatever names lead to it.
#[derive(Default)]
pub(super) struct Folders {
    canonical: HashMap<PathBuf, PathBuf>,
}

impl Folders {
    /// The file's name in its folder's only name. A link is a file of its own: what lies beside it counts.
    pub(super) fn key(&mut self, path: &Path) -> PathBuf {
        let (Some(folder), Some(name)) = (path.parent(), path.file_name()) else { return path.to_owned() };
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        if let Some(canonical) = self.canonical.get(folder) {
            return canonical.join(name);
        }
        let canonical = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
        self.canonical.insert(folder.to_owned(), canonical.clone());
        canonical.join(name)
    }
}

/// Text of an OBJ or MTL file, of a line each statement: see [`super::statements`].
pub(super) fn decode_statements(path: &Path, mut bytes: Vec<u8>) -> Result<String> {
    if !is_utf16(&bytes) {
        end_lines(&mut bytes);
        bytes = join_lines(bytes);
    }
    decode(path, bytes)
}

fn is_utf16(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff])
}

/// Cuts off the Ctrl-Z or NUL bytes with which some programs end or fill a file.
fn cut_filling(bytes: &mut Vec<u8>) {
    let fills = |byte: &u8| matches!(byte, 0 | 0x1a);
    let text = bytes.iter().rposition(|byte| !fills(byte) && !byte.is_ascii_whitespace()).map_or(0, |last| last + 1);
    if text > 0 && bytes[text..].iter().any(fills) {
        bytes.truncate(text);
    }
}

/// Text of `bytes`, which `path` holds. Bytes that are not UTF-8 are read as Latin-1, as old exporters write names.
pub(super) fn decode(path: &Path, mut bytes: Vec<u8>) -> Result<String> {
    if bytes.is_empty() {
        return Err(Error::scene(path, 0, "the file is empty; allowed is UTF-8 text"));
    }
    if is_utf16(&bytes) {
        return Err(Error::scene(path, 0, "the file is UTF-16; allowed is UTF-8 text"));
    }
    cut_filling(&mut bytes);
    end_lines(&mut bytes);
    check_bytes(path, &bytes)?;
    let mut text = match String::from_utf8(bytes) {
        Ok(text) => text,
        Err(error) => {
            let bytes = error.into_bytes();
            // No letter of Latin-1 takes more than two bytes of UTF-8.
            check_memory(path, 0, "its text, read as Latin-1", 2 * bytes.len() as u64)?;
            let mut text = String::with_capacity(2 * bytes.len());
            text.extend(bytes.iter().map(|&byte| char::from(byte)));
            text
        }
    };
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    Ok(text)
}

/// Refuses control bytes and over-long lines.
fn check_bytes(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut offset = 0;
    for (index, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        if line.len() > MAX_LINE_BYTES {
            let message = format!("a line of {} bytes; allowed are {MAX_LINE_BYTES}", line.len());
            return Err(Error::scene(path, index + 1, message));
        }
        let is_control = |byte: &u8| *byte < 0x20 && !matches!(byte, b'\t' | b'\r' | 0x0b | 0x0c);
        if let Some(column) = line.iter().position(is_control) {
            let message = format!(
                "byte 0x{:02x} at offset {}: the file is binary; allowed is UTF-8 text",
                line[column],
                offset + column
            );
            return Err(Error::scene(path, index + 1, message));
        }
        offset += line.len() + 1;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_byte_order_mark_is_dropped_and_latin1_is_read() {
        let path = Path::new("a.obj");
        assert_eq!(decode(path, b"\xef\xbb\xbfv 1 2 3".to_vec()).unwrap(), "v 1 2 3");
        assert_eq!(decode(path, b"usemtl gr\xfcn".to_vec()).unwrap(), "usemtl grün");
    }

    #[test]
    fn what_fills_the_end_of_a_file_is_cut_off() {
        let path = Path::new("a.obj");
        for end in ["\0\0\0", "\x1a", "\n\x1a\n", "\r\n\0\0\r\n\x1a\x1a"] {
            assert_eq!(decode(path, format!("v 1 2 3{end}").into_bytes()).unwrap(), "v 1 2 3", "{end:?}");
        }
        assert_eq!(decode(path, b"v 1 2 3\n\n".to_vec()).unwrap(), "v 1 2 3\n\n");
        for binary in [&b"\0\0"[..], b"\x1av", b"v\0v"] {
            assert!(decode(path, binary.to_vec()).unwrap_err().to_string().contains("the file is binary"));
        }
    }

    #[test]
    fn names_of_one_folder_lead_to_one_file() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("a")).unwrap();
        let mut folders = Folders::default();
        let keys =
            ["a/m.obj", "a/./m.obj", "a/../a/m.obj", "a//m.obj"].map(|name| folders.key(&folder.path().join(name)));
        assert!(keys.iter().all(|key| *key == keys[0]), "{keys:?}");
        assert_ne!(folders.key(&folder.path().join("m.obj")), keys[0]);
    }
}
