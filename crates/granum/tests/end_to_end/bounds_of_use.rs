//! What would never end, fill the memory, or mean nothing is refused: inputs that are no files, numbers that belong to no packing,
//! stresses beyond the stiffness; an interruption is heard wherever the program is.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::common::{stderr, stdout};
use crate::{done, done_json, refused};

/// Runs granum, sends SIGTERM after a time, and returns the output and how long it went on.
fn terminated(here: &Path, arguments: &[&str], after: Duration) -> (Output, Duration) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_granum"));
    command.args(arguments).current_dir(here).stdout(Stdio::piped()).stderr(Stdio::piped());
    let child = command.spawn().unwrap();
    std::thread::sleep(after);
    let sent = Instant::now();
    let killed = Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let output = child.wait_with_output().unwrap();
    (output, sent.elapsed())
}

#[test]
fn an_interruption_is_heard_while_grains_are_placed() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    fs::write(here.join("case.toml"), "grains.count = 300000\n").unwrap();
    let (output, late) =
        terminated(here, &["prepare", "case.toml", "--out", "s"], Duration::from_millis(1800));
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(130), "{text}");
    assert!(text.contains("error: interrupted; ") && text.contains(" of 300000 grains"), "{text}");
    assert!(late < Duration::from_secs(3), "{late:?}");
    assert!(!here.join("s").exists());
}

/// Reading and measuring many grains: no loop listens, and nothing is left behind.
#[test]
fn an_interruption_is_heard_while_grains_are_measured() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let mut text =
        String::from("# periodic box, m: xlo=0 ylo=0 zlo=0 xhi=40 yhi=40 zhi=40\nid,x,y,z,radius\n");
    for k in 0..64_000 {
        let [x, y, z] = [k % 40, k / 40 % 40, k / 1600].map(|n| f64::from(n) + 0.5);
        text.push_str(&format!("{},{x},{y},{z},0.5001\n", k + 1));
    }
    fs::write(here.join("many.csv"), text).unwrap();
    let (output, late) =
        terminated(here, &["measure", "many.csv", "-o", "m.csv"], Duration::from_millis(700));
    assert_eq!(output.status.code(), Some(130), "{} {}", stdout(&output), stderr(&output));
    assert!(stderr(&output).contains("error: interrupted; "), "{}", stderr(&output));
    assert!(late < Duration::from_secs(3), "{late:?}");
    assert_eq!(fs::read_dir(here).unwrap().count(), 1);
}

/// Every reader takes its file by the same function.
#[test]
#[cfg(target_os = "linux")]
fn inputs_are_regular_files() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    assert!(Command::new("mkfifo").arg(here.join("pipe")).status().unwrap().success());
    fs::write(here.join("case.toml"), "grains.count = 50\n").unwrap();
    for name in ["pipe.csv", "pipe.toml", "pipe.parquet", "pipe.vtu", "pipe.gsd"] {
        std::os::unix::fs::symlink("pipe", here.join(name)).unwrap();
    }
    let vtm = r#"<VTKFile type="vtkMultiBlockDataSet"><vtkMultiBlockDataSet><DataSet index="0" file="FILE"/></vtkMultiBlockDataSet></VTKFile>"#;
    for (name, file) in [("zero.vtm", "zero"), ("pipe.vtm", "pipe")] {
        fs::write(here.join(name), vtm.replace("FILE", file)).unwrap();
    }
    std::os::unix::fs::symlink("/dev/zero", here.join("zero")).unwrap();
    for arguments in [
        &["measure", "pipe.csv"][..],
        &["measure", "pipe.parquet"],
        &["measure", "pipe.vtu"],
        &["measure", "pipe.gsd"],
        &["measure", "zero.vtm"],
        &["measure", "pipe.vtm"],
        &["measure", "/dev/zero"],
        &["export", "pipe.csv", "-o", "x.vtp"],
        &["forces", "pipe.csv"],
        &["prepare", "pipe.toml"],
        &["run", "case.toml", "--packing", "pipe.csv", "--out", "r"],
        &["bench", "--only", "dem", "--packing", "pipe.csv"],
        &["pair", "pipe.csv"],
        &["report", "pipe"],
        &["compare", "pipe.csv", "pipe.csv"],
        &["digest", "pipe"],
    ] {
        let message = refused(here, 1, arguments);
        let told =
            ["an input must be a regular file", "pipe", "zero"].iter().any(|word| message.contains(word));
        assert!(told, "{arguments:?}: {message}");
    }
    assert!(!here.join("r").exists());
}

#[test]
fn numbers_that_belong_to_no_packing_are_refused_by_every_reader() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let rows = |change: &str| {
        let mut text = String::from("#format x_y_z_r\n");
        for k in 0..60 {
            let [x, y, z] = [k % 4, k / 4 % 4, k / 16].map(|n| 1e-3 * f64::from(n) + 5e-4);
            text.push_str(&if k == 30 { format!("{change}\n") } else { format!("{x} {y} {z} 4e-4\n") });
        }
        text
    };
    let cell = ["--cell", "4 mm, 4 mm, 4 mm"];
    for (row, what) in [
        ("1e9 1e-3 1e-3 4e-4", "grain 30"),
        ("1e-3 1e-3 1e-3 1e308", "radius = 1e308 m"),
        ("1e-3 1e-3 1e-3 0.04", "radius = 4e-2 m"),
        ("1e-3 1e-3 1e-3 1e-12", "radius = 1e-12 m"),
    ] {
        fs::write(here.join("grains.txt"), rows(row)).unwrap();
        for command in [&["measure", "grains.txt"][..], &["export", "grains.txt", "-o", "x.vtp"]] {
            let message = refused(here, 1, &[command, &cell].concat());
            assert!(message.contains("grains.txt:32:") && message.contains(what), "{row}: {message}");
        }
        if row.contains("0.04") {
            continue;
        }
        let message = refused(here, 1, &["measure", "grains.txt"]);
        assert!(message.contains("grains.txt:32:") && message.contains("grain 30"), "{row}: {message}");
    }
    fs::write(here.join("grains.txt"), rows("1e-3 1e-3 1e-3 4e-4")).unwrap();
    done(here, &["measure", "grains.txt"]);
}

/// A cell that shrinks: the test ends in good order and its record says why.
#[test]
fn a_test_ends_where_grains_overlap_too_far() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let case = "grains.count = 60\ngrains.material.youngs_modulus = '50 MPa'\ngrains.material.interface_energy = 0\n\
                contact.normal = 'hertz'\ncontact.tangential = 'no-slip'\npreparation.friction = 0.1\n\
                preparation.solid_fraction = 'none'\npreparation.inertial_number = 1e-2\n\
                preparation.unbalanced_force = 2e-2\n[[stage]]\nname = 'shrink'\ninertial_number = 1e-2\n\
                xx = { rate = 1 }\nyy = { rate = 1 }\nzz = { rate = 1 }\nuntil = { xx_strain = 0.4 }\n";
    fs::write(here.join("case.toml"), case).unwrap();
    let found = done_json(here, &["run", "case.toml", "--out", "r"]);
    let notes = found["notes"].to_string();
    assert!(notes.contains("overlap by 1") && notes.contains("numerics.largest_overlap"), "{notes}");
    let flags = found["quality"].as_array().unwrap();
    assert!(
        flags.iter().any(|flag| flag["name"] == "stages_cut_short" && flag["passed"] == false),
        "{flags:?}"
    );
    assert!(here.join("r/series.parquet").is_file());

    fs::write(
        here.join("hard.toml"),
        case.replace("preparation.friction", "preparation.mean_stress = '1 GPa'\npreparation.friction"),
    )
    .unwrap();
    let message = refused(here, 1, &["prepare", "hard.toml"]);
    assert!(message.contains("hard.toml:6:") && message.contains("would press the grains"), "{message}");
    fs::write(here.join("slow.toml"), "grains.count = 50\npreparation.mean_stress = '0.001 Pa'\n").unwrap();
    let (output, _) = terminated(here, &["prepare", "slow.toml"], Duration::from_millis(700));
    assert!(
        stderr(&output).contains("warning: the compaction of its sample takes about"),
        "{}",
        stderr(&output)
    );
}
