//! The model file: a readable JSON document with a checksum as its last entry.

use std::fs;
use std::io::{Read, Write};
use std::path::Path;

use granum_core::json;
use serde::{Deserialize, Serialize};

use crate::feed_forward::activation::Activation;
use crate::feed_forward::network::Network;
use crate::model::model_definition::ModelColumn;
use crate::model::model_error::ModelError;
use crate::model::provenance::{Fit, Provenance};
use crate::model::trained::Model;
use crate::model::uncertainty::TrainingRows;
use crate::table::scaler::Scaler;
use crate::trainer::report::Evidence;

const FORMAT: &str = "granum model";
/// Version of the format. Version 1 contained neither intervals nor the range of the predictions; up to version 2 the
/// checksum was not a SHA-256 digest.
const VERSION: u64 = 3;
/// The last version with the checksum of [`fowler_noll_vo`].
const LAST_WITH_SHORT_CHECKSUM: u64 = 2;
/// Largest file that is read.
const LARGEST_FILE: u64 = 1 << 27;
/// The text before the checksum, which covers all bytes before this text.
const CHECKSUM: &str = ",\n  \"checksum\": \"";

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    version: u64,
    inputs: Vec<FileColumn>,
    output: FileColumn,
    provenance: Provenance,
    fit: Fit,
    layers: Vec<FileLayer>,
    /// The training rows, which are needed for the uncertainty of predictions.
    training_rows: Option<TrainingRows>,
    #[serde(default, skip_serializing, rename = "checksum")]
    _checksum: String,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileColumn {
    name: String,
    unit: String,
    scaler: Scaler,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileLayer {
    inputs: usize,
    neurons: usize,
    activation: Activation,
    /// For one neuron after another, the weights of its inputs and then its bias.
    weights: Vec<f64>,
}

/// The part that is read first, independently of the version of the file.
#[derive(Deserialize)]
struct Header {
    format: Option<String>,
    version: Option<u64>,
}

impl Model {
    /// Writes the model to a temporary file next to `path`, which is then renamed.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), ModelError> {
        save(self, path)
    }

    /// Reads a model.
    ///
    /// # Errors
    /// If the file cannot be read, is truncated or altered, was written by a newer version, or is not a model.
    pub fn load(path: &Path) -> Result<Model, ModelError> {
        load(path)
    }

    /// The text of the file that [`Model::save`] writes.
    pub fn to_json(&self) -> String {
        to_json(self)
    }

    /// Reads a model from the text of its file; `name` is used in error messages.
    ///
    /// # Errors
    /// As [`Model::load`].
    pub fn from_json(text: &str, name: &str) -> Result<Model, ModelError> {
        from_json(text, name)
    }

    /// The content of [`Model::to_json`] without the checksum, as a part of a larger file.
    ///
    /// # Errors
    /// If a number cannot be represented in JSON.
    pub fn to_value(&self) -> Result<serde_json::Value, ModelError> {
        to_value(self)
    }

    /// Recreates a model from the result of [`Model::to_value`]; `name` is used in error messages.
    ///
    /// # Errors
    /// If the value is not a model, or is of a newer version.
    pub fn from_value(value: &serde_json::Value, name: &str) -> Result<Model, ModelError> {
        from_value(value, name)
    }
}

/// The content of the file.
fn content(model: &Model) -> File {
    let column =
        |c: &ModelColumn, s: &Scaler| FileColumn { name: c.name.clone(), unit: c.unit.clone(), scaler: *s };
    let mut at = 0;
    let shapes = model.network.layers().windows(2).zip(model.network.activations());
    let layers = shapes.map(|(shape, &activation)| {
        let count = (shape[0] + 1) * shape[1];
        let weights = model.network.weights()[at..at + count].to_vec();
        at += count;
        FileLayer { inputs: shape[0], neurons: shape[1], activation, weights }
    });
    File {
        format: FORMAT.into(),
        version: VERSION,
        inputs: model.inputs.iter().zip(&model.input_scalers).map(|(c, s)| column(c, s)).collect(),
        output: column(&model.output, &model.output_scaler),
        provenance: model.provenance.clone(),
        fit: model.fit.clone(),
        layers: layers.collect(),
        training_rows: model.training_rows.clone(),
        _checksum: String::new(),
    }
}

fn to_json(model: &Model) -> String {
    // Writing plain structures to memory cannot fail; an empty text would not pass the checksum when it is read.
    let mut text = json::readable(&content(model)).unwrap_or_default();
    text.truncate(text.trim_end_matches('}').trim_end().len());
    let checksum = checksum(&text, VERSION);
    text.push_str(&format!("{CHECKSUM}{checksum}\"\n}}\n"));
    text
}

fn checksum(text: &str, version: u64) -> String {
    if version <= LAST_WITH_SHORT_CHECKSUM {
        return fowler_noll_vo(text);
    }
    granum_core::digest::sha256(text.as_bytes())
}

/// The 64-bit hash of Fowler, Noll and Vo (variant 1a), in model files of earlier versions.
fn fowler_noll_vo(text: &str) -> String {
    let fold = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    format!("{:016x}", text.bytes().fold(0xcbf2_9ce4_8422_2325, fold))
}

/// The content of the file as a JSON value, which can be a part of another file.
fn to_value(model: &Model) -> Result<serde_json::Value, ModelError> {
    let failed =
        |error: serde_json::Error| ModelError::File { path: "model".into(), problem: error.to_string() };
    serde_json::to_value(content(model)).map_err(failed)
}

/// Recreates a model from such a value; `name` is used in error messages.
fn from_value(value: &serde_json::Value, name: &str) -> Result<Model, ModelError> {
    let file = File::deserialize(value).map_err(|error| format!("not a usable model: {error}"));
    let version = |file: File| match (file.format.as_str(), file.version) {
        (FORMAT, 1..=VERSION) => Ok(file),
        (format, version) => {
            let wanted = format!("this program reads \"{FORMAT}\" up to version {VERSION}");
            Err(format!("found format \"{format}\" version {version}; {wanted}"))
        }
    };
    let model = file.and_then(version).and_then(assemble);
    model.map_err(|problem| ModelError::File { path: name.to_string(), problem })
}

fn from_json(text: &str, name: &str) -> Result<Model, ModelError> {
    parse(text).map_err(|problem| ModelError::File { path: name.to_string(), problem })
}

fn parse(text: &str) -> Result<Model, String> {
    let header: Header = serde_json::from_str(text).map_err(|error| {
        if error.is_eof() {
            "the file is truncated; save the model again".to_string()
        } else {
            format!("this is not a model file: {error}")
        }
    })?;
    if header.format.as_deref() != Some(FORMAT) {
        let found = header.format.unwrap_or_else(|| "none".into());
        return Err(format!("this is not a model file: \"format\" should be \"{FORMAT}\", found {found}"));
    }
    let version = match header.version {
        Some(version @ 1..=VERSION) => version,
        Some(version) if version > VERSION => {
            return Err(format!(
                "written by a newer granum (format version {version}, this program reads {VERSION})"
            ));
        }
        _ => return Err(format!("\"version\" should be 1 to {VERSION}")),
    };
    let body = text.rfind(CHECKSUM).map(|at| (&text[..at], &text[at + CHECKSUM.len()..]));
    let intact =
        body.is_some_and(|(body, rest)| rest.trim_end() == format!("{}\"\n}}", checksum(body, version)));
    if !intact {
        return Err(
            "the checksum does not match the content: the file was altered or damaged; save the model again"
                .into(),
        );
    }
    let file: File = serde_json::from_str(text).map_err(|error| format!("not a usable model: {error}"))?;
    assemble(file)
}

fn assemble(file: File) -> Result<Model, String> {
    let mut layers = vec![file.inputs.len()];
    let mut activations = Vec::new();
    let mut weights = Vec::new();
    for (l, layer) in file.layers.iter().enumerate() {
        if layer.inputs != layers[l] {
            return Err(format!(
                "layer {} takes {} inputs, but the layer before gives {}",
                l + 1,
                layer.inputs,
                layers[l]
            ));
        }
        layers.push(layer.neurons);
        activations.push(layer.activation);
        weights.extend_from_slice(&layer.weights);
    }
    if layers.last() != Some(&1) {
        return Err("the last layer should have one neuron".into());
    }
    let network = Network::from_weights(&layers, &activations, weights).map_err(|e| e.to_string())?;
    for column in file.inputs.iter().chain([&file.output]) {
        check_scaler(column)?;
    }
    if let Some(rows) = &file.training_rows {
        rows.check(&network)?;
    }
    if let Some(Evidence { alpha, beta, .. }) = file.fit.evidence
        && !(alpha > 0.0 && beta > 0.0 && alpha.is_finite() && beta.is_finite())
    {
        return Err("the evidence needs a positive alpha and beta".into());
    }
    if let Some(intervals) = &file.fit.intervals {
        let names: Vec<&str> = file.inputs.iter().map(|column| column.name.as_str()).collect();
        intervals.check(&names)?;
    }
    let split = |c: FileColumn| (ModelColumn { name: c.name, unit: c.unit }, c.scaler);
    let (inputs, input_scalers) = file.inputs.into_iter().map(split).unzip();
    let (output, output_scaler) = split(file.output);
    let columns = (inputs, output);
    Ok(Model::assemble(
        columns,
        input_scalers,
        output_scaler,
        network,
        file.provenance,
        file.fit,
        file.training_rows,
    ))
}

fn check_scaler(column: &FileColumn) -> Result<(), String> {
    let Scaler { minimum, maximum, low, high } = column.scaler;
    let finite = [minimum, maximum, low, high, maximum - minimum].iter().all(|v| v.is_finite());
    if finite && minimum <= maximum && low < high {
        return Ok(());
    }
    Err(format!("column {}: its scaler needs finite minimum <= maximum and low < high", column.name))
}

fn save(model: &Model, path: &Path) -> Result<(), ModelError> {
    let failed = |source| ModelError::Io { path: path.display().to_string(), source };
    let mut beside = path.as_os_str().to_owned();
    beside.push(".part");
    let write = || -> std::io::Result<()> {
        // An existing file of that name is removed first: it might be a link, whose target must not be overwritten.
        match fs::remove_file(&beside) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        let mut file = fs::File::create_new(&beside)?;
        file.write_all(to_json(model).as_bytes())?;
        file.sync_all()?;
        fs::rename(&beside, path)
    };
    write().map_err(|error| {
        // The incomplete file is removed, and only the first error is reported.
        let _ = fs::remove_file(&beside);
        failed(error)
    })
}

fn load(path: &Path) -> Result<Model, ModelError> {
    let name = path.display().to_string();
    let failed = |source| ModelError::Io { path: name.clone(), source };
    let mut bytes = Vec::new();
    let file = granum_core::input::open(path).map_err(failed)?;
    file.take(LARGEST_FILE + 1).read_to_end(&mut bytes).map_err(failed)?;
    let problem = |text: String| ModelError::File { path: name.clone(), problem: text };
    if bytes.len() as u64 > LARGEST_FILE {
        return Err(problem(format!("larger than {LARGEST_FILE} bytes: this is not a model file")));
    }
    let text =
        String::from_utf8(bytes).map_err(|_| problem("this is not a model file: not UTF-8 text".into()))?;
    from_json(&text, &name)
}
