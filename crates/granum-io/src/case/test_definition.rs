//! The test of a case as the laboratory sees it, whichever way the case writes it.

use granum_dem::config::RecordedColumns;
use granum_dem::loading::{Measure, Stage};

/// The test of a case: its stages, and how it begins and what it leaves behind. It is all that engines, sensors, reports and the
/// program know of a test; how a case file writes it is known to [`CaseTest`](super::CaseTest) alone.
///
/// ```
/// use granum_io::Case;
///
/// let paper = Case::default().test_definition();
/// assert_eq!((paper.stages.len(), paper.deviator_strain_end()), (1, Some(0.3)));
/// let drained = Case::parse("[[stage]]\npath = 'drained-triaxial'\n", "case.toml")?.test_definition();
/// assert_eq!((drained.stages.len(), drained.deviator_strain_end()), (1, None));
/// # Ok::<(), granum_io::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TestDefinition {
    /// The stages, with the largest overlap of the case.
    pub stages: Vec<Stage>,
    /// Mean stress, Pa, at which the first stage begins: a sample of another mean stress is consolidated to it as it was prepared,
    /// before the test. `None` if the stages take the sample as it is, as those of named paths do, which consolidate it themselves.
    pub initial_mean_stress: Option<f64>,
    /// Factor on the density of the grains when the test begins. Each stage has its own factor as well; where the first stage has
    /// another one, it changes the densities once more, and the last digits of the results depend on whether it does.
    pub initial_density_scaling: f64,
    /// Values of the measure by which states are spaced at which a snapshot of all grains and contacts is taken, in ascending order,
    /// beside the one at the end of each stage.
    pub snapshots: Vec<f64>,
    /// The columns that are recorded.
    pub columns: RecordedColumns,
    /// What sets the speed of the test in its case file, for advice: `shear.inertial_number`.
    pub speed_key: &'static str,
}

impl TestDefinition {
    /// Mean stress, Pa, at the start of the test of a sample that was prepared at a mean stress `of_sample`, Pa.
    pub fn mean_stress(&self, of_sample: f64) -> f64 {
        self.initial_mean_stress.unwrap_or(of_sample)
    }

    /// The deviator strain `eps_1 - eps_3` at which the test ends; `None` if it has several stages, or ends otherwise.
    pub fn deviator_strain_end(&self) -> Option<f64> {
        match self.stages.as_slice() {
            [only] => only.end_at(Measure::AxialDeviatorStrain),
            _ => None,
        }
    }
}
