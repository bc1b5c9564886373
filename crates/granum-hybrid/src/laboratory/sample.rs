//! Samples: prepared from a gas, taken from a folder, or made of another program's packing.

use std::path::PathBuf;
use std::time::Instant;

use granum_dem::cell::Cell;
use granum_dem::preparation::{Flow, PreparationError, Progress, Recipe, Sample, prepare, settle};
use granum_dem::simulation::{Properties, Simulation, Site};
use granum_io::Case;
use granum_io::run::{Run, RunFolder, RunRecord, RunStatus};
use granum_io::{Packing, run};

use super::{
    Laboratory, LaboratoryError, RunObserver, SAMPLE, Speedometer, Status, read_checkpoint, write_checkpoint,
};

/// Text beside the state in the checkpoint of a sample.
pub(super) const SAMPLE_MARK: &str = "sample";

/// Where a sample comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// It is prepared as the case says.
    Case,
    /// It is the one that `granum prepare` left in a folder.
    Folder(PathBuf),
    /// A packing file; it has no contact history and is brought to rest at the case's mean stress.
    Packing(PathBuf),
}

impl Laboratory {
    /// A sample at rest; `None` if the observer stopped it.
    pub(super) fn make_sample(
        &self,
        case: &Case,
        source: &Source,
        folder: &RunFolder,
        record: &mut RunRecord,
        observer: &mut dyn RunObserver,
    ) -> Result<Option<Simulation>, LaboratoryError> {
        let started = Instant::now();
        let simulation = match source {
            Source::Folder(path) => self.take_sample(case, path, record)?,
            Source::Case | Source::Packing(_) => {
                let made = self.make(case, source, observer);
                record.wall_seconds.insert("prepare".into(), started.elapsed().as_secs_f64());
                match made {
                    Err(LaboratoryError::Preparation(PreparationError::Stopped { phase })) => {
                        record.status = RunStatus::Interrupted;
                        record.notes.push(format!("interrupted during {}; run it again", phase.name()));
                        return Ok(None);
                    }
                    Err(error) => return Err(error),
                    Ok(sample) => {
                        note_sample(case, &sample, record);
                        sample.simulation
                    }
                }
            }
        };
        measure_sample(&simulation, record);
        folder.write_snapshot(SAMPLE, &simulation.assembly())?;
        write_checkpoint(folder.path(), &simulation, SAMPLE_MARK)?;
        folder.write_record(record)?;
        Ok(Some(simulation))
    }

    fn make(
        &self,
        case: &Case,
        source: &Source,
        observer: &mut dyn RunObserver,
    ) -> Result<Sample, LaboratoryError> {
        let recipe = Recipe {
            grains: &case.grains,
            contact: &case.contact,
            preparation: &case.preparation,
            time_step_factor: case.numerics.time_step_factor,
            hardware: self.hardware_for(case.grains.count),
        };
        let mut speedometer = Speedometer::new();
        let mut watch = |p: &Progress| {
            let grain_steps_per_second = speedometer.rate(p.simulation);
            let fraction = None;
            observer.status(&Status {
                phase: p.phase,
                trial: p.trial,
                fraction,
                grain_steps_per_second,
                simulation: p.simulation,
            });
            if observer.stop() { Flow::Stop } else { Flow::Continue }
        };
        match source {
            Source::Packing(path) => {
                let packing = Packing::read(path)?;
                let properties = Properties { material: case.grains.material, contact: case.contact };
                let simulation = Simulation::new(cell(&packing), &sites(&packing), properties)?;
                Ok(settle(simulation, &recipe, &mut watch)?)
            }
            _ => Ok(prepare(&recipe, &mut watch)?),
        }
    }

    /// The sample of another folder.
    fn take_sample(
        &self,
        case: &Case,
        path: &PathBuf,
        record: &mut RunRecord,
    ) -> Result<Simulation, LaboratoryError> {
        let other = Run::at(path)?.record()?;
        let (simulation, mark) = read_checkpoint(path)?;
        let bad = |what: &str| LaboratoryError::Checkpoint {
            path: path.join(super::CHECKPOINT),
            what: what.to_string(),
        };
        if mark != SAMPLE_MARK {
            return Err(bad(
                "it is a test in progress, not a sample; give a folder made by `granum prepare`",
            ));
        }
        if other.preparation_digest != case.preparation_digest() {
            return Err(bad(
                "the sample was prepared for other grains, contact law or preparation than this case asks for; prepare it anew",
            ));
        }
        record.grains = other.grains;
        record.steps.extend(other.steps);
        record.wall_seconds.extend(other.wall_seconds);
        record.measures.extend(other.measures);
        record.notes.extend(other.notes);
        Ok(simulation)
    }
}

/// The cell of a packing, its corner at the origin.
pub fn cell(packing: &Packing) -> Cell {
    Cell { edges: packing.cell }
}

/// The grains of a packing, from the corner of its cell.
pub fn sites(packing: &Packing) -> Vec<Site> {
    packing
        .grains
        .iter()
        .map(|g| Site { id: g.id, position: packing.from_corner(g), radius: g.radius })
        .collect()
}

/// How the sample was come by.
fn note_sample(case: &Case, sample: &Sample, record: &mut RunRecord) {
    let p = &case.preparation;
    record.grains = sample.simulation.state().grains();
    record.steps.insert("prepare".into(), sample.steps);
    record.measures.insert("sample_unbalanced_force".into(), sample.unbalanced_force);
    if let Some(trial) = sample.trials.last() {
        record.measures.insert("preparation_friction".into(), trial.friction);
        record.measures.insert("preparation_trials".into(), sample.trials.len() as f64);
    }
    record.quality.push(run::QualityFlag::at_most(
        "sample_unbalanced_force",
        sample.unbalanced_force,
        p.unbalanced_force,
        "the sample did not come to rest; raise preparation.unbalanced_force or lower preparation.inertial_number",
    ));
    if let Some(target) = p.solid_fraction {
        let missed = (sample.simulation.state().solid_fraction() - target).abs();
        record.quality.push(run::QualityFlag::at_most(
            "solid_fraction_missed_by",
            missed,
            p.solid_fraction_tolerance,
            "this solid fraction is out of reach of the preparation friction; ask for another or drop preparation.solid_fraction",
        ));
    }
}

/// The sample as it stands before the test.
fn measure_sample(simulation: &Simulation, record: &mut RunRecord) {
    let row = granum_sensors::measure_row(&simulation.assembly());
    for name in [
        "solid_fraction",
        "coordination_number",
        "mechanical_coordination_number",
        "compressive_coordination_number",
        "backbone_coordination_number",
        "rattler_fraction",
        "mean_stress",
        "stress_ratio",
        "deviator_fabric",
    ] {
        if let Some(k) = granum_sensors::column_index(name) {
            record.measures.insert(name.to_string(), row[k]);
        }
    }
}
