//! What all questions share: the runs, progress, and answers as tables.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use granum_core::json;
use granum_core::observer::Observer;
use granum_io::atomic::write_atomically;
use granum_io::check_output_file;
use granum_io::shell::ShowPath;
use granum_learn::runs::RunRole;
use granum_learn::{Dataset, LearnError, PooledError};
use serde::Serialize;

use crate::command::records::{self, Recorded};
use crate::command::show_steps::ShowSteps;
use crate::command::train_study::{dataset, kept_unseen};
use crate::context::Context;
use crate::failure::{Failure, Interrupted};
use crate::output;

/// The runs that are learned from and those on which errors are measured.
#[derive(Args)]
pub struct RunFlags {
    /// Run folders for training; campaigns and data sets stand for all of their runs.
    #[arg(required = true, value_name = "RUN")]
    pub runs: Vec<PathBuf>,
    /// Run folders, campaigns or data sets on which errors are measured.
    #[arg(long, num_args = 1.., value_name = "RUN")]
    unseen: Vec<PathBuf>,
    /// Keep this share of the runs unseen, as whole runs: they are chosen by their names and --seed.
    #[arg(long, value_name = "X", conflicts_with = "unseen", allow_negative_numbers = true)]
    unseen_share: Option<f64>,
}

/// How a question is worked on.
#[derive(Args)]
pub struct WorkFlags {
    /// The column along which a test runs.
    #[arg(long, value_name = "COLUMN", default_value = "axial_strain")]
    pub coordinate: String,
    /// What is learned and judged.
    #[arg(
        long,
        value_name = "COLUMN",
        value_delimiter = ',',
        default_value = "stress_ratio,volumetric_strain"
    )]
    pub output: Vec<String>,
    /// Seed of methods, noise, and --unseen-share.
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub seed: u64,
    /// Number of threads; all processors by default. Results do not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1024))]
    threads: Option<u64>,
    /// Write the answers to this file, as JSON.
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl RunFlags {
    /// The training runs and the unseen ones.
    pub fn read(&self, context: &Context, seed: u64) -> Result<(Dataset, Dataset), Failure> {
        let _reading = context.nothing_written(Some("reading the runs"));
        let mut learned = records::read(context, &self.runs, RunRole::Training)?;
        let mut unseen = records::read(context, &self.unseen, RunRole::Unseen)?;
        match self.unseen_share {
            Some(share) if share > 0.0 && share < 1.0 => unseen = kept_unseen(&mut learned, share, seed),
            Some(share) => {
                return Err(Failure::new(format!("--unseen-share {share}: it must be between 0 and 1")));
            }
            None => {}
        }
        check_unseen(&unseen)?;
        let all: Vec<&Recorded> = learned.iter().chain(&unseen).collect();
        records::check_different(&all)?;
        // Of all runs together, so that names that occur twice are told apart.
        let mut runs = dataset(&all)?.runs().to_vec();
        let unseen = Dataset::new(runs.split_off(learned.len()))?;
        Ok((Dataset::new(runs)?, unseen))
    }

    /// Each of the folders with its runs, and the unseen runs.
    pub fn read_each(&self, context: &Context) -> Result<(Vec<(String, Dataset)>, Dataset), Failure> {
        let _reading = context.nothing_written(Some("reading the runs"));
        if self.unseen_share.is_some() {
            return Err(Failure::new("designs are judged on runs of none of them; name some with --unseen"));
        }
        let unseen = records::read(context, &self.unseen, RunRole::Unseen)?;
        check_unseen(&unseen)?;
        let mut found = Vec::new();
        for folder in &self.runs {
            let runs = records::read(context, std::slice::from_ref(folder), RunRole::Training)?;
            let all: Vec<&Recorded> = runs.iter().chain(&unseen).collect();
            records::check_different(&all)?;
            found.push((folder.shown(), dataset(&runs.iter().collect::<Vec<_>>())?));
        }
        Ok((found, dataset(&unseen.iter().collect::<Vec<_>>())?))
    }
}

fn check_unseen(unseen: &[Recorded]) -> Result<(), Failure> {
    match unseen.is_empty() {
        true => Err(Failure::new(
            "there is no unseen run to measure errors on; name some with --unseen, or keep a part with --unseen-share 0.2",
        )),
        false => Ok(()),
    }
}

impl WorkFlags {
    pub fn threads(&self) -> usize {
        self.threads.unwrap_or(0) as usize
    }

    /// Refuses a file that is in the way before anything is done.
    pub fn check(&self, context: &Context) -> Result<(), Failure> {
        self.out.iter().try_for_each(|file| Ok(check_output_file(file, context.force)?))
    }

    /// Works on a question, with progress.
    pub fn answered<T>(
        &self,
        context: &Context,
        work: impl FnOnce(&mut dyn Observer) -> granum_learn::Result<T>,
    ) -> Result<T, Failure> {
        WorkFlags::observed(context, work)
    }

    /// Work with progress that the user can stop.
    pub fn observed<T>(
        context: &Context,
        work: impl FnOnce(&mut dyn Observer) -> granum_learn::Result<T>,
    ) -> Result<T, Failure> {
        let mut show = ShowSteps::new(context, "comparison");
        match work(&mut show) {
            Ok(found) => {
                show.end(|| "done".into());
                Ok(found)
            }
            Err(LearnError::Stopped { done, total }) => {
                let left = format!("{done} of {total} steps were done; nothing was written");
                Err(Interrupted { left }.into())
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Writes and prints answers.
    pub fn tell(
        &self,
        context: &Context,
        answers: &impl Serialize,
        lines: Vec<String>,
    ) -> Result<(), Failure> {
        if let Some(file) = &self.out {
            let text = json::readable(answers).map_err(|error| LearnError::Content(error.to_string()))?;
            put(file, &text)?;
        }
        let result = serde_json::json!({ "answers": answers, "out": self.out.as_deref().map(output::path) });
        output::say(context, &result, || {
            let wrote = self.out.iter().map(|file| format!("wrote {}", file.shown()));
            lines.into_iter().chain(wrote).collect::<Vec<_>>().join("\n")
        })
    }
}

/// Writes a text to a file.
pub fn put(file: &Path, text: &str) -> Result<(), Failure> {
    Ok(write_atomically(file, |out| out.write_all(text.as_bytes()))?)
}

/// The heading of a table of errors.
pub fn about(runs: &Dataset) -> String {
    let unseen = runs.runs().len();
    format!("relative RMSE on {unseen} unseen runs, in percent, with its standard error over these runs")
}

/// `13.7 ± 0.9`.
pub fn percent(error: &PooledError) -> String {
    let decimals = if error.relative < 0.0995 { 2 } else { 1 };
    format!("{:.decimals$} ± {:.decimals$}", 100.0 * error.relative, 100.0 * error.standard_error)
}

/// Aligned lines of a table.
pub fn table(head: &[String], rows: &[Vec<String>]) -> Vec<String> {
    let all = || std::iter::once(head).chain(rows.iter().map(Vec::as_slice));
    let width =
        |k: usize| all().filter_map(|row| row.get(k)).map(|cell| cell.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..head.len()).map(width).collect();
    let line = |row: &[String]| {
        let cells: Vec<String> =
            row.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}")).collect();
        cells.join("  ").trim_end().to_string()
    };
    all().map(line).collect()
}
