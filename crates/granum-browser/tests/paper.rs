//! The mappings of the paper as a page asks for them.

use std::path::Path;

use granum_browser::{ENGINE, Page, SURROGATES};
use serde_json::{Value, json};

fn call(page: &mut Page, message: Value) -> Value {
    let answer: Value = serde_json::from_str(&page.answer(&message.to_string())).unwrap();
    assert!(answer.get("error").is_none(), "{answer}");
    answer
}

fn fault(page: &mut Page, message: Value) -> String {
    let answer: Value = serde_json::from_str(&page.answer(&message.to_string())).unwrap();
    answer["error"]["message"].as_str().unwrap_or_else(|| panic!("{answer}")).to_string()
}

/// The result of a small test of the paper with softer grains.
fn run_of(seed: u32) -> Value {
    let gallery = Path::new(env!("CARGO_MANIFEST_DIR")).join("../granum/gallery/paper.toml");
    let case = std::fs::read_to_string(gallery).unwrap();
    let values = json!({
        "grains.count": "60", "grains.material.youngs_modulus": "100 MPa", "shear.inertial_number": "5e-3",
        "preparation.inertial_number": "5e-3", "preparation.seed": seed.to_string(),
    });
    let mut page = Page::new(ENGINE);
    let case = call(&mut page, json!({ "call": "with", "case": case, "values": values }))["case"].clone();
    call(&mut page, json!({ "call": "begin", "case": case }));
    while call(&mut page, json!({ "call": "go_on", "milliseconds": 1000 }))["status"] == "running" {}
    let result = call(&mut page, json!({ "call": "result", "assemblies": false }));
    json!({ "name": format!("seed {seed}"), "result": result })
}

#[test]
fn the_networks_of_a_mapping_learn_from_runs_and_answer_beside_others() {
    let runs: Vec<Value> = (1..=4).map(run_of).collect();
    let mut page = Page::new(SURROGATES);
    let known = call(&mut page, json!({ "call": "mappings" }));
    assert_eq!(known["mappings"][2]["formula"], "q/p = F3(ε_d, φ_d, P(f))");
    assert_eq!(known["mappings"][2]["networks"][1]["hidden"], json!([50, 50]));
    let asked = |run: &str, strain: f64, values: Value| json!({ "call": "ask_mapping", "run": run, "strain": strain, "values": values });
    assert!(fault(&mut page, asked("seed 4", 0.1, json!({}))).contains("no mapping is trained"));

    let training = json!({ "call": "train_mapping", "mapping": "F3", "neurons": 4, "training": runs[..2], "unseen": runs[2..] });
    let trained = call(&mut page, training.clone());
    // The same runs give the same networks.
    assert_eq!(call(&mut page, training)["errors"], trained["errors"]);
    assert_eq!(trained["runs"], json!(["seed 1", "seed 2", "seed 3", "seed 4"]));
    assert_eq!(
        (trained["training_states"].as_u64(), trained["unseen_states"].as_u64()),
        (Some(120), Some(240))
    );
    let error = |name: &str| trained["errors"][name].as_f64().unwrap();
    assert!(error("networks") < error("strain_only"), "{}", trained["errors"]);
    assert!(trained["summary"].as_str().unwrap().contains("relative RMSE"));
    assert!(trained["figure"].as_str().unwrap().contains("<svg"));
    let names: Vec<&str> =
        trained["inputs"].as_array().unwrap().iter().map(|one| one["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["deviator_strain", "deviator_fabric"]);

    let own = call(&mut page, asked("seed 4", 0.12, json!({})));
    let other = call(&mut page, asked("seed 3", 0.12, json!({})));
    assert_eq!((own["strain"].as_f64(), own["network"].as_u64()), (Some(0.12), Some(2)));
    // The strain alone says the same of both, the sensors do not.
    assert_eq!(own["strain_only"], other["strain_only"]);
    assert_ne!(own["networks"], other["networks"]);
    assert_eq!(own["measured"].as_array().unwrap().len(), 1);
    let far = call(&mut page, asked("seed 4", 0.12, json!({ "deviator_fabric": 0.6 })));
    assert_eq!(far["inputs"][1]["value"], 0.6);
    assert!(
        far["outside"] == true && own["outside"] == false && far["networks"] != own["networks"],
        "{far} {own}"
    );
    assert!(fault(&mut page, asked("seed 9", 0.1, json!({}))).contains("there is no run \"seed 9\""));

    // A mapping whose output is a histogram answers with a value for each bin.
    let training = json!({ "call": "train_mapping", "mapping": "F4", "neurons": 2, "training": runs[..1], "unseen": runs[3..] });
    let forces = call(&mut page, training)["forces"].as_array().unwrap().len();
    let answer = call(&mut page, asked("seed 4", 0.2, json!({})));
    for which in ["networks", "strain_only", "measured"] {
        assert_eq!(answer[which].as_array().unwrap().len(), forces, "{which}");
    }
}

#[test]
fn what_is_no_mapping_or_no_run_is_refused() {
    let mut page = Page::new(SURROGATES);
    let train = |mapping: &str, training: Value| json!({ "call": "train_mapping", "mapping": mapping, "training": training, "unseen": [] });
    assert!(fault(&mut page, train("F7", json!([]))).contains("there are: F1, F2"));
    assert!(fault(&mut page, train("F3", json!([]))).contains("there is no training run"));
    assert!(fault(&mut page, train("F3", json!(3))).contains("needs a list \"training\""));
    assert!(
        fault(&mut page, train("F3", json!([{ "name": "a", "result": 3 }]))).contains("no result of a run")
    );
}
