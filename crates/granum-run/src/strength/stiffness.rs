//! Secant modulus E50 of a triaxial test: half of the largest change of the deviator stress over the axial strain at which it is
//! reached (Schanz, Vermeer and Bonnier 1999).
//!
//! It is found only where the lateral stresses are held, so that q over axial strain is a Young's modulus, and in undrained tests
//! under a name of its own. Where half of the strength is reached before the second recorded state, the straight line to it is
//! flatter than the curve, so that the value is only a lower bound and has another name.

use std::collections::BTreeMap;
use std::ops::Range;

use granum_dem::loading::{Drive, Stage};

use super::curves::Curves;
use super::symmetry;

/// True if the lateral stresses are held and the axis is strained.
fn is_conventional(stage: &Stage, axis: usize) -> bool {
    let drives = &stage.control.components;
    let held =
        |drive: Drive| matches!(drive, Drive::Stress(target) if target.rate == 0.0 && target.ramp.is_none());
    symmetry::others(axis).iter().all(|k| held(drives[*k]))
        && matches!(drives[axis], Drive::Rate(_) | Drive::Ramp(_))
        && stage.control.constraints.iter().flatten().next().is_none()
}

/// Adds E50 to the measures of a monotonic triaxial test. `carries` says which rows carry stress.
pub(super) fn add(
    curves: &Curves,
    rows: &Range<usize>,
    carries: &[bool],
    measures: &mut BTreeMap<String, f64>,
) {
    let Some(axis) = curves.axis() else { return };
    let mut stages = rows.clone().filter_map(|row| curves.stage(row));
    let name = if curves.undrained_from(rows.start).is_some() {
        "undrained_secant_modulus_50"
    } else if stages.all(|stage| is_conventional(stage, axis)) {
        "secant_modulus_50"
    } else {
        return;
    };
    let (q, strain) = (curves.deviator_stress(), curves.axial_strain(rows.start));
    let change = |row: usize| q[row] - q[rows.start];
    let strong = rows.clone().zip(carries).filter(|(row, carries)| **carries && change(*row).is_finite());
    let Some((peak, _)) = strong.max_by(|a, b| change(a.0).abs().total_cmp(&change(b.0).abs())) else {
        return;
    };
    let half = 0.5 * change(peak);
    let Some(row) = (rows.start + 1..=peak).find(|row| change(*row) / half >= 1.0) else { return };
    let (before, here) = (change(row - 1), change(row));
    let share = (half - before) / (here - before);
    let at = strain[row - 1] + share * (strain[row] - strain[row - 1]);
    let modulus = half / at;
    if !(modulus.is_finite() && modulus > 0.0) {
        return;
    }
    let coarse = row == rows.start + 1;
    measures.insert(if coarse { format!("{name}_at_least") } else { name.into() }, modulus);
}
