//! Quoting, checked by a shell. It is separate from the other tests: a process that is being started would inherit the locks
//! of folders that they have open.
#![cfg(unix)]

use granum_io::shell::quoted;

#[test]
fn a_shell_reads_back_what_was_quoted() {
    for word in ["", "my runs/one", "it's", "$HOME", "a;b", "~", "*", "a\\b", "#x", "(1)", "\"", "!", "a\nb"]
    {
        let script = format!("printf %s {}", quoted(word));
        let output = std::process::Command::new("sh").args(["-c", &script]).output().unwrap();
        assert_eq!(String::from_utf8(output.stdout).unwrap(), word, "{script}");
    }
}
