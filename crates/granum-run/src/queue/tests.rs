//! Queues of small runs.

use std::path::Path;
use std::sync::Mutex;

use granum_dem::observer::{Flow, SimulationProgress};
use granum_dem::simulation::Hardware;
use granum_io::{Case, Run, RunStatus};

use super::*;
use crate::laboratory::Laboratory;
use crate::task::source::Source;

const SMALL: &str = "grains.count = 60\npreparation.solid_fraction = 'none'\npreparation.unbalanced_force = 0.05\n\
                     preparation.friction = 0.1\nshear.deviator_strain = 0.01\nshear.inertial_number = 0.01\n\
                     recording.states = 2";

fn laboratory() -> Laboratory {
    Laboratory::new(Hardware { threads: 2, ..Hardware::default() }, "test")
}

/// Tests of one sample to several strains.
fn tests(folder: &Path, strains: &[&str]) -> Vec<QueuedRun> {
    let one = |strain: &&str| {
        let mut case = Case::parse(SMALL, "case").unwrap();
        case.set("shear.deviator_strain", strain).unwrap();
        let name = format!("strain={strain}");
        QueuedRun::test(&name, case, Source::Case, folder.join(&name))
    };
    strains.iter().map(one).collect()
}

/// Notes what happens, and stops at the first progress in a test.
#[derive(Default)]
struct Notes {
    stops: bool,
    said: Mutex<Vec<String>>,
}

impl Notes {
    fn said(&self) -> Vec<String> {
        let mut said = self.said.lock().unwrap().clone();
        said.sort();
        said
    }
}

impl QueueObserver for Notes {
    fn begins(&self, run: usize) {
        self.said.lock().unwrap().push(format!("begins {run}"));
    }
    fn progress(&self, _: usize, progress: &SimulationProgress) -> Flow {
        let in_test = progress.phase == granum_dem::preparation::Phase::Test;
        if self.stops && in_test { Flow::Stop } else { Flow::Continue }
    }
    fn ends(&self, run: usize, outcome: &Outcome) {
        self.said.lock().unwrap().push(format!("ends {run} {}", outcome.word()));
    }
}

fn words(outcomes: &[Outcome]) -> Vec<&'static str> {
    outcomes.iter().map(Outcome::word).collect()
}

#[test]
fn a_shared_sample_gives_the_same_results_and_is_used_again() {
    let base = tempfile::tempdir().unwrap();
    let alone = Queue::new(tests(&base.path().join("alone"), &["0.01"])).unwrap();
    assert_eq!(words(&alone.run(&laboratory(), &NoQueueObserver)), ["finished"]);

    let folder = base.path().join("shared");
    let samples = folder.join("samples");
    let queue = Queue::with_shared_samples(tests(&folder, &["0.01", "0.02"]), &samples).unwrap();
    queue.check(&laboratory(), false).unwrap();
    let notes = Notes::default();
    let outcomes = queue.run(&laboratory(), &notes);
    assert_eq!(words(&outcomes), ["finished"; 3]);
    assert_eq!(
        notes.said(),
        ["begins 0", "begins 1", "begins 2", "ends 0 finished", "ends 1 finished", "ends 2 finished"]
    );
    let series = |folder: &Path| Run::at(folder.join("strain=0.01")).unwrap().series().unwrap();
    assert_eq!(series(&folder), series(&base.path().join("alone")));
    assert!(queue.is_finished(&laboratory()));

    // A further test uses the sample again, and nothing else is computed. What a process left that was killed after the end of a
    // run goes.
    let left = folder.join("strain=0.01").join(".seconds.json.1-1.granum-unfinished");
    std::fs::write(&left, "{").unwrap();
    let more = Queue::with_shared_samples(tests(&folder, &["0.01", "0.02", "0.03"]), &samples).unwrap();
    more.check(&laboratory(), false).unwrap();
    let notes = Notes::default();
    let outcomes = more.run(&laboratory(), &notes);
    assert!(matches!(outcomes[1], Outcome::Finished { reused: true, .. }));
    assert!(matches!(outcomes[3], Outcome::Finished { reused: false, .. }));
    assert_eq!(notes.said()[0], "begins 3");
    assert!(!left.exists());

    // The strength of a run of an earlier version, whose record does not tell it, is found from its series.
    let entry = crate::runs_table::RunEntry::from_run(&Run::at(folder.join("strain=0.02")).unwrap()).unwrap();
    let mut old = entry.clone();
    old.record.measures.clear();
    let found = old.with_strength().unwrap().record.measures;
    assert!(found.keys().any(|name| name.starts_with("peak_")), "{found:?}");
    assert!(found.iter().all(|(name, value)| entry.record.measures.get(name) == Some(value)), "{found:?}");

    // The sample of finished tests is not missed.
    std::fs::remove_dir_all(&samples).unwrap();
    assert_eq!(words(&more.run(&laboratory(), &NoQueueObserver))[0], "not needed");
}

#[test]
fn a_failed_run_takes_only_those_that_wait_for_it() {
    let base = tempfile::tempdir().unwrap();
    let mut runs = tests(base.path(), &["0.01", "0.02"]);
    // Its folder is a file.
    std::fs::write(base.path().join("blocked"), "").unwrap();
    let blocked =
        QueuedRun { folder: base.path().join("blocked"), name: "blocked".into(), ..runs[0].clone() };
    runs[1].after = Some("blocked".into());
    runs.push(blocked);
    let outcomes = Queue::new(runs).unwrap().run(&laboratory(), &NoQueueObserver);
    assert_eq!(words(&outcomes), ["finished", "failed", "failed"]);
    assert_eq!(outcomes[1].failure().unwrap(), "its sample blocked failed");
    assert!(outcomes[2].failure().unwrap().contains("blocked"), "{:?}", outcomes[2]);
}

#[test]
fn a_stop_ends_all_runs_in_good_order_and_the_queue_continues() {
    let base = tempfile::tempdir().unwrap();
    let queue = Queue::with_shared_samples(
        tests(base.path(), &["0.01", "0.02", "0.03", "0.04"]),
        &base.path().join("samples"),
    )
    .unwrap();
    let outcomes = queue.run(&laboratory(), &Notes { stops: true, ..Notes::default() });
    assert_eq!(outcomes[0].word(), "finished");
    assert!(outcomes[1..].iter().all(Outcome::is_stopped), "{:?}", words(&outcomes));
    // The longest begins first, and with two threads two runs are left unbegun.
    assert_eq!(outcomes[4].record().unwrap().status, RunStatus::Interrupted);
    assert!(words(&outcomes).contains(&"not begun"));

    // It continues from its file.
    RunList::from_queue(&queue, base.path()).unwrap().write(base.path()).unwrap();
    let read = RunList::read(base.path())
        .unwrap()
        .unwrap()
        .queue(base.path(), &granum_io::case::Vocabulary::standard())
        .unwrap();
    assert_eq!(read, queue);
    assert_eq!(words(&read.run(&laboratory(), &NoQueueObserver)), ["finished"; 5]);
}

#[test]
fn what_cannot_run_is_refused_before_anything_is_written() {
    let base = tempfile::tempdir().unwrap();
    let mut runs = tests(base.path(), &["0.01", "0.02"]);
    runs[1].case.recording.sensors = vec!["no_such_sensor".into()];
    let message = |runs: &[QueuedRun]| {
        Queue::new(runs.to_vec()).unwrap().check(&laboratory(), false).unwrap_err().to_string()
    };
    let error = message(&runs);
    assert!(error.starts_with("strain=0.02: recording.sensors: there is no sensor"), "{error}");
    runs[1].case.recording.sensors.clear();
    runs[1].source = Source::Folder(base.path().join("nowhere"));
    let error = message(&runs);
    assert!(error.starts_with("strain=0.02: ") && error.contains("there is no such folder"), "{error}");
    assert_eq!(std::fs::read_dir(base.path()).unwrap().count(), 0);

    // The folder of another run.
    let queue = Queue::new(tests(base.path(), &["0.01"])).unwrap();
    queue.run(&laboratory(), &NoQueueObserver);
    let mut other = tests(base.path(), &["0.01"]);
    other[0].case.preparation.seed = 7;
    let error = message(&other);
    assert!(error.contains("its run has another case or version (granum test)"), "{error}");
    let other = Queue::new(other).unwrap();
    other.check(&laboratory(), true).unwrap();
    other.replace_others(&laboratory()).unwrap();
    other.check(&laboratory(), false).unwrap();
    assert!(queue.check(&laboratory(), false).is_ok(), "the folder is empty now");
}

#[test]
fn a_list_of_runs_stays_in_its_folder() {
    let base = tempfile::tempdir().unwrap();
    let queue = Queue::new(tests(base.path(), &["0.01"])).unwrap();
    RunList::from_queue(&queue, base.path()).unwrap().write(base.path()).unwrap();
    let path = base.path().join(RUN_LIST);
    let text = std::fs::read_to_string(&path).unwrap();
    let message = |text: &str| {
        std::fs::write(&path, text).unwrap();
        RunList::read(base.path()).unwrap_err().to_string()
    };
    for elsewhere in ["../x", "/elsewhere/x", ""] {
        let changed = text.replace("\"folder\": \"strain=0.01\"", &format!("\"folder\": {elsewhere:?}"));
        assert!(message(&changed).contains("was changed or damaged"), "{elsewhere}");
        let mut value: serde_json::Value = serde_json::from_str(&changed).unwrap();
        value.as_object_mut().unwrap().remove("sha256");
        let error = message(&granum_io::sealed::seal(&value).unwrap());
        assert!(error.contains("is not inside"), "{elsewhere}: {error}");
    }
    assert!(message("{}").contains("was changed or damaged"));
}
