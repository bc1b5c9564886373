//! `granum examine map`: a self-organising map of the states of runs.

use std::path::PathBuf;

use clap::Args;
use granum_core::json;
use granum_io::check_output_file;
use granum_io::shell::ShowPath;
use granum_learn::LearnError;
use granum_learn::examine::{MapOptions, StateMap};
use granum_learn::runs::RunRole;
use granum_report::state_map;
use serde_json::json as value;

use super::question::{WorkFlags, put};
use crate::command::records;
use crate::command::train_study::dataset;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Draw a self-organising map of the states of runs: a sheet of cells, neighbours alike, on which each state lies in the cell that is most like it.
/// The picture has a panel for each column, the number of states in each cell, and the distance of each cell from its neighbours, which is
/// high between groups of states.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum examine map study -o map.svg\n  granum examine map study --column stress_ratio,deviator_fabric --cells 30x20 -o map.json"
)]
pub struct MapFlags {
    /// Run folders, campaigns or data sets.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// The columns of a state; the name of a histogram stands for all of its bins.
    #[arg(
        long,
        value_name = "COLUMN",
        value_delimiter = ',',
        default_value = "axial_strain,stress_ratio,volumetric_strain,deviator_fabric,mechanical_coordination_number,sliding_fraction,mean_square_force"
    )]
    column: Vec<String>,
    /// Number of cells across and up.
    #[arg(long, value_name = "NxM", default_value = "24x16", value_parser = cells)]
    cells: [usize; 2],
    /// Largest number of states from which the map is made: of more, every n-th of each run is used.
    #[arg(long, value_name = "N", default_value_t = 10_000, value_parser = clap::value_parser!(u64).range(100..))]
    most_states: u64,
    /// The picture (.svg) or the numbers (.json).
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
}

/// `24x16`.
fn cells(text: &str) -> Result<[usize; 2], String> {
    let parsed =
        text.split_once('x').and_then(|(a, b)| Some([a.trim().parse().ok()?, b.trim().parse().ok()?]));
    parsed.ok_or_else(|| "two numbers are needed, such as 24x16".into())
}

impl MapFlags {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        check_output_file(&self.out, context.force)?;
        let is_picture = match self.out.extension().and_then(|ending| ending.to_str()) {
            Some("svg") => true,
            Some("json") => false,
            _ => {
                let name = self.out.shown();
                return Err(Failure::new(format!("{name}: a map is written as .svg or .json")));
            }
        };
        let recorded = records::read(context, &self.runs, RunRole::Training)?;
        let runs = dataset(&recorded.iter().collect::<Vec<_>>())?;
        let options = MapOptions {
            columns: self.column.clone(),
            cells: self.cells,
            most_states: self.most_states as usize,
        };
        let map = WorkFlags::observed(context, |observer| StateMap::new(&runs, &options, observer))?;
        let text = match is_picture {
            true => state_map(&map),
            false => json::readable(&map).map_err(|error| LearnError::Content(error.to_string()))?,
        };
        put(&self.out, &text)?;
        let states: usize = map.states.iter().sum();
        let empty = map.states.iter().filter(|count| **count == 0).count();
        let [across, up] = self.cells;
        let result = value!({
            "out": output::path(&self.out), "states": states, "empty_cells": empty, "error": map.error, "folded": map.folded,
        });
        output::say(context, &result, || {
            format!(
                "{states} states of {} runs on {across} x {up} cells, {empty} of them empty: the cells leave {:.1} % of the distance of a state from \
                 the mean, and {:.1} % of the states lie in a fold\nwrote {}",
                runs.runs().len(),
                100.0 * map.error,
                100.0 * map.folded,
                self.out.shown()
            )
        })
    }
}
