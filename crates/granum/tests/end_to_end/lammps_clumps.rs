//! Input decks for LAMMPS of grains of several pieces: what is written, and, where `lmp` is installed, that LAMMPS finds granum's forces and
//! stress in a sample and granum's curve in a test.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};

use granum_core::assembly::Assembly;
use granum_io::{Run, Table, read_table};

use crate::{SMALL, done, refused};

fn case(shape: &str) -> String {
    let laws = "[grains.material]\nyoungs_modulus = \"2 GPa\"\ninterface_energy = 0\n[contact]\nnormal = \"hertz\"\ntangential = \"no-slip\"\n";
    format!("{SMALL}{laws}[grains.shape]\n{shape}\n")
}

/// Executes a script of LAMMPS; false, with a line that says so, where there is no `lmp`.
fn executed(folder: &Path, script: &str) -> bool {
    let mut command = Command::new("lmp");
    command.args(["-in", script, "-screen", "none"]).current_dir(folder).env("OMP_NUM_THREADS", "1");
    match command.stdout(Stdio::null()).stderr(Stdio::null()).status() {
        Err(_) => {
            println!("lmp is not on the PATH: {script} was not run");
            false
        }
        Ok(status) => {
            let log = std::fs::read_to_string(folder.join("log.lammps")).unwrap_or_default();
            assert!(status.success(), "{}", log.lines().rev().take(5).collect::<Vec<_>>().join("\n"));
            true
        }
    }
}

/// The sample of a folder of `granum prepare`.
fn sample(folder: &Path) -> Assembly {
    Run::at(folder).unwrap().snapshot("start").unwrap()
}

/// Stress of the normal forces between the centres of bodies: 11, 22, 33, 12, 13, 23.
fn normal_stress(assembly: &Assembly) -> [f64; 6] {
    let mut sum = [0.0; 6];
    for contact in &assembly.contacts {
        let branch = assembly.branch_of_bodies(contact);
        let force = contact.normal.map(|n| n * contact.normal_force);
        for (into, (r, c)) in sum.iter_mut().zip([(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]) {
            *into += branch[r] * force[c] / assembly.volume();
        }
    }
    sum
}

/// Forces and stress of samples of two shapes: capsules, whose pieces weigh alike in the centre of their body, and random grains.
#[test]
fn forces_and_stress_of_a_packing_of_bodies_are_those_of_lammps() {
    for shape in
        ["kind = \"capsule\"", "kind = \"sand\"\nelongation = 0.7\nflatness = 0.8\nshapes = 3\npieces = 6"]
    {
        let base = tempfile::tempdir().unwrap();
        let here = base.path();
        std::fs::write(here.join("case.toml"), case(shape)).unwrap();
        done(here, &["prepare", "case.toml", "--out", "sample"]);
        let path = ["--path", "drained-triaxial", "--with", "axial_strain=0.02"];
        done(here, &[&["export", "sample", "--to", "lammps", "--out", "deck"], &path[..]].concat());
        let deck = here.join("deck");
        let script = std::fs::read_to_string(deck.join("in.granum")).unwrap();
        assert!(
            script.contains("fix move all rigid/small molecule infile bodies.txt reinit no\n"),
            "{script}"
        );
        let (head, _) = script.split_once("run 0 post no\n").unwrap();
        let dump = "compute pairs all property/local patom1 patom2 cutoff radius\n\
                    compute pair_forces all pair/local fx fy fz cutoff radius\n\
                    dump pairs all local 1 forces.txt c_pairs[1] c_pairs[2] c_pair_forces[1] c_pair_forces[2] c_pair_forces[3]\n\
                    dump_modify pairs format float %.17g\nrun 0 post no\n\
                    print \"$(v_s11:%.17g) $(v_s22:%.17g) $(v_s33:%.17g) $(v_s12:%.17g) $(v_s13:%.17g) $(v_s23:%.17g)\" file stress.txt\n";
        std::fs::write(deck.join("forces.in"), format!("{head}{dump}")).unwrap();
        if !executed(&deck, "forces.in") {
            return;
        }
        let assembly = sample(&here.join("sample"));
        let ours: BTreeMap<(usize, usize), f64> = assembly
            .contacts
            .iter()
            .map(|contact| {
                ((contact.i.min(contact.j) + 1, contact.i.max(contact.j) + 1), contact.normal_force)
            })
            .collect();
        let mut theirs = BTreeMap::new();
        for line in std::fs::read_to_string(deck.join("forces.txt")).unwrap().lines() {
            let numbers: Vec<f64> = line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
            if let [one, two, x, y, z] = numbers[..] {
                let force = (x * x + y * y + z * z).sqrt();
                if force > 0.0 {
                    theirs.insert((one.min(two) as usize, one.max(two) as usize), force);
                }
            }
        }
        assert_eq!(ours.len(), theirs.len(), "{shape}");
        let mean = ours.values().sum::<f64>() / ours.len() as f64;
        let apart = ours.iter().map(|(pair, force)| (force - theirs[pair]).abs()).fold(0.0, f64::max);
        println!(
            "{shape}: {} contacts, forces differ by at most {:e} of their mean",
            ours.len(),
            apart / mean
        );
        assert!(apart < 1e-9 * mean, "{shape}: {}", apart / mean);
        let text = std::fs::read_to_string(deck.join("stress.txt")).unwrap();
        let stress: Vec<f64> = text.split_whitespace().map(|word| word.parse().unwrap()).collect();
        let expected = normal_stress(&assembly);
        let p = (expected[0] + expected[1] + expected[2]) / 3.0;
        for (a, b) in stress.iter().zip(expected) {
            assert!((a - b).abs() < 1e-9 * p, "{shape}: {stress:?}, {expected:?}");
        }
    }
}

/// Mean of a column of stage 1 over a range of another.
fn mean(table: &Table, column: &str, along: &str, range: std::ops::Range<f64>) -> f64 {
    let [place, values, stage] = [along, column, "stage"].map(|name| table.column(name).unwrap());
    let rows: Vec<f64> = (0..place.len())
        .filter(|&k| stage[k] == 1.0 && range.contains(&place[k]))
        .map(|k| values[k])
        .collect();
    rows.iter().sum::<f64>() / rows.len() as f64
}

/// A drained test, and simple shear at constant volume in a box that is tilted.
#[test]
fn lammps_runs_the_decks_of_bodies_and_finds_the_curves_of_granum() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), case("kind = \"dimer\"")).unwrap();
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    let speed = "inertial_number=3e-3";
    for (path, strain, along) in [
        ("drained-triaxial", "axial_strain=0.02", "axial_strain"),
        ("simple-shear-constant-volume", "shear_strain=0.02", "shear_strain_xy"),
    ] {
        let test = ["--path", path, "--with", strain, "--with", speed];
        let told = done(here, &[&["export", "sample", "--to", "lammps", "--out", path], &test[..]].concat());
        assert!(told.contains("a deck of 150 grains"), "{told}");
        if !executed(&here.join(path), "in.granum") {
            return;
        }
        let log = std::fs::read_to_string(here.join(path).join("log.lammps")).unwrap();
        assert!(log.contains("\nall stages are complete"), "{log}");
        done(
            here,
            &[&["run", "case.toml", "--sample", "sample", "--out", "run", "--force"], &test[..]].concat(),
        );
        done(here, &["export", "run", "-o", "series.csv", "--force"]);
        let theirs = read_table(here.join(path).join("curve.csv")).unwrap();
        let ours = read_table(here.join("series.csv")).unwrap();
        for (column, tolerance) in [
            ("mean_stress", 0.05),
            (if along == "axial_strain" { "stress_ratio" } else { "stress_12" }, 0.08),
            ("solid_fraction", 2e-3),
            ("coordination_number", 0.03),
        ] {
            let [a, b] = [&theirs, &ours].map(|table| mean(table, column, along, 0.005..0.02));
            println!("{path}, {column}: LAMMPS {a}, granum {b}");
            assert!((a - b).abs() < tolerance * b.abs(), "{path}, {column}: LAMMPS {a}, granum {b}");
        }
    }
}

/// Several stages, after each of which bodies lose the velocities of the homogeneous strain.
#[test]
fn stages_of_bodies_follow_each_other() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let laws = case("kind = \"dimer\"");
    let (before, after) = laws.split_once("[shear]").unwrap();
    let after = after.split_once("[recording]").unwrap().1;
    let sample = format!("{before}[recording]{}", after.replace("states = 8\n", ""));
    std::fs::write(here.join("case.toml"), &sample).unwrap();
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    done(here, &["export", "sample", "-o", "packing.csv"]);
    let stages = "[[stage]]\npath = 'oedometer'\naxial_stress = '60 kPa'\nunloading_stress = '40 kPa'\ninertial_number = 3e-3\n\
                  [[stage]]\npath = 'undrained-triaxial'\naxial_strain = -0.004\ninertial_number = 3e-3\n";
    std::fs::write(here.join("stages.toml"), format!("{sample}{stages}")).unwrap();
    done(here, &["export", "stages.toml", "--packing", "packing.csv", "--to", "lammps", "--out", "deck"]);
    if !executed(&here.join("deck"), "in.granum") {
        return;
    }
    done(here, &["run", "stages.toml", "--packing", "packing.csv", "--out", "run"]);
    done(here, &["export", "run", "-o", "series.csv"]);
    let theirs = read_table(here.join("deck/curve.csv")).unwrap();
    let ours = read_table(here.join("series.csv")).unwrap();
    let ends = |table: &Table, column: &str| {
        let [stage, values] = ["stage", column].map(|name| table.column(name).unwrap().to_vec());
        let last = |number: f64| (0..stage.len()).rev().find(|&k| stage[k] == number).unwrap();
        [1.0, 2.0, 3.0].map(|number| values[last(number)])
    };
    for (column, tolerance) in [("mean_stress", 0.05), ("stress_11", 0.05), ("solid_fraction", 1e-3)] {
        let (a, b) = (ends(&theirs, column), ends(&ours, column));
        println!("{column}: LAMMPS {a:?}, granum {b:?}");
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < tolerance * b), "{column}: {a:?}, {b:?}");
    }
}

#[test]
fn what_fix_rigid_small_does_not_move_is_refused() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let mixed = format!(
        "{}[[grains.shape]]\nkind = \"sphere\"\nshare = 0.5\n[[grains.shape]]\nkind = \"dimer\"\n",
        case("").replace("[grains.shape]\n", "")
    );
    std::fs::write(here.join("case.toml"), mixed).unwrap();
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    let path = ["--path", "drained-triaxial"];
    let error =
        refused(here, 1, &[&["export", "sample", "--to", "lammps", "--out", "deck"], &path[..]].concat());
    assert!(error.contains("is one sphere among grains of several pieces"), "{error}");
    assert!(!here.join("deck").exists());
}
