//! Input decks for LAMMPS of bonded samples: what the program says, and, where there is a LAMMPS with the package BPM, that it runs a deck unchanged
//! and finds granum's peak and granum's ruptures.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use granum_io::{Table, read_table};

use crate::{done, refused};

/// Cemented sand of a few grains of two sizes and more.
const CASE: &str = "[grains]\ncount = 150\ndiameter = '0.2 mm'\nspread = 0.2\n[grains.material]\ndensity = '2650 kg/m3'\nyoungs_modulus = '5 GPa'\n\
                    friction = 0.5\ninterface_energy = 0\n[contact]\nnormal = 'hertz'\ntangential = 'no-slip'\ndamping = 0.2\n\
                    [preparation]\nmean_stress = '100 kPa'\ninertial_number = 5e-3\nunbalanced_force = 1e-2\nsolid_fraction = 'none'\nfriction = 0.2\n\
                    [[bond]]\nlaw = 'additive'\nattachment = 'middle'\ncement_content = '1 %'\nmodulus = '1 GPa'\ntensile_strength = '3 MPa'\n\
                    cohesion = '3 MPa'\ndamping = 0.2\nscatter = 'weibull'\nweibull_modulus = 5\n[recording]\nobservations_per_state = 3\n\
                    [[stage]]\npath = 'drained-triaxial'\naxial_strain = 0.02\ninertial_number = 3e-3\nstates = 40\n";

/// The LAMMPS of `GRANUM_LMP`, that of `scripts/lammps`, or `lmp`, if it has bonds.
fn lammps() -> Option<Command> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/lammps");
    let given = std::env::var_os("GRANUM_LMP").map(PathBuf::from);
    let candidates = given.into_iter().chain([own.join("bin/lmp"), PathBuf::from("lmp")]);
    let command = |program: &PathBuf| {
        let mut command = Command::new(program);
        // The wheel finds MPI in the folder of its environment.
        let libraries = program.parent().and_then(Path::parent).map(|folder| folder.join("lib"));
        if let Some(libraries) = libraries.filter(|folder| folder.join("libmpi.so.12").exists()) {
            command.env("LD_LIBRARY_PATH", libraries);
        }
        command.env("OMP_NUM_THREADS", "1").stdin(Stdio::null());
        command
    };
    let has_bonds = |program: &PathBuf| {
        let output = command(program).arg("-h").output();
        output.is_ok_and(|output| {
            String::from_utf8_lossy(&output.stdout).split_whitespace().any(|word| word == "BPM")
        })
    };
    let found = candidates.into_iter().find(has_bonds);
    if found.is_none() {
        println!(
            "there is no LAMMPS with the package BPM (scripts/lammps installs one): the deck was not run"
        );
    }
    found.as_ref().map(command)
}

/// Axial strains and a column of stage 1.
fn curve(table: &Table, column: &str) -> Vec<[f64; 2]> {
    let [stage, strain, values] = ["stage", "axial_strain", column].map(|name| table.column(name).unwrap());
    (0..stage.len()).filter(|&k| stage[k] == 1.0).map(|k| [strain[k], values[k]]).collect()
}

#[test]
fn lammps_runs_the_deck_of_a_bonded_sample_and_finds_its_peak_and_its_ruptures() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), CASE).unwrap();
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    let told = done(here, &["export", "sample", "--to", "lammps", "--out", "deck"]);
    assert!(told.contains("a deck of 150 grains"), "{told}");
    let bonds = std::fs::read_to_string(here.join("deck/bonds.txt")).unwrap().lines().count();
    // The engine reads no bonds back, and says so before it looks for LAMMPS.
    let error = refused(
        here,
        1,
        &["run", "case.toml", "--engine", "lammps", "--command", "no-such-lmp", "--out", "by"],
    );
    assert!(
        error.contains("the engine lammps: bond = 1 tables") && error.contains("neither the loads of bonds"),
        "{error}"
    );
    assert!(!here.join("by").exists());
    let Some(mut lammps) = lammps() else { return };
    let status =
        lammps.args(["-in", "in.granum", "-screen", "none"]).current_dir(here.join("deck")).status().unwrap();
    let log = std::fs::read_to_string(here.join("deck/log.lammps")).unwrap_or_default();
    assert!(status.success(), "{}", log.lines().rev().take(5).collect::<Vec<_>>().join("\n"));
    assert!(log.contains("\nall stages are complete"), "{log}");
    done(here, &["run", "case.toml", "--sample", "sample", "--out", "run"]);
    done(here, &["export", "run", "-o", "series.csv"]);
    let theirs = read_table(here.join("deck/curve.csv")).unwrap();
    let ours = read_table(here.join("series.csv")).unwrap();
    // There are none while the sample comes to rest, and all where the test begins.
    assert_eq!(theirs.column("bonds").unwrap()[0], 0.0);
    let [held, holding] = [&theirs, &ours].map(|table| curve(table, "bonds"));
    assert_eq!((held[0][1], holding[0][1]), (bonds as f64, bonds as f64));
    assert!(held.is_sorted_by(|a, b| a[1] >= b[1]), "no bond heals: {held:?}");
    let half =
        |curve: &[[f64; 2]]| curve.iter().find(|row| row[1] < 0.5 * bonds as f64).map(|row| row[0]).unwrap();
    let peak = |table: &Table| curve(table, "deviator_stress").iter().map(|row| row[1]).fold(0.0, f64::max);
    let (a, b) = ([half(&held), peak(&theirs)], [half(&holding), peak(&ours)]);
    println!("half of {bonds} bonds broken at a strain, and peak of q in Pa: LAMMPS {a:?}, granum {b:?}");
    assert!((a[0] - b[0]).abs() < 1.5e-3 && (a[1] / b[1] - 1.0).abs() < 0.1, "{a:?} {b:?}");
}
