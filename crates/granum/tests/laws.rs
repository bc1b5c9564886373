//! End-to-end tests of `pair` and `impact` against theoretical values.

mod common;

use std::fs;

use common::{json, run, stderr, stdout};
use granum_io::read_table;

/// The effective modulus E* of two equal grains.
fn effective_modulus(youngs_modulus: f64, poissons_ratio: f64) -> f64 {
    youngs_modulus / (2.0 * (1.0 - poissons_ratio * poissons_ratio))
}

fn close(value: f64, wanted: f64, relative: f64) {
    assert!((value - wanted).abs() <= relative * wanted.abs(), "{value} instead of {wanted}");
}

#[test]
fn pair_gives_the_force_of_hertz_and_slides_at_the_limit() {
    let folder = tempfile::tempdir().unwrap();
    let mut path = String::from("# up, then across\nnormal_approach,tangential_displacement,note\n");
    for step in 1..=100 {
        path.push_str(&format!("{},0,1\n", 1e-8 * f64::from(step) / 100.0));
    }
    for step in 1..=400 {
        path.push_str(&format!("1e-8,{},2\n", 2e-8 * f64::from(step) / 400.0));
    }
    fs::write(folder.path().join("path.csv"), path).unwrap();
    for tangential in ["mindlin-deresiewicz", "no-slip"] {
        let done = run(
            folder.path(),
            &[
                "pair",
                "path.csv",
                "--normal",
                "hertz",
                "--tangential",
                tangential,
                "--diameter",
                "0.2 mm",
                "--youngs-modulus",
                "70 GPa",
                "--poissons-ratio",
                "0.3",
                "--friction",
                "0.25",
                "-o",
                "out.csv",
                "--force",
            ],
        );
        assert!(done.status.success(), "{}", stderr(&done));
        let table = read_table(folder.path().join("out.csv")).unwrap();
        let names: Vec<_> = table.names().collect();
        assert_eq!(names[2..], ["note", "normal_force", "tangential_force", "contact_radius"]);
        let modulus = effective_modulus(70e9, 0.3);
        // Hertz 1882 with R* = R/2 = 50 um: N = 4/3 E* R*^(1/2) alpha^(3/2), a = (R* alpha)^(1/2).
        let force = 4.0 / 3.0 * modulus * 5e-5_f64.sqrt() * 1e-8_f64.powf(1.5);
        let normal = table.column("normal_force").unwrap();
        close(normal[99], force, 1e-9);
        close(normal[49], force / 2f64.powf(1.5), 1e-9);
        close(table.column("contact_radius").unwrap()[499], (5e-5_f64 * 1e-8).sqrt(), 1e-9);
        close(table.column("tangential_force").unwrap()[499], 0.25 * force, 1e-9);
        // While the path is purely normal, the tangential force vanishes except for rounding.
        assert!(table.column("tangential_force").unwrap()[99].abs() < 1e-12 * force);
    }
}

/// The example that `granum pair --help` prints has three rows, the last of which returns to zero displacement.
#[test]
fn the_example_of_the_help_of_pair_shows_the_loop_of_mindlin_and_deresiewicz() {
    let folder = tempfile::tempdir().unwrap();
    let help = stdout(&run(folder.path(), &["pair", "--help"]));
    let printf = help.lines().find(|line| line.trim().starts_with("printf")).unwrap();
    let path = printf.split('\'').nth(1).unwrap().replace("\\n", "\n");
    fs::write(folder.path().join("path.csv"), &path).unwrap();
    let command = help.lines().find(|line| line.trim().starts_with("granum pair path.csv")).unwrap();
    let words: Vec<&str> = command.split_whitespace().skip(1).collect();
    let done = run(folder.path(), &words);
    assert!(done.status.success(), "{}", stderr(&done));
    assert!(stdout(&done).contains(" steps from one row to the next"), "{}", stdout(&done));
    let table = read_table(folder.path().join("forces.csv")).unwrap();
    let tangential = table.column("tangential_force").unwrap();

    // Mindlin and Deresiewicz 1953 at constant load, grains of 0.1 mm: E = 70 GPa, nu = 0.3, mu = 0.3.
    let (modulus, shear_modulus) = (effective_modulus(70e9, 0.3), 70e9 / 2.6 / (2.0 * 1.7));
    let (approach, displacement): (f64, f64) = (1e-8, 1e-9);
    let radius = (25e-6 * approach).sqrt();
    let limit = 0.3 * 4.0 / 3.0 * modulus * radius * approach;
    let slides = 1.5 * limit / (8.0 * shear_modulus * radius);
    let loading = |x: f64| limit * (1.0 - (1.0 - x / slides).powf(1.5));
    let top = loading(displacement);
    close(tangential[1], top, 1e-4);
    close(tangential[2], top - 2.0 * loading(0.5 * displacement), 1e-2);
    assert!(tangential[2] < 0.0);

    // With output to standard output, the number of steps must not disturb the table.
    let done = run(folder.path(), &[&["--json"], &words[..words.len() - 2]].concat());
    let told = json(&stdout(&done));
    assert!(told["steps_per_row"].as_u64().unwrap() > 8, "{told}");
    assert_eq!(told["tangential_force"].as_array().unwrap().len(), 3);
    let done = run(folder.path(), &words[..words.len() - 2]);
    assert_eq!(stdout(&done).lines().count(), 4);
    assert!(stderr(&done).contains("steps from one row to the next"), "{}", stderr(&done));
}

#[test]
fn impact_is_elastic_without_damping_and_slips_as_theory_says() {
    let folder = tempfile::tempdir().unwrap();
    // Gross slip for psi1 above 4 chi - 1: psi2 = psi1 - 4 chi, chi = 3.5 (1 - nu) / (2 - nu).
    let (nu, mu) = (0.3, 0.3);
    let psi1: f64 = 6.0;
    let angle = (psi1 * mu * (2.0 - nu) / (2.0 * (1.0 - nu))).atan().to_degrees();
    let angles = format!("0,{angle}");
    let flags = ["--normal", "hertz", "--damping", "0", "--friction", "0.3", "--json"];
    let done =
        run(folder.path(), &[&["impact", "--speed", "1 mm/s", "--angle", &angles], &flags[..]].concat());
    assert!(done.status.success(), "{}", stderr(&done));
    let result = json(&stdout(&done));
    let value = |name: &str, row: usize| result[name][row].as_f64().unwrap();
    close(value("normal_velocity_out", 0), 1e-3, 1e-5);
    close(value("restitution", 0), 1.0, 1e-5);
    assert!(value("tangential_velocity_out", 0).abs() < 1e-12 * 1e-3);
    close(value("psi1", 1), psi1, 1e-9);
    let chi = 3.5 * (1.0 - nu) / (2.0 - nu);
    close(value("psi2", 1), psi1 - 4.0 * chi, 2e-3);
    close(value("speed", 1), 1e-3, 1e-15);
    assert!(value("spin_out", 1).abs() > 0.0);
}

#[test]
fn impact_writes_its_columns_in_their_order() {
    let folder = tempfile::tempdir().unwrap();
    let law = ["--normal", "hertz", "--tangential", "no-slip", "-o", "impacts.csv"];
    let done =
        run(folder.path(), &[&["impact", "--speed", "0.05,0.1", "--angle", "0,30 deg"], &law[..]].concat());
    assert!(done.status.success(), "{}", stderr(&done));
    let table = read_table(folder.path().join("impacts.csv")).unwrap();
    let names = "speed,angle_deg,normal_velocity_in,tangential_velocity_in,normal_velocity_out,\
                 tangential_velocity_out,spin_out,restitution,psi1,psi2";
    assert_eq!(table.names().collect::<Vec<_>>().join(","), names);
    assert_eq!(table.column("speed").unwrap(), [0.05, 0.05, 0.1, 0.1]);
    assert_eq!(table.column("angle_deg").unwrap(), [0.0, 30.0, 0.0, 30.0]);
}

#[test]
fn the_law_comes_from_a_case_file_and_flags_win() {
    let folder = tempfile::tempdir().unwrap();
    let case = "[contact]\nnormal = \"hertz\"\ndamping = 0.2\n[grains]\ndiameter = \"2 mm\"\n";
    fs::write(folder.path().join("case.toml"), case).unwrap();
    let restitution = |flags: &[&str]| {
        let done = run(folder.path(), &[&["impact", "--json", "--speed", "0.1"], flags].concat());
        assert!(done.status.success(), "{}", stderr(&done));
        json(&stdout(&done))["restitution"][0].as_f64().unwrap()
    };
    let of_case = restitution(&["--case", "case.toml"]);
    assert!((0.3..0.8).contains(&of_case), "{of_case}");
    let of_flags = restitution(&["--normal", "hertz", "--damping", "0.2", "--diameter", "2 mm"]);
    assert_eq!(of_case.to_bits(), of_flags.to_bits());
    close(restitution(&["--case", "case.toml", "--damping", "0"]), 1.0, 1e-5);
}

#[test]
fn mistakes_are_named_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    file("path.csv", "normal_approach,tangential_displacement\n1e-9,0\n1e-9,x\n");
    file("columns.csv", "approach,tangential_displacement\n1e-9,0\n");
    file("deep.csv", "normal_approach,tangential_displacement\n1,0\n");
    file("bad.toml", "[grains]\ncuont = 4\n[grains.material]\nyoungs_modulus = \"70 kg\"\n");
    file("good.csv", "normal_approach,tangential_displacement\n1e-9,0\n");
    let message = |arguments: &[&str]| {
        let failed = run(folder.path(), &[arguments, &["-o", "out.csv"]].concat());
        assert_eq!(failed.status.code(), Some(1), "{arguments:?}");
        assert!(!folder.path().join("out.csv").exists());
        stderr(&failed)
    };
    let check = |arguments: &[&str], wanted: &str| {
        let message = message(arguments);
        assert!(message.contains(wanted), "{wanted} is not in {message}");
    };
    check(&["pair", "path.csv"], "error: path.csv:3:6: tangential_displacement = \"x\" is not a number");
    check(&["pair", "columns.csv"], "columns.csv: there is no column normal_approach");
    check(&["pair", "deep.csv"], "deep.csv: ");
    check(&["pair", "none.csv"], "cannot read none.csv");
    check(
        &["pair", "good.csv", "--youngs-modulus", "70 kg"],
        "--youngs-modulus = \"70 kg\" is a mass; it must be",
    );
    check(
        &["pair", "good.csv", "--normal", "slippery"],
        "--normal = \"slippery\" is not known; it must be \"hertz\"",
    );
    check(
        &["pair", "good.csv", "--normal", "hertz", "--tangential", "peeling"],
        "it can be combined with contact.normal = \"jkr\"",
    );
    let bad_case = message(&["pair", "good.csv", "--case", "bad.toml"]);
    assert!(bad_case.contains("bad.toml:2:1: unknown key grains.cuont; did you mean count?"), "{bad_case}");
    assert!(
        bad_case.contains("bad.toml:4:18: grains.material.youngs_modulus = \"70 kg\" is a mass"),
        "{bad_case}"
    );
    check(&["impact", "--speed", "0.1 m"], "--speed = \"0.1 m\" is a length; it must be a velocity");
    check(&["impact", "--speed", "-1"], "speed");
    check(&["impact", "--speed", "1", "--angle", "95"], "95");
    check(
        &["impact", "--speed", "1", "--angle", "3 m"],
        "--angle = \"3 m\" is a length; it must be an angle",
    );
}

#[test]
fn json_errors_carry_the_place() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("path.csv"), "normal_approach,tangential_displacement\n1e-9,x\n").unwrap();
    let failed = run(folder.path(), &["pair", "path.csv", "--json"]);
    let error = json(&stderr(&failed));
    assert_eq!(error["error"]["places"][0]["line"], 2);
    assert_eq!(error["error"]["places"][0]["column"], 6);
}

#[test]
fn an_impact_near_sticking_is_answered_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let done = run(folder.path(), &["impact", "--speed", "0.09", "--angle", "5"]);
    assert!(done.status.success(), "{}", stderr(&done));
    assert_eq!(stdout(&done).lines().count(), 2);
    assert!(
        stderr(&done).contains("warning: at 0.09 m/s and 5 deg the grains barely separate"),
        "{}",
        stderr(&done)
    );
}

#[cfg(unix)]
#[test]
fn a_signal_ends_a_command_in_good_order() {
    use std::process::{Command, Stdio};
    let folder = tempfile::tempdir().unwrap();
    // Many thousand collisions take much longer than sending a signal.
    let angles: Vec<String> = (0..14_000).map(|n| format!("{}", 1e-3 * f64::from(n))).collect();
    let child = Command::new(env!("CARGO_BIN_EXE_granum"))
        .args([
            "impact",
            "--speed",
            "0.1",
            "--normal",
            "hertz",
            "-o",
            "out.csv",
            "--angle",
            &angles.join(","),
        ])
        .current_dir(folder.path())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(300));
    let sent = Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    let ended = child.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(130), "{}", stderr(&ended));
    assert!(stderr(&ended).contains("interrupted; no impact was written"), "{}", stderr(&ended));
    assert!(!folder.path().join("out.csv").exists());
}
