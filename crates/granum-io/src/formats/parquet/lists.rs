//! Columns of lists of numbers: a row has as many numbers as its list, for example the bins of a histogram.
//!
//! They are written as the logical type `LIST` of `DOUBLE` (the three levels of the format's specification), which pandas, polars and
//! DuckDB read as lists.

use std::fs::File;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use granum_core::Table;
use parquet::basic::{ConvertedType, LogicalType, Repetition, Type as Physical};
use parquet::column::reader::ColumnReader;
use parquet::data_type::DoubleType;
use parquet::file::metadata::ParquetMetaDataReader;
use parquet::file::reader::{FileReader, RowGroupReader, SerializedFileReader};
use parquet::file::writer::SerializedRowGroupWriter;
use parquet::schema::types::{ColumnDescriptor, Type};

use super::decoding::{GROUP, explain};
use super::metadata::units;
use super::sizes;
use crate::error::{Error, Result};

/// A named column with a list of numbers in each row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ListColumn {
    /// Name, unique in its table.
    pub name: String,
    /// SI unit; empty for pure numbers.
    pub unit: String,
    /// The numbers of all rows, one list after another.
    pub values: Vec<f64>,
    /// The length of the list of each row.
    pub lengths: Vec<usize>,
}

impl ListColumn {
    /// A column without rows.
    pub fn new(name: impl Into<String>, unit: impl Into<String>) -> ListColumn {
        ListColumn { name: name.into(), unit: unit.into(), ..ListColumn::default() }
    }

    /// Adds a row.
    pub fn push(&mut self, list: impl IntoIterator<Item = f64>) {
        let before = self.values.len();
        self.values.extend(list);
        self.lengths.push(self.values.len() - before);
    }

    /// The lists of the rows.
    pub fn lists(&self) -> impl Iterator<Item = &[f64]> {
        let mut start = 0;
        self.lengths.iter().map(move |length| {
            let range = start..start + length;
            start = range.end;
            self.values.get(range).unwrap_or(&[])
        })
    }
}

/// A table with columns of lists beside its columns of numbers and words, all with the same number of rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TableWithLists {
    /// The flat columns.
    pub table: Table,
    /// The columns of lists.
    pub lists: Vec<ListColumn>,
}

/// The type of a column of lists.
pub(super) fn field(name: &str) -> parquet::errors::Result<Arc<Type>> {
    let element =
        Type::primitive_type_builder("element", Physical::DOUBLE).with_repetition(Repetition::REQUIRED);
    let list = Type::group_type_builder("list")
        .with_repetition(Repetition::REPEATED)
        .with_fields(vec![Arc::new(element.build()?)]);
    let column = Type::group_type_builder(name)
        .with_repetition(Repetition::REQUIRED)
        .with_logical_type(Some(LogicalType::List))
        .with_converted_type(ConvertedType::LIST)
        .with_fields(vec![Arc::new(list.build()?)]);
    Ok(Arc::new(column.build()?))
}

/// Writes the rows of a column of lists into a group. An empty list has a place without a number, which the levels tell.
pub(super) fn write_chunk<W: std::io::Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    column: &ListColumn,
    rows: Range<usize>,
) -> parquet::errors::Result<()> {
    let before: usize = column.lengths[..rows.start].iter().sum();
    let (mut definition, mut repetition) = (Vec::new(), Vec::new());
    let mut count = 0;
    for &length in &column.lengths[rows] {
        definition.extend(std::iter::repeat_n(1i16, length));
        repetition.push(0i16);
        match length {
            0 => definition.push(0),
            _ => repetition.extend(std::iter::repeat_n(1i16, length - 1)),
        }
        count += length;
    }
    let values = &column.values[before..before + count];
    if let Some(mut writer) = group.next_column()? {
        writer.typed::<DoubleType>().write_batch(values, Some(&definition), Some(&repetition))?;
        writer.close()?;
    }
    Ok(())
}

/// True for a column of lists of numbers as it is written here.
fn is_list(column: &ColumnDescriptor) -> bool {
    column.path().parts().len() == 3
        && column.max_rep_level() == 1
        && column.max_def_level() == 1
        && column.physical_type() == Physical::DOUBLE
}

/// Reads the columns of lists of a file with so many rows.
pub(super) fn read(path: &Path, file: File, rows: usize) -> Result<Vec<ListColumn>> {
    let wrong = |why: String| Error::content(path, why);
    let damaged = |error| Error::content(path, explain(&error));
    sizes::check_footer(&file).map_err(wrong)?;
    let metadata = ParquetMetaDataReader::new().parse_and_finish(&file).map_err(damaged)?;
    let schema = metadata.file_metadata().schema_descr();
    let places: Vec<usize> = (0..schema.num_columns()).filter(|at| is_list(&schema.column(*at))).collect();
    sizes::check_columns(&file, &metadata, &places).map_err(wrong)?;
    let units = units(metadata.file_metadata().key_value_metadata());
    let reader = SerializedFileReader::new(file).map_err(damaged)?;
    let mut lists: Vec<ListColumn> = places
        .iter()
        .map(|at| {
            let name = schema.column(*at).path().parts()[0].clone();
            let unit = units.get(&name).cloned().unwrap_or_default();
            ListColumn::new(name, unit)
        })
        .collect();
    for group in 0..metadata.num_row_groups() {
        let group = reader.get_row_group(group).map_err(damaged)?;
        for (column, at) in lists.iter_mut().zip(&places) {
            let name = column.name.clone();
            read_chunk(group.as_ref(), *at, rows, column)
                .map_err(|why| Error::content(path, format!("column {name}: {why}")))?;
        }
    }
    match lists.iter().find(|column| column.lengths.len() != rows) {
        Some(short) => {
            let (name, length) = (&short.name, short.lengths.len());
            Err(Error::content(path, format!("column {name} has {length} lists, but the file {rows} rows")))
        }
        None => Ok(lists),
    }
}

/// Appends the lists of one column of one group.
fn read_chunk(
    group: &dyn RowGroupReader,
    at: usize,
    rows: usize,
    into: &mut ListColumn,
) -> std::result::Result<(), String> {
    let ColumnReader::DoubleColumnReader(mut reader) =
        group.get_column_reader(at).map_err(|error| explain(&error))?
    else {
        return Err("holds no lists of numbers".into());
    };
    loop {
        let (mut definition, mut repetition) = (Vec::new(), Vec::new());
        let before = into.values.len();
        let read = reader.read_records(GROUP, Some(&mut definition), Some(&mut repetition), &mut into.values);
        let (records, _, _) = read.map_err(|error| explain(&error))?;
        if records == 0 {
            return Ok(());
        }
        let mut count = 0;
        for (present, level) in definition.iter().zip(&repetition) {
            if *level == 0 {
                into.lengths.push(0);
            }
            if let Some(length) = into.lengths.last_mut() {
                *length += usize::from(*present == 1);
            }
            count += usize::from(*present == 1);
        }
        if into.values.len() - before != count || into.lengths.len() > rows {
            return Err("has other lists than it claims".into());
        }
    }
}
