//! Reads the tables `[[bond]]` of a case file.

use toml::Spanned;
use toml::de::DeValue;

use super::BOND;
use super::case_bond::CaseBond;
use super::keys::{KEYS, parameter};
use crate::case::definition::Case;
use crate::case::reader::Reader;
use crate::case::suggestion::meant;
use crate::error::{Error, Result};

/// The text of a value, if it is a single one.
fn text_of(value: &DeValue<'_>) -> Option<String> {
    match value {
        DeValue::String(text) => Some(text.to_string()),
        DeValue::Float(number) => Some(number.as_str().replace('_', "")),
        DeValue::Integer(number) if number.radix() == 10 => Some(number.as_str().replace('_', "")),
        _ => None,
    }
}

impl Reader<'_> {
    /// Reads `[[bond]]`; mistakes go to the others.
    pub(in crate::case) fn bonds(&mut self, value: &Spanned<DeValue<'_>>) -> Vec<CaseBond> {
        let laws = self.reading.vocabulary.laws().clone();
        let mut read = Vec::new();
        for (k, (table, _)) in self.tables(BOND, value).into_iter().enumerate() {
            let place = format!("{BOND}.{}", k + 1);
            let mut bond = CaseBond::default();
            // The law comes first: it decides which other keys there are.
            let first = table.iter().filter(|(key, _)| key.get_ref() == "law");
            let others = table.iter().filter(|(key, _)| key.get_ref() != "law");
            for (key, value) in first.chain(others) {
                let name = key.get_ref().as_ref();
                self.keys.insert(format!("{place}.{name}"), key.span());
                let law = bond.law(&laws);
                if KEYS.iter().all(|known| known.key != name) && parameter(law, name).is_none() {
                    let parameters = law.law().description().parameters.iter().map(|parameter| parameter.key);
                    let help = meant(name, KEYS.iter().map(|known| known.key).chain(parameters));
                    self.error(key.span(), format!("unknown key {place}.{name}")).help = Some(help);
                    continue;
                }
                let result = match text_of(value.get_ref()) {
                    Some(text) => bond.set(name, &text, &laws),
                    None => Err("must be a single value".into()),
                };
                if let Err(why) = result {
                    let message = format!("{place}.{name} = {} {why}", self.shown(&value.span()));
                    self.error(value.span(), message);
                }
            }
            read.push(bond);
        }
        read
    }

    /// Checks what the bonds of a case need of the rest of it.
    pub(in crate::case) fn check_bonds(&mut self, case: &Case) {
        if let Err((key, message)) = problem(case) {
            let span = self.keys.get(&key).or(self.keys.get(BOND)).cloned().unwrap_or(0..0);
            self.error(span, message);
        }
    }
}

/// The first thing that is wrong with the bonds of a case: the key, and a sentence.
fn problem(case: &Case) -> std::result::Result<(), (String, String)> {
    let laws = case.vocabulary.laws();
    let stages = case.test_definition().stages.len();
    for (k, bond) in case.bonds.iter().enumerate() {
        let key = |key: &str| format!("{BOND}.{}.{key}", k + 1);
        if let Some((name, why)) = bond.without_effect(laws) {
            return Err((key(&name), format!("{} has no effect {why}", key(&name))));
        }
        let before = bond.before_stage();
        if before > stages {
            let message = format!("{} = {before}, but the test has {stages} stages", key("before_stage"));
            return Err((key("before_stage"), message));
        }
        let bonding = bond.bonding(laws);
        if bonding.places == granum_dem::bond::BondPlaces::Inside && case.grains.are_spheres() {
            let message = format!(
                "{} = \"inside\" joins the pieces of grains, and all grains are spheres; give grains.shape, e.g. kind = \"agglomerate\"",
                key("places")
            );
            return Err((key("places"), message));
        }
    }
    let attracts = case.contact.adhesion.law().acts();
    let sticky = case.grains.material.interface_energy > 0.0
        || case.grains.mixture.components.iter().any(|component| component.material.interface_energy > 0.0)
        || case
            .grains
            .mixture
            .pairs
            .iter()
            .any(|rule| rule.interface_energy.is_some_and(|energy| energy > 0.0));
    if !case.bonds.is_empty() && (attracts || sticky) {
        let what = if attracts { "contact.adhesion" } else { "grains.material.interface_energy" };
        let right = if attracts { "\"none\"" } else { "0" };
        let message = format!("bonds hold grains that {what} attracts already; write {what} = {right}");
        return Err((what.into(), message));
    }
    Ok(())
}

impl Case {
    /// Checks what the bonds of a case need of the rest of it.
    ///
    /// # Errors
    /// [`Error::Rule`] with what is wrong.
    pub(in crate::case) fn check_bonds(&self) -> Result<()> {
        problem(self).map_err(|(_, message)| Error::Rule(message))
    }
}
