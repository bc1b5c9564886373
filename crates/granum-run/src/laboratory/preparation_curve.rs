//! The history of a preparation: how stress, density and contacts grew, as a table of the sample's folder.

use granum_dem::observer::Progress;
use granum_dem::preparation::{Phase, Sample};
use granum_dem::simulation::Simulation;
use granum_io::{Column, ColumnKind, Table};
use serde::{Deserialize, Serialize};

/// Most rows; where more come, every second is dropped and from then on only every second taken.
const MOST_ROWS: usize = 1000;

/// Name and unit of the columns. The first three are whole numbers.
pub const PREPARATION_COLUMNS: [(&str, &str); 9] = [
    ("trial", ""),
    ("phase", ""),
    ("step", ""),
    ("time", "s"),
    ("mean_stress", "Pa"),
    ("solid_fraction", ""),
    ("coordination_number", ""),
    ("unbalanced_force", ""),
    ("kinetic_mean_stress", "Pa"),
];
const WHOLE: usize = 3;

/// One row, in the order of [`PREPARATION_COLUMNS`].
type Row = [f64; PREPARATION_COLUMNS.len()];

/// Rows of a preparation, evenly spaced over its observations whatever stops it in between.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct PreparationCurve {
    rows: Vec<Row>,
    /// Observations so far.
    seen: u64,
    /// One of two to the power of this many observations is a row.
    thinned: u32,
    /// Trial, phase and step of the last observation: a preparation that goes on shows it again.
    last: Option<(usize, u8, u64)>,
}

/// The number that stands for a phase in the table.
fn number(phase: Phase) -> u8 {
    match phase {
        Phase::Compaction => 0,
        Phase::Relaxation => 1,
        Phase::Consolidation => 2,
        Phase::Shear => 3,
    }
}

fn row(simulation: &Simulation, trial: usize, phase: u8, steps: u64, time: f64) -> Row {
    let state = simulation.state();
    [
        trial as f64,
        f64::from(phase),
        steps as f64,
        time,
        state.mean_stress(),
        state.solid_fraction(),
        2.0 * state.contacts() as f64 / state.grains() as f64,
        state.unbalanced_force(),
        state.kinetic_mean_stress(),
    ]
}

impl PreparationCurve {
    /// Takes a row, if one is due.
    pub(super) fn observe(&mut self, progress: &Progress) {
        let phase = number(progress.phase);
        let here = Some((progress.trial, phase, progress.steps));
        if self.last == here {
            return;
        }
        self.last = here;
        self.seen += 1;
        // A checkpoint that was tampered with must not make the shift overflow.
        if !(self.seen - 1).is_multiple_of(1 << self.thinned.min(60)) {
            return;
        }
        if self.rows.len() >= MOST_ROWS {
            let mut keep = false;
            self.rows.retain(|_| {
                keep = !keep;
                keep
            });
            self.thinned += 1;
        }
        self.rows.push(row(progress.simulation, progress.trial, phase, progress.steps, progress.time));
    }

    /// Takes the end of a preparation or consolidation as a row.
    pub(super) fn end(&mut self, sample: &Sample, phase: Phase) {
        let trial = sample.trials.len().max(1);
        self.rows.push(row(&sample.simulation, trial, number(phase), sample.steps, sample.time));
    }

    /// The rows as a table; none where nothing was observed.
    pub(super) fn table(&self) -> granum_io::Result<Option<Table>> {
        if self.rows.is_empty() {
            return Ok(None);
        }
        let column = |(k, (name, unit)): (usize, &(&str, &str))| {
            let kind = if k < WHOLE { ColumnKind::Integer } else { ColumnKind::Real };
            Column::new(*name, *unit, self.rows.iter().map(|row| row[k]).collect()).of_kind(kind)
        };
        Ok(Some(Table::new(PREPARATION_COLUMNS.iter().enumerate().map(column).collect())?))
    }
}
