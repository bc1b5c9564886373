//! The stress by which the speed and the stiffness of a stage are judged.
//!
//! It is the mean stress of the sample when the stage begins. A sample that was unloaded has none: an inertial number would then
//! give no speed, and it could never be loaded again. The largest stress that the stage brings it to takes its place, or
//! that of the forces which adhesion keeps in its contacts.

use crate::simulation::Simulation;

/// Fraction of a stress below which a sample counts as carrying nothing of it.
pub(super) const CARRIES_NOTHING: f64 = 1e-3;

/// The stress for a stage that begins with the present state and brings it to a stress `asked`, Pa; zero where nothing is carried and
/// nothing asked for.
pub(super) fn reference_stress(asked: f64, simulation: &Simulation) -> f64 {
    let state = simulation.state();
    let other = asked.max(state.contact_stress());
    let p = state.mean_stress();
    if p > CARRIES_NOTHING * other { p } else { other }
}

#[cfg(test)]
mod tests {
    use crate::checkpoint::tests::running;
    use crate::loading::{Control, Drive, Ramp, Speed, Target};

    fn isotropic(target: Target) -> Control {
        let (held, fixed) = (Drive::Stress(target), Drive::Fixed);
        Control::new(
            Speed::InertialNumber { number: 1e-3, at: None },
            [held, held, held, fixed, fixed, fixed],
        )
    }

    /// A sample with a stress goes by it; one without by what it is brought to; with neither there is no speed.
    #[test]
    fn a_sample_without_stress_goes_by_what_it_is_brought_to() {
        let loaded = running(200, 0.0);
        let p = loaded.state().mean_stress();
        assert_eq!(isotropic(Target::held(2.0 * p)).reference_stress(&loaded), p);
        let mut empty = loaded.clone();
        empty.integrator.state.sums = Default::default();
        assert_eq!(empty.state().mean_stress(), 0.0);
        for (target, stress) in [
            (Target::held(5e4), 5e4),
            (Target::held(-1e3), 1e3),
            (Target::ramp(Ramp::To(3e4)), 3e4),
            (Target::ramp(Ramp::By(2e4)), 2e4),
        ] {
            assert_eq!(isotropic(target).reference_stress(&empty), stress);
            assert!(isotropic(target).begin(&empty).is_ok());
        }
        let nothing = isotropic(Target::held(0.0)).begin(&empty).unwrap_err();
        assert!(nothing.to_string().contains("strain_rate"), "{nothing}");
    }
}
