//! One case: it is run twice in different ways, and its results are checked.

use granum_io::RunKind;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

use granum_core::Table;
use granum_dem::Isa;
use granum_dem::simulation::{Hardware, Simulation};
use granum_io::{Case, RunFolder, RunRecord, RunStatus};
use granum_run::laboratory::{CHECKPOINT, Laboratory, Source};
use granum_run::{Flow, SimulationObserver, SimulationProgress};

use crate::draw::Way;

/// Time limit of a run; a case that takes longer is given up.
pub const LONGEST: Duration = Duration::from_secs(120);
/// Tolerated gap of the energy balance of a quasi-static test.
const GAP: f64 = 1e-3;
/// Additional tolerance as a fraction of the loss in the dashpots. The dashpots use velocities that are half a step old, so
/// that their loss is overestimated by up to a quarter of `(w dt)^2`. This matters where they dissipate most of the work,
/// that is without friction.
const GAP_OF_DASHPOTS: f64 = 0.01;
/// The quality flags that decide whether a test was quasi-static.
const QUASI_STATIC: [&str; 6] = [
    "inertial_number",
    "unbalanced_force",
    "servo_error_rms",
    "servo_error_largest",
    "mean_stress_lost",
    "time_step_fraction",
];

/// The result of a case.
#[derive(Default)]
pub struct Outcome {
    pub runs: u64,
    pub grain_steps: f64,
    pub given_up: bool,
    pub reported: Option<String>,
    pub flags: Vec<String>,
    pub quasi_static: bool,
    pub energy_gap: Option<f64>,
    pub failure: Option<String>,
}

/// An observer that stops a run after a number of observations, or when it takes too long.
struct Stopper {
    observations: u64,
    stop_at: u64,
    since: Instant,
}

impl SimulationObserver for Stopper {
    fn progress(&mut self, _: &SimulationProgress) -> Flow {
        self.observations += 1;
        let over = self.observations >= self.stop_at || self.since.elapsed() > LONGEST;
        if over { Flow::Stop } else { Flow::Continue }
    }
}

/// Runs a case in a temporary folder. `place` is the fraction of the run, from 0 to 1, after which it is interrupted in the
/// case of [`Way::Interrupted`].
pub fn trial(case: &Case, way: Way, place: f64) -> Outcome {
    let mut outcome = Outcome::default();
    let work = AssertUnwindSafe(|| attempt(case, way, place, &mut outcome));
    match catch_unwind(work) {
        Ok(Ok(())) => {}
        Ok(Err(why)) => outcome.failure = Some(why),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().cloned();
            let text = text.or_else(|| panic.downcast_ref::<&str>().map(ToString::to_string));
            outcome.failure = Some(format!("panic: {}", text.unwrap_or_default()));
        }
    }
    outcome
}

fn attempt(case: &Case, way: Way, place: f64, outcome: &mut Outcome) -> Result<(), String> {
    let base = tempfile::tempdir().map_err(|error| error.to_string())?;
    case.check().map_err(|error| format!("the draw is no case: {error}"))?;
    let one = folder(base.path(), "one")?;
    let mut stopper = Stopper { observations: 0, stop_at: u64::MAX, since: Instant::now() };
    let hardware = Hardware::default();
    let Some(record) = run(case, hardware, &one, &mut stopper, outcome)? else { return Ok(()) };
    look_over(case, &one, &record, outcome)?;
    let other = match way {
        Way::Plain => return Ok(()),
        Way::Interrupted => hardware,
        Way::TwoThreads => Hardware { threads: 2, ..hardware },
        Way::Portable => Hardware { isa: Isa::Portable, ..hardware },
    };
    let stop_at =
        if way == Way::Interrupted { 1 + (place * stopper.observations as f64) as u64 } else { u64::MAX };
    let two = folder(base.path(), "two")?;
    let mut again = Stopper { observations: 0, stop_at, since: Instant::now() };
    let Some(record) = run(case, other, &two, &mut again, outcome)? else { return Ok(()) };
    if record.status == RunStatus::Interrupted {
        let mut rest = Stopper { observations: 0, stop_at: u64::MAX, since: Instant::now() };
        let record = laboratory(hardware).resume(&two, &mut rest).map_err(|error| error.to_string())?;
        if record.status != RunStatus::Finished {
            outcome.given_up = true;
            return Ok(());
        }
    }
    for name in ["series.parquet", "forces.parquet", CHECKPOINT] {
        let read = |folder: &RunFolder| std::fs::read(folder.path().join(name)).map_err(|e| e.to_string());
        if read(&one)? != read(&two)? {
            return Err(format!("{name} has other bytes"));
        }
    }
    Ok(())
}

fn folder(base: &Path, name: &str) -> Result<RunFolder, String> {
    RunFolder::create(base.join(name), false).map_err(|error| error.to_string())
}

fn laboratory(hardware: Hardware) -> Laboratory {
    let mut laboratory = Laboratory::new(hardware, "soak");
    laboratory.resources.grains_per_thread = 1;
    laboratory.resources.checkpoint_every = Duration::from_secs(5);
    laboratory
}

/// Runs the case; `None` if it took too long.
fn run(
    case: &Case,
    hardware: Hardware,
    folder: &RunFolder,
    stopper: &mut Stopper,
    outcome: &mut Outcome,
) -> Result<Option<RunRecord>, String> {
    outcome.runs += 1;
    let record = match laboratory(hardware).run(RunKind::Test, case, &Source::Case, folder, stopper) {
        Ok(record) => record,
        Err(error) => {
            let text = error.to_string();
            // The first words of the message, up to the first number, serve to count errors of the same kind.
            let kind = text.split([' ', ',']).take_while(|word| !word.contains(|c: char| c.is_ascii_digit()));
            outcome.reported = Some(kind.collect::<Vec<_>>().join(" "));
            return Err(text);
        }
    };
    outcome.grain_steps += record.grain_steps() as f64;
    let early = record.status == RunStatus::Interrupted && stopper.observations < stopper.stop_at;
    outcome.given_up |= early;
    Ok((!early).then_some(record))
}

/// The work of the boundary and the loss in the dashpots, both over the reference of the energy gap. The reference is the
/// work of the boundary, but at least a tenth of the mean stress times volume and strain, since over a short strain the
/// works of compression and shear may nearly cancel.
fn of_the_work(case: &Case, folder: &RunFolder) -> Result<[f64; 2], String> {
    let bytes = std::fs::read(folder.path().join(CHECKPOINT)).map_err(|error| error.to_string())?;
    let (simulation, _) = Simulation::restore(&bytes).map_err(|error| error.to_string())?;
    let state = simulation.state();
    let work = state.energy().boundary_work.abs();
    let strain = case.test_definition().deviator_strain_end().map_or(state.arc_length(), f64::abs);
    let least = 0.1 * state.mean_stress() * state.cell().volume() * strain;
    Ok([work, state.energy().damping].map(|energy| energy / work.max(least)))
}

/// Checks that the liquid of films and bridges is conserved, where there is any.
fn check_liquid(series: &Table) -> Result<(), String> {
    let [Ok(films), Ok(bridges)] = ["film_volume", "bridge_volume"].map(|name| series.column(name)) else {
        return Ok(());
    };
    let first = films.first().zip(bridges.first()).map_or(0.0, |(film, bridge)| film + bridge);
    for (film, bridge) in films.iter().zip(bridges) {
        let change = (film + bridge) / first - 1.0;
        if change.is_nan() || change.abs() > 1e-11 {
            return Err(format!("the volume of liquid changed by a fraction of {change:.2e}"));
        }
    }
    Ok(())
}

/// Checks that no result is NaN or infinite and that the energy balance closes.
fn look_over(
    case: &Case,
    folder: &RunFolder,
    record: &RunRecord,
    outcome: &mut Outcome,
) -> Result<(), String> {
    if record.status != RunStatus::Finished {
        return Err(format!("it ended as {:?}", record.status));
    }
    let tables = [folder.run().series(), folder.run().forces()];
    for table in tables {
        let table = table.map_err(|error| error.to_string())?;
        for column in table.columns() {
            if let Some(row) = column.values.iter().position(|value| !value.is_finite()) {
                return Err(format!("{} is {} in row {row}", column.name, column.values[row]));
            }
        }
    }
    check_liquid(&folder.run().series().map_err(|error| error.to_string())?)?;
    if let Some((name, value)) = record.measures.iter().find(|(_, value)| !value.is_finite()) {
        return Err(format!("{name} is {value}"));
    }
    let failed = |name: &str| record.quality.iter().any(|flag| flag.name == name && !flag.passed);
    outcome.quasi_static = !QUASI_STATIC.iter().any(|name| failed(name));
    outcome.flags = record.quality.iter().filter(|flag| !flag.passed).map(|flag| flag.name.clone()).collect();
    let gap = record.quality.iter().find(|flag| flag.name == "energy_gap").map(|flag| flag.value);
    // Global damping takes energy that is not counted.
    if gap.is_none() && case.test_stages().iter().any(|stage| stage.settling) {
        return Ok(());
    }
    let [work, damping] = of_the_work(case, folder)?;
    let gap = gap.ok_or("it says nothing of its energy")? * work;
    outcome.energy_gap = Some(gap);
    if outcome.quasi_static && (gap.is_nan() || gap > GAP + GAP_OF_DASHPOTS * damping) {
        return Err(format!("the energy balance of a quasi-static test has a gap of {gap:.2e}"));
    }
    Ok(())
}
