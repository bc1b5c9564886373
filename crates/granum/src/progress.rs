//! Display of progress on standard error: a bar on a terminal, otherwise a plain line every few seconds, and nothing with
//! `--json`.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use granum_io::safe_text;
use granum_run::laboratory::ProgressField;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::messages;

/// Time between plain lines.
const LINE_EVERY: Duration = Duration::from_secs(5);
/// The separator of fields.
const GAP: &str = "  ";
/// Number of columns that a line needs in addition to the phase and the fields: "  42 %  " and the space before the bar.
const AROUND: usize = 9;
/// Number of columns if the terminal does not report it.
const USUAL_COLUMNS: usize = 80;
/// Resolution of the bar.
const LENGTH: u64 = 1000;

/// The room that is available for the fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Room {
    /// A separate line of any length.
    Line,
    /// One line of a terminal.
    Screen,
}

/// A display of progress through phases.
pub struct Progress {
    display: Display,
    phase: String,
    started: Instant,
}

enum Display {
    Silent,
    Bar(ProgressBar),
    Lines { last: Option<Instant> },
}

impl Progress {
    /// A display that suits the kind of standard error, or none if `silent`.
    pub fn new(silent: bool) -> Progress {
        let display = if silent {
            Display::Silent
        } else if std::io::stderr().is_terminal() {
            Display::Bar(bar())
        } else {
            Display::Lines { last: None }
        };
        Progress { display, phase: String::new(), started: Instant::now() }
    }

    /// Starts a phase, e.g. "compaction", "test", "train F1".
    pub fn phase(&mut self, name: impl Into<String>) {
        self.phase = safe_text::line(&name.into()).into_owned();
        self.started = Instant::now();
        match &mut self.display {
            Display::Silent => {}
            Display::Bar(bar) => {
                bar.reset();
                bar.set_prefix(self.phase.clone());
                bar.set_message("");
            }
            Display::Lines { last } => *last = None,
        }
    }

    /// Updates the progress of the phase: the completed fraction, if it is known, and the fields to show, e.g. "strain
    /// 0.120", "q/p 0.61". On a terminal, the fields of the highest rank are dropped if the line is too long. Frequent
    /// calls are cheap.
    pub fn update(&mut self, fraction: Option<f64>, fields: impl FnOnce(Room) -> Vec<ProgressField>) {
        let elapsed = self.started.elapsed();
        let left = fraction.and_then(|fraction| time_left(fraction, elapsed));
        let done = fraction.unwrap_or(0.0).clamp(0.0, 1.0);
        match &mut self.display {
            Display::Silent => {}
            Display::Bar(bar) => {
                let mut fields = fields(Room::Screen);
                fields.extend(left.map(|left| ProgressField::new(0, format!("{left} left"))));
                let taken = self.phase.chars().count() + AROUND;
                bar.set_position((done * LENGTH as f64) as u64);
                let text = fitting(fields, columns().saturating_sub(taken));
                bar.set_message(safe_text::line(&text).into_owned());
            }
            Display::Lines { last } => {
                if last.is_some_and(|last| last.elapsed() < LINE_EVERY) {
                    return;
                }
                *last = Some(Instant::now());
                let percent = fraction.map_or(String::new(), |_| format!(" {:.0} %", 100.0 * done));
                let mut fields = fields(Room::Line);
                fields.extend(left.map(|left| ProgressField::new(0, format!("{left} left"))));
                messages::line(format_args!("{}{percent}: {}", self.phase, fitting(fields, usize::MAX)));
            }
        }
    }

    /// Ends a phase with a permanent line.
    pub fn end(&mut self, text: impl FnOnce() -> String) {
        let line = |phase: &str, text: String, elapsed| format!("{phase}: {text} ({})", readable(elapsed));
        match &self.display {
            Display::Silent => {}
            Display::Bar(bar) => {
                bar.println(safe_text::terminal(&line(&self.phase, text(), self.started.elapsed())));
            }
            Display::Lines { .. } => messages::line(line(&self.phase, text(), self.started.elapsed())),
        }
    }
}

impl Progress {
    /// Calls `print`, which prints lines, while the bar is not on the screen: they would otherwise begin behind it.
    pub fn aside(&self, print: impl FnOnce()) {
        match &self.display {
            Display::Bar(bar) => bar.suspend(print),
            Display::Silent | Display::Lines { .. } => print(),
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Display::Bar(bar) = &self.display {
            bar.finish_and_clear();
        }
    }
}

fn bar() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(LENGTH), ProgressDrawTarget::stderr_with_hz(5));
    // The template is constant; without it only the appearance of the bar would suffer.
    if let Ok(style) = ProgressStyle::with_template("{prefix} {percent:>3} %  {msg} {wide_bar}") {
        bar.set_style(style.progress_chars("=>-"));
    }
    bar
}

/// Number of columns of the terminal.
fn columns() -> usize {
    console::Term::stderr().size_checked().map_or(USUAL_COLUMNS, |(_, columns)| columns.into())
}

/// The fields in one line of at most so many columns; if it is too long, the fields of the highest rank are dropped first.
fn fitting(mut fields: Vec<ProgressField>, columns: usize) -> String {
    loop {
        let line = fields.iter().map(|field| field.text.as_str()).collect::<Vec<_>>().join(GAP);
        let worst = fields.iter().map(|field| field.rank).max().unwrap_or(0);
        if line.chars().count() <= columns || worst == 0 {
            return line;
        }
        fields.retain(|field| field.rank < worst);
    }
}

/// Estimate of the remaining time from the mean rate so far; `None` until there is a rate.
fn time_left(fraction: f64, elapsed: Duration) -> Option<String> {
    if !(fraction > 0.005 && fraction <= 1.0) || elapsed < Duration::from_millis(500) {
        return None;
    }
    Some(readable(elapsed.mul_f64((1.0 - fraction) / fraction)))
}

/// A readable time such as "48 s", "3 min 20 s" or "2 h 05 min".
pub fn readable(time: Duration) -> String {
    let seconds = time.as_secs_f64();
    let whole = seconds.round() as u64;
    match whole {
        0..10 => format!("{seconds:.1} s"),
        10..60 => format!("{whole} s"),
        60..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole % 3600 / 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_readable() {
        let shown = |seconds| readable(Duration::from_secs_f64(seconds));
        assert_eq!(
            [shown(0.26), shown(59.4), shown(200.0), shown(7500.0)],
            ["0.3 s", "59 s", "3 min 20 s", "2 h 05 min"]
        );
    }

    #[test]
    fn a_line_of_eighty_columns_keeps_strain_density_speed_and_time_left() {
        let fields = || {
            [(1, "strain 0.123"), (2, "q/p 0.612"), (3, "p 20.0 kPa"), (0, "density 0.620"), (0, "18.4 M/s")]
                .into_iter()
                .chain([(0, "59 min 59 s left")])
                .map(|(rank, text)| ProgressField::new(rank, text))
                .collect::<Vec<_>>()
        };
        let room = |phase: &str, columns: usize| columns - phase.len() - AROUND;
        let line = fitting(fields(), room("test", 80));
        assert_eq!(line, "strain 0.123  q/p 0.612  density 0.620  18.4 M/s  59 min 59 s left");
        assert_eq!(fitting(fields(), room("test", 100)).matches("p 20.0 kPa").count(), 1);
        let mut many = vec![ProgressField::new(0, "seed 11"), ProgressField::new(4, "relaxation")];
        many.extend(fields());
        let line = fitting(many, room("DEM", 80));
        assert_eq!(line, "seed 11  strain 0.123  density 0.620  18.4 M/s  59 min 59 s left");
        assert_eq!(fitting(fields(), 1), "density 0.620  18.4 M/s  59 min 59 s left");
    }

    #[test]
    fn time_left_follows_the_mean_rate() {
        assert_eq!(time_left(0.25, Duration::from_secs(10)).as_deref(), Some("30 s"));
        assert_eq!(time_left(0.0, Duration::from_secs(10)), None);
        assert_eq!(time_left(f64::NAN, Duration::from_secs(10)), None);
        assert_eq!(time_left(0.5, Duration::ZERO), None);
    }
}
