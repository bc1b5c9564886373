//! What the parts of a plan must have in common.

use std::collections::{BTreeMap, BTreeSet};

use granum_core::names::suggestion;
use granum_io::Case;
use granum_run::Engines;
use granum_run::engine::CHECKS;

use super::definition::{DesignKind, Plan, PlanRow, PlanVariable, SampleSeeds, Spanned, VariableKind};
use super::design::MOST_AXES;
use super::reader::Reader;

impl Reader {
    /// Checks that names are unique and that expressions and constraints use names that exist, and not each other in a circle. The names are
    /// those of all variables, also of one in which there is another mistake.
    pub fn check_names(&mut self, plan: &Plan, reference: &Case, names: &[String]) {
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        for (k, variable) in plan.variables.iter().enumerate() {
            if plan.variables[..k].iter().any(|earlier| earlier.name == variable.name) {
                let message = format!("two variables have the name {}", variable.name);
                self.error(variable.span.clone(), message, "give one of them another name");
            }
            let own: Vec<&Spanned<String>> = variable.keys.iter().collect();
            let earlier = || plan.variables[..k].iter().flat_map(|other| &other.keys);
            for key in own {
                if earlier().any(|other| other.value == key.value) {
                    self.error(key.span.clone(), format!("{} is set by two variables", key.value), "");
                }
                if plan.fixed.iter().any(|fixed| fixed.key == key.value) {
                    self.error(
                        key.span.clone(),
                        format!("{} is set by [set] and by a variable", key.value),
                        "",
                    );
                }
            }
        }
        let parameters = reference.parameters();
        let is_number =
            |name: &str| parameters.iter().any(|known| known.key == name && known.number().is_some());
        let mut unknown = Vec::new();
        for variable in &plan.variables {
            let VariableKind::Expression(expression) = &variable.kind else { continue };
            for name in expression.value.names().filter(|name| !names.contains(name) && !is_number(name)) {
                unknown.push((expression.span.clone(), name.to_string()));
            }
        }
        for constraint in &plan.constraints {
            for name in constraint.value.names().filter(|name| !names.contains(name) && !is_number(name)) {
                unknown.push((constraint.span.clone(), name.to_string()));
            }
        }
        for (span, name) in unknown {
            let help = suggestion(&name, names.iter().copied());
            self.error(span, format!("{name} is neither a variable nor a number of the base case"), &help);
        }
        if let Some(variable) = in_a_circle(&plan.variables) {
            let message = format!("the expression of {} depends on itself", variable.name);
            self.error(variable.span.clone(), message, "");
        }
        for condition in &plan.accept {
            if condition.value.names().count() == 0 {
                let help = "write e.g. accept = [\"largest_overlap < 0.05\"]";
                self.error(condition.span.clone(), "accept names no check", help);
            }
            // Another engine may make other checks.
            let is_standard = plan.engine.is_empty() || Engines::standard().named(&plan.engine).is_ok();
            let unknown = condition.value.names().find(|name| is_standard && !CHECKS.contains(name));
            if let Some(name) = unknown {
                let help = suggestion(name, CHECKS.into_iter());
                self.error(condition.span.clone(), format!("accept: {name} is not a quality check"), &help);
            }
        }
    }

    /// Checks that the design and the variables fit together.
    pub(super) fn check_design(&mut self, plan: &Plan) {
        let seeds =
            |variable: &PlanVariable| variable.keys.iter().any(|key| key.value == granum_io::case::SEED);
        let has_seeds = plan.design.replicates > 1 || plan.design.sample_seeds == SampleSeeds::Different;
        if let Some(variable) = plan.variables.iter().find(|variable| seeds(variable) && has_seeds) {
            let message = "preparation.seed is set by a variable and by the design";
            self.error(
                variable.span.clone(),
                message,
                "leave out the variable, or replicates and sample_seeds",
            );
        }
        match &plan.design.kind {
            DesignKind::Rows(rows) => self.check_rows(plan, rows),
            kind => {
                for variable in &plan.variables {
                    if variable.kind == VariableKind::Given {
                        let message = format!("the variable {} has no values", variable.name);
                        self.error(
                            variable.span.clone(),
                            message,
                            "give it from and to, values, or expression",
                        );
                    }
                    let needs_levels = *kind == DesignKind::FullFactorial
                        && matches!(variable.kind, VariableKind::Range { levels: None, .. });
                    if needs_levels {
                        let message =
                            format!("the variable {} needs levels in a full factorial design", variable.name);
                        self.error(variable.span.clone(), message, "give it levels = 3, or values = [...]");
                    }
                }
                if plan.variables.iter().filter(|variable| variable.kind.is_free()).count() > MOST_AXES {
                    self.error(plan.design.span.clone(), "the plan has more than 256 variables", "");
                }
            }
        }
    }

    pub(super) fn check_rows(&mut self, plan: &Plan, rows: &[PlanRow]) {
        for row in rows {
            let known = |name: &str| {
                plan.variables.iter().any(|variable| variable.name == name && variable.kind.is_free())
            };
            let unknown = row
                .cells
                .iter()
                .find(|(name, _)| !known(name))
                .map(|(name, _)| format!("{name} is no variable of the plan that a row can give"));
            let missing = plan.variables.iter().filter(|variable| variable.kind.is_free());
            let missing = missing
                .filter(|variable| !row.cells.iter().any(|(name, _)| *name == variable.name))
                .map(|variable| format!("the row has no value of {}", variable.name))
                .next();
            if let Some(message) = unknown.or(missing) {
                let names = plan.variables.iter().filter(|variable| variable.kind.is_free());
                let names: Vec<&str> = names.map(|variable| variable.name.as_str()).collect();
                let help = format!("a row has {}", names.join(", "));
                self.errors.push(row.place.error(&self.source, message).with_help(help));
                // The other rows of a CSV file have the same names.
                return;
            }
        }
    }
}

/// The first variable whose expression depends on itself, directly or through others.
fn in_a_circle(variables: &[PlanVariable]) -> Option<&PlanVariable> {
    let by_name: BTreeMap<&str, &PlanVariable> =
        variables.iter().map(|variable| (variable.name.as_str(), variable)).collect();
    let reaches = |start: &PlanVariable| {
        let (mut open, mut seen) = (vec![start], BTreeSet::new());
        while let Some(variable) = open.pop() {
            let VariableKind::Expression(expression) = &variable.kind else { continue };
            for name in expression.value.names() {
                let Some(next) = by_name.get(name) else { continue };
                if next.name == start.name {
                    return true;
                }
                if seen.insert(name) {
                    open.push(next);
                }
            }
        }
        false
    };
    variables.iter().find(|variable| reaches(variable))
}
