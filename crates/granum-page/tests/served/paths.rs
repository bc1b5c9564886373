//! Paths that lead out of the folder.

use crate::Served;

#[test]
fn no_path_leads_out_of_the_folder() {
    let outer = tempfile::tempdir().unwrap();
    let inner = outer.path().join("served");
    std::fs::create_dir_all(inner.join("a")).unwrap();
    std::fs::write(outer.path().join("run.json"), "{\"secret\": 1}").unwrap();
    std::fs::write(outer.path().join("secret.svg"), "<svg>secret</svg>").unwrap();
    std::fs::create_dir_all(inner.join("fit/figures")).unwrap();
    std::fs::write(inner.join("fit/calibration.json"), "{}").unwrap();
    let served = Served::new(&inner);
    let paths = [
        "..",
        "../",
        "%2e%2e",
        "%2e%2e%2fsecret.svg",
        "%252e%252e",
        "..%5csecret.svg",
        "a/../..",
        "/etc/passwd",
        "//etc/passwd",
        "%2fetc%2fpasswd",
        "/a/c%3A/x",
        "%00",
        "a%00",
        "%ff%fe",
        "...",
    ];
    for route in [
        "run",
        "progress",
        "figures",
        "compare",
        "grains",
        "campaign",
        "calibration",
        "surrogate",
        "family",
        "map",
    ] {
        for path in paths {
            let (status, content) =
                served.get(&format!("/api/{route}?path={path}&name=x&x=a&y=b&snapshot=end"));
            assert!([400, 404].contains(&status), "{route} {path}: {status} {content}");
            assert!(!content.contains("secret\""), "{route} {path}: {content}");
        }
    }
    for name in ["../../secret.svg", "..%2f..%2f..%2fsecret.svg", "%2e%2e/calibration.json"] {
        let (status, content) = served.get(&format!("/api/calibration-figure?path=fit&name={name}"));
        assert_eq!(status, 404, "{name}: {content}");
    }
    for target in [
        "/%2e%2e/secret.svg",
        "/..%5csecret.svg",
        "/%252e%252e/x",
        "//etc/passwd",
        "/modules/../../Cargo.toml",
        "/%00",
    ] {
        let (status, content) = served.get(target);
        assert!([400, 404].contains(&status), "{target}: {status} {content}");
    }
}

/// A link out of the folder, or a pipe that nobody ever writes to, is neither read nor waited for.
#[cfg(unix)]
#[test]
fn links_out_of_the_folder_and_pipes_are_not_opened() {
    use std::os::unix::fs::symlink;
    let [folder, other] = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let root = folder.path();
    std::fs::write(other.path().join("run.json"), "{}").unwrap();
    std::fs::write(other.path().join("secret.json"), "{ \"format\": \"granum surrogate\", \"secret\": 1 }")
        .unwrap();
    symlink(other.path(), root.join("linked")).unwrap();
    symlink(other.path().join("secret.json"), root.join("secret.json")).unwrap();
    std::fs::create_dir_all(root.join("run")).unwrap();
    symlink(other.path().join("run.json"), root.join("run/run.json")).unwrap();
    std::fs::create_dir_all(root.join("piped")).unwrap();
    let piped = std::process::Command::new("mkfifo").arg(root.join("piped/run.json")).status();
    let piped = piped.is_ok_and(|made| made.success());
    let served = Served::new(root);
    let (status, content) = served.get("/api/folder");
    assert!(status == 200 && content.contains("\"total\":0"), "{content}");
    for target in ["run?path=linked", "surrogate?path=secret.json", "run?path=run", "figures?path=run"] {
        let (status, content) = served.get(&format!("/api/{target}"));
        assert!([403, 404].contains(&status), "{target}: {status} {content}");
        assert!(!content.contains("\"secret\""), "{content}");
    }
    if piped {
        assert_eq!(served.get("/api/run?path=piped").0, 403);
    }
}

/// What is in names and in texts of files is data and nothing else.
#[cfg(unix)]
#[test]
fn names_are_data() {
    let folder = tempfile::tempdir().unwrap();
    let name = "<img src=x onerror=alert(1)> \"'& </script>";
    let run = folder.path().join(name.replace('/', "|"));
    std::fs::create_dir_all(&run).unwrap();
    std::fs::write(run.join("run.json"), "{}").unwrap();
    let served = Served::new(folder.path());
    let answer = served.ask("GET", "/api/folder", "");
    assert!(answer.contains("content-type: application/json") && answer.contains("nosniff"), "{answer}");
    assert!(
        answer.contains("<img src=x onerror=alert(1)> \\\"'& <|script>") && answer.contains("\"damaged\""),
        "{answer}"
    );
}
