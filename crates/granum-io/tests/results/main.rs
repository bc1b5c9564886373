//! Files that other programs wrote, and files that granum writes for them.

use std::path::{Path, PathBuf};

use granum_core::assembly::Matrix;
use granum_core::{Cell, MacroState, ObservedState, Part};
use granum_dem::config::{ContactModel, Material};
use granum_dem::simulation::{InitialSphere, Properties, Simulation};
use granum_io::formats::{Formats, FrameCell, JoinOptions, ObservedAssembly, ReadOptions};
use granum_sensors::Sensors;

fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/results").join(name)
}

const COLUMNS: &str = "index,patom1,patom2,fx,fy,fz,p1,p2,p3,p10,p11,p12";

fn with_columns(name: &str, columns: &str) -> (PathBuf, ReadOptions) {
    let columns = columns.split(',').map(String::from).collect();
    (sample(name), ReadOptions::with_columns(Some(columns)))
}

fn plain(name: &str) -> (PathBuf, ReadOptions) {
    (sample(name), ReadOptions::default())
}

fn read(files: &[(PathBuf, ReadOptions)]) -> Vec<ObservedAssembly> {
    Formats::standard().read_results(files, &JoinOptions::default()).unwrap()
}

/// Stress of the contacts, Pa, compression positive.
fn stress(observation: &ObservedAssembly) -> Matrix {
    MacroState::from_assembly(&observation.assembly).stress
}

fn lammps(columns: &str) -> Vec<ObservedAssembly> {
    read(&[plain("lammps/grains.dump"), with_columns("lammps/contacts.dump", columns)])
}

/// LAMMPS's own pressure is recorded beside the dumps, with 16 digits.
#[test]
fn the_stress_of_a_lammps_run_is_its_own_to_rounding() {
    let text = std::fs::read_to_string(sample("lammps/pressure.txt")).unwrap();
    // With the vectors that LAMMPS wrote, and with those that follow from the places of the grains.
    let without: String = COLUMNS.replace("p10,p11,p12", "-,-,-");
    for columns in [COLUMNS, without.as_str()] {
        let found = lammps(columns);
        assert_eq!(found.len(), 3);
        for (observation, line) in found.iter().zip(text.lines()) {
            let numbers: Vec<f64> = line.split_whitespace().map(|word| word.parse().unwrap()).collect();
            assert_eq!(observation.assembly.step as f64, numbers[0]);
            let ours = stress(observation);
            let ours = [ours[0][0], ours[1][1], ours[2][2], ours[1][0], ours[2][0], ours[2][1]];
            for (our, theirs) in ours.iter().zip(&numbers[1..]) {
                let gap = (our - theirs).abs() / numbers[1];
                assert!(gap < 2e-13, "step {}: {our} {theirs}", numbers[0]);
            }
        }
    }
}

#[test]
fn a_series_of_dumps_has_strains_and_the_parts_that_it_has() {
    let found = lammps(COLUMNS);
    let known = [
        Part::Cell,
        Part::Positions,
        Part::Radii,
        Part::Masses,
        Part::Spins,
        Part::NormalForces,
        Part::Strain,
    ];
    assert!(found[2].parts.missing(&known).is_empty());
    assert!(!found[2].parts.has(Part::Time) && !found[2].parts.has(Part::Velocities));
    let first = found[0].assembly.cell;
    let last = found[2].assembly.cell;
    let wanted = -(last[0][0] / first[0][0]).ln();
    assert!(
        (found[2].assembly.strain[0][0] - wanted).abs() < 1e-3 * wanted,
        "{:?}",
        found[2].assembly.strain
    );
    assert!(last[0][1] != 0.0 && last[1][0] == 0.0, "the box is tilted");
    let mass = 2650.0 * 4.0 / 3.0 * std::f64::consts::PI * found[0].assembly.pieces[0].radius.powi(3);
    assert!((found[0].assembly.bodies[0].mass / mass - 1.0).abs() < 1e-12);
    let options = JoinOptions::new(None, None, Some(1e-6));
    let timed = Formats::standard().read_results(&[plain("lammps/grains.dump")], &options).unwrap();
    assert!((timed[1].assembly.time - 0.0195).abs() < 1e-12 && timed[1].parts.has(Part::StrainRate));
}

#[test]
fn contacts_whose_columns_are_not_named_are_refused_with_the_line() {
    let files = [plain("lammps/grains.dump"), plain("lammps/contacts.dump")];
    let error = Formats::standard().read_results(&files, &JoinOptions::default()).unwrap_err().to_string();
    assert!(error.contains("contacts.dump:9:1: the columns index c_ids[1]"), "{error}");
    assert!(error.contains("--columns"), "{error}");
}

/// The data file was written at the end of the same run.
#[test]
fn a_lammps_data_file_is_the_last_state_of_the_dump_and_a_packing() {
    let data = &read(&[plain("lammps/end.data")])[0];
    let dump = &lammps(COLUMNS)[2];
    assert_eq!(data.assembly.bodies.len(), 24);
    for a in 0..3 {
        for b in 0..3 {
            assert!((data.assembly.cell[a][b] - dump.assembly.cell[a][b]).abs() < 1e-15);
        }
    }
    for (one, two) in data.assembly.bodies.iter().zip(&dump.assembly.bodies) {
        assert_eq!(one.id, two.id);
        assert!(
            (one.equivalent_radius / two.equivalent_radius - 1.0).abs() < 1e-12
                && (one.mass / two.mass - 1.0).abs() < 1e-12
        );
        assert!((0..3).all(|a| (one.position[a] - two.position[a]).abs() < 1e-12), "{one:?} {two:?}");
    }
    // These soft spheres overlap by more than a packing of grains may.
    let error = granum_io::read_packing(sample("lammps/end.data")).unwrap_err().to_string();
    assert!(error.contains("overlaps grain") && error.contains("of the smaller diameter"), "{error}");
    // Named are the lines of the file, where the atoms follow the head and stand in an order of their own.
    assert!(error.contains("end.data:17:1: grain 1 overlaps grain 19 (line 31) by"), "{error}");
    let text = std::fs::read_to_string(sample("lammps/end.data")).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[16].starts_with("1 1 ") && lines[30].starts_with("19 1 "), "{} {}", lines[16], lines[30]);
    // The same grains with smaller radii are a packing.
    let mut smaller = data.clone();
    smaller.assembly.bodies.iter_mut().for_each(|grain| grain.equivalent_radius *= 0.9);
    smaller.assembly.pieces.iter_mut().for_each(|piece| piece.radius *= 0.9);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("smaller.data");
    Formats::standard().write_results(&path, None, std::slice::from_ref(&smaller)).unwrap();
    let packing = granum_io::read_packing(&path).unwrap();
    let volume: f64 = smaller.assembly.pieces.iter().map(|piece| piece.radius.powi(3)).sum::<f64>() * 4.0
        / 3.0
        * std::f64::consts::PI;
    assert!((packing.solid_fraction() / (volume / smaller.assembly.volume()) - 1.0).abs() < 1e-12);
}

/// YADE wrote coordinates and forces with six digits; its own stress (`getStress`, tension positive) was printed by the run.
#[test]
fn the_stress_of_a_yade_sample_is_its_own_to_the_digits_of_its_files() {
    let files = ["yade/spheres.vtk", "yade/contacts.vtk", "yade/cell.vtk"].map(plain);
    let found = read(&files);
    assert_eq!((found.len(), found[0].assembly.bodies.len(), found[0].assembly.contacts.len()), (1, 24, 71));
    let theirs = [
        [183650.400, -38346.892, 29264.019],
        [-38346.892, 240830.905, 10244.086],
        [29264.019, 10244.086, 244648.212],
    ];
    let ours = stress(&found[0]);
    for a in 0..3 {
        for b in 0..3 {
            assert!((ours[a][b] - theirs[a][b]).abs() < 3e-5 * 2e5, "{ours:?}");
        }
    }
    assert!(found[0].parts.has(Part::TangentialForces) && found[0].assembly.cell[2][1] != 0.0);
}

#[test]
fn text_of_yade_has_its_cell_or_is_given_one() {
    let saved = &read(&[plain("yade/packing.txt")])[0];
    assert_eq!(saved.assembly.bodies.len(), 24);
    assert!((saved.assembly.cell[0][0] - 2.8e-3).abs() < 1e-15);
    assert_eq!(granum_io::read_packing(sample("yade/packing.txt")).unwrap().grains.len(), 24);
    let bare = &read(&[plain("yade/ext.txt")])[0];
    assert!(!bare.parts.has(Part::Cell) && bare.parts.has(Part::Radii));
    let error = granum_io::read_packing(sample("yade/ext.txt")).unwrap_err().to_string();
    assert!(error.contains("ext.txt: has no cell; `granum export FILE --cell"), "{error}");
    let options = JoinOptions::new(Some(FrameCell::between([0.0; 3], [3e-3; 3])), Some(2650.0), None);
    let given = &Formats::standard().read_results(&[plain("yade/ext.txt")], &options).unwrap()[0];
    assert!(given.parts.has(Part::Cell) && given.parts.has(Part::Masses));
}

fn written(folder: &Path, name: &str, text: &str) -> (PathBuf, ReadOptions) {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    (path, ReadOptions::default())
}

/// Two spheres that touch across a face, in the words of MercuryDPM: the contact stands in the file from both sides.
#[test]
fn mercury_files_give_each_contact_once_with_its_force() {
    let folder = tempfile::tempdir().unwrap();
    let data = "2 0.5 0 0 0 4 4 4 \n0.2 2 2 1 0 0 0.5 0 0 0 0 0 1 0\n3.3 2 2 0 0 0 0.5 0 0 0 0 0 0 0\n";
    let fstat = "# 0.5 1\n# 0 0 0 4 4 4\n# 0.5 0.5 0 0 0 0\n\
                 0.5 0 1 -0.25 2 2 0.1 0.01 7 2 1 0 0 0 1 0\n0.5 1 0 -0.25 2 2 0.1 0.01 7 2 -1 0 0 0 -1 0\n";
    let files = [written(folder.path(), "two.data", data), written(folder.path(), "two.fstat", fstat)];
    let found = &read(&files)[0];
    let [contact] = found.assembly.contacts[..] else { panic!("{:?}", found.assembly.contacts) };
    assert_eq!((contact.i, contact.j, contact.normal), (0, 1, [-1.0, 0.0, 0.0]));
    assert!((contact.branch[0] + 0.9).abs() < 1e-12);
    // A file with the second line of the contact alone says the same.
    let mirrored: Vec<&str> =
        fstat.lines().enumerate().filter(|(k, _)| *k != 3).map(|(_, line)| line).collect();
    let half = written(folder.path(), "half.fstat", &mirrored.join("\n"));
    let again = &read(&[files[0].clone(), half])[0];
    assert_eq!(again.assembly.contacts.len(), 1);
    assert_eq!(again.assembly.contacts[0].force(), [-7.0, -2.0, 0.0]);
    // Pushed along x by 7 N and dragged along y by 2 N.
    assert_eq!(contact.force(), [7.0, 2.0, 0.0]);
    assert_eq!(found.assembly.time, 0.5);
    // An instant before the first particle, and the format of two dimensions.
    let empty = format!("0 0 0 0 0 4 4 4 \n{data}");
    assert_eq!(read(&[written(folder.path(), "empty.data", &empty)]).len(), 1);
    let flat = written(folder.path(), "flat.data", "1 0 0 0 4 4 \n2 2 0 0 0.5 0 0 0\n");
    let error = Formats::standard().read_results(&[flat], &JoinOptions::default()).unwrap_err().to_string();
    assert!(error.contains("flat.data:1:1:") && error.contains("two-dimensional"), "{error}");
    let wall = fstat.replace("0.5 0 1 -0.25", "0.5 0 -1 -0.25");
    let files = [files[0].clone(), written(folder.path(), "wall.fstat", &wall)];
    let error = Formats::standard().read_results(&files, &JoinOptions::default()).unwrap_err().to_string();
    assert!(error.contains("wall.fstat:4:1: the contact is one with a wall"), "{error}");
}

#[test]
fn a_restart_file_of_mercury_has_masses_and_a_cell_where_it_is_periodic() {
    let folder = tempfile::tempdir().unwrap();
    let boundary = |k: usize, normal: &str| {
        format!(
            "PeriodicBoundary id {k} normal {normal} scaleFactor 1 distanceLeft 0 distanceRight 3 shift 3 0 0\n"
        )
    };
    let grain = |id: u64, x: f64| {
        format!(
            "BaseParticle id {id} indSpecies 0 position {x} 1 1 orientation 1 0 0 0 velocity 1 2 3 angularVelocity 0 0 0 \
                 force 0 0 0 torque 0 0 0 radius 0.5 invMass 0.25 timeStamp 0\n"
        )
    };
    let text = format!(
        "MercuryDPM 1.0 name two\nxMin 0 xMax 3 yMin 0 yMax 3 zMin 0 zMax 3\ntimeStep 0.0005 time 50 ntimeSteps 100000 timeMax 50\n\
         Boundaries 3\n{}{}{}Particles 2\n{}{}Interactions 1\nLinearViscoelasticInteraction particleIds 0 1 timeStamp 1 contactPoint \
         1 1 1 force -4 1 0 torque 0 0 0\n",
        boundary(0, "1 0 0"),
        boundary(1, "0 1 0"),
        boundary(2, "0 0 1"),
        grain(0, 1.0),
        grain(1, 1.9)
    );
    let found = &read(&[written(folder.path(), "two.restart", &text)])[0];
    assert_eq!(
        (found.assembly.time, found.assembly.bodies[1].mass, found.assembly.cell[2][2]),
        (50.0, 4.0, 3.0)
    );
    assert_eq!(found.assembly.contacts[0].normal_force, 4.0);
    let open = text.replace(&boundary(1, "0 1 0"), "");
    assert!(!read(&[written(folder.path(), "open.restart", &open)])[0].parts.has(Part::Cell));
    // Not every domain has a height, nor every boundary a normal.
    let flat = open
        .replace("zMax 3", "zMax 0")
        .replace("Boundaries 3\n", "Boundaries 3\nAngledPeriodicBoundary id 3\n");
    assert!(!read(&[written(folder.path(), "flat.restart", &flat)])[0].parts.has(Part::Cell));
}

/// What granum writes it reads: places, radii and cell, to the precision of the format.
#[test]
fn what_is_written_for_other_programs_is_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let series = lammps(COLUMNS);
    for (name, instants) in [("a.data", 1), ("a.dump", 3), ("a.xyz", 3), ("a.gsd", 3)] {
        let path = folder.path().join(name);
        let given = &series[3 - instants..];
        Formats::standard().write_results(&path, None, given).unwrap();
        let again = Formats::standard()
            .read_results(&[(path, ReadOptions::default())], &JoinOptions::default())
            .unwrap();
        assert_eq!(again.len(), instants, "{name}");
        for (before, after) in given.iter().zip(&again) {
            let volume = after.assembly.volume() / before.assembly.volume();
            assert!((volume - 1.0).abs() < 3e-7, "{name}: {volume}");
            for (one, two) in before.assembly.bodies.iter().zip(&after.assembly.bodies) {
                assert!(
                    (one.equivalent_radius - two.equivalent_radius).abs() < 1e-15
                        && (one.mass / two.mass - 1.0).abs() < 1e-6,
                    "{name}"
                );
                // Distances to the first grain, which no shift of the corner changes.
                let apart = |o: &ObservedAssembly, k: usize, a: usize| {
                    o.assembly.bodies[k].position[a] - o.assembly.bodies[0].position[a]
                };
                let k = one.id as usize - 1;
                let whole = before.assembly.cell[0][0];
                let gap: f64 = (0..3).map(|a| (apart(before, k, a) - apart(after, k, a)).abs()).sum();
                // A grain may have come in from the other side.
                assert!(name == "a.gsd" || name == "a.dump" || gap < 1e-12 * whole, "{name}: {gap}");
            }
        }
    }
    // A species that ASE accepts.
    let text = std::fs::read_to_string(folder.path().join("a.xyz")).unwrap();
    assert!(text.lines().nth(2).unwrap().starts_with("X 1 "), "{text}");
    let error = Formats::standard().write_results(&folder.path().join("a.data"), None, &series).unwrap_err();
    assert!(error.to_string().contains("holds one instant, not 3"), "{error}");
    let error =
        Formats::standard().write_results(&folder.path().join("a.restart"), None, &series).unwrap_err();
    assert!(
        error.to_string().contains("its name ends in .restart; it must end in .dump")
            && error.to_string().contains(".csv or .parquet"),
        "{error}"
    );
}

/// The pieces of a line that crosses faces add up to the branch, and each is inside the cell.
#[test]
fn lines_of_contacts_are_cut_at_the_faces() {
    let observation = &lammps(COLUMNS)[2];
    let assembly = &observation.assembly;
    let pieces = granum_io::formats::vtp::contact_lines(assembly);
    assert!(pieces.len() > assembly.contacts.len() + 5, "{}", pieces.len());
    let inverse = granum_core::geometry::invert(&assembly.cell);
    let mut sums = vec![[0.0; 3]; assembly.contacts.len()];
    for piece in &pieces {
        for end in [piece.from, piece.to] {
            let place = granum_core::geometry::apply(&inverse, end);
            assert!(place.iter().all(|x| (-1e-9..=1.0 + 1e-9).contains(x)), "{place:?}");
        }
        (0..3).for_each(|a| sums[piece.contact][a] += piece.to[a] - piece.from[a]);
    }
    for (sum, contact) in sums.iter().zip(&assembly.contacts) {
        assert!((0..3).all(|a| (sum[a] - contact.branch[a]).abs() < 1e-15), "{sum:?} {:?}", contact.branch);
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.vtp");
    Formats::standard().write_results(&path, None, std::slice::from_ref(observation)).unwrap();
    let text = std::fs::read_to_string(path).unwrap();
    let wanted = format!("NumberOfVerts=\"24\" NumberOfLines=\"{}\"", pieces.len());
    assert!(text.contains(&wanted) && text.contains("Name=\"tangential_force\""));
}

#[test]
fn damaged_files_are_refused_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let dump = std::fs::read_to_string(sample("lammps/grains.dump")).unwrap();
    let message = |name: &str, text: &str| {
        let files = [written(folder.path(), name, text)];
        Formats::standard().read_results(&files, &JoinOptions::default()).unwrap_err().to_string()
    };
    let cut: String = dump.lines().take(20).map(|line| format!("{line}\n")).collect();
    assert!(message("cut.dump", &cut).contains("cut.dump:21:1: the file ends where an atom should follow"));
    let more = dump.replacen("\n24\n", "\n23\n", 1);
    assert!(
        message("more.dump", &more)
            .contains("more.dump:33:1: a line that begins with \"ITEM:\" should stand here")
    );
    let bad = dump.replacen("1 1 ", "1 1 nan", 1);
    assert!(message("bad.dump", &bad).contains("bad.dump:10:"), "{}", message("bad.dump", &bad));
    let xyz = "1\nLattice=\"1 0 0 0 1 0 0 0\" Properties=pos:R:3\n0 0 0\n";
    assert!(
        message("a.xyz", xyz).contains("a.xyz:2:1: Lattice=\"1 0 0 0 1 0 0 0\" has 8 numbers; 9 are needed")
    );
    let data = std::fs::read_to_string(sample("lammps/end.data")).unwrap();
    assert!(
        message("bond.data", &data.replace("# sphere", "# full")).contains("atom_style full cannot be read")
    );
    let mut gsd = vec![0xDF, 0x65, 0xDF, 0x65, 0xDF, 0x65, 0xDF, 0x65];
    gsd.resize(256, 0xFF);
    let path = folder.path().join("a.gsd");
    std::fs::write(&path, gsd).unwrap();
    let error = Formats::standard()
        .read_results(&[(path, ReadOptions::default())], &JoinOptions::default())
        .unwrap_err();
    assert!(error.to_string().contains("a.gsd: is no GSD file or is damaged"), "{error}");
}

/// Files without lines name grains alone.
#[test]
fn a_grain_that_is_wrong_is_named_with_the_line_of_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let message = |name: &str, text: &str| {
        let (path, _) = written(folder.path(), name, text);
        granum_io::read_packing(path).unwrap_err().to_string()
    };
    let xyz = "3\nLattice=\"4 0 0 0 4 0 0 0 4\" Properties=id:I:1:pos:R:3:radius:R:1\n9 1 1 1 0.5\n4 3 3 3 0.5\n7 1.5 1 1 0.5\n";
    let found = message("a.xyz", xyz);
    assert!(found.contains("a.xyz:5:1: grain 7 overlaps grain 9 (line 3) by 5.000e-1 m, 50.0 %"), "{found}");
    let found = message("a.xyz", &xyz.replace("9 1 1 1 0.5", "7 1 1 1 0.5"));
    assert!(found.contains("a.xyz:5:1: grain 7 is already given in line 3"), "{found}");
    let found = message("a.xyz", &xyz.replace("4 3 3 3 0.5", "4 3 3 3 2.5"));
    assert!(found.contains("a.xyz:4:1: grain 4: radius = 2.5e0 m does not fit"), "{found}");
    let observation = &read(&[written(folder.path(), "b.xyz", xyz)])[0];
    let path = folder.path().join("a.gsd");
    Formats::standard().write_results(&path, None, std::slice::from_ref(observation)).unwrap();
    let found = granum_io::read_packing(&path).unwrap_err().to_string();
    assert!(found.contains("a.gsd: grain 2 overlaps grain 3 by 5.000e-1 m"), "{found}");
}

/// The stress that a line of a file gives in nine numbers, after some words.
fn printed_stress(name: &str, starts: &str, skipped: usize) -> Matrix {
    let text = std::fs::read_to_string(sample(name)).unwrap();
    let line = text.lines().find(|line| line.starts_with(starts)).unwrap();
    let n: Vec<f64> = line.split_whitespace().skip(skipped).map(|word| word.parse().unwrap()).collect();
    std::array::from_fn(|a| std::array::from_fn(|b| n[3 * a + b]))
}

/// Largest difference of two stresses, relative to the first component.
fn gap(one: &Matrix, two: &Matrix) -> f64 {
    let gaps = (0..9).map(|n| (one[n / 3][n % 3] - two[n / 3][n % 3]).abs());
    gaps.fold(0.0, f64::max) / one[0][0].abs()
}

/// MercuryDPM writes ten digits, in the restart file fifteen; `getStaticStress` was printed by the run.
#[test]
fn the_stress_of_a_mercury_sample_is_its_own_to_the_digits_of_its_files() {
    let theirs = printed_stress("mercury/stress.txt", "STRESS static", 2);
    let found = &read(&[plain("mercury/box.data"), plain("mercury/box.fstat")])[0];
    assert_eq!((found.assembly.bodies.len(), found.assembly.contacts.len()), (27, 62));
    assert!(
        gap(&stress(found), &theirs) < 5e-9,
        "{} {:?} {theirs:?}",
        gap(&stress(found), &theirs),
        stress(found)
    );
    let restart = &read(&[plain("mercury/box.restart")])[0];
    assert_eq!((restart.assembly.bodies.len(), restart.assembly.contacts.len()), (27, 62));
    assert!(
        gap(&stress(restart), &theirs) < 1e-12,
        "{} {:?} {theirs:?}",
        gap(&stress(restart), &theirs),
        stress(restart)
    );
    for (one, two) in found.assembly.bodies.iter().zip(&restart.assembly.bodies) {
        assert!((one.equivalent_radius / two.equivalent_radius - 1.0).abs() < 1e-9, "{one:?} {two:?}");
        let mass = 2650.0 * 4.0 / 3.0 * std::f64::consts::PI * two.equivalent_radius.powi(3);
        assert!((two.mass / mass - 1.0).abs() < 1e-12, "{two:?} {mass}");
        assert!((0..3).all(|a| (one.position[a] - two.position[a]).abs() < 1e-15), "{one:?} {two:?}");
        assert!((0..3).all(|a| (one.spin[a] - two.spin[a]).abs() < 1e-5), "{one:?} {two:?}");
    }
}

/// LIGGGHTS's virial pressure was printed by the run, after a run of no steps and at the end of 500 steps, where it evaluates the
/// dashpots for the table with other velocities than for the pressure.
#[test]
fn the_stress_of_a_liggghts_run_is_its_own() {
    let text = std::fs::read_to_string(sample("liggghts/stress.txt")).unwrap();
    let rows = text.lines().map(|line| line.split_whitespace().map(|word| word.parse().unwrap()).collect());
    let rows: Vec<Vec<f64>> = rows.collect();
    let apart = |observation: &ObservedAssembly, row: &[f64]| {
        let ours = stress(observation);
        let ours = [ours[0][0], ours[1][1], ours[2][2], ours[1][0], ours[2][0], ours[2][1]];
        ours.iter().zip(&row[2..]).map(|(one, two)| (one - two).abs() / row[2]).fold(0.0, f64::max)
    };
    let columns = "id1,id2,-,force_x,force_y,force_z,-";
    let found = read(&[plain("liggghts/grains.dump"), with_columns("liggghts/contacts.dump", columns)]);
    assert_eq!((found.len(), found[1].assembly.bodies.len()), (2, 27));
    assert_eq!(found[1].assembly.step as f64, rows[1][0]);
    assert!(apart(&found[0], &rows[0]) < 1e-14, "{}", apart(&found[0], &rows[0]));
    assert!(apart(&found[1], &rows[1]) < 2e-4, "{}", apart(&found[1], &rows[1]));
    // The data file is of the end and has the box with all digits, the dump with six.
    let end = &read(&[plain("liggghts/end.data")])[0];
    assert!((end.assembly.volume() / rows[1][1] - 1.0).abs() < 1e-14, "{}", end.assembly.volume());
    assert!((end.assembly.volume() / found[1].assembly.volume() - 1.0).abs() < 1e-5);
    for (one, two) in end.assembly.bodies.iter().zip(&found[1].assembly.bodies) {
        assert_eq!((one.id, one.equivalent_radius), (two.id, two.equivalent_radius));
        assert!((one.mass / two.mass - 1.0).abs() < 1e-12);
        assert!((0..3).all(|a| (one.spin[a] - two.spin[a]).abs() < 1e-12), "{one:?} {two:?}");
    }
    // Its VTK files hold places with seven digits, the box with all.
    let names =
        ["liggghts/grains-6000.vtp", "liggghts/contacts-6000.vtp", "liggghts/grains-boundingBox_6000.vtr"];
    let found = &read(&names.map(plain))[0];
    assert!(apart(found, &rows[0]) < 1e-5, "{}", apart(found, &rows[0]));
    assert!((found.assembly.volume() / rows[0][1] - 1.0).abs() < 1e-14);
    assert!(found.parts.missing(&[Part::Spins, Part::Masses, Part::Velocities, Part::Overlaps]).is_empty());
}

/// Names that mean nothing, and a vector that is not whole, are refused: nothing of a file is passed over without a word.
#[test]
fn names_of_columns_are_known_and_complete() {
    let message = |name: &str, columns: &str| {
        let files = [plain("lammps/grains.dump"), with_columns(name, columns)];
        Formats::standard().read_results(&files, &JoinOptions::default()).unwrap_err().to_string()
    };
    for (columns, parts) in [
        (
            "id1,id2,dist",
            &["contacts.dump: --columns: \"dist\" is not the name of a quantity", "patom1", "force_z, and -"]
                [..],
        ),
        (
            "-,patom1,patom2,fx,fy,fz,-,-,-,-,-,-",
            &["fx fy fz are the normal force", "p1 p2 p3, its tangential force, are missing"],
        ),
        ("index,patom1,patom2,fx,fy,fz,p1,p2,-,-,-,-", &["there is p1 p2, but no p3"]),
        ("index,patom1,patom1,fx,fy,fz,p1,p2,p3,-,-,-", &["patom1 is given twice"]),
        ("index,patom1,patom2,fx,fy,fz,p1,p2,p4,-,-,-", &["\"p4\" is not the name"]),
    ] {
        let found = message("lammps/contacts.dump", columns);
        assert!(parts.iter().all(|part| found.contains(part)), "{columns}: {found}");
    }
    let found = message("lammps/grains.dump", "id,x,y,z");
    assert!(found.contains("--columns"), "{found}");
    // The normal force alone, with the vector that says its direction, is enough.
    let files = [
        plain("lammps/grains.dump"),
        with_columns("lammps/contacts.dump", "-,patom1,patom2,fx,fy,fz,-,-,-,p10,p11,p12"),
    ];
    let found = read(&files);
    assert!(found[0].parts.has(granum_core::Part::NormalForces));
}

/// Sensors see a state of LAMMPS, from its dumps, and one of granum's engine through one interface: what follows from the places of the
/// grains agrees.
#[test]
fn the_same_sensors_measure_states_of_lammps_and_of_granum() {
    let theirs = lammps(COLUMNS).pop().unwrap();
    let spheres: Vec<InitialSphere> = (theirs.assembly.spheres().unwrap().iter())
        .map(|sphere| InitialSphere { id: sphere.id, position: sphere.position, radius: sphere.radius })
        .collect();
    let properties = Properties::new(Material::default(), ContactModel::default());
    let ours = Simulation::new(Cell { edges: theirs.assembly.cell }, &spheres, properties).unwrap();
    let states: [&dyn ObservedState; 2] = [&theirs, &ours];
    assert_eq!(states.map(|state| state.grains()), [24, 24]);
    assert_eq!(states.map(|state| state.contacts()), [theirs.assembly.contacts.len(); 2]);
    let measured = states.map(|state| Sensors::standard().measure_state(state));
    for column in ["solid_fraction", "void_ratio", "coordination_number", "fabric_11", "mean_overlap"] {
        let [one, two] = measured.each_ref().map(|measured| measured.value(column));
        let (Some(one), Some(two)) = (one, two) else { panic!("{column}: {one:?} {two:?}") };
        assert!(one != 0.0 && (two / one - 1.0).abs() < 1e-9, "{column}: {one} {two}");
    }
    // LAMMPS does not say how much energy its contacts hold.
    assert!(
        measured[0].value("elastic_normal_energy").is_none()
            && measured[1].value("elastic_normal_energy").is_some()
    );
}
