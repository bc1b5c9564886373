//! What the page needs of the program that serves it: what it knows by name, and its reports.

use std::path::{Path, PathBuf};

use granum_core::quantity::Dimension;
use granum_io::Run;
use granum_io::case::Vocabulary;
use granum_learn::SurrogateMethods;
use granum_learn::family::{FamilyDefinition, FamilyModel};
use granum_report::Document;
use granum_run::runs_table::RunEntry;

/// A report with what its reader must know.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// The report.
    pub document: Document,
    /// Warnings and remarks.
    pub remarks: Vec<String>,
}

/// What a folder holds, and what can be done next.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Next {
    /// What it holds, in words such as "an interrupted test".
    pub name: String,
    /// A sentence on what can be done next.
    pub text: String,
    /// The command line for that, if there is one.
    pub command: Option<String>,
}

/// A property of a test of a family, as the command line gives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TestProperty {
    /// The flag, such as `--void-ratio`.
    pub flag: &'static str,
    /// The key of the case or of the sample.
    pub key: &'static str,
    /// What it is.
    pub dimension: Dimension,
}

/// What the page needs of the program that serves it. Errors are sentences that the page shows; nothing is written.
pub trait Program: Send + Sync {
    /// The version that is shown.
    fn version(&self) -> String;

    /// The laws, paths and sensors that cases can name.
    fn vocabulary(&self) -> &Vocabulary;

    /// The methods of surrogates.
    fn methods(&self) -> &SurrogateMethods;

    /// The run in a folder.
    ///
    /// # Errors
    /// If there is none.
    fn run_at(&self, folder: &Path) -> Result<Run, String>;

    /// The report that the program would write of folders.
    ///
    /// # Errors
    /// If they cannot be read or drawn.
    fn report(&self, folders: &[PathBuf]) -> Result<Report, String>;

    /// The runs of a campaign that have been begun, also those whose folders have gone.
    ///
    /// # Errors
    /// If they cannot be read.
    fn entries(&self, folder: &Path) -> Result<Vec<RunEntry>, String>;

    /// What a folder holds, and what can be done next with it. `named` is what the command line is to name.
    ///
    /// # Errors
    /// If it cannot be read.
    fn next(&self, folder: &Path, named: &Path) -> Result<Next, String>;

    /// The surrogate of a family that comes with the program; `None` if it has none.
    ///
    /// # Errors
    /// If it cannot be read.
    fn family(&self, family: &FamilyDefinition) -> Result<Option<FamilyModel>, String>;

    /// The properties by which tests of families are asked for.
    fn properties(&self) -> Vec<TestProperty>;
}
