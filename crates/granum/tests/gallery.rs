//! Every ready case, small: does it show what it says?

#[path = "common/mod.rs"]
mod common;

use common::{json, run, stderr, stdout};
use granum::gallery::{CASES, ReadyCase};
use granum_io::Case;
use granum_run::Laboratory;
use granum_run::RunResult;

/// A ready case with fewer grains, faster, and with keys changed.
fn small(name: &str, changes: &[(&str, &str)]) -> Case {
    let ready = ReadyCase::named(name).unwrap();
    let mut case = Case::parse(ready.text, name).unwrap();
    case.set("grains.count", "300").unwrap();
    case.set("preparation.inertial_number", "5e-3").unwrap();
    case.set("preparation.unbalanced_force", "5e-3").unwrap();
    for (key, value) in changes {
        case.set(key, value).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
    case
}

fn test(case: &Case) -> RunResult {
    Laboratory::here().test(case).unwrap_or_else(|error| panic!("{error}"))
}

/// A column of the last stage.
fn column(test: &RunResult, name: &str) -> Vec<f64> {
    let series = &test.record.series;
    let values = series.values(name).unwrap_or_else(|| panic!("no column {name}"));
    let Some(stages) = series.values("stage") else { return values.to_vec() };
    let last = stages[stages.len() - 1];
    values.iter().zip(stages).filter(|(_, stage)| **stage == last).map(|(value, _)| *value).collect()
}

fn last(test: &RunResult, name: &str) -> f64 {
    *column(test, name).last().unwrap()
}

/// Mean over the last fifth of the states.
fn late(test: &RunResult, name: &str) -> f64 {
    let values = column(test, name);
    let from = values.len() - values.len().div_ceil(5);
    values[from..].iter().sum::<f64>() / (values.len() - from) as f64
}

fn peak(test: &RunResult, name: &str) -> f64 {
    column(test, name).into_iter().fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn every_case_is_read_and_has_a_title() {
    for ready in CASES {
        let case = Case::parse(ready.text, ready.name).unwrap_or_else(|error| panic!("{error}"));
        case.check().unwrap();
        assert!(ready.title().len() > 30 && ready.title().ends_with('.'), "{}", ready.name);
        assert_eq!(CASES.iter().filter(|other| other.name == ready.name).count(), 1);
        assert_eq!(granum_run::engine::foreseen_failures(&case), [], "{}: a check must fail", ready.name);
    }
    assert_eq!(Case::parse(ReadyCase::named("paper").unwrap().text, "paper").unwrap(), Case::default());
}

/// The book shows every case, with its picture.
#[test]
fn every_case_has_a_section_and_a_picture_in_the_book() {
    let book = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/src/");
    let page = std::fs::read_to_string(format!("{book}gallery.md")).unwrap();
    for ready in CASES {
        assert!(page.contains(&format!("granum init --case {}", ready.name)), "{}", ready.name);
        let section = page
            .lines()
            .find(|line| line.starts_with("![") && line.contains(&format!("gallery-{}", ready.name)));
        let line = section.unwrap_or_else(|| panic!("no picture of {}", ready.name));
        let file = line.split('(').nth(1).unwrap().trim_end_matches(')');
        assert!(std::path::Path::new(&format!("{book}{file}")).is_file(), "{file}");
    }
}

const DENSE: &[(&str, &str)] =
    &[("stage.1.axial_strain", "0.2"), ("stage.1.inertial_number", "3e-3"), ("stage.1.states", "40")];

/// Dense sand has a peak and dilates, loose sand contracts without a peak, and both end at one strength and one density.
#[test]
fn drained_samples_meet_at_the_critical_state() {
    let far =
        [("stage.1.axial_strain", "0.35"), ("stage.1.inertial_number", "3e-3"), ("stage.1.states", "60")];
    let [dense, loose] = ["drained-dense", "drained-loose"].map(|name| test(&small(name, &far)));
    let solid = |test: &RunResult| column(test, "solid_fraction");
    assert!(solid(&dense)[0] > solid(&loose)[0] + 0.04, "{} {}", solid(&dense)[0], solid(&loose)[0]);
    assert!(last(&dense, "volumetric_strain") < -0.03, "{}", last(&dense, "volumetric_strain"));
    assert!(peak(&loose, "volumetric_strain") > 0.005, "{}", peak(&loose, "volumetric_strain"));
    let ratio = "von_mises_ratio";
    assert!(
        peak(&dense, ratio) > 1.2 * late(&dense, ratio),
        "{} {}",
        peak(&dense, ratio),
        late(&dense, ratio)
    );
    assert!((late(&dense, ratio) / late(&loose, ratio) - 1.0).abs() < 0.12);
    assert!((late(&dense, "solid_fraction") - late(&loose, "solid_fraction")).abs() < 0.015);
}

/// At constant volume a loose sample loses its mean stress, and a dense one gains.
#[test]
fn undrained_samples_lose_or_gain_mean_stress_by_their_density() {
    let [loose, dense] = ["undrained-loose", "undrained-dense"].map(|name| {
        test(&small(
            name,
            &[
                ("stage.1.axial_strain", "0.08"),
                ("stage.1.inertial_number", "3e-3"),
                ("stage.1.states", "40"),
            ],
        ))
    });
    let p = |test: &RunResult| column(test, "mean_stress");
    assert!(p(&loose).into_iter().fold(f64::INFINITY, f64::min) < 40e3, "{:?}", p(&loose));
    assert!(last(&dense, "mean_stress") > 300e3, "{:?}", p(&dense));
}

/// Undrained cycles take the mean stress away; drained ones leave a strain behind.
#[test]
fn cycles_liquefy_or_ratchet() {
    let undrained = test(&small("cyclic-undrained", &[("stage.1.inertial_number", "3e-3")]));
    let p = column(&undrained, "mean_stress");
    assert!(p.iter().copied().fold(f64::INFINITY, f64::min) < 30e3, "{p:?}");
    let drained = test(&small(
        "cyclic-drained",
        &[("stage.1.inertial_number", "3e-3"), ("stage.2.inertial_number", "3e-3"), ("stage.2.cycles", "6")],
    ));
    let strain = column(&drained, "axial_strain");
    // The strain between the first and the last cycle is more than that of a single cycle.
    let third = strain.len() / 3;
    let middle = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    assert!(middle(&strain[2 * third..]) > middle(&strain[..third]), "{strain:?}");
}

/// The larger principal stress turns from the vertical towards 45 degrees.
#[test]
fn principal_axes_turn_in_simple_shear() {
    let sheared = test(&small(
        "simple-shear",
        &[("stage.1.shear_strain", "0.15"), ("stage.1.inertial_number", "3e-3")],
    ));
    let [x, y, xy] = ["stress_11", "stress_22", "stress_12"].map(|name| late(&sheared, name));
    let angle = 0.5 * (2.0 * xy).atan2(x - y).to_degrees();
    assert!((30.0..60.0).contains(&angle.abs()), "{angle}");
    assert!((y / 100e3 - 1.0).abs() < 0.02 && xy.abs() > 0.2 * y, "{x} {y} {xy}");
}

/// q/p falls with b, between Drucker and Prager's cone and Mohr and Coulomb's pyramid, as Matsuoka and Nakai or Lade and Duncan
/// have it: for a friction angle of 20 to 35 degrees in compression the strength at b = 1 is 0.70 to 0.86 of that at b = 0.
#[test]
fn strength_falls_with_b() {
    let tested = test(&small("true-triaxial", &[]));
    let series = &tested.record.series;
    let (stages, ratio) = (series.values("stage").unwrap(), series.values("von_mises_ratio").unwrap());
    let mut of_stage: Vec<(f64, f64)> = Vec::new();
    for (stage, value) in stages.iter().zip(ratio) {
        match of_stage.iter_mut().find(|(known, _)| known == stage) {
            Some((_, most)) => *most = most.max(value.abs()),
            None => of_stage.push((*stage, value.abs())),
        }
    }
    let strengths: Vec<f64> = of_stage.iter().rev().take(5).rev().map(|(_, most)| *most).collect();
    assert_eq!(strengths.len(), 5);
    let share = strengths[4] / strengths[0];
    assert!((0.62..0.92).contains(&share), "{strengths:?}");
    assert!(strengths[2] < strengths[0] && strengths[4] < strengths[1], "{strengths:?}");
}

/// A cohesive powder packs loosely, collapses under load and does not come back.
#[test]
fn a_powder_collapses_and_stays_so() {
    let loaded = test(&small(
        "powder-oedometer",
        &[("stage.1.inertial_number", "5e-3"), ("stage.1.interval", "1e-2")],
    ));
    let series = &loaded.record.series;
    let void: Vec<f64> =
        series.values("solid_fraction").unwrap().iter().map(|solid| 1.0 / solid - 1.0).collect();
    let least = void.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(void[0] > 0.9 && least < void[0] - 0.2, "{void:?}");
    assert!(void[void.len() - 1] - least < 0.1 * (void[0] - least), "{void:?}");
    // At its own speed it is quasi-static.
    let slow = test(&small("powder-oedometer", &[("grains.count", "100")]));
    let flag = slow.about.quality.iter().find(|flag| flag.name == "inertial_number").unwrap();
    assert!(flag.passed, "{flag:?}");
}

/// A cohesive powder has a strength without lateral stress, and grains without adhesion have none. Its flow function coefficient grows
/// with the consolidation stress and falls with the interface energy.
#[test]
fn a_powder_has_an_unconfined_strength() {
    let measured = |energy: &str, stress: &str| {
        let changes = [
            ("grains.material.interface_energy", energy),
            ("preparation.interface_energy", energy),
            ("stage.1.lateral_stress", stress),
            ("stage.1.pre_shear_strain", "0.12"),
            ("stage.1.axial_strain", "0.06"),
            ("stage.1.inertial_number", "3e-3"),
            ("stage.1.states", "40"),
        ];
        let done = test(&small("powder-flow", &changes));
        let cut = done.about.quality.iter().find(|flag| flag.name == "stages_cut_short").unwrap();
        assert!(cut.passed, "{:?}", done.about.notes);
        let measures = done.about.measures.clone();
        assert!(measures.values().all(|value| value.is_finite()), "{measures:?}");
        measures
    };
    let powder = measured("5 mJ/m2", "4 kPa");
    let (strength, coefficient) = (powder["unconfined_yield_strength"], powder["flow_function_coefficient"]);
    assert!((6e3..20e3).contains(&powder["consolidation_stress"]), "{powder:?}");
    assert!((200.0..8e3).contains(&strength) && coefficient > 1.0, "{powder:?}");
    assert!(measured("5 mJ/m2", "12 kPa")["flow_function_coefficient"] > 1.3 * coefficient);
    assert!(measured("20 mJ/m2", "4 kPa")["flow_function_coefficient"] < 0.7 * coefficient);
    let dry = measured("0 J/m2", "4 kPa");
    assert_eq!(dry["unconfined_yield_strength"], 0.0, "{dry:?}");
    assert!(!dry.contains_key("flow_function_coefficient"));
}

/// Liquid bridges give strength where next to none presses the grains together.
#[test]
fn wet_grains_have_cohesion() {
    let quick =
        [("stage.1.axial_strain", "0.1"), ("stage.1.inertial_number", "5e-3"), ("stage.1.states", "20")];
    let wet = test(&small("wet-grains", &quick));
    let mut dry = small("wet-grains", &quick);
    dry.set("contact.adhesion", "none").unwrap();
    let dry = test(&dry);
    let strength = |test: &RunResult| peak(test, "von_mises_stress");
    assert!(strength(&wet) > 1.5 * strength(&dry), "{} {}", strength(&wet), strength(&dry));
}

#[test]
fn resistance_to_rolling_makes_grains_stronger() {
    let with = test(&small("rolling-resistance", DENSE));
    let mut free = small("rolling-resistance", DENSE);
    free.contact.parameters.unset("rolling_friction");
    free.set("contact.rolling", "none").unwrap();
    let without = test(&free);
    let ratio = "von_mises_ratio";
    assert!(
        late(&with, ratio) > 1.1 * late(&without, ratio),
        "{} {}",
        late(&with, ratio),
        late(&without, ratio)
    );
}

/// Both samples of Karlsruhe sand have the sieve curve, and the dense one is stronger and dilates more, as in the laboratory.
#[test]
fn karlsruhe_sand_dilates_by_its_density() {
    let quick =
        [("stage.1.axial_strain", "0.12"), ("stage.1.inertial_number", "3e-3"), ("stage.1.states", "30")];
    let [dense, loose] = ["karlsruhe-dense", "karlsruhe-loose"].map(|name| test(&small(name, &quick)));
    let strength = [&dense, &loose].map(|test| peak(test, "von_mises_ratio"));
    assert!(strength[0] > 1.1 * strength[1], "{strength:?}");
    assert!(last(&dense, "volumetric_strain") < last(&loose, "volumetric_strain") - 0.02);
    let radii: Vec<f64> =
        dense.simulation().unwrap().assembly().pieces.iter().map(|piece| piece.radius).collect();
    let mass =
        |of: &dyn Fn(f64) -> bool| radii.iter().filter(|r| of(2.0 * **r)).map(|r| r.powi(3)).sum::<f64>();
    let finer = mass(&|d| d < 0.1249e-3) / mass(&|_| true);
    assert!((finer - (0.2824 - 0.0153) / (1.0 - 0.0153)).abs() < 0.01, "{finer}");
}

#[test]
fn a_history_of_strains_is_followed() {
    let done = test(&small("strain-history", &[("stage.1.inertial_number", "3e-3")]));
    let end = |name: &str| *done.record.series.values(name).unwrap().last().unwrap();
    for (name, strain) in [("axial_strain", 0.009), ("lateral_strain_2", -0.001), ("shear_strain_xy", -0.01)]
    {
        assert!((end(name) - strain).abs() < 2e-5, "{name}: {}", end(name));
    }
    assert!(end("stress_12") < 0.0, "the last row shears the other way");
}

/// From the list to a picture over a test of the laboratory, as in the book.
#[test]
fn a_ready_case_is_written_run_and_compared() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    let done = |arguments: &[&str]| {
        let output = run(place, arguments);
        assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
        stdout(&output)
    };
    let list = json(&done(&["--json", "init", "--list"]));
    assert_eq!(list["cases"].as_array().unwrap().len(), CASES.len());
    assert!(done(&["init", "--case", "drained-loose", "loose.toml"]).contains("granum run loose.toml"));
    assert!(stderr(&run(place, &["init", "--case", "drained-lose"])).contains("did you mean drained-loose?"));
    assert!(
        !run(place, &["init", "--case", "drained-loose", "loose.toml"]).status.success(),
        "it is there already"
    );
    let few =
        ["--set", "grains.count=100", "--set", "stage.1.axial_strain=0.02", "--set", "stage.1.states=10"];
    let quick = ["--set", "stage.1.inertial_number=5e-3", "--set", "preparation.unbalanced_force=2e-2"];
    done(&[&["run", "loose.toml", "--out", "loose"], &few[..], &quick[..]].concat());
    let lab = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/lab/karlsruhe-fine-sand-drained.csv");
    let found = json(&done(&["--json", "compare", "loose", lab, "--test", "TMD2", "-o", "loose.svg"]));
    let one = &found["comparisons"][0];
    assert_eq!((one["run"].as_str(), one["test"].as_str()), (Some("loose"), Some("TMD2")));
    let number = |key: &str| one[key].as_f64().unwrap();
    assert!(number("up_to_axial_strain") > 0.015 && number("up_to_axial_strain") < 0.021);
    assert!(number("deviator_stress_error") > 0.0 && number("void_ratio_error") > 0.1);
    assert!(std::fs::read_to_string(place.join("loose.svg")).unwrap().contains("TMD2"));
    for (arguments, part) in [
        (&["compare", "loose", lab][..], "or all of them with --test all: TMD1"),
        (&["compare", "loose", lab, "--test", "TMD99"], "there are TMD1"),
        (&["compare", lab, "loose"], "the laboratory's file comes last"),
        (
            &["compare", "loose", lab, "--test", "TMD1", "--map", "axial_strian=x"],
            "did you mean axial_strain?",
        ),
    ] {
        let output = run(place, &[arguments, &["-o", "other.svg"]].concat());
        assert!(!output.status.success() && stderr(&output).contains(part), "{}", stderr(&output));
    }
}

/// Long grains are stronger than spheres of the same friction, touch more neighbours, and their long axes turn away from the load.
#[test]
fn long_grains_are_stronger_than_spheres() {
    let short =
        [("stage.1.axial_strain", "0.2"), ("stage.1.inertial_number", "3e-3"), ("stage.1.states", "40")];
    let long = test(&small("long-grains", &short));
    let mut case = small("long-grains", &short);
    case.grains.shapes.clear();
    let spheres = test(&case);
    let ratio = "stress_ratio";
    assert!(
        late(&long, ratio) > 1.2 * late(&spheres, ratio),
        "{} {}",
        late(&long, ratio),
        late(&spheres, ratio)
    );
    assert!(last(&long, "coordination_number") > 1.3 * last(&spheres, "coordination_number"));
    assert!(
        last(&long, "long_axis_angle") > column(&long, "long_axis_angle")[0] + 3.0,
        "{}",
        last(&long, "long_axis_angle")
    );
    assert!(spheres.record.series.values("long_axis_angle").is_none(), "spheres have no long axes");
}

/// Layers across the load make a stronger sample than layers along it.
#[test]
fn strength_depends_on_the_angle_of_the_layers() {
    let tilted = |tilt: &str| {
        let changes = [
            ("preparation.bedding_tilt", tilt),
            ("stage.1.inertial_number", "2e-3"),
            ("grains.count", "500"),
        ];
        peak(&test(&small("bedded-grains", &changes)), "stress_ratio")
    };
    let (across, along) = (tilted("0 deg"), tilted("90 deg"));
    assert!(across > 1.05 * along, "{across} {along}");
}

#[test]
fn cement_makes_a_brittle_peak_and_leaves_sand() {
    let changes = [("stage.1.axial_strain", "0.12"), ("stage.1.inertial_number", "3e-3")];
    let cemented = test(&small("cemented-sand", &changes));
    let mut without = small("cemented-sand", &changes);
    without.bonds.clear();
    let without = test(&without);
    let (with_peak, without_peak) = (peak(&cemented, "stress_ratio"), peak(&without, "stress_ratio"));
    assert!(with_peak > 1.25 * without_peak, "{with_peak} {without_peak}");
    let late = |test: &RunResult| {
        let ratios = column(test, "stress_ratio");
        let last = &ratios[3 * ratios.len() / 4..];
        last.iter().sum::<f64>() / last.len() as f64
    };
    assert!((late(&cemented) / late(&without) - 1.0).abs() < 0.2, "{} {}", late(&cemented), late(&without));
    let broken = column(&cemented, "broken_bond_fraction");
    assert!(broken[0] < 0.01 && broken[broken.len() - 1] > 0.9, "{broken:?}");
}

/// At constant volume cement carries a loose sand far above its own strength, and the sand that is left liquefies.
#[test]
fn loose_sand_liquefies_when_its_cement_breaks() {
    let changes = [("stage.1.inertial_number", "3e-3"), ("stage.1.states", "60")];
    let cemented = test(&small("cemented-sand-undrained", &changes));
    let mut without = small("cemented-sand-undrained", &changes);
    without.bonds.clear();
    let without = test(&without);
    let strength = |test: &RunResult| peak(test, "deviator_stress");
    assert!(strength(&cemented) > 2.0 * strength(&without), "{} {}", strength(&cemented), strength(&without));
    let p = column(&cemented, "mean_stress");
    assert!(p[p.len() - 1] < 30e3, "{p:?}");
    let broken = column(&cemented, "broken_bond_fraction");
    assert!(broken[0] < 0.01 && broken[broken.len() - 1] > 0.5, "{broken:?}");
}

#[test]
fn a_rock_like_packing_is_elastic_and_brittle() {
    let changes =
        [("stage.1.axial_strain", "0.006"), ("stage.1.inertial_number", "1e-3"), ("stage.1.states", "60")];
    let rock = test(&small("rock-like", &changes));
    let (stress, strain) = (column(&rock, "stress_11"), column(&rock, "axial_strain"));
    let largest = stress.iter().copied().fold(0.0, f64::max);
    assert!(largest > 30e6 && stress[stress.len() - 1] < 0.75 * largest, "{largest} {:?}", stress.last());
    let early = strain.iter().position(|strain| *strain > 5e-4).unwrap();
    let modulus = (stress[early] - stress[0]) / (strain[early] - strain[0]);
    assert!((1e10..2.5e10).contains(&modulus), "{modulus}");
}

#[test]
fn crushable_grains_break_and_are_graded() {
    let mut case = small(
        "crushable-grains",
        &[
            ("stage.1.mean_stress", "100 kPa"),
            ("stage.2.axial_stress", "600 kPa"),
            ("stage.2.inertial_number", "1e-2"),
        ],
    );
    case.set("grains.count", "50").unwrap();
    case.set("grains.shape.agglomerate_spheres", "13").unwrap();
    case.set("bond.1.tensile_strength", "3 MPa").unwrap();
    case.set("bond.1.cohesion", "3 MPa").unwrap();
    let crushed = test(&case);
    let breakage = column(&crushed, "einav_breakage");
    let (first, last) = (breakage[0], breakage[breakage.len() - 1]);
    assert!(last > first + 0.01 && last < 1.0, "{first} {last}");
    let single = column(&crushed, "single_grain_fraction");
    assert!(single[single.len() - 1] > single[0]);
}
