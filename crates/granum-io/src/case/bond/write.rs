//! Bonds of a case as text, as parameters of a run, and as keys that can be set.

use granum_core::quantity::format_number;

use super::BOND;
use super::case_bond::BondValue;
use super::keys::{KEYS, parameter};
use crate::case::definition::Case;
use crate::case::parameters::{CaseParameter, ParameterValue};
use crate::case::suggestion::meant;
use crate::error::{Error, Result};

fn text_of(value: &BondValue) -> String {
    match value {
        BondValue::Number(number) if *number == f64::INFINITY => "inf".into(),
        BondValue::Number(number) => format_number(*number),
        BondValue::Word(word) => format!("\"{word}\""),
    }
}

impl Case {
    /// The tables `[[bond]]` as TOML in SI units, with every key that has an effect; empty where there are no bonds.
    pub fn bonds_toml(&self) -> String {
        let laws = self.vocabulary.laws();
        let mut text = String::new();
        for bond in &self.bonds {
            text.push_str("\n[[bond]]\n");
            for (key, unit, value) in bond.resolved(laws) {
                let remark = if unit.is_empty() { String::new() } else { format!("  # {unit}") };
                text.push_str(&format!("{key} = {}{remark}\n", text_of(&value)));
            }
        }
        text
    }

    /// Keys and values of the tables, for comparisons: `bond.1.modulus`.
    pub(in crate::case) fn bond_values(&self) -> Vec<(String, String)> {
        let laws = self.vocabulary.laws();
        let tables = self.bonds.iter().enumerate();
        tables
            .flat_map(|(k, bond)| {
                let shown = |(key, unit, value): (&str, String, BondValue)| {
                    let text = format!("{} {unit}", text_of(&value));
                    (format!("{BOND}.{}.{key}", k + 1), text.trim_end().to_string())
                };
                bond.resolved(laws).into_iter().map(shown).collect::<Vec<_>>()
            })
            .collect()
    }

    /// The parameters of a run that its bonds are. A strength without bound is no number of a table.
    pub(in crate::case) fn bond_parameters(&self) -> Vec<CaseParameter> {
        let laws = self.vocabulary.laws();
        let mut all = Vec::new();
        for (k, bond) in self.bonds.iter().enumerate() {
            for (key, unit, value) in bond.resolved(laws) {
                let value = match value {
                    BondValue::Number(number) if number.is_finite() => ParameterValue::Number(number),
                    BondValue::Number(_) => continue,
                    BondValue::Word(word) => ParameterValue::Word(word),
                };
                all.push(CaseParameter::new(format!("{BOND}.{}.{key}", k + 1), &unit, value));
            }
        }
        all
    }

    /// Sets a key of one of the tables: `bond.1.modulus`.
    pub(in crate::case) fn set_bond(&mut self, path: &str, text: &str) -> Result<()> {
        let wrong =
            |message: String| Error::Value { name: path.to_string(), value: text.to_string(), message };
        let rest = path.strip_prefix(BOND).and_then(|rest| rest.strip_prefix('.')).unwrap_or_default();
        let (number, key) = rest.split_once('.').unwrap_or((rest, ""));
        let count = self.bonds.len();
        let place = number.parse::<usize>().ok().filter(|number| (1..=count).contains(number));
        let Some(place) = place else {
            return Err(wrong(match count {
                0 => "needs a table [[bond]] in the case file".into(),
                _ => format!("names bonds that the case does not have; there are {count}, counted from 1"),
            }));
        };
        let laws = self.vocabulary.laws().clone();
        let law = self.bonds[place - 1].law(&laws);
        if KEYS.iter().all(|known| known.key != key) && parameter(law, key).is_none() {
            let parameters = law.law().description().parameters.iter().map(|parameter| parameter.key);
            let names = KEYS.iter().map(|known| known.key).chain(parameters);
            return Err(wrong(format!("is not one of its keys; {}", meant(key, names))));
        }
        let mut changed = self.bonds[place - 1].clone();
        changed.set(key, text, &laws).map_err(wrong)?;
        self.bonds[place - 1] = changed;
        Ok(())
    }
}
