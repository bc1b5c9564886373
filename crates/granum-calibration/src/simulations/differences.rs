//! How the runs of an earlier campaign differ from the simulations that the file of a calibration describes.

use std::collections::{BTreeMap, BTreeSet};

use granum_io::Case;
use granum_io::case::{CaseParameter, ParameterValue, SEED};

use crate::error::{CalibrationError, Result};
use crate::file::CalibrationFile;

/// Ends of keys that say how a test is observed and how far it goes, and not what the grains do.
const OF_NO_MATTER: [&str; 3] = [".states", ".axial_strain", ".snapshots"];
/// Section of keys that say what is recorded.
const RECORDING: &str = "recording.";
/// Most differences that are named.
const MOST_NAMED: usize = 6;
/// Relative difference of numbers that are the same.
const SAME: f64 = 1e-9;

/// What is different.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Differences {
    /// Numbers that vary over the earlier runs and that no variable of the file sets: key, unit, and the value of the calibration's own
    /// simulations.
    pub varying: Vec<(String, String, f64)>,
    /// Where the runs are not those that the file describes, in a sentence for each key.
    pub remarks: Vec<String>,
}

type Keys = BTreeMap<String, CaseParameter>;

impl Differences {
    /// Compares earlier runs, each by its name and case, with the case of a simulation of the calibration itself.
    ///
    /// # Errors
    /// If the runs differ in a word, such as a law, or in a number that the calibration's own simulations do not have.
    pub fn new(file: &CalibrationFile, own: &Case, runs: &[(&str, &Case)]) -> Result<Differences> {
        let cases: Vec<Keys> = runs.iter().map(|(_, case)| by_key(case)).collect();
        let own = by_key(own);
        let set: BTreeSet<&str> = file
            .plan
            .variables
            .iter()
            .flat_map(|variable| variable.keys.iter().map(|key| key.value.as_str()))
            .collect();
        let counts = |key: &&String| {
            let observed = key.starts_with(RECORDING) || OF_NO_MATTER.iter().any(|end| key.ends_with(end));
            !(set.contains(key.as_str()) || observed || key.as_str() == SEED)
        };
        let mut found = Differences::default();
        let keys: BTreeSet<&String> =
            cases.iter().flat_map(BTreeMap::keys).chain(own.keys()).filter(counts).collect();
        for key in keys {
            found.compare(key, own.get(key), &cases)?;
        }
        found.remarks.extend(keys_apart(file, runs, &cases));
        if found.remarks.len() > MOST_NAMED {
            let more = found.remarks.len() - MOST_NAMED;
            found.remarks.truncate(MOST_NAMED);
            found.remarks.push(format!("{more} more keys differ between the earlier runs and the file"));
        }
        Ok(found)
    }

    fn compare(&mut self, key: &str, own: Option<&CaseParameter>, cases: &[Keys]) -> Result<()> {
        let known: Vec<&CaseParameter> = cases.iter().filter_map(|case| case.get(key)).collect();
        let Some(first) = known.first() else {
            self.remarks.extend(own.map(|own| {
                format!("the earlier runs have no {key}, which is {} in the file", word(&own.value))
            }));
            return Ok(());
        };
        if known.len() < cases.len() {
            return Err(CalibrationError::Input(format!(
                "{} of {} earlier runs have no {key}; take runs of one kind",
                cases.len() - known.len(),
                cases.len()
            )));
        }
        if known.iter().any(|one| !is_same(&one.value, &first.value)) {
            let Some(own) = first.number().and(own).and_then(CaseParameter::number) else {
                return Err(CalibrationError::Input(format!(
                    "the earlier runs differ in {key}, which is not a number of the file's simulations that a surrogate could learn; take runs that \
                     have one value of it"
                )));
            };
            self.varying.push((key.into(), first.unit.clone(), own));
            return Ok(());
        }
        match own {
            None => self.remarks.push(format!(
                "the earlier runs have {key} = {}, which the simulations of the file do not have",
                word(&first.value)
            )),
            Some(own) if !is_same(&own.value, &first.value) => {
                let [there, here] = [first, own].map(|known| word(&known.value));
                self.remarks.push(format!("{key} is {there} in the earlier runs, and {here} in the file"));
            }
            Some(_) => {}
        }
        Ok(())
    }
}

/// Variables of the file that set several keys to one value, which earlier runs have apart: the surrogate sees the first key only.
fn keys_apart(file: &CalibrationFile, runs: &[(&str, &Case)], cases: &[Keys]) -> Vec<String> {
    let mut told = Vec::new();
    for variable in &file.plan.variables {
        let [first, others @ ..] = variable.keys.as_slice() else { continue };
        for other in others {
            let value = |case: &Keys, key: &str| case.get(key).map(|known| known.value.clone());
            let is_apart = |case: &&Keys| match (value(case, &first.value), value(case, &other.value)) {
                (Some(a), Some(b)) => !is_same(&a, &b),
                _ => true,
            };
            let apart = cases.iter().filter(is_apart).count();
            let Some(at) = cases.iter().position(|case| is_apart(&case)) else { continue };
            let [a, b] = [first, other]
                .map(|key| value(&cases[at], &key.value).as_ref().map_or("nothing".into(), word));
            told.push(format!(
                "{} = {b} beside {} = {a} in {apart} of the earlier runs (the first is {}); the variable {} gives both one value, and the surrogate \
                 learns from the second one only",
                other.value, first.value, runs[at].0, variable.name
            ));
        }
    }
    told
}

fn by_key(case: &Case) -> Keys {
    case.parameters().into_iter().map(|parameter| (parameter.key.clone(), parameter)).collect()
}

fn is_same(a: &ParameterValue, b: &ParameterValue) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() <= SAME * a.abs().max(b.abs());
    match (a, b) {
        (ParameterValue::Number(a), ParameterValue::Number(b)) => near(*a, *b),
        (ParameterValue::List(a), ParameterValue::List(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| near(*a, *b))
        }
        _ => a == b,
    }
}

fn word(value: &ParameterValue) -> String {
    match value {
        ParameterValue::Number(number) => number.to_string(),
        ParameterValue::Word(word) => word.clone(),
        ParameterValue::List(numbers) => format!("{numbers:?}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::{CASE_FOR_TESTS as BASE, STRESS_AND_FRICTION, file_for_tests};

    const FURTHER: &str = "[set]
contact.tangential = \"no-slip\"
[[variable]]
name = \"lateral_stress\"
keys = [\"preparation.mean_stress\", \"stage.1.lateral_stress\"]
test = \"lateral_stress\"
";

    fn file() -> CalibrationFile {
        file_for_tests(&format!("{STRESS_AND_FRICTION}{FURTHER}"))
    }

    fn case(settings: &[(&str, &str)]) -> Case {
        let mut case = Case::parse(BASE, "sand.toml").unwrap();
        settings.iter().for_each(|(key, text)| case.set(key, text).unwrap());
        case
    }

    fn found(runs: &[Case]) -> Result<Differences> {
        let own = case(&[("contact.tangential", "no-slip")]);
        let named: Vec<(&str, &Case)> = ["a", "b", "c"].into_iter().zip(runs).collect();
        Differences::new(&file(), &own, &named)
    }

    #[test]
    fn runs_as_the_file_has_them_are_not_remarked() {
        let like = |friction: &str| {
            case(&[
                ("contact.tangential", "no-slip"),
                ("grains.material.friction", friction),
                ("preparation.seed", friction.get(2..).unwrap()),
            ])
        };
        assert_eq!(found(&[like("0.3"), like("0.5")]).unwrap(), Differences::default());
    }

    #[test]
    fn a_number_that_varies_is_learned_with_the_value_of_the_file() {
        let of_count = |count: &str| case(&[("contact.tangential", "no-slip"), ("grains.count", count)]);
        let found = found(&[of_count("100"), of_count("300")]).unwrap();
        assert_eq!((found.varying.len(), found.remarks.len()), (1, 0), "{found:?}");
        assert_eq!((found.varying[0].0.as_str(), found.varying[0].2), ("grains.count", 200.0));
    }

    #[test]
    fn numbers_and_words_also_those_of_set_are_compared() {
        let other = case(&[("grains.count", "300")]);
        let there = by_key(&other)["contact.tangential"].value.clone();
        let found = found(&[other.clone(), other]).unwrap();
        let told = found.remarks.join("\n");
        assert!(told.contains("grains.count is 300 in the earlier runs, and 200 in the file"), "{told}");
        let expected =
            format!("contact.tangential is {} in the earlier runs, and no-slip in the file", word(&there));
        assert!(told.contains(&expected), "{told}");
    }

    #[test]
    fn every_key_of_a_variable_is_looked_at() {
        let like = |lateral: &str| {
            case(&[
                ("contact.tangential", "no-slip"),
                ("preparation.mean_stress", "50 kPa"),
                ("stage.1.lateral_stress", lateral),
            ])
        };
        let told = found(&[like("50 kPa"), like("200 kPa"), like("300 kPa")]).unwrap().remarks;
        let [told] = told.as_slice() else { panic!("{told:?}") };
        for part in [
            "stage.1.lateral_stress = 200000",
            "preparation.mean_stress = 50000",
            "2 of the earlier runs",
            "first is b",
        ] {
            assert!(told.contains(part), "{told}");
        }
    }

    #[test]
    fn keys_that_one_side_lacks_are_told() {
        let like = |more: &str| {
            let mut case = Case::parse(&format!("{BASE}{more}"), "sand.toml").unwrap();
            case.set("contact.tangential", "no-slip").unwrap();
            case
        };
        let longer = "[[stage]]\npath = \"isotropic\"\nmean_stress = \"50 kPa\"\n";
        let remarks_joined = found(&[like(longer), like(longer)]).unwrap().remarks.join("\n");
        assert!(
            remarks_joined.contains("the earlier runs have stage.2.mean_stress = 50000, which"),
            "{remarks_joined}"
        );
        let run = like("");
        let remarks_joined =
            Differences::new(&file(), &like(longer), &[("a", &run)]).unwrap().remarks.join("\n");
        assert!(
            remarks_joined
                .contains("the earlier runs have no stage.2.mean_stress, which is 50000 in the file"),
            "{remarks_joined}"
        );
        let message = found(&[like(longer), like("")]).unwrap_err().to_string();
        assert!(message.contains("1 of 2 earlier runs have no stage.2."), "{message}");
    }

    #[test]
    fn runs_that_differ_in_a_word_are_refused() {
        let message =
            found(&[case(&[]), case(&[("contact.tangential", "no-slip")])]).unwrap_err().to_string();
        assert!(message.contains("differ in contact.tangential"), "{message}");
    }

    #[test]
    fn many_differences_are_counted() {
        let other = Case::parse(
            "[grains]\ncount = 300\n[grains.material]\nyoungs_modulus = '1 GPa'\npoissons_ratio = 0.1\ndensity = 1000\n[preparation]\nmean_stress = \
             \"100 kPa\"\nfriction = 0.1\ninertial_number = 1e-2\nunbalanced_force = 5e-2\n[[stage]]\npath = \"drained-triaxial\"\nlateral_stress = \
             \"100 kPa\"\ninertial_number = 1e-2\n",
            "sand.toml",
        )
        .unwrap();
        let told = found(&[other]).unwrap().remarks;
        assert_eq!(told.len(), MOST_NAMED + 1, "{told:?}");
        assert!(told[MOST_NAMED].contains("more keys differ"), "{told:?}");
    }
}
