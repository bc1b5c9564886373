//! Networks that learn q/p from strain and fabric of two samples and predict it for a third.

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
    let named = |seed: u64| NamedRecord { name: "run", seed, record: &records[seed as usize - 1] };
    let dataset = StudyData::new(&[named(1), named(2)], &[named(3)], &StudyDataOptions::default())?;
    let mappings = vec![granum::antony2006::mapping::paper_mapping("F3")?];
    let study = Study::train(&dataset, &StudyOptions { mappings, ..StudyOptions::default() }, &Silent)?;
    for evaluation in study.evaluate(&dataset)? {
        let [ours, strain_only] =
            [&evaluation.network, &evaluation.strain_only].map(|parts| 100.0 * parts.unseen.relative_rmse);
        println!(
            "{}: {ours:.1} % on the unseen run, {strain_only:.1} % by strain alone",
            evaluation.mapping.name
        );
    }
    let surrogate = &study.mapping("F3")?.surrogate;
    // Every fifth state of the unseen sample: the predictions of the networks next to the values of DEM.
    let states: Vec<_> = dataset.unseen().into_iter().step_by(5).collect();
    let intervals = surrogate.intervals(states.iter().copied(), 0.9)?;
    println!("eps_d   DEM    network  90 % interval");
    for ((state, answer), interval) in
        states.iter().zip(surrogate.answer(states.iter().copied())?).zip(intervals)
    {
        let [low, high] = interval.and_then(|ends| ends.first().copied()).unwrap_or([f64::NAN; 2]);
        println!(
            "{:.4}  {:.3}  {:.3}    {low:.3} to {high:.3}",
            state.strain, state.stress_ratio, answer.values[0]
        );
        assert!(answer.values[0].is_finite());
    }
    Ok(())
}
