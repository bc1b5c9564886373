//! The report of a campaign.

use granum_campaign::plan::RunValue;
use granum_campaign::{Campaign, CampaignStatus, RunState};
use granum_core::names::suggestion;
use granum_core::parallel;
use granum_io::shell::ShowPath;
use granum_report::campaign::{CampaignEntry, CampaignRuns, ReportVariable, VariableValue};
use granum_report::{Document, RoleInStudy, RunReport, campaign_report};

use crate::context::Context;
use crate::failure::Failure;

/// The report of a campaign, whose curves are coloured by a variable: the first one that is no seed, if none is chosen.
pub fn document(context: &Context, campaign: &Campaign, colour: Option<&str>) -> Result<Document, Failure> {
    let coloured_by = chosen(campaign, colour)?;
    let status = CampaignStatus::read(campaign)?;
    let with_state = || campaign.runs().iter().zip(&status.states);
    let finished: Vec<_> = with_state()
        .filter_map(|(run, state)| match state {
            RunState::Finished { accepted, .. } => Some((run, *accepted)),
            _ => None,
        })
        .collect();
    if finished.is_empty() {
        let message = format!("{}: none of its runs is finished", campaign.folder().shown());
        return Err(Failure::new(message));
    }
    let rows = campaign.rows_kept()?;
    let entry = |k: usize| -> Result<CampaignEntry, Failure> {
        context.check_stopped(|| "nothing was written".into())?;
        let (run, accepted) = finished[k];
        let folder = campaign.folder_of(&run.name);
        let report = match folder.join("run.json").is_file() {
            true => RunReport::read_without_pictures(&context.run_at(folder)?, RoleInStudy::Single)?,
            false => {
                let stored = rows.run(&run.name)?;
                let case = campaign.case_of(run)?;
                RunReport::of_parts(&run.name, case, stored.record, stored.measured, RoleInStudy::Single)
            }
        };
        let values = run.values.iter().map(value).collect();
        Ok(CampaignEntry::new(&report, values, accepted, finished.len()))
    };
    let runs = parallel::map(finished.len(), 0, entry)?;
    let failed = with_state().filter_map(|(run, state)| match state {
        RunState::Failed { reason } => {
            let values = campaign.variables().iter().zip(&run.values);
            let values: Vec<String> =
                values.map(|(variable, value)| format!("{} = {value}", variable.name)).collect();
            Some([run.name.clone(), values.join(", "), reason.clone()])
        }
        _ => None,
    });
    let failed: Vec<[String; 3]> = failed.collect();
    let folder = std::path::absolute(campaign.folder()).unwrap_or_else(|_| campaign.folder().to_path_buf());
    let name = folder.file_name().map_or_else(|| folder.shown(), |name| name.to_string_lossy().into_owned());
    let variable = |variable: &granum_campaign::VariableRecord| ReportVariable {
        name: variable.name.clone(),
        unit: variable.unit.clone(),
        logarithmic: variable.logarithmic,
        is_seed: is_seed(variable),
    };
    Ok(campaign_report(&CampaignRuns {
        name,
        variables: campaign.variables().iter().map(variable).collect(),
        unfinished: campaign.runs().len() - runs.len() - failed.len(),
        runs,
        failed,
        coloured_by,
    }))
}

/// True for a variable that is the seed of samples.
fn is_seed(variable: &granum_campaign::VariableRecord) -> bool {
    variable.keys.iter().all(|key| key == "preparation.seed")
}

fn value(value: &RunValue) -> VariableValue {
    match value {
        RunValue::Number(number) => VariableValue::Number(*number),
        RunValue::Word(word) => VariableValue::Word(word.clone()),
    }
}

/// The number of the variable by which curves are coloured.
fn chosen(campaign: &Campaign, colour: Option<&str>) -> Result<usize, Failure> {
    let Some(wanted) = colour else {
        // A seed is no quantity that colours could show.
        return Ok(campaign.variables().iter().position(|variable| !is_seed(variable)).unwrap_or(0));
    };
    let names = || campaign.variables().iter().map(|variable| variable.name.as_str());
    names().position(|name| name == wanted).ok_or_else(|| {
        let help = suggestion(wanted, names().collect::<Vec<_>>().into_iter());
        Failure::new(format!("--colour {wanted}: the campaign has no such variable; {help}"))
    })
}
