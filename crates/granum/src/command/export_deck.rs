//! `granum export --to lammps`: a case as an input deck for LAMMPS.

use std::path::{Path, PathBuf};

use clap::Args;
use granum_io::Packing;
use granum_io::shell::ShowPath;
use granum_io::shell::quoted_path;
use granum_run::laboratory::SAMPLE;
use granum_run::lammps_deck::{Confinement, LammpsDeck, SCRIPT};
use serde_json::json;

use super::case_flags::CaseFlags;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// What of a case is written as a deck.
#[derive(Args)]
pub struct DeckFlags {
    /// With --to lammps and a case file: the packing that is the sample.
    #[arg(long, value_name = "FILE")]
    packing: Option<PathBuf>,
    /// With --to lammps: this named path instead of the test of the case. With --to onnx and the name of a family: the path of its tests.
    #[arg(long, value_name = "NAME")]
    path: Option<String>,
    /// With --to lammps: a parameter of the path, e.g. --with axial_strain=0.1; can be repeated.
    #[arg(long, value_name = "KEY=VALUE", requires = "path")]
    with: Vec<String>,
    #[command(flatten)]
    flags: CaseFlags,
}

impl DeckFlags {
    /// Checks that none of these flags is given to an export of data.
    pub fn check_unused(&self) -> Result<(), Failure> {
        self.check(("--path", self.path.is_some()))
    }

    /// The path, after a check that no other flag is given.
    pub fn only_path(&self) -> Result<Option<&str>, Failure> {
        self.check(("--with", !self.with.is_empty()))?;
        Ok(self.path.as_deref())
    }

    fn check(&self, other: (&str, bool)) -> Result<(), Failure> {
        let given = [("--packing", self.packing.is_some()), other, ("--set", self.flags.is_given())];
        match given.into_iter().find(|(_, given)| *given) {
            Some((flag, _)) => {
                Err(Failure::new(format!("{flag} belongs to --to lammps: other exports take no case")))
            }
            None => Ok(()),
        }
    }

    /// Writes the deck of a run folder or a case file.
    pub fn write(&self, context: &Context, data: &[PathBuf], folder: &Path) -> Result<(), Failure> {
        let [source] = data else {
            return Err(Failure::new("--to lammps takes one run folder or one case file"));
        };
        let reading = context.nothing_written(Some("reading the sample"));
        let (file, packing, confinement) = if source.is_dir() {
            if self.packing.is_some() {
                return Err(Failure::new("--packing goes with a case file: a run folder has its own sample"));
            }
            let sample = sample(context, source)?;
            (source.join("case.toml"), sample, Confinement::Own)
        } else {
            let Some(packing) = &self.packing else {
                let (shown, quoted) = (source.shown(), quoted_path(source));
                return Err(Failure::new(format!(
                    "{shown} is a case without a sample: add --packing FILE, or make its sample with `granum prepare {quoted} --out \
                     sample` and export the folder sample"
                )));
            };
            (source.clone(), context.read_packing(packing)?, Confinement::Prepared)
        };
        let parameters = super::run::parameters(&self.with)?;
        let path = self.path.as_deref().map(|name| (name, parameters.as_slice()));
        let case = self.flags.read_with_path(context, &file, true, path)?;
        let deck = LammpsDeck::new(&case, &packing, confinement)?;
        // The deck has two files, which belong together.
        drop(reading);
        deck.write(folder, context.force)?;
        let (grains, shown) = (deck.grains(), folder.shown());
        output::say(
            context,
            &json!({ "output": output::path(folder), "script": SCRIPT, "grains": grains }),
            || format!("wrote a deck of {grains} grains to {shown}; run it there with `lmp -in {SCRIPT}`"),
        )
    }
}

/// The sample of a run as its test began.
fn sample(context: &Context, folder: &Path) -> Result<Packing, Failure> {
    let run = context.run_at(folder)?;
    // The case of a deck is that of the run, with the changes of the command line.
    run.case()?;
    if !run.snapshots()?.iter().any(|name| name == SAMPLE) {
        let folder = folder.shown();
        return Err(Failure::new(format!("{folder}: its sample is not complete; resume the run first")));
    }
    Ok(Packing::from_assembly(&run.snapshot(SAMPLE)?))
}
