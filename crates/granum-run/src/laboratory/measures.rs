//! Summary of a finished test in a few numbers: peak and late values.

use std::collections::BTreeMap;
use std::ops::Range;

use granum_dem::loading::{Drive, Stage};
use granum_sensors::Record;

/// Fraction of the strain, at the end of a test, over which late values are averaged.
pub const LATE: f64 = 0.25;

/// Mean of recorded values over the last quarter of the strain, with linear interpolation between states; `None` if there
/// are fewer than two states in it.
///
/// The mean is weighted by strain, so that it does not depend on the spacing of the states.
pub fn late_mean(strains: &[f64], values: &[f64]) -> Option<f64> {
    let points: Vec<(f64, f64)> = (strains.iter().copied().zip(values.iter().copied()))
        .filter(|(strain, value)| strain.is_finite() && value.is_finite())
        .collect();
    let from = (1.0 - LATE) * points.last()?.0;
    let (mut area, mut length) = (0.0, 0.0);
    for pair in points.windows(2) {
        let ((a, at_a), (b, at_b)) = (pair[0], pair[1]);
        if b <= from || b <= a {
            continue;
        }
        let begin = a.max(from);
        let at_begin = at_a + (at_b - at_a) * (begin - a) / (b - a);
        area += 0.5 * (at_begin + at_b) * (b - begin);
        length += b - begin;
    }
    (length > 0.0).then(|| area / length)
}

/// The rows of the series in which peak and late values are sought: all of the paper's test, and of a list of stages those of
/// the last stage with two states or more, since a stage may begin a new count of strain.
fn rows_of_test(record: &Record) -> Range<usize> {
    let numbers = record.series.values("stage").unwrap_or(&[]);
    let mut end = numbers.len();
    while end > 0 {
        let start =
            numbers[..end].iter().rposition(|number| *number != numbers[end - 1]).map_or(0, |row| row + 1);
        if end - start >= 2 {
            return start..end;
        }
        end = start;
    }
    0..record.series.rows()
}

/// These rows of a column; nothing if there is no such column.
fn column<'a>(record: &'a Record, name: &str, rows: &Range<usize>) -> &'a [f64] {
    record.series.values(name).and_then(|values| values.get(rows.clone())).unwrap_or(&[])
}

/// Adds the peak and late values of a test to the measures of its run: those of the paper's stress ratio and deviator
/// strain, or those of the invariants if the test is defined as a list of stages.
pub(super) fn of_test(record: &Record, measures: &mut BTreeMap<String, f64>) {
    let rows = rows_of_test(record);
    let column = |name: &str| column(record, name, &rows);
    let (strain, ratio) = match record.series.values("von_mises_ratio") {
        Some(_) => ("deviatoric_strain", "von_mises_ratio"),
        None => ("deviator_strain", "stress_ratio"),
    };
    let strains = column(strain);
    // The signed von Mises stress may change its sign in a test that is neither triaxial compression nor extension.
    let ratios: Vec<f64> = match strain {
        "deviatoric_strain" => column(ratio).iter().map(|value| value.abs()).collect(),
        _ => column(ratio).to_vec(),
    };
    let peak =
        (0..ratios.len()).filter(|k| ratios[*k].is_finite()).max_by(|a, b| ratios[*a].total_cmp(&ratios[*b]));
    if let Some(peak) = peak {
        measures.insert("peak_stress_ratio".into(), ratios[peak]);
        for (name, column) in [
            (format!("{strain}_at_peak").as_str(), strain),
            ("deviator_fabric_at_peak", "deviator_fabric"),
            ("solid_fraction_at_peak", "solid_fraction"),
        ] {
            if let Some(value) = self::column(record, column, &rows).get(peak) {
                measures.insert(name.into(), *value);
            }
        }
    }
    let largest =
        column("deviator_fabric").iter().copied().filter(|value| value.is_finite()).fold(f64::NAN, f64::max);
    if largest.is_finite() {
        measures.insert("peak_deviator_fabric".into(), largest);
    }
    for (name, values) in [
        ("late_stress_ratio", ratios.as_slice()),
        ("late_deviator_fabric", column("deviator_fabric")),
        ("late_solid_fraction", column("solid_fraction")),
    ] {
        if let Some(mean) = late_mean(strains, values) {
            measures.insert(name.into(), mean);
        }
    }
}

/// Adds the ratio of lateral to axial stress at the end of every oedometric stage to the measures, as `k0_` and the name of the
/// stage, with its number where stages have one name.
pub(super) fn of_oedometers(record: &Record, stages: &[Stage], measures: &mut BTreeMap<String, f64>) {
    let column = |name: &str| record.series.values(name).unwrap_or(&[]);
    let numbers = column("stage");
    let stresses = ["stress_11", "stress_22", "stress_33"].map(column);
    for (k, stage) in stages.iter().enumerate().filter(|(_, stage)| is_oedometric(stage)) {
        let last = numbers.iter().rposition(|number| *number == (k + 1) as f64);
        let Some([axial, y, z]) =
            last.map(|row| stresses.map(|stress| stress.get(row).copied().unwrap_or(0.0)))
        else {
            continue;
        };
        if axial > 0.0 {
            let name: String = stage
                .name
                .chars()
                .map(|c| if c.is_alphanumeric() { c.to_ascii_lowercase() } else { '_' })
                .collect();
            let ratio = 0.5 * (y + z) / axial;
            // Stages of one name, as of a path that is repeated, are distinguished by their numbers.
            let key = format!("k0_{name}");
            let key = if measures.contains_key(&key) { format!("{key}_{}", k + 1) } else { key };
            measures.insert(key, ratio);
        }
    }
}

/// True if axis x alone is strained.
fn is_oedometric(stage: &Stage) -> bool {
    let [x, others @ ..] = &stage.control.components;
    !matches!(x, Drive::Fixed | Drive::Free) && others.iter().all(|drive| *drive == Drive::Fixed)
}

#[cfg(test)]
mod tests {
    use granum_core::{Column, Table};

    use super::*;

    /// A stage may begin a new count of strain, so that the strains of two stages are not those of one curve.
    #[test]
    fn peak_and_late_values_are_those_of_the_last_stage_with_states() {
        let column = |name: &str, values: &[f64]| Column::new(name, "", values.to_vec());
        let series = Table::new(vec![
            column("stage", &[1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 3.0]),
            column("deviatoric_strain", &[0.0, 0.1, 0.2, 0.0, 0.1, 0.2, 0.0]),
            column("von_mises_ratio", &[0.0, 0.9, 0.9, 0.0, -0.6, -0.5, 0.3]),
        ])
        .unwrap();
        let mut measures = BTreeMap::new();
        of_test(&Record { series, ..Record::default() }, &mut measures);
        assert_eq!(measures["peak_stress_ratio"], 0.6);
        assert_eq!(measures["deviatoric_strain_at_peak"], 0.1);
        assert!((measures["late_stress_ratio"] - 0.525).abs() < 1e-12, "{measures:?}");
    }

    #[test]
    fn late_is_the_last_quarter_of_the_strain_however_states_are_spaced() {
        let line = |strains: &[f64]| {
            let values: Vec<f64> = strains.iter().map(|strain| 1.0 - strain).collect();
            late_mean(strains, &values).unwrap()
        };
        // The exact value is the mean of 1 - x from 0.3 to 0.4.
        for strains in [&[0.0, 0.1, 0.2, 0.3, 0.4][..], &[0.0, 0.001, 0.01, 0.4], &[0.0, 0.31, 0.39, 0.4]] {
            assert!((line(strains) - 0.65).abs() < 1e-12, "{strains:?}");
        }
        assert_eq!(late_mean(&[0.1], &[1.0]), None);
        assert_eq!(late_mean(&[], &[]), None);
        assert!((late_mean(&[0.0, 0.1, 0.2], &[0.0, f64::NAN, 0.8]).unwrap() - 0.7).abs() < 1e-12);
    }
}
