//! The tables `[[stage]]` of a case: named paths with their parameters, or a control written out.

use std::collections::BTreeMap;

use granum_dem::config::{Recording, Spacing};
use granum_dem::loading::preset::{self, Parameter, Preset};
use granum_dem::loading::{Drive, Kinematics, Record, Speed, Stage, Target, Turns, Until};
use granum_dem::servo::COMPONENTS;
use serde::{Deserialize, Serialize};

use super::Case;
use crate::error::{Error, Result};
use granum_core::names::nearest;
use granum_core::quantity::{Dimension, format_number, parse_quantity};

/// One table `[[stage]]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CaseStage {
    /// A named path.
    Path {
        /// Its name.
        name: String,
        /// Its parameters in SI units; those not given have their defaults.
        parameters: BTreeMap<String, f64>,
    },
    /// A stage written out.
    Control(Box<Stage>),
}

impl CaseStage {
    /// What it comes to.
    pub fn stages(&self) -> Vec<Stage> {
        match self {
            CaseStage::Path { name, parameters } => {
                preset::named(name).map_or_else(Vec::new, |preset| preset.expand(parameters))
            }
            CaseStage::Control(stage) => vec![(**stage).clone()],
        }
    }

    /// The table as TOML in SI units, with its heading.
    pub(super) fn toml(&self) -> String {
        let body = match self {
            CaseStage::Path { name, parameters } => path_toml(name, parameters),
            CaseStage::Control(stage) => stage_toml(stage),
        };
        format!("[[stage]]\n{body}")
    }
}

/// The dimension of a unit of a parameter or measure.
pub(super) fn dimension(unit: &str) -> Dimension {
    match unit {
        "Pa" => Dimension::STRESS,
        "Pa/s" => Dimension::STRESS_RATE,
        "s" => Dimension::TIME,
        "1/s" => Dimension::RATE,
        _ => Dimension::NUMBER,
    }
}

/// Reads a value of a parameter of a path.
///
/// # Errors
/// A sentence that goes on from "key = value".
pub(super) fn parse_parameter(parameter: &Parameter, text: &str) -> std::result::Result<f64, String> {
    let value = parse_quantity(text, dimension(parameter.unit))? + 0.0;
    let [low, high] = parameter.bounds;
    if (low..=high).contains(&value) {
        return Ok(value);
    }
    Err(format!("is out of bounds; it must be {}", bounds(parameter)))
}

/// "from 0.001 Pa to 1e11 Pa".
pub(super) fn bounds(parameter: &Parameter) -> String {
    let unit = if parameter.unit == "1" { String::new() } else { format!(" {}", parameter.unit) };
    let [low, high] = parameter.bounds.map(format_number);
    format!("from {low}{unit} to {high}{unit}")
}

/// "did you mean X?" or what there is.
pub(super) fn meant<'a>(wrong: &str, names: impl Iterator<Item = &'a str> + Clone) -> String {
    match nearest(wrong, names.clone()) {
        Some(name) => format!("did you mean {name}?"),
        None => format!("known here: {}", names.collect::<Vec<_>>().join(", ")),
    }
}

fn path_toml(name: &str, parameters: &BTreeMap<String, f64>) -> String {
    let mut text = format!("path = \"{name}\"\n");
    let declared = preset::named(name).map_or(&[][..], |preset: &Preset| preset.parameters);
    for parameter in declared {
        if let Some(value) = parameters.get(parameter.key) {
            let unit = if parameter.unit == "1" { String::new() } else { format!("  # {}", parameter.unit) };
            text.push_str(&format!("{} = {}{unit}\n", parameter.key, format_number(*value)));
        }
    }
    text
}

fn list(values: &[f64]) -> String {
    format!("[{}]", values.iter().copied().map(format_number).collect::<Vec<_>>().join(", "))
}

fn target(target: &Target, value: &str, rate: &str) -> Vec<String> {
    let mut parts: Vec<String> =
        target.value.map(|v| format!("{value} = {}", format_number(v))).into_iter().collect();
    if target.rate != 0.0 || parts.is_empty() {
        parts.push(format!("{rate} = {}", format_number(target.rate)));
    }
    parts
}

fn stage_toml(stage: &Stage) -> String {
    let mut text = format!("name = {}\n", toml_text(&stage.name));
    let control = &stage.control;
    match control.speed {
        Speed::InertialNumber { number, .. } => {
            text.push_str(&format!("inertial_number = {}\n", format_number(number)));
        }
        Speed::StrainRate(rate) => text.push_str(&format!("strain_rate = {}  # 1/s\n", format_number(rate))),
    }
    for (name, drive) in COMPONENTS.iter().zip(&control.components) {
        let drive = match drive {
            Drive::Fixed => "\"fixed\"".to_string(),
            Drive::Free => "\"free\"".to_string(),
            Drive::Rate(rate) => format!("{{ rate = {} }}", format_number(*rate)),
            Drive::Stress(held) => format!("{{ {} }}", target(held, "stress", "stress_rate").join(", ")),
        };
        text.push_str(&format!("{name} = {drive}\n"));
    }
    let constraints: Vec<String> = control
        .constraints
        .iter()
        .flatten()
        .map(|constraint| {
            let mut parts = Vec::new();
            if constraint.strain != [0.0; 6] {
                parts.push(format!("strain = {}", list(&constraint.strain)));
            }
            if constraint.stress != [0.0; 6] {
                parts.push(format!("stress = {}", list(&constraint.stress)));
            }
            parts.extend(target(&constraint.target, "value", "rate"));
            parts.extend(constraint.moves.map(|moves| format!("moves = {}", list(&moves))));
            format!("  {{ {} }},\n", parts.join(", "))
        })
        .collect();
    if !constraints.is_empty() {
        text.push_str(&format!("constraint = [\n{}]\n", constraints.concat()));
    }
    if control.kinematics == Kinematics::SimpleShear {
        text.push_str("kinematics = \"simple-shear\"\n");
    }
    text.push_str(&format!("servo_limit = {}\n", format_number(control.servo_limit)));
    text.push_str(&format!("servo_response = {}\n", format_number(control.response)));
    if let Some(Turns { measure, high, low }) = stage.turns {
        let [high, low] = [high, low].map(format_number);
        text.push_str(&format!(
            "turns = {{ measure = \"{}\", high = {high}, low = {low} }}\n",
            measure.name()
        ));
    }
    text.push_str(&format!(
        "until = {{ {} }}\n",
        stage.until.iter().map(until_toml).collect::<Vec<_>>().join(", ")
    ));
    if let Some(most) = stage.most_arc_length {
        text.push_str(&format!("most_arc_length = {}\n", format_number(most)));
    }
    if let Some(record) = record_toml(&stage.record) {
        text.push_str(&format!("record = {{ {record} }}\n"));
    }
    text.push_str(&format!("settling = {}\nresets = {}\n", stage.settling, stage.resets));
    text
}

fn until_toml(until: &Until) -> String {
    match *until {
        Until::Reaches { measure, value } => format!("{} = {}", measure.name(), format_number(value)),
        Until::Reversals(count) => format!("reversals = {count}"),
        Until::AtRest { unbalanced_force } => {
            format!("unbalanced_force = {}", format_number(unbalanced_force))
        }
        Until::CriticalState { window, stress_ratio, volumetric_strain } => {
            let [window, ratio, strain] = [window, stress_ratio, volumetric_strain].map(format_number);
            format!(
                "critical_state = {{ window = {window}, stress_ratio = {ratio}, volumetric_strain = {strain} }}"
            )
        }
    }
}

fn record_toml(record: &Record) -> Option<String> {
    let measure = format!("measure = \"{}\"", record.measure.name());
    match &record.spacing {
        Spacing::Every(interval) => Some(format!("{measure}, every = {}", format_number(*interval))),
        Spacing::Equal => {
            Some(format!("{measure}, states = {}, end = {}", record.states, format_number(record.end)))
        }
        Spacing::Strains(places) if !places.is_empty() => Some(format!("{measure}, at = {}", list(places))),
        Spacing::Strains(_) | Spacing::Geometric(_) => None,
    }
}

/// Text in quotes, with what TOML needs escaped.
fn toml_text(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => quoted.push_str(&format!("\\u{:04X}", c as u32)),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

/// Keys of `[shear]` and `[recording]` that have no part in a case with stages.
pub(super) fn has_no_part(path: &str) -> bool {
    path.starts_with("shear.")
        || ["recording.states", "recording.first_strain", "recording.strains", "recording.snapshots"]
            .contains(&path)
}

impl Case {
    /// True if the test is given as stages, not as the section `[shear]`.
    pub fn has_stages(&self) -> bool {
        !self.stages.is_empty()
    }

    /// The stages of the test: those that are given, or the one of the paper's test.
    pub fn test_stages(&self) -> Vec<Stage> {
        if self.has_stages() {
            return self.stages.iter().flat_map(CaseStage::stages).collect();
        }
        vec![preset::antony2006(&self.shear, &self.recording, self.preparation.mean_stress)]
    }

    /// The same case with a named path in place of its test. Its parameters are given as text, as flags of the program are.
    ///
    /// # Errors
    /// [`Error::Value`] if there is no such path or parameter, or a text is no value for it.
    pub fn with_path(&self, name: &str, parameters: &[(&str, &str)]) -> Result<Case> {
        let wrong = |name: &str, value: &str, message: String| Error::Value {
            name: name.to_string(),
            value: value.to_string(),
            message,
        };
        let Some(preset) = preset::named(name) else {
            let help = meant(name, preset::all().iter().map(|preset| preset.name));
            return Err(wrong("path", name, format!("is no path; {help}")));
        };
        let mut case = self.clone();
        case.shear = Default::default();
        let Recording { looks, bin_width, largest_force, .. } = self.recording;
        let sensors = self.recording.sensors.clone();
        case.recording = Recording { looks, bin_width, largest_force, sensors, ..Recording::default() };
        case.stages = vec![CaseStage::Path { name: name.to_string(), parameters: BTreeMap::new() }];
        for (key, text) in parameters {
            if preset.parameter(key).is_none() {
                let help = meant(key, preset.parameters.iter().map(|parameter| parameter.key));
                return Err(wrong(key, text, format!("is no parameter of the path {name}; {help}")));
            }
            case.set(&format!("stage.1.{key}"), text)?;
        }
        Ok(case)
    }

    /// Sets a parameter of a stage that is a named path: `stage.1.axial_strain`, the first stage being 1.
    pub(super) fn set_stage(&mut self, path: &str, text: &str) -> Result<()> {
        let wrong =
            |message: String| Error::Value { name: path.to_string(), value: text.to_string(), message };
        let rest = path.strip_prefix("stage.").unwrap_or(path);
        let count = self.stages.len();
        let place = rest.split_once('.').and_then(|(number, key)| Some((number.parse::<usize>().ok()?, key)));
        let Some((number, key)) = place.filter(|(number, _)| (1..=count).contains(number)) else {
            let stages = match count {
                0 => "this case has no [[stage]]".to_string(),
                _ => format!("this case has the stages 1 to {count}"),
            };
            return Err(wrong(format!("is no key of a stage, as stage.1.axial_strain is; {stages}")));
        };
        let CaseStage::Path { name, parameters } = &mut self.stages[number - 1] else {
            return Err(wrong("belongs to a stage that is written out; change the case file".into()));
        };
        let preset = preset::named(name);
        let Some(parameter) = preset.and_then(|preset| preset.parameter(key)) else {
            let known = preset.map_or(&[][..], |preset| preset.parameters);
            let help = meant(key, known.iter().map(|parameter| parameter.key));
            return Err(wrong(format!("is no parameter of the path {name}; {help}")));
        };
        parameters.insert(key.to_string(), parse_parameter(parameter, text).map_err(wrong)?);
        Ok(())
    }

    /// The tables `[[stage]]` as TOML in SI units; empty without stages.
    pub fn stages_toml(&self) -> String {
        self.stages.iter().map(|stage| format!("\n{}", stage.toml())).collect()
    }

    /// Checks the stages: bounds of parameters, and that each control determines the strain rates.
    pub(super) fn check_stages(&self) -> Result<()> {
        for (k, stage) in self.stages.iter().enumerate() {
            if let CaseStage::Path { name, parameters } = stage {
                let Some(preset) = preset::named(name) else {
                    return Err(Error::Rule(format!("stage {}: there is no path {name:?}", k + 1)));
                };
                for (key, value) in parameters {
                    let text = format_number(*value);
                    let found = preset.parameter(key).map(|parameter| parse_parameter(parameter, &text));
                    if let Some(Err(message)) = found {
                        return Err(Error::Value {
                            name: format!("stage.{}.{key}", k + 1),
                            value: text,
                            message,
                        });
                    }
                }
            }
            for stage in stage.stages() {
                stage.control.check().map_err(|error| Error::Rule(format!("stage {}: {error}", k + 1)))?;
            }
        }
        Ok(())
    }
}
