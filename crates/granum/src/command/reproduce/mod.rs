//! `granum reproduce`: the whole paper in one command.

mod runs;
mod study;

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use granum_dem::config::Rate;
use granum_hybrid::Summary;
use granum_io::{Case, OutputFolder};
use serde_json::json;

use super::checkpoints::CheckpointFlags;
use super::hardware::HardwareFlags;
use super::scores;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;
use crate::progress::readable;

/// Recompute Antony, Zhou and Wang (2006): three DEM tests, soft sensors, eighteen networks, comparison, report.
///
/// One run trains the networks; two with other seeds are seen by none and judge them. Finished runs and networks are used
/// again if their case has not changed.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum reproduce\n  granum reproduce --quick --out quick\n  granum reproduce --trainer traingdx"
)]
pub struct Reproduce {
    /// 1000 grains, fewer states and a faster test: a minute to see that everything works, not to be cited.
    #[arg(long)]
    quick: bool,
    /// Folder of the results; made if it is not there, gone on with if it is.
    #[arg(short, long, default_value = "reproduction", value_name = "DIR")]
    out: PathBuf,
    /// Trainer of the networks: levenberg-marquardt (with Bayesian regularisation) or traingdx (the paper's, with its
    /// epochs).
    #[arg(long, default_value = "levenberg-marquardt", value_name = "NAME")]
    trainer: String,
    #[command(flatten)]
    checkpoints: CheckpointFlags,
    #[command(flatten)]
    hardware: HardwareFlags,
}

impl Reproduce {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let started = Instant::now();
        granum_nets::trainer::by_name(&self.trainer, &Default::default())?;
        let folder = OutputFolder::open_or_create(&self.out)?;
        let laboratory = self.hardware.laboratory(&self.checkpoints)?;
        let runs = runs::all(context, &laboratory, &case(self.quick), folder.path())?;
        let summary = study::all(context, &folder, &runs, self)?;
        let seconds = started.elapsed();
        let result = json!({
            "report": folder.file("report.html"),
            "summary": folder.file("summary.json"),
            "seconds": seconds.as_secs_f64(),
        });
        output::say(context, &result, || {
            format!(
                "{}\nreport: {}\nnumbers: {}\ndone in {}",
                table(&summary),
                folder.file("report.html").display(),
                folder.file("summary.json").display(),
                readable(seconds)
            )
        })
    }
}

/// The command line that makes runs of a case and networks of a trainer again.
pub(super) fn command_line(of: &Case, trainer: &str) -> String {
    let mut quick_case = case(true);
    quick_case.preparation.seed = of.preparation.seed;
    let quick = if *of == quick_case { " --quick" } else { "" };
    let trainer = match trainer {
        "levenberg-marquardt" => String::new(),
        other => format!(" --trainer {other}"),
    };
    format!("granum reproduce{quick}{trainer}")
}

/// The paper's case, or a small and fast one like it.
fn case(quick: bool) -> Case {
    let mut case = Case::default();
    if quick {
        case.grains.count = 1000;
        case.shear.rate = Rate::InertialNumber(1e-3);
        case.preparation.inertial_number = 2e-3;
        case.preparation.solid_fraction_tolerance = 0.008;
        case.recording.states = 60;
        case.recording.looks = 10;
    }
    case
}

/// The mappings with their errors, for the terminal.
fn table(summary: &Summary) -> String {
    let mut lines = scores::lines(&summary.mappings, "seed scatter");
    lines.push(format!(
        "networks answer {:.0} times faster than DEM ({:.0} s against {:.2e} s)",
        summary.speed.factor, summary.speed.dem_seconds, summary.speed.network_seconds
    ));
    lines.join("\n")
}
