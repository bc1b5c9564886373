//! Several tests of a family at once: a row of a table, or a curve of a figure, for each.

use std::path::Path;

use granum_core::{Column, Table};
use granum_io::shell::ShowPath;
use granum_io::write_table;
use granum_learn::family::{FamilyModel, FamilyPrediction, InputSource};
use granum_report::family::{Shown, svg};
use serde_json::{Value, json};

use super::family_answer::{as_json, curve_columns, ending, flags_of, input_line, write_text, wrong_ending};
use super::family_flags;
use super::family_rows::{Asked, plain_name};
use super::prediction_input::LEVEL;
use super::text_table;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Most tests that a figure can show apart.
const MOST_CURVES: usize = 8;

/// The answers to several tests.
struct Answers<'a> {
    model: &'a FamilyModel,
    asked: &'a [Asked],
    predictions: Vec<FamilyPrediction>,
}

/// Predicts all tests, prints a table of them and writes their curves.
pub fn run(
    context: &Context,
    model: &FamilyModel,
    asked: &[Asked],
    out: Option<&Path>,
) -> Result<(), Failure> {
    if let Some(path) = out.filter(|path| !["svg", "json", "csv", "parquet"].contains(&ending(path).as_str()))
    {
        return Err(wrong_ending(path));
    }
    if let Some(path) = out.filter(|path| ending(path) == "svg" && asked.len() > MOST_CURVES) {
        return Err(Failure::new(format!(
            "-o {}: a figure shows {MOST_CURVES} tests at most, and {} are asked for; write a table (.csv, .parquet) or .json",
            path.shown(),
            asked.len()
        )));
    }
    let mut predictions = Vec::new();
    for (number, one) in asked.iter().enumerate() {
        context.check_stopped(|| "nothing was written".into())?;
        let named =
            |message: String| Failure::new(format!("test {} ({}): {message}", number + 1, one.label()));
        let inputs = family_flags::inputs_of(model.definition(), &one.known)
            .map_err(|error| named(error.message()))?;
        predictions.push(model.predict(&inputs, LEVEL).map_err(|error| named(error.to_string()))?);
    }
    let answers = Answers { model, asked, predictions };
    answers.flags().iter().for_each(|text| context.warn_in_json(text));
    if let Some(path) = out {
        answers.write(path)?;
    }
    let mut result = answers.as_json();
    if let (Value::Object(object), Some(path)) = (&mut result, out) {
        object.insert("output".into(), output::path(path));
    }
    let summary = answers.summary()?;
    output::say(context, &result, || {
        let mut lines = answers.head();
        lines.extend(text_table::lines(&summary));
        lines.push("(ends: of the interval that should contain 90 % of new samples)".into());
        lines.extend(answers.flags());
        lines.extend(out.map(|path| format!("wrote {}", path.shown())));
        lines.join("\n")
    })
}

impl Answers<'_> {
    fn numbered(&self) -> impl Iterator<Item = (usize, &FamilyPrediction)> {
        self.predictions.iter().enumerate().map(|(k, prediction)| (k + 1, prediction))
    }

    /// What is said of answers for which there are no runs.
    fn flags(&self) -> Vec<String> {
        let of_test = |(number, prediction): (usize, &FamilyPrediction)| -> Vec<String> {
            flags_of(prediction).into_iter().map(|text| format!("test {number}: {text}")).collect()
        };
        self.numbered().flat_map(of_test).collect()
    }

    /// The family, and the inputs that all tests have.
    fn head(&self) -> Vec<String> {
        let family = self.model.definition();
        let mut lines =
            vec![format!("{}: {} (fitted to {} runs)", family.name, family.title, self.model.runs())];
        let Some(first) = self.predictions.first() else { return lines };
        for (k, input) in first.inputs.iter().enumerate() {
            match self.predictions.iter().all(|one| one.inputs[k] == *input) {
                true => lines.push(input_line(input)),
                false if input.source != InputSource::Given => lines.push(format!(
                    "  {}: not given; what is typical differs from test to test",
                    input.name.trim_start_matches("sample.").replace('_', " ")
                )),
                false => {}
            }
        }
        lines
    }

    /// Flags of what differs, in their order.
    fn varied(&self) -> Vec<&'static str> {
        let mut flags: Vec<&'static str> = Vec::new();
        for (flag, _) in self.asked.iter().flat_map(|asked| &asked.varied) {
            if !flags.contains(flag) {
                flags.push(flag);
            }
        }
        flags
    }

    /// The value of a flag in a test; not a number where it is not known.
    fn value(asked: &Asked, flag: &str) -> f64 {
        asked.varied.iter().find(|(varied, _)| *varied == flag).map_or(f64::NAN, |(_, value)| *value)
    }

    /// A row for each test: what differs, and of each output that is a number its largest value and that at the end with its interval.
    fn summary(&self) -> Result<Table, Failure> {
        let rounded = |value: f64| {
            if value.is_nan() { String::new() } else { crate::numbers::rounded(value, 4) }
        };
        let mut columns =
            vec![Column::of_words("test", self.numbered().map(|(number, _)| number.to_string()))];
        for flag in self.varied() {
            let values = self.asked.iter().map(|asked| rounded(Answers::value(asked, flag)));
            columns.push(Column::of_words(plain_name(flag), values));
        }
        for output in self.model.definition().outputs {
            let [column] = self.model.columns_of(output)[..] else { continue };
            let short = |value: f64| crate::numbers::rounded(value, 3);
            let of_each = |value: &dyn Fn(&FamilyPrediction) -> String| -> Vec<String> {
                self.predictions.iter().map(value).collect()
            };
            let largest = |one: &FamilyPrediction| {
                short(one.curves[column].mean.iter().copied().fold(f64::NEG_INFINITY, f64::max))
            };
            let last = |one: &FamilyPrediction| {
                let curve = &one.curves[column];
                let end = |values: &[f64]| values.last().map_or(String::new(), |value| short(*value));
                format!("{} ({} to {})", end(&curve.mean), end(&curve.lower), end(&curve.upper))
            };
            columns.push(Column::of_words(format!("{}_largest", output.column), of_each(&largest)));
            columns.push(Column::of_words(format!("{}_at_end", output.column), of_each(&last)));
        }
        Ok(Table::new(columns)?)
    }

    fn as_json(&self) -> Value {
        let one = |(number, prediction): (usize, &FamilyPrediction)| {
            let mut answer = as_json(self.model, prediction);
            answer["test"] = json!(number);
            for (flag, value) in &self.asked[number - 1].varied {
                answer["asked"][plain_name(flag)] = json!(value);
            }
            answer
        };
        json!({
            "family": self.model.definition().name,
            "path": self.model.definition().path,
            "level": LEVEL,
            "tests": self.numbered().map(one).collect::<Vec<_>>(),
        })
    }

    fn write(&self, path: &Path) -> Result<(), Failure> {
        match ending(path).as_str() {
            "svg" => {
                let shown = self.predictions.iter().zip(self.asked).map(|(prediction, asked)| Shown {
                    prediction,
                    label: asked.label(),
                    measured: None,
                });
                write_text(path, &svg(self.model, &shown.collect::<Vec<_>>()))
            }
            "json" => write_text(path, &format!("{:#}\n", self.as_json())),
            _ => Ok(write_table(path, &self.table()?)?),
        }
    }

    /// A row for each point of each test: the number of the test, what differs, the inputs, the coordinate, the curves, and whether it is outside of
    /// the runs.
    fn table(&self) -> Result<Table, Failure> {
        let points = self.predictions.first().map_or(0, |one| one.points.len());
        let repeated = |value: &dyn Fn(usize) -> f64| -> Vec<f64> {
            (0..self.predictions.len()).flat_map(|test| vec![value(test); points]).collect()
        };
        let mut columns = vec![Column::new("test", "", repeated(&|test| (test + 1) as f64))];
        for flag in self.varied() {
            columns.push(Column::new(
                format!("asked_{}", plain_name(flag)),
                "",
                repeated(&|test| Answers::value(&self.asked[test], flag)),
            ));
        }
        for (k, input) in self.model.definition().inputs.iter().enumerate() {
            // What is integrated over has no value.
            let used = |test: usize| match self.predictions[test].inputs[k].source {
                InputSource::Integrated(_) => f64::NAN,
                _ => self.predictions[test].inputs[k].value,
            };
            columns.push(Column::new(input.name, "", repeated(&used)));
        }
        let coordinate = self.predictions.iter().flat_map(|one| one.points.clone()).collect();
        columns.push(Column::new(self.model.definition().coordinate, "", coordinate));
        let each: Vec<Vec<Column>> = self.predictions.iter().map(|one| curve_columns("", one)).collect();
        for place in 0..each.first().map_or(0, Vec::len) {
            let values = each.iter().flat_map(|of_test| of_test[place].values.clone()).collect();
            columns.push(Column::new(each[0][place].name.clone(), "", values));
        }
        let outside = |test: usize| f64::from(u8::from(self.predictions[test].is_extrapolated()));
        columns.push(Column::new("outside", "", repeated(&outside)));
        Ok(Table::new(columns)?)
    }
}
