//! `granum predict --family`: the curves of a test of a family.

use std::path::Path;

use granum_core::{Column, Table};
use granum_io::shell::ShowPath;
use granum_io::{atomic::write_atomically, check_output_file, write_table};
use granum_learn::family::{FamilyModel, FamilyPrediction, InputSource, UsedInput};
use serde_json::{Map, Value, json};

use super::family_card;
use super::family_chart::{ChartPoint, chart, short};
use super::family_check;
use super::family_figure;
use super::family_flags::{self, FamilyFlags};
use super::prediction_input::{LEVEL, combination_json, combination_text, outside_text};
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// A density that is next to nothing.
const NOTHING: f64 = 1e-6;

/// Predicts, lists the families, or prints a card.
pub fn run(
    context: &Context,
    name: &str,
    flags: &FamilyFlags,
    case: Option<&Path>,
    out: Option<&Path>,
) -> Result<(), Failure> {
    if name.is_empty() {
        let lines = family_flags::listed();
        return output::say(context, &json!({ "families": lines }), || lines.join("\n"));
    }
    let model = flags.fitted(context, name, case)?;
    if flags.card {
        let card = family_card::text(&model);
        return output::say(context, &family_card::as_json(&model), || card);
    }
    if let Some(path) = out {
        check_output_file(path, context.force)?;
    }
    let family = model.definition();
    let known = flags.known(context, family, case)?;
    let inputs = family_flags::inputs_of(family, &known)?;
    let prediction = model.predict(&inputs, LEVEL)?;
    flags_of(&prediction).iter().for_each(|text| context.warn_in_json(text));
    let checked = match flags.check {
        true => Some(family_check::run(context, &model, &known, &inputs, flags.grains)?),
        false => None,
    };
    if let Some(path) = out {
        write(path, &model, &prediction)?;
    }
    let mut result = as_json(&model, &prediction);
    if let (Value::Object(object), Some(checked)) = (&mut result, &checked) {
        object.insert("check".into(), checked.as_json());
    }
    if let (Value::Object(object), Some(path)) = (&mut result, out) {
        object.insert("output".into(), output::path(path));
    }
    output::say(context, &result, || {
        let mut lines = text(&model, &prediction);
        lines.extend(checked.iter().flat_map(|checked| checked.lines()));
        lines.extend(out.map(|path| format!("wrote {}", path.shown())));
        lines.join("\n")
    })
}

/// What is said of an answer for which there are no runs.
fn flags_of(prediction: &FamilyPrediction) -> Vec<String> {
    let combination = combination_text(prediction.combination.as_ref());
    outside_text(&prediction.outside).into_iter().chain(combination).collect()
}

/// What the answer is made of, and its curves.
fn text(model: &FamilyModel, prediction: &FamilyPrediction) -> Vec<String> {
    let family = model.definition();
    let mut lines = vec![format!("{}: {} (fitted to {} runs)", family.name, family.title, model.runs())];
    lines.extend(prediction.inputs.iter().map(input_line));
    lines.extend(flags_of(prediction));
    for output in family.outputs {
        let columns = model.columns_of(output);
        let symbol = if output.symbol.is_empty() { String::new() } else { format!("{} = ", output.symbol) };
        let points: Vec<ChartPoint> = match columns[..] {
            [column] => {
                let curve = &prediction.curves[column];
                let point = |k: usize| ChartPoint {
                    x: prediction.points[k],
                    mean: curve.mean[k],
                    lower: curve.lower[k],
                    upper: curve.upper[k],
                };
                (0..prediction.points.len()).map(point).collect()
            }
            _ => at_the_end(prediction, &columns),
        };
        let along = match columns.len() {
            1 => family.coordinate.replace('_', " "),
            _ => "force over its mean, at the end".into(),
        };
        let most = points.iter().map(|point| point.mean).fold(f64::NEG_INFINITY, f64::max);
        lines.push(String::new());
        lines.push(format!("{symbol}{} over {along}; 90 % interval", output.meaning));
        lines.extend(chart(&points));
        if let (Some(last), 1) = (points.last(), columns.len()) {
            let ends = format!("{} to {}", short(last.lower), short(last.upper));
            lines.push(format!(
                "{:>11}largest {}, at the end {} ({ends})",
                "",
                short(most),
                short(last.mean)
            ));
        }
    }
    lines
}

/// A distribution in the last state: centre of the bin, density, its interval. Bins before the first that can have something are left out.
fn at_the_end(prediction: &FamilyPrediction, columns: &[usize]) -> Vec<ChartPoint> {
    let last = prediction.points.len() - 1;
    let bin = |column: &usize| {
        let curve = &prediction.curves[*column];
        let centre = curve.column.rsplit('_').next().and_then(|centre| centre.parse().ok());
        ChartPoint {
            x: centre.unwrap_or(f64::NAN),
            mean: curve.mean[last],
            lower: curve.lower[last],
            upper: curve.upper[last],
        }
    };
    columns.iter().map(bin).skip_while(|point| point.upper < NOTHING).collect()
}

/// `  void ratio = 0.7 (given)`, or what is typical and by how much it varies.
fn input_line(input: &UsedInput) -> String {
    let name = input.name.trim_start_matches("sample.").replace('_', " ");
    match input.source {
        InputSource::Given => format!("  {name} = {} (given)", crate::numbers::rounded(input.value, 4)),
        InputSource::Typical(typical) => format!(
            "  {name} = {} +- {} (not given: typical of the runs with the inputs that are)",
            crate::numbers::rounded(input.value, 4),
            crate::numbers::rounded(typical.deviation, 2)
        ),
    }
}

fn as_json(model: &FamilyModel, prediction: &FamilyPrediction) -> Value {
    let input = |input: &UsedInput| {
        let deviation = match input.source {
            InputSource::Given => None,
            InputSource::Typical(typical) => Some(typical.deviation),
        };
        json!({
            "input": input.name,
            "value": input.value,
            "given": deviation.is_none(),
            "standard_deviation": deviation,
        })
    };
    let curves: Map<String, Value> = prediction
        .curves
        .iter()
        .map(|curve| {
            let own = json!({ "mean": curve.mean, "lower": curve.lower, "upper": curve.upper });
            (curve.column.clone(), own)
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

/// Writes the curves by the ending of the file: a figure, JSON, or a table.
fn write(path: &Path, model: &FamilyModel, prediction: &FamilyPrediction) -> Result<(), Failure> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    let text = match ending.as_deref() {
        Some("svg") => family_figure::svg(model, prediction),
        Some("json") => format!("{:#}\n", as_json(model, prediction)),
        Some("csv" | "parquet") => return Ok(write_table(path, &table(model, prediction)?)?),
        _ => {
            let message = format!(
                "-o {}: its name must end in .svg (a figure), .csv or .parquet (a table) or .json",
                path.shown()
            );
            return Err(Failure::new(message));
        }
    };
    Ok(write_atomically(path, |file| std::io::Write::write_all(file, text.as_bytes()))?)
}

/// A column of the coordinate, and three for each output.
fn table(model: &FamilyModel, prediction: &FamilyPrediction) -> Result<Table, Failure> {
    let mut columns = vec![Column::new(model.definition().coordinate, "", prediction.points.clone())];
    for curve in &prediction.curves {
        let name = &curve.column;
        columns.push(Column::new(name, "", curve.mean.clone()));
        columns.push(Column::new(format!("{name}_lower"), "", curve.lower.clone()));
        columns.push(Column::new(format!("{name}_upper"), "", curve.upper.clone()));
    }
    Ok(Table::new(columns)?)
}
