//! Something that is shown, found in a folder.

use std::path::PathBuf;
use std::time::SystemTime;

/// What a place holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A run: a sample or a test.
    Run,
    /// The runs of a plan.
    Campaign,
    /// Surrogates with their scores, or a training under way.
    Study,
    /// The file of a surrogate.
    Surrogate,
    /// The file of a fitted family.
    Family,
    /// What a calibration found.
    Calibration,
    /// A reproduction of the paper.
    Reproduction,
}

impl Kind {
    /// All, in the order in which they are shown.
    pub const ALL: [Kind; 7] = [
        Kind::Run,
        Kind::Campaign,
        Kind::Study,
        Kind::Surrogate,
        Kind::Family,
        Kind::Calibration,
        Kind::Reproduction,
    ];

    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            Kind::Run => "run",
            Kind::Campaign => "campaign",
            Kind::Study => "study",
            Kind::Surrogate => "surrogate",
            Kind::Family => "family",
            Kind::Calibration => "calibration",
            Kind::Reproduction => "reproduction",
        }
    }

    /// The kind of a word.
    pub fn named(word: &str) -> Option<Kind> {
        Kind::ALL.into_iter().find(|kind| kind.word() == word)
    }
}

/// Something that is shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// What it is.
    pub kind: Kind,
    /// Its folder or file.
    pub place: PathBuf,
    /// When the file that tells what it is was written last.
    pub modified: Option<SystemTime>,
}
