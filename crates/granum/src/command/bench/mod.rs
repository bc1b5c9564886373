//! `granum bench`: the measurements of BENCHMARKS.md on the user's computer.

mod arithmetic;
mod dem;
mod learning;
mod nets;
mod timing;

use std::path::PathBuf;

use clap::Args;
use granum_dem::Isa;
use serde_json::json;

use super::hardware::{instruction_set, processors};
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// The packing with which all values of BENCHMARKS.md were measured.
const PACKING: &str = include_str!("../../../data/packing-5000.csv");

/// Measure the speed of this computer: grain-steps per second by law, size, threads and instruction set, and the speed of
/// the networks.
///
/// The packing is sheared at constant volume with an inertial number of 1e-3; larger samples are periodic copies of it.
/// Every figure is the best of several segments of steps, together with the mean of all segments; in each segment all
/// numbers of threads compute the same steps one after another. Their speed-up is printed next to that of arithmetic in
/// registers, which is what the processor itself provides. The contacts a grain and the mean stress are those at the end of the
/// measurement; a packing that has lost its load by then, with fewer than 0.5 contacts a grain, half of its first contacts or a tenth
/// of its first stress, is refused. The measurement takes about a minute on two cores.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum bench\n  granum bench --threads 1,8 --grains 5000,1000000 --json > bench.json\n  granum bench \
                  --only dem --law jkr,mindlin-deresiewicz --time-step 3e-8 --strain-rate 27.5"
)]
pub struct Bench {
    /// The packing (CSV); 5000 equal spheres of 0.1 mm at 20 kPa by default.
    #[arg(long, value_name = "FILE")]
    packing: Option<PathBuf>,
    /// Numbers of threads; by default one, and as many as there are processors.
    #[arg(long, value_name = "N,...", value_delimiter = ',')]
    threads: Vec<usize>,
    /// Instruction set: portable, avx2 or avx512; by default the widest for all figures, and the others for one figure.
    #[arg(long, value_name = "NAME")]
    isa: Option<String>,
    /// Numbers of grains, multiples of that of the packing; by default the packing itself and 20 copies of it.
    #[arg(long, value_name = "N,...", value_delimiter = ',')]
    grains: Vec<usize>,
    /// One set of contact laws, e.g. jkr,mindlin-deresiewicz or hertz,no-slip,elastic-plastic; three sets by default.
    #[arg(long, value_name = "NORMAL,TANGENTIAL")]
    law: Option<String>,
    /// Time for each figure, s.
    #[arg(long, value_name = "S", default_value_t = 1.0, allow_negative_numbers = true)]
    seconds: f64,
    /// Measure this many steps once, the same steps on every computer, instead of the best of several segments.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    steps: Option<u64>,
    /// Number of steps before those that --steps measures.
    #[arg(long, value_name = "N", requires = "steps", default_value_t = 0)]
    skip_steps: u64,
    /// Time step for the figures of the engine, s; by default a fraction of the period of the stiffest contact.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    time_step: Option<f64>,
    /// Strain rate for the figures of the engine, 1/s; by default that of an inertial number of 1e-3.
    #[arg(long, value_name = "RATE", allow_negative_numbers = true)]
    strain_rate: Option<f64>,
    /// Measure only the engine (dem) or the networks (nets).
    #[arg(long, value_name = "WHAT", value_parser = ["dem", "nets"])]
    only: Option<String>,
}

impl Bench {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        if !(self.seconds > 0.0 && self.seconds <= 3600.0) {
            return Err(Failure::new(format!(
                "--seconds {}: it must be above 0 and at most 3600, e.g. \
                1",
                self.seconds
            )));
        }
        let wanted = |part: &str| self.only.as_deref().is_none_or(|only| only == part);
        let isa = self.isa.as_deref().map(instruction_set).transpose()?;
        let mut measured = json!({
            "granum": env!("CARGO_PKG_VERSION"),
            "processors": processors(),
            "isa": isa.unwrap_or_else(Isa::detect).name(),
            "dem": [],
            "nets": [],
        });
        if wanted("dem") {
            let _alone = context.nothing_written(None);
            let packing = match &self.packing {
                Some(path) => context.read_packing(path)?,
                None => {
                    granum_io::formats::packing_csv::read_from(PACKING.as_bytes(), "the shipped packing")?
                }
            };
            measured["dem"] =
                json!(dem::measure(context, &packing, &self.measurement(isa, packing.grains.len())?)?);
        }
        if wanted("nets") {
            let threads = self.threads.iter().copied().max().unwrap_or_else(processors);
            measured["nets"] = json!(nets::measure(context, isa, self.seconds, threads)?);
        }
        if context.json { output::say(context, &measured, String::new) } else { Ok(()) }
    }

    /// Settings for the measurements of the engine.
    fn measurement(&self, isa: Option<Isa>, base: usize) -> Result<dem::Measurement, Failure> {
        for threads in &self.threads {
            if !(1..=1024).contains(threads) {
                return Err(Failure::new(format!("--threads {threads}: it must be from 1 to 1024")));
            }
        }
        for (flag, value) in [("--time-step", self.time_step), ("--strain-rate", self.strain_rate)] {
            if let Some(value) = value.filter(|v| !(v.is_finite() && *v > 0.0)) {
                return Err(Failure::new(format!("{flag} {value}: a positive number is needed")));
            }
        }
        let mut threads = self.threads.clone();
        if threads.is_empty() {
            threads = vec![1];
            threads.extend(Some(processors()).filter(|n| *n > 1));
        }
        let grains = if self.grains.is_empty() { vec![base, 20 * base] } else { self.grains.clone() };
        let laws = match &self.law {
            None => dem::LAWS.to_vec(),
            Some(text) => vec![dem::law(text)?],
        };
        Ok(dem::Measurement {
            laws,
            grains,
            threads,
            isa: isa.unwrap_or_else(Isa::detect),
            others: isa.is_none() && self.law.is_none(),
            seconds: self.seconds,
            segment: self.steps.map(|steps| dem::Segment { skipped: self.skip_steps, steps }),
            time_step: self.time_step,
            strain_rate: self.strain_rate,
        })
    }
}
