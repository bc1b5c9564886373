//! What a plan says, before its runs are made.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use granum_core::input::read_text;
use granum_io::shell::ShowPath;
use granum_io::{Case, Error, InputError, Result};
use granum_run::engine::LammpsStart;
use serde::{Deserialize, Serialize};

use super::design::PointDesign;
use super::expression::{Condition, Expression};

/// The key that stands for the named path of the test.
pub(super) const PATH: &str = "path";

/// A plan as it is written: the base case, the variables and the design. [`Plan::read`] reads it, [`Plan::runs`] makes its runs.
///
/// ```
/// use granum_campaign::plan::Plan;
///
/// let folder = tempfile::tempdir()?;
/// std::fs::write(folder.path().join("sand.toml"), "[grains]\ncount = 300\n")?;
/// let text = "case = 'sand.toml'\n[design]\nkind = 'sobol'\npoints = 8\n\
///             [[variable]]\nname = 'friction'\nkey = 'grains.material.friction'\nfrom = 0.1\nto = 0.8\nscale = 'log'\n";
/// let file = folder.path().join("plan.toml");
/// std::fs::write(&file, text)?;
/// let runs = Plan::read(&file, Default::default())?.runs()?;
/// assert_eq!(runs.runs.len(), 8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Plan {
    /// Where the plan was read from, for messages.
    pub source: PlanSource,
    /// The file of the base case.
    pub case_file: PathBuf,
    /// The base case.
    pub case: Case,
    /// Keys that every run has in addition to those of the base case.
    pub fixed: Vec<FixedKey>,
    /// The variables, in the order of the plan.
    pub variables: Vec<PlanVariable>,
    /// The design.
    pub design: DesignTable,
    /// What every run must fulfil.
    pub constraints: Vec<Spanned<Condition>>,
    /// Limits up to which a run that did not pass a check is taken all the same.
    pub accept: Vec<Spanned<Condition>>,
    /// What stays of the runs.
    pub keep: Keep,
    /// The engine that carries out the tests; empty for granum's own.
    pub engine: String,
    /// How LAMMPS is started, if it is the engine.
    pub lammps: LammpsStart,
}

/// What stays of finished runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Keep {
    /// Their folders.
    #[default]
    Folders,
    /// Their rows in the data set: the folder of a run goes once its rows are on the disk. The folders of runs that are not part of the
    /// data set stay.
    Dataset,
}

impl Keep {
    /// True for the usual one, which files leave out.
    pub(crate) fn is_usual(&self) -> bool {
        *self == Keep::default()
    }
}

/// The text of a plan with its name.
#[derive(Clone, Debug)]
pub struct PlanSource {
    /// The name of the file as the user gave it.
    pub file: String,
    /// The folder in which the files lie that the plan names.
    pub folder: PathBuf,
    /// The text.
    pub text: Arc<str>,
}

/// A plan is a page or two long, but for long lists of runs; a larger file is something else.
const LARGEST_FILE: u64 = 1 << 24;

impl PlanSource {
    /// Opens a plan, or a file that is like one.
    ///
    /// # Errors
    /// If the file cannot be read, is too large, or is no text.
    pub fn open(path: &Path) -> Result<PlanSource> {
        let text = read_text(path, LARGEST_FILE).map_err(Error::file("read", path))?;
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        Ok(PlanSource { file: path.shown(), folder, text: Arc::from(text) })
    }

    /// A mistake at a place of the plan.
    pub fn error(&self, span: &Range<usize>, message: impl Into<String>) -> InputError {
        InputError::in_text(&self.file, &self.text, span.clone(), message.into())
    }
}

/// A value with its place in the plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Spanned<T> {
    /// The value.
    pub value: T,
    /// The bytes of the plan from which it was read.
    pub span: Range<usize>,
}

/// A key with the value that all runs have.
#[derive(Clone, Debug, PartialEq)]
pub struct FixedKey {
    /// The key.
    pub key: String,
    /// Its value as text.
    pub text: String,
    /// Where it stands.
    pub span: Range<usize>,
}

/// A variable of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanVariable {
    /// Its name, by which expressions, constraints, tables and reports know it.
    pub name: String,
    /// The keys that take its value; none for one that only expressions use.
    pub keys: Vec<Spanned<String>>,
    /// SI unit of its numbers; empty for pure numbers and words.
    pub unit: String,
    /// How it gets its value.
    pub kind: VariableKind,
    /// True if a named path that the plan sets takes over no parameter of the stage of the base case.
    pub new_stage: bool,
    /// Its numbers are rounded to multiples of this step, if there is one.
    pub step: Option<f64>,
    /// Where it stands.
    pub span: Range<usize>,
}

/// How a variable gets its value.
#[derive(Clone, Debug, PartialEq)]
pub enum VariableKind {
    /// A number between two bounds.
    Range {
        /// The bounds, in SI units.
        between: [f64; 2],
        /// The bounds as they are written.
        texts: [String; 2],
        /// True if equal ratios are equally likely, rather than equal differences.
        logarithmic: bool,
        /// Number of values in a full factorial design.
        levels: Option<usize>,
    },
    /// One of several values.
    Choice(Vec<Choice>),
    /// Given by other variables.
    Expression(Spanned<Expression>),
    /// Given by the rows of the design.
    Given,
}

impl VariableKind {
    /// True if the design chooses the value.
    pub fn is_free(&self) -> bool {
        !matches!(self, VariableKind::Expression(_))
    }
}

/// A value that a variable can take.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Its name: the value itself, or the name of a set of keys.
    pub name: String,
    /// The number in SI units, if it is one.
    pub number: Option<f64>,
    /// The keys that it sets beside those of the variable, with their values.
    pub set: Vec<(String, String)>,
    /// Where it stands.
    pub span: Range<usize>,
}

/// The table `[design]`.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignTable {
    /// The kind.
    pub kind: DesignKind,
    /// Number of points, for designs that are drawn.
    pub points: Option<usize>,
    /// Seed of a design that is drawn.
    pub seed: u32,
    /// Runs of every point, which differ in the seed of their samples.
    pub replicates: usize,
    /// How points share the seeds of their samples.
    pub sample_seeds: SampleSeeds,
    /// Where it stands.
    pub span: Range<usize>,
}

/// Which seeds the samples of different points have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleSeeds {
    /// Every point has the same seeds, so that differences between points are those of their variables alone.
    Same,
    /// No two runs have the same seed, so that a data set has the scatter of samples everywhere.
    Different,
}

/// The kinds of design.
#[derive(Clone, Debug, PartialEq)]
pub enum DesignKind {
    /// Points that a design makes by itself.
    Points(&'static PointDesign),
    /// Points of a Sobol sequence by their numbers, in the order in which they were chosen ([`Plan::with_chosen`]).
    Chosen(Vec<usize>),
    /// Rows that the plan lists, or those of a CSV file.
    Rows(Vec<PlanRow>),
}

/// A row of a listed design: names of variables with the texts of their values.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanRow {
    /// Names and values.
    pub cells: Vec<(String, String)>,
    /// Where the row stands: in the plan, or in a CSV file.
    pub place: RowPlace,
}

/// Where a row stands.
#[derive(Clone, Debug, PartialEq)]
pub enum RowPlace {
    /// In the plan.
    Plan(Range<usize>),
    /// In a line of a CSV file.
    Csv {
        /// The file.
        file: String,
        /// Its line, from 1.
        line: usize,
        /// The text of the line.
        text: String,
    },
}

impl Plan {
    /// The text of the plan.
    pub fn text(&self) -> &str {
        &self.source.text
    }
}

impl PlanVariable {
    /// True if it is spread on a logarithmic scale.
    pub fn is_logarithmic(&self) -> bool {
        matches!(self.kind, VariableKind::Range { logarithmic: true, .. })
    }
}

impl RowPlace {
    /// A mistake in the row.
    pub(super) fn error(&self, source: &PlanSource, message: String) -> InputError {
        match self {
            RowPlace::Plan(span) => source.error(span, message),
            RowPlace::Csv { file, line, text } => {
                InputError::in_line(file, *line, text, 0..text.len(), message)
            }
        }
    }
}
