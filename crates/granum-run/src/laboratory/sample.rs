//! Samples: prepared from a loose random state, read from a folder, or made from the packing of another program.

use std::path::{Path, PathBuf};

use granum_core::cell::Cell;
use granum_dem::config::Preparation;
use granum_dem::observer::{Flow, Observer, Observers, Progress};
use granum_dem::preparation::{Outcome, Phase, Preparing, Recipe, Sample};
use granum_dem::simulation::{InitialSphere, Properties, Simulation};
use granum_io::case::{decides_sample, differences};
use granum_io::run::{Run, RunRecord, RunSource};
use granum_io::shell::quoted_path;
use granum_io::{Case, Packing, run};
use granum_sensors::Sensors;

use super::preparation_curve::PreparationCurve;
use super::run_state::{RunResults, RunState, Stage};
use super::{
    CHECKPOINT, Interval, Laboratory, LaboratoryError, PREVIOUS_CHECKPOINT, Segment, Speedometer,
    from_packing, memory, quality,
};
use crate::laboratory::follow::Follow;

/// The source of a sample.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// It is prepared as the case specifies.
    Case,
    /// It is read from the folder that `granum prepare` wrote.
    Folder(PathBuf),
    /// It is made from a packing file, which has no contact history. A loose packing is compacted as the case specifies; one
    /// that already carries its load is only brought to rest at the mean stress of the case.
    Packing(PathBuf),
}

impl Source {
    /// The source for the record of a run, with absolute paths, so that the run can be resumed from any working directory.
    pub(crate) fn record(&self) -> Result<RunSource, LaboratoryError> {
        let absolute = |path: &PathBuf| {
            std::path::absolute(path).map_err(granum_io::Error::file("find the folder of", path))
        };
        Ok(match self {
            Source::Case => RunSource::Case,
            Source::Folder(path) => RunSource::Sample(absolute(path)?),
            Source::Packing(path) => {
                RunSource::Packing { file: absolute(path)?, sha256: run::file_digest(path)? }
            }
        })
    }

    /// The source that a record names. A packing file that is missing or was changed is refused, since it would give another
    /// sample.
    pub(super) fn recorded(source: &RunSource) -> Result<Source, LaboratoryError> {
        match source {
            RunSource::Case => Ok(Source::Case),
            RunSource::Sample(path) => Ok(Source::Folder(path.clone())),
            RunSource::Packing { file, sha256 } => {
                if run::file_digest(file)? != *sha256 {
                    let message =
                        "was changed since the run began, and there is no checkpoint of it yet; run it anew";
                    return Err(granum_io::Error::content(file, message).into());
                }
                Ok(Source::Packing(file.clone()))
            }
        }
    }
}

impl Laboratory {
    /// The initial state of a run. A packing that has already been read can be passed in.
    pub(super) fn start(
        &self,
        case: &Case,
        source: &Source,
        packing: Option<Packing>,
        record: &mut RunRecord,
        observer: &mut dyn Observer,
    ) -> Result<RunState, LaboratoryError> {
        let recipe = self.recipe(case, &case.preparation, case.grains.count);
        let preparing = match source {
            Source::Folder(path) => return take_sample(case, path, &self.sensors, record),
            Source::Case => {
                if let Some(remark) = remark_on_sizes(case) {
                    note(record, remark);
                }
                Preparing::new(&recipe)?
            }
            Source::Packing(path) => {
                let packing = packing.map_or_else(|| self.formats.read_packing(path), Ok)?;
                let (preparing, why_not) = from_packing::begin(&packing, &recipe)?;
                for remark in from_packing::remarks(case, path, why_not.as_deref()) {
                    observer.warn(&remark);
                    note(record, remark);
                }
                preparing
            }
        };
        Ok(RunState::new(preparing.simulation, Stage::Preparation(preparing.progress)))
    }

    pub(super) fn recipe<'a>(
        &self,
        case: &'a Case,
        preparation: &'a Preparation,
        grains: usize,
    ) -> Recipe<'a> {
        Recipe {
            grains: &case.grains,
            contact: &case.contact,
            preparation,
            time_step_factor: case.numerics.time_step_factor,
            hardware: self.hardware_for(grains),
        }
    }

    /// Continues a preparation until the sample is complete, until a checkpoint is due, or until the observer stops it.
    pub(super) fn prepare_on(
        &self,
        case: &Case,
        run_state: RunState,
        source: &RunSource,
        speedometer: &mut Speedometer,
        observer: &mut dyn Observer,
    ) -> Result<(RunState, Segment), LaboratoryError> {
        // The state is passed by value, because memory may not hold a large simulation twice.
        let RunState { simulation, stage, mut results, older } = run_state;
        let Stage::Preparation(progress) = stage else {
            return Ok((RunState { simulation, stage, results, older }, Segment::GoOn));
        };
        let compacted = progress.friction().is_some();
        let recipe = self.recipe(case, &case.preparation, results.grains);
        let preparing = Preparing { simulation, progress };
        let (outcome, stopped) =
            self.compress(preparing, &recipe, &mut results.curve, speedometer, observer)?;
        let (simulation, stage) = match outcome {
            Outcome::Stopped(at) => (at.simulation, Stage::Preparation(at.progress)),
            Outcome::Again(next) => {
                let preparing = from_packing::again(&self.formats, source, &recipe, next)?;
                (preparing.simulation, Stage::Preparation(preparing.progress))
            }
            Outcome::Sample(sample) => {
                results.curve.end(&sample, Phase::Relaxation);
                note_sample(case, &sample, compacted, &mut results);
                measure_sample(&sample.simulation, &mut results);
                (sample.simulation, Stage::Sample)
            }
        };
        let segment = if stopped { Segment::Stop } else { Segment::GoOn };
        Ok((RunState { simulation, stage, results, older }, segment))
    }

    /// Continues a preparation or consolidation, and returns whether the observer stopped it.
    pub(super) fn compress(
        &self,
        preparing: Preparing,
        recipe: &Recipe,
        curve: &mut PreparationCurve,
        speedometer: &mut Speedometer,
        observer: &mut dyn Observer,
    ) -> Result<(Outcome, bool), LaboratoryError> {
        let mut note = |progress: &Progress| {
            curve.observe(progress);
            Flow::Continue
        };
        let mut follow = Follow {
            observer,
            speedometer,
            checkpoint: Interval::new(self.checkpoint_every),
            stage: None,
            place: [0, 1],
            stopped: false,
        };
        let outcome = preparing.go_on(recipe, &mut Observers(vec![&mut note, &mut follow]))?;
        // A stop that is requested while the sample becomes complete takes effect in the next segment.
        let stopped = follow.stopped && matches!(outcome, Outcome::Stopped(_));
        Ok((outcome, stopped))
    }
}

/// Adds a note unless the record has it already: a run that was killed before its first checkpoint starts again with the
/// record of the first attempt.
fn note(record: &mut RunRecord, text: String) {
    if !record.notes.contains(&text) {
        record.notes.push(text);
    }
}

/// Reads the sample of another folder.
fn take_sample(
    case: &Case,
    path: &Path,
    sensors: &Sensors,
    record: &mut RunRecord,
) -> Result<RunState, LaboratoryError> {
    let folder = Run::at(path)?;
    let other = folder.record()?;
    let checkpoint = path.join(CHECKPOINT);
    let bad = |what: String| LaboratoryError::Checkpoint { path: checkpoint.clone(), what };
    let name = quoted_path(path);
    if other.preparation_digest != case.preparation_digest_with(other.packing_digest()) {
        return Err(bad(format!(
            "the sample was prepared with other values than this case has: {}; prepare another sample, or change the case",
            in_what(&folder.case()?, case)
        )));
    }
    let run_state = match RunState::read(&checkpoint, None, sensors) {
        Ok(Some(run_state)) => run_state,
        Ok(None) => return Err(bad(format!("there is none; `granum resume {name}` makes the sample"))),
        Err(LaboratoryError::Checkpoint { what, .. }) if path.join(PREVIOUS_CHECKPOINT).is_file() => {
            return Err(bad(format!("{what}; `granum resume {name}` makes it again from the one before")));
        }
        Err(error) => return Err(error),
    };
    match run_state.stage {
        Stage::Sample => {
            record.wall_seconds.extend(other.wall_seconds);
            other.notes.into_iter().for_each(|text| note(record, text));
            if let Some(packing) = other.packing {
                record.set_packing(case, packing);
            }
            Ok(run_state)
        }
        Stage::Preparation(_) => {
            Err(bad(format!("its preparation is not finished; continue it with `granum resume {name}`")))
        }
        Stage::Consolidation(_) | Stage::Consolidated | Stage::Test(_) => {
            Err(bad("this is the folder of a test, not of a sample; give a folder made by `granum prepare`"
                .into()))
        }
    }
}

/// The differences between a case and that of a sample, among the keys that determine the sample.
fn in_what(sample: &Case, case: &Case) -> String {
    let found = differences(&[("the sample", &sample.values()), ("the case", &case.values())]);
    let keys: Vec<String> =
        found.iter().filter(|found| decides_sample(&found.key)).map(ToString::to_string).collect();
    keys.join("; ")
}

/// Largest ratio of the radii in a packing. The search for neighbours uses the size of the largest grain, and its skin must
/// not contain a large number of the smallest grains.
const WIDEST_RADII: f64 = 100.0;
/// Largest ratio of an edge of the cell to the largest radius, sufficient for 10^9 grains.
const WIDEST_CELL: f64 = 1e5;

/// The grains of a packing at rest, with the forces of their geometry.
///
/// # Errors
/// If the memory does not suffice, if the radii differ too much or the cell is too large for them, or as
/// [`Simulation::new`].
pub fn simulation(packing: &Packing, properties: Properties) -> Result<Simulation, LaboratoryError> {
    memory::check_grains(packing.grains.len())?;
    let radii = packing.grains.iter().map(|grain| grain.radius);
    let (smallest, largest) = radii.fold((f64::INFINITY, 0.0f64), |(a, b), r| (a.min(r), b.max(r)));
    if largest > WIDEST_RADII * smallest {
        return Err(LaboratoryError::Packing(format!(
            "its radii go from {smallest:e} m to {largest:e} m; the largest can be at most {WIDEST_RADII} times the smallest"
        )));
    }
    let edge = packing.cell.iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
    if edge >= WIDEST_CELL * largest {
        return Err(LaboratoryError::Packing(format!(
            "its cell has an edge of {edge:e} m, but its largest grain a radius of {largest:e} m; at most {WIDEST_CELL:e} times that \
             is possible"
        )));
    }
    let (cell, spheres) = (cell(packing), spheres(packing));
    match materials(packing, &properties)? {
        Some(materials) => Ok(Simulation::of_materials(cell, &spheres, &materials, properties)?),
        None => Ok(Simulation::new(cell, &spheres, properties)?),
    }
}

/// The material of each grain as the packing names it, where it does and there are several to choose from; else it is drawn.
fn materials(packing: &Packing, properties: &Properties) -> Result<Option<Vec<u8>>, LaboratoryError> {
    let mixture = &properties.mixture;
    if mixture.is_empty() || packing.materials.of.is_empty() {
        return Ok(None);
    }
    let place = |grain: usize| {
        let name = packing.materials.name(grain).unwrap_or_default();
        mixture.position(name).map(|place| place as u8).ok_or_else(|| {
            let known: Vec<&str> = mixture.components.iter().map(|c| c.name.as_str()).collect();
            LaboratoryError::Packing(format!(
                "its grain {} is of {name:?}, but the case has the materials {}; give it a table [[material]] with this name",
                packing.grains[grain].id,
                known.join(", ")
            ))
        })
    };
    (0..packing.grains.len()).map(place).collect::<Result<_, _>>().map(Some)
}

/// The cell of a packing, with its corner moved to the origin.
pub fn cell(packing: &Packing) -> Cell {
    Cell { edges: packing.cell }
}

/// The grains of a packing, with positions relative to the corner of its cell.
pub fn spheres(packing: &Packing) -> Vec<InitialSphere> {
    packing
        .grains
        .iter()
        .map(|g| InitialSphere { id: g.id, position: packing.from_corner(g), radius: g.radius })
        .collect()
}

/// A sentence about the sizes of the grains where they are not those of `grains.spread`.
fn remark_on_sizes(case: &Case) -> Option<String> {
    let grains = &case.grains;
    if grains.sizes.is_standard() {
        return None;
    }
    let ([smallest, largest], mean) = (grains.size_range().ok()?, grains.mean_diameter().ok()?);
    let left_out = grains.mass_left_out().filter(|share| *share > 1e-9).map_or_else(String::new, |share| {
        format!(
            "; {:.2} % of the mass of the sieve curve lies outside of them and is left out",
            100.0 * share
        )
    });
    let name = grains.sizes.distribution.name();
    Some(format!(
        "the diameters of the grains ({name}) go from {:.4} mm to {:.4} mm with a mean of {:.4} mm{left_out}",
        1e3 * smallest,
        1e3 * largest,
        1e3 * mean
    ))
}

/// Records how the sample was prepared. The advice mentions the preparation friction only if the sample was compacted.
fn note_sample(case: &Case, sample: &Sample, compacted: bool, results: &mut RunResults) {
    let p = &case.preparation;
    results.steps.insert("prepare".into(), sample.steps);
    results.measures.insert("sample_unbalanced_force".into(), sample.unbalanced_force);
    if let Some(trial) = sample.trials.last() {
        results.measures.insert("preparation_friction".into(), trial.friction);
        results.measures.insert("preparation_trials".into(), sample.trials.len() as f64);
    }
    results.quality.extend(quality::judge_rest("sample", &sample.simulation, sample.unbalanced_force, p));
    if let (Some(densest), Some(loosest)) = (p.densest_void_ratio, p.loosest_void_ratio) {
        let void_ratio = 1.0 / sample.simulation.state().solid_fraction() - 1.0;
        let density = (loosest - void_ratio) / (loosest - densest);
        results.measures.insert("relative_density".into(), density);
    }
    if let Some(target) = p.target() {
        let reached = sample.simulation.state().solid_fraction();
        let advice = if !compacted {
            format!(
                "target {target} not reached: the packing was not compacted, since it carried its load or was dense enough, and came to rest at {reached:.4}; set \
                 preparation.solid_fraction = \"none\" or begin with a looser packing"
            )
        } else if let Some(friction) = p.friction {
            format!(
                "target {target} not reached: preparation.friction = {friction} gives {reached:.4}; set it to \"auto\", or \
                 preparation.solid_fraction = \"none\""
            )
        } else {
            let friction = sample.trials.last().map_or(0.0, |trial| (trial.friction * 1e3).round() / 1e3);
            let means = if reached < target {
                "preparation.cycles makes denser samples"
            } else {
                "a lower preparation.mean_stress or a larger preparation.inertial_number makes looser ones"
            };
            format!(
                "target {target} not reached: friction {friction} gives {reached:.4}, and no other came nearer; ask for another \
                 preparation.solid_fraction, or \"none\" ({means})"
            )
        };
        results.quality.push(run::QualityFlag::at_most(
            "solid_fraction_missed_by",
            (reached - target).abs(),
            p.solid_fraction_tolerance,
            advice,
        ));
    }
}

/// Measures the sample before the test.
pub(super) fn measure_sample(simulation: &Simulation, results: &mut RunResults) {
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
            results.measures.insert(name.to_string(), row[k]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_dem::config::{Contact, Material};

    #[test]
    fn packings_that_no_machine_could_hold_are_refused() {
        let refused = |edge: f64, radius: f64| {
            let file = format!(
                "# periodic box, m: xlo=0 ylo=0 zlo=0 xhi={edge} yhi={edge} zhi={edge}\n\
                 id,x,y,z,radius\n1,0.1,0.1,0.1,1e-3\n2,0.2,0.2,0.2,{radius}\n"
            );
            let packing = granum_io::formats::packing_csv::read_from(file.as_bytes(), "p.csv").unwrap();
            let properties = Properties::new(Material::default(), Contact::default());
            simulation(&packing, properties).err().map(|error| error.to_string()).unwrap_or_default()
        };
        assert_eq!(refused(1.0, 1e-3), "");
        assert!(refused(1.0, 0.9e-5).contains("radii go from 9e-6 m to 1e-3 m"), "{}", refused(1.0, 0.9e-5));
        assert!(refused(100.1, 1e-3).contains("an edge of 1.001e2 m"), "{}", refused(100.1, 1e-3));
    }
}
