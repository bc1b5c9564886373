//! Tests of the tables `[[stage]]`.

use granum_dem::loading::preset::{self, Given, PathParameterKind, PathValue};
use granum_dem::loading::{
    Drive, History, HistoryQuantity, Kinematics, Measure, Ramp, Speed, Start, Target, Until,
};
use proptest::prelude::*;

use super::case_stage::driven;
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

/// A named path can also end at what `until` says, beside its own end: an undrained test at a stress.
#[test]
fn a_named_path_ends_at_a_stress_as_well() {
    let text = "[[stage]]\npath = 'undrained-triaxial'\nmean_stress = '100 kPa'\naxial_strain = 0.1\nuntil = { mean_stress = '10 kPa' }\n";
    let case = parse(text);
    let stages = case.test_stages();
    let at_strain = Until::Reaches { measure: Measure::Strain(0), value: 0.1 };
    let at_stress = Until::Reaches { measure: Measure::MeanStress, value: 1e4 };
    assert_eq!(stages[1].until, [at_strain, at_stress]);
    assert_eq!(stages[0].until.len(), 1, "the sample comes to rest as before");
    assert_eq!(parse(&case.resolved_toml()), case);
    let bare = parse(&text.replace("until = { mean_stress = '10 kPa' }\n", ""));
    assert!(bare.digest() != case.digest() && !bare.resolved_toml().contains("until"));
    assert!(case.parameters().iter().any(|refusal| refusal.key == "stage.1.until.mean_stress"));
    let several =
        "[[stage]]\npath = 'oedometer'\nunloading_stress = '10 kPa'\nuntil = { mean_stress = '10 kPa' }\n";
    let refusal = message(several);
    assert!(refusal.contains("case.toml:4:1") && refusal.contains("several stages"), "{refusal}");
    let refusal = message(&text.replace("mean_stress = '10 kPa'", "mean_stres = '10 kPa'"));
    assert!(refusal.contains("did you mean mean_stress"), "{refusal}");
}

/// A case as deep as it may be can be written and read again; a deeper one is refused.
#[test]
fn repetitions_have_a_largest_depth() {
    let nested = |depth: usize| {
        let mut text = String::new();
        for level in 1..=depth {
            text += &format!("[[{}]]\nrepeat = 1\n", vec!["stage"; level].join("."));
        }
        text + &format!("[[{}]]\npath = \"hold\"\n", vec!["stage"; depth + 1].join("."))
    };
    let case = Case::parse(&nested(32), "case.toml").unwrap();
    assert_eq!(Case::parse(&case.readable_toml(None).unwrap(), "case.toml").unwrap(), case);
    let error = Case::parse(&nested(33), "case.toml").unwrap_err().to_string();
    let wanted = "case.toml:1:1: this stage has 33 repetitions within one another; at most 32 are possible";
    assert!(error.starts_with(wanted), "{error}");
    let inner = case.test.tables().to_vec();
    let deeper = Case::default().with_stages(vec![CaseStage::Repeat { times: 1, stages: inner }]);
    assert!(deeper.check().unwrap_err().to_string().contains("stage.1 has 33 repetitions"));
    assert!(deeper.readable_toml(None).is_err());
}

#[test]
fn stages_are_read_as_paths_and_written_out() {
    let case = parse(WRITTEN_OUT);
    let stages = case.test_stages();
    assert_eq!(stages.len(), 2);
    let shear = &stages[1];
    assert_eq!(shear.control.speed, Speed::StrainRate(2e-3));
    assert_eq!(shear.control.components[0], Drive::Rate(1.0));
    assert_eq!(shear.control.components[1], Drive::Stress(Target::held(1e5).moving(1e3)));
    assert_eq!(shear.control.components[5], Drive::Stress(Target::default()));
    assert_eq!(shear.control.kinematics, Kinematics::SimpleShear);
    assert!(shear.until.contains(&Until::Reaches { measure: Measure::MeanStress, value: 5e3 }));
    let critical = Until::CriticalState { window: 0.02, stress_ratio: 0.02, volumetric_strain: 0.002 };
    assert!(shear.until.contains(&critical));
    assert_eq!(parse(&case.resolved_toml()), case);
    assert!(!case.resolved_toml().contains("[shear]"));
}

/// A new case file has every key at its default; stages can be added to it as it is.
#[test]
fn stages_can_be_added_to_a_new_case_file() {
    let stage = "[[stage]]\npath = \"isotropic\"\n";
    let added = Case::parse(&format!("{}\n{stage}", Case::template()), "case.toml").unwrap();
    assert_eq!(added, Case::parse(stage, "case.toml").unwrap());
    // What differs from the default would be ignored, and is refused.
    let changed = Case::template().replace("deviator_strain = 0.3", "deviator_strain = 0.2");
    let error = Case::parse(&format!("{changed}\n{stage}"), "case.toml").unwrap_err().to_string();
    assert!(error.contains("shear.deviator_strain has no effect in a case with [[stage]]"), "{error}");
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

/// Every mistake is reported with its position, the key, the value, and what would be right.
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
            &["the speed of the stage is already given", "multiple"],
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
            &["has no effect in a case with [[stage]]"],
        ),
        (
            "[recording]\nstates = 3\n[[stage]]\npath = \"isotropic\"\n",
            "2:1",
            &["recording.states has no effect"],
        ),
        ("stage = 3\n", "1:9", &["is not a list of tables", "[[stage]]"]),
        (
            "[[stage]]\nrepeat = 2\n[[stage.stage]]\npath = \"isotropic\"\nmean_stres = 1\n",
            "5:1",
            &["unknown key stage.1.1.mean_stres"],
        ),
        ("[[stage]]\nrepeat = 2\n", "1:1", &["stage.1 has no stages to repeat", "[[stage.stage]]"]),
        (
            "[[stage]]\nrepeat = 1.5\n[[stage.stage]]\npath = \"isotropic\"\n",
            "2:10",
            &["is not a whole number"],
        ),
        (
            "[[stage]]\nrepeat = 9000\n[[stage.stage]]\nrepeat = 9\n[[stage.stage.stage]]\npath = \"isotropic\"\n",
            "1:1",
            &["81000 stages", "at most 10000"],
        ),
        (
            "[[stage]]\nrepeat = 2\nxx = \"free\"\n[[stage.stage]]\npath = \"isotropic\"\n",
            "3:1",
            &["stage.1.xx"],
        ),
        (
            "[[stage]]\npath = \"cyclic\"\ndrainage = \"dry\"\n",
            "3:12",
            &["is not known", "undrained, drained"],
        ),
        ("[[stage]]\npath = \"unload-reload\"\nat = [0.02, 0.01]\n", "3:6", &["does not increase"]),
        ("[[stage]]\npath = \"unload-reload\"\nat = 3\n", "3:6", &["is not a list of numbers"]),
        ("[[stage]]\npath = \"history\"\n", "1:1", &["stage.1 has no history", "file ="]),
        ("[[stage]]\npath = \"history\"\nfile = \"not-there.csv\"\n", "3:8", &["cannot read not-there.csv"]),
        (
            "[[stage]]\npath = \"history\"\ncolumns = [\"xx_strain\"]\nrows = [[1], [1, 2]]\n",
            "4:8",
            &["a row 2 without a finite number for each"],
        ),
        (
            "[[stage]]\npath = \"plane-strain\"\ndensity_scaling = 1e12\n",
            "3:1",
            &["density_scaling has no effect without strain_rate"],
        ),
        (
            "[[stage]]\npath = \"plane-strain\"\nstrain_rate = 1\ninertial_number = 1e-3\n",
            "3:1",
            &["strain_rate and inertial_number both set the speed"],
        ),
        (
            "[[stage]]\nxx = { rate = 1 }\nuntil = { time = 1 }\ndensity_scaling = 4\n",
            "4:19",
            &["has no effect without strain_rate"],
        ),
        ("[[stage]]\nxx = { strain_to = 1, rate = 1 }\n", "2:6", &["a ramp starts from the present value"]),
        ("[[stage]]\nxx = { strain_to = 1 }\nstart = \"back\"\n", "1:1", &["stage.1 goes back", "kept"]),
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
    assert!(found.contains("is not a parameter of the path isotropic"), "{found}");
    let mut set = |key: &str, text: &str| other.set(key, text).unwrap_err().to_string();
    assert!(set("stage.2.axial_strain", "1").contains("the stages 1 to 1"));
    assert!(set("stage.1.axial_strian", "1").contains("did you mean axial_strain?"));
    assert!(set("shear.deviator_strain", "1").contains("has no effect in a case with stages"));
}

const NESTED: &str = r#"
[[stage]]
path = "isotropic"
mean_stress = "50 kPa"
[[stage]]
repeat = 3
[[stage.stage]]
path = "drained-triaxial"
axial_strain = 0.01
resets = false
[[stage.stage]]
repeat = 2
[[stage.stage.stage]]
name = "small step"
xx = { strain_by = 1e-3 }
yy = { stress_to = "60 kPa" }
zz = "free"
constraint = [{ stress = [0, 1, -1, 0, 0, 0], value_to = "1 kPa" }]
"#;

#[test]
fn stages_nest_and_repeat() {
    let case = parse(NESTED);
    let stages = case.test_stages();
    let names: Vec<&str> = stages.iter().map(|stage| stage.name.as_str()).collect();
    let round = ["shear", "small step", "small step"];
    assert_eq!(names, [&["isotropic"], &round[..], &round, &round].concat());
    assert!(stages[0].resets && !stages[1].resets);
    let step = &stages[2];
    assert_eq!(step.until, [Until::RampOver]);
    assert_eq!(step.control.components[0], Drive::Ramp(Ramp::By(1e-3)));
    assert_eq!(step.control.components[1], Drive::Stress(Target::ramp(Ramp::To(60e3))));
    assert_eq!(parse(&case.resolved_toml()), case);
    let mut other = case.clone();
    other.set("stage.2.1.axial_strain", "0.02").unwrap();
    other.set("stage.2.repeat", "5").unwrap();
    assert_eq!(other.test_stages().len(), 1 + 5 * 3);
    assert_ne!(other.digest(), case.digest());
    let say = |key: &str| other.clone().set(key, "1").unwrap_err().to_string();
    assert!(say("stage.2.3.axial_strain").contains("is not a key of a stage"));
    assert!(say("stage.2.1.axial_strian").contains("did you mean axial_strain?"));
    assert!(say("stage.2.axial_strain").contains("it has repeat"));
}

/// A history is read from its file once and is then part of the case; mistakes are reported with their positions in the file.
#[test]
fn a_history_comes_from_a_file_beside_the_case() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("case.toml");
    std::fs::write(&file, "[[stage]]\npath = \"history\"\nfile = \"element.csv\"\n").unwrap();
    let write = |text: &str| std::fs::write(folder.path().join("element.csv"), text).unwrap();
    write("xx_strain (%),yy_stress (kPa)\n0,100\n0.5,110\n");
    let case = Case::read(&file).unwrap();
    assert_eq!(case.test_stages().len(), 2 + 1);
    let text = case.resolved_toml();
    assert!(text.contains("[0.005, 110000],") || text.contains("[0.005, 1.1e5],"), "{text}");
    assert_eq!(parse(&text), case);
    write("xx_strain,yy_stress\n0,x\n");
    let found = Case::read(&file).unwrap_err().to_string();
    assert!(found.contains("element.csv:2:3: yy_stress = \"x\" is not a number"), "{found}");
    // A flag names the file as the shell sees it.
    write("xx_strain\n0.1\n");
    let file = folder.path().join("element.csv").display().to_string();
    let case = Case::default().with_path("history", &[("file", &file)]).unwrap();
    assert!(case.check().is_ok() && case.test_stages().len() == 2);
    let bare = Case::default().with_path("history", &[]).unwrap();
    assert!(bare.check().unwrap_err().to_string().contains("file must be given"));
}

/// The steps of a file of the IncrementalDriver become stages of the case, which then needs the file no more.
#[test]
fn steps_of_the_incremental_driver_become_stages() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("case.toml");
    let stage = "[[stage]]\nincremental_driver = \"test.inp\"\nstress_unit = \"1 kPa\"\n";
    std::fs::write(&file, stage).unwrap();
    let steps =
        "out\n*Repetition\n1 3\n*TriaxialE1\n1 1 1\n-0.01\n*PerturbationsE\n8 1 1\n*Rendulic\n1e-5\n*End\n";
    std::fs::write(folder.path().join("test.inp"), steps).unwrap();
    let case = Case::read(&file).unwrap();
    assert_eq!(case.test_stages().len(), 3 + 1 + 2 * 8);
    assert_eq!(parse(&case.resolved_toml()), case);
    std::fs::write(folder.path().join("test.inp"), "out\n*RandomWalk\n").unwrap();
    let found = Case::read(&file).unwrap_err().to_string();
    assert!(found.contains("test.inp:2:1: *RandomWalk is not supported"), "{found}");
    let found = message("[[stage]]\nincremental_driver = \"test.inp\"\n");
    assert!(found.contains("case.toml:1:1") && found.contains("stress_unit"), "{found}");
}

/// The examples of the book can be run as they are.
#[test]
fn examples_of_the_book_are_cases() {
    let book = [include_str!("../../../../docs/src/case.md"), include_str!("../../../../docs/src/howto.md")]
        .concat();
    let blocks = book.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next());
    let stages: Vec<&str> = blocks
        .filter(|block| block.contains("[[stage]]") || block.contains("[[preparation.stage]]"))
        .collect();
    assert_eq!(stages.len(), 7);
    for text in stages {
        assert!(parse(text).check().is_ok(), "{text}");
    }
}

/// A random stage that is a path with some of its parameters.
fn any_path() -> impl Strategy<Value = CaseStage> {
    let draws = proptest::collection::vec((any::<bool>(), 0.0..1.0f64), 16);
    (0..preset::ALL.len(), draws, any::<bool>()).prop_map(|(which, draws, resets)| {
        let path = &preset::ALL[which];
        let mut parameters = Given::new();
        for (parameter, (given, place)) in path.parameters().zip(draws) {
            // Stresses that press the grains into each other are refused, and most of what the bounds allow would do so.
            let most = if parameter.unit == "Pa" { 1e8 } else { f64::INFINITY };
            let [low, high] = parameter.bounds.map(|bound| bound.clamp(-most, most));
            let number = (low + place * (high - low)).clamp(low, high);
            let value = match parameter.kind {
                PathParameterKind::History => {
                    let columns = vec![HistoryQuantity::Strain(0), HistoryQuantity::Stress(5)];
                    PathValue::History(History { columns, rows: vec![vec![0.1 * place, -1e5 * place]; 2] })
                }
                _ if !given || ["strain_rate", "density_scaling"].contains(&parameter.key) => continue,
                PathParameterKind::Number => PathValue::Number(number.floor().max(low)),
                PathParameterKind::Word(words) => {
                    PathValue::Word(words[(place * words.len() as f64) as usize][0].into())
                }
                PathParameterKind::List => PathValue::List(vec![0.1 * place, 0.1 + place]),
            };
            parameters.insert(parameter.key.to_string(), value);
        }
        // The two ways to say how fast exclude each other.
        if resets && !parameters.contains_key("inertial_number") {
            parameters.insert("strain_rate".into(), PathValue::Number(1e-5));
            parameters.insert("density_scaling".into(), PathValue::Number(1e12));
        }
        while let Some((key, _)) = path.fault(&parameters) {
            // A default can be what does not go with a given value.
            if parameters.remove(key).is_none() {
                parameters.clear();
            }
        }
        let ends =
            vec![Until::Reaches { measure: Measure::MeanStress, value: 5e3 }, Until::PorePressureRatio(0.9)];
        let until = if resets && driven(&path.expand(&parameters)).is_some() { ends } else { Vec::new() };
        CaseStage::Path { path, parameters, resets, until }
    })
}

/// Parameters of a path that exclude each other, or that would let it end where it begins.
#[test]
fn parameters_that_do_not_go_together_are_refused() {
    let refused = |path: &str, keys: &str, wanted: &str| {
        let text = message(&format!("[[stage]]\npath = \"{path}\"\n{keys}"));
        assert!(text.contains(wanted), "{path}: {text}");
    };
    refused("drained-triaxial", "axial_strain = 0", "axial_strain must not be 0");
    refused("constant-p", "deviator_strain = 0", "deviator_strain must not be 0");
    refused("constant-p", "states = 7.5", "states = 7.5 must be a whole number");
    refused("probes", "directions = 7.9", "directions = 7.9 must be a whole number");
    refused("probes", "strain = 1e-5\nstress = \"1 kPa\"", "strain has no effect with stress");
    refused(
        "oedometer",
        "axial_stress = \"1 MPa\"\nunloading_stress = \"2 MPa\"",
        "must be below axial_stress",
    );
    refused(
        "cyclic",
        "strain_amplitude = 1e-3\nstress_amplitude = \"1 kPa\"",
        "strain_amplitude has no effect with",
    );
    refused(
        "cyclic",
        "drainage = \"drained\"\npore_pressure_ratio = 0.9",
        "pore_pressure_ratio has no effect with",
    );
    refused(
        "hold",
        "duration = \"1 s\"\nunbalanced_force = 1e-3",
        "unbalanced_force has no effect with duration",
    );
}

/// Along a short line the mean stress changes much with the strain; what a stage of it says is read again.
#[test]
fn a_mean_stress_that_moves_steeply_with_the_strain_is_read_again() {
    let path = "path = \"random\"\ndrainage = \"moving\"\namplitude = 1e-6\nlength = 2e-6\nmean_stress = \"1 MPa\"\nhighest_mean_stress = \"60 MPa\"";
    let case = parse(&format!("[[stage]]\n{path}\n"));
    let steep = |stage: &granum_dem::loading::Stage| {
        let constraint = stage.control.constraints[2].filter(|held| held.stress != [0.0; 6]);
        constraint.is_some_and(|held| held.strain.iter().any(|weight| weight.abs() > 1e12))
    };
    let mut stages = case.test_stages();
    stages.retain(steep);
    assert!(!stages.is_empty());
    let written = stages.into_iter().map(|mut stage| {
        stage.start = Start::Here;
        CaseStage::Control(Box::new(stage))
    });
    let case = Case::default().with_stages(written.collect());
    assert!(case.check().is_ok());
    assert_eq!(parse(&case.resolved_toml()), case);
}

/// A random stage with an explicit control, taken from the expansion of a path.
fn any_written_out() -> impl Strategy<Value = CaseStage> {
    (any_path(), any::<prop::sample::Index>(), "[ -~]{0,12}").prop_map(|(path, index, name)| {
        let mut stages = path.stages();
        let mut stage = stages.swap_remove(index.index(stages.len()));
        stage.name = name;
        // A stage that starts from a saved state needs a stage before it that saved one.
        stage.start = Start::Here;
        // In a case file the mean stress for an inertial number is that of the state of the sample.
        if let Speed::InertialNumber { number, .. } = stage.control.speed {
            stage.control.speed = Speed::InertialNumber { number, at: None };
        }
        CaseStage::Control(Box::new(stage))
    })
}

/// A stage of any kind.
pub(super) fn any_stage() -> impl Strategy<Value = CaseStage> {
    prop_oneof![any_path(), any_written_out()].prop_recursive(2, 8, 3, |inner| {
        let stages = proptest::collection::vec(inner, 1..3);
        (1..5u64, stages).prop_map(|(times, stages)| CaseStage::Repeat { times, stages })
    })
}

proptest! {
    #[test]
    fn stages_read_back_as_the_same_case(stages in proptest::collection::vec(any_stage(), 1..4)) {
        let case = Case::default().with_stages(stages);
        // The columns of a random history may depend on each other, which is refused.
        prop_assume!(case.check().is_ok());
        let text = case.resolved_toml();
        let back = parse(&text);
        prop_assert_eq!(&back, &case, "{}", text);
        prop_assert_eq!(back.digest(), case.digest());
    }

    #[test]
    fn no_stage_makes_the_reader_panic(text in "(path|xx|xy|until|constraint|record|turns|rate|stress|name|repeat|stage|rows|columns|start|resets) = (\"[ -~]{0,9}\"|[0-9e.-]{1,6}|\\[1, 2\\]|\\{ (rate|stress|measure|every|at) = [0-9\"a-z\\[\\]]{1,6} \\})") {
        let _ = Case::parse(&format!("[[stage]]\n{text}\n"), "case.toml");
    }
}

/// Keys of stages and of other sections are found where they belong.
#[test]
fn a_key_without_its_place_is_found_in_the_stages_of_the_case() {
    let mut case = parse(
        "[[stage]]\npath = \"isotropic\"\n[[stage]]\nrepeat = 2\n[[stage.stage]]\npath = \"drained-triaxial\"\n",
    );
    let mut set = |key: &str| case.set(key, "1").unwrap_err().to_string();
    assert!(set("lateral_stress").contains("did you mean stage.2.1.lateral_stress?"));
    assert!(set("stress.lateral_stress").contains("did you mean stage.2.1.lateral_stress?"));
    assert!(set("lateral_stres").contains("did you mean stage.2.1.lateral_stress?"));
    assert!(set("friction").contains("did you mean grains.material.friction or preparation.friction?"));
    assert!(
        set("shear_strain")
            .contains("parameter of the path \"simple-shear\" or \"simple-shear-constant-volume\"")
    );
    assert!(set("shear_strain").contains("--path NAME --with shear_strain=VALUE"));
    assert!(
        set("mean_stress").contains("preparation.mean_stress, shear.mean_stress or stage.1.mean_stress?")
    );
    let found = message("lateral_stress = 1e5\n");
    assert!(
        found.contains("lateral_stress belongs to a [[stage]] with path = \"drained-triaxial\""),
        "{found}"
    );
    let found = message("[[stage]]\nlateral_stress = 1e5\nuntil = { xx_strain = 0.1 }\n");
    assert!(found.contains("lateral_stress belongs to a stage with path ="), "{found}");
}
