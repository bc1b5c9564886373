//! The data set of a campaign: the same bytes however it came about, and read by granum and by other programs.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use granum_core::digest::sha256;
use granum_run::engine::CHECKS;

use crate::common::{python_with, run, stderr};
use crate::{done, done_json, refused};

/// A drained triaxial test that takes a tenth of a second.
const SAND: &str = "[grains]\ncount = 60\n[grains.material]\ninterface_energy = 0\n[contact]\nnormal = 'hertz'\n\
                    tangential = 'no-slip'\n[preparation]\nmean_stress = '100 kPa'\nfriction = 0.1\nsolid_fraction = 'none'\n\
                    inertial_number = 1e-2\nunbalanced_force = 5e-2\n[[stage]]\npath = 'drained-triaxial'\naxial_strain = 0.01\n\
                    inertial_number = 1e-2\nstates = 4\n[recording]\nsensors = ['overlap_distribution']\n";
/// Four runs that share two samples. They are far too fast, which the plan accepts.
const PLAN: &str = "case = 'sand.toml'\naccept = ['inertial_number < 1', 'servo_error_rms < 1', 'servo_error_largest < 10', \
                    'unbalanced_force < 10', 'energy_gap < 1', 'sample_unbalanced_force < 1', 'largest_overlap < 1']\n[design]\n\
                    kind = 'full-factorial'\n[[variable]]\nname = 'friction'\nkeys = ['grains.material.friction']\n\
                    values = [0.2, 0.4]\n[[variable]]\nname = 'strain'\nkey = 'stage.1.axial_strain'\nvalues = ['1 %', '1.5 %']\n";

fn folder_with_plan() -> tempfile::TempDir {
    let base = tempfile::tempdir().unwrap();
    std::fs::write(base.path().join("sand.toml"), SAND).unwrap();
    std::fs::write(base.path().join("plan.toml"), PLAN).unwrap();
    std::fs::write(base.path().join("keep.toml"), format!("keep = 'dataset'\n{PLAN}")).unwrap();
    base
}

/// The files of a data set but for those that depend on the computer or on the text of the plan.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    let named =
        entries.map(|entry| (entry.file_name().into_string().unwrap(), std::fs::read(entry.path()).unwrap()));
    let out = ["seconds.parquet", "SHA256SUMS", ".granum-lock"];
    named.filter(|(name, _)| !out.contains(&name.as_str())).collect()
}

fn count_of_files(folder: &Path) -> usize {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    entries.map(|entry| if entry.path().is_dir() { count_of_files(&entry.path()) } else { 1 }).sum()
}

#[test]
fn a_data_set_has_the_same_bytes_however_it_came_about() {
    let base = folder_with_plan();
    let here = base.path();
    let told = done_json(here, &["campaign", "plan.toml", "--out", "study", "--workers", "1"]);
    assert_eq!(
        (&told["data_set"]["runs"], &told["data_set"]["digest"].as_str().unwrap().len()),
        (&4.into(), &64)
    );
    let wanted = files(&here.join("study/dataset"));
    assert_eq!(wanted.len(), 5, "{:?}", wanted.keys());
    let sums = std::fs::read_to_string(here.join("study/dataset/SHA256SUMS")).unwrap();
    for (name, bytes) in &wanted {
        assert!(sums.contains(&format!("{}  {name}\n", sha256(bytes))), "{name}: {sums}");
        let text = String::from_utf8_lossy(bytes);
        assert!(!text.contains(here.to_str().unwrap()), "{name} names the folder");
    }

    let runs =
        granum_io::formats::parquet::read_with_words(&here.join("study/dataset/runs.parquet"), None).unwrap();
    let checks =
        runs.names().filter_map(|name| name.strip_prefix("check.")).filter(|name| !name.ends_with(".limit"));
    let unknown: Vec<&str> = checks.filter(|name| !CHECKS.contains(name)).collect();
    assert!(unknown.is_empty(), "a plan could not accept {unknown:?}");

    // With other workers, elsewhere, without the folders of runs.
    std::fs::create_dir(here.join("deep")).unwrap();
    let kept = done_json(here, &["campaign", "keep.toml", "--out", "deep/kept", "--workers", "3"]);
    assert_eq!(kept["data_set"]["digest"], told["data_set"]["digest"]);
    assert_eq!(files(&here.join("deep/kept/dataset")), wanted);
    assert!(count_of_files(&here.join("deep/kept")) <= 16, "{}", count_of_files(&here.join("deep/kept")));

    // By commands in another order, collected twice.
    let listed = done(here, &["campaign", "keep.toml", "--out", "listed", "--list-jobs"]);
    let jobs: Vec<Vec<&str>> = listed.lines().map(|line| line.split(' ').skip(1).collect()).collect();
    for (k, job) in jobs.iter().enumerate().rev() {
        done(here, job);
        if k == 2 {
            done(here, &["campaign", "keep.toml", "--out", "listed", "--collect"]);
            let left_out = std::fs::read_to_string(here.join("listed/dataset/left_out.csv")).unwrap();
            assert_eq!(left_out.matches("unfinished").count(), 2, "{left_out}");
            // A run that has been taken in is finished.
            done(here, job);
            assert!(!here.join("listed/tests").join(job.last().unwrap()).exists());
        }
    }
    done(here, &["campaign", "keep.toml", "--out", "listed", "--collect"]);
    assert_eq!(files(&here.join("listed/dataset")), wanted);

    the_folders_are_not_missed(here);
}

/// Status, report, table and the same command go on to work.
fn the_folders_are_not_missed(here: &Path) {
    let without_seconds = |mut value: serde_json::Value| {
        value["runs"].as_array_mut().unwrap().iter_mut().for_each(|run| run["seconds"] = 0.into());
        value["runs"].clone()
    };
    let status = |folder: &str| without_seconds(done_json(here, &["campaign", "status", folder]));
    assert_eq!(status("deep/kept"), status("study"));
    std::fs::remove_file(here.join("deep/kept/journal.jsonl")).unwrap();
    assert_eq!(status("deep/kept"), status("study"), "without the journal");
    let again = done_json(here, &["campaign", "keep.toml", "--out", "deep/kept"]);
    assert_eq!((&again["finished"], &again["reused"], &again["refused"]), (&4.into(), &4.into(), &0.into()));
    assert_eq!(done_json(here, &["resume", "deep/kept"])["finished"], 4);
    assert!(done(here, &["campaign", "keep.toml", "--out", "deep/kept", "--list-jobs"]).is_empty());
    let told = done_json(here, &["report", "deep/kept"]);
    assert!(told["figure_files"].as_u64().unwrap() >= 3, "{told}");

    // A table of the campaign with or without folders, and of its data set.
    let table = |folder: &str| {
        let mut runs = done_json(here, &["table", folder])["runs"].clone();
        for run in runs.as_array_mut().unwrap() {
            ["folder", "checks"].into_iter().for_each(|key| drop(run.as_object_mut().unwrap().remove(key)));
        }
        runs
    };
    assert_eq!(table("deep/kept"), table("study"));
    assert_eq!(table("study/dataset"), table("study"));

    // Folders that are kept at first go when the plan says so, and a foreign file saves its folder.
    let name = table("study")[0]["name"].as_str().unwrap().to_string();
    std::fs::write(here.join("study/tests").join(&name).join("notes.txt"), "mine").unwrap();
    let output = run(here, &["campaign", "keep.toml", "--out", "study"]);
    assert!(stderr(&output).contains("notes.txt: was not written by granum"), "{}", stderr(&output));
    assert_eq!(std::fs::read_dir(here.join("study/tests")).unwrap().count(), 1);
}

/// What is learned from a data set is what is learned from the folders of its runs.
#[test]
fn surrogates_learn_from_a_data_set_as_from_its_runs() {
    let base = folder_with_plan();
    let here = base.path();
    done(here, &["campaign", "plan.toml", "--out", "study"]);
    let names: Vec<String> = done_json(here, &["campaign", "status", "study"])["runs"]
        .as_array()
        .unwrap()
        .iter()
        .map(|run| format!("study/tests/{}", run["name"].as_str().unwrap()))
        .collect();
    let rest = [
        "--input",
        "grains.material.friction,sample.void_ratio,probability_density",
        "--output",
        "stress_ratio",
    ];
    let fit = |runs: &[&str], more: &[&str]| {
        done_json(here, &[&["train"], runs, &rest, &["--method", "ridge"], more].concat())
    };
    let folders = fit(&names.iter().map(String::as_str).collect::<Vec<_>>(), &["--out", "from-folders"]);
    let campaign = fit(&["study"], &["--out", "from-campaign"]);
    assert_eq!(campaign["dataset_digest"], folders["dataset_digest"]);
    assert_eq!(campaign["fits"], folders["fits"]);

    // Whole runs are kept unseen, also after the training was resumed.
    let part = fit(&["study/dataset"], &["--unseen-share", "0.25", "--out", "part"]);
    let study: serde_json::Value =
        serde_json::from_slice(&std::fs::read(here.join("part/study.json")).unwrap()).unwrap();
    let roles: Vec<&str> =
        study["runs"].as_array().unwrap().iter().map(|run| run["role"].as_str().unwrap()).collect();
    assert_eq!(roles, ["training", "training", "training", "unseen"], "{part}");
    done(here, &["resume", "part"]);
    let scores = done_json(here, &["evaluate", "part", "study"]);
    assert_eq!(scores["runs"].as_array().unwrap().len(), 4, "{scores}");
    let told = refused(
        here,
        1,
        &["train", "study", "--input", "stress_ratio", "--output", "time", "--unseen-share", "1"],
    );
    assert!(told.contains("--unseen-share 1: it must be between 0 and 1"), "{told}");
}

/// Runs that do not pass their checks are counted and named, and are no part of it; a data set that was changed is not used.
#[test]
fn what_is_left_out_is_named_and_damage_is_noticed() {
    let base = folder_with_plan();
    let here = base.path();
    let plan = std::fs::read_to_string(here.join("keep.toml")).unwrap();
    // One check is only passed with the smaller friction.
    std::fs::write(
        here.join("keep.toml"),
        plan.replace("'unbalanced_force < 10'", "'unbalanced_force < 0.1'"),
    )
    .unwrap();
    let told = done(here, &["campaign", "keep.toml", "--out", "study"]);
    assert!(
        told.contains("data set of 2 runs: study/dataset; left out: 2 did not pass their checks"),
        "{told}"
    );
    let card = std::fs::read_to_string(here.join("study/dataset/README.md")).unwrap();
    assert!(
        card.contains("The plan has 4 runs; 2 are in this data set.")
            && card.contains("2 did not pass a check and are left out:"),
        "{card}"
    );
    assert_eq!(
        std::fs::read_dir(here.join("study/tests")).unwrap().count(),
        2,
        "what is left out can be looked at"
    );
    let left_out = std::fs::read_to_string(here.join("study/dataset/left_out.csv")).unwrap();
    assert!(left_out.contains("flagged") && left_out.contains("unbalanced_force"), "{left_out}");
    // They are accepted later.
    std::fs::write(here.join("keep.toml"), plan).unwrap();
    let told = done(here, &["campaign", "keep.toml", "--out", "study"]);
    assert!(told.contains("data set of 4 runs: study/dataset; SHA-256"), "{told}");
    assert_eq!(std::fs::read_dir(here.join("study/tests")).unwrap().count(), 0);
    assert!(!here.join("study/dataset/left_out.csv").exists());

    let runs = here.join("study/dataset/runs.parquet");
    let mut bytes = std::fs::read(&runs).unwrap();
    bytes[2000] ^= 1;
    std::fs::write(&runs, bytes).unwrap();
    let told = refused(here, 1, &["export", "study", "-o", "x.csv"]);
    assert!(told.contains("runs.parquet: was changed or damaged"), "{told}");
    // A file that is missing is written again.
    std::fs::remove_file(&runs).unwrap();
    done(here, &["campaign", "keep.toml", "--out", "study"]);
    done(here, &["export", "study", "-o", "x.csv"]);
    std::fs::remove_file(here.join("x.csv")).unwrap();
    std::fs::remove_dir_all(here.join("study/dataset")).unwrap();
    let told = refused(here, 1, &["export", "study", "-o", "x.csv"]);
    assert!(told.contains("study: the campaign has no data set yet") && told.contains("--collect"), "{told}");
    done(here, &["campaign", "keep.toml", "--out", "study"]);
    done(here, &["export", "study", "-o", "x.csv"]);

    // Rows that were damaged are named, and run again when their file is removed.
    let rows = here.join("study/rows/0001.rows");
    let mut bytes = std::fs::read(&rows).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    std::fs::write(&rows, bytes).unwrap();
    std::fs::remove_dir_all(here.join("study/dataset")).unwrap();
    let told = refused(here, 1, &["campaign", "keep.toml", "--out", "study"]);
    assert!(
        told.contains("0001.rows: the rows of the run") && told.contains("were changed or damaged"),
        "{told}"
    );
    std::fs::remove_file(&rows).unwrap();
    let told = done_json(here, &["campaign", "keep.toml", "--out", "study"]);
    assert_eq!((&told["finished"], &told["data_set"]["runs"]), (&4.into(), &4.into()));
}

#[test]
fn a_data_set_is_exported() {
    let base = folder_with_plan();
    let here = base.path();
    done(here, &["campaign", "keep.toml", "--out", "study"]);
    let told = done(here, &["export", "study", "-o", "states.csv"]);
    assert!(told.contains("wrote 20 rows of states"), "{told}");
    let states = std::fs::read_to_string(here.join("states.csv")).unwrap();
    let head = states.lines().next().unwrap();
    assert!(head.starts_with("run,variable.friction,variable.strain,stage,state,"), "{head}");
    assert!(
        head.contains(",probability_density_0.125,") && head.contains(",overlaps_probability_density_"),
        "{head}"
    );
    done(here, &["export", "study/dataset", "--table", "runs", "-o", "runs.csv"]);
    assert_eq!(std::fs::read_to_string(here.join("runs.csv")).unwrap().lines().count(), 5);
    done(here, &["export", "study", "-o", "states.parquet"]);
    done(here, &["export", "study", "--to", "grainlearning", "-o", "study.hdf5"]);
    assert!(std::fs::read(here.join("study.hdf5")).unwrap().starts_with(b"\x89HDF\r\n\x1a\n"));
    for (arguments, wanted) in [
        (
            &["export", "study", "--table", "series", "-o", "y.csv"][..],
            "a data set has the tables states and runs",
        ),
        (&["export", "study", "--to", "vtp", "-o", "y.vtp"], "a campaign can be written as .csv, .parquet"),
        (
            &["export", "sand.toml", "--to", "grainlearning", "-o", "y.hdf5"],
            "is neither a campaign nor its data set",
        ),
        (
            &["export", "study", "--to", "grainlearning", "--sequence-length", "50", "-o", "y.hdf5"],
            "no run has 50 states",
        ),
        (&["export", "study", "-o", "runs.csv"], "runs.csv exists already"),
    ] {
        let told = refused(here, 1, arguments);
        assert!(told.contains(wanted), "{told}");
    }

    // The states of a single run in the same form.
    done(here, &["run", "sand.toml", "--out", "one"]);
    done(here, &["export", "one", "--table", "states", "-o", "one.parquet"]);
    let one = granum_io::formats::parquet::read_with_lists(&here.join("one.parquet")).unwrap();
    let names: Vec<&str> = one.lists.iter().map(|list| list.name.as_str()).collect();
    assert_eq!((one.table.rows(), names), (5, vec!["probability_density", "overlaps_probability_density"]));
    done(here, &["export", "one", "--table", "states", "-o", "one.csv"]);
    let text = std::fs::read_to_string(here.join("one.csv")).unwrap();
    assert!(text.lines().next().unwrap().contains(",probability_density_0.125,"));
}

/// The commands of the section "The data set" of the book work as they are printed.
#[test]
fn the_commands_of_the_book_work() {
    let book = include_str!("../../../../docs/src/campaigns.md");
    let section = book.split("## The data set").nth(1).unwrap().split("\n## ").next().unwrap();
    let block = section.split("```sh\n").nth(1).unwrap().split("```").next().unwrap().replace("\\\n", " ");
    let base = folder_with_plan();
    let here = base.path();
    done(here, &["campaign", "keep.toml", "--out", "study"]);
    let mut commands = 0;
    for line in block.lines() {
        let words: Vec<&str> = line.split_whitespace().take_while(|word| *word != "#").collect();
        assert_eq!(words[0], "granum", "{line}");
        done(here, &words[1..]);
        commands += 1;
    }
    assert!(commands >= 5 && here.join("study.hdf5").is_file(), "{commands}");
}

#[test]
fn the_schema_of_a_plan_is_printed() {
    let base = folder_with_plan();
    let schema: serde_json::Value = serde_json::from_str(&done(base.path(), &["schema", "--plan"])).unwrap();
    assert_eq!(schema["title"], "granum plan");
    assert!(schema["properties"]["design"]["properties"]["kind"]["enum"].as_array().unwrap().len() == 5);
    let told = refused(base.path(), 1, &["campaign", "sand.toml"]);
    assert!(told.contains("the plan names no base case"), "{told}");
    std::fs::write(base.path().join("odd.toml"), format!("keep = 'data'\n{PLAN}")).unwrap();
    let told = refused(base.path(), 1, &["campaign", "odd.toml"]);
    assert!(told.contains("odd.toml:1:") && told.contains("must be \"folders\" or \"dataset\""), "{told}");
}

/// Other programs open a data set: pandas, polars, DuckDB, mlcroissant, h5py. Skipped where a Python with these packages is absent;
/// `scripts/python-readers` makes one.
#[test]
fn other_programs_read_a_data_set() {
    let Some(python) =
        python_with(&["pandas", "pyarrow", "polars", "duckdb", "mlcroissant", "h5py", "jsonschema"])
    else {
        eprintln!(
            "skipped other_programs_read_a_data_set: no Python with the packages of scripts/python-readers"
        );
        return;
    };
    let base = folder_with_plan();
    let here = base.path();
    done(here, &["campaign", "keep.toml", "--out", "study"]);
    done(here, &["export", "study", "--to", "grainlearning", "-o", "study.hdf5"]);
    std::fs::write(here.join("schema.json"), done(here, &["schema", "--plan"])).unwrap();
    std::fs::write(here.join("readers.py"), include_str!("data_sets.py")).unwrap();
    let output = Command::new(python).arg("readers.py").current_dir(here).output().unwrap();
    let told = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success() && told.ends_with("all read\n"),
        "{told}{}",
        String::from_utf8_lossy(&output.stderr)
    );
}
