//! Tests of output folders.

use super::lock::has_no_locks;
use super::*;

#[cfg(target_os = "linux")]
#[test]
fn file_systems_without_locks_are_known_by_their_answer() {
    // ENOLCK, ENOSYS, EOPNOTSUPP; EIO and EINTR are errors.
    let known = [37, 38, 95, 5, 4].map(|code| has_no_locks(&std::io::Error::from_raw_os_error(code)));
    assert_eq!(known, [true, true, true, false, false]);
}

#[test]
fn a_new_or_empty_folder_is_taken_and_a_second_user_refused() {
    let base = tempfile::tempdir().unwrap();
    let path = base.path().join("deep").join("run");
    let folder = OutputFolder::create(&path, false).unwrap();
    let error = OutputFolder::create(&path, true).unwrap_err().to_string();
    let process = std::process::id();
    assert!(
        error.contains(&format!("run is in use by another granum process (process {process})")),
        "{error}"
    );
    assert!(matches!(OutputFolder::open(&path), Err(Error::Locked { .. })));
    drop(folder);
    OutputFolder::open(&path).unwrap();
}

#[test]
fn what_is_there_is_replaced_only_with_force() {
    let base = tempfile::tempdir().unwrap();
    let folder = OutputFolder::create(base.path().join("run"), false).unwrap();
    fs::write(folder.file("run.json"), "{}").unwrap();
    let path = folder.path().to_path_buf();
    drop(folder);
    let error = OutputFolder::create(&path, false).unwrap_err().to_string();
    assert!(error.contains("run exists already; give --force to replace it"), "{error}");
    let folder = OutputFolder::create(&path, true).unwrap();
    assert!(folder.file("run.json").exists());
    folder.clear(&["run.json", "snapshots"]).unwrap();
    assert!(!folder.file("run.json").exists());
}

#[test]
fn a_foreign_folder_stays_as_it_is_even_with_force() {
    let base = tempfile::tempdir().unwrap();
    fs::write(base.path().join("thesis.tex"), "mine").unwrap();
    for force in [false, true] {
        let error = OutputFolder::create(base.path(), force).unwrap_err().to_string();
        assert!(error.contains("contains files that granum did not write"), "{error}");
    }
    assert!(!OutputFolder::is_free(base.path()) && !OutputFolder::is_granums(base.path()));
    assert!(OutputFolder::open(base.path()).is_err());
    assert!(OutputFolder::open_or_create(base.path()).is_err());
    assert_eq!(fs::read_dir(base.path()).unwrap().count(), 1);
}

#[test]
fn names_from_files_are_plain_words() {
    for name in ["end", "F1-strain-only", "a_B-9"] {
        check_name("snapshot", name).unwrap();
    }
    for name in ["", ".", "..", "../x", "/x", "a/b", "a\\b", "C:", "a.json", "\0", "grün", &"x".repeat(101)]
    {
        let message = check_name("snapshot", name).unwrap_err().to_string();
        assert!(
            message.contains("snapshot = ") && message.contains("cannot be part of a file name"),
            "{message}"
        );
    }
}

#[test]
fn a_process_at_work_is_seen_without_a_trace() {
    let base = tempfile::tempdir().unwrap();
    assert!(!OutputFolder::is_in_use(base.path()));
    let folder = OutputFolder::create(base.path(), false).unwrap();
    assert!(OutputFolder::is_in_use(base.path()));
    drop(folder);
    assert!(!OutputFolder::is_in_use(base.path()));
    assert_eq!(fs::read_dir(base.path()).unwrap().count(), 1);
}

#[cfg(unix)]
#[test]
fn links_and_strange_locks_lead_nowhere() {
    let base = tempfile::tempdir().unwrap();
    let (outside, path) = (base.path().join("outside"), base.path().join("run"));
    fs::create_dir(&outside).unwrap();
    let folder = OutputFolder::create(&path, false).unwrap();
    std::os::unix::fs::symlink(&outside, path.join("snapshots")).unwrap();
    let message = folder.subfolder("snapshots").unwrap_err().to_string();
    assert!(message.contains("snapshots: is a symbolic link"), "{message}");
    drop(folder);
    fs::write(outside.join("thesis"), "mine").unwrap();
    fs::remove_file(path.join(LOCK)).unwrap();
    std::os::unix::fs::symlink(outside.join("thesis"), path.join(LOCK)).unwrap();
    assert!(OutputFolder::open(&path).is_err() && OutputFolder::create(&path, true).is_err());
    fs::remove_file(path.join(LOCK)).unwrap();
    fs::hard_link(outside.join("thesis"), path.join(LOCK)).unwrap();
    assert!(OutputFolder::open(&path).is_err() && OutputFolder::create(&path, true).is_err());
    assert_eq!(fs::read(outside.join("thesis")).unwrap(), b"mine");
}

#[test]
fn a_folder_copied_without_its_hidden_files_is_known_by_its_record() {
    let base = tempfile::tempdir().unwrap();
    let path = base.path();
    fs::write(path.join("run.json"), "{\"format\": 2}").unwrap();
    let message = OutputFolder::open(path).unwrap_err().to_string();
    assert!(
        message.contains("is not a folder that granum wrote") && message.contains("run.json"),
        "{message}"
    );
    assert!(OutputFolder::create(path, true).is_err() && !OutputFolder::is_granums(path));
    fs::write(path.join("run.json"), "{\"granum_version\": \"0.1.0\"}").unwrap();
    assert!(
        OutputFolder::is_granums(path) && matches!(OutputFolder::create(path, false), Err(Error::Exists(_)))
    );
    drop(OutputFolder::open(path).unwrap());
    fs::remove_file(path.join(LOCK)).unwrap();
    drop(OutputFolder::create(path, true).unwrap());
    assert!(path.join(LOCK).exists());
}

#[test]
fn only_files_that_are_named_are_cleared_inside() {
    let base = tempfile::tempdir().unwrap();
    let folder = OutputFolder::create(base.path().join("study"), false).unwrap();
    let sizes = folder.subfolder("sizes").unwrap();
    let left = format!(".F1-1.json.1-0{UNFINISHED}");
    let written = ["F1-1.json", "F1-1.unfinished", "F1-2.json", "absent.json"].map(String::from);
    for name in ["F1-1.json", "F1-1.unfinished", &left, "my.json", "my.unfinished"] {
        fs::write(sizes.join(name), "x").unwrap();
    }
    fs::create_dir(sizes.join("F1-2.json")).unwrap();
    folder.clear_inside("sizes", &written).unwrap();
    let mut names: Vec<String> = fs::read_dir(&sizes)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, ["F1-2.json", "my.json", "my.unfinished"]);
    for name in ["my.json", "my.unfinished"] {
        fs::remove_file(sizes.join(name)).unwrap();
    }
    fs::remove_dir(sizes.join("F1-2.json")).unwrap();
    folder.clear_inside("sizes", &written).unwrap();
    assert!(!sizes.exists());
}

#[cfg(unix)]
#[test]
fn force_does_not_follow_a_link() {
    let base = tempfile::tempdir().unwrap();
    let (real, link) = (base.path().join("real"), base.path().join("link"));
    drop(OutputFolder::create(&real, false).unwrap());
    std::os::unix::fs::symlink(&real, &link).unwrap();
    for path in [link.clone(), base.path().join("link/")] {
        let message = OutputFolder::create(&path, true).unwrap_err().to_string();
        assert!(message.contains("is a symbolic link, which --force does not follow"), "{message}");
    }
    drop(OutputFolder::create(&link, false).unwrap());
    drop(OutputFolder::create(&real, true).unwrap());
}

#[test]
fn leftovers_of_a_killed_process_do_not_count() {
    let base = tempfile::tempdir().unwrap();
    drop(OutputFolder::create(base.path(), false).unwrap());
    let left = base.path().join(format!(".run.json.1-0{UNFINISHED}"));
    fs::write(&left, "half").unwrap();
    OutputFolder::create(base.path(), false).unwrap();
    assert!(!left.exists());
}

#[test]
fn output_files_need_force_too() {
    let base = tempfile::tempdir().unwrap();
    let path = base.path().join("out.csv");
    check_output_file(&path, false).unwrap();
    fs::write(&path, "x").unwrap();
    assert!(check_output_file(&path, false).is_err());
    check_output_file(&path, true).unwrap();
    assert!(check_output_file(base.path(), true).unwrap_err().to_string().contains("is a folder"));
}

#[test]
fn a_file_in_a_folder_that_does_not_exist_is_refused_before_anything_is_computed() {
    let base = tempfile::tempdir().unwrap();
    let path = base.path().join("none").join("out.csv");
    let found = check_output_file(&path, false).unwrap_err().to_string();
    assert!(found.contains("cannot write") && found.contains("out.csv"), "{found}");
    check_new_file(&path, false).unwrap();
    check_output_file("out-of-no-folder.csv", false).unwrap();
}
