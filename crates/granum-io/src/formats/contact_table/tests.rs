use granum_core::assembly::{Assembly, Sphere, Vector};
use granum_core::{Part, Parts};

use super::*;
use crate::formats::join::{JoinOptions, join};
use crate::formats::result::{Frame, FrameCell};

/// Four grains of radius 0.5 in a row along x, in a cell of edge 8: 1 and 2 and 3 overlap by 0.1, and 4 is apart by 0.4.
const PLACES: [Vector; 4] = [[1.0, 1.0, 1.0], [1.9, 1.0, 1.0], [2.8, 1.0, 1.0], [4.2, 1.0, 1.0]];

fn grains() -> Frame {
    let mut frame = Frame { cell: Some(FrameCell::between([0.0; 3], [8.0; 3])), ..Frame::default() };
    frame.grains = (1..)
        .zip(PLACES)
        .map(|(id, position)| Sphere { id, position, radius: 0.5, ..Sphere::default() })
        .collect();
    frame.knows(&[Part::Positions, Part::Radii]);
    frame
}

/// A pair with a force along x on the first grain, or with none known.
fn pair(first: u64, second: u64, force: impl Into<Option<f64>>) -> FileContact {
    let force = force.into().map(|x: f64| [x, 0.0, 0.0]);
    FileContact { first, second, force, ..FileContact::default() }
}

type Read = Result<(Assembly, Parts, Vec<Remark>), String>;

fn read_with(grains: Frame, pairs: Vec<FileContact>, options: ContactOptions) -> Read {
    let contacts = Frame { contacts: Some(pairs), ..Frame::default() };
    let files = vec![("grains".into(), vec![grains]), ("pairs".into(), vec![contacts])];
    let found = join(files, &JoinOptions::default().with_contacts(options)).map_err(|e| e.to_string())?;
    let one = found.into_iter().next().unwrap();
    Ok((one.assembly, one.parts, one.remarks))
}

fn read(pairs: Vec<FileContact>, options: ContactOptions) -> Read {
    read_with(grains(), pairs, options)
}

fn answer(option: &str, name: &str) -> ContactOptions {
    let of = |wanted: &str| (wanted == option).then_some(name);
    ContactOptions::default()
        .with_names(of("pairs-apart"), of("missing-pairs"), of("contact-forces"), of("repeated-pairs"))
        .unwrap()
}

fn forces(assembly: &Assembly) -> Vec<f64> {
    assembly.contacts.iter().map(|contact| contact.normal_force).collect()
}

#[test]
fn a_table_that_agrees_with_its_grains_needs_no_word() {
    let (assembly, _, remarks) =
        read(vec![pair(1, 2, -3.0), pair(2, 3, -4.0)], ContactOptions::default()).unwrap();
    assert_eq!((forces(&assembly), remarks), (vec![3.0, 4.0], vec![]));
}

#[test]
fn pairs_apart_without_a_force_are_left_out_and_with_one_are_kept_and_named() {
    let rows = || vec![pair(1, 2, -3.0), pair(2, 3, -4.0)];
    let with = |force: f64| [rows(), vec![pair(3, 4, force)]].concat();
    let (assembly, _, remarks) = read(with(0.0), ContactOptions::default()).unwrap();
    assert_eq!(assembly.contacts.len(), 2);
    assert!(!remarks[0].doubtful && remarks[0].text.starts_with("1 pair of 3 of the table does not touch"));
    let (assembly, _, remarks) = read(with(0.5), ContactOptions::default()).unwrap();
    assert_eq!(forces(&assembly), [3.0, 4.0, -0.5]);
    assert!(remarks[0].doubtful, "{remarks:?}");
    assert!(remarks[0].text.contains("a force across a gap, at most 0.4 m between the grains 3 and 4"));
}

#[test]
fn pairs_apart_without_forces_are_decided_by_their_owner() {
    let rows = || vec![pair(1, 2, None), pair(2, 3, None), pair(3, 4, None)];
    let refused = read(rows(), ContactOptions::default()).unwrap_err();
    assert!(refused.contains("pairs: 1 pair of 3 does not touch, by up to 0.4 m"), "{refused}");
    assert!(refused.contains("`--pairs-apart no-contacts`"), "{refused}");
    let count = |name: &str| read(rows(), answer("pairs-apart", name)).unwrap().0.contacts.len();
    assert_eq!([count("contacts"), count("no-contacts")], [3, 2]);
}

#[test]
fn a_pair_counts_once_in_whatever_direction_it_is_repeated() {
    let rows = vec![pair(1, 2, -3.0), pair(2, 3, -4.0), pair(2, 1, 3.0), pair(2, 3, -4.0)];
    let (assembly, _, remarks) = read(rows, ContactOptions::default()).unwrap();
    assert_eq!(forces(&assembly), [3.0, 4.0]);
    assert!(
        remarks[0].text.contains("2 rows repeat a pair that stands in the table before, in both directions")
    );
    // A second force of the same pair is a part of it, or wrong.
    let rows = || vec![pair(1, 2, -3.0), pair(2, 3, -4.0), pair(1, 2, -1.0)];
    let refused = read(rows(), ContactOptions::default()).unwrap_err();
    assert!(refused.contains("the contact of the grains 1 and 2 stands in the table before"), "{refused}");
    assert!(refused.contains("`--repeated-pairs sum`"), "{refused}");
    let of = |name: &str| forces(&read(rows(), answer("repeated-pairs", name)).unwrap().0);
    assert_eq!((of("first"), of("sum")), (vec![3.0, 4.0], vec![4.0, 4.0]));
}

#[test]
fn forces_that_pull_everywhere_are_decided_by_their_owner() {
    let rows = || vec![pair(1, 2, 3.0), pair(2, 3, 4.0)];
    let refused = read(rows(), ContactOptions::default()).unwrap_err();
    assert!(refused.contains("every pair that overlaps is in tension"), "{refused}");
    let of = |name: &str| forces(&read(rows(), answer("contact-forces", name)).unwrap().0);
    assert_eq!((of("as-given"), of("reversed")), (vec![-3.0, -4.0], vec![3.0, 4.0]));
    // One that pushes is enough to know the sign.
    assert!(read(vec![pair(1, 2, 3.0), pair(2, 3, -4.0)], ContactOptions::default()).is_ok());
}

#[test]
fn pairs_that_are_missing_are_decided_by_their_owner() {
    let rows = || vec![pair(1, 2, -3.0)];
    let refused = read(rows(), ContactOptions::default()).unwrap_err();
    assert!(
        refused.contains("1 pair of grains overlaps that is not in the table, the grains 2 and 3 by 0.1 m"),
        "{refused}"
    );
    let of = |name: &str| forces(&read(rows(), answer("missing-pairs", name)).unwrap().0);
    assert_eq!((of("no-contacts"), of("without-force")), (vec![3.0], vec![3.0, 0.0]));
    // Parts of one body do not touch each other.
    let mut dimer = grains();
    dimer.clump_of = [(2, 5), (3, 5)].into();
    assert!(read_with(dimer, rows(), ContactOptions::default()).is_ok());
}

#[test]
fn branches_and_normals_are_held_against_the_centres() {
    let row = |first, second, x: f64, force: f64| FileContact {
        branch: Some([x, 0.0, 0.0]),
        normal: Some([x.signum(), 0.0, 0.0]),
        ..pair(first, second, force)
    };
    let (assembly, _, remarks) =
        read(vec![row(1, 2, -0.9, -3.0), row(2, 3, -0.9, -4.0)], ContactOptions::default()).unwrap();
    assert_eq!(forces(&assembly), [3.0, 4.0]);
    assert_eq!((remarks.len(), assembly.contacts[0].normal), (2, [1.0, 0.0, 0.0]));
    let refused = read(vec![row(1, 2, 0.7, -3.0), row(2, 3, 0.9, -4.0)], ContactOptions::default());
    assert!(refused.unwrap_err().contains("differs by 2.000e-1 m from the distance of their centres"));
    let aslant = FileContact { normal: Some([0.0, 1.0, 0.0]), ..pair(1, 2, -3.0) };
    let refused = read(vec![aslant, pair(2, 3, -4.0)], ContactOptions::default()).unwrap_err();
    assert!(refused.contains("no direction along the line of their centres"), "{refused}");
}

#[test]
fn contacts_across_a_boundary_need_its_cell() {
    let mut open = grains();
    open.cell = None;
    open.grains[0].position[0] = 0.2;
    open.grains[3].position[0] = 7.4;
    let rows = || vec![pair(1, 4, 3.0), pair(2, 3, -4.0)];
    let refused = read_with(open.clone(), rows(), ContactOptions::default()).unwrap_err();
    assert!(refused.contains("is one of centres that are 7.2 sums of the radii apart"), "{refused}");
    assert!(refused.contains("`--cell \"A, B, C\"`"), "{refused}");
    // A branch of its own says where the image is.
    let branch = FileContact { branch: Some([-0.8, 0.0, 0.0]), ..rows()[0] };
    let (assembly, ..) = read_with(open, vec![branch, rows()[1]], ContactOptions::default()).unwrap();
    assert_eq!(forces(&assembly), [3.0, 4.0]);
}

#[test]
fn ids_from_zero_are_seen_where_the_grains_have_none() {
    let mut bare = grains();
    bare.counts_from_one = true;
    let of = |rows| read_with(bare.clone(), rows, ContactOptions::default()).unwrap();
    let (assembly, _, remarks) = of(vec![pair(0, 1, -3.0), pair(1, 2, -4.0)]);
    assert_eq!((forces(&assembly), assembly.contacts[0].i), (vec![3.0, 4.0], 0));
    assert_eq!(remarks[0].text, "the contacts count the grains from 0");
    let (assembly, _, remarks) = of(vec![pair(1, 2, -3.0), pair(2, 3, -4.0)]);
    assert_eq!((assembly.contacts[0].i, remarks.len()), (0, 0));
}

#[test]
fn answers_that_are_not_possible_are_refused_by_name() {
    let (option, why) = ContactOptions::default().with_names(Some("contact"), None, None, None).unwrap_err();
    assert_eq!(option, "pairs-apart");
    assert!(why.contains("did you mean contacts?"), "{why}");
}

#[test]
fn without_radii_pairs_without_a_force_are_named_and_tension_everywhere_is_asked_for() {
    let mut points = grains();
    points.parts = Parts::new(&[Part::Positions]);
    let of = |rows| read_with(points.clone(), rows, ContactOptions::default());
    let (assembly, _, remarks) = of(vec![pair(1, 2, -3.0), pair(3, 4, 0.0)]).unwrap();
    assert_eq!(assembly.contacts.len(), 2);
    assert!(remarks[0].doubtful && remarks[0].text.starts_with("1 of 2 pairs of the table have no force"));
    assert!(of(vec![pair(1, 2, 3.0)]).unwrap_err().contains("every pair is in tension"));
}
