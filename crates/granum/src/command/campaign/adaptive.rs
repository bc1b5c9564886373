//! `granum campaign --adaptive`: batch after batch, the next runs where a surrogate of those before is least sure.

use std::collections::BTreeSet;
use std::path::Path;

use granum_campaign::Campaign;
use granum_campaign::plan::{Choice as Value, Plan, VariableKind};
use granum_io::Case;
use granum_io::shell::{ShowPath, quoted_path};
use granum_learn::LearnError;
use granum_learn::active_learning::ActiveLearning;
use granum_learn::runs::RunRole;

use super::choice::Choice;
use super::execute;
use super::flags::PlanFlags;
use crate::command::records;
use crate::command::show_steps::ShowSteps;
use crate::command::train_study::dataset;
use crate::context::Context;
use crate::failure::{Failure, Interrupted};

/// Points among which a batch is chosen, and over which the variance is averaged.
const CANDIDATES: usize = 512;

/// Carries out a plan batch after batch.
pub fn run(context: &Context, flags: &PlanFlags, surrogate: &str) -> Result<(), Failure> {
    if !flags.scheduler.is_local() {
        return Err(Failure::new(
            "--adaptive chooses runs by those before, which are executed on this machine",
        ));
    }
    let (plan, out) = execute::plan_and_folder(context, flags)?;
    let (plan, out) = (&plan, out.as_path());
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
        choice.write(out)?;
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
        choice.write(out)?;
    }
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
    let mut show = ShowSteps::new(context, "choosing the next runs");
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
    let is_word = |value: &Value| value.number.is_none();
    for variable in &plan.variables {
        if let VariableKind::Choice(choices) = &variable.kind
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
