//! Text of others as messages may show it: no character of it steers a terminal, and none of it is long.
//!
//! Comes in: names, values and paths as a file or the command line has them. Goes out: the same with every character
//! that a terminal obeys or does not show as an escape such as `\u{1b}`. A foundation below all stages, as
//! [`crate::error`] is.

use std::borrow::Cow;
use std::path::Path;

/// Most characters of a value that are shown, escapes counted as they are written.
pub const MOST_SHOWN: usize = 40;

/// Whether a terminal obeys the character or shows nothing for it: controls (C0, DEL, C1), marks that turn the
/// direction of writing, separators of lines, characters without width, and tags.
pub fn is_hidden(character: char) -> bool {
    character.is_control()
        || matches!(character,
            '\u{ad}' | '\u{61c}' | '\u{180e}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}'
            | '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}')
}

/// The text with its hidden characters as escapes.
pub fn escaped(text: &str) -> Cow<'_, str> {
    escaped_but(text, |_| false)
}

/// A text of several lines, hidden characters other than its line feeds and tabs as escapes.
pub fn escaped_lines(text: &str) -> Cow<'_, str> {
    escaped_but(text, |character| matches!(character, '\n' | '\t'))
}

/// A JSON document of several lines, hidden characters in its strings as escapes of JSON.
pub fn escaped_json(text: &str) -> Cow<'_, str> {
    let hidden = |character: char| is_hidden(character) && character != '\n';
    if !text.contains(hidden) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for character in text.chars() {
        if !hidden(character) {
            shown.push(character);
            continue;
        }
        for unit in character.encode_utf16(&mut [0; 2]) {
            shown.push_str(&format!("\\u{unit:04x}"));
        }
    }
    Cow::Owned(shown)
}

fn escaped_but(text: &str, kept: impl Fn(char) -> bool) -> Cow<'_, str> {
    let hidden = |character: char| is_hidden(character) && !kept(character);
    if !text.contains(hidden) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for character in text.chars() {
        match hidden(character) {
            true => shown.extend(character.escape_unicode()),
            false => shown.push(character),
        }
    }
    Cow::Owned(shown)
}

/// The text, its hidden characters as escapes, cut after [`MOST_SHOWN`] characters.
pub fn shown(text: &str) -> String {
    cut(text, MOST_SHOWN)
}

/// As [`shown`], in quotes.
pub fn quoted(text: &str) -> String {
    format!("\"{}\"", shown(text))
}

/// The text, its hidden characters as escapes, cut where it would be longer than `most` characters.
pub fn cut(text: &str, most: usize) -> String {
    let mut cut = String::new();
    let mut count = 0;
    for character in text.chars() {
        let width = if is_hidden(character) { character.escape_unicode().len() } else { 1 };
        count += width;
        if count > most {
            cut.push('…');
            break;
        }
        match is_hidden(character) {
            true => cut.extend(character.escape_unicode()),
            false => cut.push(character),
        }
    }
    cut
}

/// A path, whole, its hidden characters as escapes.
pub fn path(path: &Path) -> String {
    escaped(&path.display().to_string()).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_values_are_cut_when_quoted() {
        assert_eq!(quoted("short"), "\"short\"");
        assert_eq!(quoted(&"ä".repeat(40)), format!("\"{}\"", "ä".repeat(40)));
        assert_eq!(quoted(&"ä".repeat(50)), format!("\"{}…\"", "ä".repeat(40)));
        let hidden = quoted(&"\u{1b}".repeat(50));
        assert!(hidden.starts_with("\"\\u{1b}\\u{1b}") && hidden.chars().count() <= 60, "{hidden}");
    }

    #[test]
    fn what_steers_a_terminal_is_escaped() {
        for hidden in
            ['\0', '\u{7}', '\u{1b}', '\u{7f}', '\u{9b}', '\u{200b}', '\u{2028}', '\u{202e}', '\u{2066}', '\u{feff}']
        {
            let text = format!("a{hidden}b");
            assert!(!quoted(&text).contains(hidden) && !path(Path::new(&text)).contains(hidden), "{hidden:?}");
        }
        assert_eq!(escaped("a\u{1b}[31m\n"), "a\\u{1b}[31m\\u{a}");
        assert_eq!(escaped_lines("a\u{1b}[31m\n\tb"), "a\\u{1b}[31m\n\tb");
        assert_eq!(escaped_json("{\n\"a\": \"\u{9b}\u{e0001}\"}"), "{\n\"a\": \"\\u009b\\udb40\\udc01\"}");
        assert!(matches!(escaped("grün, 灰色, é"), Cow::Borrowed(_)));
    }
}
