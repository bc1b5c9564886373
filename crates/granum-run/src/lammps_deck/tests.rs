//! Tests of the text; that LAMMPS runs it and gives granum's curve is a test of the program.

use granum_io::packing::PackedGrain;
use granum_io::{Case, Packing};

use super::{Confinement, LammpsDeck};

const LAWS: &str = "[contact]\nnormal = 'hertz'\ntangential = 'no-slip'\n";

/// Grains of a simple cubic lattice that carry about 20 kPa.
pub(super) fn packing() -> Packing {
    let (radius, edge) = (5e-5, 2.0 * 5e-5 - 8.5e-9);
    let grains = (0..27u64).map(|k| {
        let at = |n: u64| (n as f64 + 0.5) * edge;
        PackedGrain { id: k + 1, position: [at(k % 3), at(k / 3 % 3), at(k / 9)], radius }
    });
    let side = 3.0 * edge;
    Packing::new([0.0; 3], [[side, 0.0, 0.0], [0.0, side, 0.0], [0.0, 0.0, side]], grains.collect())
}

fn deck(case: &str) -> Result<String, String> {
    let case = Case::parse(case, "case.toml").map_err(|error| error.to_string())?;
    let deck = LammpsDeck::new(&case, &packing(), Confinement::Own).map_err(|error| error.to_string())?;
    Ok(deck.script().to_string())
}

fn stage(text: &str) -> Result<String, String> {
    deck(&format!("{LAWS}[[stage]]\n{text}"))
}

/// The first line that begins with a text.
fn line<'a>(script: &'a str, start: &str) -> &'a str {
    script.lines().find(|line| line.starts_with(start)).unwrap_or_else(|| panic!("{start} in {script}"))
}

#[test]
fn every_path_that_lammps_can_follow_is_written_without_minus_zero() {
    let paths = [
        "path = 'isotropic'\nunloading_stress = '50 kPa'",
        "path = 'drained-triaxial'",
        "path = 'drained-triaxial'\naxial_strain = -0.1",
        "path = 'undrained-triaxial'",
        "path = 'undrained-triaxial'\nfluid_modulus = '2 GPa'",
        "path = 'constant-p'\nmean_stress = '20 kPa'",
        "path = 'constant-p-and-b'",
        "path = 'oedometer'\nunloading_stress = '100 kPa'",
        "path = 'simple-shear'",
        "path = 'simple-shear-constant-volume'",
        "path = 'plane-strain'",
        "path = 'proportional'",
        "path = 'proportional'\nratios_of = 'stress'",
        "path = 'cyclic'",
        "path = 'cyclic'\ndrainage = 'drained'\nstress_amplitude = '5 kPa'",
        "path = 'unload-reload'",
    ];
    for path in paths {
        let script = stage(path).unwrap_or_else(|error| panic!("{path}: {error}"));
        let mut zeros =
            script.match_indices("-0.0").map(|(at, zero)| script[at + zero.len()..].chars().next());
        assert!(zeros.all(|next| next.is_some_and(|c| c.is_ascii_digit())), "{path}: minus zero in {script}");
        assert!(!script.contains("NaN") && !script.contains("inf"), "{path}");
        assert!(!script.contains("erate") && !script.contains("press/"), "{path}");
        for fix in ["cell", "stop", "mean", "integrals", "drag"] {
            let [made, unmade] = ["fix", "unfix"].map(|word| format!("\n{word} {fix}"));
            assert_eq!(script.matches(&made).count(), script.matches(&unmade).count(), "{path}: {fix}");
        }
        // Rows follow each other while the rates of a stage grow, and afterwards.
        for label in ["start_", "stage_"] {
            let labels = script.lines().filter(|line| line.starts_with(&format!("label {label}"))).count();
            assert_eq!(script.matches(&format!("jump SELF {label}")).count(), labels, "{path}");
            // A path whose rates are those of its servo alone has no beginning of its own.
            let by_servo = path.contains("isotropic") || path.contains("stress_amplitude");
            assert!(labels >= 1 || (label == "start_" && by_servo), "{path}: {label}");
        }
    }
    let shear = deck(&format!("{LAWS}[shear]\ndeviator_strain = 0.05\ninertial_number = 1e-3\n")).unwrap();
    assert!(shear.contains("variable value1 equal 0.3333333333333333*v_s11+"), "{shear}");
    assert!(shear.contains("variable target1 equal 20000.0\n"));
}

#[test]
fn the_servo_is_that_of_the_stage() {
    let script = stage("path = 'drained-triaxial'\naxial_strain = 0.05\n").unwrap();
    // The axial rate is prescribed, each lateral stress is held at what it is by its own axis.
    let l11 = script.rfind("variable l11 equal -v_share*v_speed\n").unwrap();
    assert!(
        script[l11..]
            .contains("variable l22 equal -v_out1\nvariable l33 equal -v_out2\nvariable l12 equal 0\n")
    );
    assert!(script.contains("variable target1 equal $(v_value1)\n"));
    assert!(script.contains("variable sense0 equal $(1-2*(0.05<v_e11))\n"));
    assert!(script.contains(
        "fix cell all deform 1 x variable v_change_x v_rate_x y variable v_change_y v_rate_y z variable"
    ));
    // A sample without tangential forces comes to rest before the test, which is stage 1.
    assert!(script.contains("print \"stage 0: rest\"") && script.contains("print \"stage 1: shear\""));
    // With a consolidation of its own it does not come to rest twice.
    let script = stage("path = 'drained-triaxial'\nlateral_stress = '50 kPa'").unwrap();
    assert!(!script.contains("stage 0") && script.contains("variable target2 equal 50000.0\n"));
}

#[test]
fn a_cyclic_stage_turns_round_and_counts_its_reversals() {
    let script = stage("path = 'cyclic'\nstrain_amplitude = 1e-3\ncycles = 3").unwrap();
    assert!(
        script.contains(
            "variable turns equal (v_direction>0)*(v_e11>=0.001)+(v_direction<0)*(v_e11<=(-0.001))\n"
        )
    );
    assert!(script.contains("variable until0 equal (v_turned>=6)\n"));
    assert!(script.contains("variable l11 equal -v_share*v_direction*v_speed\n"));
    let turn = &script[script.find("label turn_1\n").unwrap()..];
    let order = [
        "variable turned equal $(v_turned+1)",
        "jump SELF over_1",
        "variable direction equal $(-v_direction)",
    ];
    let places = order.map(|text| turn.find(text).unwrap_or_else(|| panic!("{text} in {turn}")));
    assert!(
        places.is_sorted() && turn.contains("variable leg_at equal $(v_now)\njump SELF begin_1\n"),
        "{turn}"
    );
    // A stress that changes turns round at its present value; its double amplitude counts from there.
    let script = stage("path = 'cyclic'\nstress_amplitude = '5 kPa'").unwrap();
    assert!(script.contains("variable rate1 equal $((5000.0-v_target1)/v_ramp)\n"), "{script}");
    assert!(script.contains("variable aim1 equal v_target1+v_direction*v_rate1*v_progress\n"));
    let turn = &script[script.find("label turn_1\n").unwrap()..];
    assert!(
        turn.contains("variable target1 equal $(v_value1)\nvariable turned_at2 equal $(v_e11)\n"),
        "{turn}"
    );
}

/// A row of a history has ramps of strains and stresses, which end together.
#[test]
fn ramps_take_as_long_as_the_slowest_of_them() {
    let script =
        stage("xx = { strain_to = 0.002 }\nyy = { stress_to = '22 kPa' }\nzz = { stress = '20 kPa' }")
            .unwrap();
    assert!(
        script.contains("variable other equal $(abs(22000.0-v_target1)/(0.25*(3.0*v_modulus)*v_speed))\n"),
        "{script}"
    );
    assert!(script.contains("variable other equal $(abs(0.002-v_e11)/v_speed)\n"));
    assert!(script.contains("variable ramp_end equal $(v_ramp+0.5*v_ease)\n"));
    assert!(script.contains("variable pace1 equal $((0.002-v_e11)/v_ramp)\n"));
    assert!(script.contains("variable l11 equal -v_share*v_pace1\n"));
    assert!(script.contains("variable until0 equal (v_lasted>=v_ramp_end)\n"));
    // What is held has no rate, and no ramp counts for it.
    assert!(script.contains("variable aim2 equal v_target2\n") && !script.contains("v_rate2"));
}

#[test]
fn coordination_numbers_are_means_over_a_row_as_the_stresses_beside_them() {
    let script = stage("path = 'oedometer'\nunloading_stress = '100 kPa'").unwrap();
    let rows = script.lines().filter(|line| line.starts_with("print \"$(v_stage"));
    let means: Vec<&str> = rows.filter(|line| line.contains("$(f_mean[1]:")).collect();
    // A row of each loop: of the relaxation, and of the beginning and the rest of the two stages.
    assert_eq!(means.len(), 5, "{script}");
    for row in means {
        assert!(row.contains("$(0.5*(v_coordination_before+v_coordination):%.6g)"), "{row}");
    }
}

#[test]
fn a_sheared_box_is_tilted_and_others_are_not() {
    let script = stage("path = 'simple-shear-constant-volume'").unwrap();
    assert!(script.contains("change_box all triclinic\n"));
    assert!(script.contains("variable l12 equal -v_share*v_speed\n"));
    assert!(script.contains("xy variable v_change_xy v_rate_xy"));
    assert!(!stage("path = 'oedometer'").unwrap().contains("triclinic"), "an orthogonal box costs less");
}

#[test]
fn laws_are_those_of_the_case() {
    let laws = |text: &str| line(&deck(text).unwrap(), "pair_coeff").to_string();
    let hertz = laws(LAWS);
    // Restitution of a tenth of critical damping, 8 G* and (k_t/k_n)^(1/2) of glass.
    let words: Vec<&str> = hertz.split(' ').collect();
    assert_eq!(words[..5], ["pair_coeff", "*", "*", "hertz/material", "70000000000.0"]);
    let number = |k: usize| words[k].parse::<f64>().unwrap();
    assert!((number(5) - 0.6104).abs() < 1e-4 && number(6) == 0.3, "{hertz}");
    assert_eq!(words[7..9], ["tangential", "mindlin_rescale/force"]);
    assert!((number(9) / 6.334_841_628_959_276e10 - 1.0).abs() < 1e-12, "{hertz}");
    assert!((number(10) / 0.907_485_212_973_03 - 1.0).abs() < 1e-12, "{hertz}");
    assert_eq!(words[11..], ["0.3", "damping", "tsuji"]);

    let hooke = laws(
        "[contact]\nnormal = 'hooke'\ntangential = 'no-slip'\nnormal_stiffness = 4e4\ntangential_stiffness_ratio = 0.25\n",
    );
    assert!(
        hooke.contains("hooke 40000.0 ") && hooke.contains(" linear_history 10000.0 0.5 0.3 "),
        "{hooke}"
    );

    let jkr = laws(
        "[contact]\nnormal = 'jkr'\ntangential = 'no-slip'\n[grains.material]\ninterface_energy = 0.05\n[preparation]\nmean_stress = '5 kPa'\n",
    );
    assert!(jkr.contains(" jkr 70000000000.0 ") && jkr.contains(" 0.3 0.025 tangential"), "{jkr}");

    let rolling =
        laws(&format!("{LAWS}rolling = 'elastic-plastic'\nrolling_friction = 0.1\nrolling_damping = 0.3\n"));
    let values: Vec<f64> = rolling
        .split(" rolling sds ")
        .nth(1)
        .unwrap()
        .trim()
        .split(' ')
        .map(|word| word.parse().unwrap())
        .collect();
    // Contacts of the lattice: alpha = 8.5e-9 m, k_n = 2 E* (R* alpha)^(1/2), k = 9/4 k_n mu_r^2.
    let stiffness = 2.0 * 70e9 / (2.0 * 0.91) * (2.5e-5 * 8.5e-9f64).sqrt();
    assert!((values[0] / (2.25 * 0.01 * stiffness) - 1.0).abs() < 1e-2, "{rolling}");
    assert_eq!(values[2], 0.1);
    // With Hertz's law the stiffness follows the mean stress in every row of the curve; with Hooke's it does not.
    let case = format!("{LAWS}rolling = 'elastic-plastic'\n");
    let script = deck(&case).unwrap();
    assert!(script.matches("*v_stiffer) $(").count() == 2, "one in each stage");
    // The memory of rolling does not outlive a change of the order of atoms.
    assert!(script.contains("\natom_modify sort 0 0.0\n") && !deck(LAWS).unwrap().contains("atom_modify"));
    let case = "[contact]\nnormal = 'hooke'\ntangential = 'no-slip'\nnormal_stiffness = 4e4\nrolling = 'elastic-plastic'\n";
    assert!(!deck(case).unwrap().contains("*v_stiffer) $("));
    let twisting = laws(&format!("{LAWS}rolling = 'elastic-plastic-twisting'\ntwisting_friction = 0.2\n"));
    // The limit of twisting is a length, mu_t R*.
    let arm: f64 = twisting.rsplit(' ').next().unwrap().parse().unwrap();
    assert!(twisting.contains(" rolling sds ") && (arm / 5e-6 - 1.0).abs() < 1e-12, "{twisting}");
}

/// The law that LAMMPS has too keeps its numbers, whatever the normal law and the stress.
#[test]
fn the_spring_dashpot_slider_is_written_as_it_is() {
    for normal in ["'hertz'", "'hooke'\nnormal_stiffness = 4e4"] {
        let case = format!(
            "[contact]\nnormal = {normal}\ntangential = 'no-slip'\nrolling = 'spring-dashpot-slider'\n\
             rolling_stiffness = 800\nrolling_viscosity = '1.05e-3 N s/m'\nrolling_friction = 0.15\n"
        );
        let script = deck(&case).unwrap();
        assert!(line(&script, "pair_coeff").ends_with(" rolling sds 800.0 0.00105 0.15"), "{script}");
        assert_eq!(script.matches("\npair_coeff").count(), 1, "it does not follow the stress");
        assert!(script.contains("\natom_modify sort 0 0.0\n"));
    }
}

#[test]
fn what_lammps_has_not_is_refused_by_name() {
    let refused = [
        (
            "[contact]\nnormal = 'hertz'\n",
            "contact.tangential = \"mindlin-deresiewicz\" cannot be written for LAMMPS",
        ),
        ("[contact]\nnormal = 'dmt'\ntangential = 'no-slip'\n", "contact.normal = \"dmt\""),
        ("[contact]\nnormal = 'hertz'\ntangential = 'no-slip'\ndamping = 0.6\n", "contact.damping = 0.6"),
        (
            "[contact]\nnormal = 'hertz'\ntangential = 'no-slip'\nadhesion = 'van-der-waals'\n",
            "contact.adhesion",
        ),
    ];
    for (case, message) in refused {
        let error = deck(case).unwrap_err();
        assert!(error.contains(message), "{error}");
    }
    let refused = [
        ("path = 'probes'", "it shears the cell without rotation"),
        ("xy = { rate = 1 }\nuntil = { xy_strain = 0.1 }", "it shears the cell without rotation"),
        (
            "xx = { rate = 1 }\nuntil = { critical_state = { window = 0.1, stress_ratio = 0.1, volumetric_strain = 0.1 } }",
            "its end condition",
        ),
    ];
    for (text, message) in refused {
        let error = stage(text).unwrap_err();
        assert!(error.starts_with("the stage ") && error.contains(message), "{error}");
    }
}

#[test]
fn a_loose_packing_is_refused() {
    let mut packing = packing();
    for grain in &mut packing.grains {
        grain.radius = 4e-5;
    }
    let case = Case::parse(LAWS, "case.toml").unwrap();
    let error = LammpsDeck::new(&case, &packing, Confinement::Prepared).unwrap_err().to_string();
    assert!(error.contains("it is loose"), "{error}");
}
