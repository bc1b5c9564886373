//! The ends of the stages of a test in `run.json`: why each ended, and the state that was reached there.
//!
//! The series holds means over intervals of strain. A stage that ends at a stress ends at an instant, at which the stress differs
//! from the mean over the interval before it by as much as it changed there.

use granum_core::assembly::Assembly;
use granum_core::geometry::Matrix;
use granum_dem::invariants;
use granum_dem::loading::{MacroState, StageEnd};
use granum_sensors::Observation;
use granum_sensors::solid_fraction::solid_fraction;
use serde::{Deserialize, Deserializer, Serialize};

/// Most stages of which all ends are recorded; of a test with more stages only the last end is.
const MOST_ENDS: usize = 1000;

/// The end of a stage of a test: values of one instant, where the series has means over intervals. The stress is that of the contacts,
/// as in snapshots and in the series.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StageEndRecord {
    /// Number of the stage, from 1.
    pub stage: usize,
    /// Its name.
    pub name: String,
    /// Why it ended.
    pub reason: String,
    /// True if it met one of its end conditions.
    pub asked_for: bool,
    /// Number of its steps.
    pub steps: u64,
    /// Mean stress p, Pa.
    #[serde(deserialize_with = "null_is_nan")]
    pub mean_stress: f64,
    /// `sigma_x - (sigma_y + sigma_z) / 2`, Pa: q of a triaxial test along x.
    #[serde(deserialize_with = "null_is_nan")]
    pub axial_deviator_stress: f64,
    /// Von Mises stress `sqrt(3/2 s:s)`, Pa.
    #[serde(deserialize_with = "null_is_nan")]
    pub von_mises_stress: f64,
    /// Stress, Pa, compression positive.
    #[serde(deserialize_with = "nulls_are_nan")]
    pub stress: Matrix,
    /// Logarithmic strain, compression positive.
    #[serde(deserialize_with = "nulls_are_nan")]
    pub strain: Matrix,
    /// Solid fraction.
    #[serde(deserialize_with = "null_is_nan")]
    pub solid_fraction: f64,
}

impl StageEndRecord {
    /// The end of a stage, by its number from 1, with the grains as they were then.
    pub fn new(stage: usize, end: &StageEnd, assembly: &Assembly) -> StageEndRecord {
        StageEndRecord {
            stage,
            name: end.name.clone(),
            reason: end.reason.to_string(),
            asked_for: end.reason.is_asked_for(),
            steps: end.steps,
            ..StageEndRecord::of_state(assembly)
        }
    }

    /// The state of an assembly alone, for runs of versions that did not record the ends of stages but have snapshots of them.
    pub fn of_state(assembly: &Assembly) -> StageEndRecord {
        let MacroState { stress, strain, .. } = MacroState::from_assembly(assembly);
        StageEndRecord {
            mean_stress: invariants::mean(&stress),
            axial_deviator_stress: invariants::axial_deviator(&stress),
            von_mises_stress: invariants::signed_von_mises(&stress).abs(),
            stress,
            strain,
            solid_fraction: solid_fraction(&Observation::new(assembly)),
            ..StageEndRecord::default()
        }
    }

    /// Adds an end to those of a test of so many stages; of a test with very many only the last is kept.
    pub fn add_to(self, ends: &mut Vec<StageEndRecord>, stages: usize) {
        if stages > MOST_ENDS {
            ends.clear();
        }
        ends.push(self);
    }
}

fn null_is_nan<'de, D: Deserializer<'de>>(input: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(input)?.unwrap_or(f64::NAN))
}

fn nulls_are_nan<'de, D: Deserializer<'de>>(input: D) -> Result<Matrix, D::Error> {
    let rows = <[[Option<f64>; 3]; 3]>::deserialize(input)?;
    Ok(rows.map(|row| row.map(|value| value.unwrap_or(f64::NAN))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::RunRecord;

    /// A record with ends is read back as it was, a number that JSON cannot write is no number, and records of earlier versions have none.
    #[test]
    fn ends_are_read_back_and_earlier_records_have_none() {
        let end = StageEndRecord {
            stage: 2,
            name: "shear".into(),
            mean_stress: 99.4e3,
            solid_fraction: f64::NAN,
            ..StageEndRecord::default()
        };
        let record = RunRecord { stage_ends: vec![end], ..RunRecord::default() };
        let text = serde_json::to_string(&record).unwrap();
        let back: RunRecord = serde_json::from_str(&text).unwrap();
        assert_eq!((back.stage_ends[0].stage, back.stage_ends[0].mean_stress), (2, 99.4e3));
        assert!(back.stage_ends[0].solid_fraction.is_nan());
        let earlier = serde_json::to_string(&RunRecord::default()).unwrap();
        assert!(!earlier.contains("stage_ends"));
        assert!(serde_json::from_str::<RunRecord>(&earlier).unwrap().stage_ends.is_empty());
    }

    #[test]
    fn of_very_many_stages_the_last_end_is_kept() {
        let mut ends = Vec::new();
        for stage in 1..=3 {
            StageEndRecord { stage, ..StageEndRecord::default() }.add_to(&mut ends, MOST_ENDS + 1);
        }
        assert_eq!(ends.iter().map(|end| end.stage).collect::<Vec<_>>(), [3]);
        StageEndRecord { stage: 4, ..StageEndRecord::default() }.add_to(&mut ends, 4);
        assert_eq!(ends.len(), 2);
    }
}
