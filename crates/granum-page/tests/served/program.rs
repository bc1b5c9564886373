//! A program with what comes with the library alone.

use std::path::{Path, PathBuf};

use granum_io::Run;
use granum_io::case::Vocabulary;
use granum_learn::SurrogateMethods;
use granum_learn::family::{FamilyDefinition, FamilyModel};
use granum_page::{Next, Program, Report, TestProperty};
use granum_report::{RoleInStudy, RunReport, overlay_report, run_report};
use granum_run::runs_table::{RunEntry, find_runs};

pub struct TestProgram {
    vocabulary: Vocabulary,
    methods: SurrogateMethods,
}

impl Default for TestProgram {
    fn default() -> TestProgram {
        TestProgram { vocabulary: Vocabulary::standard(), methods: SurrogateMethods::standard() }
    }
}

fn words(error: impl ToString) -> String {
    error.to_string()
}

impl Program for TestProgram {
    fn version(&self) -> String {
        "granum of a test".into()
    }

    fn vocabulary(&self) -> &Vocabulary {
        &self.vocabulary
    }

    fn methods(&self) -> &SurrogateMethods {
        &self.methods
    }

    fn run_at(&self, folder: &Path) -> Result<Run, String> {
        Run::at(folder).map_err(words)
    }

    fn report(&self, folders: &[PathBuf]) -> Result<Report, String> {
        let read =
            |folder: &PathBuf| RunReport::read(&self.run_at(folder)?, RoleInStudy::Single).map_err(words);
        let runs: Vec<RunReport> = folders.iter().map(read).collect::<Result<_, _>>()?;
        let document = if let [run] = &runs[..] { run_report(run) } else { overlay_report(&runs) };
        Ok(Report { document, remarks: Vec::new() })
    }

    fn entries(&self, folder: &Path) -> Result<Vec<RunEntry>, String> {
        let runs = find_runs(&[folder.to_path_buf()]).map_err(words)?;
        runs.iter().map(|run| RunEntry::from_run(&self.run_at(run)?).map_err(words)).collect()
    }

    fn next(&self, _: &Path, _: &Path) -> Result<Next, String> {
        Ok(Next::default())
    }

    fn family(&self, _: &FamilyDefinition) -> Result<Option<FamilyModel>, String> {
        Ok(None)
    }

    fn properties(&self) -> Vec<TestProperty> {
        Vec::new()
    }
}
