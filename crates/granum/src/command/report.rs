//! `granum report`: writes the report of a run or of a whole reproduction from its folder.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use granum::contents::{Contents, Kind, taken};
use granum_antony2006::figures::figures;
use granum_antony2006::files::load_study;
use granum_antony2006::reproduction::{Reproduction, SPEED_FILE, SUMMARY_FILE};
use granum_antony2006::{StudyData, StudyDataOptions};
use granum_antony2006::{StudyReport, speed_page, study_report};
use granum_io::shell::quoted_path;
use granum_io::{Run, RunStatus, atomic::write_atomically, check_output_file};
use granum_learn::NamedRecord;
use granum_report::{Document, Role, RunReport, run_report, sample_report};
use serde_json::json;

use super::records;
use super::reproduce::read_summary;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Write the report of a run folder, a sample folder or a reproduction from the contents of the folder.
///
/// The report consists of report.html, which contains its figures and can be read offline, and of the figures as SVG files
/// in the folder figures.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum report run-1\n  granum report run-1 --out run-1.html\n  granum report reproduction --force"
)]
pub struct Report {
    /// Folder of a run, a sample or a reproduction.
    folder: PathBuf,
    /// Folder for report.html and figures, or a file name that ends in .html for the page alone; by default the folder
    /// itself.
    #[arg(short, long, value_name = "FILE/DIR")]
    out: Option<PathBuf>,
}

impl Report {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let out = self.out.as_deref().unwrap_or(&self.folder);
        let page = out.extension().is_some_and(|extension| extension == "html") && !out.is_dir();
        let file = if page { out.to_path_buf() } else { out.join("report.html") };
        check_output_file(&file, context.force)?;
        if !page {
            self.check_place(out)?;
        }
        let (document, study) = document(&self.folder)?;
        if page {
            write_atomically(out, |file| file.write_all(document.html.as_bytes()))?;
        } else {
            for (name, _) in &document.figures {
                check_output_file(out.join("figures").join(name), context.force)?;
            }
            document.write(out)?;
            study.map_or(Ok(()), |study| write_speed_page(out, &study))?;
        }
        let figures = if page { 0 } else { document.figures.len() };
        output::say(context, &json!({ "report": file, "figure_files": figures }), || match figures {
            0 => format!("wrote {}", file.display()),
            _ => {
                format!("wrote {} and {figures} figures in {}", file.display(), out.join("figures").display())
            }
        })
    }
}

impl Report {
    /// Refuses an output folder that already holds other results, since it would then contain two reports, or the wrong one.
    fn check_place(&self, out: &Path) -> Result<(), Failure> {
        let same =
            |a: &Path, b: &Path| matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b);
        let contents = Contents::of(out)?;
        if contents.kind().is_none() || same(out, &self.folder) {
            return Ok(());
        }
        let what = format!("the report of {}", self.folder.display());
        Err(taken(out, &contents, &what, false).into())
    }
}

/// Writes the page with the computing times of a study, which the report leaves out, since all of the report is the same on
/// every computer. A study whose times are unknown has no such page.
pub(super) fn write_speed_page(folder: &Path, study: &StudyReport) -> Result<(), Failure> {
    if let Some(page) = speed_page(study) {
        write_atomically(&folder.join(SPEED_FILE), |file| file.write_all(page.html.as_bytes()))?;
    }
    Ok(())
}

/// The report of a folder, and the study from which it was made where it is a reproduction.
fn document(folder: &Path) -> Result<(Document, Option<StudyReport>), Failure> {
    let (runs, models) = (folder.join("runs"), folder.join("models"));
    if folder.join(SUMMARY_FILE).is_file() && runs.is_dir() && models.is_dir() {
        let study = study(folder, &runs, &models)?;
        return Ok((study_report(&study), Some(study)));
    }
    let contents = Contents::of(folder)?;
    if contents.kind() == Some(Kind::Reproduction) {
        let (name, next) = (folder.display(), contents.next(folder).text);
        return Err(Failure::new(format!("{name}: the reproduction is not finished; {next}")));
    }
    if folder.join(granum_antony2006::layout::STUDY_FILE).is_file() {
        return Err(Failure::new(format!(
            "{}: it contains networks but no runs to draw; `granum evaluate {} RUN...` scores them on runs",
            folder.display(),
            quoted_path(folder)
        )));
    }
    let run = Run::at(folder)?;
    let about = run.record()?;
    if about.kind == "prepare" {
        if about.status != RunStatus::Finished {
            return Err(Failure::new(format!(
                "{}: the sample is not finished; continue it: `granum resume {}`",
                folder.display(),
                quoted_path(folder)
            )));
        }
        return Ok((sample_report(&RunReport::read(&run, Role::Single)?), None));
    }
    records::check_begun(&run, &about)?;
    Ok((run_report(&RunReport::read(&run, Role::Single)?), None))
}

/// Collects the contents of the folder of a reproduction.
fn study(folder: &Path, runs: &Path, models: &Path) -> Result<StudyReport, Failure> {
    let (path, summary) = (folder.join(SUMMARY_FILE), read_summary(folder)?);
    let reports: Vec<RunReport> = summary
        .dem
        .runs
        .iter()
        .map(|run| {
            let role = match run.role.as_str() {
                "training" => Role::Training,
                "unseen" => Role::Unseen,
                other => {
                    let message =
                        format!("{}: role {other:?} is neither training nor unseen", path.display());
                    return Err(Failure::new(message));
                }
            };
            Ok(RunReport::read(&Run::at(runs.join(format!("{}-{}", role.word(), run.seed)))?, role)?)
        })
        .collect::<Result<_, Failure>>()?;
    let of = |role: Role| -> Vec<NamedRecord> {
        let own = reports.iter().filter(|report| report.role == role);
        own.map(|r| NamedRecord { name: &r.name, seed: r.run.seed.unwrap_or_default(), record: &r.record })
            .collect()
    };
    let dataset = StudyData::new(&of(Role::Training), &of(Role::Unseen), &StudyDataOptions::default())?;
    let study = load_study(models)?;
    let dataset_hash = dataset.hash()?;
    if dataset_hash != study.dataset_hash {
        return Err(Failure::new(format!(
            "{}: the networks were not trained on the runs in {}; train them again: granum resume {}",
            models.display(),
            runs.display(),
            quoted_path(folder)
        )));
    }
    Ok(StudyReport {
        figures: figures(&study, &dataset)?,
        command: Reproduction::read(folder)?.map_or(String::new(), |of| of.options.command_line(None)),
        runs: reports,
        summary,
        dataset_hash,
        network_seed: study.seed,
    })
}
