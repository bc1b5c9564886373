//! Every file in `tests/bad` is a case that must be rejected with exactly the messages that its comments announce: one line
//! `# expect: LINE:COLUMN: message` for each.

use granum_io::{Case, Error};

fn expected(text: &str) -> Vec<&str> {
    text.lines().filter_map(|line| line.strip_prefix("# expect: ")).collect()
}

#[test]
fn bad_cases_are_refused_with_the_message_inside_the_file() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/bad");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let text = std::fs::read_to_string(&path).unwrap();
        let expected = expected(&text);
        assert!(!expected.is_empty(), "{name} announces no message");
        let error = match Case::read(&path) {
            Ok(_) => panic!("{name} was accepted"),
            Err(error) => error,
        };
        let Error::Inputs(errors) = &error else { panic!("{name}: {error}") };
        let found: Vec<String> = errors
            .iter()
            .map(|error| {
                let help = error.help.as_ref().map_or(String::new(), |help| format!("; {help}"));
                format!("{}:{}: {}{help}", error.line, error.column, error.message)
            })
            .collect();
        assert_eq!(found, expected, "{name}");
        assert!(error.to_string().starts_with(&path.display().to_string()), "{name} is not named");
        count += 1;
    }
    assert!(count >= 20, "only {count} bad cases");
}
