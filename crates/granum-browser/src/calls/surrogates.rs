//! Surrogates: the families that a page has loaded, and a training on the states of its run.

use granum_core::digest::{self, Digest};
use granum_core::observer::NoObserver;
use granum_core::quantity::format_number;
use granum_io::Case;
use granum_io::case::field;
use granum_learn::dataset::{Dataset, RunStates};
use granum_learn::family::{FamilyModel, FamilyPrediction, InputSource};
use granum_learn::surrogate::{FitSpec, SurrogateMethods, to_json};
use granum_report::family::{Shown, svg};
use serde_json::{Value, json};

use super::case::NAME;
use super::reports::{measurements, received};
use crate::answer::CallError;
use crate::page::{Arguments, Page};

/// The share of the states of new samples that an interval holds where nothing is said.
const LEVEL: f64 = 0.9;

/// Loads the text of a fitted family; the answer says what it is asked with.
pub(super) fn load(page: &mut Page, arguments: &Arguments) -> Result<Value, CallError> {
    let name = arguments.text("name")?.to_string();
    let model = FamilyModel::from_json(arguments.text("text")?, &name)?;
    let family = model.definition();
    let inputs: Vec<Value> = (family.inputs.iter().zip(model.ranges()))
        .map(|(input, range)| {
            json!({
                "name": input.name, "meaning": input.meaning, "range": range, "required": input.is_required,
            })
        })
        .collect();
    let answer = json!({
        "name": family.name, "path": family.path, "title": family.title, "case": family.case,
        "coordinate": family.coordinate, "runs": model.runs(), "inputs": inputs, "about": family.about, "limits": family.limits,
        "outputs": family.outputs.iter().map(|output| json!({
            "column": output.column, "meaning": output.meaning, "symbol": output.symbol,
        })).collect::<Vec<_>>(),
    });
    page.last = None;
    page.families.insert(name, model);
    Ok(answer)
}

fn loaded<'a>(page: &'a Page, arguments: &Arguments) -> Result<&'a FamilyModel, CallError> {
    let name = arguments.text("name")?;
    let unknown = || CallError::Message(format!("the family {name:?} is not loaded"));
    page.families.get(name).ok_or_else(unknown)
}

/// The curves of a test with the given `values` of the inputs, and their figure; with the `result` of a test over them.
pub(super) fn predict(page: &mut Page, arguments: &Arguments) -> Result<Value, CallError> {
    let name = arguments.text("name")?;
    let values = arguments.numbers("values");
    let inputs = loaded(page, arguments)?.definition().inputs;
    let given: Vec<Option<f64>> = inputs.iter().map(|input| values.get(input.name).copied()).collect();
    if page.last.as_ref().is_none_or(|(of, asked, _)| of != name || *asked != given) {
        let prediction = loaded(page, arguments)?.predict(&given, arguments.number_or("level", LEVEL))?;
        page.last = Some((name.to_string(), given, prediction));
    }
    let (model, Some((_, _, prediction))) = (loaded(page, arguments)?, &page.last) else {
        return Ok(Value::Null);
    };
    let measured = measured_so_far(page, model, arguments, prediction)?;
    let measured = measured.as_deref().map(|curves| (curves, "this test".to_string()));
    let figure = svg(model, &[Shown { prediction, label: String::new(), measured }]);
    Ok(json!({
        "inputs": prediction.inputs.iter().map(|input| json!({
            "name": input.name, "value": input.value,
            "source": match input.source {
                InputSource::Given => "given",
                InputSource::Typical(_) => "typical",
                InputSource::Integrated(_) => "integrated",
            },
        })).collect::<Vec<_>>(),
        "extrapolated": prediction.is_extrapolated(),
        "outside": prediction.outside.iter().map(|outside| json!({
            "name": outside.name, "value": outside.value, "range": outside.range,
        })).collect::<Vec<_>>(),
        "points": prediction.points,
        "curves": prediction.curves.iter().map(|curve| json!({
            "column": curve.column, "mean": curve.mean, "lower": curve.lower, "upper": curve.upper,
        })).collect::<Vec<_>>(),
        "figure": figure,
    }))
}

/// The curves of the `result` of a test of the family at the points of a prediction, as far as the test has come; `None` without one.
fn measured_so_far(
    page: &Page,
    model: &FamilyModel,
    arguments: &Arguments,
    prediction: &FamilyPrediction,
) -> Result<Option<Vec<Vec<f64>>>, CallError> {
    if arguments.value("result").is_null() {
        return Ok(None);
    }
    let result = received(arguments)?;
    let case = Case::parse(result.case(), NAME)?;
    let run = RunStates::of_case("this test", &case, measurements(page, &result)?)?;
    let run = model.definition().with_columns(&run)?;
    let along = run.column(model.definition().coordinate)?;
    let curve = |column: &str| -> Result<Vec<f64>, CallError> {
        let values = run.column(column)?;
        Ok(prediction.points.iter().map_while(|point| between(&along, &values, *point)).collect())
    };
    Ok(Some(prediction.curves.iter().map(|one| curve(&one.column)).collect::<Result<_, _>>()?))
}

/// The value at a point, on a straight line between the states on either side; `None` beyond the last one.
fn between(along: &[f64], values: &[f64], point: f64) -> Option<f64> {
    let after = along.iter().position(|x| *x >= point)?;
    let before = after.saturating_sub(1);
    let width = along[after] - along[before];
    let share = if width > 0.0 { (point - along[before]) / width } else { 1.0 };
    Some(values[before] + share * (values[after] - values[before]))
}

/// The case of a test of a family: its `ready` case with the settings of the family, the `values` of what is known of the grains, and typical
/// ones of what is not.
pub(super) fn case_of(page: &mut Page, arguments: &Arguments) -> Result<Value, CallError> {
    let model = loaded(page, arguments)?;
    let family = model.definition();
    let values = arguments.numbers("values");
    let given: Vec<Option<f64>> = family.inputs.iter().map(|input| values.get(input.name).copied()).collect();
    let used = model.predict(&given, LEVEL)?.inputs;
    let mut case = Case::parse(arguments.text("ready")?, NAME)?;
    for (key, value) in family.settings {
        match *key {
            "path" => case = case.with_path(value, &[])?,
            key => case.set(key, value)?,
        }
    }
    // What has no divisor comes first: others are taken over it.
    let of_case = family.inputs.iter().zip(&used).filter(|(input, _)| !input.key.starts_with("sample."));
    let (plain, over): (Vec<_>, Vec<_>) = of_case.partition(|(input, _)| input.over.is_empty());
    for (input, used) in plain.into_iter().chain(over) {
        let value = input.over.iter().fold(used.value, |value, key| value * number(&case, key));
        set(&mut case, input.key, value)?;
    }
    let stress = number(&case, "preparation.mean_stress");
    for (key, factor) in family.stress_keys {
        set(&mut case, key, factor * stress)?;
    }
    // A sample is made with a part of the friction that its grains have in the test.
    let part = used
        .iter()
        .find(|input| input.name == "preparation_ratio")
        .map_or(0.0, |input| input.value.clamp(0.0, 1.0));
    let friction = part * number(&case, "grains.material.friction");
    set(&mut case, "preparation.friction", friction)?;
    case.check()?;
    Ok(json!({ "case": case.resolved_toml() }))
}

fn number(case: &Case, key: &str) -> f64 {
    let parameters = case.parameters();
    parameters.iter().find(|parameter| parameter.key == key).and_then(|one| one.number()).unwrap_or(f64::NAN)
}

fn set(case: &mut Case, key: &str, value: f64) -> Result<(), CallError> {
    let unit = match field(key) {
        Some(field) => field.si_unit(),
        None if key.ends_with("stress") => "Pa".into(),
        None => String::new(),
    };
    Ok(case.set(key, format!("{} {unit}", format_number(value)).trim_end())?)
}

/// A digest of what a family predicts in the middle of its ranges and a quarter from either end, by which the bits of a browser are compared
/// with those of the program.
pub(super) fn digest_of_predictions(page: &mut Page, arguments: &Arguments) -> Result<Value, CallError> {
    let model = loaded(page, arguments)?;
    let mut hash = Digest::new();
    for share in [0.25, 0.5, 0.75] {
        let given: Vec<Option<f64>> =
            model.ranges().iter().map(|[low, high]| Some(low + share * (high - low))).collect();
        take_in(&mut hash, &model.predict(&given, LEVEL)?);
        let required = model.definition().inputs.iter().map(|input| input.is_required);
        let typical: Vec<Option<f64>> =
            given.iter().zip(required).map(|(x, needed)| x.filter(|_| needed)).collect();
        take_in(&mut hash, &model.predict(&typical, LEVEL)?);
    }
    Ok(json!({ "digest": hash.finish() }))
}

fn take_in(hash: &mut Digest, prediction: &FamilyPrediction) {
    hash.numbers(&prediction.points);
    for curve in &prediction.curves {
        hash.text(&curve.column);
        [&curve.mean, &curve.lower, &curve.upper, &curve.from_inputs]
            .iter()
            .for_each(|ends| hash.numbers(ends));
    }
}

/// Fits a `method` to the states of the `result` of a run, one column over another, and gives the digest of the file of the surrogate.
pub(super) fn digest_of_training(page: &mut Page, arguments: &Arguments) -> Result<Value, CallError> {
    let record = measurements(page, &received(arguments)?)?;
    let dataset = Dataset::new(vec![RunStates::of_record("run", record)?])?;
    let methods = SurrogateMethods::standard();
    let method = methods.by_name(arguments.text("method")?)?;
    let spec = FitSpec::new([arguments.text("input")?], [arguments.text("output")?]).with_threads(1);
    let surrogate = method.fit(&dataset, &spec, &mut NoObserver)?;
    Ok(json!({ "digest": digest::sha256(to_json(surrogate.as_ref())?.as_bytes()) }))
}
