//! ONNX files of surrogates.

use std::io::Write;
use std::path::Path;

use granum_core::digest;
use granum_io::atomic::write_atomically;
use prost::Message;

use crate::error::Result;
use crate::family::FamilyModel;
use crate::onnx::messages::{ModelProto, OperatorSetIdProto, StringStringEntryProto};
use crate::onnx::{MOST_BYTES, OPSET, OnnxGraph, too_large};
use crate::surrogate::{Surrogate, check_level, to_json};

/// Version of the format of the file.
pub const IR_VERSION: i64 = 8;

/// The bytes of an ONNX file with all that a surrogate predicts: inputs and outputs in physical units under the names of its columns, scaling inside, and intervals that should
/// contain the given share of the observations of new runs.
///
/// Every tensor holds doubles, with a row for each state. Without memory the inputs are the columns, and the outputs those of
/// [`predict_table`](crate::inference::predict_table). A surrogate with memory is one step of it: the input `memory` is the output `next_memory` of the state before, and
/// where `begins` is 1 a run begins, whatever the memory is. The metadata state opset, units, trained ranges, the version of granum and the SHA-256 of the
/// surrogate's own file.
///
/// ```
/// use granum_core::observer::NoObserver;
/// use granum_core::{Column, Table};
/// use granum_learn::{Dataset, FitSpec, RunStates, SurrogateMethods, onnx};
///
/// let x: Vec<f64> = (0..20).map(f64::from).collect();
/// let y = x.iter().map(|x| 3.0 * x).collect();
/// let table = Table::new(vec![Column::new("x", "", x), Column::new("y", "Pa", y)])?;
/// let dataset = Dataset::new(vec![RunStates::new("run", table)?])?;
/// let methods = SurrogateMethods::standard();
/// let spec = FitSpec::new(["x"], ["y"]).with_coordinate("x");
/// let ridge = methods.by_name("ridge")?.fit(&dataset, &spec, &mut NoObserver)?;
/// assert!(onnx::to_bytes(ridge.as_ref(), 0.9)?.len() > 1000);
/// let nearest = methods.by_name("nearest-run")?.fit(&dataset, &spec, &mut NoObserver)?;
/// let refused = onnx::to_bytes(nearest.as_ref(), 0.9).unwrap_err().to_string();
/// assert!(refused.starts_with("nearest-run: it has no ONNX form"), "{refused}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the surrogate has no ONNX form, with the reason, or the level is not between 0 and 1.
pub fn to_bytes(surrogate: &dyn Surrogate, level: f64) -> Result<Vec<u8>> {
    check_level(surrogate.method(), level)?;
    let mut graph = OnnxGraph::default();
    surrogate.onnx(&mut graph, level)?;
    of_graph(graph, surrogate, level)
}

/// The bytes of an ONNX file with what a fitted family answers where the values of all of its inputs are given; the metadata state family and path as well. See [`to_bytes`].
///
/// # Errors
/// As [`FamilyModel::onnx`].
pub fn family_to_bytes(family: &FamilyModel, level: f64) -> Result<Vec<u8>> {
    check_level(family.surrogate().method(), level)?;
    let mut graph = OnnxGraph::default();
    family.onnx(&mut graph, level)?;
    of_graph(graph, family.surrogate(), level)
}

/// The file of the graph of a surrogate.
fn of_graph(mut graph: OnnxGraph, surrogate: &dyn Surrogate, level: f64) -> Result<Vec<u8>> {
    let version = env!("CARGO_PKG_VERSION");
    graph.state("granum.version", version);
    graph.state("granum.method", surrogate.method());
    graph.state("granum.sha256", digest::sha256(to_json(surrogate)?.as_bytes()));
    graph.state("opset", OPSET.to_string());
    graph.state("ir_version", IR_VERSION.to_string());
    graph.state("interval_level", level.to_string());
    let columns = surrogate.columns();
    for (kind, variables) in [("input", &columns.inputs), ("output", &columns.outputs)] {
        for variable in variables {
            let unit = if variable.unit.is_empty() { "1" } else { &variable.unit };
            graph.state(&format!("unit.{kind}.{}", variable.name), unit);
        }
    }
    let entry = |(key, value): &(String, String)| StringStringEntryProto {
        key: Some(key.clone()),
        value: Some(value.clone()),
    };
    let model = ModelProto {
        ir_version: Some(IR_VERSION),
        opset_import: vec![OperatorSetIdProto { domain: Some(String::new()), version: Some(OPSET) }],
        producer_name: Some("granum".into()),
        producer_version: Some(version.into()),
        doc_string: Some(format!("{} surrogate of granum", surrogate.method())),
        metadata_props: graph.metadata().iter().map(entry).collect(),
        graph: Some(graph.message(surrogate.method())),
    };
    let bytes = model.encoded_len();
    if bytes > MOST_BYTES {
        return Err(too_large(surrogate.method(), bytes));
    }
    Ok(model.encode_to_vec())
}

/// Writes the ONNX file of a surrogate, see [`to_bytes`].
///
/// # Errors
/// If the surrogate has no ONNX form, or the file cannot be written.
pub fn save(path: &Path, surrogate: &dyn Surrogate, level: f64) -> Result<()> {
    let bytes = to_bytes(surrogate, level)?;
    write_atomically(path, |file| file.write_all(&bytes))?;
    Ok(())
}

/// Writes the ONNX file of a fitted family, see [`family_to_bytes`].
///
/// # Errors
/// If it has no ONNX form, or the file cannot be written.
pub fn save_family(path: &Path, family: &FamilyModel, level: f64) -> Result<()> {
    let bytes = family_to_bytes(family, level)?;
    write_atomically(path, |file| file.write_all(&bytes))?;
    Ok(())
}
