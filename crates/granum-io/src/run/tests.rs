use super::RunKind;
use super::*;
use granum_core::Column;
use granum_core::assembly::Bond;
use std::collections::BTreeMap;
use std::fs;

fn record() -> RunRecord {
    let mut record = RunRecord::new(RunKind::Test, "0.1.0", &Case::default(), Machine::here("avx2", 2));
    record.status = RunStatus::Finished;
    record.steps.insert(TEST.into(), 1000);
    record.wall_seconds.insert(TEST.into(), 0.1 + 0.2);
    record.measures.insert("solid_fraction".into(), 0.61);
    record.quality.push(QualityFlag::at_most("servo_error_rms", 0.004, 0.01, "lower the strain rate"));
    record
}

fn table() -> Table {
    Table::new(vec![Column::new("deviator_strain", "", vec![0.0, 0.3])]).unwrap()
}

/// A folder that holds only times would be neither empty nor a run.
#[test]
fn a_record_that_cannot_be_written_leaves_no_times() {
    let base = tempfile::tempdir().unwrap();
    let folder = RunFolder::create(base.path().join("run"), false).unwrap();
    folder.write_case(&Case::default(), None).unwrap();
    fs::create_dir(folder.path().join(RECORD)).unwrap();
    assert!(folder.write_record(&record()).is_err());
    assert!(!folder.path().join(times::TIMES).exists());
    fs::remove_dir(folder.path().join(RECORD)).unwrap();
    folder.write_record(&record()).unwrap();
    assert_eq!(folder.run().record().unwrap().wall_seconds, record().wall_seconds);
}

#[test]
fn a_run_comes_back() {
    let base = tempfile::tempdir().unwrap();
    let path = base.path().join("run");
    let assembly = crate::snapshot::tests::assembly();
    let folder = RunFolder::create(&path, false).unwrap();
    folder.write_case(&Case::default(), None).unwrap();
    folder.write_series(&table()).unwrap();
    folder.write_forces(&table()).unwrap();
    folder.write_snapshot("end", &assembly).unwrap();
    folder.write_record(&record()).unwrap();
    drop(folder);
    let run = Run::at(&path).unwrap();
    assert_eq!(run.case().unwrap(), Case::default());
    assert_eq!(run.series().unwrap(), table());
    assert_eq!(run.snapshots().unwrap(), ["end"]);
    assert_eq!(run.snapshot("end").unwrap(), assembly);
    let back = run.record().unwrap();
    assert_eq!(back.content["series.parquet"], back.content["forces.parquet"]);
    assert_eq!(RunRecord { content: BTreeMap::new(), ..back.clone() }, record());
    assert_eq!(back.grain_steps(), 5_000_000);
    assert!(back.is_result_of(&Case::default(), "0.1.0") && !back.is_result_of(&Case::default(), "0.2.0"));
}

/// A finished run with a snapshot, a further histogram and a preparation.
fn whole_run(path: &Path) -> RunFolder {
    let folder = RunFolder::create(path, false).unwrap();
    folder.write_record(&record()).unwrap();
    folder.write_case(&Case::default(), None).unwrap();
    folder.write_checkpoint(|out| out.write_all(b"one")).unwrap();
    folder.write_checkpoint(|out| out.write_all(b"two")).unwrap();
    folder.write_series(&table()).unwrap();
    folder.write_forces(&table()).unwrap();
    folder.write_preparation(&table()).unwrap();
    folder.write_histogram("overlap", &table()).unwrap();
    folder.write_snapshot("end", &crate::snapshot::tests::assembly()).unwrap();
    folder.write_record(&record()).unwrap();
    folder
}

fn listing(path: &Path) -> Vec<String> {
    let mut left: Vec<String> =
        fs::read_dir(path).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    left.sort();
    left
}

#[test]
fn force_replaces_the_old_run_and_nothing_else() {
    let base = tempfile::tempdir().unwrap();
    let path = base.path().join("run");
    drop(whole_run(&path));
    fs::create_dir(path.join("figures")).unwrap();
    for name in ["report.html", "figures/figure-s1-stress.svg"] {
        fs::write(path.join(name), "old").unwrap();
    }
    let mine =
        ["notes.txt", "figures/mine.svg", "figures/mine.png", "snapshots/my.json", "histograms/mine.parquet"];
    for name in mine {
        fs::write(path.join(name), "mine").unwrap();
    }
    assert!(matches!(RunFolder::create(&path, false), Err(Error::Exists(_))));
    let before = listing(&path);
    // Nothing is replaced until the new run writes its first file.
    drop(RunFolder::create(&path, true).unwrap());
    assert_eq!(listing(&path), before);
    assert!(Run::at(&path).unwrap().faults().unwrap().is_empty());
    let folder = RunFolder::create(&path, true).unwrap();
    folder.write_record(&RunRecord { status: RunStatus::Running, ..record() }).unwrap();
    assert_eq!(
        listing(&path),
        [".granum-lock", "figures", "histograms", "notes.txt", "run.json", "seconds.json", "snapshots"]
    );
    for name in mine {
        assert_eq!(fs::read(path.join(name)).unwrap(), b"mine");
    }
    assert_eq!(folder.run().record().unwrap().status, RunStatus::Running);
    assert!(folder.run().snapshots().unwrap().is_empty() && folder.run().tables().unwrap().is_empty());
}

#[test]
fn a_replacement_that_fails_or_is_cut_short_leaves_the_old_run_whole() {
    let base = tempfile::tempdir().unwrap();
    let path = base.path().join("run");
    drop(whole_run(&path));
    let whole = || {
        let run = Run::at(&path).unwrap();
        assert!(run.faults().unwrap().is_empty() && run.record().unwrap().status == RunStatus::Finished);
        assert_eq!(run.series().unwrap(), table());
        assert_eq!(run.snapshot("end").unwrap(), crate::snapshot::tests::assembly());
    };
    // The first file cannot be written.
    let folder = RunFolder::create(&path, true).unwrap();
    assert!(folder.write_checkpoint(|_| Err(std::io::Error::other("the disk is full"))).is_err());
    whole();
    drop(folder);
    // The process was killed after the files were moved, before or after the first new file.
    for new in [None, Some("run.json")] {
        let names = content::written(&path, Run::at(&path).unwrap().record().ok().as_ref());
        aside::set_aside(&path, &names).unwrap();
        if let Some(name) = new {
            fs::write(path.join(name), "{}").unwrap();
        } else {
            let message = Run::at(&path).unwrap_err().to_string();
            assert!(message.contains("was cut short") && message.contains("granum resume"), "{message}");
        }
        drop(RunFolder::open(&path).unwrap());
        whole();
    }
}

/// The SHA-256 of a large snapshot takes time.
#[test]
fn files_found_whole_are_not_compared_again_by_the_same_reader() {
    let base = tempfile::tempdir().unwrap();
    let path = base.path().join("run");
    drop(whole_run(&path));
    let run = Run::at(&path).unwrap();
    let file = path.join("snapshots/end.json");
    let good = fs::read(&file).unwrap();
    fs::write(&file, "{}").unwrap();
    assert_eq!(run.faults().unwrap().len(), 1);
    assert!(!run.compared_names().contains("snapshots/end.json"));
    assert!(run.snapshot("end").unwrap_err().to_string().contains("snapshots/end.json"));
    fs::write(&file, good).unwrap();
    assert!(run.faults().unwrap().is_empty());
    let names: Vec<String> = run.record().unwrap().content.into_keys().collect();
    assert!(names.iter().all(|name| run.compared_names().contains(name)), "{names:?}");
}

#[test]
fn every_changed_bit_and_every_missing_file_is_noticed() {
    let base = tempfile::tempdir().unwrap();
    let path = base.path().join("run");
    drop(whole_run(&path));
    let names = [
        "run.json",
        "series.parquet",
        "forces.parquet",
        "preparation.parquet",
        "histograms/overlap.parquet",
        "snapshots/end.json",
        "snapshots/end.grains.parquet",
        "snapshots/end.contacts.parquet",
    ];
    let read_all = || -> Result<()> {
        let run = Run::at(&path)?;
        drop([run.series()?, run.forces()?, run.histogram("overlap")?]);
        drop((run.preparation()?, run.snapshot("end")?));
        Ok(())
    };
    read_all().unwrap();
    let mut noise = 20_061_121_u64;
    for (round, name) in names.iter().cycle().take(400).enumerate() {
        let file = path.join(name);
        let good = fs::read(&file).unwrap();
        noise = noise * 48271 % 2_147_483_647;
        let at = noise as usize % good.len();
        let mut bytes = good.clone();
        bytes[at] ^= 1 << (round / 8 % 8);
        fs::write(&file, &bytes).unwrap();
        let message = read_all().unwrap_err().to_string();
        assert!(message.contains(name), "byte {at} of {name}: {message}");
        let told = Run::at(&path).unwrap().faults();
        let told = told.map(|faults| faults.iter().map(ToString::to_string).collect::<String>());
        assert!(told.unwrap_or_else(|error| error.to_string()).contains(name), "{name}");
        fs::write(&file, good).unwrap();
    }
    for name in names.iter().skip(1) {
        let (file, other) = (path.join(name), base.path().join("kept"));
        fs::rename(&file, &other).unwrap();
        let message = read_all().unwrap_err().to_string();
        assert!(message.contains(name) && message.contains("is missing"), "{message}");
        fs::rename(&other, &file).unwrap();
    }
    // A file that the record does not list is not a part of the run, whatever it holds.
    let folder = RunFolder::open(&path).unwrap();
    assert!(folder.check_present().is_ok());
    fs::remove_file(path.join("snapshots/end.json")).unwrap();
    assert!(folder.check_present().unwrap_err().to_string().contains("end.json: was removed while the run"));
    drop(folder);
    let bare = RunFolder::create(base.path().join("bare"), false).unwrap();
    bare.write_case(&Case::default(), None).unwrap();
    bare.write_record(&record()).unwrap();
    fs::copy(path.join("series.parquet"), bare.path().join("series.parquet")).unwrap();
    let message = bare.run().series().unwrap_err().to_string();
    assert!(message.contains("series.parquet: is not a file of this run"), "{message}");
    assert_eq!(bare.run().faults().unwrap().len(), 1);
}

/// What only snapshots of clumps and of bonded grains have is compared as the rest: a bond or a piece that is lost shows nowhere else.
#[test]
fn changed_pieces_and_lost_bonds_are_noticed() {
    let base = tempfile::tempdir().unwrap();
    let folder = RunFolder::create(base.path().join("run"), false).unwrap();
    folder.write_case(&Case::default(), None).unwrap();
    folder.write_record(&record()).unwrap();
    for write in [RunFolder::write_series, RunFolder::write_forces, RunFolder::write_preparation] {
        write(&folder, &table()).unwrap();
    }
    let mut assembly = crate::snapshot::tests::with_a_dimer();
    assembly.bonds = vec![Bond { id: 1, i: 0, j: 2, ..Bond::default() }];
    folder.write_snapshot("end", &assembly).unwrap();
    folder.write_record(&record()).unwrap();
    let read = || Run::at(folder.path()).unwrap().snapshot("end");
    assert_eq!(read().unwrap().bonds.len(), 1);
    for name in ["snapshots/end.pieces.parquet", "snapshots/end.bonds"] {
        let (file, other) = (folder.path().join(name), base.path().join("kept"));
        let mut bytes = fs::read(&file).unwrap();
        fs::rename(&file, &other).unwrap();
        let message = read().unwrap_err().to_string();
        assert!(message.contains(name) && message.contains("is missing"), "{message}");
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        fs::write(&file, bytes).unwrap();
        let message = read().unwrap_err().to_string();
        assert!(message.contains(name) && message.contains("SHA-256"), "{message}");
        fs::rename(&other, &file).unwrap();
    }
    read().unwrap();
}

#[test]
fn a_run_killed_between_its_record_and_a_file_is_whole() {
    let base = tempfile::tempdir().unwrap();
    let path = base.path().join("run");
    let folder = whole_run(&path);
    let longer = Table::new(vec![Column::new("deviator_strain", "", vec![0.0, 0.3, 0.4])]).unwrap();
    let old = fs::read(path.join("series.parquet")).unwrap();
    folder.write_series(&longer).unwrap();
    drop(folder);
    // Killed before the new table took its place, and before the new histogram came.
    fs::write(path.join("series.parquet"), &old).unwrap();
    assert!(Run::at(&path).unwrap().faults().unwrap().is_empty());
    assert_eq!(Run::at(&path).unwrap().series().unwrap(), table());
    let folder = RunFolder::open(&path).unwrap();
    folder.write_histogram("second", &table()).unwrap();
    fs::remove_file(path.join("histograms/second.parquet")).unwrap();
    drop(folder);
    let run = Run::at(&path).unwrap();
    assert!(run.faults().unwrap().is_empty());
    assert_eq!(run.histograms().unwrap(), ["overlap"]);
    // The next record is that of the files that are there.
    let folder = RunFolder::open(&path).unwrap();
    folder.write_record(&record()).unwrap();
    let after = folder.run().record().unwrap();
    assert!(after.replaced.is_empty() && !after.content.contains_key("histograms/second.parquet"));
    assert!(folder.run().faults().unwrap().is_empty());
    assert_eq!(folder.run().series().unwrap(), table());
}

#[test]
fn runs_of_earlier_versions_are_read_and_say_what_cannot_be_checked() {
    let base = tempfile::tempdir().unwrap();
    let path = base.path().join("run");
    drop(whole_run(&path));
    let mut old: serde_json::Value = serde_json::from_slice(&fs::read(path.join(RECORD)).unwrap()).unwrap();
    old["format"] = 1.into();
    old["machine"] = serde_json::to_value(Machine::here("avx2", 2)).unwrap();
    // Tests were called after the section `[shear]`.
    old["wall_seconds"] = serde_json::json!({ "shear": 2.5 });
    (old["kind"], old["steps"]) = ("shear".into(), serde_json::json!({ "shear": 1000 }));
    old.as_object_mut().unwrap().remove("sha256");
    let content = old["content"].as_object_mut().unwrap();
    content.retain(|name, _| !name.starts_with("snapshots"));
    fs::write(path.join(RECORD), serde_json::to_vec(&old).unwrap()).unwrap();
    fs::remove_file(path.join(times::TIMES)).unwrap();
    fs::write(path.join("snapshots/my.json"), "{}").unwrap();
    let run = Run::at(&path).unwrap();
    let read = run.record().unwrap();
    assert_eq!((read.kind, read.steps[TEST], read.wall_seconds[TEST]), (RunKind::Test, 1000, 2.5));
    assert_eq!(run.snapshots().unwrap(), ["end"]);
    run.snapshot("end").unwrap();
    assert_eq!(run.uncheckable().unwrap(), content::snapshot_files("end"));
    // Its tables are checked, and a run that goes on gets the SHA-256 of all of its files.
    fs::copy(path.join("snapshots/end.grains.parquet"), path.join("series.parquet")).unwrap();
    assert!(Run::at(&path).unwrap().series().unwrap_err().to_string().contains("was changed or exchanged"));
    let folder = RunFolder::open(&path).unwrap();
    folder.write_series(&table()).unwrap();
    folder.write_record(&record()).unwrap();
    assert!(folder.run().uncheckable().unwrap().is_empty() && folder.run().faults().unwrap().is_empty());
    assert_eq!(folder.run().record().unwrap().content.len(), 7);
}

#[test]
fn a_run_without_its_case_file_has_the_case_of_its_record() {
    let base = tempfile::tempdir().unwrap();
    let folder = RunFolder::create(base.path(), false).unwrap();
    let mut record = record();
    record.unwritten_case = Some(Case::default().resolved_toml());
    folder.write_record(&record).unwrap();
    assert_eq!(folder.run().case().unwrap(), Case::default());
    folder.write_case(&Case::default(), None).unwrap();
    fs::remove_file(base.path().join("run.json")).unwrap();
    let message = folder.run().record().unwrap_err().to_string();
    assert!(message.contains("holds a case but no run.json"), "{message}");
    fs::remove_file(base.path().join("case.toml")).unwrap();
    let message = folder.run().record().unwrap_err().to_string();
    assert!(message.contains("holds no run.json") && message.contains("training.json"), "{message}");
    fs::create_dir(base.path().join("run.json")).unwrap();
    let message = folder.run().record().unwrap_err().to_string();
    assert!(message.contains("run.json: is not a regular file"), "{message}");
}

#[test]
fn records_that_cannot_be_read_say_why() {
    let base = tempfile::tempdir().unwrap();
    let folder = RunFolder::create(base.path(), false).unwrap();
    assert!(Run::at(base.path()).unwrap_err().to_string().contains("contains no run"));
    assert!(Run::at(base.path().join("x")).unwrap_err().to_string().contains("no such folder"));
    folder.write_record(&record()).unwrap();
    let path = base.path().join("run.json");
    let text = fs::read_to_string(&path).unwrap();
    let message = |text: &str| {
        fs::write(&path, text).unwrap();
        folder.run().record().unwrap_err().to_string()
    };
    assert!(message(&text[..text.len() / 2]).contains("run.json: is truncated (EOF"));
    let newer = text.replace("\"format\": 2", "\"format\": 3");
    assert!(message(&newer).contains("was written by a newer granum (format 3; this one reads up to 2)"));
    assert!(message(&text.replace("5000", "6000")).contains("run.json: was changed or damaged"));
    let earlier = text.replace("\"format\": 2", "\"format\": 1").replace("5000", "\"many\"");
    let earlier = earlier.split(",\n  \"sha256\"").next().unwrap().to_string() + "\n}";
    assert!(message(&earlier).contains("run.json: is damaged (invalid type"), "{}", message(&earlier));
    assert!(folder.write_snapshot("../end", &Assembly::default()).is_err());
}

#[test]
fn a_measure_that_is_no_number_survives_and_is_not_good() {
    let base = tempfile::tempdir().unwrap();
    let folder = RunFolder::create(base.path(), false).unwrap();
    let mut record = record();
    assert!(record.is_good());
    record.quality.push(QualityFlag::at_most("energy_closure", f64::NAN, 1e-3, ""));
    record.measures.insert("coordination_number".into(), f64::NAN);
    folder.write_record(&record).unwrap();
    let back = folder.run().record().unwrap();
    assert!(back.measures["coordination_number"].is_nan() && back.quality[1].value.is_nan());
    assert!(!back.is_good());
}

#[test]
fn the_digest_of_a_file_is_its_sha_256() {
    let base = tempfile::tempdir().unwrap();
    let path = base.path().join("abc");
    fs::write(&path, "abc").unwrap();
    // FIPS 180-2, appendix B.1.
    let known = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
    assert_eq!(file_digest(&path).unwrap(), known);
}
