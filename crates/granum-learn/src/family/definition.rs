//! What a family is: which tests belong to it, what is known of a sample before its test, and what is predicted.

use super::test_progress::{TEST_PROGRESS, test_progress};
use crate::dataset::{Dataset, RunStates};
use crate::error::{LearnError, Result};

/// The key of the path of a test.
pub(super) const PATH: &str = "stage.1.path";

/// A family of tests along one path: grains of one kind with stated ranges of their properties. The paths of a family have the same name, and
/// each has its surrogate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FamilyDefinition {
    /// Its name, for `granum predict --family NAME`.
    pub name: &'static str,
    /// What it is, in a few words.
    pub title: &'static str,
    /// The path of its tests.
    pub path: &'static str,
    /// The ready case (`granum init --case`) from which its tests are made.
    pub case: &'static str,
    /// Keys that are set over the case before the inputs are.
    pub settings: &'static [(&'static str, &'static str)],
    /// Keys of the test that are the stress of the sample times a factor.
    pub stress_keys: &'static [(&'static str, f64)],
    /// Words of the case that all of its runs have: key and word.
    pub words: &'static [(&'static str, &'static str)],
    /// The column along which curves run; `test_progress` counts stages and the share of the strain within a stage.
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
    /// True for a property of the grains and their stress: where it is not given, a prediction is the mean over its range. For anything else a
    /// typical value stands.
    pub is_required: bool,
    /// The range that the plan of the family states; `None` for what is measured on a sample. Its ends are as good as known where runs come
    /// close to them.
    pub limits: Option<[f64; 2]>,
}

/// An output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FamilyOutput {
    /// The column that is predicted: one of a run, the name of a histogram, of which all bins are predicted, or the name of `ratio`.
    pub column: &'static str,
    /// The column of a run and the parameter over which it is taken, if the runs do not have the output themselves.
    pub ratio: Option<(&'static str, &'static str)>,
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
            let divisor = number(key)?;
            // As in a run: without any friction there is no ratio of frictions.
            value = if divisor == 0.0 && value == 0.0 { 0.0 } else { value / divisor };
        }
        value.is_finite().then_some(value)
    }
}

impl FamilyDefinition {
    /// The runs along its path, of a data set that may have others.
    pub fn along_its_path(&self, dataset: &Dataset) -> Dataset {
        dataset.select(|run, _| run.word(PATH).is_none_or(|path| path == self.path))
    }

    /// The runs along its path with all of its columns: its coordinate, its inputs as parameters, and its outputs.
    ///
    /// # Errors
    /// If no run is along its path, or one is not of the family or lacks a column.
    pub fn with_its_columns(&self, dataset: &Dataset) -> Result<Dataset> {
        let own = self.along_its_path(dataset);
        if own.runs().is_empty() {
            let reason = format!("there is no run of the family {} along the path {}", self.name, self.path);
            return Err(LearnError::Dataset(reason));
        }
        Dataset::new(own.runs().iter().map(|run| self.with_columns(run)).collect::<Result<_>>()?)
    }

    /// The run with the inputs as parameters, and the outputs that are ratios as columns.
    ///
    /// # Errors
    /// If the run is not of the family, or lacks what an input or output is made of.
    pub fn with_columns(&self, run: &RunStates) -> Result<RunStates> {
        self.check(run)?;
        let mut made = run.clone();
        for input in self.inputs.iter().filter(|input| input.name != input.key) {
            made = made.with_parameter(input.name, "", input.of_run(run)?)?;
        }
        if self.coordinate == TEST_PROGRESS {
            made = made.with_column(TEST_PROGRESS, "", test_progress(run)?)?;
        }
        for output in self.outputs {
            let Some((column, over)) = output.ratio else { continue };
            let divisor = run.parameter(over).filter(|divisor| *divisor != 0.0).ok_or_else(|| {
                let reason = format!("it has no {over}, over which {column} is taken");
                LearnError::Record { run: run.name().into(), reason }
            })?;
            let values = run.column(column)?.into_iter().map(|value| value / divisor).collect();
            made = made.with_column(output.column, "", values)?;
        }
        Ok(made)
    }

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
                    reason: format!(
                        "{key} is {found}; the runs of the family {} along the path {} have {word}",
                        self.name, self.path
                    ),
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

    use super::super::sand::{SAND, SAND_UNDRAINED};
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

    #[test]
    fn runs_are_taken_along_the_path_and_get_the_ratios_that_are_outputs() {
        let run = |name: &str, path: &str| {
            let columns = vec![
                Column::new("axial_strain", "", vec![0.0, 0.1]),
                Column::new("mean_stress", "Pa", vec![1e5, 3e5]),
            ];
            let mut run = RunStates::new(name, Table::new(columns).unwrap()).unwrap();
            for (key, word) in SAND_UNDRAINED.words.iter().filter(|(key, _)| *key != PATH) {
                run = run.with_word(key, word).unwrap();
            }
            for input in SAND.inputs {
                run = run.with_parameter(input.key, "", 0.5).unwrap();
            }
            let run = run.with_parameter("grains.material.youngs_modulus", "Pa", 2e9).unwrap();
            run.with_word(PATH, path).unwrap()
        };
        let runs = [run("drained", "drained-triaxial"), run("undrained", "undrained-triaxial")];
        let own = SAND_UNDRAINED.along_its_path(&Dataset::new(runs.to_vec()).unwrap());
        assert_eq!(own.runs().iter().map(RunStates::name).collect::<Vec<_>>(), ["undrained"]);
        let all = SAND_UNDRAINED.with_its_columns(&Dataset::new(runs.to_vec()).unwrap()).unwrap();
        assert_eq!(all.runs().len(), 1);
        assert_eq!(all.column("mean_stress_over_initial").unwrap(), [2e5, 6e5]);
        let none = SAND_UNDRAINED.with_its_columns(&Dataset::new(runs[..1].to_vec()).unwrap());
        assert!(
            none.unwrap_err()
                .to_string()
                .contains("no run of the family sand along the path undrained-triaxial")
        );
        let told = SAND_UNDRAINED.with_columns(&runs[0]).unwrap_err().to_string();
        assert!(told.contains("stage.1.path is drained-triaxial"), "{told}");
        // The stress of the sample is 0.5 Pa here.
        let made = SAND_UNDRAINED.with_columns(&runs[1]).unwrap();
        assert_eq!(made.column("mean_stress_over_initial").unwrap(), [2e5, 6e5]);
        assert_eq!(made.parameter("preparation_ratio"), Some(1.0));
    }

    #[test]
    fn families_have_their_paths() {
        use super::super::{ALL, by_name};
        for (k, family) in ALL.iter().enumerate() {
            assert_eq!(by_name(family.name, Some(family.path)).unwrap().title, family.title);
            assert!(family.words.contains(&(PATH, family.path)), "{}", family.title);
            assert!(ALL[..k].iter().all(|other| (other.name, other.path) != (family.name, family.path)));
        }
        assert_eq!(by_name("sand", None).unwrap().path, "drained-triaxial");
        let told = by_name("sand", Some("undraind-triaxial")).unwrap_err().to_string();
        assert!(told.contains("did you mean undrained-triaxial"), "{told}");
    }
}
