//! `granum report`: writes the report of a run, of several runs, of a whole reproduction, or of the data of another program.

use granum_io::RunKind;

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use granum::contents::{Contents, FolderKind, taken};
use granum_antony2006::figures::figures;
use granum_antony2006::reproduction::{Reproduction, SUMMARY_FILE};
use granum_antony2006::{PaperData, PaperDataOptions};
use granum_antony2006::{StudyReport, study_report};
use granum_campaign::Campaign;
use granum_io::formats::ObservedAssembly;
use granum_io::shell::ShowPath;
use granum_io::shell::quoted_path;
use granum_io::{RunStatus, atomic::write_atomically, check_new_file};
use granum_learn::NamedRecord;
use granum_report::other_data::Instant;
use granum_report::{
    Document, RoleInStudy, RunReport, data_report, overlay_report, run_report, sample_report,
    surrogate_study_report,
};
use granum_run::runs_table::find_runs;
use serde_json::json;

use super::campaign_report;
use super::measure::packing_alone;
use super::records;
use super::run_folders::run_folders;
use super::sources::SourceFlags;
use super::summary_file::{read_summary, write_speed_page};
use super::whole::open_run;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Write the report of a run, of several runs over each other, of a sample, of a study of any columns, of a reproduction, or of
/// the data of another program.
///
/// The report consists of report.html, which contains its figures and can be read offline, and of the figures as SVG files
/// in the folder figures. Several runs, or folders that contain runs, are drawn over each other, with a legend of the keys by which
/// their cases differ; runs that differ in their seed alone have one colour. The report of a campaign has the curves of all runs, coloured by
/// a variable, their strength against each variable, checks, failures and times. Files of grains and contacts of other programs, as
/// `granum measure` reads them, give a report with their force chains, fabric, distribution of forces and all sensors.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum report run-1\n  granum report run-1 --out run-1.html\n  granum report run-1 run-2 --out both.html\n  \
                  granum report study --colour pressure\n  granum report grains.dump contacts.dump --columns \
                  contacts.dump=index,patom1,patom2,fx,fy,fz,p1,p2,p3 --out lammps\n  granum report reproduction --force"
)]
pub struct Report {
    /// Folders of runs, of a campaign, of a sample or of a reproduction, or files of grains and contacts of another program.
    #[arg(required = true, value_name = "DATA")]
    data: Vec<PathBuf>,
    /// Folder for report.html and figures, or a file name that ends in .html for the page alone. By default the folder of the data;
    /// the page report.html here for several folders or for files.
    #[arg(short, long, value_name = "FILE/DIR")]
    out: Option<PathBuf>,
    /// The variable of a campaign by which its curves are coloured; the first one by default.
    #[arg(long, value_name = "VARIABLE")]
    colour: Option<String>,
    #[command(flatten)]
    sources: SourceFlags,
}

/// Page of the data that have no folder of their own.
const PAGE: &str = "report.html";

impl Report {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let own_folder = match &self.data[..] {
            [one] if one.is_dir() => one.clone(),
            _ => PathBuf::from(PAGE),
        };
        let out = self.out.as_deref().unwrap_or(&own_folder);
        let page = out.extension().is_some_and(|extension| extension == "html") && !out.is_dir();
        let file = if page { out.to_path_buf() } else { out.join("report.html") };
        check_new_file(&file, context.force)?;
        if !page {
            self.check_place(context, out)?;
        }
        // The page and its figures are several files, whose writing is not cut off.
        let (document, study) = {
            let _alone = context.nothing_written(Some("making the report"));
            self.document(context)?
        };
        if page {
            write_atomically(out, |file| file.write_all(document.html.as_bytes()))?;
        } else {
            for (name, _) in &document.figures {
                check_new_file(out.join("figures").join(name), context.force)?;
            }
            document.write(out)?;
            study.map_or(Ok(()), |study| write_speed_page(out, &study))?;
        }
        let figures = if page { 0 } else { document.figures.len() };
        output::say(context, &json!({ "report": output::path(&file), "figure_files": figures }), || {
            match figures {
                0 => format!("wrote {}", file.shown()),
                _ => {
                    format!("wrote {} and {figures} figures in {}", file.shown(), out.join("figures").shown())
                }
            }
        })
    }

    /// Refuses an output folder that already holds other results, since it would then contain two reports, or the wrong one.
    fn check_place(&self, context: &Context, out: &Path) -> Result<(), Failure> {
        let same =
            |a: &Path, b: &Path| matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b);
        let contents = Contents::read(out, context.vocabulary())?;
        let its_own = matches!(&self.data[..], [one] if same(out, one));
        if contents.kind().is_none() || its_own {
            return Ok(());
        }
        let names: Vec<String> = self.data.iter().map(|path| path.shown()).collect();
        let what = format!("the report of {}", names.join(", "));
        Err(taken(out, &contents, &what, false).into())
    }

    fn document(&self, context: &Context) -> Result<(Document, Option<StudyReport>), Failure> {
        if let Some(path) = self.data.iter().find(|path| !path.exists()) {
            return Err(Failure::new(format!("{}: there is no such file or folder", path.shown())));
        }
        let files = self.data.iter().filter(|path| !path.is_dir()).count();
        if files == self.data.len() {
            return Ok((self.of_files(context)?, None));
        }
        if let Some(file) = self.data.iter().find(|path| !path.is_dir()) {
            let message = "is no folder; give folders of runs, or files of another program, not both";
            return Err(Failure::new(format!("{}: {message}", file.shown())));
        }
        if let Some(flag) = self.sources.first_given() {
            return Err(Failure::new(format!("{flag}: it belongs to files of another program, not to runs")));
        }
        let campaign = match &self.data[..] {
            [one] => Campaign::read(one, context.vocabulary())?,
            _ => None,
        };
        if let Some(campaign) = campaign {
            return Ok((campaign_report::document(context, &campaign, self.colour.as_deref())?, None));
        }
        if self.colour.is_some() {
            return Err(Failure::new("--colour: it belongs to the report of a campaign"));
        }
        match &self.data[..] {
            [one] if !is_of_several(context, one)? => document(context, one),
            folders => over_each_other(context, folders),
        }
    }

    /// The report of files of another program.
    fn of_files(&self, context: &Context) -> Result<Document, Failure> {
        let sensors = context.vocabulary().sensors();
        let names: Vec<String> = (self.data.iter())
            .map(|path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned())
            .collect();
        let title = names.join(", ");
        let instant = |name: String, assembly, parts| Instant { name, assembly, parts };
        if let [one] = &self.data[..]
            && one.is_file()
            && self.sources.first_given().is_none()
            && !context.formats().is_result(one)?
        {
            let (assembly, parts) = packing_alone(context, one)?;
            return Ok(data_report(&title, &[instant(title.clone(), assembly, parts)], sensors));
        }
        let found = self.sources.read(context, &self.data)?;
        let count = found.len();
        let named = |(k, found): (usize, ObservedAssembly)| {
            instant(format!("instant {} of {count}", k + 1), found.assembly, found.parts)
        };
        let found = found.into_iter().map(ObservedAssembly::with_contacts_by_geometry);
        let instants: Vec<Instant> = found.enumerate().map(named).collect();
        Ok(data_report(&title, &instants, sensors))
    }
}

/// The report of folders by itself, for whoever shows it elsewhere.
pub fn document_of(context: &Context, folders: &[PathBuf]) -> Result<Document, Failure> {
    let sources = SourceFlags::default();
    let report = Report { data: folders.to_vec(), out: None, colour: None, sources };
    Ok(report.document(context)?.0)
}

/// True for a folder that is no run itself and contains several.
fn is_of_several(context: &Context, folder: &Path) -> Result<bool, Failure> {
    Ok(match Contents::read(folder, context.vocabulary())? {
        Contents::Runs { .. } | Contents::Campaign(_) => true,
        Contents::Other => find_runs(&[folder.to_path_buf()]).is_ok(),
        _ => false,
    })
}

/// The report of the runs in folders, over each other.
fn over_each_other(
    context: &Context,
    folders: &[PathBuf],
) -> Result<(Document, Option<StudyReport>), Failure> {
    let found = run_folders(context, folders)?;
    let mut runs = Vec::new();
    for folder in &found {
        let run = open_run(context, folder)?;
        let about = run.record()?;
        if about.kind == RunKind::Sample {
            let message =
                "is a sample; tests are drawn over each other, and a sample has a report of its own";
            return Err(Failure::new(format!("{}: {message}", folder.shown())));
        }
        records::check_begun(&run, &about)?;
        if about.status != RunStatus::Finished {
            context.warn(&format!(
                "{} did not reach its end; the states recorded so far are drawn",
                folder.shown()
            ));
        }
        runs.push(RunReport::read_without_pictures(&run, RoleInStudy::Single)?);
    }
    // Runs of different studies may have the same name.
    let names: Vec<String> = runs.iter().map(|run| run.name.clone()).collect();
    for (run, folder) in runs.iter_mut().zip(&found) {
        if names.iter().filter(|name| **name == run.name).count() > 1 {
            run.name = folder.shown();
        }
    }
    match &runs[..] {
        [_] => document(context, &found[0]),
        _ => Ok((overlay_report(&runs), None)),
    }
}

/// What each soft sensor is worth, if the folder of a study has it.
fn worth_in(folder: &Path) -> Result<Option<granum_learn::worth::Worth>, Failure> {
    let file = folder.join("worth.json");
    if !file.is_file() {
        return Ok(None);
    }
    let text =
        granum_core::input::read_text(&file, 1 << 26).map_err(granum_io::Error::file("read", &file))?;
    let read = serde_json::from_str(&text);
    let name = file.shown();
    read.map(Some).map_err(|error| {
        Failure::new(format!(
            "{name}: it is not what `granum worth` writes ({error}); write it again or remove it"
        ))
    })
}

/// The report of a folder, and the study from which it was made where it is a reproduction.
fn document(context: &Context, folder: &Path) -> Result<(Document, Option<StudyReport>), Failure> {
    let (runs, models) = (folder.join("runs"), folder.join("models"));
    if folder.join(SUMMARY_FILE).is_file() && runs.is_dir() && models.is_dir() {
        let study = study(context, folder, &runs, &models)?;
        return Ok((study_report(&study), Some(study)));
    }
    let contents = Contents::read(folder, context.vocabulary())?;
    if contents.kind() == Some(FolderKind::Reproduction) {
        let (name, next) = (folder.shown(), contents.next(folder).text);
        return Err(Failure::new(format!("{name}: the reproduction is not finished; {next}")));
    }
    if granum_learn::study::is_study(folder) {
        let stored = granum_learn::study::load(folder, context.methods())?;
        let name = folder.file_name().map_or_else(|| "study".into(), |name| name.to_string_lossy());
        let worth = worth_in(folder)?;
        return Ok((surrogate_study_report(&stored, &name, worth.as_ref()), None));
    }
    if folder.join(granum_learn::study::STUDY_FILE).is_file() {
        return Err(Failure::new(format!(
            "{}: it contains networks but no runs to draw; `granum evaluate {} RUN...` scores them on runs",
            folder.shown(),
            quoted_path(folder)
        )));
    }
    let run = open_run(context, folder)?;
    let about = run.record()?;
    if about.kind == RunKind::Sample {
        if about.status != RunStatus::Finished {
            return Err(Failure::new(format!(
                "{}: the sample is not finished; continue it: `granum resume {}`",
                folder.shown(),
                quoted_path(folder)
            )));
        }
        return Ok((sample_report(&RunReport::read(&run, RoleInStudy::Single)?), None));
    }
    records::check_begun(&run, &about)?;
    Ok((run_report(&RunReport::read(&run, RoleInStudy::Single)?), None))
}

/// Collects the contents of the folder of a reproduction.
fn study(context: &Context, folder: &Path, runs: &Path, models: &Path) -> Result<StudyReport, Failure> {
    let (path, summary) = (folder.join(SUMMARY_FILE), read_summary(folder)?);
    let reports: Vec<RunReport> = summary
        .dem
        .runs
        .iter()
        .map(|run| {
            let role = match run.role.as_str() {
                "training" => RoleInStudy::Training,
                "unseen" => RoleInStudy::Unseen,
                other => {
                    let message = format!("{}: role {other:?} is neither training nor unseen", path.shown());
                    return Err(Failure::new(message));
                }
            };
            Ok(RunReport::read(&context.run_at(runs.join(format!("{}-{}", role.word(), run.seed)))?, role)?)
        })
        .collect::<Result<_, Failure>>()?;
    let of = |role: RoleInStudy| -> Vec<NamedRecord> {
        let own = reports.iter().filter(|report| report.role == role);
        own.map(|r| NamedRecord { name: &r.name, seed: r.run.seed.unwrap_or_default(), record: &r.record })
            .collect()
    };
    let data = PaperData::from_records(
        &of(RoleInStudy::Training),
        &of(RoleInStudy::Unseen),
        &PaperDataOptions::default(),
    )?;
    let study = granum_learn::study::load(models, context.methods())?.study;
    let dataset_hash = data.hash()?;
    if data.dataset.digest() != study.dataset_digest {
        return Err(Failure::new(format!(
            "{}: the networks were not trained on the runs in {}; train them again: granum resume {}",
            models.shown(),
            runs.shown(),
            quoted_path(folder)
        )));
    }
    Ok(StudyReport {
        figures: figures(&study, &data)?,
        command: Reproduction::read(folder)?.map_or(String::new(), |of| of.options.command_line(None)),
        runs: reports,
        summary,
        dataset_hash,
        network_seed: study.definition.fits.first().map_or(1, |fit| fit.seed),
    })
}
