//! The quantities that a calibration compares. Each is one `QuantityDefinition`, and a line in [`Quantity::ALL`]: keys and words of the file of a
//! calibration, units, errors of measurement and the readings of a test follow from it.

use std::borrow::Cow;
use std::fmt;

use granum_io::LaboratoryTest;

use crate::compared::curve::MeasurementError;

/// What is known of a quantity.
struct QuantityDefinition {
    /// Its word in files.
    word: &'static str,
    /// True for a stress, Pa; others are pure numbers.
    is_stress: bool,
    /// Its usual error of measurement: an absolute part, and a part of the value.
    error: [f64; 2],
    /// True if it is made of others, and says nothing beside them.
    is_derived: bool,
    /// The values of a test; empty if it has none.
    readings: fn(&LaboratoryTest) -> Cow<'_, [f64]>,
}

/// The usual errors of a stress: 1 kPa and 2 %.
const ERROR_OF_STRESS: [f64; 2] = [1e3, 0.02];

const DEVIATOR_STRESS: QuantityDefinition = QuantityDefinition {
    word: "deviator_stress",
    is_stress: true,
    error: ERROR_OF_STRESS,
    is_derived: false,
    readings: |test| Cow::from(&test.deviator_stress),
};

const MEAN_STRESS: QuantityDefinition = QuantityDefinition {
    word: "mean_stress",
    is_stress: true,
    error: ERROR_OF_STRESS,
    is_derived: false,
    readings: |test| Cow::from(&test.mean_stress),
};

const VOLUMETRIC_STRAIN: QuantityDefinition = QuantityDefinition {
    word: "volumetric_strain",
    is_stress: false,
    error: [5e-4, 0.05],
    is_derived: false,
    readings: |test| Cow::from(&test.volumetric_strain),
};

const VOID_RATIO: QuantityDefinition = QuantityDefinition {
    word: "void_ratio",
    is_stress: false,
    error: [2e-3, 0.0],
    is_derived: false,
    readings: |test| Cow::from(&test.void_ratio),
};

const PORE_PRESSURE: QuantityDefinition = QuantityDefinition {
    word: "pore_pressure",
    is_stress: true,
    error: ERROR_OF_STRESS,
    is_derived: true,
    readings: |test| {
        let lateral: Vec<f64> =
            test.mean_stress.iter().zip(&test.deviator_stress).map(|(p, q)| p - q / 3.0).collect();
        Cow::from(lateral.iter().map(|now| lateral[0] - now).collect::<Vec<f64>>())
    },
};

/// A quantity that tests and simulations have.
#[derive(Clone, Copy)]
pub struct Quantity(&'static QuantityDefinition);

impl Quantity {
    /// Deviator stress q, Pa.
    pub const DEVIATOR_STRESS: Quantity = Quantity(&DEVIATOR_STRESS);
    /// Effective mean stress p, Pa.
    pub const MEAN_STRESS: Quantity = Quantity(&MEAN_STRESS);
    /// Volumetric strain over the initial volume, compression positive.
    pub const VOLUMETRIC_STRAIN: Quantity = Quantity(&VOLUMETRIC_STRAIN);
    /// Void ratio e.
    pub const VOID_RATIO: Quantity = Quantity(&VOID_RATIO);
    /// Excess pore pressure of a test whose total lateral stress and back pressure stay as they are, Pa: what the effective lateral stress
    /// `p - q / 3` has lost since the start. In a drained test it is zero.
    pub const PORE_PRESSURE: Quantity = Quantity(&PORE_PRESSURE);

    /// All of them.
    pub const ALL: [Quantity; 5] = [
        Quantity::DEVIATOR_STRESS,
        Quantity::MEAN_STRESS,
        Quantity::VOLUMETRIC_STRAIN,
        Quantity::VOID_RATIO,
        Quantity::PORE_PRESSURE,
    ];

    /// Its word.
    pub fn word(self) -> &'static str {
        self.0.word
    }

    /// SI unit; empty for a pure number.
    pub fn unit(self) -> &'static str {
        if self.is_stress() { "Pa" } else { "" }
    }

    /// True for a stress.
    pub fn is_stress(self) -> bool {
        self.0.is_stress
    }

    /// True for a quantity that is made of others, and says nothing beside them.
    pub(crate) fn is_derived(self) -> bool {
        self.0.is_derived
    }

    /// The values of a test; empty if it has none.
    pub fn readings(self, test: &LaboratoryTest) -> Cow<'_, [f64]> {
        (self.0.readings)(test)
    }

    /// The error of measurement unless the file states another one: 1 kPa and 2 % of stresses, 0.05 % and 5 % of volumetric strains, 0.002
    /// of void ratios, alike over 2 % of axial strain.
    pub fn usual_error(self) -> MeasurementError {
        let [absolute, relative] = self.0.error;
        MeasurementError { absolute, relative, correlation_strain: 0.02 }
    }
}

impl PartialEq for Quantity {
    fn eq(&self, other: &Quantity) -> bool {
        self.word() == other.word()
    }
}

impl Eq for Quantity {}

impl fmt::Debug for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_quantity_has_a_word_of_its_own_and_readings_of_a_test() {
        let test = LaboratoryTest {
            deviator_stress: vec![0.0, 3e4],
            mean_stress: vec![1e5, 6e4],
            volumetric_strain: vec![0.0, 0.01],
            void_ratio: vec![0.7, 0.68],
            ..LaboratoryTest::default()
        };
        for (k, quantity) in Quantity::ALL.into_iter().enumerate() {
            assert!(!Quantity::ALL[..k].contains(&quantity), "{quantity:?}");
            assert_eq!(quantity.readings(&test).len(), 2);
            assert!(quantity.usual_error().absolute > 0.0);
        }
        assert_eq!(*Quantity::PORE_PRESSURE.readings(&test), [0.0, 5e4]);
    }
}
