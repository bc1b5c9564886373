//! Tests of the tables `[[stage]]`.

use granum_dem::loading::preset;
use granum_dem::loading::{Drive, Kinematics, Measure, Speed, Target, Until};
use proptest::prelude::*;

use super::*;

fn parse(text: &str) -> Case {
    Case::parse(text, "case.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn message(text: &str) -> String {
    Case::parse(text, "case.toml").unwrap_err().to_string()
}

const WRITTEN_OUT: &str = r#"
[[stage]]
path = "isotropic"
mean_stress = "50 kPa"

[[stage]]
name = "shear"
xx = { rate = "2e-3 /s" }
yy = { stress = "100 kPa", stress_rate = "1 kPa/s" }
zz = "free"
xy = { stress = "current" }
constraint = [{ stress = [0, 1, -1, 0, 0, 0], value = 0 }]
kinematics = "simple-shear"
until = { xx_strain = 0.2, mean_stress = "5 kPa", reversals = 4, unbalanced_force = 1e-4, critical_state = { window = 0.02 } }
turns = { measure = "xx_strain", high = 0.1, low = -0.1 }
record = { measure = "arc_length", every = 1e-3 }
"#;

#[test]
fn stages_are_read_as_paths_and_written_out() {
    let case = parse(WRITTEN_OUT);
    let stages = case.test_stages();
    assert_eq!(stages.len(), 2);
    let shear = &stages[1];
    assert_eq!(shear.control.speed, Speed::StrainRate(2e-3));
    assert_eq!(shear.control.components[0], Drive::Rate(1.0));
    assert_eq!(shear.control.components[1], Drive::Stress(Target { value: Some(1e5), rate: 1e3 }));
    assert_eq!(shear.control.components[5], Drive::Stress(Target::default()));
    assert_eq!(shear.control.kinematics, Kinematics::SimpleShear);
    assert!(shear.until.contains(&Until::Reaches { measure: Measure::MeanStress, value: 5e3 }));
    let critical = Until::CriticalState { window: 0.02, stress_ratio: 0.02, volumetric_strain: 0.002 };
    assert!(shear.until.contains(&critical));
    assert_eq!(parse(&case.resolved_toml()), case);
    assert!(!case.resolved_toml().contains("[shear]"));
}

#[test]
fn stages_are_part_of_the_digest_and_the_values_only_where_there_are_any() {
    let case = parse(WRITTEN_OUT);
    assert_ne!(case.digest(), Case::default().digest());
    assert_eq!(case.preparation_digest(), Case::default().preparation_digest());
    let longer = parse(&WRITTEN_OUT.replace("xx_strain = 0.2", "xx_strain = 0.3"));
    assert_ne!(longer.digest(), case.digest());
    let found = differences(&[("one", &case.values()), ("two", &longer.values())]);
    assert_eq!(found.iter().map(|f| f.key.as_str()).collect::<Vec<_>>(), ["stage"]);
    assert!(!Case::default().values().contains_key("stage"));
}

/// Every mistake has its place, the key, the value, and what would be right.
#[test]
fn mistakes_are_told_with_their_place() {
    for (text, place, parts) in [
        ("[[stage]]\npath = \"drained-triaxal\"\n", "2:8", &["did you mean drained-triaxial?"][..]),
        (
            "[[stage]]\npath = \"isotropic\"\nmean_stres = 1\n",
            "3:1",
            &["unknown key stage.1.mean_stres", "did you mean mean_stress?"],
        ),
        (
            "[[stage]]\npath = \"drained-triaxial\"\nlateral_stress = \"1 kg\"\n",
            "3:18",
            &["stage.1.lateral_stress = \"1 kg\" is a mass; it must be a stress"],
        ),
        (
            "[[stage]]\npath = \"drained-triaxial\"\naxial_strain = 7\n",
            "3:16",
            &["stage.1.axial_strain = 7 is out of bounds; it must be from -3 to 3"],
        ),
        ("[[stage]]\nxx = { rate = 1 }\n", "2:6", &["stage.1 has no until", "e.g. until"]),
        ("[[stage]]\nxx = { rat = 1 }\nuntil = { time = 1 }\n", "2:8", &["did you mean rate?"]),
        ("[[stage]]\nxx = \"loose\"\nuntil = { time = 1 }\n", "2:6", &["\"fixed\", \"free\""]),
        (
            "[[stage]]\ninertial_number = 1e-3\nxx = { rate = \"1 /s\" }\nuntil = { time = 1 }\n",
            "3:6",
            &["the stage says how fast", "multiple"],
        ),
        ("[[stage]]\nxx = \"free\"\nuntil = { time = \"1 s\" }\n", "1:1", &["5 equations", "stage.1"]),
        ("[[stage]]\nxx = { rate = 1 }\nuntil = { xx_strian = 1 }\n", "3:23", &["did you mean xx_strain?"]),
        (
            "[[stage]]\nxx = \"free\"\nconstraint = [{ stress = [1, 1] }]\nuntil = { time = 1 }\n",
            "3:26",
            &["six numbers"],
        ),
        (
            "[[stage]]\nxx = { rate = 1 }\nuntil = { xx_strain = 1 }\nrecord = { states = 3 }\n",
            "4:10",
            &["give every, or states and end"],
        ),
        (
            "[[stage]]\npath = \"isotropic\"\n[shear]\ndeviator_strain = 0.1\n",
            "4:1",
            &["has no part in a case with [[stage]]"],
        ),
        (
            "[recording]\nstates = 3\n[[stage]]\npath = \"isotropic\"\n",
            "2:1",
            &["recording.states has no part"],
        ),
        ("stage = 3\n", "1:9", &["is no list of tables", "[[stage]]"]),
    ] {
        let found = message(text);
        assert!(found.contains(&format!("case.toml:{place}:")), "{text}{found}");
        for part in parts {
            assert!(found.contains(part), "{text}{found}\nwithout {part}");
        }
    }
}

#[test]
fn several_mistakes_are_told_at_once() {
    let found = message("[[stage]]\npath = \"isotropic\"\nmean_stress = 1e99\ninertial_number = \"x\"\n");
    assert!(found.contains("stage.1.mean_stress") && found.contains("stage.1.inertial_number"), "{found}");
}

#[test]
fn flags_take_a_path_and_set_its_parameters() {
    let case = Case::default().with_path("drained-triaxial", &[("axial_strain", "5 %")]).unwrap();
    let mut other = case.clone();
    other.set("stage.1.axial_strain", "0.05").unwrap();
    assert_eq!(case, other);
    let say = |error: crate::Result<Case>| error.unwrap_err().to_string();
    let found = say(Case::default().with_path("drained", &[]));
    assert!(found.contains("did you mean drained-triaxial?"), "{found}");
    let found = say(Case::default().with_path("isotropic", &[("axial_strain", "1")]));
    assert!(found.contains("is no parameter of the path isotropic"), "{found}");
    let mut set = |key: &str, text: &str| other.set(key, text).unwrap_err().to_string();
    assert!(set("stage.2.axial_strain", "1").contains("the stages 1 to 1"));
    assert!(set("stage.1.axial_strian", "1").contains("did you mean axial_strain?"));
    assert!(set("shear.deviator_strain", "1").contains("has no part in a case with stages"));
}

/// What the book shows can be run as it stands.
#[test]
fn examples_of_the_book_are_cases() {
    let book = [include_str!("../../../../docs/src/case.md"), include_str!("../../../../docs/src/howto.md")]
        .concat();
    let blocks = book.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next());
    let stages: Vec<&str> = blocks.filter(|block| block.contains("[[stage]]")).collect();
    assert_eq!(stages.len(), 3);
    for text in stages {
        assert!(parse(text).check().is_ok(), "{text}");
    }
}

/// A random stage that is a path with some of its parameters.
fn any_path() -> impl Strategy<Value = CaseStage> {
    let draws = proptest::collection::vec((any::<bool>(), 0.0..1.0f64), 8);
    (0..preset::ALL.len(), draws).prop_map(|(which, draws)| {
        let path = &preset::ALL[which];
        let parameters = path.parameters.iter().zip(draws).filter(|(_, (given, _))| *given);
        let value = |[low, high]: [f64; 2], place: f64| (low + place * (high - low)).clamp(low, high);
        CaseStage::Path {
            name: path.name.to_string(),
            parameters: parameters
                .map(|(p, (_, place))| (p.key.to_string(), value(p.bounds, place)))
                .collect(),
        }
    })
}

/// A stage that a path comes to is as good an example of one that is written out as any.
fn any_written_out() -> impl Strategy<Value = CaseStage> {
    (any_path(), any::<prop::sample::Index>(), "[ -~]{0,12}").prop_map(|(path, index, name)| {
        let mut stages = path.stages();
        let mut stage = stages.swap_remove(index.index(stages.len()));
        stage.name = name;
        // The mean stress of an inertial number is said by the state of the sample in a case file.
        if let Speed::InertialNumber { number, .. } = stage.control.speed {
            stage.control.speed = Speed::InertialNumber { number, at: None };
        }
        CaseStage::Control(Box::new(stage))
    })
}

proptest! {
    #[test]
    fn stages_read_back_as_the_same_case(stages in proptest::collection::vec(prop_oneof![any_path(), any_written_out()], 1..4)) {
        let case = Case { stages, ..Case::default() };
        prop_assert!(case.check().is_ok());
        let text = case.resolved_toml();
        let back = parse(&text);
        prop_assert_eq!(&back, &case, "{}", text);
        prop_assert_eq!(back.digest(), case.digest());
    }

    #[test]
    fn no_stage_makes_the_reader_panic(text in "(path|xx|xy|until|constraint|record|turns|rate|stress|name) = (\"[ -~]{0,9}\"|[0-9e.-]{1,6}|\\[1, 2\\]|\\{ (rate|stress|measure|every|at) = [0-9\"a-z\\[\\]]{1,6} \\})") {
        let _ = Case::parse(&format!("[[stage]]\n{text}\n"), "case.toml");
    }
}
