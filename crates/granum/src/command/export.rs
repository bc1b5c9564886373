//! `granum export`: series, grains and contacts in the formats of other programs, and cases as input decks for them.

use std::path::PathBuf;

use clap::Args;
use granum_core::Table;
use granum_io::formats::{AssemblyFile, ObservedAssembly};
use granum_io::shell::ShowPath;
use granum_io::{Error, Run, check_output_file};
use serde_json::json;

use super::export_data_set;
use super::export_deck::DeckFlags;
use super::export_onnx;
use super::sources::SourceFlags;
use super::whole::open_run;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Write the series of a run, or the grains and contacts of a run, a packing or the results of another program, in the format of the
/// output file's extension.
///
/// Tables: .csv and .parquet. Grains and contacts at one instant: .vtp (ParaView), .data (LAMMPS), .csv (packing). Grains at any
/// number of instants: .xyz (extended XYZ), .gsd (OVITO, freud) and .dump (LAMMPS, OVITO). Of grains of several pieces these have the pieces,
/// with the body of each; --to vtp-bodies writes the grains with their orientations for glyphs of ParaView, --to vtp-bonds bonds and cracks.
///
/// With --to lammps it writes a folder with a complete input deck for LAMMPS instead: the sample (packing.data) and a script
/// (in.granum) that tests it along the same path and writes curve.csv. The sample is that of a run or of a prepared sample as its test
/// began; for a case file it is that of --packing. LAMMPS first brings it to rest, since files of LAMMPS hold no tangential forces.
///
/// With --to onnx it writes a surrogate as an ONNX file, which answers as `granum predict` does: inputs and outputs in physical units under the names of its
/// columns, with standard deviations and intervals. The name of a family writes the surrogate that comes with the program, along the path of --path.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum export run-1 -o series.csv\n  granum export run-1 -o end.vtp\n  granum export run-1 --snapshot all -o \
                  run.gsd\n  granum export run-1 --table contacts -o contacts.parquet\n  granum export grains.dump -o packing.csv\n  \
                  granum export run-1 --to lammps --out deck\n  granum export sample --to lammps --path drained-triaxial --with \
                  axial_strain=0.05 --out deck\n  granum export my-sand.toml --packing packing.csv --to lammps --out deck\n  granum export study -o states.csv\n  granum export study --table runs -o runs.csv\n  \
                  granum export study --to grainlearning -o study.hdf5\n  granum export surrogate.json --to onnx -o surrogate.onnx\n  granum export sand --to onnx --path undrained-triaxial -o sand.onnx"
)]
pub struct Export {
    /// A run folder, a campaign or its data set, a packing file, or files of results of another program; with --to lammps a run folder or
    /// a case file; with --to onnx the file of a surrogate, the folder of a study or the name of a family.
    #[arg(required = true, value_name = "DATA")]
    data: Vec<PathBuf>,
    /// File to write; with --to lammps the folder.
    #[arg(short, long, visible_alias = "out", value_name = "FILE")]
    output: PathBuf,
    /// Format of the file, where its extension does not say it: vtp, vtp-bodies, vtp-bonds, lammps-data, lammps-dump, extended-xyz, gsd. Or lammps: an input deck; or, of a
    /// campaign, grainlearning: a file of HDF5 in the layout of GrainLearning; or, of a surrogate, onnx.
    #[arg(long, value_name = "FORMAT")]
    to: Option<String>,
    /// With --to onnx and the folder of a study: the surrogate (stress_ratio-ridge), or the mapping (F2).
    #[arg(short, long, visible_alias = "mapping", value_name = "NAME")]
    model: Option<String>,
    /// Table to write: of a run series (the default), states (series and histograms, in Parquet as lists), forces, preparation, or a
    /// further histogram by its name; of a campaign states (the default) or runs; of a run, a sample or other results grains or contacts.
    #[arg(long, value_name = "NAME", conflicts_with = "to")]
    table: Option<String>,
    /// Snapshot of the run folder, or all in the order of their times; the one at its end by default, of a prepared sample the only one.
    /// Of other results the number of the instant, from 1, or last, or all; all by default.
    #[arg(long, value_name = "NAME")]
    snapshot: Option<String>,
    /// Number of states of each run with --to grainlearning: longer runs are cut, shorter ones left out; by default as many as the
    /// shortest run has.
    #[arg(long, value_name = "N")]
    sequence_length: Option<usize>,
    #[command(flatten)]
    sources: SourceFlags,
    #[command(flatten)]
    deck: DeckFlags,
}

impl Export {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        if let Some(what) = self.of_data_set(context)? {
            return self.say(context, &what);
        }
        if self.to.as_deref() == Some(export_onnx::ONNX) {
            return self.onnx(context);
        }
        if let Some(model) = &self.model {
            return Err(Failure::new(format!(
                "--model {model} belongs to --to onnx: other exports are of data"
            )));
        }
        if self.to.as_deref() == Some("lammps") {
            if self.snapshot.is_some() {
                return Err(Failure::new(
                    "--snapshot does not go with --to lammps: a deck begins where the test began",
                ));
            }
            if let Some(flag) = self.sources.first_given() {
                return Err(Failure::new(format!(
                    "{flag} does not go with --to lammps: a deck is made of a run or a case, not of another program's results"
                )));
            }
            return self.deck.write(context, &self.data, &self.output);
        }
        self.deck.check_unused()?;
        let _alone = context.nothing_written(Some("exporting"));
        check_output_file(&self.output, context.force)?;
        let formats = context.formats();
        let path = &self.output;
        if let Some(name) = &self.to {
            let unknown = |error| {
                Failure::new(format!(
                    "--to {name}: {error}; lammps makes an input deck, onnx the file of a surrogate"
                ))
            };
            formats.written_format(path, Some(name)).map_err(unknown)?;
        }
        let run = match &self.data[..] {
            [folder] if folder.is_dir() => Some(open_run(context, folder)?),
            _ => None,
        };
        let tabular = self.to.is_none() && formats.table(path).is_ok();
        if let (Some(run), true) = (&run, tabular) {
            // A prepared sample that was not tested has no series: its grains are written.
            let series = run.has_series().then_some("series");
            if self.table.as_deref() == Some(export_data_set::STATES) && run.has_series() {
                let what = export_data_set::write_run(context, run, path)?;
                return self.say(context, &what);
            }
            if let Some(name) = self.table.as_deref().or(series).filter(|name| !OF_SNAPSHOTS.contains(name)) {
                let table = run_table(run, name)?;
                formats.write_table(path, &table)?;
                return self.say(context, &format!("{} rows of {name}", table.rows()));
            }
        }
        let observations = match &run {
            Some(run) => self.snapshots(run)?,
            None => self.instants(self.sources.read(context, &self.data)?)?,
        };
        self.say_of_bonds(context, &observations);
        let grains = observations.last().map_or(0, |observation| observation.assembly.bodies.len());
        let instants = observations.len();
        let of = if instants > 1 { format!(", the last of {instants} instants") } else { String::new() };
        if let Some(name) = &self.table {
            let last = observations.into_iter().last();
            let last = last.ok_or_else(|| Failure::new("there is nothing to write"))?;
            let rows = match name.as_str() {
                "grains" => formats.write_grains(path, last)?,
                "contacts" => formats.write_contacts(path, last)?,
                _ => {
                    let message = "these data have the tables grains and contacts";
                    return Err(Failure::new(format!("--table {name:?}: {message}")));
                }
            };
            return self.say(context, &format!("{rows} rows of {name}{of}"));
        }
        let written = formats.write_assemblies(path, self.to.as_deref(), observations, &self.data[0]);
        let what = match written {
            Ok(AssemblyFile::Packing) => format!("a packing of {grains} grains{of}"),
            Ok(AssemblyFile::Grains) => format!("{grains} rows of grains{of}"),
            Ok(AssemblyFile::Results(_)) if instants == 1 => format!("{grains} grains at 1 instant"),
            Ok(AssemblyFile::Results(_)) => format!("{grains} grains at {instants} instants"),
            Err(error @ Error::Instants { count, .. }) => {
                let choice = match &run {
                    Some(run) => format!("there are {}", run.snapshots()?.join(", ")),
                    None => format!("1 to {count}, or last"),
                };
                return Err(Failure::new(format!(
                    "{error}; choose one with --snapshot ({choice}), or write a .gsd, .xyz or .dump"
                )));
            }
            Err(error) => return Err(error.into()),
        };
        self.say(context, &what)
    }

    /// Writes a surrogate as an ONNX file.
    fn onnx(&self, context: &Context) -> Result<(), Failure> {
        let family_path = self.deck.only_path()?;
        let other = self.snapshot.as_ref().map(|_| "--snapshot").or(self.sources.first_given());
        if let Some(flag) = other {
            return Err(Failure::new(format!("{flag} does not go with --to onnx, which writes a surrogate")));
        }
        let _alone = context.nothing_written(Some("exporting"));
        let what = export_onnx::write(context, &self.data, self.model.as_deref(), family_path, &self.output)?;
        self.say(context, &what)
    }

    /// Writes what is asked for of a campaign or its data set, and says what; `None` if the data are something else.
    fn of_data_set(&self, context: &Context) -> Result<Option<String>, Failure> {
        let for_grainlearning = self.to.as_deref() == Some(export_data_set::GRAINLEARNING);
        if self.sequence_length.is_some() && !for_grainlearning {
            return Err(Failure::new("--sequence-length belongs to --to grainlearning"));
        }
        let Some(folder) = export_data_set::data_set(&self.data)? else {
            return match for_grainlearning {
                true => Err(export_data_set::not_a_data_set("--to grainlearning", &self.data)),
                false => Ok(None),
            };
        };
        let _alone = context.nothing_written(Some("exporting"));
        self.deck.check_unused()?;
        if self.snapshot.is_some() {
            return Err(Failure::new(
                "--snapshot: a campaign has runs and states, and its runs have snapshots",
            ));
        }
        if let Some(flag) = self.sources.first_given() {
            return Err(Failure::new(format!(
                "{flag} belongs to results of another program, not to a campaign"
            )));
        }
        let what = match &self.to {
            Some(_) if for_grainlearning => {
                export_data_set::write_grainlearning(context, &folder, self.sequence_length, &self.output)
            }
            Some(other) => Err(Failure::new(format!(
                "--to {other}: a campaign can be written as .csv, .parquet, or --to grainlearning"
            ))),
            None => export_data_set::write(context, &folder, self.table.as_deref(), &self.output),
        };
        what.map(Some)
    }

    /// Warns of bonds for which the file has no place.
    fn say_of_bonds(&self, context: &Context, observations: &[ObservedAssembly]) {
        let bonds = observations.last().map_or(0, |observation| observation.bonded_pairs().len());
        let formats = context.formats();
        let file = formats.assembly_file(&self.output, self.to.as_deref());
        let written =
            self.table.is_none() && matches!(file, Ok(AssemblyFile::Results(format)) if format.holds_bonds());
        if bonds > 0 && !written {
            context.warn(&format!(
                "the {bonds} bonds between the grains are not written: this format has no place for them. A LAMMPS data file has (-o NAME.data), \
                 a file of bonds for ParaView (--to vtp-bonds), and the snapshots of a run (NAME.bonds)"
            ));
        }
    }

    /// The requested snapshots of a run.
    fn snapshots(&self, run: &Run) -> Result<Vec<ObservedAssembly>, Failure> {
        let names = run.snapshots()?;
        // A sample that was prepared and not tested has one snapshot, that of its start.
        let usual = match &names[..] {
            [only] => only,
            _ => "end",
        };
        let wanted = self.snapshot.as_deref().unwrap_or(usual);
        let chosen: Vec<&String> = names.iter().filter(|name| wanted == "all" || *name == wanted).collect();
        if chosen.is_empty() {
            let known = names.join(", ");
            return Err(Failure::new(format!(
                "--snapshot {wanted}: the run has no such snapshot; there are {known}"
            )));
        }
        let mut found = Vec::with_capacity(chosen.len());
        for name in chosen {
            found.push(ObservedAssembly::complete(run.snapshot(name)?));
        }
        found.sort_by(|one, two| one.assembly.time.total_cmp(&two.assembly.time));
        Ok(found)
    }

    /// The requested instants of other results.
    fn instants(&self, mut all: Vec<ObservedAssembly>) -> Result<Vec<ObservedAssembly>, Failure> {
        let count = all.len();
        let at = match self.snapshot.as_deref() {
            None | Some("all") => return Ok(all),
            Some("last") => count,
            Some(text) => text.parse().unwrap_or(0),
        };
        if !(1..=count).contains(&at) {
            let name = self.snapshot.as_deref().unwrap_or_default();
            return Err(Failure::new(format!(
                "--snapshot {name}: these data have {count} instant(s); give a number from 1 to {count}, last or all"
            )));
        }
        Ok(vec![all.swap_remove(at - 1)])
    }

    fn say(&self, context: &Context, what: &str) -> Result<(), Failure> {
        let path = self.output.shown();
        output::say(context, &json!({ "output": output::path(&self.output), "content": what }), || {
            format!("wrote {what} to {path}")
        })
    }
}

/// The tables of a snapshot; the others are files of a run folder.
const OF_SNAPSHOTS: [&str; 2] = ["grains", "contacts"];

/// A table of a run by its name.
fn run_table(run: &Run, name: &str) -> Result<Table, Failure> {
    let mut known = run.tables()?;
    if known.iter().any(|table| table == name) {
        return Ok(run.table_named(name)?);
    }
    known.extend(OF_SNAPSHOTS.map(String::from));
    Err(Failure::new(format!(
        "--table {name:?}: {} has no such table; there are {}",
        run.path().shown(),
        known.join(", ")
    )))
}
