//! Families of tests: the curves of grains that were never simulated, with their intervals.

use granum_core::quantity::parse_quantity;
use granum_io::shell::quoted_path;
use granum_learn::family::{
    ALL, FamilyDefinition, FamilyModel, FamilyPrediction, InputSource, UsedInput, by_name,
};
use granum_report::family::{Shown, svg};
use serde_json::{Value, json};

use crate::answer::{Answer, Answered};
use crate::commands;
use crate::numbers::{number, numbers};
use crate::program::TestProperty;
use crate::query::Query;
use crate::refused::Refused;
use crate::site::Site;

/// Nominal coverage of intervals for new samples.
const LEVEL: f64 = 0.9;

/// The families with a surrogate in the program.
pub fn list(site: &Site, _: &Query) -> Answered {
    let told = |family: &&FamilyDefinition| -> Option<Value> {
        let is_fitted = site.program.family(family).ok()?.is_some();
        is_fitted.then(|| json!({ "family": family.name, "path": family.path, "title": family.title }))
    };
    Ok(Answer::Json(json!({ "families": ALL.iter().filter_map(told).collect::<Vec<_>>() })))
}

/// The surrogate of an address: `family` and `along` for one of the program, or `path` for a file.
fn model(site: &Site, query: &Query) -> Result<(FamilyModel, String), Refused> {
    let wrong = |error: &dyn ToString| Refused::unreadable(site.without_root(error.to_string()));
    if let Some(path) = query.get("path") {
        let place = site.folder.place(path)?;
        let model = FamilyModel::load(&place).map_err(|error| wrong(&error))?;
        return Ok((model, format!("--family {}", quoted_path(&site.folder.as_named(path)))));
    }
    let (name, along) = (query.needed("family")?, query.get("along"));
    let family = by_name(name, along).map_err(|error| Refused::not_found(error.to_string()))?;
    let fitted = site.program.family(family).map_err(|error| wrong(&error))?;
    let model =
        fitted.ok_or_else(|| Refused::not_found(format!("the program has no surrogate of {name}")))?;
    Ok((model, format!("--family {} --path {}", family.name, family.path)))
}

/// The properties that a family uses.
fn properties(site: &Site, family: &FamilyDefinition) -> Vec<TestProperty> {
    let used = |property: &TestProperty| {
        family.inputs.iter().any(|input| input.key == property.key || input.over.contains(&property.key))
    };
    site.program.properties().into_iter().filter(used).collect()
}

/// What a family is and asks for.
pub fn family(site: &Site, query: &Query) -> Answered {
    let (model, of) = model(site, query)?;
    let family = model.definition();
    let input = |(input, range): (&granum_learn::family::FamilyInput, [f64; 2])| {
        let keys: Vec<&str> = std::iter::once(input.key).chain(input.over.iter().copied()).collect();
        json!({
            "name": input.name, "meaning": input.meaning, "keys": keys, "required": input.is_required, "range": numbers(&range),
            "unit": "",
        })
    };
    let property = |property: TestProperty| {
        let alone = family.inputs.iter().position(|input| input.key == property.key && input.over.is_empty());
        let range = alone.and_then(|k| model.ranges().get(k).copied());
        json!({
            "flag": property.flag, "key": property.key, "unit": property.dimension.si_unit(),
            "name": property.flag.trim_start_matches('-').replace('-', " "),
            "range": range.map(|range| numbers(&range)),
        })
    };
    Ok(Answer::Json(json!({
        "family": family.name,
        "path": family.path,
        "title": family.title,
        "about": family.about,
        "limits": family.limits,
        "runs": model.runs(),
        "inputs": family.inputs.iter().zip(model.ranges()).map(input).collect::<Vec<_>>(),
        "properties": properties(site, family).into_iter().map(property).collect::<Vec<_>>(),
        "commands": [commands::line("Its card", format!("granum predict {of} --card"))],
    })))
}

/// The curves of a test: a value with its unit for each property that is known, under the name of its flag.
pub fn predict(site: &Site, query: &Query) -> Answered {
    let (model, of) = model(site, query)?;
    let family = model.definition();
    let (mut known, mut flags) = (Vec::new(), Vec::new());
    for property in properties(site, family) {
        let Some(text) = query.get(property.flag).map(str::trim).filter(|text| !text.is_empty()) else {
            continue;
        };
        let name = property.flag.trim_start_matches('-').replace('-', " ");
        let value = parse_quantity(text, property.dimension)
            .map_err(|why| Refused::bad(format!("{name} {text:?}: {why}")))?;
        if value < 0.0 {
            return Err(Refused::bad(format!("{name} {text:?}: it cannot be negative")));
        }
        known.push((property.key, value));
        flags.push((property.flag.to_string(), text.to_string()));
    }
    let value = |key: &str| known.iter().find(|(known, _)| *known == key).map(|(_, value)| *value);
    let inputs: Vec<Option<f64>> = family.inputs.iter().map(|input| input.from_numbers(&value)).collect();
    if inputs.iter().all(Option::is_none) {
        return Err(Refused::bad(
            "give one property of the grains or of their sample at least, with its unit",
        ));
    }
    let predicted = model.predict(&inputs, LEVEL);
    let prediction = predicted.map_err(|error| Refused::unreadable(site.without_root(error)))?;
    let command = commands::predict(&of, &[flags, vec![("-o".into(), "curves.svg".into())]].concat());
    Ok(Answer::Json(json!({
        "svg": svg(&model, &[Shown { prediction: &prediction, label: String::new(), measured: None }]),
        "title": format!("Predicted curves: {}", family.title),
        "level": LEVEL,
        "inputs": prediction.inputs.iter().map(used).collect::<Vec<_>>(),
        "warnings": warnings(&prediction),
        "coordinate": family.coordinate,
        "points": numbers(&prediction.points),
        "curves": prediction.curves.iter().map(|curve| json!({
            "column": curve.column, "mean": numbers(&curve.mean), "lower": numbers(&curve.lower), "upper": numbers(&curve.upper),
        })).collect::<Vec<_>>(),
        "commands": [commands::line("These curves as a figure", command)],
    })))
}

fn used(input: &UsedInput) -> Value {
    let (source, deviation, range) = match input.source {
        InputSource::Given => ("given", None, None),
        InputSource::Typical(typical) => ("typical of the runs", Some(typical.deviation), None),
        InputSource::Integrated(range) => ("not known, integrated over its range", None, Some(range)),
    };
    json!({
        "name": input.name, "value": number(input.value), "source": source, "deviation": deviation.map(number),
        "range": range.map(|range| numbers(&range)),
    })
}

/// What is said of a prediction for which there are no runs.
fn warnings(prediction: &FamilyPrediction) -> Vec<String> {
    let outside = prediction.outside.iter().map(super::surrogate::outside_text);
    let together = prediction.combination.iter().map(super::surrogate::combination_text);
    outside.chain(together).collect()
}
