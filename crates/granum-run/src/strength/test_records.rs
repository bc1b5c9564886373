//! Records of tests whose curves are known, for the tests of this module.

use granum_core::{Column, Table};
use granum_dem::loading::Stage;
use granum_io::Case;
use granum_sensors::Record;

/// A record of rows: axial strain, lateral strain, mean stress and deviator stress in kPa.
pub(super) fn triaxial(rows: impl Iterator<Item = [f64; 4]>, solid_fraction: f64) -> Record {
    let rows: Vec<[f64; 4]> = rows.collect();
    let column = |name: &str, value: &dyn Fn(&[f64; 4]) -> f64| {
        Column::new(name, "", rows.iter().map(value).collect())
    };
    let lateral = |row: &[f64; 4]| 1e3 * (row[2] - row[3] / 3.0);
    let mut columns = vec![
        column("stage", &|_| 1.0),
        column("axial_strain", &|row| row[0]),
        column("lateral_strain_2", &|row| row[1]),
        column("lateral_strain_3", &|row| row[1]),
        column("volumetric_strain", &|row| row[0] + 2.0 * row[1]),
        column("stress_11", &|row| 1e3 * (row[2] + 2.0 * row[3] / 3.0)),
        column("stress_22", &lateral),
        column("stress_33", &lateral),
        column("mean_stress", &|row| 1e3 * row[2]),
        column("solid_fraction", &|_| solid_fraction),
    ];
    let shear = ["stress_12", "stress_13", "stress_21", "stress_23", "stress_31", "stress_32"];
    columns.extend(shear.map(|name| column(name, &|_| 0.0)));
    Record { series: Table::new(columns).unwrap(), ..Record::default() }
}

fn stages(path: &str) -> Vec<Stage> {
    Case::parse(&format!("[[stage]]\npath = '{path}'\n"), "case.toml").unwrap().test_stages()
}

pub(super) fn drained_stages() -> Vec<Stage> {
    stages("drained-triaxial")
}

pub(super) fn undrained_stages() -> Vec<Stage> {
    stages("undrained-triaxial")
}
