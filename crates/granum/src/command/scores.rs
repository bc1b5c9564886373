//! Scores of mappings as readable lines of text.

use std::collections::BTreeMap;

use granum_antony2006::summary::MappingSummary;
use granum_core::words::{self, percentage};
use granum_learn::student_t::PairedTest;

/// A fraction as a percentage, or a dash if there is none, to the right of a column.
pub fn percent_or_dash(share: Option<f64>) -> String {
    format!("{:>8}", share.map_or("-".to_owned(), percentage))
}

/// A mean difference and its standard error in percentage points.
pub fn points(test: Option<PairedTest>) -> String {
    let Some(test) = test else { return "-".to_owned() };
    let error = test.standard_error.map_or(String::new(), |error| format!(" ± {:.2}", 100.0 * error));
    format!("{}{error}", words::signed(100.0 * test.mean, 2))
}

/// The mappings with their errors, one line each below a heading, followed by their use of the sensors; `spread` is the name
/// of the difference between the runs.
pub fn lines(mappings: &BTreeMap<String, MappingSummary>, spread: &str) -> Vec<String> {
    let heading = format!(
        "{:<34} {:>8} {:>8} {:>11} {:>8} {:>10} {:>12}",
        "relative RMSE", "held out", "unseen", "strain only", "ridge", "mean curve", spread
    );
    let line = |(name, m): (&String, &MappingSummary)| {
        format!(
            "{name} {:<31} {} {} {:>11} {} {:>10} {:>12}",
            m.formula,
            percent_or_dash(Some(m.relative_rmse.held_out)),
            percent_or_dash(m.relative_rmse.unseen),
            percent_or_dash(Some(m.relative_rmse.strain_only)),
            percent_or_dash(m.ridge),
            percent_or_dash(m.mean_curve),
            percent_or_dash(m.seed_scatter),
        )
    };
    let mut lines: Vec<String> = std::iter::once(heading).chain(mappings.iter().map(line)).collect();
    lines.extend(sensor_lines(mappings));
    lines.extend(mappings.iter().filter_map(|(name, mapping)| constants(name, mapping)));
    lines
}

/// Lines on the use that the mappings make of the sensors of unseen runs; empty without unseen runs.
fn sensor_lines(mappings: &BTreeMap<String, MappingSummary>) -> Vec<String> {
    if mappings.values().all(|m| m.with_permuted_sensors.is_none()) {
        return Vec::new();
    }
    let rows = mappings.iter().map(|(name, m)| SensorRow {
        name: name.clone(),
        own: m.relative_rmse.unseen,
        with_other: m.with_other_sensors,
        permuted: m.with_permuted_sensors,
        lost: m.sensor_use,
        help: m.help,
        verdict: m.verdict.to_string(),
    });
    sensor_table(&rows.collect::<Vec<_>>())
}

/// Errors of a mapping on unseen runs with sensors of different origin.
pub struct SensorRow {
    pub name: String,
    pub own: Option<f64>,
    pub with_other: Option<f64>,
    pub permuted: Option<f64>,
    pub lost: Option<PairedTest>,
    pub help: Option<PairedTest>,
    pub verdict: String,
}

/// Errors with sensors of different origin: a heading, one line for each mapping, and an explanation.
pub fn sensor_table(rows: &[SensorRow]) -> Vec<String> {
    let mut lines = vec![format!(
        "{:<8} {:>8} {:>11} {:>8}   {:>15} {:>15}   verdict",
        "sensors", "its own", "another run", "permuted", "use", "help"
    )];
    lines.extend(rows.iter().map(|row| {
        format!(
            "{:<8} {} {:>11} {}   {:>15} {:>15}   {}",
            row.name,
            percent_or_dash(row.own),
            percent_or_dash(row.with_other),
            percent_or_dash(row.permuted),
            points(row.lost),
            points(row.help),
            row.verdict,
        )
    }));
    let runs = rows.iter().filter_map(|row| row.lost.or(row.help)).map(|test| test.runs).max().unwrap_or(0);
    let plural = if runs == 1 { "" } else { "s" };
    lines.push(format!(
        "use: error with the sensors of another unseen run minus error with its own; help: error of the strain-only networks \
         minus that of the networks; percentage points, mean ± standard error over {runs} unseen run{plural}, one-sided t test \
         at 5 %"
    ));
    lines
}

/// A line that names the networks which predict a constant.
fn constants(name: &str, mapping: &MappingSummary) -> Option<String> {
    let numbers: Vec<String> = (mapping.sub_models.iter().enumerate())
        .filter(|(_, sub_model)| sub_model.constant)
        .map(|(k, _)| format!("{name}-{}", k + 1))
        .collect();
    let verb =
        if numbers.len() == 1 { "predicts a constant: it has" } else { "predict constants: they have" };
    (!numbers.is_empty()).then(|| format!("{} {verb} learned nothing", numbers.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_that_rounds_to_zero_has_no_minus() {
        assert_eq!(points(PairedTest::new(&[-1e-6])), "+0.00");
        assert_eq!(points(PairedTest::new(&[-0.01, -0.02])), "-1.50 ± 0.50");
        assert_eq!(points(None), "-");
    }
}
