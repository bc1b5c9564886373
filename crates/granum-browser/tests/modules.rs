//! What the modules answer, on this processor: the digests with which those of browsers are compared (`scripts/page`).

use std::path::{Path, PathBuf};

use granum_browser::{ENGINE, Page, SURROGATES};
use serde_json::{Value, json};

fn crates() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(name: &str) -> String {
    std::fs::read_to_string(crates().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn call(page: &mut Page, message: Value) -> Value {
    let answer: Value = serde_json::from_str(&page.answer(&message.to_string())).unwrap();
    assert!(answer.get("error").is_none(), "{answer}");
    answer
}

fn kept_case(name: &str) -> String {
    read(&format!("granum/tests/end_to_end/sixteen_cases/{name}.toml"))
}

/// A page whose run of a kept case is complete.
fn run_of(name: &str) -> Page {
    let mut page = Page::new(ENGINE);
    call(&mut page, json!({ "call": "begin", "case": kept_case(name) }));
    let mut pieces = 0;
    while call(&mut page, json!({ "call": "go_on", "milliseconds": 1 }))["status"] == "running" {
        pieces += 1;
    }
    assert!(pieces > 1);
    page
}

#[test]
fn a_run_has_the_digest_of_the_program() {
    for name in ["drained-triaxial", "grains-of-three-shapes"] {
        let digest = call(&mut run_of(name), json!({ "call": "digest" }))["digest"].clone();
        let line = format!("{}  {name}\n", digest.as_str().unwrap());
        assert!(read("granum/tests/end_to_end/sixteen_cases/digests.txt").contains(&line), "{line}");
    }
}

/// A sample is prepared in stretches of 500 steps. A piece may end within one, so that a page can draw in the meantime.
#[test]
fn a_piece_ends_within_a_stretch_of_the_preparation() {
    let mut page = Page::new(ENGINE);
    call(&mut page, json!({ "call": "begin", "case": kept_case("drained-triaxial") }));
    let answer = call(&mut page, json!({ "call": "go_on", "milliseconds": 0 }));
    let steps = answer["steps"]["prepare"].as_u64().unwrap();
    assert!(0 < steps && steps < 500, "{answer}");
}

/// Keeps its digests in `digests.txt`, which a test of the modules in a browser reads as well.
#[test]
fn predictions_and_a_training_keep_their_bits() {
    let mut digests = String::new();
    let mut page = Page::new(SURROGATES);
    for family in ["powder", "sand", "shaped-sand"] {
        let folder = crates().join("granum/families").join(family);
        let mut paths: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .filter(|name| name.ends_with(".json"))
            .collect();
        paths.sort();
        for path in paths {
            let name = format!("{family}/{path}");
            let text = read(&format!("granum/families/{name}"));
            let loaded = call(&mut page, json!({ "call": "load_family", "name": name, "text": text }));
            assert_eq!(loaded["name"], family);
            let digest = call(&mut page, json!({ "call": "digest_of_predictions", "name": name }));
            digests += &format!("{}  {name}\n", digest["digest"].as_str().unwrap());
        }
    }
    let result = call(&mut run_of("drained-triaxial"), json!({ "call": "result" }));
    for method in ["feed-forward", "recurrent", "ridge"] {
        let training = json!({
            "call": "digest_of_training", "method": method, "result": result, "input": "deviator_strain",
            "output": "stress_ratio",
        });
        let digest = call(&mut page, training);
        digests += &format!("{}  {method}\n", digest["digest"].as_str().unwrap());
    }
    assert_eq!(digests, read("granum-browser/tests/digests.txt"), "digests.txt should be\n{digests}");
}

/// The parts of a text as the HTML of a report.
fn marked_up(parts: &Value) -> String {
    let part = |part: &Value| {
        let (text, kinds) = (part[0].as_str().unwrap(), part[1].as_str().unwrap());
        let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
        let wrap = |text: String, kind: &str| {
            if kind.is_empty() { text } else { format!("<{kind}>{text}</{kind}>") }
        };
        kinds.split(' ').rev().fold(text, wrap)
    };
    parts.as_array().unwrap().iter().map(part).collect()
}

#[test]
fn a_result_becomes_a_report() {
    let mut engine = run_of("drained-triaxial");
    let view = call(&mut engine, json!({ "call": "view", "strongest": 100 }));
    assert_eq!(view["contacts"], 100);
    let csv = call(&mut engine, json!({ "call": "series" }))["csv"].as_str().unwrap().to_string();
    let states = call(&mut engine, json!({ "call": "states", "from": 2 }));
    assert_eq!(states["rows"].as_array().unwrap().len() + 2, csv.trim().lines().count() - 1);
    let result = call(&mut engine, json!({ "call": "result" }));
    let mut surrogates = Page::new(SURROGATES);
    let report = call(&mut surrogates, json!({ "call": "report", "result": result, "name": "drained" }));
    let html = report["html"].as_str().unwrap();
    // What the page says beside the test is what the report says first, word by word.
    let presented =
        call(&mut surrogates, json!({ "call": "presented", "result": result, "name": "drained" }));
    let (mut texts, checks) = (Vec::new(), presented["checks"].as_array().unwrap());
    texts.extend(presented["tiles"].as_array().unwrap().iter().flat_map(|tile| tile.as_array().unwrap()));
    texts.extend(checks.iter().flat_map(|check| [&check["name"], &check["value"], &check["after"]]));
    texts.extend(
        presented["strength"]["rows"].as_array().unwrap().iter().flat_map(|row| row.as_array().unwrap()),
    );
    assert!(checks.len() > 5 && texts.len() > 30);
    for text in texts.into_iter().chain([&presented["verdict"], &presented["signs"]]) {
        assert!(html.contains(&marked_up(text)), "{text} is not in the report");
    }
    assert!(!report["figures"].as_array().unwrap().is_empty());
}

#[test]
fn mistakes_in_a_case_have_their_places() {
    let mut page = Page::new(ENGINE);
    let message = json!({ "call": "check", "case": "[grains]\ncount = 100\ndiametre = '1 mm'\n" });
    let answer: Value = serde_json::from_str(&page.answer(&message.to_string())).unwrap();
    let place = &answer["error"]["places"][0];
    assert_eq!((place["line"].as_u64(), place["column"].as_u64()), (Some(3), Some(1)), "{answer}");
    assert!(place["message"].as_str().unwrap().contains("diametre"), "{answer}");
    let good = call(&mut page, json!({ "call": "check", "case": kept_case("simple-shear") }));
    assert_eq!(good["digest"].as_str().unwrap().len(), 64);
}

#[test]
fn a_message_that_is_none_is_refused_by_name() {
    let mut page = Page::new(ENGINE);
    for (message, said) in [
        ("{", "no message in JSON"),
        (r#"{"call": "fly"}"#, "there is no call \"fly\"; known are about"),
        (r#"{"call": "begin"}"#, "needs a text \"case\""),
        (r#"{"call": "go_on"}"#, "there is no run"),
        (r#"{"call": "predict"}"#, "there is no call \"predict\""),
    ] {
        assert!(page.answer(message).contains("error"), "{message}");
        let answer: Value = serde_json::from_str(&page.answer(message)).unwrap();
        assert!(answer["error"]["message"].as_str().unwrap().contains(said), "{answer}");
    }
    let mut page = Page::new(SURROGATES);
    assert!(page.answer(r#"{"call": "load_family", "name": "x", "text": "{}"}"#).contains("error"));
    assert!(page.answer(r#"{"call": "predict", "name": "x"}"#).contains("is not loaded"));
    assert!(page.answer(r#"{"call": "report", "result": 3}"#).contains("no result of a run"));
}

#[test]
fn the_case_of_a_family_is_tested_over_its_prediction() {
    let mut surrogates = Page::new(SURROGATES);
    let name = "powder/oedometer.json";
    let text = read(&format!("granum/families/{name}"));
    let family = call(&mut surrogates, json!({ "call": "load_family", "name": name, "text": text }));
    let values: serde_json::Map<String, Value> = (family["inputs"].as_array().unwrap().iter())
        .filter(|input| input["required"] == true)
        .map(|input| {
            let range: Vec<f64> =
                input["range"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
            (input["name"].as_str().unwrap().to_string(), json!(0.5 * (range[0] + range[1])))
        })
        .collect();
    let ready = read(&format!("granum/gallery/{}.toml", family["case"].as_str().unwrap()));
    let case =
        call(&mut surrogates, json!({ "call": "case_of", "name": name, "values": values, "ready": ready }));
    let mut engine = Page::new(ENGINE);
    let fewer = json!({ "call": "with", "case": case["case"], "values": { "grains.count": "60" } });
    let fewer = call(&mut engine, fewer);
    assert_eq!(call(&mut engine, json!({ "call": "check", "case": fewer["case"] }))["grains"], 60);
    call(&mut engine, json!({ "call": "begin", "case": fewer["case"] }));
    // A test under way, whose curves end before those of the prediction.
    while call(&mut engine, json!({ "call": "go_on", "milliseconds": 1 }))["states"].as_u64().unwrap() < 4 {}
    let result = call(&mut engine, json!({ "call": "result", "assemblies": false }));
    assert!(result["start"].is_null() && result["states"].as_array().unwrap().len() >= 4);
    let asked = json!({ "call": "predict", "name": name, "values": values });
    let alone = call(&mut surrogates, asked.clone());
    let mut over = asked;
    over["result"] = result;
    let over = call(&mut surrogates, over);
    assert_eq!(alone["curves"], over["curves"]);
    let drawn = |answer: &Value| answer["figure"].as_str().unwrap().contains("this test");
    assert!(drawn(&over) && !drawn(&alone));
}

#[test]
fn curves_of_runs_are_a_figure() {
    let mut page = Page::new(SURROGATES);
    let curve = |name: &str| json!({ "name": name, "points": [[0.0, 0.0], [0.1, 1.2]] });
    let panels =
        json!([{ "x": "axial strain", "y": "stress ratio", "curves": [curve("seed 1"), curve("seed 2")] }]);
    let figure = call(&mut page, json!({ "call": "curves", "panels": panels }));
    let svg = figure["figure"].as_str().unwrap();
    assert!(
        ["<svg", "axial strain", "stress ratio", "seed 1", "seed 2"].iter().all(|word| svg.contains(word))
    );
    assert!(page.answer(r#"{"call": "curves", "panels": 3}"#).contains("no panels of a figure"));
}
