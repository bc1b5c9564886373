//! Reading Parquet files of any writer, with every size checked before memory is allocated for it.

use std::path::Path;
use std::sync::Arc;

use granum_core::names::suggestion;
use granum_core::{Column, ColumnKind, Table};
use parquet::basic::{ConvertedType, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::metadata::ParquetMetaDataReader;
use parquet::file::reader::{ChunkReader, FileReader, RowGroupReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use super::decoding::{GROUP, explain};
use super::lists::{self, TableWithLists};
use super::metadata::{units, value};
use super::{sizes, words};
use crate::contain::contain;
use crate::error::{Error, Result};

/// Number of values to which even a small file may expand.
const FREE_VALUES: u64 = 1 << 22;
/// Number of further values that each byte of the file may expand to.
const VALUES_PER_BYTE: u64 = 64;

/// Reads the named columns, in that order, or all numeric ones.
///
/// # Errors
/// [`Error::File`] if the file cannot be opened; [`Error::Content`] if it is not a Parquet file, is damaged, has a
/// compression other than snappy and gzip, lacks a column, or a requested column is not flat and numeric.
pub fn read(path: &Path, names: Option<&[&str]>) -> Result<Table> {
    let file = granum_core::input::open_on_disk(path).map_err(Error::file("read", path))?;
    read_contained(path, file, names, Taken::Numbers)
}

/// The same as [`read`], with columns of text (UTF-8) as words.
///
/// # Errors
/// As for [`read`], and if a text is not UTF-8.
pub fn read_with_words(path: &Path, names: Option<&[&str]>) -> Result<Table> {
    let file = granum_core::input::open_on_disk(path).map_err(Error::file("read", path))?;
    read_contained(path, file, names, Taken::NumbersAndWords)
}

/// Reads a file with its columns of lists that granum wrote; the flat columns as [`read_with_words`] does.
///
/// # Errors
/// As [`read_with_words`].
pub fn read_with_lists(path: &Path) -> Result<TableWithLists> {
    let table = read_with_words(path, None)?;
    let file = granum_core::input::open_on_disk(path).map_err(Error::file("read", path))?;
    let lists = contain(|| lists::read(path, file, table.rows())).unwrap_or_else(|| {
        Err(Error::content(path, "is not a Parquet file or is damaged (its lists cannot be decoded)"))
    })?;
    Ok(TableWithLists { table, lists })
}

/// The text of a key in the metadata of a file, if there is one.
///
/// # Errors
/// As [`read`].
pub fn read_metadata(path: &Path, key: &str) -> Result<Option<String>> {
    let file = granum_core::input::open_on_disk(path).map_err(Error::file("read", path))?;
    let found = contain(|| {
        sizes::check_footer(&file).map_err(|why| Error::content(path, why))?;
        let metadata = ParquetMetaDataReader::new().parse_and_finish(&file);
        let metadata = metadata.map_err(|error| Error::content(path, explain(&error)))?;
        Ok(value(metadata.file_metadata().key_value_metadata(), key).map(str::to_string))
    });
    found.unwrap_or_else(|| {
        Err(Error::content(path, "is not a Parquet file or is damaged (its end cannot be decoded)"))
    })
}

/// Which columns are taken.
#[derive(Clone, Copy, PartialEq)]
enum Taken {
    Numbers,
    NumbersAndWords,
}

impl Taken {
    /// The reason why a column is not taken, if there is one.
    fn refuses(self, column: &ColumnDescriptor) -> Option<String> {
        not_numeric(column).filter(|_| self == Taken::Numbers || !words::is_text(column))
    }
}

/// The same as [`read`], from memory; `name` is used in messages.
///
/// # Errors
/// [`Error::Content`] as for [`read`].
pub fn read_bytes(bytes: Vec<u8>, name: &str, names: Option<&[&str]>) -> Result<Table> {
    read_contained(Path::new(name), bytes::Bytes::from(bytes), names, Taken::Numbers)
}

fn read_contained(
    path: &Path,
    input: impl ChunkReader + 'static,
    names: Option<&[&str]>,
    taken: Taken,
) -> Result<Table> {
    contain(|| read_from(path, input, names, taken)).unwrap_or_else(|| {
        Err(Error::content(path, "is not a Parquet file or is damaged (its pages cannot be decoded)"))
    })
}

fn read_from(
    path: &Path,
    input: impl ChunkReader + 'static,
    names: Option<&[&str]>,
    taken: Taken,
) -> Result<Table> {
    let bytes = input.len();
    let wrong = |why: String| Error::content(path, why);
    let damaged = |error: ParquetError| Error::content(path, explain(&error));
    sizes::check_footer(&input).map_err(wrong)?;
    let metadata = ParquetMetaDataReader::new().parse_and_finish(&input).map_err(damaged)?;
    let schema = metadata.file_metadata().schema_descr();
    let wanted = choose(path, schema.columns(), names, taken)?;
    let allowed = FREE_VALUES.max(bytes.saturating_mul(VALUES_PER_BYTE));
    let rows = u64::try_from(metadata.file_metadata().num_rows()).unwrap_or(u64::MAX);
    if rows.saturating_mul(wanted.len() as u64) > allowed {
        return Err(Error::content(
            path,
            format!("claims {rows} rows, more than a file of {bytes} bytes can hold"),
        ));
    }
    sizes::check_columns(&input, &metadata, &wanted).map_err(wrong)?;
    let reader = SerializedFileReader::new(input).map_err(damaged)?;
    let units = units(metadata.file_metadata().key_value_metadata());
    let mut columns: Vec<Column> = wanted
        .iter()
        .map(|at| {
            let column = schema.column(*at);
            let name = column.name().to_string();
            let unit = units.get(&name).cloned().unwrap_or_default();
            let kind = match column.physical_type() {
                // A null becomes NaN, which is neither a whole number nor a truth value.
                _ if column.max_def_level() > 0 => ColumnKind::Real,
                Physical::INT32 | Physical::INT64 => ColumnKind::Integer,
                Physical::BOOLEAN => ColumnKind::Boolean,
                _ => ColumnKind::Real,
            };
            Column::new(name, unit, Vec::new()).of_kind(kind)
        })
        .collect();
    let mut texts: Vec<Vec<String>> = vec![Vec::new(); columns.len()];
    for group in 0..metadata.num_row_groups() {
        let group = reader.get_row_group(group).map_err(damaged)?;
        for ((column, at), texts) in columns.iter_mut().zip(&wanted).zip(&mut texts) {
            let left = (rows as usize).saturating_sub(column.values.len());
            let result = match words::is_text(&schema.column(*at)) {
                true => {
                    words::read_chunk(group.as_ref(), *at, (rows as usize).saturating_sub(texts.len()), texts)
                }
                false => read_chunk(group.as_ref(), *at, left, &mut column.values),
            };
            result.map_err(|why| Error::content(path, format!("column {}: {why}", column.name)))?;
        }
    }
    for ((column, at), texts) in columns.iter_mut().zip(&wanted).zip(texts) {
        if words::is_text(&schema.column(*at)) {
            *column = Column::of_words(std::mem::take(&mut column.name), texts);
        }
    }
    if let Some(short) = columns.iter().find(|column| column.values.len() as u64 != rows) {
        let (name, length) = (&short.name, short.values.len());
        return Err(Error::content(
            path,
            format!("column {name} has {length} values, but the file {rows} rows"),
        ));
    }
    Ok(Table::new(columns)?)
}

/// Indices of the requested columns.
fn choose(
    path: &Path,
    columns: &[Arc<ColumnDescriptor>],
    names: Option<&[&str]>,
    taken: Taken,
) -> Result<Vec<usize>> {
    let Some(names) = names else {
        let numeric: Vec<usize> =
            (0..columns.len()).filter(|at| taken.refuses(&columns[*at]).is_none()).collect();
        if numeric.is_empty() {
            return Err(Error::content(path, "has no flat numeric column"));
        }
        return Ok(numeric);
    };
    names
        .iter()
        .map(|name| {
            let at = columns
                .iter()
                .position(|c| c.name() == *name && c.path().parts().len() == 1)
                .ok_or_else(|| {
                    let help = suggestion(name, columns.iter().map(|column| column.name()));
                    Error::content(path, format!("there is no column {name}; {help}"))
                })?;
            match taken.refuses(&columns[at]) {
                None => Ok(at),
                Some(why) => Err(Error::content(path, format!("column {name} {why}"))),
            }
        })
        .collect()
}

/// The reason why a column is not read as numbers, if there is one.
fn not_numeric(column: &ColumnDescriptor) -> Option<String> {
    if column.path().parts().len() != 1 || column.max_rep_level() > 0 {
        return Some("is nested; only flat columns are read".into());
    }
    let plain = matches!(
        column.physical_type(),
        Physical::BOOLEAN | Physical::INT32 | Physical::INT64 | Physical::FLOAT | Physical::DOUBLE
    );
    let number = matches!(
        column.converted_type(),
        ConvertedType::NONE
            | ConvertedType::INT_8
            | ConvertedType::INT_16
            | ConvertedType::INT_32
            | ConvertedType::INT_64
            | ConvertedType::UINT_8
            | ConvertedType::UINT_16
            | ConvertedType::UINT_32
            | ConvertedType::UINT_64
    );
    // A column with a logical type but no converted type holds times in nanoseconds or something newer, not plain numbers.
    let known = column.converted_type() != ConvertedType::NONE || column.logical_type_ref().is_none();
    (!(plain && number && known)).then(|| {
        format!("holds {:?} ({:?}), not plain numbers", column.physical_type(), column.converted_type())
    })
}

/// Appends the values of one column of one group, at most `limit` of them.
fn read_chunk(
    group: &dyn RowGroupReader,
    at: usize,
    limit: usize,
    into: &mut Vec<f64>,
) -> std::result::Result<(), String> {
    let descriptor = group.metadata().column(at).column_descr_ptr();
    let optional = descriptor.max_def_level() > 0;
    let unsigned = matches!(descriptor.converted_type(), ConvertedType::UINT_32 | ConvertedType::UINT_64);
    let mut chunk = Chunk { optional, limit, into };
    match group.get_column_reader(at).map_err(|error| explain(&error))? {
        ColumnReader::BoolColumnReader(reader) => chunk.read(reader, |value| Ok(f64::from(u8::from(value)))),
        ColumnReader::Int32ColumnReader(reader) if unsigned => {
            chunk.read(reader, |value| Ok(f64::from(value as u32)))
        }
        ColumnReader::Int32ColumnReader(reader) => chunk.read(reader, |value| Ok(f64::from(value))),
        ColumnReader::Int64ColumnReader(reader) => chunk.read(reader, whole),
        ColumnReader::FloatColumnReader(reader) => chunk.read(reader, |value| Ok(f64::from(value))),
        ColumnReader::DoubleColumnReader(reader) => chunk.read(reader, Ok),
        _ => Err("holds no numbers".into()),
    }
}

/// A 64-bit integer as a double, if this is exact. Signed and unsigned integers beyond 2^53 are both rejected.
fn whole(value: i64) -> std::result::Result<f64, String> {
    if value.unsigned_abs() > 1 << 53 {
        return Err(format!("{value} is too large to be represented exactly"));
    }
    Ok(value as f64)
}

struct Chunk<'a> {
    optional: bool,
    limit: usize,
    into: &'a mut Vec<f64>,
}

impl Chunk<'_> {
    fn read<T: DataType>(
        &mut self,
        mut reader: ColumnReaderImpl<T>,
        convert: impl Fn(T::T) -> std::result::Result<f64, String>,
    ) -> std::result::Result<(), String> {
        let (mut values, mut levels) = (Vec::new(), Vec::new());
        let mut left = self.limit;
        loop {
            values.clear();
            levels.clear();
            let wanted = GROUP.min(left.saturating_add(1));
            let definition = self.optional.then_some(&mut levels);
            let (records, _, _) = reader
                .read_records(wanted, definition, None, &mut values)
                .map_err(|error| explain(&error))?;
            if records == 0 {
                return Ok(());
            }
            if records > left {
                return Err("has more values than the file has rows".into());
            }
            left -= records;
            let mut present = values.drain(..);
            let mut next =
                || present.next().ok_or_else(|| "has fewer values than its header states".to_string());
            for record in 0..records {
                let null = self.optional && levels.get(record) == Some(&0);
                self.into.push(if null { f64::NAN } else { convert(next()?)? });
            }
        }
    }
}
