//! Words of a command line that can be pasted into a shell.

use std::path::Path;

/// A word in the form that a shell requires: unchanged if it contains nothing special to a shell, otherwise in quotes.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=:,+@%\\".contains(c);
    // A backslash is plain on Windows only; elsewhere the shell interprets it.
    let plain = |c: char| plain(c) && (cfg!(windows) || c != '\\');
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_string();
    }
    if cfg!(windows) { format!("\"{word}\"") } else { format!("'{}'", word.replace('\'', r"'\''")) }
}

/// A path as an argument: quoted, and never mistaken for an option.
pub fn quoted_path(path: &Path) -> String {
    let path = path.to_string_lossy();
    if path.starts_with('-') { quoted(&format!("./{path}")) } else { quoted(&path) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_words_stay_and_others_are_quoted() {
        assert_eq!(quoted("run-1/F1_2.json"), "run-1/F1_2.json");
        assert_eq!(quoted("grün"), "grün");
        assert_eq!(quoted_path(Path::new("-run")), "./-run");
    }
}
