//! Tests of tables of grains and of contacts.

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
    assert_eq!(assembly.bodies.iter().map(|grain| grain.id).collect::<Vec<_>>(), [2, 3, 7]);
    let across = assembly.contacts[0];
    assert_eq!((across.i, across.j, across.normal_force), (0, 2, 3.0));
    // The nearest image is on the other side of the cell.
    assert!((across.branch[0] + 0.9).abs() < 1e-12 && (across.normal[0] + 1.0).abs() < 1e-12);
    assert!((across.approach - 0.1).abs() < 1e-12);
    assert!((assembly.contacts[1].approach - 0.05).abs() < 1e-12);
    let missing = parts.missing(&Part::ALL);
    for part in [Part::Cell, Part::Positions, Part::Radii, Part::Contacts, Part::Overlaps, Part::NormalForces]
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
    assert_eq!(first.assembly.bodies[0].velocity, [0.1, 0.2, 0.3]);
    assert_eq!((first.assembly.bodies[0].position[0], first.assembly.pieces[0].radius), (1.0, 0.5));
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
    let packing = "# periodic box, m: xlo=0 ylo=0 zlo=0 xhi=1 yhi=1 zhi=1\nid,x,y,z,radius\n1,0,0,0,0.1\n";
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
        contacts("first,second\n2,7.5\n").contains("row 1: the id of a grain = 7.5 is not a whole number")
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
