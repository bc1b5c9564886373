//! Tests of the Parquet format.

use std::ops::Range;
use std::sync::Arc;

use granum_core::{Column, ColumnKind, Table};
use parquet::basic::Type as Physical;
use parquet::data_type::DoubleType;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;

use super::*;
use crate::error::Error;
use proptest::prelude::*;
use std::fs::{self, File};

fn table(rows: usize) -> Table {
    let numbers = (0..rows).map(|i| (i as f64 * 0.37).sin() * 1e5).collect();
    Table::new(vec![
        Column::new("deviator_strain", "", (0..rows).map(|i| i as f64 * 1e-3).collect()),
        Column::new("mean_stress", "Pa", numbers),
    ])
    .unwrap()
}

#[test]
fn a_table_comes_back_with_units_and_equal_tables_have_equal_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let (one, two) = (folder.path().join("one.parquet"), folder.path().join("two.parquet"));
    for rows in [0, 1, 300_000] {
        write(&one, &table(rows)).unwrap();
        write(&two, &table(rows)).unwrap();
        assert_eq!(read(&one, None).unwrap(), table(rows));
        assert_eq!(fs::read(&one).unwrap(), fs::read(&two).unwrap());
        let whole = table(rows);
        let part = |range: Range<usize>| {
            let cut = |c: &Column| Column::new(&c.name, &c.unit, c.values[range.clone()].to_vec());
            Ok(Table::new(whole.columns().iter().map(cut).collect())?)
        };
        write_parts(&two, rows, part).unwrap();
        assert_eq!(fs::read(&one).unwrap(), fs::read(&two).unwrap(), "in parts");
    }
    let bad = write_parts(&one, 3, |_| Err(Error::Rule("no such grain".into())));
    assert!(bad.unwrap_err().to_string().contains("no such grain"));
    assert_eq!(read(&one, None).unwrap().rows(), 300_000, "what stood there stands");
    let one_column = read(&one, Some(&["mean_stress"])).unwrap();
    assert_eq!(one_column.columns(), &table(300_000).columns()[1..]);
    let error = read(&one, Some(&["mean_stres"])).unwrap_err().to_string();
    assert!(error.ends_with("there is no column mean_stres; did you mean mean_stress?"), "{error}");
}

#[test]
fn integers_and_booleans_are_stored_as_such_and_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.parquet");
    let of = |values: Vec<f64>, kind| {
        Table::new(vec![Column::new("id", "", values.clone()).of_kind(kind)]).unwrap()
    };
    for (values, kind, physical) in [
        (vec![1.0, 9007199254740992.0], ColumnKind::Integer, Physical::INT64),
        (vec![0.0, 1.0], ColumnKind::Boolean, Physical::BOOLEAN),
        (vec![0.5, f64::INFINITY], ColumnKind::Real, Physical::DOUBLE),
    ] {
        write(&path, &of(values.clone(), kind)).unwrap();
        assert_eq!(read(&path, None).unwrap(), of(values, kind));
        let file = SerializedFileReader::new(File::open(&path).unwrap()).unwrap();
        assert_eq!(file.metadata().file_metadata().schema_descr().column(0).physical_type(), physical);
    }
    for (value, kind) in [
        (0.5, ColumnKind::Integer),
        (f64::NAN, ColumnKind::Integer),
        (1e300, ColumnKind::Integer),
        (2.0, ColumnKind::Boolean),
    ] {
        let error = write(&path, &of(vec![value], kind)).unwrap_err().to_string();
        assert!(error.contains("column id") && error.contains(&format!("{value}")), "{error}");
    }
}

#[test]
fn files_that_are_none_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.parquet");
    for content in [&b""[..], b"PAR1", b"not parquet at all, but long enough to hold a footer"] {
        fs::write(&path, content).unwrap();
        let error = read(&path, None).unwrap_err().to_string();
        assert!(error.contains("x.parquet: is not a Parquet file or is damaged"), "{error}");
    }
    write(&path, &table(100)).unwrap();
    let whole = fs::read(&path).unwrap();
    fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    assert!(read(&path, None).is_err());
    let none = Table::new(vec![]).unwrap();
    assert!(write(&path, &none).unwrap_err().to_string().contains("at least one column"));
}

/// Writes columns of every kind that other programs write, with nulls.
fn write_foreign(path: &Path, compression: parquet::basic::Compression) {
    use parquet::data_type::{BoolType, ByteArrayType, Int32Type, Int64Type};
    let message = "message other { required int32 count; required int64 id; optional double gap;
        required boolean sliding; required binary name (UTF8); required int32 unsigned (UINT_32); }";
    let schema = Arc::new(parquet::schema::parser::parse_message_type(message).unwrap());
    // The encoding with which floating-point numbers are compressed best.
    let split = parquet::basic::Encoding::BYTE_STREAM_SPLIT;
    let properties = WriterProperties::builder()
        .set_compression(compression)
        .set_column_dictionary_enabled("gap".into(), false)
        .set_column_encoding("gap".into(), split)
        .build();
    let mut file =
        SerializedFileWriter::new(File::create(path).unwrap(), schema, Arc::new(properties)).unwrap();
    let mut group = file.next_row_group().unwrap();
    let mut at = 0;
    while let Some(mut column) = group.next_column().unwrap() {
        match at {
            0 => column.typed::<Int32Type>().write_batch(&[-3, 4], None, None).unwrap(),
            1 => column.typed::<Int64Type>().write_batch(&[1, 1 << 53], None, None).unwrap(),
            2 => column.typed::<DoubleType>().write_batch(&[0.5], Some(&[0, 1]), None).unwrap(),
            3 => column.typed::<BoolType>().write_batch(&[true, false], None, None).unwrap(),
            4 => column.typed::<ByteArrayType>().write_batch(&["a".into(), "b".into()], None, None).unwrap(),
            _ => column.typed::<Int32Type>().write_batch(&[-1, 1], None, None).unwrap(),
        };
        column.close().unwrap();
        at += 1;
    }
    group.close().unwrap();
    file.close().unwrap();
}

#[test]
fn numeric_columns_of_other_writers_are_read_and_texts_passed_over() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.parquet");
    write_foreign(&path, parquet::basic::Compression::SNAPPY);
    let snappy = read(&path, None).unwrap();
    write_foreign(&path, parquet::basic::Compression::GZIP(parquet::basic::GzipLevel::default()));
    let table = read(&path, None).unwrap();
    assert_eq!(table.names().collect::<Vec<_>>(), ["count", "id", "gap", "sliding", "unsigned"]);
    assert_eq!(table.column("count").unwrap(), [-3.0, 4.0]);
    assert_eq!(snappy.column("sliding").unwrap(), table.column("sliding").unwrap());
    assert_eq!(snappy.column("gap").unwrap()[1], 0.5);
    assert_eq!(table.column("id").unwrap(), [1.0, 9007199254740992.0]);
    assert!(table.column("gap").unwrap()[0].is_nan() && table.column("gap").unwrap()[1] == 0.5);
    assert_eq!(table.column("sliding").unwrap(), [1.0, 0.0]);
    assert_eq!(table.column("unsigned").unwrap(), [4294967295.0, 1.0]);
    let error = read(&path, Some(&["name"])).unwrap_err().to_string();
    assert!(error.contains("column name holds BYTE_ARRAY (UTF8), not plain numbers"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]
    #[test]
    fn a_damaged_file_gives_a_table_or_a_message(flips in proptest::collection::vec((any::<usize>(), 1u8..), 1..4)) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.parquet");
        write_foreign(&path, parquet::basic::Compression::SNAPPY);
        let mut bytes = fs::read(&path).unwrap();
        for (at, mask) in flips {
            let at = at % bytes.len();
            bytes[at] ^= mask;
        }
        fs::write(&path, bytes).unwrap();
        let _ = read(&path, None);
    }
}

/// Lists of any length, also none, are read back with their units, beside flat columns that other readers take alone.
#[test]
fn lists_are_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("states.parquet");
    let table = Table::new(vec![
        Column::new("x", "m", vec![1.0, 2.0, 3.0, 4.0]),
        Column::of_words("run", ["a", "a", "b", "b"]),
    ])
    .unwrap();
    let mut list = ListColumn::new("density", "1/m");
    [&[0.5, 0.25][..], &[], &[1.0], &[2.0, 3.0, 4.0]]
        .iter()
        .for_each(|values| list.push(values.iter().copied()));
    let mut empty = ListColumn::new("none", "");
    (0..4).for_each(|_| empty.push([]));
    let whole = TableWithLists { table: table.clone(), lists: vec![list.clone(), empty] };
    write_with_lists(&path, &whole).unwrap();
    assert_eq!(read_with_lists(&path).unwrap(), whole);
    assert_eq!(read_with_words(&path, None).unwrap(), table);
    assert_eq!(list.lists().map(<[f64]>::len).collect::<Vec<_>>(), [2, 0, 1, 3]);
    // In two groups the same rows.
    let columns =
        TableWithLists { table: table.rows_at(&[]), lists: vec![ListColumn::new("density", "1/m")] };
    let part = |rows: &[usize]| {
        let mut part = ListColumn::new("density", "1/m");
        let all: Vec<&[f64]> = list.lists().collect();
        rows.iter().for_each(|row| part.push(all[*row].iter().copied()));
        TableWithLists { table: table.rows_at(rows), lists: vec![part] }
    };
    let mut parts = vec![part(&[0]), part(&[1, 2, 3])].into_iter();
    write_groups(&path, &columns, || Ok(parts.next())).unwrap();
    assert_eq!(read_with_lists(&path).unwrap(), TableWithLists { table, lists: vec![list] });
}

/// A damaged file is an error and nothing else, whichever byte is wrong.
#[test]
fn damaged_lists_are_refused_or_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("states.parquet");
    let mut list = ListColumn::new("density", "");
    (0..5).for_each(|k| list.push((0..k).map(f64::from)));
    let table = Table::new(vec![Column::new("x", "", vec![0.0; 5])]).unwrap();
    write_with_lists(&path, &TableWithLists { table, lists: vec![list] }).unwrap();
    let whole = std::fs::read(&path).unwrap();
    let mut refused = 0;
    for at in 0..whole.len() {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x2d;
        std::fs::write(&path, &bytes).unwrap();
        refused += usize::from(read_with_lists(&path).is_err());
    }
    assert!(refused > whole.len() / 3, "{refused} of {}", whole.len());
}
