//! Tables of grains or of contacts, as CSV or Parquet, with the columns of a snapshot or the usual names of other programs; capitals do
//! not matter, and other columns are passed over.
//!
//! | quantity | columns |
//! |---|---|
//! | grains | `id`; `position_x`, `pos_x` or `x`; `radius` or `r`, `diameter` or `d`; `mass`; `velocity_x`, `vx` or `v_x`; `spin_x`, `omegax`, `omega_x` or `wx`; `force_x`, `fx` or `f_x`; `torque_x` |
//! | contacts | `first` and `second`, `id1` and `id2`, or `i` and `j`; `branch_x`; `normal_x` or `nx`; `normal_force` or `fn`; `tangential_force_x`, `ftx` or `ft_x`; `force_x`, `fx` or `f_x`, the whole force on the first grain; `approach` or `overlap`; `normal_energy` with `tangential_energy`; `sliding`; pairs whose `touching` is 0 are passed over |
//! | instants | `step` or `timestep`, `time`: rows that follow each other with the same values are one instant |
//!
//! Only the positions are required, and for contacts the two ids. Without ids grains are numbered from 1. A CSV may give the cell as a
//! [packing](super::packing_csv) does.

use std::ops::Range;
use std::path::Path;

use granum_core::assembly::{Grain, Vector};
use granum_core::{Part, Table};

use super::beginning::{extension, head};
use super::column_names;
use super::packing_csv::{self, PackingCsv};
use super::result::{FileContact, Frame, FrameCell, ReadOptions, ResultFormat};
use super::{PackingFormat, csv, parquet};
use crate::error::{Error, Result};

/// The format.
pub struct GrainTable;

/// Extension and first bytes of Parquet files; a CSV is recognised by its columns.
const PARQUET: &str = "parquet";
const MAGIC: &[u8] = b"PAR1";

impl ResultFormat for GrainTable {
    fn name(&self) -> &'static str {
        "table of grains or contacts"
    }
    fn extensions(&self) -> &'static [&'static str] {
        &[PARQUET]
    }
    fn recognises(&self, head: &[u8]) -> bool {
        if head.starts_with(MAGIC) {
            return true;
        }
        let text = String::from_utf8_lossy(head);
        let mut lines = text.lines().map(|line| line.trim().trim_start_matches('\u{feff}'));
        let Some(line) = lines.find(|line| !line.is_empty() && !line.starts_with('#')) else { return false };
        let names = Names::new(line.split(',').map(|name| name.trim().trim_matches('"')));
        // A packing that has nothing but places and radii is read as one.
        names.are_of_contacts()
            || (names.are_of_grains() && (names.say_more() || !PackingCsv.recognises(head)))
    }
    fn names_columns(&self) -> bool {
        true
    }
    fn read(&self, path: &Path, options: &ReadOptions) -> Result<Vec<Frame>> {
        if let Some(given) = &options.columns {
            let given: Vec<String> = given.iter().map(|name| name.to_ascii_lowercase()).collect();
            let (known, vectors) = known_names();
            column_names::check(path, &given, &known, &vectors)?;
        }
        let source = Source::open(path, options)?;
        let contacts = source.names.are_of_contacts();
        if !contacts && !source.names.are_of_grains() {
            let message = "is a table neither of grains, with position_x, position_y and position_z or x, y and z, nor of contacts, with \
                           first and second";
            return Err(Error::content(path, message));
        }
        let steps = source.scalar(STEP);
        let times = source.scalar(TIME);
        let instants = instants(source.rows(), [steps, times]);
        let frame = |rows: Range<usize>| {
            let mut frame = Frame { cell: source.cell, ..Frame::default() };
            let first = rows.start;
            frame.step = steps.map(|steps| source.whole("step", first, steps[first])).transpose()?;
            frame.time = times.map(|times| times[first]);
            if contacts {
                frame.contacts = Some(source.contacts(rows)?);
            } else {
                source.grains(rows, &mut frame)?;
            }
            Ok(frame)
        };
        instants.into_iter().map(frame).collect()
    }
}

/// The names of a number, the usual one first.
type Scalar = &'static [&'static str];
/// The names of a vector, in which the axis replaces `?`.
type Triple = &'static [&'static str];

const STEP: Scalar = &["step", "timestep"];
const TIME: Scalar = &["time"];
const ID: Scalar = &["id"];
const POSITION: Triple = &["position_?", "pos_?", "?"];
const RADIUS: Scalar = &["radius", "r"];
const DIAMETER: Scalar = &["diameter", "d"];
const MASS: Scalar = &["mass"];
const VELOCITY: Triple = &["velocity_?", "v?", "v_?"];
const SPIN: Triple = &["spin_?", "omega?", "omega_?", "w?"];
const FORCE: Triple = &["force_?", "f?", "f_?"];
const TORQUE: Triple = &["torque_?"];
/// Ids of the two grains of a contact; each pair of names goes together.
const PAIRS: [[&str; 2]; 3] = [["first", "second"], ["id1", "id2"], ["i", "j"]];
const BRANCH: Triple = &["branch_?"];
const NORMAL: Triple = &["normal_?", "n?"];
const NORMAL_FORCE: Scalar = &["normal_force", "fn"];
const TANGENTIAL_FORCE: Triple = &["tangential_force_?", "ft?", "ft_?"];
const APPROACH: Scalar = &["approach", "overlap"];
const NORMAL_ENERGY: Scalar = &["normal_energy"];
const TANGENTIAL_ENERGY: Scalar = &["tangential_energy"];
const SLIDING: Scalar = &["sliding"];
const TOUCHING: Scalar = &["touching"];

/// All of the scalars and vectors above.
const SCALARS: [Scalar; 12] = [
    STEP,
    TIME,
    ID,
    RADIUS,
    DIAMETER,
    MASS,
    NORMAL_FORCE,
    APPROACH,
    NORMAL_ENERGY,
    TANGENTIAL_ENERGY,
    SLIDING,
    TOUCHING,
];
const TRIPLES: [Triple; 8] = [POSITION, VELOCITY, SPIN, FORCE, TORQUE, BRANCH, NORMAL, TANGENTIAL_FORCE];

/// All names, and those of vectors.
fn known_names() -> (Vec<String>, Vec<[String; 3]>) {
    let vector = |name: &&str| ["x", "y", "z"].map(|axis| name.replace('?', axis));
    let vectors: Vec<[String; 3]> = TRIPLES.iter().flat_map(|names| names.iter().map(vector)).collect();
    let mut known: Vec<String> =
        SCALARS.iter().flat_map(|names| names.iter().map(|name| name.to_string())).collect();
    known.extend(PAIRS.iter().flatten().map(|name| name.to_string()));
    known.extend(vectors.iter().flatten().cloned());
    (known, vectors)
}

/// The names of the columns of a table, without capitals.
struct Names(Vec<String>);

impl Names {
    fn new<'a>(names: impl Iterator<Item = &'a str>) -> Names {
        Names(names.map(str::to_ascii_lowercase).collect())
    }

    fn place(&self, name: &str) -> Option<usize> {
        self.0.iter().position(|known| known == name)
    }

    fn scalar(&self, names: Scalar) -> Option<usize> {
        names.iter().find_map(|name| self.place(name))
    }

    /// The three columns of a vector, if all are there.
    fn triple(&self, names: Triple) -> Option<[usize; 3]> {
        names.iter().find_map(|name| {
            let [x, y, z] = ["x", "y", "z"].map(|axis| self.place(&name.replace('?', axis)));
            Some([x?, y?, z?])
        })
    }

    fn pair(&self) -> Option<[usize; 2]> {
        PAIRS.iter().find_map(|[first, second]| Some([self.place(first)?, self.place(second)?]))
    }

    fn are_of_grains(&self) -> bool {
        self.triple(POSITION).is_some()
    }

    fn are_of_contacts(&self) -> bool {
        self.pair().is_some()
    }

    /// True for more than a packing holds.
    fn say_more(&self) -> bool {
        [VELOCITY, SPIN, FORCE].iter().any(|names| self.triple(names).is_some())
            || [STEP, TIME, MASS].iter().any(|names| self.scalar(names).is_some())
    }
}

/// The numbers of a file.
struct Source<'a> {
    path: &'a Path,
    names: Names,
    /// Each column by its place among the names; none for a column that is not needed.
    columns: Vec<Option<usize>>,
    table: Table,
    cell: Option<FrameCell>,
}

impl<'a> Source<'a> {
    fn open(path: &'a Path, options: &ReadOptions) -> Result<Source<'a>> {
        if head(path)?.starts_with(MAGIC) || extension(path) == PARQUET {
            let table = parquet::read(path, None)?;
            let names = table.names().map(str::to_string).collect();
            return Source::from_columns(path, options, names, None, |_| Ok(table));
        }
        let (cell, names) = packing_csv::cell_and_names(path)?;
        Source::from_columns(path, options, names, cell, |wanted| csv::read(path, Some(wanted)))
    }

    /// Names the columns as the options say, and reads those that are needed.
    fn from_columns(
        path: &'a Path,
        options: &ReadOptions,
        own: Vec<String>,
        cell: Option<FrameCell>,
        read: impl FnOnce(&[&str]) -> Result<Table>,
    ) -> Result<Source<'a>> {
        let given = options.columns.as_ref().unwrap_or(&own);
        if given.len() != own.len() {
            let message = format!("has {} columns; {} names are given for them", own.len(), given.len());
            return Err(Error::content(path, message));
        }
        let names = Names::new(given.iter().map(String::as_str));
        let needed = needed(&names);
        let wanted: Vec<&str> = needed.iter().map(|at| own[*at].as_str()).collect();
        let table = read(&wanted)?;
        let place = |at: usize| table.names().position(|name| name == own[at]);
        let columns = (0..own.len()).map(|at| needed.contains(&at).then(|| place(at)).flatten()).collect();
        Ok(Source { path, names, columns, table, cell })
    }

    fn rows(&self) -> usize {
        self.table.rows()
    }

    fn column(&self, at: usize) -> Option<&[f64]> {
        Some(&self.table.columns()[self.columns[at]?].values)
    }

    fn scalar(&self, names: Scalar) -> Option<&[f64]> {
        self.column(self.names.scalar(names)?)
    }

    fn triple(&self, names: Triple) -> Option<[&[f64]; 3]> {
        let [x, y, z] = self.names.triple(names)?.map(|at| self.column(at));
        Some([x?, y?, z?])
    }

    fn error(&self, row: usize, message: &str) -> Error {
        Error::content(self.path, format!("row {}: {message}", row + 1))
    }

    fn whole(&self, what: &str, row: usize, value: f64) -> Result<u64> {
        if value >= 0.0 && value.fract() == 0.0 && value < 9e15 {
            return Ok(value as u64);
        }
        Err(self.error(row, &format!("{what} = {value} is not a whole number")))
    }

    /// Refuses what is no number; granum's own tables have none.
    fn check(&self, rows: Range<usize>) -> Result<()> {
        for (name, at) in self.names.0.iter().zip(0..) {
            let Some(values) = self.column(at) else { continue };
            if let Some(row) = rows.clone().find(|row| !values[*row].is_finite()) {
                return Err(self.error(row, &format!("{name} = {} is not finite", values[row])));
            }
        }
        Ok(())
    }

    fn grains(&self, rows: Range<usize>, frame: &mut Frame) -> Result<()> {
        self.check(rows.clone())?;
        let ids = self.scalar(ID);
        let radii = self.scalar(RADIUS).map(|values| (values, 1.0));
        let radii = radii.or_else(|| self.scalar(DIAMETER).map(|values| (values, 0.5)));
        let masses = self.scalar(MASS);
        let vectors = [POSITION, VELOCITY, SPIN, FORCE, TORQUE].map(|names| self.triple(names));
        for row in rows.clone() {
            let at = |k: usize| vectors[k].map_or([0.0; 3], |columns| vector(columns, row));
            let number = (row - rows.start) as u64 + 1;
            let radius = radii.map_or(0.0, |(values, factor)| factor * values[row]);
            if radii.is_some() && radius <= 0.0 {
                return Err(self.error(row, &format!("radius = {radius} must be positive")));
            }
            frame.grains.push(Grain {
                id: ids.map_or(Ok(number), |ids| self.whole("id", row, ids[row]))?,
                position: at(0),
                velocity: at(1),
                spin: at(2),
                force: at(3),
                torque: at(4),
                radius,
                mass: masses.map_or(0.0, |masses| masses[row]),
                ..Grain::default()
            });
        }
        let known = [
            (Part::Positions, true),
            (Part::Radii, radii.is_some()),
            (Part::Masses, masses.is_some()),
            (Part::Velocities, vectors[1].is_some()),
            (Part::Spins, vectors[2].is_some()),
            (Part::ResultantForces, vectors[3].is_some()),
        ];
        for (part, _) in known.iter().filter(|(_, known)| *known) {
            frame.knows(&[*part]);
        }
        Ok(())
    }

    fn contacts(&self, rows: Range<usize>) -> Result<Vec<FileContact>> {
        self.check(rows.clone())?;
        let Some([Some(first), Some(second)]) = self.names.pair().map(|pair| pair.map(|at| self.column(at)))
        else {
            return Err(Error::content(self.path, "the ids of the grains of its contacts are not numbers"));
        };
        let scalars = [NORMAL_FORCE, APPROACH, NORMAL_ENERGY, TANGENTIAL_ENERGY, SLIDING, TOUCHING];
        let [normal_force, approach, normal_energy, tangential_energy, sliding, touching] =
            scalars.map(|names| self.scalar(names));
        let vectors = [BRANCH, NORMAL, TANGENTIAL_FORCE, FORCE].map(|names| self.triple(names));
        let mut pairs = Vec::with_capacity(rows.len());
        for row in rows {
            if touching.is_some_and(|touching| touching[row] == 0.0) {
                continue;
            }
            let scalar = |values: Option<&[f64]>| values.map(|values| values[row]);
            let [branch, normal, tangential_force, force] =
                vectors.map(|columns| columns.map(|columns| vector(columns, row)));
            pairs.push(FileContact {
                first: self.whole("the id of a grain", row, first[row])?,
                second: self.whole("the id of a grain", row, second[row])?,
                branch,
                normal,
                force,
                normal_force: scalar(normal_force),
                tangential_force,
                approach: scalar(approach),
                energies: scalar(normal_energy).zip(scalar(tangential_energy)).map(|(n, t)| [n, t]),
                sliding: scalar(sliding).map(|sliding| sliding != 0.0),
            });
        }
        Ok(pairs)
    }
}

fn vector(columns: [&[f64]; 3], row: usize) -> Vector {
    columns.map(|values| values[row])
}

/// Places of all columns that are read.
fn needed(names: &Names) -> Vec<usize> {
    let mut places: Vec<usize> = SCALARS.iter().filter_map(|known| names.scalar(known)).collect();
    places.extend(TRIPLES.iter().filter_map(|known| names.triple(known)).flatten());
    places.extend(names.pair().into_iter().flatten());
    places.sort_unstable();
    places.dedup();
    places
}

/// Ranges of rows in which steps and times do not change.
fn instants(rows: usize, marks: [Option<&[f64]>; 2]) -> Vec<Range<usize>> {
    let changes =
        |row: &usize| marks.iter().flatten().any(|mark| mark[*row].to_bits() != mark[*row - 1].to_bits());
    let mut starts = vec![0];
    starts.extend((1..rows).filter(changes));
    let ends = starts.iter().skip(1).copied().chain([rows]).collect::<Vec<usize>>();
    starts.into_iter().zip(ends).map(|(start, end)| start..end).filter(|range| !range.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Formats, JoinOptions, ObservedAssembly};
    use super::*;
    use granum_core::Column;
    use proptest::prelude::*;
    use std::fs;

    const GRAINS: &str =
        "position_z,id,position_x,position_y,radius\n1,7,3.6,1,0.5\n1,2,0.5,1,0.5\n1,3,1.45,1,0.5\n";

    /// Reads files of these names and texts as a user gives them, in a cell of edge 4 if they have none.
    fn read(files: &[(&str, &str)]) -> Result<Vec<ObservedAssembly>> {
        let folder = tempfile::tempdir().unwrap();
        let given: Vec<_> = files
            .iter()
            .map(|(name, text)| {
                let path = folder.path().join(name);
                fs::write(&path, text).unwrap();
                (path, ReadOptions::default())
            })
            .collect();
        let cell = Some(FrameCell::between([0.0; 3], [4.0; 3]));
        Formats::standard().read_results(&given, &JoinOptions::new(cell, None, None))
    }

    #[test]
    fn what_is_not_given_follows_from_places_and_radii() {
        let contacts = "first,second,normal_force\n2,7,3\n2,3,5\n";
        let found = read(&[("grains.csv", GRAINS), ("contacts.csv", contacts)]).unwrap();
        let [ObservedAssembly { assembly, parts, .. }] = &found[..] else { panic!("{found:?}") };
        assert_eq!(assembly.grains.iter().map(|grain| grain.id).collect::<Vec<_>>(), [2, 3, 7]);
        let across = assembly.contacts[0];
        assert_eq!((across.i, across.j, across.normal_force), (0, 2, 3.0));
        // The nearest image is on the other side of the cell.
        assert!((across.branch[0] + 0.9).abs() < 1e-12 && (across.normal[0] + 1.0).abs() < 1e-12);
        assert!((across.approach - 0.1).abs() < 1e-12);
        assert!((assembly.contacts[1].approach - 0.05).abs() < 1e-12);
        let missing = parts.missing(&Part::ALL);
        for part in
            [Part::Cell, Part::Positions, Part::Radii, Part::Contacts, Part::Overlaps, Part::NormalForces]
        {
            assert!(parts.has(part), "{}", part.name());
        }
        for part in [Part::TangentialForces, Part::Velocities, Part::Masses, Part::Strain, Part::Sliding] {
            assert!(missing.contains(&part), "{}", part.name());
        }
    }

    /// The names of another program, the cell of a packing, a column of text, and two instants.
    #[test]
    fn names_of_other_programs_and_several_instants_are_read() {
        let grains = "# periodic box, m: xlo=-1 ylo=0 zlo=0 xhi=3 yhi=4 zhi=4\nStep,Kind,X,Y,Z,Diameter,vx,vy,vz\n\
                      5,sand,0,1,1,1,0.1,0.2,0.3\n5,sand,1,1,1,1,0,0,0\n10,sand,2,1,1,1,0,0,0\n10,sand,1.05,1,1,1,0,0,0\n";
        let contacts = "step,id1,id2,fx,fy,fz,sliding\n5,1,2,-2,0.5,0,1\n10,1,2,3,0,0,0\n";
        let found = read(&[("grains.csv", grains), ("contacts.csv", contacts)]).unwrap();
        assert_eq!(found.len(), 2);
        let first = &found[0];
        assert_eq!((first.assembly.step, first.origin), (5, [-1.0, 0.0, 0.0]));
        assert_eq!(first.assembly.grains[0].velocity, [0.1, 0.2, 0.3]);
        assert_eq!((first.assembly.grains[0].position[0], first.assembly.grains[0].radius), (1.0, 0.5));
        assert!(first.parts.has(Part::Velocities) && first.parts.has(Part::Sliding));
        let contact = first.assembly.contacts[0];
        assert_eq!(
            (contact.normal_force, contact.tangential_force, contact.sliding),
            (2.0, [0.0, 0.5, 0.0], true)
        );
        let contact = found[1].assembly.contacts[0];
        assert_eq!((contact.normal_force, contact.sliding), (3.0, false));
    }

    /// A packing stays one, and grains with velocities but without the line of the cell are a table.
    #[test]
    fn a_packing_is_no_table() {
        let packing =
            "# periodic box, m: xlo=0 ylo=0 zlo=0 xhi=1 yhi=1 zhi=1\nid,x,y,z,radius\n1,0,0,0,0.1\n";
        assert!(!GrainTable.recognises(packing.as_bytes()));
        assert!(GrainTable.recognises(packing.replace("radius", "radius,vx,vy,vz").as_bytes()));
        assert!(GrainTable.recognises(GRAINS.as_bytes()));
        assert!(GrainTable.recognises(b"i,j,fn\n"));
        assert!(!GrainTable.recognises(b"deviator_strain,stress_ratio\n"));
    }

    #[test]
    fn what_granum_writes_is_read_from_parquet_and_is_a_packing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("grains.parquet");
        let column = |name: &str, values: [f64; 2]| Column::new(name, "", values.to_vec());
        let table = Table::new(vec![
            column("id", [4.0, 9.0]),
            column("position_x", [0.5, 1.49]),
            column("position_y", [1.0, 1.0]),
            column("position_z", [1.0, 1.0]),
            column("radius", [0.5, 0.5]),
        ]);
        parquet::write(&path, &table.unwrap()).unwrap();
        let formats = Formats::standard();
        let cell = Some(FrameCell::between([0.0; 3], [4.0; 3]));
        let files = [(path.clone(), ReadOptions::default())];
        let found = formats.read_results(&files, &JoinOptions::new(cell, None, None)).unwrap();
        let packing = found[0].packing(&path).unwrap();
        assert_eq!(packing.grains.iter().map(|grain| grain.id).collect::<Vec<_>>(), [1, 2]);
        // Without a cell it is none.
        let error = formats.read_packing(&path).unwrap_err().to_string();
        assert!(error.contains("cell"), "{error}");
    }

    #[test]
    fn tables_that_are_none_are_refused_with_their_place() {
        let message = |files: &[(&str, &str)]| read(files).unwrap_err().to_string();
        let grains = |text: &str| message(&[("grains.csv", text)]);
        let contacts = |text: &str| message(&[("grains.csv", GRAINS), ("contacts.csv", text)]);
        assert!(grains(&GRAINS.replace("1,3,", "1,2,")).contains("grain 2 is already given"));
        assert!(contacts("first,second\n2,9\n").contains("the grain 9, which is not among the grains"));
        assert!(
            contacts("first,second\n2,7.5\n")
                .contains("row 1: the id of a grain = 7.5 is not a whole number")
        );
        assert!(grains(&GRAINS.replace("1,3,", "1,3.5,")).contains("row 3: id = 3.5 is not a whole number"));
        assert!(
            grains(&GRAINS.replace("1,0.5\n1,3", "1,-0.5\n1,3"))
                .contains("row 2: radius = -0.5 must be positive")
        );
        assert!(grains(&GRAINS.replace("1.45", "nan")).contains("row 3: position_x = NaN is not finite"));
        assert!(grains(&GRAINS.replace("1.45", "left")).contains("grains.csv:4"), "the line and the column");
        let error = message(&[("table.parquet", "PAR1")]);
        assert!(error.contains("table.parquet"), "{error}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]
        /// Tables of any columns and cells are read or refused.
        #[test]
        fn no_table_makes_the_reader_panic(
            names in prop::sample::subsequence(vec!["id", "x", "y", "z", "r", "vx", "vy", "vz", "step", "i", "j", "fn", "sliding"], 1..13),
            cells in prop::collection::vec("[0-3]|-1|1e3|nan|x|", 0..40),
        ) {
            let rows: Vec<String> = cells.chunks(names.len()).map(|row| row.join(",")).collect();
            let text = format!("{}\n{}\n", names.join(","), rows.join("\n"));
            let _ = read(&[("one.csv", &text)]);
            let _ = read(&[("grains.csv", GRAINS), ("other.csv", &text)]);
        }
    }
}
