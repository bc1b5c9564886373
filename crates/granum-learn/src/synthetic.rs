//! Synthetic records with known laws for the tests: curves similar to those of a sheared sample, with noise from a seed.

use granum_core::{Column, Table};
use granum_learn::FitSpec;
use granum_learn::dataset::{Dataset, NamedRecord, RunStates, Split, SplitParts};
use granum_sensors::Record;
use granum_sensors::{Histogram, force_distribution};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// The dependence of the quantities of a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Law {
    /// Everything is a function of strain, with small independent noise.
    Plain,
    /// The stress ratio follows a variable that jumps from state to state and shows in P(f) and in the fabric.
    Hidden,
    /// The stress ratio follows the same variable, but P(f) and the fabric do not show it.
    #[allow(dead_code, reason = "the tests of the paper's study, which share this file, use it")]
    Blind,
}

struct Noise(ChaCha8Rng);

impl Noise {
    fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A sum of uniform numbers with mean 0 and variance 1.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// A record of `intervals + 1` states to a deviator strain of 0.3.
pub(crate) fn record(law: Law, seed: u64, intervals: usize) -> Record {
    let mut noise = Noise(ChaCha8Rng::seed_from_u64(seed));
    let mut columns: Vec<(&str, Vec<f64>)> =
        ["state", "deviator_strain", "stress_ratio", "deviator_fabric"].map(|name| (name, Vec::new())).into();
    let mut forces = Vec::new();
    for state in 0..=intervals {
        let strain = 0.3 * state as f64 / intervals as f64;
        let rise = 1.0 - (-strain / 0.012).exp();
        let peak = (-(strain - 0.06).powi(2) / 0.004).exp();
        let hidden = if law == Law::Plain { 0.0 } else { noise.uniform() - 0.5 };
        let shown = if law == Law::Hidden { hidden } else { 0.0 };
        let ratio = 0.7 * rise + 0.2 * peak * rise + 0.3 * hidden + 0.004 * noise.normal();
        let fabric = 0.10 * rise + 0.04 * peak * rise + 0.06 * shown + 0.001 * noise.normal();
        let decay = 1.4 - 0.3 * rise + 0.1 * peak + 0.5 * shown;
        forces.push(histogram(&mut noise, decay));
        for (column, value) in columns.iter_mut().zip([state as f64, strain, ratio, fabric]) {
            column.1.push(value);
        }
    }
    let columns = columns.into_iter().map(|(name, values)| Column::new(name, "", values));
    Record::with_forces(Table::new(columns.collect()).unwrap(), forces)
}

/// Records of one law with the seeds from 1, to a deviator strain of 0.3 in 60 intervals.
pub(crate) fn records(law: Law, count: u64) -> Vec<Record> {
    (1..=count).map(|seed| record(law, seed, 60)).collect()
}

/// The records as runs `run-1`, `run-2` and so on of a data set.
pub(crate) fn dataset_of(records: &[Record]) -> Dataset {
    let run = |(k, record): (usize, &Record)| {
        let name = format!("run-{}", k + 1);
        RunStates::from_record(&NamedRecord { name: &name, seed: k as u64 + 1, record }).unwrap()
    };
    Dataset::new(records.iter().enumerate().map(run).collect()).unwrap()
}

/// The split of the paper, with the last two runs unseen.
pub(crate) fn parts(dataset: &Dataset) -> SplitParts {
    let unseen = dataset.runs().iter().rev().take(2).map(|run| run.name().to_string());
    dataset.split(&Split::default().first_state(1).unseen(unseen)).unwrap()
}

/// The specification of a mapping by names of columns, with bins from 0 to 3.5.
pub(crate) fn spec_of(dataset: &Dataset, mapping: &str) -> FitSpec {
    let densities: Vec<String> = dataset
        .expand(&["probability_density"])
        .unwrap()
        .into_iter()
        .filter(|name| {
            (0.0..3.5).contains(&name.trim_start_matches("probability_density_").parse::<f64>().unwrap())
        })
        .collect();
    let number = |name: &str| vec![name.to_string()];
    let strain = number("deviator_strain");
    let (inputs, outputs) = match mapping {
        "F2" => ([strain, number("stress_ratio")].concat(), densities),
        "F3" => ([strain, number("deviator_fabric"), densities].concat(), number("stress_ratio")),
        other => panic!("{other}"),
    };
    FitSpec::new(inputs, outputs).with_coordinate("deviator_strain")
}

/// Counts of a Gamma-like distribution of forces, with the noise of 200,000 contacts.
fn histogram(noise: &mut Noise, decay: f64) -> Histogram {
    let mut histogram = force_distribution::bins(0.25, 6.0).empty();
    let weights: Vec<f64> = (0..histogram.bins())
        .map(|bin| {
            let f = histogram.centre(bin);
            if f < 0.0 { 0.0 } else { (0.8 + f) * (-decay * f).exp() }
        })
        .collect();
    let total: f64 = weights.iter().sum();
    for (count, weight) in histogram.counts.iter_mut().zip(weights) {
        let expected = 200_000.0 * weight / total;
        *count = (expected + expected.sqrt() * noise.normal()).round().max(0.0) as u64;
    }
    histogram
}
