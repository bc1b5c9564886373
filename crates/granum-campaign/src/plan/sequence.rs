//! The points of a plan's Sobol sequence one by one, for designs that choose among them.

use std::collections::BTreeSet;

use granum_io::{Case, Result};

use super::definition::{DesignKind, Plan, PlanVariable};
use super::design::{Axis, DesignSize, MOST_POINTS, sobol};
use super::runs::{Refusal, apply_settings};
use super::values::{RunValue, axis};

/// A point of the sequence that fulfils the constraints of the plan.
#[derive(Clone, Debug, PartialEq)]
pub struct SequencePoint {
    /// Its number in the sequence, from 0.
    pub number: usize,
    /// The values of the variables.
    pub values: Vec<(String, RunValue)>,
    /// The case of a run at it, with the seed of the base case.
    pub case: Case,
}

impl Plan {
    /// The first `count` points of the sequence that fulfil the constraints and are not among `known`; fewer, if the sequence ends.
    ///
    /// # Errors
    /// If the design is no Sobol sequence, or a point has values that no case accepts.
    pub fn sequence(&self, known: &BTreeSet<usize>, count: usize) -> Result<Vec<SequencePoint>> {
        let is_sequence = match &self.design.kind {
            DesignKind::Points(design) => design.size == DesignSize::PointsThatFulfil,
            DesignKind::Chosen(_) => true,
            DesignKind::Rows(_) => false,
        };
        if !is_sequence {
            let message = "points can be chosen one after another in a design of kind sobol only";
            return Err(self.source.error(&self.design.span, message).into());
        }
        let free: Vec<&PlanVariable> =
            self.variables.iter().filter(|variable| variable.kind.is_free()).collect();
        let axes: Vec<Axis> = free.iter().map(|variable| axis(variable)).collect();
        let mut found = Vec::new();
        for number in (0..MOST_POINTS).filter(|number| !known.contains(number)) {
            if found.len() == count {
                break;
            }
            match self.of_point(&free, &sobol(number, self.design.seed, &axes)) {
                Ok(valued) => {
                    let case = apply_settings(&self.case, &valued.settings)?;
                    found.push(SequencePoint { number, values: valued.values, case });
                }
                Err(Refusal::Constraint(_)) => {}
                Err(Refusal::Mistake(span, message)) => return Err(self.source.error(&span, message).into()),
            }
        }
        Ok(found)
    }

    /// The same plan with these points of its sequence, in this order; points that are added at the end leave the seeds of the others as they are.
    #[must_use]
    pub fn with_chosen(&self, numbers: &[usize]) -> Plan {
        let mut plan = self.clone();
        plan.design.kind = DesignKind::Chosen(numbers.to_vec());
        plan.design.points = Some(numbers.len());
        plan
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "case = 'sand.toml'\nconstraints = ['friction < 0.6']\n[design]\nkind = 'sobol'\npoints = 6\n\
        sample_seeds = 'different'\n[[variable]]\nname = 'friction'\nkey = 'grains.material.friction'\nfrom = 0.1\nto = 0.8\n";

    fn plan(text: &str) -> Plan {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("sand.toml"), "[grains]\ncount = 300\n").unwrap();
        let file = folder.path().join("plan.toml");
        std::fs::write(&file, text).unwrap();
        Plan::read(&file, Default::default()).unwrap()
    }

    /// The first points of the sequence are those of the plan, and chosen ones are the same runs whatever is added to them.
    #[test]
    fn chosen_points_are_those_of_the_sequence() {
        let plan = plan(TEXT);
        let all = plan.sequence(&BTreeSet::new(), 6).unwrap();
        let numbers: Vec<usize> = all.iter().map(|point| point.number).collect();
        let runs = plan.runs().unwrap().runs;
        assert_eq!(plan.with_chosen(&numbers).runs().unwrap().runs, runs);
        assert_eq!(
            all.iter().map(|point| point.values.clone()).collect::<Vec<_>>(),
            runs.iter().map(|run| run.values.clone()).collect::<Vec<_>>()
        );
        // Points that break a constraint are not among them.
        assert!(numbers[5] > 5, "{numbers:?}");
        let more = plan.sequence(&numbers.iter().copied().collect(), 2).unwrap();
        assert!(more.iter().all(|point| !numbers.contains(&point.number)));
        let chosen = [&numbers[..], &[more[1].number]].concat();
        let longer = plan.with_chosen(&chosen).runs().unwrap().runs;
        assert_eq!(&longer[..6], &runs[..]);
        assert_eq!(longer[6].values, more[1].values);
    }

    #[test]
    fn other_designs_have_no_sequence() {
        let plan = plan(&TEXT.replace("'sobol'", "'latin-hypercube'"));
        let error = plan.sequence(&BTreeSet::new(), 1).unwrap_err().to_string();
        assert!(error.contains("kind sobol only"), "{error}");
    }
}
