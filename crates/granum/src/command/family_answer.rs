//! What is said and written of the answer of a family, of one test or of several.

use std::path::Path;

use granum_core::Column;
use granum_io::atomic::write_atomically;
use granum_io::shell::ShowPath;
use granum_learn::family::{FamilyCurve, FamilyModel, FamilyPrediction, InputSource, UsedInput};
use serde_json::{Map, Value, json};

use super::prediction_input::{combination_json, combination_text, outside_text};
use crate::failure::Failure;

/// What is said of an answer for which there are no runs.
pub fn flags_of(prediction: &FamilyPrediction) -> Vec<String> {
    let combination = combination_text(prediction.combination.as_ref());
    outside_text(&prediction.outside).into_iter().chain(combination).collect()
}

/// The columns of the means, and of the lower and upper ends of intervals.
pub fn curve_columns(before: &str, prediction: &FamilyPrediction) -> Vec<Column> {
    let of_curve = |curve: &FamilyCurve| {
        let name = format!("{before}{}", curve.column);
        [
            Column::new(name.as_str(), "", curve.mean.clone()),
            Column::new(format!("{name}_lower"), "", curve.lower.clone()),
            Column::new(format!("{name}_upper"), "", curve.upper.clone()),
        ]
    };
    prediction.curves.iter().flat_map(of_curve).collect()
}

/// The ending of a file in small letters.
pub fn ending(path: &Path) -> String {
    path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

/// The error of a file whose ending is not known.
pub fn wrong_ending(path: &Path) -> Failure {
    Failure::new(format!(
        "-o {}: its name must end in .svg (a figure), .csv or .parquet (a table) or .json",
        path.shown()
    ))
}

/// Writes a text under another name, and renames it.
pub fn write_text(path: &Path, text: &str) -> Result<(), Failure> {
    Ok(write_atomically(path, |file| std::io::Write::write_all(file, text.as_bytes()))?)
}

/// `  void ratio = 0.7 (given)`, or what is typical and by how much it varies.
pub fn input_line(input: &UsedInput) -> String {
    let name = input.name.trim_start_matches("sample.").replace('_', " ");
    match input.source {
        InputSource::Given => format!("  {name} = {} (given)", crate::numbers::rounded(input.value, 4)),
        InputSource::Typical(typical) => format!(
            "  {name} = {} +- {} (not given: typical of the runs with the inputs that are)",
            crate::numbers::rounded(input.value, 4),
            crate::numbers::rounded(typical.deviation, 2)
        ),
        InputSource::Integrated([low, high]) => format!(
            "  {name} = {} to {} (not given: integrated over the range of the runs)",
            crate::numbers::rounded(low, 4),
            crate::numbers::rounded(high, 4)
        ),
    }
}

pub fn as_json(model: &FamilyModel, prediction: &FamilyPrediction) -> Value {
    let input = |input: &UsedInput| {
        let (deviation, integrated) = match input.source {
            InputSource::Given => (None, None),
            InputSource::Typical(typical) => (Some(typical.deviation), None),
            InputSource::Integrated(range) => (None, Some(range)),
        };
        json!({
            "input": input.name,
            "value": input.value,
            "given": input.source == InputSource::Given,
            "standard_deviation": deviation,
            "integrated_over": integrated,
        })
    };
    let curves: Map<String, Value> = prediction
        .curves
        .iter()
        .map(|curve| {
            let values = json!({ "mean": curve.mean, "lower": curve.lower, "upper": curve.upper });
            (curve.column.clone(), values)
        })
        .collect();
    let outside = prediction.outside.iter();
    json!({
        "family": model.definition().name,
        "path": model.definition().path,
        "runs": model.runs(),
        "level": prediction.level,
        "inputs": prediction.inputs.iter().map(input).collect::<Vec<_>>(),
        "outside": outside.map(|o| json!({ "input": o.name, "value": o.value, "range": o.range })).collect::<Vec<_>>(),
        "unseen_combination": combination_json(prediction.combination.as_ref()),
        model.definition().coordinate: prediction.points,
        "curves": curves,
    })
}
