//! Surrogates: the families that a page has loaded, and a training on the states of its run.

use granum_core::digest::{self, Digest};
use granum_core::observer::NoObserver;
use granum_learn::dataset::{Dataset, RunStates};
use granum_learn::family::{FamilyModel, FamilyPrediction, InputSource};
use granum_learn::surrogate::{FitSpec, SurrogateMethods, to_json};
use granum_report::family::{Shown, svg};
use serde_json::{Value, json};

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
    page.families.insert(name, model);
    Ok(answer)
}

fn loaded<'a>(page: &'a Page, arguments: &Arguments) -> Result<&'a FamilyModel, CallError> {
    let name = arguments.text("name")?;
    let unknown = || CallError::Message(format!("the family {name:?} is not loaded"));
    page.families.get(name).ok_or_else(unknown)
}

/// The curves of a test with the given `values` of the inputs, and their figure.
pub(super) fn predict(page: &mut Page, arguments: &Arguments) -> Result<Value, CallError> {
    let model = loaded(page, arguments)?;
    let values = arguments.numbers("values");
    let given: Vec<Option<f64>> =
        model.definition().inputs.iter().map(|input| values.get(input.name).copied()).collect();
    let prediction = model.predict(&given, arguments.number_or("level", LEVEL))?;
    let figure = svg(model, &[Shown { prediction: &prediction, label: String::new(), measured: None }]);
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
