//! What a named path that a plan sets takes over from the test of the base case, and what it replaces.

use std::collections::BTreeSet;

use super::definition::{PATH, Plan, PlanVariable, VariableKind};
use super::runs::{FIRST_STAGE, PlannedRuns, Refusal};

/// Keys with their values as text.
type Settings = [(String, String)];

/// The parameters of the first stage that settings give.
fn parameters_of_stage(settings: &Settings) -> Vec<&str> {
    settings.iter().filter_map(|(key, _)| key.strip_prefix(FIRST_STAGE)).collect()
}

fn path_in(settings: &Settings) -> Option<&str> {
    settings.iter().find(|(key, _)| key == PATH).map(|(_, name)| name.as_str())
}

/// `axial_strain = 0.3, states = 100`.
fn shown(values: &Settings) -> String {
    values.iter().map(|(key, value)| format!("{key} = {value}")).collect::<Vec<_>>().join(", ")
}

impl PlanVariable {
    /// True if it can set the named path of the test.
    fn sets_path(&self) -> bool {
        let by_choice = match &self.kind {
            VariableKind::Choice(choices) => {
                choices.iter().any(|choice| choice.set.iter().any(|(key, _)| key == PATH))
            }
            _ => false,
        };
        by_choice || self.keys.iter().any(|key| key.value == PATH)
    }
}

impl Plan {
    /// True if the plan says that a named path which it sets has its own parameters only.
    fn has_new_stage(&self) -> bool {
        self.variables.iter().any(|variable| variable.new_stage)
    }

    /// The parameters of the stage of the base case that a run with another named path keeps, as further settings.
    ///
    /// # Errors
    /// If the base case has more than one stage that is a named path: the others would be lost.
    pub(super) fn carried_over(&self, settings: &Settings) -> Result<Vec<(String, String)>, Refusal> {
        let Some(name) = path_in(settings).filter(|_| !self.has_new_stage()) else { return Ok(Vec::new()) };
        // A path that does not exist is told when the case of the run is made.
        let Some(change) = self.case.path_exchange(name, &parameters_of_stage(settings)) else {
            return Ok(Vec::new());
        };
        if let Some(lost) = change.lost {
            let variable = self.variables.iter().find(|variable| variable.sets_path());
            let span = variable.map(|variable| variable.span.clone());
            let span = span.or_else(|| {
                self.fixed.iter().find(|fixed| fixed.key == PATH).map(|fixed| fixed.span.clone())
            });
            let message = format!(
                "{PATH} = {name} would replace the whole test of the base case, {lost}, of which a path can take over nothing: \
                 give the plan a base case whose test is one named path, or say stage = \"new\" beside {PATH}, with all \
                 parameters of the stage"
            );
            return Err(Refusal::Mistake(span.unwrap_or(0..0), message));
        }
        Ok(change.carried.into_iter().map(|(key, text)| (format!("{FIRST_STAGE}{key}"), text)).collect())
    }

    /// A sentence for each named path that runs of the plan have in place of the test of the base case: what of it remains, and what does
    /// not.
    pub fn replaced_tests(&self, planned: &PlannedRuns) -> Vec<String> {
        let mut sentences = BTreeSet::new();
        let keys_of_plan: BTreeSet<&str> = self
            .variables
            .iter()
            .flat_map(|variable| &variable.keys)
            .map(|key| key.value.as_str())
            .chain(self.fixed.iter().map(|fixed| fixed.key.as_str()))
            .collect();
        for run in &planned.runs {
            let Some(name) = path_in(&run.settings) else { continue };
            // The run has what is carried over among its settings, so that it is asked about without them.
            let Some(all) = self.case.path_exchange(name, &[]) else { continue };
            let now = parameters_of_stage(&run.settings);
            let of_run =
                |key: &str| run.settings.iter().find(|(set, _)| set.strip_prefix(FIRST_STAGE) == Some(key));
            let (mut carried, mut lost) = (Vec::new(), all.replaced.clone());
            // What the plan gives itself is told with its variables.
            for (key, text) in all
                .carried
                .iter()
                .filter(|(key, _)| !keys_of_plan.contains(format!("{FIRST_STAGE}{key}").as_str()))
            {
                match of_run(key) {
                    Some((_, now)) if now == text => carried.push((key.clone(), text.clone())),
                    // The plan gives it another value.
                    Some(_) => {}
                    None => lost.push((key.clone(), text.clone())),
                }
            }
            lost.retain(|(key, _)| !now.contains(&key.as_str()));
            let mut text = match (&all.lost, all.test == name) {
                (Some(lost), _) => format!("path = {name} replaces the test of the base case ({lost})"),
                (None, true) if lost.is_empty() => continue,
                (None, true) => format!("path = {name} begins the stage of the base case anew"),
                (None, false) => format!("path = {name} replaces {} of the base case", all.test),
            };
            if !carried.is_empty() {
                text += &format!("; {} of the base case stays", shown(&carried));
            }
            if !lost.is_empty() {
                text += &format!("; {} of the base case does not", shown(&lost));
            }
            sentences.insert(text);
        }
        sentences.into_iter().collect()
    }
}
