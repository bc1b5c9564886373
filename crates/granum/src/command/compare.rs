//! `granum compare`: runs over the curves of laboratory tests, or over each other.

use granum_core::words;
use granum_io::RunKind;

use std::path::{Path, PathBuf};

use clap::Args;
use granum_core::Table;
use granum_io::shell::ShowPath;
use granum_io::{LaboratoryTest, check_output_file, read_laboratory, write_table};
use granum_report::comparison::{ComparedRun, Errors, errors, figure, residuals};
use granum_report::figure::Figure;
use granum_report::laboratory_summary::{LaboratorySummary, summary_table};
use granum_run::record::read_record;
use granum_run::runs_table::{RunEntry, legend, repetitions};
use granum_sensors::Record;
use serde_json::{Value, json};

use super::comparability::{check_common, unlike_stresses};
use super::compare_strength::Strength;
use super::laboratory_flags::{LaboratoryFlags, doubts};
use super::records::check_begun;
use super::run_folders::run_folders;
use super::text_table;
use super::whole::open_run;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Draw runs over the curves of laboratory tests (deviator stress, volumetric strain, void ratio against axial strain) and print
/// the differences.
///
/// Without a laboratory file the runs are drawn over each other, with a legend of the keys by which their cases differ, and the
/// differences are those from the first run. A folder that contains runs stands for all of them.
///
/// The laboratory's file is a CSV with a row for each reading. Its header names the columns with their units, e.g. `axial_strain
/// (%)` or `axial_stress_kPa`; known are axial_strain, volumetric_strain, axial_stress, lateral_stress, deviator_stress,
/// mean_stress, void_ratio, initial_void_ratio and test (a name, where the file holds several tests). Compression is positive and
/// strains are engineering strains, unless flags or comments `# compression = negative` and `# strain = logarithmic` in the file
/// say otherwise. The logarithmic strains of runs are converted.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum compare run-dense data/lab/karlsruhe-fine-sand-drained.csv --test TMD22\n  granum compare run-1 run-2 \
                  lab.csv --map axial_strain='eps1 (%)' --map deviator_stress='q (kPa)' --compression negative\n  granum compare run-1 run-2\n  granum compare runs lab.csv --test all --same-stress --summary summary.csv --residuals residuals.csv"
)]
pub struct Compare {
    /// Folders of runs or with runs, and the laboratory's files last, if there are any.
    #[arg(required = true, num_args = 1.., value_names = ["RUN", "LAB.csv"])]
    files: Vec<PathBuf>,
    /// A test of the files; can be repeated. `all` stands for all tests, which is the default where there are no more than three.
    #[arg(long, value_name = "NAME")]
    test: Vec<String>,
    #[command(flatten)]
    laboratory: LaboratoryFlags,
    /// Compare each run only with those tests that begin at its mean stress, within 5 %.
    #[arg(long)]
    same_stress: bool,
    /// Also write what a laboratory reports of all tests and runs as a table: peak and late strength, dilatancy angle, E50 and secant moduli
    /// (a file .csv, .tsv or .parquet).
    #[arg(long, value_name = "FILE")]
    summary: Option<PathBuf>,
    /// Also write the differences at all readings as a table (a file .csv, .tsv or .parquet).
    #[arg(long, value_name = "FILE")]
    residuals: Option<PathBuf>,
    /// Figure to write.
    #[arg(short, long, default_value = "compare.svg", value_name = "FILE")]
    output: PathBuf,
}

/// Largest number of tests that are drawn without being named.
const MOST_TESTS: usize = 3;
/// The word for all tests.
const ALL_TESTS: &str = "all";
/// Share by which mean stresses that are alike may differ.
const LIKE_STRESS: f64 = 0.05;

impl Compare {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let _alone = context.nothing_written(Some("comparing"));
        let also = [&self.summary, &self.residuals];
        for path in also.into_iter().flatten().chain([&self.output]) {
            check_output_file(path, context.force)?;
        }
        // The laboratory's files come last: the last one may be anything but a folder, such as a pipe.
        let is_lab = |(place, path): &(usize, &PathBuf)| match place {
            0 => !path.is_dir(),
            _ => path.is_file(),
        };
        let labs = self.files.iter().rev().enumerate().take_while(is_lab).count();
        let first_file = self.files.len() - labs;
        let (folders, labs) = self.files.split_at(first_file);
        let (runs, records, tests, entries) = match labs.is_empty() {
            false => {
                if folders.is_empty() {
                    return Err(Failure::new("give runs before the laboratory's files"));
                }
                let folders = run_folders(context, folders)?;
                let tests = self.chosen(self.laboratory_tests(labs)?)?;
                let used: Vec<&LaboratoryTest> = tests.iter().collect();
                doubts(&used).iter().for_each(|doubt| context.warn(doubt));
                let (runs, records): (Vec<ComparedRun>, Vec<Record>) = (folders.iter())
                    .map(|folder| curves(context, folder))
                    .collect::<Result<Vec<_>, _>>()?
                    .into_iter()
                    .unzip();
                check_common(&runs, &used)?;
                unlike_stresses(&runs, &used).iter().for_each(|remark| context.warn(remark));
                (runs, records, tests, entries(context, &folders)?)
            }
            true => {
                let (runs, records, entries) = self.labelled(context)?;
                if runs.len() < 2 {
                    let message = "give two runs or more, or runs and the laboratory's file last";
                    return Err(Failure::new(message));
                }
                (runs, records, Vec::new(), entries)
            }
        };
        let compared: Vec<(&ComparedRun, &LaboratoryTest)> = match (tests.is_empty(), runs.split_first()) {
            (true, Some((first, others))) => others.iter().map(|run| (run, &first.curves)).collect(),
            _ => runs.iter().flat_map(|run| tests.iter().map(move |test| (run, test))).collect(),
        };
        let compared = self.like(compared)?;
        let pairs: Vec<Pair> = compared.iter().map(|(run, test)| Pair::new(run, test)).collect();
        // Over tests repetitions are a band; over each other each run is a line.
        let groups = if tests.is_empty() { Vec::new() } else { repetitions(&entries) };
        let strength = Strength::from_runs(&entries, &runs, &records);
        let (mut drawn, _) = figure(&runs, &tests, &compared, &groups);
        drawn.panels.extend(strength.panel().filter(|_| tests.is_empty()));
        self.draw(&drawn)?;
        let names: Vec<&str> = runs.iter().map(|run| run.name.as_str()).collect();
        let summary = summary(&runs, &tests)?;
        if let Some(path) = &self.summary {
            write_table(path, &summary)?;
        }
        if let Some(path) = &self.residuals {
            write_table(path, &residuals(&compared)?)?;
        }
        output::say(context, &as_json(&pairs, &names, &strength, &summary, &self.output), || {
            let summary = [vec![String::new()], text_table::lines(&summary)].concat();
            let lines = [vec![text(&pairs)], summary, strength.lines()].concat();
            let written = also.into_iter().flatten().chain([&self.output]).map(|path| path.shown());
            format!("{}\nwrote {}", lines.join("\n"), written.collect::<Vec<_>>().join(", "))
        })
    }

    /// The tests of all files; where there are several files, a test without a name has that of its file.
    fn laboratory_tests(&self, labs: &[PathBuf]) -> Result<Vec<LaboratoryTest>, Failure> {
        let conventions = self.laboratory.conventions()?;
        let mut all = Vec::new();
        for path in labs {
            for mut test in read_laboratory(path, &conventions)? {
                if test.name.is_empty() && labs.len() > 1 {
                    test.name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
                }
                all.push(test);
            }
        }
        Ok(all)
    }

    /// The runs with the tests at their mean stress, if these alone are to be compared.
    fn like<'a>(
        &self,
        compared: Vec<(&'a ComparedRun, &'a LaboratoryTest)>,
    ) -> Result<Vec<(&'a ComparedRun, &'a LaboratoryTest)>, Failure> {
        if !self.same_stress {
            return Ok(compared);
        }
        let is_like = |(run, test): &(&ComparedRun, &LaboratoryTest)| {
            let first = |curves: &LaboratoryTest| curves.mean_stress.first().copied().unwrap_or(f64::NAN);
            (first(&run.curves) / first(test) - 1.0).abs() <= LIKE_STRESS
        };
        let like: Vec<_> = compared.into_iter().filter(is_like).collect();
        match like.is_empty() {
            true => {
                Err(Failure::new("--same-stress: no run begins at the mean stress of a test, within 5 %"))
            }
            false => Ok(like),
        }
    }

    /// The runs of the folders, each named by the keys in which it differs from the others.
    fn labelled(&self, context: &Context) -> Result<Labelled, Failure> {
        if !self.test.is_empty() || self.laboratory.is_given() {
            let message = "--test, --map, --as, --compression and --strain belong to a laboratory's file, which comes last";
            return Err(Failure::new(message));
        }
        if let Some(file) = self.files.iter().find(|path| path.is_file()) {
            let message = format!("{}: is a file, not a run; the laboratory's file comes last", file.shown());
            return Err(Failure::new(message));
        }
        let folders = run_folders(context, &self.files)?;
        let entries = entries(context, &folders)?;
        if let Some(sample) = entries.iter().find(|entry| entry.record.kind == RunKind::Sample) {
            return Err(Failure::new(format!("{}: is a sample, not a test", sample.folder.shown())));
        }
        let labels = legend(&entries);
        let named = |(folder, name): (&PathBuf, String)| {
            let (mut curves, record) = curves(context, folder)?;
            curves.curves.name.clone_from(&name);
            Ok((ComparedRun { name, ..curves }, record))
        };
        let runs = folders.iter().zip(labels).map(named).collect::<Result<Vec<_>, Failure>>()?;
        let (runs, records) = runs.into_iter().unzip();
        Ok((runs, records, entries))
    }

    fn draw(&self, figure: &Figure) -> Result<(), Failure> {
        Ok(granum_io::atomic::write_atomically(&self.output, |file| {
            std::io::Write::write_all(file, figure.to_svg().as_bytes())
        })?)
    }

    /// The tests that are drawn.
    fn chosen(&self, tests: Vec<LaboratoryTest>) -> Result<Vec<LaboratoryTest>, Failure> {
        let names = || tests.iter().map(|test| test.name.as_str()).collect::<Vec<_>>().join(", ");
        if self.test.is_empty() && tests.len() > MOST_TESTS {
            let message = format!(
                "there are {} tests; choose some with --test, or all of them with --test {ALL_TESTS}: {}",
                tests.len(),
                names()
            );
            return Err(Failure::new(message));
        }
        if self.test.is_empty() || self.test.iter().any(|name| name == ALL_TESTS) {
            return Ok(tests);
        }
        let find = |name: &String| {
            tests.iter().find(|test| test.name == *name).cloned().ok_or_else(|| {
                Failure::new(format!("--test {name}: there is no such test; there are {}", names()))
            })
        };
        self.test.iter().map(find).collect()
    }
}

/// What a laboratory reports of all tests and runs, each over its own range of strain.
fn summary(runs: &[ComparedRun], tests: &[LaboratoryTest]) -> Result<Table, Failure> {
    let of_run = |run: &ComparedRun| {
        let curves = LaboratoryTest { name: run.name.clone(), ..run.curves.clone() };
        LaboratorySummary::of_curves(&curves, run.measures.clone())
    };
    let all: Vec<LaboratorySummary> =
        tests.iter().map(LaboratorySummary::of_test).chain(runs.iter().map(of_run)).collect();
    Ok(summary_table(&all)?)
}

/// Runs with their measurements and what a table says of them.
type Labelled = (Vec<ComparedRun>, Vec<Record>, Vec<RunEntry>);

/// The runs in folders.
fn entries(context: &Context, folders: &[PathBuf]) -> Result<Vec<RunEntry>, Failure> {
    folders.iter().map(|folder| Ok(RunEntry::from_run(&context.run_at(folder)?)?)).collect()
}

fn curves(context: &Context, folder: &Path) -> Result<(ComparedRun, Record), Failure> {
    let run = open_run(context, folder)?;
    let about = run.record()?;
    check_begun(&run, &about)?;
    let name = folder.file_name().map_or_else(|| folder.shown(), |name| name.to_string_lossy().into_owned());
    let (case, record) = (run.case()?, read_record(&run)?);
    let measures = granum_run::strength::of_run(&case, &about, &record);
    let compared = ComparedRun { measures, ..ComparedRun::from_record(&name, &record, &case.test_stages()) };
    Ok((compared, record))
}

/// A run, the test or run with which it is compared, and the differences.
struct Pair {
    run: String,
    other: String,
    errors: Errors,
}

impl Pair {
    fn new(run: &ComparedRun, other: &LaboratoryTest) -> Pair {
        Pair { run: run.name.clone(), other: other.name.clone(), errors: errors(run, other) }
    }
}

fn as_json(pairs: &[Pair], runs: &[&str], strength: &Strength, summary: &Table, figure: &Path) -> Value {
    let pair = |Pair { run, other, errors }: &Pair| {
        json!({
            "run": run,
            "test": other,
            "up_to_axial_strain": errors.up_to,
            "deviator_stress_error": errors.deviator_stress,
            "peak_deviator_stress_error": errors.peak,
            "volumetric_strain_error": errors.volumetric_strain,
            "void_ratio_error": errors.void_ratio,
        })
    };
    let mut comparison = json!({
        "runs": runs,
        "comparisons": pairs.iter().map(pair).collect::<Vec<_>>(),
        "summary": text_table::rows(summary),
        "figure": output::path(figure),
    });
    strength.add_to(&mut comparison);
    comparison
}

fn text(pairs: &[Pair]) -> String {
    let percent = |value: Option<f64>| value.map_or("-".to_string(), |value| words::percent(value, 1));
    let width = |of: fn(&Pair) -> &str, least: usize| {
        pairs.iter().map(|pair| of(pair).chars().count()).fold(least, usize::max)
    };
    let (runs, others) = (width(|pair| &pair.run, 20), width(|pair| &pair.other, 13));
    let mut lines = vec![format!(
        "{:<runs$} {:<others$} {:>12} {:>12} {:>12} {:>16} {:>12}",
        "run", "compared with", "up to eps_1", "q (rms)", "largest q", "eps_v (rms)", "e (rms)"
    )];
    for Pair { run, other, errors } in pairs {
        let void_ratio = errors.void_ratio.map_or("-".to_string(), |value| format!("{value:.4}"));
        let volume = errors
            .volumetric_strain
            .map_or("-".to_string(), |value| format!("{} strain", words::percent(value, 2)));
        lines.push(format!(
            "{run:<runs$} {other:<others$} {:>12} {:>12} {:>12} {volume:>16} {void_ratio:>12}",
            percent(Some(errors.up_to)),
            percent(errors.deviator_stress),
            percent(errors.peak),
        ));
    }
    lines.push(
        "q: relative to the largest q of what the run is compared with; largest q: its ratio minus one"
            .into(),
    );
    lines.join("\n")
}
