//! The text of a scene file, before and while it is read as TOML.
//!
//! Comes in: a path and its text. Goes out: the parsed text, lines of places in it, and what memory it asks for.

use std::path::Path;

use toml::Spanned;
use toml::de::DeTable;

use crate::{Error, Result, quote};

/// Bytes of text between two entries of the table of line numbers.
const STRIDE: usize = 1 << 12;
/// Bytes of memory for a byte of text: of two bytes, as in `0,`, an event of the parser and a value are made.
const BYTE_BYTES: u64 = 96;
/// Bytes of memory for a table: a node of a tree with room for eleven entries.
const TABLE_BYTES: u64 = 1200;
/// Longest message of the TOML parser that is passed on, in characters.
const MESSAGE: usize = 120;

/// The file that tables stand in.
pub(super) struct Source<'a> {
    /// The file.
    pub path: &'a Path,
    /// Its text.
    pub text: &'a str,
    /// Line feeds before every [`STRIDE`]th byte: to count them from the start for every key would take the square of
    /// the file's length.
    line_feeds: Vec<usize>,
}

impl<'a> Source<'a> {
    /// The file `path` with this text.
    pub(super) fn new(path: &'a Path, text: &'a str) -> Source<'a> {
        let mut line_feeds = Vec::with_capacity(text.len() / STRIDE + 1);
        let mut count = 0;
        for chunk in text.as_bytes().chunks(STRIDE) {
            line_feeds.push(count);
            count += newlines(chunk);
        }
        Source { path, text, line_feeds }
    }

    /// Line, from 1, of the byte at `offset`.
    pub(super) fn line(&self, offset: usize) -> usize {
        let offset = offset.min(self.text.len());
        let before = self.line_feeds.get(offset / STRIDE).copied().unwrap_or(0);
        1 + before + newlines(&self.text.as_bytes()[offset / STRIDE * STRIDE..offset])
    }

    /// Bytes of memory that the parsed text takes at the most: so many for each byte, as an array of `0,` takes them,
    /// and for each table, of which a brace, a header and a dot in a key make one each.
    pub(super) fn memory_bytes(&self) -> u64 {
        let bytes = self.text.as_bytes();
        let is_end = |byte: &u8| matches!(byte, b',' | b']' | b'}' | b'\n' | b'\r' | b'#');
        // The dot of a number has digits on both sides, and behind them the value ends.
        let of_number = |at: usize| {
            let behind = &bytes[at + 1..];
            let digits =
                behind.iter().take_while(|byte| matches!(byte, b'0'..=b'9' | b'e' | b'E' | b'+' | b'-' | b'_'));
            let blank = |byte: &&u8| matches!(byte, b' ' | b'\t');
            let digits = digits.count();
            digits > 0 && behind[digits..].iter().find(|byte| !blank(byte)).is_none_or(is_end)
        };
        let opens = |at: usize| match bytes[at] {
            b'{' => true,
            b'[' => at == 0 || bytes[at - 1] == b'\n',
            b'.' => !of_number(at),
            _ => false,
        };
        let tables = (0..bytes.len()).filter(|&at| opens(at)).count() as u64;
        tables.saturating_mul(TABLE_BYTES).saturating_add(bytes.len() as u64 * BYTE_BYTES)
    }

    /// The text as TOML.
    pub(super) fn parse(&self) -> Result<Spanned<DeTable<'a>>> {
        DeTable::parse(self.text).map_err(|error| {
            let line = error.span().map_or(0, |span| self.line(span.start));
            let message = quote::cut(&error.message().replace('\n', "; "), MESSAGE);
            Error::scene(self.path, line, format!("not valid TOML: {message}"))
        })
    }
}

fn newlines(bytes: &[u8]) -> usize {
    bytes.iter().filter(|&&byte| byte == b'\n').count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tables(text: &str) -> u64 {
        (Source::new(Path::new("a.toml"), text).memory_bytes() - text.len() as u64 * BYTE_BYTES) / TABLE_BYTES
    }

    #[test]
    fn lines_are_counted_from_the_nearest_stride() {
        let text = "a\n".repeat(10_000);
        let source = Source::new(Path::new("a.toml"), &text);
        for offset in [0, 1, 2, STRIDE - 1, STRIDE, STRIDE + 1, 19_998, 20_000, 30_000] {
            assert_eq!(source.line(offset), 1 + newlines(&text.as_bytes()[..offset.min(text.len())]), "{offset}");
        }
    }

    #[test]
    fn tables_are_counted_and_numbers_are_not() {
        assert_eq!(tables("[camera]\norigin = [0.5, 1.25e-3, 3.0]\n[[mesh]]\nscale = 0.5 # half\n"), 2);
        assert_eq!(tables("a.b.c = 1\n1.1 = 0.5\nr = { axis = [0, 1, 0], degrees = 3.5 }\n"), 4);
    }
}
