//! `granum serve`: what is in a folder, as the page asks for it.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant, SystemTime};

use serde_json::Value;

use crate::{done, json, refused};

/// A case of a few tenths of a second.
const TINY: &str = "[grains]\ncount = 60\n[preparation]\nfriction = 0.1\nsolid_fraction = \"none\"\ninertial_number = 1e-2\n\
                    unbalanced_force = 2e-2\n[shear]\ndeviator_strain = 0.02\ninertial_number = 1e-2\n[recording]\nstates = 6\n\
                    observations_per_state = 2\n";
const PLAN: &str = "case = \"case.toml\"\naccept = [\"inertial_number < 1\", \"unbalanced_force < 1\", \"servo_error_rms < 1\"]\n[design]\n\
                    kind = \"full-factorial\"\n[[variable]]\nname = \"friction\"\nkey = \"grains.material.friction\"\nvalues = [0.2, 0.5]\n";

/// A folder that is served.
struct Page {
    child: Child,
    port: u16,
    token: String,
}

impl Page {
    fn new(folder: &Path, arguments: &[&str]) -> Page {
        let mut child = Command::new(env!("CARGO_BIN_EXE_granum"))
            .arg("serve")
            .args(arguments)
            .args(["--port", "0"])
            .current_dir(folder)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
        let address = lines.find(|line| line.contains("http://")).unwrap();
        let rest = address.trim().strip_prefix("http://127.0.0.1:").unwrap();
        let (port, token) = rest.split_once("/?token=").unwrap();
        Page { child, port: port.parse().unwrap(), token: token.to_string() }
    }

    fn get(&self, target: &str) -> (u16, String) {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        let (port, token) = (self.port, &self.token);
        let head = format!(
            "GET {target} HTTP/1.0\r\nHost: 127.0.0.1:{port}\r\nAuthorization: Bearer {token}\r\n\r\n"
        );
        stream.write_all(head.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        let (head, content) = answer.split_once("\r\n\r\n").unwrap();
        (head.split(' ').nth(1).unwrap().parse().unwrap(), content.to_string())
    }

    fn data(&self, target: &str) -> Value {
        let (status, content) = self.get(target);
        assert_eq!(status, 200, "{target}: {content}");
        json(&content)
    }

    /// Ends it as Ctrl-C does.
    fn end(self) -> Output {
        signal(&self.child, "-INT");
        self.child.wait_with_output().unwrap()
    }
}

fn signal(child: &Child, signal: &str) {
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
}

fn tree(folder: &Path) -> BTreeMap<String, (SystemTime, Vec<u8>)> {
    let (mut found, mut left) = (BTreeMap::new(), vec![folder.to_path_buf()]);
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
fn everything_in_a_folder_is_shown_and_nothing_is_written() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), TINY).unwrap();
    std::fs::write(here.join("plan.toml"), PLAN).unwrap();
    done(here, &["run", "case.toml", "--out", "all/runs/a run"]);
    done(here, &["run", "case.toml", "--set", "preparation.seed=2", "--out", "all/runs/b"]);
    done(here, &["campaign", "plan.toml", "--out", "all/campaign"]);
    let study = [
        "--input",
        "solid_fraction",
        "--output",
        "stress_ratio",
        "--coordinate",
        "deviator_strain",
        "--method",
        "ridge",
    ];
    done(here, &[&["train", "all/runs/a run", "all/runs/b", "--out", "all/study"], &study[..]].concat());
    let before = tree(&here.join("all"));
    let page = Page::new(here, &["all"]);
    let list = page.data("/api/folder");
    assert_eq!(list["counts"]["run"], 2, "{list}");
    assert_eq!((&list["counts"]["campaign"], &list["counts"]["study"]), (&Value::from(1), &Value::from(1)));
    let run = page.data("/api/run?path=runs/a%20run");
    assert_eq!(run["progress"]["status"], "finished");
    let commands = run["commands"].to_string();
    assert!(
        commands.contains("granum report 'all/runs/a run'")
            && !commands.contains(base.path().to_str().unwrap())
    );
    for target in ["path=runs/a%20run", "path=runs/a%20run&path=runs/b", "path=campaign"] {
        let figures = page.data(&format!("/api/figures?{target}"));
        let first = figures["figures"][0]["name"].as_str().unwrap_or_else(|| panic!("{target}: {figures}"));
        assert!(page.get(&format!("/api/figure?{target}&name={first}")).1.contains("<svg"));
    }
    let campaign = page.data("/api/campaign?path=campaign");
    assert_eq!((&campaign["total"], campaign["is_done"].as_bool()), (&Value::from(2), Some(true)));
    let quantities = page.data("/api/quantities?path=campaign").to_string();
    assert!(
        quantities.contains("grains.material.friction") && quantities.contains("peak_stress_ratio"),
        "{quantities}"
    );
    let map = page.data("/api/map?path=campaign&x=grains.material.friction&y=peak_stress_ratio");
    let point = &map["points"][1];
    assert!(point["left"].as_f64().unwrap() > map["points"][0]["left"].as_f64().unwrap(), "{map}");
    assert_eq!(page.get(&format!("/api/run?path={}", point["path"].as_str().unwrap())).0, 200);
    assert_eq!(page.get("/api/map?path=campaign&x=nothing&y=peak_stress_ratio").0, 404);
    assert_eq!(page.data("/api/figures?path=study")["remarks"], Value::Array(Vec::new()));
    let study = page.data("/api/study?path=study");
    assert!(
        study["scores"][0]["training"].is_number() && study["models"].as_array().unwrap().len() > 1,
        "{study}"
    );
    let asked = page.data("/api/surrogate?path=study");
    assert_eq!(asked["model"], "stress_ratio-ridge");
    let range = &asked["inputs"][0]["range"];
    assert!(range[0].as_f64().unwrap() < range[1].as_f64().unwrap(), "{asked}");
    let names: Vec<&str> =
        asked["inputs"].as_array().unwrap().iter().map(|i| i["name"].as_str().unwrap()).collect();
    let set: Vec<String> = names.iter().map(|name| format!("set.{name}=0.01")).collect();
    let predicted = page.data(&format!("/api/predict?path=study&along=deviator_strain&{}", set.join("&")));
    assert!(
        predicted["outputs"][0]["mean"].is_number() && predicted["svg"].as_str().unwrap().contains("<svg")
    );
    let command = predicted["commands"][0]["command"].as_str().unwrap();
    let words: Vec<&str> = command.split(' ').skip(1).collect();
    assert!(done(here, &words).contains("stress_ratio = "), "{command}");
    assert!(!page.data("/api/families")["families"].as_array().unwrap().is_empty());
    let curves =
        page.data("/api/predict-family?family=sand&along=drained-triaxial&--friction=0.4&--pressure=100+kPa");
    assert!(
        curves["svg"].as_str().unwrap().contains("<svg") && curves["curves"].as_array().unwrap().len() > 3
    );
    let command = curves["commands"][0]["command"].as_str().unwrap();
    assert_eq!(
        command,
        "granum predict --family sand --path drained-triaxial --friction 0.4 --pressure '100 kPa' -o curves.svg"
    );
    let (status, told) = page.get("/api/predict-family?family=sand&--friction=0.4+kPa");
    assert!(status == 400 && told.contains("friction"), "{told}");
    let ended = page.end();
    assert_eq!(ended.status.code(), Some(0), "{ended:?}");
    assert!(String::from_utf8_lossy(&ended.stderr).contains("all is no longer shown"), "{ended:?}");
    assert!(before == tree(&here.join("all")), "a file was changed, made or removed");
}

/// A run that is under way is followed by `states.jsonl`, and its curves grow.
#[test]
fn the_progress_of_a_run_is_live() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let long = TINY
        .replace("deviator_strain = 0.02", "deviator_strain = 0.5")
        .replace("states = 6", "states = 2000");
    std::fs::write(here.join("case.toml"), long).unwrap();
    let page = Page::new(here, &[]);
    let run = Command::new(env!("CARGO_BIN_EXE_granum"))
        .args(["run", "case.toml", "--out", "run", "--json"])
        .current_dir(here)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let states = |least: u64| {
        let begun = Instant::now();
        loop {
            let (status, content) = page.get("/api/progress?path=run");
            let states = if status == 200 { json(&content)["states"].as_u64().unwrap() } else { 0 };
            if states >= least {
                return json(&content);
            }
            assert!(begun.elapsed() < Duration::from_secs(60), "{content}");
            std::thread::sleep(Duration::from_millis(20));
        }
    };
    let first = states(2);
    assert_eq!(
        (first["status"].as_str(), first["at_work"].as_bool()),
        (Some("running"), Some(true)),
        "{first}"
    );
    assert!(first["share"].as_f64().unwrap() < 1.0, "{first}");
    let later = states(first["states"].as_u64().unwrap() + 3);
    assert!(later["deviator_strain"].as_f64() > first["deviator_strain"].as_f64(), "{later}");
    assert!(!page.data("/api/figures?path=run")["figures"].as_array().unwrap().is_empty());
    signal(&run, "-INT");
    let mut run = run;
    run.wait().unwrap();
    let status = page.data("/api/progress?path=run");
    assert_eq!(status["status"], "interrupted", "{status}");
    assert_eq!(page.end().status.code(), Some(0));
}

#[test]
fn mistakes_are_named() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    assert!(refused(here, 1, &["serve", "nothing"]).contains("nothing: there is no such folder"));
    std::fs::write(here.join("case.toml"), "").unwrap();
    assert!(refused(here, 1, &["serve", "case.toml"]).contains("case.toml: this is a file"));
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let told = refused(here, 1, &["serve", "--port", &port]);
    assert!(told.contains(&port) && told.contains("--port 0"), "{told}");
    assert!(refused(here, 2, &["serve", "--address", "example.org"]).contains("--address"));
}
