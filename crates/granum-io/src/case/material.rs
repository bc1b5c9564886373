//! The tables `[[material]]` and `[[pair]]` of a case: several materials in one sample, and what two of them have in common.
//!
//! A material has the keys of `[grains.material]` and the parameters of contact laws; a key that it leaves out has the value of
//! `[grains.material]` or `[contact]`. Its values are read, bounded and written by the fields of those sections.

use std::sync::Arc;

use granum_dem::config::{Component, ContactModel, Material, Mixture, PairRule, ParameterValues};
use granum_dem::contact::choice::check;
use granum_dem::simulation::Properties;

use super::definition::Case;
use super::field::{Field, Value};
use super::fields::Fields;
use super::suggestion::meant;
use crate::error::{Error, Result};
use crate::material_name::is_material_name;
use granum_core::quantity::format_number;

/// Section whose keys a material has.
pub(super) const MATERIAL: &str = "grains.material";
/// Keys of `[grains.material]` that a pair may have.
pub(super) const OF_PAIR: [&str; 2] = ["friction", "interface_energy"];

/// Help of the keys that are not those of another section.
pub(super) const NAME: &str =
    "Its name, of letters, digits, - and _. The order of the materials does not matter.";
pub(super) const SHARE: &str = "Share of the grains, by number; one may be left out and gets the rest; all are equal \
                                if none is given. Which grain has which material is drawn at random from \
                                preparation.seed.";
pub(super) const BETWEEN: &str =
    "The names of two materials, or one name twice: the values apply to contacts between their grains.";

/// Smallest share of a material.
pub(super) const SMALLEST_SHARE: f64 = 1e-6;

/// The fields that a material may have.
pub(super) fn fields(all: &Fields) -> impl Iterator<Item = Arc<Field>> + '_ {
    all.iter().filter(|field| field.section == MATERIAL || field.is_of_law()).cloned()
}

/// The fields that a pair of materials may have.
pub(super) fn pair_fields(all: &Fields) -> impl Iterator<Item = Arc<Field>> + '_ {
    fields(all).filter(|field| field.is_of_law() || OF_PAIR.contains(&field.key))
}

/// The same case with a material and parameters of laws in place of its own, through which the fields of a case reach them.
fn scratch(case: &Case, material: Material, parameters: ParameterValues) -> Case {
    let mut scratch = case.clone();
    scratch.grains.material = material;
    scratch.contact.parameters = parameters;
    scratch
}

/// Puts a value among those of the laws, if it is one of them. A value that equals the default is kept as given: `[contact]`, or
/// the mean of two materials, may differ from the default.
fn put_of_law(parameters: &mut ParameterValues, field: &Field, value: &Value) -> bool {
    match (field.law_parameter(), value) {
        // There is room for all parameters that are registered.
        (Some(parameter), Value::Number(Some(value))) => {
            parameters.set(parameter.key, *value).map_or(true, |()| true)
        }
        _ => false,
    }
}

/// Puts the value of a field into a material.
pub(super) fn put(case: &Case, component: &mut Component, field: &Field, value: Value) {
    if put_of_law(&mut component.parameters, field, &value) {
        return;
    }
    let mut scratch = scratch(case, component.material, component.parameters);
    field.apply(&mut scratch, value);
    (component.material, component.parameters) = (scratch.grains.material, scratch.contact.parameters);
}

/// Puts the value of a field into the rule of a pair.
pub(super) fn put_into_pair(case: &Case, rule: &mut PairRule, field: &Field, value: Value) {
    match (field.key, &value) {
        ("friction", Value::Number(friction)) => rule.friction = *friction,
        ("interface_energy", Value::Number(energy)) => rule.interface_energy = *energy,
        _ if put_of_law(&mut rule.parameters, field, &value) => {}
        _ => {
            let mut scratch = scratch(case, Material::default(), rule.parameters);
            field.apply(&mut scratch, value);
            rule.parameters = scratch.contact.parameters;
        }
    }
}

/// What is wrong where no law of a case has a parameter, if so.
pub(super) fn means_nothing(contact: &ContactModel, place: &str, field: &Field) -> Option<String> {
    let used = check::parameters_of(contact).iter().any(|parameter| parameter.key == field.key);
    if used || !field.is_of_law() {
        return None;
    }
    let mut parameters = ParameterValues::NONE;
    let known = field.law_parameter()?;
    parameters.set(known.key, known.default).ok()?;
    let error = check::check(&(*contact).with(|contact| contact.parameters = parameters)).err()?.to_string();
    Some(error.replace(&format!("contact.{}", field.key), &format!("{place}.{}", field.key)))
}

/// The value of a field of a material, if it is its own.
fn own_value(case: &Case, component: &Component, field: &Field) -> Option<Value> {
    if field.is_of_law() && component.parameters.given(field.key).is_none() {
        return None;
    }
    field.value(&scratch(case, component.material, component.parameters))
}

/// The value of a field of the rule of a pair, if it is given.
fn pair_value(case: &Case, rule: &PairRule, field: &Field) -> Option<Value> {
    match field.key {
        "friction" => rule.friction.map(|value| Value::Number(Some(value))),
        "interface_energy" => rule.interface_energy.map(|value| Value::Number(Some(value))),
        key => {
            rule.parameters.given(key)?;
            field.value(&scratch(case, Material::default(), rule.parameters))
        }
    }
}

/// A line of a table.
fn line(field: &Field, value: &Value) -> String {
    let unit = field.si_unit();
    let comment = if unit.is_empty() { unit } else { format!("  # {unit}") };
    format!("{} = {}{comment}\n", field.key, field.toml(value))
}

impl Case {
    /// Materials and contact law of the grains.
    ///
    /// ```
    /// let text = "[[material]]\nname = \"glass\"\n[[material]]\nname = \"steel\"\nshare = 0.2\ndensity = 7800\n";
    /// let case = granum_io::Case::parse(text, "case.toml").unwrap();
    /// assert_eq!(case.properties().mixture.components[1].material.density, 7800.0);
    /// assert_eq!(case.grains.mixture.components[0].share, 0.8);
    /// ```
    pub fn properties(&self) -> Properties {
        Properties::for_grains(&self.grains, &self.contact, self.preparation.seed)
    }

    /// The tables `[[material]]` and `[[pair]]` as TOML in SI units; empty where there is one material.
    pub fn materials_toml(&self) -> String {
        self.materials_with(|_, _| true)
    }

    /// The same for digests: a parameter of a law is left out where it has its default and would have it anyway, so that a case has
    /// one digest whether the default is written out or not.
    pub(super) fn materials_for_digest(&self) -> String {
        let standard = |field: &Field, names: &[&String]| {
            let is_default = |value: Option<Value>| field.is_default_of_law(&value);
            let of = |name: &&String| {
                let component = self.grains.mixture.components.iter().find(|known| known.name == **name);
                component.and_then(|component| own_value(self, component, field))
            };
            match names {
                [_] => is_default(field.value(self)),
                pair => pair.iter().all(|name| is_default(of(name).or_else(|| field.value(self)))),
            }
        };
        self.materials_with(|(field, value), names| {
            !(field.is_default_of_law(&Some(value.clone())) && standard(field, names))
        })
    }

    /// The tables with the values of one material or of a pair that are wanted.
    fn materials_with(&self, wanted: impl Fn((&Field, &Value), &[&String]) -> bool) -> String {
        let mut text = String::new();
        for component in &self.grains.mixture.components {
            text.push_str(&format!("\n[[material]]\nname = \"{}\"\n", component.name));
            text.push_str(&format!("share = {}\n", format_number(component.share)));
            for field in fields(&self.fields()) {
                let value = own_value(self, component, &field);
                let value = value.filter(|value| wanted((&field, value), &[&component.name]));
                text.extend(value.map(|value| line(&field, &value)));
            }
        }
        for rule in &self.grains.mixture.pairs {
            let [a, b] = &rule.between;
            text.push_str(&format!("\n[[pair]]\nbetween = [\"{a}\", \"{b}\"]\n"));
            for field in pair_fields(&self.fields()) {
                let value = pair_value(self, rule, &field);
                let value = value.filter(|value| wanted((&field, value), &[a, b]));
                text.extend(value.map(|value| line(&field, &value)));
            }
        }
        text
    }

    /// Keys and values of the materials and of their pairs, for comparisons: `material.glass.density`.
    pub(super) fn material_values(&self) -> Vec<(String, String)> {
        let (mut values, all_fields) = (Vec::new(), self.fields());
        let shown = |field: &Field, value: &Value| {
            let (text, unit) = (field.toml(value), field.si_unit());
            if unit.is_empty() { text } else { format!("{text} {unit}") }
        };
        for component in &self.grains.mixture.components {
            let key = |key: &str| format!("material.{}.{key}", component.name);
            values.push((key("share"), format_number(component.share)));
            let own = fields(&all_fields).filter_map(|field| {
                let value = own_value(self, component, &field)?;
                Some((field, value))
            });
            values.extend(own.map(|(field, value)| (key(field.key), shown(&field, &value))));
        }
        for rule in &self.grains.mixture.pairs {
            let [a, b] = &rule.between;
            let given = pair_fields(&all_fields).filter_map(|field| {
                let value = pair_value(self, rule, &field)?;
                Some((field, value))
            });
            values.extend(
                given.map(|(field, value)| (format!("pair.{a}.{b}.{}", field.key), shown(&field, &value))),
            );
        }
        values
    }

    /// The keys of the materials and of their pairs with all their values, also those that a material takes from `[grains.material]`
    /// and `[contact]`; without a field where the value is the share.
    pub(super) fn material_fields(&self) -> Vec<(String, Option<Arc<Field>>, Value)> {
        let (mut all, all_fields) = (Vec::new(), self.fields());
        for component in &self.grains.mixture.components {
            let key = |key: &str| format!("material.{}.{key}", component.name);
            all.push((key("share"), None, Value::Number(Some(component.share))));
            let value = |field: &Field| own_value(self, component, field).or_else(|| field.value(self));
            all.extend(fields(&all_fields).filter_map(|field| {
                let value = value(&field)?;
                Some((key(field.key), Some(field), value))
            }));
        }
        for rule in &self.grains.mixture.pairs {
            let [a, b] = &rule.between;
            let key = |field: &Field| format!("pair.{a}.{b}.{}", field.key);
            let given = pair_fields(&all_fields).filter_map(|field| {
                let value = pair_value(self, rule, &field)?;
                Some((field, value))
            });
            all.extend(given.map(|(field, value)| (key(&field), Some(field), value)));
        }
        all
    }

    /// Sets a key of a material or of a pair of them: `material.glass.friction`, `pair.glass.steel.friction`.
    pub(super) fn set_material(&mut self, path: &str, text: &str) -> Result<()> {
        let wrong =
            |message: String| Error::Value { name: path.to_string(), value: text.to_string(), message };
        let parts: Vec<&str> = path.split('.').collect();
        let names = |mixture: &Mixture| -> Vec<String> {
            mixture.components.iter().map(|component| component.name.clone()).collect()
        };
        let known = names(&self.grains.mixture);
        let unknown = |name: &str| {
            if known.is_empty() {
                return wrong("needs the tables [[material]] in the case file".into());
            }
            let help = meant(name, known.iter().map(String::as_str));
            wrong(format!("names a material {name:?} that the case does not have; {help}"))
        };
        let of_key = |key: &str, all: &mut dyn Iterator<Item = Arc<Field>>| {
            let all: Vec<Arc<Field>> = all.collect();
            let found = all.iter().find(|field| field.key == key).cloned();
            found.ok_or_else(|| {
                let help = meant(key, all.iter().map(|field| field.key));
                wrong(format!("is not one of its keys; {help}"))
            })
        };
        let (case, all_fields) = (self.clone(), self.fields());
        match parts.as_slice() {
            ["material", name, key] => {
                let place = self.grains.mixture.position(name).ok_or_else(|| unknown(name))?;
                if *key == "share" || *key == "name" {
                    return Err(wrong("can only be changed in the case file".into()));
                }
                let field = of_key(key, &mut fields(&all_fields))?;
                let value = field.parse(text).map_err(wrong)?;
                put(&case, &mut self.grains.mixture.components[place], &field, value);
            }
            ["pair", a, b, key] => {
                for name in [a, b] {
                    self.grains.mixture.position(name).ok_or_else(|| unknown(name))?;
                }
                let field = of_key(key, &mut pair_fields(&all_fields))?;
                let value = field.parse(text).map_err(wrong)?;
                let between = [a.to_string(), b.to_string()];
                let mut rule = self.grains.mixture.rule(a, b).cloned();
                let mut rule = rule.take().unwrap_or(PairRule { between, ..PairRule::default() });
                put_into_pair(&case, &mut rule, &field, value);
                self.grains.mixture.pairs.retain(|known| known.between != rule.between);
                self.grains.mixture.pairs.push(rule);
                self.grains.mixture.sort();
            }
            _ => {
                return Err(wrong(
                    "is not a key of a material, e.g. material.NAME.friction or pair.NAME.NAME.friction"
                        .into(),
                ));
            }
        }
        Ok(())
    }

    /// Checks materials and pairs: names, shares and the bounds of all values.
    pub(super) fn check_materials(&self) -> Result<()> {
        let mixture = &self.grains.mixture;
        if let Some(component) =
            mixture.components.iter().find(|component| !is_material_name(&component.name))
        {
            return Err(Error::Rule(format!(
                "the name {:?} of a material must be of letters, digits, - and _",
                component.name
            )));
        }
        let check = |name: String, field: &Field, value: Option<Value>| match value {
            None => Ok(()),
            Some(value) => {
                let text = field.toml(&value);
                let wrong = |message| Error::Value { name, value: text.clone(), message };
                field.parse(&text).map(|_| ()).map_err(wrong)
            }
        };
        for component in &mixture.components {
            for field in fields(&self.fields()) {
                let name = format!("material.{}.{}", component.name, field.key);
                check(name, &field, own_value(self, component, &field))?;
            }
        }
        for rule in &mixture.pairs {
            for field in pair_fields(&self.fields()) {
                let name = format!("pair.{}.{}.{}", rule.between[0], rule.between[1], field.key);
                check(name, &field, pair_value(self, rule, &field))?;
            }
        }
        mixture.check(&self.contact).map_err(|error| Error::Rule(error.to_string()))
    }
}
