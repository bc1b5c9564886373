//! The model file: one JSON document that a person can read, with a checksum as its last entry.

use std::fs;
use std::io::{Read, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::activation::Activation;
use crate::hash::Fnv;
use crate::model::{Column, Fit, Model, ModelError, Provenance};
use crate::network::Network;
use crate::scaler::Scaler;
use crate::trainer::Evidence;
use crate::uncertainty::TrainingRows;

const FORMAT: &str = "granum model";
/// Version 1 had neither intervals nor the range of the answers.
const VERSION: u64 = 2;
/// Largest file that is read.
const LARGEST_FILE: u64 = 1 << 27;
/// What comes before the checksum, which covers every byte before it.
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
    /// For the uncertainty of predictions.
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
    /// Neuron after neuron: the weights of its inputs, then its bias.
    weights: Vec<f64>,
}

/// What is read first, whatever else the file holds.
#[derive(Deserialize)]
struct Header {
    format: Option<String>,
    version: Option<u64>,
}

pub(crate) fn to_json(model: &Model) -> String {
    let column =
        |c: &Column, s: &Scaler| FileColumn { name: c.name.clone(), unit: c.unit.clone(), scaler: *s };
    let mut at = 0;
    let shapes = model.network.layers().windows(2).zip(model.network.activations());
    let layers = shapes.map(|(shape, &activation)| {
        let count = (shape[0] + 1) * shape[1];
        let weights = model.network.weights()[at..at + count].to_vec();
        at += count;
        FileLayer { inputs: shape[0], neurons: shape[1], activation, weights }
    });
    let file = File {
        format: FORMAT.into(),
        version: VERSION,
        inputs: model.inputs.iter().zip(&model.input_scalers).map(|(c, s)| column(c, s)).collect(),
        output: column(&model.output, &model.output_scaler),
        provenance: model.provenance.clone(),
        fit: model.fit.clone(),
        layers: layers.collect(),
        training_rows: model.training_rows.clone(),
        _checksum: String::new(),
    };
    let mut bytes = Vec::new();
    let mut serializer = serde_json::Serializer::with_formatter(&mut bytes, Lines { depth: 0 });
    // Writing plain structures to memory cannot fail; an empty text would fail its checksum when read.
    if file.serialize(&mut serializer).is_err() {
        return String::new();
    }
    let mut text = String::from_utf8(bytes).unwrap_or_default();
    text.truncate(text.trim_end_matches('}').trim_end().len());
    let checksum = checksum(&text);
    text.push_str(&format!("{CHECKSUM}{checksum}\"\n}}\n"));
    text
}

fn checksum(text: &str) -> String {
    let mut hash = Fnv::default();
    hash.write(text.as_bytes());
    hash.hex()
}

pub(crate) fn from_json(text: &str, name: &str) -> Result<Model, ModelError> {
    parse(text).map_err(|problem| ModelError::File { path: name.to_string(), problem })
}

fn parse(text: &str) -> Result<Model, String> {
    let header: Header = serde_json::from_str(text).map_err(|error| {
        if error.is_eof() {
            "the file ends too early: it is truncated; save the model again".to_string()
        } else {
            format!("this is no model file: {error}")
        }
    })?;
    if header.format.as_deref() != Some(FORMAT) {
        let found = header.format.unwrap_or_else(|| "none".into());
        return Err(format!("this is no model file: \"format\" should be \"{FORMAT}\", found {found}"));
    }
    match header.version {
        Some(1..=VERSION) => {}
        Some(version) if version > VERSION => {
            return Err(format!(
                "written by a newer granum (format version {version}, this program reads {VERSION})"
            ));
        }
        _ => return Err(format!("\"version\" should be 1 to {VERSION}")),
    }
    let body = text.rfind(CHECKSUM).map(|at| (&text[..at], &text[at + CHECKSUM.len()..]));
    let intact = body.is_some_and(|(body, rest)| rest.trim_end() == format!("{}\"\n}}", checksum(body)));
    if !intact {
        return Err(
            "the checksum does not fit the content: the file was altered or damaged; save the model again"
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
                "layer {} takes {} inputs, but {} come to it",
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
    let split = |c: FileColumn| (Column { name: c.name, unit: c.unit }, c.scaler);
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

pub(crate) fn save(model: &Model, path: &Path) -> Result<(), ModelError> {
    let failed = |source| ModelError::Io { path: path.display().to_string(), source };
    let mut beside = path.as_os_str().to_owned();
    beside.push(".part");
    let write = || -> std::io::Result<()> {
        // Not written through: what is there by that name may be a link.
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
        // Nothing half-written stays behind; the first error is the one to tell.
        let _ = fs::remove_file(&beside);
        failed(error)
    })
}

pub(crate) fn load(path: &Path) -> Result<Model, ModelError> {
    let name = path.display().to_string();
    let failed = |source| ModelError::Io { path: name.clone(), source };
    let mut bytes = Vec::new();
    let file = fs::File::open(path).map_err(failed)?;
    file.take(LARGEST_FILE + 1).read_to_end(&mut bytes).map_err(failed)?;
    let problem = |text: String| ModelError::File { path: name.clone(), problem: text };
    if bytes.len() as u64 > LARGEST_FILE {
        return Err(problem(format!("larger than {LARGEST_FILE} bytes: this is no model file")));
    }
    let text =
        String::from_utf8(bytes).map_err(|_| problem("this is no model file: not UTF-8 text".into()))?;
    from_json(&text, &name)
}

/// Objects a key a line, lists of numbers on one line.
struct Lines {
    depth: usize,
}

impl Lines {
    fn line<W: ?Sized + Write>(&self, writer: &mut W) -> std::io::Result<()> {
        write!(writer, "\n{}", "  ".repeat(self.depth))
    }
}

impl serde_json::ser::Formatter for Lines {
    fn begin_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> std::io::Result<()> {
        self.depth += 1;
        writer.write_all(b"{")
    }
    fn end_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> std::io::Result<()> {
        self.depth -= 1;
        self.line(writer)?;
        writer.write_all(b"}")
    }
    fn begin_object_key<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> std::io::Result<()> {
        if !first {
            writer.write_all(b",")?;
        }
        self.line(writer)
    }
    fn begin_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> std::io::Result<()> {
        writer.write_all(b": ")
    }
    fn begin_array_value<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> std::io::Result<()> {
        writer.write_all(if first { b"" } else { b", " })
    }
}
