//! The command line of the program as seen by a user.

mod common;

use common::{json, run, stderr, stdout};

#[test]
fn help_and_version_are_there_and_a_wrong_word_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    assert!(stdout(&run(folder.path(), &["--help"])).contains("Usage: granum"));
    assert!(stdout(&run(folder.path(), &["--version"])).starts_with("granum "));
    let wrong = run(folder.path(), &["inti"]);
    assert_eq!(wrong.status.code(), Some(2));
    assert!(stderr(&wrong).contains("init"), "{}", stderr(&wrong));
}

#[test]
fn init_writes_a_case_that_granum_reads_and_never_replaces_one_unasked() {
    let folder = tempfile::tempdir().unwrap();
    let made = run(folder.path(), &["init"]);
    assert!(made.status.success(), "{}", stderr(&made));
    let path = folder.path().join("case.toml");
    assert_eq!(granum_io::Case::read(&path).unwrap(), granum_io::Case::default());
    std::fs::write(&path, "mine").unwrap();
    let again = run(folder.path(), &["init"]);
    assert_eq!(again.status.code(), Some(1));
    assert!(stderr(&again).contains("case.toml exists already; give --force"), "{}", stderr(&again));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
    let forced = run(folder.path(), &["init", "--force", "--json"]);
    assert_eq!(json(&stdout(&forced))["case"], "case.toml");
}

#[test]
fn errors_are_json_for_machines() {
    let folder = tempfile::tempdir().unwrap();
    for (wrong, word) in [
        (&["--json", "inti"][..], "unrecognized subcommand 'inti'"),
        (&["shear", "--json"], "required arguments were not provided: <CASE>"),
        (&["--json", "shear", "case.toml", "--grains", "5"], "unexpected argument '--grains'"),
        (&["bench", "--threads", "many", "--json"], "invalid value 'many'"),
        (&["--json"], "requires a subcommand"),
    ] {
        let failed = run(folder.path(), wrong);
        assert_eq!((failed.status.code(), stdout(&failed)), (Some(2), String::new()));
        let error = json(&stderr(&failed))["error"].clone();
        assert!(error["message"].as_str().unwrap().contains(word), "{error}");
        assert!(error["usage"].as_str().is_none_or(|usage| usage.starts_with("granum")), "{error}");
        assert!(!error["message"].as_str().unwrap().contains("Usage"), "{error}");
    }
    assert!(stdout(&run(folder.path(), &["--json", "--help"])).contains("Usage: granum"));
    let failed = run(folder.path(), &["--json", "init", "nowhere/case.toml"]);
    assert_eq!(failed.status.code(), Some(1));
    let message = json(&stderr(&failed))["error"]["message"].as_str().unwrap().to_string();
    assert!(message.contains("cannot write nowhere/case.toml"), "{message}");
}
