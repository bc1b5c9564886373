//! The text of a table that a person hands in, whatever program saved it: UTF-8 with or without a byte order mark, UTF-16, or
//! Windows-1252, in which Excel saves "CSV" in western Europe.

use std::io::{self, BufRead, Read};
use std::ops::Range;

/// A longer line is not a row of a table.
const LONGEST_LINE: u64 = 1 << 24;
/// A larger file is not a table that is read whole.
const LARGEST_FILE: u64 = 1 << 32;

/// The characters of Windows-1252 from 0x80 to 0x9F; the other bytes are those of Latin-1, and five stand for nothing.
const WINDOWS_1252: [char; 32] = [
    '€', '\0', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\0', 'Ž', '\0', '\0', '‘', '’', '“',
    '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\0', 'ž', 'Ÿ',
];

/// Why bytes are no text of a table.
#[derive(Debug)]
pub(super) enum TextFault {
    /// The bytes could not be read.
    Unreadable(io::Error),
    /// What is wrong, with the number of the line, from 1.
    AtLine(usize, String),
}

/// Reads all bytes and makes text of them.
///
/// # Errors
/// If they cannot be read, are too many, have a line without end, or are no text.
pub(super) fn read(mut reader: impl BufRead) -> Result<String, TextFault> {
    let mut bytes = Vec::new();
    for line in 1.. {
        let before = bytes.len();
        let count = Read::take(&mut reader, LONGEST_LINE).read_until(b'\n', &mut bytes);
        match count.map_err(TextFault::Unreadable)? as u64 {
            0 => break,
            LONGEST_LINE => {
                return Err(TextFault::AtLine(line, format!("the line is longer than {LONGEST_LINE} bytes")));
            }
            _ if bytes.len() as u64 > LARGEST_FILE => {
                return Err(TextFault::AtLine(line, format!("the file is longer than {LARGEST_FILE} bytes")));
            }
            _ if before == 0 && is_binary(&bytes) => {
                return Err(TextFault::AtLine(
                    line,
                    "the file is not text, but the data of a program: save it as CSV".into(),
                ));
            }
            _ => {}
        }
    }
    decoded(bytes)
}

/// True for a workbook, an archive or the like, which begin with marks of their own.
fn is_binary(first: &[u8]) -> bool {
    [&b"PK\x03\x04"[..], b"\xd0\xcf\x11\xe0", b"PAR1", b"\x1f\x8b"].iter().any(|mark| first.starts_with(mark))
}

/// Text of the bytes of a file, without byte order marks at its beginning.
fn decoded(bytes: Vec<u8>) -> Result<String, TextFault> {
    if let Some(rest) = bytes.strip_prefix(b"\xff\xfe") {
        return utf_16(rest, u16::from_le_bytes);
    }
    if let Some(rest) = bytes.strip_prefix(b"\xfe\xff") {
        return utf_16(rest, u16::from_be_bytes);
    }
    // Without a mark every second byte of western text is zero.
    let zeros = |odd: usize| {
        bytes.len() > 3
            && bytes.len().is_multiple_of(2)
            && bytes.iter().take(64).skip(odd).step_by(2).all(|b| *b == 0)
    };
    if zeros(1) {
        return utf_16(&bytes, u16::from_le_bytes);
    }
    if zeros(0) {
        return utf_16(&bytes, u16::from_be_bytes);
    }
    let text = match String::from_utf8(bytes) {
        Ok(text) => text,
        Err(error) => windows_1252(error.as_bytes())?,
    };
    checked(
        text.strip_prefix('\u{feff}')
            .map(|rest| rest.trim_start_matches('\u{feff}').to_string())
            .unwrap_or(text),
    )
}

fn utf_16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Result<String, TextFault> {
    let (pairs, rest) = bytes.as_chunks::<2>();
    let mut text = String::with_capacity(bytes.len() / 2);
    let fault = |text: &str| {
        TextFault::AtLine(
            line_of(text.as_bytes(), text.len()),
            "the line is not UTF-16 text; save the file as UTF-8".into(),
        )
    };
    for character in char::decode_utf16(pairs.iter().map(|pair| unit(*pair))) {
        match character {
            Ok(character) => text.push(character),
            Err(_) => return Err(fault(&text)),
        }
    }
    if !rest.is_empty() {
        return Err(fault(&text));
    }
    checked(text)
}

/// Text with one byte for each character. Bytes that are partly UTF-8 are a damaged file and no such text.
fn windows_1252(bytes: &[u8]) -> Result<String, TextFault> {
    let fault = |at: usize, what: &str| {
        TextFault::AtLine(
            line_of(bytes, at),
            format!("byte {:#04x} {what}; save the file as UTF-8", bytes[at]),
        )
    };
    let (mut at, mut first, mut has_utf_8) = (0, None, false);
    for chunk in bytes.utf8_chunks() {
        has_utf_8 |= !chunk.valid().is_ascii();
        at += chunk.valid().len();
        if !chunk.invalid().is_empty() {
            first = first.or(Some(at));
        }
        at += chunk.invalid().len();
    }
    if let Some(first) = first.filter(|_| has_utf_8) {
        return Err(fault(first, "is not UTF-8, as the rest of the file is"));
    }
    let mut text = String::with_capacity(bytes.len());
    for (at, byte) in bytes.iter().enumerate() {
        let character = match byte {
            0x80..=0x9f => WINDOWS_1252[usize::from(byte - 0x80)],
            _ => char::from(*byte),
        };
        if character == '\0' {
            return Err(fault(at, "is neither UTF-8 nor Windows-1252 text"));
        }
        text.push(character);
    }
    Ok(text)
}

/// Refuses characters that no text has.
fn checked(text: String) -> Result<String, TextFault> {
    match text.find('\0') {
        Some(at) => {
            let message = "the line has a zero byte, which no text has; save the file as CSV in UTF-8";
            Err(TextFault::AtLine(line_of(text.as_bytes(), at), message.into()))
        }
        None => Ok(text),
    }
}

/// The number of ends of lines in a range of bytes: `\n`, `\r\n` or `\r`.
pub(super) fn line_ends(text: &[u8], range: Range<usize>) -> usize {
    let ends = |at: &usize| match text.get(*at) {
        Some(b'\n') => true,
        Some(b'\r') => text.get(at + 1) != Some(&b'\n'),
        _ => false,
    };
    range.filter(ends).count()
}

/// The number of the line in which a byte stands, from 1.
pub(super) fn line_of(text: &[u8], at: usize) -> usize {
    line_ends(text, 0..at.min(text.len())) + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(bytes: &[u8]) -> Result<String, String> {
        read(bytes).map_err(|fault| match fault {
            TextFault::Unreadable(error) => error.to_string(),
            TextFault::AtLine(line, message) => format!("{line}: {message}"),
        })
    }

    #[test]
    fn the_usual_encodings_are_read() {
        let wanted = "σ;ε °\r\n1;2\r\n";
        let utf_16 =
            |unit: fn(u16) -> [u8; 2], text: &str| text.encode_utf16().flat_map(unit).collect::<Vec<u8>>();
        let marked = format!("\u{feff}{wanted}");
        assert_eq!(text(wanted.as_bytes()).unwrap(), wanted);
        assert_eq!(text(marked.as_bytes()).unwrap(), wanted);
        assert_eq!(text(&utf_16(u16::to_le_bytes, &marked)).unwrap(), wanted);
        assert_eq!(text(&utf_16(u16::to_be_bytes, &marked)).unwrap(), wanted);
        assert_eq!(text(&utf_16(u16::to_le_bytes, "a;b\n1;2\n")).unwrap(), "a;b\n1;2\n");
        assert_eq!(text(&utf_16(u16::to_be_bytes, "a;b\n1;2\n")).unwrap(), "a;b\n1;2\n");
        assert_eq!(text(b"Pr\xfcfung \x96 \x80\n").unwrap(), "Prüfung – €\n");
        assert_eq!(text(b"").unwrap(), "");
    }

    #[test]
    fn what_is_no_text_is_refused_with_its_line() {
        assert_eq!(
            text(b"a\n\x81\n").unwrap_err(),
            "2: byte 0x81 is neither UTF-8 nor Windows-1252 text; save the file as UTF-8"
        );
        assert!(
            text("µ\n1\n".as_bytes().iter().chain(b"\xff\n").copied().collect::<Vec<u8>>().as_slice())
                .unwrap_err()
                .starts_with("3: byte 0xff is not UTF-8")
        );
        assert!(text(b"\xff\xfea\0\n\0\x00\xd8b\0").unwrap_err().starts_with("2: the line is not UTF-16"));
        assert!(text(b"a,b\n1,\0\0\n").unwrap_err().starts_with("2: the line has a zero byte"));
        assert!(text(b"PK\x03\x04rest").unwrap_err().contains("save it as CSV"));
    }
}
