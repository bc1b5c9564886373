//! How the numbers of a laboratory's file are to be read.

use granum_core::names::suggestion;
use granum_core::quantity::{Dimension, parse_quantity};

/// How numbers of a file are to be read; what is `None` is as the comments of the file say, or else the first of its words.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Conventions {
    /// True if compression is negative in the file.
    pub compression_negative: Option<bool>,
    /// True if strains are logarithmic.
    pub logarithmic: Option<bool>,
    /// True if stresses are total ones, from which the column `pore_pressure` is subtracted.
    pub total_stress: Option<bool>,
    /// What the column `deviator_stress` holds.
    pub deviator: Option<DeviatorMeasure>,
    /// Axial strain by which the loading plate only settled on the sample: readings before it are left out, and strains count from it.
    pub bedding_strain: Option<f64>,
    /// Known quantities with the columns that hold them: `("axial_strain", "eps_1 (%)")`, where the unit may be left out if the
    /// header has it.
    pub columns: Vec<(String, String)>,
}

/// What a file calls the deviator stress, of axial stress a and lateral stress l.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviatorMeasure {
    /// q = a - l.
    Difference,
    /// The largest shear stress t = (a - l) / 2.
    Half,
    /// The norm of the deviator, sqrt(2/3) (a - l).
    Norm,
    /// The octahedral shear stress, sqrt(2)/3 (a - l).
    Octahedral,
}

impl DeviatorMeasure {
    /// All of them with their words.
    pub(super) const ALL: [(DeviatorMeasure, &'static str); 4] = [
        (DeviatorMeasure::Difference, "difference"),
        (DeviatorMeasure::Half, "half"),
        (DeviatorMeasure::Norm, "norm"),
        (DeviatorMeasure::Octahedral, "octahedral"),
    ];

    /// The measure over the difference of the stresses.
    pub(super) fn share(self) -> f64 {
        match self {
            DeviatorMeasure::Difference => 1.0,
            DeviatorMeasure::Half => 0.5,
            DeviatorMeasure::Norm => (2.0f64 / 3.0).sqrt(),
            DeviatorMeasure::Octahedral => 2f64.sqrt() / 3.0,
        }
    }
}

/// The keys that a comment or a caller can state, each with what it can be.
const KEYS: [(&str, &str); 5] = [
    ("compression", "positive or negative"),
    ("strain", "engineering or logarithmic"),
    ("stress", "effective or total"),
    ("deviator_stress", "difference, half, norm or octahedral"),
    ("bedding_strain", "an axial strain such as 0.3 %"),
];

impl Conventions {
    /// States a convention, as a comment `# key = value` does.
    ///
    /// ```
    /// let mut conventions = granum_io::Conventions::default();
    /// conventions.state("strain", "logarithmic").unwrap();
    /// assert_eq!(conventions.logarithmic, Some(true));
    /// assert!(conventions.state("strain", "true").unwrap_err().contains("engineering or logarithmic"));
    /// ```
    ///
    /// # Errors
    /// What the key or its value can be.
    pub fn state(&mut self, key: &str, value: &str) -> Result<(), String> {
        let Some((_, words)) = KEYS.iter().find(|(known, _)| *known == key) else {
            let known = KEYS.iter().map(|(known, _)| *known);
            return Err(format!("{key} is no convention of a laboratory's file; {}", suggestion(key, known)));
        };
        let refused = || format!("{key} = {value} is not known; it must be {words}");
        let one_of = |words: [&str; 2]| {
            words.iter().position(|word| *word == value).map(|which| which == 1).ok_or_else(refused)
        };
        match key {
            "compression" => self.compression_negative = Some(one_of(["positive", "negative"])?),
            "strain" => self.logarithmic = Some(one_of(["engineering", "logarithmic"])?),
            "stress" => self.total_stress = Some(one_of(["effective", "total"])?),
            "deviator_stress" => {
                let known = DeviatorMeasure::ALL.iter().find(|(_, word)| *word == value);
                self.deviator = Some(known.ok_or_else(refused)?.0);
            }
            _ => {
                let strain = parse_quantity(value, Dimension::NUMBER)
                    .map_err(|why| format!("{key} = {value} {why}; it must be {words}"))?;
                if !(0.0..0.2).contains(&strain) {
                    return Err(format!("{key} = {value} is beyond what bedding can be; it must be {words}"));
                }
                self.bedding_strain = Some(strain);
            }
        }
        Ok(())
    }

    /// True if a comment with this key states a convention.
    pub(super) fn is_key(key: &str) -> bool {
        KEYS.iter().any(|(known, _)| *known == key)
    }

    /// These conventions where they are stated, otherwise those of another.
    pub(super) fn or(&self, other: Conventions) -> Conventions {
        Conventions {
            compression_negative: self.compression_negative.or(other.compression_negative),
            logarithmic: self.logarithmic.or(other.logarithmic),
            total_stress: self.total_stress.or(other.total_stress),
            deviator: self.deviator.or(other.deviator),
            bedding_strain: self.bedding_strain.or(other.bedding_strain),
            columns: self.columns.clone(),
        }
    }
}
