//! Carrying out a plan.

use std::path::{Path, PathBuf};

use granum::contents::{FolderKind, check_free};
use granum_campaign::data_set::{Collected, DataSetSummary};
use granum_campaign::execution::{Coordinator, Summary};
use granum_campaign::plan::{DesignKind, Keep, Plan, PlannedRuns};
use granum_campaign::scheduler::{
    self, JobRecord, Order, Scheduler, SchedulerError, SchedulerOptions, Submission, Submitted,
};
use granum_campaign::{Campaign, CampaignStatus, PlanDifference, RUNS, RunState};
use granum_io::OutputFolder;
use granum_io::shell::{ShowPath, quoted_path};
use granum_run::LaboratoryError;
use granum_run::engine::{LAMMPS, LammpsStart};
use granum_run::queue::QueueError;
use serde_json::json;

use super::flags::{CarryOutFlags, PlanFlags, SchedulerFlags};
use super::show::ShowCampaign;
use super::{choice, estimate, plan_text, scheduling, status};
use crate::command::engine_flags::LammpsFlags;
use crate::command::foreseen::Foreseen;
use crate::context::Context;
use crate::failure::{Failure, Interrupted};
use crate::output;

/// What becomes of runs that do not pass their checks.
const LEFT_OUT: &str = "; they will be left out of the data set unless `accept` of the plan names the check";
/// Number of runs that are named in a message.
const MOST_NAMED: usize = 10;

/// Carries out a plan, or prints what it will run.
pub fn run(context: &Context, flags: &PlanFlags) -> Result<(), Failure> {
    let (plan, out) = plan_and_folder(context, flags)?;
    let planned = plan.runs()?;
    if flags.dry_run {
        let campaign = Campaign::new(&out, &plan, &planned, env!("CARGO_PKG_VERSION"));
        check(&context.with_force(), &flags.carry_out, &campaign)?;
        let foreseen = Foreseen::of_campaign(&campaign)?;
        foreseen.tell(context, LEFT_OUT);
        let estimate = estimate::run_pilots(context, flags, &plan, &planned)?;
        let mut result = plan_text::as_json(&plan, &planned);
        result["foreseen_failures"] = foreseen.as_json();
        result["estimate"] = json!(estimate.as_ref().map(estimate::as_json));
        return output::say(context, &result, || {
            let text = plan_text::text(&plan, &planned);
            estimate.map_or(text.clone(), |found| format!("{text}\n{}", estimate::text(&found)))
        });
    }
    carry_out_whole(context, flags, &plan, &planned, &out)
}

/// Reads the plan, and names the folder of its campaign.
pub(super) fn plan_and_folder(context: &Context, flags: &PlanFlags) -> Result<(Plan, PathBuf), Failure> {
    let Some(file) = &flags.plan else { return Err(Failure::new("a plan is needed")) };
    flags.scheduler.check(&flags.carry_out)?;
    let mut plan = Plan::read(file, context.reading())?;
    if !plan.engine.is_empty() {
        context.run_registry().engines.named(&plan.engine).map_err(LaboratoryError::from)?;
    }
    plan.lammps = lammps_start(&flags.lammps, &plan.engine, &plan.lammps)?;
    let out =
        flags.out.clone().unwrap_or_else(|| PathBuf::from(file.file_stem().unwrap_or(file.as_os_str())));
    Ok((plan, out))
}

/// Carries out the runs of a plan as the flags say.
pub(super) fn carry_out_whole(
    context: &Context,
    flags: &PlanFlags,
    plan: &Plan,
    planned: &PlannedRuns,
    out: &Path,
) -> Result<(), Failure> {
    let scheduler = flags.scheduler.scheduler(context, &flags.carry_out)?;
    plan.replaced_tests(planned).iter().for_each(|text| context.note(text));
    let (campaign, folder) = prepared(context, &flags.carry_out, plan, planned, out)?;
    if flags.list_jobs {
        return list_jobs(context, &campaign);
    }
    if flags.collect {
        let collected = collect(context, &campaign)?;
        context.note(&format!("{} more runs are finished", collected.added));
        collected.remarks.iter().for_each(|remark| context.warn(remark));
        context.note(&data_set_line(&collected));
        // So that the state is that of a campaign on which none is at work.
        drop(folder);
        return status::print(context, &campaign);
    }
    if flags.scheduler.is_local() {
        scheduling::check_none_queued(context, &campaign)?;
        return carry_out(context, &*scheduler, &flags.carry_out, None, &campaign, &folder);
    }
    let pace = if scheduler.packs() { pace(context, flags, plan, planned, &campaign)? } else { None };
    let submitted = carry_out(context, &*scheduler, &flags.carry_out, pace, &campaign, &folder);
    // So that the state is that of a campaign on which none is at work here.
    drop(folder);
    submitted?;
    status::print(context, &campaign)
}

/// How LAMMPS is started: by the flags, if they say so, else as before.
fn lammps_start(flags: &LammpsFlags, engine: &str, before: &LammpsStart) -> Result<LammpsStart, Failure> {
    let start = flags.start()?;
    match start.given() {
        None => Ok(before.clone()),
        Some(_) if engine == LAMMPS => Ok(start),
        Some(flag) => Err(Failure::new(format!(
            "--{flag} says how LAMMPS is started: write engine = \"{LAMMPS}\" into the plan"
        ))),
    }
}

/// Seconds for each unit of the expected work of a run, which is needed unless the number of runs in an element is given: from runs that
/// are finished, or from pilot runs here.
fn pace(
    context: &Context,
    flags: &PlanFlags,
    plan: &Plan,
    planned: &PlannedRuns,
    campaign: &Campaign,
) -> Result<Option<f64>, Failure> {
    if flags.scheduler.per_task.is_some() {
        return Ok(None);
    }
    match campaign.pace()? {
        Some(pace) => Ok(Some(pace)),
        None => Ok(estimate::run_pilots(context, flags, plan, planned)?.and_then(|found| found.pace())),
    }
}

/// Takes up what ended elsewhere, by whatever means.
fn collect(context: &Context, campaign: &Campaign) -> Result<Collected, Failure> {
    let submitted = JobRecord::open_in(campaign.folder())?.into_iter().map(|record| record.scheduler).next();
    let name = submitted.unwrap_or_else(|| scheduler::DEFAULT.into());
    collect_by(context, &*context.schedulers().named(&name, SchedulerOptions::default())?, campaign)
}

/// Takes up what ended, unless the user stops it.
fn collect_by(
    context: &Context,
    scheduler: &dyn Scheduler,
    campaign: &Campaign,
) -> Result<Collected, Failure> {
    scheduler.collect(campaign, &|| context.flow()).map_err(|error: SchedulerError| match context.stopped() {
        true => {
            let left = "the data set was not written to its end; the same command goes on with it";
            Interrupted { left: left.into() }.into()
        }
        false => error.into(),
    })
}

/// A command for each run that is not finished.
fn list_jobs(context: &Context, campaign: &Campaign) -> Result<(), Failure> {
    let status = CampaignStatus::read(campaign)?;
    let left = campaign.runs().iter().zip(&status.states);
    let left = left.filter(|(_, state)| !matches!(state, RunState::Finished { .. }));
    let folder = std::path::absolute(campaign.folder()).unwrap_or_else(|_| campaign.folder().to_path_buf());
    let folder = quoted_path(&folder);
    let commands: Vec<String> =
        left.map(|(run, _)| format!("granum campaign run {folder} {}", run.name)).collect();
    if commands.is_empty() && !context.json {
        context.note("all runs are finished");
        return Ok(());
    }
    output::say(context, &json!({ "jobs": commands }), || commands.join("\n"))
}

/// The campaign of a plan in its folder, which this process alone uses, before any run begins.
fn prepared(
    context: &Context,
    flags: &CarryOutFlags,
    plan: &Plan,
    planned: &PlannedRuns,
    out: &Path,
) -> Result<(Campaign, OutputFolder), Failure> {
    check_free(out, FolderKind::Campaign, true, context.vocabulary())?;
    let earlier = Campaign::read(out, context.vocabulary())?;
    let mut campaign = Campaign::new(out, plan, planned, env!("CARGO_PKG_VERSION"));
    let mut dropped = Vec::new();
    if let Some(earlier) = &earlier {
        campaign = campaign.after(earlier);
        let difference = campaign.difference(earlier);
        // That chosen points follow each other is no change of a plan.
        if !matches!(plan.design.kind, DesignKind::Chosen(_)) || !difference.dropped.is_empty() {
            tell_difference(context, &difference, campaign.no_longer_planned());
        }
        if context.force {
            dropped = campaign.no_longer_planned().to_vec();
            campaign = campaign.forgetting_earlier();
        }
    }
    check(context, flags, &campaign)?;
    Foreseen::of_campaign(&campaign)?.tell(context, LEFT_OUT);
    let folder = OutputFolder::open_or_create(out)?;
    folder.refuse_links(&[RUNS])?;
    for name in &dropped {
        remove_run(&campaign, name)?;
    }
    campaign.write()?;
    Ok((campaign, folder))
}

/// Continues the campaign of a folder without its plan.
pub fn resume(
    context: &Context,
    campaign: &Campaign,
    flags: &CarryOutFlags,
    lammps: &LammpsFlags,
) -> Result<(), Failure> {
    let start = lammps_start(lammps, campaign.engine(), campaign.lammps())?;
    let campaign = &campaign.clone().with_lammps(start);
    check(context, flags, campaign)?;
    scheduling::check_none_queued(context, campaign)?;
    let folder = OutputFolder::open(campaign.folder())?;
    if !lammps.start()?.is_usual() {
        campaign.write()?;
    }
    let scheduler = SchedulerFlags::local().scheduler(context, flags)?;
    carry_out(context, &*scheduler, flags, None, campaign, &folder)?;
    choice::remark(campaign.folder()).iter().for_each(|text| context.note(text));
    Ok(())
}

/// Carries out a plan here for a command that needs its runs, and adds them to the data set of the campaign; what is finished is used again.
pub fn carry_out_for(
    context: &Context,
    flags: &CarryOutFlags,
    plan: &Plan,
    planned: &PlannedRuns,
    out: &Path,
) -> Result<(Campaign, Summary), Failure> {
    let (campaign, folder) = prepared(context, flags, plan, planned, out)?;
    scheduling::check_none_queued(context, &campaign)?;
    let scheduler = SchedulerFlags::local().scheduler(context, flags)?;
    let laboratory = campaign.laboratory(&flags.laboratory(context)?);
    let order = Order {
        campaign: &campaign,
        folder: &folder,
        laboratory: &laboratory,
        replace_others: context.force,
        again: flags.again || context.force,
        pace: None,
    };
    let submitted = {
        let show = ShowCampaign::new(context);
        scheduler.submit(&order, &show)?
    };
    let Submitted::Ended(summary) = submitted else {
        return Err(Failure::new("the runs of this command are executed on this machine"));
    };
    if !summary.stopped {
        let collected = collect_by(context, &*scheduler, &campaign)?;
        collected.remarks.iter().for_each(|remark| context.warn(remark));
    }
    Ok((campaign, summary))
}

/// Refuses a campaign of which a run cannot be executed, before any begins.
fn check(context: &Context, flags: &CarryOutFlags, campaign: &Campaign) -> Result<(), Failure> {
    flags.workers()?;
    let laboratory = campaign.laboratory(&flags.laboratory(context)?);
    laboratory.registry.engines.named(&laboratory.engine).map_err(LaboratoryError::from)?;
    let executor = scheduling::executor(context, campaign.folder(), flags)?;
    let _alone = context.nothing_written(Some("checking the runs"));
    let coordinator = Coordinator {
        campaign,
        laboratory: &laboratory,
        executor: &executor,
        workers: None,
        stop_after: None,
        again: false,
    };
    coordinator.check(context.force).map_err(|error| match error {
        QueueError::OtherRun { .. } => {
            Failure::new(format!("{error}; give --force to replace it, or another folder with --out"))
        }
        other => other.into(),
    })
}

/// Gives the runs to the scheduler, and tells what became of them.
fn carry_out(
    context: &Context,
    scheduler: &dyn Scheduler,
    flags: &CarryOutFlags,
    pace: Option<f64>,
    campaign: &Campaign,
    folder: &OutputFolder,
) -> Result<(), Failure> {
    let laboratory = campaign.laboratory(&flags.laboratory(context)?);
    let order = Order {
        campaign,
        folder,
        laboratory: &laboratory,
        replace_others: context.force,
        again: flags.again || context.force,
        pace,
    };
    let submitted = {
        let show = ShowCampaign::new(context);
        scheduler.submit(&order, &show)?
    };
    match submitted {
        Submitted::Ended(summary) => {
            // What is missing is added by the command that goes on.
            let collected = (!summary.stopped).then(|| collect_by(context, scheduler, campaign));
            let collected = collected.transpose();
            report(context, campaign, &summary, collected.as_ref().ok().and_then(Option::as_ref))?;
            collected?;
        }
        Submitted::Queued(submission) => {
            tell_submission(context, &submission);
            let is_done = CampaignStatus::read(campaign)?.is_done();
            if is_done || campaign.keep() == Keep::Dataset {
                let collected = collect_by(context, scheduler, campaign)?;
                collected.remarks.iter().for_each(|remark| context.warn(remark));
                context.note(&data_set_line(&collected));
            }
        }
    }
    Ok(())
}

/// What became of the data set, in a line.
fn data_set_line(collected: &Collected) -> String {
    let mut left = Vec::new();
    for (count, what) in [
        (collected.flagged, "did not pass their checks"),
        (collected.failed, "failed"),
        (collected.unfinished, "are not finished"),
    ] {
        if count > 0 {
            left.push(format!("{count} {what}"));
        }
    }
    let left = if left.is_empty() { String::new() } else { format!("; left out: {}", left.join(", ")) };
    match &collected.data_set {
        Some(DataSetSummary { folder, runs, digest, is_new }) => {
            let state = if *is_new { "" } else { " (unchanged)" };
            format!("data set of {runs} runs{state}: {}{left}; SHA-256 {digest}", folder.shown())
        }
        None => format!("no data set, since none of the runs is part of it{left}"),
    }
}

/// Says what was queued.
fn tell_submission(context: &Context, submission: &Submission) {
    if !submission.jobs.is_empty() {
        context.note(&format!(
            "{} runs were submitted in {} elements, as the jobs {}",
            submission.runs,
            submission.elements,
            named(&submission.jobs)
        ));
    }
    if let Some((runs, why)) = &submission.waiting {
        context.note(&format!(
            "for {runs} runs there is no room at present ({why}); the same command submits them when jobs have ended"
        ));
    }
}

/// Says how a changed plan differs from the runs that the folder has.
fn tell_difference(context: &Context, difference: &PlanDifference, left: &[String]) {
    if !difference.is_none() {
        let PlanDifference { kept, added, dropped } = difference;
        let mut text = format!("the plan was changed: {kept} runs are still in it, {added} are new");
        if !dropped.is_empty() {
            text += &format!(", {} are no longer in it", dropped.len());
        }
        context.note(&text);
    }
    if left.is_empty() {
        return;
    }
    let names = named(left);
    context.note(&match context.force {
        true => format!("the folders of {} runs that are no longer in the plan are removed: {names}", left.len()),
        false => format!(
            "the folders of {} runs that are no longer in the plan stay and are not used: {names}; --force removes them",
            left.len()
        ),
    });
}

fn named(names: &[String]) -> String {
    let shown = names.iter().take(MOST_NAMED).map(String::as_str).collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(MOST_NAMED) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// Removes the folder of a run that is no longer planned.
fn remove_run(campaign: &Campaign, name: &str) -> Result<(), Failure> {
    let path = campaign.folder_of(name);
    if !path.is_dir() {
        return Ok(());
    }
    // Held, so that a process at work in it is not disturbed.
    let _locked = OutputFolder::open(&path)?;
    std::fs::remove_dir_all(&path).map_err(granum_io::Error::file("remove", &path))?;
    Ok(())
}

/// Prints how the campaign ended.
fn report(
    context: &Context,
    campaign: &Campaign,
    summary: &Summary,
    collected: Option<&Collected>,
) -> Result<(), Failure> {
    let (out, quoted) = (campaign.folder().shown(), quoted_path(campaign.folder()));
    let line = summary.progress.line();
    if summary.stopped && context.stopped() {
        let left = format!("{line} in {out}; continue with the same command or `granum resume {quoted}`");
        return Err(Interrupted { left }.into());
    }
    let result = json!({
        "folder": output::path(campaign.folder()),
        "runs": summary.progress.runs,
        "finished": summary.progress.finished,
        "reused": summary.reused,
        "flagged": summary.progress.flagged,
        "refused": summary.progress.refused,
        "failed": summary.failed.iter().map(|(name, why)| json!({ "name": name, "reason": why })).collect::<Vec<_>>(),
        "stopped": summary.stopped,
        "data_set": collected.and_then(|collected| collected.data_set.as_ref()).map(|data_set| json!({
            "folder": output::path(&data_set.folder),
            "runs": data_set.runs,
            "digest": data_set.digest,
        })),
    });
    if let Some(collected) = collected {
        collected.remarks.iter().for_each(|remark| context.warn(remark));
    }
    let found = status::Found::read(campaign)?;
    output::say_complete(context, campaign.folder(), &result, || {
        let mut lines = vec![format!("{out}: {line}")];
        match summary.reused {
            0 => {}
            count if !summary.stopped && count >= summary.progress.runs => {
                lines.push("all were already finished; nothing was left to do".into());
            }
            count => lines.push(format!("{count} runs and samples were already finished")),
        }
        lines.extend(found.flagged_lines());
        lines.extend(collected.map(data_set_line));
        if summary.stopped {
            lines.push(format!(
                "stopped before the end; continue with the same command or: granum resume {quoted}"
            ));
        } else {
            lines.push(format!("their results in a table: granum table {quoted}"));
        }
        lines.join("\n")
    })?;
    if summary.failed.is_empty() {
        return Ok(());
    }
    let told: Vec<String> =
        summary.failed.iter().take(MOST_NAMED).map(|(name, why)| format!("{name}: {why}")).collect();
    let more = match summary.failed.len().saturating_sub(MOST_NAMED) {
        0 => String::new(),
        more => format!("\n  and {more} more"),
    };
    let all = summary.progress.runs;
    Err(Failure::new(format!(
        "{} of {all} runs failed:\n  {}{more}",
        summary.progress.failed,
        told.join("\n  ")
    )))
}
