//! Samples made from packing files: whether a packing is compacted, and which keys of the case are then without effect.

use std::path::Path;

use granum_dem::bond::BondPlaces;
use granum_dem::preparation::{NextTrial, Preparing, SampleSpecification, is_loose};
use granum_io::case::field;
use granum_io::run::{PackingRecord, RunSource, file_digest};
use granum_io::shell::ShowPath;
use granum_io::{Case, Formats, Packing};

use super::task_execution::TaskExecution;
use crate::task::laboratory_error::LaboratoryError;
use crate::task::packing_simulation::simulation;
use crate::task::source::Source;

/// Keys that have an effect only if the packing is compacted.
const USED_IN_COMPACTION: [&str; 6] = [
    "preparation.friction",
    "preparation.compaction_stress",
    "preparation.rolling_friction",
    "preparation.interface_energy",
    "preparation.cycles",
    "preparation.cycle_strain",
];

/// Name of a packing's file without its folder.
fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(|| path.shown(), |name| name.to_string_lossy().into_owned())
}

/// The description of a packing for the record of a run.
pub(super) fn describe(path: &Path, packing: &Packing, sha256: &str) -> PackingRecord {
    let diameters = || packing.grains.iter().map(|grain| 2.0 * grain.radius);
    let (smallest, largest) = diameters().fold((f64::INFINITY, 0.0f64), |(a, b), d| (a.min(d), b.max(d)));
    let mean = diameters().sum::<f64>() / packing.grains.len().max(1) as f64;
    // With equal grains the mean would differ from the diameter by rounding.
    let mean_diameter = if largest > smallest { mean } else { largest };
    let spread = 0.5 * (largest - smallest) / mean_diameter;
    PackingRecord {
        file_name: file_name(path),
        sha256: sha256.to_owned(),
        grains: packing.grains.len(),
        mean_diameter,
        spread,
    }
}

/// Begins to prepare a sample from a packing. If the packing is not compacted, the reason is returned as well.
pub(super) fn begin(
    packing: &Packing,
    specification: &SampleSpecification,
) -> Result<(Preparing, Option<String>), LaboratoryError> {
    let next = NextTrial::first(specification);
    let loose = simulation(packing, next.properties(specification))?;
    if is_loose(&loose, &specification.preparation) {
        return Ok((Preparing::compacting(loose, specification, next), None));
    }
    let state = loose.state();
    let why = format!(
        "it is not loose (mean stress {:.3} kPa, solid fraction {:.4}) and is only brought to rest",
        state.mean_stress() / 1e3,
        state.solid_fraction()
    );
    drop(loose);
    Ok((Preparing::settling(simulation(packing, specification.properties())?, specification), Some(why)))
}

/// Begins the next trial of the preparation friction, again from the packing.
pub(super) fn again(
    formats: &Formats,
    source: &RunSource,
    specification: &SampleSpecification,
    next: NextTrial,
) -> Result<Preparing, LaboratoryError> {
    let RunSource::Packing { file, sha256 } = source else {
        return Err(LaboratoryError::Packing("its file is no longer known; run it again".into()));
    };
    if file_digest(file)? != *sha256 {
        let message = "was changed since the run began, but the search for the preparation friction needs it \
                       unchanged; restore it and resume the run, or run it again";
        return Err(granum_io::Error::content(file, message).into());
    }
    let simulation = simulation(&formats.read_packing(file)?, next.properties(specification))?;
    Ok(Preparing::compacting(simulation, specification, next))
}

/// A sentence for every key that the case sets to a value other than the default and that has no effect on the run.
pub(super) fn remarks(case: &Case, path: &Path, why_not: Option<&str>) -> Vec<String> {
    let default = Case::default();
    let name = file_name(path);
    let set = |key: &&str| field(key).is_some_and(|field| field.value(case) != field.value(&default));
    let shown = |key: &str| field(key).map_or_else(String::new, |field| field.shown(case));
    let mut remarks: Vec<String> = (case.unused_with_packing().filter(|key| set(key)))
        .map(|key| {
            format!("{key} = {} has no effect in this run: its grains are those of {name}", shown(key))
        })
        .collect();
    if !case.grains.are_spheres() {
        remarks.push(format!("[grains.shape] has no effect in this run: its grains are those of {name}"));
    }
    if let Some(why) = why_not {
        let keys = USED_IN_COMPACTION.iter().filter(|key| set(key));
        remarks.extend(keys.map(|key| {
            format!("{key} = {} has no effect in this run: {name} is not compacted, {why}", shown(key))
        }));
        if !case.preparation_stages.is_empty() {
            let remark = "[[preparation.stage]] has no effect in this run";
            remarks.push(format!("{remark}: {name} is not compacted, {why}"));
        }
    }
    remarks
}

/// A sentence about the bonds that a packing lists, if no table of the case makes bonds of them.
pub(super) fn remark_on_bonds(case: &Case, path: &Path, packing: &Packing) -> Option<String> {
    let laws = case.vocabulary.laws();
    let made = case.bonds.iter().any(|bond| bond.bonding(laws).places == BondPlaces::Listed);
    (!packing.bonds.is_empty() && !made).then(|| {
        format!(
            "{} lists {} bonds, of which none is made in this run: a table [[bond]] with places = \"file\" makes them",
            file_name(path),
            packing.bonds.len()
        )
    })
}

impl TaskExecution {
    /// Reads the packing if the source is a packing file.
    ///
    /// # Errors
    /// As for [`Formats::read_packing`].
    pub(super) fn packing(&self, source: &Source) -> Result<Option<Packing>, LaboratoryError> {
        match source {
            Source::Packing(path) => Ok(Some(self.formats.read_packing(path)?)),
            Source::Case | Source::Folder(_) => Ok(None),
        }
    }
}
