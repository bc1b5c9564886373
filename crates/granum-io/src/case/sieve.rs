//! Sieve curves for `grains.sieve_curve`: points in the case, or a CSV file of diameters and per cent finer.
//!
//! The case of a run contains the points, so that the run no longer needs the file.

use std::path::Path;

use granum_core::quantity::{Dimension, format_number, parse_quantity};
use granum_dem::sizes::check_curve;

use crate::error::{Error, Result};
use crate::sheet::{Sheet, Sought, plain, split};

/// Points of a curve: diameter, m, and share of the mass that is finer.
pub(super) type Points = Vec<[f64; 2]>;

/// The columns of a file.
const COLUMNS: [(&str, Dimension, &str); 2] =
    [("diameter", Dimension::LENGTH, "diameter (mm)"), ("finer", Dimension::NUMBER, "finer (%)")];

/// Most points of a curve.
const MOST_POINTS: usize = 10_000;

/// What the header of a file looks like.
const EXAMPLE: &str = "e.g. diameter (mm),finer (%)";

/// Reads a file whose columns are `diameter` and `finer`, each with its unit in the header, e.g. `diameter (mm),finer (%)`, or in a row below
/// it.
///
/// # Errors
/// If it cannot be read; with line and column for what is wrong in it.
pub(super) fn read(path: &Path) -> Result<Points> {
    with_header(|sought| points(&Sheet::open(path, sought)?))
}

fn with_header<T>(read: impl FnOnce(&Sought) -> Result<T>) -> Result<T> {
    let is_name = |cell: &str| place(split(cell).0).is_some();
    read(&Sought { is_name: &is_name, count: COLUMNS.len(), may_have_units: true })
}

fn points(sheet: &Sheet) -> Result<Points> {
    let factors = header(sheet)?;
    let mut points: Points = Vec::new();
    let mut rows = sheet.rows(&(0..factors.len()).collect::<Vec<_>>())?;
    while rows.advance()? {
        let mut point = [0.0; 2];
        for (column, (place, factor)) in factors.iter().enumerate() {
            point[*place] = rows.number(column, COLUMNS[*place].0)? * factor;
        }
        points.push(point);
        let fault = |wrong: (Option<usize>, String)| wrong.0.map(|_| wrong.1);
        if let Some(message) = check_curve(&points).err().and_then(fault) {
            return Err(rows.whole_error(format!("the point {message}")).into());
        }
        if points.len() > MOST_POINTS {
            return Err(rows.whole_error(format!("a curve can have {MOST_POINTS} points")).into());
        }
    }
    match check_curve(&points) {
        Ok(()) => Ok(points),
        Err((_, message)) => {
            Err(Error::content(Path::new(sheet.file()), format!("the sieve curve {message}")))
        }
    }
}

/// For each column of the file its place in a point, and what its numbers are multiplied by.
fn header(sheet: &Sheet) -> Result<Vec<(usize, f64)>> {
    let column = |at: usize| {
        let (name, unit) = sheet.name_and_unit(at)?;
        column(name, unit).map_err(|message| Error::from(sheet.header_error(at, message).with_help(EXAMPLE)))
    };
    let columns: Vec<(usize, f64)> = (0..sheet.header().len()).map(column).collect::<Result<_>>()?;
    let mut places: Vec<usize> = columns.iter().map(|(place, _)| *place).collect();
    places.sort_unstable();
    if places != [0, 1] {
        let message = "a sieve curve has the columns diameter and finer, each once";
        return Err(sheet.whole_header_error(message.into()).with_help(EXAMPLE).into());
    }
    Ok(columns)
}

/// The place of a column in a point.
fn place(name: &str) -> Option<usize> {
    let is = |name: &str| COLUMNS.iter().position(|(column, _, _)| *column == name);
    is(name).or_else(|| is(&plain(name)))
}

/// Place and factor of a column from its name and unit, e.g. of `finer (%)`.
fn column(name: &str, unit: &str) -> std::result::Result<(usize, f64), String> {
    let Some(place) = place(name) else {
        return Err(format!("{name} is no column of a sieve curve"));
    };
    let (_, dimension, example) = COLUMNS[place];
    if unit.is_empty() {
        return Err(format!("the column {name} needs its unit, as {example}"));
    }
    let factor = parse_quantity(&format!("1 {unit}"), dimension);
    Ok((place, factor.map_err(|why| format!("the unit of {name}: 1 {unit} {why}"))?))
}

/// Points from text such as `[["0.1 mm", "10 %"], [2e-4, 1]]`.
///
/// # Errors
/// A sentence that continues "key = value".
pub(super) fn parse(text: &str) -> std::result::Result<Points, String> {
    let wrong = || format!("is not a list of points; {}", bounds_text());
    let inner = text.trim().strip_prefix('[').and_then(|rest| rest.strip_suffix(']')).ok_or_else(wrong)?;
    let mut points = Vec::new();
    for part in inner
        .split(']')
        .map(|part| part.trim().trim_start_matches(',').trim())
        .filter(|part| !part.is_empty())
    {
        let cells = part.strip_prefix('[').ok_or_else(wrong)?;
        let cells: Vec<&str> = cells.split(',').map(|cell| cell.trim().trim_matches('"')).collect();
        let number = points.len() + 1;
        points.push(point(&cells).map_err(|why| format!("is no sieve curve: point {number} {why}"))?);
    }
    check(points)
}

/// A point from its two texts.
///
/// # Errors
/// A sentence that continues "key = value".
pub(super) fn point(cells: &[&str]) -> std::result::Result<[f64; 2], String> {
    let [diameter, finer] = cells else {
        return Err(format!("has {} values, not a diameter and a share; {}", cells.len(), bounds_text()));
    };
    Ok([parse_quantity(diameter, Dimension::LENGTH)?, parse_quantity(finer, Dimension::NUMBER)? + 0.0])
}

/// Refuses points that are no curve.
///
/// # Errors
/// A sentence that continues "key = value".
pub(super) fn check(points: Points) -> std::result::Result<Points, String> {
    if points.len() > MOST_POINTS {
        return Err(format!("has {} points; at most {MOST_POINTS} are possible", points.len()));
    }
    match check_curve(&points) {
        Ok(()) => Ok(points),
        Err((Some(k), message)) => Err(format!("is no sieve curve: point {} {message}", k + 1)),
        Err((None, message)) => Err(format!("is no sieve curve: it {message}")),
    }
}

/// What a value must be.
pub(super) fn bounds_text() -> String {
    "a CSV file with the columns diameter (mm),finer (%), or a list of points such as [[\"0.1 mm\", \"10 %\"], [\"0.2 mm\", \"100 %\"]]".into()
}

/// Points as TOML in SI units.
pub(super) fn toml(points: &[[f64; 2]]) -> String {
    let point =
        |[diameter, finer]: &[f64; 2]| format!("[{}, {}]", format_number(*diameter), format_number(*finer));
    format!("[{}]", points.iter().map(point).collect::<Vec<_>>().join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Case;

    fn read(text: &str) -> Result<Points> {
        with_header(|sought| points(&Sheet::read(text.as_bytes(), "sand.csv", sought)?))
    }

    #[test]
    fn units_stand_in_the_header() {
        let found = read("# sand\nfiner (%),diameter (mm)\n0,0.1\n25,0.2\n100,0.4\n").unwrap();
        assert_eq!(found, [[1e-4, 0.0], [2e-4, 0.25], [4e-4, 1.0]]);
    }

    #[test]
    fn a_mistake_in_a_point_of_the_case_has_its_place() {
        let text = "[grains]\ndistribution = 'sieve-curve'\nsieve_curve = [[1e-4, 0.3], [2e-4, nan]]\n";
        let error = crate::Case::parse(text, "case.toml").unwrap_err();
        let [error] = error.inputs() else { panic!("{error}") };
        assert_eq!((error.line, error.column), (3, 29), "{error}");
        assert!(error.message.contains("value 2 = [2e-4, nan]"), "{error}");
    }

    #[test]
    fn mistakes_have_line_and_column() {
        for (text, parts) in [
            ("diameter,finer (%)\n", &["sand.csv:1:1", "needs its unit", "diameter (mm)"][..]),
            ("diameter (kg),finer (%)\n", &[":1:1", "is a mass"]),
            ("size (mm),finer (%)\n", &[":1:1", "size is no column"]),
            ("diameter (mm)\n0.1\n", &[":1:1", "each once"]),
            ("diameter (mm),finer (%)\n0.1,0\n0.1,100\n", &[":3:1", "does not rise"]),
            ("diameter (mm),finer (%)\n0.1,0\n0.2,x\n", &[":3:5", "is not a number"]),
            ("diameter (mm),finer (%)\n0.1,0\n0.2,90\n", &["90 % finer", "100 %"]),
        ] {
            let found = read(text).unwrap_err().to_string();
            assert!(parts.iter().all(|part| found.contains(part)), "{text}: {found}");
        }
    }

    #[test]
    fn a_case_has_the_points_or_a_file_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("sand.csv"), "diameter (mm),finer (%)\n0.1,0\n0.3,100\n").unwrap();
        let file = folder.path().join("case.toml");
        std::fs::write(&file, "[grains]\ndistribution = \"sieve-curve\"\nsieve_curve = \"sand.csv\"\n")
            .unwrap();
        let from_file = Case::read(&file).unwrap();
        let text =
            "[grains]\ndistribution = \"sieve-curve\"\nsieve_curve = [[\"0.1 mm\", 0], [3e-4, \"100 %\"]]\n";
        let from_points = Case::parse(text, "case.toml").unwrap();
        assert_eq!(from_file.grains.sizes.curve, [[1e-4, 0.0], [3e-4, 1.0]]);
        assert_eq!(from_file, from_points);
        assert_eq!(Case::parse(&from_file.resolved_toml(), "case.toml").unwrap(), from_file);
        assert_eq!(from_file.digest(), from_points.digest());
        assert_ne!(from_file.preparation_digest(), Case::default().preparation_digest());
        let mut set = Case::default();
        set.set("grains.distribution", "sieve-curve").unwrap();
        set.set("grains.sieve_curve", "[[1e-4, 0], [\"0.3 mm\", 1]]").unwrap();
        assert_eq!(set, from_file);
    }

    #[test]
    fn keys_of_sizes_are_refused_where_they_mean_nothing() {
        for (text, parts) in [
            ("size_deviation = 0.2\n", &["case.toml:2:1", "size_deviation means nothing"][..]),
            ("distribution = \"lognormal\"\nsize_deviation = 3\n", &[":3:18", "from 0.001 to 2"]),
            ("distribution = \"lognormal\"\nspread = 0.1\n", &[":3:1", "spread = 0.1 means nothing"]),
            ("distribution = \"lognrmal\"\n", &[":2:16", "is not known"]),
            ("distribution = \"fractal\"\n", &[":2:1", "needs grains.smallest"]),
            ("distribution = \"sieve-curve\"\n", &[":2:1", "needs grains.sieve_curve"]),
            (
                "distribution = \"sieve-curve\"\nsieve_curve = [[1e-4, 0], [1e-5, 1]]\n",
                &[":3:15", "point 2 does not rise"],
            ),
            (
                "distribution = \"sieve-curve\"\nsieve_curve = [[1e-4, 0, 3], [1e-5, 1]]\n",
                &[":3:16", "value 1 = [1e-4, 0, 3]", "3 values"],
            ),
            (
                "distribution = \"fractal\"\nsmallest = \"1 mm\"\nlargest = \"2 mm\"\ndiameter = \"5 mm\"\n",
                &[":5:1", "diameter"],
            ),
        ] {
            let found = Case::parse(&format!("[grains]\n{text}"), "case.toml").unwrap_err().to_string();
            assert!(parts.iter().all(|part| found.contains(part)), "{text}: {found}");
        }
    }

    #[test]
    fn densities_are_given_in_one_way() {
        let parse = |text: &str| Case::parse(&format!("[preparation]\n{text}"), "case.toml");
        assert_eq!(parse("void_ratio = 0.6\n").unwrap().preparation.target(), Some(0.625));
        let limits = "densest_void_ratio = 0.55\nloosest_void_ratio = 0.75\n";
        let case = parse(&format!("relative_density = \"25 %\"\n{limits}")).unwrap();
        assert!((1.0 / case.preparation.target().unwrap() - 1.7).abs() < 1e-12);
        assert_eq!(Case::parse(&case.resolved_toml(), "case.toml").unwrap(), case);
        for (text, parts) in [
            ("void_ratio = 0.6\nsolid_fraction = 0.62\n".to_string(), &["case.toml:2:1", "both say"][..]),
            (format!("void_ratio = 0.6\nrelative_density = 0.2\n{limits}"), &["both say"]),
            (
                "relative_density = 0.5\n".into(),
                &[":2:1", "needs preparation.densest_void_ratio", "granum limits"],
            ),
            ("densest_void_ratio = 0.8\nloosest_void_ratio = 0.7\n".into(), &[":2:1", "must be below"]),
        ] {
            let found = parse(&text).unwrap_err().to_string();
            assert!(parts.iter().all(|part| found.contains(part)), "{text}: {found}");
        }
    }
}
