//! The strength of a sample as a function of the friction of its grains: several samples for each value, and a table as CSV.

use granum::prelude::*;

const CASE: &str = "
[grains]
count = 100
material.interface_energy = 0
[contact]
normal = \"hertz\"
tangential = \"no-slip\"
[preparation]
solid_fraction = \"none\"
friction = 0.1
unbalanced_force = 0.02
[[stage]]
path = \"drained-triaxial\"
axial_strain = 0.03
inertial_number = 0.005
states = 15
[recording]
observations_per_state = 4
";

// ANCHOR: one
/// The largest stress ratio q/p of one sample.
fn strength(case: &Case, friction: &str, seed: &str) -> Result<f64, Box<dyn std::error::Error>> {
    let mut case = case.clone();
    case.set("grains.material.friction", friction)?;
    case.set("preparation.seed", seed)?;
    let test = Laboratory::here().test(&case)?;
    Ok(test.record.series.column("stress_ratio")?.iter().copied().fold(0.0, f64::max))
}
// ANCHOR_END: one

// ANCHOR: scatter
/// Mean and standard deviation of samples that differ in their seed alone.
fn mean_and_deviation(values: &[f64]) -> [f64; 2] {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let square = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    [mean, (square / (values.len() - 1) as f64).sqrt()]
}
// ANCHOR_END: scatter

/// The whole program.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let case = Case::parse(CASE, "case")?;
    // ANCHOR: study
    let frictions = ["0.1", "0.3", "0.6"];
    let (mut means, mut deviations) = (Vec::new(), Vec::new());
    for friction in frictions {
        let strengths = ["1", "2", "3"]
            .map(|seed| strength(&case, friction, seed))
            .into_iter()
            .collect::<Result<Vec<_>, _>>()?;
        let [mean, deviation] = mean_and_deviation(&strengths);
        println!("friction {friction}: peak q/p {mean:.3} +- {deviation:.3}");
        means.push(mean);
        deviations.push(deviation);
    }
    // ANCHOR_END: study

    // ANCHOR: table
    let table = Table::new(vec![
        Column::new("friction", "1", frictions.map(|text| text.parse().unwrap_or(f64::NAN)).to_vec()),
        Column::new("peak_stress_ratio", "1", means.clone()),
        Column::new("standard_deviation", "1", deviations),
    ])?;
    let file = std::env::temp_dir().join(format!("granum-parameter-study-{}.csv", std::process::id()));
    write_table(&file, &table)?;
    // ANCHOR_END: table
    assert_eq!(read_table(&file)?.column("peak_stress_ratio")?, means);
    assert!(means[2] > means[0]);
    std::fs::remove_file(file)?;
    Ok(())
}
