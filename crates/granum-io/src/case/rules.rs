//! Rules between fields: each field may be right on its own and the whole still wrong.

use granum_dem::config::{NormalKind, TangentialKind};

use super::Case;
use crate::error::{Error, Result};

/// A rule: the fields that it is about (the first one given by the user is pointed at), and what is wrong.
pub(super) struct Rule {
    pub fields: &'static [&'static str],
    pub broken: fn(&Case) -> Option<String>,
}

pub(super) const RULES: &[Rule] = &[
    Rule {
        fields: &["contact.tangential", "contact.normal"],
        broken: |case| {
            let peeling = case.contact.tangential == TangentialKind::Peeling;
            (peeling && case.contact.normal != NormalKind::Jkr).then(|| {
                "contact.tangential = \"peeling\" needs contact.normal = \"jkr\": nothing peels without adhesion"
                    .to_string()
            })
        },
    },
    Rule {
        fields: &["preparation.initial_solid_fraction", "preparation.solid_fraction"],
        broken: |case| {
            let initial = case.preparation.initial_solid_fraction;
            let target = case.preparation.solid_fraction.filter(|target| *target <= initial)?;
            Some(format!(
                "preparation.initial_solid_fraction = {initial} must be below preparation.solid_fraction = {target}: \
                 the gas is compressed to the sample"
            ))
        },
    },
    Rule {
        fields: &["recording.bin_width", "recording.largest_force"],
        broken: |case| {
            let (width, largest) = (case.recording.bin_width, case.recording.largest_force);
            (width > largest).then(|| {
                format!("recording.bin_width = {width} must not be above recording.largest_force = {largest}")
            })
        },
    },
    Rule {
        fields: &["recording.bin_width", "recording.largest_force"],
        broken: |case| {
            let bins = (case.recording.largest_force / case.recording.bin_width).ceil();
            (bins > 10_000.0).then(|| {
                format!("recording.largest_force / recording.bin_width asks for {bins} bins; at most 10000 are kept")
            })
        },
    },
];

impl Case {
    /// Checks the bounds of every field and the rules between fields, for a case that was not read from a file.
    ///
    /// # Errors
    /// The first thing that is wrong, with the key, the value and what would be right.
    pub fn check(&self) -> Result<()> {
        for field in super::FIELDS {
            let Some(value) = field.value(self) else { continue };
            let text = field.toml(&value);
            field.parse(text.trim_matches('"')).map_err(|message| Error::Value {
                name: field.path(),
                value: text.trim_matches('"').to_string(),
                message,
            })?;
        }
        for rule in RULES {
            if let Some(message) = (rule.broken)(self) {
                return Err(Error::Rule(message));
            }
        }
        Ok(())
    }
}
