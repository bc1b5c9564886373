//! Why a stage ended, as the script tells it.

use granum_dem::loading::{Reason, Stage, StageEnd};
use granum_dem::state::ServoError;

use super::events::End;

/// The end of a stage of the test.
pub(super) fn stage_end(stage: &Stage, end: &End) -> StageEnd {
    let met = stage.until.iter().zip(&end.met).find(|(_, met)| **met).map(|(until, _)| *until);
    let [mean_stress, before] = end.mean_stress;
    let reason = match met {
        Some(until) => Reason::End(until),
        None if end.lost => Reason::Unjammed { mean_stress, before },
        None => Reason::TooLong { arc_length: end.arc_length, time: end.time },
    };
    let mut servo_error = ServoError::default();
    for ((square, steps), error) in
        servo_error.squares.iter_mut().zip(&mut servo_error.steps).zip(&end.servo_errors)
    {
        (*square, *steps) = (error * error, 1);
    }
    StageEnd { name: stage.name.clone(), reason, steps: end.steps, time: end.time, servo_error }
}
