use granum_core::{Column, Table};
use granum_dem::loading::{Reason, StageEnd, Until};
use granum_dem::state::ServoError;
use granum_io::Case;

use super::*;

fn stages(text: &str) -> Vec<Stage> {
    Case::parse(text, "case.toml").unwrap().test_stages()
}

/// A record of rows: stage, axial strain, lateral strain, axial and lateral stress in kPa, shear stress in kPa, solid fraction.
fn record(rows: &[[f64; 7]]) -> Record {
    let column = |name: &str, value: &dyn Fn(&[f64; 7]) -> f64| {
        Column::new(name, "", rows.iter().map(value).collect())
    };
    let series = Table::new(vec![
        column("stage", &|row| row[0]),
        column("axial_strain", &|row| row[1]),
        column("lateral_strain_2", &|row| row[2]),
        column("lateral_strain_3", &|row| row[2]),
        column("volumetric_strain", &|row| row[1] + 2.0 * row[2]),
        column("stress_11", &|row| 1e3 * row[3]),
        column("stress_22", &|row| 1e3 * row[4]),
        column("stress_33", &|row| 1e3 * row[4]),
        column("stress_12", &|row| 1e3 * row[5]),
        column("stress_21", &|row| 1e3 * row[5]),
        column("stress_13", &|_| 0.0),
        column("stress_31", &|_| 0.0),
        column("stress_23", &|_| 0.0),
        column("stress_32", &|_| 0.0),
        column("mean_stress", &|row| 1e3 * (row[3] + 2.0 * row[4]) / 3.0),
        column("solid_fraction", &|row| row[6]),
    ])
    .unwrap();
    Record { series, ..Record::default() }
}

/// The bug of a ready case: a sample of 10 kPa is consolidated to 100 kPa and liquefies. Pore pressure counts from 100 kPa, and
/// the noise of the sample without stress is no strength.
#[test]
fn pore_pressure_counts_from_the_start_of_the_undrained_stage() {
    let stages =
        stages("[[stage]]\npath = 'undrained-triaxial'\nmean_stress = '100 kPa'\naxial_strain = 0.1\n");
    let rows = [
        [1.0, 0.0, 0.0, 10.0, 10.0, 0.0, 0.6],
        [2.0, 0.0, 0.0, 100.0, 100.0, 0.0, 0.58],
        [2.0, 0.01, -0.005, 120.0, 80.0, 0.0, 0.58],
        [2.0, 0.02, -0.01, 90.0, 50.0, 0.0, 0.58],
        [2.0, 0.04, -0.02, 4.0, 1.0, 0.0, 0.58],
        [2.0, 0.08, -0.04, 0.05, 0.001, 0.0, 0.58],
        [2.0, 0.1, -0.05, 0.05, 0.001, 0.0, 0.58],
    ];
    let record = record(&rows);
    let curves = Curves::new(&record, &stages);
    let ratios = curves.pore_pressure_ratio();
    assert!(ratios[0].is_nan() && ratios[1] == 0.0, "{ratios:?}");
    assert!((ratios[4] - 0.98).abs() < 1e-12 && ratios[6] > 0.999);
    let lost = curves.lost_while_undrained("mean_stress");
    assert!((lost[6] - 100e3).abs() < 20.0 && lost[1] == 0.0, "{lost:?}");
    assert_eq!(curves.test_rows(), 1..7);

    let found = of_test(&record, &stages, &[]);
    assert_eq!(found["liquefied"], 1.0);
    // r_u goes from 1 - 63.33/100 to 0.98 between strains of 0.02 and 0.04.
    let share = (0.95 - (1.0 - 190.0 / 300.0)) / (0.98 - (1.0 - 190.0 / 300.0));
    assert!((found["axial_strain_at_liquefaction"] - (0.02 + 0.02 * share)).abs() < 1e-12, "{found:?}");
    // The largest q/p of a state with stress, not 2.9 of a few pascals.
    assert!((found["peak_stress_ratio"] - 40.0 / (190.0 / 3.0)).abs() < 1e-12, "{found:?}");
    assert!((found["peak_friction_angle"] - (40.0f64 / 140.0).asin().to_degrees()).abs() < 1e-9);
    assert!(!found.contains_key("critical_friction_angle") && !found.contains_key("late_stress_ratio"));
    assert!(!found.contains_key("largest_dilatancy_angle"));
}

/// An isotropic state with residual shear has no q; in extension q is negative, as the column says.
#[test]
fn q_is_axial_minus_lateral_whatever_shear_is_left() {
    let stages = stages("[[stage]]\npath = 'drained-triaxial'\naxial_strain = -0.1\n");
    let rows: Vec<[f64; 7]> = (0..=20)
        .map(|k| {
            let strain = 0.005 * f64::from(k);
            let axial = 100.0 - 50.0 * (strain / 0.02).min(1.0);
            [1.0, -strain, 0.6 * strain, axial, 100.0, 2.6, 0.6 - 0.1 * strain]
        })
        .collect();
    let record = record(&rows);
    let curves = Curves::new(&record, &stages);
    assert_eq!((curves.deviator_stress()[0], curves.friction_angle()[0]), (0.0, 0.0));
    let found = of_test(&record, &stages, &[]);
    let ratio = -50.0 / (250.0 / 3.0);
    assert!((found["peak_stress_ratio"] - ratio).abs() < 1e-12, "{found:?}");
    assert!((found["late_stress_ratio"] - ratio).abs() < 1e-12, "{found:?}");
    assert!((found["peak_friction_angle"] - (50.0f64 / 150.0).asin().to_degrees()).abs() < 1e-9);
    // Extension by Schanz and Vermeer: sin psi = -d_eps_v / sum |d_eps| = -(-1 + 1.2) / 2.2.
    assert!(
        (found["largest_dilatancy_angle"] - (-0.2f64 / 2.2).asin().to_degrees()).abs() < 1e-9,
        "{found:?}"
    );
    // Half of 50 kPa at an axial strain of 0.01, at the second state after the start.
    assert!((found["secant_modulus_50"] - 2.5e6).abs() < 1.0, "{found:?}");
    let e = |strain: f64| 1.0 / (0.6 - 0.1 * strain) - 1.0;
    assert!((found["critical_void_ratio"] - e(0.0875)).abs() < 1e-4);
    // e as a function of the deviatoric strain 2/3 (1 + 0.6) of the axial one.
    let drift = (e(0.1) - e(0.075)) / (0.025 * 2.0 / 3.0 * 1.6);
    assert!((found["critical_void_ratio_drift"] / drift - 1.0).abs() < 1e-3, "{found:?} {drift}");
    assert!(!found.contains_key("liquefied") && !found.contains_key("peak_von_mises_ratio"));
}

#[test]
fn a_general_test_has_the_von_mises_stress_without_sign() {
    let stages = stages("[[stage]]\npath = 'simple-shear'\nshear_strain = 0.1\n");
    let rows = [
        [1.0, 0.0, 0.0, 100.0, 100.0, -1.0, 0.6],
        [1.0, 0.0, 0.0, 100.0, 100.0, -30.0, 0.6],
        [1.0, 0.0, 0.0, 100.0, 100.0, -20.0, 0.6],
    ];
    let found = of_test(&record(&rows), &stages, &[]);
    assert!((found["peak_von_mises_ratio"] - 0.3 * 3f64.sqrt()).abs() < 1e-12, "{found:?}");
    assert!((found["peak_friction_angle"] - 0.3f64.asin().to_degrees()).abs() < 1e-9);
    assert!(!found.contains_key("peak_stress_ratio"));
}

/// Half of the strength is reached before the second state: the straight line to it is flatter than the curve.
#[test]
fn a_modulus_between_the_first_two_states_is_only_a_bound() {
    let stages = stages("[[stage]]\npath = 'drained-triaxial'\naxial_strain = 0.1\n");
    let rows = [
        [1.0, 0.0, 0.0, 100.0, 100.0, 0.0, 0.6],
        [1.0, 0.01, -0.005, 250.0, 100.0, 0.0, 0.6],
        [1.0, 0.02, -0.01, 300.0, 100.0, 0.0, 0.6],
    ];
    let found = of_test(&record(&rows), &stages, &[]);
    assert!((found["secant_modulus_50_at_least"] - 15e6).abs() < 1.0, "{found:?}");
    assert!(!found.contains_key("secant_modulus_50"));
    let constant_p = self::stages("[[stage]]\npath = 'constant-p'\n");
    assert!(of_test(&record(&rows), &constant_p, &[]).keys().all(|name| !name.contains("secant")));
}

fn end(reason: Reason) -> StageEnd {
    StageEnd { name: "cyclic".into(), reason, steps: 1, time: 1.0, servo_error: ServoError::default() }
}

/// Twelve states a half cycle; the mean stress falls by a tenth in each, and the strain grows.
#[test]
fn cycles_to_liquefaction_are_counted_by_pore_pressure_and_by_strain() {
    let text =
        "[[stage]]\npath = 'cyclic'\nstress_amplitude = '20 kPa'\nmean_stress = '100 kPa'\ncycles = 20\n";
    let stages = stages(text);
    let mut rows = vec![[1.0, 0.0, 0.0, 100.0, 100.0, 0.0, 0.6]];
    for k in 0..=(12 * 10 - 6) {
        let phase = f64::from(k) / 24.0;
        let wave = (2.0 * std::f64::consts::PI * phase).sin();
        let p = 100.0 * (1.0 - 0.2 * phase).max(0.001);
        let strain = 0.001 * phase.powi(3) * wave;
        rows.push([2.0, strain, -0.5 * strain, p + 20.0 * wave * 2.0 / 3.0, p - 20.0 * wave / 3.0, 0.0, 0.6]);
    }
    let mut record = record(&rows);
    let q: Vec<f64> = rows.iter().map(|row| 1e3 * (row[3] - row[4])).collect();
    record.series.set(Column::new("deviator_stress", "Pa", q)).unwrap();
    let found = of_test(&record, &stages, &[]);
    // Turning points at 0.25, 0.75 ... 4.75 cycles: ten.
    assert_eq!(found["cycles"], 5.0, "{found:?}");
    // r_u reaches 0.95 at 4.75 cycles, in the tenth half cycle.
    assert_eq!(found["cycles_to_pore_pressure_ratio_95"], 5.0, "{found:?}");
    // 0.001 (x^3 + (x - 0.5)^3) reaches 0.05 between turning points at 2.75 and 3.25 (0.055): the seventh half cycle.
    assert_eq!(found["cycles_to_double_amplitude_5_percent"], 3.5, "{found:?}");
    assert_eq!((found["cycles_to_liquefaction"], found["liquefied"]), (3.5, 1.0));
    assert!(!found.contains_key("late_stress_ratio") && !found.contains_key("critical_void_ratio"));

    // The engine ends the stage at 0.95, just after the last recorded state.
    let short: Vec<[f64; 7]> = rows[..60].to_vec();
    let mut record = self::record(&short);
    let q: Vec<f64> = short.iter().map(|row| 1e3 * (row[3] - row[4])).collect();
    record.series.set(Column::new("deviator_stress", "Pa", q)).unwrap();
    assert_eq!(of_test(&record, &stages, &[])["liquefied"], 0.0);
    let rest = end(Reason::End(Until::AtRest { unbalanced_force: 1e-3 }));
    let liquefied = [rest, end(Reason::End(Until::PorePressureRatio(0.95)))];
    let found = of_test(&record, &stages, &liquefied);
    assert_eq!((found["liquefied"], found["cycles_to_liquefaction"]), (1.0, 3.0), "{found:?}");
}

/// Strains count from the start of the shear, also where no stage resets them, and an oedometer tells no strength.
#[test]
fn strains_count_from_the_start_of_the_shear() {
    let text =
        "[[stage]]\npath = 'isotropic'\nmean_stress = '100 kPa'\n[[stage]]\npath = 'drained-triaxial'\n";
    let mut stages = stages(text);
    stages[1].resets = false;
    let rows = [
        [1.0, 0.0, 0.0, 50.0, 50.0, 0.0, 0.6],
        [1.0, 0.01, 0.01, 100.0, 100.0, 0.0, 0.6],
        [2.0, 0.01, 0.01, 100.0, 100.0, 0.0, 0.6],
        [2.0, 0.02, 0.006, 200.0, 100.0, 0.0, 0.6],
        [2.0, 0.03, 0.002, 250.0, 100.0, 0.0, 0.6],
    ];
    let record = record(&rows);
    let curves = Curves::new(&record, &stages);
    let rows = curves.test_rows();
    assert_eq!(rows, 2..5);
    assert!((curves.axial_strain(rows.start)[4] - 0.02).abs() < 1e-15);
    let found = of_test(&record, &stages, &[]);
    assert!((found["axial_strain_at_peak"] - 0.02).abs() < 1e-15, "{found:?}");
    let oedometer = self::stages("[[stage]]\npath = 'oedometer'\n");
    assert!(!of_test(&record, &oedometer, &[]).contains_key("peak_friction_angle"));
}
