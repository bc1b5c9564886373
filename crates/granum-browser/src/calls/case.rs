//! The text of a case.

use granum_io::Case;
use serde_json::{Value, json};

use crate::answer::CallError;
use crate::page::{Arguments, Page};

/// The name by which messages mean the text.
pub(super) const NAME: &str = "case.toml";

/// Reads the text of a case: what it says, with all defaults, or its mistakes with their places.
pub(super) fn check(_: &mut Page, arguments: &Arguments) -> Result<Value, CallError> {
    let case = Case::parse(arguments.text("case")?, NAME)?;
    let stages: Vec<String> = case.test_stages().iter().map(|stage| stage.name.clone()).collect();
    Ok(json!({
        "grains": case.grains.count,
        "pieces": case.grains.pieces().unwrap_or(case.grains.count),
        "stages": stages,
        "seed": case.preparation.seed,
        "digest": case.digest(),
        "resolved": case.resolved_toml(),
    }))
}

/// The text of a case with other `values` of some keys, all keys written out.
pub(super) fn with(_: &mut Page, arguments: &Arguments) -> Result<Value, CallError> {
    let mut case = Case::parse(arguments.text("case")?, NAME)?;
    for (key, value) in arguments.value("values").as_object().into_iter().flatten() {
        let text = value.as_str().map_or_else(|| value.to_string(), str::to_string);
        case.set(key, &text)?;
    }
    Ok(json!({ "case": case.resolved_toml() }))
}
