//! Sensors that are functions of Python.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};

use granum::Registry;
use granum_core::Assembly as Observed;
use granum_dem::config::Recording;
use granum_sensors::{Averaging, Bins, Memory, Observation, Sensor, SensorColumn, SensorDescription, Values};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyMapping, PyTuple};

use crate::arrays;
use crate::assembly::Assembly;
use crate::detached::raise;
use crate::errors;

/// Largest number of bins of a histogram.
const MOST_BINS: f64 = 1e6;

/// A sensor that is a function of Python.
struct PythonSensor {
    description: SensorDescription,
    bins: Vec<Bins>,
    measure: Py<PyAny>,
}

/// What the function gave for one assembly.
struct Measured {
    row: Vec<f64>,
    counts: Vec<Vec<f64>>,
    memory: Memory,
}

/// A word that stays: names of sensors and columns do so in granum. Each is kept once, however many runs have it.
fn kept(word: &str) -> &'static str {
    static WORDS: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    let mut words = WORDS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = words.get(word) {
        return known;
    }
    let new: &'static str = Box::leak(word.to_owned().into_boxed_str());
    words.insert(new);
    new
}

fn text(object: &Bound<'_, PyAny>, field: &str) -> PyResult<&'static str> {
    Ok(kept(&object.getattr(field)?.extract::<String>()?))
}

/// The entries of a mapping that a sensor has.
fn entries<'py>(sensor: &Bound<'py, PyAny>, field: &str) -> PyResult<Vec<(&'static str, Bound<'py, PyAny>)>> {
    let mapping = sensor.getattr(field)?;
    let Ok(mapping) = mapping.cast::<PyMapping>() else {
        let kind = mapping.get_type().name()?;
        return Err(PyTypeError::new_err(format!("the {field} of a sensor are a dict, not {kind}")));
    };
    let entry = |item: Bound<'py, PyAny>| {
        let (name, value): (String, Bound<'py, PyAny>) = item.extract()?;
        Ok((kept(&name), value))
    };
    mapping.items()?.iter().map(entry).collect()
}

fn column(name: &'static str, value: &Bound<'_, PyAny>) -> PyResult<SensorColumn> {
    if let Ok(unit) = value.extract::<String>() {
        return Ok(SensorColumn::new(name, kept(&unit), ""));
    }
    let averaging: String = value.getattr("averaging")?.extract()?;
    let averaging = match averaging.as_str() {
        "mean" => Averaging::Mean,
        "root-mean-square" => Averaging::RootMeanSquare,
        "largest" => Averaging::Largest,
        _ => {
            let message = "the averaging of a column is mean, root-mean-square or largest";
            return Err(errors::of_value(value.py(), name, averaging, message));
        }
    };
    Ok(SensorColumn::new(name, text(value, "unit")?, text(value, "meaning")?).averaged(averaging))
}

fn bins(name: &'static str, value: &Bound<'_, PyAny>) -> PyResult<Bins> {
    let number = |field: &str| value.getattr(field)?.extract::<f64>();
    let (width, smallest, largest) = (number("width")?, number("smallest")?, number("largest")?);
    if !(width > 0.0 && smallest < largest && (largest - smallest) / width <= MOST_BINS) {
        let message = format!(
            "bins of the width {width} from {smallest} to {largest} cannot be; the width is positive, the range rises, and there are at most \
             {MOST_BINS} bins"
        );
        return Err(errors::of_value(value.py(), name, width.to_string(), message));
    }
    Ok(Bins::new(name, text(value, "quantity")?, text(value, "unit")?).width(width).range(smallest, largest))
}

impl PythonSensor {
    fn new(sensor: &Bound<'_, PyAny>) -> PyResult<PythonSensor> {
        let name = text(sensor, "name")?;
        let columns = entries(sensor, "columns")?;
        let columns =
            columns.iter().map(|(name, value)| column(name, value)).collect::<PyResult<Vec<_>>>()?;
        let histograms = entries(sensor, "histograms")?;
        let bins = histograms.iter().map(|(name, value)| bins(name, value)).collect::<PyResult<_>>()?;
        let measure = sensor.getattr("measure")?;
        if !measure.is_callable() {
            return Err(PyTypeError::new_err(format!("what the sensor {name} measures with is no function")));
        }
        let description = SensorDescription::new(name, text(sensor, "meaning")?).columns(columns);
        let remembers: bool = sensor.getattr("remembers")?.extract()?;
        let description = if remembers { description.remembering() } else { description };
        Ok(PythonSensor { description, bins, measure: measure.unbind() })
    }

    fn wrong(&self, what: &str) -> PyErr {
        PyTypeError::new_err(format!("the sensor {} returned {what}", self.description.name))
    }

    /// Calls the function.
    fn call(&self, py: Python<'_>, assembly: Arc<Observed>, memory: &Memory) -> PyResult<Measured> {
        let assembly = Bound::new(py, Assembly::shared(assembly))?;
        let function = self.measure.bind(py);
        if !self.description.remembers {
            return self.measured(&function.call1((assembly,))?);
        }
        let before = arrays::reals(py, memory.clone(), vec![memory.len()])?;
        let answer = function.call1((assembly, before))?;
        let pair = answer.cast::<PyTuple>().ok().filter(|pair| pair.len() == 2);
        let pair = pair.ok_or_else(|| {
            self.wrong("no pair; one that remembers returns its values and what to remember")
        })?;
        let mut measured = self.measured(&pair.get_item(0)?)?;
        let (numbers, shape) = arrays::numbers(self.description.name, &pair.get_item(1)?)?;
        arrays::check_finite(py, self.description.name, &numbers, &shape)?;
        measured.memory = numbers;
        Ok(measured)
    }

    /// The values that the function returned.
    fn measured(&self, answer: &Bound<'_, PyAny>) -> PyResult<Measured> {
        let columns = &self.description.columns;
        let Ok(values) = answer.cast::<PyMapping>() else {
            return match columns.as_slice() {
                [only] if self.bins.is_empty() => {
                    let row = vec![self.number(only.name, answer)?];
                    Ok(Measured { row, counts: Vec::new(), memory: Memory::new() })
                }
                _ => Err(self.wrong(&format!("{}, not a dict of its values", answer.get_type().name()?))),
            };
        };
        let missing = |name: &str| self.wrong(&format!("no {name}"));
        let item = |name: &str| values.get_item(name).map_err(|_| missing(name));
        let row = columns.iter().map(|column| self.number(column.name, &item(column.name)?));
        let row = row.collect::<PyResult<Vec<f64>>>()?;
        let counts = self.bins.iter().map(|bins| Ok(arrays::numbers(bins.name, &item(bins.name)?)?.0));
        let counts = counts.collect::<PyResult<Vec<Vec<f64>>>>()?;
        if values.len()? != row.len() + counts.len() {
            let known =
                columns.iter().map(|column| column.name).chain(self.bins.iter().map(|bins| bins.name));
            let known: Vec<&str> = known.collect();
            for name in values.keys()? {
                let name: String = name.extract()?;
                if !known.contains(&name.as_str()) {
                    return Err(self.wrong(&format!("{name}, which is none of its columns and histograms")));
                }
            }
        }
        Ok(Measured { row, counts, memory: Memory::new() })
    }

    fn number(&self, column: &'static str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
        let Ok(number) = value.extract::<f64>() else {
            return Err(self.wrong(&format!("{} for {column}, not a number", value.get_type().name()?)));
        };
        if number.is_finite() {
            return Ok(number);
        }
        let message = format!("the sensor {} returned {number}, which is not finite", self.description.name);
        Err(errors::of_value(value.py(), column, number.to_string(), message))
    }
}

impl Sensor for PythonSensor {
    fn description(&self) -> SensorDescription {
        self.description.clone()
    }

    fn histograms(&self, _: &Recording) -> Vec<Bins> {
        self.bins.clone()
    }

    /// An assembly without grains, which no test has, is not shown to the function: its values are zero.
    fn measure(&self, observation: &Observation, memory: &mut Memory, values: &mut Values) {
        if observation.assembly.bodies.is_empty() {
            values.extend(self.description.columns.iter().map(|_| 0.0));
            return;
        }
        let assembly = Arc::new(observation.assembly.clone());
        match Python::try_attach(|py| self.call(py, assembly, memory)) {
            Some(Ok(measured)) => {
                values.extend(measured.row);
                for (number, counts) in measured.counts.into_iter().enumerate() {
                    values.count(number, counts);
                }
                *memory = measured.memory;
            }
            Some(Err(error)) => raise(error),
            None => values.give_up("the interpreter of Python has ended"),
        }
    }
}

/// Sensors of Python, and the names of sensors that are to be recorded.
pub struct Sensors {
    pub registry: Registry,
    pub names: Vec<String>,
}

impl Sensors {
    /// Granum's own, with those of a list: names, and `granum.Sensor`s, which are added to the registry.
    ///
    /// # Errors
    /// `granum.CaseError` if a name is taken or a declaration contradicts itself, `TypeError` for what is no sensor.
    pub fn from_list(py: Python<'_>, given: Option<&Bound<'_, PyAny>>) -> PyResult<Sensors> {
        let mut found = Sensors { registry: Registry::standard(), names: Vec::new() };
        let Some(given) = given else { return Ok(found) };
        let class = py.import("granum.sensors")?.getattr("Sensor")?;
        let wrong = |what: &Bound<'_, PyAny>| -> PyErr {
            let kind = what.get_type().name().map_or_else(|_| String::new(), |name| format!(", not {name}"));
            PyTypeError::new_err(format!("sensors are a list of granum.Sensor and names of sensors{kind}"))
        };
        if given.extract::<String>().is_ok() || given.is_instance(&class)? {
            return Err(wrong(given));
        }
        for sensor in given.try_iter().map_err(|_| wrong(given))? {
            let sensor = sensor?;
            if let Ok(name) = sensor.extract::<String>() {
                found.names.push(name);
                continue;
            }
            if !sensor.is_instance(&class)? {
                return Err(wrong(&sensor));
            }
            let sensor = PythonSensor::new(&sensor)?;
            let name = sensor.description.name;
            found.registry = found
                .registry
                .with_sensor(sensor)
                .map_err(|error| errors::of_value(py, "sensors", name, error.to_string()))?;
            found.names.push(name.into());
        }
        Ok(found)
    }

    /// Adds them to those that a recording names.
    pub fn record(&self, recording: &mut Recording) {
        for name in &self.names {
            if !recording.sensors.contains(name) {
                recording.sensors.push(name.clone());
            }
        }
    }
}
