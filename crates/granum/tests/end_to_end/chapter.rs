//! The commands and files of a chapter of the book, as the tests of chapters take them.

use std::path::Path;

/// The words of a line; those in quotes are one, and a comment ends it.
pub fn words(line: &str) -> Vec<String> {
    let (mut words, mut word, mut in_quotes) = (Vec::new(), String::new(), false);
    for c in line.chars() {
        match c {
            '"' => in_quotes = !in_quotes,
            '#' if !in_quotes && word.is_empty() => break,
            ' ' if !in_quotes => {
                words.extend(Some(std::mem::take(&mut word)).filter(|word| !word.is_empty()));
            }
            c => word.push(c),
        }
    }
    words.extend(Some(word).filter(|word| !word.is_empty()));
    words
}

/// Changes texts of a written file, mostly to make it smaller; every one must be in it.
pub fn change(file: &Path, changes: &[(&str, &str)]) {
    let mut text = std::fs::read_to_string(file).unwrap();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}\n{text}");
        text = text.replace(from, to);
    }
    std::fs::write(file, text).unwrap();
}
