//! What the system tells of another process of this machine.

/// True if the process is suspended (Ctrl-Z, SIGSTOP, or a scheduler that lets another job run): it lives and does nothing. False where
/// the system does not tell.
pub fn is_suspended(process: u32) -> bool {
    let Ok(text) = std::fs::read_to_string(format!("/proc/{process}/stat")) else { return false };
    // The name of the program stands in parentheses and may contain anything.
    let state = text.rfind(')').and_then(|at| text[at + 1..].split_whitespace().next());
    matches!(state, Some("T" | "t"))
}

/// `process 4711`, with what can be done about it if it is suspended.
pub fn in_words(process: u32) -> String {
    match is_suspended(process) {
        true => format!(
            "process {process}, which is suspended: kill -CONT {process} lets it go on, and kill -KILL {process} ends it"
        ),
        false => format!("process {process}"),
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use std::process::Command;
    use std::time::{Duration, Instant};

    #[test]
    fn a_suspended_process_is_known_as_such() {
        assert!(!is_suspended(std::process::id()));
        let mut child = Command::new("sleep").arg("60").spawn().unwrap();
        let process = child.id();
        assert_eq!(in_words(process), format!("process {process}"));
        assert!(Command::new("kill").args(["-STOP", &process.to_string()]).status().unwrap().success());
        let since = Instant::now();
        while !is_suspended(process) {
            assert!(since.elapsed() < Duration::from_secs(10));
        }
        assert!(in_words(process).contains("is suspended: kill -CONT"), "{}", in_words(process));
        child.kill().unwrap();
        child.wait().unwrap();
    }
}
