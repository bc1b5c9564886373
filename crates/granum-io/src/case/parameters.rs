//! Every resolved key of a case with its value and type: what a table or a data set can have as columns of a run.

use std::collections::BTreeMap;

use granum_dem::loading::preset::{Given, PathParameterDefault, PathValue, Preset};

use toml::de::{DeTable, DeValue};

use super::case_stage::CaseStage;
use super::case_stage::{PREPARATION_STAGE, STAGE};
use super::definition::Case;
use super::field::Value;
use super::shape_value::SHAPE;
use super::unit::dimension;

/// The value of a key of a case.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterValue {
    /// A number in the SI unit of the parameter.
    Number(f64),
    /// A choice: the name of a law or of a path, a keyword such as `none`, or any other text.
    Word(String),
    /// Numbers in the SI unit of the parameter.
    List(Vec<f64>),
}

/// A key of a case that takes part in its result, with its value.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseParameter {
    /// Its key: `grains.material.friction`, `material.sand.friction`, `stage.2.lateral_stress`.
    pub key: String,
    /// SI unit; empty for a pure number and for words.
    pub unit: String,
    /// Its value.
    pub value: ParameterValue,
}

impl CaseParameter {
    /// A parameter from its parts.
    pub fn new(key: impl Into<String>, unit: &str, value: ParameterValue) -> CaseParameter {
        CaseParameter { key: key.into(), unit: unit.into(), value }
    }

    /// The number, if it is one.
    pub fn number(&self) -> Option<f64> {
        match self.value {
            ParameterValue::Number(number) => Some(number),
            _ => None,
        }
    }
}

impl Case {
    /// Every key of the case, resolved, in the order of a case file: keys that were not given have their defaults, also those of
    /// materials and of named paths. Keys that have no part in the result are left out: those of laws that are not used, and those of
    /// `[shear]` where there are stages.
    ///
    /// Stages are counted from 1; a stage with explicit control has a key for each of its values (`stage.1.xx.stress`), and
    /// repeated stages stand below the number of their repetition (`stage.2.1.axial_strain`).
    ///
    /// ```
    /// let text = "[[stage]]\npath = 'isotropic'\nmean_stress = '50 kPa'\n[[stage]]\npath = 'drained-triaxial'\n";
    /// let case = granum_io::Case::parse(text, "case.toml")?;
    /// let parameters = case.parameters();
    /// let of = |key: &str| parameters.iter().find(|parameter| parameter.key == key);
    /// assert_eq!(of("stage.1.mean_stress").and_then(|found| found.number()), Some(5e4));
    /// // The default of the path.
    /// assert_eq!(of("stage.2.axial_strain").and_then(|found| found.number()), Some(0.2));
    /// assert!(of("shear.inertial_number").is_none());
    /// # Ok::<(), granum_io::Error>(())
    /// ```
    pub fn parameters(&self) -> Vec<CaseParameter> {
        let mut all = Vec::new();
        // Spheres have no parameters of shape, so that data sets of spheres are what they were before there were shapes.
        let spheres = self.grains.shapes.is_empty();
        for field in self.fields().iter().filter(|field| !(spheres && is_of_shapes(&field.path()))) {
            if let Some(value) = field.value(self).filter(|_| self.test.uses(&field.path())) {
                all.push(CaseParameter::new(
                    field.path(),
                    &field.si_unit(),
                    of_field(&value, &field.toml(&value)),
                ));
            }
        }
        for (key, value) in self.undeclared_parameters() {
            all.push(CaseParameter::new(format!("recording.{key}"), "", ParameterValue::Number(value)));
        }
        all.extend(self.shape_parameters());
        for (key, field, value) in self.material_fields() {
            let (unit, value) = match field {
                Some(field) => (field.si_unit(), of_field(&value, &field.toml(&value))),
                None => (String::new(), of_field(&value, "")),
            };
            all.push(CaseParameter::new(key, &unit, value));
        }
        all.extend(self.bond_parameters());
        add_stages(&mut all, PREPARATION_STAGE, &self.preparation_stages);
        add_stages(&mut all, STAGE, self.test.tables());
        all
    }

    /// The SI unit of a key, also of one that has no value in this case; empty for a pure number and for words, `None` for a key that
    /// the case cannot have.
    ///
    /// ```
    /// let case = granum_io::Case::parse("[[stage]]\npath = 'drained-triaxial'\n", "case.toml")?;
    /// assert_eq!(case.unit_of("stage.1.lateral_stress").as_deref(), Some("Pa"));
    /// assert_eq!(case.unit_of("grains.material.friction").as_deref(), Some(""));
    /// assert_eq!(case.unit_of("grains.material.frction"), None);
    /// # Ok::<(), granum_io::Error>(())
    /// ```
    pub fn unit_of(&self, key: &str) -> Option<String> {
        if let Some(field) = self.fields().named(key) {
            return Some(field.si_unit());
        }
        if let Some(parameter) = self.parameter_of(key) {
            return Some(dimension(parameter.unit).si_unit());
        }
        self.parameters().into_iter().find(|known| known.key == key).map(|known| known.unit)
    }
}

/// True for the keys that mean something only for grains that are not spheres.
fn is_of_shapes(key: &str) -> bool {
    key.starts_with(SHAPE) || key == "grains.size_measure" || key.starts_with("preparation.bedding_")
}

/// The value of a field, whose text in a case file is used where it is neither a number nor a list of them.
fn of_field(value: &Value, text: &str) -> ParameterValue {
    match value {
        Value::Number(Some(number)) => ParameterValue::Number(*number),
        Value::Count(count) => ParameterValue::Number(*count as f64),
        Value::Choice(word) => ParameterValue::Word((*word).to_string()),
        Value::List(values) if !values.is_empty() => ParameterValue::List(values.clone()),
        Value::Number(None) | Value::List(_) | Value::Names(_) | Value::Curve(_) | Value::Spheres(_) => {
            ParameterValue::Word(text.trim_matches('"').to_string())
        }
    }
}

fn add_stages(all: &mut Vec<CaseParameter>, place: &str, stages: &[CaseStage]) {
    for (k, stage) in stages.iter().enumerate() {
        let place = format!("{place}.{}", k + 1);
        match stage {
            CaseStage::Path { path, parameters, resets, until } => {
                let name = ParameterValue::Word(path.name.to_string());
                all.push(CaseParameter::new(format!("{place}.path"), "", name));
                add_path(all, &place, path, parameters);
                if !until.is_empty() {
                    add_text(all, &place, &super::stage_write::ends_toml(until));
                }
                if !resets {
                    all.push(CaseParameter::new(
                        format!("{place}.resets"),
                        "",
                        ParameterValue::Word("false".into()),
                    ));
                }
            }
            CaseStage::Repeat { times, stages } => {
                all.push(CaseParameter::new(
                    format!("{place}.repeat"),
                    "",
                    ParameterValue::Number(*times as f64),
                ));
                add_stages(all, &place, stages);
            }
            CaseStage::Control(_) => add_control(all, &place, stage),
        }
    }
}

/// The parameters of a named path, with their defaults where none is given.
fn add_path(all: &mut Vec<CaseParameter>, place: &str, path: &Preset, given: &Given) {
    let by_strain_rate = given.contains_key("strain_rate");
    for parameter in path.parameters() {
        let value = match (given.get(parameter.key), parameter.default) {
            (Some(PathValue::Number(number)), _) => ParameterValue::Number(*number),
            (Some(PathValue::Word(word)), _) => ParameterValue::Word(word.clone()),
            (Some(PathValue::List(values)), _) => ParameterValue::List(values.clone()),
            // A history has no single value; its rows are those of the file.
            (Some(PathValue::History(history)), _) => {
                let text = super::history::toml(history);
                let digest = granum_core::digest::sha256(text.as_bytes());
                ParameterValue::Word(format!("sha256:{digest}"))
            }
            // The strain rate replaces the default speed.
            (None, _) if by_strain_rate && parameter.key == "inertial_number" => continue,
            (None, PathParameterDefault::Value(number)) => ParameterValue::Number(number),
            (None, PathParameterDefault::Word(word)) => ParameterValue::Word(word.into()),
            (None, PathParameterDefault::List(values)) => ParameterValue::List(values.to_vec()),
            (None, PathParameterDefault::Absent(_) | PathParameterDefault::Needed) => continue,
        };
        let unit = match value {
            ParameterValue::Word(_) => String::new(),
            _ => dimension(parameter.unit).si_unit(),
        };
        all.push(CaseParameter::new(format!("{place}.{}", parameter.key), &unit, value));
    }
}

/// The values of keys that a stage has beside its parameters, from their lines in a case file.
fn add_text(all: &mut Vec<CaseParameter>, place: &str, lines: &str) {
    let Ok(table) = DeTable::parse(lines) else { return };
    let mut values = BTreeMap::new();
    for (key, value) in table.get_ref() {
        flatten(&format!("{place}.{}", key.get_ref()), value.get_ref(), &mut values);
    }
    all.extend(values.into_iter().map(|(key, value)| CaseParameter::new(key, "", value)));
}

/// The values of a stage with explicit control, by the keys that a case file has for them.
fn add_control(all: &mut Vec<CaseParameter>, place: &str, stage: &CaseStage) {
    // What granum writes can be read: a table of stages with one entry.
    let text = stage.toml(STAGE);
    let Ok(table) = DeTable::parse(&text) else { return };
    let Some(DeValue::Array(stages)) = table.get_ref().get(STAGE).map(|stages| stages.get_ref()) else {
        return;
    };
    let Some(inner) = stages.iter().next() else { return };
    let mut found = BTreeMap::new();
    flatten(place, inner.get_ref(), &mut found);
    all.extend(found.into_iter().map(|(key, value)| {
        let unit = match value {
            ParameterValue::Word(_) => "",
            _ => unit_of_control(key.rsplit('.').find(|part| part.parse::<u32>().is_err()).unwrap_or("")),
        };
        CaseParameter::new(key, unit, value)
    }));
}

/// The SI unit of a value of an explicit control that has one by itself.
fn unit_of_control(key: &str) -> &'static str {
    match key {
        "stress" | "stress_to" | "stress_by" => "Pa",
        "stress_rate" => "Pa/s",
        "strain_rate" => "1/s",
        _ => "",
    }
}

fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(number) => number.as_str().replace('_', "").parse().ok(),
        DeValue::Integer(number) => number.as_str().replace('_', "").parse().ok(),
        _ => None,
    }
}

fn flatten(place: &str, value: &DeValue<'_>, found: &mut BTreeMap<String, ParameterValue>) {
    match value {
        DeValue::Table(table) => table
            .iter()
            .for_each(|(key, value)| flatten(&format!("{place}.{}", key.get_ref()), value.get_ref(), found)),
        DeValue::Array(items) => {
            match items.iter().map(|item| number(item.get_ref())).collect::<Option<Vec<f64>>>() {
                Some(numbers) => drop(found.insert(place.into(), ParameterValue::List(numbers))),
                None => (items.iter().enumerate())
                    .for_each(|(k, item)| flatten(&format!("{place}.{}", k + 1), item.get_ref(), found)),
            }
        }
        DeValue::String(text) => drop(found.insert(place.into(), ParameterValue::Word(text.to_string()))),
        DeValue::Boolean(yes) => drop(found.insert(place.into(), ParameterValue::Word(yes.to_string()))),
        other => {
            found.extend(number(other).map(|number| (place.to_string(), ParameterValue::Number(number))));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(text: &str) -> BTreeMap<String, (String, ParameterValue)> {
        let case = Case::parse(text, "case.toml").unwrap();
        case.parameters().into_iter().map(|found| (found.key, (found.unit, found.value))).collect()
    }

    #[test]
    fn fields_are_typed_and_have_units() {
        let found = all(
            "[contact]\nnormal = 'hertz'\n[grains.material]\nyoungs_modulus = '2 GPa'\ninterface_energy = 0\n",
        );
        assert_eq!(found["grains.material.youngs_modulus"], ("Pa".into(), ParameterValue::Number(2e9)));
        assert_eq!(found["contact.normal"], (String::new(), ParameterValue::Word("hertz".into())));
        assert_eq!(found["grains.count"].1, ParameterValue::Number(5000.0));
        // A keyword is a word, and the keys of other laws have no part in the case.
        assert!(
            matches!(&found["recording.sensors"].1, ParameterValue::Word(word) if word == "none"),
            "{found:?}"
        );
        assert!(!found.contains_key("contact.rolling_friction"));
        assert!(found.contains_key("shear.inertial_number"));
    }

    #[test]
    fn a_material_has_every_key_whether_it_is_its_own_or_not() {
        let found = all(
            "[contact]\nrolling = 'elastic-plastic'\nrolling_friction = 0.3\n[grains.material]\nfriction = 0.5\n\
                         [[material]]\nname = 'sand'\nshare = 0.75\nrolling_friction = 0.1\n[[material]]\nname = 'silt'\nfriction = 0.2\n\
                         [[pair]]\nbetween = ['sand', 'silt']\nfriction = 0.35\n",
        );
        let number = |key: &str| match found[key].1 {
            ParameterValue::Number(number) => number,
            _ => panic!("{key}"),
        };
        assert_eq!(number("material.sand.friction"), 0.5);
        assert_eq!(number("material.silt.friction"), 0.2);
        assert_eq!(number("material.sand.rolling_friction"), 0.1);
        assert_eq!(number("material.silt.rolling_friction"), 0.3);
        assert_eq!(number("material.silt.share"), 0.25);
        assert_eq!(number("pair.sand.silt.friction"), 0.35);
    }

    #[test]
    fn stages_of_every_kind_have_their_keys() {
        let found = all("[[preparation.stage]]\npath = 'isotropic'\nmean_stress = '30 kPa'\n\
                         [[stage]]\npath = 'drained-triaxial'\nlateral_stress = '50 kPa'\nstrain_rate = '1 /s'\n\
                         [[stage]]\nrepeat = 3\n[[stage.stage]]\nname = 'down'\nxx = { rate = 1 }\nyy = { stress = '50 kPa' }\n\
                         zz = { stress = '50 kPa' }\nuntil = { xx_strain = 0.01 }\n");
        let value = |key: &str| &found.get(key).unwrap_or_else(|| panic!("{key} of {:?}", found.keys())).1;
        assert_eq!(value("preparation.stage.1.mean_stress"), &ParameterValue::Number(3e4));
        assert_eq!(value("stage.1.path"), &ParameterValue::Word("drained-triaxial".into()));
        assert_eq!(found["stage.1.lateral_stress"], ("Pa".into(), ParameterValue::Number(5e4)));
        assert_eq!(found["stage.1.strain_rate"], ("1/s".into(), ParameterValue::Number(1.0)));
        assert!(!found.contains_key("stage.1.inertial_number"));
        assert_eq!(value("stage.2.repeat"), &ParameterValue::Number(3.0));
        assert_eq!(found["stage.2.1.yy.stress"], ("Pa".into(), ParameterValue::Number(5e4)));
        assert_eq!(value("stage.2.1.until.xx_strain"), &ParameterValue::Number(0.01));
        assert_eq!(value("stage.2.1.name"), &ParameterValue::Word("down".into()));
    }

    #[test]
    fn equal_cases_have_equal_parameters_and_different_ones_do_not() {
        let paper = Case::default();
        let read_back = Case::parse(&paper.resolved_toml(), "case.toml").unwrap();
        assert_eq!(paper.parameters(), read_back.parameters());
        let mut other = paper.clone();
        other.set("preparation.seed", "77").unwrap();
        assert_ne!(paper.parameters(), other.parameters());
    }
}
