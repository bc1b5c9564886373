//! Tests of data sets along arbitrary paths.

use granum_core::{Column, Table};
use granum_io::{Case, Machine, RunFolder, RunRecord};
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
    assert!(text.contains("state 4: its histogram does not have the bins of the first state"), "{text}");
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
    folder.write_record(&RunRecord::new("shear", "0.1.0", &case, Machine::here("avx2", 1))).unwrap();
    granum_run::record::write_record(&folder, &record).unwrap();

    let dataset = Dataset::read(&[&path]).unwrap();
    assert_eq!(dataset.column("grains.material.friction").unwrap(), [0.45; 9]);
    assert_eq!(dataset.variable("grains.material.youngs_modulus").unwrap().unit, "Pa");
    assert_eq!(dataset.runs()[0].parameter("preparation.seed"), Some(case.preparation.seed as f64));
    // The stages are parameters too, with the defaults of their path.
    assert_eq!(dataset.column("stage.1.lateral_stress").unwrap(), [5e4; 9]);
    assert_eq!(dataset.runs()[0].parameter("stage.1.axial_strain"), Some(0.2));
    // Names of contact laws are not numbers and therefore not columns.
    assert!(dataset.column("contact.normal").is_err());
    // For strains e (2, -1, -1) / 3, the arc length sqrt(2/3 e:e) is 2/3 e.
    let arc = dataset.column("arc_length").unwrap();
    assert!(arc.iter().zip(&strain).all(|(arc, strain)| (arc - 2.0 / 3.0 * strain).abs() < 1e-12), "{arc:?}");
}
