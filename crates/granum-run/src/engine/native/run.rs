//! A run of the engine of granum, which consists of preparation, sample, consolidation (if the mean stress of the test
//! differs from that of the sample) and test. A checkpoint is written between the parts, at intervals of wall time, and
//! when the observer stops the run.

use std::sync::Arc;

use granum_core::clock::Instant;
use granum_dem::loading::StageEnd;
use granum_dem::observer::SimulationObserver;
use granum_io::Case;
use granum_io::run::{FileFault, Run, RunFolder, RunKind, RunRecord, RunSource, RunStatus};
use granum_sensors::Record;

use super::run_state::{self, RunPart, RunState};
use super::sample::note;
use super::segment::Segment;
use super::snapshot_names::{END, SAMPLE};
use super::task_execution::TaskExecution;
use super::test_state::{MOST_STAGES_NOTED, Test};
use super::{consolidation, from_packing, measures, quality};
use crate::engine::engine_run::EngineRun;
use crate::laboratory::{estimate, memory};
use crate::strength;
use crate::task::definition::Task;
use crate::task::laboratory_error::LaboratoryError;
use crate::task::sink::Sink;
use crate::task::source::Source;
use crate::task::status::Speedometer;

/// Reads and checks the inputs of a run, and warns the observer of anything that the user should know. Nothing is written.
///
/// # Errors
/// [`LaboratoryError`] if the case does not fit into memory, or if its sample, packing or sensors cannot be used.
pub(super) fn plan(task: Task, observer: &mut dyn SimulationObserver) -> Result<EngineRun, LaboratoryError> {
    let is_test = task.kind == RunKind::Test;
    let Begun { execution, run_state, record } = begin(&task, is_test, observer)?;
    let case = task.case;
    let run = EngineRun::new(record, move |sink, observer| execution.go_on(&case, run_state, sink, observer));
    Ok(run.saving_first())
}

/// What is left of a run that no longer goes on.
pub(super) enum Left {
    /// Nothing: it is complete, and its state is in the sink.
    Complete,
    /// The observer stopped it in this state.
    Stopped(RunState),
    /// The sample of a test that the caller makes.
    Sample(RunState),
}

/// A run whose inputs have been read and checked.
pub(super) struct Begun {
    pub(super) execution: TaskExecution,
    pub(super) run_state: RunState,
    pub(super) record: RunRecord,
}

/// Reads and checks the inputs of a run; the estimate of its time counts the test if that is to be run here as well.
pub(super) fn begin(
    task: &Task,
    with_test: bool,
    observer: &mut dyn SimulationObserver,
) -> Result<Begun, LaboratoryError> {
    let execution = TaskExecution::new(task);
    let Task { case, source, .. } = task;
    execution.vocabulary.sensors().of_test(&case.recording, case.test_definition().columns)?;
    // The folder of the run is read again from what is written there.
    case.readable_toml(None)?;
    if *source == Source::Case {
        memory::check(case)?;
    }
    let packing = execution.packing(source)?;
    let mut record = task.record()?;
    if let (Some(packing), RunSource::Packing { file, sha256 }) = (&packing, &record.source) {
        let packing = from_packing::describe(file, packing, sha256);
        record.set_packing(case, packing);
    }
    if let Some(text) = estimate::warning(case, *source == Source::Case, with_test) {
        observer.warn(&text);
        record.notes.push(text);
    }
    let run_state = execution.start(case, source, packing, &mut record, observer)?;
    Ok(Begun { execution, run_state, record })
}

/// Reads and checks what is needed to continue a preparation or test from its last usable checkpoint, or from the case if there is
/// none yet; `None` if it is complete and whole.
///
/// # Errors
/// [`LaboratoryError`] if the contents of the folder cannot be used.
pub(super) fn resume(
    task: Task,
    record: RunRecord,
    folder: &RunFolder,
    observer: &mut dyn SimulationObserver,
) -> Result<Option<EngineRun>, LaboratoryError> {
    let execution = TaskExecution::new(&task);
    let case = task.case;
    let run = folder.run().with_vocabulary(&execution.vocabulary);
    let run_state = run_state::last_good(folder, &record, &case, &execution.vocabulary, observer)?;
    let changed = changed_files(&run, run_state.as_ref(), observer)?;
    if record.status == RunStatus::Finished && !changed && run_state.as_ref().is_none_or(|s| !s.older) {
        return Ok(None);
    }
    Ok(Some(EngineRun::new(record, move |sink, observer| {
        let run_state = match run_state {
            Some(run_state) => run_state,
            None => {
                let source = Source::recorded(&sink.record().source)?;
                execution.start(&case, &source, None, sink.record(), observer)?
            }
        };
        if changed {
            write_curve(sink, &run_state)?;
        }
        execution.go_on(&case, run_state, sink, observer)
    })))
}

/// Looks at all files of a run that goes on. Those that the run writes again from its state are announced to the observer; the
/// result tells whether there are any.
///
/// # Errors
/// [`LaboratoryError::Damaged`] if a file was changed or removed that the run cannot write again.
fn changed_files(
    run: &Run,
    run_state: Option<&RunState>,
    observer: &mut dyn SimulationObserver,
) -> Result<bool, LaboratoryError> {
    let faults = run.faults()?;
    let snapshot = |fault: &FileFault| {
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

impl TaskExecution {
    /// Executes one stage after another until the run is complete or the observer stops it.
    pub(crate) fn go_on(
        &self,
        case: &Case,
        run_state: RunState,
        sink: &mut dyn Sink,
        observer: &mut dyn SimulationObserver,
    ) -> Result<(), LaboratoryError> {
        if let Left::Stopped(run_state) = self.go_on_to(case, run_state, false, sink, observer)? {
            sink.keep(Arc::new(run_state.simulation));
        }
        Ok(())
    }

    /// The same; with `sample_only` the test is left to the caller, who gets the sample at the mean stress of the test, unless the
    /// observer stopped the run before. Who gets the state of a run that was stopped can go on with it.
    pub(super) fn go_on_to(
        &self,
        case: &Case,
        mut run_state: RunState,
        sample_only: bool,
        sink: &mut dyn Sink,
        observer: &mut dyn SimulationObserver,
    ) -> Result<Left, LaboratoryError> {
        run_state.results.case_digest.clone_from(&sink.record().case_digest);
        // This first checkpoint makes the run independent of all files outside its folder.
        save(sink, &run_state)?;
        if let RunPart::Test(test) = &run_state.part {
            sink.begin_states(&test.recorded_states())?;
        }
        let mut speedometer = Speedometer::new();
        let mut saved = Instant::now();
        loop {
            let started = Instant::now();
            let in_test = matches!(run_state.part, RunPart::Test(_));
            speedometer.begin();
            let phase = run_state.phase();
            let segment = match run_state.part {
                RunPart::Preparation(_) => {
                    let source = &sink.record().source;
                    let (next, segment) =
                        self.prepare_on(case, run_state, source, &mut speedometer, observer)?;
                    run_state = next;
                    segment
                }
                RunPart::Sample => {
                    write_sample(sink, &run_state)?;
                    if sink.record().kind == RunKind::Sample {
                        run_state.write_into(sink.record());
                        sink.keep(Arc::new(run_state.simulation));
                        return Ok(Left::Complete);
                    }
                    match consolidation::wanted(case) {
                        None if sample_only => {
                            save(sink, &run_state)?;
                            return Ok(Left::Sample(run_state));
                        }
                        None => self.begin_test(case, &mut run_state, sink)?,
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
                    write_sample(sink, &run_state)?;
                    if sample_only {
                        save(sink, &run_state)?;
                        return Ok(Left::Sample(run_state));
                    }
                    self.begin_test(case, &mut run_state, sink)?
                }
                RunPart::Test(_) => self.test_on(case, &mut run_state, sink, &mut speedometer, observer)?,
            };
            if let Some(phase) = phase {
                *sink.record().wall_seconds.entry(phase.into()).or_default() +=
                    started.elapsed().as_secs_f64();
            }
            match segment {
                Segment::Complete => {
                    complete(case, &run_state, sink, observer)?;
                    sink.keep(Arc::new(run_state.simulation));
                    return Ok(Left::Complete);
                }
                Segment::GoOn if phase.is_none() => {}
                // A test may have thousands of short stages, and a checkpoint is large.
                Segment::GoOn if in_test && saved.elapsed() < self.resources.checkpoint_every => {}
                Segment::GoOn => {
                    save(sink, &run_state)?;
                    saved = Instant::now();
                }
                Segment::Stop => {
                    save(sink, &run_state)?;
                    sink.record().status = RunStatus::Interrupted;
                    return Ok(Left::Stopped(run_state));
                }
            }
        }
    }
}

/// Writes the state of a run: checkpoint, measurements and record.
fn save(sink: &mut dyn Sink, run_state: &RunState) -> Result<(), LaboratoryError> {
    run_state.write(sink)?;
    match &run_state.part {
        RunPart::Test(test) => sink.save_measurements(&test.record())?,
        RunPart::Preparation(_) | RunPart::Consolidation(_) => write_curve(sink, run_state)?,
        RunPart::Sample | RunPart::Consolidated => {}
    }
    run_state.write_into(sink.record());
    Ok(sink.save_record()?)
}

/// Writes the history of the preparation so far.
fn write_curve(sink: &mut dyn Sink, run_state: &RunState) -> Result<(), LaboratoryError> {
    if let Some(table) = run_state.results.curve.table()? {
        sink.save_preparation(&table)?;
    }
    Ok(())
}

/// Writes the snapshot of a complete sample, with the history of its preparation.
fn write_sample(sink: &mut dyn Sink, run_state: &RunState) -> Result<(), LaboratoryError> {
    write_curve(sink, run_state)?;
    Ok(sink.save_snapshot(SAMPLE, &run_state.simulation.assembly())?)
}

/// Completes a test: writes the last snapshot, and adds the quality flags and measures to the record.
fn complete(
    case: &Case,
    run_state: &RunState,
    sink: &mut dyn Sink,
    observer: &mut dyn SimulationObserver,
) -> Result<(), LaboratoryError> {
    let RunPart::Test(test) = &run_state.part else { return Ok(()) };
    let end = run_state.simulation.assembly();
    sink.save_snapshot(END, &end)?;
    save(sink, run_state)?;
    let record = sink.record();
    let seen = test.record();
    let speed_key = case.test_definition().speed_key;
    record.quality.extend(quality::judge(&run_state.simulation, &end, &seen, test, speed_key));
    record.measures.extend(strength::of_test(&seen, test.list(), &test.ends));
    record.measures.extend(strength::cohesion_of(case));
    measures::of_oedometers(&seen, test.list(), &test.stage_ends, &mut record.measures);
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
fn record_stages(test: &Test, seen: &Record, record: &mut RunRecord, observer: &mut dyn SimulationObserver) {
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
        if quality::is_liquefied_end(test.list(), k, end) {
            text.push_str("; the sample has liquefied, which is the result of this undrained test");
        } else if !reason.is_asked_for() {
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
