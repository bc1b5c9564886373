//! The test itself: the loading path with its recorder, checkpoints on the way, judgement at the end.

use std::time::{Duration, Instant};

use granum_dem::path::axisymmetric::AxisymmetricCompression;
use granum_dem::path::{Ending, Watcher, density_scaling, follow, start};
use granum_dem::preparation::{Flow, Progress};
use granum_dem::simulation::{Properties, Simulation};
use granum_io::Case;
use granum_io::run::{RunFolder, RunRecord, RunStatus};
use granum_sensors::Recorder;
use serde::{Deserialize, Serialize};

use super::{
    END, Laboratory, LaboratoryError, RunObserver, Speedometer, Status, quality, read_checkpoint,
    write_checkpoint,
};
use crate::files::write_record;

/// Wall time between two checkpoints.
const CHECKPOINT_EVERY: Duration = Duration::from_secs(30);

/// What a test remembers beside the state of the simulation.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Memory {
    recorder: Recorder,
    path: AxisymmetricCompression,
    /// Energy of the sample before the test.
    before: quality::Stored,
    /// Wall time of the test before this stretch, s.
    seconds: f64,
}

/// Watches a test: lets the recorder look, reports, stops for a checkpoint.
struct Watch<'a> {
    recorder: &'a mut Recorder,
    observer: &'a mut dyn RunObserver,
    speedometer: Speedometer,
    end: f64,
    since: Instant,
    stopped: bool,
}

impl Watcher for Watch<'_> {
    fn next_look(&self) -> f64 {
        self.recorder.next_look()
    }
    fn look(&mut self, simulation: &Simulation) {
        self.recorder.look(&simulation.assembly());
    }
    fn progress(&mut self, progress: &Progress) -> Flow {
        let simulation = progress.simulation;
        self.observer.status(&Status {
            phase: progress.phase,
            trial: 1,
            fraction: Some(simulation.state().deviator_strain() / self.end),
            grain_steps_per_second: self.speedometer.rate(simulation),
            simulation,
        });
        self.stopped = self.observer.stop();
        if self.stopped || self.since.elapsed() > CHECKPOINT_EVERY { Flow::Stop } else { Flow::Continue }
    }
}

impl Laboratory {
    /// Shears a sample as the case says.
    pub(super) fn run_test(
        &self,
        case: &Case,
        mut simulation: Simulation,
        folder: &RunFolder,
        record: &mut RunRecord,
        observer: &mut dyn RunObserver,
    ) -> Result<(), LaboratoryError> {
        let mut material = case.grains.material;
        material.density *= density_scaling(&case.shear.rate);
        simulation.set_properties(Properties { material, contact: case.contact })?;
        simulation.set_time_step_factor(case.numerics.time_step_factor);
        let path = AxisymmetricCompression::new(&case.shear, &simulation, case.preparation.mean_stress);
        start(&path, &mut simulation);
        let memory = Memory {
            recorder: Recorder::new(&case.recording, case.shear.deviator_strain),
            path,
            before: quality::Stored::of(&simulation.assembly()),
            seconds: 0.0,
        };
        self.go_on(simulation, memory, folder, record, observer)
    }

    /// Goes on with a test from the checkpoint in its folder.
    pub(super) fn resume_test(
        &self,
        case: &Case,
        folder: &RunFolder,
        record: &mut RunRecord,
        observer: &mut dyn RunObserver,
    ) -> Result<(), LaboratoryError> {
        let (simulation, text) = read_checkpoint(folder.path())?;
        if text == super::sample::SAMPLE_MARK {
            // It was killed before the first checkpoint of the test; the sample is there.
            return self.run_test(case, simulation, folder, record, observer);
        }
        let memory = serde_json::from_str(&text).map_err(|e| LaboratoryError::Checkpoint {
            path: folder.path().join(super::CHECKPOINT),
            what: format!("it is not of a test ({e})"),
        })?;
        self.go_on(simulation, memory, folder, record, observer)
    }

    fn go_on(
        &self,
        mut simulation: Simulation,
        mut memory: Memory,
        folder: &RunFolder,
        record: &mut RunRecord,
        observer: &mut dyn RunObserver,
    ) -> Result<(), LaboratoryError> {
        loop {
            simulation.set_hardware(self.hardware_for(simulation.state().grains()));
            let started = Instant::now();
            let mut watch = Watch {
                recorder: &mut memory.recorder,
                observer,
                speedometer: Speedometer::new(),
                end: memory.path.deviator_strain,
                since: started,
                stopped: false,
            };
            let ending = follow(&memory.path, &mut simulation, &mut watch)?;
            let stopped = watch.stopped;
            memory.seconds += started.elapsed().as_secs_f64();
            record.steps.insert("shear".into(), simulation.state().step());
            record.wall_seconds.insert("shear".into(), memory.seconds);
            if ending == Ending::Complete {
                return self.complete(&simulation, &memory, folder, record);
            }
            write_checkpoint(folder.path(), &simulation, &to_text(&memory))?;
            write_record(folder, &memory.recorder.record())?;
            if stopped {
                record.status = RunStatus::Interrupted;
                return Ok(());
            }
            folder.write_record(record)?;
        }
    }

    fn complete(
        &self,
        simulation: &Simulation,
        memory: &Memory,
        folder: &RunFolder,
        record: &mut RunRecord,
    ) -> Result<(), LaboratoryError> {
        let seen = memory.recorder.record();
        let end = simulation.assembly();
        folder.write_snapshot(END, &end)?;
        write_record(folder, &seen)?;
        write_checkpoint(folder.path(), simulation, &to_text(memory))?;
        record.quality.extend(quality::judge(simulation, &end, &seen, &memory.before));
        Ok(())
    }
}

/// The memory as text. Serialising plain numbers to memory cannot fail; an empty text would be refused when read.
fn to_text(memory: &Memory) -> String {
    serde_json::to_string(memory).unwrap_or_default()
}
