//! How the numbers of a laboratory's file are to be read.

use granum_core::names::suggestion;
use granum_core::quantity::{Dimension, parse_quantity};

use super::laboratory_test::{QUANTITIES, place};
use crate::sheet::signs::signs;
use crate::sheet::{DecimalMark, split};

/// The quantities that have a sign of compression.
const SIGNED: [&str; 7] = [
    "axial_strain",
    "volumetric_strain",
    "axial_stress",
    "lateral_stress",
    "deviator_stress",
    "mean_stress",
    "pore_pressure",
];

/// How numbers of a file are to be read; what is `None` is as the comments of the file say, or else the first of its words.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Conventions {
    /// True if compression is negative in the file.
    pub compression_negative: Option<bool>,
    /// The same of single quantities, which goes before what is said of all: `("axial_strain", true)`.
    pub column_signs: Vec<(String, bool)>,
    /// The decimal mark of the file, if its numbers do not tell it.
    pub decimal_mark: Option<DecimalMark>,
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
const KEYS: [(&str, &str); 6] = [
    ("compression", "positive or negative"),
    ("decimal", "point or comma"),
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
            "compression" => self.state_signs(value)?,
            "decimal" => self.decimal_mark = Some(DecimalMark::from_word(value).ok_or_else(refused)?),
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

    /// States signs of compression: `negative` of all columns, `axial_strain=negative` of one, or several of these with commas between.
    ///
    /// # Errors
    /// What it can be.
    fn state_signs(&mut self, value: &str) -> Result<(), String> {
        for (name, is_negative) in signs(value)? {
            match name {
                None => self.compression_negative = Some(is_negative),
                Some(name) => self.column_signs.push((name, is_negative)),
            }
        }
        Ok(())
    }

    /// With the quantities of the names whose signs are stated, which may also be those of columns that are mapped.
    ///
    /// # Errors
    /// If a name is neither, if a quantity has no sign of compression, or two.
    pub(super) fn resolved(mut self) -> Result<Conventions, String> {
        let mut signs: Vec<(String, bool)> = Vec::new();
        for (name, is_negative) in &self.column_signs {
            let mapped = self.columns.iter().find(|(_, column)| column == name || split(column).0 == name);
            let quantity = mapped.map_or_else(|| name.clone(), |(quantity, _)| quantity.clone());
            let stated = format!("compression of {name}");
            if !SIGNED.contains(&quantity.as_str()) {
                return Err(match place(&quantity) {
                    Some(_) => format!("{stated}: {quantity} has no sign of compression"),
                    None => format!(
                        "{stated}: it is no quantity of a laboratory test; {}",
                        suggestion(name, SIGNED.into_iter())
                    ),
                });
            }
            if signs.iter().any(|(signed, negative)| *signed == quantity && negative != is_negative) {
                return Err(format!("{stated}: it is stated twice, as positive and as negative"));
            }
            signs.push((quantity, *is_negative));
        }
        self.column_signs = signs;
        Ok(self)
    }

    /// -1 for each quantity in whose column compression is negative. A pore pressure is a pressure unless its own sign is stated.
    pub(super) fn signs(&self) -> [f64; QUANTITIES.len()] {
        let sign = |(name, _): (&str, _)| {
            let of_column = self
                .column_signs
                .iter()
                .find(|(quantity, _)| quantity == name)
                .map(|(_, negative)| *negative);
            let all = self.compression_negative.filter(|_| SIGNED.contains(&name) && name != "pore_pressure");
            if of_column.or(all) == Some(true) { -1.0 } else { 1.0 }
        };
        QUANTITIES.map(sign)
    }

    /// True if a comment with this key states a convention.
    pub(super) fn is_key(key: &str) -> bool {
        KEYS.iter().any(|(known, _)| *known == key)
    }

    /// These conventions where they are stated, otherwise those of another.
    pub(super) fn or(&self, other: Conventions) -> Conventions {
        Conventions {
            compression_negative: self.compression_negative.or(other.compression_negative),
            column_signs: self.signs_or(&other),
            decimal_mark: self.decimal_mark.or(other.decimal_mark),
            logarithmic: self.logarithmic.or(other.logarithmic),
            total_stress: self.total_stress.or(other.total_stress),
            deviator: self.deviator.or(other.deviator),
            bedding_strain: self.bedding_strain.or(other.bedding_strain),
            columns: self.columns.clone(),
        }
    }

    /// The signs of single columns; what is said here of all columns goes before what the other says of single ones.
    fn signs_or(&self, other: &Conventions) -> Vec<(String, bool)> {
        let mut signs = self.column_signs.clone();
        if self.compression_negative.is_none() {
            let is_new = |(name, _): &&(String, bool)| !self.column_signs.iter().any(|(own, _)| own == name);
            signs.extend(other.column_signs.iter().filter(is_new).cloned());
        }
        signs
    }
}
