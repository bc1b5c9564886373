//! What was chosen in an adaptive campaign, and how it is asked for.

use std::path::Path;

use clap::Args;
use granum_campaign::plan::Plan;
use granum_core::input::read_text;
use granum_io::Error;
use granum_io::sealed::{unseal_strictly, write_sealed};
use granum_io::shell::ShowPath;
use granum_learn::active_learning::FEWEST_RUNS;
use serde::{Deserialize, Serialize};

use crate::failure::Failure;

/// The file with what was chosen, in the folder of the campaign.
const FILE: &str = "adaptive.json";
/// Layout of the file.
const FORMAT: u32 = 1;
/// A larger file is something else.
const LARGEST: u64 = 1 << 24;
/// The first points, for each free variable, unless told otherwise.
const FIRST_OF_EACH: usize = 4;

/// How the next runs are chosen.
#[derive(Args, Clone, Debug)]
pub struct AdaptiveFlags {
    /// Choose the runs batch after batch, where a surrogate of those before is least sure, until the plan has its number of points. The plan
    /// needs a Sobol sequence, which gives the first points and those to choose from.
    #[arg(long, value_name = "SURROGATE", value_parser = ["gaussian-process"], conflicts_with_all = ["dry_run", "list_jobs", "collect"])]
    pub adaptive: Option<String>,
    /// Number of points before the first choice [default: 4 for each free variable, at least 8].
    #[arg(long, value_name = "N", requires = "adaptive", value_parser = clap::value_parser!(u32).range(FEWEST_RUNS as i64..))]
    pub first: Option<u32>,
    /// Number of points that are chosen at once [default: as many as the first].
    #[arg(long, value_name = "N", requires = "adaptive", value_parser = clap::value_parser!(u32).range(1..))]
    pub batch: Option<u32>,
    /// What the surrogate learns.
    #[arg(
        long,
        value_name = "COLUMN",
        requires = "adaptive",
        value_delimiter = ',',
        default_value = "stress_ratio,volumetric_strain"
    )]
    pub learn: Vec<String>,
    /// The column along which a test runs.
    #[arg(long, value_name = "COLUMN", requires = "adaptive", default_value = "axial_strain")]
    pub along: String,
}

/// What was chosen so far, with all that it depends on beside the plan and the runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    format: u32,
    surrogate: String,
    pub first: usize,
    pub batch: usize,
    pub learn: Vec<String>,
    pub along: String,
    /// Seed of the sequence.
    seed: u32,
    /// Numbers of points in the sequence, in the order in which they were chosen.
    pub points: Vec<usize>,
    /// The variance of the mean curves over the ranges, over that of the curves of the runs, before and after each choice: as it was expected.
    pub variance: Vec<[f64; 2]>,
}

impl Choice {
    pub fn new(flags: &AdaptiveFlags, surrogate: &str, plan: &Plan) -> Choice {
        let free = plan.variables.iter().filter(|variable| variable.kind.is_free()).count();
        let first = flags.first.map_or((FIRST_OF_EACH * free).max(8), |count| count as usize);
        Choice {
            format: FORMAT,
            surrogate: surrogate.into(),
            first,
            batch: flags.batch.map_or(first, |count| count as usize),
            learn: flags.learn.clone(),
            along: flags.along.clone(),
            seed: plan.design.seed,
            points: Vec::new(),
            variance: Vec::new(),
        }
    }

    /// Writes it into the folder of the campaign.
    pub fn write(&self, folder: &Path) -> Result<(), Failure> {
        Ok(write_sealed(&folder.join(FILE), self)?)
    }

    /// The same with what an earlier command chose, if it was asked the same.
    pub fn continued(self, folder: &Path) -> Result<Choice, Failure> {
        let path = folder.join(FILE);
        if !path.is_file() {
            return Ok(self);
        }
        let text = read_text(&path, LARGEST).map_err(Error::file("read", &path))?;
        let text = unseal_strictly(&path, &text)?;
        let known: Choice = serde_json::from_str(&text)
            .map_err(|error| Error::content(&path, format!("is damaged or of a newer version: {error}")))?;
        let asked = Choice { points: known.points.clone(), variance: known.variance.clone(), ..self };
        if asked == known {
            return Ok(known);
        }
        Err(Failure::new(format!(
            "{}: the runs were chosen with other settings (--first {} --batch {} --learn {} --along {}, seed {} of the design); give the same, or \
             another folder with --out",
            folder.shown(),
            known.first,
            known.batch,
            known.learn.join(","),
            known.along,
            known.seed
        )))
    }
}

/// Says that a campaign whose runs are complete may not have all of its points.
pub fn remark(folder: &Path) -> Option<String> {
    folder.join(FILE).is_file().then(|| {
        "the runs of this campaign are chosen batch after batch; the command with which it was begun goes on with the next ones".into()
    })
}
