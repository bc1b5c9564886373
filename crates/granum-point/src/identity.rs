//! The identity of a state: a digest of its sample and of everything that was done to it.

use std::fmt;

use granum_core::digest::Digest;
use serde::{Deserialize, Serialize};

/// A digest (SHA-256) of the sample, the controls and the path by which a state was reached. Two states with one identity have the same
/// bits, in whichever process and on whichever thread they were made.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Identity([u8; 32]);

impl Identity {
    /// The identity of what a digest took in.
    pub(crate) fn new(digest: Digest) -> Identity {
        let text = digest.finish();
        let digit =
            |k: usize| text.as_bytes().get(k).map_or(0, |c| (*c as char).to_digit(16).unwrap_or(0) as u8);
        Identity(std::array::from_fn(|k| 16 * digit(2 * k) + digit(2 * k + 1)))
    }

    /// Its bytes.
    pub fn bytes(&self) -> &[u8; 32] {
        &self.0
    }

    /// A whole number from 1 to 2^52 that stands for the identity where a program keeps state variables as doubles. It is the beginning
    /// of the digest, so that a state has the same ticket in every process.
    pub fn ticket(&self) -> u64 {
        let first = self.0[..8].iter().fold(0u64, |number, byte| (number << 8) | u64::from(*byte));
        (first >> 12) + 1
    }
}

impl fmt::Display for Identity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for Identity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ticket_is_the_beginning_of_the_digest_and_fits_a_double() {
        let mut digest = Digest::new();
        digest.bytes(b"abc");
        let identity = Identity::new(digest);
        assert!(identity.to_string().starts_with("ba7816bf8f01cfea4141"));
        assert_eq!(identity.ticket(), 0xba7816bf8f01c + 1);
        let ticket = identity.ticket();
        assert_eq!((ticket as f64) as u64, ticket);
        assert_eq!(Identity([0xff; 32]).ticket() as f64, 2f64.powi(52));
        assert_eq!(Identity([0; 32]).ticket(), 1);
    }
}
