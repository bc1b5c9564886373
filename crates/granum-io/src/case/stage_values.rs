//! Reads the values of a stage of a case file: numbers, words, drives, constraints, ends.

use std::ops::Range;

use granum_dem::config::Spacing;
use granum_dem::loading::{Constraint, Drive, Measure, Ramp, RecordedStates, Target, Turns, Until};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::suggestion::meant;
use super::unit::dimension;
use granum_core::quantity::{Dimension, format_number, parse_quantity};

/// A value with its position in the file.
pub(super) type Node<'a> = Spanned<DeValue<'a>>;

/// Arc length of strain over which a state is critical, unless a case says otherwise.
pub const CRITICAL_WINDOW: f64 = 0.05;
/// Change of q/p in it below which the state is critical, unless a case says otherwise.
pub const CRITICAL_STRESS_RATIO: f64 = 0.02;
/// Change of the volumetric strain in it below which the state is critical, unless a case says otherwise.
pub const CRITICAL_VOLUMETRIC_STRAIN: f64 = 0.002;
/// Keys of the end condition `critical_state`, with their defaults.
const CRITICAL: [(&str, f64); 3] = [
    ("window", CRITICAL_WINDOW),
    ("stress_ratio", CRITICAL_STRESS_RATIO),
    ("volumetric_strain", CRITICAL_VOLUMETRIC_STRAIN),
];

/// A mistake: its position, what is wrong, and what would be right.
pub(super) struct Mistake(pub(super) Range<usize>, pub(super) String, pub(super) Option<String>);

pub(super) type Parsed<T> = Result<T, Mistake>;

/// The text of a number or string.
pub(super) fn scalar(value: &Node<'_>) -> Parsed<String> {
    match value.get_ref() {
        DeValue::String(text) => Ok(text.to_string()),
        DeValue::Float(number) => Ok(number.as_str().replace('_', "")),
        DeValue::Integer(number) if number.radix() == 10 => Ok(number.as_str().replace('_', "")),
        other => {
            Err(Mistake(value.span(), format!("is of type {}; it must be a number", other.type_str()), None))
        }
    }
}

pub(super) fn text(value: &Node<'_>) -> Parsed<String> {
    match value.get_ref() {
        DeValue::String(text) => Ok(text.to_string()),
        other => {
            Err(Mistake(value.span(), format!("is of type {}; it must be text", other.type_str()), None))
        }
    }
}

pub(super) fn boolean(value: &Node<'_>) -> Parsed<bool> {
    match value.get_ref() {
        DeValue::Boolean(yes) => Ok(*yes),
        other => {
            let why = format!("is of type {}; it must be true or false", other.type_str());
            Err(Mistake(value.span(), why, None))
        }
    }
}

pub(super) fn number(value: &Node<'_>, dimension: Dimension, [low, high]: [f64; 2]) -> Parsed<f64> {
    let wrong = |why: String| Mistake(value.span(), why, None);
    let number = parse_quantity(&scalar(value)?, dimension).map_err(wrong)? + 0.0;
    if (low..=high).contains(&number) {
        return Ok(number);
    }
    let unit = dimension.si_unit();
    let unit = if unit.is_empty() { unit } else { format!(" {unit}") };
    let (low, high) = (format_number(low), format_number(high));
    Err(wrong(format!("is out of bounds; it must be from {low}{unit} to {high}{unit}")))
}

/// A whole number within bounds.
pub(super) fn whole(value: &Node<'_>, bounds: [f64; 2]) -> Parsed<u64> {
    let count = number(value, Dimension::NUMBER, bounds)?;
    if count.fract() != 0.0 {
        return Err(Mistake(value.span(), "is not a whole number".into(), None));
    }
    Ok(count as u64)
}

/// The texts of a list of numbers.
pub(super) fn numbers(value: &Node<'_>) -> Parsed<Vec<String>> {
    match value.get_ref() {
        DeValue::Array(items) => items.iter().map(scalar).collect(),
        _ => Err(Mistake(value.span(), "is not a list of numbers".into(), Some("e.g. [0.01, 0.02]".into()))),
    }
}

pub(super) const ANY_STRESS: [f64; 2] = [-1e12, 1e12];
pub(super) const ANY_RATE: [f64; 2] = [-1e30, 1e30];
/// A weight of a strain in a constraint is a stress over a strain, which can be small.
const ANY_COEFFICIENT: [f64; 2] = [-1e30, 1e30];

/// The keys of an inner table; any other key is a mistake.
pub(super) fn inner<'t, 'a>(value: &'t Node<'a>, known: &[&str]) -> Parsed<&'t DeTable<'a>> {
    let DeValue::Table(table) = value.get_ref() else {
        let help = format!("write {{ {} = ... }}", known.first().unwrap_or(&"key"));
        return Err(Mistake(value.span(), "is not a table".into(), Some(help)));
    };
    match table.keys().find(|key| !known.contains(&key.get_ref().as_ref())) {
        None => Ok(table),
        Some(key) => {
            let help = meant(key.get_ref(), known.iter().copied());
            Err(Mistake(key.span(), "is not one of its keys".into(), Some(help)))
        }
    }
}

/// The drive of a component, and true if it is a strain rate with its unit.
pub(super) fn drive(value: &Node<'_>) -> Parsed<(Drive, bool)> {
    if let DeValue::String(word) = value.get_ref() {
        return match word.as_ref() {
            "fixed" => Ok((Drive::Fixed, false)),
            "free" => Ok((Drive::Free, false)),
            _ => {
                let help = "it must be \"fixed\", \"free\", or a table such as { rate = 1 } or { stress = \"100 kPa\" }";
                Err(Mistake(value.span(), "is not known".into(), Some(help.into())))
            }
        };
    }
    let table =
        inner(value, &["rate", "stress", "stress_rate", "strain_to", "strain_by", "stress_to", "stress_by"])?;
    if let Some(ramp) = ramp(table, ["strain_to", "strain_by"], Dimension::NUMBER)? {
        alone(table, value)?;
        return Ok((Drive::Ramp(ramp), false));
    }
    if let Some(ramp) = ramp(table, ["stress_to", "stress_by"], Dimension::STRESS)? {
        alone(table, value)?;
        return Ok((Drive::Stress(Target::ramp(ramp)), false));
    }
    match (table.get("rate"), table.get("stress"), table.get("stress_rate")) {
        (Some(rate), None, None) => {
            let absolute = matches!(rate.get_ref(), DeValue::String(_));
            let unit = if absolute { Dimension::RATE } else { Dimension::NUMBER };
            Ok((Drive::Rate(number(rate, unit, [-1e9, 1e9])?), absolute))
        }
        (None, None, None) | (Some(_), ..) => {
            let help = "give rate, or stress with or without stress_rate, or one of strain_to, strain_by, stress_to, stress_by";
            Err(Mistake(value.span(), "does not set a rate, a stress or a ramp".into(), Some(help.into())))
        }
        (None, stress, rate) => Ok((Drive::Stress(target(stress, rate, Dimension::STRESS_RATE)?), false)),
    }
}

/// A stress, which may be "current", and its rate of change.
pub(super) fn target(
    stress: Option<&Node<'_>>,
    rate: Option<&Node<'_>>,
    rate_unit: Dimension,
) -> Parsed<Target> {
    let value = match stress.map(|value| (value, value.get_ref())) {
        None => None,
        Some((_, DeValue::String(word))) if word == "current" => None,
        Some((value, _)) => Some(number(value, Dimension::STRESS, ANY_STRESS)?),
    };
    let rate = rate.map_or(Ok(0.0), |rate| number(rate, rate_unit, ANY_RATE))?;
    let target = value.map_or_else(Target::current, Target::held);
    Ok(target.moving(rate))
}

/// The end of a ramp, by the keys for a value and for a change, if one is given.
fn ramp(table: &DeTable<'_>, [to, by]: [&str; 2], unit: Dimension) -> Parsed<Option<Ramp>> {
    let end = |key: &str| table.get(key).map(|value| number(value, unit, ANY_STRESS)).transpose();
    Ok(end(to)?.map(Ramp::To).or(end(by)?.map(Ramp::By)))
}

/// The end of a ramp says all that is to be said.
fn alone(table: &DeTable<'_>, value: &Node<'_>) -> Parsed<()> {
    if table.len() == 1 {
        return Ok(());
    }
    let help = "a ramp starts from the present value and needs only its end: remove the other keys";
    Err(Mistake(value.span(), "has too many keys".into(), Some(help.into())))
}

pub(super) fn six(value: &Node<'_>, dimension: Dimension) -> Parsed<[f64; 6]> {
    let wrong = || {
        let why = "is not a list of six numbers, one each for xx, yy, zz, yz, zx, xy";
        Mistake(value.span(), why.into(), None)
    };
    let DeValue::Array(items) = value.get_ref() else { return Err(wrong()) };
    let numbers: Vec<f64> =
        items.iter().map(|item| number(item, dimension, ANY_COEFFICIENT)).collect::<Parsed<_>>()?;
    numbers.try_into().map_err(|_| wrong())
}

pub(super) fn constraint(value: &Node<'_>) -> Parsed<Constraint> {
    let table = inner(value, &["stress", "strain", "value", "rate", "value_to", "value_by", "moves"])?;
    let list = |key: &str, unit| table.get(key).map_or(Ok([0.0; 6]), |value| six(value, unit));
    let stress = list("stress", Dimension::NUMBER)?;
    let held = stress != [0.0; 6];
    let strain = list("strain", if held { Dimension::STRESS } else { Dimension::NUMBER })?;
    if !held && strain == [0.0; 6] {
        let help = "give stress or strain, e.g. stress = [1, 1, 1, 0, 0, 0]";
        return Err(Mistake(value.span(), "has no weights".into(), Some(help.into())));
    }
    let of_stresses = ["value", "value_to", "value_by", "moves"].iter().find_map(|key| table.get(*key));
    if let (false, Some(value)) = (held, of_stresses) {
        return Err(Mistake(value.span(), "can only be given for a combination of stresses".into(), None));
    }
    let unit = if held { Dimension::STRESS_RATE } else { Dimension::NUMBER };
    let target = match ramp(table, ["value_to", "value_by"], Dimension::STRESS)? {
        Some(_) if table.get("value").or(table.get("rate")).is_some() => {
            let help = "value and rate cannot be given together with the end of a ramp";
            return Err(Mistake(value.span(), "has too many keys".into(), Some(help.into())));
        }
        Some(ramp) => Target::ramp(ramp),
        None => target(table.get("value"), table.get("rate"), unit)?,
    };
    let moves = table.get("moves").map(|value| six(value, Dimension::NUMBER)).transpose()?;
    Ok(Constraint { strain, stress, target, moves })
}

/// The measure with a given name.
pub(super) fn measure(name: &str, span: Range<usize>) -> Parsed<Measure> {
    Measure::named(name).ok_or_else(|| {
        let names = Measure::ALL.iter().map(|(name, _, _)| *name);
        Mistake(span, "is not a measure".into(), Some(meant(name, names.chain(OTHER_ENDS.iter().copied()))))
    })
}

/// Ends of a stage beside the values of measures.
pub(super) const OTHER_ENDS: &[&str] = &[
    "reversals",
    "ramp_over",
    "pore_pressure_ratio",
    "double_amplitude",
    "unbalanced_force",
    "critical_state",
];

pub(super) fn end(key: &str, value: &Node<'_>) -> Parsed<Until> {
    match key {
        "ramp_over" => match boolean(value)? {
            true => Ok(Until::RampOver),
            false => Err(Mistake(value.span(), "sets no end".into(), Some("leave it out".into()))),
        },
        "pore_pressure_ratio" => Ok(Until::PorePressureRatio(number(value, Dimension::NUMBER, [1e-6, 1.0])?)),
        "double_amplitude" => {
            let table = inner(value, &["measure", "value"])?;
            let measure = measured(table, value.span())?;
            let Some(far) = table.get("value") else {
                let help = "e.g. double_amplitude = { measure = \"xx_strain\", value = 0.05 }";
                return Err(Mistake(value.span(), "needs a value".into(), Some(help.into())));
            };
            let value = number(far, dimension(measure.unit()), [1e-12, 1e12])?;
            Ok(Until::DoubleAmplitude { measure, value })
        }
        "reversals" => Ok(Until::Reversals(whole(value, [1.0, 1e9])?)),
        "unbalanced_force" => {
            Ok(Until::AtRest { unbalanced_force: number(value, Dimension::NUMBER, [1e-9, 1.0])? })
        }
        "critical_state" => {
            let table = inner(value, &CRITICAL.map(|(name, _)| name))?;
            let [window, stress_ratio, volumetric_strain] = CRITICAL.map(|(name, default)| {
                table.get(name).map_or(Ok(default), |value| number(value, Dimension::NUMBER, [1e-9, 100.0]))
            });
            Ok(Until::CriticalState {
                window: window?,
                stress_ratio: stress_ratio?,
                volumetric_strain: volumetric_strain?,
            })
        }
        _ => {
            let measure = measure(key, value.span())?;
            Ok(Until::Reaches { measure, value: number(value, dimension(measure.unit()), ANY_STRESS)? })
        }
    }
}

pub(super) fn measured(table: &DeTable<'_>, span: Range<usize>) -> Parsed<Measure> {
    match table.get("measure") {
        None => Ok(Measure::ArcLength),
        Some(value) => measure(&text(value)?, value.span()),
    }
    .map_err(|Mistake(at, why, help)| Mistake(if at.is_empty() { span } else { at }, why, help))
}

pub(super) fn turns(value: &Node<'_>) -> Parsed<Turns> {
    let table = inner(value, &["measure", "high", "low"])?;
    let measure = measured(table, value.span())?;
    let unit = dimension(measure.unit());
    let (Some(high), Some(low)) = (table.get("high"), table.get("low")) else {
        let help = "e.g. turns = { measure = \"xx_strain\", high = 0.01, low = -0.01 }";
        return Err(Mistake(value.span(), "needs high and low".into(), Some(help.into())));
    };
    let (high, low) = (number(high, unit, ANY_STRESS)?, number(low, unit, ANY_STRESS)?);
    if low >= high {
        return Err(Mistake(value.span(), "has a low that is not below its high".into(), None));
    }
    Ok(Turns { measure, high, low })
}

pub(super) fn record(value: &Node<'_>) -> Parsed<RecordedStates> {
    let table = inner(value, &["measure", "every", "states", "end", "at"])?;
    let measure = measured(table, value.span())?;
    let unit = dimension(measure.unit());
    let positive = |value: &Node<'_>| number(value, unit, [1e-12, 1e12]);
    match (table.get("every"), table.get("states"), table.get("end"), table.get("at")) {
        (Some(every), None, None, None) => Ok(RecordedStates::every(measure, positive(every)?)),
        (None, Some(states), Some(end), None) => {
            let count = number(states, Dimension::NUMBER, [1.0, 1e6])?;
            Ok(RecordedStates::equal(measure, count as usize, number(end, unit, [0.0, 1e12])?))
        }
        (None, None, None, Some(places)) => {
            let DeValue::Array(items) = places.get_ref() else {
                return Err(Mistake(places.span(), "is not a list".into(), None));
            };
            let places: Vec<f64> = items.iter().map(positive).collect::<Parsed<_>>()?;
            if places.is_empty() || places.windows(2).any(|pair| pair[0] >= pair[1]) {
                return Err(Mistake(value.span(), "does not increase from value to value".into(), None));
            }
            Ok(RecordedStates { measure, states: 0, spacing: Spacing::Strains(places), end: f64::INFINITY })
        }
        _ => {
            let help = "give every, or states and end, or at = [...]";
            Err(Mistake(value.span(), "does not set which states are recorded".into(), Some(help.into())))
        }
    }
}
