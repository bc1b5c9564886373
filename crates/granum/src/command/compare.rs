//! `granum compare`: runs over the curves of laboratory tests, or over each other.

use granum_io::RunKind;

use std::path::{Path, PathBuf};

use clap::Args;
use granum_core::{Column, Table};
use granum_io::shell::ShowPath;
use granum_io::{Case, LaboratoryTest, check_output_file, read_laboratory};
use granum_report::comparison::{ComparedRun, Errors, errors, figure};
use granum_report::strength::{Measures, late_state, scatter_table};
use granum_run::record::read_record;
use granum_run::runs_table::{RunEntry, legend};
use granum_run::strength::critical_state_line::{CriticalStateLine, LateState};
use granum_run::strength::one_material;
use serde_json::{Value, json};

use super::comparability::{check_common, unlike_stresses};
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
                  lab.csv --map axial_strain='eps1 (%)' --map deviator_stress='q (kPa)' --compression negative\n  granum compare run-1 run-2"
)]
pub struct Compare {
    /// Folders of runs or with runs, and the laboratory's file last, if there is one.
    #[arg(required = true, num_args = 1.., value_names = ["RUN", "LAB.csv"])]
    files: Vec<PathBuf>,
    /// A test of the file; can be repeated. All tests of a file with no more than three are drawn without it.
    #[arg(long, value_name = "NAME")]
    test: Vec<String>,
    #[command(flatten)]
    laboratory: LaboratoryFlags,
    /// Figure to write.
    #[arg(short, long, default_value = "compare.svg", value_name = "FILE")]
    output: PathBuf,
}

/// Largest number of tests that are drawn without being named.
const MOST_TESTS: usize = 3;

impl Compare {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let _alone = context.nothing_written(Some("comparing"));
        check_output_file(&self.output, context.force)?;
        let (runs, pairs, entries) = match self.files.split_last() {
            Some((lab, folders)) if !lab.is_dir() => {
                let tests = read_laboratory(lab, &self.laboratory.conventions()?)?;
                let tests = self.chosen(&tests)?;
                doubts(&tests).iter().for_each(|doubt| context.warn(doubt));
                let runs: Vec<ComparedRun> =
                    folders.iter().map(|folder| curves(context, folder)).collect::<Result<_, _>>()?;
                check_common(&runs, &tests)?;
                unlike_stresses(&runs, &tests).iter().for_each(|remark| context.warn(remark));
                let pairs = (runs.iter())
                    .flat_map(|run| tests.iter().map(|test| Pair::new(run, test)).collect::<Vec<_>>())
                    .collect();
                self.draw(&runs, &tests)?;
                let entries = entries(context, folders)?;
                (runs, pairs, entries)
            }
            _ => {
                let (runs, entries) = self.labelled(context)?;
                let Some((first, others)) = runs.split_first().filter(|(_, others)| !others.is_empty())
                else {
                    let message = "give two runs or more, or runs and the laboratory's file last";
                    return Err(Failure::new(message));
                };
                let pairs: Vec<Pair> = others.iter().map(|run| Pair::new(run, &first.curves)).collect();
                self.draw(&runs, &[])?;
                (runs, pairs, entries)
            }
        };
        let names: Vec<&str> = runs.iter().map(|run| run.name.as_str()).collect();
        let strength = Strength::from_runs(&entries, &runs);
        output::say(context, &as_json(&pairs, &names, &strength, &self.output), || {
            let lines = [vec![text(&pairs)], strength.lines()].concat();
            format!("{}\nwrote {}", lines.join("\n"), self.output.shown())
        })
    }

    /// The runs of the folders, each named by the keys in which it differs from the others.
    fn labelled(&self, context: &Context) -> Result<(Vec<ComparedRun>, Vec<RunEntry>), Failure> {
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
            let mut curves = curves(context, folder)?;
            curves.curves.name.clone_from(&name);
            Ok(ComparedRun { name, ..curves })
        };
        Ok((folders.iter().zip(labels).map(named).collect::<Result<_, Failure>>()?, entries))
    }

    fn draw(&self, runs: &[ComparedRun], tests: &[&LaboratoryTest]) -> Result<(), Failure> {
        let (figure, _) = figure(runs, tests);
        Ok(granum_io::atomic::write_atomically(&self.output, |file| {
            std::io::Write::write_all(file, figure.to_svg().as_bytes())
        })?)
    }

    /// The tests that are drawn.
    fn chosen<'a>(&self, tests: &'a [LaboratoryTest]) -> Result<Vec<&'a LaboratoryTest>, Failure> {
        let names = || tests.iter().map(|test| test.name.as_str()).collect::<Vec<_>>().join(", ");
        if self.test.is_empty() {
            if tests.len() > MOST_TESTS {
                let message =
                    format!("the file holds {} tests; choose some with --test: {}", tests.len(), names());
                return Err(Failure::new(message));
            }
            return Ok(tests.iter().collect());
        }
        let find = |name: &String| {
            tests.iter().find(|test| test.name == *name).ok_or_else(|| {
                Failure::new(format!("--test {name}: there is no such test; there are {}", names()))
            })
        };
        self.test.iter().map(find).collect()
    }
}

/// The runs in folders.
fn entries(context: &Context, folders: &[PathBuf]) -> Result<Vec<RunEntry>, Failure> {
    folders.iter().map(|folder| Ok(RunEntry::from_run(&context.run_at(folder)?)?)).collect()
}

fn curves(context: &Context, folder: &Path) -> Result<ComparedRun, Failure> {
    let run = open_run(context, folder)?;
    let about = run.record()?;
    check_begun(&run, &about)?;
    let name = folder.file_name().map_or_else(|| folder.shown(), |name| name.to_string_lossy().into_owned());
    let (case, record) = (run.case()?, read_record(&run)?);
    let measures = granum_run::strength::of_run(&case, &about, &record);
    Ok(ComparedRun { measures, ..ComparedRun::from_record(&name, &record, &case.test_stages()) })
}

/// The strength of runs, with the scatter of those that differ in their seeds alone, and the critical state line through them.
struct Strength {
    table: Table,
    line: Option<CriticalStateLine>,
    /// Keys by which the runs are of different materials, which have no line in common.
    materials_differ_in: Vec<String>,
}

impl Strength {
    fn from_runs(entries: &[RunEntry], runs: &[ComparedRun]) -> Strength {
        let measures: Vec<Measures> = runs.iter().map(|run| run.measures.clone()).collect();
        let states: Vec<LateState> = measures.iter().filter_map(late_state).collect();
        let cases: Vec<&Case> = entries.iter().map(|entry| &entry.case).collect();
        let materials_differ_in = one_material::differing(&cases);
        let line = CriticalStateLine::through(&states).filter(|_| materials_differ_in.is_empty());
        Strength { table: scatter_table(entries, &measures), line, materials_differ_in }
    }

    /// The rows of the table as objects.
    fn rows(&self) -> Vec<Value> {
        let cell = |column: &Column, row: usize| match column.numbers() {
            Some(numbers) => json!(numbers.get(row).filter(|value| value.is_finite())),
            None => json!(column.text(row)),
        };
        let object = |row: usize| {
            let cells = self.table.columns().iter().map(|column| (column.name.clone(), cell(column, row)));
            Value::Object(cells.collect())
        };
        (0..self.table.rows()).map(object).collect()
    }

    fn lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if self.table.columns().len() > 1 {
            lines.push(String::new());
            lines.extend(text_table::lines(&self.table));
        }
        if !self.materials_differ_in.is_empty() {
            lines.push(format!(
                "no critical state line: the runs are of different materials ({})",
                self.materials_differ_in.join(", ")
            ));
        }
        if let Some(line) = &self.line {
            let error = |error: Option<f64>| error.map_or(String::new(), |error| format!(" +- {error:.4}"));
            let [low, high] = line.range.map(|p| p / 1e3);
            lines.push(format!(
                "critical state line e = Gamma - lambda ln(p / 1 kPa) through the late states of {} runs: Gamma {:.4}{}, lambda \
                 {:.4}{} (standard errors), from {low:.1} to {high:.1} kPa",
                line.tests,
                line.intercept,
                error(line.intercept_error),
                line.slope,
                error(line.slope_error),
            ));
        }
        lines
    }
}

fn line_as_json(line: &CriticalStateLine) -> Value {
    json!({
        "void_ratio_at_1_kPa": line.intercept,
        "void_ratio_at_1_kPa_standard_error": line.intercept_error,
        "lambda": line.slope,
        "lambda_standard_error": line.slope_error,
        "scatter_of_void_ratio": line.scatter,
        "runs": line.tests,
        "mean_stress_range": line.range,
    })
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

fn as_json(pairs: &[Pair], runs: &[&str], strength: &Strength, figure: &Path) -> Value {
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
    json!({
        "runs": runs,
        "comparisons": pairs.iter().map(pair).collect::<Vec<_>>(),
        "strength": strength.rows(),
        "critical_state_line": strength.line.map(|line| line_as_json(&line)),
        "materials_differ_in": strength.materials_differ_in,
        "figure": output::path(figure),
    })
}

fn text(pairs: &[Pair]) -> String {
    let percent =
        |value: Option<f64>| value.map_or("-".to_string(), |value| format!("{:.1} %", 100.0 * value));
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
            .map_or("-".to_string(), |value| format!("{:.2} % strain", 100.0 * value));
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
