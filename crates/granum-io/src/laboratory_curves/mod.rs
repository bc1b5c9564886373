//! Curves of laboratory tests: a CSV file with one row a reading, of one test or of several.
//!
//! The header names the columns, each with its unit, as in `axial_strain (%)` or `axial_stress_kPa`, or with the units in the row below
//! (see [`sheet`](crate::sheet) for what a file may look like). Known are [`QUANTITIES`] and `test`, the name of the test of a row; other columns are ignored, and a column of another name can be
//! mapped to a known one. Compression is positive, strains are engineering strains (changes over initial lengths and volume) and
//! stresses effective ones, unless a comment such as `# compression = negative`, `# compression axial_strain = negative` or `# strain = logarithmic`, or [`Conventions`], say
//! otherwise. What readings show to be otherwise is a doubt, which is told and changes nothing.

mod conventions;
mod doubts;
mod laboratory_test;

use std::collections::HashMap;
use std::path::Path;

use granum_core::names::suggestion;
use granum_core::quantity::{Dimension, format_number, parse_quantity};

use crate::case::doubt::{Known, NumberKind};
use crate::error::{Error, InputError, Result};
use crate::sheet::{Sheet, Sought, plain, signs, split};

pub use conventions::{Conventions, DeviatorMeasure};
pub use laboratory_test::{LaboratoryDoubt, LaboratoryTest, QUANTITIES};

use laboratory_test::Readings;

/// Column with the name of the test.
const TEST: &str = "test";

/// A column of the file that is used.
struct SourceColumn {
    /// Its place in the file.
    at: usize,
    quantity: usize,
    factor: f64,
    /// Where the name of the column stands, if it has no unit.
    bare: Option<InputError>,
}

/// The columns of a file that are used, and the place of that of the names of tests.
struct Header {
    columns: Vec<SourceColumn>,
    test: Option<usize>,
}

/// The readings of a test, in the order of [`QUANTITIES`].
type Reading = [f64; QUANTITIES.len()];

/// Reads all tests of a file, in the order in which they first appear.
///
/// # Errors
/// If it cannot be read; with line and column for what is wrong in it.
pub fn read_laboratory(path: impl AsRef<Path>, conventions: &Conventions) -> Result<Vec<LaboratoryTest>> {
    let path = path.as_ref();
    with_header(conventions, |sought| read(Sheet::open(path, sought)?, conventions))
}

/// Reads what has a header with the quantities of a test, or with the columns that are mapped to them.
fn with_header<T>(conventions: &Conventions, read: impl FnOnce(&Sought) -> Result<T>) -> Result<T> {
    let is_mapped = |cell: &str| {
        conventions.columns.iter().any(|(_, column)| cell == column || split(cell).0 == split(column).0)
    };
    let is_name = |cell: &str| is_mapped(cell) || quantity_named(split(cell).0).is_some();
    read(&Sought { is_name: &is_name, count: usize::MAX, may_have_units: true })
}

/// The quantity of a name, or of one that differs in capitals and blanks.
fn quantity_named(name: &str) -> Option<usize> {
    laboratory_test::place(name).or_else(|| laboratory_test::place(&plain(name)))
}

fn read(sheet: Sheet, conventions: &Conventions) -> Result<Vec<LaboratoryTest>> {
    let sheet = sheet.with_mark(conventions.decimal_mark);
    let mut stated = Conventions::default();
    for (at, text) in sheet.comments() {
        comment(&sheet, at, text, &mut stated)?;
    }
    let file = Path::new(sheet.file());
    let stated = conventions.or(stated).resolved().map_err(|why| Error::content(file, why))?;
    let header = header(&sheet, conventions)?;
    let tests = readings(&sheet, &header)?;
    if tests.is_empty() {
        return Err(Error::content(
            file,
            "has no rows; a header of columns and a row for each reading are needed",
        ));
    }
    for column in &header.columns {
        check_bare(column, tests.iter().flat_map(|(_, rows)| rows).map(|row| row[column.quantity]))?;
    }
    tests.into_iter().map(|(name, rows)| test(file, name, &rows, &stated)).collect()
}

/// The readings of each test, in the order in which they first appear.
fn readings(sheet: &Sheet, header: &Header) -> Result<Vec<(String, Vec<Reading>)>> {
    let mut tests: Vec<(String, Vec<Reading>)> = Vec::new();
    let mut places: HashMap<String, usize> = HashMap::new();
    let mut rows = sheet.rows(&header.columns.iter().map(|column| column.at).collect::<Vec<_>>())?;
    while rows.advance()? {
        let mut reading = [f64::NAN; QUANTITIES.len()];
        for column in &header.columns {
            let value = rows.finite(column.at, QUANTITIES[column.quantity].0)?;
            reading[column.quantity] = value * column.factor;
        }
        let name = header.test.map_or("", |at| rows.cell(at));
        match places.get(name) {
            Some(place) => tests[*place].1.push(reading),
            None => {
                places.insert(name.to_string(), tests.len());
                tests.push((name.to_string(), vec![reading]));
            }
        }
    }
    Ok(tests)
}

/// Refuses strains beyond 1 in a column whose name has no unit: they are probably in per cent.
fn check_bare(column: &SourceColumn, values: impl Iterator<Item = f64>) -> Result<()> {
    let Some(place) = &column.bare else { return Ok(()) };
    let larger = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
    let largest = values.fold(0.0, larger);
    let name = QUANTITIES[column.quantity].0;
    let Some(doubt) = Known::of_sample(f64::NAN).doubt(NumberKind::Strain, largest, &format_number(largest))
    else {
        return Ok(());
    };
    let mut error = place.clone();
    error.message = format!("{name} goes to {} and {}", format_number(largest), doubt.message());
    let help = format!(
        "{}; --map {name}='COLUMN (%)' says the same of a file that is left as it is",
        doubt.header_help(name)
    );
    Err(error.with_help(help).into())
}

/// A comment may state a convention.
fn comment(sheet: &Sheet, at: usize, text: &str, stated: &mut Conventions) -> Result<()> {
    let wrong = |message| Error::from(sheet.error(at..at + text.len(), message));
    if let Some(signs) = signs::of_comment(text) {
        return stated.state("compression", signs).map_err(wrong);
    }
    let text = text.trim().trim_start_matches('#').trim();
    let Some((key, value)) = text.split_once('=').map(|(key, value)| (key.trim(), value.trim())) else {
        return Ok(());
    };
    match Conventions::is_key(key) && key != "decimal" {
        true => stated.state(key, value).map_err(wrong),
        false => Ok(()),
    }
}

/// A column that is mapped: its place, the quantity, and the unit that goes before that of the header.
type Mapped<'a> = (usize, &'a str, &'a str);

fn mapped<'a>(sheet: &Sheet, conventions: &'a Conventions) -> Result<Vec<Mapped<'a>>> {
    let mut mapped: Vec<Mapped> = Vec::new();
    for (quantity, column) in &conventions.columns {
        let quantities = QUANTITIES.iter().map(|(name, _)| *name).chain([TEST]);
        if !quantities.clone().any(|name| name == quantity) {
            let message = format!(
                "{quantity} is no quantity of a laboratory test; {}",
                suggestion(quantity, quantities)
            );
            return Err(Error::Rule(message));
        }
        let at = mapped_place(sheet, column)?;
        let twice = mapped.iter().find(|(place, other, _)| *place == at || other == quantity);
        if let Some((place, other, _)) = twice {
            let message = match *place == at {
                true => format!("the column is mapped to {other} and to {quantity}"),
                false => format!("the column is mapped to {quantity}, and so is {}", sheet.header()[*place]),
            };
            return Err(sheet.header_error(at, message).into());
        }
        mapped.push((at, quantity, split(column).1));
    }
    Ok(mapped)
}

/// The place of a column that is named as in the header, or without its unit.
fn mapped_place(sheet: &Sheet, column: &str) -> Result<usize> {
    let header = sheet.header();
    if let Some(at) = header.iter().position(|cell| cell == column) {
        return Ok(at);
    }
    let (name, _) = split(column);
    let mut named = header.iter().enumerate().filter(|(_, cell)| split(cell).0 == name);
    match (named.next(), named.next()) {
        (Some((at, _)), None) => Ok(at),
        (Some((_, first)), Some((_, second))) => {
            let message = format!("both {first} and {second} are columns {name}; give one of them in full");
            Err(Error::content(Path::new(sheet.file()), message))
        }
        (None, _) => {
            let help = suggestion(name, header.iter().map(String::as_str));
            Err(Error::content(Path::new(sheet.file()), format!("there is no column {name}; {help}")))
        }
    }
}

fn header(sheet: &Sheet, conventions: &Conventions) -> Result<Header> {
    let mapped = mapped(sheet, conventions)?;
    let is_exact = |name: &str| sheet.header().iter().any(|cell| split(cell).0 == name);
    let mut header = Header { columns: Vec::new(), test: None };
    for (at, cell) in sheet.header().iter().enumerate() {
        let (written, _) = split(cell);
        let mapping = mapped.iter().find(|(place, _, _)| *place == at);
        let name_of = |quantity: usize| QUANTITIES[quantity].0;
        // A name in other words, such as "Axial strain", stands for the known one where that is not there.
        let meant = match laboratory_test::place(&plain(written)).map(name_of).filter(|name| !is_exact(name))
        {
            Some(name) => name,
            None => written,
        };
        let taken = mapped.iter().any(|(_, quantity, _)| *quantity == meant);
        let (name, stated_unit) = match mapping {
            Some((_, quantity, unit)) => (*quantity, *unit),
            None if taken => continue,
            None => (meant, ""),
        };
        if name == TEST {
            header.test = Some(at);
        }
        let Some(quantity) = laboratory_test::place(name) else { continue };
        if let Some(first) = header.columns.iter().find(|column| column.quantity == quantity) {
            let first = &sheet.header()[first.at];
            let message = format!("{cell} is {name}, and so is the column {first}");
            let help = format!("leave one of them out, or name the right one: --map {name}='COLUMN'");
            return Err(sheet.header_error(at, message).with_help(help).into());
        }
        header.columns.push(source_column(sheet, at, quantity, stated_unit)?);
    }
    let is_axial = |column: &SourceColumn| QUANTITIES[column.quantity].0 == "axial_strain";
    if !header.columns.iter().any(is_axial) {
        let names: Vec<&str> = sheet.header().iter().map(String::as_str).take(12).collect();
        let message = format!(
            "there is no column axial_strain among {}; name it in the header, or map a column to it (--map axial_strain='COLUMN')",
            names.join(", ")
        );
        return Err(Error::content(Path::new(sheet.file()), message));
    }
    Ok(header)
}

/// A column of a quantity with its unit: the stated one, or else that of the header or of the row below it.
fn source_column(sheet: &Sheet, at: usize, quantity: usize, stated_unit: &str) -> Result<SourceColumn> {
    let (name, dimension) = QUANTITIES[quantity];
    let unit = if stated_unit.is_empty() { sheet.name_and_unit(at)?.1 } else { stated_unit };
    if unit.is_empty() && dimension == Dimension::STRESS {
        let message = format!("the column {name} needs its unit");
        return Err(sheet.header_error(at, message).with_help(format!("e.g. {name} (kPa)")).into());
    }
    let factor = if unit.is_empty() { Ok(1.0) } else { parse_quantity(&format!("1 {unit}"), dimension) };
    let factor = factor
        .map_err(|why| Error::from(sheet.header_error(at, format!("the unit of {name}: 1 {unit} {why}"))))?;
    let bare = (unit.is_empty() && name.ends_with("_strain")).then(|| sheet.header_error(at, String::new()));
    Ok(SourceColumn { at, quantity, factor, bare })
}

/// A test from its rows.
fn test(
    file: &Path,
    name: String,
    rows: &[[f64; QUANTITIES.len()]],
    stated: &Conventions,
) -> Result<LaboratoryTest> {
    let logarithmic = stated.logarithmic == Some(true);
    let readings = Readings { rows, signs: stated.signs() };
    let column = |wanted: &str| readings.column(wanted);
    let strain = |wanted: &str| -> Vec<f64> {
        readings
            .signed(wanted)
            .into_iter()
            .map(|x| if logarithmic { 1.0 - libm::exp(-x) } else { x })
            .collect()
    };
    let pore_pressure = if stated.total_stress == Some(true) {
        readings.signed("pore_pressure")
    } else {
        vec![0.0; rows.len()]
    };
    if pore_pressure.is_empty() {
        let message = "stresses are total ones, and there is no column pore_pressure to subtract from them";
        return Err(Error::content(file, message));
    }
    let stress = |wanted: &str| -> Vec<f64> {
        readings.signed(wanted).into_iter().zip(&pore_pressure).map(|(stress, u)| stress - u).collect()
    };
    let measure = stated.deviator.unwrap_or(DeviatorMeasure::Difference).share();
    let (axial, lateral) = (stress("axial_stress"), stress("lateral_stress"));
    let pairs = || axial.iter().zip(&lateral);
    let mut found = LaboratoryTest {
        axial_strain: strain("axial_strain"),
        volumetric_strain: strain("volumetric_strain"),
        deviator_stress: readings.signed("deviator_stress").into_iter().map(|q| q / measure).collect(),
        mean_stress: stress("mean_stress"),
        void_ratio: column("void_ratio"),
        doubts: Vec::new(),
        name,
    };
    if found.deviator_stress.is_empty() {
        found.deviator_stress = pairs().map(|(a, l)| a - l).collect();
    }
    if found.mean_stress.is_empty() {
        found.mean_stress = pairs().map(|(a, l)| (a + 2.0 * l) / 3.0).collect();
    }
    let initial = column("initial_void_ratio");
    if found.void_ratio.is_empty() && initial.len() == found.volumetric_strain.len() {
        let later = |(e, volume): (&f64, &f64)| (1.0 + e) * (1.0 - volume) - 1.0;
        found.void_ratio = initial.iter().zip(&found.volumetric_strain).map(later).collect();
    }
    let of = if found.name.is_empty() { String::new() } else { format!(" of the test {}", found.name) };
    if found.axial_strain.windows(2).any(|pair| pair[1] < pair[0]) {
        let is_negative = readings.signs[0] < 0.0;
        let what = match is_negative {
            true => {
                "with compression = negative; is it positive in this file? (--compression axial_strain=positive)"
            }
            false => {
                "(is compression = negative missing? of this column alone: --compression axial_strain=negative)"
            }
        };
        let message = format!(
            "the axial strain{of} falls from row to row; curves of monotonic tests are compared {what}"
        );
        return Err(Error::content(file, message));
    }
    for (name, values) in [("mean stress", &found.mean_stress), ("deviator stress", &found.deviator_stress)] {
        if values.iter().sum::<f64>() < 0.0 {
            let message = format!(
                "the {name}{of} is negative, which is tension, while the axial strain is positive, which is compression: strains and \
                 stresses must have one sign of compression (--compression negative tells that of the file, --compression \
                 axial_strain=negative that of a column)"
            );
            return Err(Error::content(file, message));
        }
    }
    if found.deviator_stress.is_empty() && found.volumetric_strain.is_empty() && found.void_ratio.is_empty() {
        let what = "has neither stresses (axial_stress with lateral_stress, or deviator_stress) nor volumetric_strain nor void_ratio";
        return Err(Error::content(file, format!("the table{of} {what}")));
    }
    found.doubts = doubts::doubts(&found, &readings, stated);
    Ok(without_bedding(found, stated.bedding_strain.unwrap_or(0.0)))
}

/// A test without the readings at its start while the plate settled; its strains count from there.
fn without_bedding(test: LaboratoryTest, bedding: f64) -> LaboratoryTest {
    let first = test.axial_strain.iter().take_while(|strain| **strain < bedding).count();
    let rest = |values: Vec<f64>| values.into_iter().skip(first).collect();
    LaboratoryTest {
        axial_strain: test.axial_strain.into_iter().skip(first).map(|strain| strain - bedding).collect(),
        volumetric_strain: rest(test.volumetric_strain),
        deviator_stress: rest(test.deviator_stress),
        mean_stress: rest(test.mean_stress),
        void_ratio: rest(test.void_ratio),
        ..test
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn tests(text: &str, conventions: &Conventions) -> Result<Vec<LaboratoryTest>> {
        let open = |sought: &Sought| Sheet::read(text.as_bytes(), "lab.csv", sought);
        with_header(conventions, |sought| read(open(sought)?, conventions))
    }

    #[test]
    fn the_karlsruhe_tests_are_read() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/lab/karlsruhe-fine-sand-drained.csv");
        let found = read_laboratory(path, &Conventions::default()).unwrap();
        assert_eq!(found.len(), 15);
        let loose = &found[0];
        assert_eq!(
            (loose.name.as_str(), loose.axial_strain[1], loose.void_ratio[0]),
            ("TMD1", 0.001, 0.9961)
        );
        assert!(
            found.iter().all(|test| test.doubts.is_empty()),
            "{:?}",
            found.iter().map(|test| &test.doubts).collect::<Vec<_>>()
        );
        assert!((loose.deviator_stress[1] - 15.96e3).abs() < 1e-6);
        assert!((loose.void_ratio[1] - (1.9961 * (1.0 - 0.000586) - 1.0)).abs() < 1e-12);
        // The strength of the sand: 33 to 34 degrees loose, 40 to 43 degrees dense.
        let angle = |test: &LaboratoryTest| {
            let ratio =
                test.deviator_stress.iter().zip(&test.mean_stress).map(|(q, p)| q / p).fold(0.0, f64::max);
            (3.0 * ratio / (6.0 + ratio)).asin().to_degrees()
        };
        let angles: Vec<f64> = found.iter().map(angle).collect();
        assert!(angles[..5].iter().all(|angle| (32.0..35.5).contains(angle)), "{angles:?}");
        assert!(angles[10..].iter().all(|angle| (39.0..44.0).contains(angle)), "{angles:?}");
    }

    #[test]
    fn conventions_stand_in_the_file_or_are_given() {
        let text =
            "# compression = negative\n# strain = logarithmic\neps (%),q (kPa)\n0,0\n-22.31435513,-5\n";
        let columns = [("axial_strain", "eps"), ("deviator_stress", "q")];
        let columns = columns.map(|(a, b)| (a.to_string(), b.to_string())).to_vec();
        let given = Conventions { columns, ..Conventions::default() };
        let found = tests(text, &given).unwrap();
        assert!((found[0].axial_strain[1] - 0.2).abs() < 1e-9 && found[0].deviator_stress[1] == 5e3);
        assert!(found[0].void_ratio.is_empty() && found[0].mean_stress.is_empty());
        let engineering = Conventions { logarithmic: Some(false), ..given };
        assert!((tests(text, &engineering).unwrap()[0].axial_strain[1] - 0.2231435513).abs() < 1e-12);
    }

    #[test]
    fn total_stresses_other_deviators_and_bedding_are_corrected() {
        let text = "# stress = total\n# deviator_stress = half\naxial_strain (%),mean_stress (kPa),deviator_stress (kPa),pore_pressure (kPa)\n\
                    0,300,0,200\n1,310,10,220\n2,320,30,230\n";
        let given = Conventions { bedding_strain: Some(0.005), ..Conventions::default() };
        let found = tests(text, &given).unwrap().remove(0);
        assert_eq!((found.mean_stress, found.deviator_stress), (vec![90e3, 90e3], vec![20e3, 60e3]));
        assert!(found.axial_strain.iter().zip([0.005, 0.015]).all(|(a, b)| (a - b).abs() < 1e-15));
        // What the caller states counts more than a comment.
        let effective = Conventions { total_stress: Some(false), ..Conventions::default() };
        assert_eq!(tests(text, &effective).unwrap()[0].mean_stress[0], 300e3);
        let lacking = text.replace("pore_pressure", "other");
        assert!(tests(&lacking, &given).unwrap_err().to_string().contains("no column pore_pressure"));
    }

    #[test]
    fn strains_in_per_cent_and_tension_are_noticed() {
        let given = Conventions::default();
        let text = "axial_strain,q\n0,0\n1,5\n20,9\n".replace('q', "deviator_stress (kPa)");
        let found = tests(&text, &given).unwrap_err().to_string();
        let parts = [
            "lab.csv:1:1: axial_strain goes to 20 and is understood as a strain of 2000 %",
            "probably axial_strain (%)",
            "--map",
        ];
        assert!(parts.iter().all(|part| found.contains(part)), "{found}");
        for header in ["axial_strain (%)", "axial_strain [%]", "axial_strain_percent"] {
            let found = tests(&text.replace("axial_strain", header), &given).unwrap();
            assert_eq!(found[0].axial_strain, [0.0, 0.01, 0.2], "{header}");
        }
        let columns = vec![("axial_strain".to_string(), "axial_strain (%)".to_string())];
        assert_eq!(tests(&text, &Conventions { columns, ..given.clone() }).unwrap()[0].axial_strain[2], 0.2);
        let text = "axial_strain (%),volumetric_strain\n0,0\n1,-2.5\n";
        assert!(
            tests(text, &given)
                .unwrap_err()
                .to_string()
                .contains("lab.csv:1:18: volumetric_strain goes to -2.5")
        );
        let text = "axial_strain (%),axial_stress (kPa),lateral_stress (kPa)\n0,-100,-100\n1,-200,-100\n";
        let found = tests(text, &given).unwrap_err().to_string();
        assert!(found.contains("the mean stress is negative, which is tension"), "{found}");
        let turned = Conventions { compression_negative: Some(true), ..given };
        let found = tests(text, &turned).unwrap_err().to_string();
        assert!(found.contains("with compression = negative; is it positive in this file?"), "{found}");
    }

    #[test]
    fn mistakes_have_their_place() {
        for (text, parts) in [
            ("axial_strain (%),axial_stress\n0,1\n", &["lab.csv:1:18", "needs its unit", "(kPa)"][..]),
            ("axial_strain (kg),q\n0,1\n", &[":1:1", "is a mass"]),
            ("strain (%),axial_stress (kPa)\n0,1\n", &["no column axial_strain"]),
            ("axial_strain (%),volumetric_strain (%)\n0,x\n", &[":2:3", "is not a number"]),
            ("axial_strain (%),volumetric_strain (%)\n0,1,2\n", &[":2:1", "3 cells"]),
            (
                "axial_strain (%),volumetric_strain (%)\n0,0\n-1,0\n",
                &["falls from row to row", "compression = negative"],
            ),
            ("axial_strain (%)\n0\n1\n", &["neither stresses"]),
            ("# compression = up\naxial_strain\n0\n", &[":1:1", "positive or negative"]),
            ("axial_strain (%)\n", &["has no rows"]),
        ] {
            let found = tests(text, &Conventions::default()).unwrap_err().to_string();
            assert!(parts.iter().all(|part| found.contains(part)), "{text}: {found}");
        }
    }
}
