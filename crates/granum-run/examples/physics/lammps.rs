//! Comparison of a whole test with LAMMPS: the same packing, laws and path (see `data/validation/README.md`).

use std::error::Error;
use std::path::{Path, PathBuf};

use granum_io::{Column, Table, read_table, write_table};

use super::runs::{CURVES, Test, distance, mean, packed, sheared, within};

/// Strain from which curves are compared, after the initial elastic response.
const FROM: f64 = 0.0075;
/// Time step factors of repeated runs of granum: their rounding differs, and since the dynamics is chaotic, the runs give a
/// measure of the scatter.
const FACTORS: [f64; 3] = [0.2, 0.19, 0.21];

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data").join(name)
}

/// Prints the means over the test of the curves of granum and LAMMPS, the distance between the two, and for comparison the
/// distance between repeated runs of each. Writes the mean curves of granum next to those of LAMMPS.
pub fn study() -> Result<(), Box<dyn Error>> {
    let lammps = [read("validation/lammps.csv")?, read("validation/lammps-again.csv")?];
    let sample = packed(&data("packing-5000.csv"))?;
    let granum = FACTORS
        .into_iter()
        .map(|time_step_factor| sheared(&sample, Test { time_step_factor, ..Test::default() }))
        .collect::<Result<Vec<Table>, _>>()?;
    let mut columns = Vec::new();
    println!(
        "curve: means of LAMMPS, granum, difference; rms distance of the means, of copies of LAMMPS, of granum"
    );
    for name in CURVES {
        let theirs = lammps.iter().map(|t| curve(t, name)).collect::<Result<Vec<_>, _>>()?;
        let ours = granum.iter().map(|s| within(s, name, FROM..1.0)).collect::<Result<Vec<_>, _>>()?;
        let (a, b) = (middle(&theirs), middle(&ours));
        println!(
            "{name:32} {:.4} {:.4} {:+.4}; {:.4} {:.4} {:.4}",
            mean(&a),
            mean(&b),
            mean(&b) - mean(&a),
            distance(&a, &b),
            distance(&theirs[0], &theirs[1]),
            distance(&ours[0], &ours[1]).max(distance(&ours[0], &ours[2])),
        );
        let all =
            granum.iter().map(|s| s.column(name).map(<[f64]>::to_vec)).collect::<Result<Vec<_>, _>>()?;
        columns.push(Column::new(name, "1", middle(&all)));
    }
    let strain = granum[0].column("deviator_strain")?.to_vec();
    columns.insert(0, Column::new("deviator_strain", "1", strain));
    write_table(data("validation/granum.csv"), &Table::new(columns)?)?;
    Ok(())
}

fn read(name: &str) -> Result<Table, Box<dyn Error>> {
    Ok(read_table(data(name))?)
}

fn curve(table: &Table, name: &str) -> Result<Vec<f64>, Box<dyn Error>> {
    let strain = table.column("deviator_strain")?;
    let values = table.column(name)?;
    Ok(strain.iter().zip(values).filter(|(e, _)| **e > FROM).map(|(_, &v)| v).collect())
}

/// The mean of curves.
fn middle(curves: &[Vec<f64>]) -> Vec<f64> {
    (0..curves[0].len()).map(|k| mean(&curves.iter().map(|c| c[k]).collect::<Vec<_>>())).collect()
}
