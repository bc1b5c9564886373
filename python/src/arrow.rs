//! Tables as streams of Arrow, which polars, pandas, pyarrow and DuckDB read without a copy.

use std::collections::HashMap;
use std::ffi::CStr;
use std::sync::Arc;

use arrow_array::RecordBatchOptions;
use arrow_array::ffi::FFI_ArrowSchema;
use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::{
    ArrayRef, BooleanArray, Float64Array, Int64Array, RecordBatch, RecordBatchIterator, StringArray,
};
use arrow_buffer::{Buffer, ScalarBuffer};
use arrow_schema::{ArrowError, DataType, Field, Schema};
use bytes::Bytes;
use granum_core::{Column, ColumnKind, Table};
use pyo3::prelude::*;
use pyo3::types::PyCapsule;

use crate::errors;

/// Names of the capsules of Arrow's interface for Python.
const STREAM: &CStr = c"arrow_array_stream";
const SCHEMA: &CStr = c"arrow_schema";

/// The bytes of a column, which stay those of the table.
struct Shared(Arc<Table>, usize);

impl AsRef<[u8]> for Shared {
    fn as_ref(&self) -> &[u8] {
        self.0.columns().get(self.1).map_or(&[], |column| bytemuck::cast_slice(&column.values))
    }
}

/// True if every value is a whole number that a column of whole numbers can hold.
pub fn is_whole(column: &Column) -> bool {
    const LARGEST: f64 = 9_007_199_254_740_992.0;
    column.values.iter().all(|value| value.fract() == 0.0 && value.abs() <= LARGEST)
}

/// The values of a column: real numbers without a copy.
fn array(table: &Arc<Table>, place: usize, column: &Column) -> ArrayRef {
    match column.kind {
        ColumnKind::Word => Arc::new(StringArray::from_iter_values(
            (0..column.values.len()).map(|row| column.word(row).unwrap_or_default()),
        )),
        ColumnKind::Boolean => {
            Arc::new(BooleanArray::from_iter(column.values.iter().map(|value| Some(*value != 0.0))))
        }
        ColumnKind::Integer if is_whole(column) => {
            Arc::new(Int64Array::from_iter_values(column.values.iter().map(|value| *value as i64)))
        }
        ColumnKind::Integer | ColumnKind::Real => {
            let buffer = Buffer::from(Bytes::from_owner(Shared(table.clone(), place)));
            Arc::new(Float64Array::new(ScalarBuffer::new(buffer, 0, column.values.len()), None))
        }
    }
}

/// The columns of a table with their types and their units.
fn schema(table: &Table) -> Schema {
    let field = |column: &Column| {
        let kind = match column.kind {
            ColumnKind::Word => DataType::Utf8,
            ColumnKind::Boolean => DataType::Boolean,
            ColumnKind::Integer if is_whole(column) => DataType::Int64,
            ColumnKind::Integer | ColumnKind::Real => DataType::Float64,
        };
        let unit = HashMap::from([("unit".to_string(), column.unit.clone())]);
        Field::new(&column.name, kind, false).with_metadata(unit)
    };
    Schema::new(table.columns().iter().map(field).collect::<Vec<Field>>())
}

/// A table as one record batch.
fn batch(table: &Arc<Table>) -> Result<RecordBatch, ArrowError> {
    let arrays = table.columns().iter().enumerate().map(|(k, column)| array(table, k, column)).collect();
    let options = RecordBatchOptions::new().with_row_count(Some(table.rows()));
    RecordBatch::try_new_with_options(Arc::new(schema(table)), arrays, &options)
}

/// The capsule `arrow_array_stream` of a table.
pub fn stream<'py>(py: Python<'py>, table: &Arc<Table>) -> PyResult<Bound<'py, PyCapsule>> {
    let batch = batch(table).map_err(|error| errors::internal(py, &error.to_string()))?;
    let batches = RecordBatchIterator::new([Ok(batch.clone())], batch.schema());
    PyCapsule::new_with_value(py, FFI_ArrowArrayStream::new(Box::new(batches)), STREAM)
}

/// The capsule `arrow_schema` of a table.
pub fn schema_capsule<'py>(py: Python<'py>, table: &Table) -> PyResult<Bound<'py, PyCapsule>> {
    let schema = FFI_ArrowSchema::try_from(&schema(table));
    let schema = schema.map_err(|error| errors::internal(py, &error.to_string()))?;
    PyCapsule::new_with_value(py, schema, SCHEMA)
}
