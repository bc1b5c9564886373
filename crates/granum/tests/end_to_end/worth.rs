//! What each soft sensor is worth, measured by the program on small runs.

use crate::networks::make_run_of;
use crate::{done, done_json, refused};

const SURROGATES: &str = include_str!("../../../../docs/src/theory/surrogates.md");

const ASKED: [&str; 15] = [
    "worth",
    "run-1",
    "run-2",
    "run-3",
    "run-4",
    "run-5",
    "--unseen",
    "run-6",
    "run-7",
    "--sensor",
    "deviator_fabric,sliding_fraction",
    "--property",
    "grains.material.friction",
    "--method",
    "ridge",
];

#[test]
fn the_worth_of_sensors_is_measured_written_and_reported() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    for k in 1..=7 {
        make_run_of(here, &format!("run-{k}"), |case| {
            let case = case
                .replace("count = 150", "count = 100")
                .replace("deviator_strain = 0.3", "deviator_strain = 0.06");
            let case = case.replace("states = 40", "states = 20");
            format!("{case}\n[grains.material]\nfriction = 0.{k}\n")
                .replace("[preparation]", &format!("[preparation]\nseed = {k}"))
        });
    }
    let found = done_json(here, &[&ASKED[..], &["-o", "worth.json", "--page", "worth.html"]].concat());
    let answers = found["worth"]["answers"].as_array().unwrap();
    let error = |output: &str, name: &str| {
        let own = answers.iter().find(|own| own["output"] == output && own["knowledge"]["name"] == name);
        own.unwrap_or_else(|| panic!("{output} {name}: {found}"))["error"]["relative"].as_f64().unwrap()
    };
    for name in ["strain alone", "strain + all sensors", "properties", "properties + all sensors"] {
        assert!((0.0..1.0).contains(&error("stress_ratio", name)), "{name}: {found}");
    }
    assert!(error("stress_ratio", "cascade: properties, sensors predicted from them") > 0.0);
    assert!(error("deviator_fabric", "strain + stress_ratio + volumetric_strain") > 0.0);
    let page = std::fs::read_to_string(here.join("worth.html")).unwrap();
    assert!(
        page.contains("What each soft sensor is worth") && page.contains("cascade") && !page.contains("NaN")
    );
    let written: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(here.join("worth.json")).unwrap()).unwrap();
    assert_eq!(written, found["worth"]);

    // The command of the chapter, with runs in place of a campaign and what makes it quick.
    let command = SURROGATES.lines().find(|line| line.starts_with("granum worth study ")).unwrap();
    let runs = "run-1 run-2 run-3 run-4 run-5 run-6 run-7";
    let command =
        command.replace("study", runs).replace("worth.json", "all.json").replace("worth.html", "all.html");
    let words: Vec<&str> = command.split_whitespace().skip(1).chain(ASKED[9..].iter().copied()).collect();
    let text = done(here, &words);
    assert!(text.contains("strain + all sensors") && here.join("all.html").is_file(), "{text}");

    // Text, and the files that exist are not replaced.
    let text = done(here, &ASKED);
    assert!(
        text.contains("relative RMSE on 2 unseen runs") && text.contains("strain + deviator_fabric"),
        "{text}"
    );
    let message = refused(here, 1, &[&ASKED[..], &["-o", "worth.json"]].concat());
    assert!(message.contains("worth.json") && message.contains("--force"), "{message}");
    let message = refused(here, 1, &["worth", "run-1", "run-2"]);
    assert!(message.contains("--unseen-share"), "{message}");

    // The same as the first section of the report of a study.
    let train = [
        "train",
        "run-1",
        "run-2",
        "run-3",
        "--unseen",
        "run-6",
        "--input",
        "deviator_fabric",
        "--output",
        "stress_ratio",
        "--coordinate",
        "axial_strain",
        "--method",
        "nearest-run,boosted-trees",
        "-o",
        "study",
    ];
    let message = refused(here, 1, &train);
    assert!(message.contains("deviator_fabric is not constant"), "{message}");
    let train = [
        "train",
        "run-1",
        "run-2",
        "run-3",
        "--unseen",
        "run-6",
        "--input",
        "grains.material.friction",
        "--output",
        "stress_ratio",
        "--coordinate",
        "axial_strain",
        "--method",
        "nearest-run,boosted-trees,cascade",
        "-o",
        "study",
    ];
    let text = done(here, &train);
    assert!(text.contains("stress_ratio: the least error on 1 unseen run has stress_ratio-"), "{text}");
    std::fs::copy(here.join("worth.json"), here.join("study/worth.json")).unwrap();
    done(here, &["report", "study"]);
    let page = std::fs::read_to_string(here.join("study/report.html")).unwrap();
    let place = |title: &str| page.find(title).unwrap_or_else(|| panic!("{title}"));
    assert!(place("What each soft sensor is worth") < place("Use of the inputs"));
}

/// Rows of a table of the book: its label and the numbers with their standard errors.
fn rows_of_table<'a>(text: &'a str, head: &str) -> Vec<(&'a str, Vec<&'a str>)> {
    let table = text.split(head).nth(1).expect(head);
    let lines = table.lines().skip(2).take_while(|line| line.starts_with('|'));
    let cells =
        |line: &'a str| -> Vec<&'a str> { line.trim_matches('|').split('|').map(str::trim).collect() };
    lines.map(cells).map(|cells| (cells[0], cells[1..].to_vec())).collect()
}

/// True if a number is printed as `text`, to the digits that it has.
fn is_printed(text: &str, number: f64) -> bool {
    let digits = text.split('.').nth(1).map_or(0, str::len);
    text.parse::<f64>().is_ok_and(|found| (found - number).abs() <= 0.51 * 0.1f64.powi(digits as i32))
}

#[test]
fn the_tables_of_the_book_and_the_readme_are_those_that_were_measured() {
    let measured: serde_json::Value =
        serde_json::from_str(include_str!("../../../../data/families/sand/worth.json")).unwrap();
    let answers = measured["answers"].as_array().unwrap();
    let of_output = |output: &str| -> Vec<[f64; 2]> {
        let own = answers.iter().filter(|answer| answer["output"] == output);
        own.map(|answer| {
            ["relative", "standard_error"].map(|key| 100.0 * answer["error"][key].as_f64().unwrap())
        })
        .collect()
    };
    let readme = include_str!("../../../../README.md");
    let (of_book, of_sensors) = ("| known | q/p | volumetric strain |", "| known | fabric | second moment |");
    let laboratory = ["stress_ratio", "volumetric_strain"].map(of_output);
    let sensors = [
        "deviator_fabric",
        "mean_square_force",
        "probability_density",
        "mechanical_coordination_number",
        "sliding_fraction",
    ];
    let check = |rows: &[(&str, Vec<&str>)], outputs: &[Vec<[f64; 2]>], lines: &[usize]| {
        assert_eq!(rows.len(), lines.len());
        for ((label, cells), line) in rows.iter().zip(lines) {
            for (cell, output) in cells.iter().zip(outputs) {
                let (value, error) = cell.trim_end_matches(" %").split_once(" ± ").expect(cell);
                let [exact, scatter] = output[*line];
                assert!(
                    is_printed(value, exact) && is_printed(error, scatter),
                    "{label}: {cell} {exact} {scatter}"
                );
            }
        }
    };
    let all: Vec<usize> = (0..laboratory[0].len()).collect();
    check(&rows_of_table(SURROGATES, of_book), &laboratory, &all);
    let sensors = sensors.map(of_output);
    let each: Vec<usize> = (0..sensors[0].len()).collect();
    check(&rows_of_table(SURROGATES, of_sensors), &sensors, &each);
    check(&rows_of_table(readme, of_book), &laboratory, &[0, 1, 3, 4, 5, 9, 10, 11, 12]);
}

/// The answers along the other paths, in the order of the columns of the book.
const OTHER_PATHS: [&str; 5] = [
    include_str!("../../../../data/families/sand/worth-constant-p.json"),
    include_str!("../../../../data/families/sand/worth-undrained-triaxial.json"),
    include_str!("../../../../data/families/sand/worth-unload-reload.json"),
    include_str!("../../../../data/families/powder/worth-constant-p.json"),
    include_str!("../../../../data/families/powder/worth-oedometer.json"),
];

/// What a cell of a table says is what was measured.
fn check_cell(label: &str, cell: &str, answer: &serde_json::Value) {
    let (value, error) = cell.split_once(" ± ").expect(cell);
    let [exact, scatter] =
        ["relative", "standard_error"].map(|key| 100.0 * answer["error"][key].as_f64().unwrap());
    assert!(is_printed(value, exact) && is_printed(error, scatter), "{label}: {cell} {exact} {scatter}");
}

#[test]
fn the_tables_of_the_other_paths_are_those_that_were_measured() {
    let paths: Vec<serde_json::Value> =
        OTHER_PATHS.iter().map(|text| serde_json::from_str(text).unwrap()).collect();
    let answers = |path: &serde_json::Value, output: &serde_json::Value| -> Vec<serde_json::Value> {
        let all = path["answers"].as_array().unwrap();
        all.iter().filter(|answer| answer["output"] == *output).cloned().collect()
    };
    // Of each path what the laboratory measures: a row for each knowledge, a column for each path.
    for (number, head) in ["| q/p from |", "| volume or mean stress from |"].into_iter().enumerate() {
        let rows = rows_of_table(SURROGATES, head);
        assert_eq!(rows.len(), 14, "{head}");
        for (column, path) in paths.iter().enumerate() {
            let own = answers(path, &path["plan"]["outputs"][number]);
            assert_eq!(own.len(), rows.len());
            rows.iter().zip(&own).for_each(|((label, cells), own)| check_cell(label, cells[column], own));
        }
    }
    // The other way round: five rows for each path, a column for each sensor; of what is known from one quantity of the laboratory alone, q/p is shown.
    let rows = rows_of_table(SURROGATES, "| path: known |");
    assert_eq!(rows.len(), 5 * paths.len());
    for (rows, path) in rows.chunks(5).zip(&paths) {
        for (column, sensor) in path["plan"]["sensors"].as_array().unwrap().iter().enumerate() {
            let own = answers(path, sensor);
            for ((label, cells), number) in rows.iter().zip([0, 1, 3, 4, 5]) {
                check_cell(label, cells[column], &own[number]);
            }
        }
    }
}
