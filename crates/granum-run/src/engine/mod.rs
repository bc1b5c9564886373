//! An [`Engine`] executes the run of a case. The engine of granum is [`Native`](native::Native); a new one needs a file in
//! this folder and a line in [`Engines::standard`], and a program can add its own engine with [`Engines::with`].

pub(crate) mod engine_error;
pub(crate) mod engine_trait;
pub mod native;

use std::sync::Arc;

pub use engine_error::EngineError;
pub use engine_trait::{Engine, Engines, PlannedRun, Task};

impl Engines {
    /// The engines that come with granum.
    pub fn standard() -> Engines {
        Engines(vec![Arc::new(native::Native)])
    }
}

#[cfg(test)]
mod tests {
    use granum_dem::observer::{NoObserver, Observer};
    use granum_io::run::TEST;
    use granum_io::{Case, RunFolder, RunStatus};

    use super::*;
    use crate::laboratory::{Laboratory, LaboratoryError, Source};
    use crate::registry::Registry;

    /// Writes a case and a record, and no more.
    struct Clerk;
    impl Engine for Clerk {
        fn name(&self) -> &'static str {
            "clerk"
        }
        fn help(&self) -> &'static str {
            "writes down what it is asked for"
        }
        fn begin<'a>(
            &'a self,
            task: Task<'a>,
            observer: &mut dyn Observer,
        ) -> Result<PlannedRun<'a>, LaboratoryError> {
            if task.kind != TEST {
                let what = "it makes no samples; use the engine granum".to_string();
                return Err(EngineError::Failed { engine: self.name(), what }.into());
            }
            observer.warn("nothing is simulated");
            let mut record = task.record(self)?;
            Ok(PlannedRun::new(move |folder, _| {
                folder.write_case(task.case, None)?;
                record.status = RunStatus::Interrupted;
                folder.write_record(&record)?;
                Ok(record)
            }))
        }
    }

    #[test]
    fn an_engine_of_ones_own_runs_the_cases_of_a_laboratory() {
        let base = tempfile::tempdir().unwrap();
        let registry = Registry::standard().with_engine(Clerk).unwrap();
        let laboratory = Laboratory { engine: "clerk".into(), ..Laboratory::here().with_registry(registry) };
        let folder = RunFolder::create(base.path().join("run"), false).unwrap();
        let record = laboratory.shear(&Case::default(), &Source::Case, &folder, &mut NoObserver).unwrap();
        assert_eq!((record.engine.as_str(), record.status), ("clerk", RunStatus::Interrupted));
        assert_eq!(folder.run().record().unwrap(), record);
        assert_eq!(folder.run().case().unwrap(), Case::default());

        // A refusal comes before a folder is created.
        let case = Case::default();
        let begun = laboratory.planned("prepare", &case, &Source::Case, &mut NoObserver);
        let message = begun.err().unwrap().to_string();
        assert_eq!(message, "the engine clerk: it makes no samples; use the engine granum");
        // The record names the engine of a run, and resuming the run uses that engine.
        let message = laboratory.resume(&folder, &mut NoObserver).unwrap_err().to_string();
        assert!(message.starts_with("the engine clerk cannot resume an interrupted run"), "{message}");
        let message = Laboratory::here().resume(&folder, &mut NoObserver).unwrap_err().to_string();
        assert_eq!(message, "there is no engine \"clerk\"; there are: granum");
        let taken = laboratory.registry.with_engine(Clerk).err();
        assert_eq!(taken, Some(EngineError::NameTaken { name: "clerk" }.into()));
    }

    #[test]
    fn a_sensor_that_is_not_known_is_refused_before_there_is_a_folder() {
        let mut case = Case::default();
        case.grains.count = 60;
        case.recording.sensors = vec!["overlap_distributon".into()];
        let laboratory = Laboratory::here();
        let begun = laboratory.planned(TEST, &case, &Source::Case, &mut NoObserver);
        let message = begun.err().unwrap().to_string();
        let wanted = "there is no sensor \"overlap_distributon\"; did you mean overlap_distribution?";
        assert_eq!(message, format!("recording.sensors: {wanted}"));
    }
}
