//! A small run: everything that is shown of it, and its folder as it was before.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::SystemTime;

use granum_io::{Case, RunFolder, RunKind};
use granum_run::{Laboratory, NoObserver, Source};

use crate::Served;

const CASE: &str = "[grains]\ncount = 60\n[preparation]\nfriction = 0.1\nsolid_fraction = \"none\"\ninertial_number = 1e-2\n\
                    unbalanced_force = 2e-2\n[shear]\ndeviator_strain = 0.01\ninertial_number = 1e-2\n[recording]\nstates = 4\n\
                    observations_per_state = 2\n";

/// A run of 60 grains, which takes a part of a second.
pub fn small_run(place: &Path, seed: u64) {
    let mut case = Case::parse(CASE, "case").unwrap();
    case.preparation.seed = seed;
    let folder = RunFolder::create(place, false).unwrap();
    Laboratory::here().run(RunKind::Test, &case, &Source::Case, &folder, &mut NoObserver).unwrap();
}

/// Names, sizes, times and contents of all files and folders.
fn tree(folder: &Path) -> BTreeMap<String, (SystemTime, Vec<u8>)> {
    let mut found = BTreeMap::new();
    let mut left = vec![folder.to_path_buf()];
    while let Some(path) = left.pop() {
        let about = path.metadata().unwrap();
        let content = if about.is_dir() { Vec::new() } else { std::fs::read(&path).unwrap() };
        found.insert(path.to_string_lossy().into_owned(), (about.modified().unwrap(), content));
        if about.is_dir() {
            left.extend(std::fs::read_dir(&path).unwrap().map(|entry| entry.unwrap().path()));
        }
    }
    found
}

#[test]
fn a_run_is_shown_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    small_run(&root.join("a run"), 1);
    small_run(&root.join("second"), 2);
    let before = tree(root);
    let served = Served::new(root);
    let get = |target: &str| {
        let (status, content) = served.get(target);
        assert_eq!(status, 200, "{target}: {content}");
        content
    };
    let list: serde_json::Value = serde_json::from_str(&get("/api/folder?order=name")).unwrap();
    assert_eq!((list["total"].as_u64(), list["rows"][0]["path"].as_str()), (Some(2), Some("a run")));
    assert_eq!(
        (list["rows"][0]["status"].as_str(), list["rows"][0]["grains"].as_u64()),
        (Some("finished"), Some(60))
    );
    assert!(get("/api/folder?filter=SEC&kind=run").contains("\"total\":1"));
    let run: serde_json::Value = serde_json::from_str(&get("/api/run?path=a%20run")).unwrap();
    assert_eq!(run["progress"]["status"], "finished");
    assert!(run["measures"].as_array().unwrap().iter().any(|m| m["name"] == "peak_stress_ratio"), "{run}");
    assert!(run["presented"]["tiles"].to_string().contains("quality checks passed"), "{run}");
    assert!(run["presented"]["checks"].as_array().unwrap().len() > 5, "{run}");
    assert!(
        run["columns"].as_array().unwrap().iter().any(|c| c["name"] == "mean_stress" && c["unit"] == "Pa")
    );
    assert!(run["commands"][0]["command"].as_str().unwrap().contains("a run'"), "{run}");
    assert!(get("/api/progress?path=second").contains("\"share\":1.0"));
    let figures: serde_json::Value = serde_json::from_str(&get("/api/figures?path=a+run")).unwrap();
    let figures = figures["figures"].as_array().unwrap().clone();
    assert!(figures.len() > 3);
    for figure in &figures {
        let name = figure["name"].as_str().unwrap();
        assert!(
            figure["caption"].as_str().unwrap().starts_with("Figure S")
                && !figure["title"].as_str().unwrap().is_empty()
        );
        let svg = get(&format!("/api/figure?path=a+run&name={name}"));
        assert!(svg.contains("<svg") && !svg.contains("<script"), "{name}");
    }
    assert_eq!(served.get("/api/figure?path=second&name=nothing").0, 404);
    let both = "path=a%20run&path=second";
    assert!(get(&format!("/api/compare?{both}")).contains("preparation.seed"));
    assert!(get(&format!("/api/figures?{both}")).contains("Figure S1"));
    let snapshot = run["snapshots"][0].as_str().unwrap();
    assert!(get(&format!("/api/grains?path=second&snapshot={snapshot}")).contains("\"grains\":60"));
    assert_eq!(served.get("/api/grains?path=second&snapshot=../x").0, 404);
    assert_eq!(served.get("/api/families").0, 200);
    drop(served);
    assert!(before == tree(root), "a file was changed, made or removed");
}

/// A run that was killed in a line of `states.jsonl`: the whole lines count, and numbers that are none stay apart.
#[test]
fn a_damaged_run_is_an_error_and_no_end_of_the_server() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("empty", ""), ("list", "[]"), ("deep", &"[".repeat(100_000) as &str)] {
        std::fs::create_dir(folder.path().join(name)).unwrap();
        std::fs::write(folder.path().join(name).join("run.json"), text).unwrap();
    }
    let served = Served::new(folder.path());
    assert!(served.get("/api/folder").1.matches("damaged").count() == 3);
    for name in ["empty", "list", "deep"] {
        let (status, content) = served.get(&format!("/api/figures?path={name}"));
        assert!(
            status == 200 && content.contains("\"figures\":[]") && content.contains("run.json"),
            "{content}"
        );
        for route in ["run", "progress", "compare"] {
            let (status, content) = served.get(&format!("/api/{route}?path={name}"));
            assert_eq!(status, 422, "{route} {name}: {content}");
            let root = folder.path().canonicalize().unwrap();
            assert!(
                content.contains("error") && (folder.path() != root || content.contains(name)),
                "{content}"
            );
        }
    }
}
