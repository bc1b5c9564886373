//! The rows of a CSV file as a design: a line with the names of variables, and a line for each point.

use std::path::Path;

use granum_io::sheet::{CellRow, read_cells};
use granum_io::shell::ShowPath;
use granum_io::{Error, Result};

use super::super::definition::{PlanRow, RowPlace};

/// Reads the rows of a CSV file, whose header has the names of these variables.
///
/// # Errors
/// If the file cannot be read, has no rows, or a row has more or fewer cells than the first line; the message names the line.
pub(in crate::plan) fn read_csv(path: &Path, variables: &[&str]) -> Result<Vec<PlanRow>> {
    let file = path.shown();
    let (names, rows) = read_cells(path, variables)?;
    if rows.is_empty() {
        return Err(Error::content(path, "has no rows below the names of variables"));
    }
    let row = |CellRow { line, text, cells }| PlanRow {
        cells: names.iter().cloned().zip(cells).collect(),
        place: RowPlace::Csv { file: file.clone(), line, text },
    };
    Ok(rows.into_iter().map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_told_by_their_lines() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.csv");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            read_csv(&path, &["friction", "pressure"])
        };
        let rows = read("# drawn by hand\nfriction,pressure\n0.2,50 kPa\n\n0.4,\"100 kPa\"\n").unwrap();
        assert_eq!(rows.len(), 2);
        assert_eq!(rows[1].cells[1], ("pressure".into(), "100 kPa".into()));
        assert!(matches!(&rows[1].place, RowPlace::Csv { line: 5, .. }));
        for (text, part) in [
            ("friction,pressure\n0.2\n", "runs.csv:2:1: the row has 1 cells, but the header names 2 columns"),
            ("friction\n", "has no rows"),
            ("", "is empty"),
            (
                "friction,pressure,friction\n0.1,0.2,0.3\n",
                "runs.csv:1:19: two columns have the name friction",
            ),
        ] {
            let message = read(text).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
        let marked = read("\u{feff}friction;pressure (kPa)\n0,2;50,5\n").unwrap();
        assert_eq!(
            marked[0].cells,
            [("friction".into(), "0.2".into()), ("pressure".into(), "50.5 kPa".into())]
        );
    }
}
