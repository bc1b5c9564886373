//! The test itself: the loading path with its recorder.

use granum_core::quantity::format_number;
use granum_dem::path::axisymmetric::AxisymmetricCompression;
use granum_dem::path::{Ending, Watcher, density_scaling, follow, start};
use granum_dem::preparation::{Flow, Progress};
use granum_dem::simulation::{Properties, Simulation};
use granum_io::{Case, RunFolder};
use granum_sensors::Recorder;
use serde::{Deserialize, Serialize};

use super::standing::{Stage, Standing};
use super::{Interval, Laboratory, LaboratoryError, RunObserver, Speedometer, Status, Stretch, quality};

/// What a test remembers beside the state of the simulation.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Test {
    pub(super) recorder: Recorder,
    path: AxisymmetricCompression,
    /// Energy of the sample before the test.
    pub(super) before: quality::Stored,
    /// Deviator strains at which a snapshot is still to be taken.
    #[serde(default)]
    snapshots: Vec<f64>,
}

/// Name of the snapshot at a strain, e.g. `strain-0_05`.
fn snapshot_name(strain: f64) -> String {
    format!("strain-{}", format_number(strain).replace('.', "_"))
}

impl Test {
    /// True if it can be a test of the case: with another end or rate it would perhaps never end.
    pub(super) fn is_of(&self, case: &Case) -> bool {
        let path = &self.path;
        let end = case.shear.deviator_strain;
        let stress = case.shear.mean_stress.unwrap_or(case.preparation.mean_stress);
        self.recorder.is_of(&case.recording, end)
            && (path.deviator_strain, path.mean_stress) == (end, stress)
            && case.recording.snapshots.ends_with(&self.snapshots)
            && path.strain_rate > 0.0
            && path.strain_rate.is_finite()
    }
}

/// Watches a test: lets the recorder look, takes snapshots, reports, stops for a checkpoint.
struct Watch<'a> {
    recorder: &'a mut Recorder,
    snapshots: &'a mut Vec<f64>,
    folder: &'a RunFolder,
    /// Why a snapshot could not be written; the test then stops.
    failed: Option<granum_io::Error>,
    observer: &'a mut dyn RunObserver,
    speedometer: &'a mut Speedometer,
    end: f64,
    interval: Interval,
    stopped: bool,
}

impl Watcher for Watch<'_> {
    fn next_look(&self) -> f64 {
        self.snapshots.first().copied().unwrap_or(f64::INFINITY).min(self.recorder.next_look())
    }
    fn look(&mut self, simulation: &Simulation) {
        let strain = simulation.state().deviator_strain();
        let assembly = simulation.assembly();
        // The recorder may not look earlier for the sake of a snapshot.
        if self.recorder.next_look() <= strain {
            self.recorder.look(&assembly);
        }
        while self.snapshots.first().is_some_and(|due| *due <= strain) {
            let name = snapshot_name(self.snapshots.remove(0));
            if let Err(error) = self.folder.write_snapshot(&name, &assembly) {
                self.failed.get_or_insert(error);
            }
        }
    }
    fn progress(&mut self, progress: &Progress) -> Flow {
        if self.failed.is_some() {
            return Flow::Stop;
        }
        let simulation = progress.simulation;
        self.observer.status(&Status {
            phase: progress.phase,
            trial: 1,
            fraction: Some(simulation.state().deviator_strain() / self.end),
            grain_steps_per_second: self.speedometer.rate(simulation),
            simulation,
        });
        self.stopped = self.observer.stop();
        if self.stopped || self.interval.is_over() { Flow::Stop } else { Flow::Continue }
    }
}

impl Laboratory {
    /// Makes a sample ready to be sheared as the case says.
    pub(super) fn begin_test(
        &self,
        case: &Case,
        standing: &mut Standing,
    ) -> Result<Stretch, LaboratoryError> {
        let simulation = &mut standing.simulation;
        let mut material = case.grains.material;
        material.density *= density_scaling(&case.shear.rate);
        simulation.set_properties(Properties { material, contact: case.contact })?;
        simulation.set_time_step_factor(case.numerics.time_step_factor);
        let path = AxisymmetricCompression::new(&case.shear, simulation, case.preparation.mean_stress);
        start(&path, simulation);
        let test = Test {
            recorder: Recorder::new(&case.recording, case.shear.deviator_strain),
            path,
            before: quality::Stored::of(&simulation.assembly()),
            snapshots: case.recording.snapshots.clone(),
        };
        standing.stage = Stage::Test(Box::new(test));
        Ok(Stretch::GoOn)
    }

    /// Goes on with a test to its end, until a checkpoint is due or the observer stops it.
    pub(super) fn test_on(
        &self,
        standing: &mut Standing,
        folder: &RunFolder,
        speedometer: &mut Speedometer,
        observer: &mut dyn RunObserver,
    ) -> Result<Stretch, LaboratoryError> {
        let Stage::Test(test) = &mut standing.stage else { return Ok(Stretch::GoOn) };
        let simulation = &mut standing.simulation;
        simulation.set_hardware(self.hardware_for(simulation.state().grains()));
        let mut watch = Watch {
            recorder: &mut test.recorder,
            snapshots: &mut test.snapshots,
            folder,
            failed: None,
            observer,
            speedometer,
            end: test.path.deviator_strain,
            interval: Interval::new(self.checkpoint_every),
            stopped: false,
        };
        let ending = follow(&test.path, simulation, &mut watch)?;
        if let Some(error) = watch.failed {
            return Err(error.into());
        }
        Ok(match ending {
            Ending::Complete => Stretch::Complete,
            Ending::Stopped if watch.stopped => Stretch::Stop,
            Ending::Stopped => Stretch::GoOn,
        })
    }
}
