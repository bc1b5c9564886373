//! Whether the end of a test is a critical state: how much it still changes from one window of strain to the next.
//!
//! The limits are those of the end condition `critical_state` of a stage: over an arc length of strain of 0.05 q/p changes by less than
//! 0.02 and the volumetric strain by less than 0.002; where the volume is kept, the mean stress, too, changes by less than 2 %. The
//! mean over the last window is compared with that over the window before it, so that the fluctuations of a sample of some hundred
//! grains do not decide: a steady change is the same from window to window as within one.

use std::ops::Range;

use granum_dem::loading::{Reason, Stage, StageEnd, Until};
use granum_io::case::{CRITICAL_STRESS_RATIO, CRITICAL_VOLUMETRIC_STRAIN, CRITICAL_WINDOW};
use granum_sensors::Record;

use super::curves::Curves;

/// Relative change of the mean stress over a window below which an undrained state is critical.
pub const CRITICAL_MEAN_STRESS: f64 = 0.02;

/// What the end of a test changes by, from the last but one to the last window of strain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LateChange {
    /// Change of q/p.
    pub stress_ratio: f64,
    /// Change of the volumetric strain.
    pub volumetric_strain: f64,
    /// Relative change of the mean stress of an undrained test; `None` for a drained one.
    pub mean_stress: Option<f64>,
}

impl LateChange {
    /// True if it is within the limits of the critical state.
    pub fn is_critical(&self) -> bool {
        self.stress_ratio.abs() < CRITICAL_STRESS_RATIO
            && self.volumetric_strain.abs() < CRITICAL_VOLUMETRIC_STRAIN
            && self.mean_stress.is_none_or(|change| change.abs() < CRITICAL_MEAN_STRESS)
    }

    /// What of it is beyond its limits, in words; empty for a critical state.
    pub fn excess(&self) -> String {
        let mut parts = Vec::new();
        // What is no number is beyond every limit.
        let within = |change: f64, limit: f64| change.abs() < limit;
        if !within(self.stress_ratio, CRITICAL_STRESS_RATIO) {
            parts.push(format!("{:+.3} in q/p (limit {CRITICAL_STRESS_RATIO})", self.stress_ratio));
        }
        if !within(self.volumetric_strain, CRITICAL_VOLUMETRIC_STRAIN) {
            parts.push(format!(
                "{:+.4} in the volumetric strain (limit {CRITICAL_VOLUMETRIC_STRAIN})",
                self.volumetric_strain
            ));
        }
        if let Some(change) = self.mean_stress.filter(|change| !within(*change, CRITICAL_MEAN_STRESS)) {
            parts.push(format!("{:+.1} % in p (limit {} %)", 100.0 * change, 100.0 * CRITICAL_MEAN_STRESS));
        }
        match parts.is_empty() {
            true => String::new(),
            false => format!(
                "over the last {CRITICAL_WINDOW} of strain there is still a change of {}",
                parts.join(" and ")
            ),
        }
    }
}

/// How much the end of a test with these stages still changes.
///
/// # Errors
/// A sentence where it cannot be told, as of a test that is too short.
pub fn late_change(record: &Record, stages: &[Stage]) -> Result<LateChange, String> {
    let curves = Curves::new(record, stages);
    of_rows(&curves, &curves.test_rows())
}

/// The same of some rows.
pub(super) fn of_rows(curves: &Curves, rows: &Range<usize>) -> Result<LateChange, String> {
    let mut arc = vec![0.0];
    for row in rows.clone().skip(1) {
        let step = curves.strain(row, row - 1);
        let square: f64 = step.iter().flatten().map(|part| part * part).sum();
        arc.push(arc[arc.len() - 1] + (2.0 / 3.0 * square).sqrt());
    }
    let last = arc[arc.len() - 1];
    let [middle, first] = [last - CRITICAL_WINDOW, last - 2.0 * CRITICAL_WINDOW];
    if rows.len() < 2 || first < -1e-9 {
        return Err(format!(
            "it is too short to tell: its shear has an arc length of strain of {last:.3}, and two windows of {CRITICAL_WINDOW} are \
             compared"
        ));
    }
    let values = |values: &[f64]| values.get(rows.clone()).map_or(Vec::new(), <[f64]>::to_vec);
    let means = |of: &[f64]| {
        let of = values(of);
        [mean_between(&arc, &of, first, middle), mean_between(&arc, &of, middle, last)]
    };
    let change = |of: &[f64]| {
        let [before, after] = means(of);
        after - before
    };
    let is_undrained = curves.undrained_from(rows.end - 1).is_some();
    let [before, after] = means(curves.mean_stress());
    Ok(LateChange {
        stress_ratio: change(&curves.stress_ratio()),
        volumetric_strain: change(&curves.volumetric_strain(rows.start)),
        mean_stress: is_undrained.then(|| after / before - 1.0),
    })
}

/// True if the test ended in a critical state by the end condition of its last stage, within the limits or narrower ones.
pub(super) fn ended_critical(ends: &[StageEnd]) -> bool {
    let Some(Reason::End(Until::CriticalState { window, stress_ratio, volumetric_strain })) =
        ends.last().map(|end| end.reason)
    else {
        return false;
    };
    window >= CRITICAL_WINDOW
        && stress_ratio <= CRITICAL_STRESS_RATIO
        && volumetric_strain <= CRITICAL_VOLUMETRIC_STRAIN
}

/// Mean of y over x from one value to another, with linear interpolation; NaN where there is nothing between them.
fn mean_between(xs: &[f64], ys: &[f64], from: f64, to: f64) -> f64 {
    let (mut area, mut length) = (0.0, 0.0);
    for (x, y) in xs.windows(2).zip(ys.windows(2)) {
        let [low, high] = [x[0].max(from), x[1].min(to)];
        if high <= low {
            continue;
        }
        let at = |here: f64| y[0] + (y[1] - y[0]) * (here - x[0]) / (x[1] - x[0]);
        area += 0.5 * (at(low) + at(high)) * (high - low);
        length += high - low;
    }
    if length > 0.0 { area / length } else { f64::NAN }
}

#[cfg(test)]
mod tests {
    use super::super::test_records::{drained_stages, triaxial, undrained_stages};
    use super::*;

    /// A drained test at 100 kPa whose q/p and volume change steadily, per unit of arc length; an axial strain of x with lateral ones of
    /// -x/2 is an arc length of x.
    fn drained(ratio: f64, volume: f64, to: f64) -> Record {
        let rows = (0..=100).map(|k| {
            let x = to * f64::from(k) / 100.0;
            let q_over_p = 1.0 + ratio * (x - to);
            let p = 100.0 / (1.0 - q_over_p / 3.0);
            [x, 0.5 * (volume * x - x), p, q_over_p * p]
        });
        triaxial(rows, 0.6)
    }

    #[test]
    fn a_steady_change_is_that_of_a_window() {
        let stages = drained_stages();
        let change = late_change(&drained(0.3, -0.02, 0.3), &stages).unwrap();
        assert!((change.stress_ratio - 0.3 * 0.05).abs() < 1e-4, "{change:?}");
        assert!((change.volumetric_strain + 0.02 * 0.05).abs() < 1e-5, "{change:?}");
        assert!(change.is_critical() && change.mean_stress.is_none() && change.excess().is_empty());
        let rising = late_change(&drained(0.5, -0.02, 0.3), &stages).unwrap();
        assert!(!rising.is_critical() && rising.excess().contains("+0.025 in q/p"), "{}", rising.excess());
        let dilating = late_change(&drained(0.0, -0.1, 0.3), &stages).unwrap();
        assert!(dilating.excess().contains("-0.0048 in the volumetric strain"), "{}", dilating.excess());
        let short = late_change(&drained(0.0, 0.0, 0.09), &stages).unwrap_err();
        assert!(short.contains("0.090") && short.contains("two windows of 0.05"), "{short}");
    }

    /// Fluctuations of a small sample about a steady value are no change.
    #[test]
    fn fluctuations_do_not_decide() {
        let rows = (0..=200).map(|k| {
            let x = 0.0015 * f64::from(k);
            let q = 150.0 + if k % 4 < 2 { 3.0 } else { -3.0 };
            [x, -0.5 * x, 150.0, q]
        });
        let change = late_change(&triaxial(rows, 0.6), &drained_stages()).unwrap();
        assert!(change.is_critical(), "{change:?}");
    }

    #[test]
    fn an_undrained_state_is_critical_where_its_mean_stress_stays() {
        let undrained = |rate: f64| {
            let rows = (0..=100).map(|k| {
                let x = 0.003 * f64::from(k);
                let p = 100.0 * (1.0 + rate * x);
                [x, -0.5 * x, p, 1.2 * p]
            });
            late_change(&triaxial(rows, 0.6), &undrained_stages()).unwrap()
        };
        assert!(undrained(0.1).is_critical(), "{:?}", undrained(0.1));
        let rising = undrained(2.0);
        assert!(!rising.is_critical() && rising.excess().contains("% in p"), "{}", rising.excess());
    }
}
