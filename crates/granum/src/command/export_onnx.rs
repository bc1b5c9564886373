//! `granum export --to onnx`: a surrogate as a file for programs that evaluate networks.

use std::path::{Path, PathBuf};

use granum::families::{FITTED, FittedFamily};
use granum_io::check_output_file;
use granum_io::shell::ShowPath;
use granum_learn::onnx::{OPSET, refused, save};

use super::chosen_model::ChosenModel;
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
    output: &Path,
) -> Result<String, Failure> {
    let [path] = data else {
        return Err(Failure::new("--to onnx takes the file of one surrogate or the folder of one study"));
    };
    check_output_file(output, context.force)?;
    // The name of a family, and no file of that name.
    let is_family = |known: &FittedFamily| Some(known.name) == path.to_str();
    if !path.exists() && FITTED.iter().any(is_family) {
        return Err(Failure::new(format!("family {}, {}", path.shown(), refused("gaussian-process"))));
    }
    let model = ChosenModel::read(context, path, model)?;
    let surrogate = model.surrogate()?;
    save(output, surrogate, LEVEL)?;
    let columns = surrogate.columns();
    Ok(format!(
        "the surrogate ({}, {} inputs, {} outputs) as ONNX of opset {OPSET}",
        surrogate.method(),
        columns.inputs.len(),
        columns.outputs.len()
    ))
}
