//! Digests of what decides a result, so that a finished run is used again only for the same case.

use sha2::{Digest, Sha256};

use super::fields::RENAMED;
use super::{Case, FIELDS, Field, Value};

/// Sections that decide the sample.
const PREPARATION: [&str; 5] = ["grains", "grains.material", "contact", "preparation", "numerics"];

impl Case {
    /// SHA-256 (hexadecimal) of the whole case: equal exactly if every field has the same bits.
    pub fn digest(&self) -> String {
        self.digest_of("granum case 1", |_| true)
    }

    /// SHA-256 (hexadecimal) of what decides the sample: grains, contact law, preparation and time step.
    pub fn preparation_digest(&self) -> String {
        self.digest_of("granum preparation 1", |section| PREPARATION.contains(&section))
    }

    fn digest_of(&self, title: &str, wanted: fn(&str) -> bool) -> String {
        let mut text = format!("{title}\n");
        for field in FIELDS.iter().filter(|field| wanted(field.section)) {
            let value = match field.value(self) {
                Some(Value::Number(Some(value))) => format!("{:016x}", value.to_bits()),
                Some(Value::Number(None)) | None => "-".to_string(),
                Some(Value::Count(value)) => value.to_string(),
                Some(Value::Choice(name)) => name.to_string(),
            };
            text.push_str(&format!("{}={value}\n", name(field)));
        }
        hexadecimal(&Sha256::digest(text.as_bytes()))
    }
}

/// The name of a key in digests, which is its first one.
fn name(field: &Field) -> String {
    let path = field.path();
    let first = RENAMED.iter().find(|[_, new]| *new == path);
    first.map_or(path, |[old, _]| (*old).to_string())
}

/// True if a key decides the sample, and not only what is done with it.
pub fn decides_sample(key: &str) -> bool {
    key.rsplit_once('.').is_some_and(|(section, _)| PREPARATION.contains(&section))
}

/// Bytes as lower-case hexadecimal digits.
pub(crate) fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
