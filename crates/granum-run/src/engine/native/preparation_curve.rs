//! The history of a preparation: the evolution of stress, density and contacts, as a table in the folder of the sample.

use granum_dem::observer::SimulationProgress;
use granum_dem::preparation::{Phase, Sample};
use granum_dem::simulation::Simulation;
use granum_io::{Column, ColumnKind, Table};
use serde::{Deserialize, Serialize};

/// Largest number of rows. When it is reached, every second row is dropped, and from then on only every second observation
/// is stored.
const MOST_ROWS: usize = 1000;

/// Name and unit of the columns. The first three are integers.
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

/// Rows of a preparation, evenly spaced over its observations, independently of interruptions.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct PreparationCurve {
    rows: Vec<Row>,
    /// Observations so far.
    seen: u64,
    /// Base-two logarithm of the number of observations for each row.
    thinned: u32,
    /// Trial, phase and step of the last observation, which a resumed preparation reports a second time.
    last: Option<(usize, u8, u64)>,
}

/// The number that represents a phase in the table.
fn number(phase: Phase) -> u8 {
    match phase {
        Phase::Compaction => 0,
        Phase::Relaxation => 1,
        Phase::Consolidation => 2,
        Phase::Test => 3,
        Phase::Cycles => 4,
        Phase::PreparationStage => 5,
        // Nothing is observed while grains are placed.
        Phase::Placing => 6,
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
    /// Stores a row if one is due.
    pub(super) fn observe(&mut self, progress: &SimulationProgress) {
        // Other engines have no preparation of their own.
        let Some(simulation) = progress.simulation() else { return };
        let phase = number(progress.phase);
        let here = Some((progress.trial, phase, progress.steps));
        if self.last == here {
            return;
        }
        self.last = here;
        self.seen += 1;
        // The shift must not overflow, even if the checkpoint has been altered.
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
        self.rows.push(row(simulation, progress.trial, phase, progress.steps, progress.time));
    }

    /// Stores the final state of a preparation or consolidation as a row.
    pub(super) fn end(&mut self, sample: &Sample, phase: Phase) {
        let trial = sample.trials.len().max(1);
        self.rows.push(row(&sample.simulation, trial, number(phase), sample.steps, sample.time));
    }

    /// The rows as a table, or `None` if nothing has been observed.
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
