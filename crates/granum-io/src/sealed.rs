//! Readable JSON files that carry their own check: the last entry is the SHA-256 of the text before it, so that a reader
//! notices any change.

use std::io::Write;
use std::path::Path;

use granum_core::digest;
use serde::Serialize;

use crate::atomic::write_atomically;
use crate::error::{Error, Result};

/// The text before the digest, which covers all bytes before this text.
const SEAL: &str = ",\n  \"sha256\": \"";

/// A text whose digest was compared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unsealed {
    /// The JSON text without its digest.
    pub text: String,
    /// True if the text had a digest, which matched; files of earlier versions had none.
    pub checked: bool,
}

/// The readable JSON of a value with the digest as its last entry. An object without entries has nothing to protect and gets
/// no digest.
///
/// # Errors
/// If the value cannot be written as JSON.
pub fn seal(value: &impl Serialize) -> std::result::Result<String, serde_json::Error> {
    let text = serde_json::to_string_pretty(value)?;
    Ok(match text.strip_suffix("\n}") {
        Some(body) => format!("{body}{SEAL}{}\"\n}}\n", digest::sha256(body.as_bytes())),
        None => text + "\n",
    })
}

/// Writes a value as sealed JSON.
///
/// # Errors
/// [`Error::File`] if the file cannot be written.
pub fn write_sealed(path: &Path, value: &impl Serialize) -> Result<()> {
    write_atomically(path, |file| file.write_all(seal(value)?.as_bytes()))
}

/// Compares the digest of a text with the text before it.
///
/// # Errors
/// [`Error::Content`] if they do not match: the file was changed or damaged.
pub fn unseal(path: &Path, text: &str) -> Result<Unsealed> {
    let Some(at) = text.rfind(SEAL) else { return Ok(Unsealed { text: text.to_string(), checked: false }) };
    let (body, rest) = (&text[..at], &text[at + SEAL.len()..]);
    if rest != format!("{}\"\n}}\n", digest::sha256(body.as_bytes())) {
        let message = "was changed or damaged: the SHA-256 at its end is not that of its text";
        return Err(Error::content(path, message));
    }
    Ok(Unsealed { text: format!("{body}\n}}"), checked: true })
}

/// As [`unseal`], for a file that always has a digest.
///
/// # Errors
/// [`Error::Content`] if the digest is missing or does not match.
pub fn unseal_strictly(path: &Path, text: &str) -> Result<String> {
    let unsealed = unseal(path, text)?;
    if unsealed.checked {
        return Ok(unsealed.text);
    }
    Err(Error::content(path, "was changed or damaged: the SHA-256 at its end is missing"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn every_changed_bit_is_noticed() {
        let value = BTreeMap::from([("a", 1.5), ("b", -2.0)]);
        let text = seal(&value).unwrap();
        let path = Path::new("x.json");
        let back: BTreeMap<String, f64> =
            serde_json::from_str(&unseal_strictly(path, &text).unwrap()).unwrap();
        assert_eq!(back["b"], -2.0);
        assert!(serde_json::from_str::<serde_json::Value>(&text).unwrap()["sha256"].is_string());
        for (at, bit) in (0..text.len()).flat_map(|at| (0..7).map(move |bit| (at, bit))) {
            let mut bytes = text.clone().into_bytes();
            bytes[at] ^= 1 << bit;
            let changed = String::from_utf8(bytes).unwrap();
            let message = unseal_strictly(path, &changed).unwrap_err().to_string();
            assert!(message.starts_with("x.json: was changed or damaged"), "byte {at} bit {bit}: {message}");
        }
    }

    #[test]
    fn texts_without_a_digest_are_told_apart() {
        let path = Path::new("x.json");
        assert_eq!(
            unseal(path, "{\n  \"a\": 1\n}").unwrap(),
            Unsealed { text: "{\n  \"a\": 1\n}".into(), checked: false }
        );
        assert_eq!(seal(&BTreeMap::<String, f64>::new()).unwrap(), "{}\n");
        assert!(unseal_strictly(path, "{}").unwrap_err().to_string().contains("is missing"));
    }
}
