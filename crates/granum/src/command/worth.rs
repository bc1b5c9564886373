//! `granum worth`: what each soft sensor is worth.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use granum_core::json;
use granum_io::shell::ShowPath;
use granum_io::{atomic::write_atomically, check_output_file};
use granum_learn::LearnError;
use granum_learn::family::{FamilyDefinition, by_name};
use granum_learn::runs::RunRole;
use granum_learn::worth::{Worth, WorthPlan, measure};
use granum_report::worth_report;

use super::records::{self, Recorded};
use super::show_steps::ShowSteps;
use super::train_study::{dataset, kept_unseen};
use super::worth_text;
use crate::context::Context;
use crate::failure::{Failure, Interrupted};
use crate::output;

/// The usual column along which a test runs.
const COORDINATE: &str = "axial_strain";

/// Measure what each soft sensor is worth: how well stress ratio and volumetric strain of unseen runs are known from strain alone, with
/// each soft sensor, with the properties of grains and packing, by the cascade from properties to sensors to stress, and with both; and how well
/// soft sensors are known from what a laboratory measures.
///
/// The unseen runs should have other parameters and other seeds than the training runs. Errors are relative to the root mean square of the
/// values, with standard errors over the unseen runs. The method of each line is chosen on training runs alone. Sensors of other runs and
/// permuted sensors show whether it is the value of a sensor that counts. Tests along several paths are judged path by path.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum worth study --unseen-share 0.2\n  granum worth study --unseen judges --runs 24,48,96 -o worth.json \
                  --page worth.html\n  granum worth study --unseen judges --sensor deviator_fabric,sliding_fraction --method boosted-trees\n  granum worth data/families/sand/paths --family sand --path constant-p \\\n    --unseen data/families/sand/paths-unseen"
)]
pub struct MeasureWorth {
    /// Run folders for training; campaigns and data sets stand for all of their runs.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// Run folders, campaigns or data sets on which errors are measured.
    #[arg(long, num_args = 1.., value_name = "RUN")]
    unseen: Vec<PathBuf>,
    /// Keep this share of the runs unseen, as whole runs: they are chosen by their names and --seed.
    #[arg(long, value_name = "X", conflicts_with = "unseen", allow_negative_numbers = true)]
    unseen_share: Option<f64>,
    /// The runs of this family: along its coordinate, with its inputs as properties.
    #[arg(long, value_name = "NAME")]
    family: Option<String>,
    /// Path of the tests of --family; its first one by default. Runs along other paths are left out.
    #[arg(long, value_name = "NAME", requires = "family")]
    path: Option<String>,
    /// The column along which a test runs [default: axial_strain, or that of --family].
    #[arg(long, value_name = "COLUMN")]
    coordinate: Option<String>,
    /// What a laboratory measures [default: stress_ratio,volumetric_strain, or what --family predicts beside strains and sensors].
    #[arg(long, value_name = "COLUMN", value_delimiter = ',')]
    output: Vec<String>,
    /// Soft sensors, the first two of which are also judged together [default:
    /// deviator_fabric,mean_square_force,probability_density,mechanical_coordination_number,sliding_fraction].
    #[arg(long, value_name = "COLUMN", value_delimiter = ',')]
    sensor: Vec<String>,
    /// Properties of grains, packing and test [default: all numbers of the case in which the training runs differ, and void ratio and
    /// coordination number of the sample].
    #[arg(long, value_name = "COLUMN", value_delimiter = ',')]
    property: Vec<String>,
    /// Methods among which one is chosen for each line [default: ridge,boosted-trees,gaussian-process].
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    method: Vec<String>,
    /// Numbers of training runs beside all of them; the first so many are used.
    #[arg(long = "runs", value_name = "N", value_delimiter = ',')]
    runs_used: Vec<usize>,
    /// Largest number of states from which a surrogate learns and on which it is judged: of more, every n-th of each run is used.
    #[arg(long, value_name = "N", default_value_t = 20_000, value_parser = clap::value_parser!(u64).range(100..))]
    most_states: u64,
    /// Seed of the methods, and of --unseen-share.
    #[arg(long, default_value_t = 1, value_name = "N")]
    seed: u64,
    /// Number of threads; all processors by default. Results do not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1024))]
    threads: Option<u64>,
    /// Write the answers to this file, as JSON. In the folder of a study as `worth.json` they are the first section of its report.
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Write the answers to this page, as HTML with tables and figures.
    #[arg(long, value_name = "FILE")]
    page: Option<PathBuf>,
}

impl MeasureWorth {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        for file in self.out.iter().chain(&self.page) {
            check_output_file(file, context.force)?;
        }
        // A name that does not exist is told before runs are read.
        let family = self.family.as_deref().map(|name| by_name(name, self.path.as_deref())).transpose()?;
        let reading = context.nothing_written(Some("reading the runs"));
        let mut learned = records::read(context, &self.runs, RunRole::Training)?;
        let mut unseen = records::read(context, &self.unseen, RunRole::Unseen)?;
        match self.unseen_share {
            Some(share) if share > 0.0 && share < 1.0 => unseen = kept_unseen(&mut learned, share, self.seed),
            Some(share) => {
                return Err(Failure::new(format!("--unseen-share {share}: it must be between 0 and 1")));
            }
            None => {}
        }
        if unseen.is_empty() {
            return Err(Failure::new(
                "there is no unseen run to measure errors on; name some with --unseen, or keep a part with --unseen-share 0.2",
            ));
        }
        let all: Vec<&Recorded> = learned.iter().chain(&unseen).collect();
        records::check_different(&all)?;
        // Of all runs together, so that names that occur twice are told apart.
        let mut runs = dataset(&all)?.runs().to_vec();
        let unseen = granum_learn::Dataset::new(runs.split_off(learned.len()))?;
        let training = granum_learn::Dataset::new(runs)?;
        let (training, unseen) = match family {
            Some(family) => (family.with_its_columns(&training)?, family.with_its_columns(&unseen)?),
            None => (training, unseen),
        };
        let plan = self.plan(family, &training);
        drop(reading);
        let mut show = ShowSteps::new(context, "comparison");
        let worth = match measure(&training, &unseen, &plan, context.methods(), &mut show) {
            Ok(worth) => worth,
            Err(LearnError::Stopped { done, total }) => {
                let left = format!("{done} of {total} surrogates were fitted; nothing was written");
                return Err(Interrupted { left }.into());
            }
            Err(error) => return Err(error.into()),
        };
        let count = worth.answers.len();
        show.end(|| format!("{count} answers"));
        self.write(&worth)?;
        let result = serde_json::json!({
            "worth": worth,
            "out": self.out.as_deref().map(output::path),
            "page": self.page.as_deref().map(output::path),
        });
        output::say(context, &result, || {
            let mut lines = worth_text::lines(&worth);
            lines.extend(self.out.iter().chain(&self.page).map(|file| format!("wrote {}", file.shown())));
            lines.join("\n")
        })
    }

    fn plan(&self, family: Option<&FamilyDefinition>, training: &granum_learn::Dataset) -> WorthPlan {
        let mut plan = match family {
            Some(family) => WorthPlan::of_family(family, training),
            None => WorthPlan::new(COORDINATE, training),
        };
        if let Some(coordinate) = &self.coordinate {
            plan.coordinate.clone_from(coordinate);
        }
        let given = [
            (&mut plan.outputs, &self.output),
            (&mut plan.sensors, &self.sensor),
            (&mut plan.properties, &self.property),
            (&mut plan.methods, &self.method),
        ];
        for (own, given) in given.into_iter().filter(|(_, given)| !given.is_empty()) {
            own.clone_from(given);
        }
        plan.counts.splice(0..0, self.runs_used.iter().copied());
        plan.counts.sort_unstable();
        plan.counts.dedup();
        plan.most_states = self.most_states as usize;
        plan.seed = self.seed;
        plan.threads = self.threads.unwrap_or(0) as usize;
        plan
    }

    fn write(&self, worth: &Worth) -> Result<(), Failure> {
        let put = |file: &Path, text: &str| write_atomically(file, |out| out.write_all(text.as_bytes()));
        if let Some(file) = &self.out {
            let text = json::readable(worth).map_err(|error| LearnError::Content(error.to_string()))?;
            put(file, &text)?;
        }
        if let Some(file) = &self.page {
            put(file, &worth_report(worth).html)?;
        }
        Ok(())
    }
}
