//! Tests that stay in memory, for use from other programs.

use granum_dem::observer::{NoObserver, Observer};
use granum_dem::preparation::{Phase, PreparationError};
use granum_dem::simulation::{Hardware, Simulation};
use granum_io::run::TEST;
use granum_io::{Case, RunRecord, RunStatus};
use granum_sensors::Record;

use super::laboratory_error::LaboratoryError;
use super::source::Source;
use crate::engine::engine_trait::{Laboratory, Task};
use crate::engine::native::Native;
use crate::engine::native::run;
use crate::engine::native::run_state::RunPart;
use crate::engine::native::store::Store;

/// The result of a test that was kept in memory.
#[derive(Clone)]
pub struct TestResult {
    /// The measurements: the series of states and the histograms of forces.
    pub record: Record,
    /// The record of the run: measures, quality flags, notes, numbers of steps.
    pub about: RunRecord,
    /// The simulation at the end of the test, which can be inspected or continued.
    pub simulation: Simulation,
}

/// A sample that was kept in memory.
#[derive(Clone)]
pub struct PreparedSample {
    /// The record of the preparation: measures, quality flags, notes, numbers of steps.
    pub about: RunRecord,
    /// The simulation, at rest at the mean stress of the preparation.
    pub simulation: Simulation,
}

impl Laboratory {
    /// Prepares the sample of a case, identical bit by bit to that of [`Laboratory::prepare`]; no files are written.
    ///
    /// # Errors
    /// [`LaboratoryError`] if the sample cannot be prepared, or the observer stops the preparation.
    pub fn sample(
        &self,
        case: &Case,
        observer: &mut dyn Observer,
    ) -> Result<PreparedSample, LaboratoryError> {
        let task = Task::new("prepare", case, &Source::Case, self);
        let run::Begun { record: mut about, run_state } = run::begin(&task, &Native, observer)?;
        let run_state = self.go_on(case, run_state, Store(None), &mut about, observer)?;
        if about.status == RunStatus::Interrupted {
            let phase = match &run_state.part {
                RunPart::Preparation(state) | RunPart::Consolidation(state) => state.phase(),
                _ => Phase::Compaction,
            };
            return Err(PreparationError::Stopped { phase }.into());
        }
        run_state.write_into(&mut about);
        about.status = RunStatus::Finished;
        Ok(PreparedSample { about, simulation: run_state.simulation })
    }

    /// A laboratory that uses all processors of this computer.
    pub fn here() -> Laboratory {
        let threads = granum_core::parallel::available_threads();
        Laboratory::new(Hardware { threads, ..Hardware::default() }, env!("CARGO_PKG_VERSION"))
    }

    /// Prepares the sample of a case and tests it. The results are identical bit by bit to those of [`Laboratory::shear`]
    /// with the engine of granum, but no files are written.
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

    /// As [`Laboratory::test`], with a sample from any source and with an observer that may end the test early.
    ///
    /// # Errors
    /// As [`Laboratory::test`]; also if the sample cannot be used.
    pub fn test_of(
        &self,
        case: &Case,
        source: &Source,
        observer: &mut dyn Observer,
    ) -> Result<TestResult, LaboratoryError> {
        let task = Task::new(TEST, case, source, self);
        let run::Begun { record: mut about, run_state } = run::begin(&task, &Native, observer)?;
        let run_state = self.go_on(case, run_state, Store(None), &mut about, observer)?;
        if about.status == RunStatus::Running {
            about.status = RunStatus::Finished;
        }
        let record = match &run_state.part {
            RunPart::Test(test) => test.record(),
            _ => Record::default(),
        };
        Ok(TestResult { record, about, simulation: run_state.simulation })
    }
}
