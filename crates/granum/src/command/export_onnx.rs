//! `granum export --to onnx`: a surrogate or a family as a file for programs that evaluate networks.

use std::path::{Path, PathBuf};

use granum_io::check_output_file;
use granum_learn::Surrogate;
use granum_learn::onnx::{OPSET, save, save_family};

use super::chosen_model::ChosenModel;
use super::family_flags::chosen_family;
use super::prediction_input::LEVEL;
use crate::context::Context;
use crate::failure::Failure;

/// The name of the format.
pub(super) const ONNX: &str = "onnx";

/// Writes the surrogate, and says what was written.
pub(super) fn write(
    context: &Context,
    data: &[PathBuf],
    model: Option<&str>,
    family_path: Option<&str>,
    output: &Path,
) -> Result<String, Failure> {
    let [path] = data else {
        return Err(Failure::new("--to onnx takes the file of one surrogate or the folder of one study"));
    };
    check_output_file(output, context.force)?;
    if let Some(family) = chosen_family(path, family_path, model)? {
        save_family(output, &family, LEVEL)?;
        let definition = family.definition();
        let what = format!("the family {} along {}", definition.name, definition.path);
        return Ok(described(&what, family.surrogate()));
    }
    let model = ChosenModel::read(context, path, model)?;
    let surrogate = model.surrogate()?;
    save(output, surrogate, LEVEL)?;
    Ok(described("the surrogate", surrogate))
}

/// What was written.
fn described(what: &str, surrogate: &dyn Surrogate) -> String {
    let columns = surrogate.columns();
    format!(
        "{what} ({}, {} inputs, {} outputs) as ONNX of opset {OPSET}",
        surrogate.method(),
        columns.inputs.len(),
        columns.outputs.len()
    )
}
