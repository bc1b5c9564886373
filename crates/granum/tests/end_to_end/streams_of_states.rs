//! `granum stream`: states from sensors, line by line, and the same surrogates as ONNX files.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use granum_core::observer::NoObserver;
use granum_core::{Column, Table};
use granum_learn::surrogate::{FeedForward, FitSpec, Recurrent, RidgeRegression, SurrogateMethod, save};
use granum_learn::{Dataset, RunStates};
use granum_nets::trainer::Adam;
use serde_json::{Value, json};

use crate::{done, refused};

const INPUTS: [&str; 2] = ["strain", "pressure"];

/// Writes the files of small surrogates of made-up tests: `recurrent.json`, `ridge.json` and `feed-forward.json`.
fn write_surrogates(here: &Path) {
    let run = |k: usize| {
        let rows = 20 + k;
        let strain: Vec<f64> = (0..rows).map(|state| 0.01 * state as f64).collect();
        let ratio = strain.iter().map(|e| (0.6 + 0.05 * k as f64) * (1.0 - (-30.0 * e).exp()));
        let columns = vec![
            Column::new("strain", "", strain.clone()),
            Column::new("stress_ratio", "", ratio.collect()),
            Column::new("sliding_fraction", "", strain.iter().map(|e| 0.02 + 0.1 * e).collect()),
        ];
        let pressure = 1e5 * (1.0 + 0.2 * k as f64);
        RunStates::new(&format!("run-{k}"), Table::new(columns)?)?.with_parameter("pressure", "Pa", pressure)
    };
    let dataset = Dataset::new((0..5).map(run).collect::<granum_learn::Result<_>>().unwrap()).unwrap();
    let spec = FitSpec::new(INPUTS, ["stress_ratio", "sliding_fraction"]).with_coordinate("strain");
    let mut recurrent = Recurrent::default();
    recurrent.trainer = Adam { epochs: 20, ..Adam::default() }.into();
    (recurrent.hidden, recurrent.networks) = (5, 2);
    let mut network = FeedForward::default();
    network.hidden = vec![4];
    for method in [&recurrent as &dyn SurrogateMethod, &RidgeRegression::default(), &network] {
        let fitted = method.fit(&dataset, &spec, &mut NoObserver).unwrap();
        save(&here.join(format!("{}.json", method.name())), fitted.as_ref()).unwrap();
    }
}

/// A stream that is asked line by line.
struct Stream {
    child: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
}

impl Stream {
    fn new(here: &Path, arguments: &[&str]) -> Stream {
        let mut command = Command::new(env!("CARGO_BIN_EXE_granum"));
        let command = command.arg("stream").args(arguments).current_dir(here);
        let command = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let (input, output) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
        Stream { child, input, output: BufReader::new(output) }
    }

    /// The answer to a line, which comes before the next one is asked.
    fn asked(&mut self, line: &[u8]) -> Value {
        self.input.write_all(line).and_then(|()| self.input.write_all(b"\n")).unwrap();
        let mut answer = String::new();
        self.output.read_line(&mut answer).unwrap();
        serde_json::from_str(&answer).unwrap_or_else(|error| panic!("{error}: {answer}"))
    }

    /// Ends the input; the exit status and standard error.
    fn ended(self) -> (Option<i32>, String) {
        let Stream { child, input, output } = self;
        drop((input, output));
        let output = child.wait_with_output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    }
}

fn state(k: usize) -> Value {
    json!({ "strain": 0.19 * (0.7 * k as f64).sin().abs(), "pressure": 1.3e5, "sequence": k })
}

/// Each line is answered at once with what `predict` says of the whole run, to the bit.
#[test]
fn states_one_by_one_have_the_predictions_of_the_whole_run() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    write_surrogates(here);
    let states: Vec<Value> = (0..12).map(state).collect();
    let rows: Vec<String> = states.iter().map(|s| format!("{},{}", s["strain"], s["pressure"])).collect();
    std::fs::write(here.join("rows.csv"), format!("strain,pressure\n{}\n", rows.join("\n"))).unwrap();
    for file in ["recurrent.json", "ridge.json", "feed-forward.json"] {
        let table = done(here, &["predict", file, "--input", "rows.csv"]);
        let mut table = table.lines();
        let names: Vec<&str> = table.next().unwrap().split(',').collect();
        let mut stream = Stream::new(here, &[file, "--latency"]);
        for state in &states {
            let answer = stream.asked(state.to_string().as_bytes());
            assert_eq!(answer["sequence"], state["sequence"]);
            for (name, expected) in names.iter().zip(table.next().unwrap().split(',')).skip(2) {
                match *name {
                    "outside" => {
                        assert_eq!(answer["outside"].as_array().unwrap().is_empty(), expected == "0")
                    }
                    name => {
                        assert_eq!(answer[name].as_f64(), expected.parse().ok(), "{file} {name}: {answer}")
                    }
                }
            }
        }
        // A reset begins anew; a surrogate without memory does not mind.
        let first = stream.asked(states[0].to_string().as_bytes());
        assert_eq!(
            stream.asked(br#"{"reset": true, "sequence": "r"}"#),
            json!({ "reset": true, "sequence": "r" })
        );
        let again = stream.asked(states[0].to_string().as_bytes());
        assert_eq!(again == first, file != "recurrent.json", "{first} {again}");
        let (status, text) = stream.ended();
        assert_eq!(status, Some(0), "{text}");
        assert!(text.starts_with("15 lines, microseconds from a line read"), "{text}");
    }
}

#[test]
fn lines_that_cannot_be_answered_leave_no_trace() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    write_surrogates(here);
    let mut plain = Stream::new(here, &["recurrent.json"]);
    let mut disturbed = Stream::new(here, &["recurrent.json"]);
    let damaged: [(&[u8], &str); 14] = [
        (b"", "not an object of JSON"),
        (b"nonsense", "not an object of JSON"),
        (b"[0.1, 1e5]", "not an object of JSON"),
        (b"{\"strain\": 0.1, \"pressure\": NaN}", "not an object of JSON"),
        (b"{\"strain\": 1e999, \"pressure\": 1e5}", "not an object of JSON"),
        (b"{\"strain\": 0.1, \"pressure\": \"\xff\"}", "not an object of JSON"),
        (br#"{"strain": 0.1}"#, "missing: pressure; a state has strain, pressure"),
        (
            br#"{"strain": 0.1, "pressure": null}"#,
            "pressure must be a number or a text with a unit, not null",
        ),
        (br#"{"strain": 0.1, "pressure": "100 m"}"#, "pressure"),
        (br#"{"strain": 0.1, "pressure": "NaN"}"#, "pressure"),
        (br#"{"reset": false}"#, "\"reset\" must be true, not false"),
        (br#"{"reset": true, "strain": 0.1}"#, "stands alone in a line"),
        (br#"{"units": {"pressure": "m"}}"#, "units: pressure"),
        (br#"{"units": {"presure": "kPa"}}"#, "there is no input presure; there are strain, pressure"),
    ];
    for k in 0..damaged.len() {
        let (line, told) = damaged[k];
        let answer = disturbed.asked(line);
        assert!(answer["error"].as_str().unwrap().contains(told), "{answer}");
        assert_eq!(answer["line"], json!(2 * k + 1), "{answer}");
        let state = state(k).to_string();
        assert_eq!(disturbed.asked(state.as_bytes()), plain.asked(state.as_bytes()), "after {told}");
    }
    // The sequence of a line that cannot be answered is given back as well, whatever it is.
    let answer = disturbed.asked(br#"{"sequence": {"step": 3}}"#);
    assert_eq!(answer["sequence"], json!({ "step": 3 }));
    assert_eq!(disturbed.ended().0, Some(0));
    assert_eq!(plain.ended(), (Some(0), String::new()));
    let mut strict = Stream::new(here, &["recurrent.json", "--strict"]);
    assert!(strict.asked(state(1).to_string().as_bytes())["error"].is_null());
    assert!(strict.asked(b"{}")["error"].as_str().unwrap().contains("missing: strain, pressure"));
    let (status, text) = strict.ended();
    assert!(status == Some(1) && text.contains("line 2: missing: strain, pressure"), "{status:?} {text}");
}

#[test]
fn numbers_are_in_the_units_that_are_told() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    write_surrogates(here);
    let mut stream = Stream::new(here, &["ridge.json"]);
    let plain = stream.asked(br#"{"strain": 0.1, "pressure": 128000, "time": "noon"}"#);
    assert_eq!(stream.asked(br#"{"strain": 0.1, "pressure": "128 kPa"}"#), plain);
    assert_eq!(stream.asked(br#"{"units": {"pressure": "kPa"}}"#), json!({ "units": { "pressure": "kPa" } }));
    assert_eq!(stream.asked(br#"{"strain": 0.1, "pressure": 128}"#), plain);
    let outside = stream.asked(br#"{"strain": 0.1, "pressure": 1280}"#);
    assert_eq!(outside["outside"][0]["input"], "pressure", "{outside}");
    assert_eq!(stream.ended().0, Some(0));
}

/// A line of thirty megabytes is refused and none of it is kept; a reader that ends early ends the command without a message.
#[test]
fn long_lines_and_readers_that_end_do_no_harm() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    write_surrogates(here);
    let mut stream = Stream::new(here, &["recurrent.json"]);
    let before = stream.asked(state(1).to_string().as_bytes());
    // Its largest memory so far, in kilobytes.
    let process = format!("/proc/{}/status", stream.child.id());
    let most = || -> Option<u64> {
        let status = std::fs::read_to_string(&process).ok()?;
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
        line.trim().trim_end_matches(" kB").parse().ok()
    };
    let small = most();
    let answer = stream.asked(&vec![b'x'; 30 << 20]);
    assert!(answer["error"].as_str().unwrap().contains("longer than 1048576 bytes"), "{answer}");
    stream.asked(br#"{"reset": true}"#);
    assert_eq!(stream.asked(state(1).to_string().as_bytes()), before);
    if let (Some(small), Some(large)) = (small, most()) {
        assert!(large < small + 8_000, "{small} kB, then {large} kB");
    }
    let Stream { child, mut input, output } = stream;
    drop(output);
    // The answer cannot be written any more.
    let _ = input.write_all(b"{}\n{}\n");
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
}

#[test]
fn surrogates_are_written_as_onnx_or_refused_by_name() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    write_surrogates(here);
    for file in ["recurrent.json", "ridge.json", "feed-forward.json"] {
        let text = done(here, &["export", file, "--to", "onnx", "-o", "model.onnx", "--force"]);
        assert!(text.contains("2 inputs, 2 outputs) as ONNX of opset 17 to model.onnx"), "{text}");
        let bytes = std::fs::read(here.join("model.onnx")).unwrap();
        let has = |text: &str| bytes.windows(text.len()).any(|window| window == text.as_bytes());
        let written = std::fs::read(here.join(file)).unwrap();
        assert!(has("predicted_stress_ratio") && has(&granum_core::digest::sha256(&written)), "{file}");
        assert!(has("trained_range.pressure") && has("unit.input.pressure"), "{file}");
    }
    let text = refused(here, 1, &["export", "ridge.json", "--to", "onnx", "-o", "model.onnx"]);
    assert!(text.contains("model.onnx exists already"), "{text}");
    let text = done(here, &["export", "powder", "--to", "onnx", "--path", "oedometer", "-o", "powder.onnx"]);
    assert!(
        text.contains("the family powder along oedometer (gaussian-process, 7 inputs, 38 outputs)"),
        "{text}"
    );
    let text =
        refused(here, 1, &["export", "sand", "--to", "onnx", "--path", "oedometer", "-o", "sand.onnx"]);
    assert!(text.contains("path") && text.contains("undrained-triaxial"), "{text}");
    let text = refused(here, 1, &["export", "ridge.json", "--to", "onnx", "--path", "x", "-o", "sand.onnx"]);
    assert!(text.contains("--path x goes with the name of a family"), "{text}");
    let text = refused(here, 1, &["export", "ridge.json", "--model", "x", "--to", "onnx", "-o", "x.onnx"]);
    assert!(text.contains("is the file of one surrogate"), "{text}");
    let text = refused(here, 1, &["export", "ridge.json", "--model", "x", "-o", "x.csv"]);
    assert!(text.contains("--model x belongs to --to onnx"), "{text}");
    assert!(!here.join("sand.onnx").exists() && !here.join("x.onnx").exists());
}

/// The states of a test of a family, of which all inputs are given, are those of its whole curves, line by line.
#[test]
fn families_are_streams_too() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let definition = granum_learn::family::by_name("powder", Some("oedometer")).unwrap();
    let model = granum::families::fitted(definition).unwrap().unwrap();
    let given: Vec<f64> = model.ranges().iter().map(|[low, high]| 0.6 * low + 0.4 * high).collect();
    let curves = model.predict(&given.iter().map(|value| Some(*value)).collect::<Vec<_>>(), 0.9).unwrap();
    let mut stream = Stream::new(here, &["powder", "--path", "oedometer"]);
    let mut line = serde_json::Map::new();
    for (input, value) in definition.inputs.iter().zip(&given) {
        line.insert(input.name.into(), json!(value));
    }
    for point in [0, 30, 64] {
        line.insert(definition.coordinate.into(), json!(curves.points[point]));
        let answer = stream.asked(Value::Object(line.clone()).to_string().as_bytes());
        assert_eq!(answer["outside"], json!([]), "{answer}");
        for curve in &curves.curves {
            assert_eq!(
                answer[format!("predicted_{}", curve.column)],
                json!(curve.mean[point]),
                "{}",
                curve.column
            );
        }
    }
    line.remove(definition.inputs[0].name);
    let answer = stream.asked(Value::Object(line).to_string().as_bytes());
    assert!(
        answer["error"].as_str().unwrap().starts_with("missing: friction; a state has test_progress"),
        "{answer}"
    );
    assert_eq!(stream.ended().0, Some(0));
    let text = refused(here, 1, &["stream", "powder", "--path", "drained-triaxial"]);
    assert!(text.contains("oedometer"), "{text}");
}

const CHAPTER: &str = include_str!("../../../../docs/src/real-time.md");

/// The lines of JSON of the chapter: a state is answered with the entries that it shows, in that order, and the other lines with themselves.
#[test]
fn the_chapter_shows_lines_and_their_answers() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    write_surrogates(here);
    let blocks: Vec<&str> =
        CHAPTER.split("```json\n").skip(1).filter_map(|rest| rest.split("\n```").next()).collect();
    let [asked, shown] = blocks[..] else { panic!("{blocks:?}") };
    let mut stream = Stream::new(here, &["ridge.json"]);
    stream.input.write_all(format!("{asked}\n").as_bytes()).unwrap();
    let mut answer = String::new();
    stream.output.read_line(&mut answer).unwrap();
    let keys = |text: &str| -> Vec<String> {
        let parts = text.split('"').skip(1).step_by(2);
        parts.filter(|key| !key.contains("sliding_fraction")).map(String::from).collect()
    };
    assert_eq!(keys(&answer), keys(shown), "{answer}");
    for line in [r#"{"reset": true}"#, r#"{"units": {"pressure": "kPa"}}"#] {
        assert!(CHAPTER.contains(&format!("`{line}`")), "{line}");
        assert_eq!(stream.asked(line.as_bytes()), serde_json::from_str::<Value>(line).unwrap());
    }
    assert_eq!(stream.ended().0, Some(0));
    let help = done(here, &["stream", "--help"]);
    for flag in ["--model", "--path", "--strict", "--latency"] {
        assert!(CHAPTER.contains(flag) && help.contains(flag), "{flag}");
    }
}

/// The chapter on ONNX says of every method of granum whether it is exported.
#[test]
fn the_table_of_methods_is_whole() {
    let chapter = include_str!("../../../../docs/src/onnx.md");
    let methods = granum_learn::SurrogateMethods::standard();
    for name in methods.names() {
        let row = chapter.lines().find(|line| line.starts_with('|') && line.contains(&format!("`{name}`")));
        let row = row.unwrap_or_else(|| panic!("{name} is not in the table"));
        let exported = name != "nearest-run";
        assert_eq!(row.contains("refused"), !exported, "{row}");
        if !exported {
            let reason = granum_learn::onnx::refused(name).to_string();
            assert!(!reason.contains("does not say what graph"), "{reason}");
        }
    }
}

#[test]
fn what_is_not_there_is_said_with_what_is_asked_for() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    for (command, asked) in [
        (&["stream", "nothing.json"][..], "the file of a surrogate, the folder of a study"),
        (&["predict", "nothing.json", "--set", "x=1"], "the file of a surrogate or the folder of a study"),
    ] {
        let told = refused(here, 1, command);
        assert!(told.contains("nothing.json: there is no such file or folder"), "{told}");
        assert!(told.contains(asked), "{told}");
    }
    let told = refused(here, 1, &["stream", "sandd"]);
    assert!(told.contains("no such family (did you mean sand?)"), "{told}");
    let told = refused(here, 1, &["predict", "sand", "--set", "friction=0.4"]);
    assert!(told.contains("granum predict --family sand"), "{told}");
}
