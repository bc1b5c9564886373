//! Paths and words for people and for shells: how a path is shown in a message, how it is written in JSON, and how it is quoted in a
//! command that can be pasted into a shell. Nothing else in granum decides this.
//!
//! The name of a file can have any bytes. Bytes that are not UTF-8 are shown as `\xff`.

use std::path::Path;

use crate::safe_text;

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

/// A path as an argument: quoted, and never mistaken for an option. Bytes that are not UTF-8 are written in the form `$'\xff'`, which
/// bash, zsh, ksh and the present POSIX standard read.
pub fn quoted_path(path: &Path) -> String {
    let inner = match path.to_str() {
        // What a terminal obeys is written so that a shell reads it.
        Some(text) if text.contains(safe_text::is_obeyed) && !cfg!(windows) => {
            escaped(path, |c| matches!(c, '\'' | '\\'))
        }
        Some(text) if !text.starts_with('-') => return quoted(text),
        Some(text) => return quoted(&format!("./{text}")),
        None => escaped(path, |c| matches!(c, '\'' | '\\')),
    };
    let prefix = if inner.starts_with('-') { "./" } else { "" };
    format!("$'{prefix}{inner}'")
}

/// A path as it is shown in a message, on one line: control characters and bytes that are not UTF-8 are escaped.
pub fn shown(path: &Path) -> String {
    escaped(path, |_| false)
}

/// The text of a path in a message.
pub trait ShowPath {
    /// As [`shown`] has it.
    fn shown(&self) -> String;
}

impl ShowPath for Path {
    fn shown(&self) -> String {
        shown(self)
    }
}

/// A path as text, for JSON: as it is if it is UTF-8, and otherwise as it is [shown].
pub fn path_text(path: &Path) -> String {
    path.to_str().map_or_else(|| shown(path), str::to_string)
}

/// The text of a path with `\n`, `\u{1b}` and `\xff` for what cannot be shown, and with a backslash before what `special` says.
fn escaped(path: &Path, special: impl Fn(char) -> bool) -> String {
    let mut text = String::new();
    for chunk in path.as_os_str().as_encoded_bytes().utf8_chunks() {
        for c in chunk.valid().chars() {
            match c {
                c if safe_text::is_obeyed(c) => text.push_str(&safe_text::line(c.encode_utf8(&mut [0; 4]))),
                c if special(c) => text.extend(['\\', c]),
                c => text.push(c),
            }
        }
        text.extend(chunk.invalid().iter().map(|byte| format!("\\x{byte:02x}")));
    }
    text
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

    #[test]
    fn a_path_is_shown_on_one_line() {
        assert_eq!(shown(Path::new("grün/it's")), "grün/it's");
        assert_eq!(shown(Path::new("a\nb\u{1b}[31m")), "a\\nb\\u001b[31m");
        assert_eq!(path_text(Path::new("a\nb")), "a\nb");
        assert_eq!(shown(Path::new("a\u{202e}b")), "a\\u202eb");
        if cfg!(unix) {
            assert_eq!(quoted_path(Path::new("a'\u{1b}b")), "$'a\\'\\u001bb'");
        }
    }

    #[cfg(unix)]
    #[test]
    fn bytes_that_are_not_text_are_escaped() {
        use std::ffi::OsStr;
        use std::os::unix::ffi::OsStrExt;
        let path = Path::new(OsStr::from_bytes(b"a'b/\xff\xfe9"));
        assert_eq!(shown(path), "a'b/\\xff\\xfe9");
        assert_eq!(path_text(path), shown(path));
        assert_eq!(quoted_path(path), "$'a\\'b/\\xff\\xfe9'");
        assert_eq!(quoted_path(Path::new(OsStr::from_bytes(b"-\xff"))), "$'./-\\xff'");
    }
}
