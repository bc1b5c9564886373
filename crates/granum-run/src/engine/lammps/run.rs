//! A run: the sample, and the test that LAMMPS carries out while it is followed.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::PathBuf;
use std::time::{Duration, Instant as Clock};

use granum_core::observer::Event;
use granum_dem::observer::{Flow, SimulationObserver, Work};
use granum_io::run::{RunStatus, TEST};
use granum_io::{Case, Error, Packing};
use granum_sensors::Sensors;

use super::frame::{self, Grains};
use super::place::{Place, Request};
use super::program::{NAME, Program};
use super::progress::Progress;
use super::quality;
use super::reading::{News, Reading};
use super::unknown::Unknown;
use crate::engine::native::{END, MOST_STAGES_NOTED, SampleMaker, measures, note, quality as native_quality};
use crate::lammps_deck::{Confinement, LammpsDeck};
use crate::strength;
use crate::task::definition::Task;
use crate::task::engine_error::EngineError;
use crate::task::laboratory_error::LaboratoryError;
use crate::task::sink::Sink;

/// Time between two looks at what LAMMPS has written.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// A test that LAMMPS is to carry out.
#[derive(Clone, Debug)]
pub(super) struct Test {
    case: Case,
    command: Vec<String>,
    sensors: Sensors,
    unknown: Unknown,
    save_every: Duration,
    /// True for a run that begins, false for one that goes on.
    is_new: bool,
    /// A note that the run has from its start.
    pub(super) note: Option<String>,
}

impl Test {
    /// The test of a task.
    ///
    /// # Errors
    /// If the case asks for a sensor that cannot measure what LAMMPS gives.
    pub(super) fn new(task: &Task, command: Vec<String>, is_new: bool) -> Result<Test, LaboratoryError> {
        let sensors = task.vocabulary.sensors().clone();
        let unknown = Unknown::new(&task.case, &sensors, frame::parts())?;
        let save_every = task.resources.checkpoint_every;
        Ok(Test { case: task.case.clone(), command, sensors, unknown, save_every, is_new, note: None })
    }

    /// A sentence on what is not recorded.
    pub(super) fn remark(&self) -> Option<String> {
        self.unknown.remark()
    }
}

/// The folder in which LAMMPS works: in that of the run, or a temporary one for a run that writes no files.
struct Workplace {
    place: Place,
    temporary: Option<PathBuf>,
}

impl Workplace {
    fn new(sink: &dyn Sink) -> Result<Workplace, LaboratoryError> {
        if let Some(folder) = sink.folder() {
            return Ok(Workplace { place: Place::create(folder)?, temporary: None });
        }
        static NUMBER: std::sync::atomic::AtomicU64 = std::sync::atomic::AtomicU64::new(0);
        let number = NUMBER.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let folder = std::env::temp_dir().join(format!("granum-lammps-{}-{number}", std::process::id()));
        Ok(Workplace { place: Place::create(&folder)?, temporary: Some(folder) })
    }
}

impl Drop for Workplace {
    fn drop(&mut self) {
        if let Some(folder) = &self.temporary {
            let _ = std::fs::remove_dir_all(folder);
        }
    }
}

/// Makes the sample, if there is none yet, and carries out the test, from the last restart file if there is one.
pub(super) fn run(
    test: Test,
    sample: SampleMaker,
    sink: &mut dyn Sink,
    observer: &mut dyn SimulationObserver,
) -> Result<(), LaboratoryError> {
    if let Some(text) = &test.note {
        note(sink.record(), text.clone());
    }
    let workplace = Workplace::new(sink)?;
    let place = &workplace.place;
    let Some(lock) = lock(place, observer)? else {
        sink.record().status = RunStatus::Interrupted;
        return Ok(());
    };
    if test.is_new {
        // A run that this one replaces leaves nothing from which it could go on.
        place.clear()?;
    }
    let Some(sample) = sample.make(&test.case, sink, observer)? else { return Ok(()) };
    let started = Clock::now();
    let packing = Packing::from_assembly(&sample.assembly());
    let deck = LammpsDeck::followed(&test.case, &packing, Confinement::Own).map_err(of_deck)?;
    let grains = Grains::new(deck.assembly().clone(), deck.properties().clone());
    let mut reading =
        Reading::new(test.case.clone(), test.sensors.clone(), test.unknown.clone(), grains, place.clone());
    let restart = go_back(&mut reading, sink)?;
    if restart.is_none() && !reading.is_complete() {
        begin(&test, &deck, place)?;
    }
    sink.begin_states(&reading.states())?;
    let outcome = if reading.is_complete() {
        Ok(Outcome::Complete)
    } else {
        let mut follower = Follower { test: &test, reading: &mut reading, sink, observer };
        follower.follow(restart, lock)
    };
    *sink.record().wall_seconds.entry(TEST.into()).or_default() += started.elapsed().as_secs_f64();
    let record = sink.record();
    record.steps.insert(TEST.into(), reading.steps());
    record.phase = reading.stage_name().to_string();
    match outcome? {
        Outcome::Stopped => {
            save_measurements(&reading, sink)?;
            sink.record().status = RunStatus::Interrupted;
            Ok(())
        }
        Outcome::Complete => complete(&mut reading, sink, observer),
    }
}

/// The lock of the folder; LAMMPS of a process that was killed is asked to stop. `None` if the observer does not wait for it.
fn lock(place: &Place, observer: &mut dyn SimulationObserver) -> Result<Option<File>, LaboratoryError> {
    let mut told = false;
    loop {
        if let Some(lock) = place.lock()? {
            return Ok(Some(lock));
        }
        if !std::mem::replace(&mut told, true) {
            observer.warn(
                "LAMMPS still runs in this folder, started by a process that was killed: it is asked to write a restart file and to stop",
            );
        }
        place.request(Request::Stop)?;
        let waiting = granum_core::observer::Progress::new("waiting for LAMMPS to stop", "steps", 0);
        if observer.work(&Work::Elsewhere(&waiting)) == Flow::Stop {
            return Ok(None);
        }
        std::thread::sleep(10 * LOOK_EVERY);
    }
}

fn of_deck(error: crate::lammps_deck::DeckError) -> LaboratoryError {
    EngineError::Refused { engine: NAME.into(), what: error.to_string() }.into()
}

/// Writes the deck, in place of whatever was there.
fn begin(test: &Test, deck: &LammpsDeck, place: &Place) -> Result<(), LaboratoryError> {
    place.clear()?;
    deck.write_into(place.path()).map_err(of_deck)?;
    Ok(place.write_command(&test.command)?)
}

/// Takes up what is in the folder: reads on from the last restart file what LAMMPS did after it, as far as its dumps are there.
/// Returns the step of the restart file from which it goes on.
fn go_back(reading: &mut Reading, sink: &mut dyn Sink) -> Result<Option<u64>, LaboratoryError> {
    let place = reading.place.clone();
    let mut good = None;
    for step in place.restarts()? {
        if let Ok(progress) = Progress::read(&place, step, &reading.sensors) {
            good = Some((step, progress));
            break;
        }
    }
    let Some((mut step, mut progress)) = good else { return Ok(None) };
    reading.progress = progress.clone();
    let mut lines = Lines::new(&place, progress.read);
    for (line, length) in lines.next()? {
        let Ok(news) = reading.read(&line, length) else { break };
        for (name, assembly) in &news.snapshots {
            sink.save_snapshot(name, assembly)?;
        }
        if let Some(saved) = news.saved.filter(|saved| place.is_restart(*saved)) {
            (step, progress) = (saved, reading.progress.clone());
            progress.write(&place, step)?;
        }
    }
    if !reading.is_complete() {
        reading.progress = progress;
        place.cut_to(reading.progress.read, step)?;
        place.remove_dumps()?;
    }
    Ok(Some(step))
}

/// How LAMMPS ended.
enum Outcome {
    Complete,
    Stopped,
}

/// Follows a process of LAMMPS.
struct Follower<'a, 's> {
    test: &'a Test,
    reading: &'a mut Reading,
    sink: &'a mut (dyn Sink + 's),
    observer: &'a mut dyn SimulationObserver,
}

impl Follower<'_, '_> {
    fn follow(&mut self, restart: Option<u64>, lock: File) -> Result<Outcome, LaboratoryError> {
        let place = self.reading.place.clone();
        place.request(Request::Go)?;
        let mut program = Program::start(&self.test.command, &place, restart, lock)?;
        let mut lines = Lines::new(&place, self.reading.progress.read);
        let (mut asked, mut saved) = (Request::Go, Clock::now());
        let mut speed = Speed::new(self.reading);
        loop {
            // Whether it has ended is asked first, so that everything it wrote is read.
            let ended = program.ended()?;
            for (line, length) in lines.next()? {
                let news = self.reading.read(&line, length)?;
                if self.tell(news)? {
                    saved = Clock::now();
                    if asked == Request::Save {
                        asked = Request::Go;
                        place.request(asked)?;
                    }
                }
            }
            if let Some(status) = ended {
                return match (status.success(), self.reading.is_complete(), asked) {
                    (true, true, _) => Ok(Outcome::Complete),
                    (true, false, Request::Stop) => Ok(Outcome::Stopped),
                    _ => {
                        let what = format!(
                            "LAMMPS ended with {status} before the test was complete; resume the run to go on from its last restart \
                             file{}",
                            program.last_words(&place)
                        );
                        Err(EngineError::Failed { engine: NAME.into(), what }.into())
                    }
                };
            }
            let report = self.reading.report(speed.rate(self.reading));
            let stops = self.observer.work(&Work::Elsewhere(&report)) == Flow::Stop;
            if stops && asked != Request::Stop {
                asked = Request::Stop;
                place.request(asked)?;
            }
            if asked == Request::Go && saved.elapsed() > self.test.save_every {
                asked = Request::Save;
                place.request(asked)?;
            }
            std::thread::sleep(LOOK_EVERY);
        }
    }

    /// Passes on what a line brought; true if it was a restart file.
    fn tell(&mut self, news: News) -> Result<bool, LaboratoryError> {
        if let Some(number) = news.began {
            self.observer.stage(number);
        }
        for state in &news.states {
            self.sink.add_state(state)?;
            self.observer.event(&Event::StateRecorded { values: state.values.clone() });
        }
        for (name, assembly) in &news.snapshots {
            self.sink.save_snapshot(name, assembly)?;
        }
        if let Some((number, end)) = news.ended {
            let (name, steps, reason) = (end.name, end.steps, end.reason.to_string());
            self.observer.event(&Event::StageEnded { number, name, steps, reason });
        }
        let Some(step) = news.saved else { return Ok(false) };
        let place = &self.reading.place;
        self.reading.progress.write(place, step)?;
        place.keep_restarts(&[step])?;
        save_measurements(self.reading, self.sink)?;
        let (steps, phase) = (self.reading.steps(), self.reading.stage_name().to_string());
        let stage_ends = self.reading.progress.stage_ends.clone();
        let record = self.sink.record();
        record.stage_ends = stage_ends;
        record.steps.insert(TEST.into(), steps);
        record.phase = phase;
        self.sink.save_record()?;
        Ok(true)
    }
}

/// Saves the measurements so far; before the first stage of the test there are none.
fn save_measurements(reading: &Reading, sink: &mut dyn Sink) -> Result<(), LaboratoryError> {
    match reading.progress.recorders.is_empty() {
        true => Ok(()),
        false => Ok(sink.save_measurements(&reading.record())?),
    }
}

/// Completes a test: the last snapshot, measures, quality and notes.
fn complete(
    reading: &mut Reading,
    sink: &mut dyn Sink,
    observer: &mut dyn SimulationObserver,
) -> Result<(), LaboratoryError> {
    let end = reading.last()?.assembly;
    sink.save_snapshot(END, &end)?;
    let seen = reading.record();
    sink.save_measurements(&seen)?;
    let ends = &reading.progress.ends;
    let record = sink.record();
    record.measures.extend(strength::of_test(&seen, &reading.stages, ends));
    record.measures.extend(strength::cohesion_of(&reading.case));
    record.stage_ends.clone_from(&reading.progress.stage_ends);
    measures::of_oedometers(&seen, &reading.stages, &record.stage_ends, &mut record.measures);
    for (k, end) in ends.iter().enumerate() {
        let mut text =
            format!("stage {} ({}) ended after {} steps: {}", k + 1, end.name, end.steps, end.reason);
        let error = end.servo_error.rms();
        if error > 0.0 {
            let percent = 100.0 * error;
            text += &format!("; its stresses were held within {percent:.2} % of p (root mean square)");
        }
        let asked = end.reason.is_asked_for() || native_quality::is_liquefied_end(&reading.stages, k, end);
        if !asked {
            observer.warn(&text);
        }
        if !asked || ends.len() <= MOST_STAGES_NOTED {
            note(record, text);
        }
    }
    quality::add(reading, &seen, record);
    let speed_key = reading.case.test_definition().speed_key;
    if let Some(remark) = native_quality::remark_on_samples(&reading.missed(), speed_key) {
        observer.warn(&remark);
        note(record, remark);
    }
    record.phase.clear();
    reading.place.remove_dumps()?;
    reading.place.keep_restarts(&[])?;
    Ok(())
}

/// The whole lines of the events as they come.
struct Lines {
    place: Place,
    at: u64,
}

impl Lines {
    fn new(place: &Place, at: u64) -> Lines {
        Lines { place: place.clone(), at }
    }

    /// The lines that are whole by now, with their lengths in bytes.
    fn next(&mut self) -> Result<Vec<(String, u64)>, LaboratoryError> {
        let path = self.place.events();
        let mut file = match File::open(&path) {
            Ok(file) => file,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
            Err(error) => return Err(Error::file("read", &path)(error).into()),
        };
        let mut bytes = Vec::new();
        file.seek(SeekFrom::Start(self.at))
            .and_then(|_| file.read_to_end(&mut bytes))
            .map_err(Error::file("read", &path))?;
        let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |at| at + 1);
        self.at += whole as u64;
        let text = String::from_utf8_lossy(&bytes[..whole]).into_owned();
        Ok(text.split_inclusive('\n').map(|line| (line.trim_end().to_string(), line.len() as u64)).collect())
    }
}

/// The speed of LAMMPS in grain-steps per second.
struct Speed {
    since: Clock,
    step: u64,
    rate: Option<f64>,
}

impl Speed {
    fn new(reading: &Reading) -> Speed {
        Speed { since: Clock::now(), step: reading.steps(), rate: None }
    }

    fn rate(&mut self, reading: &Reading) -> Option<f64> {
        let (steps, seconds) = (reading.steps(), self.since.elapsed().as_secs_f64());
        if seconds > 1.0 && steps > self.step {
            let rate = (steps - self.step) as f64 * reading.grains.count() as f64 / seconds;
            *self = Speed { since: Clock::now(), step: steps, rate: Some(rate) };
        }
        self.rate
    }
}
