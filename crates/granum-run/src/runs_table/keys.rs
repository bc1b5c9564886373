//! The keys by which the cases of runs differ, with their values.

use std::collections::BTreeMap;

use granum_core::quantity::format_number;
use granum_io::Case;
use granum_io::case::{Fields, ParameterValue};

use super::entry::RunEntry;
use crate::queue::short_keys;

/// Most keys of a legend; with more the names of the runs are shorter.
const MOST_IN_LEGEND: usize = 3;

/// The value of a key of a case.
#[derive(Clone, Debug, PartialEq)]
pub enum KeyValue {
    /// A number in the SI unit of the key.
    Number(f64),
    /// A word, or anything else as text.
    Word(String),
    /// The case does not have the key.
    Absent,
}

/// A key that does not have the same value in all runs.
#[derive(Clone, Debug, PartialEq)]
pub struct DifferingKey {
    /// The key, e.g. `grains.material.friction` or `stage.1.lateral_stress`.
    pub key: String,
    /// SI unit of its numbers; empty for pure numbers and words.
    pub unit: String,
    /// Its value in every run.
    pub values: Vec<KeyValue>,
}

/// The keys by which the cases of runs differ, in the order of the case file, stages and materials included.
pub fn differing_keys(runs: &[RunEntry]) -> Vec<DifferingKey> {
    let cases: Vec<BTreeMap<String, (KeyValue, String)>> =
        runs.iter().map(|run| of_case(&run.case)).collect();
    let mut keys: Vec<String> = Fields::standard().iter().map(|field| field.path()).collect();
    for key in cases.iter().flat_map(BTreeMap::keys) {
        if !keys.contains(key) {
            keys.push(key.clone());
        }
    }
    let differing = |key: String| {
        let found = |case: &BTreeMap<String, (KeyValue, String)>| {
            case.get(&key).map_or(KeyValue::Absent, |(value, _)| value.clone())
        };
        let values: Vec<KeyValue> = cases.iter().map(found).collect();
        let unit =
            cases.iter().find_map(|case| case.get(&key)).map_or_else(String::new, |(_, unit)| unit.clone());
        let differs = values.windows(2).any(|pair| pair[0] != pair[1]);
        differs.then_some(DifferingKey { key, unit, values })
    };
    keys.into_iter().filter_map(differing).collect()
}

/// A short text for each run by which a reader tells them apart: the keys that differ with their values, `friction 0.2,
/// lateral stress 50 kPa`; the names of the runs where no key or many keys differ, or where two runs would have the same text.
pub fn legend(runs: &[RunEntry]) -> Vec<String> {
    let names = || runs.iter().map(|run| run.name.clone()).collect();
    let differing = differing_keys(runs);
    if differing.is_empty() || differing.len() > MOST_IN_LEGEND {
        return names();
    }
    let keys = short_keys(&differing.iter().map(|found| found.key.as_str()).collect::<Vec<_>>());
    let text = |run: usize| {
        let part = |(key, found): (&String, &DifferingKey)| {
            format!("{} {}", key.replace('_', " "), shown(&found.values[run], &found.unit))
        };
        keys.iter().zip(&differing).map(part).collect::<Vec<_>>().join(", ")
    };
    let texts: Vec<String> = (0..runs.len()).map(text).collect();
    let alike = (0..texts.len()).any(|k| texts[..k].contains(&texts[k]));
    if alike { names() } else { texts }
}

/// Runs that are drawn alike, since they are repetitions of one test.
#[derive(Clone, Debug, PartialEq)]
pub struct RunGroup {
    /// A short text that tells the group from the others.
    pub label: String,
    /// The numbers of its runs.
    pub runs: Vec<usize>,
}

/// The numbers of runs that differ in their seeds alone, together.
pub fn repetitions(runs: &[RunEntry]) -> Vec<Vec<usize>> {
    let alike = |a: &RunEntry, b: &RunEntry| {
        let mut other = b.case.clone();
        other.preparation.seed = a.case.preparation.seed;
        a.case == other
    };
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (k, run) in runs.iter().enumerate() {
        match groups.iter_mut().find(|group| alike(&runs[group[0]], run)) {
            Some(group) => group.push(k),
            None => groups.push(vec![k]),
        }
    }
    groups
}

/// Runs by what they have in common: runs that differ in their seed alone are one group, labelled by the keys in which the groups
/// differ and the number of its runs. Where no other key differs, every run is a group of its own.
pub fn groups(runs: &[RunEntry]) -> Vec<RunGroup> {
    let mut groups = repetitions(runs);
    if groups.len() == 1 {
        groups = (0..runs.len()).map(|k| vec![k]).collect();
    }
    // The seed of a group is that of its first run, and is no difference between groups with several.
    let several = groups.iter().any(|group| group.len() > 1);
    let first: Vec<RunEntry> = groups
        .iter()
        .map(|group| {
            let mut entry = runs[group[0]].clone();
            if several {
                entry.case.preparation.seed = 1;
            }
            entry
        })
        .collect();
    let label = |(text, group): (String, &Vec<usize>)| match group.len() {
        1 => text,
        count => format!("{text} ({count} seeds)"),
    };
    let labels: Vec<String> = legend(&first).into_iter().zip(&groups).map(label).collect();
    labels.into_iter().zip(groups).map(|(label, runs)| RunGroup { label, runs }).collect()
}

/// A value for reading, with a prefix of its unit: `50 kPa`.
fn shown(value: &KeyValue, unit: &str) -> String {
    match value {
        KeyValue::Absent => "not given".into(),
        KeyValue::Word(word) => word.clone(),
        KeyValue::Number(number) => {
            let prefixes = [(1e9, "G"), (1e6, "M"), (1e3, "k")];
            let size = number.abs() * (1.0 + 1e-9);
            let prefix = prefixes.into_iter().find(|(factor, _)| unit == "Pa" && size >= *factor);
            let (factor, prefix) = prefix.unwrap_or((1.0, ""));
            format!("{} {prefix}{unit}", format_number(number / factor)).trim_end().to_string()
        }
    }
}

/// The values of all keys of a case that take part in its result.
fn of_case(case: &Case) -> BTreeMap<String, (KeyValue, String)> {
    let value = |value: ParameterValue| match value {
        ParameterValue::Number(number) => KeyValue::Number(number),
        ParameterValue::Word(word) => KeyValue::Word(word),
        ParameterValue::List(values) => {
            KeyValue::Word(values.into_iter().map(format_number).collect::<Vec<_>>().join(", "))
        }
    };
    case.parameters().into_iter().map(|found| (found.key, (value(found.value), found.unit))).collect()
}
