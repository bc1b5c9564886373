//! Liquefaction of undrained tests.
//!
//! A sample has liquefied where the ratio `r_u = 1 - p/p_0` of the excess pore pressure reaches 0.95, or, in a cyclic test, where the
//! double amplitude of the axial strain reaches 5 % (Seed and Lee 1966; Ishihara 1993, who calls the second one the state of
//! cyclic softening of samples that do not lose all of their stress). p_0 is the mean stress at the start of the undrained part.

use std::collections::BTreeMap;
use std::ops::Range;

use granum_dem::loading::{Measure, Reason, StageEnd, Until};

use super::curves::Curves;

/// Ratio r_u of the excess pore pressure at which a sample has liquefied.
pub const LIQUEFIED_RATIO: f64 = 0.95;
/// Double amplitude of the axial strain at which a cyclic test counts as liquefied.
pub const LIQUEFIED_DOUBLE_AMPLITUDE: f64 = 0.05;

/// True if a stage ended because its pore pressure ratio reached that of liquefaction, or its stress was gone: the last recorded
/// state is just before that.
pub(crate) fn ended_liquefied(end: &StageEnd) -> bool {
    matches!(end.reason, Reason::End(Until::PorePressureRatio(ratio)) if ratio >= LIQUEFIED_RATIO)
        || matches!(end.reason, Reason::Unjammed { .. })
}

/// True if a stage ended at a mean stress that is that of liquefaction, with the mean stress at the start of the undrained part, Pa.
fn ended_at_no_stress(end: &StageEnd, start: Option<f64>) -> bool {
    match (end.reason, start) {
        (Reason::End(Until::Reaches { measure: Measure::MeanStress, value }), Some(start)) => {
            value <= (1.0 - LIQUEFIED_RATIO) * start
        }
        _ => false,
    }
}

/// The first row of a range that has liquefied by its pore pressure.
pub(super) fn first_liquefied(
    ratios: &[f64],
    rows: &Range<usize>,
    ends: &[StageEnd],
    curves: &Curves,
) -> Option<usize> {
    let by_state = rows.clone().find(|row| ratios[*row] >= LIQUEFIED_RATIO);
    let last = rows.end.checked_sub(1)?;
    let by_end = || {
        let undrained = ratios[last].is_finite();
        let start = curves.undrained_from(last).and_then(|start| curves.mean_stress().get(start).copied());
        let end = ends.get(curves.stage_index(last));
        (undrained && end.is_some_and(|end| ended_liquefied(end) || ended_at_no_stress(end, start)))
            .then_some(last)
    };
    by_state.or_else(by_end)
}

/// Adds the pore pressure and the liquefaction of an undrained test to the measures; `strain` is that at which it happened.
pub(super) fn add(
    curves: &Curves,
    rows: &Range<usize>,
    ends: &[StageEnd],
    measures: &mut BTreeMap<String, f64>,
) {
    let ratios = curves.pore_pressure_ratio();
    let largest =
        ratios[rows.clone()].iter().copied().filter(|ratio| ratio.is_finite()).fold(f64::NAN, f64::max);
    if !largest.is_finite() {
        return;
    }
    let row = first_liquefied(&ratios, rows, ends, curves);
    measures.insert("largest_pore_pressure_ratio".into(), largest);
    measures.insert("liquefied".into(), f64::from(u8::from(row.is_some())));
    let is_cyclic = rows.clone().filter_map(|row| curves.stage(row)).any(|stage| stage.turns.is_some());
    let Some(row) = row.filter(|_| !is_cyclic) else { return };
    let (name, strains) = match curves.axis() {
        Some(_) => ("axial_strain_at_liquefaction", curves.axial_strain(rows.start)),
        None => ("deviatoric_strain_at_liquefaction", curves.deviatoric_strain(rows.start)),
    };
    measures.insert(name.into(), crossing(&strains, &ratios, row));
}

/// The strain at which r_u reached the ratio of liquefaction, between a row and the one before.
fn crossing(strains: &[f64], ratios: &[f64], row: usize) -> f64 {
    let Some(before) = row.checked_sub(1).filter(|before| ratios[*before] < LIQUEFIED_RATIO) else {
        return strains[row];
    };
    let share = (LIQUEFIED_RATIO - ratios[before]) / (ratios[row] - ratios[before]);
    let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 1.0 };
    strains[before] + share * (strains[row] - strains[before])
}
