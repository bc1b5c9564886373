//! A set of bonds of a case: the values that its table gives, and what they come to.

use std::collections::BTreeMap;

use granum_core::quantity::{format_number, parse_quantity};
use granum_dem::bond::{BondAttachment, BondKind, BondPlaces, BondRadius, Bonding, StrengthScatter};
use granum_dem::contact::choice::registry::Laws;
use serde::{Deserialize, Serialize};

use super::keys::{KEYS, KeyKind, dimension, known, parameter};

/// The value of a key.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub(crate) enum BondValue {
    /// A number in SI units.
    Number(f64),
    /// A word.
    Word(String),
}

/// A table `[[bond]]`: the values that it gives, by key. The others have their defaults.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CaseBond {
    values: BTreeMap<String, BondValue>,
}

impl CaseBond {
    /// Gives a value to a key, as text.
    ///
    /// # Errors
    /// What is wrong with the value, as a continuation of "KEY = VALUE".
    pub(super) fn set(&mut self, key: &str, text: &str, laws: &Laws) -> Result<(), String> {
        let value = self.parse(key, text, laws)?;
        self.values.insert(key.to_string(), value);
        Ok(())
    }

    fn parse(&self, key: &str, text: &str, laws: &Laws) -> Result<BondValue, String> {
        let words = |words: &[[&str; 2]]| {
            words.iter().map(|[word, _]| format!("\"{word}\"")).collect::<Vec<_>>().join(" or ")
        };
        match known(key).map(|known| known.kind) {
            Some(KeyKind::Law) => match laws.bond_named(text) {
                Some(law) => Ok(BondValue::Word(law.name().into())),
                None => {
                    let names: Vec<String> =
                        laws.bonds().iter().map(|law| format!("\"{}\"", law.name())).collect();
                    Err(format!("must be {}", names.join(", ")))
                }
            },
            Some(KeyKind::Word(list)) => {
                let found = list.iter().find(|[word, _]| *word == text);
                found
                    .map(|[word, _]| BondValue::Word((*word).into()))
                    .ok_or_else(|| format!("must be {}", words(list)))
            }
            Some(KeyKind::Count(least)) => {
                let count: u64 =
                    text.parse().map_err(|_| format!("must be a whole number of at least {least}"))?;
                // Larger numbers are no numbers of a case file.
                let fits = count >= least && count < 1 << 53;
                if fits {
                    Ok(BondValue::Number(count as f64))
                } else {
                    Err(format!("must be a whole number of at least {least}"))
                }
            }
            Some(KeyKind::Number(dimension, bounds)) => number(text, dimension, bounds),
            None => {
                let law = self.law(laws);
                let Some(parameter) = parameter(law, key) else {
                    return Err(format!("has no effect with law = {:?}", law.name()));
                };
                number(text, dimension(parameter), parameter.bounds)
            }
        }
    }

    fn word(&self, key: &str) -> &str {
        match self.values.get(key) {
            Some(BondValue::Word(word)) => word,
            _ => known(key).and_then(|known| known.default).unwrap_or_default(),
        }
    }

    /// The number of a key of the list: the given one, or its default.
    fn number(&self, key: &str) -> Option<f64> {
        match self.values.get(key) {
            Some(BondValue::Number(number)) => Some(*number),
            _ => known(key).and_then(|known| known.default).and_then(|text| text.parse().ok()),
        }
    }

    /// The law.
    pub fn law(&self, laws: &Laws) -> BondKind {
        laws.bond_named(self.word("law")).unwrap_or(BondKind::PARALLEL)
    }

    /// Number of the stage before which the bonds are made, from 1.
    pub fn before_stage(&self) -> usize {
        self.number("before_stage").map_or(1, |number| number as usize)
    }

    /// True if a key has an effect, given the others.
    fn is_used(&self, key: &str) -> bool {
        let cement = self.values.contains_key("cement_content");
        match key {
            "radius" => !cement,
            "cement_density" => cement,
            "strength_deviation" => self.word("scatter") == "normal",
            "weibull_modulus" | "reference_volume" => self.word("scatter") == "weibull",
            "largest_gap" => self.word("places") == "between",
            "type" => self.word("places") == "file",
            "attachment" => self.values.contains_key(key),
            "seed" => {
                self.word("scatter") != "none" || self.number("left_out").is_some_and(|share| share > 0.0)
            }
            _ => true,
        }
    }

    /// A key that is given without effect, with the reason.
    pub(super) fn without_effect(&self, laws: &Laws) -> Option<(String, String)> {
        let law = self.law(laws);
        self.values.keys().find_map(|key| {
            let why = match key.as_str() {
                "radius" => "where cement_content is given".to_string(),
                "cement_density" => "without cement_content".to_string(),
                "strength_deviation" => "unless scatter = \"normal\"".to_string(),
                "weibull_modulus" | "reference_volume" => "unless scatter = \"weibull\"".to_string(),
                "largest_gap" => format!("with places = {:?}", self.word("places")),
                "type" => "unless places = \"file\"".to_string(),
                "seed" => "where nothing is drawn at random".to_string(),
                _ => format!("with law = {:?}", law.name()),
            };
            let used = if known(key).is_some() { self.is_used(key) } else { parameter(law, key).is_some() };
            (!used).then(|| (key.clone(), why))
        })
    }

    /// Every key that has an effect, with its SI unit and value: those that are not given have their defaults.
    pub(super) fn resolved(&self, laws: &Laws) -> Vec<(&'static str, String, BondValue)> {
        let mut all = Vec::new();
        for key in KEYS.iter().filter(|key| self.is_used(key.key)) {
            let value = match (&key.kind, self.values.get(key.key)) {
                (_, Some(value)) => Some(value.clone()),
                (KeyKind::Law | KeyKind::Word(_), None) => Some(BondValue::Word(self.word(key.key).into())),
                (_, None) => self.number(key.key).map(BondValue::Number),
            };
            let unit = match key.kind {
                KeyKind::Number(dimension, _) => dimension.si_unit(),
                _ => String::new(),
            };
            all.extend(value.map(|value| (key.key, unit, value)));
        }
        for parameter in self.law(laws).law().description().parameters {
            let value = match self.values.get(parameter.key) {
                Some(value) => value.clone(),
                None => BondValue::Number(parameter.default),
            };
            all.push((parameter.key, parameter.unit.symbol.to_string(), value));
        }
        all
    }

    /// What the table comes to.
    pub fn bonding(&self, laws: &Laws) -> Bonding {
        let law = self.law(laws);
        let given = |key: &str| self.number(key).unwrap_or_default();
        let parameters = law.law().description().parameters.iter().filter_map(|parameter| {
            match self.values.get(parameter.key)? {
                BondValue::Number(number) => Some((parameter.key.to_string(), *number)),
                BondValue::Word(_) => None,
            }
        });
        Bonding::default().with(|bonding| {
            bonding.law = law;
            bonding.parameters = parameters.collect();
            bonding.places = match self.word("places") {
                "inside" => BondPlaces::Inside,
                "file" => BondPlaces::Listed,
                _ => BondPlaces::Between,
            };
            bonding.kind = self.number("type").map(|kind| kind.min(f64::from(u32::MAX)) as u32);
            bonding.radius = match self.number("cement_content") {
                Some(content) => BondRadius::Cement { content, density: given("cement_density") },
                None => BondRadius::Share(given("radius")),
            };
            bonding.largest_gap = given("largest_gap");
            bonding.attachment = match self.word("attachment") {
                "middle" => BondAttachment::Middle,
                _ => BondAttachment::Contact,
            };
            bonding.damping = given("damping");
            bonding.scatter = match self.word("scatter") {
                "normal" => StrengthScatter::Normal(given("strength_deviation")),
                "weibull" => StrengthScatter::Weibull {
                    modulus: given("weibull_modulus"),
                    reference_volume: self.number("reference_volume"),
                },
                _ => StrengthScatter::None,
            };
            bonding.left_out = given("left_out");
            bonding.seed = given("seed") as u64;
        })
    }
}

/// A quantity between bounds; without bounds above, also `inf`.
fn number(
    text: &str,
    dimension: granum_core::quantity::Dimension,
    [low, high]: [f64; 2],
) -> Result<BondValue, String> {
    let value = match text.trim() {
        "inf" | "+inf" if high == f64::INFINITY => f64::INFINITY,
        text => parse_quantity(text, dimension)?,
    };
    if (low..=high).contains(&value) {
        return Ok(BondValue::Number(value));
    }
    let unit = dimension.si_unit();
    Err(format!("is out of bounds; it must be from {} to {} {unit}", format_number(low), format_number(high))
        .trim_end()
        .to_string())
}
