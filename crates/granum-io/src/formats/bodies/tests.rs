//! Tests of bodies of several spheres in the files of other programs, written and read.

use std::path::PathBuf;

use granum_core::assembly::{Matrix, Quaternion};
use granum_core::geometry::dot;
use granum_core::rotation::{about, matrix, to_body, to_space};
use granum_core::{Part, Parts};

use super::super::{Formats, JoinOptions, ReadOptions};
use super::*;

/// The asymmetric body and the capsule of the notes on shapes, in units of the diameter.
const ASYMMETRIC: [(Vector, f64); 4] =
    [([0.0, 0.0, 0.0], 0.5), ([0.45, 0.1, 0.0], 0.35), ([-0.2, 0.4, 0.1], 0.3), ([0.1, -0.15, 0.5], 0.25)];
const DIMER: [(Vector, f64); 2] = [([-0.25, 0.0, 0.0], 0.5), ([0.25, 0.0, 0.0], 0.5)];
const SHEARED: Matrix = [[10.0, 4.0, 0.0], [0.0, 10.0, 1.0], [0.0, 0.0, 9.0]];

/// Adds a body of density 2 whose spheres are turned.
fn add(assembly: &mut Assembly, id: u64, spheres: &[(Vector, f64)], position: Vector, turn: Quaternion) {
    let union = ShapeOfSpheres::new(spheres).unwrap();
    let axes = matrix(&turn);
    let mass = 2.0 * union.shape.volume;
    let turned: Matrix =
        std::array::from_fn(|r| std::array::from_fn(|c| (0..3).map(|k| axes[r][k] * union.axes[k][c]).sum()));
    let inverse = invert(&assembly.cell);
    let body = assembly.bodies.len();
    for (centre, radius) in spheres {
        let arm = to_space(&axes, &minus(centre, &union.centre));
        let place: Vector = std::array::from_fn(|a| position[a] + arm[a]);
        let back = apply(&assembly.cell, apply(&inverse, place).map(f64::floor));
        assembly.pieces.push(Piece { body, position: minus(&place, &back), radius: *radius, arm });
    }
    let rigid = Some(assembly.rigid.len() as u32);
    assembly.rigid.push(Rigid {
        orientation: of_matrix(&turned),
        inertia: union.shape.inertia_over_mass.map(|moment| mass * moment),
    });
    assembly.bodies.push(Body {
        id,
        position,
        velocity: [0.1, -0.2, 0.3],
        spin: [1.0, 2.0, -0.5],
        equivalent_radius: union.shape.equivalent_radius(),
        mass,
        rigid,
        ..Body::default()
    });
}

/// A sphere, a dimer across a face of a sheared cell and the asymmetric body across its corner, and a contact.
fn mixed() -> ObservedAssembly {
    let mut assembly = Assembly { cell: SHEARED, time: 0.25, step: 40, ..Assembly::default() };
    assembly.push_sphere(Sphere {
        id: 1,
        position: [5.0, 5.0, 5.0],
        radius: 0.4,
        mass: 0.5,
        ..Sphere::default()
    });
    add(&mut assembly, 2, &DIMER, [5.0, 9.9, 5.0], about(&[0.0, 0.0, 1.0], 1.5));
    add(&mut assembly, 3, &ASYMMETRIC, [0.1, 0.05, 0.1], about(&[1.0, 2.0, 3.0], 0.7));
    assembly.contacts.push(Contact {
        i: 0,
        j: 3,
        branch: [0.6, 0.0, 0.2],
        normal: [1.0, 0.0, 0.0],
        normal_force: 3.0,
        ..Contact::default()
    });
    let parts = Parts::new(&[
        Part::Cell,
        Part::Positions,
        Part::Radii,
        Part::Masses,
        Part::Velocities,
        Part::Spins,
        Part::Time,
    ]);
    ObservedAssembly::new(assembly, parts, [-1.0, 2.0, 0.5])
}

fn read_text(name: &str, text: &str, options: &JoinOptions) -> Result<ObservedAssembly> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    read(path, options)
}

fn read(path: PathBuf, options: &JoinOptions) -> Result<ObservedAssembly> {
    Ok(Formats::standard().read_results(&[(path, ReadOptions::default())], options)?.remove(0))
}

/// What `export` writes of an observation in a format of that name.
fn written(name: &str, format: Option<&str>, observed: &ObservedAssembly) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    Formats::standard().write_results(&path, format, std::slice::from_ref(observed)).unwrap();
    (folder, path)
}

/// `R I R^T` of a body.
fn inertia_in_space(rigid: &Rigid) -> Matrix {
    let axes = matrix(&rigid.orientation);
    std::array::from_fn(|r| {
        std::array::from_fn(|c| (0..3).map(|k| axes[r][k] * rigid.inertia[k] * axes[c][k]).sum())
    })
}

fn assert_same_bodies(name: &str, one: &ObservedAssembly, two: &ObservedAssembly, error: f64) {
    let (one, two) = (&one.assembly, &two.assembly);
    let ids = |of: &Assembly| of.bodies.iter().map(|body| body.id).collect::<Vec<_>>();
    assert_eq!(ids(one), ids(two), "{name}");
    assert_eq!((one.pieces.len(), one.rigid.len()), (two.pieces.len(), two.rigid.len()), "{name}");
    let images = Images::new(&two.cell);
    for (a, b) in one.bodies.iter().zip(&two.bodies) {
        assert!((a.mass - b.mass).abs() <= error * b.mass, "{name}: {} {}", a.mass, b.mass);
        assert!((a.equivalent_radius / b.equivalent_radius - 1.0).abs() < error, "{name}");
        // The first body is where the cell has its corner; distances from it are the same.
        let apart = |of: &Assembly, body: &Body| minus(&body.position, &of.bodies[0].position);
        let rest = images.nearest(minus(&apart(one, a), &apart(two, b)));
        assert!(length(&rest) < error, "{name}: {rest:?}");
        let (Some(a), Some(b)) = (a.rigid, b.rigid) else { continue };
        let (a, b) = (inertia_in_space(&one.rigid[a as usize]), inertia_in_space(&two.rigid[b as usize]));
        let gap = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(gap < error, "{name}: {gap}");
    }
    for (a, b) in one.pieces.iter().zip(&two.pieces) {
        assert!(length(&minus(&a.arm, &b.arm)) < error, "{name}: {:?} {:?}", a.arm, b.arm);
    }
}

#[test]
fn bodies_are_written_and_read_again() {
    let observed = mixed();
    for (name, error) in
        [("a.dump", 1e-10), ("a.data", 1e-10), ("a.xyz", 1e-10), ("a.vtp", 1e-10), ("a.gsd", 1e-6)]
    {
        let (_folder, path) = written(name, None, &observed);
        let found = read(path, &JoinOptions::default()).unwrap();
        assert_same_bodies(name, &observed, &found, error);
        // The time stands before the step in a dump.
        let time = (found.assembly.time, found.assembly.step);
        assert!(name != "a.dump" || time == (0.25, 40), "{time:?}");
        let said = &found.remarks[0].text;
        assert!(said.starts_with("6 spheres are parts of 2 bodies"), "{name}: {said}");
        if name != "a.gsd" {
            let (one, two) = (&observed.assembly.bodies[2], &found.assembly.bodies[2]);
            assert!(length(&minus(&one.velocity, &two.velocity)) < 1e-12, "{name}: {:?}", two.velocity);
            assert!(length(&minus(&one.spin, &two.spin)) < 1e-12, "{name}: {:?}", two.spin);
        }
    }
}

/// Contacts name pieces, and stay between the same ones.
#[test]
fn a_contact_of_pieces_is_read_again() {
    let mut observed = mixed();
    observed.parts = observed.parts.with(Part::Contacts).with(Part::NormalForces);
    let beside = observed.assembly.pieces[3].position;
    let beside = [beside[0], beside[1], beside[2] - 0.85];
    (observed.assembly.bodies[0].position, observed.assembly.pieces[0].position) = (beside, beside);
    let pieces = &observed.assembly.pieces;
    let branch = Images::new(&SHEARED).nearest(minus(&pieces[3].position, &pieces[0].position));
    observed.assembly.contacts[0].branch = branch;
    observed.assembly.contacts[0].normal = branch.map(|x| x / length(&branch));
    let (_folder, path) = written("a.vtp", None, &observed);
    let found = read(path, &JoinOptions::default()).unwrap();
    let [contact] = found.assembly.contacts[..] else { panic!("{:?}", found.assembly.contacts) };
    assert_eq!((contact.i, contact.j, contact.normal_force), (0, 3, 3.0));
}

/// Fault A11: a long axis along x that is turned by 90 degrees about z; of 120 degrees about (1, 1, 1) no order could be told.
#[test]
fn every_format_has_its_order_of_quaternions() {
    let mut assembly = Assembly { cell: SHEARED, ..Assembly::default() };
    let quarter = about(&[0.0, 0.0, 1.0], std::f64::consts::FRAC_PI_2);
    add(&mut assembly, 1, &DIMER, [5.0, 5.0, 5.0], quarter);
    // The axes of inertia of the dimer as it is given are its own.
    let q = assembly.rigid[0].orientation;
    assert!(
        (q[0] - 0.5f64.sqrt()).abs() < 1e-15 && (q[3] - q[0]).abs() < 1e-15 && q[1] == 0.0 && q[2] == 0.0
    );
    let along = to_space(&matrix(&q), &[1.0, 0.0, 0.0]);
    assert!((along[1] - 1.0).abs() < 1e-15, "{along:?}");
    let observed =
        ObservedAssembly::new(assembly, Parts::new(&[Part::Cell, Part::Positions, Part::Radii]), [0.0; 3]);
    let [w, x, y, z] = q.map(|component| format!("{component:?}"));
    let text = |name: &str, format: Option<&str>| {
        let (_folder, path) = written(name, format, &observed);
        std::fs::read_to_string(path).unwrap()
    };
    let xyz = text("a.xyz", None);
    assert!(xyz.contains(":molecule:I:1:radius:R:1:orientation:R:4\n"), "{xyz}");
    assert!(xyz.lines().last().unwrap().ends_with(&format!("{x} {y} {z} {w}")), "{xyz}");
    let dump = text("a.dump", None);
    assert!(dump.contains("quatw quati quatj quatk\n"), "{dump}");
    assert!(dump.trim_end().ends_with(&format!("{w} {x} {y} {z}")), "{dump}");
    let vtp = text("a.vtp", Some("vtp-bodies"));
    let array =
        vtp.split("Name=\"orientation\" NumberOfComponents=\"4\" format=\"ascii\">\n").nth(1).unwrap();
    assert!(array.starts_with(&format!("{w} {x} {y} {z}\n")), "{vtp}");
    let (_folder, path) = written("a.gsd", None, &observed);
    let bytes = std::fs::read(path).unwrap();
    let wanted: Vec<u8> =
        [&q, &q].iter().flat_map(|q| q.iter().flat_map(|x| (*x as f32).to_le_bytes())).collect();
    assert!(bytes.windows(wanted.len()).any(|part| part == wanted));
}

/// Fault A1: the tilt 5 of 10 is written as -5; the pieces of a body and its images stay together.
#[test]
fn a_flipped_cell_leaves_the_pieces_of_a_body_together() {
    let cell = [[10.0, 5.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 10.0]];
    let mut assembly = Assembly { cell, ..Assembly::default() };
    add(&mut assembly, 1, &DIMER, [12.0, 9.0, 1.0], about(&[0.0, 0.0, 1.0], 0.8));
    let arms: Vec<Vector> = assembly.pieces.iter().map(|piece| piece.arm).collect();
    let observed = ObservedAssembly::new(
        assembly,
        Parts::new(&[Part::Cell, Part::Positions, Part::Radii, Part::Masses]),
        [0.0; 3],
    );
    let (_folder, path) = written("a.data", None, &observed);
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains("-5.0 0.0 0.0 xy xz yz"), "{text}");
    let rows = text.split("Atoms # sphere\n\n").nth(1).unwrap().lines().take(2);
    for (row, arm) in rows.zip(&arms) {
        let n: Vec<f64> = row.split(' ').map(|word| word.parse().unwrap()).collect();
        let [x, y, z, i, j, k] = n[4..] else { panic!("{row}") };
        let image = [x + 10.0 * i - 5.0 * j, y + 10.0 * j, z + 10.0 * k];
        let centre = minus(&image, arm);
        assert!(length(&minus(&centre, &[12.0, 9.0, 1.0])) < 1e-12, "{row}");
        assert!((0.0..10.0).contains(&y) && (0.0..10.0).contains(&(x + 0.5 * y)), "{row}");
    }
    assert_same_bodies("a.data", &observed, &read(path, &JoinOptions::default()).unwrap(), 1e-12);
}

/// Fault A5: the mean of the two places would be (3, 5), and the nearest image of each axis by itself is wrong as well.
#[test]
fn images_are_not_taken_axis_by_axis_in_a_sheared_cell() {
    let dump = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS xy xz yz pp pp pp\n0 14 4\n0 10 0\n0 10 0\n\
                ITEM: ATOMS id mol x y z radius\n1 7 5 9.9 5 0.5\n2 7 1 0.1 5 0.5\n";
    let found = read_text("a.dump", dump, &JoinOptions::default()).unwrap();
    let assembly = &found.assembly;
    assert_eq!((assembly.bodies.len(), assembly.bodies[0].id), (1, 7));
    let apart = minus(&assembly.pieces[1].arm, &assembly.pieces[0].arm);
    assert!(length(&minus(&apart, &[0.0, 0.2, 0.0])) < 1e-12, "{apart:?}");
    let rest = Images::new(&assembly.cell).nearest(minus(&assembly.bodies[0].position, &[1.0, 0.0, 5.0]));
    assert!(length(&rest) < 1e-12, "{rest:?}");
}

/// Three spheres of a capsule as rows of a data file, of density 1.
const CAPSULE: &str = "capsule\n\n3 atoms\n1 atom types\n\n0 10 xlo xhi\n0 10 ylo yhi\n0 10 zlo zhi\n\nAtoms # sphere\n\n\
                       1 1 1 1 9.6 5 5 0 0 0\n2 1 1 1 0.1 5 5 1 0 0\n3 1 1 1 0.6 5 5 1 0 0\n\nMolecules\n\n3 4\n1 4\n2 4\n";

/// Fault A7: what spheres share counts once in the mass and in the inertia of a file with density times volume of each.
#[test]
fn the_mass_is_that_of_the_union() {
    let found = read_text("a.data", CAPSULE, &JoinOptions::default()).unwrap();
    let (body, rigid) = (&found.assembly.bodies[0], &found.assembly.rigid[0]);
    assert!((body.mass - 1.243547092046).abs() < 1e-11, "{}", body.mass);
    assert!((body.position[0] - 0.1).abs() < 1e-12 && (body.position[1] - 5.0).abs() < 1e-12);
    for (moment, golden) in rigid.inertia.iter().zip([0.108881578947, 0.308717105263, 0.308717105263]) {
        assert!((moment / body.mass - golden).abs() < 1e-10, "{:?}", rigid.inertia);
    }
    let options = JoinOptions::default().with_masses_that_add_up(true);
    let found = read_text("a.data", CAPSULE, &options).unwrap();
    assert!((found.assembly.bodies[0].mass - std::f64::consts::FRAC_PI_2).abs() < 1e-11);
    // Taken apart, the same file has three grains, of which the sum counts twice what they share.
    let apart = read_text("a.data", CAPSULE, &JoinOptions::default().with_separate_spheres(true)).unwrap();
    let sum: f64 = apart.assembly.bodies.iter().map(|body| body.mass).sum();
    assert!((sum - std::f64::consts::FRAC_PI_2).abs() < 1e-11 && apart.remarks[0].doubtful, "{sum}");
    assert!(apart.remarks[0].text.contains("count twice"), "{:?}", apart.remarks);
}

/// Styles of atoms that have a molecule of their own.
#[test]
fn molecules_are_read_from_the_rows_of_atoms_as_well() {
    let head = "x\n\n2 atoms\n0 10 xlo xhi\n0 10 ylo yhi\n0 10 zlo zhi\n\nAtoms # ";
    for rows in [
        "bpm/sphere\n\n1 5 1 1 2 4 5 5\n2 5 1 1 2 4.5 5 5 0 0 0\n",
        "hybrid sphere molecular\n\n1 1 4 5 5 1 2 5\n2 1 4.5 5 5 1 2 5\n",
        "hybrid bond sphere\n\n1 1 4 5 5 5 1 2\n2 1 4.5 5 5 5 1 2\n",
    ] {
        let found = read_text("a.data", &format!("{head}{rows}"), &JoinOptions::default()).unwrap();
        let body = &found.assembly.bodies[0];
        assert_eq!((body.id, found.assembly.pieces.len()), (5, 2), "{rows}");
        assert!((body.mass - 2.0 * 0.8835729338221).abs() < 1e-10, "{rows}");
    }
    let error = read_text("a.data", &format!("{head}hybrid\n\n"), &JoinOptions::default()).unwrap_err();
    assert!(error.to_string().contains("write behind Atoms # the styles"), "{error}");
}

/// A file that counts clumps from 0 and has a sphere alone, of which the ids are those of first spheres.
#[test]
fn clumps_of_yade_are_bodies() {
    let text = "##PERIODIC:: 1 1 1\n0.95 0.5 0.5 0.1 0\n0.05 0.5 0.5 0.1 0\n0.245 0.5 0.5 0.1 -1\n0.5 0.5 0.5 0.1 1\n0.6 0.5 0.5 0.1 1\n";
    let found = read_text("a.txt", text, &JoinOptions::default()).unwrap();
    let assembly = &found.assembly;
    assert_eq!(assembly.bodies.iter().map(|body| body.id).collect::<Vec<_>>(), [0, 2, 3]);
    assert!(
        assembly.bodies[0].position[0].abs() < 1e-12 || (assembly.bodies[0].position[0] - 1.0).abs() < 1e-12
    );
    let touching = found.with_contacts_by_geometry();
    let pairs: Vec<[usize; 2]> = touching.assembly.contacts.iter().map(|c| [c.i, c.j]).collect();
    assert_eq!(pairs, [[1, 2]]);
    // As a sample of a run it is a packing, numbered from 1.
    let packing = touching.numbered_from_one().packing(Path::new("a.txt")).unwrap();
    assert_eq!((packing.grains.len(), packing.bodies.len()), (3, 2));
    assert_eq!((packing.bodies[1].grain, packing.bodies[1].pieces.len()), (2, 2));
}

#[test]
fn force_and_torque_of_a_body_are_those_of_its_spheres() {
    let dump = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n0 10\n0 10\n0 10\n\
                ITEM: ATOMS id mol x y z radius fx fy fz tqx tqy tqz\n1 1 4.75 5 5 0.5 0 1 0 0 0 1\n2 1 5.25 5 5 0.5 0 3 0 0 0 0\n";
    let found = read_text("a.dump", dump, &JoinOptions::default()).unwrap();
    let body = &found.assembly.bodies[0];
    assert_eq!(body.force, [0.0, 4.0, 0.0]);
    assert!((body.torque[2] - (1.0 + 0.25 * 3.0 - 0.25)).abs() < 1e-12, "{:?}", body.torque);
}

#[test]
fn bodies_that_are_none_are_refused_by_name() {
    let dump = |edge: f64, rows: &str| {
        let text = format!(
            "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n0 {edge}\n0 {edge}\n0 {edge}\n\
             ITEM: ATOMS id mol x y z radius\n{rows}"
        );
        read_text("a.dump", &text, &JoinOptions::default()).unwrap_err().to_string()
    };
    let said = dump(10.0, "8 3 1 1 1 0.5\n9 3 4 1 1 0.5\n");
    assert!(
        said.contains("a.dump:10") && said.contains("body 3 (column mol): its spheres do not hang together"),
        "{said}"
    );
    assert!(said.contains("sphere 9 touches none of those that lead to sphere 8"), "{said}");
    let said = dump(2.5, "8 3 1 1 1 0.5\n9 3 1.5 1 1 0.5\n");
    assert!(said.contains("body 3 (column mol): it is 1.5e0 m long") && said.contains("2.5e0 m"), "{said}");
    let said = dump(10.0, "8 3 1 1 1 0.5\n9 3 1 1 1 0.5\n");
    assert!(said.contains("body 3 (column mol): the spheres 0 and 1 are equal"), "{said}");
}

/// A restart file of MercuryDPM has the clump beside its pebbles, all of one kind.
#[test]
fn clumps_of_mercury_are_refused() {
    let text = "MercuryDPM 1.0 name clumps revision 0 repository 0\nParticles 1\nClumpParticle id 0 indSpecies 0 position 0 0 0 radius 1 invMass 1 \
                DzhanibekovParticle 0 VerticallyOriented 0\n";
    let error = read_text("a.restart", text, &JoinOptions::default()).unwrap_err().to_string();
    assert!(
        error.contains("a.restart:3") && error.contains("which pebble belongs to which clump"),
        "{error}"
    );
}

/// Tables of other programs name bodies as well.
#[test]
fn a_table_with_a_column_of_bodies_is_read() {
    let text = "# periodic box, m: xlo=0 ylo=0 zlo=0 xhi=4 yhi=4 zhi=4\nid,x,y,z,radius,mol,mass\n1,1,1,1,0.5,9,1\n2,1.5,1,1,0.5,9,1\n";
    let found = read_text("a.csv", text, &JoinOptions::default()).unwrap();
    assert_eq!((found.assembly.bodies.len(), found.assembly.bodies[0].id), (1, 9));
    assert!((found.assembly.bodies[0].position[0] - 1.25).abs() < 1e-12);
    // Without more than a packing has, it is a packing.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.csv");
    std::fs::write(&path, text.replace(",mass", "").replace("9,1", "9")).unwrap();
    let packing = crate::read_packing(&path).unwrap();
    assert_eq!((packing.grains.len(), packing.bodies.len()), (1, 1));
    assert!((packing.grains[0].position[0] - 1.25).abs() < 1e-12);
    assert!(packing.remarks[0].text.contains("2 spheres are parts of 1 body (column mol)"));
}

/// Without radii nothing can be put together; it is said, and a packing is refused.
#[test]
fn molecules_without_radii_stay_apart() {
    let text = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n0 9\n0 9\n0 9\nITEM: ATOMS id mol x y z\n\
                1 1 1 1 1\n2 1 2 1 1\n";
    let found = read_text("a.dump", text, &JoinOptions::default()).unwrap();
    assert_eq!(found.assembly.bodies.len(), 2);
    assert!(found.remarks[0].text.contains("cannot be put together without radii"), "{:?}", found.remarks);
    let error = found.packing(Path::new("a.dump")).unwrap_err().to_string();
    assert!(error.contains("has no radii"), "{error}");
}

fn packed(observed: &ObservedAssembly) -> crate::Packing {
    observed.packing(Path::new("p")).unwrap()
}

/// A packing keeps every bit of its bodies, also in a sheared cell across whose faces they lie, and their materials.
#[test]
fn a_packing_of_bodies_reads_back_bit_for_bit() {
    let mut observed = mixed();
    observed.assembly.materials = vec!["sand".into(), "glass".into()];
    observed.assembly.bodies[1].material = 1;
    let packing = packed(&observed);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.csv");
    crate::write_packing(&path, &packing).unwrap();
    let again = crate::read_packing(&path).unwrap();
    assert_eq!(again.bodies, packing.bodies);
    assert_eq!(again.grains, packing.grains);
    assert_eq!(
        (0..3).map(|k| again.materials.name(k).unwrap()).collect::<Vec<_>>(),
        ["sand", "glass", "sand"]
    );
    // As results it is the same packing, and what another program reads of it are spheres in the cell.
    let read = read(path.clone(), &JoinOptions::default()).unwrap();
    assert_eq!(read.assembly.rigid[1].orientation, observed.assembly.rigid[1].orientation);
    assert_same_bodies("p.csv", &ObservedAssembly::of_packing(&packing), &read, 1e-14);
    let text = std::fs::read_to_string(&path).unwrap();
    assert_eq!(text.lines().count(), 2 + 7);
    // Four copies of the cell.
    let many = again.repeated([2, 1, 2]).unwrap();
    assert_eq!((many.grains.len(), many.bodies.len(), many.bodies[7].grain), (12, 8, 11));
    assert!((many.solid_fraction() / again.solid_fraction() - 1.0).abs() < 1e-14);
}

#[test]
fn rows_of_a_packing_that_disagree_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.csv");
    crate::write_packing(&path, &packed(&mixed())).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let rows: Vec<Vec<String>> =
        text.lines().skip(1).map(|line| line.split(',').map(String::from).collect()).collect();
    let place = |name: &str| rows[0].iter().position(|known| known == name).unwrap();
    let changed = |row: usize, name: &str, value: &str| {
        let mut rows = rows.clone();
        rows[row][place(name)] = value.into();
        let lines: Vec<String> = rows.iter().map(|row| row.join(",")).collect();
        let head = text.lines().next().unwrap();
        crate::formats::packing_csv::read_from(format!("{head}\n{}\n", lines.join("\n")).as_bytes(), "p.csv")
            .map(|_| ())
            .map_err(|error| error.to_string())
    };
    assert_eq!(changed(2, "id", "2"), Ok(()));
    let said = changed(3, "orientation_w", "0.5").unwrap_err();
    assert!(said.contains("p.csv:5") && said.contains("body 2: orientation_w is 0.5 here"), "{said}");
    let said = changed(3, "x", "3.25").unwrap_err();
    assert!(said.contains("its place is not at the end of its arm from the centre of body 2"), "{said}");
    let said = changed(3, "body", "0").unwrap_err();
    assert!(said.contains("body = \"0\" is not a whole number from 1"), "{said}");
    let said = changed(3, "body", "4").unwrap_err();
    assert!(said.contains("is") && !said.is_empty(), "{said}");
}

/// Pieces of one grain overlap as they please; those of two grains do not.
#[test]
fn a_packing_of_bodies_that_overlap_is_refused() {
    let mut observed = mixed();
    add(&mut observed.assembly, 4, &DIMER, [5.1, 5.0, 5.0], about(&[0.0, 0.0, 1.0], 0.0));
    let error = observed.packing(Path::new("p")).unwrap_err().to_string();
    assert!(error.contains("overlaps grain 1") || error.contains("overlaps grain 4"), "{error}");
}

/// What a body turns by is what its inertia turns by: the axes of the union belong to the pieces.
#[test]
fn the_axes_of_a_body_are_right_handed_and_those_of_its_pieces() {
    let (_folder, path) = written("a.xyz", None, &mixed());
    let found = read(path, &JoinOptions::default()).unwrap();
    let assembly = &found.assembly;
    let axes = matrix(&assembly.rigid[1].orientation);
    assert!((granum_core::geometry::determinant(&axes) - 1.0).abs() < 1e-12);
    let union = ShapeOfSpheres::new(&ASYMMETRIC).unwrap();
    // Distances between pieces and moments do not depend on the signs of the axes.
    let of_found: Vec<Vector> = assembly.pieces[3..].iter().map(|piece| to_body(&axes, &piece.arm)).collect();
    for (one, two) in of_found.iter().zip(&union.shape.pieces) {
        for k in 0..3 {
            assert!((one[k].abs() - two.centre[k].abs()).abs() < 1e-10, "{one:?} {:?}", two.centre);
        }
    }
    assert!(
        (dot(&of_found[0], &of_found[3]) - dot(&union.shape.pieces[0].centre, &union.shape.pieces[3].centre))
            .abs()
            < 1e-10
    );
}
