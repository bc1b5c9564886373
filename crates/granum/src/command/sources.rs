//! Files of results of other programs, and the options that supply what these files do not contain.

use std::path::PathBuf;

use clap::Args;
use granum_core::quantity::{Dimension, parse_quantity};
use granum_io::formats::{FrameCell, JoinOptions, ObservedAssembly, ReadOptions};

use crate::context::Context;
use crate::failure::Failure;

/// What files of results do not say.
#[derive(Args)]
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
}

impl SourceFlags {
    /// The first of the flags that is given.
    pub fn first_given(&self) -> Option<&'static str> {
        let given = [
            ("--cell", self.cell.is_some()),
            ("--columns", !self.columns.is_empty()),
            ("--density", self.density.is_some()),
            ("--time-step", self.time_step.is_some()),
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
        Ok(context.formats().read_results(&files, &join)?)
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
