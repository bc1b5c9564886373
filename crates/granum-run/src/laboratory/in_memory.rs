//! Tests that are kept in memory, for programs of one's own.

use granum_dem::observer::{NoObserver, Observer};
use granum_dem::simulation::{Hardware, Simulation};
use granum_io::{Case, RunRecord, RunStatus};
use granum_sensors::Record;

use super::run_state::Stage;
use super::store::Store;
use super::{Laboratory, LaboratoryError, Source, run};
use crate::engine::Task;
use crate::engine::native::Native;

/// What came of a test that was kept in memory.
#[derive(Clone)]
pub struct TestResult {
    /// What the sensors saw: the series of states and the histograms of forces.
    pub record: Record,
    /// What is said of the run: measures, quality flags, notes, steps.
    pub about: RunRecord,
    /// The simulation at the end of the test, to look at or to go on with.
    pub simulation: Simulation,
}

impl Laboratory {
    /// A laboratory on all processors of this machine.
    pub fn here() -> Laboratory {
        let threads = granum_core::parallel::available_threads();
        Laboratory::new(Hardware { threads, ..Hardware::default() }, env!("CARGO_PKG_VERSION"))
    }

    /// Makes the sample of a case and tests it, by the same rules and to the same bits as [`Laboratory::shear`] with granum's own
    /// engine, and leaves no files.
    ///
    /// ```
    /// use granum_io::Case;
    /// use granum_run::Laboratory;
    ///
    /// let case = "grains.count = 60\npreparation.solid_fraction = 'none'\npreparation.unbalanced_force = 0.05\n\
    ///             shear.deviator_strain = 0.01\nshear.inertial_number = 0.01\nrecording.states = 2";
    /// let test = Laboratory::here().test(&Case::parse(case, "case")?)?;
    /// assert_eq!(test.record.series.rows(), 3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`LaboratoryError`] if the case cannot be run, or the run fails.
    pub fn test(&self, case: &Case) -> Result<TestResult, LaboratoryError> {
        self.test_of(case, &Source::Case, &mut NoObserver)
    }

    /// As [`Laboratory::test`], on a sample from elsewhere and with an observer, who may end it early.
    ///
    /// # Errors
    /// As [`Laboratory::test`]; also if the sample cannot be used.
    pub fn test_of(
        &self,
        case: &Case,
        source: &Source,
        observer: &mut dyn Observer,
    ) -> Result<TestResult, LaboratoryError> {
        let task = Task::new("shear", case, source, self);
        let run::Begun { record: mut about, run_state } = run::begin(&task, &Native, observer)?;
        let run_state = self.go_on(case, run_state, Store(None), &mut about, observer)?;
        if about.status == RunStatus::Running {
            about.status = RunStatus::Finished;
        }
        let record = match &run_state.stage {
            Stage::Test(test) => test.record(),
            _ => Record::default(),
        };
        Ok(TestResult { record, about, simulation: run_state.simulation })
    }
}
