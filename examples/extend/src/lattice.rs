//! A subcommand: `granum-extend lattice N FILE` writes a packing in any format that the program knows.

use std::path::Path;

use granum::prelude::*;

use crate::spheres::loose_lattice;

/// Runs it with the words after its name.
pub fn lattice(registry: &Registry, words: &[String]) -> Result<(), Box<dyn std::error::Error>> {
    let [edge, file] = words else { return Err("give N and a file: granum-extend lattice N FILE".into()) };
    let edge: usize = edge.parse().map_err(|_| format!("N must be a whole number, not {edge:?}"))?;
    if !(2..=100).contains(&edge) {
        return Err(format!("N must be from 2 to 100, not {edge}").into());
    }
    registry.runs.formats.write_packing(Path::new(file), &loose_lattice(edge))?;
    println!("wrote {} spheres to {file}", edge.pow(3));
    Ok(())
}
