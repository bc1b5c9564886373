//! What a data set has, for readers: which names can be inputs and outputs of surrogates.

use granum_core::quantity::format_number;
use granum_sensors::Sensors;

use super::category::Category;
use super::named_columns::Dataset;

/// A column or a group of columns that a data set has.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct CatalogueEntry {
    /// The name to use.
    pub name: String,
    /// SI unit; empty for pure numbers and words.
    pub unit: String,
    /// What it is, in a few words; for numbers of the case the values that the runs have.
    pub meaning: String,
}

/// A kind of columns with its entries.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct CatalogueSection {
    /// What these columns are.
    pub title: &'static str,
    /// The columns.
    pub entries: Vec<CatalogueEntry>,
}

impl Dataset {
    /// The values of a number of the case over the runs: "0.3 in all runs" or "0.2 to 0.5".
    fn range(&self, name: &str) -> String {
        let values = || self.runs().iter().filter_map(|run| run.parameter(name));
        let [low, high] =
            [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)];
        match low == high {
            true => format!("{} in all runs", format_number(low)),
            false => format!("{} to {}", format_number(low), format_number(high)),
        }
    }

    /// The columns that all runs have, by kind: measured in each state, histograms, the sample, numbers and words of the case. The meaning
    /// of measured columns is that of the sensors.
    pub fn catalogue(&self, sensors: &Sensors) -> Vec<CatalogueSection> {
        let Some(first) = self.runs().first() else { return Vec::new() };
        let meaning = |name: &str| {
            let known = sensors.columns().find(|column| column.name == name);
            known.map_or("", |column| column.description).to_string()
        };
        let is_bin = |name: &str| first.groups().iter().any(|group| group.columns().any(|own| own == name));
        let (mut states, mut sample, mut numbers) = (Vec::new(), Vec::new(), Vec::new());
        for variable in self.variables() {
            let entry = |meaning| CatalogueEntry {
                name: variable.name.clone(),
                unit: variable.unit.clone(),
                meaning,
            };
            match variable.name.strip_prefix("sample.") {
                Some(own) => sample.push(entry(meaning(own))),
                None if !first.table().has(&variable.name) => numbers.push(entry(self.range(&variable.name))),
                None if !is_bin(&variable.name) => states.push(entry(meaning(&variable.name))),
                None => {}
            }
        }
        let everywhere = |name: &str| self.runs().iter().all(|run| run.group(name).is_some());
        let groups = first.groups().iter().filter(|group| everywhere(&group.name));
        let histograms = groups.map(|group| {
            let meaning = match self.check_bins(group) {
                Ok(()) => {
                    let ends =
                        [group.columns().next(), group.columns().last()].map(Option::unwrap_or_default);
                    let (binned, bins) = (&group.binned, group.centres.len());
                    format!("density of {binned} in {bins} bins, {} to {}", ends[0], ends[1])
                }
                Err(_) => format!("density of {}, in other bins in some of the runs", group.binned),
            };
            CatalogueEntry { name: group.name.clone(), unit: String::new(), meaning }
        });
        let words = self.categories().into_iter().map(|category: Category| {
            let meaning = format!("a word, here {}", category.list());
            CatalogueEntry { name: category.name, unit: String::new(), meaning }
        });
        let section = |title, entries: Vec<CatalogueEntry>| CatalogueSection { title, entries };
        let all = [
            section("measured in each state", states),
            section(
                "histograms of each state: the name stands for all bins, each bin has a name of its own",
                histograms.collect(),
            ),
            section("measured on the sample, before it was strained", sample),
            section("numbers of the case", numbers),
            section("words of the case, only as inputs", words.collect()),
        ];
        all.into_iter().filter(|section| !section.entries.is_empty()).collect()
    }
}
