//! Words as a shell takes them.

/// `word` so that a POSIX shell reads it as one word: as it is where that is safe, else in single quotes.
pub fn word(word: &str) -> String {
    let is_safe = |c: char| c.is_alphanumeric() || "-_./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_safe) {
        return word.into();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::word;

    /// The shell itself says what it reads.
    #[cfg(unix)]
    #[test]
    fn a_shell_reads_one_word() {
        for text in
            ["", "a b", "it's", "$HOME", "a\"b", "*", "~", "a;b", "plain-1.5_x/y=2,3", "ä ö", "\\", "`x`", "a\nb"]
        {
            let output =
                std::process::Command::new("sh").args(["-c", &format!("printf '<%s>' {}", word(text))]).output();
            assert_eq!(String::from_utf8(output.unwrap().stdout).unwrap(), format!("<{text}>"));
        }
        assert_eq!(word("scenes/cornell-box.toml"), "scenes/cornell-box.toml");
    }
}
