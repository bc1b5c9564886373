//! What cannot be measured on the grains that LAMMPS tells of: columns of sensors whose parts of an assembly it does not give.

use granum_core::words::listed;
use granum_core::{Part, Parts};
use granum_io::Case;
use granum_sensors::{Record, RecordedState, Sensors};

use super::program::NAME;
use crate::task::engine_error::EngineError;
use crate::task::laboratory_error::LaboratoryError;

/// The columns of a test that are left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Unknown {
    columns: Vec<String>,
    histograms: Vec<String>,
    /// The parts of an assembly that they need.
    parts: Vec<Part>,
}

impl Unknown {
    /// What a case records and these parts do not suffice for.
    ///
    /// # Errors
    /// [`EngineError::Refused`] if the case names a sensor of which nothing can be measured.
    pub(super) fn new(case: &Case, sensors: &Sensors, known: Parts) -> Result<Unknown, LaboratoryError> {
        let columns = case.test_definition().columns;
        let names = sensors.of_test(&case.recording, columns)?;
        let mut unknown = Unknown::default();
        for name in names {
            let description = sensors.named(name)?;
            let missing = known.missing(&description.needs);
            let lacks = |needs: &[Part]| [missing.clone(), known.missing(needs)].concat();
            let nothing = description.columns.iter().all(|column| !lacks(column.needs).is_empty());
            if nothing && case.recording.sensors.iter().any(|asked| asked == name) {
                let mut parts: Vec<Part> =
                    description.columns.iter().flat_map(|column| lacks(column.needs)).collect();
                parts.sort_unstable();
                parts.dedup();
                let parts = listed(&parts.iter().map(|part| part.name()).collect::<Vec<_>>());
                let what = format!(
                    "recording.sensors = {name:?} cannot be measured: it needs {parts}, which LAMMPS does not give; leave it out"
                );
                return Err(EngineError::Refused { engine: NAME.into(), what }.into());
            }
            for column in &description.columns {
                let missing = lacks(column.needs);
                if !missing.is_empty() {
                    unknown.columns.push(column.name.into());
                    unknown.parts.extend(missing);
                }
            }
            if !missing.is_empty() {
                unknown.histograms.extend(histograms_of(sensors, case, name)?);
            }
        }
        unknown.parts.sort_unstable();
        unknown.parts.dedup();
        Ok(unknown)
    }

    /// A sentence on what is left out; none if nothing is.
    pub(super) fn remark(&self) -> Option<String> {
        (!self.columns.is_empty()).then(|| {
            format!(
                "not recorded: {}; LAMMPS does not give {}",
                listed(&self.columns),
                listed(&self.parts.iter().map(|part| part.name()).collect::<Vec<_>>())
            )
        })
    }

    fn has(&self, column: &str) -> bool {
        let of_histogram = |end: &str| {
            column.strip_suffix(end).is_some_and(|name| self.histograms.iter().any(|known| known == name))
        };
        self.columns.iter().any(|known| known == column) || of_histogram("_below") || of_histogram("_above")
    }

    /// Leaves it out of a state.
    pub(super) fn without_in_state(&self, mut state: RecordedState) -> RecordedState {
        state.values.retain(|value| !self.has(&value.name));
        state.histograms.retain(|histogram| !self.histograms.contains(&histogram.name));
        state
    }

    /// Leaves it out of a record.
    pub(super) fn without_in_record(&self, mut record: Record) -> Record {
        record.series = record.series.columns_where(|column| !self.has(&column.name));
        record.histograms.retain(|histogram| !self.histograms.contains(&histogram.name));
        record
    }
}

/// The names of the histograms of a sensor.
fn histograms_of(sensors: &Sensors, case: &Case, name: &str) -> Result<Vec<String>, LaboratoryError> {
    let description = sensors.named(name)?;
    // A histogram is named after its sensor, or after one of its columns.
    let own = |histogram: &str| {
        histogram == description.name || description.columns.iter().any(|column| column.name == histogram)
    };
    Ok(sensors
        .bins(&case.recording)
        .iter()
        .map(|bins| bins.name.to_string())
        .filter(|name| own(name))
        .collect())
}
