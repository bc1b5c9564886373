//! Measures of a stage, which decide where it ends, where it reverses and where it is recorded.

use serde::{Deserialize, Serialize};

use crate::invariants;
use crate::servo::{component, strain_component};

pub use granum_core::MacroState;

/// A quantity that increases or changes along a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// Arc length of the strain path, `sum of sqrt(2/3 d_eps:d_eps)`.
    ArcLength,
    /// Time, s.
    Time,
    /// A strain component, by its index; shear strains are angles.
    Strain(u8),
    /// `eps_x - (eps_y + eps_z) / 2`: the deviator strain of axisymmetric tests along x, as defined in the paper.
    AxialDeviatorStrain,
    /// `eps_1 + eps_2 + eps_3`, positive in compaction.
    VolumetricStrain,
    /// `sqrt(2/3 e:e)`.
    DeviatoricStrain,
    /// A stress component, by its index, Pa.
    Stress(u8),
    /// p, Pa.
    MeanStress,
    /// Von Mises stress q_vM, Pa, with the sign of `J_3` ([`invariants::signed_von_mises`]): positive near triaxial compression and
    /// negative near extension. Close to an isotropic stress the sign is that of small residual stresses; a condition on the deviator
    /// stress of an axisymmetric test is better given by [`Measure::AxialDeviatorStress`].
    DeviatorStress,
    /// `sigma_x - (sigma_y + sigma_z) / 2`, Pa: the deviator stress of axisymmetric tests along x, which passes zero smoothly.
    AxialDeviatorStress,
    /// Ratio of the von Mises stress q_vM, with its sign, to p.
    StressRatio,
}

impl Measure {
    /// Every measure with its name and unit in a case file.
    pub const ALL: [(&'static str, &'static str, Measure); 21] = [
        ("arc_length", "1", Measure::ArcLength),
        ("time", "s", Measure::Time),
        ("xx_strain", "1", Measure::Strain(0)),
        ("yy_strain", "1", Measure::Strain(1)),
        ("zz_strain", "1", Measure::Strain(2)),
        ("yz_strain", "1", Measure::Strain(3)),
        ("zx_strain", "1", Measure::Strain(4)),
        ("xy_strain", "1", Measure::Strain(5)),
        ("deviator_strain", "1", Measure::AxialDeviatorStrain),
        ("volumetric_strain", "1", Measure::VolumetricStrain),
        ("deviatoric_strain", "1", Measure::DeviatoricStrain),
        ("xx_stress", "Pa", Measure::Stress(0)),
        ("yy_stress", "Pa", Measure::Stress(1)),
        ("zz_stress", "Pa", Measure::Stress(2)),
        ("yz_stress", "Pa", Measure::Stress(3)),
        ("zx_stress", "Pa", Measure::Stress(4)),
        ("xy_stress", "Pa", Measure::Stress(5)),
        ("mean_stress", "Pa", Measure::MeanStress),
        ("deviator_stress", "Pa", Measure::DeviatorStress),
        ("axial_deviator_stress", "Pa", Measure::AxialDeviatorStress),
        ("stress_ratio", "1", Measure::StressRatio),
    ];

    /// Its name in a case file.
    pub fn name(self) -> &'static str {
        Measure::ALL.iter().find(|(_, _, measure)| *measure == self).map_or("unknown", |(name, _, _)| name)
    }

    /// Its unit.
    pub fn unit(self) -> &'static str {
        Measure::ALL.iter().find(|(_, _, measure)| *measure == self).map_or("1", |(_, unit, _)| unit)
    }

    /// The measure of a given name.
    pub fn named(name: &str) -> Option<Measure> {
        Measure::ALL.iter().find(|(known, _, _)| *known == name).map(|(_, _, measure)| *measure)
    }

    /// True if it depends on the stress.
    pub fn needs_stress(self) -> bool {
        matches!(
            self,
            Measure::Stress(_)
                | Measure::MeanStress
                | Measure::DeviatorStress
                | Measure::AxialDeviatorStress
                | Measure::StressRatio
        )
    }

    /// True if it counts from the start of its stage, not from the start of the test.
    pub fn counts_from_stage(self) -> bool {
        matches!(self, Measure::ArcLength | Measure::Time)
    }

    /// Its value.
    pub fn value(self, macro_state: &MacroState) -> f64 {
        match self {
            Measure::ArcLength => macro_state.arc_length,
            Measure::Time => macro_state.time,
            Measure::Strain(k) => strain_component(&macro_state.strain, usize::from(k.min(5))),
            Measure::AxialDeviatorStrain => invariants::axial_deviator(&macro_state.strain),
            Measure::VolumetricStrain => invariants::trace(&macro_state.strain),
            Measure::DeviatoricStrain => invariants::deviatoric_strain(&macro_state.strain),
            Measure::Stress(k) => component(&macro_state.stress, usize::from(k.min(5))),
            Measure::MeanStress => invariants::mean(&macro_state.stress),
            Measure::DeviatorStress => invariants::signed_von_mises(&macro_state.stress),
            Measure::AxialDeviatorStress => invariants::axial_deviator(&macro_state.stress),
            Measure::StressRatio => {
                let p = invariants::mean(&macro_state.stress);
                if p == 0.0 { 0.0 } else { invariants::signed_von_mises(&macro_state.stress) / p }
            }
        }
    }
}

/// A value of a measure to be reached: a series of steps ends at the first step that reaches it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasureGoal {
    /// The measure.
    pub measure: Measure,
    /// Subtracted from the measure before the comparison.
    pub origin: f64,
    /// The value to be reached.
    pub value: f64,
    /// True if the value is reached from below.
    pub rising: bool,
}

impl MeasureGoal {
    /// True if the value has been reached or passed.
    pub fn has_come(&self, macro_state: &MacroState) -> bool {
        let here = self.measure.value(macro_state) - self.origin;
        if self.rising { here >= self.value } else { here <= self.value }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_measure_has_one_name_and_every_name_one_measure() {
        for (name, unit, measure) in Measure::ALL {
            assert_eq!((measure.name(), measure.unit()), (name, unit));
            assert_eq!(Measure::named(name), Some(measure));
        }
    }

    #[test]
    fn events_come_from_either_side() {
        let macro_state = |strain: f64| MacroState {
            strain: [[strain, 0.0, 0.0], [0.0; 3], [0.0; 3]],
            ..MacroState::default()
        };
        let rising = MeasureGoal { measure: Measure::Strain(0), origin: 0.1, value: 0.05, rising: true };
        assert!(!rising.has_come(&macro_state(0.14)) && rising.has_come(&macro_state(0.16)));
        let falling = MeasureGoal { rising: false, ..rising };
        assert!(falling.has_come(&macro_state(0.14)) && !falling.has_come(&macro_state(0.16)));
        assert!(!rising.has_come(&macro_state(f64::NAN)));
    }
}
