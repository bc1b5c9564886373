//! How a case file is read.

use super::vocabulary::Vocabulary;

/// What is taken from a case file without question, by default nothing, and what its words stand for.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Reading {
    /// True if numbers without a unit are taken as they are. Otherwise a stress far from that of the sample and a strain beyond 1
    /// need their units, since they are probably meant in kPa or in per cent.
    pub bare_numbers: bool,
    /// True if the case may name files (histories, sieve curves, paths of the IncrementalDriver) outside its own folder.
    pub outside: bool,
    /// True if numbers in `[recording]` that no known sensor declares are taken as parameters of the sensors of another program, whose
    /// runs can thus be read.
    pub undeclared_parameters: bool,
    /// True if only the contact law and the grains of the case are used, so that rules on its preparation and test do not matter.
    pub law_only: bool,
    /// The laws, paths and sensors that the case can name.
    pub vocabulary: Vocabulary,
}

impl Reading {
    /// The file that a program wrote as the record of a run: its numbers are in SI units, and it may have sensors of its own.
    pub fn recorded() -> Reading {
        Reading { bare_numbers: true, undeclared_parameters: true, ..Reading::default() }
    }

    /// The same; the case may name files outside its own folder if `outside` is true.
    pub fn with_outside(self, outside: bool) -> Reading {
        Reading { outside, ..self }
    }

    /// The same; only the contact law and the grains of the case are used.
    pub fn for_law(self) -> Reading {
        Reading { law_only: true, ..self }
    }

    /// The same with other laws and paths that the case can name.
    pub fn with_vocabulary(self, vocabulary: &Vocabulary) -> Reading {
        Reading { vocabulary: vocabulary.clone(), ..self }
    }
}
