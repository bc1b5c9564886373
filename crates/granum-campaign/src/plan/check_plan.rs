//! What the parts of a plan must have in common.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use granum_core::names::suggestion;
use granum_io::Case;
use granum_run::Engines;
use granum_run::engine::CHECKS;

use super::definition::{DesignKind, Plan, PlanRow, PlanVariable, SampleSeeds, VariableKind};
use super::dependence::in_a_circle;
use super::design::{DesignSize, MOST_AXES};
use super::reader::Reader;

/// Most unknown names that are told, each with the nearest one that exists.
const MOST_UNKNOWN: usize = 20;

impl Reader {
    /// Checks that names are unique and that expressions and constraints use names that exist, and not each other in a circle. The names are
    /// those of all variables, also of one in which there is another mistake.
    pub fn check_names(&mut self, plan: &Plan, reference: &Case, names: &[String]) {
        let names: BTreeSet<&str> = names.iter().map(String::as_str).collect();
        self.check_unique(plan);
        let parameters = reference.parameters();
        let numbers: BTreeSet<&str> = parameters
            .iter()
            .filter(|parameter| parameter.number().is_some())
            .map(|parameter| parameter.key.as_str())
            .collect();
        let is_unknown = |name: &&str| !names.contains(name) && !numbers.contains(name);
        let mut unknown: BTreeMap<&str, Range<usize>> = BTreeMap::new();
        for variable in &plan.variables {
            let VariableKind::Expression(expression) = &variable.kind else { continue };
            for name in expression.value.names().filter(is_unknown) {
                unknown.entry(name).or_insert_with(|| expression.span.clone());
            }
        }
        for constraint in &plan.constraints {
            for name in constraint.value.names().filter(is_unknown) {
                unknown.entry(name).or_insert_with(|| constraint.span.clone());
            }
        }
        for (name, span) in unknown.into_iter().take(MOST_UNKNOWN) {
            let help = suggestion(name, names.iter().copied());
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

    /// Checks that no two variables have one name or set one key.
    fn check_unique(&mut self, plan: &Plan) {
        let mut seen = BTreeSet::new();
        let mut set: BTreeMap<&str, usize> = BTreeMap::new();
        let fixed: BTreeSet<&str> = plan.fixed.iter().map(|fixed| fixed.key.as_str()).collect();
        for (k, variable) in plan.variables.iter().enumerate() {
            if !seen.insert(&variable.name) {
                let message = format!("two variables have the name {}", variable.name);
                self.error(variable.span.clone(), message, "give one of them another name");
            }
            for key in &variable.keys {
                if *set.entry(&key.value).or_insert(k) != k {
                    self.error(key.span.clone(), format!("{} is set by two variables", key.value), "");
                }
                if fixed.contains(key.value.as_str()) {
                    self.error(
                        key.span.clone(),
                        format!("{} is set by [set] and by a variable", key.value),
                        "",
                    );
                }
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
                let by_levels =
                    matches!(kind, DesignKind::Points(design) if design.size == DesignSize::Levels);
                for variable in &plan.variables {
                    if variable.kind == VariableKind::Given {
                        let message = format!("the variable {} has no values", variable.name);
                        self.error(
                            variable.span.clone(),
                            message,
                            "give it from and to, values, or expression",
                        );
                    }
                    let needs_levels =
                        by_levels && matches!(variable.kind, VariableKind::Range { levels: None, .. });
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
        let free: BTreeSet<&str> = plan
            .variables
            .iter()
            .filter(|variable| variable.kind.is_free())
            .map(|variable| variable.name.as_str())
            .collect();
        for row in rows {
            let columns: BTreeSet<&str> = row.cells.iter().map(|(name, _)| name.as_str()).collect();
            let unknown = row
                .cells
                .iter()
                .find(|(name, _)| !free.contains(name.as_str()))
                .map(|(name, _)| format!("{name} is no variable of the plan that a row can give"));
            let missing = plan.variables.iter().filter(|variable| variable.kind.is_free());
            let missing = missing
                .filter(|variable| !columns.contains(variable.name.as_str()))
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
