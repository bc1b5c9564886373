//! Differences between cases, by key.

use std::collections::BTreeMap;
use std::fmt;

use granum_core::quantity::format_number;

use super::case_stage::{PREPARATION_STAGE, STAGE};
use super::definition::Case;
use super::field::{Field, Value};
use super::fields::Fields;

/// The key that gives another sample of the same material: runs that differ only in it are repetitions of one test.
pub const SEED: &str = "preparation.seed";

/// Shown for a key that is not in use, e.g. `shear.strain_rate` where `shear.inertial_number` is given.
const NOT_GIVEN: &str = "not given";

/// The values of a case by key (`grains.material.friction`), as in a case file, with their SI units. Two texts are equal
/// exactly if the values have the same bits.
pub type CaseValues = BTreeMap<String, String>;

/// A key that does not have the same value in all cases.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Section and key, e.g. `grains.material.friction`.
    pub key: String,
    /// Each of its values, with the names of the cases that have it, in the order in which they were given.
    pub values: Vec<(String, Vec<String>)>,
}

/// `grains.material.friction: 0.3 in run-1, run-2; 0.5 in run-3`.
impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = |(value, names): &(String, Vec<String>)| format!("{value} in {}", names.join(", "));
        write!(f, "{}: {}", self.key, self.values.iter().map(value).collect::<Vec<_>>().join("; "))
    }
}

impl Case {
    /// The value of every key of the case file.
    ///
    /// ```
    /// use granum_io::case::{Case, differences};
    /// let paper = Case::default();
    /// let mut other = paper.clone();
    /// other.set("grains.material.friction", "0.5").unwrap();
    /// let found = differences(&[("run-1", &paper.values()), ("run-2", &other.values())]);
    /// assert_eq!(found[0].to_string(), "grains.material.friction: 0.3 in run-1; 0.5 in run-2");
    /// ```
    pub fn values(&self) -> CaseValues {
        let fields = self.fields();
        let mut values: CaseValues =
            fields.iter().map(|field| (field.path(), shown(field, self.counted(field)))).collect();
        let undeclared = self.undeclared_parameters();
        values.extend(
            undeclared.into_iter().map(|(key, value)| (format!("recording.{key}"), format_number(value))),
        );
        values.extend(self.shape_values());
        values.extend(self.material_values());
        values.extend(self.bond_values());
        for (heading, text) in
            [(STAGE, self.stages_toml()), (PREPARATION_STAGE, self.preparation_stages_toml())]
        {
            if !text.is_empty() {
                values.insert(heading.into(), text.trim().replace('\n', "; "));
            }
        }
        values
    }
}

/// The value of a field for display, with its unit.
fn shown(field: &Field, value: Option<Value>) -> String {
    let Some(value) = value else { return NOT_GIVEN.to_string() };
    let (text, unit) = (field.toml(&value), field.si_unit());
    if unit.is_empty() || text.starts_with('"') { text } else { format!("{text} {unit}") }
}

/// All keys that differ between the named cases: those of the case file in its order, then any others. A key that is unknown
/// to some of the cases (because they were written by another version) is compared between the others.
pub fn differences(cases: &[(&str, &CaseValues)]) -> Vec<Difference> {
    let mut keys: Vec<String> = Fields::standard().iter().map(|field| field.path()).collect();
    for key in cases.iter().flat_map(|(_, values)| values.keys()) {
        if !keys.contains(key) {
            keys.push(key.clone());
        }
    }
    keys.into_iter().filter_map(|key| difference(key, cases)).collect()
}

fn difference(key: String, cases: &[(&str, &CaseValues)]) -> Option<Difference> {
    let mut values: Vec<(String, Vec<String>)> = Vec::new();
    for (name, case) in cases {
        // A material or a stage that one case has and the other has not is a difference, not another version's key.
        let of_tables =
            ["material.", "pair.", "grains.shape.", "bond."].iter().any(|table| key.starts_with(table))
                || [STAGE, PREPARATION_STAGE].contains(&key.as_str());
        let absent = of_tables.then(|| NOT_GIVEN.to_string());
        let Some(value) = case.get(&key).or(absent.as_ref()) else { continue };
        match values.iter_mut().find(|(known, _)| known == value) {
            Some((_, names)) => names.push((*name).to_string()),
            None => values.push((value.clone(), vec![(*name).to_string()])),
        }
    }
    (values.len() > 1).then_some(Difference { key, values })
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_dem::contact::choice::registry::Laws;

    fn between(one: &Case, two: &Case) -> Vec<Difference> {
        differences(&[("one", &one.values()), ("two", &two.values())])
    }

    #[test]
    fn every_key_is_compared() {
        for field in Fields::standard().iter() {
            let mut one = Case::default();
            if matches!(field.key, "strain_rate" | "density_scaling") {
                one.set("shear.strain_rate", "1e-5 /s").unwrap();
            }
            if field.is_of_law() {
                // Keys of laws are compared where a law uses them.
                let users = [
                    ("normal", "hooke"),
                    ("tangential", "no-slip"),
                    ("rolling", "elastic-plastic-twisting"),
                    ("adhesion", "capillary-bridge"),
                ];
                users.iter().for_each(|(slot, law)| one.set(&format!("contact.{slot}"), law).unwrap());
                let slots = ["normal", "rolling", "adhesion"];
                for law in Laws::standard().all().iter().filter(|law| slots.contains(&law.slot())) {
                    let (slot, law) = (law.slot(), law.description().name);
                    let mut other = one.clone();
                    other.set(&format!("contact.{slot}"), law).unwrap();
                    if field.value(&one).is_none() && field.value(&other).is_some() {
                        one = other;
                    }
                }
            }
            if field.is_of_sizes() {
                let has = |kind: &&granum_dem::sizes::SizeKind| {
                    let parameters = kind.distribution().description().parameters;
                    parameters.iter().any(|known| known.key == field.key)
                };
                let kind = granum_dem::sizes::ALL.iter().find(has).unwrap();
                one.set("grains.distribution", kind.name()).unwrap();
            }
            if field.is_of_shapes() {
                let has = |kind: &&granum_dem::shape::ShapeKind| {
                    let parameters = kind.family().description().parameters;
                    parameters.iter().any(|known| known.key == field.key)
                };
                let kind = granum_dem::shape::family::ALL.iter().find(has).unwrap();
                one.set("grains.shape.kind", kind.name()).unwrap();
            }
            if field.is_spheres() {
                one.set("grains.shape.kind", "pieces").unwrap();
            }
            if field.key == "bedding_spread" {
                one.set("preparation.bedding_tilt", "10 deg").unwrap();
            }
            let mut two = one.clone();
            let values = [0.1, 0.3, 0.55, 0.99].map(|place| field.draw(place));
            let value = values.into_iter().find(|value| Some(value) != field.value(&one).as_ref()).unwrap();
            field.apply(&mut two, value);
            let keys: Vec<String> = between(&one, &two).into_iter().map(|found| found.key).collect();
            // The two forms of the rate exclude each other, and a law adds its own keys.
            // Measures of density exclude each other.
            let brings_keys = field.path() == "shear.inertial_number"
                || field.path().starts_with("contact.")
                || ["distribution", "void_ratio", "relative_density", "kind", "bedding_tilt"]
                    .contains(&field.key);
            if brings_keys || keys.len() == 1 {
                assert!(keys.contains(&field.path()), "{} is not compared", field.path());
            } else {
                panic!("{} and {keys:?}", field.path());
            }
            assert!(between(&one, &one.clone()).is_empty());
        }
    }

    #[test]
    fn values_are_shown_as_a_case_file_has_them() {
        let one = Case::default();
        let mut two = one.clone();
        two.set("preparation.mean_stress", "50 kPa").unwrap();
        two.set("contact.normal", "hertz").unwrap();
        two.set("shear.strain_rate", "2 /s").unwrap();
        let shown: Vec<String> = between(&one, &two).iter().map(Difference::to_string).collect();
        let wanted = [
            "contact.normal: \"jkr\" in one; \"hertz\" in two",
            "preparation.mean_stress: 20000 Pa in one; 50000 Pa in two",
            "shear.inertial_number: 3.64e-4 in one; not given in two",
            "shear.strain_rate: not given in one; 2 1/s in two",
            "shear.density_scaling: not given in one; 1 in two",
        ];
        assert_eq!(shown, wanted);
    }

    /// The test of the section `[shear]` and one of stages are two tests, also where `[shear]` has its defaults.
    #[test]
    fn stages_and_their_absence_are_a_difference() {
        let path = "[[stage]]\npath = 'isotropic'\nmean_stress = '50 kPa'\n";
        let staged = Case::parse(path, "case.toml").unwrap();
        let shown: Vec<String> =
            between(&Case::default(), &staged).iter().map(Difference::to_string).collect();
        assert_eq!(shown.len(), 1, "{shown:?}");
        assert!(
            shown[0].starts_with("stage: not given in one; [[stage]]; path = \"isotropic\""),
            "{}",
            shown[0]
        );
    }

    #[test]
    fn names_stand_with_their_value_and_unknown_keys_are_passed_over() {
        let values = |pairs: &[(&str, &str)]| -> CaseValues {
            pairs.iter().map(|(key, value)| (key.to_string(), value.to_string())).collect()
        };
        let (a, b) = (values(&[("x", "1"), ("packing", "p")]), values(&[("x", "2"), ("new", "3")]));
        let found = differences(&[("a", &a), ("b", &b), ("c", &a)]);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].to_string(), "x: 1 in a, c; 2 in b");
    }
}
