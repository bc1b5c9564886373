//! Tests of the columns, rows and weights of networks by sub-model.

use super::sensor_share::{RunRows, SHARE_OF_ONE_RUN, SHARES, sensor_share};
use super::training_rows::{Rule, TrainingStates};
use super::*;
use crate::dataset::{Dataset, SplitParts};
use crate::surrogate::FitSpec;
use crate::synthetic::{Law, dataset_of, parts, records};

fn mapping(dataset: &Dataset, inputs: &[&str], output: &str, form: Form) -> NetworkMapping {
    let spec = FitSpec::new(inputs.iter().copied(), [output]).with_coordinate("deviator_strain");
    let spec = spec.with_sub_models(SubModel::divided([0.0, 0.3], &[0.1, 0.2], &[3]));
    NetworkMapping::new(dataset, &spec, form, &[3]).unwrap()
}

fn names(mapping: &NetworkMapping) -> Vec<String> {
    mapping.network_inputs().into_iter().map(|column| column.name).collect()
}

/// One run of 20 states with few bins.
fn small() -> (Dataset, SplitParts) {
    let dataset = dataset_of(&[crate::synthetic::record(Law::Plain, 1, 20)]);
    let parts = dataset.split(&crate::Split::default().first_state(1)).unwrap();
    (dataset, parts)
}

#[test]
fn inputs_and_outputs_have_names_in_both_forms() {
    let (dataset, _) = small();
    let two = ["probability_density_0.125", "probability_density_0.375"];
    let read = [&["deviator_strain"][..], &two].concat();
    let point = mapping(&dataset, &read, "stress_ratio", Form::Point);
    assert_eq!(names(&point), ["deviator_strain", "force", "probability_density"]);
    assert_eq!(names(&mapping(&dataset, &read, "stress_ratio", Form::Histogram)), read);
    let bins = point.inputs[1].bins.as_ref().unwrap();
    assert_eq!(
        (bins.centres.as_slice(), bins.width, bins.binned.as_str()),
        (&[0.125, 0.375][..], 0.25, "force")
    );
    // A histogram that is predicted needs the binned variable in both forms.
    for form in [Form::Point, Form::Histogram] {
        let given = mapping(&dataset, &["deviator_strain", "stress_ratio"], "probability_density", form);
        assert_eq!(names(&given), ["deviator_strain", "stress_ratio", "force"]);
        assert_eq!(given.network_output().name, "probability_density");
    }
    let message = |inputs: &[&str], output: &str, coordinate: Option<&str>| {
        let mut spec = FitSpec::new(inputs.iter().copied(), [output]);
        spec.coordinate = coordinate.map(Into::into);
        NetworkMapping::new(&dataset, &spec, Form::Point, &[3]).unwrap_err().to_string()
    };
    assert!(message(&["stress_ratio"], "deviator_fabric", None).contains("need a coordinate"));
    let mut two_outputs = FitSpec::new(["deviator_strain"], ["stress_ratio", "deviator_fabric"]);
    two_outputs.coordinate = Some("deviator_strain".into());
    let text = NetworkMapping::new(&dataset, &two_outputs, Form::Point, &[3]).unwrap_err().to_string();
    assert!(text.contains("fit each output separately"), "{text}");
    let overlapping = vec![SubModel::new([0.0, 0.2], [3]), SubModel::new([0.1, 0.3], [3])];
    let spec = FitSpec::new(["deviator_strain"], ["stress_ratio"]).with_coordinate("deviator_strain");
    let text = NetworkMapping::new(&dataset, &spec.with_sub_models(overlapping), Form::Point, &[3]);
    assert!(text.unwrap_err().to_string().contains("must follow each other: 0 to 0.2, 0.1 to 0.3"));
}

#[test]
fn rows_carry_what_the_mapping_reads() {
    let (dataset, parts) = small();
    let columns = ["deviator_strain", "deviator_fabric", "stress_ratio", "probability_density_0.875"];
    let values = parts.training.values(&columns).unwrap();
    let bins = dataset.expand(&["probability_density"]).unwrap();
    let at = bins.iter().position(|name| *name == "probability_density_0.875").unwrap();
    let [strain, fabric, ratio, density] = values[3 * 4..4 * 4] else { panic!() };

    let read = mapping(
        &dataset,
        &["deviator_strain", "deviator_fabric", "probability_density"],
        "stress_ratio",
        Form::Point,
    );
    let states = TrainingStates::new(&read, &parts.training).unwrap();
    let data = states.data(0, Rule::Pooled).unwrap();
    let row = (3 * bins.len() + at) * 4;
    assert_eq!(data.inputs()[row..row + 4], [strain, fabric, 0.875, density]);
    assert!(data.targets()[3 * bins.len()..4 * bins.len()].iter().all(|target| *target == ratio));
    assert_eq!((data.points(), data.rows()), (bins.len(), 10 * bins.len()));
    // The states of the first range are those below 0.1.
    let own = states.data(0, Rule::Separate).unwrap();
    assert_eq!((own.rows(), states.count_in(0)), (states.count_in(0) * bins.len(), 3));

    let given = mapping(&dataset, &["deviator_strain", "stress_ratio"], "probability_density", Form::Point);
    let states = TrainingStates::new(&given, &parts.training).unwrap();
    let data = states.data(0, Rule::Pooled).unwrap();
    let row = 3 * bins.len() + at;
    assert_eq!(data.inputs()[row * 3..row * 3 + 3], [strain, ratio, 0.875]);
    assert_eq!((data.targets()[row], data.points()), (density, 1));

    // The coordinate may be at any place, and without another input a state is one row.
    let turned = mapping(&dataset, &["deviator_fabric", "deviator_strain"], "stress_ratio", Form::Point);
    assert_eq!((turned.coordinate, turned.coordinate_of(&[fabric, strain])), (1, strain));
    let alone = mapping(&dataset, &["deviator_strain"], "stress_ratio", Form::Point);
    let data = TrainingStates::new(&alone, &parts.training).unwrap().data(0, Rule::Pooled).unwrap();
    assert_eq!((data.rows(), data.inputs()[3]), (10, strain));
}

#[test]
fn bins_of_another_width_are_refused() {
    let (dataset, _) = small();
    let read = mapping(&dataset, &["deviator_strain", "probability_density"], "stress_ratio", Form::Point);
    read.check_bins(&dataset).unwrap();
    let mut finer = crate::synthetic::record(Law::Plain, 1, 20);
    for histogram in &mut finer.histograms[0].states {
        histogram.bin_width = 0.25 / 3.0;
        histogram.counts =
            [histogram.counts.clone(), histogram.counts.clone(), histogram.counts.clone()].concat();
    }
    let text = read.check_bins(&dataset_of(&[finer])).unwrap_err().to_string();
    assert!(text.contains("record with bins of width 0.25"), "{text}");
}

fn share(inputs: &[&str], law: Law, runs: u64) -> f64 {
    let dataset = dataset_of(&records(law, runs + 2));
    let training = parts(&dataset).training;
    let mapping = mapping(&dataset, inputs, "stress_ratio", Form::Point);
    let states = TrainingStates::new(&mapping, &training).unwrap();
    let held_back: Vec<bool> = (0..mapping.inputs.len()).map(|k| k != mapping.coordinate).collect();
    sensor_share(&mapping, &states.runs, 0.15, &held_back).unwrap()
}

#[test]
fn inputs_that_tell_of_other_runs_are_believed() {
    let bins = [
        "deviator_strain",
        "probability_density_0.125",
        "probability_density_0.375",
        "probability_density_1.125",
    ];
    for runs in [2, 4] {
        assert_eq!(share(&bins, Law::Hidden, runs), SHARES[4], "{runs} runs");
        assert_eq!(share(&["deviator_strain", "deviator_fabric"], Law::Hidden, runs), SHARES[4]);
    }
    assert_eq!(share(&bins, Law::Hidden, 1), SHARE_OF_ONE_RUN);
}

/// A relation between an input and the output that changes its sign from run to run gives a small share, in contrast
/// to one that is the same in all runs.
#[test]
fn what_only_holds_within_a_run_is_not_believed() {
    let (dataset, _) = small();
    let mapping = mapping(&dataset, &["deviator_strain", "deviator_fabric"], "stress_ratio", Form::Point);
    let run = |sign: f64| {
        let wave = |k: u32| (0.9 * f64::from(k)).sin();
        RunRows {
            inputs: (1..60).map(|k| vec![0.005 * f64::from(k), 0.1 + 0.03 * wave(k)]).collect(),
            outputs: (1..60).map(|k| vec![0.5 + 0.005 * f64::from(k) + 0.1 * sign * wave(k)]).collect(),
        }
    };
    for (signs, expected) in [([1.0; 4], SHARES[4]), ([1.0, -1.0, 1.0, -1.0], SHARES[0])] {
        let runs = signs.map(run);
        assert_eq!(sensor_share(&mapping, &runs, 0.15, &[false, true]).unwrap(), expected);
    }
    // An input that never changes has a range of zero and does no harm.
    let constant = |mut rows: RunRows| {
        rows.inputs.iter_mut().for_each(|row| row[1] = 0.1);
        rows
    };
    let runs = [constant(run(1.0)), constant(run(0.9))];
    assert!(SHARES.contains(&sensor_share(&mapping, &runs, 0.15, &[false, true]).unwrap()));
}
