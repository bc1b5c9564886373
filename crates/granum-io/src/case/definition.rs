//! The case: all the input that determines a result.

use granum_dem::config::{ContactModel, Grains, Numerics, Preparation, Recording};
use serde::{Deserialize, Serialize};

use super::bond::CaseBond;
use super::case_stage::CaseStage;
use super::case_test::CaseTest;
use super::vocabulary::Vocabulary;

/// All the input that determines a result. [`Default`] is the case of Antony, Zhou and Wang (2006).
///
/// ```
/// let case = granum_io::Case::parse("[grains]\ncount = 1000\ndiameter = \"0.2 mm\"\n", "case.toml").unwrap();
/// assert_eq!(case.grains.count, 1000);
/// assert_eq!(case.grains.diameter, 2e-4);
/// let error = granum_io::Case::parse("[contact]\ndampling = 0.1\n", "case.toml").unwrap_err();
/// assert!(error.to_string().starts_with("case.toml:2:1: unknown key contact.dampling"));
/// assert!(error.to_string().contains("did you mean damping?"));
/// ```
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Case {
    /// The grains.
    pub grains: Grains,
    /// The contact law.
    pub contact: ContactModel,
    /// The preparation of the sample.
    pub preparation: Preparation,
    /// Loading paths between the compaction and the relaxation of the sample; empty if there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub preparation_stages: Vec<CaseStage>,
    /// The test as its file writes it; [`Case::test_definition`] is what it comes to.
    #[serde(flatten)]
    pub test: CaseTest,
    /// The states that the sensors record.
    pub recording: Recording,
    /// Bonds, each set with the stage before which it is made; empty if there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bonds: Vec<CaseBond>,
    /// Numerical choices.
    pub numerics: Numerics,
    /// The laws and paths that the case can name. It has no part in the result.
    #[serde(skip)]
    pub vocabulary: Vocabulary,
}

/// Two cases are equal if they mean the same, whatever other words each of them knows.
impl PartialEq for Case {
    fn eq(&self, other: &Case) -> bool {
        let Case {
            grains,
            contact,
            preparation,
            preparation_stages,
            test,
            recording,
            bonds,
            numerics,
            vocabulary: _,
        } = self;
        *grains == other.grains
            && *contact == other.contact
            && *preparation == other.preparation
            && *preparation_stages == other.preparation_stages
            && *test == other.test
            && *recording == other.recording
            && *bonds == other.bonds
            && *numerics == other.numerics
    }
}
