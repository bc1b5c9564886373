//! The secret of an address: whoever has it may read the folder.

use crate::serve_error::ServeError;

/// Bytes of a token: 128 bits.
const BYTES: usize = 16;

/// 128 random bits in hexadecimal digits, made anew whenever a folder is served.
#[derive(Clone, PartialEq, Eq)]
pub struct Token(String);

impl Token {
    /// A new one.
    ///
    /// # Errors
    /// If the system gives no random numbers.
    pub fn new() -> Result<Token, ServeError> {
        let mut bytes = [0u8; BYTES];
        getrandom::fill(&mut bytes).map_err(|error| ServeError::Random(error.to_string()))?;
        Ok(Token(bytes.iter().map(|byte| format!("{byte:02x}")).collect()))
    }

    /// Its digits.
    pub fn text(&self) -> &str {
        &self.0
    }

    /// True if a text is the token. How long that takes does not tell where they differ.
    pub fn is(&self, text: &str) -> bool {
        let (own, other) = (self.0.as_bytes(), text.as_bytes());
        own.len() == other.len() && own.iter().zip(other).fold(0, |sum, (a, b)| sum | (a ^ b)) == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_differ_and_are_told_apart() {
        let [a, b] = [Token::new().unwrap(), Token::new().unwrap()];
        assert_eq!(a.text().len(), 32);
        assert!(a.is(a.text()) && !a.is(b.text()) && !a.is("") && !a.is(&a.text()[1..]));
        let mut changed = a.text().to_string();
        changed.replace_range(31..32, if changed.ends_with('0') { "1" } else { "0" });
        assert!(!a.is(&changed));
    }
}
