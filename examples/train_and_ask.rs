//! Networks that learn q/p from strain and fabric of two samples and predict it for a third.

use granum::antony2006::evaluation::networks;
use granum::antony2006::{Evaluation, PaperData, PaperDataOptions, PaperOptions, paper_mapping};
use granum::learn::surrogate::RunInputs;
use granum::prelude::*;

fn record(seed: u64) -> Result<Record, Box<dyn std::error::Error>> {
    let text = format!(
        "grains.count = 150\npreparation.seed = {seed}\npreparation.solid_fraction = \"none\"\n\
         preparation.unbalanced_force = 0.01\nshear.deviator_strain = 0.3\nshear.inertial_number = 0.01\n\
         recording.states = 45\nrecording.observations_per_state = 6"
    );
    Ok(Laboratory::here().test(&Case::parse(&text, "case")?)?.record)
}

/// The whole program.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let records = (1..=3).map(record).collect::<Result<Vec<_>, _>>()?;
    let names = ["first", "second", "third"];
    let named = |k: usize| NamedRecord { name: names[k], seed: k as u64 + 1, record: &records[k] };
    let data = PaperData::from_records(&[named(0), named(1)], &[named(2)], &PaperDataOptions::default())?;
    let options = PaperOptions { mappings: vec![paper_mapping("F3")?], ..PaperOptions::default() };
    let study = options.train(&data, &NoStudyObserver)?;
    for evaluation in Evaluation::of_study(&study, &data)? {
        let [ours, strain_only] =
            [&evaluation.network, &evaluation.strain_only].map(|parts| 100.0 * parts.unseen.relative_rmse);
        println!(
            "{}: {ours:.1} % on the unseen run, {strain_only:.1} % by strain alone",
            evaluation.mapping.name
        );
    }
    // Every fifth state of the unseen sample: the predictions of the networks next to the values of DEM.
    let networks = networks(&study, "F3")?;
    let unseen = &data.parts.unseen;
    let predictions = networks.predict(&RunInputs::from_dataset(unseen, networks.columns())?, 0.9)?;
    let (strains, ratios) = (unseen.column("deviator_strain")?, unseen.column("stress_ratio")?);
    println!("eps_d   DEM    network  90 % interval");
    for k in (0..unseen.rows()).step_by(5) {
        let estimate = &predictions[k].values[0];
        let [low, high] = estimate.interval.as_ref().map_or([f64::NAN; 2], |ends| [ends.lower, ends.upper]);
        println!("{:.4}  {:.3}  {:.3}    {low:.3} to {high:.3}", strains[k], ratios[k], estimate.mean);
        assert!(estimate.mean.is_finite());
    }
    Ok(())
}
