//! Cycles: how many there were, their double amplitude of axial strain, and how many it took to liquefy.
//!
//! Cycles are counted in half cycles between the turning points of what the stage turns at, as its engine does: a cycle has two
//! turning points. What happens in the k-th half cycle happens after `k/2` cycles. The double amplitude of the axial strain is its
//! change from one turning point to the next, or from the last one to the present state (ASTM D5311).

use std::collections::BTreeMap;
use std::ops::Range;

use granum_dem::loading::{Measure, Reason, StageEnd, Turns, Until};

use super::curves::Curves;
use super::liquefaction::{LIQUEFIED_DOUBLE_AMPLITUDE, first_liquefied};

/// Share of the range between the turning points by which a curve must come back for a turning point to be seen.
const COMES_BACK: f64 = 0.5;
/// Share of that range within which the end of a curve counts as having reached the next turning point.
const REACHED: f64 = 0.05;

/// The column of a measure; `None` for one that has none.
fn column_of(measure: Measure) -> Option<&'static str> {
    const STRAINS: [&str; 6] = [
        "axial_strain",
        "lateral_strain_2",
        "lateral_strain_3",
        "shear_strain_yz",
        "shear_strain_zx",
        "shear_strain_xy",
    ];
    const STRESSES: [&str; 6] =
        ["stress_11", "stress_22", "stress_33", "stress_23", "stress_31", "stress_12"];
    Some(match measure {
        Measure::Strain(k) => STRAINS.get(usize::from(k)).copied()?,
        Measure::Stress(k) => STRESSES.get(usize::from(k)).copied()?,
        Measure::AxialDeviatorStrain => "deviator_strain",
        Measure::VolumetricStrain => "volumetric_strain",
        Measure::DeviatoricStrain => "deviatoric_strain",
        Measure::MeanStress => "mean_stress",
        Measure::DeviatorStress => "von_mises_stress",
        Measure::AxialDeviatorStress => "deviator_stress",
        Measure::StressRatio => "von_mises_ratio",
        Measure::ArcLength | Measure::Time => return None,
    })
}

/// The rows at which values turn round between two levels, the upper one first; the last row is one of them if it has reached the
/// next level.
fn turning_rows(values: &[f64], turns: &Turns) -> Vec<usize> {
    let range = turns.high - turns.low;
    let mut found = Vec::new();
    let mut extreme = 0;
    for (row, value) in values.iter().enumerate() {
        let up = found.len().is_multiple_of(2);
        let sense = if up { 1.0 } else { -1.0 };
        if sense * (value - values[extreme]) > 0.0 {
            extreme = row;
        } else if sense * (values[extreme] - value) > COMES_BACK * range {
            found.push(extreme);
            extreme = row;
        }
    }
    let level = if found.len().is_multiple_of(2) { turns.high } else { turns.low };
    let reached = values.get(extreme).is_some_and(|value| (value - level).abs() <= REACHED * range);
    if reached {
        found.push(extreme);
    }
    found
}

/// What is counted in one cyclic stage.
struct Cycles {
    /// Rows of the turning points, counted in the whole record.
    turning: Vec<usize>,
    rows: Range<usize>,
}

impl Cycles {
    /// Number of cycles after which something happens in a row: that of the half cycles begun, over two.
    fn at(&self, row: usize) -> f64 {
        let before = self.turning.iter().filter(|turning| **turning < row).count();
        0.5 * (before + 1) as f64
    }

    /// The change of a strain from the last turning point before each row; zero before the first one.
    fn double_amplitudes(&self, strains: &[f64]) -> Vec<f64> {
        let since = |row: usize| self.turning.iter().rev().find(|turning| **turning < row);
        self.rows
            .clone()
            .map(|row| since(row).map_or(0.0, |last| (strains[row] - strains[*last]).abs()))
            .collect()
    }
}

fn cycles(curves: &Curves, rows: &Range<usize>) -> Option<(Cycles, usize)> {
    let first = rows.clone().find(|row| curves.stage(*row).is_some_and(|stage| stage.turns.is_some()))?;
    let stage = curves.stage_index(first);
    let turns = curves.stage(first)?.turns?;
    let end = (first..rows.end).find(|row| curves.stage_index(*row) != stage).unwrap_or(rows.end);
    let values = curves.column(column_of(turns.measure)?).get(first..end)?;
    let turning = turning_rows(values, &turns).into_iter().map(|row| first + row).collect();
    Some((Cycles { turning, rows: first..end }, stage))
}

/// Adds the number of cycles, their double amplitude and the cycles to liquefaction to the measures of a test with a cyclic stage (of
/// several the first).
pub(super) fn add(
    curves: &Curves,
    rows: &Range<usize>,
    ends: &[StageEnd],
    measures: &mut BTreeMap<String, f64>,
) {
    let Some((cycles, stage)) = cycles(curves, rows) else { return };
    let reason = ends.get(stage).map(|end| end.reason);
    let counted = 0.5 * cycles.turning.len() as f64;
    let count = match reason {
        Some(Reason::End(Until::Reversals(reversals))) => 0.5 * reversals as f64,
        _ => counted,
    };
    measures.insert("cycles".into(), count);
    let mut by_strain = None;
    if curves.axis().is_some() {
        let amplitudes = cycles.double_amplitudes(&curves.axial_strain(cycles.rows.start));
        let mut largest = amplitudes.iter().copied().fold(0.0, f64::max);
        by_strain = amplitudes.iter().position(|value| *value >= LIQUEFIED_DOUBLE_AMPLITUDE);
        // The stage ends at the step that reaches it, and its last state is a mean over steps before that one.
        if let Some(Reason::End(Until::DoubleAmplitude { measure: Measure::Strain(_), value })) = reason {
            largest = largest.max(value);
            let reached = value >= LIQUEFIED_DOUBLE_AMPLITUDE;
            by_strain = by_strain.or_else(|| reached.then(|| amplitudes.len().saturating_sub(1)));
        }
        measures.insert("double_amplitude_axial_strain".into(), largest);
    }
    let undrained = curves.undrained_from(cycles.rows.start).is_some();
    if !undrained {
        return;
    }
    let by_strain = by_strain.map(|place| cycles.at(cycles.rows.start + place));
    let by_pressure =
        first_liquefied(&curves.pore_pressure_ratio(), &cycles.rows, ends, curves).map(|row| cycles.at(row));
    for (name, number) in [
        ("cycles_to_pore_pressure_ratio_95", by_pressure),
        ("cycles_to_double_amplitude_5_percent", by_strain),
        ("cycles_to_liquefaction", [by_pressure, by_strain].into_iter().flatten().reduce(f64::min)),
    ] {
        if let Some(number) = number {
            measures.insert(name.into(), number);
        }
    }
    if by_strain.is_some() {
        measures.insert("liquefied".into(), 1.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turning_points_are_counted_as_the_engine_counts_them() {
        let turns = Turns { measure: Measure::AxialDeviatorStress, high: 1.0, low: -1.0 };
        // Three and a half cycles of a triangular wave with small waves on it, in steps of an eighth of the range.
        let wave = |k: usize| {
            let phase = (k as f64 / 16.0 + 0.25).fract();
            (1.0 - 4.0 * (phase - 0.5).abs()) + if k.is_multiple_of(2) { 0.04 } else { -0.04 }
        };
        let values: Vec<f64> = (0..=16 * 3 + 4).map(wave).collect();
        let rows = turning_rows(&values, &turns);
        assert_eq!(rows.len(), 7, "{rows:?} {values:?}");
        assert!(rows.iter().enumerate().all(|(k, row)| row.abs_diff(4 + 8 * k) <= 1), "{rows:?}");
        // Without the last way to the upper level there are six.
        assert_eq!(turning_rows(&values[..48], &turns).len(), 6);
        assert!(turning_rows(&[], &turns).is_empty());
    }

    #[test]
    fn amplitudes_count_from_the_last_turning_point() {
        let cycles = Cycles { turning: vec![1, 3], rows: 0..5 };
        let found = cycles.double_amplitudes(&[0.0, 0.01, 0.0, -0.02, 0.0]);
        for (value, wanted) in found.iter().zip([0.0, 0.0, 0.01, 0.03, 0.02]) {
            assert!((value - wanted).abs() < 1e-15, "{found:?}");
        }
        assert_eq!([0, 2, 3, 4].map(|row| cycles.at(row)), [0.5, 1.0, 1.0, 1.5]);
    }
}
