//! Files of results of other programs, and the options that supply what these files do not contain.

use std::path::PathBuf;

use clap::Args;
use granum_core::quantity::{Dimension, parse_quantity};
use granum_io::formats::{ContactOptions, FrameCell, JoinOptions, ObservedAssembly, ReadOptions, Remark};

use crate::context::Context;
use crate::failure::Failure;

/// So many remarks on the instants of a series are told.
const MOST_REMARKS: usize = 8;

/// What files of results do not say.
#[derive(Args, Default)]
pub struct SourceFlags {
    /// Edges of the periodic cuboid cell of files that have none.
    #[arg(long, value_name = "A, B, C")]
    pub cell: Option<String>,
    /// Names of the columns of a file whose header has none of use, as a LAMMPS dump local: the keywords of its computes, and -
    /// for what is to be passed over. Can be repeated.
    #[arg(long, value_name = "FILE=NAME,NAME,...")]
    columns: Vec<String>,
    /// Density of the grains, for files that have no masses.
    #[arg(long, value_name = "DENSITY")]
    density: Option<String>,
    /// Time step, for files that have steps but no times.
    #[arg(long, value_name = "TIME")]
    time_step: Option<String>,
    /// In a table without forces: what pairs are whose grains do not touch, contacts or no-contacts.
    #[arg(long, value_name = "ANSWER")]
    pairs_apart: Option<String>,
    /// What pairs of grains are that overlap and that the table of contacts lacks, no-contacts or contacts without-force.
    #[arg(long, value_name = "ANSWER")]
    missing_pairs: Option<String>,
    /// Take each sphere as a grain of its own, also where a column puts several into one molecule, clump or body; without it such bodies are rigid
    /// grains.
    #[arg(long)]
    separate_spheres: bool,
    /// The masses of the spheres of a molecule add up to its mass, as in dumps of LAMMPS that began with a data file of granum; without it each is
    /// density times volume of its sphere, and the mass of the body is that of the union.
    #[arg(long)]
    masses_add_up: bool,
    /// What forces are by which all grains that overlap pull each other: as-given, or reversed for those on the second grain of each
    /// contact.
    #[arg(long, value_name = "ANSWER")]
    contact_forces: Option<String>,
    /// What rows of the same pair of grains are that differ in their forces: the first counts, or their sum.
    #[arg(long, value_name = "ANSWER")]
    repeated_pairs: Option<String>,
}

impl SourceFlags {
    /// The first of the flags that is given.
    pub fn first_given(&self) -> Option<&'static str> {
        let given = [
            ("--cell", self.cell.is_some()),
            ("--columns", !self.columns.is_empty()),
            ("--density", self.density.is_some()),
            ("--time-step", self.time_step.is_some()),
            ("--pairs-apart", self.pairs_apart.is_some()),
            ("--missing-pairs", self.missing_pairs.is_some()),
            ("--separate-spheres", self.separate_spheres),
            ("--masses-add-up", self.masses_add_up),
            ("--contact-forces", self.contact_forces.is_some()),
            ("--repeated-pairs", self.repeated_pairs.is_some()),
        ];
        given.into_iter().find(|(_, given)| *given).map(|(flag, _)| flag)
    }

    /// Reads and joins files of results.
    pub fn read(&self, context: &Context, files: &[PathBuf]) -> Result<Vec<ObservedAssembly>, Failure> {
        let mut columns: Vec<(PathBuf, Vec<String>)> = Vec::new();
        for text in &self.columns {
            let found = text.split_once('=').filter(|(file, _)| files.contains(&PathBuf::from(file)));
            let Some((file, names)) = found else {
                let example = "--columns contacts.dump=index,patom1,patom2,fx,fy,fz,p1,p2,p3";
                return Err(Failure::new(format!(
                    "--columns {text:?}: it must name one of the files, as {example}"
                )));
            };
            columns.push((file.into(), names.split(',').map(|name| name.trim().to_string()).collect()));
        }
        let options = |file: &PathBuf| {
            let given = columns.iter().find(|(known, _)| known == file).map(|(_, names)| names.clone());
            (file.clone(), ReadOptions::with_columns(given))
        };
        let files: Vec<_> = files.iter().map(options).collect();
        let cell = self.cell.as_deref().map(edges).transpose()?;
        let join = JoinOptions::new(
            cell.map(|edges| FrameCell::between([0.0; 3], edges)),
            positive("--density", self.density.as_deref(), Dimension::DENSITY)?,
            positive("--time-step", self.time_step.as_deref(), Dimension::TIME)?,
        );
        let join = join.with_contacts(self.contact_options()?).with_separate_spheres(self.separate_spheres);
        let join = join.with_masses_that_add_up(self.masses_add_up);
        let observations = context.formats().read_results(&files, &join)?;
        tell_remarks(context, &observations);
        Ok(observations)
    }

    fn contact_options(&self) -> Result<ContactOptions, Failure> {
        let named = ContactOptions::default().with_names(
            self.pairs_apart.as_deref(),
            self.missing_pairs.as_deref(),
            self.contact_forces.as_deref(),
            self.repeated_pairs.as_deref(),
        );
        named.map_err(|(option, why)| Failure::new(format!("--{option}: {why}")))
    }
}

/// Tells what was set right in data and what is doubtful, each sentence once for all instants.
fn tell_remarks(context: &Context, observations: &[ObservedAssembly]) {
    let mut said: Vec<(&Remark, usize)> = Vec::new();
    for remark in observations.iter().flat_map(|observation| &observation.remarks) {
        match said.iter_mut().find(|(known, _)| *known == remark) {
            Some((_, count)) => *count += 1,
            None => said.push((remark, 1)),
        }
    }
    let more = said.len().saturating_sub(MOST_REMARKS);
    for (remark, count) in said.into_iter().take(MOST_REMARKS) {
        let times = if count > 1 { format!(" ({count} instants)") } else { String::new() };
        context.tell_remark(&format!("{}{times}", remark.text), remark.doubtful);
    }
    if more > 0 {
        context.note(&format!("{more} more remarks of this kind, on other instants"));
    }
}

fn positive(flag: &str, text: Option<&str>, dimension: Dimension) -> Result<Option<f64>, Failure> {
    let Some(text) = text else { return Ok(None) };
    let value =
        parse_quantity(text, dimension).map_err(|why| Failure::new(format!("{flag} {text:?}: {why}")))?;
    if value > 0.0 {
        return Ok(Some(value));
    }
    Err(Failure::new(format!("{flag} {text:?} must be positive")))
}

/// Three lengths with units, as `2 mm, 2 mm, 3 mm`.
pub fn edges(text: &str) -> Result<[f64; 3], Failure> {
    let wrong = |why: String| {
        Failure::new(format!("--cell {text:?}: {why}; give three lengths as \"2 mm, 2 mm, 3 mm\""))
    };
    let lengths = text.split(',').map(|item| parse_quantity(item.trim(), Dimension::LENGTH).map_err(&wrong));
    let lengths = lengths.collect::<Result<Vec<f64>, Failure>>()?;
    if lengths.iter().any(|length| *length <= 0.0) {
        return Err(wrong("its edges must be positive".into()));
    }
    <[f64; 3]>::try_from(lengths).map_err(|found| wrong(format!("these are {} lengths", found.len())))
}
