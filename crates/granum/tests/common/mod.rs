//! Helpers that run the program in a folder.
#![allow(dead_code, reason = "not every test file takes every helper")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs granum in a folder and waits for its end.
pub fn run(folder: &Path, arguments: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_granum");
    Command::new(program).args(arguments).current_dir(folder).output().unwrap()
}

/// The standard output of the program.
pub fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// The standard error of the program.
pub fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Changes a JSON file that ends with its SHA-256 and gives it the right one again, as a program would that knows how.
pub fn change_sealed(file: &Path, change: impl FnOnce(&mut serde_json::Value)) {
    let mut value: serde_json::Value = serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap();
    value.as_object_mut().unwrap().remove("sha256");
    change(&mut value);
    std::fs::write(file, granum_io::sealed::seal(&value).unwrap()).unwrap();
}

/// Parses a text as JSON.
pub fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// A Python with some packages: `GRANUM_PYTHON`, that of `scripts/python-readers`, or `python3`.
pub fn python_with(packages: &[&str]) -> Option<PathBuf> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/python-readers/bin/python");
    let given = std::env::var_os("GRANUM_PYTHON").map(PathBuf::from);
    let find = format!(
        "import importlib.util, sys; sys.exit(any(importlib.util.find_spec(p) is None for p in {packages:?}))"
    );
    given.into_iter().chain([own, PathBuf::from("python3")]).find(|python| {
        Command::new(python).args(["-c", &find]).output().is_ok_and(|output| output.status.success())
    })
}
