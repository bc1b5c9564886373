//! The relation of a run to the training runs of a study, which determines how scores on it are labelled.

use granum_io::case::Difference;
use granum_learn::runs::{RunRole, StudyRun, differences_but_seed};
use serde_json::{Value, json};

use super::records::Recorded;

/// The relation of a run to the training runs of a study.
pub struct Relation {
    /// True if networks were trained on the run; `None` if the study does not record its training runs.
    trained: Option<bool>,
    /// Keys whose value in this run occurs in no training run.
    differences: Vec<NewValue>,
}

/// A key with a value that occurs in no training run.
struct NewValue {
    key: String,
    value: String,
    trained: Vec<String>,
}

impl Relation {
    /// Compares a run with those that a study records.
    pub fn new(run: &Recorded, known: Option<&[StudyRun]>) -> Relation {
        let training: Vec<&StudyRun> =
            known.unwrap_or_default().iter().filter(|other| other.role == RunRole::Training).collect();
        if training.is_empty() {
            return Relation { trained: None, differences: Vec::new() };
        }
        let trained = training.iter().any(|other| other.is_same_test(&run.known));
        // The differences list values by the name of their run, so that this run needs a name that no training run has.
        let mut named: Vec<(&str, &StudyRun)> = training.iter().map(|other| ("training", *other)).collect();
        named.push(("this", &run.known));
        let differences =
            differences_but_seed(&named).into_iter().filter_map(NewValue::from_difference).collect();
        Relation { trained: Some(trained), differences }
    }

    /// True if networks are known to have been trained on it.
    pub fn is_training(&self) -> bool {
        self.trained == Some(true)
    }

    /// The label of scores on the run.
    pub fn kind(&self) -> &'static str {
        match (self.trained, self.differences.is_empty()) {
            (Some(true), _) => "scores on a training run",
            (Some(false), true) => "scores on an unseen run",
            (Some(false), false) => "scores on an unseen run of another case",
            (None, _) => "scores on a run; the study does not say whether it was a training run",
        }
    }

    /// A warning that the user needs in order to interpret the scores.
    pub fn warning(&self, name: &str) -> Option<String> {
        match self.trained {
            Some(true) => Some(format!(
                "{name}: the networks were trained on every second state of this run; its scores show how well they \
                 fit it, not how well they predict a run that they have not seen"
            )),
            Some(false) if !self.differences.is_empty() => {
                let keys: Vec<String> = self.differences.iter().map(NewValue::sentence).collect();
                Some(format!(
                    "{name}: the case of this run differs from that of the training runs: {}; its scores show how the \
                     networks predict outside their training",
                    keys.join("; ")
                ))
            }
            Some(false) => None,
            None => Some(format!(
                "{name}: the study was written by an earlier version, which did not record the training runs; train it \
                 again to know whether this is one of them"
            )),
        }
    }

    /// The keys that differ, with their value in this run and the values of the training runs.
    pub fn differences_json(&self) -> Value {
        let one = |d: &NewValue| json!({ "key": d.key, "value": d.value, "trained": d.trained });
        self.differences.iter().map(one).collect()
    }
}

impl NewValue {
    /// The difference, if the value of this run occurs in no training run.
    fn from_difference(difference: Difference) -> Option<NewValue> {
        let key = difference.key;
        let (own, trained): (Vec<_>, Vec<_>) =
            difference.values.into_iter().partition(|(_, names)| names.iter().all(|name| name == "this"));
        let value = own.into_iter().next()?.0;
        Some(NewValue { key, value, trained: trained.into_iter().map(|(value, _)| value).collect() })
    }

    fn sentence(&self) -> String {
        format!("{} is {}, trained at {}", self.key, self.value, self.trained.join(" and "))
    }
}
