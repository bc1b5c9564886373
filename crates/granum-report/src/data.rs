//! The data from which a report is made.

use granum_io::RunKind;

use std::borrow::Cow;
use std::collections::BTreeMap;

use granum_core::Table;
use granum_core::assembly::Assembly;
use granum_dem::loading::Stage;
use granum_io::run::{RunRecord, RunStatus};
use granum_io::{Case, Run};
use granum_learn::LearnError;
use granum_learn::runs::RunRole;
use granum_run::strength::Curves;
use granum_run::strength::symmetry::shear_at_constant_p;
use granum_sensors::Record;
use serde::{Deserialize, Serialize};

use super::symbols::STRAIN;

/// One DEM run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunReport {
    /// Name of the run, that of its folder.
    pub name: String,
    /// Role of the run.
    pub role: RoleInStudy,
    /// The case.
    pub case: Case,
    /// The contents of `run.json`.
    pub run: RunRecord,
    /// The measurements.
    pub record: Record,
    /// The history of the preparation; empty if it was not recorded.
    #[serde(default)]
    pub preparation: Table,
    /// The sample before shear, for pictures.
    pub start: Option<Assembly>,
    /// The assembly at the end, for pictures.
    pub end: Option<Assembly>,
}

/// The role of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RoleInStudy {
    /// It does not belong to a study.
    #[default]
    Single,
    /// Networks were trained on it.
    Training,
    /// It was used neither for training nor for selection.
    Unseen,
}

impl From<RunRole> for RoleInStudy {
    fn from(role: RunRole) -> RoleInStudy {
        match role {
            RunRole::Training => RoleInStudy::Training,
            RunRole::Unseen => RoleInStudy::Unseen,
        }
    }
}

impl RoleInStudy {
    /// The role as one word.
    pub fn word(self) -> &'static str {
        match self {
            RoleInStudy::Single => "run",
            RoleInStudy::Training => RunRole::Training.name(),
            RoleInStudy::Unseen => RunRole::Unseen.name(),
        }
    }
}

/// A record without the states of stages that bring the sample to rest and record nothing but their start. What a test shows counts
/// from the state in which it began, not from the sample before it was consolidated.
fn without_consolidation(record: Record, stages: &[Stage]) -> Record {
    let rests = |number: &f64| {
        let stage = stages.get((*number as usize).saturating_sub(1));
        stage.is_some_and(|stage| {
            stage.settling
                && !stage.is_mark()
                && stage.record == granum_dem::loading::RecordedStates::default()
        })
    };
    let kept: Vec<bool> = match record.series.values("stage") {
        Some(numbers) => numbers.iter().map(|number| !rests(number)).collect(),
        None => return record,
    };
    // A test that is still in its consolidation has nothing else.
    if !kept.contains(&true) || !kept.contains(&false) {
        return record;
    }
    let columns = record.series.columns().iter().map(|column| {
        let values =
            column.values.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(value, _)| *value).collect();
        granum_core::Column { values, ..column.clone() }
    });
    // All columns have lost the same rows.
    let Ok(series) = Table::new(columns.collect()) else { return record };
    let mut histograms = record.histograms;
    for histogram in &mut histograms {
        let mut rows = kept.iter();
        histogram.states.retain(|_| rows.next().copied().unwrap_or(true));
    }
    Record { series, histograms }
}

/// A column of a record; empty if there is none.
pub fn column<'a>(record: &'a Record, name: &str) -> &'a [f64] {
    record.series.values(name).unwrap_or(&[])
}

impl RunReport {
    /// Reads the folder of a run, including the snapshots of the sample and of the end for pictures if they exist.
    ///
    /// # Errors
    /// If the case, the record or a snapshot is missing or damaged; the message names the file.
    pub fn read(run: &Run, role: RoleInStudy) -> Result<Self, LearnError> {
        let names = run.snapshots()?;
        let snapshot =
            |name: &str| names.iter().find(|found| *found == name).map(|name| run.snapshot(name)).transpose();
        Ok(RunReport {
            start: snapshot(granum_run::laboratory::SAMPLE)?,
            end: snapshot(granum_run::laboratory::END)?,
            ..RunReport::read_without_pictures(run, role)?
        })
    }

    /// As [`RunReport::read`], without the snapshots.
    ///
    /// # Errors
    /// As [`RunReport::read`].
    pub fn read_without_pictures(run: &Run, role: RoleInStudy) -> Result<Self, LearnError> {
        let about = run.record()?;
        let case = run.case()?;
        Ok(RunReport {
            name: run.path().file_name().map_or("run".to_owned(), |name| name.to_string_lossy().into_owned()),
            role,
            // A sample has no record of a test.
            record: if about.kind == RunKind::Sample {
                Record::default()
            } else {
                without_consolidation(granum_run::record::read_record(run)?, &case.test_stages())
            },
            case,
            run: about,
            preparation: run.preparation()?.unwrap_or_default(),
            start: None,
            end: None,
        })
    }

    /// A test of which only the case, the record and the measurements are known.
    pub fn of_parts(name: &str, case: Case, run: RunRecord, measured: Record, role: RoleInStudy) -> Self {
        RunReport {
            name: name.to_string(),
            role,
            record: without_consolidation(measured, &case.test_stages()),
            case,
            run,
            preparation: Table::default(),
            start: None,
            end: None,
        }
    }

    /// True if the test reached its end.
    pub fn is_complete(&self) -> bool {
        self.run.status == RunStatus::Finished
    }

    /// Number of grains; that of the packing if the sample was made from one.
    pub fn grains(&self) -> usize {
        self.run.packing.as_ref().map_or(self.case.grains.count, |packing| packing.grains)
    }

    /// Mean diameter of the grains, m, and half the range of the diameters over the mean.
    pub fn diameter(&self) -> (f64, f64) {
        let grains = &self.case.grains;
        let mean = grains.mean_diameter().unwrap_or(grains.diameter);
        let range = grains.size_range().ok().filter(|_| !grains.sizes.is_standard());
        let spread = range.map_or(grains.spread, |[smallest, largest]| 0.5 * (largest - smallest) / mean);
        let of_case = (mean, spread);
        self.run.packing.as_ref().map_or(of_case, |packing| (packing.mean_diameter, packing.spread))
    }

    /// Mean stress, Pa: of the test, or of a sample that was not sheared.
    pub fn mean_stress(&self) -> f64 {
        match self.run.kind {
            RunKind::Sample => self.case.preparation.mean_stress,
            RunKind::Test => self.case.test_definition().mean_stress(self.case.preparation.mean_stress),
        }
    }

    /// True for a test like the paper's ([`shear_at_constant_p`]), whose figures and tables are those of the paper.
    pub fn is_at_constant_p(&self) -> bool {
        shear_at_constant_p(&self.case.test_stages()).is_some()
    }

    /// Wall time of all phases, s.
    pub fn wall_seconds(&self) -> f64 {
        self.run.wall_seconds.values().sum()
    }

    /// A column of the record; empty if there is none.
    pub fn column(&self, name: &str) -> &[f64] {
        column(&self.record, name)
    }

    /// Two columns as points.
    pub fn points(&self, x: &str, y: &str) -> Vec<[f64; 2]> {
        self.column(x).iter().zip(self.column(y)).map(|(&x, &y)| [x, y]).collect()
    }

    /// A column against the strain that figures have on their axis ([`RunReport::strain`]).
    pub fn against_strain(&self, y: &str) -> Vec<[f64; 2]> {
        self.strain().iter().zip(self.column(y)).map(|(&x, &y)| [x, y]).collect()
    }

    /// The strain that figures have on their axis: the deviator strain of a test like the paper's; of any other test the deviatoric
    /// strain where it only grows, else the length of the whole way.
    pub fn strain(&self) -> Cow<'_, [f64]> {
        self.strain_and_label().0
    }

    /// As [`RunReport::strain`], with the label of its axis.
    pub fn strain_and_label(&self) -> (Cow<'_, [f64]>, &'static str) {
        let arcs = self.column("arc_length");
        if arcs.is_empty() || self.is_at_constant_p() {
            return (Cow::Borrowed(self.column("deviator_strain")), STRAIN);
        }
        let deviatoric = self.column("deviatoric_strain");
        if deviatoric.windows(2).all(|pair| pair[1] >= pair[0] - 1e-6) && deviatoric.last() > Some(&1e-4) {
            return (Cow::Borrowed(deviatoric), "Deviatoric strain *ε*_{q}");
        }
        let stages = self.case.test_stages();
        let curves = Curves::new(&self.record, &stages);
        let mut before = 0.0;
        let way = arcs.iter().enumerate().map(|(row, &arc)| {
            // The strain began to count anew.
            if row > 0 && curves.counted_from(row) == row {
                before += arcs[row - 1];
            }
            before + arc
        });
        (Cow::Owned(way.collect()), "Length of the strain path")
    }

    /// The measures of the test: strength, critical state, liquefaction ([`granum_run::strength`]).
    pub fn measures(&self) -> BTreeMap<String, f64> {
        granum_run::strength::of_run(&self.case, &self.run, &self.record)
    }

    /// The first value of a column, that of the sample before shear; for a sample that was not sheared, the measured value.
    pub fn first(&self, name: &str) -> Option<f64> {
        match self.run.kind {
            RunKind::Sample => self.run.measures.get(name).copied(),
            RunKind::Test => self.column(name).first().copied(),
        }
    }

    /// The row where a column is largest.
    pub fn peak_row(&self, name: &str) -> Option<usize> {
        let values = self.column(name);
        (0..values.len()).filter(|&k| values[k].is_finite()).max_by(|&a, &b| values[a].total_cmp(&values[b]))
    }

    /// Mean of a column over the last quarter of the strain.
    pub fn late_mean(&self, name: &str) -> Option<f64> {
        granum_run::laboratory::late_mean(&self.strain(), self.column(name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_core::Column;

    #[test]
    fn columns_are_found_or_empty() {
        let column = |name: &str, values: &[f64]| Column::new(name, "", values.to_vec());
        let series = Table::new(vec![
            column("deviator_strain", &[0.0, 0.1, 0.2, 0.3]),
            column("stress_ratio", &[0.0, 0.9, f64::NAN, 0.7]),
        ])
        .unwrap();
        let run = RunReport { record: Record { series, histograms: Vec::new() }, ..Default::default() };
        assert_eq!(run.against_strain("stress_ratio").len(), 4);
        assert_eq!(run.peak_row("stress_ratio"), Some(1));
        // The mean is taken from 0.225 to 0.3, between the states with 0.9 at 0.1 and 0.7 at 0.3.
        assert!((run.late_mean("stress_ratio").unwrap() - 0.7375).abs() < 1e-12);
        assert_eq!(run.first("stress_ratio"), Some(0.0));
        assert!(run.column("nothing").is_empty() && run.peak_row("nothing").is_none());
        assert_eq!(RunReport::default().late_mean("stress_ratio"), None);
    }
}
