//! The next trial of a search for the procedure of the preparation.

use super::procedure_search::Line;
use super::{Procedure, SampleSpecification, Trial};
use crate::simulation::Properties;

/// The next trial for the procedure of the preparation, and the results of the trials before.
#[derive(Clone, Debug, PartialEq)]
pub struct NextTrial {
    pub(super) procedure: Procedure,
    pub(super) position: f64,
    pub(super) trials: Vec<Trial>,
    pub(super) steps: u64,
    pub(super) time: f64,
}

impl NextTrial {
    /// The first trial of a specification.
    pub fn first(specification: &SampleSpecification) -> NextTrial {
        let (p, own) = (&specification.preparation, specification.grains.mean_friction());
        let line = Line::new(p, own);
        let position = match (p.friction, p.target()) {
            (None, Some(target)) => line.next(&[], target),
            _ => own,
        };
        let mut procedure = line.procedure(position);
        procedure.friction = p.friction.unwrap_or(procedure.friction);
        NextTrial { procedure, position, trials: Vec::new(), steps: 0, time: 0.0 }
    }

    /// Material and contact laws during the compaction of this trial.
    pub fn properties(&self, specification: &SampleSpecification) -> Properties {
        specification.properties().while_compacting(&specification.preparation, self.procedure.friction)
    }
}
