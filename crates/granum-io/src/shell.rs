//! Words of a command line that can be pasted into a shell.

use std::path::Path;

/// A word as a shell takes it: as it is if a shell reads nothing special in it, else in quotes.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=:,+@%\\".contains(c);
    // A backslash is plain on Windows only; elsewhere it is read by the shell.
    let plain = |c: char| plain(c) && (cfg!(windows) || c != '\\');
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_string();
    }
    if cfg!(windows) { format!("\"{word}\"") } else { format!("'{}'", word.replace('\'', r"'\''")) }
}

/// A path as an argument: quoted, and never taken for an option.
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
