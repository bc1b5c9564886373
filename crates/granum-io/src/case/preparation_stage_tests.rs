//! Tests of the tables `[[preparation.stage]]`.

use granum_dem::loading::preset::{self, Given, PathValue};
use granum_dem::loading::{Drive, Measure, Ramp, RecordedStates, Start, Until};
use proptest::prelude::*;

use super::case_stage::PREPARATION_STAGE;
use super::stage::{RECORDING_KEYS, goes_back, without_recording};
use super::stage_tests::any_stage;
use super::*;

fn parse(text: &str) -> Case {
    Case::parse(text, "case.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

const CONSOLIDATED: &str = r#"
[preparation]
mean_stress = "50 kPa"

[[preparation.stage]]
path = "oedometer"
axial_stress = "200 kPa"
unloading_stress = "100 kPa"

[[preparation.stage]]
repeat = 3

[[preparation.stage.stage]]
name = "small step"
xx = { strain_by = 1e-3 }
until = { ramp_over = true, xx_stress = "1 MPa" }

[[stage]]
path = "drained-triaxial"
"#;

#[test]
fn stages_of_a_preparation_are_read_as_those_of_a_test_and_written_back() {
    let case = parse(CONSOLIDATED);
    let stages = case.sample_stages();
    let names: Vec<&str> = stages.iter().map(|stage| stage.name.as_str()).collect();
    assert_eq!(names, ["loading", "unloading", "small step", "small step", "small step"]);
    assert_eq!(stages[0].until, [Until::Reaches { measure: Measure::Stress(0), value: 200e3 }]);
    assert_eq!(stages[2].control.components[0], Drive::Ramp(Ramp::By(1e-3)));
    assert_eq!((case.test_stages().len(), case.preparation.mean_stress), (1, 50e3));
    assert!(case.check().is_ok());
    let text = case.resolved_toml();
    assert!(text.contains("[[preparation.stage]]") && text.contains("[[preparation.stage.stage]]"), "{text}");
    assert_eq!(parse(&text), case);
    // With the test of the paper as well.
    let (prepared, _) = CONSOLIDATED.split_once("[[stage]]").unwrap();
    let paper = parse(prepared);
    assert!(paper.test.shear().is_some() && paper.check().is_ok());
    assert_eq!(parse(&paper.resolved_toml()), paper);
    let json = serde_json::to_string(&paper).unwrap();
    assert_eq!(serde_json::from_str::<Case>(&json).unwrap(), paper);
    assert!(!serde_json::to_string(&Case::default()).unwrap().contains("preparation_stages"));
}

/// They determine the sample. The digest of a case without them is tested with the published digests.
#[test]
fn stages_of_a_preparation_are_part_of_both_digests_and_of_the_values() {
    let case = parse(CONSOLIDATED);
    let mut bare = case.clone();
    bare.preparation_stages.clear();
    let mut longer = case.clone();
    longer.set("preparation.stage.1.axial_stress", "300 kPa").unwrap();
    for other in [&bare, &longer] {
        assert_ne!(other.digest(), case.digest());
        assert_ne!(other.preparation_digest(), case.preparation_digest());
        let found = differences(&[("one", &case.values()), ("two", &other.values())]);
        assert_eq!(found.iter().map(|f| f.key.as_str()).collect::<Vec<_>>(), ["preparation.stage"]);
    }
    assert!(decides_sample(PREPARATION_STAGE) && !decides_sample("stage"));
    // The same tables as stages of the test are another case.
    let of_test = parse(&CONSOLIDATED.replace("[preparation.", "["));
    assert_ne!(of_test.digest(), case.digest());
    assert!(of_test.preparation_stages.is_empty());
}

/// Mistakes are reported as those of the stages of a test are.
#[test]
fn mistakes_are_told_with_their_place() {
    let stage = |text: &str| format!("[[preparation.stage]]\n{text}");
    for (text, place, parts) in [
        (stage("path = \"oedometr\"\n"), "2:8", &["preparation.stage.1.path", "did you mean oedometer?"][..]),
        (
            stage("path = \"oedometer\"\naxial_stress = \"1 kg\"\n"),
            "3:16",
            &["preparation.stage.1.axial_stress = \"1 kg\" is a mass; it must be a stress"],
        ),
        (
            stage("path = \"oedometer\"\naxial_stres = 1\n"),
            "3:1",
            &["unknown key preparation.stage.1.axial_stres", "did you mean axial_stress?"],
        ),
        (
            stage("path = \"oedometer\"\ninterval = 1e-3\n"),
            "3:1",
            &["preparation.stage.1.interval = 1e-3 has no effect in a preparation", "leave it out"],
        ),
        (
            stage("path = \"drained-triaxial\"\nstates = 5\n"),
            "3:1",
            &["preparation.stage.1.states = 5 has no effect in a preparation"],
        ),
        (
            stage("xx = { strain_to = 0.1 }\nrecord = { every = 1e-3 }\n"),
            "3:1",
            &["preparation.stage.1.record = { every = 1e-3 } has no effect in a preparation"],
        ),
        (
            stage("xx = { strain_to = 0.1 }\nstart = \"kept\"\n"),
            "1:1",
            &["preparation.stage.1 starts from a saved state or saves its start", "[[stage]] of the test"],
        ),
        (stage("xx = { strain_to = 0.1 }\nstart = \"back\"\n"), "1:1", &["starts from a saved state"]),
        (stage("path = \"probes\"\n"), "1:1", &["preparation.stage.1 starts from a saved state"]),
        (
            stage("repeat = 2\n[[preparation.stage.stage]]\npath = \"isotropic\"\nstates = 1\n"),
            "5:1",
            &["preparation.stage.1.1.states"],
        ),
        (
            stage("repeat = 2\n"),
            "1:1",
            &["preparation.stage.1 has no stages to repeat", "[[preparation.stage.stage]]"],
        ),
        (stage("xx = { rate = 1 }\n"), "2:6", &["preparation.stage.1 has no until"]),
        (stage("xx = \"free\"\nuntil = { time = 1 }\n"), "1:1", &["5 equations", "preparation.stage.1"]),
        (
            "[preparation]\nstage = 3\n".to_string(),
            "2:9",
            &[
                "preparation.stage = 3 is not a list of tables",
                "write [[preparation.stage]] with its keys below",
            ],
        ),
        (
            stage(
                "repeat = 9000\n[[preparation.stage.stage]]\nrepeat = 9\n[[preparation.stage.stage.stage]]\npath = \"isotropic\"\n",
            ),
            "1:1",
            &["81000 stages", "at most 10000"],
        ),
    ] {
        let found = Case::parse(&text, "case.toml").unwrap_err().to_string();
        assert!(found.contains(&format!("case.toml:{place}:")), "{text}{found}");
        for part in parts {
            assert!(found.contains(part), "{text}{found}\nwithout {part}");
        }
    }
}

#[test]
fn flags_set_the_parameters_of_these_stages() {
    let mut case = parse(CONSOLIDATED);
    case.set("preparation.stage.1.axial_stress", "0.4 MPa").unwrap();
    case.set("preparation.stage.2.repeat", "2").unwrap();
    assert_eq!(case.sample_stages().len(), 2 + 2);
    assert_eq!(case.sample_stages()[0].until, [Until::Reaches { measure: Measure::Stress(0), value: 4e5 }]);
    let mut refused = |key: &str, text: &str| case.set(key, text).unwrap_err().to_string();
    assert!(refused("preparation.stage.1.interval", "1e-3").contains("has no effect in a preparation"));
    assert!(refused("preparation.stage.1.axial_strss", "1").contains("did you mean axial_stress?"));
    assert!(refused("preparation.stage.3.repeat", "1").contains("the stages 1 to 2"));
    let found = Case::default().set("preparation.stage.1.axial_stress", "1 kPa").unwrap_err().to_string();
    assert!(found.contains("this case has no [[preparation.stage]]"), "{found}");
}

/// Cases that a program builds are checked by the same rules.
#[test]
fn what_a_program_gives_is_checked_as_well() {
    let fault = |stage: CaseStage| {
        let repeated = CaseStage::Repeat { times: 2, stages: vec![stage] };
        let case = Case { preparation_stages: vec![repeated], ..Case::default() };
        case.check().map_err(|error| error.to_string())
    };
    let path = |name: &str, key: &str, value: f64| CaseStage::Path {
        path: preset::named(name).unwrap(),
        parameters: Given::from([(key.to_string(), PathValue::Number(value))]),
        resets: true,
        until: Vec::new(),
    };
    let message = |stage| fault(stage).unwrap_err();
    assert!(fault(path("oedometer", "axial_stress", 1e5)).is_ok());
    let found = message(path("oedometer", "interval", 1e-3));
    assert!(found.starts_with("preparation.stage.1.1.interval has no effect"), "{found}");
    assert!(message(path("oedometer", "axial_stress", -1.0)).contains("preparation.stage.1.1.axial_stress"));
    assert!(message(path("probes", "directions", 3.0)).contains("preparation.stage.1.1 starts from a saved"));
    let stage = preset::named("oedometer").unwrap().expand(&Given::new()).remove(0);
    let control = |stage: granum_dem::loading::Stage| CaseStage::Control(Box::new(stage));
    assert!(message(control(stage.clone())).contains("preparation.stage.1.1.record has no effect"));
    let bare = stage.recording(RecordedStates::default());
    assert!(fault(control(bare.clone())).is_ok());
    assert!(message(control(bare.with(|stage| stage.start = Start::Kept))).contains("starts from a saved"));
}

#[test]
fn steps_of_the_incremental_driver_prepare_a_sample_and_record_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("case.toml");
    let stage = "[[preparation.stage]]\nincremental_driver = \"test.inp\"\nstress_unit = \"1 kPa\"\n";
    std::fs::write(&file, stage).unwrap();
    let write = |steps: &str| std::fs::write(folder.path().join("test.inp"), steps).unwrap();
    write("out\n*Repetition\n1 3\n*TriaxialE1\n1 1 1\n-0.01\n*End\n");
    let case = Case::read(&file).unwrap();
    let stages = case.sample_stages();
    assert!(stages.len() == 3 && stages.iter().all(|stage| stage.record == RecordedStates::default()));
    assert_eq!(parse(&case.resolved_toml()), case);
    std::fs::write(&file, format!("{stage}interval = 1e-3\n")).unwrap();
    let found = Case::read(&file).unwrap_err().to_string();
    assert!(found.contains("case.toml:4:1: preparation.stage.1.interval = 1e-3 has no effect"), "{found}");
    std::fs::write(&file, stage).unwrap();
    write("out\n*PerturbationsE\n8 1 1\n*Rendulic\n1e-5\n*End\n");
    let found = Case::read(&file).unwrap_err().to_string();
    assert!(found.contains("preparation.stage.1 starts from a saved state"), "{found}");
}

/// The stage without what it records; `None` if it needs a saved state.
fn unrecorded(stage: CaseStage) -> Option<CaseStage> {
    if goes_back(&stage) {
        return None;
    }
    Some(match without_recording(stage) {
        CaseStage::Path { path, mut parameters, resets, until } => {
            RECORDING_KEYS.iter().for_each(|key| drop(parameters.remove(*key)));
            CaseStage::Path { path, parameters, resets, until }
        }
        CaseStage::Repeat { times, stages } => {
            CaseStage::Repeat { times, stages: stages.into_iter().map(unrecorded).collect::<Option<_>>()? }
        }
        stage => stage,
    })
}

proptest! {
    // Most stresses drawn at random are too large for the grains and are refused.
    #![proptest_config(ProptestConfig { max_global_rejects: 100_000, ..ProptestConfig::default() })]
    #[test]
    fn they_read_back_as_the_same_case(stages in proptest::collection::vec(any_stage(), 1..4)) {
        let stages: Option<Vec<CaseStage>> = stages.into_iter().map(unrecorded).collect();
        prop_assume!(stages.is_some());
        let case = Case { preparation_stages: stages.unwrap_or_default(), ..Case::default() };
        prop_assume!(case.check().is_ok());
        let text = case.resolved_toml();
        let back = parse(&text);
        prop_assert_eq!(&back, &case, "{}", text);
        prop_assert_eq!(back.preparation_digest(), case.preparation_digest());
    }
}
