//! One digest (SHA-256) by which cases, files, data sets and models are identified.

use sha2::{Digest as _, Sha256};

/// Takes in texts and numbers piece by piece.
///
/// ```
/// use granum_core::digest::{self, Digest};
///
/// let mut digest = Digest::new();
/// digest.bytes(b"ab");
/// digest.bytes(b"c");
/// let hexadecimal = digest.finish();
/// assert_eq!(hexadecimal, digest::sha256(b"abc"));
/// assert!(hexadecimal.starts_with("ba7816bf8f01cfea"));
/// ```
#[derive(Clone, Debug, Default)]
pub struct Digest(Sha256);

impl Digest {
    /// Of nothing yet.
    pub fn new() -> Digest {
        Digest::default()
    }

    /// Takes in bytes as they are.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    /// Takes in a text with its length, so that no two lists of texts have one digest.
    pub fn text(&mut self, text: &str) {
        self.count(text.len());
        self.0.update(text);
    }

    /// Takes in a count.
    pub fn count(&mut self, count: usize) {
        self.0.update((count as u64).to_le_bytes());
    }

    /// Takes in the bits of numbers with their count. Every NaN counts as the same, for machines differ in its payload.
    pub fn numbers(&mut self, values: &[f64]) {
        self.count(values.len());
        for value in values {
            let bits = if value.is_nan() { 0x7ff8_0000_0000_0000 } else { value.to_bits() };
            self.0.update(bits.to_le_bytes());
        }
    }

    /// The digest as 64 hexadecimal digits.
    pub fn finish(self) -> String {
        self.0.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

/// The SHA-256 of some bytes, as 64 hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    let mut digest = Digest::new();
    digest.bytes(bytes);
    digest.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_values() {
        // FIPS 180-2, appendix B.
        assert_eq!(sha256(b""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
        assert_eq!(sha256(b"abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    }

    #[test]
    fn lists_and_numbers_are_told_apart() {
        let of = |texts: &[&str]| {
            let mut digest = Digest::new();
            texts.iter().for_each(|text| digest.text(text));
            digest.finish()
        };
        assert_ne!(of(&["a", "bc"]), of(&["ab", "c"]));
        let of = |values: &[f64]| {
            let mut digest = Digest::new();
            digest.numbers(values);
            digest.finish()
        };
        assert_eq!(of(&[f64::NAN]), of(&[-f64::NAN]));
        assert_ne!(of(&[0.0]), of(&[-0.0]));
        assert_ne!(of(&[1.0]), of(&[1.0f64.next_up()]));
    }
}
