//! What the state of an interrupted training holds of this trainer.

use crate::trainer::report::Evidence;
use crate::trainer::state::{MOST, TrainerState};
use crate::training_error::TrainingError;

/// The part of the state that is specific to this trainer.
pub(super) struct Method {
    pub damping: f64,
    pub evidence: Evidence,
    pub start: Option<Vec<f64>>,
    pub ceiling: f64,
    pub settled: bool,
    pub quiet: u64,
}

impl Method {
    pub fn into_state(self, state: TrainerState) -> TrainerState {
        let Evidence { alpha, beta, gamma } = self.evidence;
        let state = state
            .with("damping", &[self.damping])
            .with("evidence", &[alpha, beta, gamma])
            .with("ceiling", &[self.ceiling])
            .with("settled", &[f64::from(u8::from(self.settled))])
            .with("quiet", &[self.quiet as f64]);
        match self.start {
            Some(start) => state.with("start", &start),
            None => state,
        }
    }

    /// Reads it from a state; refuses values with which the search for a step would not terminate.
    pub fn from_state(state: &TrainerState, weights: usize) -> Result<Method, TrainingError> {
        let start = state.values("start").map(|_| state.vector("start", weights)).transpose()?;
        let evidence = state.vector("evidence", 3)?;
        let method = Method {
            damping: state.number("damping")?,
            evidence: Evidence { alpha: evidence[0], beta: evidence[1], gamma: evidence[2] },
            start: start.map(<[f64]>::to_vec),
            ceiling: state.number("ceiling")?,
            settled: state.number("settled")? != 0.0,
            quiet: state.number("quiet")? as u64,
        };
        let Evidence { alpha, beta, .. } = method.evidence;
        if method.damping > 0.0 && alpha >= 0.0 && beta > 0.0 && method.ceiling > 0.0 && method.quiet < MOST {
            return Ok(method);
        }
        Err(TrainingError::State("its damping or evidence is not a valid number".into()))
    }
}
