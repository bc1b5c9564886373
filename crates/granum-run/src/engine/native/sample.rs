//! Samples: prepared from a loose random state, read from a folder, or made from the packing of another program.

use std::cell::RefCell;
use std::path::Path;

use granum_dem::bond::BondPlaces;
use granum_dem::config::Preparation;
use granum_dem::observer::{EachProgress, Flow, SimulationObserver, SimulationObservers, SimulationProgress};
use granum_dem::preparation::{
    DensityMeasure, Phase, PreparationOutcome, Preparing, Sample, SampleSpecification, Trial,
};
use granum_dem::simulation::Simulation;
use granum_io::case::{Vocabulary, decides_sample, differences};
use granum_io::run::{CHECKPOINT, PREVIOUS_CHECKPOINT, Run, RunRecord, RunSource};
use granum_io::shell::{ShowPath, quoted_path};
use granum_io::{Case, Packing, run};

use super::follow::Follow;
use super::pace::Interval;
use super::preparation_curve::PreparationCurve;
use super::run_state::{RunPart, RunResults, RunState};
use super::segment::Segment;
use super::task_execution::TaskExecution;
use super::{from_packing, quality};
use crate::remark_on_shapes::remark_on_shapes;
use crate::task::laboratory_error::LaboratoryError;
use crate::task::resources::Resources;
use crate::task::source::Source;
use crate::task::status::Speedometer;

impl TaskExecution {
    /// The initial state of a run. A packing that has already been read can be passed in.
    pub(super) fn start(
        &self,
        case: &Case,
        source: &Source,
        packing: Option<Packing>,
        record: &mut RunRecord,
        observer: &mut dyn SimulationObserver,
    ) -> Result<RunState, LaboratoryError> {
        let specification = self.specification(case, &case.preparation, case.grains.count);
        let preparing = match source {
            Source::Folder(path) => {
                let found = take_sample(case, path, &self.vocabulary, record)?;
                check_listed_bonds(case, &found.simulation)?;
                return Ok(found);
            }
            Source::Case => {
                for remark in [remark_on_sizes(case), remark_on_shapes(case)].into_iter().flatten() {
                    note(record, remark);
                }
                Preparing::followed(&specification, observer)?
            }
            Source::Packing(path) => {
                let packing = packing.map_or_else(|| self.formats.read_packing(path), Ok)?;
                let (preparing, why_not) = from_packing::begin(&packing, &specification)?;
                let of_file =
                    packing.remarks.iter().map(|remark| format!("{}: {}", path.shown(), remark.text));
                let of_bonds = from_packing::remark_on_bonds(case, path, &packing);
                let of_keys = from_packing::remarks(case, path, why_not.as_deref());
                for remark in of_file.chain(of_bonds).chain(of_keys) {
                    observer.warn(&remark);
                    note(record, remark);
                }
                preparing
            }
        };
        check_listed_bonds(case, &preparing.simulation)?;
        Ok(RunState::new(preparing.simulation, RunPart::Preparation(preparing.progress)))
    }

    pub(super) fn specification(
        &self,
        case: &Case,
        preparation: &Preparation,
        grains: usize,
    ) -> SampleSpecification {
        SampleSpecification {
            grains: case.grains.clone(),
            contact: case.contact,
            preparation: preparation.clone(),
            stages: case.sample_stages(),
            time_step_factor: case.numerics.time_step_factor,
            largest_overlap: case.numerics.overlap_limit(),
            hardware: self.resources.hardware_for(grains),
        }
    }

    /// Continues a preparation until the sample is complete, until a checkpoint is due, or until the observer stops it.
    pub(super) fn prepare_on(
        &self,
        case: &Case,
        run_state: RunState,
        source: &RunSource,
        speedometer: &mut Speedometer,
        observer: &mut dyn SimulationObserver,
    ) -> Result<(RunState, Segment), LaboratoryError> {
        // The state is passed by value, because memory may not hold a large simulation twice.
        let RunState { simulation, part, mut results, older } = run_state;
        let RunPart::Preparation(progress) = part else {
            return Ok((RunState { simulation, part, results, older }, Segment::GoOn));
        };
        let compacted = progress.procedure().is_some();
        let specification = self.specification(case, &case.preparation, results.grains);
        let preparing = Preparing { simulation, progress };
        let (outcome, stopped) =
            self.compress(preparing, &specification, &mut results.curve, speedometer, observer)?;
        let (simulation, part) = match outcome {
            PreparationOutcome::Stopped(at) => (at.simulation, RunPart::Preparation(at.progress)),
            PreparationOutcome::Again(next) => {
                let preparing = from_packing::again(&self.formats, source, &specification, next)?;
                (preparing.simulation, RunPart::Preparation(preparing.progress))
            }
            PreparationOutcome::Sample(sample) => {
                results.curve.end(&sample, Phase::Relaxation);
                note_sample(case, &sample, compacted, &mut results);
                measure_sample(&sample.simulation, &mut results);
                (sample.simulation, RunPart::Sample)
            }
        };
        let segment = if stopped { Segment::Stop } else { Segment::GoOn };
        Ok((RunState { simulation, part, results, older }, segment))
    }

    /// Continues a preparation or consolidation, and returns whether the observer stopped it.
    pub(super) fn compress(
        &self,
        preparing: Preparing,
        specification: &SampleSpecification,
        curve: &mut PreparationCurve,
        speedometer: &mut Speedometer,
        observer: &mut dyn SimulationObserver,
    ) -> Result<(PreparationOutcome, bool), LaboratoryError> {
        let mut note = EachProgress(|progress: &SimulationProgress| {
            curve.observe(progress);
            Flow::Continue
        });
        let observer = RefCell::new(observer);
        let mut follow = Follow {
            observer: &observer,
            speedometer,
            checkpoint: Interval::new(self.resources.checkpoint_every),
            stage: None,
            axis: None,
            place: [0, 1],
            stopped: false,
        };
        let outcome =
            preparing.go_on(specification, &mut SimulationObservers(vec![&mut note, &mut follow]))?;
        // A stop that is requested while the sample becomes complete takes effect in the next segment.
        let stopped = follow.stopped && matches!(outcome, PreparationOutcome::Stopped(_));
        Ok((outcome, stopped))
    }
}

/// The simulation at the last checkpoint of a folder: of a finished preparation or test its end.
///
/// # Errors
/// [`LaboratoryError::Checkpoint`] if there is none or it cannot be used.
pub(crate) fn last_state(
    folder: &Path,
    vocabulary: &Vocabulary,
    resources: &Resources,
) -> Result<Simulation, LaboratoryError> {
    let path = folder.join(CHECKPOINT);
    let run = Run::at(folder)?;
    run.check_tables()?;
    match RunState::read(&path, &run.record()?, None, vocabulary)? {
        Some(RunState { mut simulation, .. }) => {
            simulation.set_hardware(resources.hardware_for(simulation.state().grains()));
            Ok(simulation)
        }
        None => {
            let what = "there is none; give the folder of a sample or of a run that granum made".into();
            Err(LaboratoryError::Checkpoint { path, what })
        }
    }
}

/// Adds a note unless the record has it already: a run that was killed before its first checkpoint starts again with the
/// record of the first attempt.
pub(in crate::engine) fn note(record: &mut RunRecord, text: String) {
    if !record.notes.contains(&text) {
        record.notes.push(text);
    }
}

/// Refuses bonds of pairs that no file lists before the sample is prepared.
fn check_listed_bonds(case: &Case, simulation: &Simulation) -> Result<(), LaboratoryError> {
    let definitions = case.bonds.iter().map(|bond| bond.bonding(case.vocabulary.laws()));
    for bonding in definitions.filter(|bonding| bonding.places == BondPlaces::Listed) {
        simulation.check_listed(&bonding)?;
    }
    Ok(())
}

/// Reads the sample of another folder.
fn take_sample(
    case: &Case,
    path: &Path,
    vocabulary: &Vocabulary,
    record: &mut RunRecord,
) -> Result<RunState, LaboratoryError> {
    let folder = Run::at(path)?.with_vocabulary(vocabulary);
    let other = folder.record()?;
    let checkpoint = path.join(CHECKPOINT);
    let bad = |what: String| LaboratoryError::Checkpoint { path: checkpoint.clone(), what };
    let name = quoted_path(path);
    if other.preparation_digest != case.preparation_digest_with(other.packing_digest()) {
        return Err(bad(format!(
            "the sample was prepared with values that differ from those of the case: {}; prepare another sample, or \
             change the case",
            in_what(&folder.case()?, case)
        )));
    }
    folder.check_tables()?;
    let run_state = match RunState::read(&checkpoint, &other, None, vocabulary) {
        Ok(Some(run_state)) => run_state,
        Ok(None) => return Err(bad(format!("it does not exist; `granum resume {name}` makes the sample"))),
        Err(LaboratoryError::Checkpoint { what, .. }) if path.join(PREVIOUS_CHECKPOINT).is_file() => {
            return Err(bad(format!("{what}; `granum resume {name}` makes it again from the previous one")));
        }
        Err(error) => return Err(error),
    };
    match run_state.part {
        RunPart::Sample => {
            record.wall_seconds.extend(other.wall_seconds);
            other.notes.into_iter().for_each(|text| note(record, text));
            if let Some(packing) = other.packing {
                record.set_packing(case, packing);
            }
            Ok(run_state)
        }
        RunPart::Preparation(_) => {
            Err(bad(format!("its preparation is not finished; continue it with `granum resume {name}`")))
        }
        RunPart::Consolidation(_) | RunPart::Consolidated | RunPart::Test(_) => {
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
        results.measures.insert("preparation_stress".into(), trial.mean_stress);
        results.measures.insert("preparation_cycles".into(), trial.cycles as f64);
        results.measures.insert("preparation_trials".into(), sample.trials.len() as f64);
    }
    if sample.densified {
        results.measures.insert("preparation_densified".into(), 1.0);
    }
    results.quality.extend(quality::judge_rest("sample", &sample.simulation, sample.unbalanced_force, p));
    if let (Some(densest), Some(loosest)) = (p.densest_void_ratio, p.loosest_void_ratio) {
        let void_ratio = 1.0 / sample.simulation.state().solid_fraction() - 1.0;
        let density = (loosest - void_ratio) / (loosest - densest);
        results.measures.insert("relative_density".into(), density);
    }
    if let Some(target) = p.target() {
        let reached = sample.simulation.state().solid_fraction();
        let is_looser = reached < target;
        let beyond = |density: &dyn Fn(f64) -> String| beyond(&sample.trials, target, density);
        let missed = (reached - target).abs();
        // In the measure in which it was asked for; a solid fraction is the usual one and goes without its name.
        let measure = DensityMeasure::new(p);
        let key = measure.key();
        let value = |solid_fraction: f64| (measure.value(p, solid_fraction) * 1e4).round() / 1e4;
        let reached = format!("{:.4}", measure.value(p, reached));
        let target = match measure {
            DensityMeasure::SolidFraction => target.to_string(),
            _ => format!("{} {}", measure.name(), measure.target(p).unwrap_or_else(|| value(target))),
        };
        let advice = if !compacted {
            format!(
                "target {target} not reached: the packing was not compacted, since it carried its load or was dense enough, and came to rest at {reached}; set \
                 preparation.solid_fraction = \"none\" or start from a looser packing"
            )
        } else if let Some(friction) = p.friction {
            format!(
                "target {target} not reached: preparation.friction = {friction} gives {reached}; set it to \"auto\", or \
                 preparation.solid_fraction = \"none\""
            )
        } else {
            let mut procedure = sample.trials.last().map_or_else(String::new, described);
            if sample.densified {
                procedure += ", made denser,";
            }
            let means = if is_looser {
                "more preparation.cycles, or preparation.rolling_friction = 0, make denser samples"
            } else {
                "more resistance to rolling of the grains or a larger preparation.inertial_number makes looser ones"
            };
            let beyond = beyond(&|solid_fraction| {
                format!("{} {:.4}", measure.name(), measure.value(p, solid_fraction))
            });
            format!(
                "target {target} not reached: compaction with {procedure} gives {reached}, and no other came closer{beyond}; choose another \
                 preparation.{key}, or preparation.solid_fraction = \"none\" in its place ({means})"
            )
        };
        results.quality.push(run::QualityFlag::at_most(
            "solid_fraction_missed_by",
            missed,
            p.solid_fraction_tolerance,
            advice,
        ));
    }
}

/// Where no procedure reached a density: that all trials are on one side of it, and what the last of the procedures gave.
fn beyond(trials: &[Trial], target: f64, density: &dyn Fn(f64) -> String) -> String {
    let by_density = |a: &&Trial, b: &&Trial| a.solid_fraction.total_cmp(&b.solid_fraction);
    let [Some(loosest), Some(densest)] = [trials.iter().min_by(by_density), trials.iter().max_by(by_density)]
    else {
        return String::new();
    };
    let (end, way, which) = if densest.solid_fraction < target {
        (densest, "looser", "densest")
    } else if loosest.solid_fraction > target {
        (loosest, "denser", "loosest")
    } else {
        return String::new();
    };
    let count = trials.len();
    let reached = density(end.solid_fraction);
    format!(
        ": all {count} trials are {way}, and the {which} of them, with {}, has a {reached}",
        described(end)
    )
}

/// The procedure of a trial in words.
fn described(trial: &Trial) -> String {
    let friction = libm::round(trial.friction * 1e3) / 1e3;
    let stress = trial.mean_stress / 1e3;
    match trial.cycles {
        0 => format!("friction {friction} at {stress:.4} kPa"),
        cycles => format!("friction {friction} at {stress:.4} kPa and {cycles} strain cycles"),
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
