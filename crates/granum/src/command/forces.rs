//! `granum forces`: the contact forces of a given packing.

use std::path::PathBuf;

use clap::Args;
use granum_io::{Column, Table};
use granum_run::laboratory::simulation;
use serde_json::json;

use super::law::LawFlags;
use crate::context::Context;
use crate::failure::Failure;
use crate::messages;
use crate::output;

/// Compute the forces on every grain of a packing at rest without contact history, and the stress tensor.
///
/// The table has the columns id, fx, fy, fz (N), tx, ty, tz (N m). The stress tensor (Pa, compression positive) is
/// printed. With --json the output is one object, with the columns as lists in `forces` unless they are written to a file.
#[derive(Args)]
#[command(after_help = "Example:\n  granum forces packing.csv --normal hertz -o forces.csv")]
pub struct Forces {
    /// The packing (CSV: a comment line with the box, then id,x,y,z,radius).
    packing: PathBuf,
    #[command(flatten)]
    law: LawFlags,
    /// File for the table (CSV or Parquet by extension); standard output by default.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl Forces {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let _alone = context.nothing_written(Some("computing the forces"));
        let case = self.law.case(context)?;
        let packing = context.read_packing(&self.packing)?;
        let simulation = simulation(&packing, case.properties())?;
        let assembly = simulation.assembly();
        let mut columns =
            vec![Column::new("id", "1", assembly.bodies.iter().map(|g| g.id as f64).collect::<Vec<_>>())];
        for (k, name) in ["fx", "fy", "fz"].into_iter().enumerate() {
            columns.push(Column::new(
                name,
                "N",
                assembly.bodies.iter().map(|g| g.force[k]).collect::<Vec<_>>(),
            ));
        }
        for (k, name) in ["tx", "ty", "tz"].into_iter().enumerate() {
            columns.push(Column::new(
                name,
                "N m",
                assembly.bodies.iter().map(|g| g.torque[k]).collect::<Vec<_>>(),
            ));
        }
        let table = Table::new(columns)?;
        let stress = simulation.state().stress();
        if let Some(path) = &self.output {
            granum_io::check_output_file(path, context.force)?;
            granum_io::write_table(path, &table)?;
        } else if !context.json {
            output::put_table(context, None, &table)?;
        }
        let mut result = json!({
            "output": self.output.as_deref().map(output::path),
            "grains": assembly.bodies.len(),
            "contacts": assembly.contacts.len(),
            "stress": stress,
            "mean_stress": simulation.state().mean_stress(),
        });
        if self.output.is_none() {
            let mut forces = output::columns(&table);
            forces.insert("id".into(), assembly.bodies.iter().map(|grain| grain.id).collect());
            result["forces"] = forces.into();
        }
        if context.json || self.output.is_some() {
            return output::say(context, &result, || {
                let rows: Vec<String> = stress
                    .iter()
                    .map(|row| row.iter().map(|x| format!("{x:14.4}")).collect::<Vec<_>>().join(" "))
                    .collect();
                format!(
                    "{} grains, {} contacts, mean stress {:.4} Pa\nstress tensor, Pa (compression positive):\n{}",
                    assembly.bodies.len(),
                    assembly.contacts.len(),
                    simulation.state().mean_stress(),
                    rows.join("\n")
                )
            });
        }
        for row in stress {
            messages::line(format_args!("# stress, Pa: {:e} {:e} {:e}", row[0], row[1], row[2]));
        }
        Ok(())
    }
}
