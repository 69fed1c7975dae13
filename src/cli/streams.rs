//! The standard streams, without panics: a reader that has gone away is no reason to lose a picture.
//!
//! Comes in: text. Goes out: results on stdout, everything else on stderr.

use std::io::{self, ErrorKind, Write};

use texray::{Error, Result};

/// A line on stderr. One that cannot be written is dropped: there is nobody to tell.
pub fn say(line: &str) {
    let _ = writeln!(io::stderr().lock(), "{line}");
}

/// A result on stdout, with a line feed. A reader that has read enough (`| head`) is not an error.
pub fn answer(text: &str) -> Result<()> {
    let mut stdout = io::stdout().lock();
    match writeln!(stdout, "{text}").and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Error::output("stdout", error.to_string())),
        _ => Ok(()),
    }
}

/// A JSON document on stdout.
pub fn answer_json(document: &impl serde::Serialize) -> Result<()> {
    answer(&json(document)?)
}

/// A value as indented JSON.
pub fn json(document: &impl serde::Serialize) -> Result<String> {
    serde_json::to_string_pretty(document).map_err(|error| Error::Internal(format!("JSON: {error}")))
}
