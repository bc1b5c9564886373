//! Unconfined yield strength of powders, and the tensile strength that a stage found.
//!
//! A sample that was consolidated under the major principal stress sigma_1 and unloaded fails in compression without lateral stress at
//! the unconfined yield strength sigma_c. Their ratio `ff_c = sigma_1 / sigma_c` tells how a powder flows (Jenike 1964). sigma_1 is that of
//! the last stage before the stress was taken off: its mean over the last quarter of the strain if the stage shears the sample to
//! steady flow, as the pre-shear of a shear tester does, and else its value at the end.

use std::collections::BTreeMap;
use std::ops::Range;

use granum_dem::invariants;
use granum_dem::loading::{Reason, Stage, StageEnd};

use super::curves::Curves;
use super::late::late_mean;
use super::symmetry;

/// Share of the consolidation stress below which there is no strength: a ratio would be that of noise.
const NO_STRENGTH: f64 = 1e-3;

/// Adds what the compression without lateral stress, and stages in tension, say of a test.
pub(super) fn add(
    curves: &Curves,
    stages: &[Stage],
    ends: &[StageEnd],
    measures: &mut BTreeMap<String, f64>,
) {
    let mut strengths = ends.iter().filter_map(|end| match end.reason {
        Reason::TensileStrength { strength, .. } => Some(strength),
        _ => None,
    });
    if let Some(strength) = strengths.next_back() {
        measures.insert("tensile_strength".into(), strength);
    }
    let last =
        stages.iter().enumerate().rev().find_map(|(k, stage)| Some((k, symmetry::unconfined_axis(stage)?)));
    let Some((stage, axis)) = last else { return };
    let rows = rows_of(curves, stage);
    let Some((strength, failure)) = largest(curves, &rows, axis) else { return };
    let before =
        stages[..stage].iter().rposition(|stage| !stage.is_mark() && !symmetry::takes_stress_off(stage));
    let consolidation = before.and_then(|before| consolidation_stress(curves, &stages[before], before));
    let strength = match consolidation {
        Some(consolidation) if strength < NO_STRENGTH * consolidation => 0.0,
        _ => strength.max(0.0),
    };
    // A strength at the last state may be exceeded beyond it.
    if strength > 0.0 && failure + 1 == rows.end {
        measures.insert("unconfined_yield_strength_at_least".into(), strength);
    } else {
        measures.insert("unconfined_yield_strength".into(), strength);
        if strength > 0.0 {
            let at = |row: usize| curves.strain(row, rows.start)[axis][axis];
            measures.insert("axial_strain_at_failure".into(), at(failure));
        }
        if let Some(consolidation) = consolidation.filter(|_| strength > 0.0) {
            measures.insert("flow_function_coefficient".into(), consolidation / strength);
        }
    }
    if let Some(consolidation) = consolidation {
        measures.insert("consolidation_stress".into(), consolidation);
    }
}

/// The rows of a stage.
fn rows_of(curves: &Curves, stage: usize) -> Range<usize> {
    let mut rows = (0..curves.rows()).filter(|row| curves.stage_index(*row) == stage);
    let Some(first) = rows.next() else { return 0..0 };
    first..rows.next_back().unwrap_or(first) + 1
}

/// The largest axial less lateral stress of rows, with its row; the first state, before the compression, does not count.
fn largest(curves: &Curves, rows: &Range<usize>, axis: usize) -> Option<(f64, usize)> {
    let deviator = |row: usize| symmetry::axial_deviator(&curves.stress(row), axis);
    let values = rows.clone().skip(1).map(|row| (deviator(row), row)).filter(|(value, _)| value.is_finite());
    values.max_by(|a, b| a.0.total_cmp(&b.0))
}

/// The major principal stress of a stage, Pa, at its steady flow or at its end.
fn consolidation_stress(curves: &Curves, stage: &Stage, index: usize) -> Option<f64> {
    let rows = rows_of(curves, index);
    let of_rows: Vec<f64> = rows.clone().map(|row| invariants::eigenvalues(&curves.stress(row))[0]).collect();
    let strains: Vec<f64> =
        rows.clone().map(|row| invariants::deviatoric_strain(&curves.strain(row, rows.start))).collect();
    let mean = if symmetry::is_isotropic(stage) { None } else { late_mean(&strains, &of_rows) };
    mean.or(of_rows.last().copied()).filter(|stress| *stress > 0.0)
}

#[cfg(test)]
mod tests {
    use granum_core::{Column, Table};
    use granum_dem::loading::Measure;
    use granum_dem::state::ServoError;
    use granum_io::Case;
    use granum_sensors::Record;

    use super::*;

    const PATH: &str = "[[stage]]\npath = 'unconfined-strength'\nlateral_stress = '10 kPa'\n";

    /// Rows of stage, axial strain, axial and lateral stress in kPa.
    fn measures(text: &str, rows: &[[f64; 4]], ends: &[StageEnd]) -> BTreeMap<String, f64> {
        let column = |name: &str, value: &dyn Fn(&[f64; 4]) -> f64| {
            Column::new(name, "", rows.iter().map(value).collect())
        };
        let series = Table::new(vec![
            column("stage", &|row| row[0]),
            column("axial_strain", &|row| row[1]),
            column("lateral_strain_2", &|row| -0.5 * row[1]),
            column("lateral_strain_3", &|row| -0.5 * row[1]),
            column("stress_11", &|row| 1e3 * row[2]),
            column("stress_22", &|row| 1e3 * row[3]),
            column("stress_33", &|row| 1e3 * row[3]),
            column("stress_12", &|_| 0.0),
            column("stress_21", &|_| 0.0),
            column("stress_13", &|_| 0.0),
            column("stress_31", &|_| 0.0),
            column("stress_23", &|_| 0.0),
            column("stress_32", &|_| 0.0),
            column("mean_stress", &|row| 1e3 * (row[2] + 2.0 * row[3]) / 3.0),
            column("solid_fraction", &|_| 0.5),
        ])
        .unwrap();
        let stages = Case::parse(text, "case.toml").unwrap().test_stages();
        super::super::of_test(&Record { series, ..Record::default() }, &stages, ends)
    }

    /// Consolidation, pre-shear to 30 kPa, unloading, rest, and failure at 6 kPa.
    fn rows(peak: f64) -> Vec<[f64; 4]> {
        let mut rows = vec![[1.0, 0.0, 10.0, 10.0]];
        let axial = |k: u32| if k < 10 { 10.0 + 2.0 * f64::from(k) } else { 30.0 };
        rows.extend((0..=30).map(|k| [2.0, 0.01 * f64::from(k), axial(k), 10.0]));
        rows.extend([[3.0, 0.3, 30.0, 10.0], [4.0, 0.295, 0.001, 0.0]]);
        rows.extend([0.0, 0.5, 1.0, 0.8, 0.6].map(|share| [5.0, 0.01 * share, share * peak, 0.0]));
        rows
    }

    #[test]
    fn strength_is_that_of_the_compression_without_lateral_stress() {
        let measured = measures(PATH, &rows(6.0), &[]);
        assert!((measured["consolidation_stress"] - 30e3).abs() < 1e-6, "{measured:?}");
        assert!((measured["unconfined_yield_strength"] - 6e3).abs() < 1e-6);
        assert!((measured["flow_function_coefficient"] - 5.0).abs() < 1e-12);
        assert!((measured["axial_strain_at_failure"] - 0.01).abs() < 1e-12);
        // Friction is that of the pre-shear: sin phi = 20 / 40. No angle of 90 degrees of a compression without lateral stress.
        assert!((measured["peak_friction_angle"] - 30.0).abs() < 1e-9, "{measured:?}");
        assert!(!measured.contains_key("tensile_strength"));
    }

    #[test]
    fn grains_without_cohesion_have_no_strength_and_no_ratio() {
        for peak in [0.0, 1e-4, -1e-4] {
            let measured = measures(PATH, &rows(peak), &[]);
            assert_eq!(measured["unconfined_yield_strength"], 0.0, "{measured:?}");
            assert!(measured.values().all(|value| value.is_finite()), "{measured:?}");
            assert!(!measured.contains_key("flow_function_coefficient"));
            assert!((measured["consolidation_stress"] - 30e3).abs() < 1e-6);
        }
    }

    /// A strength that still grows is only a bound, and gives no ratio.
    #[test]
    fn a_strength_at_the_last_state_is_a_bound() {
        let mut rows = rows(6.0);
        rows.truncate(rows.len() - 2);
        let measured = measures(PATH, &rows, &[]);
        assert!((measured["unconfined_yield_strength_at_least"] - 6e3).abs() < 1e-6, "{measured:?}");
        assert!(!measured.contains_key("flow_function_coefficient"));
        assert!(!measured.contains_key("unconfined_yield_strength"));
    }

    #[test]
    fn the_tensile_strength_is_that_of_the_last_stage_that_found_one() {
        let end = |strength: f64| StageEnd {
            name: "pull".into(),
            reason: Reason::TensileStrength { measure: Measure::MeanStress, strength },
            steps: 1,
            time: 1.0,
            servo_error: ServoError::default(),
        };
        let pull = "[[stage]]\npath = 'isotropic'\nmean_stress = '-5 kPa'\n";
        let rows = [[1.0, 0.0, 10.0, 10.0], [1.0, -0.01, -1.0, -1.0], [1.0, -0.02, -0.1, -0.1]];
        let measured = measures(pull, &rows, &[end(900.0), end(1100.0)]);
        assert_eq!(measured["tensile_strength"], 1100.0);
        assert!(measured.values().all(|value| value.is_finite()), "{measured:?}");
    }
}
