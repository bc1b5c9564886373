//! Reads the tables `[[material]]` and `[[pair]]` of a case file.

use std::ops::Range;
use std::sync::Arc;

use granum_dem::config::{Component, Mixture, PairRule};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::definition::Case;
use super::field::Field;
use super::material::{SMALLEST_SHARE, fields, means_nothing, pair_fields, put, put_into_pair};
use super::material_table::{MaterialTable, PairTable, Values};
use super::reader::{Reader, scalar};
use super::suggestion::meant;
use crate::material_name::is_material_name;
use granum_core::quantity::{Dimension, format_number, parse_quantity};

/// A value with its position in the file.
type Node<'a> = Spanned<DeValue<'a>>;

/// The place of a table for messages: `material.2`.
fn place_of(key: &str, number: usize) -> String {
    format!("{key}.{number}")
}

impl Reader<'_> {
    /// The tables of a list of tables; others are mistakes.
    pub(super) fn tables<'t, 'a>(
        &mut self,
        key: &str,
        value: &'t Node<'a>,
    ) -> Vec<(&'t DeTable<'a>, Range<usize>)> {
        let DeValue::Array(items) = value.get_ref() else {
            let message = format!("{key} = {} is not a list of tables", self.shown(&value.span()));
            self.error(value.span(), message).help = Some(format!("write [[{key}]] with its keys below"));
            return Vec::new();
        };
        let mut tables = Vec::new();
        for (k, item) in items.iter().enumerate() {
            match item.get_ref() {
                DeValue::Table(table) => tables.push((table, item.span())),
                other => {
                    let place = place_of(key, k + 1);
                    let message = format!("{place} is of type {}; it must be a table", other.type_str());
                    self.error(item.span(), message);
                }
            }
        }
        tables
    }

    /// Reads `[[material]]`; mistakes go to the others.
    pub(super) fn materials(&mut self, value: &Node<'_>) -> Vec<MaterialTable> {
        let mut found = Vec::new();
        for (k, (table, span)) in self.tables("material", value).into_iter().enumerate() {
            let place = place_of("material", k + 1);
            let known: Vec<Arc<Field>> = fields(&self.fields).collect();
            let values = self.values_of(&place, table, &known, &["name", "share"]);
            let Some(name) = self.name_of(&place, table, &span) else { continue };
            let share = table.get("share").and_then(|node| Some((self.share(&place, node)?, node.span())));
            found.push(MaterialTable { place, span, name, share, values });
        }
        found
    }

    /// Reads `[[pair]]`; mistakes go to the others.
    pub(super) fn pairs(&mut self, value: &Node<'_>) -> Vec<PairTable> {
        let mut found = Vec::new();
        for (k, (table, span)) in self.tables("pair", value).into_iter().enumerate() {
            let place = place_of("pair", k + 1);
            let known: Vec<Arc<Field>> = pair_fields(&self.fields).collect();
            let values = self.values_of(&place, table, &known, &["between"]);
            let names = table.get("between").map(|node| (names(node), node.span()));
            match names {
                Some((Some(between), _)) => found.push(PairTable { place, between, values }),
                Some((None, at)) => {
                    let message = format!("{place}.between = {} is not a pair of names", self.shown(&at));
                    self.error(at, message).help = Some("e.g. between = [\"glass\", \"steel\"]".into());
                }
                None => {
                    self.error(span, format!("{place} does not name its two materials")).help =
                        Some("add between = [\"NAME\", \"NAME\"]".into());
                }
            }
        }
        found
    }

    /// The values of the fields of a table; keys that are neither fields nor others are mistakes.
    pub(super) fn values_of(
        &mut self,
        place: &str,
        table: &DeTable<'_>,
        known: &[Arc<Field>],
        others: &[&str],
    ) -> Values {
        let mut values = Vec::new();
        for (key, value) in table {
            let name = key.get_ref().as_ref();
            if others.contains(&name) {
                continue;
            }
            let Some(field) = known.iter().find(|field| field.key == name).cloned() else {
                let all = known.iter().map(|field| field.key).chain(others.iter().copied());
                let help = meant(name, all);
                self.error(key.span(), format!("unknown key {place}.{name}")).help = Some(help);
                continue;
            };
            let parsed = match value.get_ref() {
                DeValue::Array(items) if field.is_spheres() => Self::spheres(items).map_err(|(_, why)| why),
                other => scalar(&field, other).and_then(|text| field.parse(&text)),
            };
            match parsed {
                Ok(found) => values.push((field, found, key.span())),
                Err(why) => {
                    let message = format!("{place}.{name} = {} {why}", self.shown(&value.span()));
                    let quoted = field.example.parse::<f64>().is_err();
                    let example = if quoted { format!("{:?}", field.example) } else { field.example.clone() };
                    self.error(value.span(), message).help = Some(format!("e.g. {name} = {example}"));
                }
            }
        }
        values
    }

    fn name_of(&mut self, place: &str, table: &DeTable<'_>, span: &Range<usize>) -> Option<String> {
        let Some(node) = table.get("name") else {
            self.error(span.clone(), format!("{place} has no name")).help =
                Some("add one, e.g. name = \"glass\"".into());
            return None;
        };
        match node.get_ref() {
            DeValue::String(name) if is_material_name(name) => Some(name.to_string()),
            _ => {
                let shown = self.shown(&node.span());
                let message = format!("{place}.name = {shown} must be text of letters, digits, - and _");
                self.error(node.span(), message).help = Some("e.g. name = \"glass\"".into());
                None
            }
        }
    }

    fn share(&mut self, place: &str, node: &Node<'_>) -> Option<f64> {
        let text = match node.get_ref() {
            DeValue::String(text) => text.to_string(),
            DeValue::Float(number) => number.as_str().replace('_', ""),
            DeValue::Integer(number) if number.radix() == 10 => number.as_str().replace('_', ""),
            _ => String::new(),
        };
        let bounds = format!("it must be from {} to 1", format_number(SMALLEST_SHARE));
        let found = parse_quantity(&text, Dimension::NUMBER).and_then(|share| {
            let fits = (SMALLEST_SHARE..=1.0).contains(&share);
            if fits { Ok(share) } else { Err(format!("is out of bounds; {bounds}")) }
        });
        found
            .map_err(|why| {
                let message = format!("{place}.share = {} {why}", self.shown(&node.span()));
                self.error(node.span(), message).help = Some("e.g. share = 0.5".into());
            })
            .ok()
    }

    /// The mixture of the tables, where keys that are left out have the values of the case.
    pub(super) fn mixture(
        &mut self,
        case: &Case,
        materials: Vec<MaterialTable>,
        pairs: Vec<PairTable>,
    ) -> Mixture {
        let before = self.errors.len();
        let mut mixture = Mixture::default();
        let shares = self.shares(&materials);
        for (table, share) in materials.iter().zip(shares) {
            if mixture.position(&table.name).is_some() {
                let message = format!(
                    "{}.name = {:?} is already the name of another material",
                    table.place, table.name
                );
                self.error(table.span.clone(), message).help = Some("give it another name".into());
            }
            let mut component = Component::new(table.name.clone(), share, case.grains.material);
            for (field, value, span) in &table.values {
                if let Some(message) = means_nothing(&case.contact, &table.place, field) {
                    self.error(span.clone(), message);
                }
                put(case, &mut component, field, value.clone());
            }
            mixture.components.push(component);
        }
        for table in &pairs {
            let mut rule =
                PairRule { between: table.between.clone().map(|(name, _)| name), ..PairRule::default() };
            for (name, span) in &table.between {
                if mixture.position(name).is_none() {
                    let known = mixture.components.iter().map(|component| component.name.as_str());
                    let help = if mixture.is_empty() {
                        "add [[material]] with this name".to_string()
                    } else {
                        meant(name, known)
                    };
                    let message = format!("{}.between names {name:?}, which is not a material", table.place);
                    self.error(span.clone(), message).help = Some(help);
                }
            }
            let [a, b] = &rule.between;
            if mixture.rule(a, b).is_some() {
                let message = format!("{} sets the pair of {a} and {b} a second time", table.place);
                self.error(table.between[0].1.clone(), message).help = Some("keep one of the two".into());
            }
            for (field, value, span) in &table.values {
                if let Some(message) = means_nothing(&case.contact, &table.place, field) {
                    self.error(span.clone(), message);
                }
                put_into_pair(case, &mut rule, field, value.clone());
            }
            mixture.pairs.push(rule);
        }
        mixture.sort();
        if self.errors.len() == before
            && let Err(error) = mixture.check(&case.contact)
        {
            let span = materials.first().map_or(0..0, |table| table.span.clone());
            self.error(span, error.to_string());
        }
        mixture
    }

    /// The shares of the materials: those given, the rest for the one without, or equal ones where none is given.
    fn shares(&mut self, materials: &[MaterialTable]) -> Vec<f64> {
        let given: f64 = materials.iter().filter_map(|table| Some(table.share.as_ref()?.0)).sum();
        let without: Vec<&MaterialTable> = materials.iter().filter(|table| table.share.is_none()).collect();
        let rest = 1.0 - given;
        if without.len() == materials.len() {
            return vec![1.0 / materials.len().max(1) as f64; materials.len()];
        }
        let last =
            materials.iter().rev().find_map(|table| table.share.as_ref().map(|(_, span)| span.clone()));
        match without.as_slice() {
            [] if rest.abs() > 1e-9 => {
                let message = format!("the shares of the materials sum to {}", format_number(given));
                self.error(last.unwrap_or(0..0), message).help =
                    Some("they must sum to 1; leave one out, and it gets the rest".into());
            }
            [one] if rest < SMALLEST_SHARE => {
                let message = format!(
                    "{} has no share, and nothing is left for it: the others sum to {}",
                    one.place,
                    format_number(given)
                );
                self.error(one.span.clone(), message).help = Some("lower the shares of the others".into());
            }
            [_, second, ..] => {
                let message = format!("{} has no share, and neither has another material", second.place);
                self.error(second.span.clone(), message).help =
                    Some("give all shares but one, or none for equal shares".into());
            }
            _ => {}
        }
        materials.iter().map(|table| table.share.as_ref().map_or(rest, |(share, _)| *share)).collect()
    }
}

/// Two names with their places.
fn names(node: &Node<'_>) -> Option<[(String, Range<usize>); 2]> {
    let DeValue::Array(items) = node.get_ref() else { return None };
    let name = |item: &Node<'_>| match item.get_ref() {
        DeValue::String(name) => Some((name.to_string(), item.span())),
        _ => None,
    };
    let found: Vec<_> = items.iter().map(name).collect::<Option<_>>()?;
    found.try_into().ok()
}
