//! Measuring assemblies outside a test: what could be measured, and what not, with the reason.

use granum_core::{Assembly, ObservedState, Part, Parts};
use granum_dem::config::Recording;

use super::{Kinds, Sensors};
use crate::histogram::{Bins, Histogram};
use crate::{Memory, Observation, SensorColumn, SensorDescription, Values};

impl Sensors {
    /// Evaluates every sensor for which the known parts of an assembly suffice, and reports the others with the reason. Sensors that
    /// are recorded only of grains of several pieces are passed over where every grain has one.
    pub fn measure(&self, assembly: &Assembly, parts: Parts) -> Measurement {
        self.measure_with(assembly, parts, &Recording::default())
    }

    /// The same of a state, whoever computes it: granum's engine, another program, a file.
    pub fn measure_state(&self, state: &dyn ObservedState) -> Measurement {
        self.measure(&state.assembly(), state.parts())
    }

    /// As [`Sensors::measure`], with the parameters of sensors and the bins of a recording.
    pub fn measure_with(&self, assembly: &Assembly, parts: Parts, recording: &Recording) -> Measurement {
        let observation = Observation::new(assembly).with_recording(recording);
        let mut found = Measurement::default();
        let kinds = Kinds::new([assembly].into_iter());
        for known in self.known.iter().filter(|known| known.applies(kinds)) {
            let SensorDescription { name, columns, needs, remembers, .. } = &known.description;
            let missing = parts.missing(needs);
            let lacks = known.lacks(recording).or_else(|| known.costs_too_much(assembly).map(String::from));
            if *remembers || !missing.is_empty() || lacks.is_some() {
                found.left_out.push(LeftOut {
                    sensor: name,
                    columns: Vec::new(),
                    missing,
                    remembers: *remembers,
                    lacks,
                });
                continue;
            }
            let bins = known.sensor.histograms(recording);
            let (mut row, mut counts) = (Vec::new(), bins.iter().map(Bins::empty).collect::<Vec<_>>());
            let mut values = Values::new(&mut row, &mut counts);
            known.sensor.measure(&observation, &mut Memory::new(), &mut values);
            if let Some(why) = values.why_not() {
                found.left_out.push(LeftOut::whole(name, why));
                continue;
            }
            for (column, value) in columns.iter().zip(row) {
                match parts.missing(column.needs) {
                    missing if missing.is_empty() => found.columns.push((*column, value)),
                    missing => found.leave_out(name, column.name, missing),
                }
            }
            found.histograms.extend(bins.into_iter().zip(counts));
        }
        found
    }
}

impl Sensors {
    /// Measures a series of assemblies, each with its known parts, in their order: every column for which the parts that all of
    /// them have suffice, including the sensors that compare an observation with the previous one if there are two or more
    /// assemblies.
    ///
    /// ```
    /// use granum_core::{Assembly, Part, Parts};
    /// use granum_sensors::Sensors;
    ///
    /// let grains = Assembly::default();
    /// let parts = Parts::new(&[Part::Cell, Part::Radii]);
    /// let series = Sensors::standard().measure_series(&[(&grains, parts), (&grains, parts)]);
    /// assert_eq!(series.values("solid_fraction"), Some([0.0, 0.0].as_slice()));
    /// assert!(series.left_out.iter().any(|left_out| left_out.sensor == "fabric"));
    /// ```
    pub fn measure_series(&self, observations: &[(&Assembly, Parts)]) -> MeasuredSeries {
        self.measure_series_with(observations, &Recording::default())
    }

    /// As [`Sensors::measure_series`], with the parameters of sensors and the bins of a recording.
    pub fn measure_series_with(
        &self,
        observations: &[(&Assembly, Parts)],
        recording: &Recording,
    ) -> MeasuredSeries {
        let every = |part: &Part| observations.iter().all(|(_, parts)| parts.has(*part));
        let parts = Parts::new(&Part::ALL.into_iter().filter(every).collect::<Vec<Part>>());
        let observations: Vec<Observation> = observations
            .iter()
            .map(|(assembly, _)| Observation::new(assembly).with_recording(recording))
            .collect();
        let (mut found, mut left_out) = (MeasuredSeries::default(), Measurement::default());
        let kinds = Kinds::new(observations.iter().map(|one| one.assembly));
        for known in self.known.iter().filter(|known| known.applies(kinds)) {
            let SensorDescription { name, columns, needs, remembers, .. } = &known.description;
            let missing = parts.missing(needs);
            let alone = *remembers && observations.len() < 2;
            let costly =
                || observations.iter().find_map(|one| known.costs_too_much(one.assembly).map(String::from));
            let lacks = known.lacks(recording).or_else(costly);
            if alone || !missing.is_empty() || lacks.is_some() {
                let columns = Vec::new();
                left_out.left_out.push(LeftOut { sensor: name, columns, missing, remembers: alone, lacks });
                continue;
            }
            let bins = known.sensor.histograms(recording);
            let mut memory = Memory::new();
            let mut rows = Vec::with_capacity(observations.len());
            let mut why_not = None;
            for observation in &observations {
                let (mut row, mut counts) = (Vec::new(), bins.iter().map(Bins::empty).collect::<Vec<_>>());
                let mut values = Values::new(&mut row, &mut counts);
                known.sensor.measure(observation, &mut memory, &mut values);
                why_not = values.why_not();
                if why_not.is_some() {
                    break;
                }
                rows.push(row);
            }
            if let Some(why) = why_not {
                left_out.left_out.push(LeftOut::whole(name, why));
                continue;
            }
            for (k, column) in columns.iter().enumerate() {
                match parts.missing(column.needs) {
                    missing if missing.is_empty() => {
                        let values = rows.iter().filter_map(|row| row.get(k).copied()).collect();
                        found.columns.push((*column, values));
                    }
                    missing => left_out.leave_out(name, column.name, missing),
                }
            }
        }
        found.left_out = left_out.left_out;
        found
    }
}

/// The measurements of a series of assemblies, and the sensors that could not be evaluated.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct MeasuredSeries {
    /// Each column that could be measured, with one value for each assembly.
    pub columns: Vec<(SensorColumn, Vec<f64>)>,
    /// The sensors that could not be evaluated, and why.
    pub left_out: Vec<LeftOut>,
}

impl MeasuredSeries {
    /// The values of a column, if it could be measured.
    pub fn values(&self, column: &str) -> Option<&[f64]> {
        self.columns.iter().find(|(known, _)| known.name == column).map(|(_, values)| values.as_slice())
    }
}

/// The measurements of one assembly, and the sensors that could not be evaluated.
#[derive(Clone, Debug, Default)]
pub struct Measurement {
    /// Each column that could be measured, with its value.
    pub columns: Vec<(SensorColumn, f64)>,
    /// Each histogram that could be counted.
    pub histograms: Vec<(Bins, Histogram)>,
    /// The sensors that could not be evaluated, and why.
    pub left_out: Vec<LeftOut>,
}

impl Measurement {
    /// The value of a column, if it could be measured.
    pub fn value(&self, column: &str) -> Option<f64> {
        self.columns.iter().find(|(known, _)| known.name == column).map(|(_, value)| *value)
    }

    /// Columns of one sensor that lack the same parts are reported together.
    fn leave_out(&mut self, sensor: &'static str, column: &'static str, missing: Vec<Part>) {
        match self.left_out.iter_mut().find(|known| known.sensor == sensor && known.missing == missing) {
            Some(known) => known.columns.push(column),
            None => self.left_out.push(LeftOut {
                sensor,
                columns: vec![column],
                missing,
                remembers: false,
                lacks: None,
            }),
        }
    }
}

/// A sensor, or some of its columns, that could not be measured on an assembly, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct LeftOut {
    /// The sensor.
    pub sensor: &'static str,
    /// Its columns that could not be measured; empty for all.
    pub columns: Vec<&'static str>,
    /// The parts of the assembly that they need and that are not known.
    pub missing: Vec<Part>,
    /// True if the sensor compares an observation with the one before, which a single assembly does not have.
    pub remembers: bool,
    /// The parameter that it needs and the recording does not have, or why it would take too long.
    pub lacks: Option<String>,
}

impl LeftOut {
    /// A sensor of which nothing could be measured.
    fn whole(sensor: &'static str, why: &'static str) -> LeftOut {
        LeftOut {
            sensor,
            columns: Vec::new(),
            missing: Vec::new(),
            remembers: false,
            lacks: Some(why.into()),
        }
    }
}

/// `fabric (strong_fraction): the data have no normal forces`.
impl std::fmt::Display for LeftOut {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.sensor)?;
        if !self.columns.is_empty() {
            write!(f, " ({})", self.columns.join(", "))?;
        }
        if self.remembers {
            return write!(f, ": it compares two observations of a test, and there is only one");
        }
        if let (Some(what), true) = (&self.lacks, self.missing.is_empty()) {
            return write!(f, ": {what}");
        }
        let names: Vec<&str> = self.missing.iter().map(|part| part.name()).collect();
        write!(f, ": the data have no {}", names.join(", no "))
    }
}
