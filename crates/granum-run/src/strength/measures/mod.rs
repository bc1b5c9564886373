//! All measures of a test by name.

use std::collections::BTreeMap;

use granum_dem::loading::{Stage, StageEnd};
use granum_io::{Case, RunRecord};
use granum_sensors::Record;

use super::curves::Curves;
use super::{cohesion_of, criticality, cyclic, liquefaction, monotonic, stiffness, unconfined};

/// The measures of a test with the given stages ([`granum_io::Case::test_stages`]), by the names of [`super::MEASURES`]. `ends` are the
/// ends of its stages, as far as they are known: they tell of a state that was reached just after the last recorded one.
pub fn of_test(record: &Record, stages: &[Stage], ends: &[StageEnd]) -> BTreeMap<String, f64> {
    let curves = Curves::new(record, stages);
    let mut measures = BTreeMap::new();
    let rows = curves.test_rows();
    if rows.is_empty() {
        return measures;
    }
    let carries = curves.carry_stress(&rows);
    let fabric = curves.column("deviator_fabric").get(rows.clone()).unwrap_or(&[]);
    let largest = fabric.iter().copied().filter(|value| value.is_finite()).fold(f64::NAN, f64::max);
    if largest.is_finite() {
        measures.insert("peak_deviator_fabric".into(), largest);
    }
    monotonic::add_peak(&curves, &rows, &mut measures);
    let turns = rows.clone().filter_map(|row| curves.stage(row)).any(|stage| stage.turns.is_some());
    if !turns {
        monotonic::add_late(&curves, &rows, &carries, &mut measures);
    }
    if measures.contains_key("critical_void_ratio") {
        let is_critical = criticality::ended_critical(ends)
            || criticality::of_rows(&curves, &rows).is_ok_and(|change| change.is_critical());
        measures.insert("at_critical_state".into(), f64::from(u8::from(is_critical)));
    }
    if curves.tells_strength(&rows) {
        monotonic::add_friction(&curves, &rows, &carries, &mut measures);
        if !turns {
            monotonic::add_dilatancy(&curves, &rows, &mut measures);
            stiffness::add(&curves, &rows, &carries, &mut measures);
        }
        liquefaction::add(&curves, &rows, ends, &mut measures);
        cyclic::add(&curves, &rows, ends, &mut measures);
    }
    unconfined::add(&curves, stages, ends, &mut measures);
    measures
}

/// The measures of a run from its record and its `run.json`, also of one that an earlier version made or that has not ended: what
/// follows from the series alone is found anew, and what also needs to know how its stages ended is taken from `run.json`.
pub fn of_run(case: &Case, about: &RunRecord, record: &Record) -> BTreeMap<String, f64> {
    let mut measures = of_test(record, &case.test_stages(), &[]);
    let needs_ends = |name: &str| {
        ["cycles", "liquef", "double_amplitude", "tensile_strength", "at_critical_state"]
            .iter()
            .any(|part| name.contains(part))
            && !name.starts_with("preparation")
    };
    let recorded = about.measures.iter().filter(|(name, _)| needs_ends(name));
    measures.extend(recorded.map(|(name, value)| (name.clone(), *value)));
    measures.extend(cohesion_of(case));
    measures
}

#[cfg(test)]
mod tests;
