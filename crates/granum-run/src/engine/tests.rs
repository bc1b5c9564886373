use granum_core::observer::{Event, NamedValue};
use granum_dem::observer::{NoObserver, SimulationObserver};
use granum_io::{Case, RunFolder, RunKind, RunStatus};
use granum_sensors::RecordedState;

use super::*;
use crate::laboratory::{Laboratory, LaboratoryError, Source};
use crate::registry::RunRegistry;

/// Writes a case and a record, and no more.
struct Clerk;
impl Engine for Clerk {
    fn name(&self) -> &'static str {
        "clerk"
    }
    fn help(&self) -> &'static str {
        "writes down what it is asked for"
    }
    fn version(&self) -> Result<String, EngineError> {
        Ok("3.1".into())
    }
    fn plan(&self, task: Task, observer: &mut dyn SimulationObserver) -> Result<EngineRun, LaboratoryError> {
        if task.kind == RunKind::Sample {
            let what = "it makes no samples; use the engine granum".to_string();
            return Err(EngineError::Refused { engine: self.name().into(), what }.into());
        }
        observer.warn("nothing is simulated");
        Ok(EngineRun::new(task.record()?, |sink, observer| {
            let value = |name: &'static str, value| NamedValue { name: name.into(), value, unit: "".into() };
            sink.begin_states(&[])?;
            for state in 0..3 {
                let values =
                    vec![value("state", f64::from(state)), value("deviator_strain", 0.1 * f64::from(state))];
                sink.add_state(&RecordedState { values: values.clone(), histograms: Vec::new() })?;
                observer.event(&Event::StateRecorded { values });
            }
            if let Some(folder) = sink.folder() {
                std::fs::write(folder.join("restart"), "of its own")
                    .map_err(granum_io::Error::file("write", folder))?;
            }
            sink.record().measures.insert("pages".into(), 3.0);
            sink.record().status = RunStatus::Interrupted;
            Ok(())
        }))
    }
}

#[test]
fn an_engine_of_ones_own_runs_the_cases_of_a_laboratory() {
    let base = tempfile::tempdir().unwrap();
    let registry = RunRegistry::standard().with_engine(Clerk).unwrap();
    let laboratory = Laboratory { engine: "clerk".into(), ..Laboratory::here().with_registry(registry) };
    let folder = RunFolder::create(base.path().join("run"), false).unwrap();
    let case = Case::default();
    let record = laboratory.run(RunKind::Test, &case, &Source::Case, &folder, &mut NoObserver).unwrap();
    assert_eq!((record.engine.as_str(), record.status), ("clerk", RunStatus::Interrupted));
    assert_eq!((record.engine_version.as_str(), record.measures["pages"]), ("3.1", 3.0));
    assert_eq!(folder.run().record().unwrap().engine_version, record.engine_version);
    assert_eq!(folder.run().case().unwrap(), Case::default());

    // A refusal comes before a folder is created.
    let begun = laboratory.plan(RunKind::Sample, &case, &Source::Case, &mut NoObserver);
    let message = begun.err().unwrap().to_string();
    assert_eq!(message, "the engine clerk: it makes no samples; use the engine granum");
    // The record names the engine of a run, and resuming the run uses that engine.
    let message = laboratory.resume(&folder, &mut NoObserver).unwrap_err().to_string();
    assert!(message.starts_with("the engine clerk cannot resume an interrupted run"), "{message}");
    let message = Laboratory::here().resume(&folder, &mut NoObserver).unwrap_err().to_string();
    assert_eq!(message, "there is no engine \"clerk\"; there are: granum, lammps");
    let taken = laboratory.registry.with_engine(Clerk).err();
    assert_eq!(taken, Some(granum_core::RegistrationError::name_taken("engine", "clerk")));
}

#[test]
fn a_sensor_that_is_not_known_is_refused_before_there_is_a_folder() {
    let mut case = Case::default();
    case.grains.count = 60;
    case.recording.sensors = vec!["overlap_distributon".into()];
    let laboratory = Laboratory::here();
    let begun = laboratory.plan(RunKind::Test, &case, &Source::Case, &mut NoObserver);
    let message = begun.err().unwrap().to_string();
    let wanted = "there is no sensor \"overlap_distributon\"; did you mean overlap_distribution?";
    assert_eq!(message, format!("recording.sensors: {wanted}"));
}
