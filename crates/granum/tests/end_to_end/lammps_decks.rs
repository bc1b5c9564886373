//! Input decks for LAMMPS: what is written, what is refused, and, where `lmp` is installed, that LAMMPS runs a deck unchanged and
//! finds what granum finds.

use std::path::Path;
use std::process::{Command, Stdio};

use granum_io::{Table, read_table};

use crate::{SMALL, done, refused};

/// The small case with laws that LAMMPS has.
fn case() -> String {
    let laws =
        "[grains.material]\ninterface_energy = 0\n[contact]\nnormal = \"hertz\"\ntangential = \"no-slip\"\n";
    format!("{SMALL}{laws}")
}

const TEST: [&str; 6] =
    ["--path", "drained-triaxial", "--with", "axial_strain=0.02", "--with", "inertial_number=3e-3"];

/// Executes a deck; false, with a line that says so, where there is no `lmp`.
fn executed(deck: &Path) -> bool {
    let mut command = Command::new("lmp");
    command.args(["-in", "in.granum", "-screen", "none"]).current_dir(deck).env("OMP_NUM_THREADS", "1");
    match command.stdout(Stdio::null()).stderr(Stdio::null()).status() {
        Err(_) => {
            println!("lmp is not on the PATH: the deck was not run");
            false
        }
        Ok(status) => {
            let log = std::fs::read_to_string(deck.join("log.lammps")).unwrap_or_default();
            assert!(status.success(), "{}", log.lines().rev().take(5).collect::<Vec<_>>().join("\n"));
            assert!(log.contains("\nall stages are complete"), "{log}");
            true
        }
    }
}

/// Mean of a column over the rows of stage 1 whose axial strain is in a range.
fn mean(table: &Table, column: &str, range: std::ops::Range<f64>) -> f64 {
    let [strain, values, stage] = ["axial_strain", column, "stage"].map(|name| table.column(name).unwrap());
    let rows: Vec<f64> = (0..strain.len())
        .filter(|&k| stage[k] == 1.0 && range.contains(&strain[k]))
        .map(|k| values[k])
        .collect();
    rows.iter().sum::<f64>() / rows.len() as f64
}

#[test]
fn lammps_runs_the_deck_of_a_sample_and_finds_the_curve_of_granum() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), case()).unwrap();
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    let told = done(here, &[&["export", "sample", "--to", "lammps", "--out", "deck"], &TEST[..]].concat());
    assert!(told.contains("a deck of 150 grains") && told.contains("lmp -in in.granum"), "{told}");
    // A second deck does not replace the first.
    let error =
        refused(here, 1, &[&["export", "sample", "--to", "lammps", "--out", "deck"], &TEST[..]].concat());
    assert!(error.contains("--force"), "{error}");
    if !executed(&here.join("deck")) {
        return;
    }
    done(here, &[&["run", "case.toml", "--sample", "sample", "--out", "run"], &TEST[..]].concat());
    done(here, &["export", "run", "-o", "series.csv"]);
    let theirs = read_table(here.join("deck/curve.csv")).unwrap();
    let ours = read_table(here.join("series.csv")).unwrap();
    // (column, tolerance): several times what two copies of either program with other time steps differ by.
    for (column, tolerance) in [
        ("stress_ratio", 0.05),
        ("solid_fraction", 1.5e-3),
        ("coordination_number", 0.2),
        ("mean_stress", 500.0),
    ] {
        let [a, b] = [&theirs, &ours].map(|table| mean(table, column, 0.005..0.02));
        println!("{column}: LAMMPS {a}, granum {b}");
        assert!((a - b).abs() < tolerance, "{column}: LAMMPS {a}, granum {b}");
    }
    // The deck holds the lateral stresses within a per cent in the mean over a row.
    let stage = theirs.column("stage").unwrap();
    let strain = theirs.column("axial_strain").unwrap();
    for column in ["stress_22", "stress_33"] {
        let held = mean(&theirs, column, 0.001..0.02);
        let square: Vec<f64> = (theirs.column(column).unwrap().iter().zip(stage).zip(strain))
            .filter(|((_, stage), strain)| **stage == 1.0 && **strain > 0.001)
            .map(|((value, _), _)| (value / held - 1.0).powi(2))
            .collect();
        let rms = (square.iter().sum::<f64>() / square.len() as f64).sqrt();
        println!("{column}: held at {held} within {rms}");
        assert!(rms < 0.01, "{column}: {rms}");
    }
}

/// Every kind of stage that a deck can have runs to its end, with a box that is sheared too.
#[test]
fn lammps_runs_the_decks_of_other_paths() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let laws = case().replace(
        "tangential = \"no-slip\"",
        "tangential = \"no-slip\"\nrolling = \"elastic-plastic-twisting\"",
    );
    let stages = "[[stage]]\npath = 'isotropic'\nmean_stress = '25 kPa'\n[[stage]]\npath = 'oedometer'\naxial_stress = '60 kPa'\n\
                  unloading_stress = '40 kPa'\ninertial_number = 1e-3\n[[stage]]\npath = 'undrained-triaxial'\n\
                  axial_strain = -0.004\ninertial_number = 3e-3\n[[stage]]\npath = 'simple-shear-constant-volume'\nshear_strain = 0.01\n\
                  inertial_number = 3e-3\n";
    let (before, after) = laws.split_once("[shear]").unwrap();
    let after = after.split_once("[recording]").unwrap().1;
    let sample = format!("{before}[recording]{}", after.replace("states = 8\n", ""));
    std::fs::write(here.join("case.toml"), &sample).unwrap();
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    granum_io::write_packing(
        here.join("packing.csv"),
        &granum_io::Packing::from_assembly(
            &granum_io::Run::at(here.join("sample")).unwrap().snapshot("start").unwrap(),
        ),
    )
    .unwrap();
    std::fs::write(here.join("stages.toml"), format!("{sample}{stages}")).unwrap();
    done(here, &["export", "stages.toml", "--packing", "packing.csv", "--to", "lammps", "--out", "deck"]);
    if !executed(&here.join("deck")) {
        return;
    }
    let curve = read_table(here.join("deck/curve.csv")).unwrap();
    let [stage, axial, p, shear, volume] =
        ["stage", "axial_strain", "mean_stress", "shear_strain_xy", "volumetric_strain"]
            .map(|name| curve.column(name).unwrap());
    let last = |number: f64| (0..stage.len()).rev().find(|&k| stage[k] == number).unwrap();
    assert!((p[last(1.0)] / 25e3 - 1.0).abs() < 5e-3, "{}", p[last(1.0)]);
    let axial_stress = curve.column("stress_11").unwrap();
    assert!(axial_stress[last(2.0)] > 50e3 && axial_stress[last(3.0)] < axial_stress[last(2.0)]);
    assert!(
        (axial[last(4.0)] + 0.004).abs() < 2e-4 && volume[last(4.0)].abs() < 1e-6,
        "{}",
        axial[last(4.0)]
    );
    assert!((shear[last(5.0)] - 0.01).abs() < 5e-4 && axial[last(5.0)].abs() < 1e-9, "{}", shear[last(5.0)]);
    // Grains move along -x with y, which is positive shear with compression positive, and a positive shear stress resists it.
    assert!(curve.column("stress_12").unwrap()[last(5.0)] > 1e3);
}

#[test]
fn what_no_deck_can_be_is_said() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), case()).unwrap();
    let error = refused(here, 1, &["export", "case.toml", "--to", "lammps", "--out", "deck"]);
    assert!(error.contains("is a case without a sample: add --packing FILE"), "{error}");
    assert!(!here.join("deck").exists());
    let error = refused(here, 1, &["export", "case.toml", "--path", "oedometer", "-o", "a.csv"]);
    assert!(error.contains("--path belongs to --to lammps"), "{error}");
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    // A misspelt format is named as such, and a sample that was not tested has its one snapshot written.
    let error = refused(here, 1, &["export", "sample", "--to", "lamps", "--out", "deck"]);
    assert!(error.contains("no format that granum writes is called \"lamps\""), "{error}");
    done(here, &["export", "sample", "-o", "sample.vtp"]);
    assert!(here.join("sample.vtp").exists());
    let law = ["--set", "contact.tangential=mindlin-deresiewicz"];
    let error =
        refused(here, 1, &[&["export", "sample", "--to", "lammps", "--out", "deck"], &law[..]].concat());
    assert!(
        error.contains("contact.tangential = \"mindlin-deresiewicz\" cannot be written for LAMMPS"),
        "{error}"
    );
    let error =
        refused(here, 1, &["export", "sample", "--to", "lammps", "--out", "deck", "--path", "probes"]);
    assert!(error.contains("it shears the cell without rotation"), "{error}");
    let error =
        refused(here, 1, &["export", "sample", "--to", "lammps", "--out", "deck", "--snapshot", "start"]);
    assert!(error.contains("--snapshot does not go with --to lammps"), "{error}");
    let error =
        refused(here, 1, &["export", "sample", "--to", "lammps", "--out", "deck", "--cell", "1, 1, 1"]);
    assert!(error.contains("--cell does not go with --to lammps"), "{error}");
    assert!(!here.join("deck").exists(), "nothing is written for a case that is refused");
}
