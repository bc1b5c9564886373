//! The tests that are asked of a family: one, or several by lists of values and by the rows of a table.

use std::path::Path;

use granum_core::names::nearest;
use granum_core::quantity::{Dimension, parse_quantity};
use granum_io::case::{SetKey, ValueShape, field, values_in};
use granum_io::shell::ShowPath;
use granum_io::{Case, Error, read_table_with_words};
use granum_learn::family::FamilyDefinition;

use super::known_numbers::KnownNumbers;
use crate::context::Context;
use crate::failure::Failure;

/// Most tests that are asked at once.
const MOST_TESTS: usize = 1000;

/// A number that a flag, or a column of a table, gives: the flag, the key, what it is.
pub type Property = (&'static str, &'static str, Dimension);

/// A test that is asked for.
#[derive(Clone, Debug, Default)]
pub struct Asked {
    pub known: KnownNumbers,
    /// Flag and value of what differs from test to test.
    pub varied: Vec<(&'static str, f64)>,
}

impl Asked {
    /// What makes it differ from the others: `friction 0.3, void ratio 0.7`.
    pub fn label(&self) -> String {
        let each = self.varied.iter().map(|(flag, value)| {
            format!("{} {}", plain_name(flag).replace('_', " "), crate::numbers::rounded(*value, 4))
        });
        each.collect::<Vec<_>>().join(", ")
    }
}

/// `--void-ratio` as `void_ratio`.
pub fn plain_name(flag: &str) -> String {
    flag.trim_start_matches('-').replace('-', "_")
}

/// The values that a flag gives, one or several between commas.
pub fn values_of_flag((flag, key, dimension): Property, text: &str) -> Result<Vec<f64>, Failure> {
    let texts =
        values_in(text, ValueShape::Number).map_err(|why| Failure::new(format!("{flag} {text:?} {why}")))?;
    texts.iter().map(|text| number(flag, key, dimension, text)).collect()
}

/// A number with the unit of its dimension; one without a unit that is in doubt is asked about.
fn number(name: &str, key: &str, dimension: Dimension, text: &str) -> Result<f64, Failure> {
    let value =
        parse_quantity(text, dimension).map_err(|why| Failure::new(format!("{name} {text:?}: {why}")))?;
    if value < 0.0 {
        return Err(Failure::new(format!("{name} {text:?}: it cannot be negative")));
    }
    // The bounds and the questions about units are those of a case.
    if field(key).is_some() {
        let before = Case::default();
        let mut case = before.clone();
        let asked = case
            .set(key, text)
            .and_then(|()| case.check_bare_numbers(&before, &[SetKey { flag: name, path: key, text }]));
        asked.map_err(|error| match error {
            Error::Value { message, .. } => {
                let meant = probably_meant(key, text).filter(|_| !message.contains("was meant"));
                Failure::new(format!("{name} {text:?} {message}{}", meant.unwrap_or_default()))
            }
            other => other.into(),
        })?;
    }
    Ok(value)
}

/// What was probably meant by a number without a unit that no case accepts, in the unit in which such a property is usually given.
fn probably_meant(key: &str, text: &str) -> Option<String> {
    text.trim().parse::<f64>().ok()?;
    let unit = match key {
        "grains.material.youngs_modulus" => "GPa",
        "preparation.mean_stress" => "kPa",
        "grains.diameter" => "um",
        "grains.material.interface_energy" => "mJ/m2",
        _ => return None,
    };
    let with_unit = format!("{} {unit}", text.trim());
    let accepted = Case::default().set(key, &with_unit).is_ok();
    accepted.then(|| format!("; probably {with_unit} was meant: write \"{with_unit}\""))
}

/// Refuses a property that the family does not have, which would be without any effect.
pub fn check_used(
    family: &FamilyDefinition,
    name: &str,
    key: &str,
    properties: &[Property],
) -> Result<(), Failure> {
    let is_used = |key: &str| family.inputs.iter().any(|input| input.key == key || input.over.contains(&key));
    if is_used(key) {
        return Ok(());
    }
    let used: Vec<&str> =
        properties.iter().filter(|(_, key, _)| is_used(key)).map(|(flag, ..)| *flag).collect();
    Err(Failure::new(format!(
        "{name}: the tests of the family {} do not depend on it, so that it would be without effect; they have {}",
        family.name,
        used.join(", ")
    )))
}

/// The tests of all combinations of the values, which are given before those of a case.
pub fn combinations(base: &KnownNumbers, values: &[(Property, Vec<f64>)]) -> Result<Vec<Asked>, Failure> {
    let count = values.iter().try_fold(1usize, |count, (_, values)| count.checked_mul(values.len()));
    refuse_many(count)?;
    let mut all = vec![Asked { known: base.clone(), varied: Vec::new() }];
    for ((flag, key, _), values) in values {
        let with = |asked: &Asked| -> Vec<Asked> {
            let one = |value: &f64| {
                let mut asked = asked.clone();
                asked.known.set(key, *value);
                if values.len() > 1 {
                    asked.varied.push((*flag, *value));
                }
                asked
            };
            values.iter().map(one).collect()
        };
        all = all.iter().flat_map(with).collect();
    }
    Ok(all)
}

fn refuse_many(count: Option<usize>) -> Result<(), Failure> {
    if count.is_some_and(|count| count <= MOST_TESTS) {
        return Ok(());
    }
    let count = count.map_or("too many".to_string(), |count| count.to_string());
    Err(Failure::new(format!("{count} tests are asked for; at most {MOST_TESTS} are answered at once")))
}

/// The tests of the rows of a table, whose columns are named as flags without dashes or as keys of a case, with their units in brackets. A cell
/// without a value is not known.
pub fn of_table(
    context: &Context,
    path: &Path,
    family: &FamilyDefinition,
    properties: &[Property],
    asked: &[Asked],
) -> Result<Vec<Asked>, Failure> {
    let table = read_table_with_words(path, None)?;
    refuse_many(asked.len().checked_mul(table.rows()))?;
    let named = |message: String| Failure::new(format!("{}: {message}", path.shown()));
    let mut columns: Vec<(Property, String, usize)> = Vec::new();
    let mut unused: Vec<String> = Vec::new();
    for (place, column) in table.columns().iter().enumerate() {
        let (name, unit) = name_and_unit(&column.name, &column.unit);
        let is_it = |(flag, key, _): &&Property| name.replace('-', "_") == plain_name(flag) || name == *key;
        let Some(property) = properties.iter().find(is_it) else {
            let names: Vec<String> = properties.iter().map(|(flag, ..)| plain_name(flag)).collect();
            let near = nearest(&name, names.iter().map(String::as_str));
            if let Some(near) = near {
                return Err(named(format!("column {name}: there is no such property; did you mean {near}?")));
            }
            unused.push(name);
            continue;
        };
        check_used(family, &format!("column {name}"), property.1, properties)
            .map_err(|error| named(error.message()))?;
        if columns.iter().any(|(other, ..)| other.1 == property.1) {
            return Err(named(format!("column {name}: this property has two columns")));
        }
        if let Some(asked) =
            asked.iter().find(|asked| asked.varied.iter().any(|(flag, _)| *flag == property.0))
        {
            return Err(named(format!("column {name}: {} gives it as well ({})", property.0, asked.label())));
        }
        columns.push((*property, unit, place));
    }
    if columns.is_empty() {
        let names: Vec<String> = properties.iter().map(|(flag, ..)| plain_name(flag)).collect();
        return Err(named(format!("it has no column of a property; they are named {}", names.join(", "))));
    }
    if table.rows() == 0 {
        return Err(named("it has no rows".into()));
    }
    if !unused.is_empty() {
        context.note(&format!(
            "{}: columns that are no properties are not used: {}",
            path.shown(),
            unused.join(", ")
        ));
    }
    let mut all = Vec::new();
    for row in 0..table.rows() {
        for asked in asked {
            let mut asked = asked.clone();
            for ((flag, key, dimension), unit, place) in &columns {
                let text = table.columns()[*place].text(row);
                let text = text.trim();
                if text.is_empty() || text.eq_ignore_ascii_case("nan") {
                    continue;
                }
                let is_bare = text.parse::<f64>().is_ok();
                let with_unit =
                    if is_bare && !unit.is_empty() { format!("{text} {unit}") } else { text.into() };
                let name = format!("row {}: {}", row + 1, plain_name(flag));
                let value =
                    number(&name, key, *dimension, &with_unit).map_err(|error| named(error.message()))?;
                asked.known.set(key, value);
                asked.varied.push((*flag, value));
            }
            all.push(asked);
        }
    }
    Ok(all)
}

/// The name and the unit of a column: `pressure (kPa)` or `pressure [kPa]`.
fn name_and_unit(name: &str, unit: &str) -> (String, String) {
    for (open, close) in [('(', ')'), ('[', ']')] {
        if let Some((name, inside)) = name.trim().strip_suffix(close).and_then(|rest| rest.rsplit_once(open))
        {
            return (name.trim().to_string(), inside.trim().to_string());
        }
    }
    (name.trim().to_string(), unit.trim().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRICTION: Property = ("--friction", "grains.material.friction", Dimension::NUMBER);
    const MODULUS: Property = ("--youngs-modulus", "grains.material.youngs_modulus", Dimension::STRESS);

    #[test]
    fn lists_of_values_are_combined() {
        let values = |property: Property, text: &str| {
            values_of_flag(property, text).unwrap_or_else(|error| panic!("{}", error.message()))
        };
        let all_of = |given: &[(Property, Vec<f64>)]| {
            combinations(&KnownNumbers::default(), given)
                .unwrap_or_else(|error| panic!("{}", error.message()))
        };
        let friction = values(FRICTION, "0.3,0.4,0.5");
        let modulus = values(MODULUS, "2 GPa, 5 GPa");
        let all = all_of(&[(FRICTION, friction), (MODULUS, modulus)]);
        assert_eq!(all.len(), 6);
        assert_eq!(all[1].label(), "friction 0.3, youngs modulus 5e9");
        assert_eq!(all[4].known.get("grains.material.friction"), Some(0.5));
        // One value is no difference.
        let one = all_of(&[(FRICTION, vec![0.3])]);
        assert_eq!((one.len(), one[0].label()), (1, String::new()));
        let many: Vec<f64> = (0..40).map(f64::from).collect();
        let refusal = combinations(&KnownNumbers::default(), &[(FRICTION, many.clone()), (MODULUS, many)]);
        assert!(refusal.unwrap_err().message().contains("1600 tests are asked for"));
    }

    #[test]
    fn numbers_in_doubt_are_asked_about() {
        let told = |property: Property, text: &str| values_of_flag(property, text).unwrap_err().message();
        assert!(told(MODULUS, "70").contains("probably 70 GPa was meant"), "{}", told(MODULUS, "70"));
        assert!(told(FRICTION, "0,3").contains("decimal comma"), "{}", told(FRICTION, "0,3"));
        assert!(told(FRICTION, "-0.3").contains("cannot be negative"));
        assert_eq!(name_and_unit("pressure (kPa)", ""), ("pressure".into(), "kPa".into()));
        assert_eq!(name_and_unit("pressure [kPa]", ""), ("pressure".into(), "kPa".into()));
        assert_eq!(name_and_unit("friction", ""), ("friction".into(), String::new()));
    }
}
