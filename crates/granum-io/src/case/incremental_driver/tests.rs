//! Files of the IncrementalDriver in tests.

use super::*;

const OPTIONS: Options = Options { stress_unit: 1e3, inertial_number: 1e-3, interval: 1e-4, outside: false };

fn read(text: &str) -> Result<Vec<CaseStage>> {
    parse(text, "test.inp", Path::new(""), &OPTIONS)
}

fn stages(text: &str) -> Vec<Stage> {
    read(text).unwrap().iter().flat_map(CaseStage::stages).collect()
}

#[test]
fn steps_become_ramps_with_compression_positive() {
    let found = stages(
        "output.txt # a heading\n*LinearLoad // text\n100 10 1.0 : 10\n*Cartesian\n0 -0.01\n1 -5.0\n1 0\n0 0.002 ! shear\n0 0\n0 0\n*END\n*Nonsense\n",
    );
    assert_eq!(found.len(), 1);
    let [x, y, z, yz, _, xy] = found[0].control.components;
    assert_eq!(x, Drive::Ramp(Ramp::By(0.01)));
    assert_eq!(y, Drive::Stress(Target::ramp(Ramp::By(5e3))));
    assert_eq!((z, yz), (Drive::Stress(Target::current()), Drive::Fixed));
    assert_eq!(xy, Drive::Ramp(Ramp::By(-0.002)));
    assert_eq!(found[0].until, [Until::RampOver]);
}

#[test]
fn named_steps_repetitions_and_conditions() {
    let found = stages(
        "out\n*Repetition\n2 3\n*TriaxialE1 ? s1 < -300\n10 1 1\n-0.02\n*TriaxialS1\n10 1 1\n50\n*OedometricE1\n1 1 1\n-0.01\n*TriaxialUEq\n1 1 1\n0.02\n*TriaxialUq\n1 1 1\n-10\n*PureCreep\n1 1 1\n*End\n",
    );
    assert_eq!(found.len(), 2 * 3 + 4);
    assert_eq!(found[0].control.components[0], Drive::Ramp(Ramp::By(0.02)));
    assert!(found[0].until.contains(&Until::Reaches { measure: Measure::Stress(0), value: 3e5 }));
    assert_eq!(found[1].control.components[0], Drive::Stress(Target::ramp(Ramp::By(-50e3))));
    assert_eq!(found[6].control.components[1], Drive::Fixed);
    assert_eq!(found[7].control.components[1], Drive::Ramp(Ramp::By(-0.01)));
    assert!(found.iter().all(|stage| stage.control.check().is_ok()));
}

/// Deeper repetitions would be written to a case file that is too deep to be read.
#[test]
fn repetitions_have_a_largest_depth() {
    let nested =
        |depth: usize| format!("out\n{}*TriaxialE1\n1 1 1\n-0.01\n", "*Repetition\n1 2\n".repeat(depth));
    let once = nested(32).replace("1 2", "1 1");
    let case = super::super::Case::default().with_stages(read(&once).unwrap());
    case.readable_toml(None).unwrap();
    for depth in [33, 80, 100_000] {
        let found = read(&nested(depth)).unwrap_err().to_string();
        assert!(found.starts_with("test.inp:66:1: this *Repetition is within 32 others"), "{found}");
    }
    for (counts, part) in
        [("0 3", ":3:1: 0 steps and 3"), ("1 0", ":3:1: 1 steps and 0"), ("1 99999", "1 to 10000 times")]
    {
        let found = read(&nested(1).replace("1 2", counts)).unwrap_err().to_string();
        assert!(found.contains(part), "{found}");
    }
}

#[test]
fn an_imported_file_lies_below_the_path() {
    let base = tempfile::tempdir().unwrap();
    let folder = base.path().join("here");
    std::fs::create_dir(&folder).unwrap();
    std::fs::write(base.path().join("rows.txt"), "0 0\n1 -0.01\n").unwrap();
    std::fs::write(folder.join("rows.txt"), "0 0\n1 -0.01\n").unwrap();
    let imported = |name: &str, outside: bool| {
        let text = format!("out\n*ImportFile {name}\n1 1 1\n*Cartesian\n0 2\n0 0\n0 0\n0 0\n0 0\n0 0\n");
        parse(&text, "test.inp", &folder, &Options { outside, ..OPTIONS })
    };
    assert_eq!(imported("rows.txt", false).unwrap().len(), 1);
    let found = imported("../rows.txt", false).unwrap_err().to_string();
    let parts = ["test.inp:2:1: *ImportFile ../rows.txt leads out of the folder", "--allow-outside"];
    assert!(parts.iter().all(|part| found.contains(part)), "{found}");
    assert_eq!(imported("../rows.txt", true).unwrap().len(), 1);
}

#[test]
fn restrictions_are_constraints() {
    let found = stages(
        "out\n*ObeyRestrictions\n100 1 1\nsd1 + sd2 + sd3 = 0 ! constant p - said so\ned2 - 1.0e+0*ed3 = 0\ned1 = -0.01\ned4 = 0\ned5 = 0\ned6 = 0\n",
    );
    let control = found[0].control;
    assert_eq!(control.components[0], Drive::Ramp(Ramp::By(0.01)));
    assert_eq!(control.components[1], Drive::Free);
    let [first, second] = [0, 1].map(|k| control.constraints[k].unwrap());
    assert_eq!(
        (first.stress, second.strain),
        ([1.0, 1.0, 1.0, 0.0, 0.0, 0.0], [0.0, 1.0, -1.0, 0.0, 0.0, 0.0])
    );
}

/// One period of a sine comes back to where it began, but for the drift.
#[test]
fn circulating_loads_add_up_to_their_drift() {
    let text =
        "out\n*CirculatingLoad\n8 1 1\n*Cartesian\n1 100 0 40\n0 0 0 0\n0 0 0 0\n0 0 0 0\n0 0 0 0\n0 0 0 0\n";
    let found = stages(text);
    let change = |stage: &Stage| match stage.control.components[0] {
        Drive::Stress(target) => target.ramp.map_or(0.0, |ramp| ramp.change(0.0)),
        _ => 0.0,
    };
    let changes: Vec<f64> = found.iter().map(change).collect();
    assert_eq!(changes.len(), 8);
    assert!((changes.iter().sum::<f64>() + 40e3).abs() < 1e-6, "{changes:?}");
    assert!((changes[..2].iter().sum::<f64>() + 110e3).abs() < 1e-6);
}

#[test]
fn what_cannot_be_followed_is_refused_by_name_and_line() {
    for (text, parts) in [
        ("out\n*RandomWalk\n1 1 1\n", &["test.inp:2:1", "*RandomWalk is not supported"][..]),
        ("out\n*Nonsense\n1 1 1\n", &[":2:1", "*Nonsense is not a known keyword"]),
        ("out\n*LinearLoad\n1 1 1\n*Roscoe\n", &[":4:1", "*Roscoe are not supported", "*Cartesian"]),
        ("out\n*LinearLoad\n1 1 1\n*Cartesian\n2 0\n", &[":5:1", "1 (stress) or 0 (strain)"]),
        ("out\n*TriaxialE1\n1 1 1\nx\n", &[":4:1", "is not a number"]),
        ("out\n*TriaxialE1\n1 1 1\n", &[":2:1", "the file ends where a value is needed"]),
        ("out\n*TriaxialE1 ? v3 > 1\n1 1 1\n-0.1\n", &[":2:1", "condition is not supported"]),
        ("out\n*ObeyRestrictions\n1 1 1\nsd1 + q = 0\n", &[":4:1", "is not a term"]),
        ("out\n*ObeyRestrictions\n1 1 1\ned1 + ed2 = 1\n", &[":4:1", "give single strains"]),
        ("out\n", &["has no steps"]),
    ] {
        let found = read(text).unwrap_err().to_string();
        assert!(parts.iter().all(|part| found.contains(part)), "{text}: {found}");
    }
}
