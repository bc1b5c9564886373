//! Reads what LAMMPS tells of a test, and records it.

use granum_core::assembly::Assembly;
use granum_core::observer::Progress as Report;
use granum_dem::config::RecordedColumns;
use granum_dem::loading::{Measure, Stage, StageEnd, Until};
use granum_io::Case;
use granum_io::run::StageEndRecord;
use granum_sensors::{MissedObservations, Record, RecordedState, Recorder, Sensors};

use super::events::{Event, Instant};
use super::frame::{Grains, Seen};
use super::place::Place;
use super::progress::Progress;
use super::reasons::stage_end;
use super::unknown::Unknown;
use crate::engine::native::{MOST_STAGES_NOTED, snapshot_name, stage_snapshot};
use crate::task::laboratory_error::LaboratoryError;

/// Share by which a measure may fall short of the value at which an observation is due.
const ROUNDING: f64 = 1e-9;

/// A test that is being read.
pub(super) struct Reading {
    pub(super) case: Case,
    pub(super) stages: Vec<Stage>,
    pub(super) columns: RecordedColumns,
    pub(super) sensors: Sensors,
    pub(super) unknown: Unknown,
    pub(super) grains: Grains,
    pub(super) place: Place,
    pub(super) progress: Progress,
    /// The instant that was read last, with its grains.
    seen: Option<(u64, Seen)>,
}

/// What a line brought.
#[derive(Debug, Default)]
pub(super) struct News {
    /// States that are complete.
    pub(super) states: Vec<RecordedState>,
    /// Snapshots that the case asks for.
    pub(super) snapshots: Vec<(String, Assembly)>,
    /// The stage of the test that began, from 1.
    pub(super) began: Option<usize>,
    /// The end of a stage of the test, with its number.
    pub(super) ended: Option<(usize, StageEnd)>,
    /// The step of a restart file that is complete.
    pub(super) saved: Option<u64>,
}

impl Reading {
    pub(super) fn new(
        case: Case,
        sensors: Sensors,
        unknown: Unknown,
        grains: Grains,
        place: Place,
    ) -> Reading {
        let definition = case.test_definition();
        let progress = Progress::new(definition.snapshots);
        Reading {
            stages: definition.stages,
            columns: definition.columns,
            case,
            sensors,
            unknown,
            grains,
            place,
            progress,
            seen: None,
        }
    }

    /// True once the last stage is over, or one that met none of its end conditions.
    pub(super) fn is_complete(&self) -> bool {
        let ends = &self.progress.ends;
        ends.len() == self.stages.len() || ends.last().is_some_and(|end| !end.reason.is_asked_for())
    }

    /// Reads a line of the events, `length` bytes with its end.
    pub(super) fn read(&mut self, line: &str, length: u64) -> Result<News, LaboratoryError> {
        let event = Event::from_line(line, &self.stages);
        self.progress.read += length;
        let mut news = News::default();
        match event {
            Some(Event::Began(instant)) => self.begin(instant, &mut news)?,
            Some(Event::Row(instant)) => self.row(instant, &mut news)?,
            Some(Event::Ended(end)) => match end.stage.checked_sub(1).and_then(|at| self.stages.get(at)) {
                None => self.progress.steps_before = end.steps,
                Some(stage) => {
                    let ended = stage_end(stage, &end);
                    self.end(end.stage, ended, &mut news)?;
                }
            },
            Some(Event::Saved(step)) => news.saved = Some(step),
            None => {
                let what = format!("has the line {line:?}, which is none of a deck that granum follows");
                return Err(granum_io::Error::content(&self.place.events(), what).into());
            }
        }
        news.states = news.states.into_iter().map(|state| self.unknown.without_in_state(state)).collect();
        Ok(news)
    }

    fn begin(&mut self, instant: Instant, news: &mut News) -> Result<(), LaboratoryError> {
        self.progress.began = Some(instant);
        let Some(stage) = instant.stage.checked_sub(1).and_then(|at| self.stages.get(at)) else {
            return Ok(());
        };
        let record = &stage.record;
        let origin = match record.measure.counts_from_stage() {
            true => record.measure.value(&instant.macro_state()),
            false => 0.0,
        };
        let recorder = Recorder::of_stage(&self.sensors, &self.case.recording, self.columns, record, origin)?;
        self.progress.recorders.push(recorder);
        self.progress.origins.push(origin);
        news.began = Some(instant.stage);
        // The grains are those of the last dump, which was written where the stage begins.
        let last = self.progress.last.map_or(instant, |last| Instant {
            step: last.step,
            gradient: last.gradient,
            ..instant
        });
        let mut seen = self.seen_at(&last)?;
        seen.assembly.velocity_gradient = [[0.0; 3]; 3];
        seen.assembly.target_mean_stress = None;
        self.observe(&seen, news);
        Ok(())
    }

    fn row(&mut self, instant: Instant, news: &mut News) -> Result<(), LaboratoryError> {
        // A dump is needed until the next row: the stage may end or the next one begin here.
        if let Some(before) = self.progress.last.filter(|before| before.step != instant.step) {
            self.place.remove_dump(before.step)?;
        }
        self.progress.last = Some(instant);
        if instant.stage == 0 || !self.is_due(&instant) {
            return Ok(());
        }
        let seen = self.seen_at(&instant)?;
        let (own, told) = (mean_stress(&seen.assembly), instant.mean_stress());
        if told > 0.0 {
            self.progress.compared += 1;
            self.progress.differences += (own / told - 1.0).powi(2);
        }
        self.progress.time_step_fraction = self.progress.time_step_fraction.max(seen.time_step_fraction);
        self.observe(&seen, news);
        self.take_snapshots(&instant, &seen, news);
        Ok(())
    }

    fn end(&mut self, number: usize, end: StageEnd, news: &mut News) -> Result<(), LaboratoryError> {
        let last = self.last()?;
        let state_there = StageEndRecord::new(number, &end, &last.assembly);
        state_there.add_to(&mut self.progress.stage_ends, self.stages.len());
        if number < self.stages.len() && self.stages.len() <= MOST_STAGES_NOTED && end.reason.is_asked_for() {
            news.snapshots.push((stage_snapshot(number), last.assembly));
        }
        if let Some(recorder) = self.progress.recorders.last_mut() {
            let told = recorder.complete_states();
            recorder.end();
            let rest = told..recorder.states();
            news.states.extend(rest.map(|index| recorder.state(index, number, self.columns)));
        }
        self.progress.ends.push(end.clone());
        news.ended = Some((number, end));
        Ok(())
    }

    /// The grains at the last row.
    pub(super) fn last(&mut self) -> Result<Seen, LaboratoryError> {
        match self.progress.last {
            Some(last) => self.seen_at(&last),
            None => {
                let what = "LAMMPS has not told of any step".to_string();
                Err(granum_io::Error::content(&self.place.events(), what).into())
            }
        }
    }

    fn seen_at(&mut self, instant: &Instant) -> Result<Seen, LaboratoryError> {
        let known = self.seen.take().filter(|(step, _)| *step == instant.step);
        let mut seen = match known {
            Some((_, seen)) => seen,
            None => self.grains.seen(&self.place, instant)?,
        };
        // Strain and time may be counted anew from here.
        let assembly = &mut seen.assembly;
        (assembly.time, assembly.strain, assembly.arc_length) =
            (instant.time, instant.strain, instant.arc_length);
        self.seen = Some((instant.step, seen.clone()));
        Ok(seen)
    }

    /// True if an observation or a snapshot is due, or depends on a stress that only the contacts tell.
    fn is_due(&self, instant: &Instant) -> bool {
        let at = instant.stage - 1;
        let (Some(stage), Some(recorder)) = (self.stages.get(at), self.progress.recorders.get(at)) else {
            return false;
        };
        let measure = stage.record.measure;
        if measure.needs_stress() {
            return true;
        }
        let here = self.here(instant, measure);
        let slack = ROUNDING * here.abs();
        here + slack >= recorder.next_observation()
            || self.progress.snapshots.first().is_some_and(|due| here + slack >= *due)
    }

    fn here(&self, instant: &Instant, measure: Measure) -> f64 {
        let origin = self.progress.origins.get(instant.stage.saturating_sub(1)).copied().unwrap_or(0.0);
        measure.value(&instant.macro_state()) - origin
    }

    fn observe(&mut self, seen: &Seen, news: &mut News) {
        let number = self.progress.recorders.len();
        let Some(recorder) = self.progress.recorders.last_mut() else { return };
        let told = recorder.complete_states();
        recorder.observe(&seen.assembly);
        let complete = told..recorder.complete_states();
        news.states.extend(complete.map(|index| recorder.state(index, number, self.columns)));
    }

    fn take_snapshots(&mut self, instant: &Instant, seen: &Seen, news: &mut News) {
        let Some(stage) = self.stages.get(instant.stage.saturating_sub(1)) else { return };
        let here = self.here(instant, stage.record.measure) * (1.0 + ROUNDING);
        while self.progress.snapshots.first().is_some_and(|due| *due <= here) {
            let name = snapshot_name(self.progress.snapshots.remove(0));
            news.snapshots.push((name, seen.assembly.clone()));
        }
    }

    /// The measurements so far.
    pub(super) fn record(&self) -> Record {
        let record = Recorder::record_of_stages(&self.progress.recorders, self.columns);
        self.unknown.without_in_record(record)
    }

    /// The states so far, without the one under way.
    pub(super) fn states(&self) -> Vec<RecordedState> {
        let mut states = Vec::new();
        for (k, recorder) in self.progress.recorders.iter().enumerate() {
            let over = k < self.progress.ends.len();
            let count = if over { recorder.states() } else { recorder.complete_states() };
            states.extend((0..count).map(|index| recorder.state(index, k + 1, self.columns)));
        }
        states.into_iter().map(|state| self.unknown.without_in_state(state)).collect()
    }

    /// Observations that were asked for and not made.
    pub(super) fn missed(&self) -> MissedObservations {
        let recorders = self.progress.recorders.iter();
        recorders
            .map(Recorder::missed_observations)
            .fold(MissedObservations::default(), MissedObservations::plus)
    }

    /// Number of steps of the test so far.
    pub(super) fn steps(&self) -> u64 {
        let last = self.progress.last.map_or(0, |last| last.step);
        last.saturating_sub(self.progress.steps_before)
    }

    /// Name of the present stage.
    pub(super) fn stage_name(&self) -> &str {
        self.stages.get(self.progress.ends.len()).map_or("", |stage| stage.name.as_str())
    }

    /// How far the test is, for those who follow it.
    pub(super) fn report(&self, speed: Option<f64>) -> Report {
        let instant = self.progress.last.unwrap_or_default();
        let (at, all) = (self.progress.ends.len(), self.stages.len().max(1));
        let part = self.part_of_stage().unwrap_or(0.0);
        let fraction = (instant.stage > 0).then(|| (at as f64 + part) / all as f64);
        let mut report = Report::new(granum_dem::observer::Phase::Test.name(), "steps", self.steps());
        if instant.stage == 0 {
            report = report.part("rest");
        } else {
            report = report.part(self.stage_name());
        }
        let p = instant.mean_stress();
        let ratio = if p > 0.0 { instant.von_mises.abs() / p } else { 0.0 };
        let strain = granum_dem::invariants::deviatoric_strain(&instant.strain);
        let report = report
            .fraction(fraction)
            .with("time", instant.time, "s")
            .with("deviatoric_strain", strain, "")
            .with("von_mises_ratio", ratio, "")
            .with("mean_stress", p, "Pa");
        match speed {
            Some(speed) => report.with("grain_steps_per_second", speed, "1/s"),
            None => report,
        }
    }

    /// The completed part of the present stage, where an end condition tells it.
    fn part_of_stage(&self) -> Option<f64> {
        let (began, last) = (self.progress.began?, self.progress.last?);
        let stage = self.stages.get(last.stage.checked_sub(1)?)?;
        stage.until.iter().find_map(|until| {
            let Until::Reaches { measure, value } = *until else { return None };
            let [start, here] = [began, last].map(|instant| measure.value(&instant.macro_state()));
            let origin = if measure.counts_from_stage() { start } else { 0.0 };
            let way = value + origin - start;
            (way != 0.0).then(|| ((here - start) / way).clamp(0.0, 1.0))
        })
    }
}

/// Mean stress of the contacts, Pa.
fn mean_stress(assembly: &Assembly) -> f64 {
    Measure::MeanStress.value(&granum_dem::loading::MacroState::from_assembly(assembly))
}
