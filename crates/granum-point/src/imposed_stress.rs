//! Bringing a live cell to a stress that its caller imposes: all six components are controlled by the servo.

use granum_core::geometry::Matrix;
use granum_dem::loading::{Control, Drive, Ramp, Reason, Speed, Stage, Target, Until, begin, follow};
use granum_dem::observer::NoObserver;
use granum_dem::servo::component;
use granum_dem::simulation::Simulation;

use crate::controls::Controls;
use crate::error::PointError;
use crate::straining::{AveragedStress, relax};

/// Difference of a component from the imposed stress, over the scale of the stress, that is aimed at and that is accepted.
const AIMED: f64 = 2e-4;
const ACCEPTED: f64 = 1e-3;
/// How often the stress is held again when the difference is larger than the one aimed at.
const MOST_HOLDS: usize = 8;
/// Unbalanced force at which a sample counts as at rest.
const AT_REST: f64 = 1e-3;
/// Largest arc length of strain on the way to the stress.
const LONGEST_WAY: f64 = 0.3;

/// Brings a simulation to a stress, Pa, in the axes of the cell, and lets it relax.
///
/// `least` is a stress, Pa, by which differences and speeds are judged where the imposed one is smaller.
///
/// # Errors
/// [`PointError::StressNotReached`] if the sample does not carry the stress, and if the engine fails.
pub(crate) fn impose(
    simulation: &mut Simulation,
    stress: &Matrix,
    least: f64,
    controls: &Controls,
) -> Result<AveragedStress, PointError> {
    let mean_stress = (stress[0][0] + stress[1][1] + stress[2][2]) / 3.0;
    let scale = stress.iter().flatten().fold(least, |scale, x| scale.max(x.abs()));
    let target = |k: usize| component(stress, k);
    let ramps = std::array::from_fn(|k| Drive::Stress(Target::ramp(Ramp::To(target(k)))));
    let held = std::array::from_fn(|k| Drive::Stress(Target::held(target(k))));
    // A sample without stress that is to have none would otherwise have no speed.
    let present = simulation.state().mean_stress();
    let speed = |carried: f64| {
        let at = if carried > least { None } else { Some(least) };
        Speed::InertialNumber { number: controls.inertial_number, at }
    };
    let ramp = Stage::new(
        "way to the imposed stress",
        Control::new(speed(present.max(mean_stress)), ramps),
        vec![Until::RampOver],
    )
    .with(|stage| stage.most_arc_length = Some(LONGEST_WAY));
    let at_rest = Until::AtRest { unbalanced_force: AT_REST };
    let hold =
        Stage::new("imposed stress", Control::new(speed(mean_stress), held), vec![at_rest]).with(|stage| {
            stage.settling = true;
            stage.most_arc_length = Some(0.1 * LONGEST_WAY);
        });
    simulation.fix_time_step(None);
    let missed = |difference: f64| PointError::StressNotReached { difference, mean_stress };
    if !matches!(run(&ramp, simulation)?, Reason::End(_)) {
        return Err(missed(largest_difference(&simulation.state().stress(), stress)));
    }
    let mut difference = f64::INFINITY;
    for held_before in 0..MOST_HOLDS {
        simulation.fix_time_step(None);
        run(&hold, simulation)?;
        simulation.set_global_damping(0.0);
        let reached = match relax(simulation, controls) {
            Ok(reached) => reached,
            // A cell that yields on the way is deformed without end.
            Err(PointError::Thin { .. } | PointError::TooDeep { .. }) => break,
            Err(error) => return Err(error),
        };
        difference = largest_difference(&reached.mean, stress);
        let accepted = if held_before + 1 < MOST_HOLDS { AIMED } else { ACCEPTED };
        if difference <= accepted * scale {
            return Ok(reached);
        }
    }
    let now = largest_difference(&simulation.state().stress(), stress);
    Err(missed(if difference.is_finite() { difference } else { now }))
}

/// Runs a stage to its end.
fn run(stage: &Stage, simulation: &mut Simulation) -> Result<Reason, PointError> {
    let mut progress = begin(stage, simulation)?;
    loop {
        match follow(stage, &mut progress, simulation, &mut NoObserver)? {
            granum_dem::loading::Ending::Complete(reason) => return Ok(reason),
            // Nobody who could stop it observes the stage.
            granum_dem::loading::Ending::Stopped => {}
        }
    }
}

/// Largest difference of two stresses by components, Pa.
pub(crate) fn largest_difference(one: &Matrix, other: &Matrix) -> f64 {
    (0..6).fold(0.0f64, |largest, k| largest.max((component(one, k) - component(other, k)).abs()))
}
