//! Names of files and folders with characters that have a meaning somewhere, and names that are not UTF-8.

use std::ffi::OsString;
use std::os::unix::ffi::OsStringExt;

use crate::files;
use crate::ground::Ground;
use crate::judge;
use crate::process::{Limits, Program};
use crate::{Case, Fault};

const NAMES: [&[u8]; 14] = [
    b"<img src=x onerror=alert(1)>",
    b"a&b",
    b"it's \"so\"",
    b"two\nlines",
    b"tab\there",
    b"\xff",
    b"caf\xe9",
    "gr\u{fc}n \u{202e}neurg".as_bytes(),
    b"$(touch made)",
    b"-v",
    b"--help",
    b" ",
    b"%s%n",
    b"a\x1b[31mred",
];

/// Runs the commands on a folder with such a name.
pub fn attack(ground: &Ground, program: &Program, case: &mut Case) -> Result<Vec<Fault>, String> {
    let bytes = *case.random.pick(&NAMES);
    let name = OsString::from_vec(bytes.to_vec());
    case.told = format!("a folder with the name {name:?}");
    let path = case.folder.join(&name);
    let text = |word: &str| OsString::from(word);
    let there = || {
        let mut there = text("./");
        there.push(&name);
        there
    };
    let with = |end: &str| {
        let mut with = there();
        with.push(end);
        with
    };
    for (from, to) in [
        ("run-1", path.clone()),
        ("case.toml", case.folder.join(with(".toml"))),
        ("run-2", case.folder.join("run-2")),
        ("packing.csv", case.folder.join(with(".packing.csv"))),
        ("lab.csv", case.folder.join(with(".lab.csv"))),
        ("staged", case.folder.join("staged")),
    ] {
        files::copy(&ground.folder.join(from), &to).map_err(|error| format!("{from}: {error}"))?;
    }
    let lines: Vec<Vec<OsString>> = vec![
        vec![text("status"), there()],
        vec![text("digest"), there()],
        vec![text("report"), there()],
        vec![text("report"), there(), text("--out"), with(".html")],
        vec![text("export"), there(), text("-o"), with(".vtp")],
        vec![text("export"), there(), text("-o"), with(".csv")],
        vec![text("export"), there(), text("--to"), text("lammps"), text("-o"), with("-deck")],
        vec![text("measure"), there()],
        vec![text("resume"), there()],
        vec![text("init"), with("-new.toml")],
        vec![text("compare"), text("staged"), with(".lab.csv"), text("-o"), with(".svg")],
        vec![text("forces"), with(".packing.csv"), text("-o"), with("-forces.csv")],
        vec![
            text("prepare"),
            with(".toml"),
            text("--packing"),
            with(".packing.csv"),
            text("--out"),
            with("-out"),
        ],
        vec![text("shear"), with(".toml"), text("--out"), with("-sheared")],
        vec![text("status"), text("--"), name.clone()],
    ];
    // Some of the commands compute.
    let patient = Program { longest: 3 * program.longest, ..program.clone() };
    let mut faults = Vec::new();
    for _ in 0..4 {
        let mut words = case.random.pick(&lines).clone();
        if case.random.chance(0.5) {
            words.insert(0, text("--json"));
        }
        let ended =
            patient.run(&case.folder, &words, Limits::default()).map_err(|error| error.to_string())?;
        let wrong = judge::wrong(&ended, true)
            .into_iter()
            .chain(judge::wrong_words(&ended))
            .chain(judge::left_behind(&case.folder));
        faults.extend(wrong.map(|(kind, what)| Fault {
            kind,
            what,
            line: ended.line.clone(),
            ended: ended.error.clone(),
        }));
    }
    for file in files::under(&case.folder) {
        let page = std::fs::read(case.folder.join(&file)).unwrap_or_default();
        let kind = file.extension().and_then(|kind| kind.to_str()).unwrap_or_default();
        if ["html", "svg", "vtp"].contains(&kind) && page.windows(8).any(|window| window == b"<img src") {
            let what = format!("{} holds a name as markup", file.display());
            faults.push(Fault { kind: "markup", what, line: String::new(), ended: String::new() });
        }
    }
    if case.folder.join("made").exists() {
        faults.push(Fault {
            kind: "shell",
            what: "a name was executed".into(),
            line: String::new(),
            ended: String::new(),
        });
    }
    Ok(faults)
}
