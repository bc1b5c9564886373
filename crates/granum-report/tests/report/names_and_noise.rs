//! Names that users chose are shown letter by letter, and ratios of the stresses of a sample that has lost them are not drawn.

use granum_core::{Column, Table};
use granum_learn::dataset::{Dataset, RunStates, Split};
use granum_learn::study::{NoStudyObserver, Study, StudyDefinition};
use granum_learn::surrogate::{FitSpec, SurrogateMethods};
use granum_report::{self as report, RunReport};
use granum_sensors::Record;

use crate::checks::check;

#[test]
fn names_in_a_study_are_shown_letter_by_letter() {
    let run = |k: u32| {
        let x: Vec<f64> = (0..12).map(|i| f64::from(i) / 11.0).collect();
        let y = x.iter().map(|x| 1.0 + x * x + 0.01 * f64::from(k)).collect();
        let columns = vec![Column::new("x", "", x), Column::new("y*1*", "Pa", y)];
        RunStates::new(&format!("run*{k}*"), Table::new(columns).unwrap()).unwrap()
    };
    let dataset = Dataset::new((1..=3).map(run).collect()).unwrap();
    let fit = FitSpec::new(["x"], ["y*1*"]).with_coordinate("x");
    let definition = StudyDefinition::new([fit], ["ridge"], Split::default().unseen(["run*3*"]));
    let methods = SurrogateMethods::standard();
    let study = Study::train(&dataset, &definition, &methods, &NoStudyObserver).unwrap();
    let folder = tempfile::tempdir().unwrap();
    granum_learn::study::save(folder.path(), &study, &dataset).unwrap();
    let stored = granum_learn::study::load(folder.path(), &methods).unwrap();
    let document = report::surrogate_study_report(&stored, "a*b*", None);
    check(&document);
    for name in ["Study a*b*", "run*3*", "y*1*"] {
        assert!(document.html.contains(name), "{name} is not shown as it is");
    }
    assert!(!document.html.contains("<i>"), "a part of a name became italic");
    assert!(
        document.figures.iter().all(|(_, svg)| !svg.contains("italic")),
        "a part of a name became italic"
    );
}

#[test]
fn runs_over_each_other_have_no_ratios_of_stresses_that_are_lost() {
    let text = "[[stage]]\npath = \"undrained-triaxial\"\n";
    let run = |name: &str| {
        let column = |name: &str, values: [f64; 4]| Column::new(name, "", values.to_vec());
        // The sample liquefies; of its last pascals the ratio is noise.
        let (axial, lateral) = ([100e3, 60e3, 20.0, 30.0], [100e3, 30e3, 1.0, -9.0]);
        let mean = std::array::from_fn(|k| (axial[k] + 2.0 * lateral[k]) / 3.0);
        let strain = [0.0, 0.01, 0.02, 0.03];
        let columns = vec![
            column("stage", [1.0; 4]),
            column("arc_length", strain),
            column("deviatoric_strain", strain),
            column("axial_strain", strain),
            column("stress_11", axial),
            column("stress_22", lateral),
            column("stress_33", lateral),
            column("mean_stress", mean),
        ];
        RunReport {
            name: name.into(),
            case: granum_io::Case::parse(text, "case.toml").unwrap(),
            record: Record { series: Table::new(columns).unwrap(), histograms: Vec::new() },
            ..RunReport::default()
        }
    };
    let document = report::overlay_report(&[run("one"), run("two")]);
    let (_, svg) = document.figures.iter().find(|(name, _)| name.ends_with("-stress.svg")).unwrap();
    // Of the states that carry stress it is 0.75 at most; of the others 2.6 and 9.75.
    let on_the_left = |number: &str| svg.contains(&format!("text-anchor=\"end\">{number}</text>"));
    assert!(on_the_left("0.6") && !on_the_left("2") && !on_the_left("10"), "{svg}");
}
