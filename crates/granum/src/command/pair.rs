//! `granum pair`: the forces between two grains on a prescribed path.

use std::path::PathBuf;

use clap::Args;
use granum_dem::contact::PairProperties;
use granum_dem::contact::pair::path::{PairRow, PathRow};
use granum_dem::contact::pair::refined::drive_pair_refined;
use granum_io::shell::ShowPath;
use granum_io::{Column, read_table};

use super::law::LawFlags;
use crate::context::Context;
use crate::failure::Failure;
use crate::output::put_table_with;

/// Tolerated change of a force when the number of steps is doubled, over the largest force of its kind on the path.
const TOLERANCE: f64 = 1e-5;

/// Move two equal grains along a prescribed path and print the forces between them.
///
/// The path is a table (CSV or Parquet) with the columns `normal_approach` (the overlap of the grains) and
/// `tangential_displacement` (of one grain relative to the other), both in m; before the first row the grains have not been
/// in contact. The result is the same table with `normal_force` (N, compression positive), `tangential_force` (N, positive
/// if it resists an increasing displacement) and `contact_radius` (m). Between rows the grains move along a straight line,
/// which is divided into equal steps; their number is doubled until no force at any row changes by more than 1e-5 of the
/// largest force of its kind. Rows are therefore needed only where the path turns or where a result is wanted. The number of
/// steps is printed.
#[derive(Args)]
#[command(after_help = "\
Example:
  printf 'normal_approach,tangential_displacement\\n1e-8,0\\n1e-8,1e-9\\n1e-8,0\\n' > path.csv
  granum pair path.csv --normal hertz --tangential mindlin-deresiewicz --friction 0.3 -o forces.csv")]
pub struct Pair {
    /// Table with the path, CSV or Parquet.
    #[arg(value_name = "PATH.csv")]
    path: PathBuf,
    /// File for the result (.csv or .parquet); standard output by default.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    law: LawFlags,
}

impl Pair {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let _alone = context.nothing_written(Some("moving the pair"));
        let case = self.law.case_of_one_material(context)?;
        let mut table = read_table(&self.path)?;
        let in_file = |error: &dyn std::fmt::Display| Failure::new(format!("{}: {error}", self.path.shown()));
        let [approach, displacement] =
            table.select(["normal_approach", "tangential_displacement"]).map_err(|error| in_file(&error))?;
        let path: Vec<PathRow> = approach
            .iter()
            .zip(displacement)
            .map(|(approach, displacement)| PathRow {
                normal_approach: *approach,
                tangential_displacement: *displacement,
            })
            .collect();
        let side = (&case.grains.material, 0.5 * case.grains.diameter);
        let pair = PairProperties::new(side, side, case.contact.damping);
        let refined =
            drive_pair_refined(&case.contact, &pair, &path, TOLERANCE).map_err(|error| in_file(&error))?;
        let rows = &refined.rows;
        let column = |name: &str, unit: &str, value: fn(&PairRow) -> f64| {
            Column::new(name, unit, rows.iter().map(value).collect())
        };
        table.set(column("normal_force", "N", |row| row.normal_force))?;
        table.set(column("tangential_force", "N", |row| row.tangential_force))?;
        table.set(column("contact_radius", "m", |row| row.contact_radius))?;
        context.say(|| {
            format!("{} rows with {} and {}", path.len(), case.contact.normal, case.contact.tangential)
        });
        let steps = refined.steps;
        let note = format!(
            "{steps} steps from one row to the next: with half as many steps no force at a row differs by more than \
             {TOLERANCE:e} of the largest"
        );
        put_table_with(context, self.output.as_deref(), &table, &[("steps_per_row", steps.into())], &note)
    }
}
