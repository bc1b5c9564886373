//! Networks with a share of ridge regression beside each of them alone: where the truth is linear, where it is not, and in files.

use granum_core::observer::NoObserver;
use granum_core::{Column, Table};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::*;
use crate::dataset::{Dataset, RunStates};
use crate::score_surrogate;
use crate::surrogate::{
    FeedForward, FitSpec, RidgeRegression, Surrogate, SurrogateMethod, SurrogateMethods, to_json,
};
use crate::synthetic::{Law, dataset_of, parts, records, spec_of};

/// Number of sensors of a synthetic run.
const SENSORS: usize = 8;

/// How the output depends on the sensors.
#[derive(Clone, Copy, PartialEq)]
enum Truth {
    /// A curve of strain and a multiple of each sensor.
    Linear,
    /// A curve of strain and a product of two sensors.
    Product,
}

/// Runs with sensors that follow strain and deviate slowly from it, and with an offset of each run.
fn runs(truth: Truth, count: u64, first: u64) -> Dataset {
    let run = |number: u64| {
        let mut random = ChaCha8Rng::seed_from_u64(number);
        let mut normal =
            || (0..12).map(|_| f64::from(random.next_u32()) / f64::from(u32::MAX)).sum::<f64>() - 6.0;
        let offset = 0.02 * normal();
        let strains: Vec<f64> = (1..=40).map(|k| 0.3 * f64::from(k) / 40.0).collect();
        let mut sensors = vec![Vec::new(); SENSORS];
        let mut deviations: Vec<f64> = (0..SENSORS).map(|_| normal()).collect();
        let mut ratios = Vec::new();
        for strain in &strains {
            let curve = 0.8 * (1.0 - libm::exp(-strain / 0.02));
            for (sensor, deviation) in sensors.iter_mut().zip(&mut deviations) {
                *deviation = 0.9 * *deviation + 0.44 * normal();
                sensor.push(curve + 0.1 * *deviation);
            }
            let linear: f64 =
                deviations.iter().enumerate().map(|(k, z)| if k % 2 == 0 { *z } else { -z }).sum();
            let from_sensors = match truth {
                Truth::Linear => 0.015 * linear,
                Truth::Product => 0.1 * deviations[0] * deviations[1],
            };
            ratios.push(curve + from_sensors + offset + 0.01 * normal());
        }
        let mut columns = vec![Column::new("strain", "", strains), Column::new("ratio", "", ratios)];
        columns.extend(
            sensors.into_iter().enumerate().map(|(k, values)| Column::new(format!("sensor_{k}"), "", values)),
        );
        RunStates::new(&format!("run-{number}"), Table::new(columns).unwrap()).unwrap()
    };
    Dataset::new((first..first + count).map(run).collect()).unwrap()
}

fn spec(sensors: usize) -> FitSpec {
    let inputs = ["strain".to_string()].into_iter().chain((0..sensors).map(|k| format!("sensor_{k}")));
    FitSpec::new(inputs, ["ratio"]).with_coordinate("strain")
}

/// The mean error on unseen runs over some trials of networks with their share of ridge regression, of ridge regression, and of the networks alone.
fn errors(truth: Truth, count: u64, sensors: usize) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for trial in 0..4 {
        let training = runs(truth, count, 100 * trial);
        let unseen = runs(truth, 12, 100 * trial + 50);
        let method = NetworksBySubModel { hidden: vec![6, 6], ..NetworksBySubModel::default() };
        let both = method.fit(&training, &spec(sensors), &mut NoObserver).unwrap();
        let networks = networks_of(both.as_ref()).unwrap();
        let alone = networks.clone().beside(None);
        let ridge = RidgeRegression::default().fit(&training, &spec(sensors), &mut NoObserver).unwrap();
        let fitted: [&dyn Surrogate; 3] = [both.as_ref(), ridge.as_ref(), &alone];
        for (sum, surrogate) in sums.iter_mut().zip(fitted) {
            *sum += score_surrogate(surrogate, &unseen).unwrap().relative_rmse / 4.0;
        }
    }
    sums
}

/// Where ridge regression of few noisy runs is better than networks alone by a fifth to a third, three quarters of its lead are gained.
#[test]
fn where_the_truth_is_linear_networks_gain_most_of_the_lead_of_ridge_regression() {
    for count in [2, 4] {
        let [both, ridge, alone] = errors(Truth::Linear, count, SENSORS);
        let lead = alone - ridge;
        assert!(lead > 0.2 * alone, "{count} runs: ridge regression {ridge}, networks alone {alone}");
        assert!(
            both < ridge + 0.3 * lead,
            "{count} runs: {both}, ridge regression {ridge}, networks alone {alone}"
        );
    }
}

#[test]
fn where_the_truth_is_not_linear_networks_win_as_they_did_alone() {
    for (count, most) in [(4, 1.15), (8, 1.06)] {
        let [both, ridge, alone] = errors(Truth::Product, count, 2);
        assert!(both < 0.7 * ridge, "{count} runs: {both}, ridge regression {ridge}, networks alone {alone}");
        assert!(
            both < most * alone,
            "{count} runs: {both}, ridge regression {ridge}, networks alone {alone}"
        );
    }
}

/// Files keep the share, and those of earlier versions, which have none, are read as networks that stand alone.
#[test]
fn files_with_and_without_a_share_are_read() {
    let dataset = dataset_of(&records(Law::Hidden, 5));
    let training = parts(&dataset).training;
    let rows = |surrogate: &dyn Surrogate| training.values(&surrogate.columns().input_names()).unwrap();
    let small = NetworksBySubModel { hidden: vec![3], ..NetworksBySubModel::default() };
    let plain = FeedForward { hidden: vec![3], ..FeedForward::default() };
    let methods = SurrogateMethods::standard();
    let mapped =
        ["F2", "F3"].map(|name| small.fit(&training, &spec_of(&dataset, name), &mut NoObserver).unwrap());
    let other = plain.fit(&training, &spec_of(&dataset, "F3"), &mut NoObserver).unwrap();
    for fitted in mapped.into_iter().chain([other]) {
        let text = to_json(fitted.as_ref()).unwrap();
        let read = methods.from_json(&text, "file").unwrap();
        let rows = rows(fitted.as_ref());
        let predictions = fitted.predict_rows(&rows, 0.9).unwrap();
        assert_eq!(read.predict_rows(&rows, 0.9).unwrap(), predictions);
        let inputs =
            crate::surrogate::RunInputs::separate(rows.clone(), read.columns().inputs.len()).unwrap();
        let means = read.means(&inputs).unwrap();
        assert!(
            predictions.iter().zip(&means).all(|(p, m)| p
                .values
                .iter()
                .map(|v| v.mean)
                .eq(m.iter().copied()))
        );

        let method = methods.by_name(fitted.method()).unwrap();
        let content = |change: &dyn Fn(&mut serde_json::Value)| {
            let mut value: serde_json::Value = fitted.content().unwrap().read().unwrap();
            change(&mut value);
            crate::surrogate::Content::new(&value).unwrap()
        };
        let without = content(&|value| drop(value.as_object_mut().unwrap().remove("beside").unwrap()));
        let alone = method.load(fitted.columns().clone(), &without).unwrap();
        assert_ne!(alone.means(&inputs).unwrap(), means);
        for wrong in [serde_json::json!([1.5]), serde_json::json!([])] {
            let damaged = content(&|value| value["beside"]["shares"] = wrong.clone());
            let text = method.load(fitted.columns().clone(), &damaged).err().unwrap().to_string();
            assert!(text.contains("the shares of ridge regression must be"), "{text}");
        }
        let damaged = content(&|value| value["beside"]["limits"][0] = serde_json::json!([1.0, 0.0]));
        let text = method.load(fitted.columns().clone(), &damaged).err().unwrap().to_string();
        assert!(text.contains("the limits of ridge regression must be"), "{text}");
        let damaged = content(&|value| value["beside"]["ridge"]["deviations"] = serde_json::json!([]));
        assert!(method.load(fitted.columns().clone(), &damaged).is_err());
    }
}

/// Far outside of what was trained, the linear part does not leave the values that a network can have.
#[test]
fn far_outside_predictions_stay_near_the_values_that_were_trained() {
    let training = runs(Truth::Linear, 4, 0);
    let method = FeedForward { hidden: vec![4], ..FeedForward::default() };
    let fitted = method.fit(&training, &spec(SENSORS), &mut NoObserver).unwrap();
    let ratios = training.column("ratio").unwrap();
    let [low, high] = crate::curve::range(ratios);
    let beyond = 0.1251 * (high - low);
    for sensor in [-1e3, 1e3] {
        let mut row = vec![sensor; SENSORS + 1];
        row[0] = 0.1;
        let mean = fitted.predict_rows(&row, 0.9).unwrap()[0].values[0].mean;
        assert!((low - beyond..high + beyond).contains(&mean), "{mean} of {low} to {high}");
    }
}

/// A histogram is predicted at any place, and at the centres of its bins as a whole.
#[test]
fn between_the_bins_a_predicted_histogram_is_continuous() {
    let dataset = dataset_of(&records(Law::Hidden, 5));
    let training = parts(&dataset).training;
    let method = NetworksBySubModel { hidden: vec![4], ..NetworksBySubModel::default() };
    let fitted = method.fit(&training, &spec_of(&dataset, "F2"), &mut NoObserver).unwrap();
    let networks = networks_of(fitted.as_ref()).unwrap();
    let share = networks.share_of_ridge();
    assert!(share > 0.0, "{share}");
    let row = training.values(&["deviator_strain", "stress_ratio"]).unwrap()[20..22].to_vec();
    let centres = networks.mapping().output_centres().to_vec();
    let whole = networks.predict_states(&row).unwrap()[0].values.clone();
    let near: Vec<f64> = centres.iter().map(|centre| centre + 1e-9).collect();
    let beside = networks.predict_states_at(&row, &near).unwrap()[0].values.clone();
    assert!(whole.iter().zip(&beside).all(|(a, b)| (a - b).abs() < 1e-7), "{whole:?} {beside:?}");
    for (centre, value) in near.iter().zip(&beside) {
        let single = networks.predict_row(&[row[0], row[1], *centre], 0.9).unwrap();
        assert_eq!(single.value, *value);
        let [low, high] = single.interval.unwrap();
        assert!(low < *value && *value < high);
    }
}
