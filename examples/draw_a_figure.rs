//! A figure as SVG: the stress ratio of three samples, and their mean with the scatter between them.

use granum::prelude::*;
use granum::report::figure::palette::{GREY, color};
use granum::report::figure::{Axis, Figure, Layer, Legend, Panel, Plot, Stroke};

const CASE: &str = "
[grains]
count = 100
[preparation]
solid_fraction = \"none\"
unbalanced_force = 0.02
[shear]
deviator_strain = 0.06
inertial_number = 0.01
[recording]
states = 20
observations_per_state = 4
";

/// Strain and stress ratio of the states of a sample.
fn curve(seed: u64) -> Result<Vec<[f64; 2]>, Box<dyn std::error::Error>> {
    let mut case = Case::parse(CASE, "case")?;
    case.set("preparation.seed", &seed.to_string())?;
    let record = Laboratory::here().test(&case)?.record;
    let [strain, ratio] = record.series.select(["deviator_strain", "stress_ratio"])?;
    Ok(strain.iter().zip(ratio).map(|(strain, ratio)| [*strain, *ratio]).collect())
}

/// The whole program.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let curves = (1..=3).map(curve).collect::<Result<Vec<_>, _>>()?;

    // ANCHOR: band
    // At each recorded strain: the mean of the samples, and one standard deviation to either side.
    let band: Vec<[f64; 3]> = (0..curves[0].len())
        .map(|state| {
            let ratios = [0, 1, 2].map(|sample| curves[sample][state][1]);
            let mean = ratios.iter().sum::<f64>() / 3.0;
            let deviation = (ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum::<f64>() / 2.0).sqrt();
            [curves[0][state][0], mean - deviation, mean + deviation]
        })
        .collect();
    let mean = band.iter().map(|[strain, low, high]| [*strain, 0.5 * (low + high)]).collect();
    // ANCHOR_END: band

    // ANCHOR: figure
    // Text is marked up: *italic*, _{subscript}, ^{superscript}. Layers are drawn in their order.
    let axes = Plot::new(Axis::new("Deviator strain *ε*_{d}"), Axis::new("Stress ratio *q*/*p*"));
    let plot = axes
        .with(Layer::band(band, color(0)).named("± one standard deviation"))
        .with_all(curves.iter().map(|curve| Layer::stroked(curve.clone(), Stroke::new(GREY, 0.8))))
        .with(Layer::line(mean, color(0)).named("mean of three samples"));
    let figure = Figure::new("Stress ratio against strain", 1, vec![Panel::plot(plot)]).legend(Legend::Above);
    let file = std::env::temp_dir().join(format!("granum-figure-{}.svg", std::process::id()));
    std::fs::write(&file, figure.to_svg())?;
    // ANCHOR_END: figure
    let svg = std::fs::read_to_string(&file)?;
    assert!(svg.starts_with("<?xml") && svg.contains("mean of three samples"));
    assert_eq!(svg, figure.to_svg(), "the same data give the same bytes");
    match std::env::args().nth(1).filter(|argument| argument.ends_with(".svg")) {
        Some(place) => std::fs::copy(&file, place).map(drop)?,
        None => println!("{} bytes of SVG; give the name of a file to keep it", svg.len()),
    }
    std::fs::remove_file(file)?;
    Ok(())
}
