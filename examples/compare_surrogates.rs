//! Comparison of surrogates that are fitted to chosen columns: networks, ridge regression, and a user-defined method.
//!
//! Four samples with different friction are sheared; three are used for training, and the fourth is an unseen run.

use granum::core::observer::{NoObserver, Observer};
use granum::learn::surrogate::{Cause, Columns, Content, RunInputs, outside_of, save};
use granum::prelude::*;

fn run(seed: u64, friction: f64) -> Result<RunStates, Box<dyn std::error::Error>> {
    let text = format!(
        "grains.count = 150\npreparation.seed = {seed}\npreparation.solid_fraction = \"none\"\n\
         grains.material.friction = {friction}\npreparation.friction = 0.3\npreparation.unbalanced_force = 0.01\n\
         shear.deviator_strain = 0.2\nshear.inertial_number = 0.01\nrecording.states = 40"
    );
    let record = Laboratory::here().test(&Case::parse(&text, "case")?)?.record;
    let name = format!("friction {friction}");
    // The measurements, with the friction as an additional column. (For a run in a folder, all numbers of its case are
    // added.)
    Ok(RunStates::from_record(&NamedRecord { name: &name, seed, record: &record })?
        .with_parameter("friction", "", friction)?)
}

// ANCHOR: method
/// A user-defined method: the mean of the nearest training rows.
struct Neighbours {
    count: usize,
}

struct FittedNeighbours {
    columns: Columns,
    count: usize,
    ranges: Vec<[f64; 2]>,
    /// Inputs and outputs of the training rows.
    rows: Vec<(Vec<f64>, Vec<f64>)>,
}

impl SurrogateMethod for Neighbours {
    fn name(&self) -> &str {
        "neighbours"
    }
    fn help(&self) -> &str {
        "the mean of the nearest training rows"
    }
    fn fit(
        &self,
        dataset: &Dataset,
        spec: &FitSpec,
        _: &mut dyn Observer,
    ) -> granum::learn::Result<Box<dyn Surrogate>> {
        let columns = spec.columns(dataset)?;
        let (inputs, outputs) = (columns.input_names(), columns.output_names());
        let (x, y) = (dataset.values(&inputs)?, dataset.values(&outputs)?);
        let rows = x.chunks(inputs.len()).zip(y.chunks(outputs.len()));
        let rows: Vec<_> = rows.map(|(x, y)| (x.to_vec(), y.to_vec())).collect();
        let wider = |[low, high]: [f64; 2], x: f64| [low.min(x), high.max(x)];
        let range =
            |k: usize| rows.iter().map(|row| row.0[k]).fold([f64::INFINITY, f64::NEG_INFINITY], wider);
        let ranges = (0..inputs.len()).map(range).collect();
        Ok(Box::new(FittedNeighbours { columns, count: self.count, ranges, rows }))
    }
    fn load(&self, columns: Columns, content: &Content) -> granum::learn::Result<Box<dyn Surrogate>> {
        let (count, ranges, rows) = content.read()?;
        Ok(Box::new(FittedNeighbours { columns, count, ranges, rows }))
    }
}

impl Surrogate for FittedNeighbours {
    fn method(&self) -> &str {
        "neighbours"
    }
    fn columns(&self) -> &Columns {
        &self.columns
    }
    fn evaluate(&self, inputs: &RunInputs, _level: f64) -> granum::learn::Result<Vec<Prediction>> {
        let predicted = |row: &[f64]| {
            let distance = |other: &[f64]| -> f64 {
                let each = other.iter().zip(row).zip(&self.ranges);
                each.map(|((a, b), [low, high])| ((a - b) / (high - low)).powi(2)).sum()
            };
            let mut nearest: Vec<_> = self.rows.iter().collect();
            nearest.sort_by(|a, b| distance(&a.0).total_cmp(&distance(&b.0)));
            nearest.truncate(self.count);
            let mean = |k: usize| nearest.iter().map(|row| row.1[k]).sum::<f64>() / nearest.len() as f64;
            let estimates = (0..self.columns.outputs.len()).map(|k| Estimate::new(mean(k)));
            Prediction::new(estimates.collect()).with_outside(outside_of(&self.columns, &self.ranges, row))
        };
        Ok(inputs.rows().map(predicted).collect())
    }
    fn content(&self) -> granum::learn::Result<Content> {
        Content::new(&(self.count, &self.ranges, &self.rows))
    }
}
// ANCHOR_END: method

/// The whole program.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    // ANCHOR: data
    let frictions = [0.1, 0.3, 0.5, 0.2];
    let runs = frictions.iter().zip(1..).map(|(friction, seed)| run(seed, *friction));
    let dataset = Dataset::new(runs.collect::<Result<_, _>>()?)?;
    let parts = dataset.split(&Split::default().first_state(1).unseen(["friction 0.2"]))?;
    let spec = FitSpec::new(["arc_length", "friction", "deviator_fabric"], ["stress_ratio"]);
    let spec = spec.with_coordinate("arc_length");
    // ANCHOR_END: data

    // ANCHOR: compare
    let methods = SurrogateMethods::standard().with(Neighbours { count: 4 })?;
    let compared = ["feed-forward", "ridge", "neighbours"].map(|name| methods.by_name(name));
    let scores =
        compare(&parts, &spec, &compared.into_iter().collect::<Result<Vec<_>, _>>()?, 0.9, &mut NoObserver)?;
    println!("method         held out  unseen  in 90 % interval");
    for scored in &scores {
        let [held_out, unseen] = [scored.held_out, scored.unseen].map(|score| 100.0 * score.relative_rmse);
        let share = scored.coverage.map_or("-".to_string(), |share| format!("{:.0} %", 100.0 * share));
        println!("{:<13} {held_out:>7.1} % {unseen:>6.1} %  {share:>6}", scored.method);
        assert!(scored.unseen.states == 40 && scored.unseen.relative_rmse < 0.5);
    }
    // ANCHOR_END: compare

    // ANCHOR: save
    // All surrogates are saved and read in the same way, and report the causes of their intervals.
    let file = std::env::temp_dir().join(format!("granum-example-{}.json", std::process::id()));
    save(&file, scores[1].surrogate.as_ref())?;
    let ridge = methods.load(&file)?;
    std::fs::remove_file(&file)?;
    let prediction = &ridge.predict_rows(&[0.1, 0.2, 0.12], 0.9)?[0];
    let interval = prediction.values[0].interval.as_ref().ok_or("ridge regression has intervals")?;
    println!(
        "q/p at arc length 0.1: {:.3}, {:.3} to {:.3}",
        prediction.values[0].mean, interval.lower, interval.upper
    );
    for (cause, deviation) in &interval.causes {
        println!("  standard deviation by {cause}: {deviation:.3}");
    }
    // ANCHOR_END: save
    assert!(interval.causes.iter().any(|(cause, _)| *cause == Cause::Runs));
    Ok(())
}
