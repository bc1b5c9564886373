//! Columns of text.

use std::ops::Range;

use granum_core::Column;
use parquet::basic::{ConvertedType, Type as Physical};
use parquet::column::reader::ColumnReader;
use parquet::data_type::ByteArray;
use parquet::file::reader::RowGroupReader;
use parquet::schema::types::ColumnDescriptor;

use super::decoding::{GROUP, explain};

/// True for a flat column of UTF-8 text.
pub(super) fn is_text(column: &ColumnDescriptor) -> bool {
    column.path().parts().len() == 1
        && column.max_rep_level() == 0
        && column.physical_type() == Physical::BYTE_ARRAY
        && column.converted_type() == ConvertedType::UTF8
}

/// The texts of some rows of a column of words.
pub(super) fn texts(column: &Column, rows: Range<usize>) -> Vec<ByteArray> {
    rows.map(|row| ByteArray::from(column.word(row).unwrap_or_default())).collect()
}

/// Appends the texts of one column of one group, at most `limit` of them; a null becomes an empty text.
pub(super) fn read_chunk(
    group: &dyn RowGroupReader,
    at: usize,
    limit: usize,
    into: &mut Vec<String>,
) -> Result<(), String> {
    let optional = group.metadata().column(at).column_descr_ptr().max_def_level() > 0;
    let ColumnReader::ByteArrayColumnReader(mut reader) =
        group.get_column_reader(at).map_err(|error| explain(&error))?
    else {
        return Err("holds no text".into());
    };
    let (mut values, mut levels) = (Vec::new(), Vec::new());
    let mut left = limit;
    loop {
        values.clear();
        levels.clear();
        let wanted = GROUP.min(left.saturating_add(1));
        let definition = optional.then_some(&mut levels);
        let read = reader.read_records(wanted, definition, None, &mut values);
        let (records, _, _) = read.map_err(|error| explain(&error))?;
        if records == 0 {
            return Ok(());
        }
        left = left.checked_sub(records).ok_or("has more values than the file has rows")?;
        let mut texts = values.iter();
        for record in 0..records {
            if optional && levels.get(record) == Some(&0) {
                into.push(String::new());
                continue;
            }
            let text = texts.next().ok_or("has fewer values than it claims")?;
            let text = text.as_utf8().map_err(|_| "holds a text that is not UTF-8")?;
            into.push(text.to_string());
        }
    }
}
