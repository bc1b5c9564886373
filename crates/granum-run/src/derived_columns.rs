//! What data sets have of a run beside its series: its parameters as single numbers and words, the measures of its sample, and the arc
//! length of its path.

use granum_core::Table;
use granum_core::digest::Digest;
use granum_io::Case;
use granum_io::case::{CaseParameter, ParameterValue};
use granum_sensors::force_distribution::FORCES;

/// Arc length of the strain path up to a state.
pub const ARC_LENGTH: &str = "arc_length";
/// Density in the bins of a histogram; by itself the density of the contact forces P(f).
const DENSITY: &str = "probability_density";
/// Beginning of the names of the measures of the sample.
const SAMPLE: &str = "sample";
/// Columns of a series that do not measure anything.
const NOT_MEASURED: [&str; 3] = ["stage", "state", "observations"];
/// A list of more numbers than this is one word, by which equal lists are recognised.
const LONGEST_LIST: usize = 16;

/// The name of the density in the bins of a histogram. That of the contact forces is P(f), the density without another word.
pub fn density_name(histogram: &str) -> String {
    if histogram == FORCES { DENSITY.into() } else { format!("{histogram}_{DENSITY}") }
}

/// The histogram of which a density has this name.
pub fn histogram_of_density(name: &str) -> &str {
    name.strip_suffix(DENSITY).and_then(|own| own.strip_suffix('_')).unwrap_or(FORCES)
}

/// The parameters of a case, numbers and words; the numbers of lists one by one (`KEY.1`, `KEY.2`). A long list is one word.
pub fn single_parameters(case: &Case) -> Vec<CaseParameter> {
    case.parameters().into_iter().flat_map(taken_apart).collect()
}

/// The numbers of a list as parameters of their own.
fn taken_apart(found: CaseParameter) -> Vec<CaseParameter> {
    let ParameterValue::List(numbers) = &found.value else { return vec![found] };
    if numbers.len() > LONGEST_LIST {
        return vec![CaseParameter::new(found.key, "", ParameterValue::Word(listed(numbers)))];
    }
    let number = |(k, number): (usize, &f64)| {
        CaseParameter::new(format!("{}.{}", found.key, k + 1), &found.unit, ParameterValue::Number(*number))
    };
    numbers.iter().enumerate().map(number).collect()
}

/// A word by which equal lists are recognised.
pub fn listed(numbers: &[f64]) -> String {
    let mut digest = Digest::new();
    digest.numbers(numbers);
    format!("sha256:{}", digest.finish())
}

/// What the sensors measured on the sample, before it was strained: the columns of the state 0 of the first stage, as `sample.NAME`, and
/// the void ratio, which follows from the solid fraction. Nothing if that state was not recorded.
pub fn sample_measures(series: &Table) -> Vec<CaseParameter> {
    let first = |name: &str| series.values(name).and_then(|values| values.first()).copied();
    if first("state") != Some(0.0) || first("stage").is_some_and(|stage| stage != 1.0) {
        return Vec::new();
    }
    let parameter = |name: &str, unit: &str, value: f64| {
        CaseParameter::new(format!("{SAMPLE}.{name}"), unit, ParameterValue::Number(value))
    };
    let measured = series.columns().iter().filter(|column| !NOT_MEASURED.contains(&column.name.as_str()));
    let mut all: Vec<CaseParameter> = measured
        .filter_map(|column| {
            let value = column.numbers()?.first().filter(|value| value.is_finite())?;
            Some(parameter(&column.name, &column.unit, *value))
        })
        .collect();
    if let Some(solid) = first("solid_fraction").filter(|solid| !series.has("void_ratio") && *solid > 0.0) {
        all.push(parameter("void_ratio", "", (1.0 - solid) / solid));
    }
    all
}

/// The arc length of the strain path up to each state, from the strains along the axes at the recorded states; `None` for a series
/// that has it already or lacks a strain.
pub fn arc_length(table: &Table) -> Option<Vec<f64>> {
    if table.has(ARC_LENGTH) {
        return None;
    }
    let strains: Vec<&[f64]> = ["axial_strain", "lateral_strain_2", "lateral_strain_3"]
        .iter()
        .map(|name| table.values(name))
        .collect::<Option<_>>()?;
    let mut length = 0.0;
    let step = |row: usize| {
        let square = |strain: &&[f64]| {
            let before = if row == 0 { 0.0 } else { strain[row - 1] };
            (strain[row] - before) * (strain[row] - before)
        };
        (2.0 / 3.0 * strains.iter().map(square).sum::<f64>()).sqrt()
    };
    Some(
        (0..table.rows())
            .map(|row| {
                length += step(row);
                length
            })
            .collect(),
    )
}
