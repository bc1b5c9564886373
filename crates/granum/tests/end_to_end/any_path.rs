//! The section "Any path" of the chapter on surrogates, with smaller samples and shorter paths.

use std::path::Path;

use crate::{done, done_json, refused};

/// Makes a plan small: fewer and smaller runs on shorter paths, which are faster than its checks allow.
fn shrink(here: &Path, plan: &str, points: &str, length: [&str; 2]) {
    let file = here.join(format!("{plan}.toml"));
    let text = std::fs::read_to_string(&file).unwrap();
    let lines = text.lines().map(|line| match line {
        line if line.starts_with("points = ") => format!("points = {points}"),
        "grains.count = 300" => "grains.count = 80\nstage.1.inertial_number = 1e-2".into(),
        "from = 0.1" | "from = 2" => format!("from = {}", length[0]),
        "to = 0.2" | "to = 2.001" => format!("to = {}", length[1]),
        line => line.to_string(),
    });
    let accepted = "accept = ['inertial_number < 1', 'servo_error_rms < 1', 'servo_error_largest < 10', 'unbalanced_force < 10', \
                    'energy_gap < 1', 'sample_unbalanced_force < 1', 'largest_overlap < 1']\n";
    let text = lines.collect::<Vec<_>>().join("\n").replacen("[set]", &format!("{accepted}\n[set]"), 1);
    std::fs::write(file, text).unwrap();
}

#[test]
fn surrogates_of_any_path_are_learned_and_judged() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    for (plan, folder, points, length) in [
        ("random-paths", "paths", "8", ["0.03", "0.04"]),
        ("random-paths-unseen", "unseen", "4", ["0.03", "0.04"]),
        ("random-paths-cycles", "cycles", "1", ["0.05", "0.051"]),
    ] {
        done(here, &["init", "--plan", plan, "--force"]);
        shrink(here, plan, points, length);
        done(here, &["campaign", &format!("{plan}.toml"), "--out", folder]);
    }
    let asked = ["examine", "paths", "paths", "--unseen", "unseen", "--long", "cycles", "--method"];
    let methods = [
        "path-gru:networks=2,epochs=2,rotations=1",
        "path-tensor:networks=2,epochs=6",
        "path-tensor:networks=1,epochs=6,internal=0",
    ];
    let answers = &done_json(here, &[&asked[..], &methods].concat())["answers"];
    let errors = answers["errors"].as_array().unwrap();
    let of = |method: &str, kind: &str, quantity: &str| {
        let is = |own: &&serde_json::Value| {
            own["method"] == method && own["kind"] == kind && own["quantity"] == quantity
        };
        let found = errors.iter().find(is);
        found.unwrap_or_else(|| panic!("{method} {kind} {quantity}"))["error"]["relative"].as_f64().unwrap()
    };
    for kind in ["all", "random", "cyclic", "mixed", "monotonic"] {
        for method in methods.into_iter().chain(["first state", "another sample"]) {
            assert!((0.01..5.0).contains(&of(method, kind, "stress deviator")), "{method} {kind}");
        }
    }
    // The mean of the training states knows nothing of the path.
    let mean = of("mean of the training states", "all", "volumetric strain");
    assert!((mean - 1.0).abs() < 1e-9, "{mean}");
    let work = answers["work"].as_array().unwrap();
    assert_eq!(work.len(), 2 + methods.len());
    assert_eq!(
        (&work[0]["method"], &work[0]["negative"], &work[0]["error"]),
        (&"simulation".into(), &0.into(), &0.0.into())
    );
    assert_eq!(answers["drift"].as_array().unwrap().len(), 4 * methods.len());
    // Whether intervals hold is told of the methods that have some: one network alone has none.
    let intervals = answers["intervals"].as_array().unwrap();
    let held =
        |method: &str| intervals.iter().filter(|own| own["method"] == method && own["kind"] == "all").count();
    assert_eq!(methods.map(held), [4, 4, 0]);
    assert!(intervals.iter().all(|own| (0.0..=1.0).contains(&own["held"].as_f64().unwrap())));
    assert!(!answers["intervals_of_long"].as_array().unwrap().is_empty());
    // The tables in words, from the same program again, are the same for any number of threads.
    let words = |threads: &str| {
        let more = ["path-tensor:networks=2,epochs=2", "--threads", threads];
        done(here, &[&asked[..5], &["--method"], &more].concat())
    };
    let told = words("1");
    assert!(
        told.contains("coordination number")
            && told.contains("states within their intervals, % (intervals of 90 %)"),
        "{told}"
    );
    assert_eq!(told, words("2"));
    let refusal =
        refused(here, 1, &["examine", "paths", "paths", "--unseen", "unseen", "--method", "path-gru:size=3"]);
    assert!(refusal.contains("`size=3` is no setting"), "{refusal}");
    let refusal = refused(
        here,
        1,
        &["examine", "paths", "paths", "--unseen", "unseen", "--method", "path-gru:rate=nan"],
    );
    assert!(refusal.contains("`rate=nan`: it must be above 0 and at most 1"), "{refusal}");
}

/// The plan sand-step with small samples and short paths: the volume is an input, the mean stress is learned, and the surrogate is kept in a file.
#[test]
fn a_surrogate_to_which_the_volume_is_an_input_is_judged_and_kept() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    done(here, &["init", "--plan", "sand-step"]);
    let file = here.join("sand-step.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    let accepted = "accept = ['inertial_number < 10', 'servo_error_rms < 10', 'servo_error_largest < 100', 'unbalanced_force < 10', \
                    'energy_gap < 1', 'sample_unbalanced_force < 1', 'largest_overlap < 1']";
    let lines = text.lines().map(|line| match line {
        line if line.starts_with("accept = ") => accepted,
        line if line.starts_with("points = ") => "points = 12",
        "grains.count = 1000" => "grains.count = 80\nstage.1.inertial_number = 1e-2",
        "from = 0.06" => "from = 0.02",
        "to = 0.18" => "to = 0.03",
        line => line,
    });
    std::fs::write(&file, lines.collect::<Vec<_>>().join("\n")).unwrap();
    done(here, &["campaign", "sand-step.toml", "--out", "runs"]);
    let asked =
        ["examine", "paths", "runs", "--unseen-share", "0.25", "--volume-is-input", "--model", "step.json"];
    let asked =
        [&asked[..], &["--property", "grains.material.friction", "contact.rolling_friction"]].concat();
    let method = ["--method", "path-tensor:networks=2,epochs=4"];
    let answers = &done_json(here, &[&asked[..], &method].concat())["answers"];
    let quantities: Vec<&str> =
        answers["errors"].as_array().unwrap().iter().map(|own| own["quantity"].as_str().unwrap()).collect();
    assert!(quantities.contains(&"logarithm of mean stress") && !quantities.contains(&"volumetric strain"));
    let kinds: Vec<&str> =
        answers["errors"].as_array().unwrap().iter().map(|own| own["kind"].as_str().unwrap()).collect();
    assert!(["drained", "undrained", "moving"].iter().any(|kind| kinds.contains(kind)), "{kinds:?}");
    let text = std::fs::read_to_string(here.join("step.json")).unwrap();
    let model: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(model["method"], "path-tensor");
    assert!(text.contains("\"offset\""), "the mean stress is seen by its logarithm");
    // It is not overwritten, and one file holds one surrogate.
    let told = refused(here, 1, &[&asked[..], &method].concat());
    assert!(told.contains("step.json"), "{told}");
    let told = refused(here, 1, &[&asked[..], &["--force", "--method", "path-gru", "path-tensor"]].concat());
    assert!(told.contains("--model takes the surrogate of one method, and --method names 2"), "{told}");
}
