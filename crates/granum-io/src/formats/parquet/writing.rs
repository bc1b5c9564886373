//! Writing Parquet files, whole or group by group.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use granum_core::{Column, ColumnKind, Table};
use parquet::basic::{ConvertedType, Encoding, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use super::decoding::GROUP;
use super::lists::{self, ListColumn, TableWithLists};
use super::metadata::UNITS;
use super::words;
use crate::atomic::write_atomically;
use crate::error::{Error, Result};

/// Writes a table under a temporary name and renames it.
///
/// # Errors
/// [`Error::Rule`] for a table without columns; [`Error::File`] if the file cannot be written.
pub fn write(path: &Path, table: &Table) -> Result<()> {
    write_with_metadata(path, table, &[])
}

/// The same with further metadata of the file: keys with texts.
///
/// # Errors
/// As [`write()`].
pub fn write_with_metadata(path: &Path, table: &Table, further: &[(&str, String)]) -> Result<()> {
    if table.columns().is_empty() {
        return Err(Error::Rule("a Parquet file needs at least one column".into()));
    }
    write_atomically(path, |file| {
        let mut writer = start(file, table, further).map_err(io_error)?;
        for from in (0..table.rows()).step_by(GROUP) {
            write_group(&mut writer, table, from..table.rows().min(from + GROUP)).map_err(io_error)?;
        }
        writer.close().map(|_| ()).map_err(io_error)
    })
}

/// Writes a table of `rows` rows that is never completely in memory: `part` returns the rows of a range.
///
/// # Errors
/// As for [`write()`], and any error of `part`.
pub fn write_parts(path: &Path, rows: usize, part: impl Fn(Range<usize>) -> Result<Table>) -> Result<()> {
    let mut failed = None;
    let written = write_atomically(path, |file| {
        let mut next = |range| part(range).map_err(|error| keep(&mut failed, error));
        let mut writer = start(file, &next(0..0)?, &[]).map_err(io_error)?;
        for from in (0..rows).step_by(GROUP) {
            let table = next(from..rows.min(from + GROUP))?;
            write_group(&mut writer, &table, 0..table.rows()).map_err(io_error)?;
        }
        writer.close().map(|_| ()).map_err(io_error)
    });
    failed.map_or(written, Err)
}

/// Writes a table with columns of lists under a temporary name and renames it.
///
/// # Errors
/// As [`write()`].
pub fn write_with_lists(path: &Path, whole: &TableWithLists) -> Result<()> {
    let columns = TableWithLists {
        table: whole.table.rows_at(&[]),
        lists: whole.lists.iter().map(|list| ListColumn::new(&list.name, &list.unit)).collect(),
    };
    let mut parts = Some(whole.clone()).into_iter();
    write_groups(path, &columns, || Ok(parts.next()))
}

/// Writes a table with columns of lists that is never completely in memory: `columns` has its columns and no rows, and `next` returns
/// one group of rows after another, all with these columns.
///
/// # Errors
/// As for [`write()`], and any error of `next`.
pub fn write_groups(
    path: &Path,
    columns: &TableWithLists,
    mut next: impl FnMut() -> Result<Option<TableWithLists>>,
) -> Result<()> {
    if columns.table.columns().is_empty() {
        return Err(Error::Rule("a Parquet file needs at least one column".into()));
    }
    let mut failed = None;
    let written = write_atomically(path, |file| {
        let mut fields = flat_fields(&columns.table).map_err(io_error)?;
        for list in &columns.lists {
            fields.push(lists::field(&list.name).map_err(io_error)?);
        }
        let flat = columns.table.columns().iter().map(|column| (column.name.as_str(), column.unit.as_str()));
        let lists = columns.lists.iter().map(|list| (list.name.as_str(), list.unit.as_str()));
        let mut writer = begin(file, fields, &flat.chain(lists).collect(), &[]).map_err(io_error)?;
        while let Some(group) = next().map_err(|error| keep(&mut failed, error))? {
            for from in (0..group.table.rows()).step_by(GROUP) {
                let rows = from..group.table.rows().min(from + GROUP);
                write_rows(&mut writer, &group.table, &group.lists, rows).map_err(io_error)?;
            }
        }
        writer.close().map(|_| ()).map_err(io_error)
    });
    failed.map_or(written, Err)
}

/// Stores the error of a part, and returns an error for the writer.
fn keep(failed: &mut Option<Error>, error: Error) -> io::Error {
    *failed = Some(error);
    io::Error::other("a part of the table cannot be produced")
}

/// A file with the columns of a table and no rows so far.
fn start<W: Write + Send>(
    writer: W,
    table: &Table,
    further: &[(&str, String)],
) -> parquet::errors::Result<SerializedFileWriter<W>> {
    let units = table.columns().iter().map(|column| (column.name.as_str(), column.unit.as_str())).collect();
    begin(writer, flat_fields(table)?, &units, further)
}

/// The types of the columns of a table.
fn flat_fields(table: &Table) -> parquet::errors::Result<Vec<Arc<Type>>> {
    let field = |column: &Column| {
        let physical = match column.kind {
            ColumnKind::Real => Physical::DOUBLE,
            ColumnKind::Integer => Physical::INT64,
            ColumnKind::Boolean => Physical::BOOLEAN,
            ColumnKind::Word => Physical::BYTE_ARRAY,
        };
        let text = if column.has_words() { ConvertedType::UTF8 } else { ConvertedType::NONE };
        let field = Type::primitive_type_builder(&column.name, physical).with_converted_type(text);
        Ok(Arc::new(field.with_repetition(Repetition::REQUIRED).build()?))
    };
    table.columns().iter().map(field).collect()
}

/// A file with these columns, their units and further metadata, and no rows so far.
fn begin<W: Write + Send>(
    writer: W,
    fields: Vec<Arc<Type>>,
    units: &BTreeMap<&str, &str>,
    further: &[(&str, String)],
) -> parquet::errors::Result<SerializedFileWriter<W>> {
    let schema = Type::group_type_builder("granum").with_fields(fields).build()?;
    let units = serde_json::to_string(units).map_err(|error| ParquetError::External(Box::new(error)))?;
    let further = further.iter().map(|(key, text)| KeyValue::new((*key).to_string(), text.clone()));
    let metadata = std::iter::once(KeyValue::new(UNITS.into(), units)).chain(further).collect();
    let properties = WriterProperties::builder()
        .set_created_by("granum".into())
        .set_dictionary_enabled(false)
        .set_encoding(Encoding::PLAIN)
        .set_statistics_enabled(EnabledStatistics::None)
        .set_offset_index_disabled(true)
        .set_key_value_metadata(Some(metadata))
        .build();
    SerializedFileWriter::new(writer, Arc::new(schema), Arc::new(properties))
}

fn write_group<W: Write + Send>(
    file: &mut SerializedFileWriter<W>,
    table: &Table,
    rows: Range<usize>,
) -> parquet::errors::Result<()> {
    write_rows(file, table, &[], rows)
}

fn write_rows<W: Write + Send>(
    file: &mut SerializedFileWriter<W>,
    table: &Table,
    lists: &[ListColumn],
    rows: Range<usize>,
) -> parquet::errors::Result<()> {
    let mut group = file.next_row_group()?;
    for column in table.columns() {
        if let Some(mut writer) = group.next_column()? {
            let values = &column.values[rows.clone()];
            match column.kind {
                ColumnKind::Real => {
                    writer.typed::<DoubleType>().write_batch(values, None, None)?;
                }
                ColumnKind::Integer => {
                    let values = converted(column, values, whole_number)?;
                    writer.typed::<Int64Type>().write_batch(&values, None, None)?;
                }
                ColumnKind::Boolean => {
                    let values = converted(column, values, |value| match value {
                        0.0 => Some(false),
                        1.0 => Some(true),
                        _ => None,
                    })?;
                    writer.typed::<BoolType>().write_batch(&values, None, None)?;
                }
                ColumnKind::Word => {
                    let texts = words::texts(column, rows.clone());
                    writer.typed::<ByteArrayType>().write_batch(&texts, None, None)?;
                }
            }
            writer.close()?;
        }
    }
    for list in lists {
        lists::write_chunk(&mut group, list, rows.clone())?;
    }
    group.close()?;
    Ok(())
}

/// The integer equal to a double; `None` if it is not a whole number, or so large that not every integer of its size is a
/// double.
fn whole_number(value: f64) -> Option<i64> {
    (value.fract() == 0.0 && value.abs() <= (1u64 << 53) as f64).then_some(value as i64)
}

/// The values of a column, converted to another type.
fn converted<T>(
    column: &Column,
    values: &[f64],
    convert: impl Fn(f64) -> Option<T>,
) -> parquet::errors::Result<Vec<T>> {
    let one = |value: &f64| {
        convert(*value).ok_or_else(|| {
            let (name, kind) = (&column.name, column.kind);
            ParquetError::General(format!("column {name}: {value} cannot be written as {kind:?}"))
        })
    };
    values.iter().map(one).collect()
}

fn io_error(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(inner) => match inner.downcast::<io::Error>() {
            Ok(inner) => *inner,
            Err(inner) => io::Error::other(inner),
        },
        other => io::Error::other(other),
    }
}
