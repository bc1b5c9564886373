//! What a family is: which tests belong to it, what is known of a sample before its test, and what is predicted.

use crate::dataset::RunStates;
use crate::error::{LearnError, Result};

/// A family of tests: grains of one kind with stated ranges of their properties, along one path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FamilyDefinition {
    /// Its name, for `granum predict --family NAME`.
    pub name: &'static str,
    /// What it is, in a few words.
    pub title: &'static str,
    /// The path of its tests.
    pub path: &'static str,
    /// The ready case (`granum init --case`) from which its tests are made, and keys that are set over it.
    pub case: &'static str,
    /// Keys that are set over the case before the inputs are.
    pub settings: &'static [(&'static str, &'static str)],
    /// Words of the case that all of its runs have: key and word.
    pub words: &'static [(&'static str, &'static str)],
    /// The column along which curves run.
    pub coordinate: &'static str,
    /// What is known before a test, in the order in which typical values depend on each other.
    pub inputs: &'static [FamilyInput],
    /// Columns, or the names of histograms, that are predicted.
    pub outputs: &'static [FamilyOutput],
    /// The ready plan (`granum init --plan`) of its training runs.
    pub plan: &'static str,
    /// What the grains and tests are, in sentences for its card.
    pub about: &'static [&'static str],
    /// What it must not be used for, in sentences for its card.
    pub limits: &'static [&'static str],
}

/// An input: a number without a dimension, a column of a run or a column over others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FamilyInput {
    /// Its name.
    pub name: &'static str,
    /// What it is, in words.
    pub meaning: &'static str,
    /// The column: a key of the case or a measure of the sample.
    pub key: &'static str,
    /// The columns by which it is divided.
    pub over: &'static [&'static str],
    /// True if a prediction cannot be made without it; otherwise a typical value stands for it.
    pub is_required: bool,
}

/// An output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FamilyOutput {
    /// The column of a run, or the name of a histogram, of which all bins are predicted.
    pub column: &'static str,
    /// What it is, in words.
    pub meaning: &'static str,
    /// Its sign in formulas, if it has one.
    pub symbol: &'static str,
}

impl FamilyInput {
    /// The value in a run.
    ///
    /// # Errors
    /// If the run lacks a column, or one by which it is divided is zero.
    pub fn of_run(&self, run: &RunStates) -> Result<f64> {
        let bad = |reason: String| LearnError::Record { run: run.name().into(), reason };
        let number = |key: &str| {
            run.parameter(key).ok_or_else(|| {
                bad(format!("it has no {key}, which the input {} of the family is made of", self.name))
            })
        };
        let mut value = number(self.key)?;
        for key in self.over {
            let divisor = number(key)?;
            // Without any friction there is no ratio of frictions, and none of it matters.
            value = if divisor == 0.0 && value == 0.0 { 0.0 } else { value / divisor };
        }
        match value.is_finite() {
            true => Ok(value),
            false => Err(bad(format!("its input {} is {value}, not a finite number", self.name))),
        }
    }

    /// The value from numbers by key; `None` if one is missing, or if the value is not finite.
    pub fn from_numbers(&self, number: &dyn Fn(&str) -> Option<f64>) -> Option<f64> {
        let mut value = number(self.key)?;
        for key in self.over {
            value /= number(key)?;
        }
        value.is_finite().then_some(value)
    }
}

impl FamilyDefinition {
    /// Refuses a run that is not of the family.
    ///
    /// # Errors
    /// If a word of its case is another; the message names run, key and word.
    pub fn check(&self, run: &RunStates) -> Result<()> {
        for (key, word) in self.words {
            let found = run.word(key).unwrap_or_else(|| "not given".into());
            if found != *word {
                return Err(LearnError::Record {
                    run: run.name().into(),
                    reason: format!("{key} is {found}; the runs of the family {} have {word}", self.name),
                });
            }
        }
        Ok(())
    }

    /// The number of an input.
    ///
    /// # Errors
    /// [`LearnError::Unknown`] with the existing names.
    pub fn input(&self, name: &str) -> Result<usize> {
        self.inputs.iter().position(|input| input.name == name).ok_or_else(|| LearnError::Unknown {
            kind: "input of the family",
            name: name.to_owned(),
            known: self.inputs.iter().map(|input| input.name).collect::<Vec<_>>().join(", "),
        })
    }
}

#[cfg(test)]
mod tests {
    use granum_core::{Column, Table};

    use super::super::sand::SAND;
    use super::*;

    #[test]
    fn an_input_is_a_column_over_others() {
        let table = Table::new(vec![Column::new("axial_strain", "", vec![0.0, 0.1])]).unwrap();
        let run = RunStates::new("run", table).unwrap();
        let run = run.with_parameter("preparation.mean_stress", "Pa", 1e5).unwrap();
        let stress = SAND.inputs[SAND.input("stress_over_modulus").unwrap()];
        let told = stress.of_run(&run).unwrap_err().to_string();
        assert!(told.contains("`run`") && told.contains("grains.material.youngs_modulus"), "{told}");
        let run = run.with_parameter("grains.material.youngs_modulus", "Pa", 2e9).unwrap();
        assert!((stress.of_run(&run).unwrap() - 5e-5).abs() < 1e-18);
        assert!(SAND.check(&run).unwrap_err().to_string().contains("contact.normal is not given"));
        assert!(SAND.input("frction").unwrap_err().to_string().contains("did you mean friction"));
    }
}
