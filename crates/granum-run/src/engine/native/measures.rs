//! The ratio of lateral to axial stress of oedometric stages.

use std::collections::BTreeMap;

use granum_dem::loading::Stage;
use granum_io::run::StageEndRecord;
use granum_sensors::Record;

use crate::strength::symmetry::is_oedometric;

/// Adds the ratio of lateral to axial stress at the end of every oedometric stage to the measures, as `k0_` and the name of the
/// stage, with its number where stages have one name.
pub(in crate::engine) fn of_oedometers(
    record: &Record,
    stages: &[Stage],
    ends: &[StageEndRecord],
    measures: &mut BTreeMap<String, f64>,
) {
    let column = |name: &str| record.series.values(name).unwrap_or(&[]);
    let numbers = column("stage");
    let stresses = ["stress_11", "stress_22", "stress_33"].map(column);
    for (k, stage) in stages.iter().enumerate().filter(|(_, stage)| is_oedometric(stage)) {
        let end = ends.iter().find(|end| end.stage == k + 1).map(|end| [0, 1, 2].map(|k| end.stress[k][k]));
        // The mean over the last interval stands in where the end itself was not recorded.
        let of_interval = || {
            let row = numbers.iter().rposition(|number| *number == (k + 1) as f64)?;
            Some(stresses.map(|stress| stress.get(row).copied().unwrap_or(0.0)))
        };
        let Some([axial, y, z]) = end.or_else(of_interval) else { continue };
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
