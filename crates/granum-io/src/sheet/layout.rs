//! What separates the cells of a table, which line is its header, and whether a row of units follows.

use csv::StringRecord;

use super::column_name::unit_of_cell;
use super::records::{records, start_of_record, trimmed};
use super::sought::Sought;

/// What can separate cells; between equals the first is taken.
const SEPARATORS: [u8; 3] = [b',', b';', b'\t'];
/// A header stands among the first records.
const MOST_BEFORE: usize = 200;
/// Records that must have as many cells as the header, for a separator to be believed where no name is known.
const COMPARED: usize = 20;

/// How a text is a table.
pub(super) struct Layout {
    pub(super) separator: u8,
    /// The names; empty for a text without any record.
    pub(super) header: Vec<String>,
    /// The first byte of the header.
    pub(super) header_at: usize,
    /// The first byte of what follows it, without the row of units.
    pub(super) rows_at: usize,
    /// The units below the names, if they stand there.
    pub(super) units: Vec<String>,
}

/// A record with the bytes at which it begins and ends.
struct Record {
    cells: Vec<String>,
    start: usize,
    end: usize,
}

/// The first records that are not blank.
fn first_records(text: &str, separator: u8, from: usize) -> impl Iterator<Item = Record> {
    let mut reader = records(&text[from..], separator);
    let mut end = from;
    std::iter::from_fn(move || {
        loop {
            let mut record = StringRecord::new();
            if !reader.read_record(&mut record).unwrap_or(false) {
                return None;
            }
            let start = start_of_record(text, end);
            end = from + reader.position().byte() as usize;
            let cells: Vec<String> = record.iter().map(|cell| trimmed(cell).to_string()).collect();
            let is_comment = cells.first().is_some_and(|first| first.starts_with('#'));
            if !is_comment && cells.iter().any(|cell| !cell.is_empty()) {
                return Some(Record { cells, start, end });
            }
        }
    })
}

/// Finds the layout: the separator and the record with the most of the names that are sought, or else a separator into which the first
/// records are cut alike, and the first of them.
pub(super) fn find(text: &str, sought: &Sought) -> Layout {
    let mut best: Option<(usize, u8, Record)> = None;
    for separator in SEPARATORS {
        for record in first_records(text, separator, 0).take(MOST_BEFORE) {
            let score = record.cells.iter().filter(|cell| (sought.is_name)(cell)).count();
            if score > best.as_ref().map_or(0, |(most, ..)| *most) {
                best = Some((score, separator, record));
            }
            if best.as_ref().is_some_and(|(most, ..)| *most >= sought.count) || sought.count == 0 {
                break;
            }
        }
    }
    let header = best.map(|(_, separator, record)| (separator, record)).or_else(|| by_consistency(text));
    let Some((separator, record)) = header else {
        return Layout { separator: b',', header: Vec::new(), header_at: 0, rows_at: 0, units: Vec::new() };
    };
    let mut header = record.cells;
    while header.last().is_some_and(String::is_empty) {
        header.pop();
    }
    let after = first_records(text, separator, record.end).next().filter(|_| sought.may_have_units);
    let (units, rows_at) = match after.and_then(|next| Some((units(&header, &next.cells, sought)?, next.end)))
    {
        Some((units, end)) => (units, end),
        None => (Vec::new(), record.end),
    };
    Layout { separator, header, header_at: record.start, rows_at, units }
}

/// The separator that cuts the first records into the same number of cells, the largest such number.
fn by_consistency(text: &str) -> Option<(u8, Record)> {
    let cut = |separator: u8| {
        let mut all = first_records(text, separator, 0).take(COMPARED);
        let first = all.next()?;
        let filled =
            |cells: &[String]| cells.iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1);
        let width = filled(&first.cells);
        let alike = all.all(|record| filled(&record.cells) <= width && record.cells.len() >= width);
        Some((alike && width > 1, width, separator, first))
    };
    let mut best: Option<(bool, usize, u8, Record)> = None;
    for candidate in SEPARATORS.into_iter().filter_map(cut) {
        if best.as_ref().is_none_or(|(alike, width, ..)| (candidate.0, candidate.1) > (*alike, *width)) {
            best = Some(candidate);
        }
    }
    best.map(|(.., separator, record)| (separator, record))
}

/// The units of a row in which each column that is sought has one, or nothing, and no cell is a number.
fn units(header: &[String], cells: &[String], sought: &Sought) -> Option<Vec<String>> {
    let is_number = |cell: &String| cell.replace(',', ".").parse::<f64>().is_ok();
    let is_written = |cell: &&String| !cell.is_empty();
    if cells.iter().any(is_number) {
        return None;
    }
    let needed = || header.iter().zip(cells).filter(|(name, _)| (sought.is_name)(name)).map(|(_, cell)| cell);
    if needed().filter(is_written).count() == 0 || !needed().all(|cell| unit_of_cell(cell).is_some()) {
        return None;
    }
    Some(cells.iter().take(header.len()).map(|cell| unit_of_cell(cell).unwrap_or("").to_string()).collect())
}
