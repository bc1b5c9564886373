//! One recorded state of a test, as it is told while the test runs.

use granum_core::observer::NamedValue;
use granum_core::{Column, Table};
use serde_json::{Map, Value, json};

use crate::record::{Histograms, Record};
use crate::{Histogram, Sensors};

/// Key of the histograms in the text of a state.
const HISTOGRAMS: &str = "histograms";

/// One recorded state of a test, as it is told while the test runs: the values of one row of the series, and its histograms.
///
/// Its text is one line of JSON, an object with the values by the names of their columns, which tools for tables can read.
///
/// ```
/// use granum_core::observer::NamedValue;
/// use granum_sensors::RecordedState;
///
/// let value = NamedValue { name: "deviator_strain".into(), value: 0.01, unit: "".into() };
/// let state = RecordedState { values: vec![value], histograms: Vec::new() };
/// assert_eq!(state.to_line(), r#"{"deviator_strain":0.01,"histograms":{}}"#);
/// assert_eq!(RecordedState::from_line(&state.to_line(), &granum_sensors::Sensors::standard()), Some(state));
/// ```
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct RecordedState {
    /// The values of the columns of the series: `stage` (in a test that is given as stages), `state`, `observations`, those of the
    /// sensors.
    pub values: Vec<NamedValue>,
    /// The histograms of the state, one of each name.
    pub histograms: Vec<Histograms>,
}

impl RecordedState {
    /// A state from a record of one row.
    pub(crate) fn from_record(record: Record) -> RecordedState {
        let value = |column: &Column| NamedValue {
            name: column.name.clone().into(),
            value: column.values.first().copied().unwrap_or(f64::NAN),
            unit: column.unit.clone().into(),
        };
        RecordedState {
            values: record.series.columns().iter().map(value).collect(),
            histograms: record.histograms,
        }
    }

    /// The value of a column.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.values.iter().find(|value| value.name == name).map(|value| value.value)
    }

    /// The state as one line of JSON, without its end. A NaN is null.
    pub fn to_line(&self) -> String {
        let mut line = String::from("{");
        for NamedValue { name, value, .. } in &self.values {
            line.push_str(&format!("{}:{},", json!(name), json!(value)));
        }
        let mut histograms = Map::new();
        for Histograms { name, quantity, unit, states } in &self.histograms {
            let Some(histogram) = states.first() else { continue };
            let one = json!({ "quantity": quantity, "unit": unit, "histogram": histogram });
            histograms.insert(name.clone(), one);
        }
        line.push_str(&format!("\"{HISTOGRAMS}\":{}}}", Value::Object(histograms)));
        line
    }

    /// The state of a line; `None` if the line is not whole. The units are those of the sensors.
    pub fn from_line(line: &str, sensors: &Sensors) -> Option<RecordedState> {
        let Value::Object(fields) = serde_json::from_str(line).ok()? else { return None };
        let unit = |name: &str| {
            let column = sensors.columns().find(|column| column.name == name);
            column.map_or("", |column| if column.unit == "1" { "" } else { column.unit })
        };
        let mut state = RecordedState::default();
        // The order of the columns is that of the line, which a map does not keep.
        for name in keys_in_order(line)? {
            let value = fields.get(&name)?;
            if name == HISTOGRAMS {
                for (name, found) in value.as_object()? {
                    let text = |key: &str| found.get(key)?.as_str().map(str::to_string);
                    let histogram: Histogram =
                        serde_json::from_value(found.get("histogram")?.clone()).ok()?;
                    state.histograms.push(Histograms {
                        name: name.clone(),
                        quantity: text("quantity")?,
                        unit: text("unit")?,
                        states: vec![histogram],
                    });
                }
                continue;
            }
            let number = if value.is_null() { f64::NAN } else { value.as_f64()? };
            let unit = unit(&name).to_string();
            state.values.push(NamedValue { name: name.into(), value: number, unit: unit.into() });
        }
        Some(state)
    }

    /// The states as a record. A column that a state lacks has been zero in it: columns that are not always in use are left out where
    /// all their values are zero.
    pub fn record(states: &[RecordedState]) -> Record {
        let mut names: Vec<&NamedValue> = Vec::new();
        for value in states.iter().flat_map(|state| &state.values) {
            if names.iter().all(|known| known.name != value.name) {
                names.push(value);
            }
        }
        let column = |named: &&NamedValue| {
            let values = states.iter().map(|state| state.value(&named.name).unwrap_or(0.0));
            Column::new(named.name.to_string(), named.unit.to_string(), values.collect())
        };
        let mut series = Table::default();
        for column in names.iter().map(column) {
            // This cannot fail: every column has one value for each state.
            let _ = series.set(column);
        }
        let mut histograms: Vec<Histograms> = Vec::new();
        for one in states.iter().flat_map(|state| &state.histograms) {
            match histograms.iter_mut().find(|known| known.name == one.name) {
                Some(known) => known.states.extend(one.states.iter().cloned()),
                None => histograms.push(one.clone()),
            }
        }
        Record { series, histograms }
    }
}

/// The keys of an object in the order of its text.
fn keys_in_order(line: &str) -> Option<Vec<String>> {
    struct Keys;
    impl<'d> serde::de::Visitor<'d> for Keys {
        type Value = Vec<String>;
        fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
            f.write_str("an object")
        }
        fn visit_map<M: serde::de::MapAccess<'d>>(self, mut map: M) -> Result<Vec<String>, M::Error> {
            let mut keys = Vec::new();
            while let Some((key, _)) = map.next_entry::<String, serde::de::IgnoredAny>()? {
                keys.push(key);
            }
            Ok(keys)
        }
    }
    serde::de::Deserializer::deserialize_map(&mut serde_json::Deserializer::from_str(line), Keys).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Recorder, lattice};
    use granum_dem::config::{RecordedColumns, Recording};

    #[test]
    fn states_told_one_by_one_are_the_record() {
        let recording = Recording::default().with(|recording| {
            recording.states = 3;
            recording.observations_per_state = 2;
            recording.sensors = vec!["overlap_distribution".to_string()];
        });
        let sensors = Sensors::standard();
        let mut recorder = Recorder::new(&sensors, &recording, 0.3).unwrap();
        let (mut told, mut lines) = (0, Vec::new());
        for k in 0..=60 {
            let mut assembly = lattice::random_contacts(50, k);
            assembly.strain[0][0] = 0.005 * k as f64;
            recorder.observe(&assembly);
            for index in told..recorder.complete_states() {
                lines.push(recorder.state(index, 1, RecordedColumns::FirstPublished).to_line());
            }
            told = recorder.complete_states();
        }
        assert_eq!(told, 4, "the last state is complete when its last observation was made");
        let states: Vec<RecordedState> =
            lines.iter().map(|line| RecordedState::from_line(line, &sensors).unwrap()).collect();
        let (whole, record) = (recorder.record(), RecordedState::record(&states));
        assert_eq!(record.histograms, whole.histograms);
        assert_eq!(record.series.names().collect::<Vec<_>>(), whole.series.names().collect::<Vec<_>>());
        for (own, other) in record.series.columns().iter().zip(whole.series.columns()) {
            assert_eq!(own.unit, other.unit, "{}", own.name);
            let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&own.values), bits(&other.values), "{}", own.name);
        }
        // A line that was cut short is no state.
        let line = &lines[1];
        assert!((1..line.len()).all(|cut| RecordedState::from_line(&line[..cut], &sensors).is_none()));
        let staged = recorder.state(2, 7, RecordedColumns::All);
        assert_eq!((staged.value("stage"), staged.value("state")), (Some(7.0), Some(2.0)));
    }
}
