//! All combinations of values of several keys, and names for them.

use std::collections::BTreeSet;

use super::queue_error::QueueError;

/// Largest number of combinations.
pub const MOST_COMBINATIONS: usize = 10_000;
/// Longest name of a run.
const LONGEST_NAME: usize = 120;

/// A key with the values that it takes, as text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    /// The key, e.g. `grains.material.friction`.
    pub key: String,
    /// Its values.
    pub values: Vec<String>,
}

/// All combinations of values, each with a value for every setting; those of the last setting follow each other.
///
/// ```
/// use granum_run::queue::{Setting, combinations, names};
///
/// let settings = [
///     Setting { key: "grains.material.friction".into(), values: vec!["0.2".into(), "0.4".into()] },
///     Setting { key: "stage.1.lateral_stress".into(), values: vec!["50 kPa".into(), "100 kPa".into()] },
/// ];
/// assert_eq!(combinations(&settings)?[1], ["0.2", "100 kPa"]);
/// assert_eq!(names(&settings)?[1], "friction=0.2_lateral_stress=100kPa");
/// # Ok::<(), granum_run::queue::QueueError>(())
/// ```
///
/// # Errors
/// [`QueueError::TooMany`] for more than [`MOST_COMBINATIONS`].
pub fn combinations(settings: &[Setting]) -> Result<Vec<Vec<String>>, QueueError> {
    let count = settings.iter().fold(1usize, |count, setting| count.saturating_mul(setting.values.len()));
    if count > MOST_COMBINATIONS {
        return Err(QueueError::TooMany { count, most: MOST_COMBINATIONS });
    }
    let mut all = vec![Vec::new()];
    for setting in settings {
        let with_each = |before: Vec<String>| {
            setting.values.iter().map(move |value| [&before[..], std::slice::from_ref(value)].concat())
        };
        all = all.into_iter().flat_map(with_each).collect();
    }
    Ok(all)
}

/// A name for each combination, made of the keys that have several values and of these values, which can be the name of a
/// folder: `friction=0.2_lateral_stress=100kPa`.
///
/// # Errors
/// As [`combinations`].
pub fn names(settings: &[Setting]) -> Result<Vec<String>, QueueError> {
    let varied: Vec<usize> = (0..settings.len()).filter(|k| settings[*k].values.len() > 1).collect();
    let keys = short_keys(&varied.iter().map(|k| settings[*k].key.as_str()).collect::<Vec<_>>());
    let mut names: Vec<String> = Vec::new();
    let mut taken = BTreeSet::new();
    for (number, values) in combinations(settings)?.iter().enumerate() {
        let part = |(k, key): (&usize, &String)| format!("{key}={}", plain(&values[*k]));
        let name = varied.iter().zip(&keys).map(part).collect::<Vec<_>>().join("_");
        let is_usable = !name.is_empty() && name.len() <= LONGEST_NAME && taken.insert(name.clone());
        names.push(if is_usable { name } else { format!("run-{}", number + 1) });
    }
    Ok(names)
}

/// The last parts of keys, as many as are needed to tell them apart.
pub(crate) fn short_keys(keys: &[&str]) -> Vec<String> {
    let last = |key: &str, count: usize| {
        let parts: Vec<&str> = key.split('.').collect();
        parts[parts.len().saturating_sub(count)..].join(".")
    };
    let short = |key: &&str| {
        let most = key.split('.').count();
        let alone =
            |count: &usize| keys.iter().filter(|other| last(other, *count) == last(key, *count)).count() == 1;
        last(key, (1..most).find(alone).unwrap_or(most))
    };
    keys.iter().map(short).collect()
}

/// A value without what has a meaning in names of files: letters, digits, dots, signs and underscores stay.
fn plain(value: &str) -> String {
    let letters = value.chars().filter(|c| !c.is_whitespace());
    letters.map(|c| if c.is_alphanumeric() || "._+-".contains(c) { c } else { '-' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn setting(key: &str, values: &[&str]) -> Setting {
        Setting { key: key.into(), values: values.iter().map(|value| value.to_string()).collect() }
    }

    #[test]
    fn names_have_the_keys_that_differ() {
        let settings = [
            setting("preparation.friction", &["0.1", "0.2"]),
            setting("shear.deviator_strain", &["0.3"]),
            setting("grains.material.friction", &["0.3", "0.5"]),
        ];
        let names = names(&settings).unwrap();
        assert_eq!(names.len(), 4);
        assert_eq!(names[1], "preparation.friction=0.1_material.friction=0.5");
        assert_eq!(combinations(&settings).unwrap()[1], ["0.1", "0.3", "0.5"]);
    }

    #[test]
    fn a_name_is_that_of_a_folder_and_unique() {
        let long = "x".repeat(200);
        let names =
            names(&[setting("recording.strains", &["0.01, 0.1", "../a b/c", "..-ab-c", &long])]).unwrap();
        assert_eq!(names, ["strains=0.01-0.1", "strains=..-ab-c", "run-3", "run-4"]);
    }

    #[test]
    fn too_many_are_refused() {
        let values: Vec<String> = (0..200).map(|k| k.to_string()).collect();
        let one = Setting { key: "preparation.seed".into(), values };
        let error = combinations(&[one.clone(), Setting { key: "grains.count".into(), ..one }]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "the values have 40000 combinations; at most 10000 runs are possible at once"
        );
    }
}
