//! The C and C++ examples are compiled and run against the library as their users have it. Where there is no compiler the tests say so.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn source(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name)
}

/// The folder in which cargo puts the library for tests.
fn libraries() -> PathBuf {
    std::env::current_exe().unwrap().parent().unwrap().to_path_buf()
}

/// Compiles a program; `None`, with a word on standard error, where there is no compiler.
fn compiled(compiler: &str, options: &[&str], name: &str, folder: &Path) -> Option<PathBuf> {
    if Command::new(compiler).arg("--version").output().is_err() {
        eprintln!("{name} is not tested: there is no {compiler}");
        return None;
    }
    let program = folder.join("program");
    let library = libraries();
    let out = Command::new(compiler)
        .args(options)
        .args(["-Wall", "-Wextra", "-Werror", "-pthread", "-I"])
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("include"))
        .arg(source(name))
        .arg("-L")
        .arg(&library)
        .arg(format!("-Wl,-rpath,{}", library.display()))
        .args(["-lgranum_c", "-lm", "-o"])
        .arg(&program)
        .output()
        .unwrap();
    assert!(out.status.success(), "{}", text(&out));
    Some(program)
}

fn text(out: &Output) -> String {
    String::from_utf8_lossy(&out.stdout).into_owned() + &String::from_utf8_lossy(&out.stderr)
}

#[test]
fn the_example_in_c() {
    let folder = tempfile::tempdir().unwrap();
    let Some(program) = compiled("cc", &["-std=c99"], "material_point.c", folder.path()) else { return };
    let out = Command::new(program).output().unwrap();
    assert!(out.status.success() && text(&out).contains("\nwell\n"), "{}", text(&out));
    assert!(text(&out).contains("refused: the strain of an increment"), "{}", text(&out));
}

#[test]
fn the_example_in_cpp() {
    let folder = tempfile::tempdir().unwrap();
    let Some(program) = compiled("c++", &["-std=c++17"], "stored_points.cpp", folder.path()) else { return };
    let out = Command::new(program).arg(folder.path().join("states.granum")).output().unwrap();
    assert!(out.status.success() && text(&out).contains("from the file as without it"), "{}", text(&out));
}

/// A drained triaxial test of one element around the UMAT, twice: the same tickets, and so the same states.
#[test]
fn one_element_around_the_umat() {
    let folder = tempfile::tempdir().unwrap();
    let Some(program) = compiled("cc", &["-std=c99"], "one_element.c", folder.path()) else { return };
    std::fs::write(
        folder.path().join("sand.toml"),
        "grains.count = 100\ngrains.material.interface_energy = 0\ngrains.material.friction = 0.5\n\
         preparation.solid_fraction = 'none'\npreparation.friction = 0.05\npreparation.mean_stress = '100 kPa'\n\
         preparation.unbalanced_force = 0.01\n",
    )
    .unwrap();
    let configuration = folder.path().join("granum-materials.toml");
    std::fs::write(
        &configuration,
        "host = 'abaqus'\n[[material]]\ncase = 'sand.toml'\ninertial_number = 2e-3\n",
    )
    .unwrap();
    let run = || Command::new(&program).arg(&configuration).args(["8", "2e-4"]).output().unwrap();
    let out = run();
    assert!(out.status.success(), "{}", text(&out));
    let axial = |step: usize| -> f64 {
        let out = text(&out);
        let line = out.lines().find(|line| line.starts_with(&format!("step {step}:"))).unwrap().to_string();
        line.split("szz ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap()
    };
    assert!(
        axial(1) < -100e3 && axial(8) < axial(1),
        "compression makes the axial stress more negative: {}",
        text(&out)
    );
    assert_eq!(text(&run()), text(&out));
    // Plane stress, a material that does not exist and mistakes of the configuration are refused by name.
    std::fs::write(&configuration, "host = 'abaqus'\n").unwrap();
    let out = run();
    assert!(!out.status.success() && text(&out).contains("material"), "{}", text(&out));
}
