//! Writing the tables `[[stage]]` of a case as TOML in SI units.

use granum_dem::config::Spacing;
use granum_dem::loading::preset::{Given, PathValue, Preset};
use granum_dem::loading::{
    Drive, Kinematics, Ramp, RecordedStates, Speed, Stage, Start, Target, Turns, Until,
};
use granum_dem::servo::COMPONENTS;

use super::case_stage::CaseStage;
use super::history;
use granum_core::quantity::format_number;

impl CaseStage {
    /// The table as TOML in SI units, below a heading of such a name.
    pub(super) fn toml(&self, heading: &str) -> String {
        let body = match self {
            CaseStage::Path { path, parameters, resets, until } => {
                let until = if until.is_empty() { String::new() } else { ends_toml(until) };
                format!("{}{until}", path_toml(path, parameters, *resets))
            }
            CaseStage::Control(stage) => stage_toml(stage),
            CaseStage::Repeat { times, stages } => {
                let inner: String = stages
                    .iter()
                    .map(|stage| format!("\n{}", stage.toml(&format!("{heading}.stage"))))
                    .collect();
                format!("repeat = {times}\n{inner}")
            }
        };
        format!("[[{heading}]]\n{body}")
    }
}

fn path_toml(path: &Preset, parameters: &Given, resets: bool) -> String {
    let mut text = format!("path = \"{}\"\n", path.name);
    for parameter in path.parameters() {
        let key = parameter.key;
        match parameters.get(key) {
            None => {}
            Some(PathValue::Number(value)) => {
                let unit =
                    if parameter.unit == "1" { String::new() } else { format!("  # {}", parameter.unit) };
                text.push_str(&format!("{key} = {}{unit}\n", format_number(*value)));
            }
            Some(PathValue::Word(word)) => text.push_str(&format!("{key} = {}\n", toml_text(word))),
            Some(PathValue::List(values)) => text.push_str(&format!("{key} = {}\n", list(values))),
            Some(PathValue::History(values)) => text.push_str(&history::toml(values)),
        }
    }
    if !resets {
        text.push_str("resets = false\n");
    }
    text
}

fn list(values: &[f64]) -> String {
    format!("[{}]", values.iter().copied().map(format_number).collect::<Vec<_>>().join(", "))
}

/// The end of a ramp, by the keys for a value and for a change.
fn ramp(ramp: Ramp, key: &str) -> String {
    match ramp {
        // Zero has one sign in files.
        Ramp::To(value) => format!("{key}_to = {}", format_number(value + 0.0)),
        Ramp::By(change) => format!("{key}_by = {}", format_number(change + 0.0)),
    }
}

fn target(target: &Target, value: &str, rate: &str) -> Vec<String> {
    if let Some(end) = target.ramp {
        return vec![ramp(end, value)];
    }
    let mut parts: Vec<String> =
        target.value.map(|v| format!("{value} = {}", format_number(v + 0.0))).into_iter().collect();
    if target.rate != 0.0 || parts.is_empty() {
        parts.push(format!("{rate} = {}", format_number(target.rate + 0.0)));
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
            Drive::Rate(rate) => format!("{{ rate = {} }}", format_number(*rate + 0.0)),
            Drive::Ramp(end) => format!("{{ {} }}", ramp(*end, "strain")),
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
    text.push_str(&ends_toml(&stage.until));
    if let Some(most) = stage.most_arc_length {
        text.push_str(&format!("most_arc_length = {}\n", format_number(most)));
    }
    if let Some(record) = record_toml(&stage.record) {
        text.push_str(&format!("record = {{ {record} }}\n"));
    }
    text.push_str(&format!("settling = {}\nresets = {}\n", stage.settling, stage.resets));
    if stage.density_scaling != 1.0 {
        text.push_str(&format!("density_scaling = {}\n", format_number(stage.density_scaling)));
    }
    match stage.start {
        Start::Here => {}
        Start::Kept => text.push_str("start = \"kept\"\n"),
        Start::Back => text.push_str("start = \"back\"\n"),
    }
    text
}

/// The end conditions of a stage as a line.
pub(super) fn ends_toml(until: &[Until]) -> String {
    format!("until = {{ {} }}\n", until.iter().map(until_toml).collect::<Vec<_>>().join(", "))
}

fn until_toml(until: &Until) -> String {
    match *until {
        Until::Reaches { measure, value } => format!("{} = {}", measure.name(), format_number(value)),
        Until::Reversals(count) => format!("reversals = {count}"),
        Until::RampOver => "ramp_over = true".into(),
        Until::PorePressureRatio(ratio) => format!("pore_pressure_ratio = {}", format_number(ratio)),
        Until::DoubleAmplitude { measure, value } => {
            let (name, value) = (measure.name(), format_number(value));
            format!("double_amplitude = {{ measure = \"{name}\", value = {value} }}")
        }
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

fn record_toml(record: &RecordedStates) -> Option<String> {
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

/// Text in quotes, with the escapes that TOML requires.
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
