//! A run of granum's own engine, part after part: preparation, sample, consolidation (where the test is at another mean stress
//! than the sample), test. It is written down between the parts, as a checkpoint at an interval of wall time, and when the
//! observer stops it.

use std::time::Instant;

use granum_dem::loading::StageEnd;
use granum_dem::observer::Observer;
use granum_io::run::{RunFolder, RunRecord, RunSource, RunStatus};
use granum_io::{Case, Error as FileError};

use super::run_state::{self, RunState, Stage};
use super::{
    END, Laboratory, LaboratoryError, SAMPLE, Segment, Source, Speedometer, Store, Test, consolidation,
    from_packing, measures, memory, quality, test,
};
use crate::engine::{Engine, Task};
use crate::record::write_record;

/// A run that was begun and of which nothing is written yet.
pub(crate) struct Begun {
    pub(super) record: RunRecord,
    pub(super) run_state: RunState,
}

/// Reads what a run begins with and refuses what cannot be run. Nothing is written. The observer is told what the user should
/// know of it.
///
/// # Errors
/// [`LaboratoryError`] if the machine cannot hold the case, or its sample, packing or sensors cannot be used.
pub(crate) fn begin(
    task: &Task,
    engine: &dyn Engine,
    observer: &mut dyn Observer,
) -> Result<Begun, LaboratoryError> {
    let Task { case, source, laboratory, .. } = *task;
    laboratory.sensors.of_test(&case.recording, case.has_stages())?;
    if *source == Source::Case {
        memory::check(case)?;
    }
    let packing = laboratory.packing(source)?;
    let mut record = task.record(engine)?;
    if let (Some(packing), RunSource::Packing { file, sha256 }) = (&packing, &record.source) {
        let packing = from_packing::describe(file, packing, sha256);
        record.set_packing(case, packing);
    }
    let run_state = laboratory.start(case, source, packing, &mut record, observer)?;
    Ok(Begun { record, run_state })
}

/// Runs from a beginning to the end. The record goes first and holds the case until that has its own file: from then
/// on the run can be resumed.
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

/// Goes on with a preparation or test that was interrupted, killed or failed: from its last good checkpoint, or from
/// the case if there is none yet.
///
/// # Errors
/// [`LaboratoryError`] if what is there cannot be used, or it fails again.
pub(crate) fn resume(
    laboratory: &Laboratory,
    folder: &RunFolder,
    observer: &mut dyn Observer,
) -> Result<RunRecord, LaboratoryError> {
    let run = folder.run();
    let case = run.case()?;
    let mut record = run.record()?;
    if !record.is_of(&case) {
        let message = "the case was changed since the run began; run the changed case anew in another folder";
        return Err(FileError::content(&folder.path().join("case.toml"), message).into());
    }
    let run_state = run_state::last_good(folder, &case, &laboratory.sensors, observer)?;
    if record.status == RunStatus::Finished && run_state.as_ref().is_none_or(|s| !s.older) {
        return Ok(record);
    }
    if record.granum_version != laboratory.version {
        let (old, new) = (&record.granum_version, &laboratory.version);
        let text = format!(
            "begun by granum {old} and resumed by {new}: its results may differ in the last digits from those of either version"
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
        laboratory.go_on(&case, run_state, Store(Some(folder)), record, observer).map(drop)
    })
}

/// Does the work and writes the record with the status that it came to.
fn finish(
    folder: &RunFolder,
    record: &mut RunRecord,
    work: impl FnOnce(&mut RunRecord) -> Result<(), LaboratoryError>,
) -> Result<RunRecord, LaboratoryError> {
    let result = work(record);
    match &result {
        Ok(()) if record.status == RunStatus::Running => record.status = RunStatus::Finished,
        Ok(()) => {}
        Err(error) => {
            record.status = RunStatus::Failed;
            record.notes.push(format!("failed: {error}"));
        }
    }
    let written = folder.write_record(record);
    // Of two errors the first is the one to tell: a full disk fails twice.
    result?;
    written?;
    Ok(record.clone())
}

impl Laboratory {
    /// Goes from stage to stage until the run is complete or the observer stops it.
    pub(super) fn go_on(
        &self,
        case: &Case,
        mut run_state: RunState,
        store: Store,
        record: &mut RunRecord,
        observer: &mut dyn Observer,
    ) -> Result<RunState, LaboratoryError> {
        // At once, so that nothing outside the folder is needed from here on.
        save(store, &run_state, record)?;
        let mut speedometer = Speedometer::new();
        loop {
            let started = Instant::now();
            speedometer.begin();
            let phase = run_state.phase();
            let segment = match run_state.stage {
                Stage::Preparation(_) => {
                    let source = &record.source;
                    let (next, segment) =
                        self.prepare_on(case, run_state, source, &mut speedometer, observer)?;
                    run_state = next;
                    segment
                }
                Stage::Sample => {
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
                Stage::Consolidation(_) => {
                    let (next, segment) = self.consolidate_on(case, run_state, &mut speedometer, observer)?;
                    run_state = next;
                    segment
                }
                Stage::Consolidated => {
                    write_sample(store, &run_state)?;
                    self.begin_test(case, &mut run_state)?
                }
                Stage::Test(_) => self.test_on(case, &mut run_state, store, &mut speedometer, observer)?,
            };
            if let Some(phase) = phase {
                *record.wall_seconds.entry(phase.into()).or_default() += started.elapsed().as_secs_f64();
            }
            match segment {
                Segment::Complete => {
                    complete(&run_state, store, record, observer)?;
                    return Ok(run_state);
                }
                Segment::GoOn if phase.is_none() => {}
                Segment::GoOn => save(store, &run_state, record)?,
                Segment::Stop => {
                    save(store, &run_state, record)?;
                    record.status = RunStatus::Interrupted;
                    return Ok(run_state);
                }
            }
        }
    }
}

/// Writes down where a run stands: checkpoint, what the sensors saw, record.
fn save(store: Store, run_state: &RunState, record: &mut RunRecord) -> Result<(), LaboratoryError> {
    store.write(|folder| run_state.write(folder))?;
    match &run_state.stage {
        Stage::Test(test) => store.write(|folder| write_record(folder, &test.record()))?,
        Stage::Preparation(_) | Stage::Consolidation(_) => write_curve(store, run_state)?,
        Stage::Sample | Stage::Consolidated => {}
    }
    run_state.write_into(record);
    store.write(|folder| folder.write_record(record))?;
    Ok(())
}

/// Writes the case; a packing in place of the random insertion is named in it.
fn write_case(folder: &RunFolder, case: &Case, record: &RunRecord) -> Result<(), LaboratoryError> {
    let packing = record.packing.as_ref().map(|packing| packing.file_name.as_str());
    Ok(folder.write_case(case, packing)?)
}

/// Writes how the sample was come by, as far as it is.
fn write_curve(store: Store, run_state: &RunState) -> Result<(), LaboratoryError> {
    let Some(folder) = store.0 else { return Ok(()) };
    if let Some(table) = run_state.results.curve.table()? {
        folder.write_preparation(&table)?;
    }
    Ok(())
}

/// Writes a sample that is there.
fn write_sample(store: Store, run_state: &RunState) -> Result<(), LaboratoryError> {
    write_curve(store, run_state)?;
    Ok(store.snapshot(SAMPLE, &run_state.simulation.assembly())?)
}

/// The end of a test: last snapshot, judgement.
fn complete(
    run_state: &RunState,
    store: Store,
    record: &mut RunRecord,
    observer: &mut dyn Observer,
) -> Result<(), LaboratoryError> {
    let Stage::Test(test) = &run_state.stage else { return Ok(()) };
    let end = run_state.simulation.assembly();
    store.snapshot(END, &end)?;
    save(store, run_state, record)?;
    let seen = test.record();
    record.quality.extend(quality::judge(&run_state.simulation, &end, &seen, test));
    measures::of_test(&seen, &mut record.measures);
    if test.staged {
        measures::of_oedometers(&seen, test.list(), &mut record.measures);
        record_stages(test, record, observer);
    }
    if let Some(remark) = quality::remark_on_samples(&test.shortfall()) {
        observer.warn(&remark);
        record.notes.push(remark);
    }
    record.phase.clear();
    Ok(())
}

/// Writes down how each stage ended; a stage that did not come to its end is told at once. Of a test of very many stages only
/// those, and the number of the others.
fn record_stages(test: &Test, record: &mut RunRecord, observer: &mut dyn Observer) {
    let many = test.ends.len() > test::STAGES_TOLD;
    for (k, end) in test.ends.iter().enumerate() {
        let StageEnd { name, reason, steps, .. } = end;
        let mut note = format!("stage {} ({name}) ended after {steps} steps: {reason}", k + 1);
        if end.servo_error.rms() > 0.0 {
            let percent = 100.0 * end.servo_error.rms();
            note.push_str(&format!("; its stresses were held within {percent:.2} % of p (root mean square)"));
        }
        if !reason.is_asked_for() {
            let left = test.stages() - test.ends.len();
            let rest =
                if left > 0 { format!("; the {left} stages after it were not run") } else { String::new() };
            observer.warn(&format!("{note}{rest}"));
        } else if many || *steps == 0 {
            // A stage without a step only records where the one before it came to.
            continue;
        }
        record.notes.push(note);
    }
    if many {
        let good = test.ends.iter().filter(|end| end.reason.is_asked_for()).count();
        record.notes.push(format!("{good} of {} stages came to an end that was asked for", test.stages()));
    }
}
