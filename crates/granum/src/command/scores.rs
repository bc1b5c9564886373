//! Scores of mappings as lines for people.

use std::collections::BTreeMap;

use granum_hybrid::summary::MappingSummary;

/// A share as a percentage, a dash where there is none.
pub fn percent(share: Option<f64>) -> String {
    share.map_or_else(|| format!("{:>8}", "-"), |share| format!("{:6.2} %", 100.0 * share))
}

/// The mappings with their errors, a line each below a heading; `spread` is what the difference between the runs is called.
pub fn lines(mappings: &BTreeMap<String, MappingSummary>, spread: &str) -> Vec<String> {
    let heading = format!(
        "{:<34} {:>8} {:>8} {:>11} {:>12}",
        "relative RMSE", "held out", "unseen", "strain only", spread
    );
    let line = |(name, m): (&String, &MappingSummary)| {
        format!(
            "{name} {:<31} {} {} {:>11} {:>12}",
            m.formula,
            percent(Some(m.relative_rmse.held_out)),
            percent(m.relative_rmse.unseen),
            percent(Some(m.relative_rmse.strain_only)),
            percent(m.seed_scatter),
        )
    };
    std::iter::once(heading).chain(mappings.iter().map(line)).collect()
}
