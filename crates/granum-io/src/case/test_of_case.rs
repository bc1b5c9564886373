//! What a case says of its test, in whichever way its file writes it.

use granum_dem::config::Shear;
use granum_dem::loading::Stage;

use super::case_stage::CaseStage;
use super::case_test::CaseTest;
use super::definition::Case;
use super::field::{Field, Value};
use super::test_definition::TestDefinition;

impl Case {
    /// The test of the case.
    pub fn test_definition(&self) -> TestDefinition {
        let sample_stress = self.preparation.mean_stress;
        self.test.definition(&self.recording, sample_stress, self.numerics.overlap_limit())
    }

    /// The stages of the test.
    pub fn test_stages(&self) -> Vec<Stage> {
        self.test_definition().stages
    }

    /// The same case with another section `[shear]` as its test.
    ///
    /// ```
    /// use granum_io::Case;
    ///
    /// let case = Case::default().with_shear(|shear| shear.deviator_strain = 0.1);
    /// assert_eq!(case.test_definition().deviator_strain_end(), Some(0.1));
    /// ```
    pub fn with_shear(mut self, change: impl FnOnce(&mut Shear)) -> Case {
        let mut shear = self.test.shear().cloned().unwrap_or_default();
        change(&mut shear);
        self.test = CaseTest::Shear(shear);
        self
    }

    /// The same case with these stages as its test.
    pub fn with_stages(self, stages: Vec<CaseStage>) -> Case {
        Case { test: CaseTest::Stages(stages), ..self }
    }

    /// The value of a field as digests and comparisons of cases count it: a key that the case does not use counts at its default, so
    /// that it makes no difference whether it was ever written.
    pub(super) fn counted(&self, field: &Field) -> Option<Value> {
        if self.test.uses(&field.path()) { field.value(self) } else { field.value(&Case::default()) }
    }
}
