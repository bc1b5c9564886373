//! How expressions of variables depend on each other.

use std::collections::BTreeMap;

use super::definition::{PlanVariable, VariableKind};

/// How far a variable has been followed.
#[derive(Clone, Copy, PartialEq)]
enum State {
    Open,
    /// Something that it depends on is being followed.
    Entered,
    Done,
}

/// The variables with expressions, each after those that it depends on; what depends on itself is left out.
pub(super) fn in_order(variables: &[PlanVariable]) -> Vec<&PlanVariable> {
    followed(variables).0
}

/// The first variable, in their order, whose expression was found to depend on itself, directly or through others.
pub(super) fn in_a_circle(variables: &[PlanVariable]) -> Option<&PlanVariable> {
    followed(variables).1.into_iter().min().map(|number| &variables[number])
}

/// The order, and the numbers of variables in circles. Nothing is called within itself, so that a chain may be long.
fn followed(variables: &[PlanVariable]) -> (Vec<&PlanVariable>, Vec<usize>) {
    let by_name: BTreeMap<&str, usize> = variables
        .iter()
        .enumerate()
        .rev()
        .map(|(number, variable)| (variable.name.as_str(), number))
        .collect();
    let needs = |number: usize| -> Vec<usize> {
        match &variables[number].kind {
            VariableKind::Expression(expression) => {
                let mut names: Vec<usize> =
                    expression.value.names().filter_map(|name| by_name.get(name).copied()).collect();
                names.sort_unstable();
                names.dedup();
                names
            }
            _ => Vec::new(),
        }
    };
    let mut states = vec![State::Open; variables.len()];
    let (mut order, mut circles) = (Vec::new(), Vec::new());
    for first in 0..variables.len() {
        if states[first] != State::Open {
            continue;
        }
        states[first] = State::Entered;
        let mut way = vec![(first, needs(first))];
        while let Some((number, left)) = way.last_mut() {
            match left.pop() {
                Some(next) if states[next] == State::Open => {
                    states[next] = State::Entered;
                    way.push((next, needs(next)));
                }
                Some(next) if states[next] == State::Entered => circles.push(next),
                Some(_) => {}
                None => {
                    states[*number] = State::Done;
                    if matches!(variables[*number].kind, VariableKind::Expression(_)) {
                        order.push(&variables[*number]);
                    }
                    way.pop();
                }
            }
        }
    }
    (order, circles)
}
