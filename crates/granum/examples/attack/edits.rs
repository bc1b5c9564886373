//! Damage to the bytes of a file.

use crate::random::Random;

/// Numbers at the ends of what can be written, and words that stand for numbers.
const EXTREMES: [&str; 19] = [
    "0",
    "-1",
    "1e9",
    "-1e9",
    "1e-300",
    "1e308",
    "-1e308",
    "5e-324",
    "1e400",
    "nan",
    "inf",
    "-inf",
    "4294967296",
    "2147483647",
    "18446744073709551615",
    "99999999999999999999999999",
    "0x10",
    "1.5",
    "",
];

/// Sequences that have a meaning in some format.
const TOKENS: [&[u8]; 18] = [
    b"\n",
    b",",
    b"\"",
    b"'",
    b"null",
    b"[]",
    b"{}",
    b"[[[[[[[[[[[[[[[[",
    b"<",
    b"&#0;",
    b"#",
    b"..",
    b"/dev/zero",
    b"\xff\xfe",
    &[0; 8],
    &[0xff; 8],
    &[0xff, 0xff, 0xff, 0xff, 0x0f],
    &[0, 0, 0, 0, 0, 0, 0xf0, 0x7f],
];

/// Damages bytes in one to three ways; `other` is a file of the same kind from which parts are taken. Returns the bytes, which differ
/// from the given ones, and what was done.
pub fn damaged(bytes: &[u8], other: &[u8], random: &mut Random) -> (Vec<u8>, String) {
    let mut new = bytes.to_vec();
    let mut done = Vec::new();
    let edits = 1 + random.below(6) / 3;
    while done.len() < edits || new == bytes {
        if done.len() > 50 {
            new.push(b'x');
        }
        done.push(edit(&mut new, other, random));
    }
    (new, done.join(", "))
}

fn edit(bytes: &mut Vec<u8>, other: &[u8], random: &mut Random) -> String {
    let text = is_text(bytes);
    let at = random.below(bytes.len());
    let end = (at + 1 + random.below(16)).min(bytes.len());
    match random.below(if text { 18 } else { 10 }) {
        0 | 1 if !bytes.is_empty() => {
            bytes[at] ^= 1 << random.below(8);
            format!("a bit of byte {at}")
        }
        2 if !bytes.is_empty() => {
            bytes[at] = random.byte();
            format!("byte {at}")
        }
        3 => {
            bytes.truncate(at);
            format!("cut off at byte {at}")
        }
        4 => {
            let token = *random.pick(&TOKENS);
            drop(bytes.splice(at..at, token.iter().copied()));
            format!("{token:?} put in at byte {at}")
        }
        5 => {
            drop(bytes.drain(at..end));
            format!("bytes {at} to {end} taken out")
        }
        6 => {
            bytes[at..end].fill(0);
            format!("bytes {at} to {end} zero")
        }
        7 if !other.is_empty() => {
            let from = random.below(other.len());
            let to = (from + 1 + random.below(200)).min(other.len());
            let end = (at + to - from).min(bytes.len());
            drop(bytes.splice(at..end, other[from..to].iter().copied()));
            format!("bytes {from} to {to} of another file at byte {at}")
        }
        8 => binary_number(bytes, random),
        9 => {
            let copy = bytes[at..].to_vec();
            bytes.extend(copy);
            format!("repeated from byte {at}")
        }
        10..=13 => number(bytes, random),
        _ => lines(bytes, random),
    }
}

fn is_text(bytes: &[u8]) -> bool {
    !bytes[..bytes.len().min(4096)].contains(&0)
        && bytes.iter().filter(|byte| **byte > 127).count() * 10 < bytes.len()
}

/// Eight bytes become a floating-point number, or four a whole number.
fn binary_number(bytes: &mut [u8], random: &mut Random) -> String {
    let values = [f64::NAN, f64::INFINITY, 1e308, -1e9, 0.0, 5e-324, -0.0];
    let whole = [0u32, 1, u32::MAX, i32::MAX as u32, 1 << 24];
    let size = if random.chance(0.5) { 8 } else { 4 };
    if bytes.len() < size {
        return "nothing".into();
    }
    // Binary numbers usually begin at multiples of four.
    let at = random.below((bytes.len() - size) / 4 + 1) * 4;
    if size == 8 {
        let value = random.pick(&values);
        bytes[at..at + 8].copy_from_slice(&value.to_le_bytes());
        format!("{value:e} as eight bytes at byte {at}")
    } else {
        let value = random.pick(&whole);
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        format!("{value} as four bytes at byte {at}")
    }
}

/// A number in a text becomes an extreme one, or loses or gains some digits.
fn number(bytes: &mut Vec<u8>, random: &mut Random) -> String {
    let part = |byte: &u8| byte.is_ascii_digit() || b".eE+-".contains(byte);
    let start = random.below(bytes.len());
    let Some(first) = (start..bytes.len()).find(|k| bytes[*k].is_ascii_digit()) else {
        return "nothing".into();
    };
    let begin = (0..first).rev().take_while(|k| part(&bytes[*k])).last().unwrap_or(first);
    let end = (first..bytes.len()).find(|k| !part(&bytes[*k])).unwrap_or(bytes.len());
    let old = String::from_utf8_lossy(&bytes[begin..end]).into_owned();
    let new = match random.below(4) {
        0 => format!("{old}{}", random.below(1000)),
        1 => format!("-{old}"),
        _ => (*random.pick(&EXTREMES)).to_string(),
    };
    drop(bytes.splice(begin..end, new.bytes()));
    format!("{old} became {new:?} at byte {begin}")
}

/// Lines are removed, duplicated, exchanged or repeated many times.
fn lines(bytes: &mut Vec<u8>, random: &mut Random) -> String {
    let mut lines: Vec<Vec<u8>> = bytes.split_inclusive(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
    if lines.is_empty() {
        return "nothing".into();
    }
    let (one, two) = (random.below(lines.len()), random.below(lines.len()));
    let told = match random.below(5) {
        0 => {
            lines.remove(one);
            format!("line {} removed", one + 1)
        }
        1 => {
            lines.insert(two, lines[one].clone());
            format!("line {} also before line {}", one + 1, two + 1)
        }
        2 => {
            lines.swap(one, two);
            format!("lines {} and {} exchanged", one + 1, two + 1)
        }
        3 => {
            let times = 1 + random.below(3000);
            let line = lines[one].clone();
            drop(lines.splice(one..one, std::iter::repeat_n(line, times)));
            format!("line {} repeated {times} times", one + 1)
        }
        _ => {
            // A word of the line.
            let words: Vec<Vec<u8>> = lines[one].split(|byte| *byte == b' ').map(<[u8]>::to_vec).collect();
            let mut words = words;
            let word = random.below(words.len());
            words.remove(word);
            lines[one] = words.join(&b' ');
            format!("word {} of line {} removed", word + 1, one + 1)
        }
    };
    *bytes = lines.concat();
    told
}
