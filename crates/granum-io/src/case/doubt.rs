//! Stresses and strains that are given as numbers without a unit and are far from those of the sample.
//!
//! A number without a unit is in SI units. A lateral stress of 50 for a sample at 100 kPa is thus 50 Pa, where 50 kPa was probably
//! meant, and an axial strain of 2 is 200 %, where 2 % was probably meant. Such a number is in doubt and needs a unit to be taken:
//!
//! - a stress that is not 0, of a tenth or less of the sample's mean stress or ten times it or more, unless another stress of the case
//!   that is not in doubt is within these bounds of it;
//! - a strain beyond 1;
//! - the mean stress of the sample itself below 1 kPa.

use granum_core::quantity::{Dimension, format_number, parse_quantity};
use granum_dem::loading::preset::{PathParameter, PathParameterKind};
use granum_dem::loading::{HistoryQuantity, Measure};

/// How many times smaller or larger a stress without a unit may be.
const FAR: f64 = 10.0;
/// Smallest mean stress of a sample, Pa, that needs no unit.
const SMALLEST_SAMPLE_STRESS: f64 = 1e3;
/// Largest strain that needs no unit.
const LARGEST_STRAIN: f64 = 1.0;
/// Key of the mean stress of the sample.
const SAMPLE_STRESS: &str = "preparation.mean_stress";

/// What a number stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum NumberKind {
    /// The mean stress of the sample.
    OfSample,
    /// Another stress.
    Stress,
    /// A strain.
    Strain,
}

impl NumberKind {
    pub(super) fn dimension(self) -> Dimension {
        if self == NumberKind::Strain { Dimension::NUMBER } else { Dimension::STRESS }
    }

    /// The kind of a key outside the tables of stages.
    pub(super) fn of_field(path: &str) -> Option<NumberKind> {
        match path {
            SAMPLE_STRESS => Some(NumberKind::OfSample),
            "preparation.compaction_stress" | "shear.mean_stress" => Some(NumberKind::Stress),
            "shear.deviator_strain" => Some(NumberKind::Strain),
            _ => None,
        }
    }

    /// The kind of a parameter of a path.
    pub(super) fn of_parameter(parameter: &PathParameter) -> Option<NumberKind> {
        let PathParameter { key, unit, kind, .. } = parameter;
        if !matches!(kind, PathParameterKind::Number | PathParameterKind::List) {
            return None;
        }
        match *unit {
            "Pa" if key.contains("stress") => Some(NumberKind::Stress),
            "1" if key.contains("strain") || ["at", "double_amplitude"].contains(key) => {
                Some(NumberKind::Strain)
            }
            _ => None,
        }
    }

    /// The kind of a measure; the arc length grows beyond 1 in many cycles and is no strain in this sense.
    pub(super) fn of_measure(measure: Measure) -> Option<NumberKind> {
        match measure.unit() {
            "Pa" => Some(NumberKind::Stress),
            _ if measure.name().ends_with("strain") => Some(NumberKind::Strain),
            _ => None,
        }
    }

    pub(super) fn of_quantity(quantity: HistoryQuantity) -> NumberKind {
        if matches!(quantity, HistoryQuantity::Stress(_)) { NumberKind::Stress } else { NumberKind::Strain }
    }
}

/// What was probably meant by a strain out of bounds whose number would be within them in per cent.
pub(super) fn in_per_cent_instead(parameter: &PathParameter, value: f64, text: &str) -> Option<String> {
    let [low, high] = parameter.bounds;
    let fits = is_bare(text) && value.abs() > LARGEST_STRAIN && (low..=high).contains(&(value / 100.0));
    let text = text.trim();
    (fits && NumberKind::of_parameter(parameter) == Some(NumberKind::Strain))
        .then(|| format!("if {text} % is meant, write \"{text} %\""))
}

/// True if text is a number without a unit.
pub(super) fn is_bare(text: &str) -> bool {
    text.trim().parse::<f64>().is_ok()
}

/// The stresses that a case has without doubt, Pa. The first is the mean stress of its sample.
pub(crate) struct Known(Vec<f64>);

impl Known {
    /// Of a sample with a mean stress, Pa.
    pub(crate) fn of_sample(mean_stress: f64) -> Known {
        Known(vec![mean_stress])
    }

    fn sample_stress(&self) -> f64 {
        self.0.first().copied().unwrap_or(f64::NAN)
    }

    pub(super) fn add(&mut self, stress: f64) {
        if stress != 0.0 {
            self.0.push(stress.abs());
        }
    }

    pub(super) fn is_near(&self, stress: f64) -> bool {
        self.0.iter().any(|known| stress.abs() > known / FAR && stress.abs() < known * FAR)
    }

    /// What a number without a unit is understood as and what was probably meant, if it is in doubt; the text is that of the number.
    pub(crate) fn doubt(&mut self, kind: NumberKind, value: f64, text: &str) -> Option<Doubt> {
        let text = text.trim();
        let exact = |unit: &'static str| WithUnit { text: format!("{text} {unit}"), unit };
        let guess = |unit| Some(exact(unit));
        match kind {
            NumberKind::OfSample if value.abs() < SMALLEST_SAMPLE_STRESS => {
                let said = format!(
                    "is understood as {}, which is less than most tests can be run at",
                    stress(value)
                );
                Some(Doubt { said, guess: guess("kPa"), exact: exact("Pa") })
            }
            NumberKind::Stress if value != 0.0 && !self.is_near(value) => {
                let sample = self.sample_stress();
                let said = format!(
                    "is understood as {}, {} the sample's mean stress of {}",
                    stress(value),
                    times(value.abs() / sample),
                    stress(sample)
                );
                let meant =
                    [("kPa", 1e3), ("MPa", 1e6)].into_iter().find(|(_, size)| self.is_near(value * size));
                Some(Doubt { said, guess: meant.and_then(|(unit, _)| guess(unit)), exact: exact("Pa") })
            }
            NumberKind::Strain if value.abs() > LARGEST_STRAIN => {
                let exact = in_per_cent(value);
                let said = format!("is understood as a strain of {exact}");
                Some(Doubt { said, guess: guess("%"), exact: WithUnit { text: exact, unit: "1" } })
            }
            NumberKind::Stress => {
                self.add(value);
                None
            }
            NumberKind::OfSample | NumberKind::Strain => None,
        }
    }
}

/// A number in doubt.
pub(crate) struct Doubt {
    /// What it is understood as, as the continuation of "key = value".
    said: String,
    /// The same number in the unit that was probably meant.
    guess: Option<WithUnit>,
    /// The same number in the unit that it is understood in.
    exact: WithUnit,
}

/// A number with its unit.
struct WithUnit {
    text: String,
    /// The unit as the header of a table has it; 1 for a pure number.
    unit: &'static str,
}

impl Doubt {
    /// The number in the unit that it is understood in.
    pub(super) fn exact(&self) -> &str {
        &self.exact.text
    }

    /// What it is understood as, as the continuation of "key = value".
    pub(crate) fn message(&self) -> &str {
        &self.said
    }

    /// What would be right for a value.
    pub(crate) fn help(&self) -> String {
        let exact = &self.exact.text;
        match &self.guess {
            Some(WithUnit { text, .. }) => {
                format!("probably {text} was meant: write \"{text}\", or \"{exact}\" if that is meant")
            }
            None => format!("write it with its unit, \"{exact}\" if that is meant"),
        }
    }

    /// What would be right for the name of a column of a table.
    pub(crate) fn header_help(&self, name: &str) -> String {
        let exact = self.exact.unit;
        match &self.guess {
            Some(WithUnit { unit, .. }) => {
                format!(
                    "name the unit in the header: probably {name} ({unit}), or {name} ({exact}) if that is meant"
                )
            }
            None => format!("name the unit in the header, {name} ({exact}) if that is meant"),
        }
    }
}

/// "2000 times less than", "15 times".
fn times(ratio: f64) -> String {
    let [factor, rest] = if ratio < 1.0 { [1.0 / ratio, 1.0] } else { [ratio, 0.0] };
    let digits = format!("{factor:.1e}").parse::<f64>().unwrap_or(factor);
    let than = if rest > 0.0 { " less than" } else { "" };
    format!("{} times{than}", format_number(digits))
}

/// A stress in the unit in which it is readable.
pub(crate) fn stress(value: f64) -> String {
    let units = [("GPa", 1e9), ("MPa", 1e6), ("kPa", 1e3)];
    let (unit, size) = units.into_iter().find(|(_, size)| value.abs() >= *size).unwrap_or(("Pa", 1.0));
    let digits = format!("{:.3e}", value / size).parse::<f64>().unwrap_or(value / size);
    format!("{} {unit}", format_number(digits))
}

/// A pure number in per cent, read back as the same double.
fn in_per_cent(value: f64) -> String {
    // The decimal point is moved, since a product would be rounded.
    let digits = format!("{value:e}");
    let (mantissa, exponent) = digits.split_once('e').unwrap_or((&digits, "0"));
    let moved = format!("{mantissa}e{}", exponent.parse::<i32>().unwrap_or(0) + 2);
    let short = moved.parse().map_or(moved.clone(), format_number);
    let same = |text: &String| parse_quantity(text, Dimension::NUMBER) == Ok(value);
    [format!("{short} %"), format!("{moved} %")]
        .into_iter()
        .find(same)
        .unwrap_or_else(|| format!("{moved} %"))
}
