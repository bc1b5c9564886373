//! VTK XML: what YADE's `VTKRecorder` wrote, what VTK writes, and what granum writes itself.

use std::path::{Path, PathBuf};

use granum_core::Part;
use granum_core::assembly::Matrix;
use granum_dem::loading::MacroState;
use granum_io::formats::{ContactOptions, Formats, JoinOptions, ObservedAssembly, ReadOptions};

fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/results").join(name)
}

fn try_read(files: &[PathBuf]) -> granum_io::Result<Vec<ObservedAssembly>> {
    let files: Vec<_> = files.iter().map(|file| (file.clone(), ReadOptions::default())).collect();
    Formats::standard().read_results(&files, &JoinOptions::default())
}

fn recorded(names: &[&str]) -> Vec<ObservedAssembly> {
    let files: Vec<_> = names.iter().map(|name| sample("yade/recorder").join(name)).collect();
    // Two grains have passed through each other, so that YADE has let go of them: they overlap and have no interaction.
    let files: Vec<_> = files.iter().map(|file| (file.clone(), ReadOptions::default())).collect();
    let contacts = ContactOptions::default().with_names(None, Some("no-contacts"), None, None).unwrap();
    Formats::standard().read_results(&files, &JoinOptions::default().with_contacts(contacts)).unwrap()
}

/// The numbers of a line that YADE printed: of the stress nine and the number of contacts.
fn printed(what: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(sample("yade/recorder/stress.txt")).unwrap();
    let line = text.lines().find(|line| line.starts_with(what)).unwrap();
    line.split_whitespace().skip(2).map(|word| word.parse().unwrap()).collect()
}

fn stress(observation: &ObservedAssembly) -> Matrix {
    MacroState::from_assembly(&observation.assembly).stress
}

/// Without friction the recorder holds all of the forces. YADE's stress has tension positive.
#[test]
fn the_stress_of_a_recorded_sample_without_friction_is_yades() {
    let found = &recorded(&["smooth-125200.vtm"])[0];
    let theirs = printed("STRESS 0.0");
    assert_eq!((found.assembly.bodies.len(), found.assembly.contacts.len() as f64), (24, theirs[9]));
    let parts = [
        Part::Cell,
        Part::Masses,
        Part::Velocities,
        Part::Spins,
        Part::ResultantForces,
        Part::TangentialForces,
    ];
    assert!(found.parts.missing(&parts).is_empty(), "{:?}", found.parts.missing(&parts));
    assert_eq!((found.assembly.step, found.assembly.cell[0][1] != 0.0), (125_200, true));
    let ours = stress(found);
    for a in 0..3 {
        for b in 0..3 {
            let gap = (ours[a][b] + theirs[3 * a + b]).abs();
            // Places have the seven digits of single precision: of a branch of about a diameter 1e-7 of the cell.
            assert!(gap < 3e-7 * 1.5e5, "{a}{b}: {} {}", ours[a][b], -theirs[3 * a + b]);
        }
    }
}

/// With friction the file has magnitudes of the components of the tangential force, so that the stress is not known.
#[test]
fn of_a_recorded_sample_with_friction_the_normal_forces_are_known() {
    let names = ["rough-spheres.125200.vtu", "rough-125200.vtm", "rough-pericell.125200.vtu"];
    let found = &recorded(&names)[0];
    assert_eq!(found.assembly.contacts.len() as f64, printed("STRESS 0.4")[9]);
    assert!(found.parts.has(Part::NormalForces) && !found.parts.has(Part::TangentialForces));
    // FrictMat of this modulus: k_n = 2 E R_1 R_2 / (R_1 + R_2).
    for contact in &found.assembly.contacts {
        let [one, two] = [contact.i, contact.j].map(|k| found.assembly.pieces[k].radius);
        let wanted = 2e7 * one * two / (one + two) * contact.approach;
        assert!((contact.normal_force - wanted).abs() < 1e-4 * wanted + 1e-6, "{contact:?} {wanted}");
    }
    let body = printed("BODY5 0.4");
    let grain = found.assembly.bodies[5];
    assert!(
        (0..3).all(|a| (grain.position[a] - body[a]).abs() < 1e-9) && grain.equivalent_radius == body[3],
        "{grain:?}"
    );
    assert!((0..3).all(|a| (grain.velocity[a] - body[5 + a]).abs() < 1e-15));
    assert!((0..3).all(|a| (grain.spin[a] - body[8 + a]).abs() < 1e-12));
    // A frame of contacts alone finds no grains.
    let error = try_read(&[sample("yade/recorder/rough-125200.vtm")]).unwrap_err().to_string();
    assert!(error.contains("has no grains"), "{error}");
}

/// Names of a shell's pattern are in the order of letters, steps are not.
#[test]
fn frames_of_one_file_each_are_in_the_order_of_their_steps() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(sample("yade/recorder/rough-spheres.125200.vtu")).unwrap();
    let files = ["a-spheres.1000.vtu", "a-spheres.200.vtu"].map(|name| {
        let path = folder.path().join(name);
        std::fs::write(&path, &text).unwrap();
        path
    });
    let steps: Vec<u64> = try_read(&files).unwrap().iter().map(|found| found.assembly.step).collect();
    assert_eq!(steps, [200, 1000]);
}

/// Written by VTK itself, see `variants.py`.
#[test]
fn every_way_in_which_vtk_writes_an_array_is_read() {
    let spheres = sample("yade/recorder/rough-spheres.125200.vtu");
    let cell = |name: &str| {
        try_read(&[spheres.clone(), sample("vtk").join(name)]).map(|found| found[0].assembly.cell)
    };
    let wanted = cell("ascii.vtu").unwrap();
    assert!(wanted[0][0] > 2.1e-3 && wanted[0][1] > 2e-5);
    for way in ["inline", "inline-zlib-64", "raw", "raw-zlib-blocks", "raw-big-endian-64", "appended"] {
        assert_eq!(cell(&format!("{way}.vtu")).unwrap(), wanted, "{way}");
    }
    let error = cell("lz4.vtu").unwrap_err().to_string();
    assert!(error.contains("is compressed by vtkLZ4DataCompressor"), "{error}");
}

/// Cut, and with bytes changed: a message that names the file, and no panic.
#[test]
fn damaged_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let message = |from: &str, change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = std::fs::read(sample(from)).unwrap();
        change(&mut bytes);
        let path = folder.path().join("x.vtu");
        std::fs::write(&path, bytes).unwrap();
        try_read(&[path]).err().map(|error| error.to_string())
    };
    let spheres = "yade/recorder/smooth-125200/smooth-125200_0.vtu";
    let length = std::fs::metadata(sample(spheres)).unwrap().len() as usize;
    for end in (10..length).step_by(97) {
        let found = message(spheres, &|bytes| bytes.truncate(end));
        // The last arrays are types of cells, which nothing needs.
        assert!(found.is_some_and(|found| found.contains("x.vtu")) || end + 200 > length, "{end}");
    }
    for at in (100..length).step_by(41) {
        let _ = message(spheres, &|bytes| bytes[at] ^= 0x11);
        let _ = message("vtk/raw-zlib-blocks.vtu", &|bytes| {
            let at = at % bytes.len();
            bytes[at] ^= 0x11;
        });
    }
    let text = |from: &'static str, to: &'static str| {
        message("yade/recorder/rough-spheres.125200.vtu", &move |bytes| {
            let text = String::from_utf8(bytes.clone()).unwrap();
            assert!(text.contains(from));
            *bytes = text.replacen(from, to, 1).into_bytes();
        })
        .unwrap()
    };
    let found = text(" 0.0005408 ", " 0.0005x36 ");
    assert!(found.contains("x.vtu:6:1: the array radii has the value \"0.0005x36\""), "{found}");
    let found = text(" 0.0005408 ", " -1 ");
    assert!(found.contains("grain 1: its place") && found.contains("radius -1 positive"), "{found}");
    let found = text("type=\"UnstructuredGrid\"", "type=\"ImageData\"");
    assert!(
        found.contains("has type=\"ImageData\"; PolyData, UnstructuredGrid and RectilinearGrid can be read"),
        "{found}"
    );
    let found = text("</PointData>", "</Pointdata>");
    assert!(found.contains("is no VTK XML file or is damaged"), "{found}");
}

/// Everything that the format holds comes back with the same bits.
#[test]
fn granums_own_vtp_is_read_again() {
    let columns = "index,patom1,patom2,fx,fy,fz,p1,p2,p3,p10,p11,p12".split(',').map(String::from).collect();
    let files = [
        (sample("lammps/grains.dump"), ReadOptions::default()),
        (sample("lammps/contacts.dump"), ReadOptions::with_columns(Some(columns))),
    ];
    let options = JoinOptions::new(None, None, Some(1e-6));
    let before = &Formats::standard().read_results(&files, &options).unwrap()[2];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.vtp");
    Formats::standard().write_results(&path, None, std::slice::from_ref(before)).unwrap();
    let after = &try_read(std::slice::from_ref(&path)).unwrap()[0];
    assert_eq!((after.assembly.cell, after.origin), (before.assembly.cell, before.origin));
    assert_eq!((after.assembly.time, after.assembly.step), (before.assembly.time, before.assembly.step));
    assert_eq!(after.assembly.bodies.len(), before.assembly.bodies.len());
    let edge = before.assembly.cell[0][0];
    for (one, two) in before.assembly.bodies.iter().zip(&after.assembly.bodies) {
        assert_eq!(
            (one.id, one.equivalent_radius, one.mass, one.spin, one.force),
            (two.id, two.equivalent_radius, two.mass, two.spin, two.force)
        );
        assert!((0..3).all(|a| (one.position[a] - two.position[a]).abs() < 1e-15 * edge), "{one:?} {two:?}");
    }
    assert_eq!(after.assembly.contacts.len(), before.assembly.contacts.len());
    for (one, two) in before.assembly.contacts.iter().zip(&after.assembly.contacts) {
        assert_eq!(
            (one.i, one.j, one.normal_force, one.tangential_force),
            (two.i, two.j, two.normal_force, two.tangential_force)
        );
        assert_eq!(one.approach, two.approach);
        assert!((0..3).all(|a| (one.branch[a] - two.branch[a]).abs() < 1e-14 * edge), "{one:?} {two:?}");
    }
    let (ours, theirs) = (stress(before), stress(after));
    assert!(
        (0..9).all(|n| (ours[n / 3][n % 3] - theirs[n / 3][n % 3]).abs() < 1e-12 * ours[0][0]),
        "{ours:?} {theirs:?}"
    );
}
