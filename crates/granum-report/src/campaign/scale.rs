//! The colours of a variable: a scale of numbers, or a colour for each word.

use super::runs::{CampaignRuns, VariableValue};
use crate::figure::palette::{GREY, color, sequential};
use crate::numbers::trimmed;

/// Number of steps of the colour scale in the legend.
const STEPS: usize = 5;
/// Up to this number of different values a legend names each of them: a step between two of them is the value of no run.
const MOST_VALUES: usize = 8;

/// The colours of a variable.
pub(super) enum Scale {
    /// From the smallest to the largest number.
    Numbers {
        /// The ends.
        between: [f64; 2],
        /// True if equal ratios have equal steps of colour.
        logarithmic: bool,
        /// The numbers of the legend: those of the runs, if they are few, and otherwise steps between the ends.
        shown: Vec<f64>,
    },
    /// A colour for each word.
    Words(Vec<String>),
}

impl Scale {
    pub(super) fn from_runs(campaign: &CampaignRuns) -> Scale {
        let values = || campaign.runs.iter().filter_map(|run| run.values.get(campaign.coloured_by));
        let numbers: Vec<f64> = values()
            .filter_map(|value| match value {
                VariableValue::Number(number) => Some(*number),
                VariableValue::Word(_) => None,
            })
            .collect();
        if numbers.len() == values().count() && !numbers.is_empty() {
            let low = numbers.iter().copied().fold(f64::INFINITY, f64::min);
            let high = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let logarithmic = low > 0.0
                && campaign.variables.get(campaign.coloured_by).is_some_and(|variable| variable.logarithmic);
            let shown = shown(numbers, [low, high], logarithmic);
            return Scale::Numbers { between: [low, high], logarithmic, shown };
        }
        let mut words: Vec<String> = values().map(word).collect();
        words.sort();
        words.dedup();
        Scale::Words(words)
    }

    pub(super) fn color(&self, value: Option<&VariableValue>) -> String {
        match (self, value) {
            (Scale::Numbers { between, logarithmic, .. }, Some(VariableValue::Number(number))) => {
                sequential(0.1 + 0.9 * share(*number, *between, *logarithmic), 0.0)
            }
            (Scale::Words(words), Some(value)) => {
                let value = word(value);
                words
                    .iter()
                    .position(|known| *known == value)
                    .map_or_else(|| GREY.to_string(), |k| color(k).to_string())
            }
            _ => GREY.to_string(),
        }
    }

    /// Values for the legend.
    pub(super) fn steps(&self) -> Vec<VariableValue> {
        match self {
            Scale::Numbers { shown, .. } => shown.iter().copied().map(VariableValue::Number).collect(),
            Scale::Words(words) => words.iter().cloned().map(VariableValue::Word).collect(),
        }
    }
}

/// The numbers of a legend.
fn shown(mut numbers: Vec<f64>, [low, high]: [f64; 2], logarithmic: bool) -> Vec<f64> {
    numbers.sort_by(f64::total_cmp);
    numbers.dedup();
    if numbers.len() <= MOST_VALUES {
        return numbers;
    }
    let step = |k: usize| {
        let share = k as f64 / (STEPS - 1) as f64;
        if logarithmic { low * libm::pow(high / low, share) } else { low + (high - low) * share }
    };
    (0..STEPS).map(step).collect()
}

fn word(value: &VariableValue) -> String {
    match value {
        VariableValue::Number(number) => trimmed(*number),
        VariableValue::Word(word) => word.clone(),
    }
}

/// Where a number is between two others.
fn share(number: f64, [low, high]: [f64; 2], logarithmic: bool) -> f64 {
    match () {
        () if low == high => 0.5,
        () if logarithmic => libm::log(number / low) / libm::log(high / low),
        () => (number - low) / (high - low),
    }
}
