//! `granum stiffness`: the small-strain stiffness of a state, or of chosen states of a test.

use granum_io::RunKind;

use std::path::PathBuf;

use clap::Args;
use granum_core::quantity::{Dimension, parse_quantity};
use granum_core::{ObservedState, Table};
use granum_dem::simulation::Simulation;
use granum_io::shell::ShowPath;
use granum_run::stiffness::{Probed, Probes, Probing, degradation, degradation_table, table};
use granum_run::{Laboratory, SimulationObservers, Source};
use serde_json::{Value, json};

use super::case_flags::CaseFlags;
use super::hardware::{HardwareFlags, Show};
use crate::context::Context;
use crate::failure::{Failure, Interrupted};
use crate::numbers::rounded;
use crate::output;

/// Measure the elastic stiffness (6 x 6) of a sample or of the end of a test, or at chosen strains of the test of a case.
///
/// Small strains are applied to copies of the state, forward and backward, and the grains come to rest; a test goes on as if
/// nothing had been measured. Each row of the table has the bulk and shear modulus, Young's moduli, the anisotropy, the moduli of
/// grains that follow the strain of the cell (effective medium), and the tensor.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum prepare my-sand.toml --out sample\n  granum stiffness sample\n  granum stiffness sample --degradation 0.01 \
                  --output curve.csv\n  granum stiffness my-sand.toml --sample sample --at 0,0.001,0.01,0.1 --output stiffness.csv"
)]
pub struct MeasureStiffness {
    /// The folder of a sample or of a run, or a case file (with --at).
    data: PathBuf,
    /// Run the test of the case and measure at these values of the measure by which it is recorded: deviator strains of
    /// [shear], or the measure of the stage.
    #[arg(long, value_name = "STRAINS", conflicts_with = "degradation")]
    at: Option<String>,
    /// The stage in which to measure, from 1.
    #[arg(long, value_name = "N", requires = "at", default_value_t = 1)]
    stage: usize,
    /// Sample for the test of the case: a folder that `granum prepare` wrote.
    #[arg(long, value_name = "DIR", requires = "at")]
    sample: Option<PathBuf>,
    /// Size of the strains.
    #[arg(long, value_name = "STRAIN", default_value_t = Probing::default().strain)]
    strain: f64,
    /// Let contacts slide: a tangent stiffness at this size of strain in place of the elastic one.
    #[arg(long)]
    sliding: bool,
    /// Measure the secant shear modulus up to this deviatoric strain, at constant volume: five strains a decade, the first is --strain.
    #[arg(long, value_name = "STRAIN")]
    degradation: Option<f64>,
    /// Where to write the table (CSV or Parquet by extension).
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    flags: CaseFlags,
    #[command(flatten)]
    hardware: HardwareFlags,
}

impl MeasureStiffness {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let _alone = context.nothing_written(Some("measuring the stiffness"));
        let laboratory = Laboratory::new(self.hardware.hardware()?, env!("CARGO_PKG_VERSION"));
        let probing = Probing { strain: self.strain, elastic: !self.sliding, ..Probing::default() };
        if let Some(at) = &self.at {
            let rows = self.in_test(context, &laboratory, strains(at)?, probing)?;
            return self.put(context, &rows);
        }
        if !self.data.is_dir() {
            return Err(Failure::new(format!(
                "{}: is no folder; give the folder of a sample or a run, or a case with --at and the strains at which to measure",
                self.data.shown()
            )));
        }
        let simulation = laboratory.last_state(&self.data)?;
        match self.degradation {
            Some(end) => self.curve(context, &simulation, end, &probing),
            None => self.put(context, &[Probed::from_simulation(&simulation, &probing)?]),
        }
    }

    /// Runs the test of the case, as far as it is needed.
    fn in_test(
        &self,
        context: &Context,
        laboratory: &Laboratory,
        at: Vec<f64>,
        probing: Probing,
    ) -> Result<Vec<Probed>, Failure> {
        if self.data.is_dir() {
            return Err(Failure::new(format!(
                "{}: is a folder; --at needs a case file, whose test it runs",
                self.data.shown()
            )));
        }
        let case = self.flags.read(context, &self.data, false)?;
        let source = self.sample.clone().map_or(Source::Case, Source::Folder);
        let mut show = Show::new(context);
        let mut probes = Probes::new(self.stage, at, probing);
        let mut until = Until { probes: &mut probes };
        let mut observers = SimulationObservers(vec![&mut show, &mut until]);
        let planned = laboratory.plan(RunKind::Test, &case, &source, &mut observers);
        let test = planned.and_then(|planned| planned.in_memory(&mut observers));
        // Warnings would begin behind the bar.
        drop(show);
        let left = probes.due().to_vec();
        let rows = probes.finish()?;
        test?;
        if rows.is_empty() && context.flow() == granum_run::Flow::Stop {
            return Err(Interrupted { left: "nothing was written".into() }.into());
        }
        if !left.is_empty() {
            context.warn(&format!("--at {left:?}: stage {} of the test ends before", self.stage));
        }
        Ok(rows)
    }

    /// The secant shear modulus over the strain.
    fn curve(
        &self,
        context: &Context,
        simulation: &Simulation,
        end: f64,
        probing: &Probing,
    ) -> Result<(), Failure> {
        if !(self.strain..=0.5).contains(&end) {
            return Err(Failure::new(format!("--degradation {end}: from --strain {} to 0.5", self.strain)));
        }
        // Renard's series of five a decade; its factors are decimals, so that every machine takes the same strains.
        let decades = (0..9).map(granum_report::figure::ticks::power_of_ten);
        let series =
            decades.flat_map(|decade| [1.0, 1.6, 2.5, 4.0, 6.3].map(|part| part * decade * self.strain));
        let mut strains: Vec<f64> = series.take_while(|strain| *strain < 0.999 * end).collect();
        strains.push(end);
        let curve = degradation(simulation, &strains, probing)?;
        let unsettled = curve.iter().filter(|point| !point.settled).count();
        if unsettled > 0 {
            context.warn(&format!(
                "at {unsettled} strains the stress did not come to rest: their moduli are too high"
            ));
        }
        output::put_table(context, self.output.as_deref(), &degradation_table(&curve))
    }

    fn put(&self, context: &Context, rows: &[Probed]) -> Result<(), Failure> {
        if let Some(row) = rows.iter().find(|row| !row.stiffness.settled) {
            context.warn(&format!(
                "at a deviator strain of {}: a response still changed by {:.1e} of itself in the last steps",
                rounded(row.deviator_strain, 4),
                row.stiffness.unsettled
            ));
        }
        let table = table(rows);
        if self.output.is_some() {
            return output::put_table(context, self.output.as_deref(), &table);
        }
        output::say(context, &as_json(&table), || rows.iter().map(text).collect::<Vec<_>>().join("\n\n"))
    }
}

/// The probes of a test, which ends once all have been made.
struct Until<'a> {
    probes: &'a mut Probes,
}

impl granum_run::SimulationObserver for Until<'_> {
    fn stage(&mut self, number: usize) {
        self.probes.stage(number);
    }
    fn next_observation(&self) -> f64 {
        self.probes.next_observation()
    }
    fn observe(&mut self, state: &dyn ObservedState) {
        self.probes.observe(state);
    }
    fn progress(&mut self, progress: &granum_run::SimulationProgress) -> granum_run::Flow {
        match self.probes.due().is_empty() {
            true => granum_run::Flow::Stop,
            false => self.probes.progress(progress),
        }
    }
}

/// Rising numbers, as `0, 0.001, 0.01`.
fn strains(text: &str) -> Result<Vec<f64>, Failure> {
    let wrong =
        |why: String| Failure::new(format!("--at {text:?}: {why}; give strains as \"0, 0.001, 0.01\""));
    let read = |item: &str| {
        let value =
            parse_quantity(item.trim(), Dimension::NUMBER).map_err(|why| wrong(format!("{item} {why}")))?;
        if value < 0.0 { Err(wrong(format!("{item} is negative"))) } else { Ok(value) }
    };
    text.split(',').map(read).collect()
}

fn as_json(table: &Table) -> Value {
    json!({ "states": table.rows(), "columns": output::columns(table) })
}

fn text(row: &Probed) -> String {
    let found = &row.stiffness;
    let (tensor, affine) = (&found.tensor, &found.affine);
    let mega = |value: f64| format!("{:.4} MPa", value / 1e6);
    let mut lines = vec![
        format!(
            "deviator strain {:.6}, void ratio {:.4}, mean stress {:.3} kPa",
            row.deviator_strain,
            row.void_ratio,
            granum_dem::invariants::mean(&found.stress) / 1e3
        ),
        format!(
            "bulk modulus K {} ({:.3} of affine)",
            mega(tensor.bulk_modulus()),
            tensor.bulk_modulus() / affine.bulk_modulus()
        ),
        format!(
            "shear modulus G {} ({:.3} of affine)",
            mega(tensor.shear_modulus()),
            tensor.shear_modulus() / affine.shear_modulus()
        ),
    ];
    if let (Some(young), Some(anisotropy)) = (tensor.youngs_moduli(), tensor.anisotropy()) {
        lines.push(format!("Young's moduli along x, y, z {}", young.map(mega).join(", ")));
        lines.push(format!("universal anisotropy {anisotropy:.4}, asymmetry {:.1e}", tensor.asymmetry()));
    }
    lines.push("stress (rows) by strain (columns), xx yy zz yz zx xy, MPa:".into());
    for row in &tensor.0 {
        lines.push(row.map(|value| format!("{:11.4}", value / 1e6)).join(""));
    }
    lines.join("\n")
}
