//! The standard streams, without panics: a reader that has gone away is no reason to lose a picture.
//!
//! Comes in: text. Goes out: results on stdout, everything else on stderr, neither with a character that steers a
//! terminal: whoever names a file or a material does not write to the terminal of whoever reads of it.

use std::io::{self, ErrorKind, Write};

use texray::quote::{escaped_json, escaped_lines};
use texray::scene::LoadReport;
use texray::{Error, Result};

/// A line on stderr. One that cannot be written is dropped: there is nobody to tell.
pub fn say(line: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", escaped_lines(line));
}

/// What loading has to say: warnings and, unless `quiet`, notes; neither where there are warnings that are `denied`:
/// those are errors then.
pub fn tell_loading(report: &LoadReport, denied: bool, quiet: bool) {
    report.warnings.iter().filter(|_| !denied).for_each(|warning| say(&format!("warning: {warning}")));
    report
        .notes
        .iter()
        .filter(|_| !quiet && (!denied || report.warnings.is_empty()))
        .for_each(|note| say(&format!("note: {note}")));
}

/// Columns of a terminal that no line of a table exceeds.
const COLUMNS: usize = 80;

/// The text broken at spaces into lines of at most 80 columns, all but the first indented. A longer word stays whole.
pub fn folded(text: &str, indent: usize) -> String {
    let mut lines = Vec::new();
    // Spaces that begin the text or stand in a row are layout: only single ones are places to break at.
    let mut rest = text;
    let mut margin = 0;
    while margin + rest.chars().count() > COLUMNS {
        let room = rest.char_indices().nth(COLUMNS - margin + 1).map_or(rest.len(), |(at, _)| at);
        let start = rest.len() - rest.trim_start().len();
        let Some(cut) = rest[start..room].rfind(' ').or_else(|| rest[start..].find(' ')) else { break };
        let cut = start + cut;
        lines.push(format!("{:margin$}{}", "", rest[..cut].trim_end()));
        rest = rest[cut..].trim_start();
        margin = indent;
    }
    lines.push(format!("{:margin$}{rest}", ""));
    lines.join("\n")
}

/// A result on stdout, with a line feed. A reader that has read enough (`| head`) is not an error.
pub fn answer(text: &str) -> Result<()> {
    let mut stdout = io::stdout().lock();
    match writeln!(stdout, "{}", escaped_lines(text)).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Error::output("stdout", error.to_string())),
        _ => Ok(()),
    }
}

/// A JSON document on stdout.
pub fn answer_json(document: &impl serde::Serialize) -> Result<()> {
    answer(&escaped_json(&json(document)?))
}

/// A value as indented JSON.
pub fn json(document: &impl serde::Serialize) -> Result<String> {
    serde_json::to_string_pretty(document).map_err(|error| Error::Internal(format!("JSON: {error}")))
}

#[cfg(test)]
mod tests {
    use super::folded;

    #[test]
    fn lines_are_folded_at_spaces() {
        let words = "  abc: ".to_owned() + &"word ".repeat(40);
        let text = folded(words.trim_end(), 4);
        assert!(text.lines().count() == 3 && text.lines().all(|line| line.len() <= 80), "{text}");
        assert!(text.starts_with("  abc: word") && text.lines().skip(1).all(|line| line.starts_with("    word")));
        assert_eq!(text.split_whitespace().count(), 41);
        let long = "x".repeat(100);
        assert_eq!(folded(&long, 2), long);
        assert_eq!(folded(&format!("a {long} b"), 2), format!("a\n  {long}\n  b"));
        assert_eq!(folded("short", 2), "short");
        let exact = "y".repeat(78) + " z";
        assert_eq!(folded(&exact, 2), exact);
    }
}
