//! Surrogates of one's own, in a file or a study: what they ask for, and what they predict.

use granum_io::shell::quoted_path;
use granum_learn::Surrogate;
use granum_learn::study::{self, Study};
use granum_learn::surrogate::{Columns, Outside, UnseenCombination};
use granum_report::figure::palette::color;
use granum_report::figure::{Axis, Figure, Layer, Legend, Panel, Plot, literal};
use granum_report::numbers::rounded;
use serde_json::json;

use crate::answer::{Answer, Answered};
use crate::commands;
use crate::numbers::{number, numbers};
use crate::query::Query;
use crate::refused::Refused;
use crate::site::Site;

/// Nominal coverage of intervals for states of unseen runs.
const LEVEL: f64 = 0.9;
/// Points of a curve.
const POINTS: usize = 61;
/// A value beyond every range, by which a surrogate tells its ranges.
const FAR: f64 = 1e30;

/// A surrogate of a file or of a study.
enum Model {
    File(Box<dyn Surrogate>),
    Study(Box<Study>, String),
}

impl Model {
    fn read(site: &Site, query: &Query) -> Result<(Model, Vec<String>), Refused> {
        let place = site.place(query.needed("path")?)?;
        let wrong = |error: granum_learn::LearnError| Refused::unreadable(site.without_root(error));
        if place.is_file() {
            return Ok((Model::File(site.program.methods().load(&place).map_err(wrong)?), Vec::new()));
        }
        let study = study::load(&place, site.program.methods()).map_err(wrong)?.study;
        let names: Vec<String> = study.members().map(|member| member.name.clone()).collect();
        let name = query.get("model").map(str::to_string).or_else(|| names.first().cloned());
        let name = name
            .ok_or_else(|| Refused::unreadable("the study has no surrogate that is asked by its columns"))?;
        study.member(&name).map_err(|error| Refused::not_found(error.to_string()))?;
        Ok((Model::Study(Box::new(study), name), names))
    }

    fn surrogate(&self) -> Result<&dyn Surrogate, Refused> {
        match self {
            Model::File(surrogate) => Ok(surrogate.as_ref()),
            Model::Study(study, name) => match study.member(name) {
                Ok(member) => Ok(member.surrogate.as_ref()),
                Err(error) => Err(Refused::not_found(error.to_string())),
            },
        }
    }

    fn name(&self) -> Option<&str> {
        match self {
            Model::File(_) => None,
            Model::Study(_, name) => Some(name),
        }
    }
}

/// Inputs with their ranges, and outputs: `path`, and `model` of a study.
pub fn surrogate(site: &Site, query: &Query) -> Answered {
    let (model, names) = Model::read(site, query)?;
    let surrogate = model.surrogate()?;
    let columns = surrogate.columns();
    let ranges = ranges(surrogate);
    let inputs = numeric(columns).into_iter().map(|k| {
        let input = &columns.inputs[k];
        json!({ "name": input.name, "unit": input.unit, "range": ranges[k].map(|range| numbers(&range)) })
    });
    let words = columns.categories();
    let words = words.iter().map(|category| json!({ "name": category.name, "words": category.words }));
    let output = |output: &granum_learn::Variable| json!({ "name": output.name, "unit": output.unit });
    Ok(Answer::Json(json!({
        "method": surrogate.method(),
        "has_memory": surrogate.has_memory(),
        "models": names,
        "model": model.name(),
        "inputs": inputs.collect::<Vec<_>>(),
        "words": words.collect::<Vec<_>>(),
        "outputs": columns.outputs.iter().map(output).collect::<Vec<_>>(),
    })))
}

/// The numbers of the inputs that are no words.
fn numeric(columns: &Columns) -> Vec<usize> {
    let words: Vec<String> =
        columns.categories().iter().flat_map(|category| category.columns().collect::<Vec<_>>()).collect();
    (0..columns.inputs.len()).filter(|k| !words.contains(&columns.inputs[*k].name)).collect()
}

/// The range of each input to which a surrogate was fitted, as far as it knows it: it names the range of a value that is outside.
fn ranges(surrogate: &dyn Surrogate) -> Vec<Option<[f64; 2]>> {
    let columns = surrogate.columns();
    let far = surrogate.predict_rows(&vec![FAR; columns.inputs.len()], LEVEL);
    let outside = far.ok().and_then(|mut rows| rows.pop()).map(|row| row.outside).unwrap_or_default();
    let range = |name: &str| outside.iter().find(|outside| outside.name == name).map(|outside| outside.range);
    columns.inputs.iter().map(|input| range(&input.name)).collect()
}

/// The row of an address: each input under its name behind `set.`, words likewise.
fn row(columns: &Columns, query: &Query) -> Result<Vec<f64>, Refused> {
    let mut row = vec![f64::NAN; columns.inputs.len()];
    for k in numeric(columns) {
        let name = &columns.inputs[k].name;
        let text = query.needed(&format!("set.{name}"))?;
        let value = text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
        row[k] = value.ok_or_else(|| Refused::bad(format!("{name} {text:?}: it is no number")))?;
    }
    for category in columns.categories() {
        let chosen = query.needed(&format!("set.{}", category.name))?;
        if !category.words.iter().any(|word| word == chosen) {
            return Err(Refused::bad(format!("{}: {chosen:?} is no word of it", category.name)));
        }
        for (column, word) in category.columns().zip(&category.words) {
            if let Some(k) = columns.inputs.iter().position(|input| input.name == column) {
                row[k] = f64::from(u8::from(word == chosen));
            }
        }
    }
    Ok(row)
}

/// The prediction for a row, and its curves along one of its inputs (`along`) with their intervals.
pub fn predict(site: &Site, query: &Query) -> Answered {
    let (model, _) = Model::read(site, query)?;
    let surrogate = model.surrogate()?;
    let columns = surrogate.columns();
    let row = row(columns, query)?;
    let wrong = |error: granum_learn::LearnError| Refused::unreadable(site.without_root(error));
    let prediction = surrogate.predict_rows(&row, LEVEL).map_err(wrong)?.pop().unwrap_or_default();
    let outputs = columns.outputs.iter().zip(&prediction.values).map(|(output, estimate)| {
        let interval = estimate.interval.as_ref();
        json!({
            "name": output.name, "unit": output.unit, "mean": number(estimate.mean),
            "lower": interval.map(|interval| number(interval.lower)), "upper": interval.map(|interval| number(interval.upper)),
        })
    });
    let outside = prediction.outside.iter().map(outside_text);
    let together = prediction.combination.iter().map(combination_text);
    let mut answer = json!({
        "level": LEVEL,
        "outputs": outputs.collect::<Vec<_>>(),
        "warnings": outside.chain(together).collect::<Vec<_>>(),
        "commands": [commands::line("This prediction", command(site, query, &model, &row)?)],
    });
    if let Some(along) = query.get("along").filter(|_| !surrogate.has_memory()) {
        let figure = curves(surrogate, &row, along)?;
        answer["svg"] = json!(figure.to_svg());
        answer["title"] = json!(figure.description);
    }
    Ok(Answer::Json(answer))
}

/// The curves of all outputs along an input over its range; the other inputs stay.
fn curves(surrogate: &dyn Surrogate, row: &[f64], along: &str) -> Result<Figure, Refused> {
    let columns = surrogate.columns();
    let wrong = || Refused::bad(format!("{along:?} is no input with a known range"));
    let place = numeric(columns).into_iter().find(|k| columns.inputs[*k].name == along).ok_or_else(wrong)?;
    let [low, high] = ranges(surrogate)[place].ok_or_else(wrong)?;
    let xs: Vec<f64> = (0..POINTS).map(|k| low + (high - low) * k as f64 / (POINTS - 1) as f64).collect();
    let rows: Vec<f64> = (xs.iter())
        .flat_map(|x| row.iter().enumerate().map(|(k, own)| if k == place { *x } else { *own }))
        .collect();
    let predicted = surrogate.predict_rows(&rows, LEVEL).map_err(Refused::unreadable)?;
    let panel = |(k, output): (usize, &granum_learn::Variable)| {
        let words = |name: &str| literal(&name.replace('_', " "));
        let axis = Axis::new(&words(&columns.inputs[place].name)).unit(&columns.inputs[place].unit);
        let mut plot = Plot::new(axis, Axis::new(&words(&output.name)).unit(&output.unit));
        let estimates = xs.iter().zip(&predicted).filter_map(|(x, row)| Some((*x, row.values.get(k)?)));
        let band: Vec<[f64; 3]> = (estimates.clone())
            .filter_map(|(x, estimate)| {
                estimate.interval.as_ref().map(|interval| [x, interval.lower, interval.upper])
            })
            .collect();
        if !band.is_empty() {
            plot = plot.with(Layer::band(band, color(0)).named("90 % interval"));
        }
        let mean = estimates.map(|(x, estimate)| [x, estimate.mean]).collect();
        Panel::plot(plot.with(Layer::line(mean, color(0)).named("mean")))
    };
    let panels: Vec<Panel> = columns.outputs.iter().enumerate().map(panel).collect();
    let count = panels.len().min(2);
    let description = format!("Predictions of {} along {}", surrogate.method(), along.replace('_', " "));
    Ok(Figure::new(&literal(&description), count, panels).legend(Legend::Above))
}

fn command(site: &Site, query: &Query, model: &Model, row: &[f64]) -> Result<String, Refused> {
    let columns = model.surrogate()?.columns();
    let mut flags: Vec<(String, String)> = Vec::new();
    flags.extend(model.name().map(|name| ("--model".to_string(), name.to_string())));
    let set = |name: &str, value: &str| ("--set".to_string(), format!("{name}={value}"));
    for k in numeric(columns) {
        flags.push(set(&columns.inputs[k].name, &granum_core::quantity::format_number(row[k])));
    }
    for category in columns.categories() {
        flags.push(set(&category.name, query.get(&format!("set.{}", category.name)).unwrap_or("")));
    }
    Ok(commands::predict(&quoted_path(&site.folder.as_named(query.needed("path")?)), &flags))
}

/// What is said of a value outside its range.
pub(super) fn outside_text(outside: &Outside) -> String {
    let [value, low, high] =
        [outside.value, outside.range[0], outside.range[1]].map(|value| rounded(value, 4));
    format!(
        "Outside of the runs: {} = {value} (they have {low} to {high}); do not trust this prediction.",
        outside.name
    )
}

/// What is said of two values that no run has together.
pub(super) fn combination_text(found: &UnseenCombination) -> String {
    let [(first, x), (second, y)] = &found.inputs;
    let [x, y] = [x, y].map(|value| rounded(*value, 4));
    format!(
        "Outside of the runs: none has {first} = {x} and {second} = {y} together, or nearly; a simulation would tell."
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_read_by_the_names_of_its_inputs() {
        let variable = |name: &str| granum_learn::Variable { name: name.into(), unit: String::new() };
        let columns = Columns {
            inputs: ["strain", "path=drained", "path=undrained"].map(variable).to_vec(),
            outputs: Vec::new(),
        };
        let query = Query::new("set.strain=0.1&set.path=undrained");
        assert_eq!(row(&columns, &query).unwrap(), [0.1, 0.0, 1.0]);
        assert!(row(&columns, &Query::new("set.strain=x&set.path=undrained")).is_err());
        assert!(row(&columns, &Query::new("set.strain=1&set.path=other")).is_err());
    }
}
