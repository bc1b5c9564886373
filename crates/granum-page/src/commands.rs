//! The command lines that give what the page shows, quoted for a shell.

use std::path::Path;

use granum_io::shell::{quoted, quoted_path};
use serde_json::{Value, json};

/// A command line with what it is for.
pub fn line(what: &str, command: String) -> Value {
    json!({ "what": what, "command": command })
}

/// Adds what can be done next, unless it is there already.
pub fn add_next(lines: &mut Vec<Value>, command: Option<String>) {
    let Some(command) = command else { return };
    if !lines.iter().any(|line| line["command"] == command.as_str()) {
        lines.push(line("What can be done next", command));
    }
}

/// Those of a run.
pub fn of_run(named: &Path, is_test: bool, has_snapshots: bool) -> Vec<Value> {
    let name = quoted_path(named);
    let mut lines = vec![
        line("Its progress", format!("granum status {name}")),
        line("Its report as a page of its own", format!("granum report {name} --out report.html")),
    ];
    if is_test {
        lines.push(line("Its results in a table", format!("granum table {name}")));
    }
    if has_snapshots {
        lines.push(line("Its grains as a page of their own", format!("granum view {name} -o grains.html")));
    }
    lines
}

/// Those of several runs.
pub fn of_several(named: &[std::path::PathBuf]) -> Vec<Value> {
    let names = named.iter().map(|path| quoted_path(path)).collect::<Vec<_>>().join(" ");
    vec![
        line("Their report as a page of its own", format!("granum report {names} --out runs.html")),
        line("Their differences in numbers", format!("granum compare {names}")),
        line("Their results in a table", format!("granum table {names}")),
    ]
}

/// Those of a campaign.
pub fn of_campaign(named: &Path) -> Vec<Value> {
    let name = quoted_path(named);
    vec![
        line("How far it is", format!("granum campaign status {name}")),
        line("Its report as a page of its own", format!("granum report {name} --out campaign.html")),
        line("What the map is drawn from", format!("granum table {name} -o table.csv")),
    ]
}

/// `granum predict` with the inputs that are given.
pub fn predict(of: &str, flags: &[(String, String)]) -> String {
    let mut command = format!("granum predict {of}");
    for (flag, value) in flags {
        command += &format!(" {flag} {}", quoted(value));
    }
    command
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_quoted_for_a_shell() {
        let lines = of_run(Path::new("a b/it's; rm -rf $HOME"), true, true);
        for line in lines {
            let command = line["command"].as_str().unwrap();
            let words =
                std::process::Command::new("sh").arg("-c").arg(format!("printf '%s\\n' {command}")).output();
            let words = String::from_utf8(words.unwrap().stdout).unwrap();
            assert!(words.lines().any(|word| word == "a b/it's; rm -rf $HOME"), "{command}: {words}");
        }
    }
}
