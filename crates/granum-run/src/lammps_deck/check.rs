//! What of a stage a box of LAMMPS and a script can follow.

use granum_dem::loading::{Drive, Kinematics, Ramp, Stage, Start, Target, Until};

use super::deck_error::DeckError;
use super::formula::of_measure;
use super::motion::Motion;

/// True if a normal stress or the mean stress is brought to zero or into tension.
fn asks_for_no_stress(stage: &Stage) -> bool {
    let ends = |target: &Target| match (target.ramp, target.value) {
        (Some(Ramp::To(value)), _) | (None, Some(value)) => value <= 0.0,
        _ => false,
    };
    let of_axes = stage.control.components[..3]
        .iter()
        .any(|drive| matches!(drive, Drive::Stress(target) if ends(target)));
    let mean = stage
        .control
        .constraints
        .iter()
        .flatten()
        .filter(|of| of.stress[..3] == [1.0; 3] && of.strain == [0.0; 6]);
    of_axes || mean.map(|of| &of.target).any(ends)
}

/// The motion of a stage, if the deck can express the stage.
pub(super) fn checked(stage: &Stage, modulus: f64) -> Result<Motion, DeckError> {
    let refuse = |why: &str| DeckError::Stage { stage: stage.name.clone(), why: why.into() };
    if stage.start != Start::Here {
        return Err(refuse("its start is a state to which stages go back, and a script cannot go back"));
    }
    let motion = Motion::new(&stage.control, modulus)?;
    if [(1, 0), (2, 0), (2, 1)].into_iter().any(|(r, c)| motion.moves(r, c)) {
        let why = match stage.control.kinematics {
            Kinematics::PureShear => {
                "it shears the cell without rotation, but a box of LAMMPS can be sheared only as in simple shear, in xy and yz \
                 (shear_kinematics = \"simple\")"
            }
            Kinematics::SimpleShear => {
                "it shears the cell in zx, but a box of LAMMPS can be sheared only in xy and yz"
            }
        };
        return Err(refuse(why));
    }
    if let Some(turns) = stage.turns
        && of_measure(turns.measure).is_none()
    {
        return Err(refuse(&format!(
            "it turns round at {}, which the deck does not follow",
            turns.measure.name()
        )));
    }
    if asks_for_no_stress(stage) {
        return Err(refuse(
            "it brings a normal stress to zero or into tension, where the script's control in per cent of the stress ends",
        ));
    }
    if stage.until.is_empty() {
        return Err(refuse("it has no end condition"));
    }
    for until in &stage.until {
        let known = match until {
            Until::Reaches { measure, .. } | Until::DoubleAmplitude { measure, .. } => {
                of_measure(*measure).is_some()
            }
            Until::AtRest { .. } | Until::PorePressureRatio(_) | Until::Reversals(_) | Until::RampOver => {
                true
            }
            _ => false,
        };
        if !known {
            let why = format!(
                "its end condition ({until}) is not one of a strain, a stress, a time, an arc length, a ramp, reversals, a double \
                 amplitude, rest or a pore pressure ratio"
            );
            return Err(refuse(&why));
        }
    }
    Ok(motion)
}
