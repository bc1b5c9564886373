//! Plans that would take all of the time or of the stack, names that a terminal, a page or a spreadsheet would obey, files of a data set
//! that were damaged, and processes that stand still.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::campaigns::folder_with_plan;
use crate::common::{run, stderr, stdout};
use crate::{done, refused};

/// All runs are part of the data set.
pub const ACCEPT: &str = "accept = ['inertial_number < 1', 'servo_error_rms < 1', 'servo_error_largest < 10', 'unbalanced_force < 10', \
                          'largest_overlap < 1', 'energy_gap < 1', 'mean_stress_lost < 1', 'sample_unbalanced_force < 1', \
                          'sample_mean_stress_missed_by < 1', 'stages_cut_short < 1.5']\n";
const DRY: [&str; 5] = ["campaign", "plan.toml", "--dry-run", "--pilots", "0"];

/// A design of four points with further variables.
fn plan(here: &Path, more: &str) {
    let text = "case = 'sand.toml'\n[design]\nkind = 'sobol'\npoints = 4\n[[variable]]\nname = 'friction'\n\
                key = 'grains.material.friction'\nfrom = 0.1\nto = 0.8\n";
    fs::write(here.join("plan.toml"), format!("{text}{more}")).unwrap();
}

fn expression(name: &str, text: &str) -> String {
    format!("[[variable]]\nname = '{name}'\nexpression = '{text}'\n")
}

#[test]
fn long_sums_and_long_chains_are_refused_by_their_limits_or_done_soon() {
    let base = folder_with_plan();
    let here = base.path();
    let sum = format!("1{}", "+1".repeat(30_000));
    plan(here, &expression("a", &sum));
    let message = refused(here, 1, &DRY);
    assert!(
        message.contains("more than 1000 numbers, names, operators and functions") && message.len() < 2000,
        "{message}"
    );
    plan(here, "");
    let text = fs::read_to_string(here.join("plan.toml")).unwrap();
    fs::write(here.join("plan.toml"), format!("constraints = ['{sum} > 0']\n{text}")).unwrap();
    assert!(refused(here, 1, &DRY).contains("more than 1000 numbers"));
    // Each is given by the next one, so that the last must be evaluated first.
    let chain = |length: usize| {
        let each = (0..length).map(|k| expression(&format!("a{k}"), &format!("a{}+1", k + 1)));
        each.collect::<String>() + &expression(&format!("a{length}"), "friction")
    };
    plan(here, &chain(3000));
    let since = Instant::now();
    assert!(refused(here, 1, &DRY).contains("there are 3002 variables; at most 1000 are possible"));
    plan(here, &chain(990));
    done(here, &DRY);
    assert!(since.elapsed() < Duration::from_secs(20), "{:?}", since.elapsed());
    plan(here, &(chain(900) + &expression("b", "c") + &expression("c", "b")));
    assert!(refused(here, 1, &DRY).contains("depends on itself"));
    plan(here, "");
    let text = fs::read_to_string(here.join("plan.toml")).unwrap();
    fs::write(here.join("plan.toml"), text.replace("points = 4", "points = 60000\nreplicates = 1000"))
        .unwrap();
    assert!(refused(here, 1, &DRY).contains("at most 1000000 runs are possible"));
}

/// What nothing that granum prints may hold: it moves the cursor of a terminal, or turns the direction of writing.
fn is_obeyed(c: char) -> bool {
    (c.is_control() && c != '\n') || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

#[test]
fn names_are_shown_and_obeyed_nowhere() {
    let base = folder_with_plan();
    let here = base.path();
    let values = r#"[{ name = "<script>alert(1)</script>", set = { "preparation.friction" = 0.1 } },
        { name = "=cmd|'/C calc'!A0", set = { "preparation.friction" = 0.2 } },
        { name = "]]>&<b>\u202eX\u001b[31m\nnew", set = { "preparation.friction" = 0.3 } }]"#;
    let text = format!(
        "case = 'sand.toml'\n{ACCEPT}[design]\nkind = 'full-factorial'\n[[variable]]\nname = 'kind'\nvalues = {values}\n"
    );
    fs::write(here.join("plan.toml"), text).unwrap();
    let out = "a\u{1b}[31m\u{202e}b";
    for arguments in [
        &DRY[..],
        &["campaign", "plan.toml", "--out", out],
        &["campaign", "status", out],
        &["--json", "campaign", "status", out],
    ] {
        let output = run(here, arguments);
        assert!(output.status.success(), "{}", stderr(&output));
        for text in [stdout(&output), stderr(&output)] {
            assert!(!text.chars().any(is_obeyed), "{arguments:?}: {text:?}");
        }
    }
    for path in ["dataset/README.md", "dataset/left_out.csv"] {
        let Ok(text) = fs::read_to_string(here.join(out).join(path)) else { continue };
        assert!(
            !text.chars().any(is_obeyed) && !text.contains("<script>") && !text.contains("<b>"),
            "{text}"
        );
        for line in text.lines().filter(|line| line.starts_with('|')) {
            let bars = line.matches('|').count() - line.matches("\\|").count();
            assert!((3..=5).contains(&bars), "{bars}: {line}");
        }
        assert!(
            !text.lines().any(|line| line.split(',').any(|cell| cell.trim_matches('"').starts_with('='))),
            "{text}"
        );
    }
    // A file that is not there, and a mistake in a plan of such a name.
    let name = "\u{1b}]0;x\u{7}\u{2066}.toml";
    let message = refused(here, 1, &["campaign", name, "--dry-run"]);
    assert!(!message.chars().any(is_obeyed), "{message:?}");
    fs::write(here.join(name), "case = 'sand.toml'\n\u{202e} = 1\n").unwrap();
    let message = refused(here, 1, &["campaign", name, "--dry-run"]);
    assert!(!message.chars().any(is_obeyed), "{message:?}");
}

#[test]
fn a_damaged_data_set_is_made_again() {
    let base = folder_with_plan();
    let here = base.path();
    let plan = fs::read_to_string(here.join("plan.toml")).unwrap();
    fs::write(here.join("plan.toml"), plan.replacen("[design]", &format!("{ACCEPT}[design]"), 1)).unwrap();
    let again = || {
        let output = run(here, &["campaign", "plan.toml", "--out", "study"]);
        assert!(output.status.success(), "{}", stderr(&output));
        (stdout(&output), stderr(&output))
    };
    again();
    let set = here.join("study/dataset");
    if !set.join("SHA256SUMS").is_file() {
        panic!("no run passed its checks");
    }
    let sums = fs::read(set.join("SHA256SUMS")).unwrap();
    assert!(again().0.contains("(unchanged)"));
    for entry in fs::read_dir(&set).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_string();
        if name.starts_with('.') {
            continue;
        }
        let before = fs::read(&path).unwrap();
        let mut bytes = before.clone();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 0x20;
        fs::write(&path, &bytes).unwrap();
        let (said, warned) = again();
        // A bit of the times, for which there is no sum, may be any other time.
        if name != "seconds.parquet" {
            assert!(!said.contains("(unchanged)"), "{name}: {said}");
            assert_eq!(fs::read(&path).unwrap(), before, "{name}");
        }
        if !["seconds.parquet", "SHA256SUMS"].contains(&name.as_str()) {
            assert!(
                warned.contains(&name) && warned.contains("made again from the rows"),
                "{name}: {warned}"
            );
        }
        assert_eq!(fs::read(set.join("SHA256SUMS")).unwrap(), sums);
        assert!(again().0.contains("(unchanged)"), "{name}");
    }
    // Rows that were damaged as well are taken in again from the folders of their runs.
    let rows = fs::read_dir(here.join("study/rows")).unwrap().next().unwrap().unwrap().path();
    let mut bytes = fs::read(&rows).unwrap();
    let last = bytes.len() - 5;
    bytes[last] ^= 1;
    fs::write(&rows, bytes).unwrap();
    fs::remove_file(set.join("states.parquet")).unwrap();
    again();
    assert_eq!(fs::read(set.join("SHA256SUMS")).unwrap(), sums);
}

/// A process that waits for one that stands still says for whom, and for how long.
#[cfg(target_os = "linux")]
#[test]
fn who_waits_for_a_suspended_process_says_so() {
    let base = folder_with_plan();
    let here = base.path();
    let case = fs::read_to_string(here.join("sand.toml")).unwrap();
    fs::write(
        here.join("sand.toml"),
        case.replace("axial_strain = 0.01", "axial_strain = 0.01\ninertial_number = 1e-4").replacen(
            "inertial_number = 1e-2\nstates",
            "states",
            1,
        ),
    )
    .unwrap();
    let start = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_granum"));
        command
            .args(arguments)
            .current_dir(here)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        command.spawn().unwrap()
    };
    done(here, &["campaign", "plan.toml", "--out", "study", "--list-jobs"]);
    let name = crate::done_json(here, &["campaign", "status", "study"])["runs"][0]["name"]
        .as_str()
        .unwrap()
        .to_string();
    let mut first = start(&["campaign", "run", "study", &name]);
    let is_claimed = || {
        let files = fs::read_dir(here.join("study/claims")).into_iter().flatten().flatten();
        files.into_iter().any(|entry| entry.metadata().is_ok_and(|file| file.len() > 0))
    };
    let since = Instant::now();
    while !is_claimed() {
        assert!(since.elapsed() < Duration::from_secs(30) && first.try_wait().unwrap().is_none());
        std::thread::sleep(Duration::from_millis(1));
    }
    let signal = |signal: &str| {
        Command::new("kill").args([signal, &first.id().to_string()]).status().unwrap().success()
    };
    assert!(signal("-STOP"));
    let mut second = start(&["campaign", "run", "study", &name]);
    let mut lines = std::io::BufRead::lines(std::io::BufReader::new(second.stderr.take().unwrap()));
    let line =
        lines.find_map(|line| line.ok().filter(|line| line.contains("has waited"))).unwrap_or_default();
    let whom = format!("for process {} on ", first.id());
    assert!(
        line.contains(&whom) && line.contains("which is suspended") && line.contains("has waited 5 s"),
        "{line}"
    );
    let _ = second.kill();
    second.wait().unwrap();
    assert!(signal("-KILL"));
    first.wait().unwrap();
}
