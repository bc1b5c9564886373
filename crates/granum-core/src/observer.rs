//! Observers of long work: one trait that shows the progress of runs, trainings and fits, hears their events, and can stop
//! them.
//!
//! What an observer receives is owned data that can be serialised, so that it can be shown, logged, or sent to another
//! process. A crate whose observers need more than that has a trait of its own that is built on this one:
//! `granum_dem::observer::SimulationObserver` also gives access to the simulation, for sensors.

use std::borrow::Cow;
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};

/// The request of an observer: to continue, or to stop in good order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Flow {
    /// Continue.
    Continue,
    /// Stop at this point.
    Stop,
}

impl Flow {
    /// The request of two observers: to continue only if both request it.
    pub fn and(self, other: Flow) -> Flow {
        if self == Flow::Continue { other } else { Flow::Stop }
    }
}

/// A value with its name and unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NamedValue {
    /// Its name, e.g. `time` or `error`.
    pub name: Cow<'static, str>,
    /// The value; a NaN is null in JSON.
    #[serde(deserialize_with = "null_is_nan")]
    pub value: f64,
    /// SI unit; empty for a pure number.
    pub unit: Cow<'static, str>,
}

fn null_is_nan<'d, D: serde::Deserializer<'d>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(from)?.unwrap_or(f64::NAN))
}

/// The progress of some work at one moment.
///
/// ```
/// use granum_core::observer::Progress;
///
/// let progress = Progress::new("training", "epochs", 25).out_of(100).part("stress_ratio").with("error", 1.5e-3, "");
/// assert_eq!(progress.completed(), Some(0.25));
/// assert_eq!(progress.value("error"), Some(1.5e-3));
/// assert_eq!(progress.to_string(), "training stress_ratio: 25 of 100 epochs, error 1.50e-3");
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Progress {
    /// What is being done, e.g. `compaction`, `shear` or `training`.
    pub activity: Cow<'static, str>,
    /// The part of the work that is in progress: the name of a stage, a network or a run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// What is counted, in the plural: `steps`, `epochs`.
    pub counted: Cow<'static, str>,
    /// How many of them are complete.
    pub done: u64,
    /// How many of them there are at most, if that is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of: Option<u64>,
    /// Fraction of the activity that is complete, if it can be determined in another way than by counting.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fraction: Option<f64>,
    /// Values that describe the present state of the work.
    #[serde(default)]
    pub values: Vec<NamedValue>,
}

impl Progress {
    /// The progress of an activity of which so many steps, epochs or other pieces are complete.
    pub fn new(
        activity: impl Into<Cow<'static, str>>,
        counted: impl Into<Cow<'static, str>>,
        done: u64,
    ) -> Progress {
        Progress {
            activity: activity.into(),
            part: None,
            counted: counted.into(),
            done,
            of: None,
            fraction: None,
            values: Vec::new(),
        }
    }

    /// Sets the largest number of pieces.
    pub fn out_of(self, most: u64) -> Progress {
        Progress { of: Some(most), ..self }
    }

    /// Sets the part of the work that is in progress.
    pub fn part(self, name: impl Into<String>) -> Progress {
        Progress { part: Some(name.into()), ..self }
    }

    /// Sets the complete fraction.
    pub fn fraction(self, fraction: Option<f64>) -> Progress {
        Progress { fraction, ..self }
    }

    /// Adds a value.
    pub fn with(mut self, name: impl Into<Cow<'static, str>>, value: f64, unit: &'static str) -> Progress {
        self.values.push(NamedValue { name: name.into(), value, unit: unit.into() });
        self
    }

    /// The value of the given name.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.values.iter().find(|value| value.name == name).map(|value| value.value)
    }

    /// Fraction of the activity that is complete, where it can be determined.
    pub fn completed(&self) -> Option<f64> {
        let counted = || self.of.filter(|most| *most > 0).map(|most| self.done as f64 / most as f64);
        self.fraction.or_else(counted)
    }
}

impl std::fmt::Display for Progress {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(&self.activity)?;
        if let Some(part) = &self.part {
            write!(f, " {part}")?;
        }
        write!(f, ": {}", self.done)?;
        if let Some(most) = self.of {
            write!(f, " of {most}")?;
        }
        write!(f, " {}", self.counted)?;
        for NamedValue { name, value, unit } in &self.values {
            write!(f, ", {name} {value:.2e}")?;
            if !unit.is_empty() {
                write!(f, " {unit}")?;
            }
        }
        Ok(())
    }
}

/// Something that happened during some work.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "snake_case")]
#[non_exhaustive]
pub enum Event {
    /// A stage of a test starts, or is resumed.
    StageStarted {
        /// Number of the stage, from 1.
        number: usize,
    },
    /// A state of a test was recorded.
    StateRecorded {
        /// The values of the columns of its series, `state` and `stage` among them.
        values: Vec<NamedValue>,
    },
    /// A stage of a test ended.
    StageEnded {
        /// Number of the stage, from 1.
        number: usize,
        /// Its name.
        name: String,
        /// Number of its steps.
        steps: u64,
        /// Why it ended, in words.
        reason: String,
    },
    /// A part of the work is complete, such as one of several networks.
    PartCompleted {
        /// Its name.
        part: String,
    },
    /// Something that the user should know and that does not end the work.
    Warning {
        /// What it is.
        text: String,
    },
}

/// Follows some work. It can stop the work, but cannot change its result in any other way.
///
/// Every method has a default, so that an observer implements only the methods that it needs. A closure that takes a
/// [`Progress`] and returns a [`Flow`] is an observer.
///
/// ```
/// use granum_core::observer::{Event, Flow, Observer, Progress};
///
/// /// Notes everything as lines of JSON, and stops after the third epoch.
/// #[derive(Default)]
/// struct Log(Vec<String>);
///
/// impl Observer for Log {
///     fn progress(&mut self, progress: &Progress) -> Flow {
///         self.0.push(serde_json::to_string(progress).unwrap());
///         if progress.done < 3 { Flow::Continue } else { Flow::Stop }
///     }
///     fn event(&mut self, event: &Event) {
///         self.0.push(serde_json::to_string(event).unwrap());
///     }
/// }
///
/// let mut log = Log::default();
/// assert_eq!(log.progress(&Progress::new("training", "epochs", 3)), Flow::Stop);
/// log.event(&Event::Warning { text: "few rows".into() });
/// assert_eq!(log.0[1], r#"{"event":"warning","text":"few rows"}"#);
/// assert_eq!(serde_json::from_str::<Progress>(&log.0[0]).unwrap().done, 3);
/// ```
pub trait Observer: Send {
    /// Called at regular intervals; returns whether to continue or to stop.
    fn progress(&mut self, progress: &Progress) -> Flow {
        let _ = progress;
        Flow::Continue
    }

    /// Called when something happened.
    fn event(&mut self, event: &Event) {
        let _ = event;
    }
}

/// The observer of work that none follows.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoObserver;

impl Observer for NoObserver {}

impl<F: FnMut(&Progress) -> Flow + Send> Observer for F {
    fn progress(&mut self, progress: &Progress) -> Flow {
        self(progress)
    }
}

/// Several observers as one: they are called one after the other, and the work stops if one of them requests it.
pub struct Observers<'a>(pub Vec<&'a mut dyn Observer>);

impl Observer for Observers<'_> {
    fn progress(&mut self, progress: &Progress) -> Flow {
        // Every observer is notified, also after one has requested the stop.
        self.0.iter_mut().fold(Flow::Continue, |flow, observer| flow.and(observer.progress(progress)))
    }

    fn event(&mut self, event: &Event) {
        self.0.iter_mut().for_each(|observer| observer.event(event));
    }
}

/// An observer that several threads share, each of which works on a part with a name. After the observer has requested a
/// stop, every part is stopped at its next report of progress.
///
/// ```
/// use granum_core::observer::{Flow, Observer, Progress, SharedObserver};
///
/// let mut parts = Vec::new();
/// let mut note = |progress: &Progress| {
///     parts.push(progress.part.clone().unwrap_or_default());
///     Flow::Stop
/// };
/// let shared = SharedObserver::new(&mut note);
/// assert_eq!(shared.part("first").progress(&Progress::new("training", "epochs", 1)), Flow::Stop);
/// assert!(shared.stopped());
/// // The second part is stopped without another question to the observer.
/// assert_eq!(shared.part("second").progress(&Progress::new("training", "epochs", 1)), Flow::Stop);
/// drop(shared);
/// assert_eq!(parts, ["first"]);
/// ```
pub struct SharedObserver<'a>(Mutex<Shared<'a>>);

struct Shared<'a> {
    observer: &'a mut dyn Observer,
    stopped: bool,
}

impl<'a> SharedObserver<'a> {
    /// Shares an observer.
    pub fn new(observer: &'a mut dyn Observer) -> SharedObserver<'a> {
        SharedObserver(Mutex::new(Shared { observer, stopped: false }))
    }

    /// The observer of a part, which adds the name of the part to its reports.
    pub fn part(&self, name: impl Into<String>) -> PartObserver<'_, 'a> {
        PartObserver { shared: self, name: name.into() }
    }

    /// True after the observer has requested a stop.
    pub fn stopped(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).stopped
    }
}

/// The observer of a part of some work, see [`SharedObserver::part`].
pub struct PartObserver<'b, 'a> {
    shared: &'b SharedObserver<'a>,
    name: String,
}

impl PartObserver<'_, '_> {
    /// Reports that the part is complete.
    pub fn completed(mut self) {
        let part = std::mem::take(&mut self.name);
        self.event(&Event::PartCompleted { part });
    }
}

impl Observer for PartObserver<'_, '_> {
    fn progress(&mut self, progress: &Progress) -> Flow {
        let mut shared = self.shared.0.lock().unwrap_or_else(PoisonError::into_inner);
        if !shared.stopped {
            let part = match &progress.part {
                Some(inner) => format!("{}, {inner}", self.name),
                None => self.name.clone(),
            };
            shared.stopped = shared.observer.progress(&progress.clone().part(part)) == Flow::Stop;
        }
        if shared.stopped { Flow::Stop } else { Flow::Continue }
    }

    fn event(&mut self, event: &Event) {
        self.shared.0.lock().unwrap_or_else(PoisonError::into_inner).observer.event(event);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Default)]
    struct Count {
        calls: u64,
        stop_at: u64,
        events: Vec<Event>,
    }

    impl Observer for Count {
        fn progress(&mut self, _: &Progress) -> Flow {
            self.calls += 1;
            if self.calls == self.stop_at { Flow::Stop } else { Flow::Continue }
        }
        fn event(&mut self, event: &Event) {
            self.events.push(event.clone());
        }
    }

    #[test]
    fn all_are_told_and_one_can_stop() {
        let (mut first, mut second) = (Count { stop_at: 1, ..Count::default() }, Count::default());
        let mut both = Observers(vec![&mut first, &mut second]);
        assert_eq!(both.progress(&Progress::new("shear", "steps", 1)), Flow::Stop);
        assert_eq!(both.progress(&Progress::new("shear", "steps", 2)), Flow::Continue);
        both.event(&Event::StageStarted { number: 2 });
        assert_eq!((first.calls, second.calls, first.events == second.events), (2, 2, true));
    }

    #[test]
    fn progress_comes_back_from_json() {
        let progress = Progress::new("shear", "steps", 400).part("load").fraction(Some(0.125)).with(
            "time",
            0.1 + 0.2,
            "s",
        );
        let text = serde_json::to_string(&progress).unwrap();
        assert_eq!(serde_json::from_str::<Progress>(&text).unwrap(), progress, "{text}");
        assert_eq!(progress.completed(), Some(0.125));
        assert_eq!(progress.to_string(), "shear load: 400 steps, time 3.00e-1 s");
        assert_eq!(Progress::new("shear", "steps", 0).completed(), None);
    }

    #[test]
    fn events_come_back_from_json() {
        let value = |name: &'static str, value| NamedValue { name: name.into(), value, unit: "".into() };
        let recorded =
            Event::StateRecorded { values: vec![value("state", 3.0), value("stress_ratio", f64::NAN)] };
        let text = serde_json::to_string(&recorded).unwrap();
        assert!(
            text.starts_with(r#"{"event":"state_recorded","values":[{"name":"state","value":3.0"#),
            "{text}"
        );
        let Event::StateRecorded { values } = serde_json::from_str(&text).unwrap() else { panic!("{text}") };
        assert!(values[0] == value("state", 3.0) && values[1].value.is_nan());
        let (name, reason) = ("load".to_string(), "reached 0.1".to_string());
        let ended = Event::StageEnded { number: 2, name, steps: 400, reason };
        let text = serde_json::to_string(&ended).unwrap();
        assert_eq!(serde_json::from_str::<Event>(&text).unwrap(), ended);
    }

    #[test]
    fn threads_share_an_observer_until_it_stops() {
        let mut count = Count { stop_at: 20, ..Count::default() };
        let shared = SharedObserver::new(&mut count);
        let steps: Vec<u64> = crate::parallel::map(4, 4, |k| {
            let mut part = shared.part(format!("part {k}"));
            let mut steps = 0;
            while part.progress(&Progress::new("work", "steps", steps)) == Flow::Continue {
                steps += 1;
            }
            part.completed();
            Ok::<u64, ()>(steps)
        })
        .unwrap();
        assert!(shared.stopped());
        // Nineteen reports were answered with Continue.
        assert_eq!(steps.iter().sum::<u64>(), 19);
        assert_eq!((count.calls, count.events.len()), (20, 4));
    }
}
