//! The runs of a campaign executed by other programs, as the page on clusters shows: GNU parallel, Dask, Snakemake.
#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::campaigns::folder_with_plan;
use crate::common::{python_with, stderr, stdout};
use crate::{digest, done, done_json};

/// The page, from which the commands are taken.
const PAGE: &str = include_str!("../../../../docs/src/cluster.md");

/// The commands of the first block of a section of the page.
fn commands_of(section: &str) -> Vec<&'static str> {
    let from = PAGE.split_once(&format!("\n## {section}\n")).unwrap().1;
    let block = from.split_once("```sh\n").unwrap().1.split_once("```").unwrap().0;
    // What follows a # is said to the reader.
    block.lines().map(|line| line.split(" #").next().unwrap().trim()).collect()
}

/// A search path with the program, and with the folders of the given programs.
fn path_with(programs: &[&Path]) -> std::ffi::OsString {
    let own = Path::new(env!("CARGO_BIN_EXE_granum"));
    let folders =
        std::iter::once(own).chain(programs.iter().copied()).filter_map(Path::parent).map(Path::to_path_buf);
    let rest = std::env::var_os("PATH").unwrap_or_default();
    std::env::join_paths(folders.chain(std::env::split_paths(&rest))).unwrap()
}

/// Executes the commands of a section in a folder with a plan; the runs are those of a campaign that granum carries out itself.
fn carried_out(section: &str, path: &std::ffi::OsStr, prepare: impl FnOnce(&Path)) {
    let base = folder_with_plan();
    let here = base.path();
    prepare(here);
    for command in commands_of(section) {
        let output =
            Command::new("sh").args(["-c", command]).current_dir(here).env("PATH", path).output().unwrap();
        assert!(output.status.success(), "{command}: {}{}", stdout(&output), stderr(&output));
    }
    let status = done_json(here, &["campaign", "status", "study"]);
    assert_eq!(status["done"], true, "{status}");
    done(here, &["campaign", "plan.toml", "--out", "own"]);
    for run in status["runs"].as_array().unwrap() {
        let name = run["name"].as_str().unwrap();
        assert_eq!(digest(here, &format!("study/tests/{name}")), digest(here, &format!("own/tests/{name}")));
    }
}

/// True if a command succeeds.
fn is_there(program: &Path, arguments: &[&str]) -> bool {
    Command::new(program).args(arguments).output().is_ok_and(|output| output.status.success())
}

#[test]
fn gnu_parallel_executes_the_runs() {
    // Another program of this name does not know --joblog.
    if !is_there(Path::new("parallel"), &["--joblog", "/dev/null", "true", ":::", "1"]) {
        eprintln!("gnu_parallel_executes_the_runs: skipped, since there is no GNU parallel here");
        return;
    }
    carried_out("GNU parallel", &path_with(&[]), |_| {});
}

#[test]
fn dask_executes_the_runs() {
    let Some(python) = python_with(&["dask", "distributed"]) else {
        eprintln!(
            "dask_executes_the_runs: skipped, since there is no Python with dask.distributed here (GRANUM_PYTHON)"
        );
        return;
    };
    carried_out("Dask", &path_with(&[&python]), |here| {
        fs::write(here.join("dask_jobs.py"), include_str!("../../../../examples/schedulers/dask_jobs.py"))
            .unwrap();
    });
}

#[test]
fn snakemake_executes_the_runs() {
    let Some(python) = python_with(&["snakemake"]) else {
        eprintln!(
            "snakemake_executes_the_runs: skipped, since there is no Python with snakemake here (GRANUM_PYTHON)"
        );
        return;
    };
    let program = python.with_file_name("snakemake");
    carried_out("Snakemake", &path_with(&[&program]), |here| {
        fs::write(here.join("Snakefile"), include_str!("../../../../examples/schedulers/Snakefile")).unwrap();
    });
}
