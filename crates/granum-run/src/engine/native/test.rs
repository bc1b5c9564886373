//! The test of a sample: its stages one after another.

use std::cell::RefCell;

use granum_core::observer::Event;
use granum_dem::loading::{self, Ending, StageEnd};
use granum_dem::observer::{SimulationObserver, SimulationObservers};
use granum_io::Case;
use granum_io::run::StageEndRecord;

use super::follow::{self, Follow, Outlet, Snapshots, stage_snapshot};
use super::pace::Interval;
use super::run_state::{RunPart, RunState};
use super::segment::Segment;
use super::task_execution::TaskExecution;
use super::test_state::{MOST_STAGES_NOTED, Test};
use crate::strength::symmetry;
use crate::task::laboratory_error::LaboratoryError;
use crate::task::sink::Sink;
use crate::task::status::Speedometer;

impl TaskExecution {
    /// Prepares a sample for the test that the case defines.
    pub(super) fn begin_test(
        &self,
        case: &Case,
        run_state: &mut RunState,
        sink: &mut dyn Sink,
    ) -> Result<Segment, LaboratoryError> {
        sink.begin_states(&[])?;
        let simulation = &mut run_state.simulation;
        let density_scaling = case.test_definition().initial_density_scaling;
        simulation.set_properties(case.properties().with_densities(density_scaling))?;
        simulation.set_time_step_factor(case.numerics.time_step_factor);
        run_state.part = RunPart::Test(Box::new(Test::begin(case, self.vocabulary.sensors(), simulation)?));
        Ok(Segment::GoOn)
    }

    /// Continues a test until the end of its stage, until a checkpoint is due, or until the observer stops it.
    pub(super) fn test_on(
        &self,
        case: &Case,
        run_state: &mut RunState,
        sink: &mut dyn Sink,
        speedometer: &mut Speedometer,
        observer: &mut dyn SimulationObserver,
    ) -> Result<Segment, LaboratoryError> {
        let RunPart::Test(test) = &mut run_state.part else { return Ok(Segment::GoOn) };
        let simulation = &mut run_state.simulation;
        let at = test.ends.len();
        if test.recorders.len() == at {
            // The last stage is complete, or a stage ended without meeting an end condition.
            return Ok(Segment::Complete);
        }
        let (Some(stage), Some(recorder)) = (test.stages.get(at), test.recorders.last_mut()) else {
            return Ok(Segment::Complete);
        };
        simulation.set_hardware(self.resources.hardware_for(simulation.state().grains()));
        observer.stage(at + 1);
        let outlet = Outlet { sink: RefCell::new(sink), observer: RefCell::new(observer) };
        let before = test.stage_progress.clone();
        let mut follow = Follow {
            observer: &outlet.observer,
            speedometer,
            checkpoint: Interval::new(self.resources.checkpoint_every),
            stage: Some(&stage.name),
            axis: symmetry::axis(std::slice::from_ref(stage)),
            place: [at, test.stages.len()],
            stopped: false,
        };
        let mut record = follow::StageRecording::new(recorder, at + 1, test.columns, &outlet);
        let mut snapshots = Snapshots {
            due: &mut test.snapshots,
            measure: stage.record.measure,
            stage_progress: &before,
            outlet: &outlet,
            failed: None,
        };
        let mut observers = SimulationObservers(vec![&mut record, &mut snapshots, &mut follow]);
        let ending = loading::follow(stage, &mut test.stage_progress, simulation, &mut observers)?;
        let stopped = follow.stopped;
        if matches!(ending, Ending::Complete(_)) {
            record.end();
        }
        if let Some(error) = record.failed.or(snapshots.failed) {
            return Err(error.into());
        }
        let reason = match ending {
            Ending::Complete(reason) => reason,
            Ending::Stopped if stopped => return Ok(Segment::Stop),
            Ending::Stopped => return Ok(Segment::GoOn),
        };
        let end = StageEnd::new(stage, &test.stage_progress, reason, simulation);
        let (number, name) = (at + 1, end.name.clone());
        let (steps, reason_text) = (end.steps, reason.to_string());
        let ended = Event::StageEnded { number, name, steps, reason: reason_text };
        outlet.observer.borrow_mut().event(&ended);
        let state_there = StageEndRecord::new(number, &end, &simulation.assembly());
        state_there.add_to(&mut test.stage_ends, test.stages.len());
        test.ends.push(end);
        // After a stage that met none of its end conditions, the following stages would not start from the intended state.
        if !reason.is_asked_for() || test.ends.len() == test.stages.len() {
            return Ok(Segment::Complete);
        }
        if test.stages.len() <= MOST_STAGES_NOTED {
            outlet
                .sink
                .borrow_mut()
                .save_snapshot(&stage_snapshot(test.ends.len()), &simulation.assembly())?;
        }
        test.begin_stage(case, self.vocabulary.sensors(), simulation)?;
        Ok(Segment::GoOn)
    }
}
