//! Quoting, checked by a shell. It is separate from the other tests: a process that is being started would inherit the locks
//! of folders that they have open.
#![cfg(unix)]

use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

use granum_io::shell::{quoted, quoted_path};

#[test]
fn a_shell_reads_back_what_was_quoted() {
    for word in ["", "my runs/one", "it's", "$HOME", "a;b", "~", "*", "a\\b", "#x", "(1)", "\"", "!", "a\nb"]
    {
        let script = format!("printf %s {}", quoted(word));
        let output = std::process::Command::new("sh").args(["-c", &script]).output().unwrap();
        assert_eq!(String::from_utf8(output.stdout).unwrap(), word, "{script}");
    }
}

/// Paths of any bytes, in a shell that knows `$'...'`.
#[test]
fn a_shell_reads_back_a_path_of_any_bytes() {
    for path in
        [&b"\xff"[..], b"my runs/\xfe1", b"-\xff", b"it's \xff\\n", b"a\nb\x80\x1b", b"gr\xc3\xbcn-\xc3"]
    {
        let script = format!("printf %s {}", quoted_path(Path::new(OsStr::from_bytes(path))));
        let output = std::process::Command::new("bash").args(["-c", &script]).output().unwrap();
        let wanted = if path.starts_with(b"-") { [b"./", path].concat() } else { path.to_vec() };
        assert_eq!(output.stdout, wanted, "{script}");
    }
}
