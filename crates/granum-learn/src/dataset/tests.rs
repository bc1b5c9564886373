//! Tests of data sets along arbitrary paths.

use granum_io::RunKind;

use granum_core::{Column, Table};
use granum_io::{Case, Machine, Run, RunFolder, RunRecord};
use granum_sensors::Record;

use super::*;
use crate::error::Result;
use crate::synthetic::{Law, record};

fn table(columns: &[(&str, &[f64])]) -> Table {
    Table::new(columns.iter().map(|(name, values)| Column::new(*name, "", values.to_vec())).collect())
        .unwrap()
}

/// A cyclic test in which the strain increases and decreases, with two stages whose states are both numbered from 0.
fn cyclic(name: &str, friction: f64) -> RunStates {
    let strain = [0.0, 0.01, 0.02, 0.01, 0.0, -0.01];
    let arc = [0.0, 0.01, 0.02, 0.03, 0.04, 0.05];
    let ratio = strain.map(|e| e * friction);
    let columns: [(&str, &[f64]); 5] = [
        ("stage", &[1.0, 1.0, 1.0, 2.0, 2.0, 2.0]),
        ("state", &[0.0, 1.0, 2.0, 0.0, 1.0, 2.0]),
        ("shear_strain_xy", &strain),
        ("arc_length", &arc),
        ("stress_ratio", &ratio),
    ];
    RunStates::new(name, table(&columns)).unwrap().with_parameter("friction", "", friction).unwrap()
}

#[test]
fn strain_may_turn_and_parameters_are_columns() {
    let dataset = Dataset::new(vec![cyclic("a", 0.3), cyclic("b", 0.5)]).unwrap();
    assert_eq!((dataset.rows(), dataset.run_of_rows()[5..7].to_vec()), (12, vec![0, 1]));
    assert_eq!(dataset.column("friction").unwrap(), [[0.3; 6], [0.5; 6]].concat());
    assert_eq!(dataset.values(&["shear_strain_xy", "friction"]).unwrap()[10..14], [-0.01, 0.3, 0.0, 0.5]);
    let table = dataset.table().unwrap();
    assert_eq!(table.column("run").unwrap()[5..7], [1.0, 2.0]);
    assert_eq!(table.rows(), 12);

    let split = Split::default().first_state(1).stride(2).unseen(["b"]);
    let parts = dataset.split(&split).unwrap();
    let key = |part: &Dataset| part.values(&["stage", "state"]).unwrap();
    assert_eq!(key(&parts.training), [1.0, 1.0, 2.0, 1.0]);
    assert_eq!(key(&parts.held_out), [1.0, 2.0, 2.0, 2.0]);
    assert_eq!(parts.unseen.rows(), 4);
    let parts = dataset.split(&Split::default().stride(1).within("arc_length", [0.02, 0.03])).unwrap();
    assert_eq!((parts.training.rows(), parts.held_out.rows(), parts.unseen.rows()), (4, 0, 0));
    let parts = dataset.split(&Split::default().stride(1).within("friction", [0.4, 1.0])).unwrap();
    assert_eq!(parts.training.runs().len(), 1);
}

#[test]
fn the_digest_sees_names_units_numbers_and_parameters() {
    let digest = |run: RunStates| Dataset::new(vec![run]).unwrap().digest();
    let reference = digest(cyclic("a", 0.3));
    assert_eq!(reference, digest(cyclic("a", 0.3)));
    assert_ne!(reference, digest(cyclic("b", 0.3)));
    assert_ne!(reference, digest(cyclic("a", 0.3f64.next_up())));
    assert_ne!(reference, digest(cyclic("a", 0.3).with_parameter("seed", "", 1.0).unwrap()));
}

#[test]
fn what_is_no_data_set_is_refused_with_its_place() {
    let message = |result: Result<RunStates>| result.unwrap_err().to_string();
    let falling = table(&[("state", &[0.0, 2.0, 1.0])]);
    assert_eq!(
        message(RunStates::new("a", falling)),
        "record `a`: state 1: the key must increase from row to row: first the stage, then the state in it"
    );
    let half = table(&[("state", &[0.0, 0.5])]);
    assert!(
        message(RunStates::new("a", half)).contains("row 1: stages and states are counted by whole numbers")
    );
    assert!(message(RunStates::new("", table(&[]))).contains("no name"));
    assert!(
        message(cyclic("a", 0.3).with_parameter("arc_length", "", 1.0))
            .contains("a column of its states already")
    );
    assert!(message(cyclic("a", 0.3).with_parameter("x", "", f64::NAN)).contains("parameter x is NaN"));

    let message = |runs: Vec<RunStates>| Dataset::new(runs).unwrap_err().to_string();
    assert_eq!(message(vec![]), "data set: there is no run");
    assert!(message(vec![cyclic("a", 0.3), cyclic("a", 0.5)]).contains("two runs have the name a"));
    let empty = RunStates::new("none", table(&[("x", &[])])).unwrap();
    assert!(message(vec![empty]).contains("run none has no state"));

    let other = cyclic("b", 0.5).with_parameter("seed", "", 2.0).unwrap();
    let dataset = Dataset::new(vec![cyclic("a", 0.3), other]).unwrap();
    let message = |name: &str| dataset.column(name).unwrap_err().to_string();
    assert_eq!(message("seed"), "data set: not all runs have a column seed; it is missing in a");
    assert_eq!(
        message("stress_ratios"),
        "data set: there is no column stress_ratios; did you mean stress_ratio?"
    );
    let message = |split: Split| dataset.split(&split).unwrap_err().to_string();
    assert!(message(Split::default().unseen(["c"])).contains("no run c to keep unseen; there are: a, b"));
    assert!(message(Split::default().stride(0)).contains("1 or more, not 0"));
    assert!(message(Split::default().first_state(9)).contains("no state to train on"));
    assert!(message(Split::default().within("arc", [0.0, 1.0])).contains("no column arc"));

    let columns: [(&str, &[f64]); 2] = [("stage", &[1.0, 2.0]), ("x", &[1.0, f64::NAN])];
    let broken = Dataset::new(vec![RunStates::new("a", table(&columns)).unwrap()]).unwrap();
    let text = broken.values(&["x"]).unwrap_err().to_string();
    assert_eq!(text, "record `a`: stage 2, state 1: x is NaN, not a finite number");
}

#[test]
fn a_histogram_is_a_column_for_each_bin() {
    let record = record(Law::Plain, 1, 8);
    let run = RunStates::from_record(&NamedRecord { name: "run", seed: 7, record: &record }).unwrap();
    let group = run.group("probability_density").unwrap();
    assert_eq!(
        (group.binned.as_str(), group.bin_width, group.centres.len()),
        ("force", 0.25, record.forces()[0].bins())
    );
    let bin = group.centres.iter().position(|centre| *centre == 1.125).unwrap();
    let column = run.column("probability_density_1.125").unwrap();
    assert!(column.iter().zip(record.forces()).all(|(value, histogram)| *value == histogram.density(bin)));
    assert_eq!(run.parameter("preparation.seed"), Some(7.0));
    let dataset = Dataset::new(vec![run]).unwrap();
    let names = dataset.expand(&["deviator_strain", "probability_density"]).unwrap();
    assert_eq!((names.len(), names[0].as_str()), (1 + record.forces()[0].bins(), "deviator_strain"));

    let refused = |change: &dyn Fn(&mut Record)| {
        let mut broken = record.clone();
        change(&mut broken);
        RunStates::from_record(&NamedRecord { name: "run", seed: 7, record: &broken })
            .unwrap_err()
            .to_string()
    };
    assert!(
        refused(&|record| drop(record.histograms[0].states.pop())).contains("9 states have 8 histograms")
    );
    let text = refused(&|record| record.histograms[0].states[4].bin_width = 0.2);
    assert!(
        text.contains("histogram forces: state 4: its histogram does not have the bins of the first state"),
        "{text}"
    );
}

/// The folder of a run provides the measurements, the arc length of the path, and the numbers of its case.
#[test]
fn a_run_folder_gives_its_case_as_parameters() {
    let mut record = record(Law::Plain, 1, 8);
    let strain = record.series.column("deviator_strain").unwrap().to_vec();
    for (name, share) in
        [("axial_strain", 2.0 / 3.0), ("lateral_strain_2", -1.0 / 3.0), ("lateral_strain_3", -1.0 / 3.0)]
    {
        let values = strain.iter().map(|e| share * e).collect();
        record.series.set(Column::new(name, "1", values)).unwrap();
    }
    for name in ["forces_below", "forces_above"] {
        record.series.set(Column::new(name, "", vec![0.0; strain.len()])).unwrap();
    }
    let base = tempfile::tempdir().unwrap();
    let path = base.path().join("run");
    let folder = RunFolder::create(&path, false).unwrap();
    let mut case = Case::default();
    case.set("grains.material.friction", "0.45").unwrap();
    case = case.with_path("drained-triaxial", &[("lateral_stress", "50 kPa")]).unwrap();
    folder.write_case(&case, None).unwrap();
    folder.write_record(&RunRecord::new(RunKind::Test, "0.1.0", &case, Machine::here("avx2", 1))).unwrap();
    granum_run::record::write_record(&folder, &record).unwrap();

    let dataset = Dataset::read(&[Run::at(&path).unwrap()]).unwrap();
    assert_eq!(dataset.column("grains.material.friction").unwrap(), [0.45; 9]);
    assert_eq!(dataset.variable("grains.material.youngs_modulus").unwrap().unit, "Pa");
    assert_eq!(dataset.runs()[0].parameter("preparation.seed"), Some(case.preparation.seed as f64));
    // The stages are parameters too, with the defaults of their path.
    assert_eq!(dataset.column("stage.1.lateral_stress").unwrap(), [5e4; 9]);
    assert_eq!(dataset.runs()[0].parameter("stage.1.axial_strain"), Some(0.2));
    // The law is a word, and the sample has been measured.
    assert_eq!(dataset.category("contact.normal").unwrap().words, ["jkr"]);
    let error = dataset.column("contact.normal").unwrap_err().to_string();
    assert_eq!(
        error,
        "data set: contact.normal holds words (jkr), not numbers; it can be an input of surrogates and nothing else"
    );
    assert_eq!(
        dataset.column("sample.stress_ratio").unwrap(),
        [record.series.column("stress_ratio").unwrap()[0]; 9]
    );
    let runs = dataset.runs_table().unwrap();
    assert_eq!((runs.rows(), runs.get("contact.normal").unwrap().word(0)), (1, Some("jkr")));
    assert_eq!(runs.column("stage.1.lateral_stress").unwrap(), [5e4]);
    // For strains e (2, -1, -1) / 3, the arc length sqrt(2/3 e:e) is 2/3 e.
    let arc = dataset.column("arc_length").unwrap();
    assert!(arc.iter().zip(&strain).all(|(arc, strain)| (arc - 2.0 / 3.0 * strain).abs() < 1e-12), "{arc:?}");
}

#[test]
fn every_histogram_is_alike() {
    let mut record = record(Law::Plain, 1, 8);
    // The histogram of any sensor, with bins whose centres show rounding errors, and a unit.
    let states = (0..9).map(|k| {
        let mut radii = granum_sensors::Histogram::new(0.1, 0.0, 0.5);
        (0..=k).for_each(|value| radii.add(0.05 * f64::from(value)));
        radii
    });
    let (name, quantity, unit) = ("radii".to_string(), "radius".to_string(), "m".to_string());
    record.histograms.push(granum_sensors::Histograms { name, quantity, unit, states: states.collect() });
    let run = RunStates::of_record("run", record.clone()).unwrap();
    let group = run.group("radii_probability_density").unwrap();
    assert_eq!(group.binned, "radius");
    assert_eq!(group.columns().nth(3).unwrap(), "radii_probability_density_0.35");
    let dataset = Dataset::new(vec![run]).unwrap();
    let column = dataset.column("radii_probability_density_0.35").unwrap();
    assert!(column.iter().zip(record.histograms("radii")).all(|(value, known)| *value == known.density(3)));
    assert_eq!(dataset.variable("radii_probability_density_0.35").unwrap().unit, "1/m");
    // Earlier versions wrote the centre with its rounding error.
    assert_eq!(dataset.column("radii_probability_density_0.35000000000000003").unwrap(), column);
    assert_eq!(
        dataset.expand(&["radii_probability_density_0.350"]).unwrap(),
        ["radii_probability_density_0.35"]
    );
    assert_eq!(dataset.expand(&["radii_probability_density", "stress_ratio"]).unwrap().len(), 6);
    let error = dataset.column("radii_probability_densty").unwrap_err().to_string();
    assert!(error.contains("did you mean radii_probability_density?"), "{error}");
    let sections = dataset.catalogue(&granum_sensors::Sensors::standard());
    let listed =
        |name: &str| sections.iter().flat_map(|section| &section.entries).find(|entry| entry.name == name);
    let meaning = &listed("radii_probability_density").unwrap().meaning;
    assert!(meaning.contains("density of radius in 5 bins, radii_probability_density_0.05 to"), "{meaning}");
    assert!(
        listed("stress_ratio").unwrap().meaning == "q/p" && listed("probability_density_0.125").is_none()
    );
    assert_eq!(listed("sample.deviator_fabric").unwrap().unit, "");

    // Another run with other bins.
    let mut finer = record.clone();
    finer.histograms[1]
        .states
        .iter_mut()
        .for_each(|radii| *radii = granum_sensors::Histogram::new(0.05, 0.0, 0.5));
    let runs = [("coarse", record), ("fine", finer)]
        .map(|(name, record)| RunStates::of_record(name, record).unwrap());
    let error =
        Dataset::new(runs.into()).unwrap().expand(&["radii_probability_density"]).unwrap_err().to_string();
    assert!(
        error.contains("fine do not have the bins of radii_probability_density that coarse has"),
        "{error}"
    );
}

/// The sample before it was strained is measured in the state 0; a record without that state says nothing of it.
#[test]
fn the_sample_is_what_the_state_0_measured() {
    let mut record = record(Law::Plain, 1, 8);
    record.series.set(Column::new("solid_fraction", "", vec![0.625; 9])).unwrap();
    let run = RunStates::of_record("run", record.clone()).unwrap();
    assert_eq!(
        (run.parameter("sample.solid_fraction"), run.parameter("sample.void_ratio")),
        (Some(0.625), Some(0.6))
    );
    assert_eq!(run.parameter("sample.observations"), None);
    record.series.set(Column::new("void_ratio", "", vec![0.61; 9])).unwrap();
    let measured = RunStates::of_record("run", record.clone()).unwrap();
    assert_eq!(measured.parameter("sample.void_ratio"), Some(0.61));
    record.series.set(Column::new("state", "", (1..10).map(f64::from).collect())).unwrap();
    let later = RunStates::of_record("run", record).unwrap();
    assert!(later.parameters().is_empty());
}

#[test]
fn words_are_inputs_by_one_column_each() {
    let run = |name: &str, law: &str| cyclic(name, 0.3).with_word("contact.normal", law).unwrap();
    let dataset = Dataset::new(vec![run("a", "hertz"), run("b", "jkr"), run("c", "hertz")]).unwrap();
    let columns = dataset.expand(&["contact.normal", "arc_length"]).unwrap();
    assert_eq!(columns, ["contact.normal=hertz", "contact.normal=jkr", "arc_length"]);
    assert_eq!(dataset.values(&columns).unwrap()[15..21], [1.0, 0.0, 0.05, 0.0, 1.0, 0.0]);
    assert_eq!(dataset.table().unwrap().get("contact.normal").unwrap().word(7), Some("jkr"));
    dataset.check_words(&columns).unwrap();
    let error =
        dataset.check_words(["contact.normal=hertz", "contact.normal=hooke"]).unwrap_err().to_string();
    assert_eq!(
        error,
        "record `b`: contact.normal is jkr, of which nothing can be known from runs with hertz, hooke"
    );
    // A number in one run and a word in another is a category.
    let mixed = Dataset::new(vec![
        cyclic("a", 0.3).with_parameter("preparation.friction", "", 0.1).unwrap(),
        cyclic("b", 0.3).with_word("preparation.friction", "auto").unwrap(),
    ]);
    assert_eq!(mixed.unwrap().category("preparation.friction").unwrap().words, ["0.1", "auto"]);

    let spec = |inputs: &[&str], outputs: &[&str]| crate::FitSpec::new(inputs.to_vec(), outputs.to_vec());
    let refused = |spec: crate::FitSpec| spec.columns(&dataset).unwrap_err().to_string();
    let text = refused(spec(&["arc_length"], &["contact.normal"]));
    assert_eq!(text, "data set: contact.normal holds words (hertz, jkr); an output must be a number");
    let text = refused(spec(&["contact.normal"], &["stress_ratio"]).with_coordinate("contact.normal"));
    assert!(text.contains("the coordinate must be a number"), "{text}");
}
