//! `granum campaign --adaptive`: batch after batch, the next runs where a surrogate of those before is least sure.

use std::collections::BTreeSet;
use std::path::Path;

use clap::Args;
use granum_campaign::Campaign;
use granum_campaign::plan::Plan;
use granum_core::input::read_text;
use granum_core::observer::{Flow, Observer, Progress as Step};
use granum_io::sealed::{unseal_strictly, write_sealed};
use granum_io::shell::{ShowPath, quoted_path};
use granum_io::{Case, Error};
use granum_learn::LearnError;
use granum_learn::active_learning::{ActiveLearning, FEWEST_RUNS};
use granum_learn::runs::RunRole;
use granum_run::laboratory::ProgressField;
use serde::{Deserialize, Serialize};

use super::execute;
use super::flags::PlanFlags;
use crate::command::records;
use crate::command::train_study::dataset;
use crate::context::Context;
use crate::failure::{Failure, Interrupted};
use crate::progress::Progress;

/// The file with what was chosen, in the folder of the campaign.
const FILE: &str = "adaptive.json";
/// Layout of the file.
const FORMAT: u32 = 1;
/// A larger file is something else.
const LARGEST: u64 = 1 << 24;
/// Points among which a batch is chosen, and over which the variance is averaged.
const CANDIDATES: usize = 512;
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
struct Choice {
    format: u32,
    surrogate: String,
    first: usize,
    batch: usize,
    learn: Vec<String>,
    along: String,
    /// Seed of the sequence.
    seed: u32,
    /// Numbers of points in the sequence, in the order in which they were chosen.
    points: Vec<usize>,
    /// The variance of the mean curves over the ranges, over that of the curves of the runs, before and after each choice: as it was expected.
    variance: Vec<[f64; 2]>,
}

impl Choice {
    fn new(flags: &AdaptiveFlags, surrogate: &str, plan: &Plan) -> Choice {
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

    /// The same with what an earlier command chose, if it was asked the same.
    fn continued(self, folder: &Path) -> Result<Choice, Failure> {
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

/// Carries out a plan batch after batch.
pub fn run(
    context: &Context,
    flags: &PlanFlags,
    surrogate: &str,
    plan: &Plan,
    out: &Path,
) -> Result<(), Failure> {
    let wanted = plan.design.points.unwrap_or(0);
    check_numbers(plan)?;
    let mut choice = Choice::new(&flags.adaptive, surrogate, plan).continued(out)?;
    if choice.points.is_empty() {
        let first = plan.sequence(&BTreeSet::new(), choice.first.min(wanted))?;
        choice.points = first.iter().map(|point| point.number).collect();
    }
    loop {
        // A plan with fewer points than before keeps the first of them.
        let now = plan.with_chosen(&choice.points[..choice.points.len().min(wanted)]);
        let planned = now.runs()?;
        if choice.points.len() >= wanted {
            return execute::carry_out_whole(context, flags, &now, &planned, out);
        }
        let (campaign, summary) = execute::carry_out_for(context, &flags.carry_out, &now, &planned, out)?;
        write_sealed(&out.join(FILE), &choice)?;
        if summary.stopped {
            return Err(stopped(context, &campaign, choice.points.len(), wanted));
        }
        let more = choice.batch.min(wanted - choice.points.len());
        let found = next(context, flags, &choice, plan, out, more)?;
        let (from, to) = (found.variance[0], found.variance[found.variance.len() - 1]);
        context.note(&format!(
            "{} of {wanted} points; the next {} should reduce the variance of the mean curves from {:.2} to {:.2} % of that between the runs",
            choice.points.len(),
            found.points.len(),
            100.0 * from,
            100.0 * to
        ));
        choice.variance.push([from, to]);
        choice.points.extend(found.points);
        write_sealed(&out.join(FILE), &choice)?;
    }
}

/// Says that a campaign whose runs are complete may not have all of its points.
pub fn remark(folder: &Path) -> Option<String> {
    folder.join(FILE).is_file().then(|| {
        "the runs of this campaign are chosen batch after batch; the command with which it was begun goes on with the next ones".into()
    })
}

/// The next points, with the variance before them and after each.
struct Found {
    points: Vec<usize>,
    variance: Vec<f64>,
}

fn next(
    context: &Context,
    flags: &PlanFlags,
    choice: &Choice,
    plan: &Plan,
    out: &Path,
    count: usize,
) -> Result<Found, Failure> {
    let known: BTreeSet<usize> = choice.points.iter().copied().collect();
    let open = plan.sequence(&known, CANDIDATES.max(2 * count))?;
    let cases: Vec<Case> = open.iter().map(|point| point.case.clone()).collect();
    let recorded = records::read(context, &[out.to_path_buf()], RunRole::Training)?;
    let runs = dataset(&recorded.iter().collect::<Vec<_>>())?;
    let learning = ActiveLearning::new(&choice.along, &choice.learn);
    let learning = ActiveLearning { threads: flags.carry_out.workers()?.unwrap_or(0), ..learning };
    let mut show = Show { context, progress: context.progress() };
    show.progress.phase("choosing the next runs");
    match learning.choose_cases(&runs, &cases, count, &mut show) {
        Ok(next) => Ok(Found {
            points: next.chosen.iter().map(|place| open[*place].number).collect(),
            variance: next.variance,
        }),
        Err(LearnError::Stopped { .. }) => {
            let left = format!("continue with the same command; {} has all runs so far", out.shown());
            Err(Interrupted { left }.into())
        }
        Err(error) => Err(error.into()),
    }
}

/// Refuses variables whose values are words: a Gaussian process of numbers says nothing about them.
fn check_numbers(plan: &Plan) -> Result<(), Failure> {
    let is_word = |choice: &granum_campaign::plan::Choice| choice.number.is_none();
    for variable in &plan.variables {
        if let granum_campaign::plan::VariableKind::Choice(choices) = &variable.kind
            && choices.iter().any(is_word)
        {
            let message = format!(
                "the variable {} has values that are no numbers; --adaptive needs numbers, so make a campaign for each of its values",
                variable.name
            );
            return Err(plan.source.error(&variable.span, message).into());
        }
    }
    Ok(())
}

fn stopped(context: &Context, campaign: &Campaign, points: usize, wanted: usize) -> Failure {
    let folder = campaign.folder();
    let left = format!(
        "{points} of {wanted} points are chosen in {}; continue with the same command",
        quoted_path(folder)
    );
    match context.stopped() {
        true => Interrupted { left }.into(),
        false => Failure::new(format!("stopped before the end; {left}")),
    }
}

/// Shows how far the fit is.
struct Show<'a> {
    context: &'a Context,
    progress: Progress,
}

impl Observer for Show<'_> {
    fn progress(&mut self, step: &Step) -> Flow {
        let part = step.part.clone().unwrap_or_default();
        self.progress.update(step.completed(), |_| vec![ProgressField::new(0, part)]);
        self.context.flow()
    }
}
