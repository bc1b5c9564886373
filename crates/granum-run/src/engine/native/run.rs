//! A run of the engine of granum, which consists of preparation, sample, consolidation (if the mean stress of the test
//! differs from that of the sample) and test. A checkpoint is written between the parts, at intervals of wall time, and
//! when the observer stops the run.

use std::time::Instant;

use granum_dem::loading::StageEnd;
use granum_dem::observer::Observer;
use granum_dem::preparation::PreparationError;
use granum_io::run::{Fault, Run, RunFolder, RunRecord, RunSource, RunStatus};
use granum_io::{Case, Error as FileError};
use granum_sensors::Record;

use super::run_state::{self, RunPart, RunState};
use super::sample::note;
use super::segment::Segment;
use super::store::{END, SAMPLE, Store};
use super::test_state::{MOST_STAGES_NOTED, Test};
use super::{consolidation, from_packing, measures, quality};
use crate::engine::engine_trait::{Engine, Laboratory, Task};
use crate::laboratory::laboratory_error::LaboratoryError;
use crate::laboratory::source::Source;
use crate::laboratory::status::Speedometer;
use crate::laboratory::{estimate, memory};
use crate::record::write_record;
use crate::strength;

/// Beginning of the note of a run that failed.
const FAILED: &str = "failed: ";

/// A run whose inputs have been checked and which has not written anything yet.
pub(crate) struct Begun {
    pub(crate) record: RunRecord,
    pub(crate) run_state: RunState,
}

/// Reads and checks the inputs of a run, and warns the observer of anything that the user should know. Nothing is written.
///
/// # Errors
/// [`LaboratoryError`] if the case does not fit into memory, or if its sample, packing or sensors cannot be used.
pub(crate) fn begin(
    task: &Task,
    engine: &dyn Engine,
    observer: &mut dyn Observer,
) -> Result<Begun, LaboratoryError> {
    let Task { case, source, laboratory, .. } = *task;
    let columns = case.test_definition().columns;
    laboratory.registry.vocabulary.sensors().of_test(&case.recording, columns)?;
    // The folder of the run is read again from what is written there.
    case.readable_toml(None)?;
    if *source == Source::Case {
        memory::check(case)?;
    }
    let packing = laboratory.packing(source)?;
    let mut record = task.record(engine)?;
    if let (Some(packing), RunSource::Packing { file, sha256 }) = (&packing, &record.source) {
        let packing = from_packing::describe(file, packing, sha256);
        record.set_packing(case, packing);
    }
    if let Some(text) = estimate::warning(case, *source == Source::Case, task.kind != "prepare") {
        observer.warn(&text);
        record.notes.push(text);
    }
    let run_state = laboratory.start(case, source, packing, &mut record, observer)?;
    Ok(Begun { record, run_state })
}

/// Executes a planned run. The record is written first and contains the case until the file of the case has been written,
/// so that the run can be resumed from the first file on.
///
/// # Errors
/// [`LaboratoryError`]; the record in the folder then has the status `failed`.
pub(crate) fn run(
    task: &Task,
    begun: Begun,
    folder: &RunFolder,
    observer: &mut dyn Observer,
) -> Result<RunRecord, LaboratoryError> {
    let Task { case, laboratory, .. } = *task;
    let Begun { mut record, run_state } = begun;
    record.unwritten_case = Some(case.resolved_toml());
    folder.write_record(&record)?;
    write_case(folder, case, &record)?;
    record.unwritten_case = None;
    finish(folder, &mut record, |record| {
        laboratory.go_on(case, run_state, Store(Some(folder)), record, observer).map(drop)
    })
}

/// Continues a preparation or test that was interrupted, was killed or failed, from its last usable checkpoint, or from the case if
/// there is none yet.
///
/// # Errors
/// [`LaboratoryError`] if the contents of the folder cannot be used, or if the run fails again.
pub(crate) fn resume(
    laboratory: &Laboratory,
    folder: &RunFolder,
    observer: &mut dyn Observer,
) -> Result<RunRecord, LaboratoryError> {
    let run = folder.run().with_vocabulary(&laboratory.registry.vocabulary);
    let case = run.case()?;
    let mut record = run.record()?;
    if !record.is_of(&case) {
        let message = "the case was changed since the run began; run the changed case in another folder";
        return Err(FileError::content(&folder.path().join("case.toml"), message).into());
    }
    let run_state = run_state::last_good(folder, &record, &case, &laboratory.registry, observer)?;
    let changed = changed_files(&run, run_state.as_ref(), observer)?;
    if record.status == RunStatus::Finished && !changed && run_state.as_ref().is_none_or(|s| !s.older) {
        return Ok(record);
    }
    // A run that goes on is past what ended it before.
    record.notes.retain(|note| !note.starts_with(FAILED));
    if record.granum_version != laboratory.version {
        let (old, new) = (&record.granum_version, &laboratory.version);
        let text = format!(
            "started with granum {old} and resumed with {new}: its results may differ in the last digits from those of \
             either version"
        );
        observer.warn(&text);
        record.notes.push(text);
    }
    record.status = RunStatus::Running;
    finish(folder, &mut record, |record| {
        if record.unwritten_case.take().is_some() {
            write_case(folder, &case, record)?;
        }
        let run_state = match run_state {
            Some(run_state) => run_state,
            None => {
                let source = Source::recorded(&record.source)?;
                laboratory.start(&case, &source, None, record, observer)?
            }
        };
        if changed {
            write_curve(Store(Some(folder)), &run_state)?;
        }
        laboratory.go_on(&case, run_state, Store(Some(folder)), record, observer).map(drop)
    })
}

/// Looks at all files of a run that goes on. Those that the run writes again from its state are announced to the observer; the
/// result tells whether there are any.
///
/// # Errors
/// [`LaboratoryError::Damaged`] if a file was changed or removed that the run cannot write again.
fn changed_files(
    run: &Run,
    run_state: Option<&RunState>,
    observer: &mut dyn Observer,
) -> Result<bool, LaboratoryError> {
    let faults = run.faults()?;
    let snapshot = |fault: &Fault| {
        let file = fault.name.strip_prefix("snapshots/")?;
        Some(file.split('.').next().unwrap_or(file).to_string())
    };
    for fault in &faults {
        let lost = snapshot(fault).zip(run_state).is_some_and(|(name, state)| !state.will_write(&name));
        if lost {
            return Err(LaboratoryError::Damaged { what: fault.to_string() });
        }
    }
    for fault in &faults {
        observer.warn(&format!("{fault}; the run writes it again"));
    }
    Ok(!faults.is_empty())
}

/// Calls `work` and writes the record with the resulting status.
fn finish(
    folder: &RunFolder,
    record: &mut RunRecord,
    work: impl FnOnce(&mut RunRecord) -> Result<(), LaboratoryError>,
) -> Result<RunRecord, LaboratoryError> {
    let result = match work(record).and_then(|()| Ok(folder.check_present()?)) {
        // Grains were being placed again: there is no state yet, and `resume` starts from the case.
        Err(LaboratoryError::Preparation(PreparationError::Stopped { .. })) => {
            record.status = RunStatus::Interrupted;
            Ok(())
        }
        result => result,
    };
    match &result {
        Ok(()) if record.status == RunStatus::Running => record.status = RunStatus::Finished,
        Ok(()) => {}
        Err(error) => {
            record.status = RunStatus::Failed;
            record.notes.push(format!("{FAILED}{error}"));
        }
    }
    let written = folder.write_record(record);
    // If both fail, as on a full disk, the first error is reported.
    result?;
    written?;
    Ok(record.clone())
}

impl Laboratory {
    /// Executes one stage after another until the run is complete or the observer stops it.
    pub(crate) fn go_on(
        &self,
        case: &Case,
        mut run_state: RunState,
        store: Store,
        record: &mut RunRecord,
        observer: &mut dyn Observer,
    ) -> Result<RunState, LaboratoryError> {
        run_state.results.case_digest.clone_from(&record.case_digest);
        // This first checkpoint makes the run independent of all files outside its folder.
        save(store, &run_state, record)?;
        let mut speedometer = Speedometer::new();
        let mut saved = Instant::now();
        loop {
            let started = Instant::now();
            let in_test = matches!(run_state.part, RunPart::Test(_));
            speedometer.begin();
            let phase = run_state.phase();
            let segment = match run_state.part {
                RunPart::Preparation(_) => {
                    let source = &record.source;
                    let (next, segment) =
                        self.prepare_on(case, run_state, source, &mut speedometer, observer)?;
                    run_state = next;
                    segment
                }
                RunPart::Sample => {
                    write_sample(store, &run_state)?;
                    if record.kind == "prepare" {
                        return Ok(run_state);
                    }
                    match consolidation::wanted(case) {
                        None => self.begin_test(case, &mut run_state)?,
                        Some(preparation) => {
                            run_state = self.begin_consolidation(case, run_state, &preparation);
                            Segment::GoOn
                        }
                    }
                }
                RunPart::Consolidation(_) => {
                    let (next, segment) = self.consolidate_on(case, run_state, &mut speedometer, observer)?;
                    run_state = next;
                    segment
                }
                RunPart::Consolidated => {
                    write_sample(store, &run_state)?;
                    self.begin_test(case, &mut run_state)?
                }
                RunPart::Test(_) => self.test_on(case, &mut run_state, store, &mut speedometer, observer)?,
            };
            if let Some(phase) = phase {
                *record.wall_seconds.entry(phase.into()).or_default() += started.elapsed().as_secs_f64();
            }
            match segment {
                Segment::Complete => {
                    complete(case, &run_state, store, record, observer)?;
                    return Ok(run_state);
                }
                Segment::GoOn if phase.is_none() => {}
                // A test may have thousands of short stages, and a checkpoint is large.
                Segment::GoOn if in_test && saved.elapsed() < self.checkpoint_every => {}
                Segment::GoOn => {
                    save(store, &run_state, record)?;
                    saved = Instant::now();
                }
                Segment::Stop => {
                    save(store, &run_state, record)?;
                    record.status = RunStatus::Interrupted;
                    return Ok(run_state);
                }
            }
        }
    }
}

/// Writes the state of a run: checkpoint, measurements and record.
fn save(store: Store, run_state: &RunState, record: &mut RunRecord) -> Result<(), LaboratoryError> {
    store.write(|folder| run_state.write(folder))?;
    match &run_state.part {
        RunPart::Test(test) => store.write(|folder| write_record(folder, &test.record()))?,
        RunPart::Preparation(_) | RunPart::Consolidation(_) => write_curve(store, run_state)?,
        RunPart::Sample | RunPart::Consolidated => {}
    }
    run_state.write_into(record);
    store.write(|folder| folder.write_record(record))?;
    Ok(())
}

/// Writes the case; if a packing takes the place of the random insertion, the file names it.
fn write_case(folder: &RunFolder, case: &Case, record: &RunRecord) -> Result<(), LaboratoryError> {
    let packing = record.packing.as_ref().map(|packing| packing.file_name.as_str());
    Ok(folder.write_case(case, packing)?)
}

/// Writes the history of the preparation so far.
fn write_curve(store: Store, run_state: &RunState) -> Result<(), LaboratoryError> {
    let Some(folder) = store.0 else { return Ok(()) };
    if let Some(table) = run_state.results.curve.table()? {
        folder.write_preparation(&table)?;
    }
    Ok(())
}

/// Writes the snapshot of a complete sample, with the history of its preparation.
fn write_sample(store: Store, run_state: &RunState) -> Result<(), LaboratoryError> {
    write_curve(store, run_state)?;
    Ok(store.snapshot(SAMPLE, &run_state.simulation.assembly())?)
}

/// Completes a test: writes the last snapshot, and adds the quality flags and measures to the record.
fn complete(
    case: &Case,
    run_state: &RunState,
    store: Store,
    record: &mut RunRecord,
    observer: &mut dyn Observer,
) -> Result<(), LaboratoryError> {
    let RunPart::Test(test) = &run_state.part else { return Ok(()) };
    let end = run_state.simulation.assembly();
    store.snapshot(END, &end)?;
    save(store, run_state, record)?;
    let seen = test.record();
    let speed_key = case.test_definition().speed_key;
    record.quality.extend(quality::judge(&run_state.simulation, &end, &seen, test, speed_key));
    record.measures.extend(strength::of_test(&seen, test.list(), &test.ends));
    measures::of_oedometers(&seen, test.list(), &mut record.measures);
    record_stages(test, &seen, record, observer);
    if let Some(remark) = quality::remark_on_samples(&test.missed_observations(), speed_key) {
        observer.warn(&remark);
        note(record, remark);
    }
    record.phase.clear();
    Ok(())
}

/// Notes in the record how each stage ended; the observer is warned of a stage that met none of its end conditions. For a test
/// with more than [`MOST_STAGES_NOTED`] stages only these are noted, with the number of the others.
fn record_stages(test: &Test, seen: &Record, record: &mut RunRecord, observer: &mut dyn Observer) {
    let many = test.ends.len() > MOST_STAGES_NOTED;
    let lost_stress = quality::stages_without_stress(seen, &test.ends);
    for (k, end) in test.ends.iter().enumerate() {
        let StageEnd { name, reason, steps, .. } = end;
        let mut text = format!("stage {} ({name}) ended after {steps} steps: {reason}", k + 1);
        if end.servo_error.rms() > 0.0 && lost_stress.get(k) == Some(&true) {
            text.push_str(
                "; the sample lost its stress, so that how well its stresses were held in per cent of p is not judged",
            );
        } else if end.servo_error.rms() > 0.0 {
            let percent = 100.0 * end.servo_error.rms();
            text.push_str(&format!("; its stresses were held within {percent:.2} % of p (root mean square)"));
        }
        if !reason.is_asked_for() {
            let left = test.stages() - test.ends.len();
            let rest =
                if left > 0 { format!("; number of later stages not run: {left}") } else { String::new() };
            observer.warn(&format!("{text}{rest}"));
        } else if many || *steps == 0 || test.list().get(k).is_some_and(quality::is_certain_to_end) {
            // A stage without a step only records the end of the previous one.
            continue;
        }
        note(record, text);
    }
    if many {
        let good = test.ends.iter().filter(|end| end.reason.is_asked_for()).count();
        note(record, format!("{good} of {} stages met one of their end conditions", test.stages()));
    }
}
