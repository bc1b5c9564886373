//! Peak and late values: stress ratio, friction angle, dilatancy angle, and the critical state with the drift that is left.

use std::collections::BTreeMap;
use std::ops::Range;

use granum_sensors::dilatancy::dilatancy_angle;

use super::curves::Curves;
use super::late::{late_mean, late_rows, slope};
use super::symmetry;

/// Strain over which a dilatancy angle is taken, unless recorded states are further apart.
const DILATANCY_WINDOW: f64 = 0.01;
/// Deviatoric strain before which elastic strains would be mistaken for dilatancy.
const DILATANCY_FROM: f64 = 0.005;

/// Adds the largest stress ratio, by its magnitude, with what the state there is; only states that carry stress count.
pub(super) fn add_peak(curves: &Curves, rows: &Range<usize>, measures: &mut BTreeMap<String, f64>) {
    let Some(peak) = curves.peak_row(rows) else { return };
    let ratios = curves.stress_ratio();
    let ratio = if curves.axis().is_some() { "peak_stress_ratio" } else { "peak_von_mises_ratio" };
    measures.insert(ratio.into(), ratios[peak]);
    let mut add = |name: &str, value: f64| {
        if value.is_finite() {
            measures.insert(name.into(), value);
        }
    };
    if curves.go_by_deviator_strain(rows) {
        add("deviator_strain_at_peak", curves.at("deviator_strain", peak));
    } else {
        add("deviatoric_strain_at_peak", curves.deviatoric_strain(rows.start)[peak]);
    }
    if curves.axis().is_some() {
        add("axial_strain_at_peak", curves.axial_strain(rows.start)[peak]);
    }
    add("deviator_fabric_at_peak", curves.at("deviator_fabric", peak));
    add("solid_fraction_at_peak", curves.at("solid_fraction", peak));
}

/// Adds means over the last quarter of the strain, if it only grows there and the sample carries stress, and their drift.
pub(super) fn add_late(
    curves: &Curves,
    rows: &Range<usize>,
    carries: &[bool],
    measures: &mut BTreeMap<String, f64>,
) {
    let strains = &curves.deviatoric_strain(rows.start)[rows.clone()];
    let Some(late) = late_rows(strains) else { return };
    let mut add = |name: &str, value: Option<f64>| {
        if let Some(value) = value.filter(|value| value.is_finite()) {
            measures.insert(name.into(), value);
        }
    };
    let of = |values: &[f64]| values.get(rows.clone()).map_or(Vec::new(), <[f64]>::to_vec);
    let by = match curves.go_by_deviator_strain(rows) {
        true => of(curves.column("deviator_strain")),
        false => strains.to_vec(),
    };
    let mean = |values: &[f64]| late_mean(&by, &of(values));
    add("late_deviator_fabric", mean(curves.column("deviator_fabric")));
    add("late_solid_fraction", mean(curves.column("solid_fraction")));
    if !carries[late.clone()].iter().all(|carries| *carries) {
        return;
    }
    let ratio = if curves.axis().is_some() { "late_stress_ratio" } else { "late_von_mises_ratio" };
    add(ratio, mean(&curves.stress_ratio()));
    if !curves.tells_strength(rows) {
        return;
    }
    add("critical_friction_angle", mean(&curves.friction_angle()));
    for (name, values) in [
        ("critical_void_ratio", curves.void_ratio()),
        ("critical_mean_stress", curves.mean_stress().to_vec()),
    ] {
        add(name, mean(&values));
        let drift = of(&values).get(late.clone()).and_then(|values| slope(&strains[late.clone()], values));
        add(&format!("{name}_drift"), drift);
    }
}

/// Adds the largest friction angle of states that carry stress.
pub(super) fn add_friction(
    curves: &Curves,
    rows: &Range<usize>,
    carries: &[bool],
    measures: &mut BTreeMap<String, f64>,
) {
    let angles = curves.friction_angle();
    let strong = rows.clone().zip(carries).filter(|(_, carries)| **carries).map(|(row, _)| angles[row]);
    let largest = strong.filter(|angle| angle.is_finite()).fold(f64::NAN, f64::max);
    if largest.is_finite() {
        measures.insert("peak_friction_angle".into(), largest);
    }
}

/// Adds the largest dilatancy angle of a drained test whose strain grows.
pub(super) fn add_dilatancy(curves: &Curves, rows: &Range<usize>, measures: &mut BTreeMap<String, f64>) {
    if rows.clone().any(|row| curves.undrained_from(row).is_some()) {
        return;
    }
    let strains = curves.deviatoric_strain(rows.start);
    let mut largest = f64::NAN;
    for from in rows.clone().filter(|row| strains[*row] >= DILATANCY_FROM) {
        let Some(to) = (from + 1..rows.end).find(|to| strains[*to] >= strains[from] + DILATANCY_WINDOW)
        else {
            break;
        };
        let grows = strains[from..=to].windows(2).all(|pair| pair[1] > pair[0]);
        if grows {
            largest = largest.max(angle(curves, from, to));
        }
    }
    if largest.is_finite() {
        measures.insert("largest_dilatancy_angle".into(), largest);
    }
}

/// Dilatancy angle between two rows, degrees; the lateral strains of an axisymmetric test are averaged.
fn angle(curves: &Curves, from: usize, to: usize) -> f64 {
    let mut increment = curves.strain(to, from);
    if let Some(axis) = curves.axis() {
        let [b, c] = symmetry::others(axis);
        let lateral = 0.5 * (increment[b][b] + increment[c][c]);
        let axial = increment[axis][axis];
        increment = [[0.0; 3]; 3];
        increment[axis][axis] = axial;
        (increment[b][b], increment[c][c]) = (lateral, lateral);
    }
    dilatancy_angle(&increment)
}
