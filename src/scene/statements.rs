//! The text of an OBJ or MTL file as statements of a line each, whatever wrote it.
//!
//! Comes in: the bytes of a file. Goes out: the same with line feeds at line ends, each statement that goes on over
//! several lines (`\` at their ends) on the first of them, and empty lines in the place of the others: lines keep their
//! numbers. And words and names of a statement without the comment behind it.

/// Statements whose words are a name, which may hold a backslash and a `#`.
const NAMING: [&[u8]; 6] = [b"o", b"g", b"usemtl", b"newmtl", b"mtllib", b"bump"];

/// A line feed for each carriage return that ends a line alone; those before a line feed stay.
pub(super) fn end_lines(bytes: &mut [u8]) {
    let mut at = 0;
    while let Some(found) = bytes[at..].iter().position(|&byte| byte == b'\r') {
        let first = at + found;
        let run = bytes[first..].iter().take_while(|&&byte| byte == b'\r').count();
        at = first + run;
        if bytes.get(at) != Some(&b'\n') {
            bytes[first..at].fill(b'\n');
        }
    }
}

/// Statements that go on over several lines, each on its first. As many bytes as before, or fewer.
pub(super) fn join_lines(bytes: Vec<u8>) -> Vec<u8> {
    if !bytes.contains(&b'\\') {
        return bytes;
    }
    let mut joined = Vec::with_capacity(bytes.len());
    // Line feeds that are owed to the lines that were joined.
    let mut owed = 0;
    let mut begins = true;
    let mut keyword: &[u8] = b"";
    for line in bytes.split_inclusive(|&byte| byte == b'\n') {
        let text = line.trim_ascii_end();
        if begins {
            keyword = first_word(text);
        }
        begins = true;
        match continued(keyword, text) {
            Some(text) if line.ends_with(b"\n") => {
                joined.extend_from_slice(text);
                joined.push(b' ');
                owed += 1;
                begins = false;
            }
            Some(text) => joined.extend_from_slice(text),
            None => {
                joined.extend_from_slice(line);
                joined.extend(std::iter::repeat_n(b'\n', std::mem::take(&mut owed)));
            }
        }
    }
    joined
}

fn first_word(line: &[u8]) -> &[u8] {
    let line = line.trim_ascii_start();
    &line[..line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len())]
}

/// What stands before the `\` that ends the line; `None` where it ends a comment or a name instead.
fn continued<'a>(keyword: &[u8], line: &'a [u8]) -> Option<&'a [u8]> {
    let text = line.strip_suffix(b"\\")?;
    let blank_before = text.last().is_none_or(u8::is_ascii_whitespace);
    let names = NAMING.contains(&keyword) || keyword.starts_with(b"map_");
    if names && !blank_before {
        return None;
    }
    // A comment ends with its line; in a name, it begins behind a blank.
    let mut before = b' ';
    let comment = text.iter().any(|&byte| {
        let begins = byte == b'#' && if names { before.is_ascii_whitespace() } else { before != b'.' };
        before = byte;
        begins
    });
    (!comment).then_some(text)
}

/// The words of a statement of numbers, without the comment behind them. What C wrote for no number, `1.#IND`, is none.
pub(super) fn uncommented(words: &str) -> &str {
    let begins = |&(at, _): &(usize, &str)| !words[..at].ends_with('.');
    words.match_indices('#').find(begins).map_or(words, |(at, _)| &words[..at])
}

/// A name without the comment behind it, which a blank must come before: `Material#2` is all name.
pub(super) fn bare_name(name: &str) -> &str {
    let begins = |&(at, _): &(usize, &str)| name[..at].ends_with([' ', '\t']) || at == 0;
    name.match_indices('#').find(begins).map_or(name, |(at, _)| name[..at].trim_ascii_end())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn joined(text: &str) -> String {
        let mut bytes = text.as_bytes().to_vec();
        end_lines(&mut bytes);
        String::from_utf8(join_lines(bytes)).unwrap()
    }

    #[test]
    fn lines_that_end_in_cr_alone_are_lines() {
        assert_eq!(joined("a\rb\r\rc\r\nd\r\r\ne\r"), "a\nb\n\nc\r\nd\r\r\ne\n");
    }

    #[test]
    fn a_statement_on_several_lines_stands_on_the_first() {
        for end in ["\n", "\r\n", " \n", "\t\r\n"] {
            let text = format!("v 1 \\{end} 2\\{end}3\nf 1 2 3\n");
            assert_eq!(joined(&text), "v 1   2 3\n\n\nf 1 2 3\n", "{end:?}");
        }
        assert_eq!(joined("v 1 \\\r 2\rv"), "v 1   2\n\nv");
        assert_eq!(joined("mtllib a \\\nb\nf 1 \\"), "mtllib a  b\n\nf 1 ");
        for same in
            ["# C:\\a\\\nv 1\n", "v 1 # C:\\\nf\n", "usemtl a\\\nf 1\n", "map_Kd C:\\a\\\nKd 1\n", "mtllib a # \\\nv\n"]
        {
            assert_eq!(joined(same), same);
        }
    }

    #[test]
    fn comments_end_words_and_names() {
        assert_eq!((uncommented("1 2 # 3"), uncommented("1 2#3"), uncommented("# 1")), ("1 2 ", "1 2", ""));
        assert_eq!(uncommented("-1.#IND 1.#QNAN # c"), "-1.#IND 1.#QNAN ");
        assert_eq!(
            (bare_name("a#2"), bare_name("a b # c"), bare_name("# c"), bare_name("a\t#")),
            ("a#2", "a b", "", "a")
        );
    }
}
