//! Measures a packing of another program with all sensors.

use granum::prelude::*;
use granum::run::laboratory::simulation;

/// The whole program.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let packing = read_packing(concat!(env!("CARGO_MANIFEST_DIR"), "/../data/packing-5000.csv"))?;
    let material = Material::default().with(|material| material.interface_energy = 0.0);
    let contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1);
    let assembly = simulation(&packing, Properties::new(material, contact))?.assembly();
    let row = measure_row(&assembly);
    for (column, value) in granum::sensors::columns().zip(&row) {
        println!("{:32} {value:14.6e} {}", column.name, column.unit);
    }
    let solid_fraction = column_index("solid_fraction").map(|at| row[at]);
    assert!(solid_fraction.is_some_and(|found| (found - packing.solid_fraction()).abs() < 1e-12));
    Ok(())
}
