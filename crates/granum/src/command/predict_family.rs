//! `granum predict --family`: the curves of a test of a family.

use std::path::Path;

use granum_core::{Column, Table};
use granum_io::shell::ShowPath;
use granum_io::{check_output_file, write_table};
use granum_learn::family::{FamilyDefinition, FamilyModel, FamilyPrediction};
use granum_report::family::{self as family_figure, Shown};
use serde_json::{Value, json};

use super::family_answer::{as_json, curve_columns, ending, flags_of, input_line, write_text, wrong_ending};
use super::family_card;
use super::family_chart::{ChartPoint, chart, short};
use super::family_check::{self, Checked};
use super::family_flags::{self, FamilyFlags};
use super::family_rows::Asked;
use super::family_several;
use super::prediction_input::LEVEL;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// A density that is next to nothing.
const NOTHING: f64 = 1e-6;

/// What is asked beside the properties: files.
#[derive(Clone, Copy)]
pub struct Files<'a> {
    /// A case that gives properties.
    pub case: Option<&'a Path>,
    /// A table whose rows give them.
    pub input: Option<&'a Path>,
    /// Where the curves are written to.
    pub out: Option<&'a Path>,
}

/// Predicts, lists the families, or prints a card.
pub fn run(context: &Context, name: &str, flags: &FamilyFlags, files: Files) -> Result<(), Failure> {
    let Files { case, input, out } = files;
    let refuse_files = |of: &str| {
        let files = [("--output", out), ("--input", input)];
        match files.into_iter().find_map(|(flag, path)| Some((flag, path?))) {
            Some((flag, path)) => {
                Err(Failure::new(format!("{flag} {}: {of} has no use for it; leave it out", path.shown())))
            }
            None => flags.refuse_properties(of),
        }
    };
    if name.is_empty() {
        refuse_files("the list of the families")?;
        if flags.check || flags.card || case.is_some() {
            return Err(Failure::new(
                "give the name of a family: --family NAME (`granum predict --family` lists them)",
            ));
        }
        let lines = family_flags::listed();
        return output::say(context, &json!({ "families": lines }), || lines.join("\n"));
    }
    let model = flags.fitted(context, name, case)?;
    if flags.card {
        refuse_files("a card")?;
        let card = family_card::text(&model);
        return output::say(context, &family_card::as_json(&model), || card);
    }
    if let Some(path) = out {
        check_output_file(path, context.force)?;
    }
    let asked = flags.asked(context, model.definition(), case, input)?;
    match asked.as_slice() {
        [one] => single(context, &model, one, flags, out),
        _ if flags.check => Err(Failure::new(format!(
            "--check makes and tests one sample, and {} tests are asked for; ask for one",
            asked.len()
        ))),
        _ => family_several::run(context, &model, &asked, out),
    }
}

/// A single test.
fn single(
    context: &Context,
    model: &FamilyModel,
    asked: &Asked,
    flags: &FamilyFlags,
    out: Option<&Path>,
) -> Result<(), Failure> {
    let family = model.definition();
    let known = &asked.known;
    let inputs = family_flags::inputs_of(family, known)?;
    if flags.check {
        refuse_unknown(family, &inputs)?;
    }
    let prediction = model.predict(&inputs, LEVEL)?;
    flags_of(&prediction).iter().for_each(|text| context.warn_in_json(text));
    let checked = match flags.check {
        true => Some(family_check::run(context, model, known, &inputs, flags.grains)?),
        false => None,
    };
    let answer = Answer { model, prediction: &prediction, checked: checked.as_ref() };
    if let Some(path) = out {
        answer.write(path)?;
    }
    let mut result = as_json(model, &prediction);
    if let (Value::Object(object), Some(checked)) = (&mut result, &checked) {
        object.insert("check".into(), checked.as_json());
    }
    if let (Value::Object(object), Some(path)) = (&mut result, out) {
        object.insert("output".into(), output::path(path));
    }
    output::say(context, &result, || {
        let mut lines = answer.text();
        lines.extend(checked.iter().flat_map(|checked| checked.lines()));
        lines.extend(out.map(|path| format!("wrote {}", path.shown())));
        lines.join("\n")
    })
}

/// A sample has one value of every property.
fn refuse_unknown(family: &FamilyDefinition, inputs: &[Option<f64>]) -> Result<(), Failure> {
    let open = family.inputs.iter().zip(inputs).filter(|(input, value)| input.is_required && value.is_none());
    let open: Vec<&str> = open.map(|(input, _)| input.name).collect();
    match open.is_empty() {
        true => Ok(()),
        false => Err(Failure::new(format!(
            "--check makes one sample, and {} of its grains is not given; give it",
            open.join(", ")
        ))),
    }
}

/// An answer with the test that it was checked by.
struct Answer<'a> {
    model: &'a FamilyModel,
    prediction: &'a FamilyPrediction,
    checked: Option<&'a Checked>,
}

impl Answer<'_> {
    /// The curves that are drawn: those for the sample that was made, if there is one, with the test over them.
    fn drawn(&self) -> (&FamilyPrediction, Option<&[Vec<f64>]>) {
        match self.checked.and_then(|checked| checked.drawn.as_ref()) {
            Some(drawn) => (&drawn.prediction, Some(drawn.measured.as_slice())),
            None => (self.prediction, None),
        }
    }

    /// What the answer is made of, and its curves.
    fn text(&self) -> Vec<String> {
        let family = self.model.definition();
        let mut lines =
            vec![format!("{}: {} (fitted to {} runs)", family.name, family.title, self.model.runs())];
        lines.extend(self.prediction.inputs.iter().map(input_line));
        lines.extend(flags_of(self.prediction));
        let (prediction, measured) = self.drawn();
        if measured.is_some() {
            lines.push(String::new());
            lines.push("curves for the sample that was made (●), and its test (×):".into());
        }
        for output in family.outputs {
            let columns = self.model.columns_of(output);
            let symbol =
                if output.symbol.is_empty() { String::new() } else { format!("{} = ", output.symbol) };
            let points = match columns[..] {
                [column] => along(prediction, measured, column),
                _ => at_the_end(prediction, measured, &columns),
            };
            let coordinate = match columns.len() {
                1 => family.coordinate.replace('_', " "),
                _ => "force over its mean, at the end".into(),
            };
            let most = points.iter().map(|point| point.mean).fold(f64::NEG_INFINITY, f64::max);
            lines.push(String::new());
            lines.push(format!("{symbol}{} over {coordinate}; 90 % interval", output.meaning));
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

    /// Writes the curves by the ending of the file: a figure, JSON, or a table.
    fn write(&self, path: &Path) -> Result<(), Failure> {
        let text = match ending(path).as_str() {
            "svg" => {
                let (prediction, measured) = self.drawn();
                let grains = self.checked.map_or(0, Checked::grains);
                let measured =
                    measured.map(|measured| (measured, format!("a simulation of {grains} grains")));
                family_figure::svg(self.model, &[Shown { prediction, label: String::new(), measured }])
            }
            "json" => {
                let mut result = as_json(self.model, self.prediction);
                if let (Value::Object(object), Some(checked)) = (&mut result, self.checked) {
                    object.insert("check".into(), checked.as_json());
                }
                format!("{result:#}\n")
            }
            "csv" | "parquet" => return Ok(write_table(path, &self.table()?)?),
            _ => return Err(wrong_ending(path)),
        };
        write_text(path, &text)
    }

    /// A column of the coordinate, and three for each output; of a check also what was measured and the prediction for its sample.
    fn table(&self) -> Result<Table, Failure> {
        let coordinate = self.model.definition().coordinate;
        let mut columns = vec![Column::new(coordinate, "", self.prediction.points.clone())];
        columns.extend(curve_columns("", self.prediction));
        if let (prediction, Some(measured)) = self.drawn() {
            let named = prediction.curves.iter().zip(measured);
            columns.extend(named.map(|(curve, values)| {
                Column::new(format!("measured_{}", curve.column), "", values.clone())
            }));
            columns.extend(curve_columns("of_sample_", prediction));
        }
        Ok(Table::new(columns)?)
    }
}

/// An output along the coordinate.
fn along(prediction: &FamilyPrediction, measured: Option<&[Vec<f64>]>, column: usize) -> Vec<ChartPoint> {
    let curve = &prediction.curves[column];
    let point = |k: usize| ChartPoint {
        x: prediction.points[k],
        mean: curve.mean[k],
        lower: curve.lower[k],
        upper: curve.upper[k],
        measured: measured.map(|measured| measured[column][k]),
    };
    (0..prediction.points.len()).map(point).collect()
}

/// A distribution in the last state: centre of the bin, density, its interval. Bins before the first that can have something are left out.
fn at_the_end(
    prediction: &FamilyPrediction,
    measured: Option<&[Vec<f64>]>,
    columns: &[usize],
) -> Vec<ChartPoint> {
    let last = prediction.points.len() - 1;
    let bin = |column: &usize| {
        let curve = &prediction.curves[*column];
        let centre = curve.column.rsplit('_').next().and_then(|centre| centre.parse().ok());
        ChartPoint {
            x: centre.unwrap_or(f64::NAN),
            mean: curve.mean[last],
            lower: curve.lower[last],
            upper: curve.upper[last],
            measured: measured.map(|measured| measured[*column][last]),
        }
    };
    columns.iter().map(bin).skip_while(|point| point.upper < NOTHING).collect()
}
