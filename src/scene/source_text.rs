//! The text of a scene, OBJ or MTL file.
//!
//! Comes in: a path. Goes out: text without control bytes, or the reason why there is none. What reads the text may
//! assume that it is UTF-8, not empty, and that no line is longer than [`MAX_LINE_BYTES`].

use std::io::ErrorKind;
use std::path::Path;

use crate::{Error, Result};

/// Longest line that is read, in bytes: no program writes longer ones, and a message has to quote them.
pub(super) const MAX_LINE_BYTES: usize = 1 << 20;

/// Bytes of the file, or in a few words why it cannot be read: the caller knows who names the file.
pub(super) fn read_bytes(path: &Path) -> std::result::Result<Vec<u8>, String> {
    let reason = |error: std::io::Error| match error.kind() {
        ErrorKind::NotFound => "no such file".to_owned(),
        ErrorKind::PermissionDenied => "no permission to read it".to_owned(),
        _ => error.to_string(),
    };
    let metadata = std::fs::metadata(path).map_err(reason)?;
    if metadata.is_dir() {
        return Err("is a directory; allowed is a file".to_owned());
    }
    if !metadata.is_file() {
        return Err("is not a regular file".to_owned());
    }
    std::fs::read(path).map_err(reason)
}

/// Text of `bytes`, which `path` holds. Bytes that are not UTF-8 are read as Latin-1, as old exporters write names.
pub(super) fn decode(path: &Path, bytes: Vec<u8>) -> Result<String> {
    if bytes.is_empty() {
        return Err(Error::scene(path, 0, "the file is empty; allowed is UTF-8 text"));
    }
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(Error::scene(path, 0, "the file is UTF-16; allowed is UTF-8 text"));
    }
    check_bytes(path, &bytes)?;
    let text = match String::from_utf8(bytes) {
        Ok(text) => text,
        Err(error) => error.into_bytes().iter().map(|&byte| char::from(byte)).collect(),
    };
    match text.strip_prefix('\u{feff}') {
        Some(rest) => Ok(rest.to_owned()),
        None => Ok(text),
    }
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

/// The value as a message quotes it: in quotes, cut after 40 characters.
pub(super) fn quoted(value: &str) -> String {
    match value.char_indices().nth(40) {
        Some((end, _)) => format!("\"{}…\"", &value[..end]),
        None => format!("\"{value}\""),
    }
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
    fn long_values_are_cut_when_quoted() {
        assert_eq!(quoted("short"), "\"short\"");
        assert_eq!(quoted(&"ä".repeat(50)), format!("\"{}…\"", "ä".repeat(40)));
    }
}
