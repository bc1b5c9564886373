//! `granum train --family` and `granum evaluate --family`: the surrogate of a family, and its scores.

use std::path::{Path, PathBuf};

use granum_io::shell::ShowPath;
use granum_io::{check_output_file, shell::path_text};
use granum_learn::family::{FamilyDefinition, FamilyFit, FamilyModel, FamilyScores, TrainingData, by_name};
use granum_learn::runs::RunRole;
use granum_learn::{Dataset, LearnError, RunStates};
use serde_json::json;

use super::family_card::score_lines;
use super::family_flags::{fitted, is_file};
use super::records::{self, Recorded};
use super::show_steps::ShowSteps;
use super::train_study::dataset;
use crate::context::Context;
use crate::failure::{Failure, Interrupted};
use crate::output;

/// The usual name of the folder of studies, which is no name for a file.
const NO_FILE: &str = "study";

/// Fits the surrogate of a family along a path and scores it on unseen runs.
pub fn train(
    context: &Context,
    (name, path): (&str, Option<&str>),
    (runs, unseen): (&[PathBuf], &[PathBuf]),
    out: &Path,
    threads: usize,
) -> Result<(), Failure> {
    let definition = by_name(name, path)?;
    let file = if out == Path::new(NO_FILE) { PathBuf::from(format!("{name}.json")) } else { out.into() };
    check_output_file(&file, context.force)?;
    let reading = context.nothing_written(Some("reading the runs"));
    let (training, data) = read(context, definition, runs, RunRole::Training)?;
    let unseen = each_read(context, definition, unseen, RunRole::Unseen)?;
    drop(reading);
    let fit = FamilyFit { threads, ..FamilyFit::default() };
    let mut show = ShowSteps::new(context, &format!("fit {name}"));
    let fitted = FamilyModel::fit(definition, &training, data, &fit, &mut show);
    let mut model = fitted.map_err(|error| failure(context, error))?;
    show.end(|| format!("{} runs", model.runs()));
    for (data, about) in unseen {
        let scores = model.score(&data, about)?;
        model.add_scores(scores);
    }
    model.save(&file)?;
    let result = json!({
        "family": name,
        "path": definition.path,
        "output": output::path(&file),
        "runs": model.runs(),
        "data": model.data(),
        "left_out": model.left_out().iter().map(|early| early.run.as_str()).collect::<Vec<_>>(),
        "scores": model.scores(),
    });
    output::say(context, &result, || {
        let mut lines: Vec<String> = model.scores().iter().flat_map(score_lines).collect();
        lines.push(format!("wrote {}, fitted to {} runs", file.shown(), model.runs()));
        lines.join("\n").trim_start().to_string()
    })
}

/// Scores a fitted family, and keeps the scores in its file if that is asked for.
pub fn evaluate(
    context: &Context,
    (name, path): (&str, Option<&str>),
    runs: &[PathBuf],
    keep: bool,
) -> Result<(), Failure> {
    let mut model = fitted(name, path)?;
    if keep && !is_file(name) {
        return Err(Failure::new(format!(
            "--keep: {name} is a family of this program; give the file of a fitted one, NAME.json"
        )));
    }
    let scores = each_read(context, model.definition(), runs, RunRole::Unseen)?
        .into_iter()
        .map(|(data, about)| model.score(&data, about))
        .collect::<Result<Vec<FamilyScores>, LearnError>>()?;
    for (scores, known) in
        scores.iter().flat_map(|scores| model.data().iter().map(move |data| (scores, data)))
    {
        if scores.data.digest == known.digest {
            context.warn(&format!(
                "{} are the runs to which the family was fitted: these scores say nothing of others",
                scores.data.name
            ));
        }
    }
    if keep {
        scores.iter().cloned().for_each(|scores| model.add_scores(scores));
        model.save(Path::new(name))?;
    }
    let FamilyDefinition { name, path, .. } = model.definition();
    output::say(context, &json!({ "family": name, "path": path, "scores": scores }), || {
        let lines: Vec<String> = scores.iter().flat_map(score_lines).collect();
        lines.join("\n").trim_start().to_string()
    })
}

/// The runs of several folders as one data set, with what each folder has.
fn read(
    context: &Context,
    family: &FamilyDefinition,
    folders: &[PathBuf],
    role: RunRole,
) -> Result<(Dataset, Vec<TrainingData>), Failure> {
    let parts = each_read(context, family, folders, role)?;
    let data = parts.iter().map(|(_, about)| about.clone()).collect();
    let runs: Vec<RunStates> = parts.into_iter().flat_map(|(data, _)| data.runs().to_vec()).collect();
    Ok((Dataset::new(runs)?, data))
}

/// The runs along the path of the family of each data set or campaign; folders of single runs are one data set together.
fn each_read(
    context: &Context,
    family: &FamilyDefinition,
    folders: &[PathBuf],
    role: RunRole,
) -> Result<Vec<(Dataset, TrainingData)>, Failure> {
    let is_run = |folder: &&PathBuf| folder.join("run.json").is_file();
    let (single, sets): (Vec<&PathBuf>, Vec<&PathBuf>) = folders.iter().partition(is_run);
    let mut all: Vec<(String, Vec<Recorded>)> = Vec::new();
    for folder in sets {
        all.push((name_of(folder), records::read(context, std::slice::from_ref(folder), role)?));
    }
    if !single.is_empty() {
        let folders: Vec<PathBuf> = single.into_iter().cloned().collect();
        all.push(("runs".into(), records::read(context, &folders, role)?));
    }
    let recorded: Vec<&Recorded> = all.iter().flat_map(|(_, runs)| runs).collect();
    records::check_different(&recorded)?;
    let data_set = |(name, runs): &(String, Vec<Recorded>)| {
        let all = dataset(&runs.iter().collect::<Vec<_>>())?;
        let own = family.along_its_path(&all);
        // Where no run has the path, the family refuses them and says why.
        let data = if own.runs().is_empty() { all } else { own };
        let others = runs.len() - data.runs().len();
        if others > 0 {
            let path = family.path;
            context.note(&format!(
                "{name}: {} runs along the path {path}; {others} along others are left out",
                data.runs().len()
            ));
        }
        let about = TrainingData { name: name.clone(), digest: data.digest(), runs: data.runs().len() };
        Ok((data, about))
    };
    all.iter().map(data_set).collect()
}

/// The name of a data set: that of its folder.
fn name_of(folder: &Path) -> String {
    let whole = std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf());
    whole.file_name().map_or_else(|| path_text(folder), |name| name.to_string_lossy().into_owned())
}

/// The failure of a fit: an interruption, if the user asked for it.
fn failure(context: &Context, error: LearnError) -> Failure {
    match error {
        LearnError::Stopped { .. } if context.stopped() => {
            Interrupted { left: "nothing was written".into() }.into()
        }
        error => error.into(),
    }
}
